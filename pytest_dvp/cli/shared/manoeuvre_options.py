"""Limits of a manoeuvre as options, and the files of those that are advised: for plan and diagnose."""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.cli.shared.arguments import WrongArgument
from pytest_dvp.drive.option_sources import possible_folder
from pytest_dvp.text.errors import SettingError

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.diagnosis import Diagnosis
    from pytest_dvp.gap.manoeuvres.choice import Choice
    from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
    from pytest_dvp.logs.log import Log
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

LIMITS: Mapping[str, str] = {
    "max_speed": "m/s",
    "max_acceleration": "m/s^2",
    "max_deceleration": "m/s^2",
    "max_lateral": "m/s^2, lateral acceleration",
    "length": "m, of the free ground",
    "width": "m, of the free ground",
    "max_steer": "rad at the road wheels",
    "steer_rate": "rad/s at the road wheels",
}


def add_limits(parser: argparse.ArgumentParser) -> None:
    """The options of the envelope."""
    from pytest_dvp.gap.manoeuvres.driving_limits import Envelope

    defaults = dataclasses.asdict(Envelope())
    group = parser.add_argument_group("limits that no manoeuvre exceeds")
    for name, unit in LIMITS.items():
        group.add_argument(f"--{name.replace('_', '-')}", metavar="X", help=f"{unit}; default {defaults[name]:g}")


def limits_from(arguments: argparse.Namespace) -> Envelope:
    """The envelope of the options. Raises WrongArgument."""
    from pytest_dvp.gap.manoeuvres.driving_limits import Envelope

    given = {}
    for name, unit in LIMITS.items():
        text = getattr(arguments, name)
        if text is None:
            continue
        option = f"--{name.replace('_', '-')}"
        try:
            if not text.isascii() or "_" in text:  # which only Python takes for a number
                raise ValueError
            given[name] = float(text)
            Envelope(**{name: given[name]})
        except ValueError:
            raise WrongArgument(f"{option} is {text}, expected more than 0 [{unit}]") from None
        if name == "max_steer" and given[name] >= math.pi / 2:
            raise WrongArgument(f"{option} is {text}, expected less than 1.57 [{unit}]; in degrees?")
    return Envelope(**given)


def limit_words(arguments: argparse.Namespace) -> list[str]:
    """The limits that were given, as words of a command line."""
    given = [(f"--{name.replace('_', '-')}", getattr(arguments, name)) for name in LIMITS]
    return [word for option, text in given if text is not None for word in (option, text)]


def check_folder(option: str, folder: Path) -> None:
    """Raises WrongArgument if the folder is none, and cannot be made."""
    try:
        possible_folder(folder, option)
    except SettingError as error:
        raise WrongArgument(str(error)) from None


def write_all(choices: Sequence[Choice], model: VehicleModel, envelope: Envelope, noise: Mapping[str, float] | None,
              folder: Path) -> list[dict[str, str]]:  # fmt: skip
    """The files of each choice, in their order. Raises WrongArgument: the folder cannot be written."""
    from pytest_dvp.gap.manoeuvres.plan_folder import write_plan
    from pytest_dvp.gap.manoeuvres.rehearsal import NOISE

    written: list[dict[str, str]] = []
    taken: dict[str, int] = {}
    for choice in choices:
        name = choice.manoeuvre.name
        taken[name] = taken.get(name, 0) + 1
        stem = name if taken[name] == 1 else f"{name}_{taken[name]}"
        try:
            written.append(write_plan(choice, model, envelope, noise or NOISE, folder, stem))
        except OSError as error:
            raise WrongArgument(f"{folder}: cannot be written: {error.strerror}") from None
    return written


def with_manoeuvres(found: Diagnosis, logs: Mapping[str, Log], model: VehicleModel, envelope: Envelope,
                    effects: tuple[Effect, ...], folder: Path) -> Diagnosis:  # fmt: skip
    """The diagnosis with the scenario that decides between each effect and its rivals, written into the folder."""
    from pytest_dvp.gap.manoeuvres.advice import advise

    advice = advise(found, logs, model, envelope, effects=effects, exciting=False)
    for line in advice.refused:
        print(f"no manoeuvre: {line}", file=sys.stderr)
    written = write_all(tuple(advice.deciding.values()), model, envelope, found.noise_floor, folder)
    files = dict(zip(advice.deciding, (entry["scenario"] for entry in written), strict=True))
    named = (dataclasses.replace(e, deciding_manoeuvre=files.get(e.name)) for e in found.effects)
    return dataclasses.replace(found, effects=tuple(named))
