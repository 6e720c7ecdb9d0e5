"""Runs that several tests of one session need: whoever needs one first drives it, the others read its log.

A folder of the session, shared by the workers of xdist; a lock file a run, which the system frees when a worker dies.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import json
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pytest_dvp.drive.result import RunResult


class SharedRuns:
    """The runs of one session, in `folder`."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def own(self, key: str, drive: Callable[[], RunResult]) -> RunResult:
        """The run of a test that is about this run: driven now, unless another test had to drive it before.

        Each run stands for one such test only: a test that is repeated drives again.
        """
        with self._locked(key) as file:
            entry = _read(file)
            if entry is not None and not entry["owned"]:
                result = _result(entry)
                if result is not None:
                    _write(file, {**entry, "owned": True})
                    return result
            result = drive()
            _keep(file, result, owned=True)
            return result

    def shared(self, key: str, drive: Callable[[], RunResult] | None) -> RunResult | None:
        """A run that another test may have made, driven now if none has; None if it is not to be driven (`drive`)."""
        with self._locked(key) as file:
            entry = _read(file)
            result = None if entry is None else _result(entry)
            if result is not None or drive is None:
                return result
            result = drive()
            _keep(file, result, owned=False)
            return result

    @contextlib.contextmanager
    def _locked(self, key: str) -> Iterator[Path]:
        import fcntl

        self._folder.mkdir(parents=True, exist_ok=True)
        with (self._folder / f"{key}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield self._folder / f"{key}.json"


def key_of(*parts: object) -> str:
    """Name of a run from all that it depends on within one session."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:32]


def _keep(file: Path, result: RunResult, *, owned: bool) -> None:
    if result.folder is not None:
        plain = result.as_dict()
        with contextlib.suppress(OSError):  # of a disk that is full: who else needs the run drives it again
            _write(file, {"owned": owned, "place": str(result.folder.absolute()), "result": plain})


def _write(file: Path, entry: dict[str, Any]) -> None:
    partial = file.with_suffix(".part")
    partial.write_text(json.dumps(entry), encoding="utf-8")
    os.replace(partial, file)


def _read(file: Path) -> dict[str, Any] | None:
    try:
        found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    return found


def _result(entry: dict[str, Any]) -> RunResult | None:
    """The run as it was; None if somebody has removed its folder since."""
    from pytest_dvp.drive.result import RunResult
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.log_error import LogError
    from pytest_dvp.verdicts.judging import Verdict

    place, plain = Path(entry["place"]), dict(entry["result"])
    try:
        log = Log.load(place)
    except LogError:
        return None
    plain.pop("simulated")
    plain["verdicts"] = tuple(Verdict(**verdict) for verdict in plain["verdicts"])
    plain.update({name: tuple(plain[name]) for name in ("notes", "findings", "events", "never_fired")})
    log = dataclasses.replace(log, tick_time=plain["tick_time"])
    return RunResult(**{**plain, "log": log, "folder": place})
