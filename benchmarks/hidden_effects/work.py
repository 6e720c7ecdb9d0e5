"""One case asked: its logs made, diagnosed, and the answer kept as one JSON-able line."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any

from benchmarks.hidden_effects.case import Case
from benchmarks.hidden_effects.truth import Question, question
from pytest_dvp.doctor.examine import examine

KEPT = (
    "verdict",
    "effects",
    "not_excited",
    "error",
    "chi2_per_n",
    "noise_floor",
    "signature",
    "vetoed",
    "refused",
    "cpu",
)
Diagnose = Callable[[Question], Mapping[str, Any]]


def by_the_tool(asked: Question) -> Mapping[str, Any]:
    """The answer of `dvp diagnose --json`; logs that the doctor finds errors in are refused, as the command does."""
    from pytest_dvp.gap.diagnose.diagnose import diagnose

    for name, log in asked.logs.items():
        for finding in examine(log, file=name):
            if finding.severity == "error":
                return {"verdict": "REFUSED", "effects": [], "refused": f"{finding.code}: {finding}"}
    begin = time.process_time()
    found = diagnose(asked.logs, asked.model, held_out=asked.held_out or None)
    return {**found.as_dict(), "cpu": round(time.process_time() - begin, 3)}


def ask(case: Case, diagnose: Diagnose = by_the_tool) -> dict[str, Any]:
    """The record of a case. A diagnosis that raises is a record, too: verdict "ERROR"."""
    line: dict[str, Any] = {
        "key": case.key,
        "base_seed": case.base_seed,
        "category": case.category,
        "names": list(case.names),
        "off": case.off,
        "noise": case.noise,
        "dirt": case.dirt,
        "car": case.car,
    }
    asked = question(case)
    if asked is None:
        return line | {"verdict": "UNDETECTABLE", "truth": {}, "effects": []}
    line |= {"truth": asked.truth, "gains": asked.gains}
    try:
        answer = dict(diagnose(asked))
    except Exception as error:  # what a user would see as a traceback is a result of the benchmark
        text = str(error).splitlines() or [""]
        answer = {"verdict": "ERROR", "effects": [], "refused": f"{type(error).__name__}: {text[0]}"}
    return _finite(line | {key: answer[key] for key in KEPT if key in answer})


def _finite(value: Any) -> Any:
    """JSON has no infinity."""
    if isinstance(value, Mapping):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def warm_up() -> None:
    """A worker compiles and loads before anything is timed. Here, as a spawned worker cannot find names of __main__."""
    ask(Case("null", (), 0, "mid", base_seed=1))
