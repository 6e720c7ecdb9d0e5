"""What is advised, and what the choice is made from."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.candidates import Candidate, candidates
from pytest_dvp.gap.diagnose.experiment import Values
from pytest_dvp.gap.diagnose.search import PRACTICAL
from pytest_dvp.gap.manoeuvres.catalogue import Manoeuvre
from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
from pytest_dvp.gap.manoeuvres.rehearsal import Hypothesis, Rehearsal
from pytest_dvp.gap.manoeuvres.simulated_drive import LONGEST, SIZES, Drive, perform

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

ENOUGH = 3.0 * PRACTICAL  # gap in chi^2/N to be had: three times what a diagnosis needs
MOST_REPEATS = 5  # of a manoeuvre in one plan; chosen for the patience of a driver
TIE = 0.9  # of the largest gap: as good, so that the shorter drive is taken


class PlanError(ValueError):
    """No manoeuvre can be advised; one line that says why."""


@dataclasses.dataclass(frozen=True, slots=True)
class LargestDifference:
    """By what two are told apart: at `time` [s] `channel` of the other differs by `difference` in its unit.

    gap: chi^2/N of the drive's log by which they differ; `truth` is empty where the other is to be seen at all.
    size: the other in words, `g = 0.9`.
    """

    truth: str
    other: str
    gap: float
    channel: str
    time: float
    difference: float
    size: str = ""


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Choice:
    """The manoeuvre that is advised.

    gap: chi^2/N of its log by which the least distinct pair differs after a refit (deciding), or by which the least
    visible effect changes it (exciting); `effects` it is about, none where the user named the manoeuvre; `signs` by
    what they show, the least first; `ranking`: what each manoeuvre would bring, to first order; repeats: how often it
    is to be driven; weak: it is the best there is in this envelope, and yet too little; not_shown: effects that nothing
    of the catalogue shows.
    """

    effects: tuple[str, ...]
    exciting: bool
    drive: Drive
    gap: float
    signs: tuple[LargestDifference, ...]
    ranking: Mapping[str, float]
    repeats: int
    weak: bool
    not_shown: tuple[str, ...] = ()

    @property
    def manoeuvre(self) -> Manoeuvre:
        """What is driven."""
        return self.drive.manoeuvre


@dataclasses.dataclass(frozen=True, slots=True)
class RehearsalInputs:
    """What every rehearsal shares: the model, the noise by channel, the limits, what is known beside, own effects."""

    model: VehicleModel
    noise: Mapping[str, float]
    envelope: Envelope
    shared: Mapping[tuple[str, str], float]
    effects: tuple[Effect, ...]

    def rehearse(self, drive: Drive, truth: Values) -> Rehearsal:
        """The log of a drive with an effect as the truth."""
        return Rehearsal(drive, self.model, truth, self.noise, shared=self.shared, extra=self.effects)

    def perform(self, manoeuvre: Manoeuvre, values: Values, sizes: tuple[float, ...] = SIZES) -> Drive | None:
        """The largest of `sizes` that keeps within the limits if these values are the truth, None if none does."""
        return perform(manoeuvre, self.model, {**self.shared, **values}, self.envelope, sizes, self.effects)

    def together(self, drive: Drive, truths: Sequence[Values]) -> list[Drive]:
        """The drive, which has the first of `truths`, as each of them would have it, all of one size that keeps every
        one within the limits; empty if none does."""
        for size in (s for s in SIZES if s <= drive.size):
            found = [drive] if size == drive.size else []
            for values in truths[len(found) :]:
                one = self.perform(drive.manoeuvre, values, (size,))
                if one is None:
                    break
                found.append(one)
            if len(found) == len(truths):
                return found
        return []


def as_named(manoeuvres: Sequence[Manoeuvre], model: VehicleModel, envelope: Envelope) -> tuple[Choice, ...]:
    """Manoeuvres that the user asked for by name, each as large as keeps within the envelope.

    Raises PlanError: one does not keep within it or does not come to its end, however small.
    """
    found = []
    for manoeuvre in manoeuvres:
        drive = perform(manoeuvre, model, {}, envelope)
        if drive is None:
            raise PlanError(
                f"{manoeuvre.name} does not keep within these limits, or lasts longer than {LONGEST:g} s; widen them"
            )
        found.append(Choice((), True, drive, 0.0, (), {}, 1, weak=False))
    return tuple(found)


def sign_of(rehearsal: Rehearsal, truth: str, other: Hypothesis, gap: float) -> LargestDifference:
    """Where an effect shows itself most against the truth of a rehearsal."""
    shares = rehearsal.channels(other.values)
    channel = max(shares, key=lambda name: shares[name])
    time, difference = rehearsal.largest(other.values, channel)
    size = ", ".join(f"{key} = {value:.3g}" for (_, key), value in other.values.items() if math.isfinite(value))
    return LargestDifference(truth, other.name, gap, channel, time, difference, size)


def candidates_by_name(
    model: VehicleModel, names: Sequence[str], effects: Sequence[Effect] = ()
) -> dict[str, Candidate]:
    """The effects of these names as a fit begins with them.

    Raises PlanError: no effect of that name, or none that acts on this model's motion.
    """
    from vehicle.model.effect_catalogue import catalogue
    from vehicle.model.errors import nearest_name

    every = {**catalogue(), **{e.name: e for e in effects}}
    found = {c.name: c for c in candidates(model, every.values(), refined=True)}
    for name in names:
        if name not in every:
            near = nearest_name(name, every)
            hint = f", did you mean {near!r}?" if near else " (dvp effects lists them)"
            raise PlanError(f"no effect called {name!r}{hint}")
        if name not in found:
            raise PlanError(f"{name} cannot be planned for: it does not act on this model, or not on its motion")
    return found
