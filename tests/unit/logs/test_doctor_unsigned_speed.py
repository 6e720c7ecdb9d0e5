"""A car that reverses while its v has no sign, as a CAN bus or a receiver tells it."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.doctor import examine
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

STEP = 0.02  # s


def parked(heading: float = 0.0, noise: float = 0.02) -> dict[str, FloatArray]:
    """40 s forwards at up to 8 m/s, then 10 s backwards at 2 m/s."""
    t = np.arange(0.0, 60.0, STEP)
    rng = np.random.default_rng(1)
    v = np.interp(t, [0.0, 5.0, 35.0, 40.0, 45.0, 47.0, 57.0, 58.0], [0.0, 8.0, 8.0, 0.0, 0.0, -2.0, -2.0, 0.0])
    rate = v * np.tan(0.2 * np.sin(0.9 * t)) / 2.7
    yaw = np.cumsum(rate) * STEP
    x, y = np.cumsum(v * np.cos(yaw)) * STEP, np.cumsum(v * np.sin(yaw)) * STEP
    place = rng.normal(0.0, noise, (2, len(t)))
    return {
        "t": t, "x": x + place[0], "y": y + place[1], "yaw": yaw + heading + rng.normal(0.0, 0.003, len(t)),
        "v": v + rng.normal(0.0, 0.02, len(t)), "yaw_rate": rate + rng.normal(0.0, 0.005, len(t)),
    }  # fmt: skip


def told(columns: dict[str, FloatArray]) -> list[str]:
    return [one.message for one in examine(Log(columns)) if one.code == "log.unsigned_speed"]


def test_a_speed_without_a_sign_is_told_with_its_time() -> None:
    columns = parked()
    (text,) = told({**columns, "v": np.abs(columns["v"])})
    assert text.startswith("v has no sign: for 12 s the car drives backwards, and v is positive, first from t = 45.")


@pytest.mark.parametrize("heading", [0.0, np.pi])
def test_a_signed_speed_and_a_heading_that_is_turned_round_are_not(heading: float) -> None:
    assert not told(parked(heading))


def test_a_course_in_place_of_the_heading_and_a_coarse_position_say_nothing() -> None:
    columns = parked(noise=1.0)
    assert not told({**columns, "v": np.abs(columns["v"])})
    columns = parked()
    course = np.where(columns["v"] < -0.1, columns["yaw"] + np.pi, columns["yaw"])
    assert not told({**columns, "v": np.abs(columns["v"]), "yaw": course})
