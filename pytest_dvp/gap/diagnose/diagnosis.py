"""What a diagnosis found, as data."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal, TypeAlias

from pytest_dvp.gap.diagnose.dependence import Dependence
from vehicle.model.effect_catalogue import run_setups
from vehicle.model.remainder import Remainder

Verdict: TypeAlias = Literal["NOTHING_MISSING", "NAMED", "AMBIGUOUS", "PARTIAL", "UNKNOWN", "NOT_EXCITED"]
Action: TypeAlias = Literal["add", "change", "remove"]
Standing: TypeAlias = Literal["confirmed", "provisional"]
SecondEngine: TypeAlias = Literal["agrees", "disagrees", "silent"]


SAME = 0.5  # of a zero that was fitted: by no more, that of another run may differ and be the car's; chosen


@dataclasses.dataclass(frozen=True, slots=True)
class Estimate:
    """A fitted value with its 95 % interval, in `unit`."""

    value: float
    low: float
    high: float
    unit: str


@dataclasses.dataclass(frozen=True, slots=True)
class NamedEffect:
    """An effect to add to the model, to change in it, or to remove from it.

    gain: share of the excess error (chi^2/N above 1) that it explains, 0..1; rivals: effects that would do as well on
    these data, best first; deciding_manoeuvre: path of the scenario that would tell them apart; held_out_gain: chi^2/N
    that it takes away on data it was not fitted on, None if those do not show it; standing: confirmed if nothing speaks
    against it, else provisional because of `doubts`; depends_on: what its value changes with while driving.
    """

    name: str
    parameters: Mapping[str, Estimate]
    rivals: tuple[str, ...] = ()
    gain: float = 0.0
    deciding_manoeuvre: str | None = None
    action: Action = "add"
    held_out_gain: float | None = None
    standing: Standing = "provisional"
    second_engine: SecondEngine = "silent"
    depends_on: Dependence | None = None
    doubts: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The entry of `diagnose --json`."""
        return {
            "name": self.name,
            "action": self.action,
            "parameters": {key: dataclasses.asdict(estimate) for key, estimate in self.parameters.items()},
            "rivals": list(self.rivals),
            "deciding_manoeuvre": self.deciding_manoeuvre,
            "gain": self.gain,
            "held_out_gain": self.held_out_gain,
            "standing": self.standing,
            "doubts": list(self.doubts),
            "second_engine": self.second_engine,
            "depends_on": self.depends_on.as_dict() if self.depends_on else None,
        }


def _differs(e: NamedEffect, run: Mapping[tuple[str, str], float]) -> bool:
    """True if a run has another value of its own than the one that was fitted."""
    mine = {key: value for (name, key), value in run.items() if name == e.name}
    fitted = {key: e.parameters[key].value for key in mine if key in e.parameters}
    return any(key not in fitted or abs(value - fitted[key]) > SAME * abs(fitted[key]) for key, value in mine.items())


@dataclasses.dataclass(frozen=True, slots=True)
class Step:
    """One step of the ladder: the effect that came in ("" for the model as given) and the error then left.

    chi2_per_n over all channels, channels: of each; rmse of each in its unit, on segments of about 5 s, of the data
    fitted on and of the data held out (empty without any). segments, held_out_segments (m,): sum of squares in units
    of the noise, by segment. values: everything fitted at this step. held_out_setups: where each held-out run has a
    set-up of its own, what its beginning says of it; the rest of the run is judged.
    """

    added: str
    chi2_per_n: float
    channels: Mapping[str, float]
    rmse: Mapping[str, float]
    held_out_chi2_per_n: float | None = None
    held_out_rmse: Mapping[str, float] = dataclasses.field(default_factory=dict)
    segments: tuple[float, ...] = ()
    held_out_segments: tuple[float, ...] = ()
    values: Mapping[tuple[str, str], float] = dataclasses.field(default_factory=dict)
    held_out_setups: tuple[Mapping[tuple[str, str], float], ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """JSON-able, without the sums by segment and the values."""
        hidden = ("segments", "held_out_segments", "values", "held_out_setups")
        return {key: value for key, value in dataclasses.asdict(self).items() if key not in hidden}


@dataclasses.dataclass(frozen=True, slots=True)
class Samples:
    """Samples that were fitted, of all channels: `count`, and how many independent ones would tell as much; fewer,
    where the noise of neighbouring samples is alike. slides, left_out: shares of the drives (0..1) in which the car
    slides or its wheels lock, which no effect does, and that are left out of the fit for it. slopes: spread [m/s^2] of
    the slope of the road that is no error of the model, 0 for a flat road."""

    count: int
    independent: float
    slides: float = 0.0
    left_out: float = 0.0
    slopes: float = 0.0


@dataclasses.dataclass(frozen=True, slots=True)
class HiddenSize:
    """An effect's parameter, and by how much at least (size, in its unit, either way) the car may differ in it from a
    twin whose known remainder hides it."""

    effect: str
    key: str
    size: float
    unit: str


@dataclasses.dataclass(frozen=True, slots=True)
class Diagnosis:
    """Result of `diagnose`.

    effects in the order of the ladder; ladder: the error after each; vetoed: effects that fitted, and that data they
    were not fitted on do not confirm; input_map: fitted scales of the model's inputs; votes: what the second engine
    would name; signature: what the misfit that is left looks like; car: parameters of the car that had to be assumed
    with the effects (where ay is measured); values: everything together, (effect, key) -> value; remainder: what the
    model file says that its twin is known not to explain, which counts as noise; samples: how many were fitted;
    chosen_by_held_out: the data held out took part in choosing the effects, so their figures are too good;
    may_hide: what the remainder hides of other effects, and is worth a name, the largest shares of their ranges first;
    scale_notes: a line for each scale of `input_map` that no vehicle has, or that the twin was not learnt with.
    """

    verdict: Verdict
    effects: tuple[NamedEffect, ...]
    not_excited: tuple[str, ...]
    ladder: tuple[Step, ...]
    noise_floor: Mapping[str, float]
    signature: Mapping[str, Any]
    vetoed: tuple[str, ...] = ()
    input_map: Mapping[str, Estimate] = dataclasses.field(default_factory=dict)
    votes: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    car: Mapping[str, float] = dataclasses.field(default_factory=dict)
    values: Mapping[tuple[str, str], float] = dataclasses.field(default_factory=dict)
    null_line: float | None = None
    remainder: Remainder = dataclasses.field(default_factory=dict)
    samples: Samples = Samples(0, 0.0)
    chosen_by_held_out: bool = False
    may_hide: tuple[HiddenSize, ...] = ()
    scale_notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects."""
        return tuple(e.name for e in self.effects)

    @property
    def set_up(self) -> tuple[str, ...]:
        """Effects that differ from run to run: these values are those of the runs fitted on, not the car's. One that a
        held-out run has as well, by at least half and at most one and a half times, is the car's."""
        zeros = [e for e in self.effects if e.name in run_setups()]
        return tuple(e.name for e in zeros if any(_differs(e, run) for run in self.ladder[-1].held_out_setups))

    def as_dict(self) -> dict[str, Any]:
        """The document of `diagnose --json`."""
        before, after = self.ladder[0], self.ladder[-1]
        setups = [{f"{name}.{key}": value for (name, key), value in run.items()} for run in after.held_out_setups]
        return {
            "verdict": self.verdict,
            "effects": [e.as_dict() for e in self.effects],
            "not_excited": list(self.not_excited),
            "error": {
                "fit": {"before": dict(before.rmse), "after": dict(after.rmse)},
                "held_out": {"before": dict(before.held_out_rmse), "after": dict(after.held_out_rmse)},
            },
            "chi2_per_n": {
                "fit": {"before": before.chi2_per_n, "after": after.chi2_per_n},
                "held_out": {"before": before.held_out_chi2_per_n, "after": after.held_out_chi2_per_n},
            },
            "noise_floor": dict(self.noise_floor),
            "signature": dict(self.signature),
            "vetoed": list(self.vetoed),
            "set_up": {"names": list(self.set_up), "held_out": setups},
            "input_map": {key: dataclasses.asdict(e) for key, e in self.input_map.items()},
            "scale_notes": list(self.scale_notes),
            "car": dict(self.car),
            "votes": dict(self.votes),
            "ladder": [step.as_dict() for step in self.ladder],
            "null_line": self.null_line,
            "remainder": {channel: dict(regimes) for channel, regimes in self.remainder.items()},
            "samples": dataclasses.asdict(self.samples),
            "chosen_by_held_out": self.chosen_by_held_out,
            "may_hide": [dataclasses.asdict(one) for one in self.may_hide],
        }
