"""How well a vehicle model answers the commands of a log as the car did: what gates of the kind `model` bound."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, metric

if TYPE_CHECKING:
    from pytest_dvp.gap.compare.compare import Comparison

_NOTE = "open loop on segments of about 5 s, start taken out"


@metric(name="open_loop_error", unit="-", bigger_is_worse=True, note=_NOTE)
def open_loop_error(log: Log, *, model: str, signal: str) -> Measured:
    """RMSE between a log's signal and the model driven by the log's commands, in the signal's unit."""
    return _measured(log, model, signal, "rmse")


@metric(name="model_mncc", unit="-", bigger_is_worse=False, note=_NOTE, ideal=1.0)
def model_mncc(log: Log, *, model: str, signal: str) -> Measured:
    """Maximum normalised cross-correlation of a log's signal and the model's. Blind to gain, delay and bias."""
    return _measured(log, model, signal, "mncc")


@metric(name="model_lag", unit="s", bigger_is_worse=True, note=_NOTE)
def model_lag(log: Log, *, model: str, signal: str) -> Measured:
    """Size of the lag at which a log's signal and the model's are most alike."""
    return _measured(log, model, signal, "lag")


@metric(name="model_gain", unit="-", bigger_is_worse=True, note=_NOTE)
def model_gain(log: Log, *, model: str, signal: str) -> Measured:
    """Distance from 1 of the slope of a log's signal against the model's, at their lag."""
    return _measured(log, model, signal, "gain")


def _measured(log: Log, model: str, signal: str, kind: str) -> Measured:
    from pytest_dvp.gap.compare.match_bounds import judge_bounds
    from pytest_dvp.gap.words.comparison import sentence, worst_place

    path = Path(model)
    stat = path.stat()
    comparison = _compared(log, model, stat.st_mtime_ns, stat.st_size)
    judged = judge_bounds(comparison, {kind: {signal: 0.0}})[0]
    if judged.value is None:
        raise Undefined(f"{kind} of {signal}: {judged.reason}")
    place = worst_place(comparison.where, signal)
    rest = np.abs(comparison.residuals[signal])
    worst = float(comparison.t[int(np.nanargmax(rest))]) if np.isfinite(rest).any() else None
    unit = judged.unit if kind == "rmse" else ""
    return Measured(judged.value, worst, sentence(place) if place else "", unit=unit)


@functools.lru_cache(maxsize=1)
def _compared(log: Log, model: str, changed: int, size: int) -> Comparison:
    """The last comparison, as several bounds of one gate ask for it; `changed` and `size` tell a rewritten file."""
    from pytest_dvp.doctor import check_log, comparable
    from pytest_dvp.gap.compare.compare import compare
    from pytest_dvp.gap.compare.compared_model import CompareError
    from pytest_dvp.gap.compare.model_loader import load_compared_model

    check_log(log)  # a wrong unit is no reality gap: LogError makes the verdict inconclusive
    try:
        return compare(comparable(log), load_compared_model(model))
    except CompareError as error:
        raise Undefined(str(error)) from error
