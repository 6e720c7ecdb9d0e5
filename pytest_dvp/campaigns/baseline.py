"""Two campaigns held against each other: what passed before and fails now, and which margins shrank."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pytest_dvp.campaigns.store import Row

RISK = 0.01  # that any gate is said to have a smaller margin by chance alone, over all gates of a comparison
SHOWN = 10  # variants that the text lists


@dataclasses.dataclass(frozen=True)
class Shrunk:
    """A gate whose margins became smaller: median change in the gate's unit, of how many pairs, and the p-value."""

    gate: str
    change: float
    pairs: int
    p: float


@dataclasses.dataclass(frozen=True)
class Comparison:
    """pairs: variants that both campaigns drove; worse: passed before and fail now; better: the reverse; undecided:
    passed before and decide nothing now; shrunk: gates with smaller margins."""

    pairs: int
    worse: tuple[Row, ...]
    better: tuple[Row, ...]
    undecided: tuple[Row, ...]
    shrunk: tuple[Shrunk, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "pairs": self.pairs,
            **{
                name: [{"key": row.key, "parameters": row.parameters, "message": row.message} for row in rows]
                for name, rows in (("worse", self.worse), ("better", self.better), ("undecided", self.undecided))
            },
            "shrunk": [dataclasses.asdict(each) for each in self.shrunk],
        }

    def text(self) -> str:
        """The comparison for a terminal."""
        lines = [
            f"{self.pairs} variants driven before and now: {len(self.worse)} passed before and fail now, "
            f"{len(self.better)} the reverse, {len(self.undecided)} passed before and decide nothing now"
        ]
        for row in self.worse[:SHOWN]:
            values = ", ".join(f"{name}={value}" for name, value in row.parameters.items())
            lines.append(f"  fails now: {values}: {row.message}")
        lines += [f"  and {len(self.worse) - SHOWN} more"] if len(self.worse) > SHOWN else []
        for each in self.shrunk:
            lines.append(
                f"  margin of {each.gate}: median change {each.change:.3g} in {each.pairs} pairs, p {each.p:.1g}"
            )
        return "\n".join(lines)


def compared(before: Sequence[Row], now: Sequence[Row]) -> Comparison:
    """Pairs of the same scenario, parameters and seed, whatever code drove them.

    A margin has shrunk where a sign test over the pairs that differ says so at RISK over all gates: it asks nothing of
    the distribution of the changes. Source: Conover, Practical Nonparametric Statistics, 3rd edition, section 3.4.
    """
    from scipy.stats import binomtest

    old = {_same(row): row for row in before}
    pairs = [(old[_same(row)], row) for row in now if _same(row) in old]
    passed = [(a, b) for a, b in pairs if a.verdict == "PASS"]
    gates = sorted({gate for a, b in pairs for gate in a.margins.keys() & b.margins.keys()})
    shrunk = []
    for gate in gates:
        both = [(a.margins.get(gate), b.margins.get(gate)) for a, b in pairs]
        changes = np.array([new - was for was, new in both if was is not None and new is not None and new != was])
        if len(changes):
            p = float(binomtest(int((changes < 0.0).sum()), len(changes), alternative="greater").pvalue)
            if p < RISK / len(gates):
                shrunk.append(Shrunk(gate, float(np.median(changes)), len(changes), p))
    return Comparison(
        len(pairs),
        tuple(b for _, b in passed if b.failed),
        tuple(b for a, b in pairs if a.failed and b.verdict == "PASS"),
        tuple(b for _, b in passed if b.verdict == "INCONCLUSIVE"),
        tuple(shrunk),
    )


def _same(row: Row) -> str:
    return json.dumps([Path(row.scenario).name, row.parameters, row.seed], sort_keys=True)
