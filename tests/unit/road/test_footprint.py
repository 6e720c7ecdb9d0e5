"""Where a box stands: one compiled call against the separate questions to the network."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from road_files import arc, crossing, geometry, lane, network, road, section

from openscenario.road.footprint import Footprint
from openscenario.road.network import RoadNetwork

CORNERS = np.array([(3.5, 0.9), (-1.0, 0.9), (-1.0, -0.9), (3.5, -0.9)])
LENGTH = 120.0  # m


def bend(folder: Path) -> RoadNetwork:
    """An arc with a sidewalk on its left; the limit of lane -1 falls at 60 m, lane -2 has one all along."""
    wide = '<width sOffset="0" a="{}" b="0.01" c="0" d="0"/><speed sOffset="0" max="{}" unit="m/s"/>'
    right = [lane(-1, inside=wide.format(3.5, 20) + '<speed sOffset="60" max="8" unit="m/s"/>')]
    right += [lane(-2, inside=wide.format(3.0, 15))]
    sections = section([lane(1), lane(2, 2.0, "sidewalk")], right)
    return network(folder, road("1", geometry(0.0, 0.0, 0.0, 0.0, LENGTH, arc(0.01)), LENGTH, sections))


@pytest.mark.parametrize("roads", [bend, crossing])
def test_it_answers_as_the_separate_questions_do(tmp_path: Path, roads: object) -> None:
    """A box that wanders, step by step and in jumps: all corners are looked for from nothing, one after the other."""
    net: RoadNetwork = roads(tmp_path)  # type: ignore[operator]
    one, rng = Footprint(net, CORNERS), np.random.default_rng(4)
    x, y, yaw = 1.0, 0.0, 0.0
    seen = set()
    for step in range(500):
        if step % 20 == 0:
            x, y, yaw = rng.uniform(-20.0, 110.0), rng.uniform(-20.0, 60.0), rng.uniform(-3.1, 3.1)
        x, y, yaw = x + math.cos(yaw) + rng.normal(0.0, 0.2), y + math.sin(yaw), yaw + rng.normal(0.02, 0.1)
        on_road, width, limit = one.under(x, y, yaw)
        cos, sin = math.cos(yaw), math.sin(yaw)
        corners = [net.locate(x + cos * u - sin * v, y + sin * u + cos * v) for u, v in CORNERS]
        assert on_road == all(each.on_road for each in corners), (step, x, y, yaw)
        middle = net.locate(x, y, yaw)
        expected = (math.nan, math.nan)
        if middle.on_road:
            speed = net.lane_speed(middle.road, middle.lane, middle.s)
            expected = net.lane_width(middle.road, middle.lane, middle.s), speed if math.isfinite(speed) else math.nan
        assert (width, limit) == pytest.approx(expected, nan_ok=True, abs=1e-9), (step, x, y, yaw)
        seen.add((on_road, limit))
    assert {each for each, _ in seen} == {True, False}
    if roads is bend:
        assert {20.0, 15.0, 8.0} <= {limit for _, limit in seen}
