"""Element states: starts, ends, priorities, execution counts, stop triggers, and what is reported afterwards."""

from __future__ import annotations

import pytest

from .conftest import (
    Make,
    at_time,
    condition,
    event,
    group,
    lane_position,
    log,
    relative_speed,
    run,
    speed,
    state_of,
    story,
    teleport,
)

HERE = [teleport(lane_position(100.0)), speed(10.0)]
RAMP = speed(20.0, "linear", "time", 2.0)


def when(value: float) -> str:
    return group(condition(at_time(value)))


def test_a_story_runs_from_start_to_end(make: Make) -> None:
    board = make(A=HERE, stories=story(event("e", RAMP, start=when(1.0))))
    run(board, 4.0)
    assert log(board, "event") == [
        (0.0, "e", "initToStandbyTransition"),
        (1.0, "e", "startTransition"),
        (3.0, "e", "endTransition"),
    ]
    assert [each[:2] for each in log(board, "maneuver", "maneuverGroup", "act", "story")[-4:]] == [
        (3.0, "maneuver"),
        (3.0, "group"),
        (3.0, "act"),
        (3.0, "story"),
    ]


def test_an_event_without_trigger_starts_with_its_maneuver(make: Make) -> None:
    board = make(A=HERE, stories=story(event("e", RAMP)))
    run(board, 0.1)
    assert (0.0, "e", "startTransition") in log(board, "event")


def test_an_act_waits_for_its_trigger(make: Make) -> None:
    board = make(A=HERE, stories=story(event("e", RAMP), start=f"<StartTrigger>{when(0.5)}</StartTrigger>"))
    run(board, 1.0)
    assert (0.5, "act", "startTransition") in log(board, "act")
    assert (0.5, "e", "startTransition") in log(board, "event")


def test_a_stop_trigger_stops_everything_below(make: Make) -> None:
    stop = f"<StopTrigger>{when(1.5)}</StopTrigger>"
    board = make(A=HERE, stories=story(event("e", RAMP, start=when(1.0)), stop=stop))
    run(board, 4.0)
    assert (1.5, "e", "stopTransition") in log(board, "event")
    assert (1.5, "act", "stopTransition") in log(board, "act")
    assert board.entities["A"].speed == 12.5


def test_the_storyboard_ends_with_its_stop_trigger(make: Make) -> None:
    board = make(A=HERE, stories=story(event("e", RAMP)), stop=when(1.0))
    run(board, 4.0)
    assert board.done
    assert board.time == 1.0


def test_override_stops_the_running_event(make: Make) -> None:
    second = event("second", speed(0.0, "linear", "time", 1.0), start=when(1.0), priority="override")
    board = make(A=HERE, stories=story(event("first", RAMP), second))
    run(board, 3.0)
    assert (1.0, "first", "stopTransition") in log(board, "event")
    assert board.entities["A"].speed == 0.0


def test_skip_does_not_start_while_another_event_runs(make: Make) -> None:
    late = event("late", speed(0.0), start=group(condition(at_time(1.0), edge="rising")), priority="skip")
    board = make(A=HERE, stories=story(event("first", RAMP), late))
    run(board, 3.0)
    assert (1.0, "late", "skipTransition") in log(board, "event")
    assert board.entities["A"].speed == 20.0


def test_a_skipped_event_with_executions_left_waits_for_its_next_trigger(make: Make) -> None:
    """8.4.2.1 (1.3): executions are the sum of startTransitions and skipTransitions."""
    again = group(condition(at_time(1.0), edge="rising")) + group(condition(at_time(2.5), edge="rising"))
    late = event("late", speed(5.0), start=again, priority="skip", count=2)
    board = make(A=HERE, stories=story(event("first", RAMP), late))
    run(board, 3.0)
    assert log(board, "event")[-3:] == [
        (2.0, "first", "endTransition"),
        (2.5, "late", "startTransition"),
        (2.5, "late", "endTransition"),
    ]


def test_a_skipped_event_without_executions_left_is_complete(make: Make) -> None:
    late = event("late", speed(5.0), start=when(1.0), priority="skip")
    board = make(A=HERE, stories=story(event("first", RAMP), late))
    run(board, 3.0)
    skipped = [each for each in board.transitions if each.element == "late"][1:]
    assert [(each.time, each.transition, each.to_state) for each in skipped] == [
        (1.0, "skipTransition", "completeState")
    ]
    assert board.entities["A"].speed == 20.0
    assert (2.0, "maneuver", "endTransition") in log(board, "maneuver")


def test_parallel_events_of_different_domains_run_together(make: Make) -> None:
    again = event("again", speed(15.0, "linear", "time", 1.0), start=when(2.5))
    board = make(A=HERE, stories=story(event("first", RAMP), again))
    run(board, 4.0)
    assert [each for each in log(board, "event") if each[2] == "endTransition"] == [
        (2.0, "first", "endTransition"),
        (3.5, "again", "endTransition"),
    ]


def test_a_new_action_in_the_same_domain_ends_the_old_one(make: Make) -> None:
    again = event("again", speed(0.0, "linear", "time", 1.0), start=when(1.0), priority="parallel")
    board = make(A=HERE, stories=story(event("first", RAMP), again))
    run(board, 3.0)
    assert (1.0, "first-0", "stopTransition") in log(board, "action")
    assert board.entities["A"].speed == 0.0


def test_an_action_on_a_selection_is_overridden_for_all_of_it(make: Make) -> None:
    """7.5.1 (1.3): if there is a conflict for one entity, all others of the selection are treated so as well."""
    both = '<EntitySelection name="both"><Members><EntityRef entityRef="A"/><EntityRef entityRef="B"/></Members>'
    ramp = speed(30.0, "linear", "time", 2.0)
    alone = story(event("alone", speed(10.0), start=when(1.0))).replace("story", "other")
    board = make(
        A=HERE,
        B=[teleport(lane_position(50.0)), speed(10.0)],
        stories=story(event("ramp", ramp), actor="both") + alone,
        selections=f"{both}</EntitySelection>",
    )
    run(board, 3.0)
    assert (1.0, "ramp-0", "stopTransition") in log(board, "action")
    assert board.entities["B"].speed == pytest.approx(20.0, abs=0.2)  # half of the ramp from 10 to 30 m/s


def test_an_action_of_two_actors_goes_on_for_the_other(make: Make) -> None:
    ramp = event("ramp", speed(30.0, "linear", "time", 2.0))
    alone = story(event("alone", speed(10.0), start=when(1.0))).replace("story", "other")
    pair = story(ramp).replace('<EntityRef entityRef="A"/>', '<EntityRef entityRef="A"/><EntityRef entityRef="B"/>')
    board = make(A=HERE, B=[teleport(lane_position(50.0)), speed(10.0)], stories=pair + alone)
    run(board, 3.0)
    assert (2.0, "ramp-0", "endTransition") in log(board, "action")
    assert (board.entities["A"].speed, board.entities["B"].speed) == (10.0, 30.0)


def test_an_event_runs_as_often_as_it_may(make: Make) -> None:
    follow = group(condition(state_of("event", "other", "endTransition")))
    other = event("other", speed(11.0, "linear", "time", 0.5), start=when(0.5), count=2)
    counted = event("counted", speed(12.0), start=follow, count=2)
    board = make(A=HERE, stories=story(other, counted))
    run(board, 3.0)
    assert len([each for each in log(board, "event") if each[1:] == ("counted", "startTransition")]) == 2
    assert board.transitions[-1].to_state == "completeState"


def test_transitions_carry_the_place_in_the_file(make: Make) -> None:
    board = make(A=HERE, stories=story(event("e", RAMP)))
    run(board, 0.1)
    start = next(each for each in board.transitions if each.element == "e")
    assert start.file.endswith("scenario.xosc")
    assert start.line > 1


def test_an_event_that_never_fired_is_reported_with_its_line(make: Make) -> None:
    board = make(A=HERE, stories=story(event("never", RAMP, start=when(99.0)), event("e", RAMP)))
    run(board, 3.0)
    found = [each for each in board.report() if each.code == "event-never-fired"]
    assert [each.element.split("/")[-1] for each in found] == ["Event[never]"]
    assert found[0].line is not None
    assert "never true" in found[0].message


def test_an_edge_that_was_true_from_the_start_is_reported(make: Make) -> None:
    blind = group(condition(at_time(0.0), name="blind", edge="rising"))
    board = make(A=HERE, stories=story(event("e", RAMP, start=blind)))
    run(board, 1.0)
    assert any(each.code == "edge-true-from-start" and "'blind'" in each.message for each in board.report())


def test_an_act_that_never_ended_is_reported(make: Make) -> None:
    endless = relative_speed(
        '<RelativeTargetSpeed entityRef="B" value="1" speedTargetValueType="factor" continuous="true"/>'
    )
    board = make(A=HERE, B=HERE, stories=story(event("e", endless)))
    run(board, 1.0)
    assert any(each.code == "act-never-ended" for each in board.report())


def test_nothing_is_reported_when_all_went_well(make: Make) -> None:
    board = make(A=HERE, stories=story(event("e", RAMP, start=when(0.5))))
    run(board, 4.0)
    assert board.report() == ()
