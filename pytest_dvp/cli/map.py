"""Proposes which field of a foreign log is which signal, as a mapping file."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from pytest_dvp.cli.doctor import existing_log, message_folders
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, new_file
from reports.whole_file import write_whole

PLACE = 140  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the foreign log, folders of message definitions, and the mapping file."""
    parser.add_argument("log", metavar="LOG", help="MCAP, ROS bag (.bag, .db3 or its folder), .mf4, .mat or .csv")
    parser.add_argument("--msg", action="append", default=[], metavar="DIR", help="folder of .msg files (ROS types)")
    parser.add_argument("--out", metavar="FILE", help="file of the mapping; default: stdout")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print or write a proposed mapping. Returns 0; raises WrongArgument for a log of dvp, which needs none."""
    path = Path(existing_log(arguments.log, parts=False))
    folders = message_folders(arguments)
    out = None if arguments.out is None else new_file("--out", arguments.out, [path])
    from openscenario.findings import Findings
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.mapping_proposal import mapping_text, propose
    from pytest_dvp.logs.read_log import read_streams

    findings = Findings()
    streams = read_streams(path, findings, folders)
    if isinstance(streams, Log):
        raise WrongArgument(f"{path}: a log of dvp, it needs no mapping")
    text = mapping_text(streams)
    if out is not None:
        write_whole(out, text.encode("utf-8", "backslashreplace"))
    if arguments.json:
        mapping, unsure = propose(streams)
        entries = [(signal, True) for signal in mapping.signals] + [(signal, False) for signal in unsure]
        told = [{"name": s.name, "topic": s.topic, "field": s.field, "unit": s.unit, "certain": c} for s, c in entries]
        print(json.dumps({"signals": told, "findings": [f.as_dict() for f in findings.in_order()]}, ensure_ascii=False))
    elif out is None:
        print(text, end="")
    return 0
