"""Drives a recorded run again and compares the logs: equal bytes, or the first difference and its time."""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import shlex
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json
from pytest_dvp.logs.unfinished_run import told_of

PLACE = 50  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the run folder."""
    parser.add_argument("run", metavar="RUN", help="run folder, with log.mcap and result.json")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Drive a run again. Returns 0 if both logs have the same bytes, else 1.

    Raises WrongArgument for a folder without a log, and for a run that did not end.
    """
    folder = Path(arguments.run)
    from pytest_dvp.logs.log import Log

    if unfinished := told_of(folder):
        raise WrongArgument(unfinished)
    words = _command(folder)
    before = folder / "log.mcap"
    if not before.is_file():
        raise WrongArgument(f"{before}: no such log")
    Log.load(before)  # a damaged one is told before the drive
    print(f"dvp replay: {shlex.join(['dvp', *words])}", file=sys.stderr)
    with tempfile.TemporaryDirectory() as place:
        now = _drive(words, Path(place))
        same = before.read_bytes() == now.read_bytes()
        found = None if same else _difference(before, now)
    if arguments.json:
        first = None if found is None else {"t": found.t, "what": found.what, "before": found.before, "now": found.now}
        print(json.dumps({"run": str(folder), "same_bytes": same, "first_difference": first}, ensure_ascii=False))
    elif same:
        print(f"{folder}: the same bytes again")
    else:
        print(f"{folder}: {found or 'the same values, but other bytes: written by another version'}")
    return 0 if same else 1


def _command(folder: Path) -> list[str]:
    """The words after `dvp` that drive it again. Raises WrongArgument if there are none, or a real car would move."""
    from pytest_dvp.drive.announced_cars import refuse_repetition
    from pytest_dvp.drive.result_file import ResultFileError, read_result
    from pytest_dvp.drive.stages import StageError

    file = folder / "result.json"
    try:
        kept = read_result(file)
    except OSError as error:
        raise WrongArgument(f"{file}: {error.strerror}; a run's folder is expected") from None
    except ResultFileError as error:
        raise WrongArgument(str(error)) from None
    if kept.get("logs"):
        compared = ", ".join(kept["logs"].values())
        raise WrongArgument(f"{folder}: holds stages against each other; replay the runs: {compared}")
    said = kept.get("replay", "")
    if not said.startswith("dvp run "):
        raise WrongArgument(f"{folder}: {said or 'how it was driven is not said'}")
    from pytest_dvp.cli.dispatch import build_parser

    try:
        words = shlex.split(said)
        if {"-h", "--help"} & set(words):
            raise WrongArgument("dvp run: --help")
        plain: Any = build_parser().parse_args(words[1:])
    except ValueError as error:
        raise WrongArgument(f"{file}: replay is {said!r}, which is no command: {error}") from None
    try:
        for stage in str(plain.stage).split(","):
            refuse_repetition("dvp replay", stage, plain.vehicle or "surrogate")
    except StageError as error:
        raise WrongArgument(str(error)) from None
    return words[1:]


def _drive(words: list[str], place: Path) -> Path:
    from pytest_dvp.cli.command_line import main

    said = io.StringIO()
    with contextlib.redirect_stdout(said), _without_variables():
        code = main([*words, "--no-ini", "--runs", str(place)])  # the words are all that the run was driven by
    logs = sorted(place.glob("*/log.mcap"))
    if code == 2 or not logs:
        raise WrongArgument("it could not be driven again; run it from the folder it was run from")
    return logs[0]


@contextlib.contextmanager
def _without_variables() -> Iterator[None]:
    """Without the variables of the environment that set an option of a run: another shell may have driven it."""
    from pytest_dvp.drive.run_spec import SETTINGS

    names = [setting.environment for setting in SETTINGS if setting.replay]
    kept = {name: os.environ.pop(name) for name in names if name in os.environ}
    try:
        yield
    finally:
        os.environ.update(kept)


def _difference(before: Path, now: Path) -> Any:
    from pytest_dvp.logs.difference import first_difference
    from pytest_dvp.logs.log import Log

    return first_difference(Log.load(before), Log.load(now))
