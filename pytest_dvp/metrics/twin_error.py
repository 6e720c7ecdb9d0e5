"""How well the twin of one stage answers the commands of another stage's drive: the open-loop error, in metres."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.obeyed_commands import with_obeyed_commands
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._presence import check_share
from pytest_dvp.metrics.metric import Measured, Series, metric

if TYPE_CHECKING:
    from pytest_dvp.gap.compare.compare import Comparison

POSITION = "position"


@metric(
    name="twin_error",
    unit="m",
    bigger_is_worse=True,
    note="open loop on segments of about 5 s, start taken out",
    open_loop=True,
)
def twin_error(model: Log, measured: Log, *, signal: str = POSITION) -> Measured:
    """RMSE between the measured drive and what the twin of the other log makes of its commands, open loop.

    `signal` is "position" (distance in the plane) or a column as in `dvp compare`, then in its unit. Two drives that
    a driving stack steers to the same line are alike whatever the car; the commands that this took are not, and they
    show here. Of a recording that was played to a stack, its own commands count. Undefined if the first log is not of
    a twin: only such a log holds its model.
    """
    from pytest_dvp.gap.words.comparison import sentence, worst_place

    found = compared(model, measured)
    names = ("x", "y") if signal == POSITION else (signal,)
    for name in names:
        if name not in found.signals:
            raise Undefined(f"{name} is not compared: {found.not_compared.get(name, 'no such signal')}")
        check_measured(found, name)
    rest = np.sqrt(sum(np.square(found.residuals[name]) for name in names))
    known = np.isfinite(rest)
    if not known.any():
        raise Undefined(f"{signal} is known nowhere")
    worst = int(np.argmax(np.where(known, rest, -1.0)))
    place = worst_place(found.where, names[0])
    unit = found.signals[names[0]].unit
    return Measured(
        math.sqrt(float(np.mean(rest[known] ** 2))),
        float(found.t[worst]),
        sentence(place) if place else "",
        Series(found.t, rest),
        {"greatest": float(rest[worst])},
        unit,
    )


def check_measured(found: Comparison, name: str) -> None:
    """Raises Undefined if a signal of the comparison was measured for less than LEAST of the drive."""
    check_share(found.t, np.isfinite(found.measured[name]), name)


@functools.lru_cache(maxsize=2)
def compared(model: Log, measured: Log) -> Comparison:
    """The measured drive beside what the twin of `model` makes of its commands; kept, as several bounds ask for one.

    Raises Undefined if `model` holds no twin, or nothing can be compared.
    """
    from pytest_dvp.doctor import check_log, comparable
    from pytest_dvp.gap.compare.compare import compare
    from pytest_dvp.gap.compare.compared_model import CompareError
    from vehicle.model.errors import ModelError
    from vehicle.model.model_file import parse_model

    about = model.meta.get("model")
    text = about.get("toml") if isinstance(about, dict) else None
    if not isinstance(text, str):
        raise Undefined("the log it is compared with is not of a twin, or of an older version: it holds no model")
    measured = with_obeyed_commands(measured)
    check_log(measured)  # a wrong unit is no reality gap
    try:
        return compare(comparable(measured), parse_model(text))
    except (CompareError, ModelError) as error:
        raise Undefined(str(error)) from error
