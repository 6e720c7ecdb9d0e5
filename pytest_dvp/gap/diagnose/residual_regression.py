"""How much of an error terms explain, on the segments they are fitted on and on segments left out.

A term stands for an acceleration or a road-wheel angle. A channel that shows it directly (ax, yaw_rate) is regressed
on the term, one that sums it up (v, yaw) on its integral with a free start in each segment: noise stays white.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from machine_code import compiled
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.compare.smoothed_motion import Motion
from pytest_dvp.gap.diagnose.experiment import Experiment, ExperimentSet
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.residual_terms import Axis, Term
from pytest_dvp.logs.log_contents import FloatArray

_FOLDS = 5  # of cross-validation, as in equation_error.py
LEAST_EXCESS = 0.02  # of the noise: shares of less are shares of chance; chosen
_RIDGE = 1e-6  # of the scaled normal equations: keeps equal columns solvable, and changes no value that shows
_DIRECT = {"longitudinal": "ax", "lateral": "yaw_rate"}
_SUMMED = {"longitudinal": "v", "lateral": "yaw"}


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class TermSums:
    """Normal equations a (k, p, p), b (k, p) of k folds of segments; chi2, count (m,) of each segment; places: columns
    of each term."""

    a: FloatArray
    b: FloatArray
    chi2: FloatArray
    count: FloatArray
    places: tuple[slice, ...]

    @property
    def excess(self) -> float:
        """chi^2 beyond that of noise."""
        return max(float(self.chi2.sum() - self.count.sum()), 1e-9)

    def fitted(self, chosen: Sequence[int]) -> tuple[float, FloatArray]:
        """Share of the excess that the chosen terms explain together, and their coefficients (p,).

        A coefficient is in the unit of the residual divided by that of its column.
        """
        own = self._columns(chosen)
        a, b = self.a.sum(axis=0)[np.ix_(own, own)], self.b.sum(axis=0)[own]
        theta = _solved(a, b)
        return _gain(a, b, theta) / self.excess, theta

    def held_out(self, chosen: Sequence[int]) -> float:
        """Share of the excess that terms explain on segments that they were not fitted on; may be negative, and is 0
        where next to nothing is in excess."""
        if self.excess < LEAST_EXCESS * float(self.count.sum()):
            return 0.0
        own = self._columns(chosen)
        a, b = self.a[:, own][:, :, own], self.b[:, own]
        whole_a, whole_b = a.sum(axis=0), b.sum(axis=0)
        gain = sum(_gain(x, y, _solved(whole_a - x, whole_b - y)) for x, y in zip(a, b, strict=True))
        return gain / self.excess

    def left(self, share: float) -> float:
        """chi^2/N when this share of the excess is explained."""
        return float(self.chi2.sum() - share * self.excess) / max(float(self.count.sum()), 1.0)

    def _columns(self, chosen: Sequence[int]) -> list[int]:
        return [k for term in chosen for k in range(self.places[term].start, self.places[term].stop)]


def term_sums(axis: Axis, target: ExperimentSet, rest: Sequence[FloatArray], motions: Sequence[Motion],
              tried: Sequence[Sequence[Term]]) -> TermSums:  # fmt: skip
    """Sums for residuals `rest` (n, 8) in channel units, motion and terms of each experiment of a campaign."""
    size = sum(t.columns.shape[1] for t in tried[0])
    a, b = np.zeros((_FOLDS, size, size)), np.zeros((_FOLDS, size))
    chi2: list[float] = []
    count: list[float] = []
    for e, r, m, own in zip(target.experiments, rest, motions, tried, strict=True):
        rows = list(_rows(axis, e, r, m, np.concatenate([t.columns for t in own], axis=1)))
        for first, end in zip(e.segments.starts, e.segments.ends, strict=True):
            fold, chi2_here, count_here = len(chi2) % _FOLDS, 0.0, 0
            for y, x, free_start in rows:
                known = np.isfinite(y[first:end])
                yy, xx = y[first:end][known], x[first:end][known]
                if free_start and len(yy):
                    yy, xx = yy - yy.mean(), xx - xx.mean(axis=0)
                _add(a[fold], b[fold], np.ascontiguousarray(xx), yy)
                chi2_here += square(yy)
                count_here += len(yy)
            chi2.append(chi2_here)
            count.append(count_here)
    ends = np.cumsum([t.columns.shape[1] for t in tried[0]])
    places = tuple(slice(int(end) - t.columns.shape[1], int(end)) for end, t in zip(ends, tried[0], strict=True))
    return TermSums(a, b, np.array(chi2), np.array(count), places)


def _rows(axis: Axis, e: Experiment, rest: FloatArray, m: Motion,
          phi: FloatArray) -> Iterator[tuple[FloatArray, FloatArray, bool]]:  # fmt: skip
    """Of each channel its whitened residual (n,), what the terms phi (n, p) do to it, and whether its start is free."""
    if axis == "lateral":  # small angles: r = v d/L
        phi = phi * (m.v / m.wheelbase)[:, None]
    if (name := _DIRECT[axis]) in e.channels:
        k = CHANNELS.index(name)
        yield rest[:, k] / e.sigma[k], phi / e.sigma[k], False
    if (name := _SUMMED[axis]) in e.channels:
        k = CHANNELS.index(name)
        integral = np.cumsum(phi * np.append(np.diff(m.t), 0.0)[:, None], axis=0)
        yield rest[:, k] / e.sigma[k], integral / e.sigma[k], True


@compiled
def _add(a: FloatArray, b: FloatArray, x: FloatArray, y: FloatArray) -> None:
    """a (p, p) += x'x, b (p,) += x'y, for x (n, p); in one thread, see `algebra`."""
    n, p = x.shape
    for i in range(n):
        for j in range(p):
            b[j] += x[i, j] * y[i]
            factor = x[i, j]
            if factor != 0.0:
                for k in range(p):
                    a[j, k] += factor * x[i, k]


def _solved(a: FloatArray, b: FloatArray) -> FloatArray:
    scale = np.sqrt(np.maximum(np.diag(a), 1e-30))
    return np.asarray(np.linalg.solve(a / np.outer(scale, scale) + _RIDGE * np.eye(len(b)), b / scale) / scale)


def _gain(a: FloatArray, b: FloatArray, theta: FloatArray) -> float:
    return float(2.0 * theta @ b - theta @ a @ theta)
