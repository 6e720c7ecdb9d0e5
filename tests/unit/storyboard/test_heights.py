"""Heights: of roads one above the other a world position is on the one at its own (ASAM OpenSCENARIO XML 1.3, class
WorldPosition: z is a coordinate of the place); on a slope one leans as the slope does, by where one faces."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from openscenario.road.network import RoadNetwork, load_network

from .conftest import XODR, Make, by_entity, condition, event, group, log, run, speed, story, teleport

SLOPE = math.atan(0.02)


@pytest.fixture(scope="module")
def decks(tmp_path_factory: pytest.TempPathFactory) -> RoadNetwork:
    """Road 2 along x at height 0, road 1 above it: 6 m high at x = 0, climbing by 1 in 50."""
    one = XODR[XODR.index("  <road") : XODR.index("</OpenDRIVE>")]
    climbs = '<elevationProfile><elevation s="0" a="6" b="0.02" c="0" d="0"/></elevationProfile><lanes>'
    low, high = one.replace('id="1" junction', 'id="2" junction'), one.replace("<lanes>", climbs, 1)
    path: Path = tmp_path_factory.mktemp("decks") / "decks.xodr"
    path.write_text(XODR.replace(one, low + high))
    return load_network(path)


@pytest.mark.parametrize(("z", "wanted", "after"), [(0.0, "2", 0.0), (8.0, "1", 8.0 + 50.0 * 0.02)])
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
    assert (board.entities["A"].road, board.entities["A"].z) == ("2", 0.0)


def climbing(z: float) -> str:
    return f'<WorldPosition x="100" y="-1.75" z="{z}" h="{{h}}"/>'


@pytest.mark.parametrize(
    ("where", "h", "pitch", "roll"),
    [
        ('<RoadPosition roadId="1" s="100" t="-1.75">{o}</RoadPosition>', 0.0, -SLOPE, 0.0),
        ('<RoadPosition roadId="1" s="100" t="-1.75">{o}</RoadPosition>', math.pi, SLOPE, 0.0),
        ('<RoadPosition roadId="1" s="100" t="-1.75">{o}</RoadPosition>', 0.5 * math.pi, 0.0, -SLOPE),
        (climbing(8.0), 0.0, -SLOPE, 0.0),
        (climbing(8.0), math.pi, SLOPE, 0.0),
        (climbing(8.0), -0.5 * math.pi, 0.0, SLOPE),
    ],
)
def test_who_stands_on_a_slope_leans_as_it_faces(
    make: Make, decks: RoadNetwork, where: str, h: float, pitch: float, roll: float
) -> None:
    """Uphill: nose up (negative pitch, ISO 8855); downhill: nose down; across: the uphill side is up."""
    place = where.format(o=f'<Orientation type="relative" h="{h}"/>', h=h)
    board = make(A=[teleport(place)], on=decks)
    run(board, 0.0)
    a = board.entities["A"]
    assert (a.pitch, a.roll) == (pytest.approx(pitch, abs=1e-9), pytest.approx(roll, abs=1e-9))


def on(deck: str, x: float) -> str:
    """A place in the right lane of a deck."""
    return f'<WorldPosition x="{x}" y="-1.75" z="{6.0 + 0.02 * x if deck == "1" else 0.0}" h="0"/>'


@pytest.mark.parametrize(("z", "deck"), [(0.0, "2"), (12.0, "1")])
def test_a_waypoint_is_on_the_deck_at_its_height(make: Make, decks: RoadNetwork, z: float, deck: str) -> None:
    """At x = 300 m the upper deck is 12 m high."""
    places = (on(deck, 50.0), f'<WorldPosition x="300" y="-1.75" z="{z}"/>')
    waypoints = "".join(f'<Waypoint routeStrategy="shortest"><Position>{p}</Position></Waypoint>' for p in places)
    route = (
        f'<PrivateAction><RoutingAction><AssignRouteAction><Route name="r" closed="false">{waypoints}</Route>'
        "</AssignRouteAction></RoutingAction></PrivateAction>"
    )
    board = make(A=[teleport(on(deck, 10.0)), route], on=decks)
    board.start()
    assert [(each.road, each.s_from, each.s_to) for each in board.entities["A"].route_lanes] == [(deck, 50.0, 300.0)]


@pytest.mark.parametrize(("z", "deck"), [(0.0, "2"), (12.0, "1")])
@pytest.mark.parametrize("h", ["", 'h="0"'])
def test_a_distance_is_to_the_deck_at_the_height_of_the_place(
    make: Make, decks: RoadNetwork, z: float, deck: str, h: str
) -> None:
    """A is on the deck of the place, 10 m before it, or on the other one, from where no road leads there."""
    where = f'<Position><WorldPosition x="300" y="-1.75" z="{z}" {h}/></Position>'
    test = (
        '<DistanceCondition freespace="false" rule="lessOrEqual" value="20" relativeDistanceType="longitudinal" '
        f'coordinateSystem="road">{where}</DistanceCondition>'
    )
    found = []
    for own in ("1", "2"):
        act = event("e", speed(5.0), start=group(condition(by_entity(test, "A"))))
        board = make(A=[teleport(on(own, 290.0))], stories=story(act), on=decks)
        run(board, 0.05)
        found.append(("e", "startTransition") in [(name, what) for _, name, what in log(board, "event")])
    assert found == [deck == "1", deck == "2"]
