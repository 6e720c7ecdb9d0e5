"""Fixes that were lost for a while and came back are no other run."""

from __future__ import annotations

import numpy as np
import pytest
from known_motion import findings, rate_and_integral, times, way

from pytest_dvp.logs.log_contents import FloatArray

CODES = ("log.concatenated", "log.position_jump")


def log(seconds: float = 120.0) -> dict[str, FloatArray]:
    t = times(seconds)
    rate, integral = rate_and_integral(0.05, 0.3)
    v, yaw = 12.0 + integral(t), 0.1 * integral(t)
    return {"t": t, **way(t, v, yaw), "v": v, "yaw": yaw, "yaw_rate": 0.1 * rate(t)}


@pytest.mark.parametrize("kind", ["zero", "five rows"])
def test_a_fix_that_comes_back_is_a_jump_of_the_position(kind: str) -> None:
    columns = log()
    lost = (columns["t"] > 50.0) & (columns["t"] < 55.0)
    for name in "xy":
        if kind == "five rows":  # up to three are spikes
            columns[name][2500:2505] += 40.0
        else:
            columns[name][lost] = 0.0
    (told,) = findings(columns, *CODES)
    assert (told.code, told.severity) == ("log.position_jump", "error")
    assert "before and after it is where speed and heading lead" in told.message


def test_a_fix_that_was_held_until_it_came_back_was_not_measured() -> None:
    columns = log()
    lost = (columns["t"] > 50.0) & (columns["t"] < 55.0)
    for name in "xy":
        columns[name][lost] = columns[name][np.argmax(lost)]
    (told,) = findings(columns, *CODES, "log.held_position")
    assert (told.code, told.severity) == ("log.held_position", "warning")


@pytest.mark.parametrize("scale", [0.9, 1.0, 1.1])
def test_another_run_at_the_same_speed_and_heading_is_one_also_if_the_speed_is_not_quite_right(scale: float) -> None:
    columns = log()
    columns["x"] += np.where(columns["t"] > 60.0, -200.0, 0.0)  # back to an earlier place of the same road
    columns["y"] += np.where(columns["t"] > 60.0, 60.0, 0.0)
    columns["v"] *= scale
    assert [told.code for told in findings(columns, *CODES)] == ["log.concatenated"]
