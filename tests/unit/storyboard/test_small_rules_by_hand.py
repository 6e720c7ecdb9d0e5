"""Small rules of actions, boxes, crowds and curves that one number or one word decides."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard import play as plays
from openscenario.storyboard.actions.lateral import Shift
from openscenario.storyboard.actions.lateral_distance import LateralDistance
from openscenario.storyboard.actions.speed_profile import SpeedProfile
from openscenario.storyboard.actions.visibility import Show
from openscenario.storyboard.crowd import weighted
from openscenario.storyboard.places import Place
from openscenario.storyboard.trajectories import FINE, _nurbs

from .bodies import car


def test_to_be_hidden_is_over_at_once() -> None:
    action = Show(model.VisibilityAction(graphics=True, sensors=False, traffic=True), car())
    assert action.ask() == ("visibility", {"sensors": False, "traffic": True}, 0.0)


def test_who_no_longer_keeps_a_distance_to_the_side_heads_along_its_lane() -> None:
    board: Any = SimpleNamespace(network=object(), entities={"A": car("A"), "B": car("B")})
    element: Any = SimpleNamespace(entity_ref="B", coordinate_system="road", dynamic_constraints=None)
    entity = board.entities["A"]
    action = LateralDistance(element, entity, board)
    entity.drift = 0.2
    action.stop()
    assert entity.drift == 0.0


@pytest.mark.parametrize(("over", "at_once"), [(0.0, True), (0.5, False), (2.0, False)])
def test_a_shift_that_takes_time_is_not_there_at_once(over: float, at_once: bool) -> None:
    entity = car()
    board: Any = SimpleNamespace(ground=SimpleNamespace(drive=lambda entity, way: None))
    assert Shift(entity, board)._begin("linear", over, 1.0) is at_once
    assert entity.offset == (1.0 if at_once else 0.0)


def test_a_profile_without_limits_that_begins_at_time_nought_is_not_late() -> None:
    entity, warned = car(), []
    entity.max_acceleration = entity.max_deceleration = 100.0
    entity.max_deceleration_rate = math.inf
    entries = tuple(model.SpeedProfileEntry(speed=v, time=t) for t, v in ((0.0, 6.0), (2.0, 10.0)))
    element = model.SpeedProfileAction(
        following_mode="position", dynamic_constraints=None, entity_ref=None, speed_profile_entries=entries
    )
    board: Any = SimpleNamespace(entities={"A": entity}, reading="standard", warn=lambda *told: warned.append(told))
    SpeedProfile(element, entity, board).start()
    assert warned == []


def test_a_box_has_its_corners_at_its_length_and_width() -> None:
    """6 m by 2 m, its middle 1 m ahead, turned so that cosine and sine are 0.6 and 0.8, at (10, 20)."""
    entity = car()
    entity.length = 6.0
    entity.put(10.0, 20.0, 0.0, math.atan2(0.8, 0.6))
    assert entity.corners() == (
        pytest.approx((10.0 + 0.6 * 4.0 - 0.8, 20.0 + 0.8 * 4.0 + 0.6)),
        pytest.approx((10.0 - 0.6 * 2.0 - 0.8, 20.0 - 0.8 * 2.0 + 0.6)),
        pytest.approx((10.0 - 0.6 * 2.0 + 0.8, 20.0 - 0.8 * 2.0 - 0.6)),
        pytest.approx((10.0 + 0.6 * 4.0 + 0.8, 20.0 + 0.8 * 4.0 - 0.6)),
    )


def test_what_has_no_weight_never_comes_beside_what_has_some() -> None:
    """Not even if chance says 0.0, the least that it says."""
    chance: Any = SimpleNamespace(random=lambda: 0.0)
    some: Any = [(0.0, "lorry"), (1.0, "car"), (1.0, "bus")]
    none: Any = [(0.0, "lorry"), (0.0, "car")]
    found: list[Any] = [weighted(chance, some), weighted(chance, none)]
    assert found == ["car", "lorry"]


@pytest.mark.parametrize("y", [0.0, 100.0, -100.0])
def test_a_curve_has_ten_samples_for_each_metre_of_its_polygon_wherever_it_lies(y: float) -> None:
    """A polygon of 4 + 5 m."""
    places = iter([Place(0.0, y, 0.0, 0.0), Place(4.0, y, 0.0, 0.0), Place(7.0, y + 4.0, 0.0, 0.0)])
    control = tuple(model.ControlPoint(position=None, time=None, weight=1.0) for _ in range(3))  # type: ignore[arg-type]
    knots = tuple(model.Knot(value=k) for k in (0.0, 0.0, 0.0, 1.0, 1.0, 1.0))
    course = _nurbs(model.Nurbs(order=3, control_points=control, knots=knots), lambda position: next(places))
    assert len(course.s) == 10 * FINE + 1


def test_without_a_seed_a_scenario_is_played_with_nought(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a storyboard has it of itself."""
    asked: list[int] = []

    class Board:
        def __init__(self, *given: Any, seed: int, **more: Any) -> None:
            asked.append(seed)
            raise InterruptedError

    monkeypatch.setattr(plays, "Storyboard", Board)
    with pytest.raises(InterruptedError):
        plays.play(None, None)  # type: ignore[arg-type]
    assert asked == [0]
