"""Gate files: TOML in, located gates out. Every gate knows its line, because a failed one must lead there."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

from openscenario.findings import Finding, nearest
from pytest_dvp.metrics import Metric, MetricError, find_metric, known_metrics
from pytest_dvp.metrics.registry import check_options
from pytest_dvp.verdicts.clean_gates import read_clean, wrong_conditions
from pytest_dvp.verdicts.equal_gates import repeated
from pytest_dvp.verdicts.excited_parameters import wrong_parameters
from pytest_dvp.verdicts.gate import STAGES, Gate, GateError, GateFile, GateTask, GateTraffic, Stage
from pytest_dvp.verdicts.gate_file_lines import Lines, locate_lines
from pytest_dvp.verdicts.gate_signal import wrong_signal
from pytest_dvp.verdicts.harmless_side import on_the_harmless_side
from pytest_dvp.verdicts.model_gate import model_file, read_model_gate
from pytest_dvp.verdicts.requirement import wrong_requirement
from vehicle.messages import RoadPoint
from vehicle.toml_file import TomlError, read_toml

GATE_KEYS = ("metric", "max", "min", "stages", "between", "max_difference", "requirement", "parameters", "clean")
TABLES = ("task", "traffic", "gate", "clean")
TASK_KEYS = ("start", "goal", "lane")
TRAFFIC_KEYS = ("net", "routes")


def read_gates(path: Path | str) -> GateFile:
    """Read a gate file. Raises GateError with everything that is wrong with it."""
    reader = _Reader(str(path))
    result = reader.read(Path(path))
    errors = [finding for finding in reader.findings if finding.severity == "error"]
    if errors:
        raise GateError(errors)
    return result


def check_gates(path: Path | str) -> tuple[Finding, ...]:
    """All findings of a gate file; never raises for a user's file."""
    reader = _Reader(str(path))
    reader.read(Path(path))
    return tuple(reader.findings)


class _Reader:
    """Collects findings while it reads, so that a user sees all of them at once."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.findings: list[Finding] = []
        self.lines = Lines()
        self.text = ""

    def find(self, code: str, line: int | None, element: str, text: str, **more: str) -> None:
        self.findings.append(Finding(f"dvp.gates.{code}", "error", self.file, line, element, text=text, **more))

    def read(self, path: Path) -> GateFile:
        data = self._toml(path)
        for key in data:
            if key not in TABLES:
                line = self.lines.top.get(key)
                self.find("unknown_key", line, key, f"unknown table or key {key[:80]!r}", hint=nearest(key, TABLES))
        task = self._task(data["task"]) if "task" in data else None
        traffic = self._traffic(data["traffic"]) if "traffic" in data else None
        tables = data.get("gate", [])
        if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
            self.find("not_a_table", self.lines.top.get("gate"), "gate", "gates are written as [[gate]] tables")
            tables = []
        elif not tables and not self.findings:
            self.find("no_gate", 1, "gate", "no [[gate]]: a file without gates judges nothing")
        gates: list[Gate] = []
        for i, table in enumerate(tables):
            if "model" in table and "metric" not in table:
                head, keys = self.lines.gates[i] if i < len(self.lines.gates) else (self.lines.top.get("gate"), {})
                gates += read_model_gate(table, f"gate[{i + 1}]", head, keys, self.file, self.find, self._stages)
            else:
                gate = self._gate(table, i)
                gates += [gate] if gate is not None else []
        self.findings += repeated(gates)
        self.findings += on_the_harmless_side(gates)
        if "clean" in data:
            gates += read_clean(data["clean"], self.text, self.file, self.find)
        return GateFile(task, tuple(gates), self.file, traffic)

    def _toml(self, path: Path) -> dict[str, Any]:
        try:
            data, text = read_toml(path)
        except TomlError as error:
            unreadable = error.kind == "unreadable"
            self.find(error.kind, error.line, "", f"cannot be read: {error}" if unreadable else str(error))
            return {"gate": []} if unreadable else {}
        self.text, self.lines = text, locate_lines(text)
        return data

    def _task(self, table: object) -> GateTask | None:
        if not isinstance(table, dict):
            self.find("not_a_table", self.lines.top.get("task"), "task", "[task] must be a table")
            return None
        for key in table:
            if key not in TASK_KEYS:
                hint = nearest(key, TASK_KEYS)
                self.find("unknown_key", self._task_line(key), f"task.{key}", f"unknown key {key!r}", hint=hint)
        lane = table.get("lane")
        if lane is not None and (isinstance(lane, bool) or not isinstance(lane, int) or lane == 0):
            self.find(
                "value",
                self._task_line("lane"),
                "task.lane",
                "lane must be a lane id",
                found=str(lane),
                allowed="whole number except 0",
            )
            lane = None
        return GateTask(self._place(table, "start"), self._place(table, "goal"), lane)

    def _traffic(self, table: object) -> GateTraffic | None:
        line = self.lines.top.get("traffic")
        if not isinstance(table, dict):
            self.find("not_a_table", line, "traffic", "[traffic] must be a table")
            return None
        for key in table:
            if key not in TRAFFIC_KEYS:
                hint = nearest(key, TRAFFIC_KEYS)
                self.find("unknown_key", line, f"traffic.{key}", f"unknown key {key!r}", hint=hint)
        for key in TRAFFIC_KEYS:
            name = table.get(key)
            # Beside the gate file and nowhere else: a name, not a path, so that nothing can climb out.
            if not isinstance(name, str) or not re.fullmatch(r"[\w.-]+", name) or name in (".", ".."):
                self.find("value", line, f"traffic.{key}", f"{key} must be the name of a file beside this one")
                return None
        return GateTraffic(str(table["net"]), str(table["routes"]))

    def _task_line(self, key: str) -> int | None:
        return self.lines.task.get(key, self.lines.top.get("task"))

    def _place(self, table: dict[str, Any], key: str) -> RoadPoint | None:
        place = table.get(key)
        if place is None:
            return None
        line, element = self._task_line(key), f"task.{key}"
        if not isinstance(place, dict) or set(place) != {"road", "lane", "s"}:
            self.find("place", line, element, f"{key} must be a place", allowed='{ road = "1", lane = -1, s = 420.0 }')
            return None
        road, lane, s = place["road"], place["lane"], place["s"]
        if not isinstance(road, str):
            self.find("value", line, f"{element}.road", "road must be an id in quotes", found=str(road))
        elif isinstance(lane, bool) or not isinstance(lane, int) or lane == 0:
            self.find(
                "value",
                line,
                f"{element}.lane",
                "lane must be a lane id",
                found=str(lane),
                allowed="whole number except 0",
            )
        elif not _finite(s) or s < 0:
            self.find("value", line, f"{element}.s", "s must be a distance", found=str(s), allowed="finite, >= 0 [m]")
        else:
            return RoadPoint(road, lane, float(s))
        return None

    def _gate(self, table: dict[str, Any], index: int) -> Gate | None:
        before = len(self.findings)
        head, keys = self.lines.gates[index] if index < len(self.lines.gates) else (self.lines.top.get("gate"), {})
        element = f"gate[{index + 1}]"
        chosen = self._metric(table, keys.get("metric", head), element)
        bounds = {
            key: self._bound(table, key, keys.get(key, head), element) for key in ("max", "min", "max_difference")
        }
        if not any(key in table for key in bounds):
            self.find("no_bound", head, element, "a gate needs a bound", allowed="max, min or both")
        low, high = bounds["min"], bounds["max"]
        if low is not None and high is not None and low > high:
            self.find(
                "min_over_max",
                keys.get("min", head),
                f"{element}.min",
                f"min {low:g} is greater than max {high:g}",
            )
        stages = self._stages(table, "stages", keys.get("stages", head), element)
        between = self._stages(table, "between", keys.get("between", head), element)
        if between is not None and (len(between) != 2 or between[0] == between[1]):
            self.find("between", keys.get("between", head), f"{element}.between", "between needs two different stages")
            between = None
        options = {key: value for key, value in table.items() if key not in GATE_KEYS}
        if chosen is not None:
            self._options(chosen, options, keys, head, element)
            wrong = _two_stages(chosen, table)
            if wrong:
                self.find("between", keys.get("between", head), element, wrong)
        if "model" in options:
            model = model_file(options["model"], Path(self.file).parent)
            if isinstance(model, str):
                line = keys.get("model", head)
                self.find("model", line, f"{element}.model", model, found=str(options["model"])[:200])
            options["model"] = str(model)
        if "requirement" in table:
            wrong = wrong_requirement(table["requirement"])
            if wrong:
                self.find("requirement", keys.get("requirement", head), f"{element}.requirement", wrong)
        if "parameters" in table:
            wrong = wrong_parameters(table["parameters"])
            if not wrong and "between" not in table:
                wrong = 'parameters are for a gate between stages: between = ["dt", "rw"]'
            if wrong:
                self.find("parameters", keys.get("parameters", head), f"{element}.parameters", wrong)
        if "clean" in table:
            wrong = wrong_conditions(table)
            if wrong:
                self.find("clean", keys.get("clean", head), f"{element}.clean", wrong)
        if len(self.findings) > before or chosen is None:
            return None
        pair = (between[0], between[1]) if between else None
        apart = bounds["max_difference"]
        return Gate(
            chosen.name,
            high,
            low,
            stages or (STAGES if "clean" not in table else ("dt",)),
            pair,
            options,
            self.file,
            head,
            max_difference=apart,
            requirement=str(table.get("requirement", "")),
            parameters=tuple(table.get("parameters", ())),
            only_with=table.get("clean"),
        )

    def _metric(self, table: dict[str, Any], line: int | None, element: str) -> Metric | None:
        name = table.get("metric")
        if not isinstance(name, str):
            self.find("no_metric", line, element, 'a gate needs a metric: metric = "collision" (or model = "car.toml")')
            return None
        try:
            return find_metric(name)
        except MetricError:
            names = list(known_metrics())
            hint = nearest(name, names)
            allowed = "" if hint else ", ".join(sorted(names))
            self.find(
                "unknown_metric", line, f"{element}.metric", f"unknown metric {name[:80]!r}", allowed=allowed, hint=hint
            )
            return None

    def _bound(self, table: dict[str, Any], key: str, line: int | None, element: str) -> float | None:
        if key not in table:
            return None
        value = table[key]
        if not _finite(value):
            self.find(
                "bound", line, f"{element}.{key}", f"{key} must be a finite number", found=str(value)
            )  # a NaN or infinite bound would never fail
            return None
        return float(value)

    def _stages(self, table: dict[str, Any], key: str, line: int | None, element: str) -> tuple[Stage, ...] | None:
        if key not in table:
            return None
        names = table[key]
        if not isinstance(names, list) or not names:
            self.find("stages", line, f"{element}.{key}", f"{key} must be a list of stages", allowed=", ".join(STAGES))
            return None
        known = tuple(stage for name in names for stage in STAGES if stage == name)
        for name in names:
            if name not in STAGES:
                hint = nearest(str(name), STAGES)
                self.find(
                    "unknown_stage",
                    line,
                    f"{element}.{key}",
                    f"unknown stage {str(name)[:80]!r}",
                    allowed=", ".join(STAGES),
                    hint=hint,
                )
        return known or None

    def _options(
        self, chosen: Metric, options: dict[str, Any], keys: dict[str, int], head: int | None, element: str
    ) -> None:
        for key in options:
            if key not in chosen.options:
                valid = (*GATE_KEYS, *chosen.options)
                hint = nearest(key, valid)
                self.find(
                    "unknown_key",
                    keys.get(key, head),
                    f"{element}.{key}",
                    f"unknown key {key[:80]!r}",
                    allowed=", ".join(valid),
                    hint=hint,
                )
                return
        try:
            check_options(chosen, options)
        except MetricError as error:
            line = next((keys[key] for key in options if key in keys and repr(key) in str(error)), head)
            self.find("option", line, element, str(error))
            return
        for key in ("signal", "command"):
            wrong = wrong_signal(chosen.name, options[key]) if key in options else None
            if wrong is not None:
                line, where = keys.get(key, head), f"{element}.{key}"
                self.find("unknown_signal", line, where, wrong.text, allowed=wrong.allowed, hint=wrong.hint)


def _two_stages(chosen: Metric, table: dict[str, Any]) -> str:
    """What is wrong with how a gate names its stages; empty if nothing is."""
    apart, between = "max_difference" in table, "between" in table
    if chosen.logs == 2 and not between:
        return f'{chosen.name} compares two logs: say which, between = ["dt", "rw"]'
    if chosen.logs == 2 and apart:
        return f"{chosen.name} compares two logs already: bound it with max and min"
    if chosen.logs == 1 and between and not apart:
        return (
            f"{chosen.name} is a metric of one log: with between, say by how much it may differ: max_difference = 0.5"
        )
    if apart and not between:
        return 'max_difference is between two stages: say which, between = ["dt", "rw"]'
    if apart and ("max" in table or "min" in table):
        return "max_difference stands alone: max and min are for a gate of its own, without between"
    if between and "stages" in table:
        return "between names the stages already: leave out stages"
    if apart and isinstance(table["max_difference"], int | float) and table["max_difference"] < 0:
        return "max_difference must be >= 0"
    return ""


def _finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
