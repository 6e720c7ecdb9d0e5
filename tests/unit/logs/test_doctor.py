"""The doctor: a sound drive has no finding, each defect has its own."""

from __future__ import annotations

import re
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from drives import Columns, drive, jittered, later, log_of, rows, scaled, swapped, two_runs, without

from pytest_dvp.doctor import examine
from pytest_dvp.doctor.smoothing import time_constant
from pytest_dvp.logs.log import Log

DEGREES = 180.0 / np.pi


def told(columns: Columns) -> list[tuple[str, str]]:
    return [(f.code, f.element) for f in examine(log_of(columns))]


@pytest.fixture(scope="module")
def sound() -> Columns:
    return drive()


@pytest.mark.parametrize("seed", range(1, 6))
@pytest.mark.parametrize(("rate", "noise"), [(50.0, 1.0), (100.0, 2.0), (20.0, 0.5)])
@pytest.mark.nightly(by_day=2)
def test_a_sound_drive_has_no_finding(seed: int, rate: float, noise: float) -> None:
    assert told(drive(rate=rate, seed=seed, noise=noise, heading=seed)) == []


def test_a_straight_drive_at_constant_speed_has_no_finding() -> None:
    t = np.arange(400) * 0.02
    assert told({"t": t, "x": 20 * t, "y": 0 * t, "yaw": 0 * t, "v": 20 + 0 * t}) == []


def test_a_steady_circle_of_a_simulated_car_has_no_finding() -> None:
    """Its yaw rate and lateral acceleration never change: no sensor is at the end of its range."""
    t, turn = np.arange(400) * 0.02, 0.2
    circle = {"x": 10.0 / turn * np.sin(turn * t), "y": 10.0 / turn * (1.0 - np.cos(turn * t)), "yaw": turn * t}
    assert told({"t": t, **circle, "v": 10 + 0 * t, "yaw_rate": turn + 0 * t, "ay": 10 * turn + 0 * t}) == []


def test_a_simulated_car_without_noise_that_stands_for_long_has_no_finding() -> None:
    quiet = drive(noise=0.0)
    still = {n: np.concatenate([c, np.repeat(c[1100:1101], 400), c[1100:]]) for n, c in quiet.items()}
    at = 1100
    for name in ("v", "yaw_rate", "ax", "ay", "accel_cmd"):
        still[name][at : at + 400] = 0.0
    still["x"][at:] += 1e-3 * np.sin(np.arange(len(still["x"]) - at))  # it trembles by a millimetre
    assert [f for f in told({**still, "t": np.arange(len(still["x"])) * 0.02}) if f[0] == "log.dead_sensor"] == []


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3])
def test_a_simulated_heading_on_a_long_straight_is_not_dead(noise: float) -> None:
    rng = np.random.default_rng(4)
    t = np.arange(3000) * 0.02
    v = 12.0 + 3.0 * np.sin(0.3 * t)
    way = np.cumsum(v) * 0.02
    x, y = (way * part + noise * rng.normal(size=len(t)) for part in (np.cos(0.4), np.sin(0.4)))
    gyro = 0.03 * rng.normal(size=len(t))
    assert told({"t": t, "x": x, "y": y, "yaw": 0.4 + 0.0 * t, "v": v, "yaw_rate": gyro}) == []
    held = {"t": t, "x": 12.0 * t * 0.9 + noise * rng.normal(size=len(t)), "y": 0.0 * t, "v": 12.0 * 0.9 + 0.0 * t}
    assert told(held) == []  # cruise control


def clipped(columns: Columns, name: str) -> Columns:
    limit = float(np.percentile(np.abs(columns[name]), 93))
    return {**columns, name: np.clip(columns[name], -limit, limit)}


def frozen(columns: Columns, name: str, share: float) -> Columns:
    values = columns[name].copy()
    n = len(values)
    first = 0 if share == 1.0 else n // 2
    values[first : first + int(share * n)] = values[first]
    return {**columns, name: values}


def backwards(columns: Columns) -> Columns:
    t = columns["t"].copy()
    t[len(t) // 2 :] -= 3.0
    return {**columns, "t": t}


DEFECTS: dict[str, tuple[Callable[[Columns], Columns], str, str]] = {
    "yaw in degrees": (lambda c: scaled(c, DEGREES, "yaw"), "log.implausible_range", "column yaw"),
    "yaw rate in degrees": (lambda c: scaled(c, DEGREES, "yaw_rate"), "log.implausible_range", "column yaw_rate"),
    "steer in degrees": (lambda c: scaled(c, DEGREES, "steer"), "log.implausible_range", "column steer"),
    "steer_cmd in degrees": (lambda c: scaled(c, DEGREES, "steer_cmd"), "log.implausible_range", "column steer_cmd"),
    "hand wheel for road wheel": (lambda c: scaled(c, 16.0, "steer"), "log.implausible_range", "column steer"),
    "km/h as m/s": (lambda c: scaled(c, 3.6, "v"), "log.unit_suspect", "column v"),
    "mph as m/s": (lambda c: scaled(c, 2.23694, "v"), "log.unit_suspect", "column v"),
    "ay in g": (lambda c: scaled(c, 1 / 9.80665, "ay"), "log.unit_suspect", "column ay"),
    "steer turned round": (lambda c: scaled(c, -1.0, "steer"), "log.sign_flipped", "column steer"),
    "steer_cmd turned round": (lambda c: scaled(c, -1.0, "steer_cmd"), "log.sign_flipped", "column steer_cmd"),
    "yaw rate turned round": (lambda c: scaled(c, -1.0, "yaw_rate"), "log.sign_flipped", "column yaw_rate"),
    "yaw turned round": (lambda c: scaled(c, -1.0, "yaw"), "log.sign_flipped", "column yaw"),
    "ay turned round": (lambda c: scaled(c, -1.0, "ay"), "log.sign_flipped", "column ay"),
    "ax turned round": (lambda c: scaled(c, -1.0, "ax"), "log.sign_flipped", "column ax"),
    "y turned round": (lambda c: scaled(c, -1.0, "y"), "log.sign_flipped", "column y"),
    "x and y swapped": (lambda c: swapped(c, "x", "y"), "log.axes_swapped", "column x"),
    "ax and ay swapped": (lambda c: swapped(c, "ax", "ay"), "log.axes_swapped", "column ax"),
    "5 % jitter": (lambda c: jittered(c, 0.05), "log.jitter", "column t"),
    "a gap": (lambda c: rows(c, np.r_[0:1000, 1050:3000]), "log.gap", "column t"),
    "reversed stamps": (backwards, "log.time_not_monotonic", "column t"),
    "milliseconds as seconds": (lambda c: scaled(c, 1000.0, "t"), "log.implausible_rate", "column t"),
    "two runs in one": (
        lambda c: two_runs(rows(c, np.arange(2000)), rows(c, np.arange(500, 3000))), "log.concatenated", "column x",
    ),
    "a saturated gyro": (lambda c: clipped(c, "yaw_rate"), "log.saturated", "column yaw_rate"),
    "a saturated accelerometer": (lambda c: clipped(c, "ay"), "log.saturated", "column ay"),
    "a dead gyro": (lambda c: frozen(c, "yaw_rate", 1.0), "log.dead_sensor", "column yaw_rate"),
    "a dead speed sensor": (lambda c: frozen(c, "v", 1.0), "log.dead_sensor", "column v"),
    "a frozen speed": (lambda c: frozen(c, "v", 0.15), "log.dead_sensor", "column v"),
    "a frozen yaw": (lambda c: frozen(c, "yaw", 0.15), "log.dead_sensor", "column yaw"),
    "a dead steering sensor": (lambda c: frozen(c, "steer", 1.0), "log.dead_sensor", "column steer"),
    "a steering report that is the command": (
        lambda c: {**c, "steer": c["steer_cmd"]}, "log.steer_is_command", "column steer",
    ),
    "the command two rows later": (
        lambda c: {**c, "steer": np.concatenate([c["steer_cmd"][:2], c["steer_cmd"][:-2]])},
        "log.steer_is_command", "column steer",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("stage", "findings"), [("dt", 0), ("rw", 1), ("rw-surrogate", 1)])
def test_a_twin_that_obeys_is_no_defect_and_a_car_that_seems_to_is_one(
    sound: Columns, stage: str, findings: int
) -> None:
    log = Log({**sound, "steer": sound["steer_cmd"]}, meta={"stage": stage})
    assert [finding.code for finding in examine(log)] == ["log.steer_is_command"] * findings


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_defect_is_found_where_it_is_and_the_finding_says_what_to_do(sound: Columns, defect: str) -> None:
    spoil, code, element = DEFECTS[defect]
    found = examine(log_of(spoil(sound)))
    assert (code, element) in [(finding.code, finding.element) for finding in found]
    for finding in found:
        assert finding.hint or finding.allowed, finding


@pytest.mark.parametrize("lacking", [(), ("x", "y"), ("steer",), ("ay", "x", "y"), ("x", "y", "yaw")])
@pytest.mark.parametrize("factor", [DEGREES, 1.0 / DEGREES])
@pytest.mark.parametrize("column", ["yaw", "yaw_rate", "steer", "steer_cmd"])
def test_a_wrong_unit_of_an_angle_is_told_of_its_own_column_only(
    sound: Columns, column: str, factor: float, lacking: tuple[str, ...]
) -> None:
    if column in lacking:
        return
    (finding,) = examine(log_of(without(scaled(sound, factor, column), *lacking)))
    assert (finding.code, finding.element) == ("log.implausible_range", f"column {column}")
    per_second = "/s" if column == "yaw_rate" else ""
    if factor > 1.0:
        assert finding.text.startswith("degrees stored as radians")
        assert f"{column} [deg{per_second}]" in finding.hint
    else:
        assert finding.text == "radians stored as degrees"
        assert f"{column} [rad{per_second}]" in finding.hint


def test_what_the_data_cannot_decide_is_told_as_such(sound: Columns) -> None:
    few = {name: sound[name] for name in ("t", "v", "yaw", "yaw_rate")}
    (finding,) = examine(log_of(scaled(few, 1.0 / DEGREES, "yaw_rate")))
    assert finding.element == "column yaw_rate"
    assert finding.message.startswith("radians stored as degrees; or yaw holds degrees stored as radians")


def test_the_hand_wheel_is_told_with_its_ratio_before_degrees(sound: Columns) -> None:
    (finding,) = examine(log_of(scaled(sound, 15.0, "steer_cmd")))
    assert finding.element == "column steer_cmd"
    assert finding.hint.startswith("give the steering ratio in a mapping: `ratio = 15`")


def test_a_steering_ratio_that_a_model_may_have_is_no_finding(sound: Columns) -> None:
    for ratio in (0.7, 1.3):
        assert told(scaled(sound, ratio, "steer_cmd")) == []


@pytest.mark.parametrize(
    ("factor", "said", "hint"),
    [
        (1 / 9.80665, "g stored as m/s^2", "`accel_cmd [g]`"),
        (9.80665, "m/s^2 stored as g", "`accel_cmd [m/s^2]`"),
        (100.0 / 3.0, "percent stored as m/s^2", "throttle_cmd"),  # a full pedal of 3 m/s^2
        (1.0 / 6.0, "a pedal from -1 to 1, or g, stored as m/s^2", "throttle_cmd"),
    ],
)
def test_a_wanted_acceleration_in_another_unit_is_told(sound: Columns, factor: float, said: str, hint: str) -> None:
    (finding,) = examine(log_of(scaled(sound, factor, "accel_cmd")))
    assert (finding.code, finding.element, finding.text) == ("log.unit_suspect", "column accel_cmd", said)
    assert hint in finding.hint


def test_a_drive_of_another_gain_is_no_finding(sound: Columns) -> None:
    for gain in (0.6, 1.4):
        assert told(scaled(sound, gain, "accel_cmd")) == []


def test_the_sign_of_a_wanted_acceleration_needs_no_turn(sound: Columns) -> None:
    along = {name: sound[name] for name in ("t", "v", "accel_cmd")}
    assert told(scaled(along, -1.0, "accel_cmd")) == [("log.sign_flipped", "column accel_cmd")]


@pytest.mark.parametrize("factor", [3.6, 1 / 3.6])
def test_a_wanted_speed_in_another_unit_is_told(sound: Columns, factor: float) -> None:
    wish = {**sound, "speed_cmd": np.roll(sound["v"], -25) + 0.3}
    assert told(wish) == []
    assert told(scaled(wish, factor, "speed_cmd")) == [("log.unit_suspect", "column speed_cmd")]


def test_a_speed_without_positions_is_judged_by_the_accelerometers(sound: Columns) -> None:
    assert told(without(scaled(sound, 3.6, "v"), "x", "y")) == [("log.unit_suspect", "column v")]


def test_one_wrong_column_hides_no_other(sound: Columns) -> None:
    assert told(scaled(scaled(scaled(sound, DEGREES, "yaw"), 3.6, "v"), -1.0, "ay")) == [
        ("log.unit_suspect", "column v"), ("log.implausible_range", "column yaw"), ("log.sign_flipped", "column ay"),
    ]  # fmt: skip


@pytest.mark.parametrize("seconds", [0.2, -0.2])
@pytest.mark.parametrize("channels", [("yaw_rate",), ("v",), ("x", "y"), ("yaw",), ("x", "y", "yaw"), ("ax",), ("ay",)])
def test_a_clock_that_is_off_is_told_with_its_channel_and_its_offset(
    sound: Columns, channels: tuple[str, ...], seconds: float
) -> None:
    findings = examine(log_of(later(sound, channels, seconds)))
    assert [(f.code, f.element) for f in findings] == [("log.clock_offset", f"column {', '.join(channels)}")]
    assert f"0.20 s {'later' if seconds > 0 else 'earlier'}" in findings[0].text
    assert f"`delay = {seconds:.2f}`" in findings[0].hint
    cause = {"v": "driven wheels, which slip", "ay": "ahead of the rear axle"}.get(
        channels[0], "the other channels are late"
    )
    assert ("latency" if seconds > 0 else cause) in findings[0].hint  # no sensor shows what comes


@pytest.mark.parametrize(("channel", "tau"), [("yaw_rate", 1.5), ("ay", 2.5)])
def test_a_smoothed_channel_is_not_told_to_be_late(sound: Columns, channel: str, tau: float) -> None:
    """An acceleration that its logger had smoothed over 2.5 s was called 1.55 s late: such stamps would be wrong."""
    keep = np.exp(-np.diff(sound["t"], prepend=sound["t"][0] - 0.02) / tau)
    smooth = np.zeros_like(sound[channel])
    for k in range(1, len(smooth)):
        smooth[k] = keep[k] * smooth[k - 1] + (1.0 - keep[k]) * sound[channel][k]
    (finding,) = examine(log_of({**sound, channel: smooth}))
    assert (finding.code, finding.element) == ("log.clock_offset", f"column {channel}")
    said = re.search(r"is smoothed: a low-pass of ([0-9.]+) s", finding.text)
    assert said is not None
    assert float(said[1]) == pytest.approx(tau, rel=0.35)  # neighbours of what is tried are a quarter apart
    assert "delay =" not in finding.hint


def test_steps_that_come_late_are_told_from_steps_that_are_smoothed() -> None:
    t = 0.02 * np.arange(3000)
    steps = np.repeat(np.random.default_rng(4).normal(size=60), 50)
    motion: Any = SimpleNamespace(t=t, step=0.02)
    smooth = np.array([np.sum(steps[max(k - 400, 0) : k + 1] * np.exp(-0.02 * np.arange(min(k, 400), -1, -1) / 0.8))
                       for k in range(3000)])  # fmt: skip
    assert time_constant(motion, smooth, steps, 0.4) == pytest.approx(0.8, rel=0.15)
    assert time_constant(motion, np.roll(steps, 20), steps, 0.4) is None
    assert time_constant(motion, smooth, steps, 0.0) is None
    assert time_constant(motion, smooth, np.full(3000, np.nan), 0.4) is None


def test_a_wrong_sign_does_not_hide_a_wrong_clock(sound: Columns) -> None:
    spoilt = scaled(later(sound, ("yaw_rate",), 0.2), -1.0, "yaw_rate")
    assert told(spoilt) == [("log.sign_flipped", "column yaw_rate"), ("log.clock_offset", "column yaw_rate")]


def test_a_late_steering_is_no_finding() -> None:
    assert told(drive(steer_delay=0.3)) == []


def test_commands_with_a_clock_of_their_own_are_told(sound: Columns) -> None:
    measured = tuple(name for name in sound if name not in ("t", "steer_cmd", "accel_cmd"))
    quick = {**sound, "steer_cmd": sound["steer"], "accel_cmd": sound["ax"]}  # without the actuators' own lags
    noisy = {n: c + 1e-3 * np.sin(7.0 * sound["t"]) if n.endswith("_cmd") else c for n, c in quick.items()}
    assert ("log.clock_offset", "column steer_cmd, accel_cmd") in told(later(noisy, measured, 0.2))


def test_missing_values_are_told_with_their_share_and_the_longest_hole(sound: Columns) -> None:
    v = sound["v"].copy()
    v[500:650] = np.nan  # 3 s
    v[np.random.default_rng(2).choice(3000, 90, replace=False)] = np.nan
    (finding,) = examine(log_of({**sound, "v": v}))
    assert (finding.code, finding.element, finding.severity) == ("log.missing_values", "column v", "warning")
    share = float(finding.text.split(" %")[0])
    assert share == pytest.approx(100.0 * np.isnan(v).mean(), abs=0.3)
    assert "longest from t = 9.98 to 13 s" in finding.text


def test_a_slower_channel_misses_nothing_and_a_silent_one_does(sound: Columns) -> None:
    slow = {n: np.where(np.arange(3000) % 5 == 0, sound[n], np.nan) for n in ("x", "y")}
    assert told({**sound, **slow}) == []
    for name in slow:
        slow[name][1000:1200] = np.nan
    assert told({**sound, **slow}) == [("log.missing_values", "column x, y")]
    assert told({**sound, "speed_cmd": np.full(3000, np.nan)}) == [("log.empty_column", "column speed_cmd")]


@pytest.mark.parametrize(
    ("lost", "severity"), [(np.r_[0:1000, 1500:3000], "warning"), (np.r_[0:500, 2400:3000], "error")]
)
def test_a_gap_in_time_is_told_with_its_length(sound: Columns, lost: np.ndarray, severity: str) -> None:
    findings = [f for f in examine(log_of(rows(sound, lost))) if f.code == "log.gap"]
    assert [f.severity for f in findings] == [severity]
    assert findings[0].text.startswith(f"a gap of {10.02 if severity == 'warning' else 38.02:.3g} s at t =")


def test_a_jump_of_the_position_alone_is_told_as_such(sound: Columns) -> None:
    x = sound["x"] + np.where(sound["t"] > 20.0, 1.5, 0.0)
    assert told({**sound, "x": x}) == [("log.position_jump", "column x")]


def test_repeated_stamps_are_told_and_the_rest_is_examined(sound: Columns) -> None:
    t = sound["t"].copy()
    t[[100, 500, 900]] = t[[99, 499, 899]]
    assert told({**scaled(sound, 3.6, "v"), "t": t}) == [
        ("log.duplicate_stamps", "column t"), ("log.unit_suspect", "column v"),
    ]  # fmt: skip


@pytest.mark.parametrize("lacking", [(), ("ay",), ("yaw_rate", "ay", "steer")])
def test_a_compass_heading_is_told_with_the_key_of_the_mapping(sound: Columns, lacking: tuple[str, ...]) -> None:
    (finding,) = examine(log_of(without({**sound, "yaw": np.pi / 2 - sound["yaw"]}, *lacking)))
    assert (finding.code, finding.element) == ("log.sign_flipped", "column yaw")
    assert finding.hint == 'frame = "ned" for yaw in a mapping'


def test_a_clockwise_yaw_from_elsewhere_is_told_with_its_offset(sound: Columns) -> None:
    (finding,) = examine(log_of({**sound, "yaw": 2.5 - sound["yaw"]}))
    stated = finding.found.split()[-2]
    assert float(stated) == pytest.approx(2.5, abs=0.02)
    assert finding.hint == f"sign = -1, offset = {stated} for yaw in a mapping"


def test_a_map_with_z_downwards_is_told_as_one(sound: Columns) -> None:
    ned = {**swapped(sound, "x", "y"), "yaw": np.pi / 2 - sound["yaw"]}
    (finding,) = examine(log_of(ned))
    assert (finding.code, finding.element) == ("log.axes_swapped", "column x")
    assert 'of the map exchange x and y, and frame = "ned" for yaw' in finding.hint


def test_a_car_whose_sensors_count_to_the_right_looks_the_same_and_is_named_beside_it(sound: Columns) -> None:
    frd = {
        name: -values if name in ("yaw_rate", "ay", "steer", "steer_cmd") else values for name, values in sound.items()
    }
    (finding,) = examine(log_of(frd))
    assert finding.hint.endswith('of the car frame = "frd" for yaw_rate, ay, steer, steer_cmd')


def test_a_receiver_ahead_of_the_axle_is_no_clock_offset(sound: Columns) -> None:
    ahead = {
        **sound, "x": sound["x"] + 1.5 * np.cos(sound["yaw"]), "y": sound["y"] + 1.5 * np.sin(sound["yaw"]),
    }  # fmt: skip
    assert told(ahead) == []


def test_a_wanted_speed_that_is_not_reached_may_be_a_limit_and_no_unit(sound: Columns) -> None:
    """The car follows slow wishes, and stays far behind fast ones: nothing tells of km/h."""
    v = sound["v"]
    wish = np.where(v < np.percentile(v[v > 0.5], 30), 1.05 * v + 0.6, 3.6 * v)
    (finding,) = examine(log_of({**sound, "speed_cmd": wish}))
    assert (finding.code, finding.severity) == ("log.speed_not_reached", "warning")
    assert "km/h" in finding.hint
    assert "speed_limit" in finding.hint


def test_a_clock_that_is_late_for_a_while_is_told_with_the_time(sound: Columns) -> None:
    """Four minutes, in one of which the yaw rate comes 0.3 s late: over the whole log nothing shows."""
    n, count = len(sound["t"]), 6
    long = {
        name: np.tile(values, count) for name, values in sound.items() if name in ("v", "yaw", "yaw_rate", "ax", "ay")
    }
    long["yaw"] = np.concatenate([sound["yaw"] + k * 0.0 for k in range(count)])
    t = np.arange(n * count) * float(np.median(np.diff(sound["t"])))
    late = slice(2 * n, 4 * n)
    assert told({"t": t, **long}) == []
    long["yaw_rate"] = long["yaw_rate"].copy()
    long["yaw_rate"][late] = np.roll(long["yaw_rate"], round(0.3 / (t[1] - t[0])))[late]
    findings = [f for f in examine(log_of({"t": t, **long})) if f.code == "log.clock_offset"]
    assert findings
    (when,) = {tuple(map(float, re.findall(r"t = (\d+) to (\d+) s only", f.text)[0])) for f in findings}
    assert when[0] == pytest.approx(t[2 * n], abs=30.0)
    assert when[1] == pytest.approx(t[4 * n], abs=30.0)


@pytest.mark.parametrize("columns", [("x", "y", "yaw"), ("x", "y", "yaw", "yaw_rate", "ax", "ay", "steer")])
def test_a_speed_with_the_wrong_sign_is_the_only_finding(columns: tuple[str, ...]) -> None:
    """All that is judged by the speed would seem turned round with it."""
    car = drive()
    assert told({"t": car["t"], "v": -car["v"], **{name: car[name] for name in columns}}) == [
        ("log.sign_flipped", "column v")
    ]


def test_a_clock_is_judged_by_the_speed_with_its_right_sign() -> None:
    car = drive()
    late = np.interp(car["t"] - 0.4, car["t"], car["ax"])
    columns = {name: car[name] for name in ("t", "x", "y", "yaw")}
    assert told({**columns, "v": -car["v"], "ax": late}) == [
        ("log.sign_flipped", "column v"), ("log.clock_offset", "column ax")
    ]  # fmt: skip


def test_a_car_that_drives_astern_has_no_wrong_sign() -> None:
    """The same drive backwards: it points where it came from, and turns as before."""
    car = drive()
    astern = {"t": car["t"], "x": car["x"], "y": car["y"], "yaw": car["yaw"] + np.pi, "v": -car["v"]}
    assert told({**astern, "yaw_rate": car["yaw_rate"], "ax": -car["ax"], "ay": -car["ay"]}) == []
