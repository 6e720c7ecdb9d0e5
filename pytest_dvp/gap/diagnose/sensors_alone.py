"""Effects of the sensors alone, asked where a twin's remainder has no part: beside dead reckoning.

A speed that is shown 2 % too large is small beside what a twin leaves of speeds and positions, and yet the car's own
positions contradict it: no force makes an error of one without the other. So for a twin with a known remainder each
effect of a sensor is asked there (`dead_reckoning`), on all drives, in the same size. It is told if nothing is named,
and takes the place of a single name, or is its rival, if it explains more there, or as much.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pytest_dvp.gap.diagnose.beyond_remainder import AGREES, all_data, is_imitated, times_beyond
from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.experiment import ExperimentSet
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.held_out import Fold, drives_apart
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.tied_effects import ALIKE, MORE, Tied
from pytest_dvp.gap.diagnose.trial import Trial

FITTED = 10.0  # standard deviations by which the data fitted on show it; chosen: on 12 drives with nothing new of two
# cars of strangers no sensor's effect that was not imitated reached 3 on both, a speed that is shown 1.9 % too large 17
# and 10 where the twin itself leaves 1 % of the speed
OTHERS = 7.0  # and each of the others; chosen with it


def sensor_effects(candidates: Iterable[Candidate]) -> list[Candidate]:
    """Those that change what is shown, and not how the car moves."""
    return [c for c in candidates if c.effect.slot == "sensor"]


def with_sensors_asked(search: Search, final: Trial, judges: Sequence[Fold]) -> Tied:
    """The set, or the effect of a sensor in the place of nothing or of a single name, and its rivals among those.

    The set as it is if it has several effects, if the model file does not say how dead reckoning wanders, or if no
    other drive is there.
    """
    data = [each.reckoned() for each in all_data(search, judges)]
    knows = all(e.model.remainder_shape.wanders for each in data for e in each.experiments)
    if len(final.names) > 1 or not knows or not drives_apart(judges):
        return Tied(final, ())
    bare = {key: value for key, value in final.values.items() if key[0] not in final.names}
    shown = {c.name: fit for c in sensor_effects(search.known.values()) if c.name not in final.names
             and (fit := _shown(search, c, bare, data, judges))}  # fmt: skip
    if not shown:
        return Tied(final, ())
    together = ExperimentSet(tuple(e for each in data for e in each.experiments), lasts=True, reckons=True)
    base = search.trial((), bare, target=together)
    gains = {name: base.chi2 - search.trial((name,), fit.values, target=together).chi2 for name, fit in shown.items()}
    best = max(gains, key=lambda name: gains[name])
    named = 0.0
    for name in final.names:
        named = base.chi2 - search.trial((name,), final.values, target=together).chi2
    if gains[best] > MORE * named:
        for c in search.known.values():
            if c.is_tied(search.known[best]) and c.name not in gains:
                gains[c.name] = base.chi2 - _fitted(search, c, bare, together).chi2
        others = sorted((n for n in gains if n != best and gains[n] >= ALIKE * gains[best]), key=lambda n: -gains[n])
        return Tied(search.trial((best,), shown[best].values), tuple(others))
    return Tied(final, tuple(n for n in gains if gains[n] >= ALIKE * named))


def _fitted(search: Search, candidate: Candidate, bare: dict[tuple[str, str], float], data: ExperimentSet) -> Trial:
    """The effect fitted to data from where it promises most; the set without it if it changes nothing."""
    now = search.trial((), bare, target=data)
    options = FirstOrderGain(data, now).promising([candidate])
    return search.trial((candidate.name,), now.values | options[0][2], target=data) if options else now


def _shown(
    search: Search, candidate: Candidate, bare: dict[tuple[str, str], float], data: Sequence[ExperimentSet],
    judges: Sequence[Fold],
) -> Trial | None:  # fmt: skip
    """The effect fitted to the first data beside dead reckoning, if they show it by FITTED standard deviations, each
    of the others by OTHERS and in that size, and it is larger than what the twin's drives imitate; None if not."""
    now, fit = search.trial((), bare, target=data[0]), _fitted(search, candidate, bare, data[0])
    if not (now.chi2 - fit.chi2 > FITTED**2 and search.is_credible(fit, candidate.name, data[0])):
        return None
    for each in data[1:]:
        without, with_it = each.whitened(bare), each.whitened(fit.values)
        gain = square(without) - square(with_it)
        if not (gain > OTHERS**2 and gain >= AGREES * square(without - with_it)):
            return None
    imitated = data[0].experiments[0].model.remainder_shape.sensors
    return None if is_imitated(search, fit, candidate.name, times_beyond(judges), of=imitated) else fit
