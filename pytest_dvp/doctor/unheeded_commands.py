"""Commands that the car did not obey: where the log says so, and where a command rests while the car turns."""

from __future__ import annotations

import itertools

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.doctor.redundant_motion import WINDOW, Motion
from pytest_dvp.logs.engagement import DRIVER, ENGAGED, STACK, driven_by_others
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

RESTS = 5.0  # s without any change of the steering command, at least; chosen: a bend and a straight
SLOWEST = 2.0  # m/s, below which a curvature is mostly noise; chosen
BENDS = 0.01  # 1/m of curvature that speed does not explain, root mean square: 0.025 rad at 2.5 m of wheelbase. Chosen
HOLE = 5.0  # usual steps without a command: nobody knows what was asked; as pytest_dvp/gap/compare/segments.py has it
STEERS = ("steer_cmd", "steer_cmd_norm")
MEAN = 1.0  # s of means, in which most noise is gone
SURE = 2.0  # times the noise of such a mean, which is no bend; chosen: few means make a root mean square


def check_engaged(log: Log, file: str, findings: Findings) -> None:
    """For how long somebody else drove, and values of `engaged` that are no answer."""
    stated = log.columns.get(ENGAGED)
    if stated is None or not np.isfinite(stated).any():
        return
    known = stated[np.isfinite(stated)]
    if len(other := known[(known != STACK) & (known != DRIVER)]):
        findings.add(
            "log.bad_engaged", file, None, f"column {ENGAGED}", "1 says that the car obeys its commands, 0 that not",
            found=f"{other[0]:.6g}", allowed="0, 1",
            hint=f'a mode is told by a mapping: [[signal]] name = "{ENGAGED}", field = "FIELD", when = [1]',
        )  # fmt: skip
        return
    others = driven_by_others(log)
    if not others.any():
        return
    begin, end = _longest(log.t, others)
    share = float(np.sum(np.diff(log.t)[others[:-1]])) / max(float(log.t[-1] - log.t[0]), 1e-9)
    findings.add(
        "log.not_engaged", file, None, f"column {ENGAGED}",
        f"somebody else drives for {100 * share:.0f} % of the log, longest from t = {begin:.6g} to "
        f"{end:.6g} s", severity="warning",
        hint="commands are not known there: a model that they drive is compared with the rest",
    )  # fmt: skip


def check_resting(log: Log, motion: Motion, file: str, findings: Findings) -> None:
    """A warning where the steering command stays for RESTS while the car goes through bends. Needs v, and a yaw rate or
    a heading: of positions, noise alone makes bends."""
    name = next((one for one in STEERS if one in log.columns), STEERS[0])
    command = log.columns.get(name)
    witness = next((one for one in ("yaw_rate", "turn") if one in motion.of), None)
    if command is None or witness is None or not motion.has("v"):
        return
    turn, noise = motion.of[witness], _noise(log, witness)
    known = np.isfinite(command)
    t, values = log.t[known], command[known]
    if len(t) < 2:
        return
    steps = np.diff(t)
    changes = np.flatnonzero((np.diff(values) != 0.0) | (steps > HOLE * np.median(steps))) + 1
    edges = np.concatenate([[0], changes, [len(values)]])
    for first, after in itertools.pairwise(edges):
        begin, end = t[first], t[after - 1]
        if end - begin < RESTS:
            continue
        # The bend that the car is in when the command comes to rest is still its own.
        inside = (motion.t >= begin + MEAN) & (motion.t <= end)
        if _bends(motion.of["v"][inside], turn[inside], motion.step, noise):
            findings.add(
                "log.resting_command", file, None, f"column {name}",
                f"{name} stays at {values[first]:.6g} from t = {begin:.6g} to {end:.6g} s while the car goes "
                "through bends: somebody else steers",
                hint=f"add a column `{ENGAGED} [-]` with 0 there, leave the commands empty, or cut the log; a model "
                f"that is driven by {name} cannot follow",
                severity="warning",
            )  # fmt: skip
            return


def _noise(log: Log, witness: str) -> float:
    """Noise [rad/s] of means over MEAN of a yaw rate, or of the rate of a heading ("turn"), by the bend of three
    samples in a row: what turns is straight over so short a time."""
    name = "yaw" if witness == "turn" else witness
    known = np.isfinite(log.columns[name])
    t, values = log.t[known], log.columns[name][known]
    values = np.unwrap(values) if witness == "turn" else values
    if len(t) < 3:
        return 0.0
    sigma = 1.4826 * float(np.median(np.abs(np.diff(values, 2)))) / np.sqrt(6.0)  # of a normal distribution
    rate = 1.0 / float(np.median(np.diff(t)))
    if witness == "turn":  # a mean of differences over WINDOW is the difference of the means of its two ends
        return float(sigma * np.sqrt(2.0 / max(1.0, WINDOW * rate)) / MEAN)
    return float(sigma / np.sqrt(max(1.0, MEAN * rate)))


def _bends(v: FloatArray, turn: FloatArray, step: float, noise: float) -> bool:
    """Whether a car of speed v [m/s] and yaw rate [rad/s] (n,) steers; with the wheel held, a car's curvature is a
    constant and a part that goes with v^2 (understeer). noise [rad/s] of means of the yaw rate is no bend."""
    goes = np.abs(v) > SLOWEST
    goes &= np.isfinite(turn) & np.isfinite(v)
    if np.count_nonzero(goes) * step < 0.5 * RESTS:
        return False
    count = max(1, round(MEAN / step))
    curvature = np.convolve(turn[goes] / v[goes], np.full(count, 1.0 / count), "valid")
    speed = np.convolve(v[goes], np.full(count, 1.0 / count), "valid")
    if len(curvature) < 4:
        return False
    held = np.column_stack([np.ones(len(speed)), speed**2])
    rest = curvature - held @ np.linalg.lstsq(held, curvature, rcond=None)[0]
    unsure = noise * float(np.sqrt(np.mean(v[goes] ** -2.0)))
    return float(np.sqrt(np.mean(rest**2))) > max(BENDS, SURE * unsure)


def _longest(t: FloatArray, rows: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> tuple[float, float]:
    """Start and end [s] of the longest stretch of rows (n,) that are true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rows, [False]]).astype(np.int8)))
    begins, ends = edges[::2], edges[1::2] - 1
    longest = int(np.argmax(t[ends] - t[begins]))
    return float(t[begins[longest]]), float(t[ends[longest]])
