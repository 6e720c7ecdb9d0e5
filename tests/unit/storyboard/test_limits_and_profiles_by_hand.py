"""Limits, speed profiles, synchronizing and requests: each piece by itself."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard.actions.appearance import Wait
from openscenario.storyboard.actions.speed_profile import SpeedProfile
from openscenario.storyboard.actions.visibility import Show
from openscenario.storyboard.limits import Limits, both, first, given, performance
from openscenario.storyboard.requests import Asked, request_kind
from openscenario.storyboard.runner import Instant

from .bodies import car

INF = math.inf

# --- limits


def test_limits_are_those_of_the_entity_or_of_the_action() -> None:
    assert performance(car()) == Limits(50.0, 3.0, 6.0, INF, 2.0)
    assert performance(car(bare=True)) == Limits()
    told = model.DynamicConstraints(max_speed=1.0, max_acceleration=2.0, max_deceleration=3.0,
                                    max_acceleration_rate=4.0, max_deceleration_rate=5.0)  # fmt: skip
    assert given(told) == Limits(1.0, 2.0, 3.0, 4.0, 5.0)
    assert given(model.DynamicConstraints(max_speed=1.0)) == Limits(speed=1.0)
    assert given(None) == Limits()


def test_the_narrower_or_the_first_one_that_there_is() -> None:
    one, other = Limits(1.0, 5.0, INF, 4.0, INF), Limits(2.0, 3.0, 6.0, INF, INF)
    assert both(one, other) == Limits(1.0, 3.0, 6.0, 4.0, INF)
    assert first(one, other) == Limits(1.0, 5.0, 6.0, 4.0, INF)
    assert first(other, one) == Limits(2.0, 3.0, 6.0, 4.0, INF)


@pytest.mark.parametrize(("rise", "fall", "smooth"), [(INF, INF, False), (4.0, INF, True), (INF, 4.0, True)])
def test_an_acceleration_may_not_jump_where_a_jerk_is_limited(rise: float, fall: float, smooth: bool) -> None:
    assert Limits(rise=rise, fall=fall).smooth is smooth


@pytest.mark.parametrize(
    ("now", "wanted", "found"),
    [
        (1.0, 3.0, 1.4),  # rises by 4 x 0.1
        (1.0, 1.2, 1.2),
        (1.0, 0.5, 0.5),  # letting go is free
        (1.0, 0.0, 0.0),
        (1.0, -3.0, 0.5),  # falls by 5 x 0.1
        (-1.0, -3.0, -1.5),
        (-1.0, -1.2, -1.2),
        (-1.0, -0.5, -0.5),
        (-1.0, 2.0, -0.6),
        (0.0, -3.0, -0.5),
        (2.0, 2.0, 2.0),
    ],
)
def test_who_keeps_a_distance_accelerates_no_harder_than_it_may(now: float, wanted: float, found: float) -> None:
    assert Limits(rise=4.0, fall=5.0).eased(now, wanted, 0.1) == pytest.approx(found)


# --- speed profiles


def profile(*entries: tuple[float | None, float], mode: Any = "position", limits: Any = None, reading: str = "standard",
            speed: float = 0.0, beside: float | None = None,
            **able: Any) -> tuple[SpeedProfile, Any, list[str]]:  # fmt: skip
    """Of a car that does 50 m/s, 100 m/s^2 either way and any jerk, unless something else is said; and its warnings."""
    entity, other = car("A"), car("B")
    entity.max_acceleration = entity.max_deceleration = 100.0
    entity.max_deceleration_rate = INF
    entity.speed = entity.speed_before = speed
    for name, value in able.items():
        setattr(entity, name, value)
    other.speed = beside or 0.0
    element = model.SpeedProfileAction(
        following_mode=mode, dynamic_constraints=limits, entity_ref="B" if beside is not None else None,
        speed_profile_entries=tuple(model.SpeedProfileEntry(speed=v, time=t) for t, v in entries),
    )  # fmt: skip
    warned: list[str] = []
    board: Any = SimpleNamespace(entities={"A": entity, "B": other}, reading=reading,
                                 warn=lambda element, code, text: warned.append(f"{code}: {text}"))  # fmt: skip
    return SpeedProfile(element, entity, board), entity, warned


def test_a_profile_goes_in_straight_lines_from_entry_to_entry() -> None:
    action, entity, warned = profile((2.0, 10.0), (1.0, 4.0), speed=2.0)
    assert not action.start()
    assert entity.set_speed == 4.0
    found = []
    for _ in range(6):
        done = action.step(0.5)
        found.append((done, round(entity.speed, 9)))
    assert found == [(False, 4.0), (False, 6.0), (False, 8.0), (False, 10.0), (False, 7.0), (True, 4.0)]
    assert warned == []


@pytest.mark.parametrize(
    ("mode", "limits", "speed"),
    [
        ("position", None, 6.0),  # it jumps to the first entry
        ("position", model.DynamicConstraints(max_acceleration=50.0), 2.0),
        ("position", model.DynamicConstraints(max_deceleration=50.0), 2.0),
        ("position", model.DynamicConstraints(max_speed=20.0), 6.0),
        ("position", model.DynamicConstraints(max_speed=5.0), 5.0),
        ("follow", None, 2.0),
    ],
)
def test_a_first_entry_at_time_nought_is_where_a_profile_begins(mode: str, limits: Any, speed: float) -> None:
    action, entity, _ = profile((0.0, 6.0), (2.0, 10.0), mode=mode, limits=limits, speed=2.0)
    action.start()
    assert entity.speed == speed
    if mode == "follow":
        action.step(1.0)
        assert entity.speed == pytest.approx(6.0)  # straight from 2 to 10 m/s in 2 s


def test_speeds_may_be_relative_and_one_without_a_time_is_reached_as_soon_as_it_can_be() -> None:
    action, entity, _ = profile((2.0, 5.0), beside=10.0)
    action.start()
    action.step(1.0)
    assert (entity.speed, entity.set_speed) == (pytest.approx(7.5), 15.0)
    soon, entity, warned = profile((None, 50.0), speed=0.0)
    soon.start()
    assert not soon.step(0.4)
    assert soon.step(0.1)
    assert (entity.speed, warned) == (50.0, [])


@pytest.mark.parametrize(
    ("entries", "more", "said"),
    [
        (((1.0, 60.0),), {}, ["profile-limited: A: 60 m/s is beyond the limit of 50 m/s, which holds"]),
        (((1.0, -60.0),), {}, ["profile-limited: A: 60 m/s is beyond the limit of 50 m/s, which holds"]),
        (((1.0, 50.0),), {}, []),
        (((0.1, 20.0),), {},
         ["profile-limited: A: the limits let the last speed be reached 0.10 s later than its times say"]),
        (((0.2, 20.0),), {}, []),
        (((1.0, 20.0),), {"max_acceleration": 0.0},
         ["profile-limited: A: the limits let the last speed be reached never"]),
        (((0.1, 20.0), (None, 25.0)), {}, []),  # what is as soon as it can be is not late
    ],
)  # fmt: skip
def test_what_the_limits_change_is_said(entries: Any, more: dict[str, Any], said: list[str]) -> None:
    action, _, warned = profile(*entries, **more)
    action.start()
    assert warned == said


@pytest.mark.parametrize(
    ("reading", "limits", "up", "cut"),
    [
        ("standard", model.DynamicConstraints(max_acceleration=200.0), 200.0, False),
        ("esmini", model.DynamicConstraints(max_acceleration=200.0), 100.0, True),
        ("esmini", model.DynamicConstraints(max_acceleration=50.0), 50.0, False),
        ("esmini", None, 100.0, False),
    ],
)
def test_constraints_come_first_or_only_narrow(reading: str, limits: Any, up: float, cut: bool) -> None:
    action, _, warned = profile((1.0, 1.0), reading=reading, limits=limits)
    assert action._limits().up == up
    assert [text.partition(":")[0] for text in warned] == (["reading-constraints"] if cut else [])


@pytest.mark.parametrize(("mode", "rates"), [("position", (INF, INF)), ("follow", (4.0, 5.0))])
def test_straight_lines_have_no_limit_of_jerk(mode: str, rates: tuple[float, float]) -> None:
    limits = model.DynamicConstraints(max_acceleration_rate=4.0, max_deceleration_rate=5.0)
    found = profile((1.0, 1.0), mode=mode, limits=limits)[0]._limits()
    assert (found.rise, found.fall) == rates


def test_an_external_one_is_asked_for_the_whole_profile_and_keeps_its_speed() -> None:
    action, entity, _ = profile((0.0, 6.0), (2.0, 10.0), (1.0, 4.0), speed=2.0)
    entity.speed_before = 1.5
    kind, values, lasts = action.ask()
    assert kind == "speed"
    assert lasts == pytest.approx(3.0)
    assert values["target"] == 4.0
    assert values["times"] == pytest.approx((0.0, 2.0, 3.0))
    assert values["speeds"] == pytest.approx((6.0, 10.0, 4.0))
    assert (entity.speed, entity.speed_before) == (2.0, 1.5)
    never, _, _ = profile((1.0, 20.0), max_acceleration=0.0)
    _, values, lasts = never.ask()
    assert (values["times"], lasts) == ((0.0,), 0.0)


# --- requests and small actions


@pytest.mark.parametrize(
    ("left", "over", "steps"),
    [(0.0, True, []), (0.3, False, [False, False, True]), (0.25, False, [False, False, True])],
)
def test_what_is_asked_of_others_lasts_as_long_as_the_action_would(left: float, over: bool, steps: list[bool]) -> None:
    posted: list[Any] = []
    board: Any = SimpleNamespace(request=lambda entity, kind, values: posted.append((entity, kind, values)))
    runner: Any = SimpleNamespace(ask=lambda: ("speed", {"target": 3.0}, left))
    entity: Any = object()
    asked = Asked(runner, None, entity, board)
    assert asked.start() is over
    assert posted == [(entity, "speed", {"target": 3.0})]
    assert [asked.step(0.1) for _ in steps] == steps


def test_who_does_not_know_what_it_asks_for_asks_by_its_name() -> None:
    posted: list[Any] = []
    board: Any = SimpleNamespace(request=lambda entity, kind, values: posted.append((kind, values)))
    element = model.LongitudinalDistanceAction(entity_ref="B", freespace=True, continuous=False, distance=1.0)
    assert Asked(Instant(), element, car(), board).start()
    assert posted == [("longitudinal_distance", {})]
    assert request_kind(SimpleNamespace()) == "simple_namespace"


@pytest.mark.parametrize(("duration", "steps"), [(0.0, []), (0.2, [False, True]), (0.15, [False, True])])
def test_an_appearance_takes_its_time(duration: float, steps: list[bool]) -> None:
    wait = Wait(duration)
    assert wait.start() is (duration == 0.0)
    assert [wait.step(0.1) for _ in steps] == steps


def test_who_sees_an_entity() -> None:
    def show(sensors: bool, traffic: bool, *names: str) -> None:
        references: Any = tuple(SimpleNamespace(name=name) for name in names)
        element: Any = SimpleNamespace(sensors=sensors, traffic=traffic, sensor_references=references)
        assert Show(element, entity).start()

    entity = car()
    show(False, True, "Lidar", "camera")
    assert [entity.visible.to(name) for name in ("lidar", "camera", "radar")] == [False, False, True]
    assert [entity.visible.traffic] == [True]
    show(True, False, "LIDAR")
    assert [entity.visible.to(name) for name in ("lidar", "camera")] == [True, False]
    assert [entity.visible.traffic] == [False]
    show(False, False)  # without a name all are meant
    assert [entity.visible.to(name) for name in ("lidar", "camera", "radar")] == [False] * 3
    done = []
    once = Instant(lambda: done.append(1))
    assert (once.start(), once.step(0.1), done) == (True, True, [1])
