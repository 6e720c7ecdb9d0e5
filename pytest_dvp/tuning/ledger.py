"""The ledger: every iteration with its parameters, effects, metrics, what changed and why; JSON lines."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.text.plain_json import finite
from reports.whole_file import write_whole


@dataclasses.dataclass(frozen=True, slots=True)
class Entry:
    """One iteration; 0 is the beginning.

    P by stage, S: parameters in force after it; effects of the twin: name -> key -> value
    structure: verdict of the diagnosis, what was taken, what was refused; tuned: of S and P, score before and after,
    knobs that moved; suspicions of the guard; held_out: what the judge saw; training: the table of stages of the drives
    that were learnt from; changes: a sentence each, what changed and why
    accepted: "twin and stack", "twin", "stack", "" (nothing: the end)
    """

    number: int
    P: Mapping[str, Mapping[str, float]]
    S: Mapping[str, float]
    effects: Mapping[str, Mapping[str, float]]
    structure: Mapping[str, Any]
    tuned: Mapping[str, Any]
    suspicions: Sequence[Mapping[str, Any]]
    held_out: Mapping[str, Any]
    training: Mapping[str, Any]
    changes: Sequence[str]
    accepted: str
    simulations: int

    def as_dict(self) -> dict[str, Any]:
        """The fields as JSON holds them; numbers that are not finite are written as JSON can."""
        plain: dict[str, Any] = finite(dataclasses.asdict(self))
        return plain


def write_ledger(path: Path, entries: Sequence[Entry]) -> None:
    """One JSON document a line, an entry each; whole or not at all."""
    lines = [json.dumps(entry.as_dict(), ensure_ascii=False) for entry in entries]
    write_whole(path, ("\n".join(lines) + "\n").encode())
