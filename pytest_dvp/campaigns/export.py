"""A campaign as a table or as JUnit XML, for tools that know neither SQLite nor us."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.campaigns.regression_set import CASES, FOLDER, regression_set, write_regression_set
from pytest_dvp.campaigns.store import SHRINKING, Row, StoreError
from pytest_dvp.text.paths import told_apart
from reports.whole_file import write_whole

KINDS = {"csv": "runs.csv", "junit": "junit.xml", "parquet": "runs.parquet", "regression": FOLDER}
_FIXED = ("key", "scenario", "seed", "verdict", "objective", "gate", "object", "vacuous", "purpose", "cpu", "commit_id",
          "log")  # fmt: skip


def export(rows: Sequence[Row], kind: str, folder: Path, cases: int = CASES) -> list[Path]:
    """Write the drives into the campaign's folder as one of KINDS; returns the files: one, or one for each scenario of
    a regression set of so many `cases`.

    Columns are the fixed ones, then `parameter.NAME`, `margin.GATE` and `metric.NAME`. JUnit has no column `purpose`,
    so drives that shrank a failure are not in it, as they are not in the summary.

    Raises StoreError for parquet without pyarrow, and for a set of a scenario that is no longer there; WriteError if a
    file cannot be written.
    """
    target = folder / KINDS[kind]
    if kind == "regression":
        sets = _sets(rows, cases)
        files = [Path(each[0].scenario).resolve() for each in sets]
        base = Path(os.path.commonpath([file.parent for file in files]))
        names = [told_apart(file, files, base) for file in files]
        return [write_regression_set(each, target, name) for each, name in zip(sets, names, strict=True)]
    if kind == "junit":
        data = _junit([row for row in rows if row.purpose != SHRINKING])
    elif kind == "csv":
        data = _csv(_table(rows))
    else:
        data = _parquet(_table(rows))
    write_whole(target, data)
    return [target]


def _sets(rows: Sequence[Row], cases: int) -> list[list[Row]]:
    """A regression set of each scenario."""
    found = []
    for scenario in sorted({row.scenario for row in rows}):
        if not Path(scenario).is_file():
            raise StoreError(f"--export regression: {scenario}: no such file; the set refers to it")
        chosen = regression_set([row for row in rows if row.scenario == scenario], cases)
        if chosen:
            found.append(chosen)
    if not found:
        raise StoreError("--export regression: no drive of the campaign was judged")
    return found


def _table(rows: Sequence[Row]) -> dict[str, list[Any]]:
    table: dict[str, list[Any]] = {name: [getattr(row, name) for row in rows] for name in _FIXED}
    for prefix, field in (("parameter", "parameters"), ("margin", "margins"), ("metric", "metrics")):
        names = sorted({name for row in rows for name in getattr(row, field)})
        table |= {f"{prefix}.{name}": [getattr(row, field).get(name) for row in rows] for name in names}
    for name in [name for name in table if name.startswith("parameter.")]:
        table[name] = _numbers(table[name])
    return table


def _numbers(values: list[Any]) -> list[Any]:
    """A column of numbers where all of it is one: a table has one type a column."""
    try:
        return [None if value is None else float(value) for value in values]
    except ValueError:
        return values


def _csv(table: dict[str, list[Any]]) -> bytes:
    text = io.StringIO()
    sheet = csv.writer(text, lineterminator="\n")
    sheet.writerow(table)
    sheet.writerows(["" if value is None else value for value in line] for line in zip(*table.values(), strict=True))
    return text.getvalue().encode()


def _parquet(table: dict[str, list[Any]]) -> bytes:
    import importlib

    try:
        arrow: Any = importlib.import_module("pyarrow")
        parquet: Any = importlib.import_module("pyarrow.parquet")
    except ModuleNotFoundError:
        raise StoreError("--export parquet needs pyarrow: pip install pyarrow; --export csv needs nothing") from None
    buffer = io.BytesIO()
    parquet.write_table(arrow.table(table), buffer)
    return buffer.getvalue()


def _junit(rows: Sequence[Row]) -> bytes:
    from lxml import etree

    failures = sum(row.verdict == "FAIL" for row in rows)
    errors = sum(row.verdict == "ERROR" for row in rows)
    skipped = len(rows) - failures - errors - sum(row.verdict == "PASS" for row in rows)
    suite = etree.Element(
        "testsuite", name="dvp campaign", tests=str(len(rows)), failures=str(failures), errors=str(errors),
        skipped=str(skipped), time=f"{sum(row.cpu for row in rows):.3f}",
    )  # fmt: skip
    for row in rows:
        values = ",".join(f"{name}={value}" for name, value in row.parameters.items())
        case = etree.SubElement(
            suite, "testcase", classname=_xml(Path(row.scenario).stem), name=_xml(values or row.key),
            time=f"{row.cpu:.3f}",
        )  # fmt: skip
        tag = {"FAIL": "failure", "ERROR": "error", "PASS": ""}.get(row.verdict, "skipped")
        if tag:
            etree.SubElement(case, tag, message=_xml(row.message))
    return etree.tostring(suite, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _xml(text: str) -> str:
    """Text without the characters that XML cannot hold."""
    from pytest_dvp.text.printable import clean

    return clean(text)
