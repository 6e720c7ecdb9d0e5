"""Sensors that are dead, frozen or saturated, and reports that are only an echo of a command."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from openscenario.findings import Findings
from pytest_dvp.doctor.redundant_motion import Motion
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

FROZEN = 1.0  # [s] without any change while the car's other signals change
SLOW = 2.0  # [s] of means in which noise is gone
SATURATED = 0.003  # share of the rows at one extreme value
_RUN = 4  # rows in a row at that value: noise never stays at its extreme

# Signal -> witnesses on the motion's grid that move when it must, and by how much (standard deviation).
_WITNESS = {
    "x": (("v", 0.0),), "y": (("v", 0.0),), "v": (("path_speed", 0.3),),
    "yaw": (("yaw_rate", 0.03), ("path_turn", 0.05)),
    "yaw_rate": (("turn", 0.03), ("path_turn", 0.05)), "ax": (("accel", 0.2),), "ay": (("v*turn", 0.15),),
    "steer": (("turn", 0.05), ("yaw_rate", 0.05)),
}  # fmt: skip
_LIMITED = ("yaw_rate", "ax", "ay")  # sensors with a range that a drive can exceed
_ECHOES = (("steer", "steer_cmd"), ("v", "speed_cmd"), ("ax", "accel_cmd"))


def check_sensors(log: Log, motion: Motion, file: str, findings: Findings) -> None:
    """Add a finding for each column that is dead or saturated; those that were never measured are left out."""
    of = dict(motion.of)
    if motion.has("v"):
        turn = of.get("turn", of.get("yaw_rate"))
        if turn is not None:
            of["v*turn"] = of["v"] * turn
    for name in _WITNESS:
        values = log.columns.get(name)
        if values is None:
            continue
        if not np.isfinite(values).any():
            continue
        if not _dead(log, name, values, motion, of, file, findings) and name in _LIMITED:
            _saturated(log, name, values, file, findings)


def _dead(
    log: Log, name: str, values: FloatArray, motion: Motion, of: dict[str, FloatArray], file: str, findings: Findings
) -> bool:
    seen = np.isfinite(values)
    t, known = log.t[seen], values[seen]
    begin, end = _longest_constant(t, known)
    lasts = end - begin
    if lasts < FROZEN:
        return False
    held = float(known[np.searchsorted(t, begin)])
    whole = lasts > 0.98 * (t[-1] - t[0])
    if not whole and name in _LIMITED and abs(held) > 1e-3 and held in (known.max(), known.min()):
        return False  # at the end of its range: that is saturation
    inside = (motion.t >= begin + 0.3) & (motion.t <= end - 0.3)
    for witness, least in _WITNESS[name]:
        other = of.get(witness)
        if other is None or np.count_nonzero(inside) < 10:
            continue
        part = other[inside]
        part = part[np.isfinite(part)]
        if name in ("x", "y"):
            moved = _distance(log, begin, end, name)
            moves = moved > max(1.0, 0.2 * float(np.sum(np.abs(part)) * motion.step))
        else:
            moves = len(part) > 10 and _moves(part, motion.step, least)
        if moves:
            findings.add(
                "log.dead_sensor",
                file,
                None,
                f"column {name}",
                f"{name} stays at {held:.6g} "
                + ("in the whole log" if whole else f"from t = {begin:.6g} to {end:.6g} s")
                + " while the car's motion changes",
                hint="the sensor or its channel is dead: leave the column out, or cut the log",
                severity="error" if whole else "warning",
            )
            return True
    return False


def _moves(witness: FloatArray, step: float, least: float) -> bool:
    """Whether a witness moves by more than its own noise.

    A simulated car on a straight has a yaw without any change, and the turn of its path is noise of the positions:
    that is gone in means over a while, a manoeuvre is not.
    """
    count = max(1, min(round(SLOW / step), len(witness) // 3))
    slow = np.convolve(witness, np.full(count, 1.0 / count), "valid")
    return float(np.std(slow)) > max(least, 0.5 * float(np.std(witness)))


def _distance(log: Log, begin: float, end: float, name: str) -> float:
    """How far the car went along the axis `name` by v and yaw [m]; by v alone without yaw."""
    v, yaw = log.columns["v"], log.columns.get("yaw")
    if yaw is None:
        return 0.0
    at = (log.t >= begin) & (log.t <= end)
    rate = (v * (np.cos(yaw) if name == "x" else np.sin(yaw)))[at]
    rate, t = rate[np.isfinite(rate)], log.t[at][np.isfinite(rate)]
    return float(np.ptp(np.cumsum(rate[:-1] * np.diff(t)))) if len(t) > 2 else 0.0


def _longest_constant(t: FloatArray, values: FloatArray) -> tuple[float, float]:
    """Start and end [s] of the longest stretch without any change."""
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    edges = np.concatenate([[0], changes, [len(values)]])
    lasts = t[edges[1:] - 1] - t[edges[:-1]]
    longest = int(np.argmax(lasts))
    return float(t[edges[longest]]), float(t[edges[longest + 1] - 1])


def _saturated(log: Log, name: str, values: FloatArray, file: str, findings: Findings) -> None:
    known = values[np.isfinite(values)]
    if known.max() == known.min():
        return  # a steady circle of a simulated car: one value has no limit
    for extreme in (float(known.max()), float(known.min())):
        at = known == extreme
        count = int(np.count_nonzero(at))
        if abs(extreme) < 1e-3 or count < max(20, SATURATED * len(known)) or _stays(at) < 1:
            continue
        # Coarse steps make equal neighbours everywhere; a limit makes them at the limit only.
        if np.count_nonzero(np.diff(known[~at]) == 0.0) > 0.2 * len(known):
            continue
        findings.add(
            "log.saturated",
            file,
            None,
            f"column {name}",
            f"{name} stays at its {'largest' if extreme == known.max() else 'smallest'} value, {extreme:.6g}, "
            f"in {count} rows",
            hint="the sensor's range ended there: leave those stretches out, or take a sensor of wider range",
            severity="warning",
        )


def _stays(at: NDArray[np.bool_]) -> int:
    """Stretches of at least _RUN rows."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], at.astype(np.int8), [0]])))
    return int(np.count_nonzero(edges[1::2] - edges[::2] >= _RUN))


def check_echoes(log: Log, file: str, findings: Findings) -> None:
    """A measured value that is its command, exactly, at once or some rows later."""
    for name, command in _ECHOES:
        if not {name, command} <= log.columns.keys():
            continue
        a, b = log.columns[name], log.columns[command]
        known = np.isfinite(a) & np.isfinite(b)
        if np.count_nonzero(known) < 20 or np.ptp(b[known]) == 0.0:
            continue
        rows = _echo(a[known], b[known])
        if rows is None:
            continue
        later = f", {rows} rows later" if rows else ""
        findings.add(
            f"log.{name}_is_command",
            file,
            None,
            f"column {name}",
            f"{name} is {command} itself{later}, not a measurement",
            hint=f"no effect between command and {name} can be seen in it: leave the column out, or record the sensor",
            severity="warning",
        )


def _echo(a: FloatArray, b: FloatArray) -> int | None:
    tolerance = 1e-5 * float(np.ptp(b))
    for rows in range(11):
        same = np.abs(a[rows:] - b[: len(b) - rows]) <= tolerance
        moving = np.abs(np.diff(b[: len(b) - rows], prepend=b[0])) > tolerance
        if np.mean(same) > 0.99 and np.any(moving & same):
            return rows
    return None
