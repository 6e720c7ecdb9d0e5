"""One case asked: the twin matched as a user does it, the car driven again, the answer as one line."""

from __future__ import annotations

import time
from collections.abc import Mapping
from math import isinf
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.foreign_cars.car import WHEEL_MASS, ForeignCar, data_sheet
from benchmarks.foreign_cars.case import Case
from benchmarks.foreign_cars.drive import LEVELS, NOISE, driven, logged, make_log
from benchmarks.foreign_cars.fleet import FLEET
from benchmarks.foreign_cars.hidden import Values, sensed
from benchmarks.foreign_cars.tyres import FloatArray
from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.gap.extend.extend import extend
from pytest_dvp.gap.extend.growth import grow
from pytest_dvp.logs.log import Log
from vehicle.model.model_file import model_text, parse_model, read_model
from vehicle.model.vehicle_model import VehicleModel

MATCHED_ON = (7001, 7002)  # seeds of the drives on which a twin learns its car; no case has them
OTHER_RUN = 500_009  # added to a case's seed for the run that is held out
VISIBLE = 3.0  # sigma of one sample, by which some signal must differ at some time to call an effect detectable,
LASTING = 25  # in so many rows of the drive


def matched(car: str, folder: Path) -> tuple[VehicleModel, dict[str, Any]]:
    """The twin of one of our foreign cars, see `learnt`; kept in a file of `folder`."""
    file = folder / f"{car}.toml"
    if file.exists():
        return read_model(file), {}
    logs = {f"{car}_rich.csv": make_log(FLEET[car], "rich", MATCHED_ON[0])}
    held_out = {f"{car}_town.csv": make_log(FLEET[car], "town", MATCHED_ON[1])}
    return learnt(file, parse_model(data_sheet(FLEET[car])), logs, held_out)


def learnt(
    file: Path, sheet: VehicleModel, logs: Mapping[str, Log], held_out: Mapping[str, Log]
) -> tuple[VehicleModel, dict[str, Any]]:
    """The twin that learnt a car from its drives, by `diagnose` and `extend` with all that is named, then, if it leaves
    more than noise, from all of them together (`grow`), and the answer of the diagnosis with its CPU time [s]. The twin
    is written to `file`, and read from it the next time (no answer)."""
    if file.exists():
        return read_model(file), {}
    begin = time.process_time()
    found = diagnose(logs, sheet, held_out)
    cpu = time.process_time() - begin
    add = [e.name for e in found.effects if e.action == "add" and e.name not in found.set_up]
    twin = extend(logs, sheet, add=add, held_out=held_out, start=found.values).model
    if twin.remainder:
        twin = grow({**logs, **held_out}, twin).model
    file.parent.mkdir(parents=True, exist_ok=True)
    draft = file.with_suffix(".part")
    draft.write_text(model_text(twin), encoding="utf-8")
    draft.replace(file)
    return twin, {**found.as_dict(), "cpu": round(cpu, 1)}


def detectable(case: Case, with_it: Mapping[str, FloatArray]) -> bool:
    """True if the car's signals (`with_it`: its motion as it is asked) on the same commands differ with and without the
    effect: by 3 sigma in 25 rows of one signal. Positions and heading are compared where the effect is one of the
    sensors alone, as both cars then drive the same way; otherwise a first small difference would grow with the
    distance."""
    car, hidden = FLEET[case.car], case.truth
    commands = np.column_stack([with_it["accel_cmd"], with_it["steer_cmd"]])
    without = driven(car, "rich", case.drive_seed, commands=commands)
    a, b = sensed(with_it, hidden), sensed(without, {})
    scale = VISIBLE * LEVELS[case.noise]
    same_way = bool(np.array_equal(with_it["x"], without["x"]) and np.array_equal(with_it["y"], without["y"]))
    signals = ("v", "yaw_rate", "ax", "ay", *(("x", "y", "yaw") if same_way else ()))
    return any(int(np.count_nonzero(np.abs(a[n] - b[n]) > scale * NOISE[n])) >= LASTING for n in signals)


def effective(car: ForeignCar, hidden: Values) -> dict[str, dict[str, float]]:
    """The hidden values as the catalogue means them, by accelerations: on a straight, the car in MuJoCo shows by how
    much less a force accelerates it with a payload (which presses the tyres flatter, too, and leaves the wheels alone);
    air slows down turning wheels as well."""
    found = {name: dict(values) for name, values in hidden.items()}
    if "mass" in hidden:
        gains = [_rate(car, 2.0, each) - _rate(car, 0.7, each) for each in ({}, hidden)]
        found["mass"]["ratio"] = gains[0] / gains[1]
    if "aero_drag" in hidden:
        found["aero_drag"]["k"] *= car.mass / (car.mass + 2.0 * WHEEL_MASS)  # four discs of this mass, rolling
    return found


def _rate(car: ForeignCar, wanted: float, hidden: Values) -> float:
    """Acceleration [m/s^2] that a car shows on a straight when `wanted` is asked for."""
    commands = np.column_stack([np.full(200, wanted), np.zeros(200)])
    log = driven(car, "rich", 1, hidden, duration=4.0, commands=commands)
    return float(np.polyfit(log["t"][50:], log["v"][50:], 1)[0])


def total(hidden: Values, twin: VehicleModel) -> dict[str, dict[str, float]]:
    """What a diagnosis that starts from the twin should find: where the twin has the effect already, its value and the
    hidden one together. Gains multiply, limits take the smaller one, all else adds. A cap on the torque is one on the
    acceleration that the twin's mass leaves of it."""
    found = {name: dict(values) for name, values in hidden.items()}
    for applied in twin.effects:
        for name, value in found.get(applied.name, {}).items():
            own, neutral = applied.values[name], applied.effect.key(name).neutral
            found[applied.name][name] = min(value, own) if isinf(neutral) else value * own if neutral else value + own
        if applied.name == "mass" and "drive_torque_limit" in found:
            found["drive_torque_limit"]["limit"] /= applied.values["ratio"]
    return found


def ask(case: Case, folder: Path) -> dict[str, Any]:
    """The record of a case. A diagnosis that raises is a record, too: verdict "ERROR"."""
    car = FLEET[case.car]
    names = [case.name] if case.name else []
    line: dict[str, Any] = {"key": case.key, "seed": case.seed, "category": case.category, "car": case.car}
    line |= {"noise": case.noise, "names": names, "truth": case.truth}
    if case.category == "bare":
        (folder / f"{case.car}.toml").unlink(missing_ok=True)
        twin, answer = matched(case.car, folder)
        return line | kept(answer) | {"remainder": {c: dict(r) for c, r in twin.remainder.items()}}
    seed = case.drive_seed
    motion = driven(car, "rich", seed, case.truth)
    if case.name and not detectable(case, motion):
        return line | {"verdict": "UNDETECTABLE", "effects": []}
    twin, _ = matched(case.car, folder)
    line["total"] = total(effective(car, case.truth), twin)
    logs = {"rich.csv": logged(motion, seed, case.noise, case.truth)}
    return line | answered(logs, twin, {"town.csv": make_log(car, "town", seed + OTHER_RUN, case.noise, case.truth)})


def answered(logs: Mapping[str, Log], twin: VehicleModel, held_out: Mapping[str, Log]) -> dict[str, Any]:
    """What a record says of a diagnosis from a twin, with its CPU time [s]."""
    begin = time.process_time()
    try:
        answer = diagnose(logs, twin, held_out).as_dict()
    except Exception as error:  # what a user would see as a traceback is a result of the benchmark
        return {"verdict": "ERROR", "effects": [], "refused": f"{type(error).__name__}: {error}"}
    return kept({**answer, "cpu": round(time.process_time() - begin, 1)})


def kept(answer: dict[str, Any]) -> dict[str, Any]:
    """What the record of a case keeps of an answer."""
    return {key: answer[key] for key in ("verdict", "effects", "chi2_per_n", "cpu") if key in answer}
