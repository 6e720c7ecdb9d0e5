"""Limits of an action and of a vehicle: which count, and how an acceleration is brought within those of jerk."""

from __future__ import annotations

import math

import pytest

from openscenario import model
from openscenario.storyboard.limits import Limits, both, first, given

OWN = Limits(speed=10.0, up=math.inf, down=4.0, rise=math.inf, fall=1.0)
ABLE = Limits(speed=30.0, up=3.0, down=2.0, rise=math.inf, fall=5.0)


def test_the_narrower_of_each_counts() -> None:
    assert both(OWN, ABLE) == (10.0, 3.0, 2.0, math.inf, 1.0)


def test_the_second_s_count_only_where_the_first_has_none() -> None:
    assert first(OWN, ABLE) == (10.0, 3.0, 4.0, math.inf, 1.0)


def test_without_constraints_nothing_is_limited() -> None:
    assert given(None) == Limits() == (math.inf,) * 5


def test_each_constraint_is_the_limit_of_its_name() -> None:
    constraints = model.DynamicConstraints(
        max_speed=1.0, max_acceleration=2.0, max_deceleration=3.0, max_acceleration_rate=4.0, max_deceleration_rate=5.0
    )
    assert given(constraints) == Limits(speed=1.0, up=2.0, down=3.0, rise=4.0, fall=5.0)
    assert given(model.DynamicConstraints(max_deceleration=0.0)) == Limits(down=0.0)


@pytest.mark.parametrize(
    ("limits", "smooth"),
    [
        (Limits(), False),
        (Limits(up=1.0, down=1.0, speed=1.0), False),
        (Limits(rise=9.0), True),
        (Limits(fall=9.0), True),
    ],
)
def test_an_acceleration_is_smooth_where_its_change_has_any_limit(limits: Limits, smooth: bool) -> None:
    assert limits.smooth is smooth


@pytest.mark.parametrize(
    ("now", "wanted", "eased"),
    [
        (1.0, 5.0, 1.4),  # rises by no more than 4 m/s^3 x 0.1 s
        (1.0, 1.3, 1.3),
        (-1.0, 2.0, -0.6),  # from braking to accelerating it rises, too
        (-1.0, 0.0, -0.6),
        (-1.0, -0.2, -0.2),  # letting go of the brake is free
        (-1.0, -5.0, -1.3),  # braking harder: 3 m/s^3 x 0.1 s
        (-1.0, -1.2, -1.2),
        (2.0, -5.0, 1.7),
        (2.0, 1.0, 1.0),  # letting go of the pedal is free
        (2.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
    ],
)
def test_only_a_harder_acceleration_is_eased(now: float, wanted: float, eased: float) -> None:
    assert Limits(rise=4.0, fall=3.0).eased(now, wanted, 0.1) == pytest.approx(eased)


def test_without_limits_of_jerk_any_acceleration_is_there_at_once() -> None:
    assert Limits(up=1.0).eased(-3.0, 9.0, 0.1) == 9.0
    assert Limits(up=1.0).eased(3.0, -9.0, 0.1) == -9.0
