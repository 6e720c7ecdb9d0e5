"""What `extend` made of a model, as data."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect, Step

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel


@dataclasses.dataclass(frozen=True, slots=True)
class Rung:
    """A step of the ladder and what was done to reach it: "", "+ steer_delay", "- brake_lag", "~ refitted"."""

    change: str
    step: Step


@dataclasses.dataclass(frozen=True, slots=True)
class Extension:
    """Result of `extend`.

    model      with the effects added and removed, their values, intervals and provenance
    effects    what was done, in order, with what each takes away on the data fitted on and on the data held out
    refitted   values of what was in the model already and was fitted again: (effect, key) -> value with interval
    ladder     from the model as given to the new one
    refusal    why the model must not be taken, in one line; empty if it may
    refused    the effects that this is due to; empty if it is due to the model as a whole, or if it may be taken
    notes      what is to be known beside it, a line each
    explained  True if what is left, on the data held out too, is no more than the noise of the sensors: nothing is to
               be added any more
    excused    True if the model as given has a known remainder, which then counts as noise
    """

    model: VehicleModel
    effects: tuple[NamedEffect, ...]
    refitted: Mapping[tuple[str, str], Estimate]
    ladder: tuple[Rung, ...]
    noise_floor: Mapping[str, float]
    refusal: str
    notes: tuple[str, ...]
    explained: bool
    excused: bool = False
    refused: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """JSON-able; `extend --json` adds the file and the gates."""
        before, after = self.ladder[0].step, self.ladder[-1].step
        return {
            "effects": [effect.as_dict() for effect in self.effects],
            "refitted": {".".join(name): dataclasses.asdict(value) for name, value in self.refitted.items()},
            "error": {
                "fit": {"before": dict(before.rmse), "after": dict(after.rmse)},
                "held_out": {"before": dict(before.held_out_rmse), "after": dict(after.held_out_rmse)},
            },
            "chi2_per_n": {
                "fit": {"before": before.chi2_per_n, "after": after.chi2_per_n},
                "held_out": {"before": before.held_out_chi2_per_n, "after": after.held_out_chi2_per_n},
            },
            "ladder": [{"change": rung.change, **rung.step.as_dict()} for rung in self.ladder],
            "noise_floor": dict(self.noise_floor),
            "explained": self.explained,
            "refusal": self.refusal,
            "notes": list(self.notes),
        }
