"""Effects that are smaller than a twin's known remainder, and yet not of its kind.

A gyro that is off by 1.5 deg/s all the time changes chi^2 less than the remainder may, which comes and goes. In the
metric of `lasting_remainder` it is tens of standard deviations away from nothing. What stands there that far on data
fitted on and on data held out, and beyond what the remainder imitates, is told. So is, as provisional, what the data
held out do not show, if it is several times as large as the remainder imitates: it may act in moments only.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite, sqrt
from typing import NamedTuple

import numpy as np

from pytest_dvp.gap.diagnose.candidates import Candidate, says_how, sizes
from pytest_dvp.gap.diagnose.experiment import ExperimentSet
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.least_squares import IMITATED
from pytest_dvp.gap.diagnose.linear_algebra import orthonormal, row_products, square
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial

EVIDENT = 20.0  # standard deviations: on 20 drives of matched twins with nothing new, no effect that went beyond what
# the remainder imitates reached 17 on both of two drives; six small biases reached 24 and more
APART = 10.0  # the same, on data held out: of twelve drives with nothing new, of three cars of strangers, what reached
# 10 to 24 where it was fitted reached 3.6 there at most
AGREES = 0.5  # of what an effect changes on data, that they must gain by it: 1 if they ask for that size, 0 if
# for half of it. A dead band of 0.115 m/s^2 that a hybrid car does not have gained 12 standard deviations on a drive in
# town, where one of that size would have gained many times as much
ALIKE = 0.85  # the same, where each drive shows it by APART alone; chosen: of 30 drives with nothing new of 12 cars
# of strangers none had such an effect; a gyro that is off by 0.5 deg/s gained 12 standard deviations on both
STEP = 20.0  # m between places that are asked: a fit begun so far off came to the top of a hill of 16 m on a MuJoCo car
PLACES = 100  # at most: each costs six replays of the log, and a drive of 110 s on a test ground has 50 to 70
LOWER = 1.5  # times: a limit than the lowest found on drives with nothing new; chosen: a bus with 11.5 m/s^3 on those
# drives gave 13 and 15 on others
BELOW = 1.25  # times: a limit than the lowest that the drives of the twin leave open; chosen: two cars with 3.1 and 2.4
# m/s^2 on those drives gave 2.6, 3.0 and 2.2 on others
FAR = 5.0  # times as large as the remainder imitates; chosen: a steering that sticks was 32 and 120 times on two cars
NUDGE = 0.02  # of its range, by which a value is moved to see what it would change; chosen
PROMISE = 0.25  # of the gain that makes an effect evident: one that gains less to first order is not fitted; chosen
_TRIED = 6  # effects, the best to first order of those that the remainder does not imitate; chosen
_HILLS = 3  # places of one, the best to first order; chosen


def single(search: Search, final: Trial, judges: Sequence[Fold]) -> Trial | None:
    """One effect in the place of a set, if the error that lasts is no larger with it alone, on all data together: by no
    more than APART standard deviations for each effect less.

    A search that counts the remainder as noise of each sample may put two effects in the place of one: a drive that is
    too strong and a drag that grows with speed for the rolling resistance that was hidden.
    """
    base = search.trial((), {k: v for k, v in final.values.items() if k[0] not in final.names})
    other = quiet(search, base, judges, placed=search.misfit(final)) if final.names else None
    if other is None or other.names == final.names:
        return None
    more = APART**2 * (len(final.names) - 1)
    return other if _left(search, other, judges) <= _left(search, final, judges) + more else None


def _left(search: Search, trial: Trial, judges: Sequence[Fold]) -> float:
    values = as_told(search, trial).values
    return sum(square(data.lasting().whitened(values)) for data in (search.target, *_drives_apart(judges)))


def quiet(search: Search, base: Trial, judges: Sequence[Fold] = (), placed: bool = True) -> Trial | None:
    """The set with one effect that the remainder hides by its size only; None if there is none, or if the set names
    what no remainder imitates. placed: hills are looked for along the way, too, which takes as long as all else.

    The best on all data together. What data held out do not show has no say beside what they do, however much it gains
    where it is fitted: where a remainder comes and goes, something else always gains there.
    """
    if not all(is_imitated(search, base, name) for name in base.names):
        return None
    lasting = search.target.lasting()
    now = search.trial(base.names, base.values, target=lasting)
    look = FirstOrderGain(lasting, now)
    ranking = []
    for candidate in search.tried.values():
        options = look.remaining_chi2(candidate, candidate.coarse) if candidate.name not in base.names else []
        if options:
            ranking.append(min(((left, candidate.name, point) for left, point in options), key=lambda o: o[:2]))
    found = []
    asked = 0
    for left, name, point in sorted(ranking, key=lambda o: o[:2]):
        if asked == _TRIED or now.chi2 - left < PROMISE * EVIDENT**2:
            break
        trial = search.trial((*base.names, name), base.values | point, target=lasting)
        if not is_imitated(search, trial, name, _times(judges)):  # what is, may gain more than all that is new
            asked += 1
            found.append(trial)
    hills = [c for c in search.refiners.values() if placed and is_placed(c) and c.name not in base.names]
    for candidate in hills:  # what a hill gains at a place nearby says little of what it gains where it is
        options = look.remaining_chi2(candidate, along_the_way(search, candidate))
        for _, point in sorted(options, key=lambda o: o[0])[:_HILLS]:
            found.append(search.trial((*base.names, candidate.name), base.values | point, target=lasting))
    found = [trial for trial in found if search.is_credible(trial, trial.names[-1], lasting)]
    shown = [trial for trial in found if is_evident_apart(search, trial, trial.names[-1], judges)] or [
        trial
        for trial in found
        if not _is_limit(search.known[trial.names[-1]])
        and is_evident(search, trial, trial.names[-1], lasting, agrees=AGREES)
    ]
    if not shown:
        return None
    best = max(shown, key=lambda trial: _gain(search, trial, judges))
    simpler = [t for t in shown if t.names[-1] == search.contained(best.names[-1])]
    if simpler and _gain(search, simpler[0], judges) > _gain(search, best, judges) - APART**2:
        best = simpler[0]  # a steering ratio, and not one for each side
    return search.trial(best.names, best.values)


def as_told(search: Search, trial: Trial) -> Trial:
    """The trial with the values that are told: of a twin with a known remainder they are estimated once more, with the
    remainder as an error that lasts."""
    target = search.target
    return search.trial(trial.names, trial.values, zoom=True, target=target.lasting()) if target.excused else trial


def _gain(search: Search, trial: Trial, judges: Sequence[Fold]) -> float:
    """What the data fitted on and the drives held out gain by the last effect of a set (chi^2)."""
    every = (search.target, *_drives_apart(judges))
    return sum(_shown(search, trial, trial.names[-1], data).gain for data in every)


def _is_limit(candidate: Candidate) -> bool:
    """True for a limit. Where a twin's drive is wrong at high power, one drive alone asks for some limit: 38 W/kg on a
    car that had done more on the drives it was learnt from."""
    return any(not isfinite(c.key.neutral) for c in candidate.coordinates)


def is_placed(candidate: Candidate) -> bool:
    """True for what lies at a place of the map. A remainder of the car comes and goes wherever it drives."""
    return any(c.key.where for c in candidate.coordinates)


def along_the_way(search: Search, candidate: Candidate) -> list[dict[tuple[str, str], float]]:
    """Points of an effect that lies somewhere: at each place that the logs pass, STEP apart, with the other values that
    the candidate's own points have. A grid of the whole map with few points misses a hill of 25 m. On a way with more
    than PLACES the steps are longer, and a small hill may be missed."""
    logs = [each.log.columns for each in search.target.experiments]
    way = np.hstack([np.array([log["x"], log["y"]]) for log in logs]).T
    way, step = way[np.isfinite(way).all(axis=1)], STEP
    while len(places := np.unique(np.round(way / step) + 0.0, axis=0)) > PLACES:
        step *= 1.5
    here, there = ((candidate.name, key) for key in ("x", "y"))
    others = {tuple(sorted((k, v) for k, v in point.items() if k not in (here, there))) for point in candidate.points}
    return [{**dict(other), here: x * step, there: y * step} for x, y in places.tolist() for other in sorted(others)]


def is_evident(
    search: Search,
    trial: Trial,
    name: str,
    data: ExperimentSet,
    least: float = EVIDENT,
    agrees: float = 0.0,
    times: float = IMITATED,
) -> bool:
    """True if the data stand far from the model without the effect, and its value from what the remainder imitates.

    least: by how many standard deviations; agrees: share of what the effect changes that the data must gain by it;
    times: see `is_imitated`.

    The other effects of the set may make up for it, to first order: drag and rolling resistance say much the same, and
    with one of them taken away alone the other one is wrong as well.
    """
    if is_imitated(search, trial, name, times):
        return False
    shown = _shown(search, trial, name, data)
    return min(shown.alone, shown.gain) > least**2 and shown.gain >= agrees * shown.changed


class _Shown(NamedTuple):
    """What data show of an effect, in chi^2: what it takes off them while the others of its set stay as they are
    (alone), and while these make up for it as far as they can (gain); and all that it changes there (changed)."""

    alone: float
    gain: float
    changed: float


def _shown(search: Search, trial: Trial, name: str, data: ExperimentSet) -> _Shown:
    values = trial.values
    off = {**values, **_without(search, name)}
    lasting = data.lasting()
    without, rest = lasting.whitened(off), lasting.whitened(values)
    alone = square(without) - square(rest)
    others = [search.known[n] for n in trial.names if n != name and n in search.known]
    moves = []
    for c in (c for other in others for c in other.coordinates):
        u = c.to_unit(values[c.name])
        moved = c.value(u + (NUDGE if u < 0.5 else -NUDGE))
        if isfinite(moved) and moved != values[c.name]:
            moves.append(lasting.whitened({**off, c.name: moved}) - without)
    if moves:
        basis = orthonormal(np.array(moves))
        without, rest = (r - row_products(basis, r) @ basis for r in (without, rest))
    return _Shown(alone, square(without) - square(rest), square(without - rest))


def is_far_beyond(search: Search, trial: Trial, name: str) -> bool:
    """True if the data fitted on show an effect FAR times as large as the twin's known remainder imitates it. What acts
    after a standstill alone, another drive may not show."""
    known = search.target.experiments[0].model.remainder_shape.imitates.get(name, {})
    return (
        any(known.values())
        and not is_imitated(search, trial, name, FAR * IMITATED)
        and is_evident(search, trial, name, search.target)
    )


def is_imitated(search: Search, trial: Trial, name: str, times: float = IMITATED) -> bool:
    """True if an effect's size is within `times` of what the twin's known remainder imitates (root mean square on
    drives with nothing new); of what has no limit in the twin, if it is not LOWER than the remainder looks like, or
    not below what those drives would have shown."""
    shape = search.target.experiments[0].model.remainder_shape
    imitates, limits, open_at = (table.get(name, {}) for table in (shape.imitates, shape.limits, shape.unseen))
    off = _without(search, name)
    return not any(
        abs(trial.values[c.name] - off[c.name]) > times * imitates.get(c.key.name, 0.0)
        if isfinite(off[c.name])
        else trial.values[c.name] * LOWER * times / IMITATED < limits.get(c.key.name, inf)
        and trial.values[c.name] * BELOW < open_at.get(c.key.name, inf)
        for c in sizes(search.known[name].coordinates)
    )


def _without(search: Search, name: str) -> dict[tuple[str, str], float]:
    """Values of an effect that the model has, or with which it does nothing."""
    model = search.target.experiments[0].model
    had = next((a.values for a in model.effects if a.name == name), {})
    return {c.name: had.get(c.key.name, c.key.neutral) for c in search.known[name].coordinates}


def is_evident_apart(search: Search, trial: Trial, name: str, judges: Sequence[Fold]) -> bool:
    """True if the data fitted on and all data held out show the effect so, or each shows it less clearly and asks for
    the same size; False without such data."""
    apart = _drives_apart(judges)
    if not apart:
        return False

    def shows(data: ExperimentSet, least: float, agrees: float) -> bool:
        return is_evident(search, trial, name, data, least, agrees, _times(judges))

    if shows(search.target, EVIDENT, AGREES):
        return all(shows(data, APART, AGREES) for data in apart)
    return all(shows(data, APART, ALIKE) for data in (search.target, *apart))


def _times(judges: Sequence[Fold]) -> float:
    """How far beyond what the remainder imitates a value has to be that all drives ask for: the mean of n such drives
    strays by 1/sqrt(n) of what one of them does."""
    return IMITATED / sqrt(1.0 + len(_drives_apart(judges)))


def is_beyond_remainder(search: Search, trial: Trial, name: str, judges: Sequence[Fold]) -> bool:
    """True if an effect is more than what a twin is known not to explain: all data show it, or those fitted on so
    clearly that others need not. A drive in town says nothing of the power that a motor has at most; of a dead band of
    its pedal it does."""
    if is_evident_apart(search, trial, name, judges):
        return True
    return is_far_beyond(search, trial, name) and not _is_contradicted(search, trial, name, judges)


def may_be_new(search: Search, trial: Trial, judges: Sequence[Fold]) -> bool:
    """True if each drive, fitted on or held out, shows the last effect of a set as more than a known remainder. What a
    remainder alone could be, or one drive refutes or cannot show, is no rival of what all of them show.
    """
    every = (search.target, *_drives_apart(judges))
    times = _times(judges)
    return all(is_evident(search, trial, trial.names[-1], data, APART, AGREES, times) for data in every)


def _is_contradicted(search: Search, trial: Trial, name: str, judges: Sequence[Fold]) -> bool:
    """True if data held out would show an effect of that size, and do not ask for it."""
    every = [_shown(search, trial, name, data) for data in _drives_apart(judges)]
    return any(shown.changed > APART**2 and shown.gain < AGREES * shown.changed for shown in every)


def _drives_apart(judges: Sequence[Fold]) -> list[ExperimentSet]:
    """The drives held out as a whole: neither parts of the fitted ones, nor with a set-up of their own."""
    return [fold.judge for fold in judges if fold.fitted is None and fold.setup is None]


def changing_instead(search: Search, final: Trial) -> dict[str, tuple[str, ...]]:
    """Effects that change while driving and that a constant one which they refine does not clearly beat, by its name.

    An assist that grows with speed looks like a smaller steering ratio, and a known remainder may make up for the
    difference. So the constant has to stand EVIDENT before the other one with its shape in the middle of its range: at
    an end of it, it may be as good as constant.
    """
    lasting = search.target.lasting()
    now = search.trial(final.names, final.values, target=lasting)
    found: dict[str, tuple[str, ...]] = {}
    for name in final.names:
        rest = tuple(n for n in final.names if n != name)
        for refiner in search.refiners.values():
            if refiner.name in rest or not {name, search.contained(name)} & set(refiner.effect.diagnosed.refines):
                continue
            look = FirstOrderGain(lasting, search.trial(rest, final.values, target=lasting))
            shapes = [c for c in refiner.coordinates if says_how(c.key)]
            points = [p for p in refiner.points if all(0.2 < c.to_unit(p[c.name]) < 0.8 for c in shapes)]
            left = min((left for left, _ in look.remaining_chi2(refiner, points)), default=inf)
            if left < now.chi2 + EVIDENT**2:
                found[name] = (*found.get(name, ()), refiner.name)
    return found
