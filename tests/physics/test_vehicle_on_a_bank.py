"""A banked road beside what follows from the side forces of tyres, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from vehicle_models import CAR, model

from vehicle.model.open_loop import Replay

G = 9.80665
T = np.arange(0.0, 12.0, 0.02)
V, YAW_RATE, AX, AY, STEER = 3, 4, 5, 6, 7  # columns of a row
BANK = 0.1  # rad, left side up
STIFF = ("cornering_stiffness_front", "cornering_stiffness_rear")


def shown(base: str, effects: dict[str, dict[str, float]], steer: float, v: float, accel: float = 0.0) -> np.ndarray:
    """What a drive at a held command shows on a bank in the direction of the x axis, (n, 8)."""
    car = model(base, {"road_bank": {"slope": BANK}, **effects})  # type: ignore[arg-type]
    replay = Replay(car, T, {"steer_cmd": 0.0 * T + steer, "accel_cmd": 0.0 * T + accel})
    states = np.array([[0.0, 0.0, 0.0, v, math.nan, math.nan]])
    return np.asarray(replay.run(starts=np.array([0]), states=states))


def test_a_body_that_leans_on_a_bank_turns_the_wheels_of_a_car_that_drives_straight_on() -> None:
    """Without turning, the axles slip by the weight across alone: d = gain sin(bank) + m/L (b/C_f - a/C_r) g sin(bank).
    The heading stays, so the bank does, too."""
    length, front, mass = CAR["wheelbase"], CAR["cg_to_front_axle"], CAR["mass"]
    soft = mass / length * ((length - front) / CAR[STIFF[0]] - front / CAR[STIFF[1]])
    steer = (0.1 + soft * G) * math.sin(BANK)
    rows = shown("dynamic_bicycle", {"roll_dynamics": {"gain": 0.1, "tau": 0.2}}, steer, 10.0)
    assert abs(rows[-1, YAW_RATE]) < 1e-3
    slow = shown("dynamic_bicycle", {"roll_dynamics": {"gain": 0.1, "tau": 0.2}}, 0.0, 0.5)
    assert slow[[0, -1], STEER] == pytest.approx(-0.1 * math.sin(BANK), rel=3e-3)


def test_tyres_that_hold_a_car_on_a_bank_drag_as_those_that_turn_it() -> None:
    """c g sin(bank) of a car that drives straight on; none where the bank turns the car and the tyres need not."""
    straight = shown("kinematic_bicycle", {"cornering_drag": {"c": 0.2}}, 0.0, 10.0)
    assert straight[100, AX] == pytest.approx(-0.2 * G * math.sin(BANK))
    bend = math.atan(-G * math.sin(BANK) / 10.0**2 * CAR["wheelbase"])  # v r = -g sin(bank)
    turning, free = (shown("kinematic_bicycle", e, bend, 10.0) for e in ({"cornering_drag": {"c": 0.2}}, {}))
    assert turning[0, AX] == pytest.approx(free[0, AX], abs=1e-9)


@pytest.mark.parametrize("base", ["kinematic_bicycle", "dynamic_bicycle"])
@pytest.mark.parametrize("v", [0.0, 0.8])
def test_the_springs_of_a_slow_car_on_a_bank_give_way_as_those_of_a_fast_one(base: str, v: float) -> None:
    rows = shown(base, {"body_roll": {"gain": 0.2}}, 0.0, v)
    assert rows[[0, -1], AY] == pytest.approx(1.2 * G * math.sin(BANK), rel=5e-3)


def test_a_car_that_gets_faster_on_a_bank_sways_without_a_jump() -> None:
    """From 0.5 to 2.5 m/s, past the speeds between which its tyres come in; its springs are steady in 0.2 s."""
    lean = {"gain": 0.2, "frequency": 4.0, "damping": 0.9}
    swaying, stiff = (shown("dynamic_bicycle", e, 0.2, 0.5, 0.25) for e in ({"body_roll": lean}, {}))
    leaning = swaying[:400, AY] - stiff[:400, AY]
    assert np.abs(np.diff(leaning)).max() < 0.005
    assert leaning == pytest.approx(0.2 * stiff[:400, AY], abs=0.05)  # it is 0.1 s late


def heights(rows: np.ndarray) -> np.ndarray:
    """Of the centre of gravity above a plane that rises by BANK to the left of the x axis [m]."""
    rear = CAR["wheelbase"] - CAR["cg_to_front_axle"]
    return np.asarray(math.tan(BANK) * rows[:, 1] + math.sin(BANK) * rear * np.sin(rows[:, 2]))


@pytest.mark.parametrize("v", [3.0, -3.0])
def test_a_car_that_turns_without_slip_on_a_slope_keeps_its_energy(v: float) -> None:
    """Up in a bend and back again: what its centre of gravity gains in height is what v^2/2 loses. The plane has a
    slope along and one across, those of `road_grade` and `road_bank` with one rise."""
    slope = {"slope": BANK, "heading": math.pi / 2.0}  # up along y
    rows = shown("kinematic_bicycle", {"road_grade": slope}, 0.3, v)
    assert np.ptp(rows[:, 2]) > 1.5
    energy = 0.5 * rows[:, V] ** 2 + G * heights(rows)
    assert energy == pytest.approx(energy[0], abs=0.08)  # steps of 0.02 s; 0.8 if only the rear axle climbs


def test_a_slow_car_whose_wheels_are_turned_uphill_is_held_back_by_its_weight() -> None:
    """-g sin(bank) b tan(d)/L along a slope, and a dynamic car between both kinds of motion hardly otherwise."""
    kept = -G * math.sin(BANK) * (CAR["wheelbase"] - CAR["cg_to_front_axle"]) * math.tan(0.3) / CAR["wheelbase"]
    for v in (0.9, 1.5):
        rows = shown("dynamic_bicycle", {}, 0.3, v)
        assert (rows[5, V] - v) / 0.1 == pytest.approx(kept, rel=0.15)
