"""A campaign: points of a scenario's space become rows of the store, each driven once in its life."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from pytest_dvp.campaigns.one_drive import Drive
from pytest_dvp.campaigns.parameter_space import Shares, Space
from pytest_dvp.campaigns.store import EXCLUDED, SHRINKING, Row, Store
from pytest_dvp.drive.deadline import FIRST
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.text.names import REFERENCE

if TYPE_CHECKING:
    from pytest_dvp.workers.job import Job

NEAREST = 5  # passes nearest to a failure whose logs are kept
UNKEYED = ("log_dir", "rootdir", "passed", "single_file", "require_real", "stack_process", "wall_limit", "tick_limit")
"""Options that change no byte of a drive which they do not end."""
ENDED_BY_CLOCK = ("wall limit", "--wall-limit", "--tick-limit")
"""Words in the message of a drive that ended by one of the last two."""
FILES = ("model", "gates", "effects", "ads", "library")
"""Options that name files: the key holds the bytes of those, not where they lie."""
KEEP = ("failures", "all", "none")
"""Which logs are kept: those of failures and of the NEAREST passes, all, or none."""


class Crew(Protocol):
    """Who drives: processes of this machine (`crew.py`) or the workers of a scheduler (`cluster_crew.py`)."""

    def rows(self, drives: Iterable[Drive]) -> Iterator[Row]:
        """The row of each drive, in the order in which they end."""
        ...


@dataclasses.dataclass
class Progress:
    """What a campaign has done: `driven` now, `known` from before, `failed` of both, in seconds `since` it began.

    shrinking: drives that come on top and make a failure smaller; as in the answer, they count nowhere else.
    """

    wanted: int = 0
    driven: int = 0
    known: int = 0
    failed: int = 0
    vacuous: int = 0
    excluded: int = 0
    shrinking: int = 0
    since: float = dataclasses.field(default_factory=time.monotonic)

    def text(self) -> str:
        """`120 of 200 driven, 7 failed, 4.2/s, 19 s left`."""
        done, seconds = self.driven + self.known, time.monotonic() - self.since
        said = f"{done} of {max(self.wanted, done)} driven, {self.failed} failed"
        said += f", {self.vacuous} vacuous" if self.vacuous else ""
        said += f", {self.excluded} outside the constraints" if self.excluded else ""
        if self.shrinking:  # how many there will be is not known before
            return f"{said}; {self.shrinking} more to find the smallest variant of each kind of failure"
        if self.driven and seconds > 0.0:
            rate = self.driven / seconds
            said += f", {rate:.1f}/s, {max(self.wanted - done, 0) / rate:.0f} s left"
        return said


class Campaign:
    """Drives points of one space into a store.

    options  the settings of all drives; keep: one of KEEP; tick: is told of progress
    """

    def __init__(
        self, space: Space, settings: RunSpec, store: Store, crew: Crew, *, keep: str = "failures",
        tick: Callable[[str], None] = lambda text: None,
    ) -> None:  # fmt: skip
        self.space, self.settings, self.store, self.keep, self.tick = space, settings, store, keep, tick
        self._crew = crew
        self.options = run_options(space, settings)
        self.base = base_key(str(space.scenario), self.options)
        self.progress = Progress()
        self._commit = commit_of(settings.rootdir)
        passed = (row.objective for row in store.rows([self.base]) if row.log and not row.failed)
        self._nearest = sorted(value for value in passed if value is not None)

    def key(self, values: Mapping[str, str]) -> str:
        """The key of a drive with these values: 40 hex digits."""
        text = json.dumps([self.base, dict(values)], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:40]

    def rows(self, points: Sequence[Shares], purpose: str) -> list[Row]:
        """A row for each point, in their order; what the store has is not driven again."""
        return self.rows_of([self.space.values(point) for point in points], purpose)

    def rows_of(self, values: Sequence[Mapping[str, str]], purpose: str) -> list[Row]:
        """The same of values by parameter."""
        keys = [self.key(each) for each in values]
        found: dict[str, Row] = {}
        missing: dict[str, Drive] = {}
        for key, each in zip(keys, values, strict=True):
            if key in found or key in missing:
                continue
            kept = self.store.get(key)
            if kept is not None and self._had_less_time(kept):
                self.store.forget(key)
                kept = None
            if kept is not None:
                if SHRINKING == kept.purpose != purpose:
                    kept = dataclasses.replace(kept, purpose=purpose)
                    self.store.add(kept)
                found[key] = kept
                self._count(kept, known=True)
            else:
                missing[key] = Drive(
                    key, self.base, purpose, str(self.space.scenario), dict(each), self.options,
                    str(self.store.folder), self._commit,
                )  # fmt: skip
        self.tick(self.progress.text())
        for row in self._crew.rows(dataclasses.replace(each, keep=self._threshold()) for each in missing.values()):
            self.store.add(row)
            found[row.key] = row
            self._count(row, known=False)
            self._prune(row)
            self.tick(self.progress.text())
        return [found[key] for key in keys]

    def _had_less_time(self, row: Row) -> bool:
        """Whether a limit of wall time ended a drive, and is another one now."""
        if row.verdict != "ERROR" or not any(word in row.message for word in ENDED_BY_CLOCK):
            return False
        now = (self.settings.wall_limit, self.settings.tick_limit, FIRST * self.settings.tick_limit)
        return not any(f" {limit:g} s" in row.message for limit in now)

    def _count(self, row: Row, *, known: bool) -> None:
        if row.purpose == SHRINKING:
            self.progress.shrinking += not known
            return
        self.progress.known += known
        self.progress.driven += not known
        self.progress.failed += row.failed
        self.progress.vacuous += row.vacuous
        self.progress.excluded += row.verdict == EXCLUDED

    def _threshold(self) -> float | None:
        """Objective below which the log of a pass is worth keeping, as far as is known when it is handed out."""
        if self.keep == "none":
            return None
        if self.keep == "all" or len(self._nearest) < NEAREST:
            return float("inf")
        return self._nearest[NEAREST - 1]

    def _prune(self, row: Row) -> None:
        """Of passes only the nearest keep their logs."""
        if self.keep != "failures" or row.failed or not row.log or row.objective is None:
            return
        self._nearest = sorted([*self._nearest, row.objective])
        if len(self._nearest) > NEAREST:
            limit = self._nearest[NEAREST - 1]
            self._nearest = self._nearest[:NEAREST]
            for each in self.store.rows([self.base]):
                if each.log and not each.failed and each.objective is not None and each.objective > limit:
                    self.store.drop_log(each.key)


def run_options(space: Space, settings: RunSpec) -> dict[str, Any]:
    """The keywords of `pytest_dvp.run` that hold for all drives of a campaign."""
    told = {**settings.keywords(), "stage": "dt", "log_dir": None}
    if told.get("gates") is None and space.gates is not None:
        told["gates"] = space.gates
    return told


def base_key(scenario: str, options: Mapping[str, Any]) -> str:
    """Hash of all that decides a drive but its parameters: scenario and what lies beside it, stack, model, effects,
    gates, libraries, options, and the sources of this package."""
    from pytest_dvp.workers.job import file_digest

    job = job_of(scenario, options)
    ads = str(options["ads"])
    plain = {name: repr(value) for name, value in options.items() if name not in (*UNKEYED, *FILES)}
    plain["ads"] = "" if ads == REFERENCE or job.ads else ads
    plain["effects"] = repr([file_digest(str(file)) for file in options["effects"]])
    return hashlib.sha256(json.dumps([job.key, plain], sort_keys=True).encode()).hexdigest()[:40]


def job_of(scenario: str, options: Mapping[str, Any]) -> Job:
    """The files of a drive and its seed, as what simulates on other machines knows them."""
    from pytest_dvp.workers.job import Job

    ads = str(options["ads"])
    return Job(
        scenario,
        model=_text(options["model"]),
        gates=_text(options["gates"]),
        library=tuple(str(folder) for folder in options["library"]),
        ads=ads if ads.rpartition(":")[0].endswith(".py") else None,
        seed=int(options["seed"]),
    )


def commit_of(folder: Path) -> str:
    """The commit of a checkout, "+" behind it if files of it differ; "" outside of one or without git."""
    words = ["git", "-C", str(folder), "describe", "--always", "--abbrev=40", "--exclude=*", "--dirty=+"]
    try:
        return subprocess.run(words, capture_output=True, text=True, check=True, timeout=10.0).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""


def _text(value: object) -> str | None:
    return None if value is None else str(value)
