"""Writes a vehicle model with its effects as one Python module or as an FMU, to be driven without pytest_dvp."""

from __future__ import annotations

import argparse
import json

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, existing, new_file
from reports.whole_file import write_whole

PLACE = 115  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the model file and what is written from it."""
    parser.add_argument("model", metavar="MODEL", help="vehicle model (.toml)")
    parser.add_argument("--python", metavar="F", help="new Python module; runs where numpy, numba and msgspec are")
    parser.add_argument("--fmu", metavar="F", help="new FMU 2 for co-simulation; needs PythonFMU here and there")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Write a model as a Python module, as an FMU, or both. Returns 0.

    Raises WrongArgument if neither is asked for, a name has another ending, or PythonFMU is not installed.
    """
    path = existing(arguments.model, "model")
    if not arguments.python and not arguments.fmu:
        raise WrongArgument("nothing to write: give --python F, --fmu F or both")
    outs = {}
    for option, ending in (("python", ".py"), ("fmu", ".fmu")):
        if text := getattr(arguments, option):
            outs[option] = new_file(f"--{option}", text, [path])
            if outs[option].suffix.lower() != ending:
                raise WrongArgument(f"--{option} {text}: allowed: a name that ends in {ending}")
    from pytest_dvp.gap.extend.exported_twin import python_text, write_fmu
    from vehicle.model.model_file import read_model

    model = read_model(path)
    if "python" in outs:
        write_whole(outs["python"], python_text(model).encode())
    if "fmu" in outs:
        try:
            write_fmu(model, outs["fmu"])
        except ImportError:
            raise WrongArgument("--fmu: needs PythonFMU: pip install pythonfmu") from None
    if arguments.json:
        print(json.dumps({option: str(out) for option, out in outs.items()}))
    else:
        for out in outs.values():
            print(f"{out}: {out.stat().st_size / 1000:.0f} kB")
    return 0
