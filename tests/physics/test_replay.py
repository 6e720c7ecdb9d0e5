"""Replay of logs: what holds between stamps, what a row shows, how a segment starts, what a value may reach."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vehicle_models import CAR, model

from vehicle.messages import FloatArray
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.errors import ModelError
from vehicle.model.open_loop import MEASURED_COLUMNS, Replay
from vehicle.model.vehicle_model import VehicleModel

L = CAR["wheelbase"]
X, Y, YAW, V, RATE, AX, AY, STEER = range(8)
T = np.arange(500) * 0.02
STEERING = 0.15 * np.sin(0.9 * T) + 0.05 * np.sign(np.sin(2.3 * T))
PUSH = np.where(T < 4, 2.0, np.where(T < 5, 0.0, np.where(T < 7, -2.0, 1.0)))
COMMANDS = {"steer_cmd": STEERING, "accel_cmd": PUSH}
AT_REST = np.zeros((1, 6))


def moving(v: float, yaw: float = 0.0, x: float = 0.0, y: float = 0.0) -> FloatArray:
    return np.array([[x, y, yaw, v, math.nan, math.nan]])


def run(
    values: dict[tuple[str, str], float] | None = None,
    *,
    commands: dict[str, FloatArray] | None = None,
    t: FloatArray = T,
    v: float = 0.0,
    base: VehicleModel | None = None,
) -> FloatArray:
    replay = Replay(base or model(), t, COMMANDS if commands is None else commands)
    return replay.run(values, starts=np.array([0]), states=moving(v))


def test_the_columns_are_those_of_the_log() -> None:
    assert MEASURED_COLUMNS == ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")
    assert run().shape == (500, 8)


def test_the_ideal_car_turns_and_pushes_as_commanded_in_the_same_row() -> None:
    rows = run(v=3.0)
    assert np.abs(rows[:, RATE] - rows[:, V] * np.tan(STEERING) / L).max() < 1e-12
    assert np.abs(rows[:, AX] - PUSH).max() < 1e-9
    assert np.abs(rows[:, AY] - rows[:, V] * rows[:, RATE]).max() < 1e-12
    assert (rows[:, STEER] == STEERING).all()


def test_a_command_holds_from_its_stamp_to_the_next() -> None:
    rows = run(commands={"steer_cmd": np.zeros(500), "accel_cmd": np.where(np.arange(500) == 10, 1.0, 0.0)}, v=3.0)
    assert rows[10, V] == 3.0
    assert rows[11, V] == pytest.approx(3.02, abs=1e-12)
    assert rows[499, V] == pytest.approx(3.02, abs=1e-12)


def test_positions_agree_with_an_independent_integration() -> None:
    def rate(t: float, q: FloatArray) -> list[float]:
        k = min(int(t / 0.02 + 1e-9), 499)
        return [q[3] * math.cos(q[2]), q[3] * math.sin(q[2]), q[3] * math.tan(STEERING[k]) / L, PUSH[k]]

    rows = run(v=3.0)
    q = np.array([0.0, 0.0, 0.0, 3.0])
    worst = 0.0
    for k in range(499):
        worst = max(worst, float(np.abs(rows[k, :4] - q).max()))
        q = solve_ivp(rate, (T[k], T[k + 1] - 1e-9), q, "RK45", rtol=1e-9, atol=1e-10).y[:, -1]
    assert worst < 2e-3  # m and rad and m/s after 10 s


def test_uneven_stamps_give_the_same_motion() -> None:
    uneven = np.sort(np.concatenate((T, np.random.default_rng(1).uniform(0.0, 9.9, 300))))
    held = np.searchsorted(T, uneven + 1e-12, side="right") - 1
    values = {("steer_delay", "T"): 0.13, ("steer_lag", "tau"): 0.2, ("drive_delay", "T"): 0.071}
    even = run(values, v=3.0)
    other = run(values, commands={"steer_cmd": STEERING[held], "accel_cmd": PUSH[held]}, t=uneven, v=3.0)
    shared = np.flatnonzero(np.isin(uneven, T))
    assert np.abs(other[shared] - even)[:, [X, Y, YAW, V]].max() < 1e-3


def test_long_pauses_are_divided() -> None:
    t = np.array([0.0, 0.02, 5.0, 5.02])
    rows = run(commands={"steer_cmd": np.full(4, 0.1), "accel_cmd": np.zeros(4)}, t=t, v=2.0)
    radius = L / math.tan(0.1)
    assert rows[2, X] == pytest.approx(radius * math.sin(2.0 * 5.0 / radius), abs=1e-4)


def test_missing_commands_hold_the_last_value() -> None:
    sparse = np.where(np.arange(500) % 5 == 0, STEERING, np.nan)
    held = STEERING[np.arange(500) // 5 * 5]
    with_gaps = run(commands={"steer_cmd": sparse, "accel_cmd": PUSH}, v=3.0)
    assert (with_gaps == run(commands={"steer_cmd": held, "accel_cmd": PUSH}, v=3.0)).all()


def test_a_log_begins_with_actuators_at_rest_at_its_first_command() -> None:
    held = {"steer_cmd": np.full(500, 0.1), "accel_cmd": np.full(500, 0.5)}
    actuators = (
        "steer_delay",
        "steer_lag",
        "steer_rate_limit",
        "steer_ratio",
        "drive_delay",
        "drive_lag",
        "jerk_limit",
    )
    keys = [(n, k) for n in actuators for k in catalogue()[n].parameters]
    values = {(n, k.name): 0.3 if k.neutral == 0.0 else min(1.1, k.maximum) for n, k in keys}
    rows = run(values, commands=held, v=3.0)
    assert np.abs(rows[:, STEER] - 0.11).max() < 1e-12
    assert np.abs(rows[:, AX] - 0.5).max() < 1e-9


def test_a_segment_starts_at_its_state_while_actuators_run_on() -> None:
    values = {("steer_lag", "tau"): 0.3, ("steer_delay", "T"): 0.1, ("steer_backlash", "half_width"): 0.01}
    replay = Replay(model(), T, COMMANDS)
    whole = replay.run(values, starts=np.array([0]), states=moving(3.0))
    cut = replay.run(
        values,
        starts=np.array([0, 200]),
        states=np.vstack((moving(3.0), moving(5.0, yaw=1.0, x=7.0, y=8.0))),
    )
    assert cut[200, :4] == pytest.approx([7.0, 8.0, 1.0, 5.0])
    assert (cut[:, STEER] == whole[:, STEER]).all()
    assert (cut[:200] == whole[:200]).all()


def test_a_segment_at_another_speed_stays_on_its_curve() -> None:
    held = {"steer_cmd": np.full(500, 0.05), "accel_cmd": np.zeros(500)}
    replay = Replay(model("dynamic_bicycle"), T, held)
    states = np.vstack((moving(6.0), moving(9.0)))
    rows = replay.run(starts=np.array([0, 250]), states=states)
    assert rows[250, RATE] / 9.0 == pytest.approx(rows[249, RATE] / rows[249, V], rel=1e-3)


SHOWN_ELSEWHERE = (
    "gnss_latency",
    "gnss_lever_arm",
    "heading_bias",
    "wheel_radius",
    "wheel_slip",
    "front_wheel_speed",
)  # than where the car is
RUN_ON = [e.name for e in catalogue().values() if e.slot != "perception" and e.name not in SHOWN_ELSEWHERE]


@pytest.mark.parametrize("name", RUN_ON)
@pytest.mark.nightly(by_day=4)
def test_a_segment_that_starts_where_the_car_is_changes_nothing(name: str) -> None:
    effect = catalogue()[name]
    values = {(name, k.name): k.low + 0.4 * (k.high - k.low) for k in effect.parameters}
    replay = Replay(model(), T, COMMANDS)
    whole = replay.run(values, starts=np.array([0]), states=moving(3.0))
    states = np.full((5, 6), np.nan)
    states[:, :4] = whole[::100, :4]
    cut = replay.run(values, starts=np.arange(0, 500, 100), states=states)
    assert np.abs(cut - whole).max() < 1e-9


def test_a_late_pose_keeps_its_past_where_a_segment_starts_elsewhere() -> None:
    late = {("gnss_latency", "T"): 0.2}
    replay = Replay(model(), T, COMMANDS)
    prompt = replay.run(starts=np.array([0]), states=moving(3.0))
    whole = replay.run(late, starts=np.array([0]), states=moving(3.0))
    assert np.abs(whole[10:, X] - prompt[:-10, X]).max() < 1e-9
    turned = prompt[200, :4] + np.array([5.0, -3.0, 1.5, 0.0])  # the same motion, seen from another place
    cut = replay.run(late, starts=np.array([0, 200]), states=np.vstack((moving(3.0), [[*turned, math.nan, math.nan]])))
    c, s = math.cos(1.5), math.sin(1.5)
    dx, dy = whole[200:, X] - prompt[200, X], whole[200:, Y] - prompt[200, Y]
    assert np.abs(cut[200:, X] - (turned[0] + c * dx - s * dy)).max() < 1e-9
    assert np.abs(cut[200:, Y] - (turned[1] + s * dx + c * dy)).max() < 1e-9


def test_a_measured_speed_is_followed_from_stamp_to_stamp() -> None:
    v = 5.0 + np.sin(T)
    rows = run(commands={"steer_cmd": np.zeros(500), "v": v}, base=model(longitudinal=("v",)))
    assert np.abs(rows[:, V] - v).max() < 1e-12
    assert rows[-1, X] == pytest.approx(np.trapezoid(v, T), abs=1e-9)


def test_a_measured_angle_runs_straight_between_stamps() -> None:
    t = np.array([0.0, 1.0, 2.0])
    rows = run(
        commands={"steer": np.array([0.0, 0.02, 0.04]), "v": np.full(3, 5.0)},
        t=t,
        base=model(steer="steer", longitudinal=("v",)),
    )
    assert rows[:, STEER] == pytest.approx([0.0, 0.02, 0.04], abs=1e-12)
    assert rows[2, YAW] == pytest.approx(5.0 / L * 0.04, rel=1e-3)  # int of 0.02 t over 2 s


@pytest.mark.parametrize("K", [-0.002, 0.001, 0.006, 0.015])
@pytest.mark.parametrize("v", [3.0, 8.0, 15.0])
def test_understeer_on_a_kinematic_car_is_its_definition(K: float, v: float) -> None:
    d = 0.004
    held = {"steer_cmd": np.full(500, d), "v": np.full(500, v)}
    bare = {k: x for k, x in CAR.items() if not k.startswith("cornering")}
    from vehicle.model.car import make_car
    from vehicle.model.vehicle_model import Inputs

    base = VehicleModel("kinematic_bicycle", Inputs(longitudinal=("v",)), make_car(bare))
    rows = run({("understeer", "K"): K}, commands=held, base=base)
    assert rows[-1, RATE] == pytest.approx(v * d / (L + K * v * v), rel=3e-4)


def test_a_released_pedal_brakes_and_a_pressed_one_does_not() -> None:
    push = np.where(T < 2.0, 0.049, np.where(T < 4.0, 0.051, -0.04))
    rows = run({("lift_off_braking", "a"): 0.6}, commands={"steer_cmd": np.zeros(500), "accel_cmd": push}, v=9.0)
    assert rows[50, AX] == pytest.approx(0.049 - 0.6, abs=1e-9)
    assert rows[150, AX] == pytest.approx(0.051, abs=1e-9)
    assert rows[300, AX] == pytest.approx(-0.04 - 0.6, abs=1e-9)
    assert rows[:, V].min() >= 0.0  # it never pushes the car backward


def test_below_the_second_gear_an_engine_is_mass_and_nothing_else() -> None:
    """A car that never passes 9 m/s, where its command alone moves it: a fifth more of its mass."""
    push = np.where(T < 4.0, 2.0, np.where(T < 6.0, 0.0, -1.5))
    commands = {"steer_cmd": np.zeros(500), "accel_cmd": push}
    geared = run({("gear_inertia", "share"): 0.2, ("gear_inertia", "v1"): 9.0}, commands=commands)
    assert 5.0 < geared[:, V].max() < 9.0
    assert geared == pytest.approx(run({("mass", "ratio"): 1.2}, commands=commands), abs=1e-9)


@pytest.mark.parametrize("v", [5.0, 12.0])
def test_an_elastic_steering_understeers_by_its_compliance_times_the_front_load(v: float) -> None:
    c, d = 0.004, 0.004  # rad/kN, rad
    held = {"steer_cmd": np.full(500, d), "v": np.full(500, v)}
    rows = run({("steer_compliance", "c"): c}, commands=held, base=model("dynamic_bicycle", longitudinal=("v",)))
    m, a, b = CAR["mass"], CAR["cg_to_front_axle"], L - CAR["cg_to_front_axle"]
    tyres = m / L * (b / CAR["cornering_stiffness_front"] - a / CAR["cornering_stiffness_rear"])
    K = tyres + c * 1e-3 * m * b / L
    assert rows[-1, RATE] == pytest.approx(v * d / (L + K * v * v), rel=3e-4)
    front = m * b / L * v * rows[-1, RATE]
    assert rows[-1, STEER] == pytest.approx(d - c * 1e-3 * front, rel=1e-3)


def test_an_accelerometer_ahead_of_the_axle_feels_the_turning() -> None:
    base = model("dynamic_bicycle", steer="steer", longitudinal=("v",))
    held = {"steer": 0.02 * np.sin(3.0 * T), "v": np.full(500, 10.0)}
    at_axle, ahead = (
        run(commands=held, base=base),
        run({("parameters", "ax_x"): 1.3, ("parameters", "ay_x"): 1.3}, commands=held, base=base),
    )
    turning = np.gradient(at_axle[:, RATE], 0.02)
    assert np.abs(ahead[:, AY] - at_axle[:, AY] - 1.3 * turning)[5:-5].max() < 2e-3
    assert np.abs(ahead[:, AX] - at_axle[:, AX] + 1.3 * at_axle[:, RATE] ** 2).max() < 1e-12


def test_an_effect_at_its_neutral_value_leaves_the_base_model_untouched() -> None:
    plain = run(v=3.0)
    for effect in catalogue().values():
        assert (run({(effect.name, k.name): k.neutral for k in effect.parameters}, v=3.0) == plain).all(), effect.name


def test_values_reach_car_and_input_map() -> None:
    longer = run({("parameters", "wheelbase"): 5.0}, v=3.0)
    assert longer[50, RATE] == pytest.approx(longer[50, V] * math.tan(STEERING[50]) / 5.0)
    pedals = {"steer_cmd": np.zeros(500), "throttle_cmd": np.full(500, 0.5)}
    rows = run({("inputs", "full_throttle"): 4.0}, commands=pedals, base=model(longitudinal=("throttle_cmd",)))
    assert rows[-1, AX] == pytest.approx(2.0, abs=1e-9)
    scaled = run({("inputs", "steer_scale"): 0.4, ("inputs", "steer_zero"): 0.01}, v=3.0)
    assert np.abs(scaled[:, STEER] - (0.4 * STEERING + 0.01)).max() < 1e-12


def test_the_same_call_gives_the_same_bytes() -> None:
    replay = Replay(model(), T, COMMANDS)
    values = {("tyre_relaxation", "length"): 0.5, ("gnss_latency", "T"): 0.1}
    assert replay.run(values).tobytes() == replay.run(values).tobytes()


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({("steer_dellay", "T"): 0.1}, "did you mean 'steer_delay'"),
        ({("steer_delay", "tau"): 0.1}, "allowed: T"),
        ({("steer_delay", "T"): -0.1}, "found -0.1"),
        ({("inputs", "full_throtle"): 1.0}, "did you mean 'full_throttle'"),
    ],
)
def test_a_wrong_value_is_one_clear_line(values: dict[tuple[str, str], float], says: str) -> None:
    with pytest.raises(ModelError, match=says):
        run(values)


@pytest.mark.parametrize(
    ("t", "commands", "says"),
    [
        (T[::-1], COMMANDS, "increase"),
        (np.where(T == 1.0, np.nan, T), COMMANDS, "finite"),
        (T, {"steer_cmd": STEERING}, "accel_cmd: the log lacks this input"),
        (T, {**COMMANDS, "steer_cmd": STEERING[:-1]}, "another length"),
        (T, {**COMMANDS, "steer_cmd": np.full(500, np.nan)}, "no value"),
    ],
)
def test_a_log_that_cannot_drive_the_model_is_refused(
    t: FloatArray, commands: dict[str, FloatArray], says: str
) -> None:
    with pytest.raises(ModelError, match=says):
        Replay(model(), t, commands)


def test_the_blind_logs_replay_without_gaps(shared_dir: object) -> None:
    from pathlib import Path

    from vehicle.model.model_file import read_model

    folder = Path(str(shared_dir)) / "blind"
    found = read_model(folder / "model.toml")
    logs = sorted(folder.glob("case_*/*.csv"))
    assert len(logs) == 32
    for path in logs[::5]:
        with path.open(encoding="utf-8") as file:
            names = [name.split(" ")[0] for name in file.readline().split(",")]
            table = np.loadtxt(file, delimiter=",")
        log = dict(zip(names, table.T, strict=True))
        starts = np.arange(0, len(table) - 100, 250)
        states = np.full((len(starts), 6), np.nan)
        states[:, :4] = np.column_stack([log[key][starts] for key in ("x", "y", "yaw", "v")])
        rows = Replay(found, log["t"], log).run(starts=starts, states=states)
        assert np.isfinite(rows).all()
        assert np.abs(rows[:, X] - log["x"]).max() < 40.0  # within a segment of 5 s


def test_a_car_restarted_in_a_turn_by_its_log_goes_on_turning() -> None:
    """Tyres in a turn slip; no log says how much. A start without slip would show 1 m/s^2 too little in ay."""
    from pytest_dvp.gap.compare.segments import cut, measured_array

    car = model("dynamic_bicycle")
    replay = Replay(car, T, {"steer_cmd": np.full(500, 0.05), "accel_cmd": np.where(T < 3.0, 2.0, 0.0)})
    whole = replay.run()
    names = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")
    log = {"t": T, **{name: whole[:, i] for i, name in enumerate(names)}}
    segments = cut(T, measured_array(log), length=2.0)
    assert len(segments.starts) > 3
    again = replay.run(starts=segments.starts, states=segments.states)
    later = T > 4.0
    assert whole[later, AY].min() > 0.5
    assert np.abs(again[later, AY] - whole[later, AY]).max() < 0.02
