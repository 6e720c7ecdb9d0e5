"""Effects that are smaller than a twin's known remainder, and yet not of its kind.

A gyro that is off by 1.5 deg/s all the time changes chi^2 less than the remainder may, which comes and goes. In the
metric of `lasting_remainder` it is tens of standard deviations away from nothing. What stands so far from it on all
data, and beyond what the remainder imitates, is told (`beyond_remainder`). So is, as provisional, what the data held
out do not show, if it is several times as large as the remainder imitates: it may act in moments only.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np

from pytest_dvp.gap.diagnose.beyond_remainder import (
    AGREES,
    APART,
    EVIDENT,
    all_data,
    as_told,
    is_evident,
    is_evident_apart,
    is_imitated,
    shown_by,
    times_beyond,
)
from pytest_dvp.gap.diagnose.candidates import Candidate
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial

STEP = 20.0  # m between places that are asked: a fit begun so far off came to the top of a hill of 16 m on a MuJoCo car
PLACES = 100  # at most: each costs six replays of the log, and a drive of 110 s on a test ground has 50 to 70
PROMISE = 0.25  # of the gain that makes an effect evident: one that gains less to first order is not fitted; chosen
_TRIED = 6  # effects, the best to first order of those that the remainder does not imitate; chosen
_PLACES = 3  # of a hill, the best to first order; chosen


def single(search: Search, final: Trial, judges: Sequence[Fold]) -> Trial | None:
    """One effect in the place of a set, if the error that lasts is no larger with it alone, on all data together: by no
    more than APART standard deviations for each effect less.

    A search that counts the remainder as noise of each sample may put two effects in the place of one: a drive that is
    too strong and a drag that grows with speed for the rolling resistance that was hidden.
    """
    base = search.trial((), final.values)
    other = quiet(search, base, judges, placed=search.misfit(final)) if final.names else None
    if other is None or other.names == final.names:
        return None
    more = APART**2 * (len(final.names) - 1)
    return other if _left(search, other, judges) <= _left(search, final, judges) + more else None


def _left(search: Search, trial: Trial, judges: Sequence[Fold]) -> float:
    values = as_told(search, trial).values
    return sum(square(data.lasting().whitened(values)) for data in all_data(search, judges))


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
    found = _promising(search, now, judges) + (_hills(search, now) if placed else [])
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


def _promising(search: Search, now: Trial, judges: Sequence[Fold]) -> list[Trial]:
    """The sets with one more effect that promise most to first order and that the remainder does not imitate, which may
    gain more than all that is new; fitted where the remainder lasts."""
    lasting = search.target.lasting()
    options = FirstOrderGain(lasting, now).promising(c for c in search.tried.values() if c.name not in now.names)
    found: list[Trial] = []
    for left, candidate, point in options:
        if len(found) == _TRIED or now.chi2 - left < PROMISE * EVIDENT**2:
            break
        trial = search.trial((*now.names, candidate.name), now.values | point, target=lasting)
        if not is_imitated(search, trial, candidate.name, times_beyond(judges)):
            found.append(trial)
    return found


def _hills(search: Search, now: Trial) -> list[Trial]:
    """The same of effects that lie somewhere, at the best of all places that were passed: what a hill gains at a place
    nearby says little of what it gains where it is."""
    lasting = search.target.lasting()
    look = FirstOrderGain(lasting, now)
    found: list[Trial] = []
    for candidate in search.refiners.values():
        if is_placed(candidate) and candidate.name not in now.names:
            options = look.remaining_chi2(candidate, along_the_way(search, candidate))
            for _, point in sorted(options, key=lambda o: o[0])[:_PLACES]:
                found.append(search.trial((*now.names, candidate.name), now.values | point, target=lasting))
    return found


def _gain(search: Search, trial: Trial, judges: Sequence[Fold]) -> float:
    """What the data fitted on and the drives held out gain by the last effect of a set (chi^2)."""
    return sum(shown_by(search, trial, trial.names[-1], data).gain for data in all_data(search, judges))


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
    way = np.vstack([each.measured[:, :2] for each in search.target.experiments])
    way, step = way[np.isfinite(way).all(axis=1)], STEP
    while len(places := np.unique(np.round(way / step) + 0.0, axis=0)) > PLACES:
        step *= 1.5
    here, there = ((candidate.name, key) for key in ("x", "y"))
    others = {tuple(sorted((k, v) for k, v in point.items() if k not in (here, there))) for point in candidate.points}
    return [{**dict(other), here: x * step, there: y * step} for x, y in places.tolist() for other in sorted(others)]
