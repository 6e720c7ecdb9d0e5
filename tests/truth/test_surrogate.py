"""The double-track surrogate against statics, single-track theory and conservation of energy."""

from __future__ import annotations

import ast
import math
from pathlib import Path

import numpy as np
import pytest

from vehicle.messages import Command, FloatArray, VehicleState
from vehicle.surrogate.__main__ import main
from vehicle.surrogate.car import Car
from vehicle.surrogate.hidden import EFFECTS, PERCEPTION, Bound, Hidden, HiddenError, check_effects, read_hidden
from vehicle.surrogate.recorder import record
from vehicle.surrogate.surrogate import DoubleTrack

CAR = Car()
SMOOTH = Car(rolling_coefficient=0.0, drag_area=0.0)  # nothing but inertia and grip
G = 9.80665


def quiet(car: Car = CAR, **effects: dict[str, float]) -> Hidden:
    return Hidden(car, check_effects(effects), "none")


def drive(
    hidden: Hidden, seconds: float, steer: float = 0.0, accel: float = 0.0, speed: float = 0.0, step: float = 1e-3
) -> tuple[DoubleTrack, FloatArray]:
    """The car and its trace after `seconds` with one command, from `speed` straight ahead."""
    car = DoubleTrack(hidden, step=step)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=speed))
    car.apply(Command(t=0.0, steer=steer, accel=accel, throttle=0.0, brake=0.0))
    return car, car.step(seconds)


def steady(hidden: Hidden, speed: float, steer: float) -> tuple[DoubleTrack, FloatArray]:
    """A car that turns steadily with its speed held; the last row of its trace."""
    car = DoubleTrack(hidden)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=speed))
    for _ in range(600):
        car.apply(Command(t=0.0, steer=steer, accel=4.0 * (speed - car.state.v), throttle=0.0, brake=0.0))
        rows = car.step(0.01)
    return car, rows[-1]


def test_wheel_loads_at_rest_carry_the_weight() -> None:
    car, _ = drive(quiet(), 1.0, accel=-1.0)
    loads = car.wheel_loads
    assert np.sum(loads) == pytest.approx(CAR.mass * G, rel=1e-9)
    front = CAR.mass * G * (CAR.wheelbase - CAR.cg_to_front_axle) / CAR.wheelbase
    assert loads[0] + loads[1] == pytest.approx(front, rel=1e-6)


def test_a_standing_car_stays_where_it_is_on_a_slope() -> None:
    car, rows = drive(quiet(road_grade={"slope": 0.1}), 10.0, accel=-3.0)
    assert abs(car.state.x) < 0.02
    assert abs(car.state.v) < 1e-3
    # the sensor feels the slope, and the springs that gave way to it
    assert rows[-1, 9] == pytest.approx(G * math.sin(0.1 - car.lean[1]), rel=5e-3)


def test_braking_moves_load_to_the_front_by_height_over_wheelbase() -> None:
    car, rows = drive(quiet(SMOOTH), 1.5, accel=-2.0, speed=10.0)
    loads = car.wheel_loads
    front = CAR.mass * G * (CAR.wheelbase - CAR.cg_to_front_axle) / CAR.wheelbase
    slowing = (rows[-1, 5] - rows[-11, 5]) / 0.1
    pitched = CAR.mass * G * CAR.cg_height * car.lean[1] / CAR.wheelbase
    moved = -CAR.mass * slowing * CAR.cg_height / CAR.wheelbase + pitched
    assert loads[0] + loads[1] - front == pytest.approx(moved, rel=0.02)
    assert car.lean[1] > 0.0  # nose down


def test_turning_left_moves_load_to_the_right_by_height_over_track() -> None:
    car, row = steady(quiet(), 8.0, 0.1)
    loads = car.wheel_loads
    lateral = row[8] * row[5]
    rolled = CAR.mass * G * CAR.cg_height * car.lean[0]
    moved = (CAR.mass * lateral * CAR.cg_height + rolled) / CAR.track
    assert 0.5 * (loads[1] + loads[3] - loads[0] - loads[2]) == pytest.approx(moved, rel=0.03)
    assert car.lean[0] > 0.0  # to the right, out of the turn
    assert np.sum(loads) == pytest.approx(CAR.mass * G, rel=1e-6)


@pytest.mark.parametrize("gradient", [0.0, 0.003, 0.008])
def test_small_turns_follow_the_single_track(gradient: float) -> None:
    """r = v d/(L + K v^2), K = (1/c_f - 1/c_r)/g from the stiffness over load of the axles; a hidden K adds itself."""
    own = (1.0 / CAR.cornering_front - 1.0 / CAR.cornering_rear) / G
    hidden = quiet(SMOOTH, understeer={"K": gradient})
    for speed in (5.0, 10.0):
        steer = 0.3 * CAR.wheelbase / speed**2
        _, row = steady(hidden, speed, steer)
        v, r = row[5], row[8]
        assert r == pytest.approx(v * steer / (CAR.wheelbase + (own + gradient) * v * v), rel=0.01)


def test_sharp_turns_understeer_by_load_transfer_and_saturation() -> None:
    _, gentle = steady(quiet(), 10.0, 0.01)
    _, sharp = steady(quiet(), 10.0, 0.15)
    assert sharp[8] / 0.15 < 0.97 * gentle[8] / 0.01
    assert sharp[8] * sharp[5] < CAR.friction * G


def test_nothing_turns_faster_than_the_friction_allows() -> None:
    _, row = steady(quiet(tyre_saturation={"limit": 3.0}), 9.0, 0.25)
    assert 2.2 < row[8] * row[5] < 3.05


def test_the_sensor_in_the_leaning_body_feels_gravity() -> None:
    car, row = steady(quiet(), 8.0, 0.1)
    assert row[10] == pytest.approx(row[8] * row[5] * math.cos(car.lean[0]) + G * math.sin(car.lean[0]), rel=0.02)


def test_full_drive_follows_torque_then_power() -> None:
    car = DoubleTrack(quiet(SMOOTH))
    car.apply(Command(t=0.0, steer=0.0, accel=10.0, throttle=0.0, brake=0.0))
    speeds = np.array([car.step(0.01)[0, 5] for _ in range(1200)])
    force = CAR.motor_torque * CAR.gear_ratio / CAR.wheel_radius
    heavy = CAR.mass + CAR.rotating_mass
    early = (speeds[150] - speeds[50]) / 1.0
    assert early == pytest.approx(force / heavy, rel=0.02)
    late = (speeds[700] - speeds[600]) / 1.0
    assert late == pytest.approx(CAR.motor_power / (heavy * speeds[650]), rel=0.03)


def test_the_motor_ends_at_its_speed() -> None:
    car, _ = drive(quiet(SMOOTH), 60.0, accel=5.0)
    assert car.state.v == pytest.approx(CAR.motor_speed / CAR.gear_ratio * CAR.wheel_radius, rel=0.01)


def test_wheels_and_motor_make_the_car_heavier_than_commanded() -> None:
    car, rows = drive(quiet(SMOOTH), 3.0, accel=1.0)
    gained = (rows[-1, 5] - rows[100, 5]) / ((len(rows) - 101) * 0.01)
    assert gained == pytest.approx(CAR.mass / (CAR.mass + CAR.rotating_mass), rel=0.01)
    assert car.state.v > 0.0


def test_energy_is_never_created() -> None:
    hidden = quiet(SMOOTH)
    car = DoubleTrack(hidden)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=10.0))
    before, spent = car.energy, car.work
    stored = 0.0
    for k in range(800):
        steer = 0.12 * math.sin(0.05 * k)
        accel = 1.5 if 200 <= k < 400 else (-1.5 if k >= 600 else 0.0)
        car.apply(Command(t=0.0, steer=steer, accel=accel, throttle=0.0, brake=0.0))
        car.step(0.01)
        # springs of the body hold some of it for a while
        roll, pitch = car.lean
        springs = 0.5 * (CAR.roll_stiffness_front + CAR.roll_stiffness_rear) * roll**2
        springs += 0.5 * CAR.pitch_stiffness * pitch**2
        assert car.energy - before <= car.work - spent + stored + 1.0
        before, spent, stored = car.energy, car.work, springs


def test_a_rolling_car_without_losses_keeps_its_speed() -> None:
    car, _ = drive(quiet(SMOOTH), 20.0, speed=10.0)
    assert car.state.v == pytest.approx(10.0, rel=1e-6)


def test_finer_steps_converge() -> None:
    ends = []
    for step in (1e-3, 5e-4, 2.5e-4):
        car = DoubleTrack(quiet(), step=step)
        car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=8.0))
        for k in range(200):
            steer = 0.08 * math.sin(0.06 * k)
            car.apply(Command(t=0.0, steer=steer, accel=1.0 if k < 100 else -2.0, throttle=0.0, brake=0.0))
            car.step(0.02)
        ends.append([car.state.x, car.state.y, car.state.yaw, car.state.v])
    coarse, middle, fine = np.array(ends)
    assert np.linalg.norm(coarse - fine) < 0.02
    assert np.linalg.norm(middle - fine) < 0.6 * np.linalg.norm(coarse - fine)


def signature(name: str) -> dict[str, float]:
    """A value of every key that should be seen."""
    special = {"road_grade": {"slope": 0.05, "heading": 0.0}, "road_bank": {"slope": 0.1, "heading": 0.0}}
    special["tyre_relaxation"] = {"length": 1.2}
    special["headwind"] = {"speed": 8.0, "k": 0.004, "heading": 0.5}
    special["brake_fade"] = {"k": 0.01, "tau": 60.0}
    special["road_profile"] = {"height": 1.0, "x": 20.0, "y": 5.0, "length": 15.0}
    if name in special:
        return special[name]
    limits = {
        "jerk_limit": 3.0,
        "power_limit": 8.0,
        "brake_limit": 1.5,
        "steer_rate_limit": 0.1,
        "drive_torque_limit": 0.6,
    }
    limits |= {"steer_angle_limit": 0.03, "tyre_saturation": 1.0}

    def value(bound: Bound) -> float:
        if math.isinf(bound.neutral):
            return limits[name]
        return bound.neutral + 0.3 * (min(bound.high, 1.0) - bound.neutral if bound.neutral < 1.0 else -0.5)

    return {key: value(bound) for key, bound in EFFECTS[name].items()}


@pytest.fixture(scope="module")
def plain() -> dict[str, FloatArray]:
    return record(quiet(), "urban", 3)


@pytest.mark.parametrize("name", sorted(set(EFFECTS) - set(PERCEPTION)))
@pytest.mark.nightly(by_day=8)
def test_every_effect_can_be_hidden_and_shows(name: str, plain: dict[str, FloatArray]) -> None:
    wild = name in ("lift_off_braking", "roll_dynamics", "tyre_relaxation", "yaw_inertia", "steer_rate_limit")
    log = record(quiet(**{name: signature(name)}), "rich" if wild else "urban", 3)
    if wild:
        plain = record(quiet(), "rich", 3)
    assert all(np.all(np.isfinite(column)) for column in log.values())
    sigma = {"x": 0.02, "y": 0.02, "yaw": 0.005, "v": 0.03, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}
    assert any(np.max(np.abs(log[c] - plain[c])) > s for c, s in sigma.items())


def test_effects_at_their_neutral_values_change_no_byte(plain: dict[str, FloatArray]) -> None:
    neutral = {name: {key: bound.neutral for key, bound in keys.items()} for name, keys in EFFECTS.items()}
    del neutral["tyre_relaxation"]  # the surrogate's tyres always have a length
    log = record(quiet(**neutral), "urban", 3)
    assert all(np.array_equal(log[c], plain[c]) for c in plain)


def test_a_hidden_delay_is_seen_at_its_length() -> None:
    for delay in (0.1, 0.2004):
        car = DoubleTrack(quiet(SMOOTH, drive_delay={"T": delay}))
        car.step(0.1)
        car.apply(Command(t=0.0, steer=0.0, accel=1.0, throttle=0.0, brake=0.0))
        car.step(1.0)
        late = DoubleTrack(quiet(SMOOTH))
        late.apply(Command(t=0.0, steer=0.0, accel=1.0, throttle=0.0, brake=0.0))
        late.step(round(1.0 - delay, 2))
        assert car.state.v == pytest.approx(late.state.v, abs=1e-3)


def test_a_late_receiver_shows_where_the_car_was() -> None:
    hidden = quiet(SMOOTH, gnss_latency={"T": 0.2}, gnss_lever_arm={"x": 1.0, "y": 0.0})
    car, _ = drive(hidden, 1.0, speed=10.0)
    assert car.measure()["x"] == pytest.approx(10.0 * (1.0 - car.dt - 0.2) + 1.0, abs=1e-3)


def test_pedals_ask_for_what_the_car_says() -> None:
    car = DoubleTrack(quiet(SMOOTH), pedals=True)
    car.apply(Command(t=0.0, steer=0.0, accel=0.0, throttle=0.5, brake=0.0))
    car.step(2.0)
    other, _ = drive(quiet(SMOOTH), 2.0, accel=0.5 * CAR.full_throttle)
    assert car.state.v == other.state.v


def test_same_seed_same_bytes_other_seed_other_noise() -> None:
    one, two = record(Hidden(), "urban", 1), record(Hidden(), "urban", 1)
    assert all(np.array_equal(one[c], two[c]) for c in one)
    assert not np.array_equal(one["ax"], record(Hidden(), "urban", 2)["ax"])


def test_noise_has_its_sigma() -> None:
    step = np.diff(
        record(Hidden(noise="high"), "urban", 1)["yaw_rate"] - record(Hidden(noise="none"), "urban", 1)["yaw_rate"]
    )
    assert np.std(step) / math.sqrt(2.0) == pytest.approx(0.01, rel=0.06)


def test_a_command_line_writes_the_log(tmp_path: Path) -> None:
    hidden = tmp_path / "hidden.toml"
    hidden.write_text('[hidden.steer_delay]\nT = 0.2\n[sensors]\nnoise = "low"\n[car]\ncg_height = 0.6\n')
    out = tmp_path / "log.csv"
    assert main(["--drive", "urban", "--hidden", str(hidden), "--out", str(out)]) == 0
    lines = out.read_text().splitlines()
    assert lines[0].startswith("t [s],accel_cmd [m/s^2],steer_cmd [rad],x [m],y [m],yaw [rad],v [m/s],yaw_rate [rad/s]")
    assert len(lines) == 1 + 45 * 50


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[hidden.steer_dely]\nT = 0.2", "hidden.toml:1: no hidden effect 'steer_dely'; did you mean steer_delay?"),
        ("\n[hidden.steer_delay]\nt = 0.2", "hidden.toml:2: steer_delay has no key 't'"),
        ("[hidden.steer_delay]\nT = 20.0", "steer_delay.T = 20 is out of range, allowed is 0 to 1 s"),
        ("[hidden.steer_delay]\nT = 'x'", "steer_delay.T is 'x'; a number is needed"),
        ("[hidden]\nsteer_delay = 0.2", "steer_delay needs a table of keys"),
        ("[car]\ncg_hight = 0.5", "hidden.toml:2: the car has no 'cg_hight'; did you mean cg_height?"),
        ("[car]\nmass = -1.0", "car.mass is -1; it must be > 0"),
        ("[car]\nmass = inf", "hidden.toml:2: car.mass is inf; a finite number is needed"),
        ("[sensors]\nnoise = 'loud'", "noise is 'loud'; known: none, low, mid, high"),
        ("[sensor]\nnoise = 'low'", "no section 'sensor'; did you mean sensors?"),
        ("hidden = 3", "hidden must be a table"),
        ("[hidden", "not TOML"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(
    text: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "hidden.toml"
    path.write_text(text)
    with pytest.raises(HiddenError) as caught:
        read_hidden(path)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    assert main(["--hidden", str(path), "--out", str(tmp_path / "log.csv")]) == 2
    assert says in capsys.readouterr().err


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(HiddenError, match="cannot be read"):
        read_hidden(tmp_path / "none.toml")


def test_it_shares_nothing_with_the_kernel() -> None:
    """Of ours it imports its own modules, the messages and the wire, which knows no car either, nor does the bridge
    or what reads the TOML of a user.

    So it is of all that it reaches through these.
    """
    folder = Path(DoubleTrack.__module__.replace(".", "/")).parent
    root = Path(__file__).resolve().parents[2]
    shared = ("vehicle.messages", "vehicle.interpreter_bridge", "vehicle.child_process", "vehicle.toml_file")
    ours = [*(root / folder).glob("*.py"), *(root / "vehicle" / "wire").glob("*.py")]
    ours += [root / f"{module.replace('.', '/')}.py" for module in shared]
    for path in sorted(ours) + sorted((root / "tests" / "truth").glob("[!t]*.py")):
        for module in imported(path):
            if module.split(".")[0] in ("vehicle", "pytest_dvp", "ads", "reports", "openscenario"):
                assert module in shared or module.startswith(("vehicle.surrogate", "vehicle.wire")), path


def imported(path: Path) -> list[str]:
    """Modules that a file imports, by `from module import` and by `import module`."""
    nodes = list(ast.walk(ast.parse(path.read_text())))
    found = [node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module]
    return found + [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
