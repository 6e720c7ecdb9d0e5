"""On a road with a friction scale below 1 the others accelerate and brake with no more than friction times weight."""

from __future__ import annotations

import pytest

from .conftest import Make, event, lane_position, run, speed, story, teleport

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
