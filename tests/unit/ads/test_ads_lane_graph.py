"""Lane graph planner: costs, and ways around blocked lanes."""

from __future__ import annotations

from pathlib import Path

import pytest

from ads.localization import Estimate
from ads.parameters import Parameters
from ads.planning.lane_graph import LaneGraphPlanner
from ads.planning.navigator import Navigator
from ads.planning.route import follow
from openscenario.road.network import RoadNetwork, load_network
from openscenario.road.route import RouteError
from vehicle.messages import RoadPoint, Task

LANE = (
    '<lane id="{id}" type="driving" level="false"><link>{link}</link>'
    '<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
)
ROAD = """<road id="{id}" length="{length}" junction="{junction}"><link>{link}</link>
<type s="0" type="town"><speed max="{limit}" unit="m/s"/></type>
<planView><geometry s="0" x="{x}" y="{y}" hdg="0" length="{length}"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none" level="false"/></center><right>{lanes}</right></laneSection>
</lanes></road>"""


def road(
    number: str, length: float, x: float, lanes: int = 1, limit: float = 10.0, before: str = "", after: str = ""
) -> str:
    """A straight road along x with `lanes` right lanes; before and after: ids of roads, or j:ID of a junction."""
    link = ""
    for tag, other, contact in (("predecessor", before, "end"), ("successor", after, "start")):
        if other.startswith("j:"):
            link += f'<{tag} elementType="junction" elementId="{other[2:]}"/>'
        elif other:
            link += f'<{tag} elementType="road" elementId="{other}" contactPoint="{contact}"/>'
    links = "".join(
        f'<{tag} id="%d"/>' for tag, other in (("predecessor", before), ("successor", after))
        if other and not other.startswith("j:")
    )  # fmt: skip
    drawn = "".join(LANE.format(id=-k, link=links.replace("%d", str(-k))) for k in range(1, lanes + 1))
    junction = "9" if len(number) == 2 else "-1"
    return ROAD.format(id=number, length=length, junction=junction, link=link, limit=limit, x=x, y=0.0, lanes=drawn)


def fork(tmp_path: Path, limits: tuple[float, float] = (10.0, 10.0)) -> RoadNetwork:
    """Road 1 leads over way 11 or way 12 (lanes of their own road each) to roads 2 and 3, and those by 21, 22 to 4."""
    parts = [
        road("1", 100.0, 0.0, after="j:9"),
        road("11", 20.0, 100.0, before="1", after="2"),
        road("12", 20.0, 100.0, before="1", after="3"),
        road("2", 200.0, 120.0, limit=limits[0], before="11", after="4"),
        road("3", 210.0, 120.0, limit=limits[1], before="12", after="4"),
        road("4", 100.0, 330.0),
    ]
    connections = "".join(
        f'<connection id="{k}" incomingRoad="1" connectingRoad="{way}" contactPoint="start">'
        '<laneLink from="-1" to="-1"/></connection>'
        for k, way in enumerate(("11", "12"))
    )
    text = (
        '<OpenDRIVE><header revMajor="1" revMinor="6"/>' + "".join(parts)
        + f'<junction id="9" name="">{connections}</junction></OpenDRIVE>'
    )  # fmt: skip
    path = tmp_path / "fork.xodr"
    path.write_text(text)
    return load_network(path)


def roads_of(legs: tuple) -> list[str]:
    return [leg.road for leg in legs]


START, GOAL = RoadPoint("1", -1, 10.0), RoadPoint("4", -1, 50.0)


class TestRoute:
    def test_the_shorter_way_at_equal_speed(self, tmp_path: Path) -> None:
        assert roads_of(LaneGraphPlanner(fork(tmp_path)).route(START, GOAL)) == ["1", "11", "2", "4"]

    def test_the_quicker_way_though_it_is_longer(self, tmp_path: Path) -> None:
        network = fork(tmp_path, limits=(8.0, 15.0))  # 200 m in 25 s, 210 m in 14 s
        assert roads_of(LaneGraphPlanner(network).route(START, GOAL)) == ["1", "12", "3", "4"]

    def test_around_a_blocked_road(self, tmp_path: Path) -> None:
        planner = LaneGraphPlanner(fork(tmp_path))
        assert roads_of(planner.route(START, GOAL, [RoadPoint("2", -1, 80.0)])) == ["1", "12", "3", "4"]

    def test_no_way_when_both_are_blocked(self, tmp_path: Path) -> None:
        planner = LaneGraphPlanner(fork(tmp_path))
        with pytest.raises(RouteError, match="around it"):
            planner.route(START, GOAL, [RoadPoint("2", -1, 80.0), RoadPoint("3", -1, 5.0)])

    def test_what_lies_behind_the_car_blocks_nothing(self, tmp_path: Path) -> None:
        planner = LaneGraphPlanner(fork(tmp_path))
        assert roads_of(planner.route(START, GOAL, [RoadPoint("1", -1, 5.0)])) == ["1", "11", "2", "4"]

    def test_what_lies_behind_the_goal_blocks_nothing(self, tmp_path: Path) -> None:
        planner = LaneGraphPlanner(fork(tmp_path))
        assert roads_of(planner.route(START, GOAL, [RoadPoint("4", -1, 60.0)])) == ["1", "11", "2", "4"]

    def test_changes_lanes_before_a_blocked_place(self, tmp_path: Path) -> None:
        path = tmp_path / "two.xodr"
        parts = road("1", 200.0, 0.0, lanes=2, after="2") + road("2", 100.0, 200.0, lanes=2, before="1")
        path.write_text(f'<OpenDRIVE><header revMajor="1" revMinor="6"/>{parts}</OpenDRIVE>')
        planner = LaneGraphPlanner(load_network(path))
        legs = planner.route(RoadPoint("1", -2, 10.0), RoadPoint("2", -2, 50.0), [RoadPoint("1", -2, 80.0)])
        first, second, *_, last = legs
        assert (first.lane, second.lane, last.lane) == (-2, -1, -2)
        assert first.s_to <= 80.0 - 12.0

    @pytest.mark.parametrize("goal", [("2", -1, 115.0), ("7", -1, 40.0), ("4", -1, 10.0)])
    def test_town_at_one_speed_limit_as_the_shortest_way(self, scenarios_dir: Path, goal: tuple) -> None:
        network = load_network(scenarios_dir / "urban.xodr")
        start = ("4", -1, 20.0)
        ours = LaneGraphPlanner(network).route(RoadPoint(*start), RoadPoint(*goal))
        assert [tuple(leg) for leg in ours] == [tuple(leg) for leg in network.route(start, goal)]


class TestNavigator:
    def navigator(self, tmp_path: Path) -> tuple[Navigator, Estimate]:
        navigator = Navigator(Parameters(), fork(tmp_path))
        navigator.assign(Task(goal=GOAL))
        here = Estimate(0.0, 10.0, -1.75, 0.0, 5.0, 0.0, 0.0, 0.1, 0.01)
        navigator.update(here, True)
        return navigator, here

    def test_another_way_when_the_lane_is_blocked(self, tmp_path: Path) -> None:
        navigator, here = self.navigator(tmp_path)
        assert navigator.avoid(navigator.s + 150.0, here)
        assert navigator.update(here, True)
        assert roads_of(navigator.route.legs) == ["1", "12", "3", "4"]

    def test_not_while_the_path_is_left(self, tmp_path: Path) -> None:
        navigator, here = self.navigator(tmp_path)
        navigator.avoid(navigator.s + 150.0, here)
        assert not navigator.update(here, False)

    def test_keeps_its_route_when_there_is_no_other(self, tmp_path: Path) -> None:
        navigator, here = self.navigator(tmp_path)
        assert not navigator.avoid(navigator.s + 50.0, here)  # still on road 1, which has one lane
        assert not navigator.update(here, True)


@pytest.mark.parametrize(("narrow", "other"), [(-1, -2), (-2, -1)])
def test_a_lane_that_narrows_to_nothing_is_left_while_it_is_wide_enough(
    tmp_path: Path, narrow: int, other: int
) -> None:
    """From 100 m on the lane of 3.5 m loses 0.035 m in a metre: it has 2.5 m at 128.6 m, and nothing at 200 m."""
    text = road("1", 200.0, 0.0, lanes=2)
    whole = LANE.format(id=narrow, link="")
    gone = whole.replace("</lane>", '<width sOffset="100" a="3.5" b="-0.035" c="0" d="0"/></lane>')
    assert whole in text
    path = tmp_path / "narrow.xodr"
    path.write_text(f'<OpenDRIVE><header revMajor="1" revMinor="6"/>{text.replace(whole, gone)}</OpenDRIVE>')
    net = load_network(path)
    first, second = follow(net, "1", narrow, 10.0, 400.0)
    assert (first.lane, second.lane, second.s_to) == (narrow, other, 200.0)
    assert first.s_to == second.s_from
    assert 126.0 <= first.s_to <= 128.6
    assert [leg.lane for leg in follow(net, "1", other, 10.0, 400.0)] == [other]
    assert [leg.lane for leg in follow(net, "1", narrow, 10.0, 60.0)] == [narrow]
