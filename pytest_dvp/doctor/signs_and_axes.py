"""Signs and axes of all that turns with the car, and the direction that yaw is counted from."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.doctor.redundant_motion import ALIKE, Motion, best_lag, far_lag, rows_between
from pytest_dvp.logs.log_contents import FloatArray

BACKWARDS = 0.8  # of the drive v must say so, and the cosine between course and yaw against it, to be wrong; chosen


def check_direction(motion: Motion, file: str, findings: Findings) -> Motion:
    """A speed that says backwards while the path goes where yaw points. Returns the motion with v turned round then, so
    that it does not turn round all else that is judged by it."""
    of = motion.of
    at = motion.moving & np.isfinite(motion.course) & np.isfinite(motion.heading)
    if "v" not in of or np.count_nonzero(at) < 50 or np.mean(of["v"][at] < 0.0) < BACKWARDS:
        return motion
    mean = complex(np.mean(np.exp(1j * (motion.course[at] - motion.heading[at]))))
    if mean.real < BACKWARDS:
        return motion
    tell_sign("v", "x, y, yaw", file, findings)
    return dataclasses.replace(motion, of={**of, **{name: -of[name] for name in ("v", "accel") if name in of}})


def check_turning(motion: Motion, file: str, findings: Findings) -> None:
    """Signs of all that turns with the car: the majority is right, and a mirrored path tells swapped axes."""
    of = motion.of
    speed = of.get("v", of.get("path_speed"))
    if speed is None:
        return
    witnesses: dict[str, FloatArray] = {name: of[name] for name in ("path_turn", "turn", "yaw_rate") if name in of}
    fast = np.where(np.abs(speed) > 0.3, speed, np.nan)
    if "ay" in of:
        witnesses["ay"] = of["ay"] / fast
    for name in ("steer", "steer_cmd"):
        if name in of:
            witnesses[name] = of[name] * fast
    at = motion.moving
    every = rows_between(motion)
    seen = {n: np.where(at, w, np.nan)[::every] for n, w in witnesses.items()}
    usable = {n: w for n, w in seen.items() if _varies(w, n)}
    if len(usable) < 2:
        return
    signs = _signs(usable, motion.step * every)
    against = [name for name, sign in signs.items() if sign < 0]
    if not against:
        _check_heading(motion, mirrored=False, file=file, findings=findings)
        return
    inside = [name for name, sign in signs.items() if sign > 0]
    if {"path_turn", "turn"} <= set(against) and _tell_downwards(motion, inside, file, findings):
        against = [name for name in against if name not in ("path_turn", "turn")]
    elif "turn" in against and signs.get("path_turn", 0) > 0 and len(signs) > 2:
        against = [name for name in against if name != "turn" or not _tell_compass(motion, file, findings)]
    elif "path_turn" in against or (against == ["turn"] and len(signs) == 2 and "path_turn" in signs):
        _check_heading(motion, mirrored=True, file=file, findings=findings)
        against = [name for name in against if name != "path_turn" and len(signs) > 2]
    for name in against:
        column = "yaw" if name == "turn" else name
        if len(signs) == 2 and "path_turn" in signs and name == "turn":
            continue
        others = ", ".join(
            "yaw" if n == "turn" else "x, y" if n == "path_turn" else n for n, s in signs.items() if s > 0
        )
        tell_sign(column, others, file, findings)


def _sum_of_headings(motion: Motion, sign: float) -> float:
    """Mean of course + sign * yaw [rad]; NaN where it is not one angle."""
    at = motion.moving & np.isfinite(motion.course) & np.isfinite(motion.heading)
    if "v" in motion.of:
        at &= motion.of["v"] > 0.3
    if np.count_nonzero(at) < 50:
        return math.nan
    mean = complex(np.mean(np.exp(1j * (motion.course[at] + sign * motion.heading[at]))))
    return math.atan2(mean.imag, mean.real) if abs(mean) >= 0.7 else math.nan


def _tell_compass(motion: Motion, file: str, findings: Findings) -> bool:
    """Yaw against all others, the path too: it counts clockwise, and course + yaw tells from where."""
    off = _sum_of_headings(motion, 1.0)
    if not math.isfinite(off) or abs(off) < 0.15:
        return False
    compass = abs(off - math.pi / 2) < 0.15
    findings.add(
        "log.sign_flipped", file, None, "column yaw",
        "yaw is a compass heading: clockwise from north (y)" if compass else "yaw counts clockwise from elsewhere",
        found=f"course + yaw = {off:.3f} rad", allowed="counter-clockwise from the x axis (ISO 8855)",
        hint='frame = "ned" for yaw in a mapping' if compass else f"sign = -1, offset = {off:.3f} for yaw in a mapping",
    )  # fmt: skip
    return True


def _tell_downwards(motion: Motion, inside: list[str], file: str, findings: Findings) -> bool:
    """Path and yaw agree with each other and with nothing in the car, `inside`: one of the two has its z axis down."""
    off = _sum_of_headings(motion, -1.0)
    if not abs(off) < 0.15:
        return False
    findings.add(
        "log.axes_swapped", file, None, "column x",
        "x, y and yaw are of a map with z downwards (x north, y east, yaw from north to east), or "
        f"{', '.join(inside)} of a car with y to the right",
        found="path and yaw turn against all that is measured in the car", allowed="x east, y north (ISO 8855)",
        hint='in a mapping: of the map exchange x and y, and frame = "ned" for yaw; of the car frame = "frd" for '
        + ", ".join(inside),
    )  # fmt: skip
    return True


def _varies(values: FloatArray, name: str) -> bool:
    known = values[np.isfinite(values)]
    least = {"steer": 0.01, "steer_cmd": 0.01}.get(name, 0.015)
    return len(known) > 20 and float(np.std(known)) > least


def _signs(usable: dict[str, FloatArray], step: float) -> dict[str, int]:
    """+1 with the majority, -1 against it; those that go with none are left out."""
    names = list(usable)
    n = len(names)
    shape = np.zeros((n, n))
    for i in range(n):
        for j in range(i):
            shape[i, j] = shape[j, i] = shape_of(usable[names[i]], usable[names[j]], step)
    votes = np.where(np.abs(shape) > 0.6, np.sign(shape), 0.0)
    centre = int(np.argmax(np.abs(votes).sum(axis=1)))
    sign = votes[centre].copy()
    sign[centre] = 1.0
    # The measured turn (yaw, yaw_rate, path) before command and acceleration where the numbers are equal.
    weight = np.array([{"turn": 1.1, "yaw_rate": 1.05, "path_turn": 0.9}.get(name, 1.0) for name in names])
    if float(sign @ weight) < 0.0:
        sign = -sign
    return {name: int(value) for name, value in zip(names, sign, strict=True) if value}


def shape_of(a: FloatArray, b: FloatArray, step: float) -> float:
    """Correlation at the best lag within 0.3 s: delays of actuators and sensors do not make a sign.

    0 for what only looks turned round, as its clock is seconds off. Samples (n,) of both, one each `step` [s], in any
    units; without a unit, -1 to 1.
    """
    shape = best_lag(a, b, step, 0.3)[1]
    return 0.0 if -ALIKE < shape < 0.0 and far_lag(a, b, step, shape) is not None else shape


def _check_heading(motion: Motion, *, mirrored: bool, file: str, findings: Findings) -> None:
    """Course of the path against yaw: the angle between them tells which axes were taken for which."""
    off = _sum_of_headings(motion, 1.0 if mirrored else -1.0)
    if not math.isfinite(off):
        return
    if not mirrored and abs(off) < 0.15:
        return
    if mirrored:
        right, half = abs(abs(off) - math.pi / 2) < 0.4, abs(off) > math.pi - 0.4
        what = (
            "x and y are swapped, or yaw is a compass heading"
            if right and off > 0
            else "the sign of x is turned round"
            if half
            else "the sign of y is turned round, or the log's y axis points to the right"
        )
        findings.add(
            "log.axes_swapped" if right else "log.sign_flipped",
            file,
            None,
            "column x" if right or half else "column y",
            f"the path turns against yaw: {what}",
            found=f"course + yaw = {off:.2f} rad",
            allowed="course - yaw = 0",
            hint='frame = "ned" for yaw in a mapping if it is a compass heading, else exchange x and y'
            if right and off > 0
            else "exchange or turn round the columns, or say the frame in a mapping",
        )
        return
    back = abs(off) > math.pi - 0.4
    findings.add(
        "log.heading_offset",
        file,
        None,
        "column yaw",
        "the car moves backwards by its yaw while v > 0" if back else "the course is not where yaw points",
        found=f"course - yaw = {off:.3f} rad",
        allowed="within 0.15 rad",
        hint="turn yaw by this offset" + (", or give v its sign" if back else ", or look whether x and y are swapped"),
        severity="warning",
    )


def tell_sign(name: str, others: str, file: str, findings: Findings) -> None:
    """Add the finding that the sign of the column `name` is against `others` (words), and how to turn it round."""
    findings.add(
        "log.sign_flipped",
        file,
        None,
        f"column {name}",
        f"the sign is against {others}",
        allowed="x forward, y left, counter-clockwise (ISO 8855)",
        hint=f"turn it round: sign = -1 for {name} in a mapping"
        + (', or frame = "ned" if it is a compass heading' if name == "yaw" else ""),
    )
