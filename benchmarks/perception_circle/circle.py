"""The circle of one hidden perception effect: hide it in the car, drive, diagnose, extend the twin, drive that."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Mapping
from pathlib import Path

from pytest_dvp.drive.run import run
from pytest_dvp.gap.extend.perception import judge_perception
from pytest_dvp.gap.perception.diagnose_perception import diagnose_perceptions
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics import tracking
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import model_text
from vehicle.model.vehicle_model import VehicleModel

P = {"LIDAR_abs_y_max": 12.0, "LIDAR_x_max": 60.0}
"""The stack keeps LiDAR points of the whole street, not of its lane alone [m]."""
ROUNDS = 3  # drives of the twin that are diagnosed: what a tracker dampens comes closer with each
AHEAD = {"reach": 40.0, "beside": 9.0, "within": 3.0}  # m, of all metrics here
HIDDEN: dict[str, dict[str, float]] = {
    "detection_latency": {"T": 0.25},
    "detection_offset": {"x": 0.6, "y": -0.4},
    "detection_range": {"R": 30.0},
    "detection_misses": {"rate": 0.5},
    "detection_false": {"rate": 2.0},
    "detection_size": {"length_ratio": 1.4, "width_ratio": 1.3},
    "detection_yaw": {"b": 0.2},
    "detection_occlusion": {"share": 0.3},
    "detection_noise": {"sigma0": 0.4, "slope": 0.0},
}


@dataclasses.dataclass(frozen=True)
class Shown:
    """What the detections of a drive are like; None where the drive does not tell."""

    recall: float | None
    position_error: float | None
    latency: float | None
    yaw_error: float | None
    false_time: float | None


@dataclasses.dataclass(frozen=True)
class Circle:
    """The answer for one hidden effect.

    found: values by effect and key that the twin was given in the end; named: effects that the first diagnosis named;
    car, before, after: of the car's drive, and of those of the twin without and with what was found.
    """

    hidden: Mapping[str, Mapping[str, float]]
    named: tuple[str, ...]
    found: Mapping[str, Mapping[str, float]]
    car: Shown
    before: Shown
    after: Shown


def circle(
    scenario: Path, folder: Path, model: VehicleModel, hidden: Mapping[str, Mapping[str, float]], seed: int = 7,
    rounds: int = ROUNDS, judges: int = 1,
) -> Circle:  # fmt: skip
    """Drive the surrogate with `hidden` in it on stage rw, and the twin `model` on dt, until they see alike.

    What they show in the end is the mean over `judges` seeds, from `seed` on, of which only the first is diagnosed.
    Files are written into `folder`. Raises RuntimeError if a drive breaks.
    """
    folder.mkdir(parents=True, exist_ok=True)
    inside = folder / "hidden.toml"
    tables = (
        f"[hidden.{name}]\n" + "".join(f"{k} = {v}\n" for k, v in values.items()) for name, values in hidden.items()
    )
    inside.write_text("\n".join(tables), encoding="utf-8")
    car = _drive(scenario, seed, stage="rw", vehicle=f"surrogate:{inside}")
    twin = before = _twin(scenario, folder, model, seed)
    named: tuple[str, ...] | None = None
    for _ in range(rounds):
        model, again = _extended(model, car, twin)
        named = again if named is None else named
        if not again:
            break
        twin = _twin(scenario, folder, model, seed)
    found = {a.name: dict(a.values) for a in model.effects if a.effect.slot == "perception"}
    cars = [_drive(scenario, seed + k, stage="rw", vehicle=f"surrogate:{inside}") for k in range(1, judges)]
    twins = [_twin(scenario, folder, model, seed + k) for k in range(1, judges)]
    return Circle(hidden, named or (), found, shown_in(car, *cars), shown_in(before), shown_in(twin, *twins))


def _extended(model: VehicleModel, car: Log, twin: Log) -> tuple[VehicleModel, tuple[str, ...]]:
    """The model with what the diagnosis confirms, and the names of that; what `dvp extend --twin` does."""
    logs, twins = {"car": car}, {str(twin.meta["scenario"]): twin}
    sure = [e for e in diagnose_perceptions(logs.values(), model, twins) if e.standing == "confirmed"]
    add = [find_effect(e.name) for e in sure if e.action != "remove"]
    gone = [e.name for e in sure if e.action == "remove"]
    for accepted in judge_perception(model, logs, {}, add, gone, twins):
        if accepted.wrong:
            continue
        name, values = accepted.effect.name, {k: e.value for k, e in accepted.effect.parameters.items()}
        model = model.without_effect(name) if accepted.effect.action == "remove" else model.with_effect(name, values)
    return model, tuple(e.name for e in sure)


def _twin(scenario: Path, folder: Path, model: VehicleModel, seed: int) -> Log:
    file = folder / "twin.toml"
    file.write_text(model_text(model), encoding="utf-8")
    return _drive(scenario, seed, stage="dt", model=file)


def _drive(scenario: Path, seed: int, **options: object) -> Log:
    result = run(scenario, seed=seed, P=P, **options)  # type: ignore[arg-type]
    if result.error is not None:
        raise RuntimeError(result.error)
    return result.log


def shown_in(*logs: Log) -> Shown:
    """The metrics of the detections of drives, mean over those that tell."""

    def value(metric: object) -> float | None:
        told = []
        for log in logs:
            with contextlib.suppress(Undefined):
                told.append(float(metric(log, **AHEAD).value))  # type: ignore[operator]
        return sum(told) / len(told) if told else None

    return Shown(
        value(tracking.detection_recall),
        value(tracking.track_position_error),
        value(tracking.track_latency),
        value(tracking.track_yaw_error),
        value(tracking.false_tracks),
    )
