"""Joins several files of one drive, such as one CSV a topic, into one log by their clocks."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from pytest_dvp.cli.doctor import existing_log
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, new_file
from reports.whole_file import write_whole

PLACE = 145  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the files of one drive and the joined file."""
    parser.add_argument(
        "logs",
        nargs="+",
        metavar="LOG",
        help="files of one drive with one clock; where two have a column of one name, the first of them keeps it",
    )
    parser.add_argument("--out", required=True, metavar="FILE", help="new .csv file")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Join two or more files into one CSV. Returns 0.

    Raises WrongArgument for a single file, or if `--out` is no .csv file.
    """
    files = [Path(existing_log(log, parts=False)) for log in arguments.logs]
    out = new_file("--out", arguments.out, files)
    if len(files) < 2:
        raise WrongArgument(f"{files[0]}: one file only; allowed: two or more files of one drive")
    if out.suffix.lower() != ".csv":
        raise WrongArgument(f"--out {out}: a CSV file is written; allowed: a name that ends in .csv")
    from pytest_dvp.logs.joining import join, text_of

    found = join(files)
    write_whole(out, text_of(found).encode())
    if arguments.json:
        told = {"out": str(out), "rows": len(found.t), "seconds": float(found.t[-1]), "origin": found.origin}
        told |= {"files": found.rows, "renamed": found.renamed, "left_out": found.left_out}
        told |= {"time_unit_guessed": found.guessed, "time_column_guessed": found.clocks}
        print(json.dumps(told, ensure_ascii=False))
        return 0
    print(
        f"{out}: {len(found.t)} stamps over {found.t[-1]:.6g} s from {len(files)} files; t = 0 is {found.origin:.6f} s"
    )
    for file, rows in found.rows.items():
        repeated = found.left_out.get(file)
        print(f"  {file}: {rows} rows" + (f"; {repeated} with a repeated stamp are left out" if repeated else ""))
    for file, column in found.clocks.items():
        print(f"  {file}: no column is called a time; {column} is taken for it, because it rises evenly")
    for file, unit in found.guessed.items():
        print(f"  {file}: its time does not say its unit; taken for {unit} by the steps from row to row")
    if found.renamed:
        new = ", ".join(found.renamed.values())
        print(f"  called after their file, because an earlier file has a column of that name: {new}")
    return 0
