"""How the kernel replays a log, as plain Python functions: rows, slopes, steps and restarts."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from plain_effects import Applied, bus

from vehicle.model.effects.drive_lag import drive_lag
from vehicle.model.effects.gyro_bias import gyro_bias
from vehicle.model.effects.steer_lag import steer_lag
from vehicle.model.kernel import ACCELERATION, DYNAMIC, IMPOSED, KINEMATIC, PEDALS

L, A, B, M, INERTIA = 2.8, 1.2, 1.6, 1600.0, 2500.0
CF, CR = 60e3, 80e3
STIFF = {"stiffness_front": CF, "stiffness_rear": CR, "steer_scale": 1.0, "mass_ref": M}
NAN = math.nan

Plain = Callable[..., Any]


def replayed(
    plain: Plain, commands: list[list[float]], *effects: Applied, t: Sequence[float] = (0.0, 0.1, 0.2, 0.3),
    mode: int = ACCELERATION, kind: int = KINEMATIC, slopes: list[list[float]] | None = None, step: float = 0.04,
    starts: Sequence[int] = (), states: Sequence[Sequence[float]] = (), **fields: float,
) -> tuple[np.ndarray, Any]:  # fmt: skip
    x = bus(steer_scale=1.0, stiffness_front=CF, stiffness_rear=CR, **fields)
    x.mass_ref = M
    n = len(commands)
    out = np.zeros((n, 8))
    given = np.zeros((n, 6))
    for row, command in zip(given, commands, strict=True):
        row[: len(command)] = command
    change = np.zeros((n, 2)) if slopes is None else np.array(slopes)
    plain("replay", *effects)(
        [x], kind, mode, None, None, None, np.zeros(1), np.array(t[:n]), given, change, step,
        np.array(starts, dtype=int), np.array(states).reshape(-1, 6), out,
    )  # fmt: skip
    return out, x


def test_a_replay_shows_each_row_with_its_own_command(plain: Plain) -> None:
    """1, -2 and 0 m/s^2 from 5 m/s, a row each 0.1 s: ways are (v0 + v1) / 2 t. Behind the last row nothing moves."""
    out, x = replayed(plain, [[0.0, 1.0], [0.0, -2.0], [0.0, 0.0], [0.0, 3.0]], vx=5.0)
    assert out[:, 3] == pytest.approx([5.0, 5.1, 4.9, 4.9])
    assert out[:, 0] == pytest.approx([0.0, 0.505, 1.005, 1.495])
    assert out[:, 5] == pytest.approx([1.0, -2.0, 0.0, 3.0])
    assert (x.x, x.vx) == pytest.approx((1.495, 4.9))


def test_pedals_are_replayed_by_their_columns(plain: Plain) -> None:
    out, _ = replayed(plain, [[0.0, 9.0, 0.5, 0.0], [0.0, 9.0, 0.0, 0.25], [0.0, 9.0, 0.0, 0.0]], mode=PEDALS, vx=5.0)
    assert out[:, 5] == pytest.approx([2.0, -2.0, 0.0])


def test_actuators_are_at_rest_at_the_first_command(plain: Plain) -> None:
    """Before the log it held: drive and steering begin there, whatever comes later."""
    lags = Applied(drive_lag, tau=0.3), Applied(steer_lag, tau=0.3)
    out, x = replayed(plain, [[0.1, 1.0], [0.3, -2.0], [0.3, -2.0]], *lags, vx=5.0, t=(7.0, 7.1, 7.2))
    assert (out[0, 5], out[0, 7]) == pytest.approx((1.0, 0.1))
    assert out[1, 5] == pytest.approx(1.0)  # the change begins here
    assert out[2, 5] == pytest.approx(-2.0 + 3.0 * math.exp(-0.1 / 0.3))
    assert out[2, 7] == pytest.approx(0.3 - 0.2 * math.exp(-0.1 / 0.3))
    assert (x.settle, x.t_start) == (0.0, 7.0)


def test_pedals_and_speeds_are_at_rest_at_the_first_command_too(plain: Plain) -> None:
    out, _ = replayed(plain, [[0.0, 0.0, 0.5, 0.0], [0.0] * 4], Applied(drive_lag, tau=0.3), mode=PEDALS, vx=5.0)
    assert out[0, 5] == pytest.approx(2.0)
    out, _ = replayed(plain, [[0.0, 0.0, 0.0, 0.25], [0.0] * 4], Applied(drive_lag, tau=0.3), mode=PEDALS, vx=5.0)
    assert out[0, 5] == pytest.approx(-2.0)


def test_a_command_that_moves_on_straight_is_followed_within_its_step(plain: Plain) -> None:
    """From 0 to 0.3 rad and from 5 to 6 m/s: way 5.5 m/s x 0.1 s; each row shows the command of its stamp."""
    rows = [[0.0, 0, 0, 0, 0, 5.0], [0.3, 0, 0, 0, 0, 6.0], [0.3, 0, 0, 0, 0, 6.0]]
    out, _ = replayed(plain, rows, mode=IMPOSED, slopes=[[0.3, 1.0], [0.0, 0.0], [0.0, 0.0]], vx=1.0)
    assert out[:, 3] == pytest.approx([5.0, 6.0, 6.0])
    assert out[:, 7] == pytest.approx([0.0, 0.3, 0.3])
    assert out[:, 4] == pytest.approx([0.0, 6.0 * math.tan(0.3) / L, 6.0 * math.tan(0.3) / L])
    assert out[1, 0] == pytest.approx(0.55, rel=1e-3)
    assert out[2, 0] - out[1, 0] < 0.6


def test_steps_are_no_longer_than_allowed(plain: Plain) -> None:
    """0.1 s in pieces of at most 0.04 s: three; on a turn more pieces are nearer to the circle of 8 m radius."""
    steer, radius = math.atan(L / 8.0), 8.0
    errors = []
    for step in (0.1, 0.05, 0.025):
        out, x = replayed(plain, [[steer, 0.0]] * 4, step=step, vx=20.0)
        errors.append(math.hypot(out[3, 0], out[3, 1] - radius) - radius)
        assert out[3, 2] == pytest.approx(20.0 * 0.3 / radius)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)
    _, x = replayed(plain, [[0.0, 0.0]] * 2, step=0.04, vx=1.0)
    assert x.dt == pytest.approx(0.04)  # behind the last row there is one step of its own
    _, x = replayed(plain, [[0.0, 0.0]] * 3, step=0.1000000001, vx=1.0)
    assert x.t == pytest.approx(0.2)


def test_a_replay_begins_anew_where_it_is_told(plain: Plain) -> None:
    """At the first row and at the third: 2 m/s for 0.1 s each, the car elsewhere from there on."""
    states = [[1.0, 2.0, 0.0, 2.0, 0.0, 0.0], [50.0, 60.0, math.pi / 2.0, 4.0, 0.0, 0.0]]
    out, _ = replayed(plain, [[0.0, 0.0]] * 4, starts=[0, 2], states=states, vx=9.0)
    assert out[:, 0] == pytest.approx([1.0, 1.2, 50.0, 50.0])
    assert out[:, 1] == pytest.approx([2.0, 2.0, 60.0, 60.4])
    assert out[:, 3] == pytest.approx([2.0, 2.0, 4.0, 4.0])


def test_only_a_restart_on_the_way_tells_the_sensors_that_the_car_was_moved(plain: Plain) -> None:
    seen: list[float] = []

    class Spy(Applied):
        def __call__(self, x: Any) -> Any:
            seen.append(x.moved)
            return x

    states = [[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]] * 2
    replayed(plain, [[0.0, 0.0]] * 4, Spy(gyro_bias), starts=[0, 2], states=states)
    assert seen == [0.0, 0.0, 1.0, 0.0]


@pytest.mark.parametrize("row", [1, 2, 3])
def test_a_replay_begins_anew_at_whichever_row_it_is_told(row: int, plain: Plain) -> None:
    """At 2 m/s from 0 m and from there on at 7 m/s from 50 m, in a row each 0.1 s."""
    states = [[0.0, 0.0, 0.0, 2.0, 0.0, 0.0], [50.0, -3.0, 0.0, 7.0, 0.0, 0.0]]
    out, _ = replayed(plain, [[0.0, 0.0]] * 4, starts=[0, row], states=states)
    assert out[:, 3].tolist() == [2.0] * row + [7.0] * (4 - row)
    assert out[:, 0] == pytest.approx([0.2 * k if k < row else 50.0 + 0.7 * (k - row) for k in range(4)])
    assert out[:, 1].tolist() == [0.0] * row + [-3.0] * (4 - row)


def test_a_car_with_tyres_begins_on_the_curve_of_its_steering(plain: Plain) -> None:
    """Where the log knows no yaw rate; a known one is kept, and so is that of a car without tyres."""
    start = [0.0, 0.0, 0.0, 10.0, 0.0, NAN]
    out, _ = replayed(plain, [[0.1, 0.0]] * 2, kind=DYNAMIC, starts=[0], states=[start], yaw_rate=0.9)
    assert out[0, 4] == pytest.approx(10.0 * math.tan(0.1) / L)
    _, x = replayed(plain, [[0.1, 0.0]], kind=DYNAMIC, starts=[0], states=[[*start[:4], 0.3, NAN]])
    assert x.vy == pytest.approx(0.3 + B * 10.0 * math.tan(0.1) / L)
    out, _ = replayed(plain, [[0.1, 0.0]] * 2, kind=DYNAMIC, starts=[0], states=[[*start[:5], 0.2]], yaw_rate=0.9)
    assert out[0, 4] == pytest.approx(0.2)
    out, _ = replayed(plain, [[0.1, 0.0]] * 2, kind=DYNAMIC, vx=10.0, yaw_rate=0.7)
    assert out[0, 4] == pytest.approx(0.7)


def test_sensors_show_after_their_effects_with_the_time_since_the_last_row(plain: Plain) -> None:
    times: list[tuple[float, float]] = []

    class Spy(Applied):
        def __call__(self, x: Any) -> Any:
            times.append((x.t, x.dt))
            return super().__call__(x)

    out, _ = replayed(plain, [[0.0, 0.0]] * 3, Spy(gyro_bias, b=0.02), t=(0.0, 0.1, 0.3), vx=3.0)
    assert out[:, 4] == pytest.approx([0.02] * 3)
    assert [t for t, _ in times] == pytest.approx([0.0, 0.1, 0.3])
    assert [dt for _, dt in times[1:]] == pytest.approx([0.1, 0.2])
