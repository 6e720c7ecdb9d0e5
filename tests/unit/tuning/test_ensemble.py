"""Mean drives held against each other: what repeats average out, and what they do not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from pytest_dvp.logs.log import Log
from pytest_dvp.tuning.mean_drives import Courses, courses, mean_likeness

T = np.arange(0.0, 40.0, 0.01)  # s
SEEN = np.arange(5.0, 15.0, 0.05)  # s


def swerve(at: float, gain: float = 1.0, bias: float = 0.0) -> Courses:
    """Steering out at `at` [s] and back: a sine of 4 s."""
    tau = T - at
    return {"steer": (T, gain * 0.1 * np.sin(np.pi * tau / 2.0) * ((tau > 0.0) & (tau < 4.0)) + bias)}


def several(starts: Sequence[float], **more: float) -> list[Courses]:
    return [swerve(start, **more) for start in starts]


def test_drives_that_begin_a_little_apart_are_alike_in_the_mean() -> None:
    """Decisions that jitter by 0.3 s about the same instant in both stages: no lag, though single drives have one."""
    one, other = several([9.7, 10.0, 10.3, 9.9, 10.1]), several([10.3, 9.7, 10.1, 9.9, 10.0])
    mncc, lag, gain = mean_likeness("steer", one, other)  # type: ignore[misc]
    assert mncc == pytest.approx(1.0, abs=1e-9)
    assert lag == 0.0
    assert gain == pytest.approx(0.0, abs=1e-9)
    single = mean_likeness("steer", one[:1], other[:1])
    assert single is not None
    assert single[1] == pytest.approx(0.6)


def test_a_lag_of_every_drive_stays() -> None:
    found = mean_likeness("steer", several([10.0, 10.2, 10.4]), several([10.2, 10.4, 10.6]))
    assert found is not None
    assert found[1] == pytest.approx(0.2)


def test_a_gain_of_every_drive_stays() -> None:
    found = mean_likeness("steer", several([10.0, 10.2]), several([10.0, 10.2], gain=0.9, bias=0.3))
    assert found is not None
    assert found[2] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize(("seconds", "defined"), [(19.0, False), (21.0, True)])
def test_one_drive_that_ended_early_does_not_hide_the_rest_of_the_others(seconds: float, defined: bool) -> None:
    """All last 40 s but one."""
    t, steer = swerve(10.0)["steer"]
    short: Courses = {"steer": (t[t < seconds], steer[t < seconds])}
    found = mean_likeness("steer", [swerve(10.0), short], several([10.0, 10.0], gain=0.9))
    assert (found is not None) == defined


@pytest.mark.parametrize("columns", [{}, {"steer": np.full(len(T), np.nan)}])
def test_a_car_that_does_not_measure_its_wheel_has_no_row_of_it(columns: dict[str, np.ndarray]) -> None:
    drive = courses(Log({"t": T, "x": T, "y": T, "v": T, **columns}, meta={"stage": "rw"}))
    assert sorted(drive) == ["ego x", "ego y", "velocity"]
    assert mean_likeness("steer", [drive, drive], [drive, drive]) is None


def test_a_road_user_that_most_drives_did_not_see_does_not_count() -> None:
    seen: Courses = {"object x Car": (SEEN, 40.0 - 3.0 * SEEN)}
    nothing: Courses = {}
    assert mean_likeness("object x", [seen, seen, nothing], [seen, nothing, nothing]) is None
    assert mean_likeness("object x", [seen, seen, nothing], [seen, seen, nothing]) is not None


def test_road_users_weigh_as_long_as_they_were_seen_by_all() -> None:
    """A car alike for 10 s, a pedestrian seen for 5 s with half the way: (10 * 0 + 5 * 0.5) / 15."""
    short = SEEN[: len(SEEN) // 2]
    one: Courses = {"object y Car": (SEEN, np.sin(SEEN)), "object y Ped": (short, 8.0 - short)}
    other: Courses = {"object y Car": (SEEN, np.sin(SEEN)), "object y Ped": (short, 8.0 - 0.5 * short)}
    found = mean_likeness("object y", [one, one], [other, other])
    assert found is not None
    assert found[2] == pytest.approx(0.5 / 3.0, rel=0.01)
