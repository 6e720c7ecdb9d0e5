"""Proposes which field of a foreign log is which signal, and in which unit, as a mapping file."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.cli.doctor import existing_log, message_folders
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, new_file
from reports.whole_file import write_whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pytest_dvp.logs.mapping import SignalMap
    from pytest_dvp.logs.mapping_text import Told
    from pytest_dvp.logs.stream import Stream

PLACE = 140  # in `dvp --help`
_LENGTHS, _MASSES = (0.05, 20.0), (0.05, 1e5)  # m of a toy and of a lorry, kg


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the foreign log, folders of message definitions, what is known of the car, and what is written."""
    parser.add_argument("log", metavar="LOG", help="MCAP, ROS bag (.bag, .db3 or its folder), .mf4, .mat or .csv")
    parser.add_argument("--msg", action="append", default=[], metavar="DIR", help="folder of .msg files (ROS types)")
    parser.add_argument("--wheelbase", metavar="M", help="of the car [m]: tells the unit of the steering")
    parser.add_argument("--mass", metavar="KG", help="of the car [kg], for --model")
    parser.add_argument("--model", metavar="FILE", help="also write the least model of this car, to begin with")
    parser.add_argument("--names-only", action="store_true", help="do not look at the numbers, only at names and units")
    parser.add_argument("--out", metavar="FILE", help="file of the mapping; default: stdout")
    parser.add_argument("--force", action="store_true", help="overwrite files of --out and --model that were edited")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print or write a proposed mapping, and with --model a model file. Returns 0.

    Raises WrongArgument for a log of dvp, which needs no mapping, for --model without --wheelbase, or for a file that
    is there, with other contents, without --force.
    """
    path = Path(existing_log(arguments.log, parts=False))
    folders = message_folders(arguments)
    wheelbase = _number("--wheelbase", arguments.wheelbase, _LENGTHS, "m")
    mass = _number("--mass", arguments.mass, _MASSES, "kg")
    out = None if arguments.out is None else new_file("--out", arguments.out, [path])
    model = None if arguments.model is None else new_file("--model", arguments.model, [path, *([out] if out else [])])
    if model is not None and wheelbase is None:
        raise WrongArgument("--model: the wheelbase of the car is needed, too: --wheelbase M (in m)")
    from openscenario.findings import Findings
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.mapping_proposal import propose
    from pytest_dvp.logs.mapping_text import mapping_text, open_modes, open_signals
    from pytest_dvp.logs.read_log import read_streams
    from pytest_dvp.recognition.starting_model import measured_drive, starting_model

    findings = Findings()
    streams = read_streams(path, findings, folders)
    if isinstance(streams, Log):
        raise WrongArgument(f"{path}: a log of dvp, it needs no mapping")
    told, remarks = ([], ()) if arguments.names_only else _by_data(streams, wheelbase)
    text = mapping_text(streams, told, remarks)
    mapping, unsure = propose(streams)
    sure = {one.signal.name for one in told if not one.doubt} | {signal.name for signal in mapping.signals}
    files = [] if out is None else [("--out", out, text.encode("utf-8", "backslashreplace"))]
    if model is not None and wheelbase is not None:
        files.append(("--model", model, starting_model(sure, wheelbase, mass).encode()))
    for option, file, content in files:
        if not arguments.force and file.is_file() and file.read_bytes() != content:
            raise WrongArgument(f"{option} {file}: is there, with other contents: name another file, or add --force")
    for _, file, content in files:
        write_whole(file, content)
    if arguments.json:
        known = {one.signal.name for one in told}
        entries = [(one.signal, not one.doubt, one.evidence) for one in told]
        entries += [(s, True, "") for s in mapping.signals if s.name not in known]
        entries += [(s, False, "") for s in unsure if s.name not in known]
        entries += [(s, False, "") for s in open_modes(streams, told)]
        signals = [
            {"name": s.name, "topic": s.topic, "field": s.field, "unit": s.unit, "certain": c, "evidence": e}
            | ({"when": list(s.when)} if s.when else {})
            for s, c, e in entries
        ]
        print(
            json.dumps({"signals": signals, "findings": [f.as_dict() for f in findings.in_order()]}, ensure_ascii=False)
        )
    elif out is None:
        print(text, end="")
    else:
        _say_next(
            arguments, told, [*_left_open([*open_signals(streams, told), *open_modes(streams, told)]), *remarks], out
        )
        if model is not None and measured_drive(sure):
            print(f"  {model} takes the speed from the log; its line `longitudinal` says how to judge the drive, too")
    return 0


def _by_data(streams: Sequence[Stream], wheelbase: float | None) -> tuple[list[Told], tuple[str, ...]]:
    """What the numbers say of each signal."""
    from openscenario.findings import Findings
    from pytest_dvp.logs.mapping_text import Told
    from pytest_dvp.logs.signals import SIGNALS
    from pytest_dvp.logs.time_column import clock_of
    from pytest_dvp.logs.topic_clocks import on_one_clock
    from pytest_dvp.recognition.columns import columns_of
    from pytest_dvp.recognition.recognise import recognise
    from pytest_dvp.recognition.who_drives import modes_of

    streams, clock, _ = clock_of(streams)
    if clock == "header":  # topics without a header count from the first message
        streams = on_one_clock(streams, [(stream, 0.0) for stream in streams], "", Findings())
    found = recognise(columns_of(streams, clock), wheelbase, modes_of(streams, clock))
    order = list(SIGNALS)
    told = [
        Told(one.signal, "; ".join(one.evidence), "" if one.decided else one.rival or "the data do not tell its unit")
        for one in sorted(found.signals, key=lambda one: order.index(one.name) if one.name in order else len(order))
    ]
    return told, found.remarks


def _left_open(signals: Sequence[SignalMap]) -> list[str]:
    """Lines on signals that names alone tell."""
    return [f"left to you: {s.name} from {s.field!r} by its name; it is not read until you decide" for s in signals]


def _say_next(arguments: argparse.Namespace, told: Sequence[Told], remarks: Sequence[str], out: Path) -> None:
    """What was decided, what is left, what else was seen, and the command to go on with."""
    sure = [one.signal.name for one in told if not one.doubt]
    print(f"{out}: decided by the data, to be confirmed: {', '.join(sure) or 'nothing'}")
    for one in told:
        if one.doubt:
            print(f"  left to you: {one.signal.name} from {one.signal.field!r} ({one.doubt})")
    for remark in remarks:
        print(f"  {remark}")
    log = f"{arguments.log} --map {out}"
    if arguments.model:
        log += f" --model {arguments.model}"
    commands = [f"dvp doctor {log}"]
    if arguments.model:
        page = out.with_suffix("")
        commands += [f"dvp compare {log} --report {page}.html", f"dvp diagnose {log} --report {page}.diagnosis.html"]
    print("\n      ".join([f"next: {commands[0]}", *commands[1:]]), file=sys.stderr)


def _number(option: str, text: str | None, allowed: tuple[float, float], unit: str) -> float | None:
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not allowed[0] <= value <= allowed[1]:
        raise WrongArgument(f"{option}: found {text!r}, allowed: {allowed[0]:g} to {allowed[1]:g} {unit}")
    return value
