"""Looks for a law that no catalogue has in what a model leaves unexplained, and writes it as an effect file."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from pytest_dvp.cli.diagnose import read_all
from pytest_dvp.cli.doctor import add_log_options, existing_log, read_files
from pytest_dvp.cli.effects import add_effects, effects_from
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, new_file
from pytest_dvp.cli.shared.command_columns import check_command_columns
from pytest_dvp.cli.shared.forwarded_options import forwarded_options
from pytest_dvp.cli.shared.held_out_logs import refuse_same_drive, refuse_same_path
from pytest_dvp.cli.shared.progress import progress
from pytest_dvp.text.plain_json import finite

PLACE = 105  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare logs, model, held-out logs and the effect file to write."""
    parser.add_argument("logs", nargs="+", metavar="LOG", help="measured logs; a part of one as LOG@0:285 (seconds)")
    parser.add_argument("--model", required=True, metavar="M.toml", help="vehicle model that leaves an error")
    parser.add_argument(
        "--held-out", nargs="+", action="extend", required=True, metavar="LOG",
        help="logs that are not fitted on but judge the law",
    )  # fmt: skip
    parser.add_argument("--out", required=True, metavar="F.py", help="effect file of the law; not written for NO_LAW")
    add_log_options(parser)
    add_effects(parser)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Look for a law, and write it if one is found. Returns 0 with or without a law.

    Raises WrongArgument if a log is not there, `--out` is no .py file or one that is read, or the same log is fitted
    and held out.
    """
    texts = [existing_log(text) for text in (*arguments.logs, *arguments.held_out)]
    refuse_same_path(arguments.logs, arguments.held_out)
    out = new_file("--out", arguments.out, [*read_files(arguments, texts), arguments.model])
    if out.suffix != ".py":
        raise WrongArgument(f"--out {out}: an effect file is written; allowed: a name that ends in .py")
    from pytest_dvp.gap.discover.discover import discover
    from pytest_dvp.gap.discover.law_file import effect_text
    from pytest_dvp.gap.words.discovery import discovery_lines
    from reports.whole_file import write_whole
    from vehicle.model.model_file import read_model

    extra = effects_from(arguments)
    own = tuple(extra.values())
    model = read_model(arguments.model, extra=extra)
    logs, held_out = read_all(arguments.logs, arguments), read_all(arguments.held_out, arguments)
    refuse_same_drive(logs, held_out)
    check_command_columns("dvp discover", model, arguments.model, logs, held_out)
    with progress("dvp discover", "discovering") as tick:
        law = discover(logs, model, held_out, effects=own, tick=tick)
    written = None
    if law.verdict != "NO_LAW":
        names = [[Path(name).name for name in group] for group in (logs, held_out)]
        write_whole(out, effect_text(law, fitted=names[0], held_out=names[1], beside=own).encode())
        written = str(out)
    if arguments.json:
        print(json.dumps(finite(law.as_dict(written)), ensure_ascii=False))
    else:
        options = forwarded_options(arguments)
        given = (arguments.model, arguments.logs, arguments.held_out)
        print("\n".join(discovery_lines(law, written, *given, options, own)))
    return 0
