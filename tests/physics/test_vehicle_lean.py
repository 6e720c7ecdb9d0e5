"""The leaning body: what its springs add to an accelerometer, against closed forms and an independent integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lsim
from vehicle_models import CAR, model

from vehicle.model.open_loop import Replay

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
