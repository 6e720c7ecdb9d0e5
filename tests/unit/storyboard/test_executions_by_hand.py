"""How elements of a storyboard start, end, begin again and displace each other: on nodes without a scenario."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.storyboard import engine
from openscenario.storyboard.engine import Held, Storyboard
from openscenario.storyboard.nodes import COMPLETE, END, INIT, RUNNING, SKIP, STANDBY, START, STOP, TO_STANDBY, Node

from .bodies import car


class Private:
    """An action of an entity."""

    XML = "PrivateAction/Fake"


class Global:
    """An action of nobody."""

    XML = "GlobalAction/Fake"


class Runner:
    """Runs until it is told that it is over; `at_once`: has nothing left to do after its start."""

    def __init__(self, *domains: str, at_once: bool = False) -> None:
        self.domains, self.at_once = domains, at_once
        self.done = self.stopped = False
        self.steps = 0

    def start(self) -> bool:
        return self.at_once

    def step(self, dt: float) -> bool:
        self.steps += 1
        return self.done

    def stop(self) -> None:
        self.stopped = True

    def ask(self) -> tuple[str, dict[str, Any], float]:
        return "something", {}, 1.0


class Trigger:
    """True when it is told so; counts how often it was forgotten."""

    def __init__(self, value: bool = False) -> None:
        self.value, self.resets = value, 0
        self.entities: tuple[str, ...] = ()

    def evaluate(self, time: float) -> bool:
        return self.value

    def reset(self) -> None:
        self.resets += 1


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Runner, str | None]]:
    """Runners that actions made, with their entities; an action's element says which."""
    found: list[tuple[Runner, str | None]] = []

    def make(element: Any, entity: Any, board: Any) -> Runner:
        runner = element.runner()
        found.append((runner, None if entity is None else entity.name))
        return runner

    monkeypatch.setattr(engine, "action_factories", lambda: {Private: make, Global: make})
    return found


def a_board(**more: Any) -> Any:
    """A storyboard that runs, with two cars and nothing in it."""
    board: Any = object.__new__(Storyboard)
    fields = {"time": 2.5, "steps": 3, "transitions": [], "_active": [], "_begun": [], "running": True, "warnings": [],
              "requests": [], "reading": "esmini", "entities": {name: car(name) for name in "AB"}, "selections": {},
              "done": False, "root": Node("storyboard", "storyBoard", None)}  # fmt: skip
    for name, value in (fields | more).items():
        setattr(board, name, value)
    return board


def a_group(board: Any, *actors: str, maximum: int = 1) -> Node:
    """A manoeuvre in its group, act and story; the group acts on `actors`."""
    story = Node("story", "s", board.root)
    act = Node("act", "a", story)
    group = Node("maneuverGroup", "g", act, maximum=maximum)
    told: Any = SimpleNamespace(entity_refs=[SimpleNamespace(entity_ref=name) for name in actors],
                                select_triggering_entities=False)  # fmt: skip
    group.actors = told
    return Node("maneuver", "m", group)


def an_event(maneuver: Node, name: str, *actions: Any, **more: Any) -> Node:
    event = Node("event", name, maneuver, **more)
    for number, element in enumerate(actions):
        Node("action", f"{name}-{number}", event, element=element)
    return event


def doing(*domains: str, at_once: bool = False, nobody: bool = False) -> Any:
    element: Any = Global() if nobody else Private()
    element.runner = lambda: Runner(*domains, at_once=at_once)
    return element


def told(board: Any) -> list[tuple[str, str, str]]:
    return [(each.element, each.transition, each.to_state) for each in board.transitions]


def test_a_story_starts_all_that_waits_for_nothing_and_events_stand_by() -> None:
    board = a_board()
    maneuver = a_group(board, "A")
    event = an_event(maneuver, "e")
    (story,) = board.root.children
    waiting = Node("act", "later", story)
    waiting.waits = True
    board._start(story)
    assert told(board) == [("s", START, RUNNING), ("a", START, RUNNING), ("g", START, RUNNING), ("m", START, RUNNING),
                           ("e", TO_STANDBY, STANDBY), ("later", TO_STANDBY, STANDBY)]  # fmt: skip
    assert [node.executions for node in (story, maneuver, event, waiting)] == [1, 1, 0, 0]
    assert event.changes == {TO_STANDBY: (3, 5)}
    assert all(each.time == 2.5 for each in board.transitions)


def test_what_stands_by_starts_when_its_trigger_says_so_and_in_the_same_instant_what_is_in_it() -> None:
    board = a_board()
    story = Node("story", "s", board.root)
    story.state = RUNNING
    act, inner = Node("act", "a", story), None
    act.state, act.start = STANDBY, Trigger()  # type: ignore[assignment]
    inner = Node("maneuverGroup", "g", act)
    inner.waits = True
    board._evaluate(story)
    assert act.state == STANDBY
    act.start.value = True  # type: ignore[union-attr]
    board._evaluate(story)
    assert (act.state, inner.state) == (RUNNING, RUNNING)  # what has no trigger waits for nobody


def test_a_stop_trigger_ends_an_element_and_that_of_the_root_everything() -> None:
    board = a_board()
    maneuver = a_group(board)
    (story,) = board.root.children
    (act,) = story.children
    for node in (board.root, story, act):
        node.state = RUNNING
    act.stop = Trigger(True)  # type: ignore[assignment]
    board._evaluate(story)
    assert (act.state, maneuver.state, story.state, board.done) == (COMPLETE, COMPLETE, COMPLETE, False)
    assert ("a", STOP, COMPLETE) in told(board)
    assert ("s", END, COMPLETE) in told(board)
    board.root.stop = Trigger(True)
    board._evaluate(board.root)
    assert (board.root.state, board.done) == (COMPLETE, True)


def test_an_event_acts_on_its_actors_and_ends_with_the_last_of_its_actions(made: Any) -> None:
    board = a_board()
    event = an_event(a_group(board, "A", "B"), "e", doing("longitudinal"), doing(nobody=True))
    maneuver = event.parent
    assert maneuver is not None
    for node in (maneuver, maneuver.parent):
        node.state, node.executions = RUNNING, 1  # type: ignore[union-attr]
    board._start_event(event)
    assert [entity for _, entity in made] == ["A", "B", None]
    assert (event.executions, [child.executions for child in event.children]) == (1, [1, 1])
    assert [board.entities[name].longitudinal for name in "AB"] == [made[0][0], made[1][0]]
    assert [(node.name, len(held)) for node, held in board._active] == [("e-0", 2), ("e-1", 1)]
    assert [(node.name, len(begun)) for node, begun in board._begun] == [("e-0", 2), ("e-1", 1)]
    board._end_finished()
    assert event.state == RUNNING
    for number, (runner, _) in enumerate(made):
        runner.done = True
        board._step_actions(0.1)
        board._end_finished()
        assert (event.state == COMPLETE) is (number == 2)
    assert board._active == []
    assert board.entities["A"].longitudinal is None
    assert (maneuver.state, maneuver.parent.state) == (COMPLETE, COMPLETE)  # type: ignore[union-attr]


def test_an_event_that_may_be_carried_out_twice_stands_by_in_between(made: Any) -> None:
    board = a_board()
    event = an_event(a_group(board, "A"), "e", doing(at_once=True), maximum=2)
    trigger: Any = Trigger()
    event.start = trigger
    event.parent.state = RUNNING  # type: ignore[union-attr]
    for number, state in ((1, STANDBY), (2, COMPLETE)):
        board._start_event(event)
        assert event.state == RUNNING
        board._end_finished()
        assert (event.executions, event.state, event.children[0].state) == (
            number,
            state,
            INIT if state == STANDBY else COMPLETE,
        )
    assert trigger.resets == 1
    assert [each for each in told(board) if each[0] == "e"] == [
        ("e", START, RUNNING), ("e", END, STANDBY), ("e", START, RUNNING), ("e", END, COMPLETE)
    ]  # fmt: skip


def test_who_is_gone_is_not_acted_on_and_one_that_others_move_is_asked(made: Any) -> None:
    board = a_board()
    board.entities["A"].active = False
    board.entities["B"].external = True
    event = an_event(a_group(board, "A", "B"), "e", doing("lateral"))
    board._start_event(event)
    ((_, held),) = board._active
    assert [each.entity.name for each in held] == ["B"]
    assert isinstance(held[0].runner, engine.Asked)


@pytest.mark.parametrize(("maximum", "states"), [(1, [COMPLETE]), (2, [STANDBY, COMPLETE])])
def test_an_event_that_is_skipped_has_been_carried_out(maximum: int, states: list[str]) -> None:
    board = a_board()
    maneuver = a_group(board, "A")
    busy = an_event(maneuver, "busy")
    busy.state = RUNNING
    event = an_event(maneuver, "e", priority="skip", maximum=maximum)
    for number, state in enumerate(states, 1):
        event.state = STANDBY
        board._start_event(event)
        assert (event.state, event.executions) == (state, number)
    assert {transition for name, transition, _ in told(board) if name == "e"} == {SKIP}
    busy.state = COMPLETE
    board._start_event(event)
    assert event.state == RUNNING


@pytest.mark.parametrize(
    ("reading", "maximum", "state"), [("esmini", 1, COMPLETE), ("esmini", 2, STANDBY), ("standard", 2, COMPLETE)]
)
def test_an_event_that_overrides_ends_those_that_run(reading: str, maximum: int, state: str, made: Any) -> None:
    """Where more executions are allowed, what was overridden stands by, if the file is read as the field's tools do."""
    doubts: list[str] = []
    board = a_board(reading=reading)
    board._doubt = lambda at, code, text: doubts.append(code)
    maneuver = a_group(board, "A")
    old = an_event(maneuver, "old", doing("longitudinal"), maximum=maximum)
    other = an_event(maneuver, "other")
    new = an_event(maneuver, "new", doing("lateral"), priority="override")
    board._start_event(old)
    board._start_event(new)
    assert (old.state, new.state, other.state) == (state, RUNNING, INIT)
    assert made[0][0].stopped
    assert not made[1][0].stopped
    assert board.entities["A"].longitudinal is None
    assert [node.name for node, _ in board._active] == ["new-0"]
    assert old.children[0].state == (INIT if state == STANDBY else COMPLETE)
    assert doubts == (["reading-event-again"] if state == STANDBY else [])


def test_a_new_action_in_a_domain_ends_the_one_that_runs_there_and_no_other(made: Any) -> None:
    board = a_board()
    maneuver = a_group(board, "A")
    old = an_event(maneuver, "old", doing("longitudinal"))
    aside = an_event(maneuver, "aside", doing("lateral"))
    new = an_event(maneuver, "new", doing("longitudinal"))
    for event in (old, aside, new):
        board._start_event(event)
    assert [runner.stopped for runner, _ in made] == [True, False, False]
    assert (old.state, aside.state, new.state) == (COMPLETE, RUNNING, RUNNING)
    assert ("old-0", STOP, COMPLETE) in told(board)
    assert board.entities["A"].longitudinal is made[2][0]
    assert [node.name for node, _ in board._active] == ["aside-0", "new-0"]


def test_it_ends_for_one_entity_alone_unless_a_selection_acts_together(made: Any) -> None:
    for together in (False, True):
        made.clear()
        board = a_board(selections={"both": ("A", "B")} if together else {})
        both = an_event(a_group(board, *(("both",) if together else ("A", "B"))), "both", doing("longitudinal"))
        one = an_event(a_group(board, "A"), "one", doing("longitudinal"))
        board._start_event(both)
        board._start_event(one)
        assert [runner.stopped for runner, _ in made] == [True, together, False]
        assert both.state == (COMPLETE if together else RUNNING)
        assert (board.entities["B"].longitudinal is None) is together


def test_of_an_init_action_no_event_ends(made: Any) -> None:
    board = a_board()
    init = Node("action", "i", None, element=doing("longitudinal"))
    board._begin(init, [board.entities["A"]])
    event = an_event(a_group(board, "A"), "e", doing("longitudinal"))
    board._start_event(event)
    assert (init.state, made[0][0].stopped) == (COMPLETE, True)
    short = Node("action", "j", None, element=doing(at_once=True))
    board._begin(short, [board.entities["B"]])
    board._end_finished()
    assert short.state == COMPLETE


def test_speeds_change_before_positions(made: Any) -> None:
    board = a_board()
    order: list[str] = []
    event = an_event(a_group(board, "A"), "e", doing("lateral"), doing("longitudinal"), doing())
    board._start_event(event)
    for runner, _ in made:
        runner.step = lambda dt, r=runner: order.append(r.domains[0] if r.domains else "none") or False
    board._step_actions(0.1)
    assert order == ["longitudinal", "none", "lateral"]


def test_what_is_stopped_stops_what_is_in_it_and_what_never_started_is_not_told(made: Any) -> None:
    board = a_board()
    maneuver = a_group(board, "A")
    event, never = an_event(maneuver, "e", doing("longitudinal")), an_event(maneuver, "never")
    maneuver.state = RUNNING
    board._start_event(event)
    board._stop(maneuver)
    assert [node.state for node in (maneuver, event, event.children[0], never)] == [COMPLETE] * 4
    assert [name for name, transition, _ in told(board) if transition == STOP] == ["e-0", "e", "m"]
    assert (made[0][0].stopped, board._active, board.entities["A"].longitudinal) == (True, [], None)


def test_an_event_that_was_to_be_carried_out_again_ends_its_execution_before_it_is_stopped(made: Any) -> None:
    board = a_board()
    event = an_event(a_group(board, "A"), "e", doing("longitudinal"), maximum=2)
    board._start_event(event)
    board._stop(event)
    assert [(transition, state) for name, transition, state in told(board) if name == "e"] == [
        (START, RUNNING), (END, STANDBY), (STOP, COMPLETE)
    ]  # fmt: skip


def test_an_event_that_was_not_to_be_carried_out_again_is_stopped_and_has_not_ended(made: Any) -> None:
    board = a_board()
    event = an_event(a_group(board, "A"), "e", doing("longitudinal"))
    board._start_event(event)
    board._stop(event)
    assert [each for each in told(board) if each[0] == "e"] == [("e", START, RUNNING), ("e", STOP, COMPLETE)]


def test_with_the_storyboard_init_actions_stop_that_still_run(made: Any) -> None:
    board = a_board()
    init = Node("action", "i", None, element=doing("longitudinal"))
    board._begin(init, [board.entities["A"]])
    board._stop(board.root)
    assert (init.state, made[0][0].stopped, board._active) == (COMPLETE, True, [])


def test_a_domain_is_let_go_by_the_action_that_has_it_only() -> None:
    board = a_board()
    a, old, new = board.entities["A"], Runner("longitudinal", "lateral"), Runner("longitudinal")
    board._hold(a, old, 3)
    assert (a.longitudinal, a.lateral, a.lateral_order) == (old, old, 3)
    board._hold(a, new, 4)
    board._release(Held(old, a))  # type: ignore[arg-type]
    assert (a.longitudinal, a.lateral) == (new, None)
    board._hold(None, old, 5)
    board._release(Held(old, None))  # type: ignore[arg-type]
    assert a.longitudinal is new
