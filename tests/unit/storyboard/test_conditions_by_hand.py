"""Conditions on time, speed and signals, and positions that few scenarios use, each with numbers worked out by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard.conditions import motion, values
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.positions import _orientation, _some
from openscenario.storyboard.world import World

RULES = ("greaterThan", "greaterOrEqual", "lessThan", "lessOrEqual", "equalTo", "notEqualTo")


@pytest.mark.parametrize(
    ("time", "holds"),
    [
        (4.5, (False, False, True, True, False, True)),
        (5.0 - 1e-12, (False, True, False, True, True, False)),
        (5.0 + 1e-12, (False, True, False, True, True, False)),
        (5.05, (True, True, False, False, True, True)),  # the step of 0.1 s that passes it counts as equal
        (5.2, (True, True, False, False, False, True)),
    ],
)
def test_a_time_is_compared_with_the_resolution_of_a_clock(time: float, holds: tuple[bool, ...]) -> None:
    scope: Any = SimpleNamespace(board=SimpleNamespace(time=time, dt=0.1))
    for rule, expected in zip(RULES, holds, strict=True):
        element: Any = SimpleNamespace(rule=rule, value=5.0)
        assert values.simulation_time(element, None, scope)() is expected, rule


def test_a_signal_is_in_the_state_asked_for() -> None:
    world = World()
    scope: Any = SimpleNamespace(board=SimpleNamespace(world=world))
    test = values.traffic_signal(SimpleNamespace(name="s", state="red"), None, scope)  # type: ignore[arg-type]
    assert test() is False
    world.show("s", "red")
    assert test() is True
    world.show("s", "green")
    assert test() is False


def moving(h: float = 0.0, speed: float = 0.0, vx: float = 0.0, vy: float = 0.0, active: bool = True) -> Any:
    return SimpleNamespace(h=h, speed=speed, vx=vx, vy=vy, active=active, ax=0.0)


@pytest.mark.parametrize(
    ("direction", "relative"),
    # seen by who heads up: the other is 3 m/s slower ahead (up), and goes to its right (east) at 4 m/s
    [(None, 1.5), ("longitudinal", 3.0), ("lateral", 4.0), ("vertical", 0.0)],
)
def test_a_relative_speed_is_that_of_the_entity_less_the_others_along_its_own_axes(
    direction: Any, relative: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine, other = moving(0.5 * math.pi, speed=6.5, vx=0.0, vy=6.0), moving(0.1, speed=5.0, vx=4.0, vy=3.0)
    monkeypatch.setattr(motion, "entity_called", lambda name, board: other)
    scope: Any = SimpleNamespace(board=None)
    for value, expected in ((relative - 0.01, True), (relative + 0.01, False)):
        element: Any = SimpleNamespace(entity_ref="B", rule="greaterThan", value=value, direction=direction)
        other.active = True
        test = motion.relative_speed(element, mine, scope)
        assert test() is expected
        other.active = False
        assert test() is False


@pytest.mark.parametrize(
    ("direction", "speed"), [(None, 7.0), ("longitudinal", 7.0), ("lateral", 2.0), ("vertical", 0.0)]
)
def test_a_speed_has_a_part_ahead_and_one_to_the_left(direction: Any, speed: float) -> None:
    """It heads at 30 degrees and moves 5 m/s along that and 2 m/s to its left."""
    c, s = math.cos(math.pi / 6.0), math.sin(math.pi / 6.0)
    entity = moving(math.pi / 6.0, speed=7.0, vx=5.0 * c - 2.0 * s, vy=5.0 * s + 2.0 * c)
    assert motion._speed(direction)(entity) == pytest.approx(speed)


def test_the_lateral_acceleration_is_the_change_of_velocity_to_the_left() -> None:
    entity, board = moving(math.pi / 6.0), SimpleNamespace(time=1.0)
    now = motion._lateral(entity, board)  # type: ignore[arg-type]
    entity.vx, entity.vy = 1.0, 2.0
    assert now() == 0.0
    board.time, entity.vx, entity.vy = 1.5, 2.0, 5.0
    assert now() == pytest.approx((3.0 * math.cos(math.pi / 6.0) - 1.0 * math.sin(math.pi / 6.0)) / 0.5)
    assert now() == 0.0  # no time has passed
    board.time = 1.7
    assert now() == pytest.approx(0.0)


# --- positions


def test_twelve_names_are_told_and_that_there_are_more() -> None:
    assert _some(tuple("abc")) == "a, b, c"
    assert _some(tuple("abcdefghijkl")) == "a, b, c, d, e, f, g, h, i, j, k, l"
    assert _some(tuple("abcdefghijklm")) == "a, b, c, d, e, f, g, h, i, j, k, l, ..."


def test_an_orientation_is_added_to_the_base_or_stands_for_itself() -> None:
    assert _orientation(None, 0.3) == 0.3
    assert _orientation(model.Orientation(h=0.5, type="relative"), 0.3) == 0.8
    assert _orientation(model.Orientation(h=0.5, type="absolute"), 0.3) == 0.5


def test_who_has_no_box_is_a_point() -> None:
    what: Any = SimpleNamespace(name="A", kind="external", category="", entity=SimpleNamespace(), bounding_box=None)
    entity = Entity(what, external=False)
    sizes = (entity.length, entity.width, entity.height, entity.center_x, entity.center_y, entity.center_z)
    assert sizes == (0.0,) * 6
    assert (entity.wheelbase, entity.hitch, entity.coupler, entity.leads) == (0.0,) * 4
    assert (entity.max_speed, entity.max_acceleration, entity.max_deceleration) == (math.inf,) * 3
    assert (entity.max_acceleration_rate, entity.max_deceleration_rate) == (math.inf,) * 2
    assert (entity.max_steer, entity.mass) == (0.6, 1500.0)
    state = (entity.x, entity.y, entity.z, entity.h, entity.pitch, entity.roll, entity.speed, entity.vx, entity.vy,
             entity.ax, entity.speed_before, entity.lane, entity.s, entity.offset, entity.twist, entity.drift,
             entity.travelled, entity.teleports, entity.longitudinal_order, entity.lateral_order)  # fmt: skip
    assert state == (0.0,) * 20
    assert (entity.sense, entity.along) == (1.0, 1.0)
    assert entity.still_since == entity.end_since == math.inf
    off = (entity.tracked, entity.shifted, entity.end_of_road, entity.blocked, entity.moved, entity.placed, entity.late)
    assert not any(off)
    assert entity.active
