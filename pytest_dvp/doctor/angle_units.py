"""Scales of angles and angular rates: degrees for radians, radians for degrees, the hand wheel for the road wheel.

All witnesses of the turn are held against each other at once, and the fewest wrong columns that explain every ratio are
told: a gyro in rad/s under a header [deg/s] disagrees with yaw, but also with the path, ay and the steering.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import NamedTuple

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.doctor.redundant_motion import Motion, best_lag, correlation, rows_between, slope
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.bus import GRAVITY

DEGREES = 180.0 / math.pi
HARDEST = 60.0  # m/s^2: no ground vehicle turns harder, not even a racing car
WIDEST = 1.2  # rad: road-wheel angle beyond that of any car
HAND_WHEEL = 14.0  # middle of the usual steering ratios, 8 to 25
WHEELBASE = (0.08, 20.0)  # [m] of a model car, and of a bus that understeers
USUAL_WHEELBASE = 2.7  # m
FACTOR = 2.5  # two witnesses of one turn may differ by as much for reasons of their own
COMMAND_FACTOR = 5.0  # wanted and measured steering: beyond that it is no steering ratio that a model could have
LONGEST = 1.0  # [s] that an actuator or a sensor is late
IN_G = 1.5  # times: how well g is known from the ratio of two witnesses; chosen, units of angles are farther away
UNDECIDED = 0.5  # two explanations nearer than this are both told

_RATES = ("yaw", "yaw_rate")
_STEERS = ("steer", "steer_cmd")
_FIXED = ("x, y", "ay")  # metres and seconds have been looked at before


class Pair(NamedTuple):
    """Two witnesses of one shape, and a / b."""

    a: str
    b: str
    ratio: float


def check_angles(log: Log, motion: Motion, file: str, findings: Findings) -> Motion:
    """Tells which of yaw, yaw_rate, steer, steer_cmd has a unit that is not what its header says.

    Returns the motion with those columns righted (without yaw, if it is that), so that they spoil no other check.
    """
    witnesses = _witnesses(motion)
    step = motion.step * rows_between(motion)
    pairs = _pairs(witnesses, step)
    if _in_g(pairs):  # told elsewhere; the steering is not wrong for it
        pairs = _pairs({**witnesses, "ay": GRAVITY * witnesses["ay"]}, step)
    sizes = {name: _high(log, name) for name in _STEERS}
    named = [name for name in _RATES if name in witnesses] + [name for name in _STEERS if sizes[name] > 0.0]
    choices = [_RATE_FACTORS if name in _RATES else _STEER_FACTORS for name in named]
    lateral = _lateral(motion)

    def cost(factors: tuple[float, ...]) -> float:
        read = dict(zip(named, factors, strict=True))
        wrong = sum(factor != 1.0 for factor in factors)
        return wrong + _disagreement(pairs, read) + _implausible(read, sizes, lateral, pairs)

    ranked = sorted(itertools.product(*choices), key=cost)
    best = {name: factor for name, factor in zip(named, ranked[0], strict=True) if factor != 1.0}
    rival = {name: factor for name, factor in zip(named, ranked[1], strict=True) if factor != 1.0} if named else {}
    if not best or cost(ranked[1]) > cost(ranked[0]) + UNDECIDED or set(rival) == set(best):
        rival = {}
    for name, factor in best.items():
        doubt = "".join(f"; or {other} holds {_what(other, rival[other])}" for other in rival if other not in best)
        _tell(name, factor, sizes.get(name, 0.0), pairs, doubt, log, file, findings)
    return _righted(motion, best)


def _in_g(pairs: list[Pair]) -> bool:
    """Whether the lateral acceleration is smaller than the turn tells, by what a unit of g makes of it."""
    turns = ("yaw", "yaw_rate", "x, y")
    shares = [pair.ratio if pair.a == "ay" else 1.0 / pair.ratio for pair in pairs
              if "ay" in (pair.a, pair.b) and (pair.a in turns or pair.b in turns)]  # fmt: skip
    return bool(shares) and all(1.0 / IN_G < share * GRAVITY < IN_G for share in shares)


def _righted(motion: Motion, wrong: dict[str, float]) -> Motion:
    of = {name: values / wrong.get(name, 1.0) for name, values in motion.of.items()}
    if "yaw" not in wrong:
        return dataclasses.replace(motion, of=of)
    for name in ("turn", "yaw_step"):
        of.pop(name, None)
    return dataclasses.replace(motion, of=of, heading=np.full(len(motion.t), np.nan))


_RATE_FACTORS = (1.0, DEGREES, 1.0 / DEGREES)
_STEER_FACTORS = (*_RATE_FACTORS, HAND_WHEEL, HAND_WHEEL * DEGREES)


def _witnesses(motion: Motion) -> dict[str, FloatArray]:
    """Turn rates [rad/s] (steering: times the wheelbase [m]) by column, thinned out by rows_between."""
    of = motion.of
    speed = of.get("v", of.get("path_speed"))
    every = rows_between(motion)
    found: dict[str, FloatArray] = {}
    fast = np.where(np.abs(speed) > 0.3, speed, np.nan) if speed is not None else np.full(len(motion.t), np.nan)
    found.update({name: of[name] * fast for name in _STEERS if name in of})
    if "yaw_step" in of:
        # Degrees taken for radians jump by 360 where they wrap: those windows are left out.
        size = np.abs(of["yaw_step"])
        found["yaw"] = np.where(size <= np.percentile(size, 97), of["yaw_step"], np.nan)
    if "yaw_rate" in of:
        found["yaw_rate"] = of["yaw_rate"]
    if "path_turn" in of:
        found["x, y"] = of["path_turn"]
    if "ay" in of:
        found["ay"] = of["ay"] / fast
    return {name: np.where(motion.moving, values, np.nan)[::every] for name, values in found.items()}


def _pairs(witnesses: dict[str, FloatArray], step: float) -> list[Pair]:
    """Pairs of one shape at their best lag; a sign does not matter here."""
    found = []
    for a, b in itertools.combinations(witnesses, 2):
        if a in _FIXED and b in _FIXED:
            continue
        ratio = _ratio(witnesses[a], witnesses[b], step)
        if math.isfinite(ratio) and ratio > 0.0:
            found.append(Pair(a, b, ratio))
    return found


def _ratio(a: FloatArray, b: FloatArray, step: float) -> float:
    """Size of a / b where they are of one shape, whatever comes later; NaN if they are not."""
    if min(np.count_nonzero(np.isfinite(a)), np.count_nonzero(np.isfinite(b))) < 20:
        return float("nan")
    lag, _ = best_lag(a, b, step, LONGEST)
    rows = round(lag / step)
    a, b = (a[rows:], b[: len(b) - rows]) if rows >= 0 else (a[: len(a) + rows], b[-rows:])
    known = np.isfinite(a) & np.isfinite(b)
    if np.count_nonzero(known) < 20:
        return float("nan")
    together = abs(correlation(a[known], b[known]))
    # Noise of b flattens the slope by the correlation, noise of a does not: with both the truth is between.
    return abs(slope(a[known], b[known])) / math.sqrt(together) if together > 0.6 else float("nan")


def _disagreement(pairs: list[Pair], read: dict[str, float]) -> float:
    """Pairs whose ratio these factors do not explain, each as bad as two wrong columns.

    A ratio that no unit of an angle explains (g for m/s^2, a filter) says nothing here.
    """
    total = 0.0
    for a, b, ratio in pairs:
        low, high = _allowed(a, b)
        right = ratio * read.get(b, 1.0) / read.get(a, 1.0)
        if not low <= right <= high and any(low <= ratio / k <= high for k in _EXPLAINED[a in _STEERS]):
            total += 2.0
    return total


_EXPLAINED = {
    False: _RATE_FACTORS,
    True: tuple(f / g for f in _STEER_FACTORS for g in _STEER_FACTORS),
}


def _allowed(a: str, b: str) -> tuple[float, float]:
    """Least and largest a / b of two columns in SI units; steering comes first in the witnesses."""
    if a in _STEERS:
        return (1.0 / COMMAND_FACTOR, COMMAND_FACTOR) if b in _STEERS else WHEELBASE
    return 1.0 / FACTOR, FACTOR


def _implausible(
    read: dict[str, float], sizes: dict[str, float], lateral: dict[str, float], pairs: list[Pair]
) -> float:
    """What no vehicle does costs as much as a pair that disagrees; what is only unusual decides between equals."""
    total = 0.0
    for name, factor in read.items():
        if name in _RATES:
            total += 2.0 * (lateral.get(name, 0.0) / factor > HARDEST)
        else:
            angle = sizes[name] / factor
            total += 2.0 * (angle > WIDEST) + 0.3 * (angle < 0.02) * (factor != 1.0)
    for a, b, ratio in pairs:
        if a in _STEERS and b not in _STEERS:
            base = ratio * read.get(b, 1.0) / read[a]
            total += 0.05 * abs(math.log(base / USUAL_WHEELBASE))
    return total


def _high(log: Log, name: str) -> float:
    values = log.columns.get(name)
    known = values[np.isfinite(values)] if values is not None else np.zeros(0)
    return float(np.percentile(np.abs(known), 99)) if len(known) else 0.0


def _lateral(motion: Motion) -> dict[str, float]:
    """Turn rate times speed [m/s^2], exceeded for a tenth of the time, by yaw and by yaw_rate."""
    speed = np.abs(motion.of.get("path_speed", motion.of.get("v", np.ones(len(motion.t)))))
    return {
        name: float(np.percentile(np.abs(motion.of[key]) * np.maximum(speed, 1.0), 90))
        for name, key in (("yaw", "yaw_step"), ("yaw_rate", "yaw_rate"))
        if key in motion.of
    }


def _evidence(name: str, pairs: list[Pair]) -> str:
    """The ratio to the witness that is least in doubt, in words."""
    for other in _WORDS:
        for a, b, ratio in pairs:
            if {a, b} != {name, other}:
                continue
            if a in _STEERS and b not in _STEERS:
                return f"v * {a} / {_WORDS[b]} = a wheelbase of {ratio:.3g} m"
            return f"{_WORDS[name]} = {ratio if a == name else 1.0 / ratio:.3g} * {_WORDS[other]}"
    return ""


_WORDS = {
    "x, y": "turn rate of the path", "yaw": "d(yaw)/dt", "yaw_rate": "yaw_rate", "ay": "ay / v",
    "steer_cmd": "steer_cmd", "steer": "steer",
}  # fmt: skip


def _what(name: str, factor: float, *, in_degrees: bool = False) -> str:
    if factor < 1.0:
        return "radians stored as degrees"
    if name not in _STEERS:
        return "degrees stored as radians"
    wheel = "the hand wheel's angle for the road wheel's"
    return wheel if in_degrees else f"degrees stored as radians, or {wheel}"


def _tell(
    name: str, factor: float, largest: float, pairs: list[Pair], doubt: str, log: Log, file: str, findings: Findings
) -> None:
    read = log.meta.get("import", {})
    column = read.get("columns", {}).get(name, {})
    mapped = next((one["unit"] for one in read.get("mapping", ()) if one["name"] == name), "")
    own, unit = column.get("from", name), column.get("unit", "")
    in_degrees = abs(column.get("scale", 1.0) * DEGREES - 1.0) < 1e-6
    second = "/s" if name == "yaw_rate" else ""
    if mapped and mapped in (f"deg{second}", f"rad{second}") and (factor < 1.0) == mapped.startswith("deg"):
        other = f"rad{second}" if factor < 1.0 else f"deg{second}"
        hint = f'the mapping says unit = "{mapped}" for {name}: write unit = "{other}"'
        if name in _STEERS and factor > 1.0 and factor != DEGREES:
            hint += (
                f", and the steering ratio: `ratio = {_ratio_of_wheel(name, factor, pairs):.0f}`, or what the car has"
            )
    elif factor < 1.0:
        twice = bool(unit) and not in_degrees
        hint = "they were turned into radians twice: do it once" if twice else f"write `{own} [rad{second}]`"
    elif name in _RATES:
        hint = "they were turned into degrees twice: do it once" if in_degrees else f"write `{own} [deg{second}]`"
    else:
        hint = _advice_for_steering(own, factor, in_degrees, _ratio_of_wheel(name, factor, pairs))
    evidence = "; ".join(part for part in (f"{largest:.3g} rad" * (largest > WIDEST), _evidence(name, pairs)) if part)
    findings.add(
        "log.implausible_range", file, None, f"column {name}", _what(name, factor, in_degrees=in_degrees) + doubt,
        found=evidence, hint=hint,
        allowed=f"a road-wheel angle, up to {WIDEST} rad" if name in _STEERS else "",
    )  # fmt: skip


def _advice_for_steering(own: str, factor: float, in_degrees: bool, ratio: float) -> str:
    wheel = f"give the steering ratio in a mapping: `ratio = {ratio:.0f}`, or what the car has"
    degrees = f"write `{own} [deg]`"
    if in_degrees:
        return wheel
    if factor == DEGREES:
        return f"{degrees}; if it is the hand wheel, {wheel}"
    return f"{wheel}; or {degrees}" if factor == HAND_WHEEL else f"{degrees} and {wheel}"


def _ratio_of_wheel(name: str, factor: float, pairs: list[Pair]) -> float:
    """Steering ratio that would make the wheelbase that of a usual car; the middle of all if nothing tells."""
    base = next((ratio for a, b, ratio in pairs if a == name and b not in _STEERS), 0.0)
    found = base / USUAL_WHEELBASE / (DEGREES if factor > DEGREES else 1.0)
    return found if 5.0 < found < 30.0 else HAND_WHEEL
