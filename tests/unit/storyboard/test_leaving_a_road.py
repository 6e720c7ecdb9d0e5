"""Driving off a road between its ends, through a virtual junction."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from openscenario.road.network import RoadNetwork, load_network

from .conftest import XODR, Make, lane_position, run, speed, teleport

LENGTH = 15.0 * math.pi  # m, a quarter of a circle of 30 m
IN_LANE = 28.25 * 0.5 * math.pi  # m, the same in the middle of the right lane


@pytest.fixture
def network(tmp_path: Path) -> RoadNetwork:
    """Road 1 with a way off at s = 500 m: road 2, a quarter circle to the right, and road 3, to the south."""

    def straight_on(kind: str) -> str:
        return f'<{kind} id="-1"/>'

    def one_lane(id_: str, plan: str, length: float, junction: str, link: str) -> str:
        inner = f"<link>{straight_on('predecessor')}{straight_on('successor')}</link>"
        width = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/>'
        return (
            f'<road id="{id_}" length="{length}" junction="{junction}" rule="RHT"><link>{link}</link><planView>{plan}'
            '</planView><lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right>'
            f'<lane id="-1" type="driving">{inner}{width}</lane></right></laneSection></lanes></road>'
        )

    bend = f'<geometry s="0" x="500" y="0" hdg="0" length="{LENGTH}"><arc curvature="{-1.0 / 30.0}"/></geometry>'
    south = f'<geometry s="0" x="530" y="-30" hdg="{-0.5 * math.pi}" length="100"><line/></geometry>'
    from_main = '<predecessor elementType="road" elementId="1" elementS="500" elementDir="+"/>'
    roads = one_lane(
        "2", bend, LENGTH, "9", f'{from_main}<successor elementType="road" elementId="3" contactPoint="start"/>'
    ) + one_lane("3", south, 100.0, "-1", '<predecessor elementType="road" elementId="2" contactPoint="end"/>')
    junction = (
        '<junction id="9" name="j" type="virtual" mainRoad="1" sStart="490" sEnd="510" orientation="+">'
        '<connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start"><laneLink from="-1" to="-1"/>'
        "</connection></junction>"
    )
    path = tmp_path / "leaving.xodr"
    path.write_text(XODR.replace("</OpenDRIVE>", roads + junction + "</OpenDRIVE>"))
    return load_network(path)


def route(to: str) -> str:
    waypoints = "".join(
        f'<Waypoint routeStrategy="shortest"><Position>{place}</Position></Waypoint>'
        for place in (lane_position(450.0), to)
    )
    return (
        "<PrivateAction><RoutingAction><AssignRouteAction>"
        f'<Route name="r" closed="false">{waypoints}</Route></AssignRouteAction></RoutingAction></PrivateAction>'
    )


def test_a_route_leads_off_the_road(make: Make, network: RoadNetwork) -> None:
    away = route(f'<WorldPosition x="528.25" y="-60" h="{-0.5 * math.pi}"/>')
    board = make(A=[teleport(lane_position(480.0)), away, speed(20.0)], on=network)
    a = board.entities["A"]
    run(board, 2.0)  # 20 m on road 1, 20 m of the arc
    angle = 20.0 / 28.25
    assert (a.x, a.y) == pytest.approx((500.0 + 28.25 * math.sin(angle), -30.0 + 28.25 * math.cos(angle)), abs=0.01)
    assert a.h % (2.0 * math.pi) == pytest.approx(2.0 * math.pi - angle, abs=1e-3)
    run(board, 3.0)
    assert (a.road, a.x, a.y) == ("3", pytest.approx(528.25), pytest.approx(-30.0 - (80.0 - IN_LANE), abs=0.01))


def test_without_a_route_it_goes_on(make: Make, network: RoadNetwork) -> None:
    board = make(A=[teleport(lane_position(480.0)), speed(20.0)], B=[teleport(lane_position(20.0))], on=network)
    run(board, 5.0)
    assert (board.entities["A"].road, board.entities["A"].x) == ("1", pytest.approx(580.0))
