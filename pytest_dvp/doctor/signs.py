"""Units, signs and axes: each quantity against the others that tell the same motion."""

from __future__ import annotations

import math

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.doctor.motion import Motion, best_lag, correlation, slope
from pytest_dvp.log import FloatArray, Log

DEGREES = 180.0 / math.pi
HARDEST = 60.0  # m/s^2: no ground vehicle turns harder, not even a racing car
WIDEST = 1.2  # rad: road-wheel angle beyond that of any car
_SCALES = (  # ratio of what was read to what it should be -> what happened
    (3.6, "km/h stored as m/s", "km/h"), (2.23694, "mph stored as m/s", "mph"), (1.94384, "knots stored as m/s", "kn"),
    (1 / 3.6, "m/s stored as km/h", "m/s"),
)  # fmt: skip


def check_speed(motion: Motion, file: str, findings: Findings) -> None:
    """v against the way between positions."""
    if not motion.has("v", "path_speed"):
        return
    path_speed = motion.of["path_speed"]
    at = motion.moving & (path_speed > 0)
    if np.count_nonzero(at) < 20 or float(np.nanpercentile(path_speed, 80)) < 0.5:
        return  # standing: the positions move by their noise only
    ratio = float(np.median(np.abs(motion.of["v"][at]) / motion.of["path_speed"][at]))
    if 0.8 < ratio < 1.25:
        return
    text, unit = next(((text, unit) for value, text, unit in _SCALES if abs(ratio / value - 1.0) < 0.1), ("", ""))
    findings.add(
        "log.unit_suspect",
        file,
        None,
        "column v",
        f"v does not fit the positions{': ' + text if text else ''}",
        found=f"v = {ratio:.3g} * distance over time",
        allowed="0.8 to 1.25",
        hint=f"write `v [{unit}]`" if unit else "check the units of v, x, y and t",
    )


def check_angles(log: Log, motion: Motion, file: str, findings: Findings) -> None:
    """Degrees stored as radians in yaw, yaw_rate, steer, steer_cmd."""
    of = motion.of
    wrong: dict[str, str] = {}
    speed = np.abs(of["path_speed"] if motion.has("path_speed") else of.get("v", np.ones(len(motion.t))))
    if motion.has("yaw_step"):
        steps = np.abs(of["yaw_step"])
        if np.percentile(steps * np.maximum(speed, 1.0), 90) > HARDEST:
            wrong["yaw"] = f"{np.percentile(steps, 90):.3g} rad/s of turn at {np.median(speed):.3g} m/s"
    ratio = _ratio(motion, "yaw_step", "yaw_rate")
    if abs(abs(ratio) / DEGREES - 1.0) < 0.25:
        wrong["yaw"] = f"d(yaw)/dt = {ratio:.3g} * yaw_rate"
    elif abs(abs(ratio) * DEGREES - 1.0) < 0.25:
        wrong["yaw_rate"] = f"yaw_rate = {1 / ratio:.3g} * d(yaw)/dt"
    against_path = _ratio(motion, "yaw_step", "path_turn")
    if "yaw" not in wrong and abs(abs(against_path) / DEGREES - 1.0) < 0.3:
        wrong["yaw"] = f"d(yaw)/dt = {against_path:.3g} * turn rate of the path"
    if not motion.has("yaw_step") and abs(abs(_ratio(motion, "yaw_rate", "path_turn")) / DEGREES - 1.0) < 0.3:
        wrong["yaw_rate"] = "57 times the turn rate of the path"
    for name, found in wrong.items():
        findings.add(
            "log.implausible_range",
            file,
            None,
            f"column {name}",
            "degrees stored as radians",
            found=found,
            hint=f"write `{name} [{'deg' if name == 'yaw' else 'deg/s'}]`",
        )
    turn = "turn" if motion.has("turn") and "yaw" not in wrong else "path_turn"
    for name in ("steer", "steer_cmd"):
        _check_steer(log, motion, name, turn, file, findings)


def _check_steer(log: Log, motion: Motion, name: str, turn: str, file: str, findings: Findings) -> None:
    values = log.columns.get(name)
    if values is None or not np.isfinite(values).any():
        return
    largest = float(np.nanpercentile(np.abs(values), 99))
    found = f"{largest:.3g} rad" if largest > WIDEST else ""
    if motion.has(name, turn, "v") and not found:
        at = motion.moving & np.isfinite(motion.of[turn])
        curve, angle = motion.of[turn][at], (motion.of[name] * motion.of["v"])[at]
        if len(curve) > 50 and abs(correlation(angle, curve)) > 0.7 and np.std(curve) > 0.02:
            base = abs(slope(angle, curve))
            if base > 20.0:
                found = f"v * {name} / turn rate = a wheelbase of {base:.3g} m"
    if found:
        findings.add(
            "log.implausible_range",
            file,
            None,
            f"column {name}",
            "degrees stored as radians, or the hand wheel's angle",
            found=found,
            allowed=f"a road-wheel angle, up to {WIDEST} rad",
            hint=f"write `{name} [deg]`, or give the steering ratio in a mapping",
        )


def _ratio(motion: Motion, a: str, b: str) -> float:
    """a / b where both turn; NaN if they are not of one shape."""
    if not motion.has(a, b):
        return float("nan")
    at = np.isfinite(motion.of[a]) & np.isfinite(motion.of[b]) & motion.moving
    first, second = motion.of[a][at], motion.of[b][at]
    if len(first) < 50:
        return float("nan")
    # The wrap of degrees at 360 makes steps; the middle of the data has none.
    size = np.percentile(np.abs(first), 97)
    kept = np.abs(first) <= size
    if abs(correlation(first[kept], second[kept])) < 0.6:
        return float("nan")
    return slope(first[kept], second[kept])


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
