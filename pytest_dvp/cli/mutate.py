"""Puts faults between car and stack, and tells which of them the gates of the scenarios would not notice."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json
from pytest_dvp.cli.shared.named_scenarios import named_scenarios
from pytest_dvp.text.names import REFERENCE
from pytest_dvp.text.plain_json import finite
from pytest_dvp.text.spelling import unknown

PLACE = 45  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare scenarios, stack, faults, number of clean drives, processes and where results are kept."""
    parser.add_argument("scenarios", nargs="+", metavar="X.xosc", help="scenario, or a folder with scenarios")
    parser.add_argument("--ads", default=REFERENCE, metavar="NAME", help="driving stack, e.g. my_stack.py:Stack")
    parser.add_argument("--fault", nargs="+", action="extend", default=[], metavar="NAME", help="these faults only")
    parser.add_argument("--clean-seeds", type=int, default=20, metavar="N", help="drives without a fault; default: 20")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes; default: 1")
    parser.add_argument("--out", metavar="DIR", help="keep what was driven here; the same command again goes on")
    parser.add_argument("--write", action="store_true", help="add the proposed gates to the gate files")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Drive with each fault and tell which no gate notices. Returns 1 if a fault escapes, else 0.

    Raises WrongArgument for fewer than 2 clean drives or 1 process, an unknown fault, or an `--out` that is a file.
    """
    if arguments.clean_seeds < 2 or arguments.jobs < 1:
        raise WrongArgument("--clean-seeds takes 2 or more, --jobs 1 or more")
    scenarios = named_scenarios(arguments.scenarios)
    from pytest_dvp.mutation.catalogue import known_faults
    from pytest_dvp.mutation.gate_writer import write_gates
    from pytest_dvp.mutation.mutate import mutate
    from pytest_dvp.mutation.words import mutation_lines

    for name in arguments.fault:
        if name not in known_faults():
            raise WrongArgument(f"--fault: {unknown('fault', name, known_faults())}")
    kept = None
    if arguments.out is not None:
        folder = Path(arguments.out)
        if folder.exists() and not folder.is_dir():
            raise WrongArgument(f"--out {folder}: a file, expected a folder")
        folder.mkdir(parents=True, exist_ok=True)
        kept = folder / "drives.jsonl"

    def tick(done: int, of: int) -> None:
        if done == of or done % 10 == 0:
            print(f"\rdvp mutate: {done} of {of} drives", end="\n" if done == of else "", file=sys.stderr, flush=True)

    found = mutate(
        scenarios, arguments.ads, faults=arguments.fault, clean=arguments.clean_seeds, kept=kept, jobs=arguments.jobs,
        tick=tick,
    )  # fmt: skip
    if arguments.json:
        print(json.dumps(finite(found.as_dict()), ensure_ascii=False))
    else:
        print("\n".join(mutation_lines(found)))
    if arguments.write:
        for file in write_gates([one.proposed for one in found.judged if one.proposed is not None]):
            print(f"dvp mutate: {file} written", file=sys.stderr)
    return 1 if any(one.escaped for one in found.judged) else 0
