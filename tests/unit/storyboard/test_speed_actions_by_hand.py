"""SpeedAction step by step, without a storyboard: what is wanted, how long it takes, and what a moving target does."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard.actions.speed import FASTEST, Speed, _time_over

from .bodies import car

INF = math.inf


def dynamics(shape: Any, dimension: Any, value: float) -> model.TransitionDynamics:
    return model.TransitionDynamics(dynamics_shape=shape, dynamics_dimension=dimension, value=value)


def to(target: float, shape: str = "linear", dimension: str = "time", value: float = 2.0, *, speed: float = 0.0,
       **able: Any) -> tuple[Speed, Any]:  # fmt: skip
    """An action of a car that can do 3 m/s^2 up, 6 down and 50 m/s, unless something else is said."""
    entity = driving(speed, **able)
    element = model.SpeedAction(speed_action_dynamics=dynamics(shape, dimension, value),
                                speed_action_target=model.AbsoluteTargetSpeed(value=target))  # fmt: skip
    return Speed(element, entity, SimpleNamespace(entities={})), entity


def driving(speed: float, name: str = "A", **able: Any) -> Any:
    entity = car(name)
    entity.speed = entity.speed_before = speed
    for key, value in able.items():
        setattr(entity, key, value)
    return entity


def after(
    other: Any, amount: float, kind: Any = "delta", shape: str = "linear", dimension: str = "time", value: float = 2.0,
    *, continuous: bool = False, speed: float = 0.0, own: bool = False,
) -> tuple[Speed, Any]:  # fmt: skip
    entity = driving(speed, max_acceleration=1e3, max_deceleration=1e3)
    target = model.RelativeTargetSpeed(entity_ref="A" if own else "B", value=amount, speed_target_value_type=kind,
                                       continuous=continuous)  # fmt: skip
    element = model.SpeedAction(
        speed_action_dynamics=dynamics(shape, dimension, value), speed_action_target=target)  # fmt: skip
    return Speed(element, entity, SimpleNamespace(entities={"A": entity, "B": other})), entity


@pytest.mark.parametrize(
    ("shape", "dimension", "value", "speed", "target", "seconds"),
    [
        ("linear", "time", 4.0, 10.0, 16.0, 4.0),
        ("linear", "time", 1.0, 10.0, 16.0, 2.0),  # 6 m/s at 3 m/s^2
        ("linear", "time", 1.0, 16.0, 10.0, 1.0),  # and at 6 m/s^2
        ("linear", "time", 0.5, 16.0, 10.0, 1.0),
        ("cubic", "time", 1.0, 10.0, 16.0, 3.0),  # whose peak is 3/2 of its mean
        ("linear", "rate", 2.0, 10.0, 16.0, 3.0),
        ("linear", "rate", 9.0, 10.0, 16.0, 2.0),
        ("linear", "distance", 130.0, 10.0, 16.0, 10.0),  # at 13 m/s in the mean
        ("step", "time", 4.0, 10.0, 16.0, 0.0),
        ("linear", "time", 4.0, 10.0, 10.0, 0.0),
        ("linear", "time", 0.0, 10.0, 16.0, 0.0),  # no time at all is a step
        ("linear", "rate", 0.0, 10.0, 16.0, INF),
    ],
)
def test_how_long_a_change_takes(
    shape: str, dimension: str, value: float, speed: float, target: float, seconds: float
) -> None:
    action, _ = to(target, shape, dimension, value, speed=speed)
    assert action._duration(speed, target) == pytest.approx(seconds)


@pytest.mark.parametrize(
    ("distance", "speed", "target", "seconds"),
    [
        (30.0, 10.0, 20.0, 2.0),
        (30.0, 0.0, 20.0, 3.0),
        (30.0, -10.0, -20.0, 2.0),
        (30.0, 0.0, 0.0, 0.0),
        (30.0, 10.0, -10.0, 6.0),  # half of it each way at 5 m/s in the mean
        (50.0, 10.0, -20.0, 6.0),  # 10 m at 5 m/s, 40 m at 10 m/s
        (50.0, 0.0, -20.0, 5.0),
    ],
)
def test_a_distance_counts_forwards_and_backwards(distance: float, speed: float, target: float, seconds: float) -> None:
    assert _time_over(distance, speed, target) == pytest.approx(seconds)


@pytest.mark.parametrize(("wanted", "top", "target"), [(60.0, 50.0, 50.0), (-60.0, 50.0, -50.0), (49.0, 50.0, 49.0),
                                                       (2e4, INF, FASTEST), (-2e4, INF, -FASTEST)])  # fmt: skip
def test_nobody_is_told_to_be_faster_than_it_can(wanted: float, top: float, target: float) -> None:
    action, entity = to(wanted, "step", max_speed=top)
    assert action.start()
    assert (entity.speed, entity.set_speed, entity.speed_before) == (target, target, target)


def test_a_step_is_over_at_once_and_a_line_is_not() -> None:
    step, entity = to(12.0, "step")
    assert step.start()
    assert entity.speed == 12.0
    line, entity = to(2.0, "linear", "time", 2.0)
    entity.travelled = 7.0
    assert not line.start()
    assert (entity.speed, entity.set_speed, line._began) == (0.0, 2.0, 7.0)
    assert [line.step(0.5) for _ in range(4)] == [False, False, False, True]


@pytest.mark.parametrize(
    ("speed", "target", "speeds"),
    [(0.0, 4.0, [1.0, 2.0, 3.0, 4.0]), (8.0, 4.0, [7.0, 6.0, 5.0, 4.0]), (2.0, -2.0, [1.0, 0.0, -1.0, -2.0])],
)
def test_a_line_goes_evenly_to_its_target(speed: float, target: float, speeds: list[float]) -> None:
    action, entity = to(target, speed=speed)
    action.start()
    found = []
    for _ in range(4):
        action.step(0.5)
        found.append(entity.speed)
    assert found == pytest.approx(speeds)


def test_who_is_held_back_goes_on_with_the_shape_where_it_is() -> None:
    """The line asks for 3 m/s^2; on ice half of it holds: each step gets half as far, and the line takes twice as long,
    from where the ice ends on as before."""
    action, entity = to(6.0)
    assert not action.start()
    entity.max_acceleration = 1.5
    for expected in (0.75, 1.5):
        assert not action.step(0.5)
        assert entity.speed == pytest.approx(expected)
    assert action._change.elapsed == pytest.approx(0.5)
    entity.max_acceleration = 3.0
    found = []
    for _ in range(3):
        done = action.step(0.5)
        found.append((done, round(entity.speed, 9)))
    assert found == [(False, 3.0), (False, 4.5), (True, 6.0)]


def test_who_is_held_back_at_the_end_is_not_done() -> None:
    action, entity = to(6.0)
    action.start()
    for _ in range(3):
        action.step(0.5)
    entity.max_acceleration = 1.0
    assert not action.step(0.5)  # 4.5 + 0.5
    assert entity.speed == pytest.approx(5.0)
    entity.max_acceleration = 3.0
    assert action.step(0.5) is True
    assert entity.speed == pytest.approx(6.0)


# --- relative to another one


@pytest.mark.parametrize(
    ("kind", "amount", "own", "wanted"),
    [("delta", 3.0, False, 13.0), ("factor", 1.5, False, 15.0), ("delta", 3.0, True, 7.0), ("factor", 1.5, True, 6.0)],
)
def test_a_relative_target_is_a_difference_or_a_share(kind: str, amount: float, own: bool, wanted: float) -> None:
    action, entity = after(driving(10.0, "B"), amount, kind, own=own, speed=4.0)
    action.start()
    assert entity.set_speed == pytest.approx(wanted)
    entity.speed = 20.0
    assert action._wanted() == pytest.approx(wanted)  # one relative to the own speed is that of the start


def test_a_line_in_time_goes_to_a_target_that_moves_and_ends_there() -> None:
    """2 s to B's speed, which is 10 and then 20 m/s: the shape of then has three quarters of the new change."""
    other = driving(10.0, "B")
    action, entity = after(other, 0.0)
    action.start()
    action.step(0.5)
    assert entity.speed == pytest.approx(2.5)
    other.speed = 20.0
    assert not action.step(1.0)
    assert entity.speed == pytest.approx(15.0)
    assert entity.set_speed == 20.0
    assert action.step(0.5)
    assert entity.speed == pytest.approx(20.0)


def test_a_target_that_is_kept_is_followed_at_once_and_never_ends() -> None:
    other = driving(10.0, "B")
    action, entity = after(other, 0.0, shape="step", continuous=True)
    assert not action.start()
    assert entity.speed == 10.0
    other.speed = 12.0
    assert not action.step(0.1)
    assert entity.speed == 12.0
    once, _ = after(other, 0.0, shape="step")
    assert once.start()


def test_a_rate_is_how_a_target_is_reached_and_not_how_it_is_kept() -> None:
    other = driving(10.0, "B")
    action, entity = after(other, 0.0, dimension="rate", value=4.0, continuous=True, speed=8.0)
    action.start()
    assert action._most(12.0) == 4.0
    for _ in range(5):
        action.step(0.1)
    assert entity.speed == pytest.approx(10.0)
    assert action._reached
    assert action._most(12.0) == 1e3
    other.speed = 30.0
    action.step(0.1)
    assert entity.speed == pytest.approx(30.0)


def test_a_line_of_a_rate_begins_anew_when_its_target_moves() -> None:
    other = driving(10.0, "B")
    action, entity = after(other, 0.0, dimension="rate", value=4.0)
    action.start()
    action.step(1.0)
    assert entity.speed == pytest.approx(4.0)
    other.speed = 0.0
    action.step(0.5)
    assert entity.speed == pytest.approx(2.0)
    assert action.step(0.5)
    assert entity.speed == pytest.approx(0.0)


def test_another_shape_of_a_rate_keeps_its_share_of_the_way() -> None:
    """A cubic to 8 m/s at 6 m/s^2 takes 2 s, one to 16 m/s 4 s: half of it is half of it."""
    other = driving(8.0, "B")
    action, _ = after(other, 0.0, shape="cubic", dimension="rate", value=6.0)
    action.start()
    assert action._change.span == pytest.approx(2.0)
    action.step(1.0)
    action._retarget(16.0)
    assert (action._change.span, action._change.elapsed, action._change.target) == pytest.approx((4.0, 2.0, 16.0))


@pytest.mark.parametrize(
    ("driven", "target", "span", "elapsed"),
    [
        # 40 m from 10 to 30 m/s take 2 s; after one of them 15 m are driven and 25 are left, which half of the shape
        # drives at 0.5 x 10 + (40 - 10) (1/2 - 1/8) = 16.25 m a second of all
        (15.0, 40.0, 25.0 / 16.25, 12.5 / 16.25),
        (15.0, 30.0, 2.0, 1.0),  # 5 + 20 x 3/8 = 12.5
        (40.0, 40.0, 2.0, 1.0),  # nothing is left: it goes on as it was
        (41.0, 40.0, 2.0, 1.0),
        (15.0, -5.0, 2.0, 1.0),  # the way back is no distance
        (15.0, 0.0, 25.0 / 1.25, 12.5 / 1.25),  # 5 - 10 x 3/8
    ],
)
def test_a_distance_is_what_is_left_of_it(driven: float, target: float, span: float, elapsed: float) -> None:
    action, entity = after(driving(30.0, "B"), 0.0, dimension="distance", value=40.0, speed=10.0)
    action.start()
    assert action._change.span == pytest.approx(2.0)
    action.step(1.0)
    entity.travelled = driven
    action._retarget(target)
    assert (action._change.span, action._change.elapsed) == pytest.approx((span, elapsed))


@pytest.mark.parametrize(("dimension", "value"), [("time", 2.0), ("rate", 0.0)])
def test_what_is_done_or_never_will_be_only_has_another_target(dimension: str, value: float) -> None:
    action, _ = after(driving(10.0, "B"), 0.0, dimension=dimension, value=value)
    action.start()
    action.step(2.0)
    span, elapsed = action._change.span, action._change.elapsed
    action._retarget(12.0)
    assert (action._change.target, action._change.span, action._change.elapsed) == (12.0, span, elapsed)


@pytest.mark.parametrize(
    ("shape", "dimension", "value", "duration"),
    [
        ("linear", "time", 3.0, 3.0),
        ("linear", "rate", 2.0, 3.0),
        ("linear", "rate", 0.0, 0.0),
        ("step", "time", 3.0, 0),
    ],
)
def test_what_is_asked_of_an_external_one(shape: str, dimension: str, value: float, duration: float) -> None:
    action, entity = to(16.0, shape, dimension, value, speed=10.0)
    kind, values, lasts = action.ask()
    assert kind == "speed"
    assert lasts == pytest.approx(duration)
    assert values == {"target": 16.0, "shape": shape, "duration": pytest.approx(duration)}
    assert entity.set_speed == 16.0
    assert entity.speed == 10.0
