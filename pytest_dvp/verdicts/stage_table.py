"""The table of stages: how alike the drives of one scenario on several stages are, and what each of them measured.

    table = stage_table({"dt": dt, "pe-surrogate": pe, "rw-surrogate": rw})
    print("\\n".join(table.lines()))

Rows and order are those of Arango et al., Sensors 2026, 26, 1338: the likeness of ego and objects, then the metrics of
each drive. As there, a stage is compared with the one to its left, the first with what came before it (`before`: the
last drive of the iteration before), if anything did. MNCC never stands without lag and gain, to which it is blind.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from pytest_dvp.logs.log import Log
from pytest_dvp.metrics import MetricValue, compute

LIKENESS = (
    ("ego x", "mncc", "x"),
    ("ego y", "mncc", "y"),
    ("steer", "mncc", "steer"),
    ("velocity", "mncc", "v"),
    ("object x", "mncc", "objects.x"),
    ("object y", "mncc", "objects.y"),
)
"""Rows of MNCC: what they are called, metric, signal."""

PATH = ("path distance", "path_distance")
TWIN = ("open-loop position", "twin_error")
"""Rows of two drives in metres: between their paths; of the twin of stage dt driven by this stage's commands."""

DRIVE = (
    ("max TTC^-1", "max_ttc_inverse"),
    ("TET", "tet"),
    ("max jerk", "max_jerk"),
    ("max yaw rate", "max_yaw_rate"),
    ("completion time", "completion_time"),
    ("lateral RMSE, lane", "lateral_rmse"),
    ("lateral RMSE, path", "lateral_rmse_path"),
    ("localization error", "localization_error"),
    ("heading error", "heading_error"),
)
"""Rows of one drive."""


@dataclasses.dataclass(frozen=True, slots=True)
class Cell:
    """A number of the table, None where it is not defined, and then `reason` says why; of an MNCC also lag [s] (> 0:
    this stage is later), gain (this stage over the other)."""

    value: float | None
    lag: float | None = None
    gain: float | None = None
    reason: str = ""

    @property
    def text(self) -> str:
        """As the table shows it: `0.9981 +0.12 s x1.004`."""
        if self.value is None:
            return "-"
        if self.lag is None or self.gain is None:
            return f"{self.value:.4g}" if abs(self.value) >= 1e-4 or self.value == 0.0 else f"{self.value:.1e}"
        return f"{self.value:.4f} {self.lag:+.2f} s x{self.gain:.3f}"


@dataclasses.dataclass(frozen=True, slots=True)
class TableRow:
    """One row: what it is called, the metric and its signal (empty: none), its unit, a cell a stage."""

    name: str
    metric: str
    signal: str
    unit: str
    cells: tuple[Cell, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class StageTable:
    """The table: stages from left to right, what each was compared with (empty: nothing), rows from top to bottom."""

    stages: tuple[str, ...]
    against: tuple[str, ...]
    rows: tuple[TableRow, ...]

    def cell(self, row: str, stage: str) -> Cell:
        """The cell of a row (its name) and a stage. Raises KeyError."""
        found = {each.name: each for each in self.rows}
        return found[row].cells[dict(zip(self.stages, range(len(self.stages)), strict=True))[stage]]

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON-able data, as result.json and the page hold it."""
        return {
            "stages": list(self.stages),
            "against": list(self.against),
            "rows": [
                {
                    "name": row.name,
                    "metric": row.metric,
                    "signal": row.signal,
                    "unit": row.unit,
                    "cells": [{**dataclasses.asdict(cell), "text": cell.text} for cell in row.cells],
                }
                for row in self.rows
            ],
        }

    def lines(self) -> list[str]:
        """The table for a terminal."""
        from pytest_dvp.verdicts.stage_table_text import table_lines

        return table_lines(self.as_dict())


def stage_table(logs: Mapping[str, Log], before: tuple[str, Log] | None = None) -> StageTable:
    """The table of logs by stage ("dt", "pe-surrogate", ...), columns in the order of the mapping; reads nothing else.

    before  name and log that the first stage is compared with: in an iteration the last drive of the one before
    """
    names = tuple(logs)
    pairs: list[tuple[str, Log] | None] = [before, *((name, logs[name]) for name in names[:-1])]
    rows = [_between(label, metric, signal, logs, pairs) for label, metric, signal in LIKENESS]
    rows.append(_between(*PATH, "", logs, pairs))
    rows.append(_between(*TWIN, "", logs, _twins(logs, pairs)))
    rows += [_single(label, metric, logs) for label, metric in DRIVE]
    return StageTable(names, tuple("" if pair is None else pair[0] for pair in pairs), tuple(rows))


def _twins(logs: Mapping[str, Log], pairs: Sequence[tuple[str, Log] | None]) -> list[tuple[str, Log] | None]:
    """What the open-loop error of each stage is against: the twin's log wherever it stands, but not against itself."""
    twin = next((name for name in logs if name.split("-")[0] == "dt"), None)
    if twin is None:
        return list(pairs)
    return [pairs[0] if name == twin else (twin, logs[twin]) for name in logs]


def _between(
    label: str, metric: str, signal: str, logs: Mapping[str, Log], pairs: Sequence[tuple[str, Log] | None]
) -> TableRow:
    options = {"signal": signal} if signal else {}
    cells, unit = [], "-"
    for log, pair in zip(logs.values(), pairs, strict=True):
        if pair is None:
            cells.append(Cell(None, reason="nothing came before it"))
            continue
        value = compute(metric, pair[1], log, **options)
        unit = value.unit
        told = metric == "mncc" and value.valid
        cells.append(
            Cell(
                value.value,
                value.extra["lag"] if told else None,
                value.extra["gain"] if told else None,
                value.reason,
            )
        )
    return TableRow(label, metric, signal, unit, tuple(cells))


def _single(label: str, metric: str, logs: Mapping[str, Log]) -> TableRow:
    values: list[MetricValue] = [compute(metric, log) for log in logs.values()]
    unit = next((value.unit for value in values if value.valid), values[0].unit if values else "-")
    return TableRow(label, metric, "", unit, tuple(Cell(value.value, reason=value.reason) for value in values))
