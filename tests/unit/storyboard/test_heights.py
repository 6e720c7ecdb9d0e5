"""Roads one above the other: a world position with a height is on the one at that height (ASAM OpenSCENARIO XML 1.3,
class WorldPosition: z is a coordinate of the place)."""

from __future__ import annotations

from pathlib import Path

import pytest

from openscenario.road.network import RoadNetwork, load_network

from .conftest import XODR, Make, run, speed, teleport


@pytest.fixture(scope="module")
def decks(tmp_path_factory: pytest.TempPathFactory) -> RoadNetwork:
    """Road 1 along x at height 0, road 2 above it: 6 m high at x = 0, climbing by 1 in 50."""
    one = XODR[XODR.index("  <road") : XODR.index("</OpenDRIVE>")]
    climbs = '<elevationProfile><elevation s="0" a="6" b="0.02" c="0" d="0"/></elevationProfile><lanes>'
    two = one.replace('id="1" junction', 'id="2" junction').replace("<lanes>", climbs, 1)
    path: Path = tmp_path_factory.mktemp("decks") / "decks.xodr"
    path.write_text(XODR.replace("</OpenDRIVE>", two + "</OpenDRIVE>"))
    return load_network(path)


@pytest.mark.parametrize(("z", "wanted", "after"), [(0.0, "1", 0.0), (8.0, "2", 8.0 + 50.0 * 0.02)])
def test_the_deck_at_that_height_is_driven_on(
    make: Make, decks: RoadNetwork, z: float, wanted: str, after: float
) -> None:
    board = make(A=[teleport(f'<WorldPosition x="100" y="-1.75" z="{z}" h="0"/>'), speed(10.0)], on=decks)
    run(board, 5.0)
    a = board.entities["A"]
    assert (a.road, a.z) == (wanted, pytest.approx(after, abs=0.05))
    assert a.x == pytest.approx(150.0, abs=0.2)


def test_a_height_that_no_road_has_leaves_the_nearest_road(make: Make, decks: RoadNetwork) -> None:
    board = make(A=[teleport('<WorldPosition x="100" y="-1.75" z="-40" h="0"/>'), speed(10.0)], on=decks)
    run(board, 1.0)
    assert (board.entities["A"].road, board.entities["A"].z) == ("1", 0.0)
