"""Sensors against sensors: what is left of positions and headings beside what the car's own speed and yaw rate say.

A model that drives a little too fast is wrong in speed and, in the same way, in position; a speed sensor that shows two
per cent too much is wrong in speed alone. So of an error in position is taken what the errors in speed and heading make
of it, and of one in heading what the error in yaw rate makes of it: dead reckoning. What remains has no part in the
forces that a model lacks. It is small whatever the model is, so what a sensor does stands out in it. It wanders, as a
sum of small errors does: a random walk, of which a step of one second is measured.

Source: A. C. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, sec. 2.3 (random walk plus
noise) and 3.4 (prediction error decomposition).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from machine_code import compiled
from pytest_dvp.gap.compare.coloured_noise import BoolArray
from pytest_dvp.gap.diagnose.known_remainder import FEWEST, largest
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.remainder import Remainder
from vehicle.model.remainder_shape import WANDERING

STEP = 1.0  # s, of the step that is measured
_LEAST = 0.05  # of the noise, the smallest step that is told: with none, a filter takes a walk for a constant
_DIGITS = 3  # significant: it is known to some per cent
_UNKNOWN = 1e4  # m^2, rad^2: where a stretch begins is free


class Reckoned(NamedTuple):
    """One log: stamps t (n,) [s], heading (n,) [rad] without gaps (NaN: not measured), what is left (n, 8) beside dead
    reckoning and the noise (8,) in the channels' units (inf: not judged), rows (n,) with which a stretch begins, and
    the masks (n,) of the driving regimes."""

    t: FloatArray
    heading: FloatArray
    rest: FloatArray
    noise: FloatArray
    begins: BoolArray
    regimes: Mapping[str, BoolArray]


@compiled
def beside_dead_reckoning(rest: FloatArray, motion: FloatArray, t: FloatArray, begins: BoolArray) -> FloatArray:
    """Residuals (n, 8) in the channels' units: x, y and yaw without what those of speed, heading and yaw rate have made
    of them since the stretch began, the other channels as they are.

    motion (n, 8): as measured, without gaps; t (n,) [s]; begins (n,): rows with which a stretch begins. To first order
    in the errors. Where a residual is not known, the last one holds.
    """
    out = rest.copy()
    x, y, yaw = 0.0, 0.0, 0.0
    x_rate, y_rate, yaw_rate = 0.0, 0.0, 0.0
    faster, turned, rate = 0.0, 0.0, 0.0
    for i in range(rest.shape[0]):
        if begins[i]:
            x, y, yaw, faster, turned, rate = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if np.isfinite(rest[i, 3]):
            faster = rest[i, 3]
        if np.isfinite(rest[i, 2]):
            turned = rest[i, 2]
        if np.isfinite(rest[i, 4]):
            rate = rest[i, 4]
        c, s, v = np.cos(motion[i, 2]), np.sin(motion[i, 2]), motion[i, 3]
        x_now, y_now = c * faster - s * v * turned, s * faster + c * v * turned
        if i > 0 and not begins[i]:
            half = 0.5 * (t[i] - t[i - 1])
            x += half * (x_rate + x_now)
            y += half * (y_rate + y_now)
            yaw += half * (yaw_rate + rate)
        x_rate, y_rate, yaw_rate = x_now, y_now, rate
        out[i, 0] -= x
        out[i, 1] -= y
        out[i, 2] -= yaw
    return out


def measured_steps(groups: Iterable[Sequence[Reckoned]]) -> Remainder:
    """Root mean square step in STEP beyond the noise, by what wanders (`WANDERING`) and driving regime, [m] or [rad];
    the largest that one of the groups of logs shows (those fitted on, those held out)."""
    return largest(map(_of_group, groups), WANDERING)


def _of_group(group: Sequence[Reckoned]) -> dict[tuple[str, str], float]:
    sums: dict[tuple[str, str], list[float]] = {}
    for log in group:
        apart = max(1, round(STEP / float(np.median(np.diff(log.t)))))
        if len(log.t) <= apart:
            continue
        stretch = np.cumsum(log.begins)
        middle = np.arange(len(log.t) - apart) + apart // 2
        change = log.rest[apart:] - log.rest[:-apart]
        c, s = np.cos(log.heading[middle]), np.sin(log.heading[middle])
        place = 0.5 * (log.noise[0] ** 2 + log.noise[1] ** 2)
        steps = {
            "along": (c * change[:, 0] + s * change[:, 1], place),
            "across": (c * change[:, 1] - s * change[:, 0], place),
            "yaw": (change[:, 2], log.noise[2] ** 2),
        }
        for name, (values, noise) in steps.items():
            known = (stretch[apart:] == stretch[:-apart]) & np.isfinite(values)
            for regime, mask in log.regimes.items() if np.isfinite(noise) else ():
                inside = values[known & mask[middle]]
                entry = sums.setdefault((name, regime), [0.0, 0.0, 0.0])
                entry[0] += float(inside @ inside)
                entry[1] += noise * len(inside)
                entry[2] += len(inside)
    found = {}
    for key, (square, noise, count) in sums.items():
        if count >= FEWEST:
            left = max(square - 2.0 * noise, _LEAST**2 * noise) / count  # both ends of a step have noise
            found[key] = float(f"{np.sqrt(left):.{_DIGITS}g}")
    return found


@compiled
def wandering_innovations(
    rest: FloatArray, noise: FloatArray, steps: FloatArray, heading: FloatArray, t: FloatArray, begins: BoolArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Fill x, y and yaw of out (n * 8,) with what a Kalman filter could not foresee of a walk, in units of its spread;
    0 where nothing was compared.

    rest (n, 8) beside dead reckoning and noise (8,) in the channels' units; steps (n, 3) of one second along and across
    the car [m] and of the heading [rad]; heading (n,) [rad]; t (n,) [s]; begins (n,): where the walk is not known.
    """
    n, m = rest.shape
    place = np.isfinite(noise[0]) and np.isfinite(noise[1])
    turn = np.isfinite(noise[2])
    x, y, xx, xy, yy = 0.0, 0.0, _UNKNOWN, 0.0, _UNKNOWN
    yaw, unsure = 0.0, _UNKNOWN
    for i in range(n):
        for k in range(3):
            out[i * m + k] = 0.0
        if begins[i]:
            x, y, xx, xy, yy = 0.0, 0.0, _UNKNOWN, 0.0, _UNKNOWN
            yaw, unsure = 0.0, _UNKNOWN
        elif i > 0:
            gap = t[i] - t[i - 1]
            c, s = np.cos(heading[i]), np.sin(heading[i])
            along, across = steps[i, 0] ** 2 * gap, steps[i, 1] ** 2 * gap
            xx += c * c * along + s * s * across
            xy += c * s * (along - across)
            yy += s * s * along + c * c * across
            unsure += steps[i, 2] ** 2 * gap
        if place and np.isfinite(rest[i, 0]) and np.isfinite(rest[i, 1]):
            p, q = rest[i, 0] - x, rest[i, 1] - y
            u, w = xx + noise[0] ** 2, yy + noise[1] ** 2
            slope = xy / u
            out[i * m] = p / np.sqrt(u)
            out[i * m + 1] = (q - slope * p) / np.sqrt(w - slope * xy)
            det = u * w - xy * xy
            x_p, x_q = (xx * w - xy * xy) / det, (xy * u - xx * xy) / det
            y_p, y_q = (xy * w - yy * xy) / det, (yy * u - xy * xy) / det
            x += x_p * p + x_q * q
            y += y_p * p + y_q * q
            xx, xy, yy = (1.0 - x_p) * xx - x_q * xy, (1.0 - x_p) * xy - x_q * yy, (1.0 - y_q) * yy - y_p * xy
        if turn and np.isfinite(rest[i, 2]):
            spread = noise[2] ** 2 + unsure
            news = rest[i, 2] - yaw
            out[i * m + 2] = news / np.sqrt(spread)
            share = unsure / spread
            yaw += share * news
            unsure *= 1.0 - share
