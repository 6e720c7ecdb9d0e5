"""Names the physical effect that a model lacks, after trying every effect of the catalogue on measured logs.

The answer is an effect with its value, and its rivals if these data cannot distinguish them; or that nothing is
missing; or that nothing known explains the residual.
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
from pytest_dvp.cli.shared.forwarded_options import forwarded_options
from pytest_dvp.cli.shared.held_out_logs import refuse_same_drive, refuse_same_path
from pytest_dvp.cli.shared.manoeuvre_options import add_limits, check_folder, limit_words, limits_from, with_manoeuvres
from pytest_dvp.cli.shared.progress import progress
from pytest_dvp.cli.shared.selected_parts import SelectedParts, select_parts
from pytest_dvp.text.plain_json import finite

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.diagnosis import Diagnosis
    from pytest_dvp.logs.log import Log
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

PLACE = 80  # in `dvp --help`
SECONDS_A_ROW = (0.3e-3, 82e-3)
"""CPU of a row of the logs, from a twin that lacks one effect to a car with an engine of which only the data sheet is
known, so that twenty effects are named, with other programs on both cores: 818 s of 10,000 rows (docs/foreign_cars.md).
One that was stopped had taken 666 s; longer ones are possible."""
SECONDS_A_ROW_IMPOSED = (0.3e-3, 20e-3)
"""The same where the model takes the speed from the log: 198 s of 17,725 rows (docs/real-cars.md), with a margin."""
IMPOSED = (
    'the speed is imposed (longitudinal = "v" in the model): drive, brakes, resistances and road grade are not judged'
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare logs, model, held-out logs, drives of the twin, report and plan folder."""
    parser.add_argument("logs", nargs="+", metavar="LOG", help="measured log; a part of it as LOG@0:285 (seconds)")
    parser.add_argument("--model", required=True, metavar="M.toml", help="vehicle model that lacks an effect")
    parser.add_argument(
        "--held-out", action="append", default=[], metavar="LOG",
        help="log that judges every effect and is not fitted to; default: each log is predicted from the others",
    )  # fmt: skip
    parser.add_argument(
        "--twin", action="append", default=[], metavar="RUN",
        help="run of the twin in a scenario of the logs, whose detections are compared; repeat for each run",
    )  # fmt: skip
    add_log_options(parser)
    add_effects(parser)
    add_report(parser)
    parser.add_argument("--plan", metavar="FOLDER", help="write the manoeuvre that distinguishes rivals (dvp plan)")
    add_limits(parser)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print which effects a model lacks. Returns 0 whatever the verdict is.

    Raises WrongArgument for a file that is not there, an output that may not be written, or the same drive twice.
    """
    for text in [*arguments.logs, *arguments.held_out, *arguments.twin]:
        existing_log(text)
    existing(arguments.model, "model")
    refuse_same_path(arguments.logs, arguments.held_out)
    if arguments.report is not None:
        texts = [*arguments.logs, *arguments.held_out, *arguments.twin]
        new_file("--report", arguments.report, [*read_files(arguments, texts), arguments.model])
    if arguments.plan is not None:
        if not arguments.plan.strip():
            raise WrongArgument("--plan: no name, expected a folder")
        check_folder("--plan", Path(arguments.plan))
    envelope = limits_from(arguments)
    from pytest_dvp.gap.diagnose.diagnose import diagnose
    from pytest_dvp.gap.diagnose.wheelbase_check import wrong_wheelbase
    from vehicle.model.effect_catalogue import perception_effect_names
    from vehicle.model.model_file import read_model

    extra = effects_from(arguments)
    model = read_model(arguments.model, extra=extra)
    logs, held_out = read_all(arguments.logs, arguments), read_all(arguments.held_out, arguments)
    refuse_same_drive(logs, held_out)
    check_command_columns("dvp diagnose", model, arguments.model, logs, held_out)
    fitted = select_parts(arguments.logs, logs, model)
    judged = select_parts(arguments.held_out, held_out, model)
    logs, held_out = fitted.logs, judged.logs
    twins = twins_of(arguments, logs, model)
    imposed = "v" in model.inputs.longitudinal
    told = (
        fitted.said, judged.said, _true_motion({**held_out, **logs}), _unjudged(logs, twins), IMPOSED if imposed else ""
    )  # fmt: skip
    said = [text for text in told if text]
    for warning in (wrong_wheelbase(logs, model), model.drives_nothing):
        if warning:
            print(f"dvp diagnose: warning: {warning}", file=sys.stderr)
    rows = sum(len(log.t) for log in (*logs.values(), *held_out.values()))
    with progress("dvp diagnose", "diagnosing", _usual_time(rows, imposed)) as tick:
        found = diagnose(logs, model, held_out=held_out, effects=tuple(extra.values()), twins=twins, tick=tick)
        if arguments.plan:
            tick("planning")
            found = with_manoeuvres(found, logs, model, envelope, tuple(extra.values()), Path(arguments.plan))
    if source := _held_out_from(arguments, found):
        said.append(source)
    if twins and not any(effect.name in perception_effect_names() for effect in found.effects):
        said.append("detections are as in the twin's run, as far as these data show")
    if arguments.report is not None:
        _report(arguments, found, fitted, model, judged, tuple(extra.values()))
    if arguments.json:
        for text in said:
            print(f"dvp diagnose: {text}", file=sys.stderr)
        print(json.dumps(finite(found.as_dict()), ensure_ascii=False, allow_nan=False))
        return 0
    from pytest_dvp.gap.words.diagnosis import extend_command, page, plan_command, trial_command

    given = (found, arguments.model, fitted.texts, judged.texts)
    command = extend_command(*given, _extending(arguments))
    trial = trial_command(*given, _extending(arguments))
    plan = plan_command(*given, [*forwarded_options(arguments), *limit_words(arguments)])
    print(*said, page(found, model=Path(arguments.model).name, command=command, plan=plan, trial=trial), sep="\n")
    return 0


def _held_out_from(arguments: argparse.Namespace, found: Diagnosis) -> str:
    """What the figures "held out" are of where no log is named for that; empty if one is, or if there are none."""
    if arguments.held_out or found.ladder[0].held_out_chi2_per_n is None:
        return ""
    if len(arguments.logs) > 1:
        return "held out: each log in turn, predicted from the others"
    return "held out: the last 40 % of the log, predicted from what comes before (--held-out LOG takes another drive)"


def _usual_time(rows: int, imposed: bool) -> str:
    """The CPU that a diagnosis of `rows` rows takes: "3 s to 520 s, ..."; imposed: the log gives the speed."""
    low, high = (max(round(rows * each), 2) for each in (SECONDS_A_ROW_IMPOSED if imposed else SECONDS_A_ROW))
    return f"{low} s to {high} s, the longer the more is missing"


def _report(arguments: argparse.Namespace, found: Diagnosis, fitted: SelectedParts, model: VehicleModel,
            judged: SelectedParts, extra: tuple[Effect, ...]) -> None:  # fmt: skip
    from pytest_dvp.gap.words.diagnosis import extend_command, trial_command
    from pytest_dvp.gap.words.diagnosis_page import Typed, diagnosis_page
    from pytest_dvp.logs.mapping import mapping_rows, read_mapping
    from reports.diagnosis import write_diagnosis_report

    rows = mapping_rows(read_mapping(Path(arguments.map))) if arguments.map else []
    typed = Typed(arguments.model, fitted.texts, judged.texts, forwarded_options(arguments), rows)
    source = _held_out_from(arguments, found)
    page = diagnosis_page(found, fitted.logs, model, held_out=judged.logs, effects=extra, typed=typed)
    given = (found, arguments.model, fitted.texts, judged.texts, _extending(arguments))
    page["command"], page["trial"] = extend_command(*given), trial_command(*given)
    page["remarks"] += [source] if source else []
    write_diagnosis_report(arguments.report, page)
    print(f"dvp diagnose: report in {arguments.report}", file=sys.stderr)


def _extending(arguments: argparse.Namespace) -> list[str]:
    """Words that `dvp extend` needs as this command did."""
    return [*(word for run in arguments.twin for word in ("--twin", run)), *forwarded_options(arguments)]


def twins_of(arguments: argparse.Namespace, logs: dict[str, Log], model: VehicleModel) -> dict[str, Log]:
    """Runs of the twin by scenario. Raises WrongArgument for one that belongs to none of the logs, or whose model had
    other effects of perception than `model`: what the logs show on top of it would be no value of this model."""
    found: dict[str, Log] = {}
    driven = {log.meta.get("scenario", "") for log in logs.values()} - {""}
    for text, log in zip(arguments.twin, read_all(arguments.twin, arguments).values(), strict=True):
        scenario, stage = log.meta.get("scenario", ""), log.meta.get("stage", "")
        if stage != "dt":
            raise WrongArgument(
                f"--twin {text}: {f'a run of stage {stage}' if stage else 'no run'}; allowed: of stage dt"
            )
        if scenario not in driven:
            known = ", ".join(sorted(driven)) or "of no scenario"
            raise WrongArgument(f"--twin {text}: a run of {scenario}; the logs are {known}")
        if (other := _sees_otherwise(log, model)) is not None:
            raise WrongArgument(
                f"--twin {text}: driven with {other or 'no effect of perception'}, and {arguments.model} has "
                f"{_seen_with(model) or 'none'}; drive {scenario} with this model (dvp run --model)"
            )
        found[scenario] = log
    return found


def _sees_otherwise(log: Log, model: VehicleModel) -> str | None:
    """The effects of perception that a run of a twin was driven with, if they are not those of the model; else None,
    also where the log does not tell."""
    from vehicle.model.errors import ModelError
    from vehicle.model.model_file import parse_model

    about = log.meta.get("model")
    text = about.get("toml") if isinstance(about, dict) else None
    if not isinstance(text, str):
        return None
    try:
        driven = _seen_with(parse_model(text))
    except ModelError:  # one with effects of the user's own
        return None
    return None if driven == _seen_with(model) else driven


def _seen_with(model: VehicleModel) -> str:
    """The effects of perception of a model, with their values, on a line; "" if it has none."""
    from vehicle.model.perception_effects import perception_in

    return ", ".join(
        f"{one.name} ({', '.join(f'{key} = {value:.6g}' for key, value in one.values.items())})"
        for one in perception_in(model.effects)
    )


def _unjudged(logs: dict[str, Log], twins: dict[str, Log]) -> str:
    """What to give so that detections of simulated sensors are judged; "" if they are, or there are none."""
    from pytest_dvp.gap.perception.diagnose_perception import simulated_sensors

    open_ones = sorted({
        log.meta.get("scenario", "") for log in logs.values()
        if simulated_sensors(log) and log.meta["stage"] != "dt" and len(log.detections.t)
    } - set(twins))  # fmt: skip
    if not open_ones:
        return ""
    names = ", ".join(open_ones)
    return f"detections are not judged: simulated sensors made them; name the twin's run of {names} by --twin"


def _true_motion(logs: dict[str, Log]) -> str:
    """What a run of the twin does not hold of its own model; "" if none of the logs is one."""
    runs = [name for name, log in logs.items() if log.meta.get("stage") == "dt"]
    if not runs:
        return ""
    what = "run of the twin, which logs" if len(runs) == 1 else "runs of the twin, which log"
    return (
        f"{', '.join(runs)}: {what} the true motion: what the model has of sensors and of a tilting body is not in it, "
        "and is called too much"
    )


def read_all(texts: list[str], arguments: argparse.Namespace) -> dict[str, Log]:
    """Logs by name; warnings are told on stderr. Raises LogError for a log with an error."""
    from pytest_dvp.doctor import print_findings, read_checked_log
    from pytest_dvp.logs.log_names import log_names

    logs: dict[str, Log] = {}
    for name, text in zip(log_names(texts), texts, strict=True):
        logs[name], findings = read_checked_log(text, **log_options(arguments))
        print_findings(findings)
    return logs
