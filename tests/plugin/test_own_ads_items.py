"""Scenario items with a driving stack of one's own, named by option, ini or environment."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

# See conftest.py: what inner sessions would import must be here before them.
import ads.stack  # noqa: F401
import reports.html  # noqa: F401
import vehicle.twin  # noqa: F401
from pytest_dvp.cli.command_line import main
from tests.plugin.conftest import XOSC, write_scenario

STACK = """
from vehicle.messages import Command


class Stack:
    def tick(self, observation):
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)
"""


@pytest.fixture
def own(pytester: pytest.Pytester) -> pytest.Pytester:
    """A project with a scenario and a stack, and no settings."""
    write_scenario(pytester.path, "x.xosc")
    (pytester.path / "my_stack.py").write_text(STACK)
    pytester.makeini("[pytest]\naddopts = --strict-config -W error -p no:cacheprovider")
    return pytester


def test_it_is_named_in_header_and_junit_and_in_the_replay(own: pytest.Pytester) -> None:
    result = own.runpytest_inprocess("x.xosc", "-m", "dt", "--dvp-ads", "my_stack.py:Stack", "--junitxml=out.xml")
    result.assert_outcomes(passed=1, deselected=2)
    result.stdout.fnmatch_lines(["dvp: *, ADS my_stack.py:Stack, *"])
    found = {p.get("name"): p.get("value") for p in ET.parse(own.path / "out.xml").iter("property")}
    assert found["ads"] == "my_stack.py:Stack"
    assert str(found["replay"]).endswith("--ads my_stack.py:Stack")
    assert found["report"] == "runs/0001-x-dt/report.html"
    assert "max_jerk" in found  # measured, although no gate judges it


def test_an_ini_file_names_it_from_its_own_folder(own: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    own.makeini("[pytest]\naddopts = -p no:cacheprovider\ndvp_ads = my_stack.py:Stack")
    (own.path / "below").mkdir()
    monkeypatch.chdir(own.path / "below")
    result = own.runpytest_inprocess("../x.xosc", "-m", "dt")
    result.assert_outcomes(passed=1, deselected=2)
    result.stdout.fnmatch_lines(["dvp: *, ADS my_stack.py:Stack (ini dvp_ads), *"])


def test_a_stack_made_in_a_test_has_no_false_replay(own: pytest.Pytester) -> None:
    own.makepyfile(
        test_mine="""
        from my_stack import Stack

        def test_it(run, gate):
            gate(run("x.xosc", ads=lambda: Stack(), duration=0.5), metrics=["scenario_ended"])
        """
    )
    result = own.runpytest_inprocess("test_mine.py", "-p", "no:cacheprovider")
    result.assert_outcomes(failed=1)
    shown = result.stdout.str()
    assert "no command line can name the ADS test_it.<locals>.<lambda>" in shown
    assert "judged there: scenario_ended" in shown
    assert "dvp run" not in shown


def test_a_failure_by_chosen_gates_is_replayed_with_them(own: pytest.Pytester) -> None:
    own.makepyfile(
        test_mine="""
        def test_it(run, gate):
            gate(run("x.xosc", duration=0.5), metrics=["scenario_ended"])
        """
    )
    result = own.runpytest_inprocess("test_mine.py")
    result.stdout.fnmatch_lines(["dvp run x.xosc --seed 7 --duration 0.5 --gate scenario_ended"])


def test_a_storyboard_without_an_event_that_fired_is_not_a_pass(own: pytest.Pytester) -> None:
    never = """<Story name="S"><Act name="A"><ManeuverGroup name="G" maximumExecutionCount="1">
      <Actors selectTriggeringEntities="false"><EntityRef entityRef="Ego"/></Actors>
      <Maneuver name="M"><Event name="Brake" priority="override">
        <Action name="brake"><PrivateAction><LongitudinalAction><SpeedAction>
          <SpeedActionDynamics dynamicsShape="step" value="0" dynamicsDimension="time"/>
          <SpeedActionTarget><AbsoluteTargetSpeed value="0"/></SpeedActionTarget>
        </SpeedAction></LongitudinalAction></PrivateAction></Action>
        <StartTrigger><ConditionGroup><Condition name="late" delay="0" conditionEdge="none">
          <ByValueCondition><SimulationTimeCondition value="900" rule="greaterThan"/></ByValueCondition>
        </Condition></ConditionGroup></StartTrigger>
      </Event></Maneuver></ManeuverGroup>
      <StartTrigger><ConditionGroup><Condition name="at once" delay="0" conditionEdge="none">
        <ByValueCondition><SimulationTimeCondition value="0" rule="greaterOrEqual"/></ByValueCondition>
      </Condition></ConditionGroup></StartTrigger>
    </Act></Story>
    <StopTrigger>"""
    write_scenario(own.path, "x.xosc", XOSC.replace("<StopTrigger>", never))
    result = own.runpytest_inprocess("x.xosc", "-m", "dt")
    result.assert_outcomes(failed=1, deselected=2)
    result.stdout.fnmatch_lines(
        ["INCONCLUSIVE x.xosc::dt storyboard INCONCLUSIVE: event 'Brake' never fired", "x.xosc::dt: *'Brake'*"]
    )
    own.makepyfile(
        test_mine="""
        def test_it(run, gate):
            gate(run("x.xosc"), metrics=["collision"])

        def test_it_need_not_fire(run, gate):
            gate(run("x.xosc"), metrics=["collision"], optional_events=["Brake"])
        """
    )
    result = own.runpytest_inprocess("test_mine.py")
    result.assert_outcomes(failed=1, passed=1)
    result.stdout.fnmatch_lines(["*event 'Brake' never fired*"])
    words = ["run", "x.xosc", "--no-report", "--gate", "collision"]
    assert [main([*words, *more]) for more in ([], ["--optional-event", "Brake"], ["--optional-event", "Brke"])] == [
        1, 0, 2,
    ]  # fmt: skip


TUNABLE = """
from vehicle.messages import Command


class Stack:
    parameters = {"LK_look": 1.2}

    def __init__(self, parameters, network, description):
        self.trace = dict(parameters)

    def tick(self, observation):
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)
"""


def test_a_session_sets_the_stacks_own_parameters_and_others_do_not_get_them(own: pytest.Pytester) -> None:
    (own.path / "my_stack.py").write_text(TUNABLE)
    own.makepyfile(
        test_mine="""
        def test_it(run):
            assert run("x.xosc", duration=0.2).log.meta["P"] == {"LK_look": 1.0}
            assert run("x.xosc", duration=0.2, P={"LK_look": 2.0}).log.meta["P"] == {"LK_look": 2.0}
            assert "LK_look" not in run("x.xosc", duration=0.2, ads="reference").log.meta["P"]
        """
    )
    chosen = ("--dvp-ads", "my_stack.py:Stack", "--dvp-set", "P.LK_look=1.0")
    own.runpytest_inprocess("test_mine.py", *chosen).assert_outcomes(passed=1)
    refused = own.runpytest_inprocess("test_mine.py", *chosen[:3], "P.LK_lok=1.0")
    assert refused.ret == pytest.ExitCode.USAGE_ERROR
    said = "--dvp-set: ADS my_stack.py:Stack: unknown parameter 'LK_lok', did you mean 'LK_look'?"
    refused.stderr.fnmatch_lines([f"*{said}"])
