"""A distance to the side of another entity, also where its road runs the other way; places from geometry."""

from __future__ import annotations

from pathlib import Path

import pytest

from openscenario.road.network import RoadNetwork, load_network
from openscenario.storyboard.distances import measure

from .conftest import (
    LANE,
    XODR,
    Make,
    at_time,
    condition,
    event,
    group,
    lane_position,
    log,
    run,
    speed,
    state_of,
    story,
    teleport,
)


@pytest.fixture(scope="module")
def road(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Road 1 from the origin to x = 1000 m, road 2 on its axis from x = 2000 m back to 1000 m."""
    lanes = (
        f'<lanes><laneSection s="0"><left>{LANE.format(id=1)}</left><center><lane id="0" type="none"/></center>'
        f"<right>{LANE.format(id=-1)}</right></laneSection></lanes>"
    )
    second = (
        '<road length="1000" id="2" junction="-1" rule="RHT"><link/><planView><geometry s="0" x="2000" y="0" '
        f'hdg="3.141592653589793" length="1000"><line/></geometry></planView>{lanes}</road>'
    )
    path = tmp_path_factory.mktemp("roads") / "straight.xodr"
    path.write_text(XODR.replace("</OpenDRIVE>", second + "</OpenDRIVE>"))
    return path


@pytest.fixture(scope="module")
def network(road: Path) -> RoadNetwork:
    return load_network(road)


def beside(displacement: str, *, continuous: bool = False, free: bool = False) -> str:
    return (
        '<PrivateAction><LateralAction><LateralDistanceAction entityRef="B" distance="1" coordinateSystem="road" '
        f'continuous="{str(continuous).lower()}" freespace="{str(free).lower()}" displacement="{displacement}"/>'
        "</LateralAction></PrivateAction>"
    )


def on_second_road(h: float) -> str:
    """In lane 1 of road 2, whose middle is at y = -1.75 m; h = 0: along x."""
    inner = f'<Orientation type="relative" h="{h}"/>'
    return lane_position(500.0, 1, inner=inner).replace('roadId="1"', 'roadId="2"')


@pytest.mark.parametrize(
    ("h", "displacement", "free", "y"),
    [
        (0.0, "leftToReferencedEntity", False, -1.75 + 1.0),
        (0.0, "rightToReferencedEntity", False, -1.75 - 1.0),
        (0.0, "leftToReferencedEntity", True, -1.75 + 1.0 + 2.0),  # both are 2 m wide
        (3.141592653589793, "leftToReferencedEntity", False, -1.75 - 1.0),
        (3.141592653589793, "rightToReferencedEntity", True, -1.75 + 1.0 + 2.0),
    ],
)
def test_left_is_where_the_other_has_its_left(make: Make, h: float, displacement: str, free: bool, y: float) -> None:
    act = event("e", beside(displacement, free=free))
    board = make(
        A=[teleport(lane_position(100.0)), speed(5.0)],
        B=[teleport(on_second_road(h))],
        stories=story(act),
    )
    run(board, 0.1)
    assert board.entities["A"].y == pytest.approx(y)


@pytest.mark.parametrize("h", [0.0, 3.141592653589793])
@pytest.mark.parametrize(("lane", "y"), [(-2, -1.75 - 1.0), (1, -1.75 + 1.0)])
def test_on_any_side_it_stays_on_the_one_where_it_is(make: Make, h: float, lane: int, y: float) -> None:
    """Lane -2 of road 1 (y = -5.25) lies on one side of the other, lane 1 (y = 1.75) on the other one."""
    board = make(
        A=[teleport(lane_position(100.0, lane)), speed(5.0)],
        B=[teleport(on_second_road(h))],
        stories=story(event("e", beside("any"))),
    )
    run(board, 0.1)
    assert board.entities["A"].y == pytest.approx(y)


@pytest.mark.parametrize(("h", "y"), [(0.0, -1.75 + 0.3 + 1.0 + 2.0), (3.141592653589793, -1.75 - 0.3 - 1.0 - 2.0)])
def test_free_space_is_from_the_side_of_a_body_that_is_not_in_the_middle(make: Make, h: float, y: float) -> None:
    """The other reaches 0.3 m farther to its left than to its right."""
    board = make(
        A=[teleport(lane_position(100.0)), speed(5.0)],
        B=[teleport(on_second_road(h))],
        stories=story(event("e", beside("leftToReferencedEntity", free=True))),
    )
    board.entities["B"].center_y = 0.3
    run(board, 0.1)
    assert board.entities["A"].y == pytest.approx(y)


@pytest.mark.parametrize(("h", "apart"), [(0.0, 3.5 + 0.3 - 2.0), (3.141592653589793, 3.5 - 0.3 - 2.0)])
def test_a_free_distance_to_the_side_is_to_the_nearer_side_of_the_other(make: Make, h: float, apart: float) -> None:
    """From lane -2 (y = -5.25) to y = -1.75, both 2 m wide; the other reaches 0.3 m farther to its left."""
    board = make(A=[teleport(lane_position(100.0, -2))], B=[teleport(on_second_road(h))])
    board.start()
    a, b = board.entities["A"], board.entities["B"]
    b.center_y = 0.3
    assert measure(board, a, b, kind="lateral", system="road", free=True)() == pytest.approx(apart)


def test_left_changes_sides_when_the_other_turns_round(make: Make) -> None:
    follow = story(event("e", beside("leftToReferencedEntity", continuous=True)))
    turn = event("t", teleport(on_second_road(3.141592653589793)), start=group(condition(at_time(1.0))))
    board = make(
        A=[teleport(lane_position(100.0)), speed(5.0)],
        B=[teleport(on_second_road(0.0))],
        stories=follow + story(turn, actor="B", name="other"),
    )
    run(board, 0.5)
    assert board.entities["A"].y == pytest.approx(-0.75)
    run(board, 1.0)
    assert board.entities["A"].y == pytest.approx(-2.75)


def test_it_is_over_when_it_has_been_there_for_a_step(make: Make) -> None:
    """Put aside in the first step, there in the second, over with the third; what waits for it starts then."""
    after = group(condition(state_of("event", "e", "endTransition")))
    events = event("e", beside("leftToReferencedEntity")), event("next", speed(1.0), start=after)
    board = make(
        A=[teleport(lane_position(100.0)), speed(5.0)], B=[teleport(lane_position(200.0))], stories=story(*events)
    )
    run(board, 0.1)
    assert (0.03, "e", "endTransition") in log(board, "event")
    assert (0.03, "next", "startTransition") in log(board, "event")
