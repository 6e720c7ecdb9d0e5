"""How a trajectory is followed, step by step: by its own time, or with the speed of who follows it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard.actions.trajectory import FollowTrajectory, _positions, _stamped
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.places import Place

from .conftest import Make


def spot(x: float, y: float, h: float | None = None, z: float | None = None) -> Any:
    return model.WorldPosition(x=x, y=y, h=h, z=z)


def vertices(*points: Any, times: tuple[float | None, ...] = ()) -> Any:
    stamps = times or (None,) * len(points)
    return model.Polyline(tuple(model.Vertex(p, t) for p, t in zip(points, stamps, strict=True)))


# 3 m along x, then 4 m along y
BEND = (spot(10.0, 0.0), spot(13.0, 0.0), spot(13.0, 4.0))
RELATIVE = model.Timing("relative", 1.0, 0.0)


class Scene:
    """An entity at 9, 0 on flat ground without a road, and a trajectory for it."""

    def __init__(self, make: Make, shape: Any, timing: Any = None, *, speed: float = 2.0, cut: float = 0.0,
                 closed: bool = False, follow: bool = False, time: float = 0.0) -> None:  # fmt: skip
        board = make(A=[], without_road=True)
        self.entity: Entity = board.entities["A"]
        self.entity.put(9.0, 0.0, 0.0, 0.0)
        self.entity.speed = self.entity.speed_before = speed
        self.warned: list[str] = []
        self.board = SimpleNamespace(time=time, network=None, ground=board.ground, entities=board.entities,
                                     warn=lambda element, kind, text: self.warned.append(kind))  # fmt: skip
        mode = SimpleNamespace(following_mode="follow" if follow else "position")
        self.element = SimpleNamespace(
            trajectory=SimpleNamespace(shape=shape, closed=closed), time_reference=timing or model.Untimed(),
            trajectory_following_mode=mode, initial_distance_offset=cut,
        )  # fmt: skip
        self.runner = FollowTrajectory(self.element, self.entity, self.board)  # type: ignore[arg-type]

    def place(self) -> Any:
        return pytest.approx((self.entity.x, self.entity.y), abs=1e-9)


def test_one_is_put_on_the_first_point_which_is_no_motion(make: Make) -> None:
    scene = Scene(make, vertices(*BEND))
    scene.entity.vx = scene.entity.vy = 5.0
    assert scene.runner.domains == ("lateral",)
    assert scene.runner.start() is False
    assert scene.place() == (10.0, 0.0)
    assert scene.entity.vx == scene.entity.vy == 0.0
    short = Scene(make, vertices(spot(10.0, 0.0), spot(10.5, 0.0)))
    assert short.runner.start() is False  # half a metre is a way
    near = Scene(make, vertices(spot(9.0005, 0.0), spot(12.0, 0.0)))
    near.entity.vx = 2.0
    near.runner.start()
    assert near.entity.vx == 2.0  # a jump of half a millimetre is none


def test_without_timing_it_is_followed_at_the_own_speed_and_what_is_left_of_a_step_goes_straight_on(make: Make) -> None:
    scene = Scene(make, vertices(*BEND), speed=2.0)
    scene.runner.start()
    assert scene.runner.step(1.0) is False
    assert scene.place() == (12.0, 0.0)
    assert (scene.entity.vx, scene.entity.vy) == pytest.approx((2.0, 0.0))
    assert scene.runner.step(1.0) is False
    assert scene.place() == (13.0, 1.0)
    assert scene.entity.moved
    assert scene.entity.travelled == pytest.approx(4.0)
    assert scene.runner.axis() == pytest.approx((0.5 * math.pi, 0.0))
    assert not scene.entity.end_of_road
    assert scene.runner.step(2.0) is True
    assert scene.place() == (13.0, 5.0)  # 3 m were left of the trajectory, one more straight on
    assert scene.entity.travelled == pytest.approx(8.0)
    assert scene.entity.end_of_road
    onto_a_road = Scene(make, vertices(*BEND), speed=9.0)
    onto_a_road.runner.start()
    onto_a_road.board.network = object()
    assert onto_a_road.runner.step(1.0) is True
    assert not onto_a_road.entity.end_of_road  # from here on it keeps a lane


def test_the_end_is_reached_exactly_in_spite_of_rounding(make: Make) -> None:
    scene = Scene(make, vertices(*BEND), speed=0.7)
    scene.runner.start()
    assert [scene.runner.step(1.0) for _ in range(10)] == [False] * 9 + [True]
    assert scene.place() == (13.0, 4.0)


def test_who_stands_goes_nowhere_and_who_turns_back_leaves_at_the_beginning(make: Make) -> None:
    scene = Scene(make, vertices(*BEND), speed=0.0)
    scene.runner.start()
    assert scene.runner.step(1.0) is False
    assert scene.place() == (10.0, 0.0)
    scene.entity.speed = scene.entity.speed_before = 2.0
    scene.runner.step(1.0)
    scene.entity.speed = scene.entity.speed_before = -1.0
    assert scene.runner.step(1.0) is False
    assert scene.place() == (11.0, 0.0)
    scene.entity.speed = scene.entity.speed_before = -3.0
    assert scene.runner.step(1.0) is True
    assert scene.place() == (8.0, 0.0)


def test_who_reverses_from_the_start_goes_the_same_way_rear_first(make: Make) -> None:
    scene = Scene(make, vertices(*BEND), speed=-2.0)
    scene.runner.start()
    assert math.cos(scene.entity.h) == pytest.approx(-1.0)
    assert scene.runner.step(1.0) is False
    assert scene.place() == (12.0, 0.0)
    assert scene.entity.vx == pytest.approx(2.0)
    scene.runner.step(1.0)
    assert scene.place() == (13.0, 1.0)
    scene.entity.speed = scene.entity.speed_before = -4.0
    assert scene.runner.step(1.0) is True
    assert scene.place() == (13.0, 5.0)


def test_the_acceleration_is_the_change_of_speed_and_who_came_later_in_the_file_acts_later(make: Make) -> None:
    scene = Scene(make, vertices(*BEND))
    scene.runner.start()
    scene.entity.speed_before, scene.entity.speed = 1.0, 3.0
    scene.entity.lateral_order, scene.entity.longitudinal_order = 1, 2
    scene.runner.step(0.5)
    assert scene.entity.ax == pytest.approx(4.0)
    assert scene.entity.late
    scene.entity.lateral_order = 2
    scene.runner.step(0.5)
    assert not scene.entity.late


def test_a_closed_one_goes_round(make: Make) -> None:
    square = vertices(spot(0.0, 0.0), spot(4.0, 0.0), spot(4.0, 4.0), spot(0.0, 4.0))
    scene = Scene(make, square, closed=True, speed=9.0)
    scene.runner.start()
    assert [scene.runner.step(1.0) for _ in range(2)] == [False, False]
    assert scene.place() == (2.0, 0.0)  # 18 m of a way of 16 m
    scene.entity.speed = scene.entity.speed_before = -3.0
    assert scene.runner.step(1.0) is False
    assert scene.place() == (0.0, 1.0)


def test_a_cut_begins_farther_on_and_a_single_point_is_over_at_once(make: Make) -> None:
    scene = Scene(make, vertices(*BEND), cut=5.0)
    assert scene.runner.start() is False
    assert scene.place() == (13.0, 2.0)
    beyond = Scene(make, vertices(*BEND), cut=99.0)
    beyond.runner.start()
    assert beyond.place() == (13.0, 4.0)
    assert Scene(make, vertices(BEND[0])).runner.start() is True


# --- by time

TIMED = vertices(*BEND, times=(1.0, 4.0, 6.0))  # 1 m/s, then 2 m/s


def test_with_timing_the_time_stamps_give_the_way_and_the_speed(make: Make) -> None:
    scene = Scene(make, TIMED, RELATIVE, speed=0.0)
    assert scene.runner.domains == ("longitudinal", "lateral")
    assert scene.runner.start() is False
    assert scene.place() == (10.0, 0.0)
    assert scene.runner.step(1.0) is False
    assert (scene.entity.speed, scene.place()) == (0.0, (10.0, 0.0))
    assert scene.runner.step(2.0) is False
    assert (scene.entity.speed, scene.entity.ax, scene.place()) == (pytest.approx(1.0), pytest.approx(0.5), (12.0, 0.0))
    assert scene.runner.step(2.0) is False
    assert (scene.entity.speed, scene.place()) == (pytest.approx(1.5), (13.0, 2.0))
    assert scene.runner.step(0.5) is False
    assert scene.entity.speed == pytest.approx(2.0)
    assert scene.runner.step(0.5) is True
    assert (scene.entity.speed, scene.place()) == (pytest.approx(2.0), (13.0, 4.0))
    assert scene.entity.travelled == pytest.approx(7.0)


def test_beyond_the_last_stamp_one_goes_straight_on_at_the_last_speed(make: Make) -> None:
    scene = Scene(make, TIMED, RELATIVE)
    scene.runner.start()
    scene.runner.step(5.0)
    scene.entity.speed = 3.0
    assert scene.runner.step(1.5) is True
    assert scene.place() == (13.0, 4.0 + 0.5 * 3.0)


@pytest.mark.parametrize(
    ("timing", "time", "place"),
    [
        (("relative", 1.0, 0.0), 50.0, (12.0, 0.0)),  # the stamp 3
        (("relative", 1.0, 1.0), 50.0, (11.0, 0.0)),  # the stamp 2
        (("relative", 0.5, 0.0), 50.0, (13.0, 4.0)),  # the stamp 6
        (("relative", 2.0, 1.0), 50.0, (10.0, 0.0)),  # the stamp 1
        (("absolute", 1.0, 0.0), 2.0, (13.0, 2.0)),  # the stamp 5
        (("absolute", 2.0, 2.0), 7.0, (13.0, 0.0)),  # the stamp 4
    ],
)
def test_a_stamp_is_the_time_less_the_offset_over_the_scale(
    make: Make, timing: tuple[Any, float, float], time: float, place: tuple[float, float]
) -> None:
    scene = Scene(make, TIMED, model.Timing(*timing), time=time)
    scene.runner.start()
    scene.runner.step(3.0)
    assert scene.place() == place


def test_of_a_cut_one_relative_time_begins_there_and_absolute_time_at_the_places_own(make: Make) -> None:
    relative = Scene(make, TIMED, model.Timing("relative", 2.0, 0.0), cut=2.0)
    relative.runner.start()
    assert relative.place() == (12.0, 0.0)
    shown = []
    for _ in range(3):
        relative.runner.step(1.0)
        shown.append((relative.entity.x, relative.entity.y))
    # the clock begins at 2 * (3 - 1) = 4 s, the stamp 2; the cut holds it until the stamp 3
    assert shown == [pytest.approx(each, abs=1e-9) for each in ((12.0, 0.0), (12.0, 0.0), (12.5, 0.0))]
    absolute = Scene(make, TIMED, model.Timing("absolute", 1.0, 0.0), cut=2.0, time=0.0)
    absolute.runner.start()
    absolute.runner.step(2.0)
    assert absolute.place() == (12.0, 0.0)
    absolute.runner.step(2.0)
    assert absolute.place() == (13.0, 0.0)


def test_timing_of_a_trajectory_without_stamps_is_warned_of(make: Make) -> None:
    scene = Scene(make, vertices(*BEND), RELATIVE)
    scene.runner.start()
    assert scene.warned == ["no-time-stamps"]
    assert scene.runner.domains == ("lateral",)
    silent = Scene(make, TIMED, RELATIVE)
    silent.runner.start()
    Scene(make, vertices(*BEND)).runner.start()
    assert silent.warned == []
    assert Scene(make, TIMED).runner.domains == ("lateral",)


def test_headings_that_look_back_make_it_reverse(make: Make) -> None:
    back = vertices(spot(10.0, 0.0, math.pi), spot(13.0, 0.0, math.pi), times=(0.0, 3.0))
    scene = Scene(make, back, RELATIVE)
    scene.runner.start()
    scene.runner.step(1.0)
    assert (scene.entity.speed, scene.place()) == (pytest.approx(-1.0), (11.0, 0.0))
    up = vertices(spot(10.0, 0.0, 0.5 * math.pi), spot(10.0, 3.0, 0.5 * math.pi), times=(0.0, 3.0))
    scene = Scene(make, up, RELATIVE)
    scene.runner.start()
    scene.runner.step(1.0)
    assert (scene.entity.speed, scene.place()) == (pytest.approx(1.0), (10.0, 1.0))
    ignoring = Scene(make, back, RELATIVE)
    ignoring.entity.properties = SimpleNamespace(get={"ignoreHeadingForTrajMotion": "true"}.get)  # type: ignore[assignment]
    ignoring.runner.start()
    ignoring.runner.step(1.0)
    assert ignoring.entity.speed == pytest.approx(1.0)
    later = vertices(spot(10.0, 0.0, 0.0), spot(12.0, 0.0, 0.0), spot(9.0, 0.0, 0.0), times=(0.0, 2.0, 5.0))
    turning = Scene(make, later, RELATIVE)
    turning.runner.start()
    turning.runner.step(1.0)
    assert turning.entity.speed == pytest.approx(1.0)
    turning.runner.step(3.9)  # back, and still looking ahead
    assert turning.entity.speed == pytest.approx(-(1.0 + 2.9) / 3.9)


def test_whether_it_reverses_is_told_by_the_heading_with_which_it_begins(make: Make) -> None:
    """Round to the left, and back: the last vertex looks the other way than the first piece goes."""
    there, back = (spot(10.0, 0.0, 0.0), spot(13.0, 0.0, 0.0)), (spot(13.0, 4.0, math.pi), spot(10.0, 4.0, math.pi))
    scene = Scene(make, vertices(*there, *back), speed=2.0)
    scene.runner.start()
    assert scene.runner.step(2.0) is False
    assert scene.place() == (13.0, 1.0)


def test_uphill_one_looks_up_and_backwards_down(make: Make) -> None:
    hill = vertices(spot(10.0, 0.0, z=0.0), spot(13.0, 0.0, z=4.0), times=(0.0, 5.0))
    scene = Scene(make, hill)
    scene.runner.start()
    rise = math.atan2(4.0, scene.runner._course.length)  # type: ignore[union-attr]
    assert scene.entity.pitch == pytest.approx(-rise)
    assert scene.runner.axis() == pytest.approx((0.0, -rise))
    back = Scene(make, hill, speed=-2.0)
    back.runner.start()
    assert back.entity.pitch == pytest.approx(rise)
    flat = Scene(make, vertices(*BEND))
    flat.entity.pitch = 0.3
    flat.runner.start()
    assert flat.entity.pitch == 0.3  # the ground's


def test_where_others_are_in_the_coordinates_of_the_trajectory(make: Make) -> None:
    scene = Scene(make, vertices(*BEND))
    scene.runner.start()
    scene.runner.step(0.5)  # 1 m on
    assert scene.runner.way_to(Place(12.0, 5.0, 0.0, 0.0)) == pytest.approx(6.0)  # to the end
    assert scene.runner.way_to(Place(10.2, -1.0, 0.0, 0.0)) == pytest.approx(0.8)
    scene.runner.step(0.5)
    assert scene.runner.way_to(Place(10.2, -1.0, 0.0, 0.0)) == pytest.approx(1.8)
    assert scene.runner.beside(11.0, 0.5) == pytest.approx((-1.0, 0.5, 0.0))
    assert scene.runner.beside(8.0, 0.5) == pytest.approx((-4.0, 0.5, 0.0))
    s, t, h = scene.runner.beside(12.0, 6.5)
    assert (s, t, h) == pytest.approx((7.0 + 2.5 - 2.0, 1.0, 0.5 * math.pi))
    assert scene.runner.beside(13.5, 2.0) == pytest.approx((3.0, -0.5, 0.5 * math.pi))


def test_an_external_one_is_asked_for_points_times_and_what_is_left(make: Make) -> None:
    scene = Scene(make, TIMED, RELATIVE)
    kind, what, left = scene.runner.ask()
    assert (kind, left) == ("trajectory", 6.0)
    assert [point[:2] for point in what["points"]] == [(10.0, 0.0), (13.0, 0.0), (13.0, 4.0)]
    assert what["times"] == (1.0, 4.0, 6.0)
    untimed = Scene(make, TIMED)
    assert untimed.runner.ask()[1]["times"] is None
    assert untimed.runner.ask()[2] == 0.0
    over = Scene(make, TIMED, model.Timing("absolute", 1.0, 0.0), time=8.0)
    assert over.runner.ask()[2] == 0.0


@pytest.mark.parametrize("missing", [None, 0, 1, 2])
def test_a_shape_has_time_stamps_if_all_its_points_have_one(missing: int | None) -> None:
    times: list[Any] = [1.0, 2.0, 3.0]
    if missing is not None:
        times[missing] = None
    whole = missing is None
    assert _stamped(vertices(*BEND, times=tuple(times))) is whole
    points = tuple(model.ControlPoint(p, t) for p, t in zip(BEND, times, strict=True))
    assert _stamped(model.Nurbs(2, points, ())) is whole
    arc = model.Clothoid(0.1, 0.0, 5.0, BEND[0], times[0], times[2])
    assert _stamped(arc) is (missing not in (0, 2))
    pieces = tuple(model.ClothoidSplineSegment(0.1, 0.1, 5.0, 0.0, t, p) for t, p in zip(times[:2], BEND, strict=False))
    spline = model.ClothoidSpline(pieces, times[2])
    assert _stamped(spline) is whole
    assert _positions(vertices(*BEND)) == _positions(model.Nurbs(2, points, ())) == list(BEND)
    assert _positions(arc) == [BEND[0]]
    assert _positions(spline) == list(BEND[:2])
    assert _positions(model.ClothoidSpline((model.ClothoidSplineSegment(0.1, 0.1, 5.0),), 1.0)) == []
