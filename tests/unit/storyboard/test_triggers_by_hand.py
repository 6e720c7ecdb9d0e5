"""What a condition and a trigger remember, and what a report and the watch over motion make of it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard.limits import Limits
from openscenario.storyboard.nodes import RUNNING, Node
from openscenario.storyboard.plausibility import Plausibility
from openscenario.storyboard.report import report
from openscenario.storyboard.triggers import ConditionState, TriggerState

from .bodies import car

# --- conditions


class Feed:
    """A test that says what it is told to, one answer after the other."""

    def __init__(self, *answers: bool) -> None:
        self.answers = list(answers)

    def __call__(self) -> bool:
        return self.answers.pop(0)


def condition(feed: Any, edge: Any = "none", delay: float = 0.0, entities: Any = ()) -> ConditionState:
    shown = model.Condition(name="c", delay=delay, condition_edge=edge,
                            condition=model.SimulationTimeCondition(rule="greaterThan", value=0.0))  # fmt: skip
    return ConditionState(shown, feed, entities)


@pytest.mark.parametrize("edge", ["none", "rising", "falling", "risingOrFalling"])
def test_a_condition_that_was_not_asked_yet_is_false_and_never_was_true(edge: str) -> None:
    state = condition(Feed(), edge)
    assert (state.value, state.ever, state.true_at_start, tuple(state.entities)) == (False, False, False, ())
    assert state.model.name == "c"


@pytest.mark.parametrize(
    ("edge", "first", "at_start"),
    [("none", True, False), ("rising", True, True), ("falling", True, True), ("risingOrFalling", True, True),
     ("rising", False, False), ("risingOrFalling", False, False)],
)  # fmt: skip
def test_what_is_true_at_the_first_evaluation_is_noted_where_an_edge_cannot_see_it(
    edge: str, first: bool, at_start: bool
) -> None:
    state = condition(Feed(first, not first), edge)
    assert state.evaluate(0.0) is (edge == "none" and first)
    assert state.true_at_start is at_start
    assert state.ever is first
    state.evaluate(1.0)
    assert state.true_at_start is at_start
    assert state.ever


def test_ever_is_the_bare_condition_whatever_edge_and_delay_make_of_it() -> None:
    state = condition(Feed(True, False), "none", delay=9.0)
    assert state.evaluate(0.0) is False
    assert (state.ever, state.value) == (True, False)
    never = condition(Feed(False, False), "falling")
    assert [never.evaluate(0.0), never.evaluate(1.0)] == [False, False]
    assert not never.ever


def test_the_value_is_that_of_the_last_evaluation() -> None:
    state = condition(Feed(False, True, True), "rising")
    found = []
    for time in (0.0, 1.0, 2.0):
        state.evaluate(time)
        found.append(state.value)
    assert found == [False, True, False]


@pytest.mark.parametrize(
    ("delay", "times", "found"),
    [
        (0.0, (0.0, 1.0, 2.0, 3.0), [True, False, True, True]),
        (1.0, (0.0, 1.0, 2.0, 3.0), [False, True, False, True]),  # just as old as the delay is old enough
        (1.0, (0.0, 1.0 - 1e-10, 2.0, 3.0), [False, True, False, True]),  # rounding
        (1.0, (0.0, 0.99, 2.0, 3.0), [False, False, False, True]),
        (2.5, (0.0, 1.0, 2.0, 3.0), [False, False, False, True]),
        (5.0, (0.0, 1.0, 2.0, 3.0), [False, False, False, False]),
    ],
)
def test_a_delayed_condition_has_the_value_that_it_had_then(
    delay: float, times: tuple[float, ...], found: list[bool]
) -> None:
    state = condition(Feed(True, False, True, True), delay=delay)
    assert [state.evaluate(time) for time in times] == found


def test_after_a_reset_nothing_was_before() -> None:
    state = condition(Feed(False, True, True, True), "rising", delay=0.5)
    assert [state.evaluate(time) for time in (0.0, 1.0, 1.5)] == [False, False, True]
    state.reset()
    assert state.value is False
    assert state.evaluate(2.0) is False
    assert len(state._history) == 1  # the edge of then is forgotten
    assert state.ever


# --- triggers


class Plain:
    def __init__(self, value: bool, *entities: str) -> None:
        self.value, self.entities, self.asked, self.resets = value, entities, 0, 0

    def evaluate(self, time: float) -> bool:
        self.asked += 1
        return self.value

    def reset(self) -> None:
        self.resets += 1


def test_every_condition_is_evaluated_whatever_the_others_say() -> None:
    groups = ((Plain(False), Plain(True)), (Plain(True), Plain(False)), (Plain(True), Plain(True)), (Plain(True),))
    trigger: Any = TriggerState(groups)  # type: ignore[arg-type]
    assert trigger.evaluate(0.0) is True
    assert [each.asked for group in groups for each in group] == [1] * 7
    trigger.reset()
    assert [each.resets for group in groups for each in group] == [1] * 7


@pytest.mark.parametrize(
    ("groups", "fires", "entities"),
    [
        ((), False, ()),
        (((),), False, ()),  # a group without conditions is no reason
        (((), (Plain(True, "A"),)), True, ("A",)),
        (((Plain(True, "A"), Plain(True, "B", "A")),), True, ("A", "B")),
        (((Plain(True, "A"), Plain(False, "B")), (Plain(True, "C"),)), True, ("C",)),
        (((Plain(True, "B"),), (Plain(False, "X"),), (Plain(True, "A", "B"),)), True, ("B", "A")),
        (((Plain(False, "A"),),), False, ()),
    ],
)
def test_those_count_that_made_a_group_true(groups: Any, fires: bool, entities: tuple[str, ...]) -> None:
    trigger = TriggerState(groups)
    assert trigger.entities == ()
    assert trigger.evaluate(0.0) is fires
    assert trigger.entities == entities


def test_those_of_the_last_time_that_it_was_true_are_kept_and_then_replaced() -> None:
    first, second = Plain(True, "A"), Plain(False, "B")
    trigger = TriggerState(((first,), (second,)))  # type: ignore[arg-type]
    trigger.evaluate(0.0)
    first.value = False
    assert not trigger.evaluate(1.0)
    assert trigger.entities == ("A",)
    second.value = True
    trigger.evaluate(2.0)
    assert trigger.entities == ("B",)


# --- what a report says of a place in the file


def test_a_report_has_the_place_in_the_file_or_the_path_of_the_element() -> None:
    root = Node("storyboard", "root", None)
    story = Node("story", "s", root)
    act = Node("act", "a", story, model.At("x.xosc", 7, "Act[a]"))
    event = Node("event", "e", act)
    act.executions = 1
    act.state = RUNNING
    ended, fired = (report(root)[k] for k in (0, 1))
    assert (ended.code, ended.severity, ended.file, ended.line, ended.element, ended.hint) == (
        "act-never-ended", "warning", "x.xosc", 7, "Act[a]", "",
    )  # fmt: skip
    assert (fired.code, fired.file, fired.line, fired.element) == ("event-never-fired", "", None, "s/a/e")
    event.executions = 1
    act.state = "completeState"
    assert report(root) == ()


@pytest.mark.parametrize(("executions", "told"), [(0, True), (1, False)])
def test_an_edge_that_no_evaluation_could_see_is_told_until_its_element_has_started(
    executions: int, told: bool
) -> None:
    at = model.At("x.xosc", 0, "Condition")
    state = SimpleNamespace(
        true_at_start=True, ever=True, model=SimpleNamespace(name="c", at=at, condition_edge="rising")
    )
    root = Node("storyboard", "root", None)
    event = Node("event", "e", Node("act", "a", root))
    root.children[0].executions, event.executions = 1, executions
    start: Any = SimpleNamespace(groups=((state, SimpleNamespace(true_at_start=False, ever=True)),))
    event.start = start
    found = [finding for finding in report(root) if finding.code == "edge-true-from-start"]
    assert len(found) == told
    if told:
        assert (found[0].file, found[0].line, found[0].element, found[0].found) == (
            "x.xosc", None, "Condition", "conditionEdge rising",
        )  # fmt: skip
        assert found[0].text == "condition 'c' was true from its first evaluation on"


# --- who is watched, and against what


def watched(**more: Any) -> tuple[Any, Any, Plausibility]:
    """A car that does 50 m/s, 3 m/s^2 up and 6 down; watched from its first moment on."""
    entity = car()
    board: Any = SimpleNamespace(**{"entities": {"A": entity}, "acted": (), "steps": 2, "time": 1.0, "done": False,
                                    "reading": "standard", "events_of": lambda entity: ["E"], **more})  # fmt: skip
    return entity, board, Plausibility(board)


def fields(watch: Plausibility) -> list[str]:
    return [str(finding["field"]) for finding in watch.findings()]


@pytest.mark.parametrize(
    ("change", "dt", "steps", "told"),
    [
        ({}, 0.1, 2, True),
        ({}, 0.1, 1, False),  # how a scenario begins
        ({}, 0.0, 2, False),
        ({"teleports": 1}, 0.1, 2, False),
        ({"external": True}, 0.1, 2, False),
        ({"active": False}, 0.1, 2, False),
        ({"drawn_by": "other"}, 0.1, 2, False),
    ],
)
def test_who_jumps_is_told_unless_it_was_put_there_or_is_moved_by_others(
    change: dict[str, Any], dt: float, steps: int, told: bool
) -> None:
    entity, board, watch = watched()
    board.steps = steps
    entity.x = 5.0
    for name, value in change.items():
        setattr(entity, name, value)
    watch.look(dt)
    assert fields(watch) == (["A.position"] if told else [])


def test_who_was_away_is_compared_with_nothing_when_it_is_back() -> None:
    entity, _, watch = watched()
    entity.active = False
    watch.look(0.1)
    entity.active, entity.x = True, 5.0
    watch.look(0.1)
    assert fields(watch) == []
    entity.x = 10.0
    watch.look(0.1)
    assert fields(watch) == ["A.position"]


def acting(element: Any, *entities: Any, kind: Any = "event", name: str = "Push") -> Any:
    parent = None if kind is None else SimpleNamespace(kind=kind, name=name)
    return SimpleNamespace(element=element, parent=parent), tuple(SimpleNamespace(entity=e) for e in entities)


CONSTRAINTS = model.DynamicConstraints(max_acceleration=1.0, max_deceleration=2.0, max_speed=20.0,
                                       max_acceleration_rate=4.0, max_deceleration_rate=5.0)  # fmt: skip


def profile(mode: Any) -> Any:
    return model.SpeedProfileAction(following_mode=mode, dynamic_constraints=CONSTRAINTS,
                                    speed_profile_entries=(model.SpeedProfileEntry(speed=1.0),))  # fmt: skip


@pytest.mark.parametrize(
    ("mode", "kind", "event", "rates"),
    [("follow", "event", "Push", (4.0, 5.0)), ("position", "event", "Push", (math.inf, math.inf)),
     ("follow", "maneuver", "Init", (4.0, 5.0)), ("follow", None, "Init", (4.0, 5.0))],
)  # fmt: skip
def test_an_action_allows_what_its_constraints_say(
    mode: str, kind: Any, event: str, rates: tuple[float, float]
) -> None:
    entity, board, watch = watched()
    board.acted = (acting(profile(mode), entity, None, kind=kind), acting(SimpleNamespace(), entity))
    ((one,),) = watch._constraints().values()
    assert (one.event, one.lateral) == (event, False)
    assert one.limits == Limits(speed=20.0, up=1.0, down=2.0, rise=rates[0], fall=rates[1])


def test_constraints_of_several_actions_hold_together() -> None:
    entity, board, watch = watched()
    other = car("B")
    board.acted = (acting(profile("follow"), entity, other, name="One"), acting(profile("follow"), entity, name="Two"))
    found = watch._constraints()
    assert [one.event for one in found["A"]] == ["One", "Two"]
    assert [one.event for one in found["B"]] == ["One"]


@pytest.mark.parametrize(
    ("reading", "most", "told"),
    [
        ("standard", 5.0, []),
        ("esmini", 5.0, [("Performance", "E")]),
        ("esmini", 1.0, [("DynamicConstraints", "Push"), ("Performance", "E")]),
    ],
)
def test_a_constraint_has_precedence_over_the_performance_where_the_standard_is_read(
    reading: str, most: float, told: list[tuple[str, str]]
) -> None:
    """The car can do 3 m/s^2 (x 1.05, and 1 for rounding) and does 4.5."""
    entity, board, watch = watched(reading=reading)
    entity.speed = 10.0
    watch.look(0.0)
    element = model.SpeedProfileAction(
        following_mode="position", dynamic_constraints=model.DynamicConstraints(max_acceleration=most),
        speed_profile_entries=(model.SpeedProfileEntry(speed=1.0),),
    )  # fmt: skip
    board.acted = (acting(element, entity),)
    entity.x, entity.speed = 1.0, 10.45
    watch.look(0.1)
    found = watch.findings()
    assert {finding["field"] for finding in found} <= {"A.acceleration"}
    assert sorted((finding["limit"], finding["event"]) for finding in found) == told
