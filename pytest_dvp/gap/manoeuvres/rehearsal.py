"""A manoeuvre tried on paper: what a log of it would hold if one effect were the truth, and how near another comes."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.experiment import Experiment, ExperimentSet, Values
from pytest_dvp.gap.diagnose.least_squares import STEP, Coordinate, Stop, fit
from pytest_dvp.gap.manoeuvres.simulated_drive import Drive, columns
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

NOISE: Mapping[str, float] = {
    "x": 0.02, "y": 0.02, "yaw": 0.005, "v": 0.03, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1,
}  # fmt: skip
"""Standard deviations [m, rad, m/s, rad/s, m/s^2] of a usual set of sensors, where no log tells those of the car."""


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Hypothesis:
    """An effect that may be the truth, with its values (effect, key) -> value."""

    candidate: Candidate
    values: Mapping[tuple[str, str], float]

    @property
    def name(self) -> str:
        """Name of the effect."""
        return self.candidate.name


class Rehearsal:
    """The log of a drive with these values as the truth, without noise: residuals are what other values change.

    noise: standard deviation of each channel that will be measured, in its unit; `shared`: values that are sure.
    """

    def __init__(self, drive: Drive, model: VehicleModel, truth: Values, noise: Mapping[str, float], *,
                 shared: Values | None = None, extra: Sequence[Effect] = ()) -> None:  # fmt: skip
        from vehicle.model.open_loop import Replay

        self.drive, self.shared = drive, dict(shared or {})
        commands = columns(drive, model.inputs)
        replay = Replay(model, drive.t, {name: c for name, c in commands.items() if name != "t"}, extra=extra)
        shown = replay.run(self.shared | dict(truth))
        measured = {name: shown[:, k] for k, name in enumerate(CHANNELS) if name in noise and name not in commands}
        self.experiment = Experiment(drive.manoeuvre.name, Log({**commands, **measured}), model, extra=extra)
        known = [noise.get(name, np.inf) if name in self.experiment.channels else np.inf for name in CHANNELS]
        self.experiment.sigma = np.array(known)
        self.experiment.settle(self.shared | dict(truth))
        self.count = max(self.experiment.count, 1)
        # not quite nothing: a signal that is shown late knows nothing of the time before a segment begins
        self._of_truth = self.experiment.whitened(self.shared | dict(truth))

    def whitened(self, values: Values) -> FloatArray:
        """What these values change (N,) of the truth's residuals, in units of the noise."""
        return self.experiment.whitened(self.shared | dict(values)) - self._of_truth

    def tangent(self, hypothesis: Hypothesis, at: FloatArray) -> FloatArray:
        """Change (N, p) of the residuals with each parameter of an effect, in noise units, by finite differences.

        at (N,): the whitened residuals with the values of the hypothesis.
        """
        found = []
        for c in hypothesis.candidate.coordinates:
            u = c.to_unit(hypothesis.values[c.name])
            moved = dict(hypothesis.values) | {c.name: c.value(u + (4.0 * STEP if u < 0.5 else -4.0 * STEP))}
            found.append(self.whitened(moved) - at)
        return np.column_stack(found)

    def refitted(self, other: Hypothesis) -> float:
        """chi^2 that another effect is left with at its best, fitted to this log, beyond that of the truth."""
        target = ExperimentSet((self.experiment,))
        starts = [dict(other.values), *other.candidate.points]
        begin = min(starts, key=lambda point: _chi2(self.whitened(point)))
        stop = Stop(rounds=6, enough=1e-3 * self.count)
        found = fit(target, other.candidate.coordinates, begin, fixed=self.shared, stop=stop)
        return max(found.chi2 - _chi2(self._of_truth), 0.0)

    def channels(self, values: Values) -> dict[str, float]:
        """Share of each channel in what these values would leave."""
        r = self.whitened(values).reshape(-1, len(CHANNELS))
        sums = np.sum(r * r, axis=0)
        whole = max(float(sums.sum()), 1e-300)
        return {name: float(sums[k]) / whole for k, name in enumerate(CHANNELS) if name in self.experiment.channels}

    def largest(self, values: Values, channel: str) -> tuple[float, float]:
        """Time [s] at which these values differ most from the truth in a channel, and by how much, in its unit."""
        k = CHANNELS.index(channel)
        r = self.whitened(values).reshape(-1, len(CHANNELS))[:, k]
        row = int(np.argmax(np.abs(r)))
        return float(self.drive.t[row]), float(r[row] * self.experiment.sigma[k])


def separable_chi2(r: FloatArray, tangent: FloatArray) -> float:
    """Sum of squares of r (N,), in units of the noise, that its owner's parameters cannot take away, to first order.

    tangent (N, p): how r changes with each of these parameters.
    """
    solution = np.linalg.lstsq(tangent.T @ tangent + 1e-9 * np.eye(tangent.shape[1]), tangent.T @ r, rcond=None)[0]
    return _chi2(r - tangent @ solution)


def closest_values(rehearsal: Rehearsal, candidate: Candidate) -> dict[tuple[str, str], float]:
    """The values with which an effect comes nearest to the truth of a rehearsal."""
    begin = min(candidate.points, key=lambda point: _chi2(rehearsal.whitened(point)))
    found = fit(ExperimentSet((rehearsal.experiment,)), candidate.coordinates, begin, fixed=rehearsal.shared)
    return found.values


def typical(coordinates: Sequence[Coordinate], points: Sequence[Mapping[tuple[str, str], float]]
            ) -> dict[tuple[str, str], float]:  # fmt: skip
    """Values of an effect of which nothing is known: those in the middle of its range."""
    return dict(points[len(points) // 2]) if points else {c.name: c.value(0.5) for c in coordinates}


def _chi2(r: FloatArray) -> float:
    return float(r @ r)
