"""Trajectories against closed forms: straight pieces, circle arcs, a NURBS quarter circle."""

from __future__ import annotations

import math

import pytest

from openscenario import model
from openscenario.storyboard.places import Place
from openscenario.storyboard.trajectories import Course, course


def at(x: float, y: float, h: float = 0.0) -> model.WorldPosition:
    return model.WorldPosition(x=x, y=y, h=h)


def resolve(position: model.Position) -> Place:
    assert isinstance(position, model.WorldPosition)
    return Place(position.x, position.y, 0.0, position.h or 0.0, has_heading=bool(position.h))


def along(shape: model.Shape, closed: bool = False) -> Course:
    return course(model.Trajectory(name="t", closed=closed, shape=shape), resolve)


def polyline(*vertices: tuple[float | None, float, float]) -> model.Polyline:
    return model.Polyline(vertices=tuple(model.Vertex(position=at(x, y), time=t) for t, x, y in vertices))


def test_polyline_length_is_that_of_its_pieces() -> None:
    assert along(polyline((None, 0, 0), (None, 3, 4), (None, 3, 10))).length == pytest.approx(11.0)


def test_polyline_goes_straight_between_vertices() -> None:
    x, y, _, h = along(polyline((None, 0, 0), (None, 30, 40))).at(20.0)
    assert (x, y) == (pytest.approx(12.0), pytest.approx(16.0))
    assert h == pytest.approx(math.atan2(4, 3))


def test_polyline_beyond_its_end_stands_at_the_end() -> None:
    assert along(polyline((None, 0, 0), (None, 10, 0))).at(99.0)[:2] == (10.0, 0.0)


def test_polyline_turns_half_way_at_a_vertex() -> None:
    corner = along(polyline((None, 0, 0), (None, 10, 0), (None, 10, 10)))
    assert corner.at(10.0)[3] == pytest.approx(math.pi / 4.0)
    assert corner.at(5.0)[3] == pytest.approx(0.0)
    assert corner.at(15.0)[3] == pytest.approx(math.pi / 2.0)


def test_given_headings_are_interpolated_the_short_way() -> None:
    shape = model.Polyline(vertices=(model.Vertex(position=at(0, 0, 3.0)), model.Vertex(position=at(10, 0, -3.0))))
    trajectory = model.Trajectory(name="t", closed=False, shape=shape)
    assert math.cos(course(trajectory, resolve, follow=1.0).at(5.0)[3]) == pytest.approx(-1.0)


def test_who_follows_has_constant_acceleration_between_time_stamps() -> None:
    """From 10 m/s: 10 m in 2 s need v = 0 at the end, a = -5 m/s^2; then 9 m in 3 s from rest, a = 2 m/s^2."""
    shape = polyline((0.0, 0, 0), (2.0, 10, 0), (5.0, 19, 0))
    follow = course(model.Trajectory(name="t", closed=False, shape=shape), resolve, follow=10.0)
    assert follow.s_at(1.0) == pytest.approx(10.0 - 0.5 * 5.0)
    assert follow.s_at(3.0) == pytest.approx(10.0 + 0.5 * 2.0)
    assert along(shape).s_at(1.0) == pytest.approx(5.0)  # mode `position`: constant speed


def test_a_nurbs_point_s_time_is_where_its_influence_is_greatest() -> None:
    """Quadratic Bezier over 20 m: the influence 2 u (1 - u) of the middle point is greatest at u = 1/2, at x = 10."""
    points = [((0, 0), 0.0), ((10, 5), 1.0), ((20, 0), 10.0)]
    control = tuple(model.ControlPoint(position=at(*place), time=time) for place, time in points)
    knots = tuple(model.Knot(value=value) for value in (0.0, 0.0, 0.0, 1.0, 1.0, 1.0))
    curve = along(model.Nurbs(order=3, control_points=control, knots=knots))
    assert curve.at(curve.s_at(1.0))[0] == pytest.approx(10.0, abs=0.5)


@pytest.mark.parametrize(("reach", "parameter"), [(6.0, 6 / 13), (9.0, 9 / 19)])
def test_a_nurbs_point_s_time_counts_from_the_whole_metre_before(reach: float, parameter: float) -> None:
    """A control polygon of 2 * reach m has 2 * reach + 1 parts; the middle, at u = 1/2, lies between two of them."""
    control = tuple(
        model.ControlPoint(position=at(x, 0), time=time) for x, time in ((0.0, 0.0), (reach, 1.0), (2.0 * reach, 10.0))
    )
    knots = tuple(model.Knot(value=value) for value in (0.0, 0.0, 0.0, 1.0, 1.0, 1.0))
    curve = along(model.Nurbs(order=3, control_points=control, knots=knots))
    assert curve.at(curve.s_at(1.0))[0] == pytest.approx(2.0 * reach * parameter, abs=1e-6)


def test_closed_polyline_returns_to_its_start() -> None:
    square = along(polyline((None, 0, 0), (None, 10, 0), (None, 10, 10), (None, 0, 10)), closed=True)
    assert square.length == pytest.approx(40.0)
    assert square.at(40.0)[:2] == (0.0, 0.0)


@pytest.mark.parametrize(("x", "y"), [(0.0, 5.0), (3.0, 0.0), (-2.0, 7.0)])
def test_what_ends_where_it_began_is_closed_already(x: float, y: float) -> None:
    """Wherever it begins; a corner of 10 m by 10 m and its diagonal."""
    corners = ((None, x, y), (None, x + 10, y), (None, x + 10, y + 10), (None, x, y))
    path = along(polyline(*corners), closed=True)
    assert path.length == pytest.approx(20.0 + math.hypot(10.0, 10.0))
    assert len(path.x) == len(along(polyline(*corners)).x)


def test_time_stamps_give_the_way() -> None:
    timed = along(polyline((0.0, 0, 0), (2.0, 10, 0), (3.0, 40, 0)))
    assert timed.s_at(1.0) == pytest.approx(5.0)
    assert timed.s_at(2.5) == pytest.approx(25.0)
    assert timed.s_at(9.0) == pytest.approx(40.0)


def test_clothoid_of_constant_curvature_is_a_circle() -> None:
    radius = 20.0
    quarter = 0.5 * math.pi * radius
    shape = model.Clothoid(curvature=1.0 / radius, curvature_prime=0.0, length=quarter, position=at(0, 0))
    x, y, _, h = along(shape).at(quarter)
    assert (x, y, h) == (pytest.approx(radius, abs=1e-3), pytest.approx(radius, abs=1e-3), pytest.approx(math.pi / 2))


def test_clothoid_heading_follows_the_integral_of_curvature() -> None:
    shape = model.Clothoid(curvature=0.01, curvature_prime=0.002, length=30.0, position=at(0, 0, 0.5))
    assert along(shape).at(30.0)[3] == pytest.approx(0.5 + 0.01 * 30.0 + 0.5 * 0.002 * 30.0**2)


def test_nurbs_of_three_weighted_points_is_an_exact_quarter_circle() -> None:
    # Piegl and Tiller, The NURBS Book, example 7.1: weights 1, cos(45 deg), 1
    points = ((10.0, 0.0, 1.0), (10.0, 10.0, math.sqrt(0.5)), (0.0, 10.0, 1.0))
    shape = model.Nurbs(
        order=3,
        control_points=tuple(model.ControlPoint(position=at(x, y), weight=w) for x, y, w in points),
        knots=tuple(model.Knot(value=k) for k in (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)),
    )
    arc = along(shape)
    assert arc.length == pytest.approx(0.5 * math.pi * 10.0, rel=1e-4)
    for share in (0.1, 0.37, 0.5, 0.9):
        x, y, _, h = arc.at(share * arc.length)
        assert math.hypot(x, y) == pytest.approx(10.0, abs=2e-3)
        assert math.cos(h - math.atan2(y, x) - math.pi / 2.0) == pytest.approx(1.0, abs=1e-3)


def test_clothoid_spline_goes_on_where_its_segment_ends() -> None:
    segment = model.ClothoidSplineSegment
    shape = model.ClothoidSpline(
        segments=(
            segment(curvature_start=0.0, curvature_end=0.0, length=10.0, position_start=at(5, 0)),
            segment(curvature_start=0.0, curvature_end=0.1, length=10.0),
        )
    )
    assert along(shape).at(10.0)[0] == pytest.approx(15.0)
    assert along(shape).at(20.0)[3] == pytest.approx(0.5)


def test_clothoid_spline_without_position_starts_where_the_entity_is() -> None:
    shape = model.ClothoidSpline(
        segments=(model.ClothoidSplineSegment(curvature_start=0.0, curvature_end=0.0, length=10.0),)
    )
    path = course(model.Trajectory(name="t", closed=False, shape=shape), resolve, Place(3.0, 4.0, 0.0, math.pi / 2))
    assert path.at(10.0)[:2] == (pytest.approx(3.0), pytest.approx(14.0))


@pytest.mark.parametrize(("start", "stop", "ends"), [(2.0, 6.0, 6.0), (None, None, None)])
def test_a_clothoid_with_times_is_passed_evenly_between_them(
    start: float | None, stop: float | None, ends: float | None
) -> None:
    """ASAM OpenSCENARIO 1.3, Clothoid: startTime and stopTime; 20 m of a straight one from 2 s to 6 s, 5 m/s."""
    shape = model.Clothoid(position=at(0, 0), curvature=0.0, curvature_prime=0.0, length=20.0, start_time=start,
                           stop_time=stop)  # fmt: skip
    found = along(shape)
    assert found.length == pytest.approx(20.0)
    if ends is None:
        assert found.t is None
    else:
        assert (found.start_time, found.end_time) == (2.0, ends)
        assert found.s_at(3.0) == pytest.approx(5.0)
