"""Reference line shapes against closed forms and adaptive quadrature."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import fresnel

from openscenario.road.geometry import evaluate
from openscenario.road.shapes import arc_rows, param_rows, poly3_rows, row_end, spiral_rows

from road_files import arc, geometry, network, road, spiral  # isort: skip


def at(rows: list[list[float]], s: float) -> tuple[float, float, float, float, float]:
    return evaluate(np.array(rows), 0, len(rows), s)


def test_arc_ends_where_the_circle_does() -> None:
    quarter = 50.0 * math.pi / 2.0
    x, y, heading, kappa, _ = at(arc_rows(0.0, 0.0, 0.0, 0.0, quarter, 0.02), quarter)
    assert (x, y, heading, kappa) == pytest.approx((50.0, 50.0, math.pi / 2.0, 0.02), abs=1e-12)


def test_arc_of_vanishing_curvature_is_a_line() -> None:
    x, y, _, _, _ = at(arc_rows(0.0, 1.0, 2.0, 0.0, 100.0, 1e-14), 100.0)
    assert (x, y) == pytest.approx((101.0, 2.0), abs=1e-9)


def test_spiral_from_straight_is_the_fresnel_integral() -> None:
    length, end = 200.0, 0.05
    scale = math.sqrt(math.pi * length / end)
    sine, cosine = fresnel(length / scale)
    x, y, heading, _, _ = at(spiral_rows(0.0, 0.0, 0.0, 0.0, length, 0.0, end), length)
    assert (x, y) == pytest.approx((scale * cosine, scale * sine), abs=1e-9)
    assert heading == pytest.approx(0.5 * end * length, abs=1e-12)


@settings(deadline=None)
@given(
    start=st.floats(-0.2, 0.2),
    end=st.floats(-0.2, 0.2),
    length=st.floats(1.0, 150.0),
    share=st.floats(0.0, 1.0),
)
def test_spiral_of_any_curvatures_agrees_with_quadrature(start: float, end: float, length: float, share: float) -> None:
    s = share * length
    rate = (end - start) / length

    def angle(u: float) -> float:
        return start * u + 0.5 * rate * u * u

    x, y, heading, kappa, _ = at(spiral_rows(0.0, 0.0, 0.0, 0.0, length, start, end), s)
    expected_x = quad(lambda u: math.cos(angle(u)), 0.0, s, epsabs=1e-11, epsrel=1e-12, limit=500)[0]
    expected_y = quad(lambda u: math.sin(angle(u)), 0.0, s, epsabs=1e-11, epsrel=1e-12, limit=500)[0]
    assert (x, y) == pytest.approx((expected_x, expected_y), abs=1e-9)
    assert (heading, kappa) == pytest.approx((angle(s), start + rate * s), abs=1e-10)


def test_polynomial_is_run_through_by_arc_length() -> None:
    # a parabola v = u^2 / 2 has the arc length (u sqrt(1 + u^2) + asinh u) / 2
    u = 3.0
    length = 0.5 * (u * math.sqrt(1.0 + u * u) + math.asinh(u))
    rows = param_rows(0.0, 0.0, 0.0, 0.0, length, (0.0, u, 0.0, 0.0, 0.0, 0.0, 0.5 * u * u, 0.0), 1.0)
    half = 1.7
    s = 0.5 * (half * math.sqrt(1.0 + half * half) + math.asinh(half))
    x, y, heading, kappa, rate = at(rows, s)
    assert (x, y) == pytest.approx((half, 0.5 * half * half), abs=1e-6)
    assert heading == pytest.approx(math.atan(half), abs=1e-6)
    assert kappa == pytest.approx((1.0 + half * half) ** -1.5, rel=1e-6)
    assert rate == pytest.approx(-3.0 * half * (1.0 + half * half) ** -3.0, rel=1e-5)


def test_polynomial_of_another_length_ends_with_its_element() -> None:
    rows = param_rows(0.0, 0.0, 0.0, 0.0, 60.0, (0.0, 50.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 1.0)
    assert at(rows, 60.0)[0] == pytest.approx(50.0, abs=1e-9)


def test_poly3_ends_at_its_arc_length() -> None:
    u = 3.0
    length = 0.5 * (u * math.sqrt(1.0 + u * u) + math.asinh(u))
    rows = poly3_rows(0.0, 0.0, 0.0, 0.0, length, (0.0, 0.0, 0.5, 0.0))
    assert at(rows, length)[:2] == pytest.approx((u, 0.5 * u * u), abs=1e-6)


@pytest.mark.parametrize(
    "rows",
    [
        arc_rows(0.0, 1.0, 2.0, 0.3, 40.0, -0.03),
        spiral_rows(0.0, 1.0, 2.0, 0.3, 90.0, 0.1, -0.1),
        param_rows(0.0, 1.0, 2.0, 0.3, 31.0, (0.0, 30.0, 0.0, 0.0, 0.0, 0.0, 5.0, 2.0), 1.0),
    ],
    ids=["arc", "spiral", "paramPoly3"],
)
def test_plain_end_of_a_row_is_the_compiled_one(rows: list[list[float]]) -> None:
    s = rows[-1][0] + rows[-1][4]
    assert row_end(rows[-1]) == pytest.approx(at(rows, s)[:3], abs=1e-9)


def test_line_spiral_arc_spiral_line_is_smooth(tmp_path: Path) -> None:
    # each element begins where theory says the one before ends; the reader finds no gap, heading has no step
    parts, s, x, y, heading = "", 0.0, 0.0, 0.0, 0.0
    for length, start, end in ((50.0, 0.0, 0.02), (40.0, 0.02, 0.02), (50.0, 0.02, 0.0)):
        shape = arc(start) if start == end else spiral(start, end)
        parts += geometry(s, x, y, heading, length, shape)
        rows = spiral_rows(s, x, y, heading, length, start, end)
        x, y, heading = row_end(rows[-1])
        s += length
    net = network(tmp_path, road("1", parts, s))
    before, after = net.road_pose("1", 50.0 - 1e-7, 0.0), net.road_pose("1", 50.0 + 1e-7, 0.0)
    assert after.h - before.h == pytest.approx(0.0, abs=1e-6)
    assert net.road_pose("1", s, 0.0).h == pytest.approx(0.02 * (25.0 + 40.0 + 25.0), abs=1e-12)
