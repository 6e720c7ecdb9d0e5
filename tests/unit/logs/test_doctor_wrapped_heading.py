"""A heading within one turn wraps, and a car that goes west wraps often."""

from __future__ import annotations

import numpy as np
import pytest
from drives import drive

from pytest_dvp.doctor import examine
from pytest_dvp.logs.log import Log


@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize("whole", [False, True])
def test_a_car_that_goes_where_its_heading_wraps_has_radians(noise: float, whole: bool) -> None:
    """A hand that steers a little around the direction in which the heading flips, from pi to -pi or from 2 pi to 0."""
    rng = np.random.default_rng(3)
    t = np.arange(3000) * 0.02
    rate = 0.02 * np.sin(0.9 * t) + 0.015 * np.sin(2.3 * t)
    yaw = np.cumsum(rate) * 0.02
    yaw += (0.0 if whole else np.pi) - np.mean(yaw)
    v = 10.0 + np.sin(0.3 * t)
    columns = {
        "t": t, "v": v + rng.normal(0.0, 0.02, len(t)), "yaw_rate": rate + rng.normal(0.0, 0.002, len(t)),
        "x": np.cumsum(v * np.cos(yaw)) * 0.02, "y": np.cumsum(v * np.sin(yaw)) * 0.02,
    }  # fmt: skip
    shown = yaw + rng.normal(0.0, noise, len(t))
    columns["yaw"] = np.mod(shown, 2.0 * np.pi) if whole else np.angle(np.exp(1j * shown))
    assert np.count_nonzero(np.abs(np.diff(columns["yaw"])) > np.pi) > 10
    assert [each.code for each in examine(Log(columns=columns))] == []


def test_degrees_are_still_told() -> None:
    columns = drive(60.0)
    columns["yaw"] = np.degrees(np.angle(np.exp(1j * columns["yaw"])))
    assert "log.implausible_range" in [each.code for each in examine(Log(columns=columns))]
