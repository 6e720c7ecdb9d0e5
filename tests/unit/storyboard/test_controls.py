"""OverrideControllerValueAction: pedals, wheel and gear of others act where no action holds the domain.

The car has maxAcceleration 4 and maxDeceleration 10 m/s^2, a wheelbase of 3 m, road wheels up to 0.5 rad.
"""

from __future__ import annotations

import math

import pytest

from .conftest import Make, at_time, condition, event, group, lane_position, run, speed, story, teleport


def override(inside: str) -> str:
    return (
        "<PrivateAction><ControllerAction><OverrideControllerValueAction>"
        f"{inside}</OverrideControllerValueAction></ControllerAction></PrivateAction>"
    )


def driven(make: Make, inside: str, seconds: float, pace: float = 20.0, then: str = "") -> tuple[float, float]:
    """Speed [m/s] and way [m] after some time with controls held from the start."""
    later = story(event("later", override(then), start=group(condition(at_time(1.0))))) if then else ""
    start = [teleport(lane_position(100.0)), speed(pace), override(inside)]
    board = make(A=start, stories=later, acceleration=4.0)
    run(board, seconds)
    return board.entities["A"].speed, board.entities["A"].x - 100.0


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        ('<Throttle active="true" value="0.5"/>', 20.0 + 2.0 * 0.5 * 4.0),
        ('<Brake active="true" value="0.25"/>', 20.0 - 2.0 * 0.25 * 10.0),
        ('<Brake active="true"><BrakePercent value="0.5"/></Brake>', 20.0 - 2.0 * 0.5 * 10.0),
        ('<Brake active="true"><BrakeForce value="3000"/></Brake>', 20.0 - 2.0 * 3000.0 / 1500.0),
        ('<ParkingBrake active="true"><BrakePercent value="0.8"/></ParkingBrake>', 20.0 - 2.0 * 0.8 * 10.0),
        ('<Throttle active="true" value="1"/><Clutch active="true" value="0.75"/>', 20.0 + 2.0 * 0.25 * 4.0),
        ('<Throttle active="true" value="1"/><Clutch active="true" value="1"/>', 20.0),
        ('<Throttle active="true" value="1"/><Gear active="true" number="0"/>', 20.0),
        ('<Throttle active="true" value="0.5"/><Gear active="true" number="-1"/>', 20.0 - 2.0 * 0.5 * 4.0),
        ('<Gear active="true"><AutomaticGear gear="p"/></Gear>', 0.0),
        ('<Throttle active="false" value="1"/>', 20.0),
    ],
)
def test_two_seconds_of_held_controls(make: Make, inside: str, expected: float) -> None:
    assert driven(make, inside, 2.0)[0] == pytest.approx(expected, abs=0.051)


def test_the_brake_stops_the_car_and_does_not_turn_it_round(make: Make) -> None:
    """v^2 / (2 a) = 20^2 / (2 x 10) = 20 m, and half of the first 10 ms step."""
    pace, way = driven(make, '<Brake active="true" value="1"/>', 4.0)
    assert pace == 0.0
    assert way == pytest.approx(20.0, abs=0.21)


def test_a_pedal_with_a_rate_comes_slowly(make: Make) -> None:
    """0.2 of the brake a second: after 2 s the car has lost 10 x 0.2 x 2^2 / 2 = 4 m/s."""
    assert driven(make, '<Brake active="true"><BrakePercent value="1" maxRate="0.2"/></Brake>', 2.0)[
        0
    ] == pytest.approx(16.0, abs=0.05)


def test_it_holds_until_it_is_let_go(make: Make) -> None:
    found = driven(make, '<Brake active="true" value="0.5"/>', 3.0, then='<Brake active="false" value="0"/>')
    assert found[0] == pytest.approx(20.0 - 1.0 * 5.0, abs=0.11)


@pytest.mark.parametrize("wheel", [1.6, -0.8, 3.2])
def test_a_held_steering_wheel_drives_a_circle_of_the_kinematic_radius(make: Make, wheel: float) -> None:
    """Road wheels stand at 1/16 of the steering wheel; the rear axle runs on R = L / tan(angle)."""
    board = make(
        A=[teleport(lane_position(100.0)), speed(5.0), override(f'<SteeringWheel active="true" value="{wheel}"/>')]
    )
    run(board, 2.0)
    car = board.entities["A"]
    radius = 3.0 / math.tan(wheel / 16.0)
    assert car.h == pytest.approx((10.0 / radius) % (2.0 * math.pi), abs=0.01) or car.h == pytest.approx(
        10.0 / radius, abs=0.01
    )
    assert math.hypot(car.x - 100.0, car.y + 1.75 - radius) == pytest.approx(abs(radius), rel=2e-3)


def test_an_action_of_the_domain_comes_first(make: Make) -> None:
    """A speed action of 1 s leads; then the brake of 5 m/s^2, held from the start, acts for the second that is left."""
    actions = [teleport(lane_position(100.0)), speed(20.0), override('<Brake active="true" value="0.5"/>')]
    board = make(A=actions, stories=story(event("keep", speed(22.0, "linear", "time", 1.0))))
    run(board, 2.0)
    assert board.entities["A"].speed == pytest.approx(22.0 - 5.0, abs=0.11)
