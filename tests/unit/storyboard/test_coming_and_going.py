"""Entities that an action adds to the scenario or takes out of it; where they are follows from their speeds."""

from __future__ import annotations

import pytest

from .conftest import Make, at_time, by_entity, condition, event, group, lane_position, log, run, speed, story, teleport

HERE = [teleport(lane_position(100.0)), speed(10.0)]


def add(name: str, position: str) -> str:
    inner = f"<AddEntityAction><Position>{position}</Position></AddEntityAction>"
    return f'<GlobalAction><EntityAction entityRef="{name}">{inner}</EntityAction></GlobalAction>'


def delete(name: str) -> str:
    return f'<GlobalAction><EntityAction entityRef="{name}"><DeleteEntityAction/></EntityAction></GlobalAction>'


def at(seconds: float) -> str:
    return group(condition(at_time(seconds)))


def test_who_is_there_already_is_not_added_again(make: Make) -> None:
    board = make(A=HERE, stories=story(event("again", add("A", lane_position(400.0)), start=at(1.0))))
    run(board, 2.0)
    assert (1.0, "again", "endTransition") in log(board, "event")
    assert board.entities["A"].x == pytest.approx(120.0)


def test_who_was_deleted_comes_back_at_its_last_speed(make: Make) -> None:
    """Relative to itself is relative to where it was last."""
    back = add("A", '<RelativeLanePosition entityRef="A" dLane="0" ds="50"/>')
    events = event("off", delete("A"), start=at(1.0)), event("on", back, start=at(2.0))
    board = make(A=HERE, stories=story(*events))
    run(board, 1.5)
    assert not board.entities["A"].active
    run(board, 1.5)
    assert board.entities["A"].active
    assert board.entities["A"].x == pytest.approx(110.0 + 50.0 + 10.0)


def test_who_is_added_later_and_has_no_init_actions_is_not_there_before(make: Make) -> None:
    """So it collides with nobody at the origin, where nobody put it."""
    crash = by_entity('<CollisionCondition><EntityRef entityRef="B"/></CollisionCondition>', "A")
    comes = event("comes", add("B", lane_position(300.0)), speed(5.0), start=at(1.0))
    hit = event("hit", speed(0.0), start=group(condition(crash)))
    stories = story(comes, actor="B") + story(hit, name="other")
    board = make(A=[teleport('<WorldPosition x="0" y="0" h="0"/>'), speed(1.0)], B=[], stories=stories)
    run(board, 0.5)
    assert not board.entities["B"].active
    run(board, 2.5)
    assert board.entities["B"].active
    assert board.entities["B"].x == pytest.approx(300.0 + 5.0 * 2.0)
    assert not [each for each in log(board, "event") if each[1] == "hit" and each[2] == "startTransition"]
