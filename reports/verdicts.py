"""Verdicts in the order a reader wants them: what failed first, then what came closest to failing."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

SEVERITY = {"ERROR": 0, "FAIL": 1, "INCONCLUSIVE": 2, "PASS": 3, "NOT ASKED": 4}
HARM = {"collision": 1, "road_departure": 2}  # what a reader must learn first, however far the others missed
_LOWER = re.compile(r">= (-?[\d.]+(?:e[+-]?\d+)?)")  # the lower bound in the label of a gate
_TOLD = 1e-3  # to which a label tells a bound, as `pytest_dvp.verdicts.judging` rounds it
_RUN_ITSELF, _ANY_OTHER, _CLEAN = 0, 3, 4

STATUS_SIGNS = {"PASS": "✓", "FAIL": "✗", "INCONCLUSIVE": "?", "ERROR": "!"}


@dataclass(frozen=True)
class Row:
    """One verdict as the table shows it; value, bound and margin in `unit`, time in [s]."""

    metric: str
    name: str  # the metric, of a model with signal and file
    status: str
    value: float | None
    bound: float | None
    sign: str  # "≤" or "≥"
    unit: str
    margin: float | None
    t: float | None
    object: str
    message: str
    place: str
    share: float | None  # of the bound, as the verdict tells it
    requirement: str = ""  # id of what the gate verifies, as its file names it
    reason: str = ""  # why there is no value: the same for all rows that share it
    clean: bool = False  # a bound that clean drives keep, no requirement
    order: tuple[int, int, float] = (0, _ANY_OTHER, math.inf)  # `urgency`

    @property
    def used(self) -> float | None:
        """Share of the bound that is used up, 1 = at the bound; None where a share has no meaning (bound 0, counts)."""
        return None if self.value is None or self.is_count else self.share

    @property
    def is_folded(self) -> bool:
        """A bound of clean drives that holds: there are dozens, and a reader need not know them."""
        return self.clean and self.status == "PASS"

    @property
    def is_count(self) -> bool:
        """A yes-no or counting gate, such as no collision: at its bound is where it should be."""
        whole = self.value is None or float(self.value).is_integer()  # a ratio may have a bound of 3, a count is whole
        return self.bound == 0 or (
            self.bound is not None and float(self.bound).is_integer() and self.unit == "" and whole
        )

    @property
    def used_percent(self) -> float:
        """Length of the bar in the table [%]; 100 = at the bound."""
        share = self.used
        if share is None:
            return 0.0 if self.status == "PASS" else 125.0
        return max(0.0, min(share, 1.25)) * 100.0

    @property
    def shown_margin(self) -> float | None:
        """Margin, unless the gate only asks whether, and it did."""
        return None if self.is_count and self.status == "PASS" else self.margin

    @property
    def limit(self) -> str:
        """The bound with its sign, as `<= 1.5`; empty without one."""
        return "" if self.bound is None else f"{self.sign} {self.bound:g}"

    def mark(self) -> dict[str, Any]:
        """What the scrubber shows at the worst moment."""
        return {"t": self.t, "metric": self.name, "status": self.status, "object": self.object}


def urgency(verdict: Mapping[str, Any]) -> tuple[int, int, float]:
    """Sort key of a verdict, the worst first; the order of every text, table and page.

    By status; of what did not pass first the run itself (a fault, a dry run: it explains the others), then harm: a
    collision, a road departure; bounds of clean drives after all others. Then by what is left of the bound as a share,
    negative for a miss: margins of different units have nothing else in common.
    """
    status = str(verdict.get("status", "ERROR"))
    passed, order, metric = status == "PASS", SEVERITY.get(status, 0), verdict.get("metric", "-")
    if not metric and not passed:
        return order, _RUN_ITSELF, -math.inf
    other = _CLEAN if verdict.get("clean") is True else _ANY_OTHER
    return order, other if passed else HARM.get(str(metric), other), _left(verdict, passed=passed)


def _left(verdict: Mapping[str, Any], *, passed: bool) -> float:
    """Share of the bound that is left; infinite where no number says how near it was."""
    bound, margin = (_number(verdict.get(key)) for key in ("bound", "margin"))
    if passed and margin == 0.0:
        return math.inf  # 0 collisions of 0 allowed: it cannot be better
    share = _told_share(verdict)
    if share is not None:
        return 1.0 - share
    if margin is None:
        return math.inf
    return margin / abs(bound) if bound else margin


def rows(verdicts: Iterable[Mapping[str, Any]]) -> list[Row]:
    """The verdicts, worst first."""
    return sorted((_row(verdict) for verdict in verdicts), key=lambda row: row.order)


def headline(status: str, table: Sequence[Row]) -> str:
    """One sentence: did it pass, and what was closest to failing, when and by whom."""
    bad = [row for row in table if row.status != "PASS"]
    if not table:
        return "No gate was judged."
    if bad:
        worst = bad[0]
        if len(bad) > 1 and worst.reason and all(row.reason == worst.reason for row in bad):
            return f"{len(bad)} of {len(table)} gates were not judged: {worst.reason}."
        return f"{_missed(table)} Worst: {_moment(worst)}".lstrip()
    asked = [row for row in table if not row.clean]
    counted = "The gate passed." if len(asked) == 1 else f"All {len(asked)} gates passed."
    if len(asked) < len(table):
        bounds = len(table) - len(asked)
        counted = f"{counted[:-1]}, and so did {bounds} bound{'' if bounds == 1 else 's'} of clean drives."
    closest = next((row for row in asked if row.used is not None), None)
    if closest is None:
        return counted if status == "PASS" else f"{counted} Status: {status}."
    return f"{counted} Closest to failing: {_moment(closest)}"


def _missed(table: Sequence[Row]) -> str:
    """How many did not pass; bounds of clean drives are no gates, and what broke the run itself is neither."""
    said = []
    for one, several, counted in (
        ("the gate", "gates", [row for row in table if row.metric and not row.clean]),
        ("the bound of clean drives", "bounds of clean drives", [row for row in table if row.clean]),
    ):
        if bad := sum(row.status != "PASS" for row in counted):
            said.append(one if len(counted) == 1 else f"{bad} of {len(counted)} {several}")
    text = " and ".join(said)
    return f"{text[0].upper()}{text[1:]} did not pass." if text else ""


def _moment(row: Row) -> str:
    if not row.metric:  # the run itself: its message says what broke
        return f"{(row.message or row.name).rstrip('.')}."
    text = row.name
    if row.value is not None:
        text += f" {row.value:.3g} {row.unit}".rstrip()
    if row.bound is not None:
        text += f" (must be {row.limit})"
    if row.t is not None:
        text += f" at {row.t:.2f} s"
    if row.object:
        text += f", {row.object}"
    return text + "."


def pretty_unit(unit: object) -> str:
    """A unit as a reader writes it: m/s^3 -> m/s³, and nothing for none."""
    return "" if unit in (None, "-") else str(unit).replace("^2", "²").replace("^3", "³")


def _number(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return float(value) if isinstance(value, bool) else None
    return float(value)


def _is_least(gate: str, value: float | None, bound: float | None, margin: float | None) -> bool:
    """True if the bound is the lower one: of a gate with both, the margin tells which of them is meant."""
    if value is not None and bound is not None and margin is not None and value != bound:
        return abs(margin - (value - bound)) < abs(margin - (bound - value))
    lower = _LOWER.search(gate)
    if lower is not None and bound is not None and "<=" in gate:  # just at one of two bounds
        return math.isclose(float(lower[1]), bound, rel_tol=_TOLD)
    return ">" in gate or "≥" in gate


def _share(value: float | None, bound: float | None, *, least: bool) -> float | None:
    """Share of the bound, of a result that was written before verdicts told it."""
    if value is None or not bound:
        return None
    if least:
        return bound / value if value > 0 else None
    return value / bound


def _told_share(verdict: Mapping[str, Any]) -> float | None:
    """Share of the bound, as the verdict tells it."""
    if "used" in verdict:
        return _number(verdict["used"])
    value, bound, margin = (_number(verdict.get(key)) for key in ("value", "bound", "margin"))
    return _share(value, bound, least=_is_least(str(verdict.get("gate") or ""), value, bound, margin))


def _row(verdict: Mapping[str, Any]) -> Row:
    gate = verdict.get("gate")
    text = str(gate or "")
    numbers = (_number(verdict.get("value")), _number(verdict.get("bound")), _number(verdict.get("margin")))
    place = str(verdict.get("file") or "")
    if place and verdict.get("line"):
        place += f":{verdict['line']}"
    least = _is_least(text, *numbers)
    return Row(
        metric=str(verdict.get("metric", "")),
        name=str(verdict.get("name") or verdict.get("metric") or verdict.get("gate") or ""),
        status=str(verdict.get("status", "ERROR")),
        value=numbers[0],
        bound=numbers[1],
        sign="≥" if least else "≤",
        unit=pretty_unit(verdict.get("unit")),
        margin=numbers[2],
        t=_number(verdict.get("t")),
        object=str(verdict.get("object") or ""),
        message=str(verdict.get("message") or ""),
        place=place,
        share=_told_share(verdict),
        requirement=str(verdict.get("requirement") or ""),
        reason=str(verdict.get("reason") or ""),
        clean=verdict.get("clean") is True,
        order=urgency(verdict),
    )
