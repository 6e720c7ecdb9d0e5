"""Data that judge a fit and were not fitted on: given, else each log from the others, else the end of a single one."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.log import Log
from pytest_dvp.logs.cut import cut_log
from pytest_dvp.reality_gap.experiment import Campaign, campaign

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.model import VehicleModel

HELD_OUT_SHARE = 0.4  # of a single log, its end
_FEWEST = 200  # rows on either side


@dataclasses.dataclass(frozen=True, slots=True)
class Fold:
    """What is fitted on (None: all the logs that are fitted on anyway) and what judges the fit."""

    fitted: Campaign | None
    judge: Campaign


def folds(logs: Mapping[str, Log], held_out: Mapping[str, Log] | None, model: VehicleModel,
          effects: Sequence[Effect] = ()) -> tuple[Fold, ...]:  # fmt: skip
    """How a fit on `logs` is judged; empty if a single log is too short to be parted."""

    def on(chosen: Mapping[str, Log]) -> Campaign:
        return campaign(chosen, model, extra=effects)

    if held_out:
        return (Fold(None, on(held_out)),)
    if len(logs) > 1:
        return tuple(
            Fold(on({n: log for n, log in logs.items() if n != name}), on({name: logs[name]})) for name in logs
        )
    ((name, log),) = logs.items()
    border = log.t[0] + (1.0 - HELD_OUT_SHARE) * (log.t[-1] - log.t[0])
    rows = int(np.searchsorted(log.t, border))
    if rows < _FEWEST or len(log.t) - rows < _FEWEST:
        return ()
    return (Fold(on({name: cut_log(log, -np.inf, border)}), on({name: cut_log(log, border, np.inf)})),)
