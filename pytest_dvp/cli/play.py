"""Plays the storyboard alone with default controllers, without a stack; writes positions and transitions as CSV.

Without --csv and --events, it prints a summary: how it ended, which events fired when, how far each entity came.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, add_settings, existing, new_file, settings_from
from reports.whole_file import write_whole

if TYPE_CHECKING:
    from openscenario.model.scenario import Scenario
    from openscenario.storyboard.play import Played, Row

PLACE = 20  # in `dvp --help`
READS_NO_LOG = True
READS_SCENARIOS = True


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the scenario, the step, the parameters and the CSV files."""
    parser.add_argument("scenario", metavar="X.xosc")
    parser.add_argument("--dt", default="0.01", metavar="SECONDS", help="step of the storyboard [s]; default: 0.01")
    parser.add_argument(
        "--csv", metavar="FILE", help="file for rows time,entity,x,y,h,speed every 0.05 s; - for stdout"
    )
    parser.add_argument("--events", metavar="FILE", help="file for rows time,element,from,transition,to")
    add_settings(parser, ("duration", "library", "reading", "roads", "set"))
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Play the storyboard alone and write or print what happened. Returns 0, however it ended."""
    path = existing(arguments.scenario, "scenario")
    _check_targets(arguments)
    settings = settings_from(arguments)
    dt = _step(arguments.dt)
    from openscenario.no_effect import without_effect
    from openscenario.read import read_scenario
    from openscenario.storyboard.play import play
    from pytest_dvp.drive.parameter_checks import check_overrides
    from pytest_dvp.drive.preparation import network_of

    check_overrides(path, settings.set)
    scenario = read_scenario(path, library=settings.library, rootdir=settings.rootdir, parameters=settings.set.scenario)
    network = network_of(scenario, settings.roads) if scenario.road_network.logic_file is not None else None
    played = play(scenario, network, dt, settings.duration or 60.0, reading=settings.reading)
    if arguments.csv is not None:
        rows = ((_six(r.time), r.entity, _six(r.x), _six(r.y), _six(_turn(r.h)), _six(r.speed)) for r in played.rows)
        _write(arguments.csv, ("time", "entity", "x", "y", "h", "speed"), rows)
    if arguments.events is not None:
        steps = ((_six(e.time), e.element, e.from_state, e.transition, e.to_state) for e in played.transitions)
        _write(arguments.events, ("time", "element", "from", "transition", "to"), steps)
    if arguments.json:
        print(json.dumps(_summary(scenario, played), ensure_ascii=False))
    elif not arguments.csv and not arguments.events:
        print(_text(path, _summary(scenario, played)))
    for finding in (*played.findings, *without_effect(scenario)):
        print(finding, file=sys.stderr)
    return 0


def _summary(scenario: Scenario, played: Played) -> dict[str, Any]:
    """How it ended, the first start of each event (None: never), each entity's way, and what is doubtful about it."""
    from openscenario.storyboard.plausibility import CODE
    from pytest_dvp.logs.event_names import EventNames

    names = EventNames(scenario)
    fired: dict[str, float | None] = dict.fromkeys(names)
    for step in played.transitions:
        if step.kind == "event" and step.to_state == "runningState" and fired.get(names.of(step)) is None:
            fired[names.of(step)] = step.time
    ways: dict[str, dict[str, float]] = {}
    last: dict[str, Row] = {}
    for row in played.rows:
        way = ways.setdefault(row.entity, {"distance": 0.0, "max_speed": 0.0, "speed": 0.0})
        if row.entity in last:
            way["distance"] += math.hypot(row.x - last[row.entity].x, row.y - last[row.entity].y)
        way["max_speed"], way["speed"] = max(way["max_speed"], row.speed), row.speed
        last[row.entity] = row
    ended = "stop trigger" if played.stopped else "duration"
    monitors = {"monitors": dict(played.monitors)} if played.monitors else {}
    others = [finding.as_dict() for finding in played.findings if finding.code != CODE]
    findings = [*others, *map(dict, played.implausible)]
    return {
        "time": played.time, "ended": ended, "events": fired, "entities": ways, **monitors, "findings": findings,
    }  # fmt: skip


def _text(path: Path, summary: Mapping[str, Any]) -> str:
    lines = [f"{path}: {summary['time']:.2f} s played, ended by the {summary['ended']}"]
    for name, way in summary["entities"].items():
        speeds = f"up to {way['max_speed']:.2f} m/s, {way['speed']:.2f} m/s at the end"
        lines.append(f"  {name}: {way['distance']:.1f} m, {speeds}")
    for name, time in summary["events"].items():
        lines.append(f"  event {name}: " + ("never fired" if time is None else f"fired at {time:.2f} s"))
    for name, value in summary.get("monitors", {}).items():
        lines.append(f"  monitor {name}: {str(value).lower()} at the end")
    lines.append(f"for rows: dvp play {path} --csv FILE --events FILE (- for stdout)")
    return "\n".join("".join(c if c.isprintable() else "?" for c in line) for line in lines)


def _check_targets(arguments: argparse.Namespace) -> None:
    """Raises WrongArgument for a file that cannot be written, and for two tables or documents in one place."""
    named = {"--csv": arguments.csv, "--events": arguments.events}
    to_stdout = [option for option, text in named.items() if text == "-"]
    to_stdout += ["--json"] if arguments.json else []
    if len(to_stdout) > 1:
        raise WrongArgument(f"{' and '.join(to_stdout)} both go to stdout; name a FILE for one of them")
    files = [
        new_file(option, text, [arguments.scenario])
        for option, text in named.items()
        if text is not None and text != "-"
    ]
    if len(files) == 2 and os.path.realpath(files[0]) == os.path.realpath(files[1]):
        raise WrongArgument(f"--csv and --events both name {files[1]}; name two files")


def _step(text: str) -> float:
    try:
        dt = float(text)
    except ValueError:
        dt = math.nan
    if not 1e-4 <= dt <= 0.05 or abs(round(0.05 / dt) * dt - 0.05) > 1e-9:
        raise WrongArgument(f"--dt is {text}, expected a step of 0.0001 to 0.05 s that divides 0.05 s")
    return dt


def _turn(angle: float) -> float:
    """Angle in [0, 2 pi), also after rounding to six decimals."""
    turned = angle % math.tau
    return 0.0 if round(turned, 6) >= round(math.tau, 6) else turned


def _six(value: float) -> str:
    text = f"{value:.6f}"
    return "0.000000" if text == "-0.000000" else text


def _write(target: str, header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    if target == "-":
        csv.writer(sys.stdout, lineterminator="\n").writerows([header, *rows])
        return
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([header, *rows])
    write_whole(Path(target), text.getvalue().encode("utf-8", "backslashreplace"))
