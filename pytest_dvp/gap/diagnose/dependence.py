"""Whether a value that was fitted as a constant changes while driving: with time, energy, speed, acceleration, place.

A brake that fades looks like a brake that is a little weak, and whoever installs that constant has a wrong twin on the
next hill. The residual and its derivative say, second by second, how far the value would have to move; that is related
to what changed meanwhile.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from pytest_dvp.gap.compare.segments import CHANNELS, filled
from pytest_dvp.gap.compare.start_correction import IntArray
from pytest_dvp.gap.diagnose.candidates import says_how
from pytest_dvp.gap.diagnose.experiment import Experiment, ExperimentSet
from pytest_dvp.gap.diagnose.least_squares import Coordinate
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect import Effect

Quantity: TypeAlias = Literal["time", "brake_energy", "motor_energy", "speed", "acceleration", "place"]
QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)

WORTH = 0.03  # of max(1, chi^2/N): a dependence that takes away less is none
CERTAIN = 4.0  # standard errors, clustered by segment: six quantities are tried for each of several values
CHANGE = 0.5  # of the least size worth naming: a value that moves by less stays the same
STEADY = 0.15  # of what a value differs from that of the model as it is: one that moves by less is a constant to who
# installs it. Chosen: a drive that gave 0.84 of what it gave before moved by 0.08 and 0.10 of that along a drive, for
# what the twin of a stranger's bus did not know; a brake that fades by a seventh moves by twice its mean loss
PLAIN = 0.15  # of what the best quantity takes away: one before it in the order that does nearly as well is taken
_WINDOW = 1.0  # s
_FEWEST = 12  # windows
_CELLS = 8  # along the longer side of the map
_APART = 4  # segments between two visits of a place that count as two: 20 s
_SHOWS = 1e-6  # of the strongest window's weight, below which a window says nothing


@dataclasses.dataclass(frozen=True, slots=True)
class Dependence:
    """A value of a named effect that changes with `quantity` from `start` to `end` (at its 5 % and 95 % quantiles), in
    the unit of `key`; effect: the effect of the catalogue that has the change, "" if none has."""

    key: str
    quantity: Quantity
    start: float
    end: float
    effect: str = ""

    def as_dict(self) -> dict[str, Any]:
        """The entry `depends_on` of `diagnose --json`."""
        return {"quantity": self.quantity, "from": self.start, "to": self.end, "effect": self.effect or None,
                "key": self.key}  # fmt: skip


class Dependences:
    """How the fitted values of a trial change while driving; effects: those that may be offered for it."""

    def __init__(self, target: ExperimentSet, trial: Trial, effects: Collection[Effect]) -> None:
        self._target, self._trial = target, trial
        self._offered = {seen: e.name for e in effects for seen in e.diagnosed.seen_as}
        had = target.experiments[0].model.effects
        self._had = {(a.name, key): value for a in had for key, value in a.values.items()}
        self._windows, self._segment, self._series = _windows(target)

    def of(self, name: str) -> Dependence | None:
        """How the value of an effect changes; None if it is as good as constant.

        First order in the change. Each value of the trial is taken to be constant but the one that is asked about, so a
        dependence that another missing effect causes may show here, too.
        """
        found: list[tuple[float, Dependence]] = []
        for row, c in enumerate(self._trial.fit.coordinates):
            if c.effect == name and not says_how(c.key) and np.isfinite(c.key.neutral):
                found += self._of_coordinate(row, c)
        if not found:
            return None
        best = max(found, key=lambda entry: entry[0])[1]
        return dataclasses.replace(best, effect=self._offered.get((name, best.quantity), ""))

    def _of_coordinate(self, row: int, c: Coordinate) -> list[tuple[float, Dependence]]:
        """The quantity that takes most off, with chi^2/N that it takes; empty if none does."""
        own = self._trial.fit.jacobian[row]
        weight, slope = _sums(own * own, self._windows), _sums(own * self._trial.fit.residual, self._windows)
        shows = weight > _SHOWS * weight.max(initial=0.0)
        if np.count_nonzero(shows) < _FEWEST:
            return []
        weight, slope, segment = weight[shows], slope[shows], self._segment[shows]
        kept = []
        for quantity in QUANTITIES:
            q = self._series[quantity][shows]
            if quantity == "place":
                by_place = _by_place(q, weight, slope, segment)
                if by_place is None:
                    continue
                q = by_place
            kept += self._line(quantity, c, q, weight, slope, segment)
        if not kept:
            return []
        best = max(gain for gain, _ in kept)  # time and energies run together: the first of those that do alike is said
        return [next(entry for entry in kept if entry[0] >= (1.0 - PLAIN) * best)]

    def _line(
        self, quantity: Quantity, c: Coordinate, q: FloatArray, weight: FloatArray, slope: FloatArray, segment: IntArray
    ) -> list[tuple[float, Dependence]]:
        """The value as a straight line over a quantity (m,), if that is worth it, certain and a change that matters."""
        low, high = _quantile(q, weight, 0.05), _quantile(q, weight, 0.95)
        if not (np.isfinite(q).all() and high > low):
            return []
        middle = float(np.average(q, weights=weight))
        z = (q - middle) / (high - low)
        spread = float(weight @ (z * z))
        mean = -float(slope.sum()) / float(weight.sum())
        rate = -float(z @ (slope + weight * mean)) / spread
        score = z * (slope + weight * (mean + rate * z))
        clustered = np.add.reduceat(score, np.flatnonzero(np.diff(segment, prepend=-1)))
        error = float(np.sqrt(clustered @ clustered)) / spread
        count = max(self._target.count, 1)
        gain = rate * rate * spread / count
        value = self._trial.values[c.name]
        change = rate * c.slope(c.to_unit(value))
        worth = WORTH * max(1.0, self._trial.chi2 / count)
        matters = max(CHANGE * c.key.least, STEADY * abs(value - self._had.get(c.name, c.key.neutral)))
        if gain < worth or abs(rate) < CERTAIN * error or abs(change) < matters:
            return []
        start, end = (value + change * (at - middle) / (high - low) for at in (low, high))
        return [(gain, Dependence(c.key.name, quantity, start, end))]


def _by_place(cell: FloatArray, weight: FloatArray, slope: FloatArray, segment: IntArray) -> FloatArray | None:
    """Each window's own shift as other visits of its cell have it; None if hardly a cell was visited twice."""
    found = np.zeros(len(cell))
    known = np.zeros(len(cell), dtype=np.bool_)
    for one in np.unique(cell):
        own = np.flatnonzero(cell == one)
        apart = np.abs(segment[own][:, None] - segment[own][None, :]) >= _APART
        others, shifts = apart @ weight[own], apart @ slope[own]
        known[own] = others > 0.0
        found[own] = np.where(others > 0.0, -shifts / np.where(others > 0.0, others, 1.0), 0.0)
    return found if 2 * np.count_nonzero(known) > len(cell) else None


def _quantile(q: FloatArray, weight: FloatArray, share: float) -> float:
    order = np.argsort(q, kind="stable")
    total = np.cumsum(weight[order])
    return float(q[order][np.searchsorted(total, share * total[-1])])


def _sums(rows: FloatArray, windows: Sequence[IntArray]) -> FloatArray:
    return np.array([float(rows[first:end].sum()) for first, end in windows])


def _windows(target: ExperimentSet) -> tuple[list[IntArray], IntArray, Mapping[str, FloatArray]]:
    """Windows in the whitened residual as (first, end), the segment of each, and the mean of each quantity in it."""
    windows: list[IntArray] = []
    segment: list[int] = []
    series: dict[str, list[float]] = {name: [] for name in QUANTITIES}
    offset = number = 0
    wholes = [filled(e.log.t, e.measured) for e in target.experiments]
    extent = max(float(np.ptp(np.concatenate([whole[:, k] for whole in wholes]))) for k in (0, 1))
    side = max(extent, 1e-6) / _CELLS
    for e, whole in zip(target.experiments, wholes, strict=True):
        of = _quantities(e, whole, side)
        t = e.log.t
        for first, end in zip(e.segments.starts, e.segments.ends, strict=True):
            count = max(1, round(float(t[end - 1] - t[first]) / _WINDOW))
            cuts = np.linspace(first, end, count + 1).astype(np.int64)
            for a, b in itertools.pairwise(cuts):
                if b > a:
                    windows.append(np.array([a, b]) * len(CHANNELS) + offset)
                    segment.append(number)
                    for name in QUANTITIES:
                        series[name].append(float(of[name][a:b].mean() if name != "place" else of[name][(a + b) // 2]))
            number += 1
        offset += len(t) * len(CHANNELS)
    return windows, np.array(segment), {name: np.array(values) for name, values in series.items()}


def _quantities(e: Experiment, whole: FloatArray, side: float) -> dict[str, FloatArray]:
    """What may change a value, at the stamps of a log: energies in J/kg since its start, the cell of the map, whose
    `side` [m] is that of all logs. whole: see `filled`."""
    t = e.log.t
    v = np.abs(whole[:, 3])
    half = max(1, round(0.25 / float(np.median(np.diff(t)))))
    kernel = np.full(2 * half + 1, 1.0 / (2 * half + 1))
    smooth = np.convolve(np.pad(v, half, mode="edge"), kernel, "valid")
    accel = np.gradient(smooth, t)
    step = np.diff(t, prepend=t[0])
    column, line = np.floor(whole[:, 0] / side), np.floor(whole[:, 1] / side)
    return {
        "time": t - t[0],
        "brake_energy": np.cumsum(np.maximum(-accel, 0.0) * smooth * step),
        "motor_energy": np.cumsum(np.maximum(accel, 0.0) * smooth * step),
        "speed": smooth,
        "acceleration": accel,
        "place": column + 1000.0 * line,
    }
