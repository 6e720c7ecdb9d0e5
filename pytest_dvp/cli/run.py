"""One scenario with the ADS in the loop: metrics, verdicts, a run folder with log and report."""

from __future__ import annotations

import argparse
import json
import math
import sys
import threading
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.arguments import add_json, add_settings, existing, settings_from
from pytest_dvp.settings import STAGES, SettingError, unknown

if TYPE_CHECKING:
    from pytest_dvp.run import RunResult

SETTINGS = (
    "seed",
    "set",
    "model",
    "gates",
    "library",
    "ego",
    "duration",
    "wall-limit",
    "after-collision",
    "runs",
)

PATIENCE = 8.0  # s of wall time before a silent run says why it may take long
FIRST_RUN = "  still at it; the first run after an installation compiles for about a minute, once"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenario", metavar="X.xosc")
    parser.add_argument("--stage", default="dt", help="dt (pe and rw need a vehicle adapter)")
    parser.add_argument("--no-report", action="store_true", help="judge only, write no run folder")
    add_settings(parser, SETTINGS)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    path = existing(arguments.scenario, "scenario")
    settings = settings_from(arguments)
    if arguments.stage not in STAGES:
        raise SettingError(f"--stage: {unknown('stage', arguments.stage, STAGES)}")
    from pytest_dvp.override import check_overrides
    from pytest_dvp.run import run

    check_overrides(path, settings.set)
    print(f"dvp run: {path}, stage {arguments.stage}, seed {settings.seed}", file=sys.stderr)
    notice = threading.Timer(PATIENCE, print, (FIRST_RUN,), {"file": sys.stderr, "flush": True})
    notice.daemon = True
    notice.start()
    try:
        result = run(
            path,
            stage=arguments.stage,
            seed=settings.seed,
            parameters=settings.set.scenario,
            P=settings.set.P,
            S=settings.set.S,
            model=settings.model,
            gates=settings.gates,
            library=settings.library,
            rootdir=settings.rootdir,
            ego=settings.ego,
            duration=settings.duration,
            wall_limit=settings.wall_limit,
            after_collision=settings.after_collision,
            log_dir=None if arguments.no_report else settings.runs_folder,
        )
    finally:
        notice.cancel()
    for note in result.notes:
        print(note, file=sys.stderr)
    print(json.dumps(_finite(result.as_dict()), ensure_ascii=False) if arguments.json else table(result))
    return 0 if result.status == "PASS" else 1


def table(result: RunResult) -> str:
    """The verdicts of a run as text, worst first, and where its report is."""
    from pytest_dvp.summary import clean, reason, worst_first

    plain = result.as_dict()
    said = f"{plain['scenario']} [{plain['stage']}]: {plain['status']}"
    lines = [clean(f"{said} after {plain['simulated']:.2f} s simulated, ended by {plain['ending']}")]
    lines += [f"  {v['status']:<12} {reason(v)}{_margin(v)}" for v in worst_first(plain["verdicts"])]
    if plain["error"]:
        lines += ["", *(clean(line) for line in plain["error"].strip().split("\n"))]
    if plain["folder"]:
        lines.append(clean(f"  report: {plain['folder']}/report.html"))
    lines.append(clean(f"  replay: {plain['replay']}"))
    return "\n".join(lines)


def _margin(verdict: Mapping[str, Any]) -> str:
    margin = verdict["margin"]
    return "" if margin is None else f", margin {margin:.3g}"


def _finite(value: Any) -> Any:
    """JSON knows no NaN."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    return [_finite(item) for item in value] if isinstance(value, list | tuple) else value
