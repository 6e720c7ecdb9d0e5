"""Everything about an advised manoeuvre as files of one folder."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pytest_dvp.gap.manoeuvres.choice import Choice
from pytest_dvp.gap.manoeuvres.driver_card import card
from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
from pytest_dvp.gap.manoeuvres.simulated_drive import columns
from pytest_dvp.gap.manoeuvres.trajectory_scenario import road, scenario
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

_ROBOT = '''"""Plays {name}_commands.csv: dvp run {name}.xosc --ads {name}_robot.py:Robot --model MODEL.toml"""

from pathlib import Path

from pytest_dvp.gap.manoeuvres.steering_robot import CommandPlayer


def Robot(parameters, network, description):
    return CommandPlayer(Path(__file__).with_name("{name}_commands.csv"), description)
'''


def write_plan(choice: Choice, model: VehicleModel, envelope: Envelope, noise: Mapping[str, float], folder: Path,
               name: str) -> dict[str, str]:  # fmt: skip
    """Writes scenario, road, commands, robot and card of a choice; their paths by kind, each whole or not at all.

    `name`: what the files are called.

    Raises OSError: the folder cannot be made or written.
    """
    from reports.driver_card import driver_card

    folder.mkdir(parents=True, exist_ok=True)
    drive = choice.drive
    files = {
        "scenario": folder / f"{name}.xosc",
        "commands": folder / f"{name}_commands.csv",
        "robot": folder / f"{name}_robot.py",
        "card": folder / f"{name}_card.html",
    }
    told = {kind: str(path) for kind, path in files.items()}
    what = f"{choice.manoeuvre.title}: {'shows' if choice.exciting else 'decides between'} {', '.join(choice.effects)}"
    _write(folder / f"{name}.xodr", road(drive.area))
    _write(files["scenario"], scenario(drive, model.car, envelope, f"{name}.xodr", what))
    _write(files["commands"], _commands(choice, model))
    _write(files["robot"], _ROBOT.format(name=name))
    text = card(choice, model, envelope, noise, {})
    page = driver_card(choice.manoeuvre.title, text, drive.t, drive.motion, drive.wishes, tuple(drive.area))
    _write(files["card"], page)
    return told


def _commands(choice: Choice, model: VehicleModel) -> str:
    """What to ask for, in the model's own inputs and plainly, and what should come of it."""
    from pytest_dvp.logs.signals import SIGNALS

    drive = choice.drive
    named: dict[str, FloatArray] = {}
    for column, values in columns(drive, model.inputs).items():
        named[f"{column} [{SIGNALS[column].unit if column in SIGNALS else '-'}]"] = values
    for k, column in enumerate(("wanted_accel [m/s^2]", "wanted_steer [rad]", "wanted_speed [m/s]")):
        named[column] = drive.wishes[:, k]
    for k, column in enumerate(("planned_x [m]", "planned_y [m]", "planned_yaw [rad]", "planned_v [m/s]")):
        named[column] = drive.motion[:, k]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(named)
    writer.writerows([[f"{value:.6g}" for value in row] for row in np.column_stack(list(named.values())).tolist()])
    return stream.getvalue()


def _write(path: Path, text: str) -> None:
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    except OSError:
        partial.unlink(missing_ok=True)
        raise
