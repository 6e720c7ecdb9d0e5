"""Events of a storyboard: each is one, and those that wait for a crash are known."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from openscenario.read import read_scenario
from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.event_names import EventNames

Write = Callable[..., Path]


def group(name: str, event: str, condition: str) -> str:
    return f"""<ManeuverGroup name="{name}" maximumExecutionCount="1">
      <Actors selectTriggeringEntities="false"><EntityRef entityRef="Ego"/></Actors>
      <Maneuver name="m"><Event name="{event}" priority="parallel"><Action name="a"><PrivateAction><LongitudinalAction>
        <SpeedAction><SpeedActionDynamics dynamicsShape="step" value="0" dynamicsDimension="time"/>
        <SpeedActionTarget><AbsoluteTargetSpeed value="4"/></SpeedActionTarget></SpeedAction>
      </LongitudinalAction></PrivateAction></Action>
      <StartTrigger><ConditionGroup><Condition name="c" delay="0" conditionEdge="none">{condition}</Condition>
      </ConditionGroup></StartTrigger></Event></Maneuver></ManeuverGroup>"""


def at(time: float) -> str:
    inner = f'<SimulationTimeCondition value="{time}" rule="greaterThan"/>'
    return f"<ByValueCondition>{inner}</ByValueCondition>"


CRASH = (
    '<ByEntityCondition><TriggeringEntities triggeringEntitiesRule="any"><EntityRef entityRef="Ego"/>'
    '</TriggeringEntities><EntityCondition><CollisionCondition><ByType type="vehicle"/></CollisionCondition>'
    "</EntityCondition></ByEntityCondition>"
)


def with_groups(*groups: str) -> tuple[str, str]:
    story = f'<Story name="s"><Act name="a">{"".join(groups)}<StartTrigger/></Act></Story>'
    return "<StopTrigger>", f"{story}<StopTrigger>"


def test_the_summary_of_a_play_tells_events_of_one_name_apart(
    scenario: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    path = scenario(
        with_groups(group("B", "Start", at(1.0)), group("C", "Start", at(99.0)), group("D", "End", at(2.0)))
    )
    assert main(["play", str(path), "--json"]) == 0
    events = json.loads(capsys.readouterr().out)["events"]
    assert list(events) == ["B::m::Start", "C::m::Start", "End"]
    assert events["B::m::Start"] == pytest.approx(1.0, abs=0.02)
    assert events["C::m::Start"] is None
    assert main(["play", str(path)]) == 0
    assert "event C::m::Start: never fired" in capsys.readouterr().out


def test_an_event_waits_for_a_collision_if_nothing_else_can_start_it(scenario: Write) -> None:
    path = scenario(with_groups(group("B", "AtCollision", CRASH), group("C", "Start", at(1.0))))
    names = EventNames(read_scenario(path))
    assert names.of_collisions("Ego") == ["AtCollision"]
    assert names.of_collisions("Other") == []
