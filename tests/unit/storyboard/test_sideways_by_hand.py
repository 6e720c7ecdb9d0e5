"""Lane changes and offsets step by step on a road that is written down here: which lane, how far, how long."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard.actions.lateral import NEAR, LaneChange, LaneOffset
from openscenario.storyboard.unsupported import Unsupported

from .bodies import car

WIDE = 3.5  # m, each lane; lane -1 is right of the middle, lane 1 left of it


class Board:
    """A straight road along x with two lanes to each side; `asked` notes what the ground was told."""

    def __init__(self, reading: str = "standard", **entities: Any) -> None:
        self.reading, self.entities = reading, entities
        self.warned: list[tuple[str, str]] = []
        self.driven: list[float] = []
        self.network: Any = SimpleNamespace(lane_t=self._lane_t)
        self.ground: Any = SimpleNamespace(network=self.network, track=self._track, drive=self._drive,
                                           position=self._position, turned=self._turned,
                                           lane_onwards=lambda there, here: (there.lane, True))  # fmt: skip
        self.tracked: list[str] = []

    def _lane_t(self, road: str, lane: int, s: float) -> float:
        if lane == 0 or abs(lane) > 2:
            return math.nan
        return math.copysign((abs(lane) - 0.5) * WIDE, lane)

    def _track(self, entity: Any) -> bool:
        entity.tracked = True
        self.tracked.append(entity.name)
        return True

    def _drive(self, entity: Any, way: float) -> None:
        self.driven.append(way)

    def _position(self, entity: Any) -> Any:
        self._track(entity)
        return SimpleNamespace(lane=entity.lane, t=self._lane_t("1", entity.lane, 0.0) + entity.offset)

    def _turned(self, ours: Any, theirs: Any) -> float:
        return 1.0

    def warn(self, element: Any, code: str, text: str) -> None:
        self.warned.append((code, text))


def driving(name: str = "A", lane: int = -1, *, offset: float = 0.0, speed: float = 10.0, sense: float = 1.0) -> Any:
    entity = car(name)
    entity.speed = entity.speed_before = speed
    entity.road, entity.lane, entity.s, entity.offset, entity.sense = "1", lane, 12.34, offset, sense
    return entity


def changer(entity: Any, board: Any, target: Any, shape: Any = "linear", dimension: Any = "time", value: float = 2.0,
            offset: float = 0.0) -> LaneChange:  # fmt: skip
    dynamics = model.TransitionDynamics(dynamics_shape=shape, dynamics_dimension=dimension, value=value)
    element: Any = SimpleNamespace(
        lane_change_action_dynamics=dynamics, lane_change_target=target, target_lane_offset=offset
    )
    return LaneChange(element, entity, board)


def lane(value: int) -> Any:
    return model.AbsoluteTargetLane(value=value)


def beside(name: str, value: int) -> Any:
    return model.RelativeTargetLane(entity_ref=name, value=value)


# --- lane changes


@pytest.mark.parametrize(
    ("own", "sense", "by", "wanted"),
    [(-2, 1.0, 1, -1), (-1, 1.0, 1, 1), (-1, 1.0, -1, -2), (1, -1.0, 1, -1), (2, -1.0, 1, 1), (1, -1.0, -1, 2),
     (-2, 1.0, 0, -2)],
)  # fmt: skip
def test_lanes_are_counted_to_the_left_of_the_one_that_is_named(own: int, sense: float, by: int, wanted: int) -> None:
    other = driving("B", own, sense=sense)
    board = Board(B=other)
    assert changer(driving(), board, beside("B", by))._lane() == wanted
    assert "B" in board.tracked
    assert changer(driving(), Board(), lane(2))._lane() == 2


def test_from_the_start_on_it_keeps_the_target_lane_and_its_offset_is_what_is_left() -> None:
    entity, board = driving(offset=0.2), Board()
    entity.twist = 0.3
    action = changer(entity, board, lane(-2), offset=0.5)
    assert not action.start()
    assert (entity.lane, entity.offset, entity.twist) == (-2, pytest.approx(3.7), 0.0)
    change = action._change
    assert (change.start, change.target, change.span) == pytest.approx((3.7, 0.5, 2.0))


def test_who_faces_the_other_way_counts_to_its_own_left() -> None:
    entity = driving(lane=1, sense=-1.0, offset=0.2)
    action = changer(entity, Board(), lane(2), offset=0.5)
    assert not action.start()
    assert entity.offset == pytest.approx(0.2 - 3.5)
    assert (action._change.start, action._change.target) == pytest.approx((3.3, -0.5))


def test_a_lane_that_is_not_there_is_warned_of() -> None:
    entity, board = driving(), Board()
    assert changer(entity, board, lane(-3)).start()
    assert board.warned == [
        ("no-such-lane", "A: no lane -3 on road 1 at s = 12.3 m: no lane change"),
    ]  # fmt: skip
    assert (entity.lane, entity.offset) == (-1, 0.0)


def test_a_step_is_in_its_lane_at_once_and_so_is_who_is_there_already() -> None:
    entity, board = driving(), Board()
    entity.drift = 0.2
    assert changer(entity, board, lane(-2), "step", offset=0.5).start()
    assert (entity.lane, entity.offset, entity.drift, entity.shifted) == (-2, pytest.approx(0.5), 0.0, True)
    assert board.driven == [0.0]
    still = driving(offset=0.5)
    assert changer(still, board, lane(-1), offset=0.5).start()


def test_over_a_time_what_goes_to_the_side_does_not_go_ahead() -> None:
    """3.5 m in 2 s at 10 m/s: 1.75 m/s to the right, so it heads asin(0.175) to the right."""
    entity = driving()
    action = changer(entity, Board(), lane(-2))
    action.start()
    assert not action.step(0.5)
    assert entity.offset == pytest.approx(3.5 - 0.875)
    assert entity.drift == pytest.approx(-math.asin(0.175))
    assert entity.along == pytest.approx(math.sqrt(1.0 - 0.175**2))
    assert [action.step(0.5) for _ in range(3)] == [False, False, True]
    assert (entity.offset, entity.drift, entity.twist) == (0.0, 0.0, 0.0)


def test_over_a_distance_the_distance_is_that_along_the_lane() -> None:
    """3.5 m in 35 m is 1 in 10: of 5 m of way 5 / sqrt(1.01) are along the lane, and a tenth of that to the side."""
    entity = driving()
    action = changer(entity, Board(), lane(-2), dimension="distance", value=35.0)
    action.start()
    assert not action.step(0.5)
    along = 5.0 / math.sqrt(1.01)
    assert action._change.elapsed == pytest.approx(along)
    assert entity.offset == pytest.approx(3.5 - 0.1 * along)
    assert entity.drift == pytest.approx(-math.atan(0.1))


def test_who_is_too_slow_for_the_shape_goes_to_the_side_with_all_of_its_way() -> None:
    entity = driving(speed=1.0)
    action = changer(entity, Board(), lane(-2))
    action.start()
    assert not action.step(0.5)
    assert entity.offset == pytest.approx(3.5 - 0.5)
    assert entity.drift == pytest.approx(-0.5 * math.pi, abs=1e-5)


def test_who_stands_does_not_change_lanes() -> None:
    entity = driving(speed=0.0)
    action = changer(entity, Board(), lane(-2))
    action.start()
    assert not action.step(0.5)
    assert (entity.offset, action._change.elapsed) == (3.5, 0.0)
    entity.speed = entity.speed_before = 0.5 * NEAR
    assert not action.step(0.5)
    assert action._change.elapsed == 0.0
    entity.speed = entity.speed_before = 2.0 * NEAR
    action.step(0.5)
    assert action._change.elapsed > 0.0


def test_who_came_later_in_the_file_acts_later_and_who_was_put_elsewhere_is_tracked_again() -> None:
    entity, board = driving(), Board()
    action = changer(entity, board, lane(-2))
    action.start()
    board.tracked.clear()
    entity.tracked = True
    for lateral, longitudinal, late in ((1, 2, True), (2, 1, False), (1, 1, False)):
        entity.lateral_order, entity.longitudinal_order = lateral, longitudinal
        action.step(0.01)
        assert entity.late is late
    assert board.tracked == []
    entity.tracked = False
    action.step(0.01)
    assert board.tracked == ["A"]
    action.stop()
    assert entity.drift == 0.0


@pytest.mark.parametrize(("left", "close"), [(0.9e-6, True), (1.1e-6, False), (-0.9e-6, True), (-1.1e-6, False)])
def test_a_millionth_of_a_metre_before_its_end_a_change_is_over(left: float, close: bool) -> None:
    action = changer(driving(), Board(), lane(-2))
    action.start()
    action._change.value = action._change.target + left
    assert action._close() is close
    action._change.value, action._change.done = 1.0, True
    assert action._close()


def test_without_a_road_nobody_moves_to_the_side() -> None:
    board = Board()
    board.network = None
    with pytest.raises(Unsupported, match="no road network"):
        changer(driving(), board, lane(-2))
    with pytest.raises(Unsupported, match="no road network"):
        offsetter(driving(), board, 1.0)
    with pytest.raises(Unsupported, match="no entity of this name"):
        changer(driving(), Board(), beside("B", 1))


# --- offsets


def offsetter(entity: Any, board: Any, value: float, other: str = "", shape: Any = "cubic", limit: float | None = 1.0,
              *, continuous: bool = False) -> LaneOffset:  # fmt: skip
    target = model.RelativeTargetLaneOffset(entity_ref=other, value=value) if other else \
        model.AbsoluteTargetLaneOffset(value=value)  # fmt: skip
    dynamics = SimpleNamespace(max_lateral_acc=limit, dynamics_shape=shape)
    element: Any = SimpleNamespace(continuous=continuous, lane_offset_target=target,
                                   lane_offset_action_dynamics=dynamics)  # fmt: skip
    return LaneOffset(element, entity, board)


@pytest.mark.parametrize(
    ("shape", "limit", "span"),
    [("cubic", 1.5, 2.0), ("sinusoidal", 0.5, math.pi), ("linear", 1.5, 2.0), ("cubic", 0.0, math.inf)],
)
def test_an_offset_takes_as_long_as_its_acceleration_lets_it(shape: str, limit: float, span: float) -> None:
    """From 0.25 to 1.25 m: sqrt(6 / 1.5) s, and pi sqrt(1 / (2 x 0.5)) s."""
    action = offsetter(driving(offset=0.25), Board(), 1.25, shape=shape, limit=limit)
    assert not action.start()
    assert action._change.span == pytest.approx(span)
    assert (action._change.start, action._change.target) == (0.25, 1.25)


@pytest.mark.parametrize(("shape", "limit"), [("cubic", None), ("step", 1.0)])
def test_without_a_limit_it_is_there_at_once(shape: str, limit: float | None) -> None:
    entity = driving(offset=0.25)
    assert offsetter(entity, Board(), 1.25, shape=shape, limit=limit).start()
    assert entity.offset == 1.25
    assert not offsetter(driving(), Board(), 1.25, shape=shape, limit=limit, continuous=True).start()


def test_an_offset_is_that_of_the_road_whichever_way_one_faces() -> None:
    action = offsetter(driving(offset=0.25, sense=-1.0), Board(), 1.25)
    action.start()
    assert (action._change.start, action._change.target) == (-0.25, -1.25)


@pytest.mark.parametrize(
    ("reading", "continuous", "other", "goes_on", "warned"),
    [
        ("standard", False, "", False, False),
        ("standard", True, "", True, False),
        ("esmini", True, "", False, True),
        ("esmini", False, "", False, False),
        ("esmini", True, "B", True, False),
        ("standard", True, "B", True, False),
    ],
)
def test_which_offset_goes_on_once_it_is_reached(
    reading: str, continuous: bool, other: str, goes_on: bool, warned: bool
) -> None:
    """In esmini's reading only one from another entity, and it is said where that cuts something short."""
    board = Board(reading, B=driving("B"))
    action = offsetter(driving(), board, 0.5, other, continuous=continuous)
    assert action._goes_on is goes_on
    assert action._ends() is not goes_on
    assert [code for code, _ in board.warned] == (["reading-offset-ended"] if warned else [])


@pytest.mark.parametrize(("sense", "wanted"), [(1.0, 0.5 + 3.5 + 1.0), (-1.0, 0.5 + 3.5 - 1.0)])
def test_an_offset_from_another_one_is_to_its_left(sense: float, wanted: float) -> None:
    """It is a lane to the left with 0.5 m of offset, and 1 m to its left is meant."""
    other = driving("B", 1, offset=0.5, sense=sense)
    entity = driving(lane=-1, offset=0.2)
    assert offsetter(entity, Board(B=other), 1.0, "B")._wanted() == pytest.approx(wanted)
    assert offsetter(entity, Board(), 1.0)._wanted() == 1.0


@pytest.mark.parametrize(
    ("name", "continuous", "target"), [("B", True, 1.5), ("B", False, 1.0), ("A", True, 1.0), ("A", False, 1.0)]
)
def test_who_is_followed_moves_the_target_and_an_offset_from_oneself_is_taken_once(
    name: str, continuous: bool, target: float
) -> None:
    """1 m to the left of who is named, who then goes half a metre to the left."""
    entity, other = driving(), driving("B")
    action = offsetter(entity, Board(A=entity, B=other), 1.0, name, limit=1.5, continuous=continuous)
    assert not action.start()
    entity.offset = other.offset = 0.5
    assert not action.step(0.1)
    assert action._change.target == target


def test_it_moves_along_its_shape_from_where_the_step_begins() -> None:
    """A cubic over 2 s and 1 m: after 1 s half of it, at 0.75 m/s; at 10 m/s it heads atan(0.075)."""
    entity = driving()
    action = offsetter(entity, Board(), 1.0, limit=1.5)
    action.start()
    entity.twist = 0.3
    assert not action.step(1.0)
    assert (entity.offset, entity.drift, entity.twist) == (0.0, 0.0, 0.0)
    assert not action.step(0.5)
    assert entity.offset == pytest.approx(0.5)
    assert entity.drift == pytest.approx(math.atan(0.075))
    assert entity.shifted
    assert not action.step(0.5)
    assert action.step(0.5)
    assert (entity.offset, entity.drift) == (1.0, 0.0)


def test_who_stands_is_moved_without_a_heading() -> None:
    entity = driving(speed=0.0)
    action = offsetter(entity, Board(), 1.0, limit=1.5)
    action.start()
    action.step(1.0)
    action.step(0.5)
    assert (entity.offset, entity.drift) == (pytest.approx(0.5), 0.0)


def test_what_is_asked_of_an_external_one() -> None:
    assert offsetter(driving(), Board(), 1.5).ask() == ("lane_offset", {"offset": 1.5}, 0.0)
    kind, values, lasts = changer(driving(), Board(), lane(-2), offset=0.25).ask()
    assert (kind, values, lasts) == ("lane_change", {"lane": -2, "offset": 0.25, "duration": 2.0}, 2.0)
