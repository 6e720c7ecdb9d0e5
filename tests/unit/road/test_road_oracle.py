"""Roads made at random of everything that shapes a lane, against a second implementation by numerical integration.

The oracle shares nothing with the product: it integrates headings and arc lengths on a dense grid and turns vectors by
rotation matrices. Bound: 1 cm, 1 mrad; what is reached is below 0.1 mm.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from road_files import cubic, geometry, lane, network, road, section

Cubic = tuple[float, float, float, float, float]  # s, a, b, c, d
Line = Callable[[float], tuple[float, float, float]]  # s -> x, y, heading
FINE = 20_001  # points of the oracle's grids


def value(records: list[Cubic], s: float, slope: bool = False) -> float:
    """A profile, or its derivative, at s."""
    held = [record for record in records if record[0] <= s]
    if not held:
        return 0.0
    start, a, b, c, d = held[-1]
    u = s - start
    return b + 2 * c * u + 3 * d * u * u if slope else a + b * u + c * u * u + d * u**3


def along(kind: str, numbers: list[float], length: float, normalized: bool) -> Callable[[float], tuple[float, ...]]:
    """Displacement (u, v) and turning after a way of ds metres on one geometry, by integration on a dense grid."""
    if kind in ("line", "arc", "spiral"):
        way = np.linspace(0.0, length, FINE)
        first, last = {"line": (0.0, 0.0), "arc": (numbers[0],) * 2, "spiral": (numbers[0], numbers[-1])}[kind]
        turn = first * way + 0.5 * (last - first) / length * way**2
        u1, v1 = np.cos(turn), np.sin(turn)
        step = way[1] - way[0]
        us = np.concatenate([[0.0], np.cumsum(0.5 * (u1[1:] + u1[:-1]) * step)])
        vs = np.concatenate([[0.0], np.cumsum(0.5 * (v1[1:] + v1[:-1]) * step)])
    else:
        p = np.linspace(0.0, 1.0 if normalized else 1.3 * length, FINE)
        of = np.polynomial.Polynomial
        up, vp = of([0.0, 1.0]) if kind == "poly3" else of(numbers[:4]), of(numbers[-4:])
        us, vs, u1, v1 = up(p), vp(p), up.deriv()(p), vp.deriv()(p)
        speed = np.hypot(u1, v1)
        way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(p))])
        turn = np.unwrap(np.arctan2(v1, u1))
    return lambda ds: (np.interp(ds, way, us), np.interp(ds, way, vs), np.interp(ds, way, turn))


def reference_line(rng: random.Random) -> tuple[str, float, Line]:
    """Some geometries end to end: their text, their length, and where the oracle has them."""
    text, s, x, y, h = "", 0.0, rng.uniform(-500, 500), rng.uniform(-500, 500), rng.uniform(-3, 3)
    pieces = []
    for kind in rng.sample(["line", "arc", "spiral", "poly3", "paramPoly3", "paramPoly3"], 4):
        length, normalized, numbers, shape = rng.uniform(20.0, 80.0), rng.random() < 0.5, [0.0], "<line/>"
        if kind == "arc":
            numbers = [rng.uniform(-0.03, 0.03)]
            shape = f'<arc curvature="{numbers[0]!r}"/>'
        elif kind == "spiral":
            numbers = [rng.uniform(-0.04, 0.04), rng.uniform(-0.04, 0.04)]
            shape = f'<spiral curvStart="{numbers[0]!r}" curvEnd="{numbers[1]!r}"/>'
        elif kind == "poly3":
            normalized, numbers = False, [0.0, 0.0, rng.uniform(-3e-3, 3e-3), rng.uniform(-3e-5, 3e-5)]
            shape = "<poly3 " + " ".join(f'{name}="{n!r}"' for name, n in zip("abcd", numbers, strict=True)) + "/>"
        elif kind == "paramPoly3":
            scale = length if normalized else 1.0
            bend = [0.0, 0.0, rng.uniform(-2e-3, 2e-3) * scale**2, rng.uniform(-2e-5, 2e-5) * scale**3]
            numbers = [0.0, scale, 0.0, 0.0, *bend]
            names = [letter + axis for axis in "UV" for letter in "abcd"]
            values = " ".join(f'{name}="{n!r}"' for name, n in zip(names, numbers, strict=True))
            last = 1.0 if normalized else length
            grid = np.linspace(0.0, last, FINE)
            speed = np.hypot(scale, np.polynomial.Polynomial(bend).deriv()(grid))
            true = float(np.sum(0.5 * (speed[1:] + speed[:-1])) * (grid[1] - grid[0]))
            if not normalized and abs(true - length) > 2e-5:
                normalized = True  # p is no arc length: written with p from 0 to 1
                numbers = [n * length**power for n, power in zip(numbers, (0, 1, 2, 3) * 2, strict=True)]
                values = " ".join(f'{name}="{n!r}"' for name, n in zip(names, numbers, strict=True))
            length = true
            shape = f'<paramPoly3 pRange="{"normalized" if normalized else "arcLength"}" {values}/>'
        text += geometry(s, x, y, h, length, shape)
        moved = along(kind, numbers, length, normalized)
        pieces.append((s, x, y, h, moved))
        du, dv, turn = moved(length)
        x, y = x + du * math.cos(h) - dv * math.sin(h), y + du * math.sin(h) + dv * math.cos(h)
        s, h = s + length, h + turn

    def line(at: float) -> tuple[float, float, float]:
        start, x0, y0, h0, moved = [piece for piece in pieces if piece[0] <= at][-1]
        du, dv, turn = moved(at - start)
        return x0 + du * math.cos(h0) - dv * math.sin(h0), y0 + du * math.sin(h0) + dv * math.cos(h0), h0 + turn

    return text, s, line


def records(rng: random.Random, length: float, size: float, least: float = 0.0) -> list[Cubic]:
    """A profile of two records that join smoothly enough: value about `size`, never below `least`."""
    middle = rng.uniform(0.3, 0.7) * length
    a, b = least + size * rng.uniform(0.5, 1.0), 0.3 * size / length * rng.uniform(-1, 1)
    c, d = 0.3 * size / length**2 * rng.uniform(-1, 1), 0.1 * size / length**3 * rng.uniform(-1, 1)
    first = (0.0, a, b, c, d)
    return [first, (middle, value([first], middle), value([first], middle, slope=True), c, -d)]


def written(tag: str, profile: list[Cubic]) -> str:
    return "".join(cubic(tag, *record) for record in profile)


def rotation(h: float, pitch: float, roll: float) -> np.ndarray:
    """Rz(h) Ry(pitch) Rx(roll)."""
    (ch, sh), (cp, sp), (cr, sr) = ((math.cos(a), math.sin(a)) for a in (h, pitch, roll))
    turn_z = np.array([[ch, -sh, 0], [sh, ch, 0], [0, 0, 1]])
    turn_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    turn_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    return turn_z @ turn_y @ turn_x


@pytest.mark.parametrize("seed", range(16))
def test_lane_points_of_a_random_road(tmp_path: Path, seed: int) -> None:
    rng = random.Random(seed)
    text, length, line = reference_line(rng)
    offset = records(rng, length, 0.8)
    widths = {number: records(rng, length, 1.0, least=2.5) for number in (2, 1, -1, -2)}
    flat = seed % 3 == 0
    heights = [] if flat else records(rng, length, 4.0)
    leans = [] if flat else records(rng, length, 0.1)
    by_border = seed % 2 == 0  # then the right lanes are written by their outer borders
    borders: dict[int, list[Cubic]] = {
        -1: [(s, -a, -b, -c, -d) for s, a, b, c, d in widths[-1]],
        -2: [(s, -a - 3.0, -b, -c, -d) for s, a, b, c, d in widths[-1]],
    }

    def lane_text(number: int) -> str:
        if by_border and number < 0:
            return lane(number, inside=written("border", borders[number]))
        return lane(number, inside=written("width", widths[number]))

    net = network(
        tmp_path,
        road(
            "1", text, length, section([lane_text(1), lane_text(2)], [lane_text(-1), lane_text(-2)]),
            offset=written("laneOffset", offset), elevation=written("elevation", heights),
            superelevation=written("superelevation", leans), rule="LHT" if seed % 4 == 1 else "RHT",
        ),
    )  # fmt: skip

    def edge(number: int, s: float, slope: bool) -> float:
        """t, or dt/ds, of the outer border of a lane."""
        if number == 0:
            return value(offset, s, slope)
        if by_border and number < 0:
            return value(borders[number], s, slope)
        side = 1 if number > 0 else -1
        return edge(number - side, s, slope) + side * value(widths[number], s, slope)

    for number in (2, 1, -1, -2):
        inner = number - (1 if number > 0 else -1)
        for s in np.linspace(0.0, length, 41)[:-1]:
            t, t1 = (0.5 * (edge(number, s, each) + edge(inner, s, each)) for each in (False, True))
            x, y, h = line(s)
            pitch, roll = -math.atan(value(heights, s, slope=True)), value(leans, s)
            expected = np.array([x, y, value(heights, s)]) + rotation(h, pitch, roll) @ [0.0, t, 0.0]
            pose = net.lane_pose("1", number, s)
            assert np.allclose(pose[:3], expected, rtol=0.0, atol=1e-4), (number, s, pose[:3], expected)
            if flat:
                assert math.remainder(pose.h - h - math.atan(t1), 2 * math.pi) == pytest.approx(0.0, abs=1e-4)
            back = net.locate(pose.x, pose.y, h=pose.h, z=pose.z) if not flat else net.locate(pose.x, pose.y, h=pose.h)
            assert (back.lane, back.s) == (number, pytest.approx(s, abs=1e-3))
