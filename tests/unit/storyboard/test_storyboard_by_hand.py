"""What a storyboard says of itself, who acts in it, and what it asks of others: on a road."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.findings import Finding
from openscenario.storyboard.engine import Held, Storyboard
from openscenario.storyboard.nodes import Node
from openscenario.storyboard.requests import Request
from openscenario.storyboard.runner import Instant

from .bodies import car
from .conftest import Make, at_time, condition, event, group, lane_position, run, speed, story, teleport

# --- what a storyboard says of itself


@pytest.fixture
def board(make: Make) -> Storyboard:
    return make(A=[teleport(lane_position(100.0)), speed(10.0)], B=[teleport(lane_position(200.0, 1)), speed(4.0)],
                external=("B",), stories=story(event("go", speed(20.0, "linear", "time", 1.0))))  # fmt: skip


def test_a_storyboard_counts_its_steps_and_its_time(board: Storyboard) -> None:
    assert (board.time, board.steps, board.dt, board.running, board.done) == (0.0, 0, 0.0, False, False)
    board.start()
    assert (board.time, board.steps, board.running) == (0.0, 0, True)
    for _ in range(3):
        board.step(0.1)
    assert (board.time, board.steps, board.dt) == (0.3, 3, 0.1)
    board.done = True
    board.step(0.1)
    assert (board.time, board.steps) == (0.3, 3)


def test_before_the_first_step_a_velocity_is_that_of_the_speed(board: Storyboard) -> None:
    board.start()
    a = board.entities["A"]
    a.h, a.vx, a.vy = 0.5 * math.pi, 7.0, 8.0
    assert board.velocity(a) == pytest.approx((0.0, 10.0))
    board.steps = 1
    assert board.velocity(a) == (7.0, 8.0)


def test_an_external_entity_is_placed_and_its_way_counts_by_its_speed(board: Storyboard) -> None:
    board.start()
    board.place("B", 150.0, 1.75, 0.5, math.pi, 6.0, 0.7)
    b = board.entities["B"]
    assert (b.x, b.y, b.z, b.speed, b.ax) == (150.0, 1.75, 0.5, 6.0, 0.7)
    before = b.travelled
    board.place("B", 150.0, 1.75, 0.5, math.pi, -6.0)
    assert b.ax == 0.0
    board.step(0.5)
    assert b.travelled - before == pytest.approx(3.0)
    assert (b.x, b.speed) == (150.0, -6.0)


def test_what_acted_in_the_last_step_is_told_by_entity(board: Storyboard) -> None:
    board.start()
    assert board.events_of(board.entities["A"]) == []
    board.step(0.1)
    assert board.events_of(board.entities["A"]) == ["go"]
    assert board.events_of(board.entities["B"]) == []
    init = Node("action", "x", Node("init", "y", None))  # type: ignore[arg-type]
    board.acted = (
        (init, (Held(Instant(), board.entities["B"]), Held(Instant(), None))),
        (Node("action", "z", None), ()),
    )
    assert board.events_of(board.entities["B"]) == ["Init"]


def test_a_warning_is_told_once_for_its_place(board: Storyboard) -> None:
    element: Any = SimpleNamespace(at=model.At("x.xosc", 0, "E"))
    board.warn(element, "code", "text")
    board.warn(element, "code", "text")
    board.warn(element, "code", "other")
    assert board.warnings == [
        Finding(code="code", severity="warning", file="x.xosc", line=None, element="E", text=text)
        for text in ("text", "other")
    ]
    assert board.report()[:2] == tuple(board.warnings)


def test_a_request_has_its_time_and_its_entity(board: Storyboard) -> None:
    board.time = 1.5
    board.request(board.entities["B"], "speed", {"target": 3.0})
    assert board.requests == [Request(1.5, "B", "speed", {"target": 3.0})]


def test_who_comes_moves_and_who_goes_is_gone(board: Storyboard) -> None:
    board.start()
    new = car("N")
    board.admit(new)
    assert board.entities["N"] is new
    board.step(0.1)
    assert new in board._movers
    board.dismiss(new)
    assert ("N" in board.entities, new.active, new in board._movers) == (False, False, False)
    assert board.crowd() is board.crowd()


@pytest.mark.parametrize(
    ("refs", "select", "triggered", "own", "actors"),
    [
        (("A",), False, ("B",), ("B",), ["A"]),
        (("A", "B", "A"), False, (), (), ["A", "B"]),
        (("both",), False, (), (), ["A", "B"]),
        ((), True, ("B",), ("A",), ["B"]),  # those that triggered the act
        ((), True, (), ("A",), ["A"]),  # where none did, those that triggered the event itself
        (("A",), True, ("B", "A"), (), ["A", "B"]),
        ((), True, None, None, []),
    ],
)
def test_who_carries_out_an_event(
    board: Storyboard, refs: Any, select: bool, triggered: Any, own: Any, actors: list[str]
) -> None:
    act = Node("act", "a", None)
    group_ = Node("maneuverGroup", "g", act)
    happening = Node("event", "e", Node("maneuver", "m", group_))
    one: Any = None if triggered is None else SimpleNamespace(entities=triggered)
    other: Any = None if own is None else SimpleNamespace(entities=own)
    act.start, happening.start = one, other
    told: Any = SimpleNamespace(entity_refs=[SimpleNamespace(entity_ref=name) for name in refs],
                                select_triggering_entities=select)  # fmt: skip
    group_.actors = told
    board.selections = {"both": ("A", "B")}
    assert [entity.name for entity in board._actors(happening) if entity is not None] == actors
    assert board._actors(Node("event", "e", None)) == []


def test_a_selection_acts_together(board: Storyboard) -> None:
    group_ = Node("maneuverGroup", "g", None)
    acting = Node("action", "x", Node("event", "e", Node("maneuver", "m", group_)))
    told: Any = SimpleNamespace(entity_refs=[SimpleNamespace(entity_ref=name) for name in ("both", "A", "one")])
    group_.actors = told
    board.selections = {"both": ("A", "B"), "one": ("B",)}
    assert [each.name for each in board._together(acting, board.entities["A"])] == ["A", "B"]
    assert [each.name for each in board._together(acting, board.entities["B"])] == ["A", "B", "B"]
    assert board._together(Node("action", "x", None), board.entities["A"]) == []


def test_triggers_of_an_instant_are_evaluated_once(make: Make) -> None:
    """A count of two executions: settling before a step does not use one up."""
    go = event("go", speed(20.0), start=group(condition(at_time(0.0))), count=2)
    made = make(A=[teleport(lane_position(100.0)), speed(10.0)], stories=story(go))
    made.start()
    made.settle()
    assert made.entities["A"].speed == 20.0
    made.settle()
    number = len(made.transitions)
    made.step(0.1)
    assert made.entities["A"].x == pytest.approx(102.0)
    assert len(made.transitions) == number
    run(made, 0.2, 0.1)
    assert len(made.transitions) > number
