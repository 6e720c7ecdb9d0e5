"""What stopping does to elements that may run again: states of ASAM OpenSCENARIO XML 1.3, section 8.4.

An event ends an execution (endTransition) when its actions have ended, however they did, and then waits in standbyState
while it has executions left; an element that is stopped goes to completeState by a stopTransition "regardless of the
number of executions left" (8.4.2.2), and never runs again.
"""

from __future__ import annotations

import pytest

from openscenario.storyboard.engine import Storyboard
from tests.unit.storyboard.conftest import (
    Make,
    at_time,
    condition,
    event,
    group,
    lane_position,
    run,
    speed,
    story,
    teleport,
)
from tests.unit.storyboard.conftest import make as make
from tests.unit.storyboard.conftest import network as network
from tests.unit.storyboard.conftest import road as road

HERE = [teleport(lane_position(100.0)), speed(10.0)]
RAMP = speed(20.0, "linear", "time", 2.0)  # from 10 m/s: 5 m/s^2
STOP = f"<StopTrigger>{group(condition(at_time(1.5)))}</StopTrigger>"


def steps_of(board: Storyboard, name: str) -> list[tuple[float, str, str]]:
    return [(round(e.time, 2), e.transition, e.to_state) for e in board.transitions if e.element == name]


def stopped(make: Make, count: int, groups: int = 1) -> Storyboard:
    """An event that starts at 1 s and would run until 3 s, in an act that is stopped at 1.5 s."""
    inside = story(event("e", RAMP, start=group(condition(at_time(1.0))), count=count), stop=STOP)
    board = make(A=HERE, stories=inside.replace('name="group" maximumExecutionCount="1"',
                                                f'name="group" maximumExecutionCount="{groups}"'))  # fmt: skip
    run(board, 4.0)
    return board


@pytest.mark.parametrize("count", [2, 3])
def test_an_event_with_executions_left_ends_this_one_before_it_is_stopped(make: Make, count: int) -> None:
    assert steps_of(stopped(make, count), "e")[1:] == [
        (1.0, "startTransition", "runningState"),
        (1.5, "endTransition", "standbyState"),
        (1.5, "stopTransition", "completeState"),
    ]


def test_an_event_on_its_last_execution_is_stopped_as_it_runs(make: Make) -> None:
    assert steps_of(stopped(make, 1), "e")[1:] == [
        (1.0, "startTransition", "runningState"),
        (1.5, "stopTransition", "completeState"),
    ]


def test_a_group_with_executions_left_ends_this_one_before_it_is_stopped(make: Make) -> None:
    assert steps_of(stopped(make, 1, groups=2), "group")[1:] == [
        (1.5, "endTransition", "standbyState"),
        (1.5, "stopTransition", "completeState"),
    ]
    assert [each[1] for each in steps_of(stopped(make, 1), "group")] == ["startTransition", "stopTransition"]


def test_what_was_stopped_moves_nothing_and_never_runs_again(make: Make) -> None:
    """Half a second of 5 m/s^2 from 10 m/s, and the condition of the event stays true to the end."""
    board = stopped(make, 3)
    assert board.entities["A"].speed == pytest.approx(12.5)
    assert [e.element for e in board.transitions if e.transition == "startTransition"].count("e-0") == 1
    assert steps_of(board, "e-0")[-1] == (1.5, "stopTransition", "completeState")


def test_what_waits_is_stopped_without_an_end(make: Make) -> None:
    """The event waits for 9 s; its action never began, so that nothing of it is told."""
    waiting = event("e", RAMP, start=group(condition(at_time(9.0))), count=2)
    board = make(A=HERE, stories=story(waiting, stop=STOP))
    run(board, 2.0)
    assert [each[1] for each in steps_of(board, "e")] == ["initToStandbyTransition", "stopTransition"]
    assert steps_of(board, "e-0") == []


def test_an_event_that_has_ended_on_its_own_waits_and_is_then_stopped(make: Make) -> None:
    """The ramp takes 0.2 s: it ends at 1.2 s, before the act is stopped."""
    rising = group(condition(at_time(1.0), edge="rising"))
    short = event("e", speed(11.0, "linear", "time", 0.2), start=rising, count=2)
    board = make(A=HERE, stories=story(short, stop=STOP))
    run(board, 2.0)
    assert steps_of(board, "e")[1:] == [
        (1.0, "startTransition", "runningState"),
        (1.2, "endTransition", "standbyState"),
        (1.5, "stopTransition", "completeState"),
    ]


def test_a_group_without_manoeuvres_has_nothing_that_could_end(make: Make) -> None:
    """No event ends an execution of it, so it is stopped as it runs."""
    empty = story(stop=STOP).replace('<Maneuver name="maneuver"></Maneuver>', "")
    board = make(A=HERE, stories=empty.replace('maximumExecutionCount="1"', 'maximumExecutionCount="2"'))
    run(board, 2.0)
    assert [each[1] for each in steps_of(board, "group")] == ["startTransition", "stopTransition"]
