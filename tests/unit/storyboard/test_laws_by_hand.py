"""Laws of actions and of the default controller with numbers worked out by hand, without a storyboard round them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.storyboard.actions import keep_distance as keeping
from openscenario.storyboard.actions.lateral import LaneChange, LaneOffset
from openscenario.storyboard.actions.trajectory import FollowTrajectory
from openscenario.storyboard.car_following import _next, following
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.ground import Ground
from openscenario.storyboard.init_order import _names
from openscenario.storyboard.motion import lean, way

INF = math.inf

# --- the intelligent driver model: 1.5 (1 - (v/w)^4 - (s*/s)^2), s* = 2 + 1.5 v + v dv / (2 sqrt(1.5 * 2))


@pytest.mark.parametrize(
    ("speed", "wished", "gap", "other", "acceleration"),
    [
        (10.0, 10.0, INF, 0.0, 0.0),
        (5.0, 10.0, INF, 0.0, 1.5 * 15.0 / 16.0),
        (3.0, 0.0, INF, 0.0, -1.5),  # who wants to stand
        (30.0, 10.0, INF, 0.0, -8.0),  # 1.5 (1 - 81) is more than anybody brakes
        (10.0, 20.0, 34.0, 10.0, 1.5 * (15.0 / 16.0 - 0.25)),  # wants 17 m and has twice that
        (10.0, 20.0, 54.0, 10.0 - 2.0 * math.sqrt(3.0), 1.5 * (15.0 / 16.0 - 0.25)),  # 10 m more for closing
        (10.0, 20.0, 4.0, 40.0, 1.5 * (15.0 / 16.0 - 0.25)),  # one that draws away leaves the 2 m of a standstill
        (10.0, 20.0, -1.0, 10.0, -8.0),
    ],
)
def test_following(speed: float, wished: float, gap: float, other: float, acceleration: float) -> None:
    assert following(speed, wished, gap, other) == pytest.approx(acceleration)


def test_a_time_gap_of_one_s_own_takes_the_place_of_the_usual_one() -> None:
    assert following(10.0, 20.0, 24.0, 10.0, headway=1.0) == pytest.approx(1.5 * (15.0 / 16.0 - 0.25))


def test_who_stands_at_the_same_place_is_not_ahead_but_on_a_road_that_is_reached_is() -> None:
    queue: Any = [(10.0, "a"), (20.0, "b"), (20.0, "c"), (30.0, "d")]
    assert _next(queue, 20.0, 1.0, strictly=True) == "d"
    assert _next(queue, 20.0, -1.0, strictly=True) == "a"
    assert _next(queue, 20.0, 1.0, strictly=False) == "b"
    assert _next(queue, 20.0, -1.0, strictly=False) == "c"
    assert _next(queue, 30.0, 1.0, strictly=True) is None
    assert _next(queue, 10.0, -1.0, strictly=True) is None
    assert _next(queue, 30.0, 1.0, strictly=False) == "d"
    assert _next(queue, 10.0, -1.0, strictly=False) == "a"


# --- the default controller


@pytest.mark.parametrize(
    ("late", "dt", "metres"), [(False, 0.1, 0.51), (True, 0.1, 0.49), (False, 0.004, 0.024), (True, 0.004, 0.016)]
)
def test_the_way_of_a_step_is_that_of_its_beats(late: bool, dt: float, metres: float) -> None:
    """From 4 to 6 m/s: the mean is 5, and 1 m/s more or less for a beat of 10 ms or a shorter step."""
    entity: Any = SimpleNamespace(speed_before=4.0, speed=6.0, late=late)
    assert way(entity, dt) == pytest.approx(metres)


@pytest.mark.parametrize(
    ("speed", "rate", "enough", "along", "drift"),
    [
        (5.0, 3.0, True, 0.8, math.asin(0.6)),
        (5.0, -3.0, True, 0.8, -math.asin(0.6)),
        (-5.0, 3.0, True, 0.8, -math.asin(0.6)),
        (5.0, 0.0, True, 1.0, 0.0),
        (5.0, 8.0, False, 0.0, 0.5 * math.pi),
        (0.0, 1.0, False, 0.0, 0.0),
    ],
)
def test_an_oblique_way_has_the_entity_s_speed(
    speed: float, rate: float, enough: bool, along: float, drift: float
) -> None:
    entity: Any = SimpleNamespace(speed_before=speed, speed=speed, late=False)
    assert lean(entity, rate, 0.1) is enough
    assert entity.along == pytest.approx(along)
    if speed:  # which way one faces who stands is no matter
        assert entity.drift == pytest.approx(drift, abs=2e-6)


# --- a distance to another one


def keeper(
    monkeypatch: pytest.MonkeyPatch,
    apart: float | None,
    *,
    limits: Any,
    speed: float = 10.0,
    other: float = 10.0,
    **element: Any,
) -> tuple[keeping.KeepDistance, Any]:
    """Wants 0 m, trailing, unless told otherwise; limits: speed, up, down."""
    names = ("max_speed", "max_acceleration", "max_deceleration")
    rates = {"max_acceleration_rate": None, "max_deceleration_rate": None}
    constraints = SimpleNamespace(**dict(zip(names, limits, strict=True)), **rates)
    asked = {"entity_ref": "B", "coordinate_system": "entity", "freespace": False, "continuous": True,
             "displacement": "trailingReferencedEntity", "distance": 0.0, "time_gap": None} | element  # fmt: skip
    able = dict.fromkeys((*names, *rates), INF)
    entity = SimpleNamespace(speed=speed, **able)
    ahead = SimpleNamespace(name="B", speed=other, placed=False)
    monkeypatch.setattr(keeping, "entity_called", lambda name, board: ahead)
    monkeypatch.setattr(keeping, "measure", lambda *_, **__: lambda: apart)
    made: Any = SimpleNamespace(dynamic_constraints=constraints, **asked)
    return keeping.KeepDistance(made, entity, SimpleNamespace()), entity  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("apart", "speed", "limits", "change"),
    [
        # k = 0.4 * 5 = 2: 2 * 2 - 2 sqrt(2) * 1
        (2.0, 11.0, (None, 9.0, 5.0), 4.0 - 2.0 * math.sqrt(2.0)),
        (-2.0, 10.0, (None, 1.25, 5.0), -1.0),  # too near: the limit that lets it come back counts, k = 0.5
        (2.0, 10.0, (None, 3.0, 5.0), 3.0),
        (-20.0, 10.0, (None, 1.25, 5.0), -5.0),
        (0.5, 10.0, (90.0, None, None), 20.0),  # no limit counts as 100 m/s^2: k = 40
        (0.0, 10.5, (None, 5.0, 5.0), -math.sqrt(2.0)),  # in its place, and faster than the other
    ],
)
def test_a_distance_is_drawn_in_by_a_critically_damped_spring(
    monkeypatch: pytest.MonkeyPatch, apart: float, speed: float, limits: Any, change: float
) -> None:
    action, entity = keeper(monkeypatch, apart, limits=limits, speed=speed)
    assert action.start() is False
    action.step(0.5)
    assert entity.speed - speed == pytest.approx(0.5 * change)


@pytest.mark.parametrize(("apart", "side"), [(-0.5, -1.0), (0.0, 1.0), (0.5, 1.0), (None, 1.0)])
def test_on_any_side_it_keeps_the_side_where_it_is(
    monkeypatch: pytest.MonkeyPatch, apart: float | None, side: float
) -> None:
    action, _ = keeper(monkeypatch, apart, limits=(8.0, 2.0, 4.0), displacement="any", distance=6.0)  # type: ignore[arg-type]
    assert not action.start()
    assert action._to_go() == (0.0 if apart is None else apart - side * 6.0)


@pytest.mark.parametrize(
    ("distance", "gap", "other", "wanted"), [(6.0, None, 10.0, 6.0), (None, 2.0, -10.0, 20.0), (None, None, 10.0, 0.0)]
)
def test_a_distance_may_be_a_time_at_the_speed_of_the_other(
    monkeypatch: pytest.MonkeyPatch, distance: float | None, gap: float | None, other: float, wanted: float
) -> None:
    action, _ = keeper(monkeypatch, 50.0, limits=(8.0, 2.0, 4.0), distance=distance, time_gap=gap, other=other)
    assert action._to_go() == 50.0 - wanted


def test_who_is_too_fast_at_first_brakes_within_its_limits_and_nobody_goes_beyond_the_greatest_speed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    action, entity = keeper(monkeypatch, 100.0, limits=(8.0, 2.0, 4.0), speed=7.9)
    action.step(0.5)
    assert entity.speed == 8.0
    action, entity = keeper(monkeypatch, 100.0, limits=(8.0, 2.0, 4.0), speed=20.0)
    action.step(0.5)
    assert entity.speed == 18.0
    action, entity = keeper(monkeypatch, -100.0, limits=(8.0, 2.0, 4.0), speed=-7.5, other=-9.0)
    action.step(0.5)
    assert entity.speed == -8.0


@pytest.mark.parametrize(
    ("apart", "continuous", "over"), [(0.09, False, True), (-0.09, False, True), (0.11, False, False),
                                      (-0.11, False, False), (0.0, True, False)]
)  # fmt: skip
def test_a_distance_is_reached_within_a_tenth_of_a_metre(
    monkeypatch: pytest.MonkeyPatch, apart: float, continuous: bool, over: bool
) -> None:
    action, _ = keeper(monkeypatch, apart, limits=(None, 1.0, 1.0), continuous=continuous)
    assert action.step(0.01) is over


@pytest.mark.parametrize(
    ("displacement", "apart", "to_go"),
    [
        ("trailingReferencedEntity", 30.0, 24.0),  # behind: up to 6 m before the other
        ("leadingReferencedEntity", 30.0, 36.0),
        ("any", 30.0, 24.0),
        ("any", 0.0, -6.0),  # level with it: behind
        ("any", -30.0, -24.0),  # it is ahead, and stays there
    ],
)
def test_the_side_that_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, displacement: str, apart: float, to_go: float
) -> None:
    """2 s at 3 m/s are 6 m, whichever way the other one drives; a distance goes before a time."""
    for told in ({"distance": None, "time_gap": 2.0}, {"distance": 6.0, "time_gap": 9.0}):
        for other in (3.0, -3.0):
            limits = (None, 1.0, 1.0)
            action, _ = keeper(monkeypatch, apart, limits=limits, other=other, displacement=displacement, **told)
            action.start()
            assert action._to_go() == pytest.approx(to_go)


def test_without_a_way_between_them_there_is_nothing_to_go(monkeypatch: pytest.MonkeyPatch) -> None:
    action, _ = keeper(monkeypatch, None, limits=(None, 1.0, 1.0), displacement="any", distance=6.0)
    action.start()
    assert action._to_go() == 0.0


# --- to the side


def changer(shape: str, dimension: str, value: float, speed: float = 10.0) -> LaneChange:
    entity: Any = SimpleNamespace(speed=speed)
    dynamics = SimpleNamespace(dynamics_shape=shape, dynamics_dimension=dimension, value=value)
    target = SimpleNamespace(value=-2)
    element: Any = SimpleNamespace(
        lane_change_action_dynamics=dynamics, lane_change_target=target, target_lane_offset=0.25
    )
    board: Any = SimpleNamespace(network=object(), ground=SimpleNamespace(track=lambda entity: True))
    return LaneChange(element, entity, board)


@pytest.mark.parametrize(
    ("shape", "dimension", "value", "speed", "duration"),
    [
        ("linear", "rate", 0.5, 10.0, 7.0),  # of a lane of 3.5 m
        ("cubic", "rate", 0.5, 10.0, 10.5),  # its peak is 3/2 of its mean
        ("sinusoidal", "rate", 1.75, 10.0, math.pi),
        ("linear", "rate", 0.0, 10.0, 0.0),  # never there: nothing that can be asked for
        ("cubic", "time", 4.0, 10.0, 4.0),
        ("cubic", "distance", 30.0, 15.0, 2.0),
        ("cubic", "distance", 30.0, 0.0, 0.0),
        ("step", "time", 4.0, 10.0, 0.0),
    ],
)
def test_how_long_a_lane_change_is_asked_for(
    shape: str, dimension: str, value: float, speed: float, duration: float
) -> None:
    kind, values, lasts = changer(shape, dimension, value, speed).ask()
    assert (kind, values["lane"], values["offset"]) == ("lane_change", -2, 0.25)
    assert values["duration"] == lasts == pytest.approx(duration)


def offsetter(*, continuous: bool = True, limit: float | None = 1.0, shape: str = "cubic") -> LaneOffset:
    dynamics = SimpleNamespace(max_lateral_acc=limit, dynamics_shape=shape)
    element: Any = SimpleNamespace(
        continuous=continuous, lane_offset_target=SimpleNamespace(value=1.5), lane_offset_action_dynamics=dynamics
    )
    board: Any = SimpleNamespace(network=object(), reading="standard", warn=None)
    return LaneOffset(element, SimpleNamespace(), board)  # type: ignore[arg-type]


def test_who_follows_an_offset_draws_nearer_no_faster_than_it_can_stop() -> None:
    """0.5 m at 1 m/s^2: sqrt(2 * 1 * 0.5) = 1 m/s, of which a step of 0.1 s gains 0.1."""
    action = offsetter()
    assert action._kept(0.5, 1.0, 0.1) == 0.5  # the step before has brought it
    assert action._kept(0.5, 1.0, 0.1) == pytest.approx(0.51)
    assert action._kept(0.51, 1.0, 0.1) == pytest.approx(0.53)
    action = offsetter(limit=2.0)
    action._kept(0.0, 0.09, 0.01)
    action._rate = 0.6  # as fast as it may be to stop there: sqrt(2 * 2 * 0.09)
    assert action._kept(0.0, 0.09, 0.01) == pytest.approx(0.006)
    action = offsetter(limit=100.0)
    action._kept(0.5, 1.0, 0.1)
    assert action._kept(0.5, 1.0, 0.1) == pytest.approx(1.0)  # no farther than it is
    action = offsetter(limit=100.0)
    action._kept(1.0, 1.0, 0.1)
    assert action._kept(1.0, 1.2, 0.1) == pytest.approx(1.2)  # with a target that goes


@pytest.mark.parametrize(
    ("continuous", "limit", "least"), [(True, 2.0, 2.0), (True, None, INF), (False, 2.0, INF)]
)  # fmt: skip
def test_only_who_keeps_an_offset_is_limited_while_it_does(continuous: bool, limit: float | None, least: float) -> None:
    action = offsetter(continuous=continuous, limit=limit)
    assert action._limit() == least
    assert action._kept(0.0, 1.0, 0.1) == (1.0 if least == INF else 0.0)


def test_a_line_has_corners_until_it_ends() -> None:
    action = offsetter(shape="linear")
    assert action._next_rate(5.0, 0.1) == 5.0
    action._change.done = True
    assert action._next_rate(5.0, 0.1) == pytest.approx(0.1)
    assert action._next_rate(-5.0, 0.1) == pytest.approx(-0.1)
    assert action._next_rate(0.05, 0.1) == 0.05


# --- along a trajectory at one's own speed


@pytest.mark.parametrize(
    ("begin", "speed", "closed", "reverse", "s", "over"),
    [
        (2.0, 4.0, False, False, 4.0, -6.0),
        (9.0, 4.0, False, False, 10.0, 1.0),
        (8.0, 4.0, False, False, 10.0, 0.0),
        (5.0, 0.0, False, False, 5.0, -1.0),  # who stands is not over
        (10.0, 0.0, False, False, 10.0, -1.0),
        (3.0, -4.0, False, False, 1.0, -1.0),  # has turned back: over at the beginning
        (1.0, -4.0, False, False, 0.0, 1.0),
        (1.0, -4.0, False, True, 3.0, -7.0),  # rear first from the start: the same way
        (9.0, -4.0, False, True, 10.0, 1.0),
        (9.0, 4.0, True, False, 1.0, -1.0),  # goes round
        (1.0, -4.0, True, False, 9.0, -1.0),
    ],
)
def test_a_trajectory_at_one_s_own_speed(
    begin: float, speed: float, closed: bool, reverse: bool, s: float, over: float
) -> None:
    """10 m of it, steps of 0.5 s; `over` is how far the way goes beyond its end [m]."""
    action = untimed(speed, speed, closed=closed)
    action._s, action._reverse = begin, reverse
    assert action._step_untimed(0.5, SimpleNamespace(length=10.0)) == pytest.approx(over)  # type: ignore[arg-type]
    assert action._s == pytest.approx(s)


def untimed(before: float, speed: float, *, closed: bool = False, lateral: int = 1, longitudinal: int = 2) -> Any:
    entity: Any = SimpleNamespace(speed_before=before, speed=speed, late=False, ax=0.0, lateral_order=lateral,
                                  longitudinal_order=longitudinal)  # fmt: skip
    shape = SimpleNamespace(control_points=[])
    element: Any = SimpleNamespace(trajectory=SimpleNamespace(shape=shape, closed=closed), time_reference=None)
    return FollowTrajectory(element, entity, SimpleNamespace())  # type: ignore[arg-type]


def test_its_acceleration_is_that_of_its_speed_and_its_place_in_the_file_says_when_it_counts() -> None:
    for order, late in (((1, 2), True), ((2, 2), False), ((3, 2), False)):
        action = untimed(10.0, 12.0, lateral=order[0], longitudinal=order[1])
        action._step_untimed(0.5, SimpleNamespace(length=100.0))
        assert action._entity.ax == pytest.approx(4.0)
        assert action._entity.late is late


# --- a slippery road, and who is named


def car(**more: Any) -> Any:
    """4 m by 2 m, its middle 1 m ahead and 0.5 m left of the reference point; brakes with 6, speeds up by 3 m/s^2."""
    box = SimpleNamespace(dimensions=SimpleNamespace(length=4.0, width=2.0, height=1.5),
                          center=SimpleNamespace(x=1.0, y=0.5, z=0.75))  # fmt: skip
    able = SimpleNamespace(max_speed=50.0, max_acceleration=3.0, max_deceleration=6.0, max_acceleration_rate=None,
                           max_deceleration_rate=None)  # fmt: skip
    told = {"kind": "vehicle", "properties": {}, "performance": able} | more
    kind = told.pop("kind")
    made: Any = SimpleNamespace(name="A", kind=kind, category="car", bounding_box=box, entity=SimpleNamespace(**told))
    return Entity(made, external=False)


def test_a_road_holds_its_friction_times_the_weight() -> None:
    """0.5 g are 4.903325 m/s^2 (CGPM 1901): less than the brake can, more than the engine can."""
    entity = car()
    entity.limit_friction(0.5)
    assert (entity.max_acceleration, entity.max_deceleration) == (3.0, pytest.approx(4.903325))
    entity.limit_friction(INF)
    assert (entity.max_acceleration, entity.max_deceleration) == (3.0, 6.0)


@pytest.mark.parametrize(
    ("lane", "condition", "most"),
    [
        (0.5, 1.0, 4.903325),
        (1.0, 0.5, 4.903325),
        (0.5, 0.5, 2.4516625),  # the material times what lies on it
        (0.5, INF, 4.903325),  # where the scenario says nothing, the material alone
        (0.5, 3.0, 4.903325),  # no weather makes it better
        (1.0, 1.0, 6.0),  # dry: nothing but the vehicle limits
    ],
)
def test_the_lane_s_material_counts_times_the_road_s_condition(lane: float, condition: float, most: float) -> None:
    vehicle, walker, gone = car(), car(kind="pedestrian"), car()
    gone.active = False
    for entity in (vehicle, walker, gone):
        entity.tracked = True
    ground = Ground(None)
    network: Any = SimpleNamespace(states_friction=True, lane_friction=lambda road, number, s: lane)
    ground.network = network
    ground.spread_friction([walker, gone, vehicle], condition)
    assert vehicle.max_deceleration == pytest.approx(most)
    assert walker.max_deceleration == gone.max_deceleration == 6.0


def test_a_road_that_states_no_friction_limits_nobody() -> None:
    entity = car()
    entity.tracked = True
    ground = Ground(None)
    ground.spread_friction([entity], 0.1)
    network: Any = SimpleNamespace(states_friction=False, lane_friction=lambda *_: 0.1)
    ground.network = network
    ground.spread_friction([entity], 0.1)
    assert entity.max_deceleration == 6.0


@dataclass
class Part:
    entity_ref: Any = None
    master_entity_ref: Any = None
    name: str = "not me"
    inner: Any = None


def test_names_are_found_wherever_they_stand_in_an_element() -> None:
    """In tuples, in tuples of tuples, and in parts of parts; a text of another name is none, nor is what is no text."""
    deep = Part(inner=Part(entity_ref="C", inner=((Part(master_entity_ref="D"),), "not me", Part(entity_ref="E"))))
    assert list(_names(Part(entity_ref="A", master_entity_ref="B", inner=deep))) == ["A", "B", "C", "D", "E"]
    assert list(_names((Part(entity_ref=Part(entity_ref="F")), Part(entity_ref=None), "not me", 3))) == ["F"]


@pytest.mark.parametrize(
    ("apart", "top", "other", "placed", "speed", "ways"),
    [
        (9.0, 4.0, 3.0, False, 3.0, (9.0, 2.0)),  # put there at first; then no faster than it drives: 4 m/s for 0.5 s
        (-9.0, 4.0, 3.0, False, 3.0, (-9.0, -2.0)),
        (9.0, 4.0, 3.0, True, 3.0, (9.0, 9.0)),  # the other was put somewhere else
        (1.0, 4.0, 7.0, False, 4.0, (1.0, 1.0)),
        (1.0, 4.0, -7.0, False, -4.0, (1.0, 1.0)),
    ],
)
@pytest.mark.parametrize("continuous", [True, False])
def test_without_limits_the_place_is_taken_at_once(
    monkeypatch: pytest.MonkeyPatch, apart: float, top: float, other: float, placed: bool, speed: float,
    ways: tuple[float, float], continuous: bool,
) -> None:  # fmt: skip
    """On a road along it; once only, unless it is asked to go on."""
    action, _ = keeper(monkeypatch, apart, limits=(None, None, None), other=other, continuous=continuous)
    driven: list[float] = []
    found: list[float] = []
    action._entity = SimpleNamespace(jump_to_speed=found.append)  # type: ignore[assignment]
    action._limits = action._limits._replace(speed=top)
    action._other.placed = placed
    ground = SimpleNamespace(track=lambda entity: True, drive=lambda entity, metres: driven.append(metres))
    action._board = SimpleNamespace(ground=ground)  # type: ignore[assignment]
    assert action.start() is not continuous
    assert action.step(0.5) is False
    assert driven == pytest.approx(list(ways))
    assert found == [speed, speed]


def test_off_the_road_the_place_lies_straight_ahead(monkeypatch: pytest.MonkeyPatch) -> None:
    """5 m in the direction of the 3-4-5 triangle."""
    action, _ = keeper(monkeypatch, 5.0, limits=(None, None, None))
    entity = car()
    entity.put(1.0, 2.0, 7.0, math.atan2(4.0, 3.0))
    action._entity = entity
    action._board = SimpleNamespace(ground=Ground(None))  # type: ignore[assignment]
    action.start()
    assert (entity.x, entity.y, entity.z) == pytest.approx((4.0, 6.0, 7.0))
    assert entity.h == pytest.approx(math.atan2(4.0, 3.0))
