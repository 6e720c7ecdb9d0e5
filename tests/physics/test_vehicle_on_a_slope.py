"""Ways on a slope as a map shows them, from above, of speeds that are along the ground. Against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from vehicle_models import CAR, model, plant

from vehicle.messages import VehicleState
from vehicle.model.open_loop import Replay
from vehicle.model.plant import Plant

X, Y, YAW, V = 0, 1, 2, 3  # columns of a row of a replay
SPEED = 5.0  # m/s


def rolled(effects: dict[str, dict[str, float]], steer: float, seconds: float, heading: float = 0.0) -> np.ndarray:
    """A car that moves without slip at a speed that is imposed, (n, 8)."""
    t = np.arange(0.0, seconds, 0.02)
    replay = Replay(
        model("kinematic_bicycle", effects, longitudinal=("v",)),
        t,
        {"steer_cmd": 0.0 * t + steer, "v": 0.0 * t + SPEED},
    )
    return np.asarray(
        replay.run(starts=np.array([0]), states=np.array([[0.0, 0.0, heading, SPEED, math.nan, math.nan]]))
    )


@pytest.mark.parametrize("slope", [0.2, -0.2])
@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_the_way_up_or_down_a_slope_is_shorter_in_a_map(slope: float, heading: float) -> None:
    """5 m/s for 10 s along a slope of 0.2 rad: 50 cos(0.2) = 49 m."""
    shown = rolled({"road_grade": {"slope": slope, "heading": heading}}, 0.0, 10.02, heading)
    assert np.hypot(shown[-1, X], shown[-1, Y]) == pytest.approx(50.0 * math.cos(slope), rel=1e-9)
    assert shown[:, V] == pytest.approx(SPEED)


@pytest.mark.parametrize("steer", [0.2, -0.2])
@pytest.mark.parametrize("direction", [0.0, 1.0])  # in which the plane rises
def test_a_circle_on_an_inclined_plane_is_an_ellipse_in_a_map(steer: float, direction: float) -> None:
    """L/tan(d) wide across the slope, cos(slope) times that along it, and closed: once round is once round."""
    slope = 0.15
    plane = {
        "road_grade": {"slope": slope, "heading": direction},
        "road_bank": {"slope": slope, "heading": direction - 0.5 * math.pi},
    }
    radius = CAR["wheelbase"] / math.tan(abs(steer))
    round_once = 2.0 * math.pi * radius / SPEED
    shown = rolled(plane, steer, round_once + 0.02)
    along = shown[:, X] * math.cos(direction) + shown[:, Y] * math.sin(direction)
    across = shown[:, Y] * math.cos(direction) - shown[:, X] * math.sin(direction)
    assert np.ptp(across) == pytest.approx(2.0 * radius, rel=1e-3)
    assert np.ptp(along) == pytest.approx(2.0 * radius * math.cos(slope), rel=1e-3)  # 1.1 % less
    last = round_once / 0.02 - (len(shown) - 1)  # of a step that is missing, or too much
    assert abs(shown[-1, YAW]) == pytest.approx(2.0 * math.pi - last * 0.02 * SPEED / radius, abs=2e-3)
    assert np.hypot(shown[-1, X], shown[-1, Y]) < 0.02 * SPEED + 0.02


def test_a_ramp_that_winds_up_a_car_park_is_narrower_in_a_map_than_its_circle() -> None:
    """A helix of the slope g whose ground is level across: its curvature is cos^2(g)/R about the normal of the ground,
    tan(d)/L. So R = cos^2(g) L/tan(d), and once round takes 2 pi R/(v cos(g))."""
    grade, steer = 0.15, 0.2
    radius = math.cos(grade) ** 2 * CAR["wheelbase"] / math.tan(steer)
    car = plant(v=SPEED, steer=steer)
    car.road(0.0, grade)
    rows = []
    for _ in range(round(2.0 * math.pi * radius / (SPEED * math.cos(grade)) * 1e3)):
        pull = 9.80665 * math.sin(grade)
        car.command(steer, accel=pull)  # holds the speed
        rows.append(car.advance(1)[0])
    shown = np.array(rows)
    assert shown[:, 5] == pytest.approx(SPEED, rel=1e-6)
    assert np.ptp(shown[:, 2]) == pytest.approx(2.0 * radius, rel=1e-4)
    assert shown[-1, 4] == pytest.approx(2.0 * math.pi, abs=1e-3)
    assert shown[-1, 8] == pytest.approx(SPEED * math.tan(steer) / CAR["wheelbase"], rel=1e-6)  # a gyroscope's


def test_what_a_hill_takes_is_its_height_in_the_map() -> None:
    """v^2/2 = v0^2/2 - g z(x, y): the height where the map says that the car is, on the flank of a steep hill."""
    top, size = 4.0, 12.0
    hill = {"road_profile": {"height": top, "x": 40.0, "y": 0.0, "length": size}}
    car = Plant(model(effects=hill), every=1)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=12.0))
    rows = car.advance(7000)
    height = top * np.exp(-0.5 * ((rows[:, 1] - 40.0) / size) ** 2)
    assert rows[-1, 1] > 70.0
    begun = 0.5 * 12.0**2 + 9.80665 * top * math.exp(-0.5 * (40.0 / size) ** 2)
    assert 0.5 * rows[:, 5] ** 2 + 9.80665 * height == pytest.approx(begun, abs=0.05)
