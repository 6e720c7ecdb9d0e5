"""All that an actuator has, where a set names a part of it: one part may stand for the others.

While the dead time of a van's steering was 0.11 s in place of 0.05 s, neither its lag nor its limit was worth a name. A
sensor that shows the motion late may stand for the actuator as well.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.fitting import Fitting
from pytest_dvp.gap.diagnose.linear_algebra import square

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.experiment import Values
    from pytest_dvp.gap.diagnose.trial import Trial

ACTUATORS = (("steer_delay", "steer_lag", "steer_rate_limit"), ("drive_delay", "drive_lag", "jerk_limit"))
"""Dead time, lag and fastest change of the steering and of the drive."""
_KEPT = (1.0, 0.5, 0.25)  # shares of a time that is named, which it may keep beside the others; chosen
_FITTED = 2  # beginnings, the best as they are, from which a whole actuator is fitted; chosen


def whole_actuators(search: Fitting, now: Trial) -> Iterator[Trial]:
    """For each actuator of which a set names a part, the best set with all of it: without what does not pay beside the
    rest, and perhaps without effects that are like what was missing. It may do no better than the set itself."""
    for parts in ACTUATORS:
        named = [name for name in parts if name in now.names]
        missing = [name for name in parts if name not in now.names]
        if named and missing and all(name in search.tried for name in parts):
            best = _without_idle(search, parts, _fitted(search, now, named, missing))
            new = [name for name in best.names if name in missing]
            if new and all(search.is_credible(best, name) for name in new):
                yield best


def _fitted(search: Fitting, now: Trial, named: Sequence[str], missing: Sequence[str]) -> Trial:
    """The set with all parts, from its best beginnings."""
    every = sorted(_beginnings(search, now, named, missing), key=lambda start: square(search.target.whitened(start)))
    trials = []
    for start in every[:_FITTED]:
        there = {name for name, _ in start}
        trials.append(search.trial([n for n in (*now.names, *missing) if n in there], start, like=now))
    return min(trials, key=search.cost)


def _without_idle(search: Fitting, parts: Sequence[str], best: Trial) -> Trial:
    """The set without those parts that do not pay beside the rest, the last of them first."""
    for name in reversed([name for name in best.names if name in parts]):
        less = search.trial([n for n in best.names if n != name], best.values, like=best)
        if not search.is_worth_adding(less, best):
            best = less
    return best


def _beginnings(search: Fitting, now: Trial, named: Sequence[str], missing: Sequence[str]) -> Iterator[Values]:
    """Values of the set with the missing parts at all their points: beside those named, which keep a share of their
    time, and in the place of one effect, or of all, that is like them (a late yaw rate of a late steering)."""
    times = [c.name for name in named for c in search.tried[name].coordinates if c.key.unit == "s"]
    like = {other for name in missing for other in search.tried[name].effect.ties}
    like |= {name for name, c in search.tried.items() if set(c.effect.ties) & set(missing)}
    stood = [name for name in now.names if name in like and name not in named]
    for out in dict.fromkeys(((), *((name,) for name in stood), tuple(stood))):
        kept = {key: value for key, value in now.values.items() if key[0] not in out}
        for share in _KEPT if times else (1.0,):
            sooner = {key: share * now.values[key] for key in times}
            for points in itertools.product(*(search.tried[name].points for name in missing)):
                yield kept | sooner | {key: value for point in points for key, value in point.items()}
