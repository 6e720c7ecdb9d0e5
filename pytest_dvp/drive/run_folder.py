"""Run folders: runs/0042-overtaking-dt/ with log.mcap, result.json and report.html, each whole or not there at all.

While a run drives, its folder holds only `log.mcap.part` (`pytest_dvp.logs.partial_log`); what it leaves comes at the
end, at once.

The reports of a folder of runs share the library that draws (`reports/frame.py`), unless one file is asked for.
"""

from __future__ import annotations

import contextlib
import dataclasses
import os
import re
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import msgspec

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.unfinished_run import LOG, PART
from pytest_dvp.metrics import MetricValue, known_metrics
from pytest_dvp.metrics.metric import REQUIRED
from pytest_dvp.metrics.registry import measured
from pytest_dvp.text.paths import shown
from pytest_dvp.text.plain_json import finite
from pytest_dvp.verdicts.judging import Verdict, overall
from reports.whole_file import WriteError, write_whole

_NUMBERED = re.compile(r"\.?(\d{4,})[.-]")


class ResultError(ValueError):
    """A run folder cannot be written; the message is one line."""


class FinishedRun(Protocol):
    """What `save_run` needs of a run; RunResult of pytest_dvp.run is one."""

    @property
    def log(self) -> Log:
        """What was recorded."""
        ...

    @property
    def verdicts(self) -> Sequence[Verdict]:
        """One for each gate."""
        ...

    @property
    def status(self) -> str:
        """The status of the whole run in one word."""
        ...

    @property
    def scenario(self) -> str:
        """The scenario's name."""
        ...

    def as_dict(self) -> dict[str, Any]:
        """The content of result.json."""
        ...


@dataclasses.dataclass(frozen=True)
class Place:
    """The numbered folder of a run that drives: `folder` where it will stand, `hidden` where it is filled."""

    folder: Path
    hidden: Path

    @classmethod
    def reserve(cls, root: Path | str, name: str, stage: str) -> Place:
        """A new folder under `root`, NNNN-name-stage, empty yet. Raises ResultError if it cannot be made."""
        token, number = _reserve(Path(root))
        folder = Path(root) / f"{number:04d}-{_slug(name)}-{_slug(stage)}"
        try:
            folder.mkdir()
        except OSError as error:
            raise ResultError(_no_folder(Path(root), error)) from error
        finally:
            _remove(token)  # the folder holds the number from now on
        return cls(folder, folder.with_name(f".{number:04d}.{os.getpid()}.part"))

    def take_up(self) -> None:
        """Put what was filled where it stands; a part of the log there is needed no more. Raises OSError."""
        (self.folder / PART).unlink(missing_ok=True)
        self.hidden.rename(self.folder)  # over an empty folder, at once
        _sync_folder(self.folder.parent)

    def give_up(self) -> None:
        """Leave nothing but a part of the log, where there is one."""
        _remove(self.hidden)
        with contextlib.suppress(OSError):
            self.folder.rmdir()


@dataclasses.dataclass(frozen=True)
class Extent:
    """What of a run is written.

    brief        neither metrics nor a report, for a run that must end at once
    single_file  the report carries the library that draws
    lost         with it, a result or a report that cannot be written is left out, and one line a file is added to it
    """

    report: bool = True
    brief: bool = False
    single_file: bool = False
    lost: list[str] | None = None


def save_run(
    run: FinishedRun,
    root: Path | str,
    name: str | None = None,
    *,
    place: Place | None = None,
    brief: bool = False,
    single_file: bool = False,
    lost: list[str] | None = None,
) -> Path:
    """Write and return the numbered run folder of a finished run, called `name` or like the scenario: `write_run`."""
    more = {key: value for key, value in run.as_dict().items() if key not in ("folder", "metrics", "verdicts")}
    return write_run(
        root, name or Path(run.scenario).stem, run.log, run.verdicts, status=run.status, more=more, place=place,
        extent=Extent(brief=brief, single_file=single_file, lost=lost),
    )  # fmt: skip


def measure(log: Log) -> dict[str, MetricValue]:
    """All metrics of one log that need no option, with their defaults, by name, for tables and pictures."""
    return {
        name: measured(name, log)
        for name, chosen in known_metrics().items()
        if chosen.logs == 1 and REQUIRED not in chosen.options.values()
    }


def result_of(
    log: Log, verdicts: Sequence[Verdict], metrics: Mapping[str, MetricValue], *, status: str | None = None
) -> dict[str, Any]:
    """The result as plain JSON-able data, as result.json and the report hold it."""
    return {
        "status": status or overall(verdicts),
        "scenario": log.meta.get("scenario", ""),
        "stage": log.meta.get("stage", ""),
        "seed": log.meta.get("seed"),
        "verdicts": [verdict.as_dict() for verdict in verdicts],
        "metrics": {name: value.as_dict() for name, value in metrics.items()},
    }


def write_run(
    root: Path | str,
    name: str,
    log: Log,
    verdicts: Sequence[Verdict],
    *,
    status: str | None = None,
    more: Mapping[str, Any] | None = None,
    place: Place | None = None,
    extent: Extent | None = None,
) -> Path:
    """Write a new run folder under `root` and return it: NNNN-name-stage, numbers never used twice.

    Everything is written into a hidden folder first and renamed at the end, each file synced: a run that dies leaves
    no folder that looks like a result. `more` is added to the result. `place`: the folder that was reserved for it when
    it began to drive.
    Raises ResultError or LogError, and then leaves no run folder behind, or only the part of the log.
    """

    extent = extent or Extent()

    def fill(folder: Path) -> None:
        log.save(folder / LOG)
        metrics = {} if extent.brief else measure(log)
        result = {**(more or {}), **result_of(log, verdicts, metrics, status=status)}
        with _left_out(folder, final, extent.lost):
            write_result(folder / "result.json", result)
        if extent.report and not extent.brief:
            with _left_out(folder, final, extent.lost), _library(root, extent.single_file) as library:
                write_report(folder / "report.html", log, result, library=library)

    place = place or Place.reserve(root, name, str(log.meta.get("stage", "dt")))
    final = place.folder
    return _filled(place, fill)


@contextlib.contextmanager
def _left_out(folder: Path, final: Path, lost: list[str] | None) -> Iterator[None]:
    """A file that cannot be written is a line in `lost`, by the name that it would have had."""
    try:
        yield
    except OSError as error:
        if lost is None:
            raise
        lost.append(unwritten(error).replace(str(folder), shown(final)))


def unwritten(error: OSError | ValueError) -> str:
    """One line: which file could not be written, and why."""
    if not isinstance(error, OSError) or isinstance(error, WriteError):
        return str(error)
    return f"{error.filename or 'a file of the run'}: cannot be written: {error.strerror or error}"


def write_across(
    root: Path | str,
    name: str,
    result: Mapping[str, Any],
    logs: Mapping[str, Log],
    labels: Mapping[str, str],
    *,
    single_file: bool = False,
) -> Path:
    """Write the numbered folder of a comparison of stages, NNNN-name-dt-rw: result.json and report.html.

    `result` as from Across.as_dict; `logs` by stage, `labels` what results of a stage are called. The logs stay in
    their own folders. Raises ResultError, and then leaves nothing behind.
    """

    def fill(folder: Path) -> None:
        from reports.stages import write_stages_report

        write_whole(folder / "result.json", _json(result))
        courses = {labels[stage]: log.columns for stage, log in logs.items()}
        with _library(root, single_file) as library:
            write_stages_report(folder / "report.html", result, courses, library)

    return _filled(Place.reserve(root, name, str(result["stage"])), fill)


def _filled(place: Place, fill: Callable[[Path], None]) -> Path:
    """A run folder with what `fill` writes, whole or not at all."""
    try:
        place.hidden.mkdir()
        fill(place.hidden)
        place.take_up()
    except OSError as error:
        place.give_up()
        raise ResultError(f"{place.folder.parent}: the run cannot be written: {error}") from error
    except BaseException:
        place.give_up()
        raise
    return place.folder


def _remove(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)


def _no_folder(root: Path, error: OSError) -> str:
    return f"{root}: no run folder can be made: {error.strerror or error}"


def write_result(path: Path, result: Mapping[str, Any]) -> None:
    """Write result.json, by rename. `result` as from `result_of`, with whatever else is known of the run."""
    write_whole(path, _json(_without_series(result)))


def write_report(path: Path, log: Log, result: Mapping[str, Any], *, library: str | None = None) -> None:
    """Write report.html, by rename. `result` as from `result_of`; `library`: where the page finds what draws its
    charts, relative to the page; None: in itself."""
    from reports.html import write_run_report

    table = log.detections
    write_run_report(
        path,
        result,
        library=library,
        columns=log.columns,
        objects=[{"name": name, **_fields(track)} for name, track in log.objects.items()],
        detections=_fields(table),
        paths=list(log.paths),
        events=[dataclasses.asdict(event) for event in log.events],
        road=list(log.road),
        meta=log.meta,
    )


@contextlib.contextmanager
def report_library(folder: Path, *, single_file: bool) -> Iterator[str | None]:
    """Address of the library for a report that is written anew into a run folder; None: into the page itself.

    Only where the reports around it share one: a folder that was copied elsewhere gets a page that needs nothing.
    """
    from reports.frame import has_library

    root = folder.absolute().parent
    with _library(root, single_file or not has_library(root)) as library:
        yield library


@contextlib.contextmanager
def _library(root: Path | str, single_file: bool) -> Iterator[str | None]:
    """Address of the library for a page in a folder below `root`; it is put there once the page is written."""
    from reports.frame import library_address, place_library

    yield None if single_file else library_address()
    if not single_file:
        place_library(Path(root))


def _reserve(root: Path) -> tuple[Path, int]:
    """A hidden folder that owns its number: mkdir is atomic, and a finished run of that number makes it give way."""
    try:
        root.mkdir(parents=True, exist_ok=True)
        number = 1 + max((int(m[1]) for p in root.iterdir() if (m := _NUMBERED.match(p.name))), default=0)
        while True:
            hidden = root / f".{number:04d}.part"
            try:
                hidden.mkdir()
            except FileExistsError:
                number += 1
                continue
            # Another process may have finished this number between our look and our mkdir.
            if not any(root.glob(f"{number:04d}-*")):
                return hidden, number
            hidden.rmdir()
            number += 1
    except OSError as error:
        raise ResultError(_no_folder(root, error)) from error


def _fields(record: Any) -> dict[str, Any]:
    return {field.name: getattr(record, field.name) for field in dataclasses.fields(record)}


def _without_series(result: Mapping[str, Any]) -> dict[str, Any]:
    """The courses are in the log already; the result file stays small enough to read."""
    metrics = {name: {k: v for k, v in m.items() if k != "series"} for name, m in result["metrics"].items()}
    return {**result, "metrics": metrics}


def _json(data: Mapping[str, Any]) -> bytes:
    return msgspec.json.format(msgspec.json.encode(finite(data)), indent=2) + b"\n"


def _sync_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _slug(name: str) -> str:
    """ASCII letters, digits and dashes: safe in every shell and file system."""
    return re.sub(r"[^A-Za-z0-9_]+", "-", name).strip("-")[:60] or "run"
