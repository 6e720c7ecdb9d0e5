"""What is accepted and does nothing is said, once a file and kind, by check, play and run."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from openscenario.no_effect import NO_EFFECT, SENSORS, without_effect
from openscenario.read import read_scenario
from openscenario.storyboard.registry import action_factories
from pytest_dvp.cli.command_line import main
from vehicle.messages import SEEING

Write = Callable[..., Path]
HIDE = (
    '<PrivateAction><VisibilityAction graphics="false" sensors="false" traffic="true"/></PrivateAction>\n'
    '<PrivateAction><VisibilityAction graphics="false" sensors="true" traffic="true"/></PrivateAction>\n'
)
SAID = (
    "accepted, no effect here: VisibilityAction graphics, 2 times, first here "
    "(nothing is drawn from the scenario while it runs)"
)


@pytest.fixture
def hidden(scenario: Write, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = scenario(('<Private entityRef="Ego">', f'<Private entityRef="Ego">\n{HIDE}'))
    (path.parent / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(path.parent)
    return path


def line_of(path: Path) -> int:
    return next(n for n, line in enumerate(path.read_text().splitlines(), start=1) if "VisibilityAction" in line)


def test_it_is_what_the_storyboard_accepts_only() -> None:
    kinds = {kind for kind, factory in action_factories().items() if factory.__module__.endswith(".accepted")}
    assert set(NO_EFFECT) == kinds


def test_the_check_says_it_and_finds_nothing_wrong(hidden: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "x.xosc", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["findings"] == []
    assert [(note["line"], note["message"]) for note in document["notes"]] == [(line_of(hidden), SAID)]
    assert main(["check", "x.xosc"]) == 0
    assert f"x.xosc:{line_of(hidden)}: note: {SAID}" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["play"], ["run", "--duration", "0.2", "--no-report"]], ids=["play", "run"])
def test_play_and_run_say_it_as_well(command: list[str], hidden: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main([command[0], "x.xosc", *command[1:]])
    assert capsys.readouterr().err.count(SAID) == 1


PROFILE = (
    '<PrivateAction><LongitudinalAction><SpeedProfileAction followingMode="{}"><DynamicConstraints '
    'maxAccelerationRate="2"/><SpeedProfileEntry speed="5" time="1"/></SpeedProfileAction></LongitudinalAction>'
    "</PrivateAction>"
)
SEEN = (
    '<PrivateAction><VisibilityAction graphics="true" sensors="false" traffic="true"><SensorReferenceSet>'
    '<SensorReference name="{}"/></SensorReferenceSet></VisibilityAction></PrivateAction>'
)


@pytest.mark.parametrize(
    ("action", "said"),
    [
        (SEEN.format("Camera"), []),
        (SEEN.format("radar"), ["SensorReference radar (sensors are called lidar and camera here)"]),
        (PROFILE.format("follow"), []),
        (
            PROFILE.format("position"),
            ["limits of jerk in a SpeedProfileAction (mode position is strictly linear; mode follow obeys them)"],
        ),
    ],
)
def test_attributes_that_change_nothing_are_said(scenario: Write, action: str, said: list[str]) -> None:
    path = scenario(('<Private entityRef="Ego">', f'<Private entityRef="Ego">\n{action}'))
    notes = without_effect(read_scenario(path))
    assert [note.message.removeprefix("accepted, no effect here: ") for note in notes] == said


def test_the_sensors_that_a_scenario_may_name_are_those_that_see() -> None:
    assert SENSORS == SEEING
