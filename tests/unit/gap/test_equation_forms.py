"""Effects as terms of equations: which each needs, on which grid it is tried, and what it adds, by its definition."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pytest_dvp.gap.diagnose.regression_signals import Signals, lagged, rate_limited, with_play, with_stiction
from pytest_dvp.gap.diagnose.regressors import FORMS, base
from pytest_dvp.gap.diagnose.tyre_regressors import RIGID, on_tyres
from pytest_dvp.logs.log_contents import FloatArray

N, STEP, W, L = 400, 0.02, 5, 2.5
T = STEP * np.arange(N)
G = 9.80665
FORM = {form.name: form for form in FORMS}


def a_signal(**given: Any) -> Signals:
    """8 s in which everything varies, both pedals are pressed and released, and the steering goes both ways."""
    accel = np.round(2.0 * np.sin(1.3 * T + 0.3), 1)
    fields: dict[str, Any] = {
        "step": STEP, "w": W, "rows": np.arange(20, 380, 5), "t": T, "v": 8.0 + 3.0 * np.sin(0.5 * T),
        "rate": 0.3 * np.cos(0.9 * T), "yaw": 0.4 * T - 1.0, "accel": np.where(np.abs(accel) < 0.4, 0.0, accel),
        "steer": 0.2 * np.sin(0.8 * T - 0.4), "wheelbase": L, "cg_front": 1.1, "gyration": 1.6,
        "measured": dict.fromkeys(("dv", "ax", "r", "dyaw", "ay", "forward", "sideways"), np.zeros(72)), "noise": {},
    }  # fmt: skip
    return Signals(**(fields | given))


S = a_signal()
A, D = np.asarray(S.accel), np.asarray(S.steer)
TURN = S.v * np.tan(D) / L


def mean(y: FloatArray) -> FloatArray:
    return np.array([y[row - W : row + W].mean() for row in S.rows])


def late(y: FloatArray, by: float) -> FloatArray:
    """Mean of a held signal over each window, `by` [s] ago: part of the row before counts."""
    shift = by / STEP
    whole, part = int(shift), shift - int(shift)
    return np.array([(1.0 - part) * y[row - W - whole : row + W - whole].mean()
                     + part * y[row - W - whole - 1 : row + W - whole - 1].mean() for row in S.rows])  # fmt: skip


def added(name: str, p: float = 0.0) -> dict[str, FloatArray]:
    return {series: np.asarray(values) for series, values in FORM[name].of(S, p).items()}


def along(change: FloatArray) -> dict[str, FloatArray]:
    return {"dv": change, "ax": change}


def across(change: FloatArray) -> dict[str, FloatArray]:
    return {"r": change, "dyaw": change}


def same(found: dict[str, FloatArray], expected: dict[str, FloatArray]) -> None:
    assert set(found) == set(expected)
    for name, values in expected.items():
        assert found[name] == pytest.approx(values, abs=1e-9), name


def column(*values: FloatArray) -> FloatArray:
    return np.column_stack(values)


ONE = np.ones(N)
LAG = np.full(N, STEP / 0.3)
WHEEL = {
    "steer_lag": (0.3, lagged(D, LAG)), "steer_rate_limit": (0.4, rate_limited(D, 0.4 * STEP)),
    "steer_angle_limit": (0.1, np.clip(D, -0.1, 0.1)), "steer_stiction": (0.03, with_stiction(D, 0.03)),
    "steer_backlash": (0.02, with_play(D, 0.02)),
}  # fmt: skip
PEDAL = {
    "drive_lag": (0.3, lagged(A, LAG)), "jerk_limit": (2.0, rate_limited(A, 2.0 * STEP)),
    "brake_limit": (1.1, np.maximum(A, -1.1)), "pedal_deadband": (0.9, np.where(np.abs(A) < 0.9, 0.0, A)),
    "power_limit": (9.0, np.where(A * S.v > 9.0, 9.0 / S.v, A)),
    "brake_lag": (0.3, np.where(A < 0.0, lagged(np.where(A < 0.0, A, 0.0), LAG), A)),
}  # fmt: skip


@pytest.mark.parametrize("name", list(PEDAL))
def test_an_actuator_of_the_pedals_acts_in_place_of_the_command(name: str) -> None:
    p, acts = PEDAL[name]
    same(added(name, p), along(mean(acts) - mean(A)))
    assert FORM[name].needs == ("accel",)


@pytest.mark.parametrize("name", list(WHEEL))
def test_an_actuator_of_the_steering_acts_in_place_of_the_command(name: str) -> None:
    p, acts = WHEEL[name]
    same(added(name, p), across(mean(S.v * np.tan(acts) / L) - mean(TURN)))
    assert FORM[name].needs == ("steer",)


@pytest.mark.parametrize(
    ("name", "columns"),
    [("drive_gain", [np.where(A > 0.0, A, 0.0)]), ("brake_gain", [np.where(A < 0.0, A, 0.0)]), ("mass", [A]),
     ("lift_off_braking", [-1.0 * (A == 0.0)]), ("rolling_resistance", [-ONE]), ("viscous_resistance", [-S.v]),
     ("aero_drag", [-S.v * S.v]), ("cornering_drag", [-np.abs(S.v * S.rate)])],
)  # fmt: skip
def test_a_force_is_linear_in_its_size(name: str, columns: list[FloatArray]) -> None:
    same(added(name), along(column(*(mean(c) for c in columns))))
    assert (FORM[name].needs, FORM[name].grid) == (("accel",), ())


def test_an_engine_takes_less_of_the_acceleration_the_faster_the_car_is() -> None:
    """Up to 5 m/s the lowest gear; at twice that the ratio is a half, and a quarter of it."""
    slow, fast = (a_signal(v=np.full(N, v)) for v in (4.0, 10.0))
    same(FORM["gear_inertia"].of(slow, 0.0), along(column(mean(-A))))
    same(FORM["gear_inertia"].of(fast, 0.0), along(column(mean(-0.25 * A))))
    assert (FORM["gear_inertia"].needs, FORM["gear_inertia"].grid) == (("accel",), ())


@pytest.mark.parametrize(
    ("name", "columns"),
    [("steer_ratio", [D]), ("steer_offset", [ONE]),
     ("steer_asymmetry", [np.where(D > 0.0, D, 0.0), np.where(D < 0.0, D, 0.0)])],
)  # fmt: skip
def test_an_angle_turns_the_car_by_speed_over_wheelbase(name: str, columns: list[FloatArray]) -> None:
    same(added(name), across(column(*(mean(c * S.v / L) for c in columns))))
    assert (FORM[name].needs, FORM[name].grid) == (("steer",), ())


def test_drag_acts_against_the_motion_and_idle_is_a_small_command() -> None:
    back = a_signal(v=-S.v)
    assert FORM["aero_drag"].of(back, 0.0)["dv"] == pytest.approx(column(mean(S.v * S.v)))
    idle = a_signal(accel=np.where(np.arange(N) < 200, 0.049, -0.051))
    shown = FORM["lift_off_braking"].of(idle, 0.0)["ax"][:, 0]
    assert (shown[S.rows < 190] == -1.0).all()
    assert (shown[S.rows > 210] == 0.0).all()


def test_an_idling_gearbox_pushes_a_slow_car_with_both_pedals_released() -> None:
    slow = a_signal(v=np.full(N, 1.0), accel=np.where(np.arange(N) < 200, 0.04, 0.06))
    for ends, push in ((1.0, 0.0), (2.0, 0.5), (4.0, 0.75)):
        shown = FORM["creep"].of(slow, ends)["ax"][:, 0]
        assert shown[slow.rows < 190] == pytest.approx(push)
        assert (shown[slow.rows > 210] == 0.0).all()
    assert (FORM["creep"].needs, FORM["creep"].grid) == (("accel",), (1.0, 2.0, 4.0))


def test_what_comes_late_is_an_older_mean() -> None:
    same(added("drive_delay", 0.13), along(late(A, 0.13) - mean(A)))
    same(added("gnss_latency", 0.13), {"dyaw": late(TURN, 0.13) - mean(TURN), "forward": late(S.v, 0.13) - mean(S.v)})
    later = np.interp(T + 0.13, T, S.rate)
    same(added("yaw_rate_latency", 0.13), {"r": late(TURN, 0.13) - mean(TURN), "ay": mean(S.v * (later - S.rate))})
    steps = np.interp(T - 0.13, T + 0.5 * STEP, D)
    held = np.interp(T + 0.5 * STEP, T, steps)
    same(added("steer_delay", 0.13), across(mean(S.v * np.tan(held) / L) - mean(TURN)))


def test_sensors_show_what_their_faults_say() -> None:
    one = np.ones((72, 1))
    ay, nothing = mean(S.v * S.rate), np.zeros(72)
    same(added("gyro_bias"), {"r": one, "ay": column(-mean(S.v))})
    same(added("accelerometer_bias"), {"ax": one})
    same(added("lateral_accelerometer_bias"), {"ay": one})
    same(added("imu_misalignment"), {"ax": column(ay), "ay": column(-mean(A))})
    same(added("pitch"), {"ax": column(mean(A))})
    same(added("roll"), {"ay": column(ay)})
    same(added("heading_bias"), {"sideways": column(-mean(S.v))})
    same(
        added("gnss_lever_arm"), {"forward": column(nothing, -mean(S.rate)), "sideways": column(mean(S.rate), nothing)}
    )
    same(added("wheel_radius"), {"forward": column(-mean(S.v)), "ay": column(-ay), "dv": column(mean(A)),
                                 "r": column(-mean(TURN)), "dyaw": column(-mean(TURN))})  # fmt: skip
    bare = FORM["wheel_radius"].of(a_signal(accel=None, steer=None), 0.0)
    assert set(bare) == {"forward", "ay"}
    slope = G * column(mean(np.cos(S.yaw)), mean(np.sin(S.yaw)))
    same(added("road_grade"), {"dv": -slope})
    same(added("road_bank"), {"ay": slope})
    lean = lagged(S.rate * S.v / G, np.full(N, STEP / 0.2))
    same(added("roll_dynamics"), across(column(mean(-lean * S.v / L))))


def test_an_ideal_car_does_what_it_is_asked() -> None:
    found = base(S)
    nothing = np.zeros(72)
    same(dict(found), {**along(mean(A)), **across(mean(TURN)), "ay": nothing, "forward": nothing, "sideways": nothing})
    same(dict(base(a_signal(accel=None, measured={"dv": nothing, "r": nothing}))), {"dv": nothing, "r": mean(TURN)})
    same(dict(base(a_signal(steer=None, measured={"dv": nothing, "r": nothing}))), {"dv": mean(A), "r": nothing})


GRIDS = {
    "force_rise": (0.01, 0.04, 3),
    "drive_delay": (0.04, 0.6, 7), "drive_lag": (0.05, 1.0, 7), "brake_lag": (0.05, 1.0, 7),
    "jerk_limit": (0.7, 20.0, 9), "power_limit": (1.0, 40.0, 9), "brake_limit": (0.7, 9.0, 9),
    "pedal_deadband": (0.05, 0.8, 7), "creep": (1.0, 4.0, 3),
    "steer_delay": (0.03, 0.6, 7), "steer_lag": (0.03, 0.8, 7), "steer_rate_limit": (0.04, 1.0, 9),
    "steer_angle_limit": (0.05, 0.6, 9), "steer_stiction": (0.002, 0.05, 7), "steer_backlash": (0.002, 0.05, 7),
    "cornering_compliance": (0.002, 0.03, 7), "tyre_saturation": (1.5, 12.0, 9), "tyre_relaxation": (0.1, 4.0, 7),
    "yaw_rate_latency": (0.02, 0.5, 7), "gnss_latency": (0.03, 0.6, 7),
}  # fmt: skip


def test_each_effect_that_is_not_linear_is_tried_in_equal_ratios() -> None:
    for name, (low, high, count) in GRIDS.items():
        ratio = (high / low) ** (1.0 / (count - 1))
        assert FORM[name].grid == pytest.approx([low * ratio**k for k in range(count)]), name
    both = FORM["understeer"].grid
    left, right = [0.0005, 0.0005 * 40.0**0.5, 0.02], [0.0005 * 40.0 ** (k / 6.0) for k in range(7)]
    assert both == pytest.approx([*(-x for x in left), *right])
    assert {name for name, form in FORM.items() if form.grid} == {*GRIDS, "understeer"}
    assert {name for name, form in FORM.items() if not form.needs} == {
        "road_bank", "wheel_radius", "gyro_bias", "roll", "heading_bias", "gnss_lever_arm",
        "lateral_accelerometer_bias",
    }  # fmt: skip
    assert {name for name, form in FORM.items() if form.needs == ("accel",)} >= {
        "accelerometer_bias",
        "pitch",
        "road_grade",
    }


def single_track(front: float, rear: float, v: float, steer: float, seconds: float) -> tuple[float, float]:
    """Yaw rate and sideways speed of the rear axle of the linear single-track car (Mitschke) after a step of steering:
    m (w' + v r) = F_f + F_r, J r' = a F_f - b F_r, with forces per mass of the slip over each axle's compliance."""
    a, b, j = S.cg_front, L - S.cg_front, S.gyration

    def slope(_: float, y: Any) -> list[float]:
        w, r = y
        f = b / L / front * (steer - (w + a * r) / v)
        g = a / L / rear * (-(w - b * r) / v)
        return [f + g - v * r, (a * f - b * g) / j]

    r0 = v * steer / L
    end = solve_ivp(slope, (0.0, seconds), [b * r0, r0], rtol=1e-9, atol=1e-12).y[:, -1]
    return float(end[1]), float(end[0] - b * end[1])


@pytest.mark.parametrize(("front", "rear"), [(0.02, 0.02), (0.03, 0.01), (0.004, 0.02)])
def test_a_car_on_tyres_is_the_linear_single_track_car(front: float, rear: float) -> None:
    v, steer = np.full(N, 9.0), np.full(N, 0.05)
    rate, side = on_tyres(a_signal(v=v, steer=steer), front, rear)
    for row in (10, 25, 60, 399):
        r, w = single_track(front, rear, 9.0, 0.05, row * STEP)
        assert rate[row] == pytest.approx(r, rel=0.03)
        assert side[row] == pytest.approx(w, rel=0.05, abs=0.003)
    steady = 9.0 * 0.05 / (L + (front - rear) * 81.0)
    assert rate[-1] == pytest.approx(steady, rel=1e-3)
    assert side[-1] == pytest.approx(-rear * 81.0 * steady, rel=1e-2)


def test_tyres_that_saturate_carry_no_more_than_their_limit_and_slow_ones_roll() -> None:
    v, ramp = np.full(N, 15.0), np.linspace(0.0, 0.05, N)  # without slip 4.5 m/s^2 at its end
    rate, side = on_tyres(a_signal(v=v, steer=ramp), 0.003, 0.003, limit=3.0)
    sideways = np.gradient(side + (L - S.cg_front) * rate, STEP) + v * rate
    assert 2.5 < sideways.max() <= 3.01
    plain, _ = on_tyres(a_signal(v=v, steer=ramp), 0.003, 0.003)
    assert 15.0 * plain[-1] > 4.0
    free, _ = on_tyres(a_signal(v=v, steer=np.full(N, 0.001)), 0.01, 0.01, limit=3.0)
    plain, _ = on_tyres(a_signal(v=v, steer=np.full(N, 0.001)), 0.01, 0.01)
    assert free[-1] == pytest.approx(plain[-1], rel=1e-3)
    slow, side = on_tyres(a_signal(v=np.full(N, 0.99), steer=D), 0.02, 0.02)
    assert slow == pytest.approx(0.99 * np.tan(D) / L)
    assert (side == 0.0).all()
    _, side = on_tyres(a_signal(v=np.full(N, 1.01), steer=D), 0.02, 0.02)
    assert np.abs(side[1:]).max() > 0.0


def test_a_force_builds_up_over_its_length() -> None:
    """A step of steering at the front, from rolling straight: after the relaxation length the force has 1 - 1/e."""
    steer = np.where(np.arange(N) < 50, 0.0, 0.02)
    v = np.full(N, 10.0)
    quick, _ = on_tyres(a_signal(v=v, steer=steer), RIGID, RIGID)
    slow, _ = on_tyres(a_signal(v=v, steer=steer), RIGID, RIGID, length=3.0)
    assert slow[-1] == pytest.approx(quick[-1], rel=0.01)
    half_quick = np.flatnonzero(quick > 0.5 * quick[-1])[0]
    half_slow = np.flatnonzero(slow > 0.5 * slow[-1])[0]
    assert 0.05 < (half_slow - half_quick) * STEP < 0.5
    rises = np.diff(slow[50:60])
    assert rises[0] < 0.3 * rises.max()  # at first hardly a force, so hardly an acceleration
    assert RIGID == 0.0021


@pytest.mark.parametrize(
    ("name", "p", "front", "rear", "more"),
    [("understeer", 0.01, RIGID + 0.01, RIGID, {}), ("understeer", -0.01, RIGID, RIGID + 0.01, {}),
     ("cornering_compliance", 0.01, 0.01, 0.01, {}), ("tyre_saturation", 4.0, RIGID, RIGID, {"limit": 4.0}),
     ("tyre_relaxation", 1.0, RIGID, RIGID, {"length": 1.0})],
)  # fmt: skip
def test_effects_of_tyres_are_cars_on_such_tyres(name: str, p: float, front: float, rear: float, more: Any) -> None:
    rate, side = on_tyres(S, front, rear, **more)
    same(
        added(name, p), {**across(mean(rate) - mean(TURN)), "sideways": mean(side), "ay": mean(np.gradient(side, STEP))}
    )
