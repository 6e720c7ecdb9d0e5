"""Scales of a model's inputs that data put elsewhere than the logs from which the twin was learnt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.diagnosis import Estimate
    from vehicle.model.vehicle_model import VehicleModel

MOVED = 0.1  # of a scale that a twin was learnt with: a larger change is said; chosen: five times brake_gain's least
_DOES = {"full_throttle": "accelerates", "full_brake": "brakes", "steer_scale": "steers"}


def moved_scales(fitted: Mapping[str, Estimate], model: VehicleModel) -> list[str]:
    """A line for each scale that these data put elsewhere than a twin that was learnt from logs, one with a known
    remainder. Such a change is the car's, or its column's, but no effect is named for it: the scale was fitted along.
    """
    lines = []
    for key, does in _DOES.items() if model.remainder else ():
        learnt = getattr(model.inputs, key)
        now = fitted.get(key)
        if now is None or now.low <= learnt <= now.high or abs(now.value - learnt) <= MOVED * abs(learnt):
            continue
        lines.append(
            f"{key} = {now.value:.3g} {now.unit}, and {learnt:.3g} in the model file: for the same command the car "
            f"{does} {now.value / learnt:.2f} times as much as its twin, which no effect above says"
        )
    return lines
