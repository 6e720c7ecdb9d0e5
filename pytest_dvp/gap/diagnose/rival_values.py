"""Values that hold whichever of some rivals is the true one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pytest_dvp.gap.diagnose.beyond_remainder import as_told
from pytest_dvp.gap.diagnose.least_squares import Intervals
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial


def with_rival_values(search: Search, final: Trial, sure: Intervals, rivals: Mapping[str, Sequence[str]]) -> Intervals:
    """The 95 % intervals `sure` of the final set, each wide enough for where it would lie with a rival in the place of
    another effect. Units are those of the values; an interval is moved with its value, and as wide as it was: where a
    rival leaves more, its own would be wider for that alone.

    An interval of one set says how far its values may be moved by noise, not that the set is true: with a lagging roll
    steer in the place of a plain understeer, which the data cannot tell apart, the same drive asks for another yaw
    inertia. Where the data are told to be unable to say which, both values stand. Rivals that the search did not fit
    in the place of the effect, such as those of the second opinion, widen nothing.
    """
    found, keys = dict(sure), {c.name: c.key for c in final.fit.coordinates}
    for name, others in rivals.items():
        among = [other for other in others if other in search.tried and other not in final.names]
        if name not in final.names or not among:
            continue
        for trial in search.in_place_of(final, name, among):
            told = as_told(search, trial)
            for key, (low, high) in sure.items():
                if key in told.fit.values and key in final.values and key[0] not in (name, told.names[-1]):
                    moved = told.fit.values[key] - final.values[key]
                    least, most = keys[key].minimum, keys[key].maximum
                    found[key] = (
                        min(found[key][0], max(low + moved, least)),
                        max(found[key][1], min(high + moved, most)),
                    )
    return found
