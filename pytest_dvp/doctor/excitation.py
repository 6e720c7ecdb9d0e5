"""Which effects a log could ever reveal: by the signals it holds and by how the car was driven.

A necessary condition, not a promise: an effect "within reach" may still drown in noise or hide behind another one. One
that is out of reach cannot be found in this log by anybody.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from pytest_dvp.doctor.redundant_motion import Motion, motion_of
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray


@dataclasses.dataclass(frozen=True)
class Fact:
    """How far a quantity was driven."""

    name: str
    value: float
    unit: str


@dataclasses.dataclass(frozen=True)
class Excitation:
    """facts: what was driven. within_reach: effects that could show. hardly: those that could only if they are large,
    with what a usual one would need. out_of_reach: the others, with what is lacking."""

    facts: tuple[Fact, ...]
    within_reach: tuple[str, ...]
    hardly: Mapping[str, str]
    out_of_reach: Mapping[str, str]

    def as_dict(self) -> dict[str, Any]:
        """JSON-able."""
        return {
            "facts": {fact.name: {"value": round(fact.value, 4), "unit": fact.unit} for fact in self.facts},
            "within_reach": list(self.within_reach),
            "hardly": dict(self.hardly),
            "out_of_reach": dict(self.out_of_reach),
        }


@dataclasses.dataclass(frozen=True)
class _Rule:
    """Effects; columns that they need, each group by one of its names; and least drives (fact, at least, said as).

    drives  without these nobody sees the effect, were it at the strong end of its usual range
    usual   without these only a strong one shows: for one in the (geometric) middle of that range
    """

    effects: tuple[str, ...]
    columns: tuple[tuple[str, ...], ...]
    drives: tuple[tuple[str, float, str], ...] = ()
    usual: tuple[tuple[str, float, str], ...] = ()


_DRIVE = ("accel_cmd", "throttle_cmd", "motor_current")
_BRAKE = ("accel_cmd", "brake_cmd", "brake_pressure", "motor_current")
_STEER = ("steer_cmd", "steer_cmd_norm", "steer")
_COMMAND = ("steer_cmd", "steer_cmd_norm")
_SPEED = ("v", "vx", "x")
_TURN = ("yaw_rate", "yaw", "ay")

_ACCELERATES = ("acceleration", 0.5, "accelerating by 0.5 m/s^2")
_BRAKES = ("braking", 0.5, "braking by 0.5 m/s^2")
_TURNS = ("turn_rate", 0.05, "turning by 0.05 rad/s")
_MOVES_WHEEL = ("steer_rate", 0.02, "steering by 0.02 rad/s")
_CURVES = ("lateral_acceleration", 1.0, "curves of 1 m/s^2")

_RULES = (
    _Rule(
        ("drive_delay", "drive_lag", "force_rise", "jerk_limit", "accel_controller"),
        (_DRIVE, _SPEED),
        (_ACCELERATES, ("command_rate", 0.5, "a command that changes by 0.5 m/s^3")),
    ),
    _Rule(("drive_gain", "mass"), (_DRIVE, _SPEED), (_ACCELERATES,)),
    _Rule(("motor_torque", "motor_inertia", "motor_damping"), (_DRIVE, _SPEED), (_ACCELERATES,)),
    _Rule(("brake_lag",), (_BRAKE, _SPEED), (_BRAKES, ("command_rate", 0.5, "a command that changes by 0.5 m/s^3"))),
    _Rule(("brake_gain",), (_BRAKE, _SPEED), (_BRAKES,)),
    _Rule(
        ("brake_limit",),
        (_BRAKE, _SPEED),
        (("braking_wanted", 1.0, "braking by 1 m/s^2"),),
        (("braking_wanted", 3.0, "braking by 3 m/s^2"),),
    ),
    _Rule(
        ("power_limit",),
        (_DRIVE, _SPEED),
        (("power_wanted", 3.0, "acceleration * speed of 3 W/kg"),),
        (("power_wanted", 11.0, "acceleration * speed of 11 W/kg"),),
    ),
    _Rule(("pedal_deadband",), (_DRIVE, _SPEED), (("small_commands", 1.0, "1 s of small commands while moving"),)),
    _Rule(("lift_off_braking",), (_DRIVE, _SPEED), (("coasting", 2.0, "2 s of coasting (command about zero)"),)),
    _Rule(
        ("rolling_resistance", "viscous_resistance"),
        (_DRIVE, _SPEED),
        (("moving_time", 10.0, "10 s of driving"), ("speed_range", 3.0, "speeds 3 m/s apart")),
    ),
    # 0.002 / m makes 0.2 m/s^2 at 10 m/s, and 0.02 / m half a m/s^2 at 5.
    _Rule(
        ("aero_drag",),
        (_DRIVE, _SPEED),
        (("speed", 5.0, "5 m/s"), ("speed_range", 3.0, "speeds 3 m/s apart")),
        (("speed", 10.0, "10 m/s"),),
    ),
    _Rule(
        ("headwind",),
        (_DRIVE, _SPEED),
        (("speed", 5.0, "5 m/s"), ("headings", 1.5, "headings 1.5 rad apart")),
        (("speed", 10.0, "10 m/s"),),
    ),
    _Rule(("cornering_drag",), (_DRIVE, _SPEED, _TURN), (_CURVES,)),
    _Rule(
        ("road_grade",),
        (_SPEED, ("ax", *_DRIVE)),
        (("moving_time", 10.0, "10 s of driving"), ("headings", 1.5, "headings 1.5 rad apart")),
    ),
    _Rule(
        ("road_bank",),
        (_TURN, ("ay",)),
        (("moving_time", 10.0, "10 s of driving"), ("headings", 1.5, "headings 1.5 rad apart")),
    ),
    _Rule(
        ("steer_delay", "steer_lag"),
        (_COMMAND, _TURN),
        (_MOVES_WHEEL, _TURNS),
        (("steer_rate", 0.04, "steering by 0.04 rad/s"),),  # 0.2 s of it turn a car at 5 m/s by 0.015 rad/s
    ),
    _Rule(
        ("steer_rate_limit",),
        (_COMMAND, _TURN),
        (("steer_rate", 0.05, "steering by 0.05 rad/s"), _TURNS),
        (("steer_rate", 0.2, "steering by 0.2 rad/s"),),
    ),
    _Rule(
        ("steer_angle_limit",),
        (_COMMAND, _TURN),
        (("steer_angle", 0.08, "0.08 rad at the road wheel"), _TURNS),
        (("steer_angle", 0.2, "0.2 rad at the road wheel"),),
    ),
    _Rule(
        ("steer_stiction", "steer_backlash"),
        (_COMMAND, _TURN),
        (("steer_reversals", 6.0, "6 reversals of the steering"), _TURNS),
    ),
    _Rule(("steer_ratio",), (_STEER, _TURN), (_TURNS,)),
    _Rule(
        ("steer_asymmetry",),
        (_STEER, _TURN),
        (("turn_left", 0.05, "left curves of 0.05 rad/s"), ("turn_right", 0.05, "right curves of 0.05 rad/s")),
    ),
    _Rule(("steer_offset",), (_STEER, _TURN), (("moving_time", 5.0, "5 s of driving"),)),
    _Rule(("understeer",), (_STEER, _TURN), (_CURVES, ("turning_speed_range", 2.0, "curves at speeds 2 m/s apart"))),
    _Rule(
        ("tyre_saturation",),
        (_STEER, _TURN),
        (("lateral_acceleration", 2.0, "curves of 2 m/s^2"),),
        (("lateral_acceleration", 5.0, "curves of 5 m/s^2"),),
    ),
    _Rule(
        ("load_transfer", "steer_compliance"), (_STEER, _TURN), (("lateral_acceleration", 2.0, "curves of 2 m/s^2"),)
    ),
    _Rule(
        ("tyre_relaxation", "yaw_inertia", "cornering_compliance", "roll_dynamics"),
        (_STEER, _TURN),
        (("lateral_acceleration", 1.0, "curves of 1 m/s^2"), ("steer_rate", 0.1, "steering by 0.1 rad/s")),
    ),
    _Rule(("wheel_radius",), (("v",), ("x",)), (("moving_time", 5.0, "5 s of driving"),)),
    _Rule(("gyro_bias",), (("yaw_rate",), ("yaw", "x"))),
    _Rule(("yaw_rate_latency",), (("yaw_rate",), ("yaw", "x", "steer")), (_TURNS,)),
    _Rule(("accelerometer_bias",), (("ax",), _SPEED)),
    _Rule(("imu_misalignment",), (("ax",), ("ay",)), (("acceleration", 1.0, "accelerating by 1 m/s^2"), _CURVES)),
    _Rule(("pitch", "body_pitch"), (("ax",), _SPEED), (("acceleration", 1.0, "accelerating by 1 m/s^2"),)),
    _Rule(("roll", "body_roll"), (("ay",), ("yaw_rate", "yaw")), (_CURVES,)),
    _Rule(("heading_bias",), (("yaw",), ("x",)), (("moving_time", 5.0, "5 s of driving"),)),
    _Rule(
        ("gnss_latency",),
        (("x",), _SPEED),
        (("moving_time", 5.0, "5 s of driving"), ("speed_range", 2.0, "speeds 2 m/s apart")),
    ),
    _Rule(("gnss_lever_arm",), (("x",), ("yaw",)), (_TURNS,)),
    _Rule(("speed_controller",), (("speed_cmd",), _SPEED), (("speed_range", 1.0, "speeds 1 m/s apart"),)),
)
_PERCEPTION = (
    "detection_latency",
    "detection_offset",
    "detection_range",
    "detection_misses",
    "detection_false",
    "detection_noise",
)


# Effects of a user's own, by the slot they act in: that is all that is known of them.
_BY_SLOT: Mapping[str, _Rule] = {
    **dict.fromkeys(
        ("command", "actuator"),
        _Rule((), ((*_COMMAND, *_DRIVE, *_BRAKE), (*_SPEED, *_TURN)), (("moving_time", 5.0, "5 s of driving"),)),
    ),
    **dict.fromkeys(
        ("force", "body", "road"), _Rule((), ((*_SPEED, *_TURN),), (("moving_time", 5.0, "5 s of driving"),))
    ),
    "sensor": _Rule((), ((*_SPEED, *_TURN, "ax"),)),
}


def excitation(log: Log, model: Any = None, own: Mapping[str, Any] | None = None) -> Excitation:
    """What the log could reveal; with a model, of its inputs only (longitudinal = "v": no effect of the drive).

    own  effects of the user's own by name: judged by their slot alone

    Bounds: the least meaningful sizes of the catalogue against usual sensor noise; they are deliberately low.
    """
    motion = motion_of(log)
    facts = _facts(log, motion)
    value = {fact.name: fact.value for fact in facts}
    held = {
        name
        for name, values in log.columns.items()
        if np.isfinite(values).any() and np.nanmax(values) > np.nanmin(values)
    }
    inputs = getattr(model, "inputs", None)
    if inputs is not None:
        longitudinal = set(inputs.longitudinal)
        held -= ({*_DRIVE, *_BRAKE, "speed_cmd"} - longitudinal) | ({*_STEER} - {inputs.steer})
        held |= {"steer_cmd"} if inputs.steer in held and inputs.steer not in _STEER else set()
    within: list[str] = []
    hardly: dict[str, str] = {}
    out: dict[str, str] = {}
    mine = [
        dataclasses.replace(_BY_SLOT[effect.slot], effects=(name,))
        for name, effect in (own or {}).items()
        if effect.slot in _BY_SLOT
    ]
    perceived = (*_PERCEPTION, *(name for name, effect in (own or {}).items() if effect.slot == "perception"))
    for rule in (*_RULES, *mine):
        lacking = _lacking(rule, held, value)
        if lacking:
            out.update((effect, lacking) for effect in rule.effects)
        elif missed := _missed(rule.usual, value):
            hardly.update((effect, missed) for effect in rule.effects)
        else:
            within.extend(rule.effects)
    if log.detections.t.size and log.objects:
        within.extend(perceived)
    else:
        out.update((effect, "needs objects, true and detected") for effect in perceived)
    return Excitation(facts, tuple(within), hardly, out)


def _lacking(rule: _Rule, held: set[str], value: Mapping[str, float]) -> str:
    for group in rule.columns:
        if not held & set(group):
            return "needs a column " + " or ".join(group[:3])
    return _missed(rule.drives, value)


def _missed(drives: tuple[tuple[str, float, str], ...], value: Mapping[str, float]) -> str:
    missed = [text for name, least, text in drives if value.get(name, 0.0) < least]
    return "needs " + ", ".join(missed) if missed else ""


def _facts(log: Log, motion: Motion | None) -> tuple[Fact, ...]:
    facts = [Fact("duration", log.duration, "s")]
    if motion is None:
        return tuple(facts)
    of, step = motion.of, motion.step
    speed = of.get("v", of.get("path_speed"))
    if speed is None:
        return tuple(facts)
    speed = np.abs(speed)
    still = np.abs(speed) < 0.05 * max(float(np.percentile(speed, 95)), 0.1)
    turn = next((of[name] for name in ("yaw_rate", "turn", "path_turn") if name in of), np.zeros(len(speed)))
    along = of.get("accel", np.gradient(speed, step))
    wanted = of.get("accel_cmd", along)
    driving = speed[~still] if (~still).any() else speed

    def high(values: np.ndarray[Any, np.dtype[np.float64]]) -> float:
        return max(float(np.nanpercentile(values, 98)), 0.0) if len(values) else 0.0

    lateral = np.abs(speed * turn)
    bent = speed[lateral > 0.5]
    facts += [
        Fact("moving_time", float(np.count_nonzero(~still)) * step, "s"),
        Fact("speed", high(speed), "m/s"),
        Fact("speed_range", float(np.percentile(driving, 95) - np.percentile(driving, 5)), "m/s"),
        Fact("acceleration", high(along), "m/s^2"),
        Fact("braking", high(-along), "m/s^2"),
        Fact("power", high(along * speed), "W/kg"),
        # A limit cuts what is done, never what is asked for.
        Fact("braking_wanted", high(-wanted), "m/s^2"),
        Fact("power_wanted", high(wanted * speed), "W/kg"),
        Fact("turn_rate", high(np.abs(turn)), "rad/s"),
        Fact("turn_left", high(turn), "rad/s"),
        Fact("turn_right", high(-turn), "rad/s"),
        Fact("lateral_acceleration", high(lateral), "m/s^2"),
        Fact(
            "turning_speed_range",
            float(np.percentile(bent, 95) - np.percentile(bent, 5)) if len(bent) > 20 else 0.0,
            "m/s",
        ),
        Fact("headings", _spread(motion), "rad"),
    ]
    return (*facts, *_command_facts(log, motion, still))


def _spread(motion: Motion) -> float:
    """Widest angle between two headings, at most pi [rad]."""
    angle = motion.heading if np.isfinite(motion.heading).any() else motion.course
    seen = angle[motion.moving & np.isfinite(angle)]
    if len(seen) < 20:
        return 0.0
    low, high = np.percentile(np.unwrap(seen), [2, 98])
    return float(min(high - low, np.pi))


def _command_facts(log: Log, motion: Motion, still: np.ndarray[Any, np.dtype[np.bool_]]) -> list[Fact]:
    facts: list[Fact] = []
    step = motion.step
    for name in ("steer_cmd", "steer_cmd_norm", "steer"):
        values = log.columns.get(name)
        if values is None or not np.isfinite(values).any():
            continue
        known = np.isfinite(values)
        # A command that follows a noisy estimate trembles; what the car could answer is its mean over a window.
        angle = motion.of[name] if name in motion.of else np.interp(motion.t, log.t[known], values[known])
        rate = np.gradient(angle, step)
        quiet = 0.05 * float(np.percentile(np.abs(rate), 98))
        sign = np.sign(rate[np.abs(rate) > quiet])
        facts += [
            Fact("steer_angle", float(np.percentile(np.abs(angle), 98)), "rad"),
            Fact("steer_rate", float(np.percentile(np.abs(rate), 98)), "rad/s"),
            Fact("steer_reversals", float(np.count_nonzero(np.diff(sign))), "-"),
        ]
        break
    for name, small in (("accel_cmd", 0.5), ("throttle_cmd", 0.1), ("motor_current", 10.0)):
        values = log.columns.get(name)
        if values is None or not np.isfinite(values).any():
            continue
        known = np.isfinite(values)
        command = np.interp(motion.t, log.t[known], values[known])
        low = np.abs(command) < small
        zero = np.abs(command) < 0.1 * small
        rate = np.abs(np.gradient(_smooth(command, round(0.4 / step)), step)) * 0.5 / small
        facts += [
            Fact("small_commands", float(np.count_nonzero(low & ~zero & ~still)) * step, "s"),
            Fact("coasting", float(np.count_nonzero(zero & ~still)) * step, "s"),
            Fact("command_rate", float(np.percentile(rate, 98)), "m/s^3"),
        ]
        break
    return facts


def _smooth(values: FloatArray, count: int) -> FloatArray:
    return np.convolve(values, np.full(max(count, 1), 1.0 / max(count, 1)), "same")
