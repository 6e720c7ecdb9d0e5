"""The guard: a tuned parameter that is no longer a parameter of this car, and the effect that it stands in for."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.tuning.plausible_ranges import S_RANGES, shows_in, stands_for
from pytest_dvp.tuning.tuned_parameter import Knob, Point

EXPLAINS_BETTER = 0.05  # of the error that is left: an effect that leaves this much less than the tuned value did
FEW = 6  # effects tried for one parameter


@dataclasses.dataclass(frozen=True, slots=True)
class ImplausibleValue:
    """A value that should not be believed.

    why      "outside" the plausible range, or "stands for" an effect
    effect   what explains the logs better, with its value in words; empty if nothing that was tried does
    tuned, explained   chi^2/N with the tuned value, and with the effect in its place and the value as before, of the
                       channels in which the parameter shows
    """

    name: str
    value: float
    before: float
    unit: str
    why: str
    plausible: tuple[float, float] | None
    reason: str
    effect: str
    tuned: float
    explained: float | None
    channels: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The fields as JSON holds them."""
        return dataclasses.asdict(self)

    @property
    def sentence(self) -> str:
        """`S.EGO_mass = 8500 kg is outside 650 to 1100 kg (...): drive_lag tau = 0.35 s leaves chi^2/N 3.1, it 210`."""
        text = f"{self.name} = {self.value:g} {self.unit}".rstrip()
        if self.plausible is not None and self.why == "outside":
            text += (
                f" is outside {self.plausible[0]:g} to {self.plausible[1]:g} {self.unit}".rstrip() + f" ({self.reason})"
            )
        else:
            text += f" (before {self.before:g}) stands in for an effect"
        if self.effect and self.explained is not None:
            of = f" of {', '.join(self.channels)}" if self.channels else ""
            return f"{text}: {self.effect} leaves chi^2/N {self.explained:.3g}{of}, the tuned value {self.tuned:.3g}"
        return f"{text}; none of the effects tried explains it better"


def find_implausible_values(
    knobs: Sequence[Knob], before: Point, after: Point, logs: Sequence[Path], model: Path,
    tick: Callable[[str], None] = lambda text: None,
) -> list[ImplausibleValue]:  # fmt: skip
    """Look at every parameter of S that tuning moved: is its value plausible, and does an effect do better?

    model: the twin before the tuning. Each effect that the parameter may stand for is fitted in its place.
    """
    moved = [k for k in knobs if k.name.startswith("S.") and before[k.name] != after[k.name]]
    outside = [
        k for k in knobs
        if k.plausible is not None and not k.plausible[0] <= after[k.name] <= k.plausible[1] and k not in moved
    ]  # fmt: skip
    found = []
    for knob in [*moved, *outside]:
        tick(f"guard: {knob.name}")
        suspicion = _suspected(knob, before, after, logs, model)
        if suspicion is not None:
            found.append(suspicion)
    return found


def _suspected(knob: Knob, before: Point, after: Point, logs: Sequence[Path], model: Path) -> ImplausibleValue | None:
    from pytest_dvp.gap.compare.compared_model import CompareError
    from pytest_dvp.gap.extend.extend import extend
    from pytest_dvp.tuning.structure_search import in_words, thinned
    from vehicle.model.effect_catalogue import find_effect
    from vehicle.model.errors import ModelError
    from vehicle.model.model_file import read_model

    known = S_RANGES.get(knob.name[2:])
    inside = knob.plausible is None or knob.plausible[0] <= after[knob.name] <= knob.plausible[1]
    twin = read_model(model)
    loaded = {path.name: thinned(path) for path in logs}
    channels = shows_in(knob.name)
    tuned = _chi2(_with_s(twin, after), loaded, channels)
    rest = {name: value for name, value in after.items() if name != knob.name}
    held = before[knob.name]
    if knob.plausible is not None:
        held = min(max(held, knob.plausible[0]), knob.plausible[1])
    base = _with_s(twin, {**rest, knob.name: held})
    best: tuple[float, str] | None = None
    for name in stands_for(knob.name)[:FEW]:
        try:
            extension = extend(loaded, base, add=[name])
        except (ModelError, CompareError):
            continue  # it does not suit this model or these logs
        left = _chi2(extension.model, loaded, channels)
        if not extension.refusal and (best is None or left < best[0]):
            effect = find_effect(name)
            values = next(e.parameters for e in extension.effects if e.name == name)
            told = {k: e for k, e in values.items() if abs(e.value - effect.key(k).neutral) >= effect.key(k).least}
            best = (left, f"{effect.name} {in_words(told or values, 3)}")
    better = best is not None and best[0] < tuned * (1.0 - EXPLAINS_BETTER)
    if inside and not better:
        return None
    why = "stands for" if inside else "outside"
    return ImplausibleValue(
        knob.name, after[knob.name], before[knob.name], knob.unit, why, knob.plausible,
        known.why if known else "stated in the study", best[1] if best and better else "", tuned,
        best[0] if best and better else None, channels,
    )  # fmt: skip


def _with_s(model: Any, values: Point) -> Any:
    from vehicle.model.simulator_parameters import apply_s
    from vehicle.sensors import default_sensors

    S = {name[2:]: value for name, value in values.items() if name.startswith("S.")}
    return apply_s(model, default_sensors(car=model.car), S)[0]


def _chi2(model: Any, logs: Any, channels: Sequence[str]) -> float:
    """chi^2/N of a twin driven by the logs' commands, mean over those of `channels` that are judged."""
    from pytest_dvp.gap.diagnose.experiment import experiment_set

    unexcused = dataclasses.replace(model, remainder={})  # or what a twin leaves would count as its noise
    found = experiment_set(logs, unexcused).by_channel({})
    values = [value for name, value in found.items() if name in channels]
    return sum(values) / len(values) if values else 0.0
