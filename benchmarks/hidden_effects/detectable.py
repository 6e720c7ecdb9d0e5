"""Whether a hidden effect can be seen at all, told by the truth alone.

The truth car without the effect gets the commands that the car with it was given, and starts anew every 5 s in the
motion of that car. What then differs, start pose and speed taken out, in units of the noise, is what chi^2/N could
gain by naming the effect. Nothing of the kernel or the diagnosis takes part.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tests.truth.car import D_LAG, D_RATE, D_RES, D_STICK, FF, FINE, FR, N_STATE, PERIOD, SUBSTEPS, VY, H, V, advance
from tests.truth.effects import C_CF, C_CR, C_DYNAMIC, PLANT, Effects, FloatArray, TruthCar, parameters
from tests.truth.effects import checked as complete
from tests.truth.generate import FACTOR, SIGMA, fine_truth, sensed
from vehicle.surrogate.driver import Drive

SEGMENT = 250  # rows, 5 s
LEAST_GAIN = 0.05
"""Gain in chi^2/N that makes a case count: the least that the diagnosis may accept, at a noise floor of 1."""
SLOWEST = 1.5  # m/s, mean speed of a drive that still is one
# effects of tyres that slip; the car without them has the same tyres
SOFT_TYRES = frozenset({"tyre_relaxation", "load_transfer", "yaw_inertia"})


def body(names: Iterable[str]) -> str:
    """Body of the truth car that hides these: "dynamic" where the baseline, too, has to have tyres."""
    return "dynamic" if SOFT_TYRES & set(names) else "auto"


def drives(effects: Effects, drive: Drive, seed: int) -> bool:
    """Whether the car with these effects still gets around: half the range of some drags stops it."""
    _, fine = fine_truth(effects, drive, seed, body=body(effects))
    return bool(np.all(np.isfinite(fine))) and float(np.mean(fine[:, V])) > SLOWEST


def gain(effects: Effects, name: str, drives_seen: Iterable[Drive], seed: int, noise: str) -> float:
    """Gain in chi^2/N over all channels and drives that `name` brings beside the other effects."""
    if name == "speed_controller":  # without it there is nothing that a commanded speed would do
        return np.inf
    total = count = 0.0
    for drive in drives_seen:
        kind = body(effects)
        commands, fine = fine_truth(effects, drive, seed, body=kind)
        others = {n: values for n, values in effects.items() if n != name}
        shown = sensed(fine, effects)
        without = sensed(driven(others, commands, fine, kind), others)
        sigma = np.array([SIGMA[c] * FACTOR[noise] for c in SIGMA])
        difference = np.column_stack([shown[c] - without[c] for c in SIGMA]) / sigma
        for begin in range(0, len(difference), SEGMENT):
            rows = slice(begin, begin + SEGMENT)
            d = difference[rows].ravel()
            basis = starts({c: values[rows] for c, values in without.items()}, sigma)
            left = d - basis @ np.linalg.lstsq(basis, d, rcond=None)[0]
            total += float(left @ left)
        count += difference.size
    return total / count


def driven(effects: Effects, commands: FloatArray, like: FloatArray, kind: str) -> FloatArray:
    """Fine motion of a car with these effects on the given commands, set to the motion `like` every SEGMENT rows."""
    car = TruthCar()
    p = parameters(car, complete({name: values for name, values in effects.items() if name in PLANT}))
    if kind == "dynamic":
        p[C_DYNAMIC] = 1.0
        if "understeer" not in effects:
            p[C_CF], p[C_CR] = car.stiffness_front, car.stiffness_rear
    rear = car.wheelbase - car.cg_to_front_axle
    fine = np.empty_like(like)
    s = np.zeros(N_STATE)
    for place in (D_LAG, D_RATE, D_STICK, D_RES):
        s[place] = commands[0, 1]
    for k in range(len(commands)):
        now = k * SUBSTEPS
        if k % SEGMENT == 0:
            x, y, yaw, v, r = like[now, :5]
            s[:4] = x, y, yaw, v
            step = (like[now + 1, :2] - like[now, :2]) / H
            middle = 0.5 * (yaw + like[now + 1, 2])
            s[VY] = np.cos(middle) * step[1] - np.sin(middle) * step[0] + rear * r
            s[VY + 1] = r
            s[FF], s[FR] = (part * car.mass / car.wheelbase * r * v for part in (rear, car.cg_to_front_axle))
        advance(s, p, commands, k, fine[now : now + SUBSTEPS])
    return fine


def starts(columns: dict[str, FloatArray], sigma: FloatArray) -> FloatArray:
    """What a segment's start would change (rows x channels, 4), in units of the noise: x, y, heading, speed."""
    channels = list(SIGMA)
    n = len(columns["x"])
    basis = np.zeros((n, len(channels), 4))
    x, y, yaw, v, r = (columns[c] for c in FINE[:5])
    turned = r / np.maximum(v, 1.0)
    heading = (np.cumsum(turned) - turned) * PERIOD
    along, across = np.cos(yaw) - v * np.sin(yaw) * heading, np.sin(yaw) + v * np.cos(yaw) * heading
    at = {c: k for k, c in enumerate(channels)}
    basis[:, at["x"], 0] = basis[:, at["y"], 1] = 1.0
    basis[:, at["yaw"], 2] = 1.0
    basis[:, at["x"], 2], basis[:, at["y"], 2] = -(y - y[0]), x - x[0]
    basis[:, at["v"], 3] = 1.0
    basis[:, at["x"], 3] = (np.cumsum(along) - along) * PERIOD
    basis[:, at["y"], 3] = (np.cumsum(across) - across) * PERIOD
    basis[:, at["yaw"], 3], basis[:, at["yaw_rate"], 3], basis[:, at["ay"], 3] = heading, turned, 2.0 * r
    return (basis / sigma[:, None]).reshape(n * len(channels), 4)
