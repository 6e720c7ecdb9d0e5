"""A pandas DataFrame as a log: a column `t` [s], every other column by its name."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.logs.column_names import Header, canonical, parse_header
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.signals import SIGNALS
from pytest_dvp.logs.table import RawColumn, Table, build_log

if TYPE_CHECKING:
    import pandas as pd


def frame_log(frame: pd.DataFrame, name: str = "DataFrame") -> Log:
    """The log of a table (n rows) in memory; its index plays no part.

    A column that names its unit (`v [km/h]`) is converted; a bare name is taken as SI, as `Log.to_frame` writes it.
    Usual aliases are known; unknown columns that hold no numbers are left out.

    Raises LogError: no column `t`, a signal that holds no numbers, times that do not rise.
    """
    columns = []
    for place, label in enumerate(frame.columns):
        header = parse_header(str(label))
        signal = SIGNALS.get(canonical(header.name))
        values = frame.iloc[:, place]
        if values.dtype.kind not in "fiub":
            if signal is None:
                continue
            allowed = "seconds" if signal.name == "t" else f"numbers [{signal.unit}]"
            raise LogError(f"{name}: column {label} holds no numbers (found {values.dtype}, allowed: {allowed})")
        unit = header.unit if header.unit is not None else signal.unit if signal is not None else "-"
        # A copy: pandas lends arrays that cannot be written, for which numba would compile everything once more
        columns.append(RawColumn(Header(header.text, header.name, unit), np.array(values, dtype=np.float64)))
    return build_log(Table(name, "frame", columns))
