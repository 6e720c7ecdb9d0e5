"""Which rows count as a slide: an antenna far ahead in a tight turn goes into the turn, a sliding car out of it."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import cut
from pytest_dvp.logs.log_contents import FloatArray

T = np.arange(0.0, 20.0, 0.02)
WHEELBASE = 4.5  # m, of a lorry


def circles(*, speed: float, rate: float, ahead: float = 0.0, drifts: float = 0.0) -> FloatArray:
    """A circle of the rear axle, measured by an antenna `ahead` of it [m]; drifts: rad by which the course of the axle
    lies out of the turn."""
    yaw = rate * T
    course = yaw - drifts * np.sign(rate) + (np.pi if speed < 0.0 else 0.0)
    step = abs(speed) * 0.02
    x = np.cumsum(step * np.cos(course)) + ahead * np.cos(yaw)
    y = np.cumsum(step * np.sin(course)) + ahead * np.sin(yaw)
    measured = np.zeros((len(T), 8))
    measured[:, 0], measured[:, 1], measured[:, 2] = x, y, yaw
    measured[:, 3], measured[:, 4] = speed, rate
    return measured


@pytest.mark.parametrize("rate", [0.38, -0.38])
@pytest.mark.parametrize("speed", [5.0, -5.0])
@pytest.mark.parametrize("ahead", [-1.0, 0.0, 4.0, 5.5])
def test_an_antenna_anywhere_on_a_lorry_in_a_tight_turn_shows_no_slide(speed: float, rate: float, ahead: float) -> None:
    """Up to atan(5.5 m / 13 m) = 0.40 rad into the turn, forwards and backwards."""
    found = cut(T, circles(speed=speed, rate=rate, ahead=ahead), wheelbase=WHEELBASE)
    assert not found.slides.any()
    assert not found.abandoned.any()


@pytest.mark.parametrize("rate", [0.38, -0.38])
@pytest.mark.parametrize("speed", [5.0, -5.0])
def test_a_course_out_of_the_turn_by_as_much_is_a_slide(speed: float, rate: float) -> None:
    sign = 1.0 if speed > 0.0 else -1.0  # backwards the tail points ahead
    found = cut(T, circles(speed=speed, rate=rate, drifts=0.4 * sign), wheelbase=WHEELBASE)
    assert found.slides.mean() > 0.9


def test_straight_ahead_an_antenna_explains_nothing() -> None:
    measured = circles(speed=10.0, rate=1e-6, drifts=-0.35)
    assert cut(T, measured, wheelbase=WHEELBASE).slides.mean() > 0.9


@pytest.mark.parametrize("pause", [False, True])
def test_the_chord_over_an_outage_or_a_pause_of_a_turning_car_is_no_slide(pause: bool) -> None:
    measured = circles(speed=5.0, rate=0.38)
    hole = (T >= 8.0) & (T < 12.0)
    measured[hole, :2] = np.nan
    kept = ~hole if pause else np.ones(len(T), dtype=bool)
    found = cut(T[kept], measured[kept], wheelbase=WHEELBASE)
    assert not found.slides.any()
    assert not found.abandoned.any()
