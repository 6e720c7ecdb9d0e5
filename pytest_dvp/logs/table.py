"""Named columns with units -> Log: conversion to SI, aliases, time base; what was done is said in `meta["import"]`."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from openscenario.findings import Finding, Findings, listed, nearest
from pytest_dvp.logs.column_names import Header, canonical
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.signals import SIGNALS
from pytest_dvp.logs.texts import Texts
from pytest_dvp.logs.units import Unit, find_unit, units_of

EPOCH = 1e7
"""A first stamp above this [s] is a date, not a time since some start; the log then begins at 0."""


class RawColumn(NamedTuple):
    """One column as the file has it: header, and values (n,) in the file's unit, NaN where the file is empty."""

    header: Header
    values: FloatArray


@dataclasses.dataclass
class Table:
    """What a reader of one format found.

    file    as the messages name it
    kind    "csv", "mat", "mdf", "mcap", "bag"
    columns in the order of the file
    lines   line of each row, None where the format has no lines
    texts   columns of words, by name; only a mapping takes them
    place   element that messages about the time base name (a topic, or "column t")
    """

    file: str
    kind: str
    columns: list[RawColumn]
    lines: NDArray[np.int64] | None = None
    header_line: int | None = None
    place: str = ""
    findings: Findings = dataclasses.field(default_factory=Findings)
    notes: dict[str, Any] = dataclasses.field(default_factory=dict)
    texts: dict[str, Texts] = dataclasses.field(default_factory=dict)

    def line(self, row: int) -> int | None:
        """Line of the file at which a row stands; None if the lines are not known."""
        return None if self.lines is None else int(self.lines[row])


def build_log(table: Table, *, strict: bool = True) -> Log:
    """The log of a table.

    strict  raise for what forbids using the log; else (the doctor) read all that can be read and keep every finding
            in `meta["import"]["findings"]`.

    Raises LogError with all the findings.
    """
    names = _names(table)
    _stop(table)
    columns: dict[str, FloatArray] = {}
    told: dict[str, dict[str, Any]] = {}
    for raw, name in zip(table.columns, names, strict=True):
        unit = find_unit(raw.header.unit or "-")
        values = raw.values
        if unit is not None and (unit.scale != 1.0 or unit.offset):
            values = values * unit.scale + unit.offset
        columns[name] = np.ascontiguousarray(values, dtype=np.float64)
        told[name] = _told(raw.header, name, unit)
    time = columns.pop("t")
    columns = {"t": time, **columns}
    origin = _rebase(columns)
    columns = _time_base(table, columns)
    if strict:
        _stop(table)
    meta: dict[str, Any] = {
        "format": table.kind,
        "columns": told,
        "converted": [name for name, entry in told.items() if {"scale", "offset"} & entry.keys()],
        "aliased": [name for name, entry in told.items() if entry["from"] != name],
        "unknown": [name for name in told if name not in SIGNALS],
        **({"time_origin": origin} if origin else {}),
        **table.notes,
        "findings": [dataclasses.asdict(finding) for finding in table.findings.in_order()],
    }
    return Log(columns=columns, meta={"import": meta})


def findings_of(log: Log) -> tuple[Finding, ...]:
    """What the import of this log found."""
    return tuple(Finding(**entry) for entry in log.meta.get("import", {}).get("findings", ()))


def _told(header: Header, name: str, unit: Unit | None) -> dict[str, Any]:
    entry: dict[str, Any] = {"from": header.name, "unit": header.unit or ""}
    if unit is not None:
        entry["si"] = unit.si
        if unit.scale != 1.0:
            entry["scale"] = unit.scale
        if unit.offset:
            entry["offset"] = unit.offset
    return entry


def _names(table: Table) -> list[str]:
    """Name of each column in the log; findings for bare names, wrong units and names that occur twice."""
    exact = {column.header.name for column in table.columns}
    names: list[str] = []
    bare: list[Header] = []
    for column in table.columns:
        header = column.header
        name = canonical(header.name)
        if name != header.name and (name in exact or name in names):
            name = header.name  # `v` and `speed` in one file: both stay, under their own names
        if name in names:
            table.findings.add(
                "log.duplicate_column", table.file, table.header_line, f"column {header.name}",
                "two columns of one name", found=header.text, hint="rename or drop one of them",
            )  # fmt: skip
            name = f"{name}#{len(names)}"
        names.append(name)
        if header.unit is None:
            bare.append(header)
        else:
            _check_unit(table, name, header)
    # The time column last: what a user reads first is then a signal, and its unit says how the rest is meant.
    strange = [header for header in bare if canonical(header.name) not in SIGNALS]
    for header in sorted(bare, key=lambda h: canonical(h.name) == "t"):
        if len(strange) < 2 or header not in strange:
            _unit_missing(table, header)
    if len(strange) > 1:
        table.findings.add(
            "log.unit_missing", table.file, table.header_line, f"columns {listed([h.name for h in strange], 8)}",
            "these columns neither have usual names nor say their units", allowed="`NAME [UNIT]`, `[-]` for none",
            hint=f"say in a mapping which of them count: `dvp map {table.file} > map.toml`, then --map map.toml",
        )  # fmt: skip
    if "t" not in names:
        table.findings.add(
            "log.time_missing", table.file, table.header_line, "column t", "no time column",
            found=listed(names, 8), allowed="a column `t [s]`",
            hint=nearest("t", names) or f"say which it is in a mapping: `dvp map {table.file} > map.toml`, then --map",
        )  # fmt: skip
    return names


def _unit_missing(table: Table, header: Header) -> None:
    signal = SIGNALS.get(canonical(header.name))
    unit = signal.unit if signal is not None else "-"
    also = units_of(unit)[1:3]
    others = f", or {' or '.join(f'`{header.name} [{u}]`' for u in also)}" if also else ""
    table.findings.add(
        "log.unit_missing", table.file, table.header_line, f"column {header.name}",
        "the column does not say its unit", found=header.text,
        allowed=f"`{header.name} [{unit}]`{others}" if signal else f"`{header.name} [UNIT]`, `[-]` for none",
        hint="write the unit behind the name, or in a row of units under the header"
        + ("" if signal else f"; or say in a mapping which columns count: `dvp map {table.file} > map.toml`"),
    )  # fmt: skip


def _check_unit(table: Table, name: str, header: Header) -> None:
    unit = find_unit(header.unit or "-")
    signal = SIGNALS.get(name)
    if signal is None or (unit is not None and unit.si == signal.unit):
        return
    table.findings.add(
        "log.unit_unknown" if unit is None else "log.unit_mismatch", table.file, table.header_line,
        f"column {header.name}",
        "the unit is not known" if unit is None else f"this is not a unit of {signal.meaning}",
        found=header.unit or "", allowed=", ".join(units_of(signal.unit)),
        hint="" if unit is None else "if the column holds something else, give it another name",
    )  # fmt: skip


def _rebase(columns: dict[str, FloatArray]) -> float:
    """Stamps that are dates start at 0; returns the first stamp then, else 0."""
    t = columns["t"]
    if not len(t) or not math.isfinite(t[0]) or abs(t[0]) < EPOCH:
        return 0.0
    origin = float(t[0])
    columns["t"] = t - origin
    return origin


def _time_base(table: Table, columns: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Columns without unusable rows; findings about too few rows, missing, repeated and reversed stamps."""
    t = columns["t"]
    file, add = table.file, table.findings.add
    place = table.place or "column t"
    missing = np.flatnonzero(~np.isfinite(t))
    if len(missing):
        add(
            "log.time_missing", file, table.line(int(missing[0])), place, f"{len(missing)} rows without a time",
            severity="warning", hint="these rows are left out",
        )  # fmt: skip
        columns = _keep(table, columns, np.isfinite(t))
        t = columns["t"]
    if _refuse_few(table, len(t)):
        return columns
    steps = np.diff(t)
    back = np.flatnonzero(steps < 0)
    if len(back):
        row = int(back[0]) + 1
        add(
            "log.time_not_monotonic", file, table.line(row), place,
            f"time jumps back {len(back)} times, first by {-steps[back[0]]:.6g} s after t = {t[back[0]]:.6g} s",
            found=f"{t[row]:.6g} s after {t[row - 1]:.6g} s", allowed="rising time",
            hint=_advice_for_jumps(t, back),
        )  # fmt: skip
    same = np.flatnonzero(steps == 0)
    if len(same):
        row = int(same[0]) + 1
        add(
            "log.duplicate_messages" if table.kind in ("mcap", "bag") else "log.duplicate_stamps",
            file, table.line(row), place,
            f"{len(same)} rows repeat the stamp before, first at t = {t[row]:.6g} s; the first of each is kept",
            severity="warning", hint="write each sample once",
        )  # fmt: skip
        if not len(back):
            columns = _keep(table, columns, np.concatenate([[True], steps != 0]))
            _refuse_few(table, len(columns["t"]))
    return columns


def _refuse_few(table: Table, rows: int) -> bool:
    if rows < 3:
        found = "1 row" if rows == 1 else f"{rows} rows"
        text = f"{found} {'is' if rows == 1 else 'are'} no log"
        table.findings.add("log.too_short", table.file, None, "", text, found=found, allowed="3 or more")
    return rows < 3


def _advice_for_jumps(t: FloatArray, back: NDArray[np.intp]) -> str:
    cuts = ", ".join(f"{t[i]:.6g} s" for i in back[:3])
    if len(back) <= 3 and np.all(t[back + 1] <= t[0] + 1.0):
        return f"this looks like concatenated runs: split the file after t = {cuts}"
    return "sort or repair the stamps where the log is written; a clock that was set back needs a cut there"


def _keep(table: Table, columns: Mapping[str, FloatArray], mask: NDArray[np.bool_]) -> dict[str, FloatArray]:
    if table.lines is not None:
        table.lines = table.lines[mask]
    return {name: values[mask] for name, values in columns.items()}


def _stop(table: Table) -> None:
    if table.findings.errors:
        raise LogError.of(table.findings.in_order())
