"""Distances between bodies in a bend, and to those that draw trailers; expected values from geometry.

The cars are 5 m long and 2 m wide, from 1 m behind the reference point to 4 m ahead of it.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from openscenario.road.network import RoadNetwork, load_network
from openscenario.storyboard.distances import measure
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.trailers import couple, line_up

from .conftest import XODR, Make, lane_position, speed, teleport

RADIUS = 50.0  # m, of the reference line, which bends to the left
MIDDLE = RADIUS + 1.75  # m, of the middle of the right lane
OUTER = RADIUS + 5.25  # m, of the one right of it


@pytest.fixture(scope="module")
def road(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bend") / "straight.xodr"
    path.write_text(XODR.replace("<line/>", f'<arc curvature="{1.0 / RADIUS}"/>'))
    return path


@pytest.fixture(scope="module")
def network(road: Path) -> RoadNetwork:
    return load_network(road)


def free(board: Storyboard, kind: str, system: str = "road", a: str = "A", b: str = "B") -> float | None:
    return measure(board, board.entities[a], board.entities[b], kind=kind, system=system, free=True)()


def standing(make: Make, *positions: str) -> Storyboard:
    board = make(**{name: [teleport(where), speed(0.0)] for name, where in zip("ABC", positions, strict=False)})
    board.start()
    return board


def test_in_a_bend_the_inner_front_corner_is_furthest_along_the_road(make: Make) -> None:
    """4 m ahead at MIDDLE - 1 m from the centre, and 1 m behind at as much: the nearest corners in s."""
    board = standing(make, lane_position(20.0), lane_position(50.0))
    reach = RADIUS * (math.atan2(4.0, MIDDLE - 1.0) + math.atan2(1.0, MIDDLE - 1.0))
    assert free(board, "longitudinal") == pytest.approx(30.0 - reach)
    assert free(board, "longitudinal", a="B", b="A") == pytest.approx(-(30.0 - reach))


def test_in_a_bend_a_front_hangs_out(make: Make) -> None:
    """Corners 4 m ahead lie further out than their sides do beside the reference point."""
    board = standing(make, lane_position(20.0, -1), lane_position(20.0, -2))
    outermost = math.hypot(MIDDLE + 1.0, 4.0)
    innermost = OUTER - 1.0
    assert free(board, "lateral") == pytest.approx(-(innermost - outermost))


def test_against_the_road_the_same_is_ahead(make: Make) -> None:
    """In the left lane the cars face against s; lane 1 lies 1.75 m inside of the reference line."""
    board = standing(make, lane_position(50.0, 1), lane_position(20.0, 1))
    inner = RADIUS - 1.75 - 1.0
    reach = RADIUS * (math.atan2(4.0, inner) + math.atan2(1.0, inner))
    assert free(board, "longitudinal") == pytest.approx(30.0 - reach)


@pytest.mark.parametrize("kind", ["longitudinal", "euclidianDistance"])
def test_trailers_belong_to_who_draws_them(make: Make, kind: str) -> None:
    """B hangs on A with its axle 6 m behind A's; its rear is 1 m behind that; C ends 4 m ahead of its own axle."""
    board = standing(make, *(f'<WorldPosition x="{x}" y="0" h="0"/>' for x in (100.0, 0.0, 80.0)))
    a, b = board.entities["A"], board.entities["B"]
    a.hitch, b.coupler = -1.0, 5.0
    couple(a, b)
    line_up(a)
    assert free(board, kind, "entity", "C", "A") == pytest.approx(93.0 - 84.0)
    assert abs(free(board, kind, "entity", "A", "C") or 0.0) == pytest.approx(93.0 - 84.0)
    assert abs(free(board, kind, "entity", "A", "B") or 0.0) == pytest.approx(99.0 - 98.0)  # between the two themselves


def test_reference_points_are_those_of_the_named(make: Make) -> None:
    board = standing(make, *(f'<WorldPosition x="{x}" y="0" h="0"/>' for x in (100.0, 0.0, 80.0)))
    couple(board.entities["A"], board.entities["B"])
    line_up(board.entities["A"])
    distance = measure(
        board, board.entities["C"], board.entities["A"], kind="longitudinal", system="entity", free=False
    )
    assert distance() == pytest.approx(20.0)
