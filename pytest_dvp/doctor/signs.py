"""Signs and axes of all that turns with the car, and the direction that yaw is counted from."""

from __future__ import annotations

import math

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.doctor.motion import Motion, best_lag
from pytest_dvp.log import FloatArray


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
    usable = {n: np.where(at, w, np.nan) for n, w in witnesses.items() if _varies(np.where(at, w, np.nan), n)}
    if len(usable) < 2:
        return
    signs = _signs(usable, motion.step)
    against = [name for name, sign in signs.items() if sign < 0]
    if not against:
        _check_heading(motion, mirrored=False, file=file, findings=findings)
        return
    if "path_turn" in against or (against == ["turn"] and len(signs) == 2 and "path_turn" in signs):
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


def _varies(values: FloatArray, name: str) -> bool:
    known = values[np.isfinite(values)]
    least = {"steer": 0.01, "steer_cmd": 0.01}.get(name, 0.015)
    return len(known) > 50 and float(np.std(known)) > least


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
    """Correlation at the best lag within 0.3 s: delays of actuators and sensors do not make a sign."""
    return best_lag(a, b, step, 0.3)[1]


def _check_heading(motion: Motion, *, mirrored: bool, file: str, findings: Findings) -> None:
    """Course of the path against yaw: the angle between them tells which axes were taken for which."""
    at = motion.moving & np.isfinite(motion.course) & np.isfinite(motion.heading)
    if "v" in motion.of:
        at &= motion.of["v"] > 0.3
    if np.count_nonzero(at) < 50:
        return
    angle = motion.course[at] + (motion.heading[at] if mirrored else -motion.heading[at])
    mean = complex(np.mean(np.exp(1j * angle)))
    if abs(mean) < 0.7:
        return
    off = math.atan2(mean.imag, mean.real)
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
            hint="exchange or turn round the columns, or say the frame in a mapping",
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
    findings.add(
        "log.sign_flipped",
        file,
        None,
        f"column {name}",
        f"the sign is against {others}",
        allowed="x forward, y left, counter-clockwise (ISO 8855)",
        hint=f"turn it round: sign = -1 for {name} in a mapping",
    )
