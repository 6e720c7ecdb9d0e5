"""Trailers: where they stand, how they follow, that they let go; expected values from the geometry of a tractrix."""

from __future__ import annotations

import math

import pytest

from openscenario import model
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.trailers import couple, draw, line_up

from .conftest import Make, at_time, condition, event, group, lane_position, run, speed, story, teleport


def coupled(make: Make) -> Storyboard:
    """B hangs on A: hitch 1 m behind A's rear axle, coupler 3 m ahead of B's axle."""
    board = make(A=[teleport(lane_position(100.0)), speed(10.0)], B=[teleport(lane_position(10.0))])
    a, b = board.entities["A"], board.entities["B"]
    a.hitch, b.coupler = -1.0, 3.0
    couple(a, b)
    return board


def test_a_placed_vehicle_has_its_trailer_straight_behind_it(make: Make) -> None:
    board = coupled(make)
    board.entities["A"].put(50.0, 20.0, 0.0, math.pi / 2.0)
    line_up(board.entities["A"])
    b = board.entities["B"]
    assert (b.x, b.y, b.h) == (pytest.approx(50.0), pytest.approx(16.0), pytest.approx(math.pi / 2.0))


def test_a_trailer_follows_straight_on_with_the_speed_of_its_vehicle(make: Make) -> None:
    board = coupled(make)
    board.start()
    line_up(board.entities["A"])
    run(board, 2.0)
    b = board.entities["B"]
    assert b.x == pytest.approx(100.0 + 20.0 - 4.0, abs=1e-9)
    assert b.speed == 10.0
    assert b.vx == pytest.approx(10.0)


def test_the_axle_lags_behind_on_a_circle(make: Make) -> None:
    """In the steady state the trailer's axle runs on a circle of radius sqrt(R_hitch^2 - c^2)."""
    board = coupled(make)
    a, b = board.entities["A"], board.entities["B"]
    radius = 20.0
    a.put(radius, 0.0, 0.0, math.pi / 2.0)
    line_up(a)
    steps = 20_000
    for i in range(1, steps + 1):
        turn = 4.0 * math.pi * i / steps
        a.put(radius * math.cos(turn), radius * math.sin(turn), 0.0, turn + math.pi / 2.0)
        draw(a, 0.01)
    hitch = math.hypot(radius, a.hitch)
    assert math.hypot(b.x, b.y) == pytest.approx(math.sqrt(hitch**2 - b.coupler**2), abs=1e-3)


CONNECT = '<PrivateAction><TrailerAction><ConnectTrailerAction trailerRef="B"/></TrailerAction></PrivateAction>'
DISCONNECT = "<PrivateAction><TrailerAction><DisconnectTrailerAction/></TrailerAction></PrivateAction>"


def test_connect_and_disconnect(make: Make) -> None:
    events = (
        event("on", CONNECT, start=group(condition(at_time(1.0)))),
        event("off", DISCONNECT, start=group(condition(at_time(2.0)))),
    )
    board = make(
        A=[teleport(lane_position(100.0)), speed(10.0)],
        B=[teleport(lane_position(90.0))],
        stories=story(*events),
    )
    run(board, 0.9)
    a, b = board.entities["A"], board.entities["B"]
    assert b.x == pytest.approx(90.0)
    run(board, 1.0)
    assert b.drawn_by is a
    assert b.speed == 10.0
    assert math.hypot(a.x + a.hitch - b.x, a.y - b.y) == pytest.approx(b.coupler, abs=1e-9)
    run(board, 0.2)
    there = b.x
    run(board, 1.0)
    assert b.drawn_by is None
    assert (b.x, b.speed) == (there, 0.0)


def test_a_vehicle_cannot_hang_on_its_own_trailer(make: Make) -> None:
    board = make(
        A=[teleport(lane_position(100.0))],
        B=[teleport(lane_position(90.0))],
        stories=story(event("on", CONNECT.replace('"B"', '"A"'), start=group(condition(at_time(0.0)))), actor="B"),
    )
    couple(board.entities["A"], board.entities["B"])
    run(board, 0.1)
    assert [finding.code for finding in board.warnings] == ["trailer-circle"]
    assert isinstance(board.scenario, model.Scenario)
