"""Drives a stack with and without faults, and keeps what each drive gave, so that nothing is driven twice."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from pytest_dvp.mutation.catalogue import known_faults

FORMAT = 1  # of a kept drive


@dataclasses.dataclass(frozen=True)
class Drive:
    """One drive to do: scenario file, stack as `--ads` takes it, seed, and the fault's name ("" for a clean one)."""

    scenario: str
    ads: str
    seed: int
    fault: str = ""

    @property
    def key(self) -> str:
        """Digest of all that the drive depends on but our own code: files of scenario, gates and stack, seed, fault."""
        told = hashlib.sha256(f"{FORMAT}|{self.seed}|{self.fault}|{self.ads}|{self.scenario}".encode())
        path = Path(self.scenario)
        stack = Path(self.ads.rpartition(":")[0] or self.ads)
        for file in (path, path.with_suffix(".gates.toml"), stack):
            told.update(file.read_bytes() if file.is_file() else b"-")
        return told.hexdigest()[:24]


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What a drive gave: its status, verdicts by gate (text -> status) and all metrics (None: undefined)."""

    status: str
    gates: Mapping[str, str]
    metrics: Mapping[str, float | None]

    @property
    def failed(self) -> list[str]:
        """Gates that did not pass; the run itself, if no gate says why it failed."""
        found = [gate for gate, status in self.gates.items() if status != "PASS"]
        return found or ([] if self.status == "PASS" else [f"run: {self.status}"])


def driven(drives: Sequence[Drive], *, kept: Path | None, jobs: int, tick: Callable[[int, int], None]
           ) -> dict[Drive, Outcome]:  # fmt: skip
    """The outcome of each drive. kept: a file of lines, one a drive, from which finished ones are taken and to which
    new ones are added; jobs: processes. tick is told how many are done, of how many."""
    known = dict(_kept(kept)) if kept is not None else {}
    found = {drive: known[drive.key] for drive in drives if drive.key in known}
    open_ones = [drive for drive in dict.fromkeys(drives) if drive not in found]
    tick(len(found), len(drives))
    for drive, outcome in zip(open_ones, _outcomes(open_ones, jobs), strict=True):
        found[drive] = outcome
        if kept is not None:
            line = json.dumps({"key": drive.key, **dataclasses.asdict(drive), **dataclasses.asdict(outcome)})
            with kept.open("a", encoding="utf-8") as file:
                file.write(line + "\n")
        tick(len(found), len(drives))
    return found


def _kept(path: Path) -> Iterator[tuple[str, Outcome]]:
    if not path.exists():
        return
    for line in path.read_text("utf-8").splitlines():
        try:
            row = json.loads(line)
            yield row["key"], Outcome(row["status"], row["gates"], row["metrics"])
        except (ValueError, KeyError, TypeError):
            continue  # a line that a kill cut in two: that drive is driven again


def _outcomes(drives: Sequence[Drive], jobs: int) -> Iterable[Outcome]:
    if jobs < 2 or len(drives) < 2:
        return map(drive_once, drives)
    return _in_processes(drives, jobs)


def _in_processes(drives: Sequence[Drive], jobs: int) -> Iterator[Outcome]:
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        yield from pool.map(drive_once, drives, chunksize=4)


def drive_once(drive: Drive) -> Outcome:
    """One drive in this process, without a run folder. Raises AdsError or ScenarioError for what cannot be driven."""
    from pytest_dvp.drive.run import run
    from pytest_dvp.drive.stack_host import find_ads
    from pytest_dvp.mutation.faulty_stack import behind

    ads = find_ads(drive.ads, process="off")
    stack: Any = behind(ads, known_faults()[drive.fault]) if drive.fault else ads
    result = run(drive.scenario, ads=stack, seed=drive.seed)
    gates = {verdict.gate: verdict.status for verdict in result.verdicts}
    return Outcome(result.status, gates, dict(result.metrics))
