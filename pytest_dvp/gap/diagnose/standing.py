"""How firm each named effect is: confirmed, or provisional with the reasons.

Confirmed is what a user may install without a second look. An effect has to pass every test here; what fails one is
still the best name for what was seen, and is said as no more than that.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping, Sequence
from math import inf, isfinite

from pytest_dvp.doctor.excitation import excitation
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.candidates import is_usual, says_how
from pytest_dvp.gap.diagnose.dependence import Dependence
from pytest_dvp.gap.diagnose.diagnosis import NamedEffect, Standing
from pytest_dvp.gap.diagnose.equation_error import Opinion
from pytest_dvp.gap.diagnose.held_out import ROUNDING
from pytest_dvp.gap.diagnose.ranges_by_size import usual_range
from pytest_dvp.gap.diagnose.search import CHANNEL_MISFIT, Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect import Effect

ACTS_ON = 0.1  # of all that an effect changes: a channel with less is not one that it acts on
DWARFS = 20.0  # times what is left over in the channels that it acts on: an effect that explains so much is not made up
# of that
ABOVE_REMAINDER = 0.2  # of chi^2/N that an effect must gain on data held out, where the twin has a known remainder:
# fragments of that gained up to 0.13 on cars in MuJoCo, true effects 0.27 and more
REMAINDER_ONLY = "on data held out it explains no more than the twin's known remainder may change by"
BESIDES = "data held out leave far more than the twin's known remainder, and it explains hardly any of that"
MUCH_LEFT = "much is left over in"  # how that doubt begins; the signals follow
TRACE = 0.1  # of what another effect gains on data held out: what gains less beside it, may be what that one does
# otherwise on this car than in the catalogue. Two that were not there gained 0.002 and 0.04 of it, on cars of strangers
SPREAD = 0.95  # of draws of segments that must gain by an effect which held-out data do not show


@dataclasses.dataclass(frozen=True, slots=True)
class Evidence:
    """What the search and its judges said of the named effects, by name: gains on held-out data (chi^2/N), opinions of
    the second engine, and how values change while driving; scales: what speaks against the fitted input scales;
    evident: effects that both data show beyond the known remainder (`beyond_remainder`); told: the set with the values
    that are told, where those are not of the search; besides: data held out show that something else is new."""

    held_out: Mapping[str, float]
    opinions: Mapping[str, Opinion]
    dependence: Mapping[str, Dependence]
    scales: Sequence[str] = ()
    evident: Collection[str] = ()
    told: Trial | None = None
    besides: bool = False


def with_standing(
    named: Sequence[NamedEffect],
    search: Search,
    final: Trial,
    logs: Sequence[Log],
    evidence: Evidence,
    known: Mapping[str, Effect],
) -> tuple[NamedEffect, ...]:
    """The effects with their standing, the second engine's opinion and its vote among their rivals. logs: all that were
    fitted on or judged, of which one at least has to be able to show an effect."""
    reached = [excitation(log, own=known) for log in logs]
    missed = {
        name: reached[0].out_of_reach[name]
        for name in (e.name for e in named)
        if reached and all(name in one.out_of_reach for one in reached)
    }
    told = evidence.told or final
    left = _Left(search.lasting() if search.target.excused else search, told)
    model = search.target.experiments[0].model
    present = {a.name: a.values for a in model.effects}
    found = []
    for e in named:
        if e.action == "remove" or e.name not in final.names:
            found.append(e)
            continue
        opinion = evidence.opinions.get(e.name, Opinion())
        rivals = e.rivals
        if opinion.instead and opinion.instead not in rivals:
            rivals = (*rivals, opinion.instead)
        changes = evidence.dependence.get(e.name)
        doubts = [
            *([f"these data cannot tell it from {', '.join(e.rivals)}"] if e.rivals else []),
            *_held_out(search, final, e.name, evidence.held_out, evidence.evident),
            *([f"these drives can hardly show it: {missed[e.name]}"] if e.name in missed else []),
            *([f"regression without simulation votes for {opinion.instead}"] if opinion.instead else []),
            *_implausible(e, known[e.name], present.get(e.name, {}), model.car.wheelbase),
            *_nothing_sure(e, known[e.name], present.get(e.name, {}), search.target.excused),
            *_at_ends(e, told),
            *_unseen(e, model.remainder_shape.unseen.get(e.name, {})),
            *(_trace(e.name, evidence.held_out) if search.target.excused else []),
            *left.doubts(e.name),
            *evidence.scales,
            *([BESIDES] if evidence.besides else []),
            *([f"its {changes.key} changes with {changes.quantity.replace('_', ' ')}"] if changes else []),
        ]
        standing: Standing = "provisional" if doubts else "confirmed"
        found.append(
            dataclasses.replace(
                e, rivals=rivals, standing=standing, second_engine=opinion.says, depends_on=changes,
                doubts=tuple(doubts),
            )
        )  # fmt: skip
    return tuple(found)


def _held_out(
    search: Search, final: Trial, name: str, gains: Mapping[str, float], evident: Collection[str]
) -> list[str]:
    """Whether data that an effect was not fitted on gain by it. Where these do not excite it, it must at least not hang
    on a single part of the drive."""
    level = max(1.0, final.chi2 / search.count)
    gain = gains.get(name)
    if gain is not None and search.target.excused and gain < ABOVE_REMAINDER and name not in evident:
        return [REMAINDER_ONLY]
    if gain is not None and abs(gain) > ROUNDING * level:
        return [] if gain > 0.0 else ["it loses on data held out"]
    spread = search.bootstrap_share(search.without(final, name).segment_chi2, final.segment_chi2)
    return [] if spread >= SPREAD else ["only one part of the drive shows it, and no data held out"]


def _trace(name: str, gains: Mapping[str, float]) -> list[str]:
    """Whether an effect may be made of another one, whose form in the catalogue is not quite that of the car."""
    others = {other: gain for other, gain in gains.items() if other != name}
    main = max(others, key=lambda n: others[n], default=name)
    most = others.get(main, 0.0)
    if most <= 0.0 or gains.get(name, inf) >= TRACE * most:
        return []
    return [f"beside {main}, which explains more than {1.0 / TRACE:.0f} times as much, it may be a trace of that"]


def _implausible(e: NamedEffect, effect: Effect, given: Mapping[str, float], wheelbase: float) -> list[str]:
    """Values farther from doing nothing than the range that is met on a vehicle of `wheelbase` [m]. given: values that
    the model has already; of these the change counts, for what a car has and what is new in it may add up to more. Of
    a share that the model has at nought, no change by a factor leads anywhere: there the value counts."""
    found = []
    for name, estimate in e.parameters.items():
        key = usual_range(effect.key(name), wheelbase)
        value = estimate.value
        if name in given and isfinite(key.neutral) and isfinite(given[name]):
            if not key.neutral:
                value -= given[name]
            elif given[name]:
                value *= key.neutral / given[name]
        if not says_how(key) and not is_usual(key, value):
            found.append(
                f"{name} = {estimate.value:.3g}{_from(value, estimate.value)} is outside what is usual, "
                f"{key.low:g} to {key.high:g} {key.unit}"
            )
    return [text.removesuffix(" -") for text in found]


def _from(change: float, value: float) -> str:
    return "" if change == value else f", {change:.3g} seen from what the model has,"


def _nothing_sure(e: NamedEffect, effect: Effect, given: Mapping[str, float], excused: bool) -> list[str]:
    """Whether the car may have no more of an effect than the model: no interval is clear of that. excused: the
    intervals hold what the known remainder of a twin imitates. However evident an effect is, what is told must agree
    with itself: a bias of 0.05 m/s^2, from -0.06 to 0.16, was confirmed on a strangers' bus that had none."""
    named = [name for name in e.parameters if not says_how(effect.key(name))] or list(
        e.parameters
    )  # a lag only says how
    for name in named:
        if not e.parameters[name].low <= given.get(name, effect.key(name).neutral) <= e.parameters[name].high:
            return []
    return ["the twin's known remainder imitates as much" if excused else "its interval holds what the model has"]


def _at_ends(e: NamedEffect, told: Trial) -> list[str]:
    """Values that stand where a search has to stop: no estimates, whatever their intervals are."""
    return [
        f"{c.key.name} = {told.values[c.name]:.3g} {c.key.unit}".removesuffix(" -")
        + " stands where the search ends: no estimate"
        for c in told.fit.coordinates
        if c.effect == e.name and c.is_at_limit(told.values[c.name])
    ]


def _unseen(e: NamedEffect, open_at: Mapping[str, float]) -> list[str]:
    """Whether the car may have a limit from the beginning. open_at: what the drives that the twin was learnt from leave
    open, from that value on."""
    values = {name: estimate.value for name, estimate in e.parameters.items()}
    return [
        f"the drives that the twin was learnt from do not come to {name} = {values[name]:.3g}: "
        "it may be older than this"
        for name in older(values, open_at)
    ]


def older(values: Mapping[str, float], open_at: Mapping[str, float]) -> list[str]:
    """The keys of an effect that the car may have had from the beginning with these values."""
    return [name for name, least in open_at.items() if name in values and values[name] >= least]


class _Left:
    """What is left over in each channel, and what each effect explains there; beside a known remainder as an error
    that lasts (`lasting_remainder`)."""

    def __init__(self, search: Search, final: Trial) -> None:
        self._search, self._final = search, final
        self._rest = self._of(final)
        counts = [e.residuals(final.values).count for e in search.target.experiments]
        self._count = {name: sum(int(count[k]) for count in counts) for k, name in enumerate(CHANNELS)}
        self._known = search.target.anew()

    def _of(self, trial: Trial) -> dict[str, float]:
        target = self._search.target
        return _by_channel(target.lasting().whitened(trial.values) if target.excused else trial.fit.residual)

    def doubts(self, name: str) -> list[str]:
        """Channels that the effect acts on in which much is left over beside what it explains."""
        less = self._of(self._search.without(self._final, name))
        gains = {c: max(less[c] - self._rest[c], 0.0) for c in less}
        total = sum(gains.values())
        found = []
        for channel, gain in gains.items():
            samples = self._count[channel] * self._known[channel]
            if not samples or gain < ACTS_ON * total:
                continue
            left = self._rest[channel] - samples
            if self._rest[channel] > CHANNEL_MISFIT * samples and gain < DWARFS * left:
                found.append(channel)
        return [f"{MUCH_LEFT} {', '.join(found)}, on which it acts"] if found else []


def _by_channel(whitened: FloatArray) -> dict[str, float]:
    squares = (whitened.reshape(-1, len(CHANNELS)) ** 2).sum(axis=0)
    return {name: float(squares[k]) for k, name in enumerate(CHANNELS)}
