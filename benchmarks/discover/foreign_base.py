"""Nulls on a base that is not ours: cars of MuJoCo with the twin that learnt them, and twins with a wrong value."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.foreign_cars.ask import OTHER_RUN, matched
from benchmarks.foreign_cars.car import CARS, data_sheet
from benchmarks.foreign_cars.drive import make_log
from pytest_dvp.logs.log import Log
from vehicle.model.model_file import parse_model
from vehicle.model.vehicle_model import VehicleModel

KINDS = ("foreign", "badly_tuned", "bare")
"""foreign: the twin that learnt the car; badly_tuned: the same with one value off; bare: the car's data sheet."""

OFF = (("steer_ratio", "g"), ("drive_gain", "g"), ("brake_gain", "g"), ("mass", "ratio"))
BY = 0.06  # at most: what a calibration of a year ago may be wrong


def foreign(
    kind: str, number: int, seed: int, folder: Path
) -> tuple[VehicleModel, dict[str, Log], dict[str, Log], dict[str, Any]]:
    """Model, logs and logs held out of a car without a hidden law; twins are kept in `folder`."""
    rng = np.random.default_rng([seed, number, KINDS.index(kind), 77])
    name = list(CARS)[int(rng.integers(len(CARS)))]
    car = CARS[name]
    if kind == "bare":
        model = parse_model(data_sheet(car))
    else:
        model, _ = matched(name, folder)
    if kind == "badly_tuned":
        effect, key = OFF[int(rng.integers(len(OFF)))]
        was = next((one.values[key] for one in model.effects if one.name == effect), 1.0)
        model = model.with_effect(
            effect, {key: was * (1.0 + float(rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 1.0) * BY))}
        )
    first = int(rng.integers(1, 1_000_000))
    logs = {"rich.csv": make_log(car, "rich", first)}
    judge = {"town.csv": make_log(car, "town", first + OTHER_RUN)}
    return model, logs, judge, {"base": f"{kind} {name}", "true": {}}
