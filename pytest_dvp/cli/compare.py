"""Compares a model with measured logs: how far it is from them, and where the error is.

The model is a vehicle model (.toml), a Python file with step(state, inputs, dt) (.py), an FMU (.fmu), or a second log
with its output.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.cli.doctor import add_log_options, existing_log, log_options, read_files
from pytest_dvp.cli.effects import add_effects, effects_from
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, add_report, existing, new_file
from pytest_dvp.cli.shared.command_columns import check_command_columns
from pytest_dvp.text.plain_json import finite
from pytest_dvp.text.spelling import unknown

if TYPE_CHECKING:
    from openscenario.findings import Finding
    from pytest_dvp.gap.compare.compare import Comparison
    from pytest_dvp.gap.compare.compared_model import ComparedModel
    from pytest_dvp.logs.log import Log

PLACE = 70  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare logs, model, channels and report."""
    parser.add_argument("logs", nargs="+", metavar="LOG", help="measured log; a part of it as LOG@0:285 (seconds)")
    parser.add_argument(
        "--model",
        required=True,
        metavar="M",
        help="model: M.toml, step.py or step.py:function, model.fmu, or a second log",
    )
    add_log_options(parser)
    add_effects(parser)
    parser.add_argument("--channels", metavar="LIST", help="compare only these channels, as in v,yaw_rate")
    add_report(parser)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print how far a model is from each log. Returns 0 however large the difference is."""
    for text in arguments.logs:
        existing_log(text)
    model = arguments.model.partition(".py:")[0] + ".py" if ".py:" in arguments.model else arguments.model
    if model.endswith((".toml", ".py", ".fmu")):
        existing(model, "model")
    else:
        existing_log(model)
    if arguments.report is not None:
        new_file("--report", arguments.report, [*read_files(arguments, arguments.logs), model])
    from pytest_dvp.gap.compare.compared_model import ModelSubject
    from pytest_dvp.gap.words.pooled_comparison import pooled

    channels = _channels(arguments)
    subject, logs = _read_all(arguments)
    if isinstance(subject, ModelSubject):
        check_command_columns(
            "dvp compare", subject.model, arguments.model, {name: log for name, (log, _) in logs.items()}
        )
    found = _compare_all(subject, {name: log for name, (log, _) in logs.items()}, channels)
    if arguments.report is not None:
        _report(arguments, found, {name: findings for name, (_, findings) in logs.items()})
    if arguments.json:
        print(json.dumps(finite(pooled(found)), ensure_ascii=False, allow_nan=False))
        return 0
    for number, (name, comparison) in enumerate(found.items()):
        print(("\n" if number else "") + _page(name, comparison))
    if arguments.report is not None:
        print(f"dvp compare: report in {arguments.report}", file=sys.stderr)
    return 0


def _read_all(arguments: argparse.Namespace) -> tuple[ComparedModel, dict[str, tuple[Log, tuple[Finding, ...]]]]:
    """The model, and logs with their warnings by name, all before any physics; the warnings are told on stderr.

    Raises LogError for a log with an error: a model would be bent to explain it.
    """
    from rich.console import Console

    from pytest_dvp.doctor import print_findings, read_checked_log
    from pytest_dvp.gap.compare.compared_model import LogSubject
    from pytest_dvp.gap.compare.model_loader import load_compared_model
    from pytest_dvp.logs.log_names import log_names

    options = log_options(arguments)
    logs: dict[str, tuple[Log, tuple[Finding, ...]]] = {}
    with Console(stderr=True).status("reading") as status:
        subject = load_compared_model(arguments.model, effects_from(arguments), **options)
        for name, text in zip(log_names(arguments.logs), arguments.logs, strict=True):
            status.update(f"reading {text}")
            logs[name] = read_checked_log(text, **options)
    for _, findings in logs.values():
        print_findings(findings)
    print_findings(subject.findings if isinstance(subject, LogSubject) else ())
    return subject, logs


def _compare_all(subject: ComparedModel, logs: dict[str, Log], channels: list[str] | None) -> dict[str, Comparison]:
    """Comparisons by log as it was named; the status line on stderr is shown on terminals only."""
    from rich.console import Console

    from pytest_dvp.gap.compare.compare import compare

    found: dict[str, Comparison] = {}
    with Console(stderr=True).status("comparing") as status:
        for name, log in logs.items():
            status.update(f"comparing {name} with {subject.name}")
            found[name] = compare(log, subject, channels=channels)
    return found


def _channels(arguments: argparse.Namespace) -> list[str] | None:
    """Those that are asked for. Raises WrongArgument for one that there is not."""
    from pytest_dvp.gap.compare.segments import CHANNELS

    if arguments.channels is None:
        return None
    names = [name.strip() for name in arguments.channels.split(",")]
    for name in names:
        if name not in CHANNELS:
            raise WrongArgument(f"--channels: {unknown('channel', name, CHANNELS)}")
    return names


def _page(name: str, comparison: Comparison) -> str:
    from pytest_dvp.gap.words.comparison import covered, headline, not_judged, places, skipped, table

    left, unjudged = skipped(comparison.not_compared), not_judged(comparison)
    return "\n".join([
        f"{name}: {comparison.t[-1] - comparison.t[0]:.1f} s, {len(comparison.segments.starts)} segments, "
        f"lag {round(comparison.alignment.lag, 3) + 0.0:+.3f} s, {covered(comparison)}",
        headline(comparison), "", *table(comparison), *([f"not compared: {left}"] if left else []),
        *([unjudged] if unjudged else []), "",
        *places(comparison.where),
    ])  # fmt: skip


def _report(
    arguments: argparse.Namespace, found: dict[str, Comparison], findings: dict[str, tuple[Finding, ...]]
) -> None:
    from pytest_dvp.gap.words.comparison_page import page_of
    from pytest_dvp.logs.mapping import mapping_rows, read_mapping
    from reports.compare import write_compare_report

    rows = mapping_rows(read_mapping(Path(arguments.map))) if arguments.map else []
    write_compare_report(arguments.report, [page_of(name, one, findings[name], rows) for name, one in found.items()])
