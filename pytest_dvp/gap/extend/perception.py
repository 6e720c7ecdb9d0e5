"""Perception effects added to a model or taken out of it: their values come from detections, nothing is simulated."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.fitted_values import rounded
from pytest_dvp.gap.extend.acceptance import Acceptance
from pytest_dvp.gap.perception.diagnose_perception import diagnose_perceptions, perceived_in, simulated_sensors
from pytest_dvp.gap.perception.on_top import on_top
from pytest_dvp.gap.perception.perceived_values import Perceived
from pytest_dvp.logs.log import Log

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel


def judge_perception(
    model: VehicleModel, logs: Mapping[str, Log], held_out: Mapping[str, Log], add: Sequence[Effect],
    remove: Sequence[str], twins: Mapping[str, Log] | None = None,
) -> list[Acceptance]:  # fmt: skip
    """Values of perception effects as the detections of the logs show them, and what detections held out say.

    twins: runs of the model by scenario, beside which the detections of the logs are judged.
    """
    if not add and not remove:
        return []
    shown = {effect.name: effect for effect in diagnose_perceptions(logs.values(), model, twins)}
    return [_added(effect, shown.get(effect.name), model, held_out, twins or {}) for effect in add] + [
        _removed(name, shown.get(name), model) for name in remove
    ]


def _added(
    effect: Effect, found: NamedEffect | None, model: VehicleModel, held_out: Mapping[str, Log],
    twins: Mapping[str, Log],
) -> Acceptance:  # fmt: skip
    if found is None or found.action == "remove":
        return Acceptance(NamedEffect(effect.name, {}), wrong=(
            f"{effect.name}: the detections of these logs do not show it; leave it out, or drive what would show it: "
            f"{effect.reveals}"
        ))  # fmt: skip
    values = {key: _written(e) for key, e in found.parameters.items()}
    taken = dataclasses.replace(found, parameters=values)
    judges = [seen for log in held_out.values() if (seen := _seen_in(log, model, twins)) is not None]
    for seen in judges:
        for key, estimate in values.items():
            told = seen.values.get((effect.name, key))
            given = model.value(effect.name, key)
            base = effect.key(key).neutral if given is None else given
            if told is not None and abs(told[0] - estimate.value) > abs(told[0] - base):
                return Acceptance(taken, wrong=(
                    f"{effect.name} loses on held-out data: {key} is {told[0]:.3g} {estimate.unit} there, "
                    f"{estimate.value:.3g} where it was fitted: leave it out, or fit it on more logs"
                ))  # fmt: skip
    note = "" if judges else f"{effect.name} is not judged on held-out data: name a log with detections by --held-out"
    return Acceptance(taken, note=note)


def _seen_in(log: Log, model: VehicleModel, twins: Mapping[str, Log]) -> Perceived | None:
    """What a log held out shows, on top of the twin's run in its scenario; None of a run that has none beside it."""
    twin = twins.get(log.meta.get("scenario", ""))
    if twin is None:
        return None if simulated_sensors(log) else perceived_in(log)
    seen, own = perceived_in(log), perceived_in(twin)
    return None if seen is None or own is None else on_top(seen, own, model)


def _written(e: Estimate) -> Estimate:
    value = rounded(e.value)
    return Estimate(value, min(rounded(e.low), value), max(rounded(e.high), value), e.unit)


def _removed(name: str, found: NamedEffect | None, model: VehicleModel) -> Acceptance:
    effect = next(a.effect for a in model.effects if a.name == name)
    off = {k.name: Estimate(k.neutral, k.neutral, k.neutral, k.unit) for k in effect.parameters}
    gone = NamedEffect(name, off, action="remove")
    if found is None:
        return Acceptance(gone, wrong=f"{name}: the detections of these logs do not say that the car lacks it: keep it")
    if found.action != "remove":
        values = ", ".join(f"{key} = {e.value:.3g} {e.unit}" for key, e in found.parameters.items())
        return Acceptance(gone, wrong=f"{name}: the detections of these logs show it ({values}): keep it")
    return Acceptance(gone)
