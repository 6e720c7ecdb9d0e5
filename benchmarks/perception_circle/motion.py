"""The surrogate's motion, learnt from its logs before its perception is looked at.

A twin that drives otherwise sees otherwise: one from a bare data sheet is 6 m elsewhere after 40 s.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from benchmarks.foreign_cars.ask import learnt
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.read_log import read_log
from vehicle.model.model_file import read_model
from vehicle.model.vehicle_model import VehicleModel

FITTED, HELD_OUT = ("rich", 1), ("urban", 2)  # drives of the surrogate and their seeds


def learn_motion(sheet: Path, folder: Path) -> VehicleModel:
    """The twin `sheet`, extended by all that a diagnosis of two drives of the surrogate names; files are in `folder`.

    Raises subprocess.CalledProcessError if the surrogate does not drive.
    """
    folder.mkdir(parents=True, exist_ok=True)
    return learnt(folder / "learnt.toml", read_model(sheet), _driven(folder, *FITTED), _driven(folder, *HELD_OUT))[0]


def _driven(folder: Path, drive: str, seed: int) -> dict[str, Log]:
    file = folder / f"{drive}.csv"
    words = ["--drive", drive, "--seed", str(seed), "--out", str(file)]
    subprocess.run([sys.executable, "-m", "vehicle.surrogate", *words], check=True, stdout=subprocess.DEVNULL)
    return {file.name: read_log(file)}
