"""Another way, driven: the only lane is blocked, the road is too narrow to pass, and a detour leads to the goal."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from ads_loop import TABBY, Car, Drive, drive, new_stack
from ads_traffic import SeeingAll, Watch, parked

from ads.stack import Stack
from openscenario.road.network import RoadNetwork, load_network
from vehicle.messages import RoadPoint, Task

QUARTER = 15.0 * 0.5 * math.pi  # m of arc, a quarter turn of 15 m radius
GOAL = Task(goal=RoadPoint("4", -1, 60.0))
Piece = tuple[float, float]  # length [m], curvature [1/m]

LANES = (
    '<lanes><laneSection s="0"><center><lane id="0" type="none" level="false"/></center><right>'
    '<lane id="-1" type="driving" level="false"><link>{link}</link><width sOffset="0" a="3.5" b="0" c="0" d="0"/>'
    "</lane></right></laneSection></lanes>"
)


def road(
    number: str, x: float, y: float, heading: float, pieces: list[Piece], before: str = "", after: str = ""
) -> str:
    """A road with one lane to the right of its line of straights and arcs; before and after: roads, or j:ID."""
    links, lane, plan, s = "", "", "", 0.0
    for tag, other, contact in (("predecessor", before, "end"), ("successor", after, "start")):
        if other.startswith("j:"):
            links += f'<{tag} elementType="junction" elementId="{other[2:]}"/>'
        elif other:
            links += f'<{tag} elementType="road" elementId="{other}" contactPoint="{contact}"/>'
            lane += f'<{tag} id="-1"/>'
    for length, curvature in pieces:
        shape = f'<arc curvature="{curvature}"/>' if curvature else "<line/>"
        plan += f'<geometry s="{s}" x="{x}" y="{y}" hdg="{heading}" length="{length}">{shape}</geometry>'
        turn = curvature * length
        chord = length if not curvature else 2.0 * math.sin(0.5 * turn) / curvature
        x, y = x + chord * math.cos(heading + 0.5 * turn), y + chord * math.sin(heading + 0.5 * turn)
        s, heading = s + length, heading + turn
    junction = {1: "-1", 2: "8" if number[0] == "2" else "9"}[len(number)]
    return (
        f'<road id="{number}" length="{s}" junction="{junction}"><link>{links}</link><planView>{plan}</planView>'
        f"{LANES.format(link=lane)}</road>"
    )


@pytest.fixture
def town(tmp_path: Path) -> RoadNetwork:
    """Road 1 leads straight on over 11, 2 and 21 to 4, or by 12, 3 and 22, 50 m to the left and back, to the same."""
    left, right = (QUARTER, 1.0 / 15.0), (QUARTER, -1.0 / 15.0)
    there, back = [(20.0, 0.0), right, (60.0, 0.0)], [right, (20.0, 0.0)]
    parts = [
        road("1", 0.0, 0.0, 0.0, [(60.0, 0.0)], after="j:9"),
        road("11", 60.0, 0.0, 0.0, [(20.0, 0.0)], before="1", after="2"),
        road("12", 60.0, 0.0, 0.0, [left], before="1", after="3"),
        road("2", 80.0, 0.0, 0.0, [(80.0, 0.0)], before="11", after="j:8"),
        road("3", 75.0, 15.0, 0.5 * math.pi, there + back, before="12", after="j:8"),
        road("21", 160.0, 0.0, 0.0, [(20.0, 0.0)], before="2", after="4"),
        road("22", 165.0, 15.0, -0.5 * math.pi, [left], before="3", after="4"),
        road("4", 180.0, 0.0, 0.0, [(100.0, 0.0)], before="j:8"),
    ]
    for junction, ways in (("9", (("1", "11"), ("1", "12"))), ("8", (("2", "21"), ("3", "22")))):
        connections = "".join(
            f'<connection id="{k}" incomingRoad="{come}" connectingRoad="{way}" contactPoint="start">'
            '<laneLink from="-1" to="-1"/></connection>'
            for k, (come, way) in enumerate(ways)
        )
        parts.append(f'<junction id="{junction}">{connections}</junction>')
    file = tmp_path / "town.xodr"
    file.write_text('<OpenDRIVE><header revMajor="1" revMinor="6"/>' + "".join(parts) + "</OpenDRIVE>")
    return load_network(file)


def driven(town: RoadNetwork, x: float | None) -> tuple[Stack, Drive, Watch]:
    """80 s from the beginning of road 1 on, with a car parked at `x` [m] on the straight way."""
    actors = [] if x is None else [parked(x)]
    stack, watch = new_stack(town, perception=SeeingAll(actors)), Watch(actors)
    return stack, drive(stack, Car(TABBY, 5.0, -1.75, 0.0, 5.0), 80.0, GOAL, watch=watch), watch


def roads(stack: Stack) -> list[str]:
    return [leg.road for leg in stack.navigator.route.legs]


def test_the_straight_way_where_nothing_blocks_it(town: RoadNetwork) -> None:
    stack, log, _ = driven(town, None)
    assert roads(stack) == ["1", "11", "2", "21", "4"]
    assert log.column(2).max() < 0.0


def test_a_blocked_lane_is_driven_around_by_another_road(town: RoadNetwork) -> None:
    stack, log, watch = driven(town, 95.0)
    assert roads(stack) == ["1", "12", "3", "22", "4"]
    assert log.column(2).max() == pytest.approx(50.0 - 1.75, abs=0.5)  # right of the line that runs at y = 50 m
    assert (log.rows[-1][1], log.rows[-1][2]) == (pytest.approx(240.0, abs=1.0), pytest.approx(-1.75, abs=0.2))
    assert log.v[-1] == 0.0
    assert log.v[40:400].min() > 1.0  # it did not stop to find that out
    assert log.rmse() < 0.15
    assert watch.least > 10.0


def test_waits_where_the_way_it_is_on_already_is_blocked(town: RoadNetwork) -> None:
    _, log, watch = driven(town, 170.0)  # seen from 60 m away, beyond the fork
    assert log.v[-1] == 0.0
    assert log.rows[-1][1] < 170.0
    assert 2.0 < watch.least < 15.0
