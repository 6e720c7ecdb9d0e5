"""What a simulator has and the car lacks: parameters of S set back to the data sheet where the logs do not mind."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.logs.log import Log

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

ALLOWED = 0.05  # of the error: an effect that the simulator has must pay as much as one that is added to it
KEPT = ("EGO_max_steer_angle",)  # an end stop that no drive reaches is what the stack steers within


@dataclasses.dataclass(frozen=True, slots=True)
class DataSheetReset:
    """The twin without what it did not need, chi^2/N of it and before, and what was set back, in words."""

    model: VehicleModel
    before: float
    after: float
    changes: tuple[str, ...]


def reset_to_data_sheet(
    model: VehicleModel, sheet: VehicleModel, logs: Mapping[str, Log], allowed: float = ALLOWED
) -> DataSheetReset:
    """Set parameters of S back to those of the data sheet, all together if the logs allow it, else one by one.

    sheet: the twin as its data sheet has it; allowed: share of the error that may come back with it.
    Raises CompareError or ModelError if the logs cannot be compared.
    """
    from vehicle.model.simulator_parameters import S_PARAMETERS, s_value

    names = [
        p.name for p in S_PARAMETERS if p.name not in KEPT and s_value(model, p.name) != s_value(sheet, p.name)
    ]  # fmt: skip
    before = chi2(model, logs)
    best, twin = before, model
    gone: list[str] = []
    for group in [names, *([name] for name in names)]:
        group = [name for name in group if name not in gone]
        if not group:
            continue
        candidate = _set_back(twin, sheet, group)
        left = chi2(candidate, logs)
        if left <= best + allowed * max(1.0, best):
            best, twin = left, candidate
            gone += group
    words = tuple(f"{name} {s_value(model, name):g} -> {s_value(sheet, name):g}" for name in gone)
    return DataSheetReset(twin, before, best, words)


def _set_back(model: VehicleModel, sheet: VehicleModel, names: Sequence[str]) -> VehicleModel:
    from vehicle.model.simulator_parameters import apply_s, s_value
    from vehicle.sensors import default_sensors

    values = {name: s_value(sheet, name) or 0.0 for name in names}
    model, _ = apply_s(model, default_sensors(car=model.car), values)
    if "EGO_mass" in names:
        model = model.with_car({"yaw_inertia": sheet.car.yaw_inertia, "mass": sheet.car.mass})
    of_sheet = {applied.name for applied in sheet.effects}
    for applied in model.effects:
        if applied.name not in of_sheet and applied.effect.is_off(applied.values):
            model = model.without_effect(applied.name)
    return model


def chi2(model: VehicleModel, logs: Mapping[str, Log]) -> float:
    """chi^2/N of a twin driven by the logs' commands."""
    from pytest_dvp.gap.diagnose.experiment import experiment_set
    from pytest_dvp.gap.diagnose.linear_algebra import square

    target = experiment_set(logs, model)
    return float(square(target.whitened({})) / max(target.count, 1))
