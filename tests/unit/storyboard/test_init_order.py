"""Init actions that are relative to entities which the file places further down."""

from __future__ import annotations

import pytest

from .conftest import Make, lane_position, relative_speed, speed, teleport

BEHIND = '<RelativeObjectPosition entityRef="{}" dx="-10" dy="0"/>'


def faster(than: str) -> str:
    return relative_speed(
        f'<RelativeTargetSpeed entityRef="{than}" value="2" speedTargetValueType="delta" continuous="false"/>'
    )


def test_who_stands_relative_to_another_waits_for_it(make: Make) -> None:
    board = make(
        A=[teleport(BEHIND.format("B")), faster("B")],
        B=[teleport(BEHIND.format("C")), faster("C")],
        C=[teleport(lane_position(100.0)), speed(5.0)],
    )
    board.start()
    assert [entity.x for entity in board.entities.values()] == [pytest.approx(x) for x in (80.0, 90.0, 100.0)]
    assert [entity.speed for entity in board.entities.values()] == [9.0, 7.0, 5.0]


def test_an_entity_s_own_actions_keep_their_order(make: Make) -> None:
    """Relative to itself: 10 m behind where it was put before."""
    board = make(A=[teleport(lane_position(100.0)), teleport(BEHIND.format("A"))])
    board.start()
    assert board.entities["A"].x == pytest.approx(90.0)


def test_a_circle_of_speeds_begins_where_the_file_does(make: Make) -> None:
    board = make(A=[teleport(lane_position(100.0)), faster("B")], B=[teleport(lane_position(50.0)), faster("A")])
    board.start()
    assert [entity.speed for entity in board.entities.values()] == [2.0, 4.0]
