"""One scenario, read as the standard has it and as esmini plays it. Clauses: ASAM OpenSCENARIO XML 1.3."""

from __future__ import annotations

from openscenario.storyboard.reading import READINGS, USUAL
from pytest_dvp.drive.run_spec import SETTINGS, RunSpec

from .conftest import Make, at_time, condition, event, group, lane_position, log, run, speed, story, teleport
from .test_actions import lane_offset

HERE = [teleport(lane_position(100.0)), speed(10.0)]
FASTER = speed(20.0, "linear", "time", 2.0)


def when(*times: float) -> str:
    return "".join(group(condition(at_time(time), edge="rising")) for time in times)


def bouncing(make: Make, reading: str) -> list[tuple[float, str, str]]:
    """An event with executions left is overridden at 1 s and triggered again at 3 s."""
    first = event("first", FASTER, start=when(0.5, 3.0), priority="override", count=2)
    other = event("other", speed(0.0, "linear", "time", 1.0), start=when(1.0), priority="override")
    board = make(A=HERE, stories=story(first, other), reading=reading)
    run(board, 6.0)
    return [each for each in log(board, "event") if each[1] == "first"]


def test_an_event_that_is_overridden_is_complete(make: Make) -> None:
    """8.4.2.2: `A terminated Event moves to completeState with stopTransition, regardless of executions left`."""
    seen = bouncing(make, "standard")
    assert [each for each in seen if each[2] == "startTransition"] == [(0.5, "first", "startTransition")]
    assert seen[-1] == (1.0, "first", "stopTransition")


def test_in_esminis_reading_it_runs_again(make: Make) -> None:
    assert bouncing(make, "esmini")[-4:] == [
        (0.5, "first", "startTransition"),
        (1.0, "first", "endTransition"),
        (3.0, "first", "startTransition"),
        (5.0, "first", "endTransition"),
    ]


def test_without_executions_left_there_is_no_difference(make: Make) -> None:
    logs = []
    for reading in ("standard", "esmini"):
        first = event("first", FASTER, start=when(0.5), priority="override")
        other = event("other", speed(0.0, "linear", "time", 1.0), start=when(1.0), priority="override")
        board = make(A=HERE, stories=story(first, other), reading=reading)
        run(board, 3.0)
        logs.append(log(board, "event"))
    assert logs[0] == logs[1]


def test_a_continuous_offset_ends_in_esminis_reading_alone(make: Make) -> None:
    """class LaneOffsetAction, continuous: `If true it does not end but has to be stopped`. The motion is the same."""
    for reading, ends in (("standard", False), ("esmini", True)):
        target = '<AbsoluteTargetLaneOffset value="0.5"/>'
        board = make(A=HERE, stories=story(event("e", lane_offset(target, continuous=True))), reading=reading)
        run(board, 3.0)
        assert ("endTransition" in {each[2] for each in log(board, "event")}) is ends
        assert abs(board.entities["A"].y - (-1.75 + 0.5)) < 1e-9


def test_a_continuous_offset_from_an_entity_goes_on_in_both(make: Make) -> None:
    for reading in ("standard", "esmini"):
        other = '<RelativeTargetLaneOffset entityRef="B" value="0.5"/>'
        board = make(A=HERE, B=HERE, stories=story(event("e", lane_offset(other, continuous=True))), reading=reading)
        run(board, 3.0)
        assert "endTransition" not in {each[2] for each in log(board, "event")}


def test_what_departs_from_the_standard_is_said(make: Make) -> None:
    target = '<AbsoluteTargetLaneOffset value="0.5"/>'
    first = event("first", FASTER, start=when(0.5), priority="override", count=2)
    other = event("other", lane_offset(target, continuous=True), start=when(1.0), priority="override")
    for reading, codes in (("standard", set()), ("esmini", {"reading-event-again", "reading-offset-ended"})):
        board = make(A=HERE, stories=story(first, other), reading=reading)
        run(board, 4.0)
        said = {finding.code: finding for finding in board.report() if finding.code.startswith("reading")}
        assert set(said) == codes
        assert all(finding.line and "--reading standard" in finding.text for finding in said.values())


def test_an_action_with_nothing_in_it_is_over_at_once_in_both(make: Make) -> None:
    for reading in ("standard", "esmini"):
        board = make(A=HERE, stories=story(event("nothing", "")), reading=reading)
        run(board, 1.0)
        assert (0.0, "nothing", "endTransition") in log(board, "event")


def test_the_setting_offers_just_these_readings() -> None:
    """Written twice: the plugin reads its settings before it may load this package."""
    (setting,) = (each for each in SETTINGS if each.name == "reading")
    assert setting.choices == READINGS
    assert setting.default == RunSpec().reading == USUAL


def test_an_offset_that_is_there_from_the_start_ends_likewise(make: Make) -> None:
    target = '<AbsoluteTargetLaneOffset value="0"/>'
    for reading, ends in (("standard", False), ("esmini", True)):
        board = make(A=HERE, stories=story(event("e", lane_offset(target, continuous=True))), reading=reading)
        run(board, 1.0)
        assert ("endTransition" in {each[2] for each in log(board, "event")}) is ends
        assert any(finding.code == "reading-offset-ended" for finding in board.report()) is ends
