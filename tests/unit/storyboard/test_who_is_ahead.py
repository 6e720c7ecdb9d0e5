"""Who is ahead in a lane, and who drives by itself behind it: on a road."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.storyboard.car_following import HEADWAY, ahead, following, queues
from openscenario.storyboard.drivers import ASIDE, BACK, activate, drive
from openscenario.storyboard.engine import Storyboard

from .conftest import Make, lane_position, speed, teleport

# --- who is ahead, and who drives by itself


@pytest.fixture
def street(make: Make) -> Storyboard:
    """A at 100 m and B at 140 m in lane -1, C against them at 120 m in lane 1; 5 m long, 4 m of it ahead."""
    made = make(A=[teleport(lane_position(100.0, -1)), speed(10.0)], B=[teleport(lane_position(140.0, -1)), speed(6.0)],
                C=[teleport(lane_position(120.0, 1)), speed(5.0)])  # fmt: skip
    made.start()
    return made


def test_lanes_hold_who_traffic_sees_in_the_order_of_the_road(street: Storyboard) -> None:
    found = queues(street.entities.values(), street.ground)
    assert {lane: [(s, e.name) for s, e in queue] for lane, queue in found.items()} == {
        ("1", -1): [(100.0, "A"), (140.0, "B")], ("1", 1): [(120.0, "C")],
    }  # fmt: skip
    street.entities["A"].active = False
    street.entities["C"].visible.traffic = False
    assert list(queues(street.entities.values(), street.ground)) == [("1", -1)]


def test_a_gap_is_from_the_front_to_the_rear_of_the_next(street: Storyboard) -> None:
    """40 m between the reference points, less 4 m ahead of A and 1 m behind B."""
    a, b, c = (street.entities[name] for name in "ABC")
    lanes = queues(street.entities.values(), street.ground)
    assert ahead(a, lanes, street.ground) == pytest.approx((35.0, 6.0))
    assert ahead(b, lanes, street.ground) == (math.inf, 0.0)
    assert ahead(c, lanes, street.ground) == (math.inf, 0.0)
    b.sense = -1.0  # it comes the other way: its front is 4 m nearer
    assert ahead(a, lanes, street.ground) == pytest.approx((32.0, -6.0))


@pytest.mark.parametrize(
    ("wished", "headway", "set_speed", "law"),
    [(None, None, None, (10.0, 10.0, HEADWAY)), (15.0, None, 99.0, (10.0, 15.0, HEADWAY)),
     (None, 2.5, 12.0, (10.0, 12.0, 2.5)), (90.0, None, None, (10.0, 70.0, HEADWAY))],
)  # fmt: skip
def test_a_driver_follows_who_is_ahead(
    street: Storyboard, wished: Any, headway: Any, set_speed: Any, law: tuple[float, float, float]
) -> None:
    a = street.entities["A"]
    driver: Any = SimpleNamespace(longitudinal=False, lateral=False, wished=wished, headway=headway, at_work=True)
    a.driver, a.set_speed = driver, set_speed
    activate(a, longitudinal=True, lateral=None)
    assert (driver.longitudinal, driver.lateral) == (True, False)
    drive(street, 0.1)
    own, goal, time = law
    wanted = following(own, goal, 35.0, 6.0, time)
    assert a.speed == pytest.approx(10.0 + 0.1 * min(max(wanted, -10.0), 10.0))


@pytest.mark.parametrize(
    ("offset", "sense", "after"),
    [(0.5, 1.0, 0.5 - 0.25 * 0.1), (-0.5, 1.0, -0.5 + 0.25 * 0.1), (3.0, 1.0, 2.9), (0.5, -1.0, 0.5 - 0.025),
     (0.0, 1.0, 0.0)],
)  # fmt: skip
def test_lane_keeping_goes_back_to_the_middle(street: Storyboard, offset: float, sense: float, after: float) -> None:
    """In 2 s if it went on like that, and no faster than 1 m/s."""
    assert (BACK, ASIDE) == (2.0, 1.0)
    a = street.entities["A"]
    driver: Any = SimpleNamespace(longitudinal=False, lateral=True, wished=None, headway=None, at_work=True)
    a.driver, a.offset, a.sense = driver, offset, sense
    drive(street, 0.1)
    assert a.offset == pytest.approx(after)
    assert a.speed == 10.0
    a.moved, before = True, a.offset
    drive(street, 0.1)
    assert a.offset == before
