"""What counts as implausible motion, from both sides of each tolerance; and a trajectory seen from the vehicle."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard.actions.trajectory import FollowTrajectory
from openscenario.storyboard.limits import Limits
from openscenario.storyboard.places import Place
from openscenario.storyboard.plausibility import NOBODY, Plausibility, _Constraint, _Seen, said_of
from openscenario.storyboard.trajectories import Course

from .bodies import car

INF = math.inf
DT = 0.1  # s, of all steps here


def watching(*entities: Any, **more: Any) -> Any:
    board = SimpleNamespace(**{
        "entities": {e.name: e for e in entities}, "acted": [], "steps": 2, "time": 1.5, "done": False,
        "reading": "standard", "events_of": lambda entity: ["Start", "Start", "Brake"], **more,
    })  # fmt: skip
    return Plausibility(board)  # type: ignore[arg-type]


def seen(x: float = 0.0, y: float = 0.0, h: float = 0.0, *, lane: float = 0.0, speed: float = 0.0, ax: Any = None,
         aside: Any = None) -> _Seen:  # fmt: skip
    return _Seen(x, y, h, lane, speed, 0, ax, aside)


def told(watch: Any) -> dict[str, dict[str, Any]]:
    return {finding["field"]: finding for finding in watch.findings()}


# --- along the way: 5 % of a limit, and 0.1 m/s


@pytest.mark.parametrize(
    ("before", "now", "limits", "what"),
    [
        (52.5, 52.59, Limits(speed=50.0), None),  # 50 x 1.05 + 0.1 is allowed
        (52.5, 52.61, Limits(speed=50.0), "speed"),
        (-52.5, -52.61, Limits(speed=50.0), "speed"),
        (10.0, 10.414, Limits(up=3.0), None),  # 3 x 1.05 + 0.1 / 0.1 m/s^2
        (10.0, 10.416, Limits(up=3.0), "acceleration"),
        (10.0, 10.416, Limits(down=3.0), None),
        (10.0, 9.584, Limits(down=3.0), "deceleration"),
        (10.0, 9.584, Limits(up=3.0), None),
        (-10.0, -10.416, Limits(up=3.0), "acceleration"),  # faster, backwards
        (-10.0, -9.584, Limits(down=3.0), "deceleration"),
        (0.0, 0.416, Limits(up=3.0), "acceleration"),
        (0.1, -0.316, Limits(down=3.0), "deceleration"),  # through a standstill
        (10.0, 90.0, NOBODY, None),
    ],
)
def test_motion_beyond_a_limit_is_noted(before: float, now: float, limits: Limits, what: str | None) -> None:
    watch = watching()
    after = seen(speed=now)
    watch._along(car(), seen(speed=before), after, DT, limits)
    assert list(told(watch)) == ([f"A.{what}"] if what else [])
    if limits != NOBODY:
        assert after.ax == pytest.approx((now - before) / DT)


@pytest.mark.parametrize(
    ("ax", "change", "limits", "moved", "what"),
    [
        (0.0, 0.114, Limits(rise=10.0), False, None),  # 1.15 m/s^2 in 0.1 s: allowed are 10 x 1.05 + 0.1 / 0.1
        (0.0, 0.116, Limits(rise=10.0), False, "acceleration_rate"),
        (1.0, 0.214, Limits(rise=10.0), False, None),
        (1.0, 0.216, Limits(rise=10.0), False, "acceleration_rate"),
        (0.0, -0.116, Limits(fall=10.0), False, "deceleration_rate"),
        (0.0, -0.116, Limits(rise=10.0), False, None),
        (5.0, 0.1, Limits(rise=10.0, fall=10.0), False, None),  # letting go of the pedal is free
        (-5.0, -0.1, Limits(rise=10.0, fall=10.0), False, None),
        (5.0, 0.0, Limits(rise=10.0, fall=10.0), False, None),  # and so it is if the speed just stays as it is
        (-5.0, 0.0, Limits(rise=10.0, fall=10.0), False, None),
        (None, 0.5, Limits(rise=10.0), False, None),
        (0.0, 0.5, Limits(rise=10.0), True, None),  # times in a file are too rough
        (0.0, 0.5, Limits(up=50.0), False, None),
    ],
)
def test_a_jerk_beyond_its_limit_is_noted(
    ax: float | None, change: float, limits: Limits, moved: bool, what: str | None
) -> None:
    watch, entity = watching(), car()
    entity.moved = moved
    watch._along(entity, seen(speed=10.0, ax=ax), seen(speed=10.0 + change), DT, limits)
    assert list(told(watch)) == ([f"A.{what}"] if what else [])


@pytest.mark.parametrize(
    ("y", "aside", "limits", "what"),
    [
        (0.1069, None, Limits(speed=1.0), None),  # 1.05 + 0.02 m/s
        (0.1071, None, Limits(speed=1.0), "lateral_speed"),
        (-0.1071, None, Limits(speed=1.0), "lateral_speed"),
        (0.0224, 0.0, Limits(up=2.0), None),  # 2.1 + 0.2 m/s^2 make 0.23 m/s in a step
        (0.0231, 0.0, Limits(up=2.0), "lateral_acceleration"),
        (0.0231, 0.0, Limits(down=2.0), None),
        (0.0769, 1.0, Limits(down=2.0), "lateral_acceleration"),
        (0.0771, 1.0, Limits(down=2.0), None),
        (0.0231, None, Limits(up=2.0), None),
    ],
)
def test_motion_across_a_lane_is_noted(y: float, aside: float | None, limits: Limits, what: str | None) -> None:
    watch = watching()
    after = seen(y=y)
    watch._aside(car(), seen(aside=aside), after, DT, [_Constraint("Shift", limits, True)])
    assert list(told(watch)) == ([f"A.{what}"] if what else [])
    assert after.aside == pytest.approx(y / DT)
    if what:
        assert told(watch)[f"A.{what}"]["limit"] == "DynamicConstraints"
        assert told(watch)[f"A.{what}"]["event"] == "Shift"


def test_across_a_lane_that_bends_counts_from_its_mean_direction() -> None:
    """The lane turns from 0 to 0.2 rad: a way of 1 m at 0.1 rad is along it."""
    watch, after = watching(), seen(math.cos(0.1), math.sin(0.1), lane=0.2)
    watch._aside(car(), seen(), after, DT, [_Constraint("Shift", Limits(speed=1.0), True)])
    assert after.aside == pytest.approx(0.0, abs=1e-12)
    west = seen(math.cos(math.pi), math.sin(math.pi), lane=0.1 - math.pi)  # it turns from pi - 0.1 on, by 0.2
    watch._aside(car(), seen(lane=math.pi - 0.1), west, DT, [_Constraint("Shift", Limits(speed=1.0), True)])
    assert west.aside == pytest.approx(0.0, abs=1e-12)
    none = seen(y=9.0)
    watch._aside(car(), seen(), none, DT, [])
    assert none.aside is None


# --- jumps


@pytest.mark.parametrize(
    ("x", "h", "before", "now", "bare", "kind", "what"),
    [
        (1.49, 0.0, 10.0, 10.0, False, "vehicle", None),  # 10 m/s for 0.1 s and half a metre
        (1.51, 0.0, 10.0, 10.0, False, "vehicle", "position"),
        (1.51, 0.0, 5.0, -10.2, True, "pedestrian", "speed_jump"),
        (0.0, 0.199, 0.0, 0.0, False, "vehicle", None),
        (0.0, 0.201, 0.0, 0.0, False, "vehicle", "heading"),
        (0.0, -0.201, 0.0, 0.0, False, "vehicle", "heading"),
        (0.4, 0.399, 4.0, 4.0, False, "vehicle", None),  # 0.4 m on a circle of 2 m
        (0.4, 0.401, 4.0, 4.0, False, "vehicle", "heading"),
        (0.0, 3.0, 0.0, 0.0, False, "pedestrian", None),
        (0.3, 0.0, 0.0, 2.99, True, "vehicle", None),
        (0.3, 0.0, 0.0, 3.01, True, "vehicle", "speed_jump"),
        (0.3, 0.0, 3.01, 0.0, True, "vehicle", "speed_jump"),
    ],
)
def test_a_jump_is_noted(
    x: float, h: float, before: float, now: float, bare: bool, kind: str, what: str | None
) -> None:
    watch, entity = watching(), car(bare=bare, kind=kind)
    if not bare:
        entity.max_acceleration = entity.max_deceleration = 1e4
    watch._compare(entity, seen(speed=before), seen(x, h=h, speed=now), DT, ())
    assert list(told(watch)) == ([f"A.{what}"] if what else [])
    if what:
        assert told(watch)[f"A.{what}"]["limit"] == "continuity"
        assert told(watch)[f"A.{what}"]["event"] == "Start, Brake"


def test_the_constraints_of_an_action_come_before_the_performance_by_the_standard_alone() -> None:
    """From 10 to 10.6 m/s: 6 m/s^2 where the car can 3 and the action allows 9."""
    for reading, limit in (("standard", []), ("field", ["Performance"])):
        watch = watching(reading=reading)
        watch._compare(car(), seen(speed=10.0), seen(1.0, speed=10.6), DT, (_Constraint("Go", Limits(up=9.0), False),))
        assert [finding["limit"] for finding in watch.findings()] == limit
    watch = watching()
    watch._compare(car(), seen(speed=10.0), seen(1.0, speed=10.6), DT, (_Constraint("Go", Limits(up=2.0), False),))
    assert [(f["limit"], f["event"], f["allowed"]) for f in watch.findings()] == [
        ("Performance", "Start, Brake", "up to 2 m/s^2"),
        ("DynamicConstraints", "Go", "up to 2 m/s^2 by DynamicConstraints of Go"),
    ]


def test_only_steps_without_a_teleport_of_what_the_storyboard_moves_are_looked_at() -> None:
    def looked(**more: Any) -> int:
        entity = car()
        watch = watching(entity, steps=more.pop("steps", 2))
        for name, value in more.items():
            setattr(entity, name, value)
        entity.x = 50.0
        watch.look(DT)
        return len(watch.findings())

    assert looked() == 1
    assert looked(steps=1) == 0  # how a scenario begins
    assert looked(teleports=1) == looked(external=True) == looked(active=False) == looked(drawn_by=car("B")) == 0


def test_the_first_time_is_kept_and_the_worst_is_told() -> None:
    watch, entity = watching(), car()
    for found in (60.0, 55.0, 70.0):
        watch._note(entity, "speed", found, 52.6, 50.0)
        watch._board.time += 1.0
    watch._note(entity, "speed", 52.6, 52.6, 50.0)
    (finding,) = watch.findings()
    assert (finding["t"], finding["found"], finding["worst"], finding["count"]) == (1.5, 60.0, 70.0, 3)
    assert said_of(finding) == (
        "implausible motion: speed of A 60 m/s at t=1.50 s (Start, Brake), allowed up to 50 m/s, in 3 steps, "
        "70 m/s at worst"
    )
    watch = watching(events_of=lambda entity: [])
    entity.end_of_road = True
    watch._note(entity, "lateral_speed", 2.0, 1.0, 1.0)
    (finding,) = watch.findings()
    assert said_of(finding) == (
        "implausible motion: lateral speed of A 2 m/s at t=1.50 s (the end of its road), allowed up to 1 m/s, in 1 step"
    )


# --- a trajectory, seen from who follows it: 10 m along x, then 10 m to the left, rising by 5 m

LINE = [(0.0, 0.0, 0.0, 0.0), (10.0, 0.0, 0.0, 0.5 * math.pi), (10.0, 10.0, 5.0, 0.5 * math.pi)]


def follower(s: float, *, reverse: bool = False, explicit: bool = False, hilly: bool = True) -> tuple[Any, Any]:
    action: Any = FollowTrajectory.__new__(FollowTrajectory)
    entity = car()
    action._entity, action._course, action._s, action._reverse = entity, Course(LINE, explicit=explicit), s, reverse
    action._hilly, action._aim = hilly, (math.nan, math.nan, 0.0)
    return action, entity


@pytest.mark.parametrize(
    ("reverse", "explicit", "h", "pitch"),
    [
        (False, False, 0.5 * math.pi, -math.atan2(5.0, 10.0)),
        (True, False, -0.5 * math.pi, math.atan2(5.0, 10.0)),
        (True, True, 0.5 * math.pi, math.atan2(5.0, 10.0)),
    ],
)
def test_who_goes_rear_first_looks_back_unless_its_headings_are_given(
    reverse: bool, explicit: bool, h: float, pitch: float
) -> None:
    action, entity = follower(15.0, reverse=reverse, explicit=explicit)
    action._go(action._course)
    assert (entity.x, entity.y, entity.z, entity.h, entity.pitch) == pytest.approx((10.0, 5.0, 2.5, h, pitch))
    flat, other = follower(15.0, hilly=False)
    flat._go(flat._course)
    assert other.pitch == 0.0


@pytest.mark.parametrize(
    ("x", "y", "place"),
    [
        (4.0, 1.0, (-1.0, 1.0, 0.0)),
        (-3.0, 1.0, (-8.0, 1.0, 0.0)),  # before its beginning it goes straight on
        (12.0, 5.0, (10.0, -2.0, 0.5 * math.pi)),
        (9.0, 14.0, (19.0, 1.0, 0.5 * math.pi)),  # behind its end, too
    ],
)
def test_a_place_in_the_coordinates_of_a_trajectory(x: float, y: float, place: tuple[float, float, float]) -> None:
    """5 m along it."""
    action, _ = follower(5.0)
    assert action.beside(x, y) == pytest.approx(place)


def test_the_way_to_a_place_is_along_the_trajectory_either_way() -> None:
    action, _ = follower(5.0)
    assert action.way_to(Place(2.0, 1.0, 0.0, 0.0)) == pytest.approx(3.0)
    assert action.way_to(Place(12.0, 5.0, 0.0, 0.0)) == pytest.approx(10.0)
    action._s = 8.0
    assert action.way_to(Place(12.0, 5.0, 0.0, 0.0)) == pytest.approx(7.0)
    assert action.axis() == pytest.approx((0.0, 0.0))


def timed(times: list[float], clock: float, *, offset: float = 0.0, scale: float = 1.0, cut: float = 0.0,
          speed: float = 0.0, reverse: bool = False) -> tuple[Any, Any]:  # fmt: skip
    action, entity = follower(0.0, reverse=reverse)
    action._course = Course(LINE, times)
    action._clock, action._cut, action._s = clock, cut, max(cut, action._course.s_at((clock - offset) / scale))
    timing = model.Timing(domain_absolute_relative="relative", offset=offset, scale=scale)
    action._element = SimpleNamespace(time_reference=timing)
    entity.speed = speed
    return action, entity


@pytest.mark.parametrize(
    ("clock", "given", "over", "s", "speed"),
    [
        (1.0, {}, -1.0, 7.5, 5.0),  # 10 m in 2 s
        (1.5, {}, 0.0, 20.0, 20.0),  # there just now
        (1.0, {"offset": 0.5}, -1.0, 5.0, 5.0),
        (1.0, {"scale": 2.0}, -1.0, 3.75, 2.5),
        (0.0, {"cut": 4.0}, -1.0, 4.0, 0.0),
        (0.5, {"cut": 4.0}, -1.0, 5.0, 2.0),
        (1.0, {"reverse": True}, -1.0, 7.5, -5.0),
    ],
)
def test_a_trajectory_in_its_own_time(clock: float, given: Any, over: float, s: float, speed: float) -> None:
    """Half a second later; its vertices are at 0, 2 and 4 s, or at 0, 1.5 and 2 s."""
    times = [0.0, 1.5, 2.0] if clock == 1.5 else [0.0, 2.0, 4.0]
    action, entity = timed(times, clock, **given)
    assert action._step_timed(0.5, action._course) == pytest.approx(over)
    assert action._s == pytest.approx(s)
    assert entity.speed == pytest.approx(speed)
    assert entity.ax == pytest.approx(speed / 0.5)


def test_behind_the_end_of_its_time_it_goes_on_with_its_speed() -> None:
    action, entity = timed([0.0, 2.0, 4.0], 3.9, speed=5.0)
    assert action._step_timed(0.5, action._course) == pytest.approx(0.4 * 5.0)
    assert entity.speed == 5.0
