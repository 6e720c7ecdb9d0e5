"""What belongs to a run and not to the car: where the zeros of sensors and steering stood that day, and the antenna.

A gyroscope's bias found on one run says nothing of the next. Thrown out because it loses there, it leaves a fit that
takes the first run's sensors for perfect; and the next run's own zeros count against a model that is right.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values, experiment_set
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Stop, fit
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_part import cut_log
from vehicle.model.effect_catalogue import catalogue

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

SHARE = 0.3  # of a held-out run, its beginning, that its set-up is taken from
_FEWEST = 200  # rows on either side
_SHOWS = 1e-3  # of chi^2, that a value must be worth to be taken from so little


@dataclasses.dataclass(frozen=True, slots=True)
class RunSetup:
    """The beginning of a run, and what is fitted to it anew, whatever other runs say.

    zeros: the effects of `coordinates` that are zeros; where a sensor is mounted is asked only if another run has it.
    """

    first: ExperimentSet
    coordinates: tuple[Coordinate, ...]
    zeros: frozenset[str]

    def less(self, name: str) -> RunSetup:
        """The same without an effect that even of the run itself says nothing."""
        return dataclasses.replace(self, coordinates=tuple(c for c in self.coordinates if c.effect != name))

    def fitted(self, values: Values, *, without: str = "") -> dict[tuple[str, str], float]:
        """The values with the set-up as the run itself has it; `without` is an effect that is not to be there."""
        names = {c.effect for c in self.coordinates}
        kept = {key: value for key, value in values.items() if key[0] not in names}
        found = {name for name, _ in values}
        asked = found | self.zeros
        mine = [c for c in self.coordinates if c.effect != without and c.effect in asked]
        best = fit(
            self.first,
            mine,
            {c.name: c.key.neutral for c in mine},
            fixed=kept,
            stop=Stop(enough=2e-4 * self.first.count),
        )
        for name in dict.fromkeys(c.effect for c in mine):
            less = [c for c in best.coordinates if c.effect != name]
            other = fit(self.first, less, best.values, fixed=kept, stop=Stop(enough=2e-4 * self.first.count))
            if other.chi2 - best.chi2 < _SHOWS * max(best.chi2, self.first.count):
                best = other
        return kept | best.values


def end_of_beginning(log: Log) -> float:
    """Stamp [s] at which the part of a run ends that its set-up is taken from."""
    return float(log.t[0] + SHARE * (log.t[-1] - log.t[0]))


def split_setup(
    logs: Mapping[str, Log], model: VehicleModel, effects: tuple[Effect, ...] = ()
) -> list[tuple[RunSetup, ExperimentSet]]:
    """Of each log its beginning, for its set-up, and the rest, which judges; without logs too short to be parted."""
    known = [e for e in catalogue().values() if e.diagnosed.run_setup]
    zeros = frozenset(e.name for e in known if e.diagnosed.run_setup == "zero")
    coordinates = tuple(c for one in candidates(model, known) for c in one.coordinates)
    found = []
    for name, log in logs.items():
        border = end_of_beginning(log)
        rows = int(np.searchsorted(log.t, border))
        if rows < _FEWEST or len(log.t) - rows < _FEWEST:
            continue
        first = experiment_set({name: cut_log(log, -np.inf, border)}, model, extra=effects)
        rest = experiment_set({name: cut_log(log, border, np.inf)}, model, extra=effects)
        found.append((RunSetup(first, coordinates, zeros), rest))
    return found
