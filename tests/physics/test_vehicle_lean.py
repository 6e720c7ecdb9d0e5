"""The leaning body: what its springs add to an accelerometer, against closed forms and an independent integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lsim
from vehicle_models import CAR, model

from vehicle.messages import VehicleState
from vehicle.model.open_loop import Replay
from vehicle.model.plant import Plant
from vehicle.model.wind import air_coefficients

T = np.arange(500) * 0.02
V, AX, AY = 3, 5, 6
STRAIGHT = {"steer_cmd": np.zeros(500), "accel_cmd": np.where(T < 2.0, 0.0, 1.5)}
ROLLING = np.array([[0.0, 0.0, 0.0, 10.0, 0.0, 0.0]])
GAIN, FREQUENCY, DAMPING = 0.12, 1.6, 0.25


def lean(name: str, frequency: float = FREQUENCY, damping: float = DAMPING) -> dict[tuple[str, str], float]:
    return {(name, "gain"): GAIN, (name, "frequency"): frequency, (name, "damping"): damping}


def test_a_step_of_drive_makes_the_body_nod_like_a_damped_mass_on_a_spring() -> None:
    rows = Replay(model(), T, STRAIGHT).run(lean("body_pitch"), starts=np.array([0]), states=ROLLING)
    since = np.maximum(T - 2.0, 0.0)
    w = 2.0 * math.pi * FREQUENCY
    damped = w * math.sqrt(1.0 - DAMPING**2)
    swing = np.exp(-DAMPING * w * since) * (np.cos(damped * since) + DAMPING * w / damped * np.sin(damped * since))
    assert np.abs(rows[:, AX] - STRAIGHT["accel_cmd"] * (1.0 + GAIN * (1.0 - swing))).max() < 1e-9
    overshoot = math.exp(-math.pi * DAMPING / math.sqrt(1.0 - DAMPING**2))
    assert rows[:, AX].max() == pytest.approx(1.5 * (1.0 + GAIN * (1.0 + overshoot)), abs=0.002)


def test_the_body_sways_under_the_side_force_of_its_tyres() -> None:
    t = np.arange(2500) * 0.002
    weaving = {"steer_cmd": 0.03 * np.sin(2.0 * math.pi * 1.3 * t), "accel_cmd": np.zeros(2500)}
    replay = Replay(model("dynamic_bicycle"), t, weaving)
    middle = {("parameters", "ay_x"): CAR["wheelbase"] - CAR["cg_to_front_axle"]}
    pushed = replay.run(middle, starts=np.array([0]), states=ROLLING)[:, AY]  # F_y/m: at the centre of gravity
    shown = replay.run({**middle, **lean("body_roll")}, starts=np.array([0]), states=ROLLING)[:, AY]
    w = 2.0 * math.pi * FREQUENCY
    _, sway, _ = lsim(([w * w], [1.0, 2.0 * DAMPING * w, w * w]), pushed, t)
    assert np.abs(shown - pushed).max() > 0.15
    assert np.abs(shown - pushed - GAIN * sway).max() < 0.01


def test_lead_and_inertia_are_of_the_rate_and_the_acceleration_of_that_sway() -> None:
    t = np.arange(2500) * 0.002
    weaving = {"steer_cmd": 0.03 * np.sin(2.0 * math.pi * 1.3 * t), "accel_cmd": np.zeros(2500)}
    replay = Replay(model("dynamic_bicycle"), t, weaving)
    middle = {("parameters", "ay_x"): CAR["wheelbase"] - CAR["cg_to_front_axle"]}
    pushed = replay.run(middle, starts=np.array([0]), states=ROLLING)[:, AY]
    lead, inertia = 0.012, -0.001
    finer = {("body_roll", "lead"): lead, ("body_roll", "inertia"): inertia}
    shown = replay.run({**middle, **lean("body_roll"), **finer}, starts=np.array([0]), states=ROLLING)[:, AY]
    w = 2.0 * math.pi * FREQUENCY
    top = [w * w * inertia, w * w * lead, w * w * GAIN]
    _, added, _ = lsim((top, [1.0, 2.0 * DAMPING * w, w * w]), pushed, t)
    assert np.abs(shown - pushed - added).max() < 0.02
    _, plain, _ = lsim(([w * w * GAIN], [1.0, 2.0 * DAMPING * w, w * w]), pushed, t)
    assert np.abs(added - plain).max() > 0.1


def test_in_a_steady_turn_a_swaying_body_shows_what_a_rigid_lean_does() -> None:
    turn = {"steer_cmd": np.full(500, 0.04), "accel_cmd": np.zeros(500)}
    replay = Replay(model("dynamic_bicycle"), T, turn, step=0.01)
    swaying = replay.run(lean("body_roll", damping=0.7), starts=np.array([0]), states=ROLLING)
    rigid = replay.run({("roll", "gain"): GAIN}, starts=np.array([0]), states=ROLLING)
    assert swaying[-1, AY] == pytest.approx(rigid[-1, AY], rel=2e-3)
    assert abs(swaying[:, V] - rigid[:, V]).max() < 1e-12  # nothing but the instrument


@pytest.mark.parametrize("steer", [0.5, -0.5])
@pytest.mark.parametrize("pulling", [{}, {"steered_wheel_forces": {"drive": 1.0, "brake": 1.0}}])
def test_a_body_leans_by_the_part_of_its_steered_wheels_forces_that_acts_across(
    pulling: dict[str, dict[str, float]], steer: float
) -> None:
    """Side forces act at right angles to the wheels, drive along them: what acts across the body is m ay at its centre
    of gravity. In a turn that is steady, or nearly so, the body is as far out as a rigid lean has it."""
    car = model("dynamic_bicycle", pulling).with_car({"ay_x": CAR["wheelbase"] - CAR["cg_to_front_axle"]})
    commands = {"steer_cmd": np.full(500, steer), "accel_cmd": np.full(500, 1.0)}
    start = np.array([[0.0, 0.0, 0.0, 5.0, np.nan, np.nan]])
    swaying, rigid, stiff = (
        Replay(car, T, commands, step=0.005).run(values, starts=np.array([0]), states=start)
        for values in (lean("body_roll", damping=0.7), {("roll", "gain"): GAIN}, {})
    )
    leaning, wanted = (shown[200:, AY] - stiff[200:, AY] for shown in (swaying, rigid))
    assert np.abs(wanted).min() > 0.3
    assert leaning == pytest.approx(wanted, rel=0.01)


def test_wind_leans_a_body_by_what_its_tyres_hold_against_it() -> None:
    """A body that the wind pushes at its centre of gravity leans away from the wind, not as in a turn: -gain W/m where
    the tyres hold all of it. Then nothing accelerates, and the lean is all that is shown."""
    car = Plant(model("dynamic_bicycle", {"body_roll": {"gain": GAIN, "frequency": FREQUENCY, "damping": 0.7}}))
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=20.0))
    car.wind(0.0, 10.0)
    rows = []
    for _ in range(600):  # a driver who keeps the heading
        state = car.state
        car.command(-0.5 * state.yaw - 0.2 * state.yaw_rate)
        car.advance(10)
        rows.append(car.shown_row())
    pushed = air_coefficients(car.model)[1] * np.hypot(20.0, 10.0) * 10.0
    assert abs(rows[-1][8]) < 1e-3
    assert rows[-1][10] == pytest.approx(
        -GAIN * pushed, rel=0.1
    )  # the car drifts with the wind and slows down a little
