"""The logs of a case, its baseline model and what is true about it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np

from benchmarks.hidden_effects.case import Case
from benchmarks.hidden_effects.detectable import LEAST_GAIN, body, drives, gain
from benchmarks.hidden_effects.ranges import draw, draw_on_top
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, ObjectTrack
from tests.truth.dirty import dirty
from tests.truth.effects import FloatArray, TruthCar
from tests.truth.generate import Noise, make_log
from tests.truth.multibody import CARS, make_multibody_log
from tests.truth.tracks import Tracks, make_tracks
from vehicle.model.car import make_car
from vehicle.model.vehicle_model import Inputs, VehicleModel
from vehicle.surrogate.car import Car
from vehicle.surrogate.driver import Drive
from vehicle.surrogate.hidden import Hidden
from vehicle.surrogate.recorder import record

TRIES = 30
OTHER_RUN = 500_009  # added to the seed for the held-out run of the same car
Values = dict[str, dict[str, float]]
SIZES = {"vehicle": (4.5, 1.8, 1.5), "pedestrian": (0.5, 0.6, 1.8), "bicycle": (1.8, 0.6, 1.7)}


@dataclass(frozen=True)
class Question:
    """What a diagnosis gets, and the answer: `truth` values by effect; `gains` of each in chi^2/N, None = not asked."""

    logs: Mapping[str, Log]
    held_out: Mapping[str, Log]
    model: VehicleModel
    truth: Values
    gains: Mapping[str, float] | None


def drives_of(case: Case) -> tuple[Drive, ...]:
    """What was driven: only the urban drive where that is the question."""
    return ("urban",) if case.category in ("urban", "perception") else ("rich", "urban")


def values_of(case: Case) -> tuple[Values, dict[str, float] | None] | None:
    """Values of all `names` that can be seen, and their gains. None if no draw of TRIES can be seen."""
    rng = case.rng()
    if case.category in ("surrogate", "multibody"):
        return {name: _on_the_grid(case, name, draw_on_top(name, rng)) for name in case.names}, None
    if case.category == "perception":
        return {name: draw(name, rng) for name in case.names}, None
    seen = drives_of(case)
    for _ in range(TRIES):
        values = {name: draw(name, rng) for name in case.names}
        if not all(drives(values, drive, case.log_seed) for drive in seen):
            continue
        gains = {name: gain(values, name, seen, case.log_seed, case.noise) for name in case.names}
        if all(found >= LEAST_GAIN for found in gains.values()):
            return values, gains
    return None


def _on_the_grid(case: Case, name: str, values: dict[str, float]) -> dict[str, float]:
    """Delays on a recording are whole samples."""
    if case.category == "multibody" and name in ("steer_delay", "drive_delay"):
        return {"T": round(round(values["T"] / 0.02) * 0.02, 6)}
    return values


def question(case: Case) -> Question | None:
    """Everything about a case; None if its effect cannot be seen however it is drawn."""
    drawn = values_of(case)
    if drawn is None:
        return None
    values, gains = drawn
    truth = {name: values[name] for name in case.truth}
    logs = {f"{drive}.csv": _log(case, truth, drive, case.log_seed) for drive in drives_of(case)}
    if case.dirt:
        logs = {name: Log(dirty(log.columns, case.dirt, case.seed)) for name, log in logs.items()}
    held_out: dict[str, Log] = {}
    if case.category != "multibody":  # there is one recording a drive
        drive = drives_of(case)[0]
        held_out = {f"other_{drive}.csv": _log(case, truth, drive, case.log_seed + OTHER_RUN)}
    return Question(logs, held_out, baseline(case), truth, gains)


def _log(case: Case, truth: Values, drive: Drive, seed: int) -> Log:
    noise = cast(Noise, case.noise)
    if case.category == "surrogate":
        return Log(record(Hidden(effects=truth, noise=case.noise), drive, seed))
    if case.category == "multibody":
        return Log(make_multibody_log(case.car, drive, seed, noise, truth))
    if case.category == "perception":
        tracks = make_tracks(truth, seed)
        return Log(make_log({}, drive, seed, noise), objects=_objects(tracks), detections=_detections(tracks))
    return Log(make_log(truth, drive, seed, noise, body=body(case.names)))


def baseline(case: Case) -> VehicleModel:
    """The car's data sheet: a kinematic bicycle with ideal actuators; with its tyres where the effect is one of how
    slipping tyres work (it would not be the only thing that the kinematic one lacks)."""
    car, base = TruthCar(), "kinematic_bicycle"
    known: dict[str, float] = {
        "wheelbase": car.wheelbase,
        "cg_to_front_axle": car.cg_to_front_axle,
        "mass": car.mass,
        "yaw_inertia": car.yaw_inertia,
    }
    if case.category == "surrogate":
        known = {name: getattr(Car(), name) for name in known}
    elif case.category == "multibody":
        known = {name: getattr(CARS[case.car], name) for name in known}
    elif body(case.names) == "dynamic":
        base = "dynamic_bicycle"
        known |= {
            "cornering_stiffness_front": car.stiffness_front,
            "cornering_stiffness_rear": car.stiffness_rear,
        }
    longitudinal = "speed_cmd" if "speed_controller" in case.names else "accel_cmd"
    return VehicleModel(base, Inputs(longitudinal=(longitudinal,)), make_car(known))  # type: ignore[arg-type]


def _objects(tracks: Tracks) -> dict[str, ObjectTrack]:
    found = {}
    for name, kind in zip(tracks.names, tracks.kinds, strict=True):
        t, x, y = (np.ascontiguousarray(column) for column in tracks.truth[name].T)
        vx, vy = np.gradient(x, t), np.gradient(y, t)
        found[name] = ObjectTrack(kind, *SIZES[kind], t, x, y, 0.75 + 0.0 * t, np.arctan2(vy, vx), vx, vy)
    return found


def _detections(tracks: Tracks) -> DetectionTable:
    t, which, x, y = (np.ascontiguousarray(column) for column in tracks.detections.T)
    kinds = tuple(tracks.kinds[int(k)] if k >= 0 else "vehicle" for k in which)
    sizes: FloatArray = np.array([SIZES[kind][:2] for kind in kinds]).reshape(-1, 2)
    unknown = np.full(len(t), math.nan)
    return DetectionTable(
        t, kinds, x, y, unknown, np.ascontiguousarray(sizes[:, 0]), np.ascontiguousarray(sizes[:, 1]), unknown, unknown
    )
