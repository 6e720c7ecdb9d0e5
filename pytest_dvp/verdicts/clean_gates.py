"""Bounds that clean drives of one stack keep: the table [clean] of a gate file.

    [clean]
    only_if_logged = "ads.position_sigma"       # a column that only this stack states
    parameters = { ego_speed = 5.5 }            # of the scenario, in those drives
    [clean.max]
    localization_error = 0.08
    "localization_error statistic=greatest" = 0.15
    [clean.min]
    completion_time = 36.0

A stack keeps such a bound with its own noise and its own habits, in that scenario and no other; of another stack, on
another stage, with other parameters or another twin it says nothing. Each is a gate that does not apply there.

A single bound of that kind is a [[gate]] with `clean = { ego_speed = 5.5 }`: these parameters, and any stack.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from openscenario.findings import nearest
from pytest_dvp.logs.log import Log
from pytest_dvp.metrics import MetricError, find_metric
from pytest_dvp.metrics.registry import check_options
from pytest_dvp.verdicts.gate import Gate

Find = Callable[..., None]
KEYS = ("only_if_logged", "parameters", "max", "min")


def read_clean(table: object, text: str, file: str, find: Find) -> list[Gate]:
    """The gates of a table [clean]; what is wrong with it goes to `find`, and the result is then empty."""
    head = _line(text, "clean", None)
    if not isinstance(table, dict):
        find("not_a_table", head, "clean", "[clean] must be a table")
        return []
    for key in table:
        if key not in KEYS:
            find("unknown_key", head, f"clean.{key}", f"unknown key {key[:80]!r}", hint=nearest(key, KEYS))
            return []
    column, parameters = table.get("only_if_logged"), table.get("parameters", {})
    if not isinstance(column, str) or not re.fullmatch(r"[\w.]+", column):
        find("clean", head, "clean.only_if_logged", 'only_if_logged must name a column, "ads.position_sigma"')
        return []
    if not isinstance(parameters, dict) or not all(_is_number(value) for value in parameters.values()):
        find("clean", head, "clean.parameters", "parameters must be numbers by name, { ego_speed = 5.5 }")
        return []
    sides = {side: table.get(side, {}) for side in ("max", "min")}
    if not all(isinstance(bounds, dict) for bounds in sides.values()) or not any(sides.values()):
        find("clean", head, "clean", "[clean] needs [clean.max] or [clean.min] with bounds by metric")
        return []
    found: dict[str, Gate] = {}
    for side, bounds in sides.items():
        for name, bound in bounds.items():
            line, element = _line(text, f"clean.{side}", name) or head, f"clean.{side}.{name[:80]}"
            read = _metric(name)
            if isinstance(read, str):
                find("unknown_metric", line, element, read)
            elif not _is_number(bound):
                find("bound", line, element, f"{side} must be a finite number", found=str(bound)[:80])
            elif name in found and float(bound) > (found[name].max or 0.0):
                find("min_over_max", line, element, f"min {bound:g} is greater than max {found[name].max:g}")
            else:
                old = found.get(name)
                found[name] = Gate(
                    read[0], old.max if old else (float(bound) if side == "max" else None),
                    float(bound) if side == "min" else None, ("dt",), None, read[1], file, old.line if old else line,
                    only_if_logged=column, only_with=parameters,
                )  # fmt: skip
    return list(found.values())


def wrong_conditions(gate: Mapping[str, Any]) -> str:
    """What is wrong with the key `clean` of the table of a [[gate]]; empty if nothing is."""
    values = gate["clean"]
    if not isinstance(values, dict) or not all(_is_number(value) for value in values.values()):
        return "clean must be the scenario's parameters in the clean drives, { ego_speed = 5.5 }; {} where it has none"
    if "between" in gate or gate.get("stages", ["dt"]) != ["dt"]:
        return "clean is for a bound that drives of the twin keep: without between, and on no stage but dt"
    return ""


def applies(gate: Gate, log: Log) -> bool:
    """Whether a gate says something of this log: always, if it is no bound of clean drives."""
    if gate.only_with is None:
        return True
    if log.meta.get("S"):
        return False
    values = log.columns.get(gate.only_if_logged) if gate.only_if_logged else None
    if gate.only_if_logged and (values is None or not np.isfinite(values).any()):
        return False
    given = log.meta.get("parameters", {})
    return all(_same(given.get(name), value) for name, value in gate.only_with.items())


def _same(given: object, value: float) -> bool:
    try:
        return math.isclose(float(str(given)), value, rel_tol=1e-9, abs_tol=1e-12)
    except ValueError:
        return False


def _metric(name: str) -> tuple[str, Mapping[str, Any]] | str:
    """Metric and options of `detection_recall reach=40.0`; what is wrong with it as a text."""
    metric, *rest = name.split()
    options: dict[str, Any] = {}
    for word in rest:
        key, _, value = word.partition("=")
        try:
            options[key] = float(value)
        except ValueError:
            options[key] = value
    try:
        check_options(find_metric(metric), options)
    except MetricError as error:
        return str(error)
    return metric, options


def _line(text: str, table: str, key: str | None) -> int | None:
    """1-based line of a key of a table, or of its head."""
    here = False
    for number, line in enumerate(text.splitlines(), 1):
        words = line.strip()
        if words.startswith("["):
            here = words.startswith(f"[{table}]")
            if here and key is None:
                return number
        elif here and key is not None and words.partition(" = ")[0].strip(' "') == key:
            return number
    return None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
