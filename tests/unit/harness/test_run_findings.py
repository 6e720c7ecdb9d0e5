"""What a run found beside its verdicts: the road that was repaired, and others that moved as nobody can."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from openscenario.findings import ScenarioError
from pytest_dvp import run
from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.run_findings import said
from tests.unit.harness.conftest import OneTrick, coast

Write = Callable[..., Path]
STEP = (
    '<Story name="s"><Act name="a"><ManeuverGroup name="g" maximumExecutionCount="1">'
    '<Actors selectTriggeringEntities="false"><EntityRef entityRef="Other"/></Actors><Maneuver name="m">'
    '<Event name="leap" priority="parallel"><Action name="x"><PrivateAction><RoutingAction><FollowTrajectoryAction>'
    '<TrajectoryRef><Trajectory name="t" closed="false"><Shape><Polyline>'
    '<Vertex time="0"><Position><WorldPosition x="60" y="1.75"/></Position></Vertex>'
    '<Vertex time="5"><Position><WorldPosition x="90" y="1.75"/></Position></Vertex>'
    "</Polyline></Shape></Trajectory></TrajectoryRef><TimeReference>"
    '<Timing domainAbsoluteRelative="relative" offset="0" scale="1"/></TimeReference>'
    '<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    '</Action><StartTrigger><ConditionGroup><Condition name="c" delay="0" conditionEdge="none"><ByValueCondition>'
    '<SimulationTimeCondition value="0.5" rule="greaterThan"/></ByValueCondition></Condition></ConditionGroup>'
    "</StartTrigger></Event></Maneuver></ManeuverGroup><StartTrigger/></Act></Story><StopTrigger>"
)


@pytest.fixture
def faulty(scenario: Write) -> Path:
    """A scenario on a road with an empty element for its left side."""
    path = scenario()
    road = path.with_name("straight.xodr")
    text = road.read_text()
    start, end = text.index("<left>"), text.index("</left>") + len("</left>")
    road.write_text(text[:start] + "<left></left>" + text[end:])
    return path


def test_a_verdict_says_on_which_repaired_road_it_stands(faulty: Path, tmp_path: Path) -> None:
    result = run(faulty, ads=OneTrick(coast), duration=0.2, log_dir=tmp_path / "runs")
    assert result.folder is not None
    (found,) = json.loads((result.folder / "result.json").read_text())["findings"]
    assert {"code", "field", "t", "found", "allowed", "count"} <= set(found)
    assert (found["code"], found["count"]) == ("road.repaired", 1)
    assert found["field"].endswith("laneSection/left")
    assert found["assumed"] == "the road has no lane on this side"
    (note,) = (note for note in result.notes if "road repaired" in note)
    assert "assumed: the road has no lane on this side" in note


def test_strict_refuses_that_road(faulty: Path) -> None:
    with pytest.raises(ScenarioError, match="the left side of a lane section is empty"):
        run(faulty, ads=OneTrick(coast), duration=0.2, roads="strict")


@pytest.fixture
def leaping(scenario: Write) -> Path:
    """A scenario in which another car is somewhere else from 0.5 s on."""
    text = scenario().read_text()
    ego = text[text.index("<ScenarioObject") : text.index("</ScenarioObject>") + len("</ScenarioObject>")]
    place = (
        '<Private entityRef="Other"><PrivateAction><TeleportAction><Position>'
        '<LanePosition roadId="1" laneId="-1" s="40"/></Position></TeleportAction></PrivateAction></Private>'
    )
    return scenario(
        ("</ScenarioObject>", "</ScenarioObject>" + ego.replace('"Ego"', '"Other"')),
        ("</Private></Actions>", f"</Private>{place}</Actions>"),
        ("<StopTrigger>", STEP),
    )


def test_a_leap_of_another_car_is_said_with_its_event(leaping: Path) -> None:
    found = {each["field"]: each for each in run(leaping, ads=OneTrick(coast), duration=1.0).findings}
    leap = found["Other.position"]
    assert (leap["code"], leap["entity"], leap["event"]) == ("dvp.implausible_motion", "Other", "leap")
    assert leap["t"] == pytest.approx(0.6, abs=0.06)
    assert leap["found"] == pytest.approx(20.3, abs=0.7)  # from (40, -1.75) to (60, 1.75)
    assert "position of Other" in said(leap)


def test_play_tells_the_leap_in_its_document(
    leaping: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(leaping.parent)
    assert main(["play", leaping.name, "--duration", "1", "--json"]) == 0
    found = {each.get("field"): each for each in json.loads(capsys.readouterr().out)["findings"]}
    leap = found["Other.position"]
    assert (leap["code"], leap["entity"], leap["event"]) == ("dvp.implausible_motion", "Other", "leap")
    assert leap["t"] == pytest.approx(0.51, abs=0.02)
    assert leap["found"] == pytest.approx(20.3, abs=0.1)  # from (40, -1.75) to (60, 1.75)
