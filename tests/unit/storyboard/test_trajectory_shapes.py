"""The shapes of trajectories, piece by piece: which headings, times and curves the numbers of a file mean."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard import trajectories
from openscenario.storyboard.places import Place
from openscenario.storyboard.trajectories import Course, _between, _de_boor, _peaks, course

BEZIER = (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)  # knots of one quadratic piece


def at(x: float, y: float, h: float | None = None, z: float = 0.0) -> model.WorldPosition:
    return model.WorldPosition(x=x, y=y, z=z, h=h)


def resolve(position: model.Position) -> Place:
    """0.3 rad where a position has no heading: what a road would say."""
    assert isinstance(position, model.WorldPosition)
    h = 0.3 if position.h is None else position.h
    return Place(position.x, position.y, position.z or 0.0, h, has_heading=position.h is not None)


def drawn(shape: model.Shape, *, closed: bool = False, start: Place | None = None, follow: float | None = None,
          turning: str | None = None) -> Course:  # fmt: skip
    trajectory = model.Trajectory(name="t", closed=closed, shape=shape)
    return course(trajectory, resolve, start, follow=follow, turning=turning)


def polyline(*positions: model.WorldPosition, times: Sequence[float | None] | None = None) -> model.Polyline:
    stamps = times or [None] * len(positions)
    return model.Polyline(tuple(model.Vertex(position=p, time=t) for p, t in zip(positions, stamps, strict=True)))


SQUARE = (at(0, 0), at(10, 0), at(10, 10), at(0, 10))


def test_without_headings_those_of_the_pieces_are_taken() -> None:
    """The last one keeps the heading it is reached with; whatever the road says does not count."""
    line = drawn(polyline(*SQUARE))
    assert line.h == pytest.approx([0.0, math.pi / 2.0, math.pi, math.pi])
    assert not line.explicit


@pytest.mark.parametrize(
    ("times", "back"),
    [
        ((0.0, 2.0, 4.0, 6.0), 8.0),  # 5 m/s on the last leg, 10 m back
        ((0.0, 2.0, 4.0, 5.0), 6.0),  # 10 m/s
        ((0.0, 2.0, 4.0, 4.0), 4.0 + 10.0 * 4.0 / 30.0),  # no time for the last leg: 30 m in 4 s on all
        ((1.0, 1.0, 1.0, 1.0), 1.0),  # no time at all
    ],
)
def test_a_closed_line_comes_back_at_the_speed_of_its_last_leg(times: Sequence[float], back: float) -> None:
    line = drawn(polyline(*SQUARE, times=times), closed=True)
    assert line.length == pytest.approx(40.0)
    assert line.end_time == pytest.approx(back)


def test_a_closed_line_whose_last_leg_stands_comes_back_at_its_mean_speed() -> None:
    """10 m in 2 s, 2 s of rest, 10 m back."""
    line = drawn(polyline(at(0, 0), at(10, 0), at(10, 0), times=(0.0, 2.0, 4.0)), closed=True)
    assert line.end_time == pytest.approx(4.0 + 10.0 * 4.0 / 10.0)


def test_a_closed_line_without_all_time_stamps_has_none() -> None:
    assert drawn(polyline(*SQUARE, times=(0.0, None, 4.0, 6.0)), closed=True).t is None


def test_given_headings_are_kept() -> None:
    line = drawn(polyline(at(0, 0, 0.5), at(10, 0), at(20, 0, 0.0)))
    assert line.h == pytest.approx([0.5, 0.0, 0.0])
    assert line.explicit


def test_a_heading_of_a_later_vertex_makes_a_line_not_explicit() -> None:
    assert not drawn(polyline(at(0, 0), at(10, 0, 0.5))).explicit


def test_vertices_that_coincide_keep_the_heading_before_them() -> None:
    """Before the first piece of any length that is the heading of the first place."""
    assert drawn(polyline(at(0, 0), at(0, 0), at(0, 5), at(0, 5))).h == pytest.approx([0.3] + 3 * [math.pi / 2.0])
    assert drawn(polyline(at(7, 8))).h == [0.3]
    shortly = drawn(polyline(at(0, 0), at(0, 1e-10), at(5, 1e-10)))
    assert shortly.h == pytest.approx([0.3, 0.0, 0.0])


def test_the_shortest_pieces_have_a_heading_already() -> None:
    assert drawn(polyline(at(0, 0), at(0, 1e-8), at(5, 1e-8))).h[0] == pytest.approx(math.pi / 2.0)


def test_a_closed_line_returns_to_its_first_vertex() -> None:
    closed = drawn(polyline(*SQUARE, times=(0.0, 1.0, 2.0, 3.0)), closed=True)
    assert closed.length == pytest.approx(40.0)
    assert closed.at(35.0)[:2] == pytest.approx((0.0, 5.0))
    assert closed.t == pytest.approx([0.0, 1.0, 2.0, 3.0, 4.0])
    opened = drawn(polyline(*SQUARE, times=(0.0, 1.0, 2.0, 3.0)))
    assert opened.length == pytest.approx(30.0)
    assert opened.t == [0.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize(("last", "length"), [(at(0, 0), 20.0), (at(0, 0.5), 20.0), (at(0, 1e-7), 20.0)])
def test_a_closed_line_whose_ends_meet_is_not_closed_again(last: model.WorldPosition, length: float) -> None:
    closed = drawn(polyline(at(0, 0), at(10, 0), last), closed=True)
    assert closed.length == pytest.approx(length + (0.5 if last.y == 0.5 else 0.0), abs=0.02)
    assert len(closed.s) == (4 if last.y == 0.5 else 3)


@pytest.mark.parametrize("middle", [at(3, 4), at(3, 0), at(0, 9)])
def test_a_line_is_closed_from_its_last_vertex_to_its_first_one(middle: model.WorldPosition) -> None:
    """One above the other or beside it, 4 m apart; or at the same place, wherever the vertex between them is."""
    there = math.hypot(middle.x, middle.y) + math.hypot(middle.x, middle.y - 4.0)
    assert drawn(polyline(at(0, 0), middle, at(0, 4)), closed=True).length == pytest.approx(there + 4.0)
    aside = math.hypot(middle.x, middle.y) + math.hypot(middle.x - 4.0, middle.y)
    assert drawn(polyline(at(0, 0), middle, at(4, 0)), closed=True).length == pytest.approx(aside + 4.0)
    meeting = drawn(polyline(at(0, 0), middle, at(0, 0)), closed=True)
    assert (len(meeting.s), meeting.length) == (3, pytest.approx(2.0 * math.hypot(middle.x, middle.y)))


def test_a_single_vertex_is_closed_already() -> None:
    assert drawn(polyline(at(3, 4)), closed=True).length == 0.0


def test_one_vertex_without_time_makes_a_line_untimed() -> None:
    assert drawn(polyline(at(0, 0), at(5, 0), at(10, 0), times=(0.0, None, 2.0))).t is None


@pytest.mark.parametrize(
    ("follow", "turning", "headings", "middle"),
    [
        (None, None, True, 0.0),  # mode `position`: near the vertices
        (1.0, None, True, 0.5),  # mode `follow`: evenly
        (1.0, None, False, 0.0),  # ... only where headings are given
        (None, "segment", True, 0.5),
        (1.0, "corner", True, 0.0),
        (1.0, "none", True, 0.0),
    ],
)
def test_how_a_heading_changes_between_vertices(
    follow: float | None, turning: str | None, headings: bool, middle: float
) -> None:
    """From 0 to 1 rad over 10 m."""
    ends = (at(0, 0, 0.0), at(10, 0, 1.0)) if headings else (at(0, 0), at(10, 0))
    line = drawn(polyline(*ends), follow=follow, turning=turning)
    assert line.at(5.0)[3] == pytest.approx(middle)


@pytest.mark.parametrize(("turning", "before"), [("corner", 0.25), ("none", 0.0), ("segment", 0.9)])
def test_a_metre_before_a_vertex(turning: str, before: float) -> None:
    line = drawn(polyline(at(0, 0, 0.0), at(10, 0, 1.0), at(20, 0, 1.0)), turning=turning)
    assert line.at(9.0)[3] == pytest.approx(before)


HERE = at(1, 2, 0.4, 3.0)


def clothoid(curvature: float, change: float, length: float, **more: Any) -> model.Clothoid:
    return model.Clothoid(
        curvature=curvature, curvature_prime=change, length=length, position=at(1, 2, 0.4, 3.0), **more
    )


def test_a_circle_of_any_curvature_is_exact() -> None:
    """Chord and midpoint are those of the arc: no error of the sampling is left."""
    r, h, length = 7.0, 0.4, 15.0
    x, y, z, end = drawn(clothoid(1.0 / r, 0.0, length)).at(length)
    assert (x, y) == pytest.approx((1.0 + r * (math.sin(h + length / r) - math.sin(h)),
                                    2.0 - r * (math.cos(h + length / r) - math.cos(h))), abs=1e-9)  # fmt: skip
    assert (z, end) == pytest.approx((3.0, h + length / r))


def test_a_clothoid_is_fresnel_s_integral() -> None:
    """From no curvature, u = c L^2 / 2: x is the sum of (-1)^k u^(2k) L / (2k)! (4k + 1), y that of the odd terms."""
    length, change = 30.0, 0.004
    shape = model.Clothoid(curvature=0.0, curvature_prime=change, length=length, position=at(0, 0, 0.0))
    u = 0.5 * change * length**2
    x = sum((-1) ** k * u ** (2 * k) * length / (math.factorial(2 * k) * (4 * k + 1)) for k in range(20))
    y = sum((-1) ** k * u ** (2 * k + 1) * length / (math.factorial(2 * k + 1) * (4 * k + 3)) for k in range(20))
    assert drawn(shape).at(length) == pytest.approx((x, y, 0.0, u), abs=1e-4)


def test_a_clothoid_is_sampled_each_decimetre() -> None:
    steps = drawn(clothoid(0.1, 0.01, 3.05)).s
    assert len(steps) == 32
    assert max(b - a for a, b in pairwise(steps)) <= 0.1
    assert len(drawn(clothoid(0.0, 0.0, 0.01)).s) == 2


@pytest.mark.parametrize("length", [0.05, 0.15, 3.0])
def test_however_short_a_clothoid_is_its_times_are_those_of_its_ends(length: float) -> None:
    times = drawn(clothoid(0.1, 0.0, length, start_time=2.0, stop_time=6.0)).t
    assert times is not None
    assert (times[0], times[-1]) == pytest.approx((2.0, 6.0))


@pytest.mark.parametrize("missing", ["start_time", "stop_time"])
def test_a_clothoid_with_one_time_is_untimed(missing: str) -> None:
    assert drawn(clothoid(0.0, 0.0, 5.0, **{missing: 1.0})).t is None


def segment(first: float, last: float, length: float, **more: Any) -> model.ClothoidSplineSegment:
    return model.ClothoidSplineSegment(curvature_start=first, curvature_end=last, length=length, **more)


def test_a_spline_s_curvature_changes_evenly_from_start_to_end() -> None:
    """The heading is the integral: 10 m from 0.02 to 0.06 are 0.4 rad, after 5 m (0.02 + 0.04) / 2 * 5."""
    spline = drawn(model.ClothoidSpline(segments=(segment(0.02, 0.06, 10.0, position_start=at(0, 0, 0.1)),)))
    assert spline.at(5.0)[3] == pytest.approx(0.1 + 0.15, abs=1e-6)
    assert spline.at(10.0)[3] == pytest.approx(0.1 + 0.4)


def test_a_spline_goes_on_turned_by_the_offset_of_the_heading() -> None:
    spline = drawn(model.ClothoidSpline(segments=(
        segment(0.0, 0.0, 10.0, position_start=at(5, 1, 0.0, 2.0)),
        segment(0.0, 0.0, 4.0, h_offset=math.pi / 2.0),
    )))  # fmt: skip
    assert spline.at(14.0) == pytest.approx((15.0, 5.0, 2.0, math.pi / 2.0))


def test_a_spline_jumps_to_a_segment_s_own_position() -> None:
    spline = drawn(model.ClothoidSpline(segments=(
        segment(0.0, 0.0, 10.0, position_start=at(0, 0, 0.0)),
        segment(0.0, 0.0, 10.0, position_start=at(10, 3, 0.5, 1.0)),
    )))  # fmt: skip
    assert spline.length == pytest.approx(23.0)
    end = spline.at(23.0)
    assert end == pytest.approx((10.0 + 10.0 * math.cos(0.5), 3.0 + 10.0 * math.sin(0.5), 1.0, 0.5))


def test_a_spline_without_any_place_begins_at_the_origin() -> None:
    spline = drawn(model.ClothoidSpline(segments=(segment(0.0, 0.0, 10.0),)))
    assert spline.at(0.0) == (0.0, 0.0, 0.0, 0.0)
    assert spline.at(10.0) == pytest.approx((10.0, 0.0, 0.0, 0.0))
    start = Place(1.0, 2.0, 3.0, math.pi)
    assert drawn(model.ClothoidSpline(segments=(segment(0.0, 0.0, 10.0),)), start=start).at(10.0) == pytest.approx(
        (-9.0, 2.0, 3.0, math.pi)
    )


def test_a_segment_without_length_is_a_place() -> None:
    spline = drawn(model.ClothoidSpline(segments=(segment(0.1, 0.3, 0.0), segment(0.0, 0.0, 5.0))))
    assert spline.at(5.0) == pytest.approx((5.0, 0.0, 0.0, 0.0))


def test_each_segment_lasts_until_the_next_begins() -> None:
    """10 m from 1 s to 3 s, 6 m from 3 s to 4 s."""
    timed = (segment(0.0, 0.0, 10.0, time_start=1.0), segment(0.0, 0.0, 6.0, time_start=3.0))
    spline = drawn(model.ClothoidSpline(segments=timed, time_end=4.0))
    assert (spline.start_time, spline.end_time) == (1.0, 4.0)
    assert [spline.s_at(t) for t in (1.5, 3.0, 3.5, 4.0)] == pytest.approx([2.5, 10.0, 13.0, 16.0])
    assert drawn(model.ClothoidSpline(segments=timed)).t is None
    half = (timed[0], segment(0.0, 0.0, 6.0))
    assert drawn(model.ClothoidSpline(segments=half, time_end=4.0)).t is None


def test_influence_is_greatest_where_a_basis_function_has_its_peak() -> None:
    """Quadratic Bernstein polynomials: (1 - u)^2, 2 u (1 - u), u^2 have theirs at 0, 1/2 and 1."""
    assert _peaks(BEZIER, 2, 3, [0.0, 0.25, 0.5, 0.75, 1.0]) == [0.0, 0.5, 1.0]


@pytest.mark.parametrize(
    ("places", "last"),
    [([0.0, 0.4, 0.8], 0.4), ([0.0, 0.2, 0.55, 1.0], 0.2), ([0.0, 0.1, 0.45, 1.0], 0.45), ([0.0, 0.4, 0.5002], 0.4)],
)
def test_between_places_a_peak_counts_for_the_one_before(places: list[float], last: float) -> None:
    """The middle one's peak at 1/2 lies behind 0.4 and 0.45, and before 0.55: there it has been greater."""
    assert _peaks(BEZIER, 2, 3, places)[1] == last


@pytest.mark.parametrize(
    ("u", "value"), [(-1.0, 5.0), (0.0, 5.0), (0.5, 6.0), (1.0, 7.0), (1.5, 8.5), (2.0, 10.0), (3.0, 4.0), (9.0, 4.0)]
)
def test_values_are_interpolated_between_places(u: float, value: float) -> None:
    """Those at one place step there; outside the outermost ones hold."""
    assert _between([0.0, 1.0, 2.0, 2.0, 3.0], [5.0, 7.0, 10.0, 10.0, 4.0], u) == pytest.approx(value)
    assert _between([0.0, 2.0, 2.0, 3.0], [1.0, 2.0, 8.0, 9.0], 2.0) == 8.0


def cox(i: int, degree: int, knots: Sequence[float], u: float) -> float:
    """Basis function by the recursion of Cox and de Boor."""
    if degree == 0:
        return 1.0 if knots[i] <= u < knots[i + 1] else 0.0
    rise, fall = knots[i + degree] - knots[i], knots[i + degree + 1] - knots[i + 1]
    up = (u - knots[i]) / rise * cox(i, degree - 1, knots, u) if rise else 0.0
    down = (knots[i + degree + 1] - u) / fall * cox(i + 1, degree - 1, knots, u) if fall else 0.0
    return up + down


@pytest.mark.parametrize("u", [2.0, 2.3, 3.0, 3.9])
@pytest.mark.parametrize("knots", [(0, 1, 2, 3, 4, 5, 6), (2, 2, 2, 3, 4, 4, 4), (1, 2, 2, 3, 4, 4, 5)])
def test_a_point_of_a_nurbs_is_the_weighted_mean_by_its_basis(knots: tuple[float, ...], u: float) -> None:
    """Sum of N_i w_i P_i over the sum of N_i w_i, of second degree, on even and on repeated knots."""
    points = [(0.0, 1.0, 5.0, 1.0), (2.0, -1.0, 4.0, 2.0), (5.0, 3.0, 3.0, 0.5), (9.0, 2.0, 1.0, 1.5)]
    basis = [cox(i, 2, knots, u) for i in range(4)]
    whole = sum(n * p[3] for n, p in zip(basis, points, strict=True))
    expected = [sum(n * p[3] * p[k] for n, p in zip(basis, points, strict=True)) / whole for k in range(3)]
    control = [(x * w, y * w, z * w, w) for x, y, z, w in points]
    assert _de_boor(control, [float(k) for k in knots], 2, u) == pytest.approx(expected)


def nurbs(*points: tuple[model.WorldPosition, float, float | None], knots: Sequence[float] = BEZIER) -> model.Nurbs:
    control = tuple(model.ControlPoint(position=p, weight=w, time=t) for p, w, t in points)
    return model.Nurbs(order=3, control_points=control, knots=tuple(model.Knot(value=k) for k in knots))


def test_a_nurbs_has_the_heights_and_weights_of_its_points() -> None:
    """At u = 1/2 the basis is 1/4, 1/2, 1/4: with weights 1, 3, 1 the middle counts (3/2) / 2."""
    curve = drawn(
        nurbs((at(0, 0, 0.0, 0.0), 1.0, None), (at(10, 0, 0.0, 8.0), 3.0, None), (at(20, 0, 0.0, 0.0), 1.0, None))
    )
    assert curve.at(10.0)[:3] == pytest.approx((10.0, 0.0, 6.0))


def test_headings_of_a_nurbs_are_those_of_its_tangent() -> None:
    """Quadratic Bezier (0, 0), (10, 0), (10, 10): the tangent turns as atan2(u, 1 - u)."""
    curve = drawn(nurbs((at(0, 0), 1.0, None), (at(10, 0), 1.0, None), (at(10, 10), 1.0, None)))
    last = len(curve.h) - 1
    for i in (50, 100, 150):
        u = i / last
        assert curve.h[i] == pytest.approx(math.atan2(u, 1.0 - u), abs=1e-4)
        assert curve.x[i] == pytest.approx(20.0 * u - 10.0 * u * u)
        assert curve.y[i] == pytest.approx(10.0 * u * u)
    assert (curve.h[0], curve.h[-1]) == pytest.approx((0.0, math.pi / 2.0), abs=5e-3)


def test_a_nurbs_turns_the_short_way_where_headings_change_sign() -> None:
    """Out to the left, back below: the tangent passes pi, no sample looks to the right."""
    curve = drawn(nurbs((at(0, 0), 1.0, None), (at(-10, 5), 1.0, None), (at(-20, 0), 1.0, None)))
    assert all(math.cos(h) < 0.0 for h in curve.h)


def test_a_nurbs_has_ten_samples_a_metre_of_its_polygon_within_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    """7.5 m: 8 parts of ten samples."""
    shape = nurbs((at(0, 0), 1.0, None), (at(3, 0), 1.0, None), (at(7.5, 0), 1.0, None))
    assert len(drawn(shape).s) == 81
    monkeypatch.setattr(trajectories, "MOST_SAMPLES", 40)
    assert len(drawn(shape).s) == 41


def test_a_nurbs_is_timed_if_all_of_its_points_are() -> None:
    assert drawn(nurbs((at(0, 0), 1.0, 0.0), (at(5, 0), 1.0, None), (at(10, 0), 1.0, 2.0))).t is None
    timed = drawn(nurbs((at(0, 0), 1.0, 1.0), (at(5, 0), 1.0, 2.0), (at(10, 0), 1.0, 4.0)))
    assert (timed.start_time, timed.end_time) == (1.0, 4.0)


def test_the_time_of_a_nurbs_changes_evenly_over_each_metre() -> None:
    """A straight Bezier with even points is even in u, too: half of the 7 m in 2 s, the other half in 1 s."""
    curve = drawn(nurbs((at(0, 0), 1.0, 0.0), (at(3.5, 0), 1.0, 2.0), (at(7, 0), 1.0, 3.0)))
    assert [curve.s_at(t) for t in (0.5, 1.0, 2.0, 2.5)] == pytest.approx([0.875, 1.75, 3.5, 5.25], abs=0.01)
