"""Writes the intact part of a damaged log (CSV or MCAP) to a new file, and says how much was lost."""

from __future__ import annotations

import argparse
import dataclasses
import json
from pathlib import Path

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, existing, new_file

PLACE = 150  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the damaged log and the new file."""
    parser.add_argument(
        "log",
        metavar="LOG",
        help="cut or damaged .csv or .mcap file, or the folder of a run (it may have been killed)",
    )
    parser.add_argument("--out", required=True, metavar="FILE", help="new file of the same kind")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Write the intact part of a log. Returns 0.

    Raises WrongArgument for a kind of log that cannot be recovered, or a new file of another kind.
    """
    from pytest_dvp.logs.recovery import KINDS, kind_of, recover
    from pytest_dvp.logs.unfinished_run import LOG, PART

    path, out = Path(arguments.log), Path(arguments.out)
    if path.is_dir():
        path = next((path / name for name in (LOG, PART) if (path / name).is_file()), path)
    existing(str(path), "log")
    kind = kind_of(path)
    if kind not in KINDS:
        raise WrongArgument(f"{path}: not a kind of log that can be recovered; allowed: {', '.join(KINDS)}")
    new_file("--out", arguments.out, [path])
    if out.suffix.lower() != kind:
        raise WrongArgument(f"--out {out}: the new file is of the same kind, {kind}")
    found = recover(path, out)
    if arguments.json:
        print(json.dumps({"log": str(path), "out": str(out), **dataclasses.asdict(found)}, ensure_ascii=False))
        return 0
    print(f"{out}: {found.kept} {found.unit} over {found.seconds:.6g} s are whole and kept")
    for text in found.lost or ("nothing: the file is whole",):
        print(f"  lost: {text}")
    return 0
