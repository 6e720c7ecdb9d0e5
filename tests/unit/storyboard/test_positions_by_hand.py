"""Positions made into places on the straight two-way road: every kind, with and without what may be left out."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.findings import ScenarioError
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.ground import Ground
from openscenario.storyboard.places import Place, RoadPoint
from openscenario.storyboard.positions import _on_surface, on_ground, place, resolver
from openscenario.storyboard.unsupported import Unsupported

from .conftest import Make, lane_position, speed, teleport

LEFT = math.pi
QUARTER = 0.5 * math.pi


@pytest.fixture
def board(make: Make) -> Storyboard:
    """A drives along x at 100 m in lane -1 (y = -1.75), 0.25 m left of its middle; B against x at 300 m in lane 1."""
    made = make(A=[teleport(lane_position(100.0, -1, 0.25)), speed(0.0)],
                B=[teleport(lane_position(300.0, 1)), speed(0.0)])  # fmt: skip
    made.start()
    return made


def turned(h: float, p: float = 0.0, r: float = 0.0, kind: Any = "relative") -> model.Orientation:
    return model.Orientation(h=h, p=p, r=r, type=kind)


def found(position: Any, board: Storyboard) -> tuple[float, float, float]:
    """x, y and heading from 0 to a turn."""
    where = place(position, board)
    return where.x, where.y, math.fmod(where.h + 4.0 * math.pi + 1e-9, 2.0 * math.pi) - 1e-9


# --- on lanes and roads


@pytest.mark.parametrize(
    ("lane", "offset", "orientation", "y", "h"),
    [
        (-1, 0.0, None, -1.75, 0.0),
        (-1, 0.5, None, -1.25, 0.0),
        (-2, -0.5, None, -5.75, 0.0),
        (1, 0.5, None, 2.25, LEFT),  # its offset is that of the road, its heading that of its traffic
        (1, 0.0, turned(0.5), 1.75, LEFT + 0.5),
        (1, 0.0, turned(0.5, kind="absolute"), 1.75, 0.5),
        (-1, 0.0, turned(0.5), -1.75, 0.5),
    ],
)
def test_a_lane_position_heads_as_its_traffic_does(
    board: Storyboard, lane: int, offset: float, orientation: Any, y: float, h: float
) -> None:
    position = model.LanePosition(road_id="1", lane_id=lane, s=50.0, offset=offset, orientation=orientation)
    assert found(position, board) == pytest.approx((50.0, y, h))
    where = place(position, board)
    assert where.road == RoadPoint("1", lane, 50.0, offset)
    assert where.has_heading is (orientation is not None)


@pytest.mark.parametrize(("s", "x"), [(-5.0, 0.0), (0.0, 0.0), (1000.0, 1000.0), (1005.0, 1000.0)])
def test_beyond_the_ends_of_a_road_its_ends_are_meant(board: Storyboard, s: float, x: float) -> None:
    assert found(model.LanePosition(road_id="1", lane_id=-1, s=s), board)[0] == pytest.approx(x)
    assert found(model.RoadPosition(road_id="1", s=s, t=0.0), board)[0] == pytest.approx(x)


@pytest.mark.parametrize(("t", "orientation", "h"), [(3.0, None, 0.0), (-3.0, turned(0.5), 0.5),
                                                     (3.0, turned(LEFT, kind="absolute"), LEFT)])  # fmt: skip
def test_a_road_position_heads_along_the_reference_line(
    board: Storyboard, t: float, orientation: Any, h: float
) -> None:
    position = model.RoadPosition(road_id="1", s=50.0, t=t, orientation=orientation)
    assert found(position, board) == pytest.approx((50.0, t, h))
    assert place(position, board).road is None


@pytest.mark.parametrize(
    ("position", "says"),
    [
        (model.LanePosition(road_id="2", lane_id=-1, s=50.0), "no road of this id"),
        (model.RoadPosition(road_id="2", s=50.0, t=0.0), "no road of this id"),
        (model.LanePosition(road_id="1", lane_id=-3, s=50.5), "no lane -3 on road 1 at s = 50.5 m"),
        (model.RelativeWorldPosition(entity_ref="C", dx=0.0, dy=0.0), "no entity of this name"),
        (model.RelativeLanePosition(entity_ref="C", d_lane=0), "no entity of this name"),
        (model.GeoPosition(), "latitude and longitude are needed"),
        (model.GeoPosition(latitude=0.5), "latitude and longitude are needed"),
        (model.GeoPosition(latitude_deg=0.5, longitude=0.5), "latitude and longitude are needed"),
    ],
)
def test_what_does_not_exist_is_refused(board: Storyboard, position: Any, says: str) -> None:
    with pytest.raises(Unsupported, match=says):
        place(position, board)


@pytest.mark.parametrize(
    "position",
    [
        model.LanePosition(road_id="1", lane_id=-1, s=50.0),
        model.RoadPosition(road_id="1", s=50.0, t=0.0),
        model.RelativeLanePosition(entity_ref="A", d_lane=0),
        model.RelativeRoadPosition(entity_ref="A", ds=0.0, dt=0.0),
        model.GeoPosition(latitude_deg=1.0, longitude_deg=1.0),
    ],
)
def test_without_a_road_network_there_are_no_roads(make: Make, position: Any) -> None:
    bare = make(A=[], without_road=True)
    with pytest.raises(Unsupported, match="the scenario has no road network"):
        place(position, bare)


@pytest.mark.parametrize(("z", "told"), [(None, 0.0), (0.0, 0.0), (2.0, 2.0), (-1.5, -1.5)])
def test_a_height_that_is_given_is_kept_and_else_it_is_the_road_s(
    board: Storyboard, make: Make, z: float | None, told: float
) -> None:
    position = model.WorldPosition(x=50.0, y=-1.75, z=z)
    assert place(position, board).z == pytest.approx(told)
    assert place(position, make(A=[], without_road=True)).z == told


# --- relative to an entity


@pytest.mark.parametrize(
    ("position", "pose"),
    [
        (model.RelativeWorldPosition(entity_ref="A", dx=2.0, dy=3.0), (102.0, 1.5, 0.0)),
        (model.RelativeWorldPosition(entity_ref="B", dx=2.0, dy=3.0), (302.0, 4.75, LEFT)),
        (model.RelativeWorldPosition(entity_ref="B", dx=2.0, dy=3.0, orientation=turned(0.5)),
         (302.0, 4.75, LEFT + 0.5)),
        (model.RelativeObjectPosition(entity_ref="A", dx=2.0, dy=3.0), (102.0, 1.5, 0.0)),
        (model.RelativeObjectPosition(entity_ref="B", dx=2.0, dy=3.0), (298.0, -1.25, LEFT)),
        (model.RelativeRoadPosition(entity_ref="A", ds=5.0, dt=2.0), (105.0, 0.5, 0.0)),
        (model.RelativeRoadPosition(entity_ref="B", ds=5.0, dt=2.0), (305.0, 3.75, LEFT)),  # faces as B would there
        (model.RelativeRoadPosition(entity_ref="B", ds=5.0, dt=2.0, orientation=turned(0.5)), (305.0, 3.75, 0.5)),
    ],
)  # fmt: skip
def test_beside_an_entity_in_the_world_in_its_own_frame_and_along_the_road(
    board: Storyboard, position: Any, pose: tuple[float, float, float]
) -> None:
    assert found(position, board) == pytest.approx(pose)


@pytest.mark.parametrize(
    ("more", "pose"),
    [
        ({"entity_ref": "A", "d_lane": 0}, (100.0, -1.75, 0.0)),
        ({"entity_ref": "A", "d_lane": -1, "ds": 5.0}, (105.0, -5.25, 0.0)),
        ({"entity_ref": "A", "d_lane": 1, "ds": 5.0, "offset": 0.5}, (105.0, 2.25, LEFT)),  # with the traffic there
        ({"entity_ref": "A", "d_lane": 1, "ds_lane": 5.0, "offset": 0.5}, (105.0, 2.25, LEFT)),
        ({"entity_ref": "B", "d_lane": 1, "ds": 5.0, "offset": 0.5}, (305.0, 5.75, LEFT)),  # as s and ids increase
        ({"entity_ref": "B", "d_lane": 1, "ds_lane": 5.0, "offset": 0.5}, (295.0, -2.25, 0.0)),  # as B sees it
        ({"entity_ref": "B", "d_lane": -1, "ds_lane": 5.0}, (295.0, 5.25, LEFT)),
        ({"entity_ref": "B", "d_lane": 0, "ds_lane": 0.0}, (300.0, 1.75, LEFT)),
        ({"entity_ref": "B", "d_lane": 0, "ds_lane": 5.0, "orientation": turned(0.5)}, (295.0, 1.75, LEFT + 0.5)),
        ({"entity_ref": "B", "d_lane": 0, "orientation": turned(0.5, kind="absolute")}, (300.0, 1.75, 0.5)),
    ],
)
def test_lanes_beside_an_entity_count_along_the_road_or_as_it_sees_them(
    board: Storyboard, more: dict[str, Any], pose: tuple[float, float, float]
) -> None:
    assert found(model.RelativeLanePosition(**more), board) == pytest.approx(pose)


def test_a_lane_that_is_not_there_beside_an_entity_is_told_while_the_scenario_runs(board: Storyboard) -> None:
    position = dataclasses.replace(
        model.RelativeLanePosition(entity_ref="A", d_lane=-2, ds=1.5), at=model.At("x.xosc", 7, "Position")
    )
    with pytest.raises(ScenarioError) as refused:
        place(position, board)
    (finding,) = refused.value.findings
    assert (finding.code, finding.file, finding.line, finding.element) == (
        "ref.unknown_lane", "x.xosc", 7, "Position@dLane",
    )  # fmt: skip
    assert finding.text == "road 1 has no lane -3 at s = 101.5 m, beside A"
    assert finding.found == "-2"


@pytest.mark.parametrize(
    ("own", "others", "asked"),
    [
        ((), (), ()),
        (("own",), ("other",), ("own",)),
        ((), ("other",), ("other",)),
        (None, ("other",), ("other",)),  # nobody is put there
    ],
)
def test_the_route_of_who_is_put_there_leads_before_that_of_the_other(
    board: Storyboard, monkeypatch: pytest.MonkeyPatch, own: Any, others: Any, asked: Any
) -> None:
    routes: list[Any] = []

    def along(ground: Any, other: Any, ds: float, route: Any) -> RoadPoint:
        routes.append(route)
        return RoadPoint("1", -1, 100.0 + ds, 0.0)

    monkeypatch.setattr(Ground, "along_road", along)
    monkeypatch.setattr(Ground, "along_lane", along)
    board.entities["A"].route_lanes = others
    mover: Any = None if own is None else SimpleNamespace(route_lanes=own)
    for position in (model.RelativeLanePosition(entity_ref="A", d_lane=0, ds=1.0),
                     model.RelativeLanePosition(entity_ref="A", d_lane=0, ds_lane=1.0),
                     model.RelativeRoadPosition(entity_ref="A", ds=1.0, dt=0.0)):  # fmt: skip
        assert resolver(position, board, mover)().x == pytest.approx(101.0)
    assert routes == [asked] * 3


# --- along trajectories and routes


def line(*points: tuple[float, float]) -> model.Trajectory:
    vertices = tuple(model.Vertex(position=model.WorldPosition(x=x, y=y)) for x, y in points)
    return model.Trajectory(name="t", closed=False, shape=model.Polyline(vertices=vertices))


@pytest.mark.parametrize(
    ("s", "t", "orientation", "pose"),
    [
        (4.0, 0.0, None, (4.0, 0.0, 0.0)),
        (4.0, 1.5, None, (4.0, 1.5, 0.0)),
        (12.0, 1.5, None, (8.5, 2.0, QUARTER)),  # to the left of a way that goes up
        (12.0, -1.5, turned(0.25), (11.5, 2.0, QUARTER + 0.25)),
        (9.0, 1.0, None, (9.0, 1.0, 0.0)),  # a metre before the corner the way still goes along x
        (12.0, 0.0, turned(0.25, kind="absolute"), (10.0, 2.0, 0.25)),
    ],
)
def test_a_place_beside_a_trajectory(
    board: Storyboard, s: float, t: float, orientation: Any, pose: tuple[float, float, float]
) -> None:
    way = line((0.0, 0.0), (10.0, 0.0), (10.0, 10.0))
    position = model.TrajectoryPosition(trajectory=way, s=s, t=t, orientation=orientation)
    assert found(position, board) == pytest.approx(pose)
    assert place(position, board).has_heading


def test_of_a_single_point_the_heading_is_its_own_and_of_a_clothoid_that_of_the_curve(board: Storyboard) -> None:
    one = model.Vertex(position=model.WorldPosition(x=3.0, y=4.0, h=QUARTER))
    point = model.Trajectory(name="t", closed=False, shape=model.Polyline(vertices=(one,)))
    assert found(model.TrajectoryPosition(trajectory=point, s=0.0, t=1.0), board) == pytest.approx((2.0, 4.0, QUARTER))
    circle = model.Clothoid(curvature=0.1, curvature_prime=0.0, length=20.0,
                            position=model.WorldPosition(x=0.0, y=0.0, h=0.0))  # fmt: skip
    bend = model.Trajectory(name="t", closed=False, shape=circle)
    where = found(model.TrajectoryPosition(trajectory=bend, s=5.0 * math.pi, t=2.0), board)
    assert where == pytest.approx((8.0, 10.0, QUARTER), abs=1e-4)  # a quarter of a circle of 10 m


# --- on the ground


class Hill:
    """A network that is shifted by (1, 2, 3) and turned by 0.1, whose only road rises by 0.2 rad along x at z = 7."""

    def __init__(self) -> None:
        self.asked: list[tuple[float, float, Any, Any]] = []

    def moved(self, x: float, y: float, z: float, h: float) -> tuple[float, float, float, float]:
        return x + 1.0, y + 2.0, z + 3.0, h + 0.1

    def locate(self, x: float, y: float, heading: Any, *, z: Any) -> Any:
        self.asked.append((x, y, heading, z))
        return SimpleNamespace(road="1", lane=-1, s=x, offset=0.5)

    def lane_pose(self, road: str, lane: int, s: float, offset: float) -> Any:
        assert (road, lane, offset) == ("1", -1, 0.5)
        return SimpleNamespace(x=s, y=0.0, z=7.0, h=0.0, pitch=-0.2, roll=0.0)


@pytest.mark.parametrize(
    ("given", "located", "told"),
    [
        # what is not given is the road's: height 7 m, and uphill where one looks along it
        ((None, None, None, None), (11.0, 22.0, None, None), (7.0, 0.1, None, None)),
        ((None, -0.1, None, None), (11.0, 22.0, 0.0, None), (7.0, 0.0, -0.2, 0.0)),
        ((None, -0.1 + QUARTER, None, None), (11.0, 22.0, QUARTER, None), (7.0, QUARTER, 0.0, -0.2)),
        ((4.0, -0.1, None, None), (11.0, 22.0, 0.0, 7.0), (7.0, 0.0, -0.2, 0.0)),
        ((5.0, -0.1, 0.3, None), (11.0, 22.0, 0.0, 8.0), (8.0, 0.0, 0.3, 0.0)),
        ((5.0, -0.1, None, 0.4), (11.0, 22.0, 0.0, 8.0), (8.0, 0.0, -0.2, 0.4)),
        ((None, -0.1, 0.3, 0.4), (11.0, 22.0, 0.0, None), (7.0, 0.0, 0.3, 0.4)),
        ((5.0, -0.1, 0.3, 0.4), None, (8.0, 0.0, 0.3, 0.4)),  # nothing is missing: no road is looked for
        ((5.0, None, 0.3, 0.4), None, (8.0, 0.1, 0.3, 0.4)),
    ],
)
def test_what_is_not_given_of_a_place_is_the_road_s(given: Any, located: Any, told: Any) -> None:
    hill = Hill()
    board: Any = SimpleNamespace(network=hill)
    z, h, pitch, roll = given
    where = place(model.WorldPosition(x=10.0, y=20.0, z=z, h=h, p=pitch, r=roll), board)
    assert [pytest.approx(one) for one in hill.asked] == ([] if located is None else [located])
    assert (where.x, where.y, where.z, where.h) == pytest.approx((11.0, 22.0, *told[:2]))
    if told[2] is not None:
        assert (where.pitch, where.roll) == pytest.approx(told[2:], abs=1e-9)
    assert where.has_heading is (given[1] is not None)


@pytest.mark.parametrize(
    ("given", "told"),
    [((1.0, 0.5, 0.2, 0.3), (1.0, 0.5, 0.2, 0.3, True)), ((None, None, None, None), (0.0, 0.0, 0.0, 0.0, False)),
     ((None, 0.0, None, None), (0.0, 0.0, 0.0, 0.0, True))],
)  # fmt: skip
def test_without_roads_what_is_not_given_is_nought(given: Any, told: Any) -> None:
    board: Any = SimpleNamespace(network=None)
    z, h, pitch, roll, has_heading = told
    assert on_ground(board, 10.0, 20.0, *given) == Place(10.0, 20.0, z, h, pitch, roll, None, has_heading)


@pytest.mark.parametrize(
    ("base", "orientation", "h", "pitch", "roll"),
    [
        (0.3, None, 0.3, -0.2, 0.0),  # uphill
        (0.3 + math.pi, None, 0.3 + math.pi, 0.2, 0.0),  # and the other way round downhill
        (0.3, turned(0.0, 0.05, 0.1), 0.3, -0.15, 0.1),
        (9.9, turned(0.3, 0.05, 0.1, "absolute"), 0.3, 0.05, 0.1),  # in the world, whatever the slope
        (0.3, turned(QUARTER), 0.3 + QUARTER, 0.0, -0.2),  # across: the right side is the lower one
    ],
)
def test_what_stands_on_a_slope_has_its_pitch_and_roll(
    base: float, orientation: Any, h: float, pitch: float, roll: float
) -> None:
    pose: Any = SimpleNamespace(x=1.0, y=2.0, z=3.0, h=0.3, pitch=-0.2, roll=0.0)
    where = _on_surface(pose, base, orientation, None)
    assert (where.x, where.y, where.z) == (1.0, 2.0, 3.0)
    assert math.remainder(where.h - h, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert (where.pitch, where.roll) == pytest.approx((pitch, roll), abs=1e-9)
    assert where.has_heading is (orientation is not None)
