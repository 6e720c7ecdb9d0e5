"""The crowd of a storyboard: where it may appear, how it is called, put, kept apart, driven and taken away."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from openscenario.storyboard import crowd as crowds
from openscenario.storyboard.actions.traffic import vehicle
from openscenario.storyboard.car_following import HEADWAY, STANDSTILL, following
from openscenario.storyboard.crowd import Crowd
from openscenario.storyboard.engine import Storyboard

from .conftest import Make, lane_position, speed, teleport


@pytest.fixture
def board(make: Make) -> Storyboard:
    """One car, A, that stands in lane -1 at 500 m: 5 m long, its middle 1.5 m ahead."""
    made = make(A=[teleport(lane_position(500.0)), speed(0.0)])
    made.start()
    return made


class Flow:
    """A flow that only counts how often it was asked."""

    def __init__(self) -> None:
        self.times: list[float] = []

    def come_and_go(self, crowd: Crowd, time: float) -> None:
        self.times.append(time)


def at(crowd: Crowd, s: float, lane: int = -1) -> int:
    """The number of the spot nearest to a place."""
    spots = [(abs(point.s - s), k) for k, point in enumerate(crowd.spots.points) if point.lane == lane]
    return min(spots)[1]


def only(crowd: Crowd, *spots: int) -> Any:
    return np.isin(np.arange(len(crowd.spots.points)), spots)


def test_spots_lie_every_5_m_in_the_middle_of_the_lanes_and_look_along_their_traffic(board: Storyboard) -> None:
    """1,000 m of road with two lanes of 3.5 m to each side; the right ones run with s."""
    spots = Crowd(board).spots
    assert len(spots.points) == 4 * 200
    for lane, y, h in ((-2, -5.25, 0.0), (-1, -1.75, 0.0), (1, 1.75, math.pi), (2, 5.25, math.pi)):
        rows = [k for k, point in enumerate(spots.points) if point.lane == lane]
        assert spots.x[rows] == pytest.approx(2.5 + 5.0 * np.arange(200))
        assert spots.y[rows] == pytest.approx(y)
        assert np.cos(spots.h[rows]) == pytest.approx(math.cos(h))
        assert [spots.points[k].s for k in rows] == pytest.approx(spots.x[rows])
        assert all(spots.points[k].offset == 0.0 for k in rows)


def lanes_of(board: Storyboard, monkeypatch: pytest.MonkeyPatch, *, length: float, width: float, kind: str) -> int:
    network = board.ground.network
    assert network is not None
    lane = SimpleNamespace(id=-1, type=kind)
    one = SimpleNamespace(
        roads={"1": SimpleNamespace(id="1", length=length)},
        section=lambda road, s: SimpleNamespace(lanes=[lane]),
        lane_width=lambda road, lane, s: width,
        lane_pose=network.lane_pose,
        driving_sign=network.driving_sign,
    )
    monkeypatch.setattr(board.ground, "network", one)
    return len(Crowd(board).spots.points)


@pytest.mark.parametrize(
    ("length", "width", "kind", "count"),
    [(3.0, 3.0, "driving", 1), (12.0, 3.0, "driving", 2), (10.0, 2.1, "driving", 2), (10.0, 2.0, "driving", 0),
     (10.0, 3.0, "sidewalk", 0)],
)  # fmt: skip
def test_a_short_road_has_one_spot_and_a_narrow_lane_or_no_driving_lane_none(
    board: Storyboard, monkeypatch: pytest.MonkeyPatch, length: float, width: float, kind: str, count: int
) -> None:
    assert lanes_of(board, monkeypatch, length=length, width=width, kind=kind) == count


def test_who_comes_has_a_free_name_its_place_and_a_speed_that_it_can_drive(board: Storyboard) -> None:
    crowd, flow = Crowd(board), Flow()
    k = at(crowd, 602.5, lane=1)
    assert crowd.admit(flow, "A", vehicle("car"), only(crowd, k), lambda: 90.0)
    assert list(board.entities) == ["A", "A-1"]
    (entity,) = crowd.of(flow)
    assert crowd.of(Flow()) == []
    assert board.entities["A-1"] is entity
    assert (entity.x, entity.y) == pytest.approx((602.5, 1.75))
    assert math.cos(entity.h) == pytest.approx(-1.0)
    assert (entity.road, entity.lane, entity.s, entity.offset, entity.sense) == ("1", 1, 602.5, 0.0, -1.0)
    assert entity.tracked
    assert (entity.speed, entity.speed_before, entity.vx) == (70.0, 70.0, pytest.approx(-70.0))
    assert abs(entity.vy) < 1e-9
    assert crowd.members["A-1"] == (entity, 70.0, flow)
    assert crowd.admit(flow, "A", vehicle("car"), only(crowd, at(crowd, 102.5)), lambda: 5.0)
    assert list(board.entities) == ["A", "A-1", "A-2"]
    assert board.entities["A-2"].sense == 1.0
    crowd.dismiss(board.entities["A-2"])
    assert list(crowd.members) == ["A-1"]
    assert crowd.admit(flow, "A", vehicle("car"), only(crowd, at(crowd, 102.5)), lambda: 5.0)
    assert list(crowd.members) == ["A-1", "A-3"]  # a name is not given twice


class Put:
    """What a crowd puts somewhere."""

    name = "put"

    def put(self, x: float, y: float, z: float, h: float) -> None:
        self.x, self.y, self.z, self.h = x, y, z, h

    def jump_to_speed(self, speed: float) -> None:
        self.speed = speed


def test_a_slope_tilts_who_is_put_there_as_he_looks(board: Storyboard, monkeypatch: pytest.MonkeyPatch) -> None:
    crowd = Crowd(board)
    for lane, sign in ((-1, 1.0), (1, -1.0)):
        k = at(crowd, 102.5, lane)
        pose = board.ground.network.lane_pose("1", lane, 102.5)  # type: ignore[union-attr]
        steep = SimpleNamespace(x=pose.x, y=pose.y, z=3.0, h=pose.h, pitch=0.1, roll=0.02)
        network = SimpleNamespace(lane_pose=lambda *place, steep=steep: steep)
        with monkeypatch.context() as patched:
            patched.setattr(board.ground, "network", network)
            entity: Any = Put()
            patched.setattr(board, "admit", lambda entity: None)
            crowd._put(entity, k, 2.0)
        assert (entity.sense, entity.pitch, entity.roll, entity.z) == (sign, sign * 0.1, sign * 0.02, 3.0)


def test_nobody_comes_where_there_is_no_spot_or_no_room_or_too_many(
    board: Storyboard, monkeypatch: pytest.MonkeyPatch
) -> None:
    crowd, flow = Crowd(board), Flow()
    assert not crowd.admit(flow, "f", vehicle("car"), only(crowd), lambda: 5.0)
    assert not crowd.admit(flow, "f", vehicle("car"), only(crowd, at(crowd, 502.5)), lambda: 5.0)
    monkeypatch.setattr(crowds, "MOST", 2)
    far = [only(crowd, at(crowd, s)) for s in (102.5, 202.5, 302.5)]
    assert [crowd.admit(flow, "f", vehicle("car"), each, lambda: 5.0) for each in far] == [True, True, False]
    assert crowds.TRIES == 20
    assert list(crowd.members) == ["f-1", "f-2"]


@pytest.mark.parametrize("other_speed", [0.0, 12.0, -12.0])
@pytest.mark.parametrize("ahead", [True, False])
def test_in_a_lane_there_is_room_behind_and_before_everybody_for_the_faster_of_two(
    board: Storyboard, ahead: bool, other_speed: float
) -> None:
    """Both bodies (half of 4.5 m and of 5 m, and how far each middle is off its reference point), the distance of a
    standstill, and the time to the next one at the greater speed."""
    crowd, car, me = Crowd(board), board.entities["A"], Crowd(board)
    assert me is not crowd
    assert crowd.admit(Flow(), "f", vehicle("car"), only(crowd, at(crowd, 102.5)), lambda: 5.0)
    new = crowd.members["f-1"][0]
    car.speed = other_speed
    bodies = 2.25 + 2.5 + (2.25 - 0.9) + 1.5
    need = bodies + STANDSTILL + HEADWAY * max(5.0, abs(other_speed))
    k = at(crowd, 702.5)
    for more, free in ((0.01, True), (-0.01, False)):
        x = 702.5 + (need + more) * (1.0 if ahead else -1.0)
        car.put(x, -1.75, 0.0, 0.0)
        assert crowd._free(k, new, 5.0) is free
    car.put(702.5, -5.25, 0.0, 0.0)  # beside, in the other lane
    assert crowd._free(k, new, 5.0)
    car.put(702.5, -1.75, 0.0, 0.0)
    car.active = False
    assert crowd._free(k, new, 5.0)


def test_someone_on_another_road_only_must_not_be_touched(board: Storyboard) -> None:
    crowd, car = Crowd(board), board.entities["A"]
    assert crowd.admit(Flow(), "f", vehicle("car"), only(crowd, at(crowd, 102.5)), lambda: 5.0)
    new = crowd.members["f-1"][0]
    k = at(crowd, 702.5)
    bodies = 2.25 + 2.5 + (2.25 - 0.9) + 1.5
    for apart, free in ((bodies + 0.01, True), (bodies - 0.01, False)):
        car.put(702.5 + 0.6 * apart, -1.75 + 0.8 * apart, 0.0, 0.0)
        car.road, car.tracked = "another", True
        assert crowd._free(k, new, 5.0) is free


def test_flows_are_asked_every_tenth_of_a_second_and_at_once_when_one_is_added(board: Storyboard) -> None:
    crowd, first, second = Crowd(board), Flow(), Flow()
    crowd.add("first", first)
    for board.time in (1.0, 1.05, 1.1, 1.19):
        crowd.come_and_go()
    assert first.times == [1.0, 1.1]
    crowd.add("second", second)
    crowd.come_and_go()
    assert (first.times[2:], second.times) == ([1.19], [1.19])
    crowd.stop("second")
    board.time = 2.0
    crowd.come_and_go()
    assert (first.times[-1], second.times) == (2.0, [1.19])
    crowd.stop("")
    board.time = 3.0
    crowd.come_and_go()
    assert first.times[-1] == 2.0


def test_who_is_at_the_end_of_the_road_or_gone_is_dismissed(board: Storyboard) -> None:
    crowd = Crowd(board)
    for s in (102.5, 202.5, 302.5):
        assert crowd.admit(Flow(), "f", vehicle("car"), only(crowd, at(crowd, s)), lambda: 5.0)
    entities = [entity for entity, _, _ in crowd.members.values()]
    entities[0].end_of_road, entities[1].active = True, False
    crowd.come_and_go()
    assert list(crowd.members) == ["f-3"]
    assert list(board.entities) == ["A", "f-3"]


def test_the_crowd_drives_by_the_law_of_following_and_never_backwards(board: Storyboard) -> None:
    crowd, car = Crowd(board), board.entities["A"]
    crowd.drive(0.1)  # nobody is there
    assert crowd.admit(Flow(), "f", vehicle("car"), only(crowd, at(crowd, 472.5)), lambda: 8.0)
    entity = crowd.members["f-1"][0]
    entity.speed, car.speed = 6.0, 2.0
    gap = (500.0 + 1.5 - 2.5) - (472.5 + 4.5 - 0.9)
    crowd.drive(0.1)
    assert entity.speed == pytest.approx(6.0 + 0.1 * following(6.0, 8.0, gap, 2.0))
    assert entity.speed < 6.0 + 0.1 * following(6.0, 8.0, math.inf, 0.0)
    entity.speed = 0.05
    car.put(478.0, -1.75, 0.0, 0.0)
    crowd.drive(0.1)
    assert entity.speed == 0.0
