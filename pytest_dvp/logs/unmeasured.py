"""A log with some of its values as not measured."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pytest_dvp.logs.log import Log


def unmeasured(log: Log, rows: Mapping[str, NDArray[np.bool_]]) -> Log:
    """The log with NaN in the given rows (n,) of its columns, whose units stay; the log itself if there are none."""
    columns = {name: np.where(those, np.nan, log.columns[name]) for name, those in rows.items() if those.any()}
    return dataclasses.replace(log, columns={**log.columns, **columns}) if columns else log
