"""What nearly every car has, all at once: the beginning of a search where a model is a bare data sheet.

Step by step, far from the car, an effect is named for what several others do together, and is hard to get rid of: an
SUV was given a stronger drive, brakes that fade and a drag in the place of a larger mass, a converter that creeps and
the drag of its engine. Fitted all at once, from values that cars have, these find their own shares in seconds; what a
car does not need is taken out again.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.fitting import Fitting
from pytest_dvp.gap.diagnose.linear_algebra import orthonormal, row_products, square

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.trial import Trial

USUAL: Mapping[str, Mapping[str, float]] = {
    "steer_ratio": {"g": 1.0},
    "steer_offset": {"offset": 0.0},
    "steer_delay": {"T": 0.05},
    "steer_lag": {"tau": 0.1},
    "steer_rate_limit": {"limit": 0.5},
    "steer_backlash": {"half_width": 0.002},
    "understeer": {"K": 0.002},
    "body_roll": {"gain": 0.05},
    "mass": {"ratio": 1.0},
    "drive_gain": {"g": 1.0},
    "brake_gain": {"g": 1.0},
    "drive_delay": {"T": 0.05},
    "drive_lag": {"tau": 0.1},
    "brake_lag": {"tau": 0.08},
    "rolling_resistance": {"c": 0.1},
    "aero_drag": {"k": 0.0004},
    "lift_off_braking": {"a": 0.2},
    "gear_inertia": {"share": 0.1},
    "creep": {"a": 0.2},
    "power_limit": {"limit": 15.0},
    "drive_torque_limit": {"limit": 2.0},
    "torque_converter": {"ratio": 1.5, "stall": 1.5, "J": 0.05},
}
"""Effects that nearly every car shows in half a minute of traffic, with values from which a fit may begin; what is not
told here begins at its neutral value. The limits begin low: one that no drive meets has nothing to be fitted to."""
_FEW = 4  # effects, after which a search of one by one is left where this much is still there:
BARE = 20.0  # times the noise
LARGEST = 24  # effects of a set that begins so, or that held-out data agree with; chosen
_NEEDED = 3  # effects, the least needed ones, that all pay: then the others do
_TIMES = 3  # that the set is fitted, each with the segments begun anew


def is_bare(search: Fitting, now: Trial) -> bool:
    """True if a few effects left so much that the model is a bare data sheet."""
    return not search.target.excused and len(now.names) >= _FEW and now.chi2 > BARE * search.count


def with_seen(search: Fitting, now: Trial) -> Trial:
    """The set with what the logs show by themselves and it has not, fitted along, if that is worth it: what is named
    before a gearbox is there takes its place. Not beside a known remainder, of which that is a part."""
    names = [name for name, one in search.tried.items() if one.seen and name not in now.names]
    if not names or search.target.excused:
        return now
    search.tick(f"what the log shows by itself: {', '.join(names)}")
    begin = {key: value for name in names for key, value in search.tried[name].seen.items()}
    more = search.trial([*now.names, *names], now.values | begin, like=now)
    return more if search.is_worth_adding(now, more) else now


def usual_car(search: Fitting) -> Trial:
    """The set of what nearly every car has, and of what the logs show by themselves, fitted, without what is not worth
    an effect on this one. What no strength of an effect would show in these logs is not fitted: a speed that is given
    from outside leaves a dozen of these nothing to do, and each of them cost a fit before it was taken out."""
    unseen = search.unseen()
    names = [name for name in USUAL if name in search.tried and name not in unseen]
    begin = {c.name: USUAL[name].get(c.key.name, c.key.neutral)
             for name in names for c in search.tried[name].coordinates}  # fmt: skip
    for candidate in search.tried.values():
        if candidate.seen:
            names.append(candidate.name)
            begin.update(candidate.seen)
    search.tick(f"what nearly every car has, {len(names)} effects at once")
    now = search.trial(names, search.start | begin)
    for _ in range(_TIMES):
        search.target.settle(now.values)
        now = search.trial(now.names, now.values, like=now)
    kept: list[str] = []
    while len(kept) < _NEEDED and (least := [n for n in _least_needed(search, now) if n not in kept]):
        search.tick(f"what nearly every car has: without {least[0]}; chi²/N {now.chi2 / search.count:.3g}")
        less = search.trial([n for n in now.names if n != least[0]], now.values, like=now)
        if search.pays(less, now):
            kept.append(least[0])
        else:
            now, kept = less, []
    search.target.settle(now.values)
    return search.trial(now.names, now.values, like=now)


def _least_needed(search: Fitting, now: Trial) -> list[str]:
    """The effects, first those without which least would be left, the others adapting to first order."""
    left, fit = {}, now.fit
    for name in now.names:
        mine = [c for c in fit.coordinates if c.effect == name]
        off = search.target.whitened(now.values | {c.name: c.key.neutral for c in mine})
        basis = orthonormal(fit.jacobian[[k for k, c in enumerate(fit.coordinates) if c.effect != name]])
        left[name] = square(off) - square(row_products(basis, off))
    return sorted(left, key=lambda name: left[name])
