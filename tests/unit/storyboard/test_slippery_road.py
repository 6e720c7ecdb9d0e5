"""On a road with a friction scale below 1 the others accelerate and brake with no more than friction times weight."""

from __future__ import annotations

from pathlib import Path

import pytest

from openscenario.road.network import RoadNetwork, load_network
from openscenario.storyboard.play import play

from .conftest import XODR, Make, event, lane_position, run, speed, story, teleport

G = 9.80665


def slippery(scale: float) -> str:
    return (
        '<GlobalAction><EnvironmentAction><Environment name="wet">'
        f'<RoadCondition frictionScaleFactor="{scale}"/></Environment></EnvironmentAction></GlobalAction>'
    )


@pytest.mark.parametrize(("scale", "deceleration"), [(0.2, 0.2 * G), (0.5, 0.5 * G), (1.0, 8.0), (3.0, 8.0)])
def test_a_car_that_is_told_to_brake_hard_brakes_with_mu_g(make: Make, scale: float, deceleration: float) -> None:
    """From 20 m/s, told to brake with 8 m/s^2: after 1 s it has lost what the road holds."""
    brake = event("wet", slippery(scale)), event("brake", speed(0.0, "linear", "rate", 8.0))
    board = make(A=[teleport(lane_position(100.0)), speed(20.0)], stories=story(*brake))
    run(board, 1.0)
    assert 20.0 - board.entities["A"].speed == pytest.approx(deceleration, abs=0.1)


def test_a_road_that_dries_holds_again(make: Make) -> None:
    board = make(A=[teleport(lane_position(100.0)), speed(20.0)])
    board.start()
    car = board.entities["A"]
    car.limit_friction(0.1)
    assert (car.max_acceleration, car.max_deceleration) == (pytest.approx(0.1 * G), pytest.approx(0.1 * G))
    car.limit_friction(float("inf"))
    assert (car.max_acceleration, car.max_deceleration) == (10.0, 10.0)


@pytest.fixture
def icy(tmp_path: Path) -> RoadNetwork:
    """The straight road; from 300 m on the material of lane -1 has a friction of 0.2."""
    material = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/><material sOffset="300" friction="0.2"/></lane>'
    old = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
    head, tail = XODR.split("<right>")
    path = tmp_path / "icy.xodr"
    path.write_text(f"{head}<right>{tail.replace(old, material, 1)}")
    return load_network(path)


@pytest.mark.parametrize(
    ("lane", "s", "scale", "deceleration"),
    [(-1, 400.0, 1.0, 0.2 * G), (-1, 400.0, 0.5, 0.1 * G), (-1, 100.0, 1.0, 8.0), (-2, 400.0, 1.0, 8.0)],
)
def test_the_material_of_the_lane_limits_who_is_on_it(
    make: Make, icy: RoadNetwork, lane: int, s: float, scale: float, deceleration: float
) -> None:
    """From 20 m/s, told to brake with 8 m/s^2; the friction of the lane times that of the road."""
    brake = event("wet", slippery(scale)), event("brake", speed(0.0, "linear", "rate", 8.0))
    board = make(A=[teleport(lane_position(s, lane=lane)), speed(20.0)], stories=story(*brake), on=icy)
    run(board, 0.1)
    before = board.entities["A"].speed
    run(board, 1.0)
    assert before - board.entities["A"].speed == pytest.approx(deceleration, abs=0.1)


def test_the_friction_of_a_lane_holds_from_its_place_on(icy: RoadNetwork) -> None:
    found = [icy.lane_friction("1", -1, s) for s in (0.0, 299.9, 300.1, 900.0)]
    assert found == [1.0, 1.0, 0.2, 0.2]
    assert icy.lane_friction("1", 1, 500.0) == 1.0
    assert icy.states_friction


def test_play_does_what_the_storyboard_says_whatever_the_lane_is_made_of(make: Make, icy: RoadNetwork) -> None:
    """From 20 m/s with 8 m/s^2: after 1 s on the icy lane 12 m/s, where a run allows 18.04 m/s."""
    brake = event("brake", speed(0.0, "linear", "rate", 8.0))
    board = make(A=[teleport(lane_position(400.0)), speed(20.0)], stories=story(brake), on=icy)
    (last,) = [row for row in play(board.scenario, icy, duration=1.0).rows if row.time == 1.0]
    assert last.speed == pytest.approx(12.0, abs=0.1)
