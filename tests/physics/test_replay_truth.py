"""Every effect of the kernel against a car written apart: other integrator, other step, own actuators (tests/truth).

Same commands, same effect with the same values; the difference is measured in the sensor noise of the blind cases.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tests.truth.effects import CATALOGUE, TYRE_EFFECTS, FloatArray, TruthCar, stiffnesses, typical
from tests.truth.generate import MEASURED, SIGMA, make_log
from vehicle.model.car import make_car
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.open_loop import Replay
from vehicle.model.vehicle_model import Inputs, VehicleModel

SHOWN_ONLY = ("gnss_latency", "gnss_lever_arm", "heading_bias", "wheel_radius")  # these alter the pose that is logged
SIGMAS = np.array([SIGMA[name] for name in MEASURED])


@cache
def columns(name: str, drive: str) -> dict[str, FloatArray]:
    effects = {name: typical(name)} if name else {}
    return make_log(effects, drive, 3, "none")  # type: ignore[arg-type]


def baseline(name: str) -> VehicleModel:
    truth = TruthCar()
    known = {
        "wheelbase": truth.wheelbase,
        "cg_to_front_axle": truth.cg_to_front_axle,
        "mass": truth.mass,
        "yaw_inertia": truth.yaw_inertia,
    }
    if name in TYRE_EFFECTS:
        front, rear = stiffnesses(truth, {name: typical(name)})
        if name == "understeer":  # ours softens the front of a neutral car
            front = rear * (truth.wheelbase - truth.cg_to_front_axle) / truth.cg_to_front_axle
        known |= {"cornering_stiffness_front": front, "cornering_stiffness_rear": rear}
    inputs = Inputs(longitudinal=("speed_cmd",)) if name == "speed_controller" else Inputs()
    return VehicleModel("kinematic_bicycle", inputs, make_car(known))


def excess(name: str, drive: str) -> FloatArray:
    """Mean squared error over sigma squared of each channel, on segments of 5 s that begin at the truth."""
    log = columns(name, drive)
    true = columns("" if name in SHOWN_ONLY else name, drive)
    starts = np.arange(0, len(log["t"]) - 100, 250)
    states = np.full((len(starts), 6), np.nan)
    states[:, :4] = np.column_stack([true[key][starts] for key in ("x", "y", "yaw", "v")])
    values = {(name, key): value for key, value in typical(name).items()} if name else {}
    rows = Replay(baseline(name), log["t"], log).run(values, starts=starts, states=states)
    measured = np.column_stack([log[key] for key in MEASURED])
    return np.asarray((((measured - rows[:, :7]) / SIGMAS) ** 2).mean(axis=0))


def test_the_truth_covers_the_catalogue_of_the_car() -> None:
    ours = {e.name for e in catalogue().values() if e.slot != "perception"}
    assert ours - set(CATALOGUE) == {
        *("accel_controller", "motor_damping", "motor_inertia", "motor_torque"),
        *(
            "body_pitch",
            "body_roll",
            "cornering_compliance",
            "force_rise",
        ),  # tested elsewhere: surrogate, multi-body cars
        *("axle_load_shift", "front_wheel_speed", "wheel_slip"),  # in test_vehicle_slipping_wheels,
        *("parallel_steering", "steered_wheel_forces"),  # with these
        *("brake_fade", "road_profile", "speed_limit", "steer_assist", "steer_servo"),  # in test_kernel_against_truth
    }


@pytest.mark.parametrize(("name", "drive"), [(name, drive) for drive in ("rich", "urban") for name in ("", *CATALOGUE)])
@pytest.mark.nightly(by_day=8)
def test_the_kernel_reproduces_the_truth_far_below_its_noise(name: str, drive: str) -> None:
    found = excess(name, drive)
    assert found.mean() < 0.1
    assert found.max() < (1.0 if name == "roll_dynamics" else 0.2)  # ay of its fast, hardly damped swing


@pytest.mark.parametrize("name", CATALOGUE)
@pytest.mark.nightly(by_day=4)
def test_without_the_effect_the_kernel_does_not(name: str) -> None:
    log = columns(name, "rich")
    plain = Replay(baseline(name), log["t"], log)
    values = {(name, key): value for key, value in typical(name).items()}
    starts = np.arange(0, len(log["t"]) - 100, 250)
    states = np.full((len(starts), 6), np.nan)
    states[:, :4] = np.column_stack([log[key][starts] for key in ("x", "y", "yaw", "v")])
    difference = plain.run(starts=starts, states=states) - plain.run(values, starts=starts, states=states)
    assert ((difference[:, :7] / SIGMAS) ** 2).mean() > 1.05 * 0.1


def test_dead_time_is_right_to_a_millisecond() -> None:
    log = columns("steer_delay", "rich")
    replay = Replay(baseline("steer_delay"), log["t"], log)
    late = {T: np.abs(replay.run({("steer_delay", "T"): T})[:, 2] - log["yaw"]).max() for T in (0.149, 0.15, 0.151)}
    assert late[0.15] < 2e-5  # rad
    assert min(late[0.149], late[0.151]) > 1e-4


def test_brakes_do_not_push_a_standing_car_backward() -> None:
    """Released brakes and a start that arrives within the next step: until then the accelerometer shows nothing."""
    t = np.arange(0.0, 2.0, 0.02)
    accel = np.where(t < 1.0, -1.5, 2.0)
    commands = {"accel_cmd": accel, "steer_cmd": np.zeros_like(t)}
    rows = Replay(baseline("drive_delay"), t, commands).run({("drive_delay", "T"): 0.07})
    assert rows[t < 1.065, 5] == pytest.approx(0.0, abs=1e-9)
    assert rows[t > 1.075, 5] == pytest.approx(2.0, rel=1e-9)
    assert rows[:, 3] == pytest.approx(2.0 * np.maximum(t - 1.07, 0.0), abs=1e-9)


@pytest.mark.parametrize("drive", ["rich", "urban"])
def test_slip_of_both_axles_reproduces_a_truth_whose_tyres_slip(drive: str) -> None:
    """Its axles carry stiffness over load C/F_z, ours of the kinematic car 48/rad: D = (F_z/C - 1/48)/g."""
    truth = TruthCar()
    log = make_log({}, drive, 3, "none", body="dynamic")  # type: ignore[arg-type]
    load = truth.mass * 9.80665 * (truth.wheelbase - truth.cg_to_front_axle) / truth.wheelbase
    slip = (load / truth.stiffness_front - 1.0 / truth.rigid) / 9.80665
    replay = Replay(baseline(""), log["t"], log)
    starts = np.arange(0, len(log["t"]) - 100, 250)
    states = np.full((len(starts), 6), np.nan)
    states[:, :4] = np.column_stack([log[key][starts] for key in ("x", "y", "yaw", "v")])
    measured = np.column_stack([log[key] for key in MEASURED])

    def misfit(values: dict[tuple[str, str], float]) -> float:
        rows = replay.run(values, starts=starts, states=states)
        return float((((measured - rows[:, :7]) / SIGMAS) ** 2).mean())

    with_slip = misfit({("cornering_compliance", "D"): slip})
    assert with_slip < 0.025  # 0.1 at the low noise level
    assert misfit({}) > 10.0 * with_slip


@pytest.mark.parametrize(
    "names",
    [
        ("steer_compliance", "tyre_saturation"),  # the force that turns the wheel is the saturated one
        ("steer_compliance", "roll_dynamics"),
        ("steer_compliance", "tyre_relaxation"),
        ("tyre_saturation", "roll_dynamics"),
        ("steer_stiction", "steer_lag"),
        ("steer_stiction", "steer_delay"),
        ("steer_lag", "steer_rate_limit"),
        ("steer_angle_limit", "steer_offset"),
        ("steer_backlash", "steer_offset"),
        ("cornering_drag", "tyre_saturation"),
        ("drive_lag", "jerk_limit"),
    ],
)
@pytest.mark.nightly(by_day=4)
def test_two_effects_act_on_each_other_as_in_the_truth(names: tuple[str, str]) -> None:
    effects = {name: typical(name) for name in names}
    log = make_log(effects, "rich", 3, "none")
    front, rear = stiffnesses(TruthCar(), effects)
    car = baseline(names[0]).with_car({"cornering_stiffness_front": front, "cornering_stiffness_rear": rear})
    starts = np.arange(0, len(log["t"]) - 100, 250)
    states = np.full((len(starts), 6), np.nan)
    states[:, :4] = np.column_stack([log[key][starts] for key in ("x", "y", "yaw", "v")])
    values = {(name, key): value for name, keys in effects.items() for key, value in keys.items()}
    rows = Replay(car, log["t"], log).run(values, starts=starts, states=states)
    measured = np.column_stack([log[key] for key in MEASURED])
    assert (((measured - rows[:, :7]) / SIGMAS) ** 2).mean() < 0.1
