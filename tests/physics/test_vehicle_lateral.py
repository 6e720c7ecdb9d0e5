"""Motion across the road against closed forms and an independent integration."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vehicle_models import CAR, model, plant

from vehicle.messages import VehicleState
from vehicle.model.kernel import DYNAMIC, KINEMATIC, _blend, _tyres
from vehicle.model.open_loop import Replay
from vehicle.model.plant import Plant

L = CAR["wheelbase"]
A = CAR["cg_to_front_axle"]
B = L - A
M = CAR["mass"]
INERTIA = CAR["yaw_inertia"]
CF, CR = CAR["cornering_stiffness_front"], CAR["cornering_stiffness_rear"]
UNDERSTEER = M / L * (B / CF - A / CR)  # rad s^2/m


def test_kinematic_car_drives_the_circle_of_its_wheelbase() -> None:
    steer, v = 0.2, 5.0
    car = plant(v=v, steer=steer)
    car.command(steer)
    rows = car.advance(5000)
    radius = L / math.tan(steer)
    distance = np.hypot(rows[:, 1], rows[:, 2] - radius)
    assert np.abs(distance - radius).max() < 1e-5
    assert rows[-1, 4] == pytest.approx(v * 5.0 / radius, abs=1e-9)
    assert rows[-1, 10] == pytest.approx(v * v / radius, abs=1e-9)


@pytest.mark.parametrize("v", [3.0, 8.0, 20.0, 30.0])
def test_steady_turn_of_the_dynamic_car_has_the_yaw_rate_of_its_understeer_gradient(v: float) -> None:
    steer = 0.004
    car = plant("dynamic_bicycle", v=v, every=10)
    car.command(steer, accel=0.0)
    row = car.advance(5000)[-1]
    assert row[8] == pytest.approx(row[5] * steer / (L + UNDERSTEER * row[5] ** 2), rel=2e-4)


def test_steady_turn_has_the_textbook_slip_of_the_rear_axle() -> None:
    v, steer = 15.0, 0.01
    car = plant("dynamic_bicycle", v=v, every=10)
    car.command(steer)
    row = car.advance(5000)[-1]
    rear_force = M * A / L * row[5] * row[8]  # the rear axle carries a/L of the centripetal force
    assert row[7] / row[5] == pytest.approx(-rear_force / CR, rel=1e-3)


def _reference(v: float, steer_of_t: object, until: float) -> np.ndarray:
    """The same single-track equations, written apart and integrated by DOP853 to 1e-10, at 100 Hz."""

    def rate(t: float, state: np.ndarray) -> list[float]:
        _x, _y, yaw, vx, vy, r = state
        d = steer_of_t(t)  # type: ignore[operator]
        front = CF * (d - math.atan2(vy + A * r, vx))
        rear = CR * -math.atan2(vy - B * r, vx)
        vy_rear = vy - B * r
        return [
            vx * math.cos(yaw) - vy_rear * math.sin(yaw),
            vx * math.sin(yaw) + vy_rear * math.cos(yaw),
            r,
            r * vy - front * math.sin(d) / M,
            (front * math.cos(d) + rear) / M - vx * r,
            (A * front * math.cos(d) - B * rear) / INERTIA,
        ]

    t = np.arange(1, round(until * 100) + 1) / 100
    found = solve_ivp(rate, (0.0, until), [0.0, 0.0, 0.0, v, 0.0, 0.0], "DOP853", t, rtol=1e-10, atol=1e-12)
    return np.column_stack((t, found.y.T))


@pytest.mark.parametrize("v", [4.0, 12.0, 25.0])
def test_step_steer_transient_agrees_with_an_independent_integration(v: float) -> None:
    car = plant("dynamic_bicycle", v=v, every=10)
    car.command(0.03)
    rows, truth = car.advance(3000), _reference(v, lambda t: 0.03, 3.0)
    assert np.abs(rows[:, 8] - truth[:, 6]).max() < 2e-4  # rad/s
    assert np.abs(rows[:, 5] - truth[:, 4]).max() < 1e-3  # m/s
    assert np.hypot(rows[:, 1] - truth[:, 1], rows[:, 2] - truth[:, 2]).max() < 5e-3  # m


def test_halving_the_step_halves_the_error_at_least() -> None:
    truth = _reference(15.0, lambda t: 0.03, 2.0)
    errors = []
    for dt in (4e-3, 2e-3, 1e-3):
        car = plant("dynamic_bicycle", v=15.0, dt=dt, every=round(0.02 / dt))
        car.command(0.03)
        rows = car.advance(round(2.0 / dt))
        errors.append(np.abs(rows[:, 8] - truth[1::2, 6]).max())
    assert errors[1] < 0.55 * errors[0]
    assert errors[2] < 0.55 * errors[1]


def test_a_coarse_step_of_20_ms_stays_stable_with_stiff_tyres_at_low_speed() -> None:
    car = plant("dynamic_bicycle", v=2.5, dt=0.02, every=1)
    car.command(0.1)
    rows = car.advance(500)
    steady = rows[-100:, 8] / rows[-100:, 5]
    assert np.ptp(steady) < 1e-6
    assert np.abs(rows[:, 8]).max() < 1.2 * steady.mean() * rows[:, 5].max()


def test_below_one_metre_per_second_the_dynamic_car_is_kinematic() -> None:
    kinematic, dynamic = plant(v=0.95, steer=0.3), plant("dynamic_bicycle", v=0.95, steer=0.3)
    for car in (kinematic, dynamic):
        car.command(0.3)
    assert np.abs(kinematic.advance(3000) - dynamic.advance(3000)).max() < 1e-12


def test_passing_the_blend_between_both_models_makes_no_jump() -> None:
    car = plant("dynamic_bicycle", v=0.5, steer=0.2)
    car.command(0.2, accel=0.5)
    rows = car.advance(5000)
    per_metre = rows[:, 8] / rows[:, 5]
    assert np.abs(np.diff(per_metre)).max() < 2e-4  # 1/m a step; the curvature itself is 0.08


def test_reverse_is_kinematic() -> None:
    car = plant("dynamic_bicycle", v=-3.0, steer=0.2)
    car.command(0.2)
    assert car.advance(1000)[-1, 8] == pytest.approx(-3.0 * math.tan(0.2) / L, abs=1e-9)


def test_tyres_never_add_energy_to_a_coasting_car() -> None:
    car = plant("dynamic_bicycle", v=20.0)
    car.command(0.08)
    rows = car.advance(4000)
    vy = rows[:, 7] + B * rows[:, 8]
    energy = 0.5 * M * (rows[:, 5] ** 2 + vy**2) + 0.5 * INERTIA * rows[:, 8] ** 2
    assert np.diff(energy).max() < 1e-5 * energy[0]
    assert energy[-1] < energy[0]


def test_saturated_tyres_hold_lateral_acceleration_below_their_limit() -> None:
    car = plant("dynamic_bicycle", {"tyre_saturation": {"limit": 5.0}}, v=25.0)
    car.command(0.3)
    rows = car.advance(2000)
    centre = rows[:, 10] + B * np.gradient(rows[:, 8], 1e-3)  # ay at the centre of gravity
    assert np.abs(centre[10:]).max() < 5.0
    assert np.abs(centre).max() > 4.0


def test_steer_lag_follows_the_first_order_step_response() -> None:
    tau = 0.2
    car = plant(effects={"steer_lag": {"tau": tau}}, v=2.0)
    car.command(0.1)
    rows = car.advance(1000)
    assert np.abs(rows[:, 11] - 0.1 * (1.0 - np.exp(-rows[:, 0] / tau))).max() < 1e-6


def test_steer_delay_moves_the_whole_turn() -> None:
    car = plant(effects={"steer_delay": {"T": 0.25}}, v=5.0)
    car.command(0.1)
    rows = car.advance(1000)
    assert rows[-1, 4] == pytest.approx(5.0 * math.tan(0.1) / L * 0.75, abs=1e-9)


def test_steer_delay_starts_from_the_angle_at_reset() -> None:
    car = plant(effects={"steer_delay": {"T": 0.2}, "steer_lag": {"tau": 0.1}}, v=5.0, steer=0.15)
    car.command(0.15)
    assert (car.advance(500)[:, 11] == 0.15).all()


def test_steer_rate_limit_ramps() -> None:
    car = plant(effects={"steer_rate_limit": {"limit": 0.4}}, v=2.0)
    car.command(0.3)
    rows = car.advance(1000)
    assert np.abs(rows[:, 11] - np.minimum(0.4 * rows[:, 0], 0.3)).max() < 1e-9


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_steer_angle_limit_is_an_end_stop_on_both_sides(sign: float) -> None:
    car = plant(effects={"steer_angle_limit": {"limit": 0.35}, "steer_rate_limit": {"limit": 1.0}}, v=2.0)
    car.command(sign * 2.0)
    assert car.advance(1000)[-1, 11] == pytest.approx(sign * 0.35)
    car.command(0.0)  # it leaves the stop at once: nothing wound up behind it
    assert abs(car.advance(100)[-1, 11]) == pytest.approx(0.25)


def test_bank_shows_on_the_accelerometer_at_rest() -> None:
    car = plant()
    car.road(0.0, bank=0.1)
    assert car.advance(1)[0, 10] == pytest.approx(9.80665 * math.sin(0.1), abs=1e-9)


@pytest.mark.parametrize(
    ("speed", "share"), [(0.0, 0.0), (0.99, 0.0), (1.25, 0.15625), (1.5, 0.5), (1.75, 0.84375), (2.01, 1.0)]
)
def test_tyres_take_over_smoothly_from_the_least_speed_to_twice_of_it(speed: float, share: float) -> None:
    """3 s^2 - 2 s^3 between 1 and 2 m/s: slip angles divide by the speed and mean nothing when the car hardly rolls."""
    assert _blend.py_func(SimpleNamespace(vx=speed, slow=1.0), DYNAMIC) == pytest.approx(share)
    assert _blend.py_func(SimpleNamespace(vx=speed, slow=1.0), KINEMATIC) == 0.0


@pytest.mark.parametrize("speed", [1.6, 10.0])
def test_slip_angles_are_those_of_the_directions_in_which_the_axles_move(speed: float) -> None:
    """Textbook slip angles of a single track, with a lateral speed of 0.2 m/s and a yaw rate of 0.3 rad/s."""
    x = SimpleNamespace(vx=speed, slow=1.5, vy=0.2, yaw_rate=0.3, steer=0.05, cg_front=1.2, cg_rear=1.5,
                        stiffness_front=8e4, stiffness_rear=9e4)  # fmt: skip
    _tyres.py_func(x)
    assert x.slip_front == pytest.approx(0.05 - math.atan((0.2 + 1.2 * 0.3) / speed))
    assert x.slip_rear == pytest.approx(-math.atan((0.2 - 1.5 * 0.3) / speed))
    assert (x.fy_front, x.fy_rear) == pytest.approx((8e4 * x.slip_front, 9e4 * x.slip_rear))


@pytest.mark.parametrize("steer", [0.2, -0.2])
@pytest.mark.parametrize("speed", [-3.0, -1.0, 0.3, 0.9])
def test_an_elastic_steering_gives_way_by_the_force_of_the_path_of_a_slow_or_reversing_car(
    speed: float, steer: float
) -> None:
    """The front axle carries m b/L v^2 k of a path of curvature k = tan(d)/L, and d = d_c - c F: some milliradians."""
    compliance = 1e-5  # rad/N
    car = plant("dynamic_bicycle", {"steer_compliance": {"c": 1e3 * compliance}}, v=speed, steer=steer)
    car.command(steer)
    last = car.advance(500)[-1]
    given = steer
    for _ in range(20):
        given = steer - compliance * M * B / L * speed**2 * math.tan(given) / L
    assert last[11] == pytest.approx(given, abs=1e-6)
    assert last[8] == pytest.approx(speed * math.tan(given) / L, abs=1e-6)


def test_what_is_shown_of_a_turn_is_that_of_the_place_of_the_accelerometer() -> None:
    """Rigid body: at a point p ahead, ay is greater by r' p, and ax smaller by r^2 p; the motion itself is the same."""
    commands = np.zeros((4000, 6))
    commands[:, 0] = 0.03 * np.sin(0.003 * np.arange(4000))
    rows = []
    for place in (0.0, 1.3):
        car = Plant(model("dynamic_bicycle").with_car({"ax_x": place, "ay_x": place}))
        car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=10.0))
        rows.append(car.drive(commands, 1, measured=True).copy())
    axle, ahead = rows
    turning = np.gradient(axle[:, 8], 0.01)
    assert np.abs(turning).max() > 0.3
    assert ahead[5:-5, 10] - axle[5:-5, 10] == pytest.approx(1.3 * turning[5:-5], abs=2e-3)
    assert axle[:, 9] - ahead[:, 9] == pytest.approx(1.3 * axle[:, 8] ** 2)
    assert (np.delete(ahead, (9, 10), axis=1) == np.delete(axle, (9, 10), axis=1)).all()


def test_a_car_that_has_not_moved_yet_shows_where_it_was_put() -> None:
    car = Plant(model().with_car({"ax_x": 1.5}))
    car.reset(VehicleState(t=2.0, x=3.0, y=-4.0, yaw=0.5, v=8.0, yaw_rate=0.2, ax=0.6, ay=1.6))
    assert car.shown_row() == pytest.approx([2.0, 3.0, -4.0, 0.0, 0.5, 8.0, 8.0, 0.0, 0.2, 0.6 - 1.5 * 0.04, 1.6, 0.0])


def energy(rows: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Of rows (n, 12) of TRACE_COLUMNS, over the mass [m^2/s^2]."""
    across = rows[:, 7] + B * rows[:, 8]
    found: np.ndarray[tuple[int], np.dtype[np.float64]] = 0.5 * (
        rows[:, 5] ** 2 + across**2 + INERTIA / M * rows[:, 8] ** 2
    )
    return found


@pytest.mark.parametrize("steer", [0.5, -0.5])
@pytest.mark.parametrize("speed", [1.2, 1.6, 1.9])
@pytest.mark.parametrize("effects", [{}, {"parallel_steering": {"share": 1.5}}, {"tyre_saturation": {"limit": 4.0}}])
def test_a_car_that_coasts_round_slowly_gains_nothing(
    effects: dict[str, dict[str, float]], speed: float, steer: float
) -> None:
    """Where tyres take over, what turns the car must come out of its speed; once it turns, it only gets slower."""
    car = plant("dynamic_bicycle", effects, v=speed)
    car.command(steer)
    rows = car.advance(12_000)
    assert rows[:, 5].max() <= speed + 1e-9
    gained = energy(rows[2000:])
    assert (gained - gained[0]).max() < 0.01 * gained[0]  # in 10 s; the rule of the step is of second order


@pytest.mark.parametrize(("steer", "share"), [(0.1, 0.0025), (0.3, 0.0231), (0.5, 0.0672)])
def test_a_car_with_tyres_pays_for_turning_in_and_gets_it_back(steer: float, share: float) -> None:
    """m (v^2 + (b r)^2) + I r^2 stays where stiff tyres keep r = v tan(d)/L; the shares of a car with I = m a b and its
    centre in the middle are those of docs/effects.md. A kinematic car pays nothing."""
    stiff = {"cornering_stiffness_front": 1e6, "cornering_stiffness_rear": 1e6}
    round_numbers = {"cg_to_front_axle": 0.5 * L, "yaw_inertia": M * 0.25 * L * L, **stiff}
    there_and_back = np.zeros((4000, 6))
    there_and_back[:, 0] = steer * np.minimum(np.arange(4000), 4000 - np.arange(4000)) / 2000.0  # 2 s each
    for base, paid in (("dynamic_bicycle", share), ("kinematic_bicycle", 0.0)):
        car = Plant(model(base).with_car(round_numbers), every=1)  # type: ignore[arg-type]
        car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=5.0))
        v = car.drive(there_and_back, 1)[:, 5]
        assert 1.0 - v[1999] / 5.0 == pytest.approx(paid, rel=0.1, abs=1e-9)  # tyres slip a little
        assert v[-1] == pytest.approx(5.0, rel=0.1 * share)


@pytest.mark.parametrize("speed", [1.4, 1.8])
def test_a_replay_of_a_car_that_coasts_round_slowly_gains_nothing_either(speed: float) -> None:
    t = np.arange(500) * 0.02
    replay = Replay(model("dynamic_bicycle"), t, {"steer_cmd": np.full(500, 0.5), "accel_cmd": np.zeros(500)})
    state = np.array([[0.0, 0.0, 0.0, speed, np.nan, np.nan]])
    shown = replay.run(starts=np.array([0]), states=state)
    assert shown[:, 3].max() < 1.02 * speed


@pytest.mark.parametrize(
    ("name", "values"),
    [("axle_load_shift", {"c": 0.2}), ("steered_wheel_forces", {"drive": 1.0, "brake": 0.6})],
)
@pytest.mark.parametrize(
    "beside",
    [{}, {"road_grade": {"slope": 0.15}, "aero_drag": {"k": 0.003}, "motor_inertia": {"J": 0.3}}, {"command_mass": {}}],
)
def test_forces_of_an_imposed_speed_are_those_that_drive_and_brakes_would_have(
    name: str, values: dict[str, float], beside: dict[str, dict[str, float]]
) -> None:
    """On a hill against the wind, too, and in a car whose mass is not the one that commands are for."""
    t = np.arange(0.0, 12.0, 0.02)
    accel = np.where(t < 6.0, 2.0, -3.0) * np.minimum(np.abs(t - 6.0), 1.0)
    commands = {"steer_cmd": 0.03 + 0.02 * np.sin(0.8 * t), "accel_cmd": accel, "brake_cmd": 0.0 * t}
    start = {"starts": np.array([0]), "states": np.array([[0.0, 0.0, 0.0, 8.0, math.nan, math.nan]])}
    effects = {k: dict(v) for k, v in beside.items() if k != "command_mass"}
    car = {"command_mass": CAR["mass"] / (1.4 if "command_mass" in beside else 1.0)}

    def made(values: dict[str, dict[str, float]], **inputs: object) -> Any:
        return model("dynamic_bicycle", effects | values, **inputs).with_car(car)

    driven = Replay(made({name: values}), t, commands).run(**start)  # type: ignore[arg-type]
    v = {"steer_cmd": commands["steer_cmd"], "v": driven[:, 3]}

    def turning(effects: dict[str, dict[str, float]], **more: float) -> np.ndarray:
        given = Replay(made(effects | {k: {"g": x} for k, x in more.items()}, longitudinal=("v",)), t, v)
        return np.asarray(given.run(**start)[:, 4])  # type: ignore[arg-type]

    with_it, without = turning({name: values}), turning({})
    off = np.abs(without - driven[:, 4]).max()
    assert np.abs(with_it - driven[:, 4]).max() < 0.05 * off  # its acceleration is a slope over 0.2 s
    assert off > 0.003
    # What drive and brakes make of commands says nothing of it.
    assert turning({name: values}, drive_gain=0.5, brake_gain=0.5) == pytest.approx(with_it, abs=0.0)


@pytest.mark.parametrize("effects", [{}, {"steer_compliance": {"c": 0.004}}])
def test_what_relaxing_tyres_show_at_a_stamp_does_not_follow_from_the_length_of_the_steps(
    effects: dict[str, dict[str, float]],
) -> None:
    """Steps of the steering by 0.05 rad, which bend the path at 3 m/s^2."""
    t = np.arange(0.0, 4.0, 0.02)
    commands = {"steer_cmd": np.where(np.floor(2.0 * t) % 2.0 == 0.0, 0.0, 0.05), "accel_cmd": 0.0 * t}
    car = model("dynamic_bicycle", {"tyre_relaxation": {"length": 0.6}, **effects})
    start = {"starts": np.array([0]), "states": np.array([[0.0, 0.0, 0.0, 12.0, math.nan, math.nan]])}
    shown, fine = (Replay(car, t, commands, step=step).run(**start) for step in (None, 2.5e-4))  # type: ignore[arg-type]
    assert np.abs(fine[:, 6]).max() > 2.0
    assert shown[:, 6] == pytest.approx(fine[:, 6], abs=0.005)
