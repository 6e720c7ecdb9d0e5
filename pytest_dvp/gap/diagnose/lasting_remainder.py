"""The known remainder as what it is: an error that lasts, not noise that is drawn anew for each sample.

A twin that brakes a little late is off by the same amount for half a second. Counted as noise, such an error says the
same thing fifty times, and a position that drifts for five seconds outweighs a yaw rate that knows better. So values
are estimated once more with residuals of which is taken what the remainder repeats: the innovations of a Kalman filter
whose state is the remainder of a channel (first-order Markov, as strong as the driving regime has it) and whose
measurement noise is the sensor's. This is generalised least squares.

Source: A. C. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, sec. 3.4 (prediction error
decomposition); A. C. Aitken, Proc. R. Soc. Edinburgh 55 (1935) 42 (generalised least squares).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from machine_code import compiled
from pytest_dvp.gap.compare.coloured_noise import BoolArray, Whitening
from pytest_dvp.gap.compare.segments import CHANNELS, filled
from pytest_dvp.gap.compare.start_correction import IntArray
from pytest_dvp.gap.diagnose.dead_reckoning import beside_dead_reckoning, wandering_innovations
from pytest_dvp.gap.diagnose.known_remainder import by_row, regimes_of
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.remainder import Remainder
from vehicle.model.remainder_shape import WANDERING, RemainderShape

MEMORY = {"x": 1.0, "y": 1.0, "yaw": 1.0, "v": 1.0}  # s, of a model file that does not tell it: three cars in MuJoCo
OTHER_MEMORY = 0.3  # s, showed 0.7 to 1.7 of these and 0.1 to 0.6 of yaw rate and accelerations
LONGEST = 250  # samples to which a correlation is followed: 5 s at 50 Hz, a segment
_DIGITS = 3  # significant: a tenth of a per cent, where another drive differs by tens of them


class LastingRemainder:
    """Residuals of one log freed of what the known remainder repeats.

    noise (8,) of each channel in its unit, inf where it is not judged; coloured: how the noise itself repeats; begins
    (n,): rows without a neighbour before them
    """

    def __init__(self, log: Log, measured: FloatArray, remainder: Remainder, shape: RemainderShape, noise: FloatArray,
                 coloured: Whitening, begins: BoolArray) -> None:  # fmt: skip
        self._noise, self._begins = noise, begins
        self._coloured = coloured.scaled(np.where(np.isfinite(noise), 1.0, np.inf))
        step = float(np.median(np.diff(log.t)))
        memory = np.array([shape.memory.get(c, MEMORY.get(c, OTHER_MEMORY)) for c in CHANNELS])
        self._kept = np.exp(-step / memory)
        masks = regimes_of(log, measured)
        passed = np.sqrt(coloured.independent)  # a filter that whitens the noise passes less of the rest
        self._levels = passed * by_row(remainder, CHANNELS, masks)
        self._t, self._motion = log.t, filled(log.t, measured)
        self._steps: FloatArray | None = None
        if shape.wanders and np.isfinite(measured[:, 2]).any():
            self._steps = passed[:3] * by_row(shape.wanders, tuple(WANDERING), masks)

    def freed(self, rest: FloatArray, *, reckoned: bool = False) -> FloatArray:
        """Residuals (n, 8) in the channels' units as (n * 8,) in units of what could not be foreseen of them; reckoned:
        positions and heading beside dead reckoning, if the model file says how that wanders."""
        steps = self._steps if reckoned else None
        if steps is not None:
            rest = beside_dead_reckoning(rest, self._motion, self._t, self._begins)
        plain = self._coloured.of(rest, self._begins).reshape(rest.shape)
        plain[~np.isfinite(rest)] = np.nan
        found = _innovations(plain, self._noise, self._levels, self._kept, self._begins)
        if steps is not None:
            heading = np.ascontiguousarray(self._motion[:, 2])
            wandering_innovations(plain, self._noise, steps, heading, self._t, self._begins, found)
        return found


@compiled
def _innovations(
    rest: FloatArray, noise: FloatArray, levels: FloatArray, kept: FloatArray, begins: BoolArray
) -> FloatArray:
    n, m = rest.shape
    out = np.zeros(n * m)
    for k in range(m):
        if not (np.isfinite(noise[k]) and noise[k] > 0.0):
            continue
        mean, unsure = 0.0, levels[0, k] ** 2
        for i in range(n):
            level = levels[i, k] ** 2
            if begins[i]:
                mean, unsure = 0.0, level
            else:
                mean *= kept[k]
                unsure = kept[k] ** 2 * unsure + (1.0 - kept[k] ** 2) * level
            if not np.isfinite(rest[i, k]):
                continue
            spread = noise[k] ** 2 + unsure
            news = rest[i, k] - mean
            out[i * m + k] = news / np.sqrt(spread)
            share = unsure / spread
            mean += share * news
            unsure *= 1.0 - share
    return out


def measured_memory(parts: Iterable[tuple[FloatArray, FloatArray, IntArray]], remainder: Remainder) -> dict[str, float]:
    """Time [s] by channel of `remainder` after which its correlation has fallen to 1/e, the longest of the logs.

    parts: stamps (n,) [s], residuals (n, 8), and where the segments begin (m,), of each log.
    """
    found: dict[str, float] = {}
    for t, rest, starts in parts:
        step = float(np.median(np.diff(t)))
        for name in remainder:
            lags = _fallen(rest[:, CHANNELS.index(name)], starts)
            if lags:
                found[name] = max(found.get(name, 0.0), as_measured(lags * step))
    return {name: found[name] for name in CHANNELS if name in found}


def _fallen(rest: FloatArray, starts: IntArray) -> int:
    """Samples after which the correlation has fallen to 1/e of that of neighbours, in which the noise has no part; 0
    if there is none."""
    products, pairs = np.zeros(LONGEST), np.zeros(LONGEST)
    for piece in np.split(np.nan_to_num(rest), starts[1:]):
        most = min(LONGEST, len(piece))
        if most:
            full = np.correlate(piece, piece, "full")[len(piece) - 1 :]
            products[:most] += full[:most]
            pairs[:most] += len(piece) - np.arange(most)
    mean = products / np.maximum(pairs, 1.0)
    if mean[1] <= 0.0:
        return 0
    below = np.flatnonzero(mean[1:] < mean[1] / np.e)
    return int(below[0]) + 1 if len(below) else LONGEST


def rounded_imitation(found: Mapping[tuple[str, str], Sequence[float]]) -> dict[str, dict[str, float]]:
    """Root mean squares of what was found, effect -> key -> value."""
    result: dict[str, dict[str, float]] = {}
    for (effect, key), values in found.items():
        square = float(np.mean(np.square(values)))
        result.setdefault(effect, {})[key] = as_measured(np.sqrt(square))
    return result


def as_measured(value: float) -> float:
    """As a model file has what was measured on drives."""
    return float(f"{value:.{_DIGITS}g}")
