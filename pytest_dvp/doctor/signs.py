"""Units, signs and axes: each quantity against the others that tell the same motion."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.doctor.motion import Motion, best_lag, correlation, slope
from pytest_dvp.log import FloatArray

_SCALES = (  # ratio of what was read to what it should be -> what happened
    (3.6, "km/h stored as m/s", "km/h"), (2.23694, "mph stored as m/s", "mph"), (1.94384, "knots stored as m/s", "kn"),
    (1 / 3.6, "m/s stored as km/h", "m/s"),
)  # fmt: skip


def check_speed(motion: Motion, file: str, findings: Findings) -> Motion:
    """v against the way between positions; without them against ay and ax, both of which must say the same.

    Returns the motion with v righted, so that a wrong speed spoils no other check.
    """
    ratio, against = _speed_ratio(motion)
    if not math.isfinite(ratio) or 0.8 < ratio < 1.25:
        return motion
    text, unit = next(((text, unit) for value, text, unit in _SCALES if abs(ratio / value - 1.0) < 0.1), ("", ""))
    if against != "the positions" and not unit:
        return motion  # accelerometers may have a scale of their own
    findings.add(
        "log.unit_suspect",
        file,
        None,
        "column v",
        f"v does not fit {against}{': ' + text if text else ''}",
        found=f"v = {ratio:.3g} * {'distance over time' if against == 'the positions' else 'what they tell'}",
        allowed="0.8 to 1.25",
        hint=f"write `v [{unit}]`" if unit else "check the units of v, x, y and t",
    )
    scaled: dict[str, FloatArray] = {name: motion.of[name] / ratio for name in ("v", "accel") if name in motion.of}
    return dataclasses.replace(motion, of={**motion.of, **scaled})


def _speed_ratio(motion: Motion) -> tuple[float, str]:
    """v over the true speed, and by what; NaN if nothing tells."""
    of = motion.of
    if motion.has("v", "path_speed"):
        at = motion.moving & (of["path_speed"] > 0)
        if np.count_nonzero(at) < 20 or float(np.nanpercentile(of["path_speed"], 80)) < 0.5:
            return math.nan, ""  # standing: the positions move by their noise only
        return float(np.median(np.abs(of["v"][at]) / of["path_speed"][at])), "the positions"
    if not motion.has("v", "yaw_rate", "ax", "ay"):
        return math.nan, ""
    found = []
    for told, felt in ((of["v"] * of["yaw_rate"], of["ay"]), (of["accel"], of["ax"])):
        known = np.isfinite(told) & np.isfinite(felt)
        if abs(correlation(told[known], felt[known])) < 0.9:
            return math.nan, ""
        found.append(abs(slope(told[known], felt[known])))
    return (found[0], "ay and ax") if abs(found[0] / found[1] - 1.0) < 0.15 else (math.nan, "")


def check_acceleration(motion: Motion, file: str, findings: Findings) -> None:
    """ax against dv/dt, ay against v * yaw rate: swapped, turned round, in g."""
    of = motion.of
    turn = next((name for name in ("yaw_rate", "turn", "path_turn") if name in of), None)
    if "v" not in of or turn is None:
        return
    lateral, along = of["v"] * of[turn], of["accel"]
    known = np.isfinite(lateral) & np.isfinite(along)
    lateral, along = lateral[known], along[known]
    ax, ay = (of[name][known] if name in of else None for name in ("ax", "ay"))
    if ax is not None and ay is not None and np.std(lateral) > 0.1 and np.std(along) > 0.1:
        straight = abs(correlation(ax, along)) + abs(correlation(ay, lateral))
        crossed = abs(correlation(ax, lateral)) + abs(correlation(ay, along))
        if crossed > straight + 0.5 and crossed > 1.0:
            findings.add(
                "log.axes_swapped",
                file,
                None,
                "column ax",
                "ax and ay are swapped: ay goes with dv/dt, ax with v * yaw_rate",
                found=f"correlation {crossed / 2:.2f} crossed, {straight / 2:.2f} as named",
                hint="exchange the two names",
            )
            return
    for name, values, reference, what in (("ax", ax, along, "dv/dt"), ("ay", ay, lateral, "v * yaw_rate")):
        if values is None or np.std(reference) < 0.2:
            continue
        if abs(correlation(values, reference)) > 0.8 and 0.08 < abs(slope(values, reference)) < 0.125:
            findings.add(
                "log.unit_suspect",
                file,
                None,
                f"column {name}",
                "g stored as m/s^2",
                found=f"{name} = {slope(values, reference):.3g} * {what}",
                hint=f"write `{name} [g]`",
            )
    for name, values in (("ax", ax), ("accel_cmd", of["accel_cmd"][known] if "accel_cmd" in of else None)):
        if values is not None and np.std(along) > 0.2 and _shape(values, along, motion.step) < -0.6:
            _tell_sign(name, "dv/dt", file, findings)


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
        _tell_sign(column, others, file, findings)


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
            shape[i, j] = shape[j, i] = _shape(usable[names[i]], usable[names[j]], step)
    votes = np.where(np.abs(shape) > 0.6, np.sign(shape), 0.0)
    centre = int(np.argmax(np.abs(votes).sum(axis=1)))
    sign = votes[centre].copy()
    sign[centre] = 1.0
    # The measured turn (yaw, yaw_rate, path) before command and acceleration where the numbers are equal.
    weight = np.array([{"turn": 1.1, "yaw_rate": 1.05, "path_turn": 0.9}.get(name, 1.0) for name in names])
    if float(sign @ weight) < 0.0:
        sign = -sign
    return {name: int(value) for name, value in zip(names, sign, strict=True) if value}


def _shape(a: FloatArray, b: FloatArray, step: float) -> float:
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


def _tell_sign(name: str, others: str, file: str, findings: Findings) -> None:
    findings.add(
        "log.sign_flipped",
        file,
        None,
        f"column {name}",
        f"the sign is against {others}",
        allowed="x forward, y left, counter-clockwise (ISO 8855)",
        hint=f"turn it round: sign = -1 for {name} in a mapping",
    )
