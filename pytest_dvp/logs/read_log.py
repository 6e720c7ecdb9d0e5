"""read_log: any log file -> Log. The one entrance; a format is one module in `formats/`."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence
from pathlib import Path

from openscenario.findings import Finding, Findings, listed
from pytest_dvp.logs.budget import Budget
from pytest_dvp.logs.file_kind import refuse_other_kind
from pytest_dvp.logs.formats.log_format import format_of_kind, log_formats
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.log_part import cut_log, parse_argument
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.table import build_log
from pytest_dvp.logs.unfinished_run import told_of


def read_log(
    argument: str | Path, *, mapping: Path | None = None, msg_dirs: Sequence[Path] = (), strict: bool = True,
    partial: bool = False, budget: Budget | None = None,
) -> Log:  # fmt: skip
    """The log that `argument` names: a file, a bag's folder, or a part of one, `LOG@0:285` (seconds).

    mapping   TOML file that says which field of the file is which signal (see `dvp map`); needed for what names no unit
    msg_dirs  folders with the .msg files of custom ROS types
    partial   the mapping was made for another file: what fits is used, the rest recognised
    budget    how large the log may be; None: the budget of the command or session
    strict    False (the doctor): keep errors of the time base as findings instead of raising

    `meta["import"]` of the result says what was converted, aliased and kept unknown, and holds the warnings.
    Raises LogError: one line with file, line, column and code; all findings in `.findings`.
    """
    part = parse_argument(argument)
    try:
        log = _whole(part.path, mapping, msg_dirs, strict, partial, budget)
    except MemoryError:
        raise LogError(f"{part.path}: the log does not fit into memory", "log.too_large") from None
    return log if part.whole else cut_log(log, part.start, part.stop, str(part.path))


def kind_of(path: Path) -> str:
    """Format of a file or folder by its name. Raises LogError for none that is known."""
    if unfinished := told_of(path):
        raise LogError(unfinished, "log.unreadable")
    if path.is_dir():
        if (path / "log.mcap").is_file():
            return "run"
        for one in log_formats():
            if one.folder and (path / one.folder).is_file():
                return one.kind
        raise LogError(
            f"{path}: a folder, but neither a run (log.mcap) nor a ROS 2 bag (metadata.yaml){_hint(path)}",
            "log.unreadable",
        )
    if not path.exists():
        raise LogError(f"{path}: no such log", "log.unreadable")
    kinds = {ending: one.kind for one in log_formats() for ending in one.endings}
    if path.suffix.lower() not in kinds:
        raise LogError(
            f"{path}: not a kind of log; allowed: {listed(list(kinds))}, a ROS bag's folder", "log.unknown_kind"
        )
    return kinds[path.suffix.lower()]


def _hint(folder: Path) -> str:
    """`; ...`: what makes a log of the files in a folder that is none; empty if nothing in it is of a log."""
    files = sorted(folder.iterdir())
    bags = [each for each in files if each.suffix.lower() in (".mcap", ".db3")]
    if len(bags) == 1 and bags[0].suffix.lower() == ".mcap":
        return f"; {bags[0]} can be read by itself"
    if bags:  # in parts, or in a kind that says nothing of its types
        return f"; `ros2 bag reindex {folder}` writes the metadata.yaml of the bag"
    if sum(each.suffix.lower() == ".csv" for each in files) > 1:
        return f"; several files of one drive become one log by `dvp join {folder}/*.csv --out drive.csv`"
    return ""


def read_streams(
    path: Path, findings: Findings, msg_dirs: Sequence[Path] = (), budget: Budget | None = None
) -> list[Stream] | Log:
    """What a file holds before any mapping; a log of ours, or what is left of one, is a Log already."""
    kind = kind_of(path)
    if kind == "run":
        path, kind = path / "log.mcap", "mcap"
    refuse_other_kind(path, kind)
    return format_of_kind(kind).read(path, findings, msg_dirs, budget)


def _whole(
    path: Path, mapping: Path | None, msg_dirs: Sequence[Path], strict: bool, partial: bool, budget: Budget | None
) -> Log:
    kind = kind_of(path)
    if kind == "run":
        path, kind = path / "log.mcap", "mcap"
    refuse_other_kind(path, kind)
    if kind == "mcap" and mapping is None:
        try:
            return Log.load(path, budget)
        except LogError as error:
            if error.code not in ("log.foreign", "log.truncated", "log.corrupt", "log.record_too_long", "log.not_mcap"):
                raise
    read_table = format_of_kind(kind).table
    if read_table is not None and mapping is None:
        log = build_log(read_table(path, budget), strict=strict)
    else:
        log = _mapped(path, kind, mapping, msg_dirs, strict, partial, budget)
    if path.is_file():
        log.meta["import"] |= {"file": path.name, "sha256": sha256(path)}
    return log


def _mapped(
    path: Path, kind: str, mapping: Path | None, msg_dirs: Sequence[Path], strict: bool, partial: bool,
    budget: Budget | None,
) -> Log:  # fmt: skip
    from pytest_dvp.logs.mapping import fitting, read_mapping, table_of
    from pytest_dvp.logs.mapping_proposal import certain, completed

    findings = Findings()
    chosen = read_mapping(mapping) if mapping is not None else None
    found = read_streams(path, findings, msg_dirs, budget)
    if isinstance(found, Log):
        if chosen is not None and not partial:
            findings.add(
                "log.mapping_unused", str(path), None, "", "a log of dvp names its signals: the mapping is not used",
                severity="warning",
            )  # fmt: skip
        told = [dataclasses.asdict(finding) for finding in findings.in_order()]
        found.meta["import"] = {"format": kind, "unknown": [], "findings": told}
        return found
    if chosen is not None and partial:
        chosen = fitting(chosen, found, str(path))
        if not chosen.signals:
            return _whole(path, None, msg_dirs, strict, partial, budget)
    try:
        whole = completed(chosen, found, str(path), kind) if chosen is not None else certain(found, str(path))
        table = table_of(found, whole, str(path), kind, findings)
    except LogError as error:
        if error.findings or not findings.found:
            raise
        last = Finding(error.code, "error", str(path), None, "", text=str(error))
        raise LogError(str(error), error.code, (*findings.in_order(), last)) from None  # the damage is told too
    table.notes["recognised"] = [signal.name for signal in whole.signals[len(chosen.signals) if chosen else 0 :]]
    return build_log(table, strict=strict)


def sha256(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
