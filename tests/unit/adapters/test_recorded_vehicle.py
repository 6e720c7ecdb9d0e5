"""A recording as the vehicle: it plays what came when it came, and says how far off the stack's commands are."""

from __future__ import annotations

import numpy as np
import pytest

from vehicle.adapter import Vehicle, VehicleLost
from vehicle.adapters.replay import Arrived, Difference, Judge, Recording, Replay
from vehicle.messages import Command, GnssFix, Imu, VehicleDescription, VehicleState, no_surroundings

CAR = VehicleDescription(4.0, 1.8, 1.5, 2.5, 1.25, 0.6, 40.0, 3.0, 7.0, 1000.0)
START = VehicleState(t=0.0, x=100.0, y=5.0, yaw=0.0, v=10.0)


def straight(seconds: float = 1.0) -> Recording:
    """10 m/s along x; a fix at 0.1 s that comes 60 ms late; 0.1 rad asked for from 0.5 s on."""
    t = np.arange(round(seconds * 100) + 1) / 100
    rows = np.zeros((len(t), 12))
    rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 5], rows[:, 6] = t, 100.0 + 10.0 * t, 5.0, 10.0, 10.0
    commands = np.array([[0.0, 0.0, 0.5], [0.5, 0.1, -1.0]])
    messages = [Arrived(0.0, Imu(0.0, 0.0, 0.0, 0.0)), Arrived(0.16, GnssFix(0.1, 101.0, 5.0, 0.02))]
    return Recording("drive.csv", CAR, rows, commands, messages)


def asked(steer: float, accel: float) -> Command:
    return Command(0.0, steer, accel, 0.0, 0.0)


def test_it_is_a_vehicle_that_is_not_real() -> None:
    replay = Replay(straight(), lambda _: None)
    assert isinstance(replay, Vehicle)
    assert not replay.is_real


def test_its_motion_is_the_recorded_one_each_row_once() -> None:
    replay = Replay(straight(), lambda _: None)
    replay.reset(START)
    rows = np.concatenate([replay.step(0.05) for _ in range(20)])
    assert rows[:, 0] == pytest.approx(np.arange(1, 101) / 100)
    assert rows[-1, 1] == pytest.approx(110.0)


def test_a_message_comes_when_it_came_not_when_it_was_true() -> None:
    replay = Replay(straight(), lambda _: None)
    replay.reset(START)
    seen = []
    for _ in range(5):
        seen.append(replay.observe(no_surroundings()))
        replay.step(0.05)
    assert [len(one.gnss) for one in seen] == [0, 0, 0, 0, 1]
    assert seen[4].gnss[0].t == 0.1
    assert len(seen[0].imu) == 1


def test_a_command_is_held_against_the_one_in_force_then() -> None:
    differences: list[Difference] = []
    replay = Replay(straight(), differences.append)
    replay.reset(START)
    for _ in range(12):
        replay.apply(asked(0.1, 0.5))
        replay.step(0.05)
    assert differences[9] == pytest.approx((0.45, 0.0, 0.5, 0.1, 0.0))
    assert differences[10] == pytest.approx((0.5, 0.1, -1.0, 0.0, 1.5))


def test_the_end_of_the_recording_is_one_line() -> None:
    replay = Replay(straight(0.1), lambda _: None)
    replay.reset(START)
    replay.step(0.1)
    with pytest.raises(VehicleLost, match=r"^drive\.csv: the recording has ended$"):
        replay.step(0.05)


def test_it_must_begin_where_the_scenario_does() -> None:
    replay = Replay(straight(), lambda _: None)
    with pytest.raises(VehicleLost, match=r"^drive\.csv: begins at x=100\.0, y=5\.0, 20\.0 m from where the scenario"):
        replay.reset(VehicleState(t=0.0, x=112.0, y=21.0, yaw=0.0, v=0.0))


def judged(*offs: tuple[float, float]) -> tuple[float | None, list[int]]:
    """When they went apart, and at which tick it was known; a difference every 50 ms."""
    judge = Judge()
    known = [k for k, (steer, accel) in enumerate(offs) if judge.hear(Difference(0.05 * k, 0.0, 0.0, steer, accel))]
    return judge.diverged, known


def test_half_a_second_beyond_a_bound_is_apart() -> None:
    assert judged(*[(0.0, 0.0)] * 4, *[(0.06, 0.0)] * 20) == (pytest.approx(0.2), [14])
    assert judged(*[(0.0, -1.1)] * 20) == (0.0, [10])


def test_up_to_the_bounds_or_for_less_than_half_a_second_is_together() -> None:
    assert judged(*[(0.05, -1.0)] * 40) == (None, [])
    assert judged(*([(0.3, 0.0)] * 10 + [(0.0, 0.0)]) * 4) == (None, [])
