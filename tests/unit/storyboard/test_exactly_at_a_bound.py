"""What actions and conditions do exactly at a bound, and who is coupled, held and put: with stubs around them."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard import drivers
from openscenario.storyboard.actions.speed import Speed
from openscenario.storyboard.actions.synchronize import Synchronize
from openscenario.storyboard.conditions.contact import collision, end_of_road, off_road
from openscenario.storyboard.conditions.distance import reach_position, time_headway
from openscenario.storyboard.conditions.motion import acceleration
from openscenario.storyboard.conditions.values import element_state
from openscenario.storyboard.dynamics import Transition
from openscenario.storyboard.ground import Ground
from openscenario.storyboard.limits import Limits
from openscenario.storyboard.motion import BEAT, move
from openscenario.storyboard.road_watch import RoadWatch
from openscenario.storyboard.speed_curve import curve
from openscenario.storyboard.trailers import couple, couple_named, couples, draw

from .bodies import car


def around(*entities: Any, **more: Any) -> Any:
    board = {"time": 0.0, "dt": 0.1, "network": None, "entities": {e.name: e for e in entities}, "steps": 0}
    return SimpleNamespace(board=SimpleNamespace(**(board | more)), node=None)


# --- conditions


@pytest.mark.parametrize(
    ("apart", "rule", "holds"),
    [(0.0, "lessThan", True), (3.0, "lessThan", False), (2.9, "lessThan", True), (-0.1, "lessThan", False)],
)
def test_who_is_beside_the_other_has_no_headway_at_all(apart: float, rule: str, holds: bool) -> None:
    """At the very place it is not behind; three seconds are not less than three."""
    a, b = car("A"), car("B")
    b.put(4.0 * apart, 0.0, 0.0, 0.0)
    a.speed = 4.0
    element: Any = SimpleNamespace(entity_ref="B", rule=rule, value=3.0, freespace=False, along_route=None,
                                   relative_distance_type="longitudinal", coordinate_system="entity")  # fmt: skip
    assert time_headway(element, a, around(a, b))() is holds


@pytest.mark.parametrize(("x", "holds"), [(0.0, True), (3.999, True), (4.0, True), (4.001, False), (-4.001, False)])
def test_boxes_collide_with_the_one_that_is_named_from_where_they_touch(x: float, holds: bool) -> None:
    a, b, far = car("A"), car("B"), car("C")
    far.put(900.0, 0.0, 0.0, 0.0)
    b.put(x, 0.0, 0.0, 0.0)
    scope = around(a, b, far)
    by_name: Any = SimpleNamespace(target=SimpleNamespace(type="vehicle"))
    test = collision(by_name, a, scope)
    assert test() is holds
    b.active = False
    assert not test()
    b.active = True
    b.kind = "pedestrian"
    assert not test()
    by_name.target.type = "pedestrian"
    assert collision(by_name, a, scope)() is holds
    b.kind = "misc"
    by_name.target.type = "miscellaneous"
    assert collision(by_name, a, scope)() is holds


@pytest.mark.parametrize("mine", [False, True])
@pytest.mark.parametrize(
    ("length", "width", "center", "x", "y"),
    [(20.0, 2.0, 40.0, 49.5, 0.0), (90.0, 2.0, 1.0, 45.5, 0.0), (4.0, 60.0, 1.0, 0.0, 30.5)],
)
def test_a_large_box_is_met_far_from_its_reference_point(
    length: float, width: float, center: float, x: float, y: float, mine: bool
) -> None:
    """Its end is half a metre beyond the reference point of the other one, whichever of both is asked; 4 m less is not
    enough."""
    large, other = car("A" if mine else "B"), car("B" if mine else "A")
    large.length, large.width, large.center_x = length, width, center
    element: Any = SimpleNamespace(target=SimpleNamespace(type="vehicle"))
    for more, meets in ((0.0, True), (4.0, False)):
        other.put(x + more if x else 0.0, y + more if y else 0.0, 0.0, 0.0)
        entity = large if mine else other
        assert collision(element, entity, around(large, other))() is meets


def test_off_the_road_and_at_its_end_the_duration_counts_from_when_it_began() -> None:
    road = [True]
    entity = car()
    watch = RoadWatch(SimpleNamespace(on_road=lambda e: road[0]))  # type: ignore[arg-type]
    scope = around(entity, road_watch=watch)
    element: Any = SimpleNamespace(duration=2.0)
    off, end = off_road(element, entity, scope), end_of_road(element, entity, scope)
    told = []
    for time, on in ((0.0, True), (1.0, False), (2.9, False), (3.0, False), (3.1, True), (3.2, False), (5.1, False),
                     (5.2, False)):  # fmt: skip
        scope.board.time, road[0] = time, on
        watch.note(entity, time)
        told.append(off())
    assert told == [False, False, False, True, False, False, False, True]
    for since, holds in ((3.2, True), (3.3, False), (math.inf, False)):
        entity.end_since = since
        assert end() is holds


@pytest.mark.parametrize(("x", "y", "holds"), [(3.0, 4.0, True), (-3.0, -4.0, True), (3.0, 4.001, False)])
def test_a_position_is_reached_just_at_its_tolerance(
    x: float, y: float, holds: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("openscenario.storyboard.conditions.distance.resolver",
                        lambda position, board: lambda: SimpleNamespace(x=0.0, y=0.0))  # fmt: skip
    entity = car()
    entity.put(x, y, 0.0, 0.0)
    element: Any = SimpleNamespace(position=None, tolerance=5.0)
    assert reach_position(element, entity, around(entity))() is holds


def test_a_transition_is_seen_once_in_its_step_or_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    node = SimpleNamespace(state="runningState", changes={})
    monkeypatch.setattr("openscenario.storyboard.conditions.values.find", lambda *asked: node)
    scope = around(steps=5, root=None)
    element: Any = SimpleNamespace(storyboard_element_type="event", storyboard_element_ref="e", state="endTransition")
    test = element_state(element, None, scope)
    assert not test()
    node.changes["endTransition"] = (5, 0)  # the very first of all transitions
    assert test()
    assert not test()
    node.changes["endTransition"] = (5, 7)
    scope.board.steps = 6
    assert test()
    node.changes["endTransition"] = (6, 9)
    scope.board.steps = 8  # two steps later nobody sees it any more
    assert not test()


# --- motion


@pytest.mark.parametrize(
    ("sense", "drift", "pose"),
    [
        (1.0, 0.0, (0.5, 0.25, 0.125)),
        (-1.0, 0.0, (0.5 - math.pi, -0.25, -0.125)),  # who faces the other way goes down, and leans to the other side
    ],
)
def test_a_body_has_the_slope_of_its_lane_as_it_faces(sense: float, drift: float, pose: tuple[float, ...]) -> None:
    entity = car()
    entity.sense, entity.drift = sense, drift
    Ground(None)._pose(entity, 1.0, 2.0, 3.0, 0.5, 0.25, 0.125)
    assert (entity.h, entity.pitch, entity.roll) == pytest.approx(pose)
    assert (entity.x, entity.y, entity.z) == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_body_that_is_turned_across_a_slope_leans_by_it(sense: float) -> None:
    """A quarter of a turn, of which 0.5 rad by its drift: what was the slope ahead is the roll, and the other way."""
    entity = car()
    entity.sense, entity.twist, entity.drift = sense, 0.5 * math.pi - 0.5, 0.5
    Ground(None)._pose(entity, 0.0, 0.0, 0.0, 0.0, 0.25, 0.0)
    assert abs(entity.pitch) == pytest.approx(0.0, abs=1e-9)
    assert abs(entity.roll) == pytest.approx(0.25)
    assert entity.h == pytest.approx(sense * 0.5 * math.pi)
    level = car()
    level.sense, level.twist, level.drift = sense, 0.25, 0.5
    Ground(None)._pose(level, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert math.remainder(level.h - (0.75 if sense > 0.0 else math.pi + 0.75), math.tau) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("lane", "road", "limited"), [(0.5, math.inf, 0.5), (0.5, 0.5, 0.25), (1.0, math.inf, None), (1.5, 1.2, None),
                                  (1.5, 0.5, 0.75), (0.999, 1.0, 0.999)],
)  # fmt: skip
def test_a_lane_as_good_as_a_dry_one_limits_nobody(
    lane: float, road: float, limited: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    ground = Ground(None)
    ground.network = SimpleNamespace(  # type: ignore[assignment]
        states_friction=True, lane_friction=lambda road, number, s: lane
    )
    monkeypatch.setattr(Ground, "track", lambda self, entity: True)
    entity, walker = car(), car("W", kind="pedestrian")
    entity.able = walker.able = (30.0, 40.0)
    walker.kind = "pedestrian"
    ground.spread_friction([entity, walker], road)
    most = math.inf if limited is None else limited * 9.81
    assert entity.max_acceleration == pytest.approx(min(30.0, most), rel=1e-3)
    assert entity.max_deceleration == pytest.approx(min(40.0, most), rel=1e-3)
    assert walker.max_acceleration == 3.0  # as its file says


@pytest.mark.parametrize(("rise", "fall"), [(0.5, 0.25), (0.25, 0.5)])
def test_a_small_jerk_is_a_limit_and_none_at_all_is_a_stop(rise: float, fall: float) -> None:
    """From 0 to 4 m/s: up with `rise`, down with `fall`, so that a rise of r t^2/2 + f (r t/f)^2/2 = 4 m/s."""
    free = Limits(speed=50.0, up=5.0, down=10.0, rise=rise, fall=fall)
    pieces = curve(((0.0, 0.0), (1.0, 4.0)), 0.0, free)
    first = math.sqrt(8.0 / (rise + rise * rise / fall))
    assert pieces[-1].time == pytest.approx(first * (1.0 + rise / fall))
    assert pieces[-1].speed == pytest.approx(4.0)
    for none in ({"rise": 0.0}, {"fall": 0.0}):
        stuck = curve(((0.0, 0.0), (1.0, 4.0)), 0.0, free._replace(**none))
        assert [(piece.time, piece.speed) for piece in stuck] == [(0.0, 0.0), (math.inf, 4.0)]
        (alone,) = curve(((0.0, 3.0),), 0.0, free._replace(**none))
        assert (alone.time, alone.speed) == (0.0, 3.0)


def on_no_road(entity: Any) -> Any:
    return SimpleNamespace(network=None, track=lambda e: False)


def test_who_was_put_moves_from_the_next_beat_on_with_its_own_velocity() -> None:
    """Put at the beginning of a step of 0.1 s at 5 m/s: it goes on for 0.09 s, and as fast as it is."""
    entity = car()
    entity.speed = entity.speed_before = 5.0
    entity.placed = True
    move(entity, 0.1, on_no_road(entity))
    assert entity.x == pytest.approx(5.0 * 0.09)
    assert (entity.vx, entity.vy, entity.travelled) == (pytest.approx(5.0), 0.0, pytest.approx(0.45))
    short = car()
    short.speed = short.speed_before = 5.0
    short.placed, short.h = True, 0.5 * math.pi
    move(short, BEAT, on_no_road(short))  # the step is over with the beat
    assert (short.x, short.y, short.travelled) == (0.0, 0.0, 0.0)
    assert (short.vx, short.vy) == (pytest.approx(0.0, abs=1e-9), pytest.approx(5.0))


def test_an_action_has_the_first_place_in_a_file_unless_another_is_said() -> None:
    entity, runner = car(), SimpleNamespace()
    entity.longitudinal_order = entity.lateral_order = 7
    for domain in ("longitudinal", "lateral"):
        entity.hold(domain, runner)
    assert (entity.longitudinal_order, entity.lateral_order) == (0, 0)
    entity.hold("longitudinal", runner, 3)
    entity.hold("longitudinal", None)
    assert (entity.longitudinal_order, entity.longitudinal) == (3, None)


@pytest.mark.parametrize(
    ("direction", "value"), [("longitudinal", 3.0), ("lateral", 4.0), ("vertical", 0.0), (None, 5.0)]
)
def test_an_acceleration_has_parts_ahead_and_to_the_left_and_a_size(direction: Any, value: float) -> None:
    """3 m/s^2 ahead; within half a second 2 m/s more to its left, which is where the map's x decreases."""
    entity = car()
    entity.h, entity.ax = 0.5 * math.pi, 3.0
    scope = around(entity)
    for more, holds in ((-0.01, True), (0.01, False)):
        element: Any = SimpleNamespace(rule="greaterThan", value=value + more, direction=direction)
        scope.board.time, entity.vx, entity.vy = 1.0, 1.0, 7.0
        test = acceleration(element, entity, scope)
        test()
        scope.board.time, entity.vx = 1.5, -1.0
        assert test() is holds


@pytest.mark.parametrize(("start", "changed"), [(0.5, True), (0.0, True), (-0.5, False)])
def test_a_target_that_moves_changes_the_time_of_a_way_that_does_not_turn_round(start: float, changed: bool) -> None:
    """Half of 12 m is left, of a line of 10 s to 1 m/s of which half is over; its target is now 1.5 m/s."""
    entity = car()
    element: Any = SimpleNamespace(
        speed_action_dynamics=SimpleNamespace(
            dynamics_shape="linear", dynamics_dimension="distance", value=12.0, following_mode=None
        ),
        speed_action_target=model.AbsoluteTargetSpeed(value=1.0),
    )
    action = Speed(element, entity, SimpleNamespace(entities={}))  # type: ignore[arg-type]
    action._change = Transition("linear", 10.0, start, 1.0)
    action._change.elapsed = 5.0
    entity.travelled, action._began = 6.5, 0.5
    action._retarget(1.5)
    mean = 0.5 * (0.5 * (start + 1.5) + 1.5)  # m/s, over what is left of the line to the new target
    assert action._change.span == pytest.approx(2.0 * 6.0 / mean if changed else 10.0)
    assert action._change.elapsed == pytest.approx(0.5 * action._change.span)


@pytest.mark.parametrize(("keeps", "held", "back"), [(True, False, True), (False, False, False), (True, True, False)])
def test_a_driver_goes_back_to_the_middle_if_it_keeps_lanes_and_no_action_does(
    keeps: bool, held: bool, back: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """1 m off, with a time constant of 2 s: 0.05 m in 0.1 s."""
    monkeypatch.setattr(drivers, "queues", lambda entities, ground: {})
    entity = car()
    entity.driver = SimpleNamespace(at_work=True, longitudinal=False, lateral=keeps, wished=None, headway=None)
    entity.lateral = SimpleNamespace() if held else None
    entity.offset, entity.sense, entity.active = 1.0, 1.0, True
    entity.speed = entity.speed_before = 10.0
    scope = around(entity, ground=SimpleNamespace(network=object(), track=lambda e: True))
    drivers.drive(scope.board, 0.1)
    assert entity.offset == pytest.approx(0.95 if back else 1.0)


# --- trailers


def named(name: str, behind: str | None) -> Any:
    ref = None if behind is None else SimpleNamespace(entity_ref=behind)
    return SimpleNamespace(name=name, entity=SimpleNamespace(trailer=SimpleNamespace(trailer_ref=ref)))


def test_trailers_hang_on_the_vehicles_that_name_them() -> None:
    truck, second, trailer, other = (car(name) for name in ("A", "B", "T", "O"))
    entities = {e.name: e for e in (truck, second, trailer, other)}
    bare = SimpleNamespace(name="O", entity=SimpleNamespace())
    scenario: Any = SimpleNamespace(entities=[bare, named("B", None), named("B", "of a catalogue"), named("A", "T")])
    couple_named(scenario, entities)
    assert couples(trailer) == (truck, trailer)
    assert couples(second) == (second,)
    scenario.entities = [named("B", "O"), named("A", "B")]
    other.external = True
    couple_named(scenario, entities)
    assert couples(other) == (other,)  # who is moved from outside hangs on nothing
    assert couples(second) == (truck, second)


def test_a_trailer_is_drawn_along_its_coupler() -> None:
    """The hitch goes from 0 to 5 m aside; the trailer's axle is 5 m behind its coupler: 3-4-5 once drawn there."""
    truck, trailer = car("A"), car("T")
    truck.hitch, trailer.coupler = 0.0, 5.0
    couple(truck, trailer)
    trailer.put(-7.0, -4.0, 0.0, 0.0)
    truck.put(-1.0, 4.0, 1.0, 0.3)
    truck.speed, truck.pitch = 2.0, 0.1
    draw(truck, 0.5)
    assert trailer.h == pytest.approx(math.atan2(8.0, 6.0))
    assert (trailer.x, trailer.y) == (pytest.approx(-1.0 - 3.0), pytest.approx(4.0 - 4.0))
    assert (trailer.z, trailer.pitch, trailer.speed) == (1.0, 0.1, 2.0)
    assert (trailer.vx, trailer.vy) == (pytest.approx(3.0 / 0.5), pytest.approx(4.0 / 0.5))
    assert trailer.travelled == pytest.approx(5.0)
    draw(truck, 0.0)  # no time has passed
    assert trailer.travelled == pytest.approx(5.0)
    trailer.coupler = 0.0
    truck.put(9.0, 9.0, 0.0, 0.0)
    draw(truck, 0.5)
    assert trailer.h == pytest.approx(math.atan2(8.0, 6.0))  # a coupler above the axle does not turn it


# --- being there in time


class Arriving(Synchronize):
    """One that has so far to go, to a master that has so far to go."""

    __slots__ = ("ways",)

    def _way(self, entity: Any, target: Any) -> float:
        return self.ways[entity.name]  # type: ignore[no-any-return]


def arriving(way: float, master_way: float, *, speed: float, pace: float = 2.0, tolerance: float = 0.0,
             tolerance_master: float | None = None) -> Any:  # fmt: skip
    action: Any = Arriving.__new__(Arriving)
    entity, master = car("A"), car("M")
    entity.speed, master.vx = speed, pace
    action.ways = {"A": way, "M": master_way}
    action._entity, action._master, action._final, action._phase = entity, master, None, "new"
    action._target = action._master_target = lambda: None
    action._last = action._last_master = math.inf
    action._element = SimpleNamespace(target_tolerance=tolerance, target_tolerance_master=tolerance_master)
    return action


@pytest.mark.parametrize(
    ("way", "speed", "after"),
    [
        (20.0, 4.0, 4.0),  # 20 m in 5 s at 4 m/s: it need not change
        (30.0, 4.0, 4.0 + 2.0 * (6.0 - 4.0) / 5.0 * 0.1),  # from 4 to 8 m/s in 5 s
        (10.0, 4.0, 4.0 - 2.0 * (4.0 - 2.0) / 5.0 * 0.1),  # from 4 to 0 m/s
        (0.5, 0.01, 0.01 + 2.0 * (0.1 - 0.01) / 5.0 * 0.1),
        (0.01, 0.02, 0.02 - 2.0 * (0.02 - 0.002) / 5.0 * 0.1),
    ],
)
def test_without_a_final_speed_one_ramp_arrives_in_time(way: float, speed: float, after: float) -> None:
    """The master has 10 m to go at 2 m/s."""
    action = arriving(way, 10.0, speed=speed)
    assert not action._go_on(0.1)
    assert action._entity.speed == pytest.approx(after)


def test_nobody_drives_back_to_be_in_time_and_a_standing_master_changes_nothing() -> None:
    late = arriving(0.01, 0.3, speed=5.0)
    assert not late._go_on(0.1)  # 0.15 s are left
    assert late._entity.speed == 0.0
    waits = arriving(20.0, 10.0, speed=3.0, pace=0.0)
    assert not waits._go_on(0.1)
    assert waits._entity.speed == 3.0
    tolerant = arriving(25.0, 10.0, speed=4.0, tolerance=5.0)
    tolerant._go_on(0.1)
    assert tolerant._entity.speed == pytest.approx(4.0)
    tolerant = arriving(20.0, 12.0, speed=4.0, tolerance_master=2.0)  # the master is there in 5 s
    tolerant._go_on(0.1)
    assert tolerant._entity.speed == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("final", "top", "speed"),
    [(None, 50.0, None), (model.AbsoluteSpeed(value=7.0), 50.0, 7.0), (model.AbsoluteSpeed(value=70.0), 50.0, 50.0),
     (model.AbsoluteSpeed(value=-70.0), 50.0, -50.0), ("delta", 50.0, 5.5), ("factor", 50.0, 6.0)],
)  # fmt: skip
def test_a_final_speed_is_given_or_relative_to_the_master_and_within_what_one_can(
    final: Any, top: float, speed: float | None
) -> None:
    """The master drives 4 m/s: 1.5 more, or 1.5 times as fast."""
    action = arriving(10.0, 10.0, speed=1.0)
    action._master.speed, action._entity.max_speed = 4.0, top
    relative = isinstance(final, str)
    action._final = SimpleNamespace(value=1.5, speed_target_value_type=final) if relative else final
    assert action._final_speed() == speed


@pytest.mark.parametrize(
    ("state", "final", "steady"),
    [(None, 5.0, (0.0, 0.0)), (model.TargetDistanceSteadyState(distance=20.0), 5.0, (20.0, 4.0)),
     (model.TargetTimeSteadyState(time=3.0), 5.0, (15.0, 3.0)),
     (model.TargetTimeSteadyState(time=3.0), 0.0, (0.0, 0.0))],
)  # fmt: skip
def test_a_steady_state_is_a_way_or_a_time_at_the_final_speed(
    state: Any, final: float, steady: tuple[float, float]
) -> None:
    action = arriving(10.0, 10.0, speed=1.0)
    action._final = SimpleNamespace(steady_state=state)
    assert action._steady(final) == steady


@pytest.mark.parametrize(("steps", "final", "stands"), [(0, True, True), (1, True, False), (0, False, False)])
def test_before_the_first_step_who_has_a_final_speed_stands(steps: int, final: bool, stands: bool) -> None:
    action = arriving(10.0, 10.0, speed=3.0)
    action._board, action._final = SimpleNamespace(steps=steps), SimpleNamespace() if final else None
    assert not action.start()
    assert (action._entity.speed, action._phase) == ((0.0, "stopped") if stands else (3.0, "new"))


@pytest.mark.parametrize(
    ("way", "master_way", "over"), [(0.0, 10.0, True), (10.0, 0.0, True), (1.0, 0.19, True), (1.0, 0.21, False)]
)
def test_it_is_over_where_one_of_both_is_there_or_no_step_is_left(way: float, master_way: float, over: bool) -> None:
    action = arriving(way, master_way, speed=1.0)
    assert action._go_on(0.1) is over
    if over:
        assert action._entity.speed == 1.0  # without a final speed it keeps its own
    final = arriving(way, master_way, speed=1.0)
    final._final = model.AbsoluteSpeed(value=7.0)
    assert final._go_on(0.1) is over
    assert (final._entity.speed == 7.0) is over


def test_it_is_over_where_one_of_both_draws_away_again() -> None:
    action = arriving(10.0, 10.0, speed=1.0)
    assert not action._go_on(0.1)
    assert not action._go_on(0.1)  # who stands does not draw away
    action.ways["A"] = 10.1
    assert action._go_on(0.1)
    action = arriving(10.0, 10.0, speed=1.0)
    action._go_on(0.1)
    action.ways["M"] = 10.1
    assert action._go_on(0.1)
    for who in "AM":  # a thousandth of a millimetre more is none yet
        action = arriving(10.0, 10.0, speed=1.0)
        action._go_on(0.1)
        action.ways[who] = 10.0 + 1e-6
        assert not action._go_on(0.1)
