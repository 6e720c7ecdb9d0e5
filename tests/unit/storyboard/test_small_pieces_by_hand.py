"""Small pieces of the storyboard each by itself: who gets a driver, what a name means, where a body stands."""

from __future__ import annotations

import math
import sys
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.road.positions import RoadPosition
from openscenario.storyboard import crowd, drivers, ground
from openscenario.storyboard.actions.speed import Speed
from openscenario.storyboard.actions.trajectory import FollowTrajectory
from openscenario.storyboard.build import _family
from openscenario.storyboard.distances import _along_axis
from openscenario.storyboard.geo import projection
from openscenario.storyboard.ground import BESIDE, Ground
from openscenario.storyboard.motion import move
from openscenario.storyboard.places import Place, RoadPoint
from openscenario.storyboard.selections import selections
from openscenario.storyboard.trailers import couple, draw
from openscenario.storyboard.trajectories import Course, _between, course
from openscenario.storyboard.unsupported import Unsupported
from openscenario.storyboard.values import typed

from .bodies import car

QUARTER = 0.5 * math.pi

# --- who gets a driver


@pytest.mark.parametrize(
    ("kind", "external", "name", "reacts", "drives"),
    [("vehicle", False, "A", (False, True), True), ("vehicle", False, "A", (False, False), False),
     ("vehicle", False, "A", (), False), ("vehicle", True, "A", (True,), False),
     ("pedestrian", False, "A", (True,), False), ("vehicle", False, "Ego", (True,), False)],
)  # fmt: skip
def test_a_vehicle_of_the_traffic_gets_the_first_controller_that_reacts(
    kind: str, external: bool, name: str, reacts: Any, drives: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drivers, "is_interactive", lambda controller: controller.reacts)
    monkeypatch.setattr(drivers, "Driver", lambda controller: controller)
    monkeypatch.setattr(drivers, "ego_among", lambda entities: "Ego")
    entity = car(name, kind=kind)
    entity.kind, entity.external, entity.driver = kind, external, SimpleNamespace()  # type: ignore[assignment]
    controllers: Any = [SimpleNamespace(controller=SimpleNamespace(reacts=each)) for each in reacts]
    drivers.assign(entity, controllers, SimpleNamespace(entities={name: entity}))  # type: ignore[arg-type]
    assert entity.driver is (controllers[reacts.index(True)].controller if drives else None)


# --- names


@pytest.mark.parametrize(
    ("xml", "family"),
    [("PrivateAction/LateralAction/LaneChangeAction", "LateralAction"), ("GlobalAction/EntityAction", "EntityAction"),
     ("UserDefinedAction", "Fake")],
)  # fmt: skip
def test_the_family_of_an_action_is_the_tag_below_the_first(xml: str, family: str) -> None:
    assert _family(type("Fake", (), {"XML": xml})()) == family


def test_a_selection_has_those_that_are_named_and_all_of_a_type_each_once() -> None:
    kinds = {"A": "vehicle", "B": "pedestrian", "C": "vehicle", "D": "misc"}
    entities = [SimpleNamespace(name=name, kind=kind) for name, kind in kinds.items()]
    by_type = {kind: SimpleNamespace(object_type=kind) for kind in ("vehicle", "miscellaneous", "pedestrian")}
    name = {each: model.EntityRef(entity_ref=each) for each in "ABC"}
    members = {"cars": [by_type["vehicle"]], "named": [name["B"], name["A"]], "none": [],
               "both": [name["C"], by_type["vehicle"], by_type["miscellaneous"]]}  # fmt: skip
    told = [SimpleNamespace(name=name, members=each) for name, each in members.items()]
    scenario: Any = SimpleNamespace(entity_selections=told, entities=entities)
    assert selections(scenario) == {"cars": ("A", "C"), "named": ("B", "A"), "both": ("C", "A", "D"), "none": ()}


@pytest.mark.parametrize(("kind", "text"), [("double", "fast"), ("integer", "x"), ("unsignedInt", ""), ("double", "")])
def test_what_spells_no_number_stays_a_text(kind: str, text: str) -> None:
    assert typed(kind, text) == text


def test_geographic_positions_need_the_package_that_projects_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyproj", None)
    with pytest.raises(Unsupported, match="need pyproj"):
        projection("+proj=tmerc +lat_0=48.123456 +lon_0=11")
    with pytest.raises(Unsupported, match="no geoReference"):
        projection("  \n ")


# --- where a body stands


def on_a_slope(h: float, x: float = 10.0, y: float = 5.0) -> tuple[Ground, Any]:
    """A body at (10, 5) that heads `h`; its lane heads 0.5 rad and rises by 0.2 rad, 3 m high at (x, y)."""
    pose = SimpleNamespace(h=0.5, pitch=-0.2, roll=0.0)
    fields = (x, y, 3.0, 0.5, -0.2, 0.0)

    class Pose(tuple[float, ...]):
        h, pitch, roll = pose.h, pose.pitch, pose.roll

    road = Ground(None)
    found = RoadPosition("1", -1, 20.0, 0.0, 0.3, 0.0, True)
    road.network = SimpleNamespace(  # type: ignore[assignment]
        lane_pose=lambda *at: Pose(fields), locate=lambda *at, **more: found
    )
    body = car()
    body.x, body.y, body.h = 10.0, 5.0, h
    return road, body


@pytest.mark.parametrize(
    ("turn", "pitch", "roll"),
    [(0.0, -0.2, 0.0), (math.pi, 0.2, 0.0), (QUARTER, 0.0, -0.2), (-QUARTER, 0.0, 0.2)],
)
def test_a_body_on_a_slope_leans_as_it_is_turned_against_its_lane(turn: float, pitch: float, roll: float) -> None:
    """A positive roll is one with the left side up: who has turned left has the hill to its right."""
    road, body = on_a_slope(0.5 + turn)
    road.stand(body)
    assert (body.z, body.pitch, body.roll) == pytest.approx((3.0, pitch, roll), abs=1e-9)
    assert (body.road, body.lane, body.s, body.offset) == ("1", -1, 20.0, 0.3)


@pytest.mark.parametrize(("off", "height"), [(0.9 * BESIDE, 3.0), (1.1 * BESIDE, 0.0), (0.5, 0.0), (-0.5, 0.0)])
@pytest.mark.parametrize("axis", [0, 1])
def test_who_is_beside_all_lanes_has_not_the_height_of_the_nearest(off: float, height: float, axis: int) -> None:
    """Half a metre beside the road one stands beside it; what that is against is rounding."""
    place = [10.0, 5.0]
    place[axis] += off
    road, body = on_a_slope(0.5, *place)
    road.stand(body)
    assert body.z == height


@pytest.mark.parametrize(
    ("against", "sense", "twist"),
    [(0.3, 1.0, 0.3), (QUARTER, 1.0, QUARTER), (-QUARTER, 1.0, -QUARTER), (2.0, -1.0, 2.0 - math.pi),
     (math.pi, -1.0, 0.0), (-3.0, -1.0, math.pi - 3.0)],
)  # fmt: skip
def test_up_to_a_quarter_turn_one_faces_along_the_lane(
    against: float, sense: float, twist: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    road, body = on_a_slope(1.5)
    monkeypatch.setattr(ground, "yaw_in_plane", lambda pitch, roll, heading: against)
    assert road.track(body)
    assert (body.sense, body.tracked) == (sense, True)
    assert body.twist == pytest.approx(twist)


@pytest.mark.parametrize(("sense", "sign"), [(1.0, 1), (-1.0, 1), (1.0, -1), (-1.0, -1)])
def test_a_way_along_a_lane_is_one_with_its_traffic_or_against_it(sense: float, sign: int) -> None:
    """The network counts a way with the traffic; along a lane it goes where the entity faces, along a road with s."""
    asked: list[Any] = []

    def advance(here: RoadPosition, way: float, aside: float, route: Any, *, on_reference: bool) -> RoadPosition:
        asked.append((here.s, here.offset, way, aside, route, on_reference))
        return RoadPosition("9", 2, 33.0, 0.0, 0.7, 0.0, True)

    road, body = Ground(None), car()
    road.network = SimpleNamespace(driving_sign=lambda road, lane, s: sign, advance=advance)  # type: ignore[assignment]
    body.road, body.lane, body.s, body.offset, body.sense = "1", -1, 20.0, 0.3, sense
    assert road.along_lane(body, 5.0, ("r",)) == ("9", 2, 33.0, 0.3)  # type: ignore[arg-type]
    assert road.along_road(body, -4.0, ()) == ("9", 2, 33.0, 0.3)
    assert asked == [(20.0, 0.3, sign * sense * 5.0, 0.0, ("r",), False), (20.0, 0.3, sign * -4.0, 0.0, (), True)]
    road.network.driving_sign = lambda road, lane, s: sign if road == "1" else -1  # type: ignore[method-assign,union-attr]
    assert road.sense_at(body, RoadPoint("8", 1, 0.0, 0.0)) == -sense * sign


def test_who_is_moved_from_outside_has_the_velocity_of_its_speed_and_no_place_on_a_road_yet() -> None:
    body = car()
    body.tracked = True
    Ground(None).place(body, 1.0, 2.0, 3.0, 0.5 + math.tau, 4.0)
    assert (body.x, body.y, body.z, body.h) == pytest.approx((1.0, 2.0, 3.0, 0.5))
    assert (body.speed, body.vx, body.vy) == pytest.approx((4.0, 4.0 * math.cos(0.5), 4.0 * math.sin(0.5)))
    assert not body.tracked


@pytest.mark.parametrize("road", [None, RoadPoint("7", 2, 30.0, 0.4)])
def test_a_place_that_names_a_road_keeps_it(road: RoadPoint | None) -> None:
    ground, body = on_a_slope(0.0)
    body.end_of_road = True
    ground.set_place(body, Place(1.0, 2.0, 3.0, 0.5, 0.1, 0.2, road=road))
    assert (body.x, body.y, body.z, body.h, body.pitch, body.roll) == (1.0, 2.0, 3.0, 0.5, 0.1, 0.2)
    assert (body.end_of_road, body.tracked) == (False, road is not None)
    if road is not None:
        assert (body.road, body.lane, body.s, body.offset) == road


class OneSpot(crowd.Crowd):
    """A crowd with one spot, at the origin."""

    spots = SimpleNamespace(points=[RoadPoint("1", -1, 0.0, 0.0)], x=[0.0], y=[0.0])  # type: ignore[assignment]


@pytest.mark.parametrize(
    ("lane", "apart", "speed", "active", "free"),
    [(-1, 20.9, 5.0, True, False), (-1, 21.1, 5.0, True, True), (-1, 0.0, 5.0, False, True), (1, 0.0, 5.0, True, True)],
)  # fmt: skip
def test_a_spot_is_free_if_all_that_are_there_are_far_enough(
    lane: int, apart: float, speed: float, active: bool, free: bool
) -> None:
    """Of 4 m length, the middle 1 m ahead: 6 m between reference points, and 2 m and 1.5 s at 8.67 m/s in the lane.
    Whoever is beside it on the same road does not matter, and one that is gone is no reason to stop looking."""
    gone, there, new = car("G"), car("T"), car("N")
    gone.active = False
    for body in (gone, there):
        body.road, body.lane = "1", -1
    there.lane, there.active, there.x, there.speed = lane, active, apart, -speed
    found: Any = object.__new__(OneSpot)
    found.board = SimpleNamespace(entities={"G": gone, "T": there}, ground=SimpleNamespace(track=lambda entity: True))
    wished = (15.0 - crowd.STANDSTILL) / crowd.HEADWAY
    assert found._free(0, new, wished) is free


class Beginning(FollowTrajectory):
    """On a line whose first heading is given against its direction."""

    def __init__(self, turned: float, *, explicit: bool, properties: Any = None, speed: float = 5.0) -> None:
        self.line = SimpleNamespace(explicit=explicit, h=[0.4 + turned], tangent=lambda s: 0.4, length=10.0)
        self._entity = car(entity=None)
        self._entity.properties, self._entity.speed = properties or {}, speed
        self._element: Any = SimpleNamespace(time_reference=None)
        self._cut, self.domains = 2.0, ("lateral",)

    def _begin(self) -> Any:
        return self.line

    def _go(self, along: Any) -> None:
        self._entity.x += 0.5


@pytest.mark.parametrize(
    ("turned", "explicit", "ignored", "speed", "reverse"),
    [(0.3, True, False, 5.0, False), (math.pi, True, False, 5.0, True), (2.0, True, False, -5.0, True),
     (math.pi, True, True, 5.0, False), (math.pi, False, False, 5.0, False), (0.0, False, False, -5.0, True),
     (0.0, True, False, -5.0, False), (0.0, False, False, 0.0, False)],
)  # fmt: skip
def test_who_is_told_to_look_back_or_drives_back_follows_a_line_rear_first(
    turned: float, explicit: bool, ignored: bool, speed: float, reverse: bool
) -> None:
    told = {"ignoreHeadingForTrajMotion": "true"} if ignored else {}
    action = Beginning(turned, explicit=explicit, properties=told, speed=speed)
    assert not action.start()
    assert (action._reverse, action._s) == (reverse, 2.0)
    action.line.length = 0.0
    assert action.start()


# --- who stands, and what is drawn


class Nothing:
    """A ground that nobody asks."""

    network = None

    def track(self, entity: Any) -> bool:
        raise AssertionError("asked for its road")


def test_who_stands_and_does_not_turn_is_not_moved_at_all() -> None:
    entity = car()
    entity.vx = entity.vy = 3.0
    move(entity, 0.1, Nothing())  # type: ignore[arg-type]
    assert (entity.vx, entity.vy, entity.ax, entity.travelled) == (0.0, 0.0, 0.0, 0.0)
    for name, value in (("drift", 0.1), ("shifted", True), ("speed", 1.0)):
        other = car()
        setattr(other, name, value)
        with pytest.raises(AssertionError):
            move(other, 0.1, Nothing())  # type: ignore[arg-type]


@pytest.mark.parametrize(("coupler", "apart", "turns"), [(0.5, 0.5, True), (1e-7, 0.5, False), (0.5, 1e-7, False)])
def test_a_short_coupler_is_drawn_too_and_one_above_its_axle_keeps_its_heading(
    coupler: float, apart: float, turns: bool
) -> None:
    ahead, behind = car("A"), car("T")
    ahead.hitch, behind.coupler = 0.0, coupler
    couple(ahead, behind)
    behind.put(0.0, 0.0, 0.0, 0.25)
    ahead.put(0.0, apart, 0.0, 0.0)
    draw(ahead, 0.1)
    assert behind.h == pytest.approx(QUARTER if turns else 0.25)


# --- speeds, distances and curves


@pytest.mark.parametrize("kind", ["factor", "delta"])
def test_a_target_that_is_relative_to_another_moves_with_it(kind: Any) -> None:
    a, b = car("A"), car("B")
    b.speed = 10.0
    target = model.RelativeTargetSpeed(entity_ref="B", value=1.5, speed_target_value_type=kind, continuous=True)
    shape = model.TransitionDynamics(dynamics_shape="step", dynamics_dimension="time", value=0.0)
    element = model.SpeedAction(speed_action_dynamics=shape, speed_action_target=target)
    action = Speed(element, a, SimpleNamespace(entities={"A": a, "B": b}))  # type: ignore[arg-type]
    assert not action.start()
    b.speed = 12.0
    a.max_acceleration = 1e3
    assert not action.step(0.1)
    assert a.speed == pytest.approx(18.0 if kind == "factor" else 13.5)


@pytest.mark.parametrize("direction", [0.0, 0.5, 2.0, -1.0])
def test_a_distance_along_an_axis_is_the_part_of_the_way_that_runs_along_it(direction: float) -> None:
    """3 m along the axis and 4 m to its left, between reference points."""
    c, s = math.cos(direction), math.sin(direction)
    a, b = car("A"), car("B")
    a.put(1.0, 2.0, 0.0, 0.0)
    b.put(1.0 + 3.0 * c - 4.0 * s, 2.0 + 3.0 * s + 4.0 * c, 0.0, 0.0)
    assert _along_axis(a, b, False, lambda: direction)() == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("u", "value"), [(-1.0, 2.0), (0.0, 2.0), (0.25, 3.0), (1.0, 9.0), (2.0, 9.0), (0.999999, 6.0)]
)
def test_where_two_places_are_one_the_later_value_counts(u: float, value: float) -> None:
    assert _between([0.0, 1.0, 1.0], [2.0, 6.0, 9.0], u) == pytest.approx(value, rel=1e-5)


@pytest.mark.parametrize(
    ("x", "y", "s"), [(0.125, 0.4, 0.125), (0.375, -0.2, 0.375), (0.9, 0.0, 0.5), (-1.0, 3.0, 0.0)]
)
def test_the_nearest_place_may_lie_within_a_piece_shorter_than_a_metre(x: float, y: float, s: float) -> None:
    assert Course([(0.0, 0.0, 0.0, 0.0), (0.25, 0.0, 0.0, 0.0), (0.5, 0.0, 0.0, 0.0)]).nearest(x, y) == pytest.approx(s)


def nurbs(points: list[tuple[float, float, float]], knots: tuple[float, ...]) -> Any:
    control = tuple(
        model.ControlPoint(position=Place(x, y, 0.0, h), weight=1.0, time=None)  # type: ignore[arg-type]
        for x, y, h in points
    )
    return model.Nurbs(order=3, control_points=control, knots=tuple(model.Knot(value=k) for k in knots))


def drawn(shape: Any) -> Any:
    return course(SimpleNamespace(shape=shape, closed=False), lambda place: place)  # type: ignore[arg-type]


@pytest.mark.parametrize(("scale", "shift"), [(1.0, 3.0), (5.0, -2.0), (0.5, 0.0)])
def test_a_curve_is_the_same_whatever_its_knots_are_counted_from_and_in(scale: float, shift: float) -> None:
    points = [(0.0, 0.0, 0.0), (4.0, 3.0, 0.0), (8.0, -1.0, 0.0), (12.0, 2.0, 0.0)]
    knots = (0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0)
    plain = drawn(nurbs(points, knots))
    other = drawn(nurbs(points, tuple(scale * k + shift for k in knots)))
    assert other.x == pytest.approx(plain.x)
    assert other.y == pytest.approx(plain.y)
    assert (plain.x[0], plain.y[0], plain.x[-1], plain.y[-1]) == pytest.approx((0.0, 0.0, 12.0, 2.0))


def test_a_curve_that_stays_at_a_place_has_the_heading_of_its_first_point() -> None:
    curve = drawn(nurbs([(1.0, 2.0, 0.7), (1.0, 2.0, 0.1), (1.0, 2.0, -0.4)], (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)))
    assert curve.h == pytest.approx([0.7] * len(curve.h))
