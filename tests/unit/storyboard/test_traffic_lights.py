"""Programs of traffic lights against a clock; user-defined values; geographic positions against the projection."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from openscenario import model
from openscenario.findings import ScenarioError
from openscenario.read import read_scenario
from openscenario.road.network import load_network
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.signals import programs

from .conftest import XODR, Make, condition, event, group, lane_position, run, speed, story, teleport


def controller(name: str, **more: object) -> model.TrafficSignalController:
    def phase(name: str, duration: float, state: str) -> model.Phase:
        states = (model.TrafficSignalState(traffic_signal_id="7", state=state),)
        return model.Phase(name=name, duration=duration, traffic_signal_states=states)

    phases = (phase("go", 10.0, "green"), phase("stop", 5.0, "red"))
    return model.TrafficSignalController(name=name, phases=phases, **more)  # type: ignore[arg-type]


def shown(program: object, time: float) -> str:
    phase = program.phase(time)  # type: ignore[attr-defined]
    assert phase is not None
    return str(phase.name)


def test_phases_follow_each_other_round_and_round() -> None:
    program = programs((controller("a"),))["a"]
    assert [shown(program, time) for time in (0.0, 9.99, 10.0, 14.99, 15.0, 26.0)] == [
        "go",
        "go",
        "stop",
        "stop",
        "go",
        "stop",
    ]


def test_a_delayed_controller_is_behind_the_one_it_refers_to() -> None:
    both = programs((controller("a", delay=2.0), controller("b", delay=3.0, reference="a")))
    assert [shown(both["a"], time) for time in (11.9, 12.0)] == ["go", "stop"]
    assert [shown(both["b"], time) for time in (14.9, 15.0)] == ["go", "stop"]


def test_an_action_sets_the_phase_and_it_goes_on_from_there() -> None:
    program = programs((controller("a"),))["a"]
    program.begin("stop", 3.0)
    assert [shown(program, time) for time in (3.0, 7.9, 8.0)] == ["stop", "stop", "go"]


LIGHTS = (
    '<TrafficSignals><TrafficSignalController name="crossing"><Phase name="go" duration="2">'
    '<TrafficSignalState trafficSignalId="7" state="green"/></Phase><Phase name="stop" duration="3">'
    '<TrafficSignalState trafficSignalId="7" state="red"/></Phase></TrafficSignalController></TrafficSignals>'
)


NEVER = '<SimulationTimeCondition value="99" rule="greaterThan"/>'


def with_lights(make: Make, test: str, *, on: Path | None = None, lights: str = LIGHTS, first: str = "") -> Storyboard:
    """A car that drives off when `test` holds, after the actions `first`; on the straight road if none is named."""
    start = group(condition(f"<ByValueCondition>{NEVER}</ByValueCondition>"))
    board = make(A=[teleport(lane_position(100.0))], stories=story(event("e", speed(10.0), start=start)))
    path = board.scenario.path
    text = path.read_text().replace("</RoadNetwork>", f"{lights}</RoadNetwork>").replace(NEVER, test)
    text = text.replace("<Init><Actions>", f"<Init><Actions>{first}")
    if on is not None:
        (path.parent / on.name).write_bytes(on.read_bytes())
        text = text.replace('<LogicFile filepath="straight.xodr"/>', f'<LogicFile filepath="{on.name}"/>')
    path.write_text(text)
    return Storyboard(read_scenario(path), board.network if on is None else load_network(on))


def test_a_phase_sets_its_lights(make: Make) -> None:
    board = with_lights(make, '<TrafficSignalControllerCondition trafficSignalControllerRef="crossing" phase="stop"/>')
    run(board, 1.9)
    assert (board.entities["A"].speed, board.world.signals) == (0.0, {"7": "green"})
    run(board, 0.3)
    assert (board.entities["A"].speed, board.world.signals) == (10.0, {"7": "red"})


NORTH = "".join(
    f'<signal id="{id}" name="{name}" s="200" t="-5" dynamic="yes" orientation="+" type="1000001" subtype="-1"'
    ' country="OpenDRIVE" zOffset="3"/>'
    for id, name in (("7", "north"), ("8", "north"), ("9", "south"))
)


@pytest.fixture
def lit(tmp_path: Path) -> Path:
    """A road with two lights called "north", of ids 7 and 8, and one called "south"."""
    road = tmp_path / "lit.xodr"
    road.write_text(XODR.replace("</lanes>", f"</lanes><signals>{NORTH}</signals>"))
    return road


def set_light(name: str, state: str) -> str:
    action = f'<TrafficSignalStateAction name="{name}" state="{state}"/>'
    return (
        f"<GlobalAction><InfrastructureAction><TrafficSignalAction>{action}</TrafficSignalAction>"
        "</InfrastructureAction></GlobalAction>"
    )


@pytest.mark.parametrize("called", ["north", "8"])
def test_a_light_set_by_its_name_fulfils_a_condition_on_its_name_and_on_its_id(
    make: Make, lit: Path, called: str
) -> None:
    first = set_light("north", "go") + set_light("south", "stop")
    board = with_lights(make, f'<TrafficSignalCondition name="{called}" state="go"/>', on=lit, lights="", first=first)
    run(board, 0.3)
    assert board.world.signals == {"7": "go", "8": "go", "9": "stop"}
    assert board.entities["A"].speed == 10.0


def test_lights_of_one_name_are_in_a_state_when_each_of_them_is(make: Make, lit: Path) -> None:
    first = set_light("8", "go")
    board = with_lights(make, '<TrafficSignalCondition name="north" state="go"/>', on=lit, lights="", first=first)
    run(board, 0.3)
    assert board.entities["A"].speed == 0.0
    board.world.show("7", "go")
    run(board, 0.1)
    assert board.entities["A"].speed == 10.0


def test_a_phase_sets_the_lights_that_it_calls_by_their_name(make: Make, lit: Path) -> None:
    by_name = LIGHTS.replace('trafficSignalId="7"', 'trafficSignalId="north"')
    board = with_lights(make, '<TrafficSignalCondition name="north" state="red"/>', on=lit, lights=by_name)
    run(board, 1.9)
    assert (board.entities["A"].speed, board.world.signals) == (0.0, {"7": "green", "8": "green"})
    run(board, 0.3)
    assert (board.entities["A"].speed, board.world.signals) == (10.0, {"7": "red", "8": "red"})


def test_a_phase_that_no_controller_has_is_refused(make: Make) -> None:
    with pytest.raises(ScenarioError, match="no such phase"):
        with_lights(make, '<TrafficSignalControllerCondition trafficSignalControllerRef="crossing" phase="amber"/>')


def test_a_user_defined_value_comes_from_outside(make: Make) -> None:
    test = '<UserDefinedValueCondition name="grip" rule="lessThan" value="0.5"/>'
    start = group(condition(f"<ByValueCondition>{test}</ByValueCondition>"))
    board = make(A=[teleport(lane_position(100.0))], stories=story(event("e", speed(10.0), start=start)))
    run(board, 1.0)
    assert board.entities["A"].speed == 0.0
    board.world.values["grip"] = "0.3"
    run(board, 0.1)
    assert board.entities["A"].speed == 10.0


GEO = '<GeoPosition latitudeDeg="{lat}" longitudeDeg="{lon}"/>'


def test_a_geographic_position_without_a_projection_is_refused(make: Make) -> None:
    with pytest.raises(ScenarioError, match="no geoReference"):
        make(A=[teleport(GEO.format(lat=48, lon=9))])


@pytest.mark.parametrize("offset", ["", '<offset x="690000" y="-40" z="3" hdg="0.5"/>'])
def test_a_geographic_position_is_projected(make: Make, tmp_path: Path, offset: str) -> None:
    """Transverse Mercator about 48 N 9 E: a small step north is that of the ellipsoid's meridian radius there.

    The header's offset leads from the numbers of the file to those that are projected, and is not applied again."""
    pytest.importorskip("pyproj")
    road = tmp_path / "road.xodr"
    reference = (
        "<geoReference><![CDATA[+proj=tmerc +lat_0=48 +lon_0=9 +k=1 +x_0=0 +y_0=0 +ellps=WGS84]]></geoReference>"
    )
    header = '<header revMajor="1" revMinor="6" name="straight"/>'
    road.write_text(XODR.replace(header, header.replace("/>", f">{reference}{offset}</header>")))
    placed = make(A=[teleport(GEO.format(lat=48.0001, lon=9.0))], on=load_network(road))
    placed.start()
    a, squared = 6378137.0, 0.00669437999014
    radius = a * (1.0 - squared) / (1.0 - squared * math.sin(math.radians(48.0)) ** 2) ** 1.5
    assert placed.entities["A"].y == pytest.approx(math.radians(0.0001) * radius, abs=1e-3)
    assert placed.entities["A"].x == pytest.approx(0.0, abs=1e-6)
