"""Moving to the side, drivers, conditions of contact and angle, and places on the earth: by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard import drivers
from openscenario.storyboard.actions.beside import side_of, steer
from openscenario.storyboard.actions.lateral_distance import LateralDistance
from openscenario.storyboard.conditions.angle import _within
from openscenario.storyboard.conditions.clearance import _number as lane_number
from openscenario.storyboard.conditions.contact import collision, end_of_road, off_road
from openscenario.storyboard.driver import Driver
from openscenario.storyboard.geo import projection
from openscenario.storyboard.limits import Limits
from openscenario.storyboard.road_watch import RoadWatch
from openscenario.storyboard.unsupported import Unsupported

from .bodies import car

INF = math.inf


# --- to the side


@pytest.mark.parametrize(
    ("displacement", "left", "side"),
    [("any", 0.0, 1.0), ("any", -0.1, -1.0), ("any", 2.0, 1.0), ("leftToReferencedEntity", -5.0, 1.0),
     ("rightToReferencedEntity", 5.0, -1.0)],
)  # fmt: skip
def test_the_side_of_the_other(displacement: str, left: float, side: float) -> None:
    assert side_of(SimpleNamespace(displacement=displacement), left) == side  # type: ignore[arg-type]


def aside(limits: Limits, *, apart: float, rate: float = 0.0, sense: float = 1.0, continuous: bool = True) -> Any:
    """Wants 3 m to the left of the other, is `apart` to the left of it."""
    action: Any = LateralDistance.__new__(LateralDistance)
    entity = SimpleNamespace(offset=0.0, sense=sense, drift=0.0, along=1.0, shifted=False, speed=10.0,
                             speed_before=10.0, late=False)  # fmt: skip
    action._entity, action._limits, action._rate, action._acceleration = entity, limits, rate, 0.0
    action._element = SimpleNamespace(continuous=continuous)
    ground = SimpleNamespace(track=lambda entity: True, drive=lambda entity, way: None)
    action._board, action._there = SimpleNamespace(ground=ground), False
    return action, entity, lambda: 3.0 - apart - entity.offset


@pytest.mark.parametrize(
    ("limits", "apart", "rate", "moved", "next_rate"),
    [
        (Limits(speed=2.0), 0.0, 0.0, 0.2, 2.0),  # at its speed
        (Limits(speed=2.0), 6.0, 0.0, -0.2, -2.0),
        (Limits(speed=2.0), 2.9, 0.0, 0.1, 1.0),  # no farther than it is
        (Limits(up=1.0, down=2.0), 0.0, 0.5, 0.05, 0.6),  # 0.4 x 3 - 2 sqrt(0.4) 0.5 = 0.57 m/s^2
        (Limits(up=1.0, down=2.0), 6.0, 0.5, 0.05, 0.5 - 0.1832),  # braked: -1.2 - 0.63 is within 2
        (Limits(speed=0.52, up=1.0, down=2.0), 0.0, 0.5, 0.05, 0.52),
        (Limits(up=0.1, down=0.1), 0.0, 0.0, 0.0, 0.01),  # 0.04 x 3 = 0.12 is too much
    ],
)
def test_moving_over_as_the_limits_allow(
    monkeypatch: pytest.MonkeyPatch, limits: Limits, apart: float, rate: float, moved: float, next_rate: float
) -> None:
    """A critically damped spring of 0.4 times the limit, for 0.1 s; what it moves with is from the step before."""
    for sense in (1.0, -1.0):
        action, entity, to_go = aside(limits, apart=apart, rate=rate, sense=sense)
        monkeypatch.setattr(LateralDistance, "_to_go", lambda self, to_go=to_go, sense=sense: sense * to_go())
        assert action.step(0.1) is False
        assert entity.offset == pytest.approx(sense * moved, abs=1e-9)
        expected = 0.5 + 0.1 * (1.2 - 2.0 * math.sqrt(0.4) * 0.5) if next_rate == 0.6 else next_rate
        assert action._rate == pytest.approx(expected, abs=2e-3)


def test_it_is_over_after_a_step_within_a_centimetre(monkeypatch: pytest.MonkeyPatch) -> None:
    for apart, continuous, over in ((2.991, False, True), (2.989, False, False), (2.991, True, False)):
        action, _, _ = aside(Limits(speed=0.0), apart=apart, continuous=continuous)
        monkeypatch.setattr(LateralDistance, "_to_go", lambda self, apart=apart: 3.0 - apart)
        assert action.step(0.1) is False
        assert action.step(0.1) is over


@pytest.mark.parametrize(
    ("to_line", "h", "heading"),
    [
        (9e-7, 0.3, 0.0),  # on the line: along it
        (5.0, 0.0, 0.15),  # near it: towards it, as hard as it may
        (20.0, 1.5, 0.5 * math.pi),
    ],
)
def test_who_steers_for_a_line(to_line: float, h: float, heading: float) -> None:
    """The line runs along 0 and lies to the left; a step of 1 m turns by 1.5 / 10 rad at most."""
    found = steer(h, to_line, 0.5 * math.pi, 0.0, 10.0, 1.0)
    assert found == pytest.approx(heading)


# --- who drives


@pytest.mark.parametrize(("text", "number"), [("12", 12.0), ("0", None), ("-1", None), ("inf", None), ("x", None),
                                              (None, None)])  # fmt: skip
def test_what_a_driver_was_told(text: str | None, number: float | None) -> None:
    told = {"setSpeed": text, "timeGap": text} if text is not None else {}
    driver = Driver(SimpleNamespace(properties=told))  # type: ignore[arg-type]
    assert (driver.wished, driver.headway, driver.at_work) == (number, number, False)


@pytest.mark.parametrize(("set_speed", "told", "wished"), [(None, None, 7.0), (9.0, None, 9.0), (9.0, "12", 12.0)])
def test_a_driver_wishes_what_it_was_told_or_the_speed_it_has(set_speed: Any, told: Any, wished: float) -> None:
    entity = car()
    entity.speed, entity.set_speed = 7.0, set_speed
    drivers.activate(entity, longitudinal=True, lateral=True)  # without one nothing happens
    entity.driver = Driver(SimpleNamespace(properties={"setSpeed": told} if told else {}))  # type: ignore[arg-type]
    drivers.activate(entity, longitudinal=None, lateral=True)
    assert (entity.driver.longitudinal, entity.driver.lateral, entity.driver.at_work) == (False, True, True)
    drivers.activate(entity, longitudinal=True, lateral=False)
    assert (entity.driver.longitudinal, entity.driver.lateral) == (True, False)
    assert entity.driver.wished == wished
    drivers.activate(entity, longitudinal=False, lateral=None)
    assert not entity.driver.at_work


# --- conditions


@pytest.mark.parametrize(
    ("angle", "wanted", "tolerance", "holds"),
    [(0.1, 0.0, 0.1, True), (0.1001, 0.0, 0.1, False), (-0.1, 0.0, 0.1, True), (math.tau + 0.05, 0.0, 0.1, True),
     (-3.1, 3.1, 0.1, True), (3.0, -3.2, 0.0, False)],
)  # fmt: skip
def test_an_angle_within_its_tolerance_modulo_a_turn(
    angle: float, wanted: float, tolerance: float, holds: bool
) -> None:
    assert _within(angle, wanted, tolerance) is holds


def test_lanes_are_numbered_without_a_gap() -> None:
    assert [lane_number(lane) for lane in (-2, -1, 1, 2)] == [-2, -1, 0, 1]


def met(others: dict[str, Any], target: Any, mine: Any) -> bool:
    board: Any = SimpleNamespace(entities={"A": mine, **others})
    scope: Any = SimpleNamespace(board=board)
    return bool(collision(SimpleNamespace(target=target), mine, scope)())  # type: ignore[arg-type]


@pytest.mark.parametrize(("x", "hit"), [(4.0, True), (4.001, False), (-4.0, True), (-4.001, False)])
def test_a_collision_with_one_or_with_any_of_a_kind(x: float, hit: bool) -> None:
    mine, other, walker = car("A"), car("B"), car("C", kind="pedestrian")
    other.put(x, 0.0, 0.0, 0.0)
    walker.put(0.0, 50.0, 0.0, 0.0)
    others = {"B": other, "C": walker}
    assert met(others, model.EntityRef(entity_ref="B"), mine) is hit
    assert met(others, SimpleNamespace(type="vehicle"), mine) is hit
    assert not met(others, SimpleNamespace(type="pedestrian"), mine)
    other.active = False
    assert not met(others, model.EntityRef(entity_ref="B"), mine)


def test_off_the_road_and_at_its_end_for_so_long() -> None:
    entity = car()
    watch = RoadWatch(SimpleNamespace(on_road=lambda entity: entity.x < 1.0))  # type: ignore[arg-type]
    board: Any = SimpleNamespace(time=5.0, road_watch=watch)
    scope: Any = SimpleNamespace(board=board)
    at_end = end_of_road(SimpleNamespace(duration=2.0), entity, scope)  # type: ignore[arg-type]
    off = off_road(SimpleNamespace(duration=2.0), entity, scope)  # type: ignore[arg-type]
    assert not at_end()
    assert not off()
    entity.end_of_road, entity.x = True, 2.0
    for time, holds in ((5.0, False), (6.9, False), (7.0, True), (8.0, True)):
        board.time = time
        watch.note(entity, time)
        assert (at_end(), off()) == (holds, holds)
    entity.x = 0.0
    watch.note(entity, 8.5)  # seen, though the condition is not asked while its event runs
    entity.x, board.time = 2.0, 9.0
    watch.note(entity, 9.0)
    assert not off()  # the time begins again


# --- on the earth


def test_a_projection_takes_longitude_before_latitude() -> None:
    """In the transverse Mercator of 9 degrees east a degree of the equator is about 111 km, a point on it x = 0."""
    project = projection("+proj=tmerc +lat_0=0 +lon_0=9 +k=1 +x_0=0 +y_0=0 +ellps=WGS84")
    assert project(9.0, 0.0) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert project(9.0, 1.0) == pytest.approx((0.0, 110574.4), abs=1.0)
    assert project(10.0, 0.0)[0] == pytest.approx(111325.0, abs=10.0)


@pytest.mark.parametrize(("text", "says"), [("", "has no geoReference"), ("  ", "has no geoReference"),
                                            ("+proj=nonsense", "is no projection")])  # fmt: skip
def test_what_is_no_projection_is_told(text: str, says: str) -> None:
    with pytest.raises(Unsupported, match=says):
        projection(text)
