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
from vehicle.model.effect import Effect
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.shown_by import BRAKE, DRIVE, STEER, Drive, ShownBy

IMPOSED = ("v", "vx", "ax")  # what says nothing of a model that takes the speed from the log


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


def excitation(log: Log, model: Any = None, own: Mapping[str, Effect] | None = None) -> Excitation:
    """What the log could reveal; with a model, of its inputs only (longitudinal = "v": no effect of the drive).

    own  effects of the user's own by name

    What each effect needs stands in its own file, as `shown_by`.
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
    idle: set[str] = set()
    if inputs is not None:
        longitudinal = set(inputs.longitudinal)
        idle = held & (({*DRIVE, *BRAKE} - longitudinal) | ({*STEER} - {inputs.steer}))
        held -= idle
        held |= {"steer_cmd"} if inputs.steer in held and inputs.steer not in STEER else set()
    imposed = set(IMPOSED) & held if inputs is not None and "v" in inputs.longitudinal else set()
    held -= imposed
    within: list[str] = []
    hardly: dict[str, str] = {}
    out: dict[str, str] = {}
    seen = bool(log.detections.t.size and log.objects)
    for effect in _judged(own or {}):
        if effect.slot == "perception":
            lacking = "" if seen else "needs objects, true and detected"
        else:
            lacking = _lacking(effect.shown_by, held, imposed, idle, value, log)
        if lacking:
            out[effect.name] = lacking
        elif missed := _missed(effect.shown_by.usual, value):
            hardly[effect.name] = missed
        else:
            within.append(effect.name)
    return Excitation(facts, tuple(within), hardly, out)


def _judged(own: Mapping[str, Effect]) -> list[Effect]:
    """The effects of the catalogue by their place, then the user's own; those of perception after the others."""
    known = sorted(catalogue().values(), key=lambda effect: (effect.shown_by.place, effect.name))
    return sorted([*known, *own.values()], key=lambda effect: effect.slot == "perception")


def _lacking(
    rule: ShownBy, held: set[str], imposed: set[str], idle: set[str], value: Mapping[str, float], log: Log
) -> str:
    for group in rule.columns:
        if not held & set(group):
            if imposed & set(group):
                return 'needs a model that does not take the speed from the log (longitudinal = "v")'
            if there := [name for name in group if name in idle]:
                return f"needs a model that is driven by {there[0]}"
            if there := [name for name in group if name in log.columns]:
                return f"needs a column {there[0]} that changes"
            return "needs a column " + " or ".join(group[:3])
    if any(name not in value for name, _, _ in rule.drives):
        return "needs the speed of the car (a column v, or x and y)"
    return _missed(rule.drives, value)


def _missed(drives: tuple[Drive, ...], value: Mapping[str, float]) -> str:
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
    # A speed controller asks for about 1 m/s^2 a m/s that is lacking (chosen: amid its usual gains). When it asks for
    # little or nothing, the wanted speed does not tell.
    for name, small in (("accel_cmd", 0.5), ("throttle_cmd", 0.1), ("motor_current", 10.0), ("speed_cmd", 0.5)):
        values = log.columns.get(name)
        if values is None or not np.isfinite(values).any():
            continue
        known = np.isfinite(values)
        command = np.interp(motion.t, log.t[known], values[known])
        low = np.abs(command) < small
        zero = np.abs(command) < 0.1 * small
        rate = np.abs(np.gradient(_smooth(command, round(0.4 / step)), step)) * 0.5 / small
        told = name != "speed_cmd"
        facts += [
            Fact("small_commands", float(np.count_nonzero(low & ~zero & ~still & told)) * step, "s"),
            Fact("coasting", float(np.count_nonzero(zero & ~still & told)) * step, "s"),
            Fact("command_rate", float(np.percentile(rate, 98)), "m/s^3"),
        ]
        break
    return facts


def _smooth(values: FloatArray, count: int) -> FloatArray:
    return np.convolve(values, np.full(max(count, 1), 1.0 / max(count, 1)), "same")
