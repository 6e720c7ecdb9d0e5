"""Puts faults between car and stack, and tells which of them the gates of the scenarios would not notice."""

from __future__ import annotations

import argparse
import json
import sys

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, add_settings, settings_from
from pytest_dvp.cli.shared.named_scenarios import named_scenarios
from pytest_dvp.cli.shared.named_stack import named_stack
from pytest_dvp.cli.shared.progress import progress
from pytest_dvp.cli.shared.worker_options import add_workers, check_workers, workers
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.names import REFERENCE
from pytest_dvp.text.plain_json import finite
from pytest_dvp.text.spelling import unknown

PLACE = 45  # in `dvp --help`

OF_MUTATE = ("ads",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare scenarios, stack, faults, number of clean drives, processes and where results are kept."""
    parser.add_argument("scenarios", nargs="+", metavar="X.xosc", help="scenario, or a folder with scenarios")
    parser.add_argument("--no-ini", action="store_true", help="ignore the dvp_ keys of the project's ini file")
    add_settings(parser, OF_MUTATE)
    parser.add_argument("--fault", nargs="+", action="extend", default=[], metavar="NAME", help="these faults only")
    parser.add_argument(
        "--source", nargs="+", action="extend", default=[], metavar="MODULE",
        help="change the stack's own source in these modules (a.b, or FILE.py) too",
    )  # fmt: skip
    parser.add_argument("--mutants", type=int, default=40, metavar="N", help="changes of source at most; default: 40")
    parser.add_argument("--clean-seeds", type=int, default=20, metavar="N", help="drives without a fault; default: 20")
    parser.add_argument("--write", action="store_true", help="add the proposed gates to the gate files")
    add_workers(parser)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Drive with each fault and tell which no gate notices. Returns 1 if a fault escapes, else 0.

    Raises WrongArgument for an unknown fault, SettingError for fewer than 2 clean drives, workers that cannot be, or a
    stack that cannot be loaded.
    """
    if arguments.clean_seeds < 2:
        raise SettingError(f"--clean-seeds is {arguments.clean_seeds}, expected a whole number >= 2")
    if arguments.mutants < 1:
        raise SettingError(f"--mutants is {arguments.mutants}, expected a whole number >= 1")
    check_workers(arguments)
    scenarios = named_scenarios(arguments.scenarios)
    from pytest_dvp.drive.stack_host import find_ads
    from pytest_dvp.drive.stack_sensors import read_by
    from pytest_dvp.mutation.catalogue import known_faults
    from pytest_dvp.mutation.drives import drive_once
    from pytest_dvp.mutation.gate_writer import write_gates
    from pytest_dvp.mutation.mutate import mutate
    from pytest_dvp.mutation.source_mutants import SourceError, sample
    from pytest_dvp.mutation.words import mutation_lines

    for name in arguments.fault:
        if name not in known_faults():
            raise WrongArgument(f"--fault: {unknown('fault', name, known_faults())}")
    settings = settings_from(arguments, ini=OF_MUTATE)
    ads = None if settings.ads == REFERENCE else settings.ads
    reads = read_by(find_ads(ads, process="off"))  # before anything drives
    try:
        source = sample(arguments.source, arguments.mutants) if arguments.source else []
    except SourceError as error:
        raise SettingError(str(error)) from None
    count = f"{len(scenarios)} scenario{'' if len(scenarios) == 1 else 's'}"
    print(f"dvp mutate: {count}, stage dt, {named_stack(settings)}", file=sys.stderr)
    with progress("dvp mutate", "driving") as tick, workers(arguments, tick, drive_once) as crew:
        found = mutate(
            scenarios, ads, crew, faults=arguments.fault, clean=arguments.clean_seeds, source=source, reads=reads
        )
    if arguments.json:
        print(json.dumps(finite(found.as_dict()), ensure_ascii=False))
    else:
        print("\n".join(mutation_lines(found)))
    if arguments.write:
        for file in write_gates([one.proposed for one in found.judged if one.proposed is not None]):
            print(f"dvp mutate: {file} written", file=sys.stderr)
    return 1 if any(one.escaped for one in found.judged) else 0
