"""Findings about what never happens: transitions that take no time, scenarios that nothing ends."""

from __future__ import annotations

import pytest
from xosc_samples import Spoil, line_of

from openscenario.read import check_scenario

LATER = '<SimulationTimeCondition value="1.0" rule="greaterThan"/>'
STOP = "<StopTrigger/>"


def trigger(test: str, edge: str = "none", tag: str = "StopTrigger") -> str:
    condition = f'<Condition name="c" delay="0" conditionEdge="{edge}"><ByValueCondition>{test}</ByValueCondition>'
    return f"<{tag}><ConditionGroup>{condition}</Condition></ConditionGroup></{tag}>"


def time(value: float, rule: str) -> str:
    return f'<SimulationTimeCondition value="{value}" rule="{rule}"/>'


def state(kind: str, name: str, state: str) -> str:
    return (
        f'<StoryboardElementStateCondition storyboardElementType="{kind}" storyboardElementRef="{name}" '
        f'state="{state}"/>'
    )


NEVER = time(-1.0, "lessThan")


def found(path: object, code: str) -> list[tuple[str, int | None, str]]:
    return [
        (finding.severity, finding.line, finding.text)
        for finding in check_scenario(path)  # type: ignore[arg-type]
        if finding.code == code
    ]


@pytest.mark.parametrize(
    ("dynamics", "code", "text"),
    [
        ('dynamicsShape="sinusoidal" value="0" dynamicsDimension="time"', "value.no_transition", "is a step"),
        ('dynamicsShape="cubic" value="0.0" dynamicsDimension="distance"', "value.no_transition", "is a step"),
        ('dynamicsShape="linear" value="0" dynamicsDimension="rate"', "value.no_transition", "never ends"),
        ('dynamicsShape="step" value="3" dynamicsDimension="time"', "value.step_with_duration", "no time"),
    ],
)
def test_a_transition_that_takes_no_time_is_said(spoil: Spoil, dynamics: str, code: str, text: str) -> None:
    path = spoil('dynamicsShape="sinusoidal" value="3.0" dynamicsDimension="time"', dynamics)
    ((severity, line, said),) = found(path, code)
    assert (severity, line) == ("warning", line_of(path, "LaneChangeActionDynamics"))
    assert text in said


@pytest.mark.parametrize(
    "dynamics",
    [
        'dynamicsShape="step" value="0" dynamicsDimension="time"',
        'dynamicsShape="step" value="4" dynamicsDimension="rate"',
        'dynamicsShape="cubic" value="0.1" dynamicsDimension="time"',
    ],
)
def test_others_are_not(spoil: Spoil, dynamics: str) -> None:
    path = spoil('dynamicsShape="sinusoidal" value="3.0" dynamicsDimension="time"', dynamics)
    assert found(path, "value.no_transition") == found(path, "value.step_with_duration") == []


def test_acts_that_end_are_enough(spoil: Spoil) -> None:
    assert found(spoil(), "storyboard.never_ends") == []


@pytest.mark.parametrize(
    "never",
    [
        NEVER,
        time(-1.0, "equalTo"),
        '<ParameterCondition parameterRef="EgoSpeed" rule="lessThan" value="10"/>',
        state("event", "event", "endTransition"),  # it waits for itself
        state("act", "act", "completeState"),
    ],
)
def test_an_event_that_can_never_start_keeps_its_act_for_ever(spoil: Spoil, never: str) -> None:
    path = spoil(LATER, never)
    path.write_text(path.read_text().replace('conditionEdge="rising"', 'conditionEdge="none"'))
    ((severity, line, text),) = found(path, "storyboard.never_ends")
    assert (severity, line) == ("warning", line_of(path, STOP))
    assert "act 'act' can never end: event 'event'" in text
    assert "has no stop trigger" in text


@pytest.mark.parametrize(
    ("test", "edge"),
    [
        (NEVER, "none"),
        (time(0.0, "lessThan"), "none"),
        (time(5.0, "lessThan"), "rising"),
        (time(5.0, "greaterThan"), "falling"),
        (time(-2.0, "notEqualTo"), "risingOrFalling"),
        ('<ParameterCondition parameterRef="EgoSpeed" rule="equalTo" value="11"/>', "none"),
        ('<ParameterCondition parameterRef="EgoSpeed" rule="equalTo" value="10"/>', "rising"),
        (state("act", "act", "completeState"), "none"),
    ],
)
def test_a_stop_trigger_may_be_one_that_never_comes(spoil: Spoil, test: str, edge: str) -> None:
    path = spoil(LATER, NEVER)
    path.write_text(path.read_text().replace(STOP, trigger(test, edge)))
    ((_, line, text),) = found(path, "storyboard.never_ends")
    assert line == line_of(path, "<StopTrigger>")
    assert "its stop trigger can never become true" in text


@pytest.mark.parametrize(
    ("test", "edge"),
    [
        (time(5.0, "greaterThan"), "rising"),
        (time(5.0, "lessThan"), "falling"),
        (time(5.0, "lessThan"), "none"),
        (time(0.0, "equalTo"), "none"),
        ('<ParameterCondition parameterRef="EgoSpeed" rule="equalTo" value="10.0"/>', "none"),
        (state("act", "act", "runningState"), "rising"),
        (state("action", "action", "stopTransition"), "none"),
        ('<UserDefinedValueCondition name="x" rule="equalTo" value="1"/>', "none"),
    ],
)
def test_one_that_may_come_is_no_finding(spoil: Spoil, test: str, edge: str) -> None:
    path = spoil(LATER, NEVER)
    path.write_text(path.read_text().replace(STOP, trigger(test, edge)))
    assert found(path, "storyboard.never_ends") == []


def test_events_that_wait_for_each_other_wait_for_ever(spoil: Spoil) -> None:
    """A second event waits for the first, which waits for the second; with a time for the first both come."""
    path = spoil(LATER, state("event", "second", "completeState"))
    text = path.read_text().replace('conditionEdge="rising"', 'conditionEdge="none"')
    start, end = text.index("<Event name="), text.index("</Event>") + len("</Event>")
    first = text[start:end]
    second = first.replace('name="event"', 'name="second"').replace('Ref="second"', 'Ref="event"')
    path.write_text(text[:end] + second + text[end:])
    assert "event 'event'" in found(path, "storyboard.never_ends")[0][2]
    path.write_text(path.read_text().replace(state("event", "second", "completeState"), LATER))
    assert found(path, "storyboard.never_ends") == []


def test_a_stop_trigger_of_the_act_ends_it(spoil: Spoil) -> None:
    path = spoil(LATER, NEVER)
    path.write_text(path.read_text().replace("</Act>", trigger(time(9.0, "greaterThan")) + "</Act>"))
    assert found(path, "storyboard.never_ends") == []


@pytest.mark.parametrize(("actor", "says"), [("Other", True), ("Ego", False)])
def test_an_action_without_an_end_is_one_unless_the_ego_is_only_asked(spoil: Spoil, actor: str, says: bool) -> None:
    path = spoil()
    text = path.read_text()
    car = text[text.index("<ScenarioObject") : text.index("</Entities>")]
    text = text.replace("</Entities>", car.replace('name="Ego"', 'name="Other"') + "</Entities>")
    text = text.replace('<EntityRef entityRef="Ego"/></Actors>', f'<EntityRef entityRef="{actor}"/></Actors>')
    start, end = text.index("<LateralAction>"), text.index("</LateralAction>") + len("</LateralAction>")
    keep = (
        '<LongitudinalAction><LongitudinalDistanceAction entityRef="Ego" continuous="true" freespace="true" '
        'distance="9"/></LongitudinalAction>'
    )
    path.write_text(text[:start] + keep + text[end:])
    said = found(path, "storyboard.never_ends")
    assert bool(said) is says
    assert all("event 'event'" in each[2] and "for ever" in each[2] for each in said)
