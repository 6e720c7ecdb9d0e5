"""Plans the manoeuvre to drive next, to distinguish rivals or to show effects that the data could not.

If logs are given, they are diagnosed first. Every manoeuvre stays within the given limits. It is written as a scenario,
as commands for a drive-by-wire car, and as a card for a driver.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.cli.diagnose import read_all
from pytest_dvp.cli.doctor import add_log_options, existing_log
from pytest_dvp.cli.effects import add_effects, effects_from
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, existing
from pytest_dvp.cli.shared.command_columns import check_command_columns
from pytest_dvp.cli.shared.forwarded_options import forwarded_options
from pytest_dvp.cli.shared.held_out_logs import refuse_same_drive, refuse_same_path
from pytest_dvp.cli.shared.manoeuvre_options import add_limits, check_folder, limits_from, write_all
from pytest_dvp.cli.shared.progress import progress
from pytest_dvp.cli.shared.selected_parts import select_parts
from pytest_dvp.text.plain_json import finite

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.diagnosis import Diagnosis
    from pytest_dvp.gap.manoeuvres.catalogue import Manoeuvre
    from pytest_dvp.gap.manoeuvres.choice import Choice
    from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
    from pytest_dvp.logs.log import Log
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

PLACE = 90  # in `dvp --help`


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare model, logs, rivals to distinguish, effects to excite, driving limits and output folder."""
    parser.add_argument("logs", nargs="*", metavar="LOG", help="measured log whose diagnosis leaves a question open")
    parser.add_argument("--model", required=True, metavar="M.toml", help="vehicle model")
    parser.add_argument("--between", metavar="A,B", help="distinguish these effects")
    parser.add_argument("--excite", metavar="A,B", help="show these effects, if the car has them")
    parser.add_argument("--drive", metavar="A,B", help="write these manoeuvres, such as step_steer, whatever they show")
    parser.add_argument(
        "--held-out",
        action="append",
        default=[],
        metavar="LOG",
        help="log that judges the diagnosis, as in diagnose; not with --between, --excite and --drive",
    )
    parser.add_argument("--out", default="plan", metavar="FOLDER", help="folder of the files; default: ./plan")
    parser.add_argument(
        "--only", metavar="A,B", help="choose only among these manoeuvres, such as step_steer,coast_down"
    )
    add_limits(parser)
    add_log_options(parser)
    add_effects(parser)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print and write the manoeuvre to drive next. Returns 0.

    Raises WrongArgument if nothing is named to plan for, a list holds an empty name, `--out` is empty, held-out logs
    are given where nothing is diagnosed, or no command moves the model.
    """
    for text in [*arguments.logs, *arguments.held_out]:
        existing_log(text)
    existing(arguments.model, "model")
    refuse_same_path(arguments.logs, arguments.held_out)
    if not (arguments.logs or arguments.between or arguments.excite or arguments.drive):
        raise WrongArgument(
            "dvp plan: nothing to plan for: name logs, --between A,B, --excite A or --drive A (dvp plan --help)"
        )
    asked = next((option for option in ("between", "excite", "drive") if getattr(arguments, option) is not None), "")
    if arguments.held_out and asked:
        raise WrongArgument(f"--held-out: judges a diagnosis, and with --{asked} there is none: leave it out")
    for option in ("between", "excite", "only", "drive"):
        if getattr(arguments, option) is not None and not _names(getattr(arguments, option)):
            raise WrongArgument(f"--{option}: no name in it")
    if not arguments.out.strip():
        raise WrongArgument("--out: no name, expected a folder")
    envelope, out = limits_from(arguments), Path(arguments.out)
    check_folder("--out", out)
    manoeuvres, driven = _manoeuvres("--only", arguments.only), _manoeuvres("--drive", arguments.drive)
    from vehicle.model.model_file import read_model

    extra = effects_from(arguments)
    model = read_model(arguments.model, extra=extra)
    effects = tuple(extra.values())
    refused: tuple[str, ...] = ()
    logs: dict[str, Log] = {}
    with progress("dvp plan", "planning") as tick:
        if arguments.drive or arguments.between or arguments.excite:
            from pytest_dvp.gap.manoeuvres.choice import as_named

            about = _names(f"{arguments.between or ''},{arguments.excite or ''}")
            if model.drives_nothing and "speed_controller" not in about:
                raise WrongArgument(f"{arguments.model}: {model.drives_nothing}")
            named = as_named(driven, model, envelope) if arguments.drive else ()
            found, choices = None, named + _asked(arguments, model, envelope, effects, manoeuvres)
        else:
            from pytest_dvp.gap.diagnose.diagnose import diagnose
            from pytest_dvp.gap.manoeuvres.advice import advise

            measured, held_out = read_all(arguments.logs, arguments), read_all(arguments.held_out, arguments)
            refuse_same_drive(measured, held_out)
            check_command_columns("dvp plan", model, arguments.model, measured, held_out)
            fitted, judged = (
                select_parts(arguments.logs, measured, model),
                select_parts(arguments.held_out, held_out, model),
            )
            logs = fitted.logs
            for text in (fitted.said, judged.said):
                if text:
                    print(f"dvp plan: {text}", file=sys.stderr)
            found = diagnose(logs, model, held_out=judged.logs, effects=effects, tick=tick)
            tick("planning")
            advice = advise(found, logs, model, envelope, effects=effects, manoeuvres=manoeuvres)
            choices, refused = advice.choices, advice.refused
    noise = found.noise_floor if found is not None else None
    written = write_all(choices, model, envelope, noise, out)
    if arguments.json:
        print(json.dumps(finite(_document(found, choices, written, refused)), ensure_ascii=False, allow_nan=False))
    else:
        print(_page(arguments, found, choices, written, refused, model, envelope, noise))
        if found is not None and not choices and not refused:
            for line in _not_shown(logs, model, extra):
                print(line)
    return 0


def _asked(arguments: argparse.Namespace, model: VehicleModel, envelope: Envelope, effects: tuple[Effect, ...],
           manoeuvres: tuple[Manoeuvre, ...]) -> tuple[Choice, ...]:  # fmt: skip
    from pytest_dvp.gap.manoeuvres.advice import between, showing
    from pytest_dvp.gap.manoeuvres.choice import PlanError, candidates_by_name

    for option, text in (("--between", arguments.between), ("--excite", arguments.excite)):
        try:
            candidates_by_name(model, _names(text or ""), effects)
        except PlanError as error:
            raise WrongArgument(f"{option}: {error}") from None
    choices: tuple[Choice, ...] = ()
    logs = read_all(arguments.logs, arguments)
    check_command_columns("dvp plan", model, arguments.model, logs)
    if arguments.between:
        choices += (between(_names(arguments.between), logs, model, envelope, effects=effects, manoeuvres=manoeuvres),)
    if arguments.excite:
        choices += showing(_names(arguments.excite), logs, model, envelope, effects=effects, manoeuvres=manoeuvres)
    return choices


def _manoeuvres(option: str, text: str | None) -> tuple[Manoeuvre, ...]:
    from pytest_dvp.gap.manoeuvres.catalogue import MANOEUVRES, chosen

    if text is None:
        return MANOEUVRES
    try:
        return chosen(_names(text))
    except ValueError as error:
        raise WrongArgument(f"{option}: {error}") from None


def _names(text: str) -> list[str]:
    return list(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


def _document(found: Diagnosis | None, choices: tuple[Choice, ...], written: list[dict[str, str]],
              refused: tuple[str, ...]) -> dict[str, object]:  # fmt: skip
    from pytest_dvp.gap.manoeuvres.driver_card import as_dict

    return {
        "verdict": found.verdict if found is not None else None,
        "manoeuvres": [as_dict(choice, files) for choice, files in zip(choices, written, strict=True)],
        "refused": list(refused),
    }


def _page(arguments: argparse.Namespace, found: Diagnosis | None, choices: tuple[Choice, ...],
          written: list[dict[str, str]], refused: tuple[str, ...], model: VehicleModel, envelope: Envelope,
          noise: Mapping[str, float] | None) -> str:  # fmt: skip
    from pytest_dvp.gap.manoeuvres.driver_card import card
    from pytest_dvp.gap.manoeuvres.rehearsal import NOISE

    parts = []
    if found is not None:
        sets = [" or ".join((e.name, *e.rivals)) for e in found.effects]
        parts.append(f"{found.verdict}: {'; '.join(sets) or 'no effect named'}")
    parts += [
        card(
            choice,
            model,
            envelope,
            noise or NOISE,
            files,
            arguments.model,
            arguments.logs,
            [*(word for log in arguments.held_out for word in ("--held-out", log)), *forwarded_options(arguments)],
        )
        for choice, files in zip(choices, written, strict=True)
    ]
    parts += [f"no manoeuvre: {line}" for line in refused]
    if not choices and not refused:
        parts.append("nothing to drive: no rivals are left, and the data could have shown every effect that was tried")
    return "\n\n".join(parts)


def _not_shown(logs: Mapping[str, Log], model: VehicleModel, extra: Mapping[str, Effect]) -> list[str]:
    """What the doctor says that none of the logs could show, and why."""
    from pytest_dvp.doctor import excitation

    shown = [excitation(log, model, extra) for log in logs.values()]
    reasons: dict[str, list[str]] = {}
    for effect, reason in shown[0].out_of_reach.items():
        if all(effect in one.out_of_reach for one in shown):
            reasons.setdefault(reason, []).append(effect)
    lines = [f"  {', '.join(effects)}: {reason}" for reason, effects in reasons.items()]
    return ["not tried, for these data could not show (dvp doctor):", *lines] if lines else []
