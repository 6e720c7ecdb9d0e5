"""A drive of a stack with or without a fault, as a job of the workers: kept by all that decides its outcome."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

from pytest_dvp.mutation.catalogue import known_faults
from pytest_dvp.mutation.needs import met
from pytest_dvp.mutation.source_mutants import WORD, mutant_named, planted
from pytest_dvp.workers.job import Job


@dataclasses.dataclass(frozen=True, slots=True)
class Drive(Job):
    """One drive; fault: its name, "" for a clean drive."""

    fault: str = ""

    @property
    def title(self) -> str:
        """For progress: `overtaking dt seed 7, ghost`."""
        plain = Job.title.fget(self)  # type: ignore[attr-defined]
        return f"{plain}, {self.fault}" if self.fault else str(plain)


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What a drive gave: its status, verdicts by gate (text -> status) and all metrics (None: undefined).
    clean: those of the gates that are no requirements but bounds of clean drives; met: what the drive met
    of what faults need."""

    status: str
    gates: Mapping[str, str]
    metrics: Mapping[str, float | None]
    clean: Sequence[str] = ()
    met: Sequence[str] = ()

    @property
    def failed(self) -> list[str]:
        """Gates that did not pass; the run itself, if no gate says why it failed."""
        found = [gate for gate, status in self.gates.items() if status != "PASS"]
        return found or ([] if self.status == "PASS" else [f"run: {self.status}"])


def drive_once(drive: Drive) -> dict[str, Any]:
    """The fields of the Outcome of a drive, without a run folder. Runs in a worker process.

    Raises AdsError or ScenarioError for what cannot be driven.
    """
    from pytest_dvp.drive.run import run
    from pytest_dvp.drive.stack_host import find_ads
    from pytest_dvp.mutation.faulty_stack import behind

    ads = find_ads(drive.ads, process="off")
    of_source = drive.fault.startswith(f"{WORD} ")
    stack: Any = behind(ads, known_faults()[drive.fault]) if drive.fault and not of_source else ads
    with planted(mutant_named(drive.fault)) if of_source else contextlib.nullcontext():
        result = run(drive.scenario, ads=stack, seed=drive.seed)
    gates = {verdict.gate: verdict.status for verdict in result.verdicts}
    metrics = {name: _finite(value) for name, value in result.metrics.items()}
    return {
        "status": result.status, "gates": gates, "metrics": metrics, "met": met(result.log, metrics),
        "clean": [verdict.gate for verdict in result.verdicts if verdict.clean],
    }  # fmt: skip


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
