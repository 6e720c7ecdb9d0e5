"""Which verdicts of `model` gates change when the gates' model is replaced by another."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.gap.compare.compare import Comparison, compare
from pytest_dvp.gap.compare.match_bounds import BoundCheck, judge_bounds
from pytest_dvp.logs.log import Log
from pytest_dvp.verdicts.gate import Gate
from pytest_dvp.verdicts.model_gate import METRICS

if TYPE_CHECKING:
    from pytest_dvp.gap.compare.compared_model import ComparedModel
from pytest_dvp.gap.words.comparison import columns

KIND_OF = {metric: kind for kind, metric in METRICS.items()}


@dataclasses.dataclass(frozen=True, slots=True)
class GateChange:
    """One bound of one gate on one log, with the model as given and with the new one."""

    log: str
    file: str
    line: int | None
    before: BoundCheck
    after: BoundCheck

    @property
    def verdicts(self) -> tuple[str, str]:
        """PASS, FAIL or INCONCLUSIVE before and after."""
        return _verdict(self.before), _verdict(self.after)

    @property
    def changed(self) -> bool:
        """True if the verdict is another."""
        return self.verdicts[0] != self.verdicts[1]

    def as_dict(self) -> dict[str, Any]:
        """JSON-able."""
        before, after = self.verdicts
        return {
            "log": self.log, "gate": f"{self.before.kind} of {self.before.signal}", "bound": self.before.bound,
            "unit": self.before.unit, "file": self.file, "line": self.line,
            "before": {"verdict": before, "value": self.before.value},
            "after": {"verdict": after, "value": self.after.value},
        }  # fmt: skip


def gates_on(gates: Sequence[Gate], model: Path) -> list[Gate]:
    """The gates that hold a log against this model file."""
    named = [gate for gate in gates if gate.metric in KIND_OF and "model" in gate.options]
    return [gate for gate in named if Path(str(gate.options["model"])).resolve() == model.resolve()]


def gate_changes(
    gates: Sequence[Gate], logs: Mapping[str, Log], old: ComparedModel, new: ComparedModel
) -> list[GateChange]:
    """Each of the gates on each log, whatever the stage it is meant for."""
    found: list[GateChange] = []
    for name, log in logs.items():
        before, after = compare(log, old), compare(log, new)
        found += [GateChange(name, g.file, g.line, _judged(g, before), _judged(g, after)) for g in gates]
    return found


def _judged(gate: Gate, comparison: Comparison) -> BoundCheck:
    kind = KIND_OF[gate.metric]
    bound = gate.min if kind == "mncc" else gate.max
    limit = bound if bound is not None else (0.0 if kind == "mncc" else float("inf"))
    return judge_bounds(comparison, {kind: {str(gate.options["signal"]): limit}})[0]


def _verdict(judged: BoundCheck) -> str:
    if judged.value is None:
        return "INCONCLUSIVE"
    return "PASS" if judged.holds else "FAIL"


def change_lines(changes: Sequence[GateChange]) -> list[str]:
    """How many verdicts change, then a table of them."""
    changed = [change for change in changes if change.changed]
    rows = [["gate", "log", "", "before", "after", "bound"]]
    for change in changes:
        before, after = change.verdicts
        unit = "" if change.before.unit == "-" else f" {change.before.unit}"
        rows.append([
            f"{change.before.kind} of {change.before.signal}", change.log, "",
            f"{before}{_value(change.before.value)}", f"{after}{_value(change.after.value)}",
            f"{change.before.bound:.4g}{unit}",
        ])  # fmt: skip
    return [f"{len(changed)} of {len(changes)} gate verdicts change", *columns(rows)]


def _value(value: float | None) -> str:
    return "" if value is None else f" {value:.4g}"
