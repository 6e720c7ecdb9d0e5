"""Which values of effects the known remainder of a twin imitates: each effect asked for on drives that hide nothing.

The twin was learnt on drives without anything new. What a fit of an effect finds there is made of the remainder alone,
and on another drive of the same car as much of it is to be expected again: a control without treatment, as in a trial
with placebos. To first order, at two places of the effect's range, in the metric of `lasting_remainder`; and fitted,
where much is gained. A limit that is never met does nothing at all, so there is no first order.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf, isfinite, isinf

import numpy as np

from pytest_dvp.gap.diagnose.beyond_remainder import APART, EVIDENT
from pytest_dvp.gap.diagnose.candidates import Candidate, says_how, sizes
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.lasting_remainder import as_measured, rounded_imitation
from pytest_dvp.gap.diagnose.least_squares import STEP, Coordinate
from pytest_dvp.gap.diagnose.linear_algebra import gram, row_products, square
from pytest_dvp.gap.diagnose.quiet_effects import along_the_way, is_placed
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.vehicle_model import VehicleModel

SHOWN = 25.0  # of chi^2 per square of an effect's range: with less, these drives say nothing of it
FARTHEST = 1.0  # of a key's range: beyond it a first order means nothing
EXPECTED_AS = 4  # drives that what is to be expected counts as; chosen: 1 to 8 did as well on 78 pairs of drives with
# nothing new of 24 cars. With 4, 4.2 % of all values stray farther than 4.3 times on a drive and 1.3 % than 3.0 times
# on both; with 0 that were 7.8 and 2.8 %
MEDIAN = 0.455  # of the square of a normal variable
LONGEST = 0.5  # of a key's range, for a slope; chosen: half of it leaves none outside
LONGER = 2.0  # times, at least, by which a step is lengthened; chosen: so at most eight are asked
MARGIN = 1.2  # times the length that would do in proportion; chosen: where the error jumps it grows by the root of it
_HALVINGS = 8  # of the range of a limit
_RIDGE = 1e-6  # of the diagonal, for keys that cannot be told apart


def imitation(groups: Iterable[ExperimentSet], tried: Sequence[Candidate]) -> dict[str, dict[str, float]]:
    """Root mean square over the groups of logs of what each key of an effect is off by, in its unit, moderated by what
    all effects of this twin are off by. groups: where the remainder lasts, or beside dead reckoning.

    Two drives say little of how far a value strays, and of fifty effects some hardly stray on these two by chance. So
    each square is averaged with one that is to be expected: how many of its formal standard deviations the values of
    this twin stray, the median of all, times its own (moderated t statistics: Smyth, 2004, doi 10.2202/1544-6115.1027).
    """
    found: dict[tuple[str, str], list[float]] = {}
    formal: dict[tuple[str, str], list[float]] = {}
    count = 0
    for group in groups:
        count += 1
        group.settle({})
        rest = group.whitened({})
        for candidate in tried:
            for place in sorted({0, len(candidate.points) // 2}):
                point = candidate.points[place]
                here = group.whitened(point)
                jacobian = np.array([_slope(group, here, point, c) for c in candidate.coordinates])
                seen = [k for k in range(len(jacobian)) if square(jacobian[k]) > SHOWN]
                sized = [k for k in seen if not says_how(candidate.coordinates[k].key)]
                if not sized and len(seen) < len(jacobian):
                    continue
                normal = gram(jacobian[seen])
                normal += _RIDGE * np.diag(np.diag(normal))
                moved = -np.linalg.solve(normal, row_products(jacobian[seen], rest))
                spread = np.sqrt(np.diag(np.linalg.inv(normal)))
                for k, u, sure in zip(seen, np.clip(moved, -FARTHEST, FARTHEST), spread, strict=True):
                    c = candidate.coordinates[k]
                    slope = c.slope(c.to_unit(point[c.name]))
                    found.setdefault(c.name, []).append(float(u) * slope)
                    formal.setdefault(c.name, []).append(float(sure) * abs(slope))
    return rounded_imitation(moderated(found, formal, count))


def _slope(group: ExperimentSet, here: FloatArray, point: Values, c: Coordinate) -> FloatArray:
    """By what the whitened error (N,), which is `here` at `point`, changes per range of a key: over a step that is as
    evident as an effect has to be.

    Where a gear is changed or the car stops, the error jumps, and a little later if a value is a little larger. Over a
    short step single samples make the slope: the resistance of a van with six gears seemed to be known many times as
    well as it was.
    """
    u = c.to_unit(point[c.name])
    side, step = (1.0 if u < 0.5 else -1.0), STEP
    while True:
        change = group.whitened({**point, c.name: c.value(u + side * step)}) - here
        size = float(np.sqrt(square(change)))
        if size >= EVIDENT or step >= LONGEST:
            return np.asarray(change / (side * step))
        step = min(step * max(MARGIN * EVIDENT / size, LONGER), LONGEST) if size > 0.0 else LONGEST


def moderated(
    found: Mapping[tuple[str, str], Sequence[float]], formal: Mapping[tuple[str, str], Sequence[float]], count: int
) -> dict[tuple[str, str], list[float]]:
    """What each key is off by, as one value: with the weight of `count` groups what was found, with that of
    EXPECTED_AS what is to be expected. formal: standard deviations beside what was found."""
    pairs = [pair for name in found for pair in zip(found[name], formal[name], strict=True)]
    ratios = [(value / sure) ** 2 for value, sure in pairs if sure]
    inflation = float(np.median(ratios)) / MEDIAN if ratios else 0.0
    result = {}
    for name, values in found.items():
        own, expected = float(np.mean(np.square(values))), inflation * float(np.mean(np.square(formal[name])))
        result[name] = [float(np.sqrt((count * own + EXPECTED_AS * expected) / (count + EXPECTED_AS)))]
    return result


def placebos(
    groups: Sequence[ExperimentSet], tried: Sequence[Candidate], model: VehicleModel
) -> tuple[dict[str, dict[str, float]], dict[str, dict[str, float]]]:
    """What each effect is fitted with where a diagnosis would take it for evident: the root mean square over the groups
    of what sizes are off by, and the lowest limits of what has no limit in the model, if no other group refutes them:
    brakes that seem to give no more than 1.1 m/s^2 in town gave 6 elsewhere. Both in the units of the keys."""
    present = {a.name: a.values for a in model.effects}
    sizes_off: dict[tuple[str, str], list[float]] = {}
    lowest: dict[str, dict[str, float]] = {}
    for k, group in enumerate(groups):
        target = group.lasting()
        target.settle({})
        for candidate in tried:
            search = Search(target, [candidate])
            now = search.trial((), {})
            points = along_the_way(search, candidate) if is_placed(candidate) else candidate.points
            options = FirstOrderGain(target, now).remaining_chi2(candidate, points)
            left, point = min(options, key=lambda option: option[0], default=(now.chi2, {}))
            if now.chi2 - left <= APART**2:
                continue
            values = search.trial((candidate.name,), point).values
            refuted = None  # asked of limits only, for it costs replays of all drives
            for c in sizes(candidate.coordinates):
                had = present.get(c.effect, {}).get(c.key.name, c.key.neutral)
                if isinf(had):
                    if refuted is None:
                        refuted = any(_refutes(each, candidate, values) for each in groups)
                    if not refuted:
                        known = lowest.setdefault(c.effect, {})
                        known[c.key.name] = min(known.get(c.key.name, np.inf), as_measured(values[c.name]))
                else:
                    sizes_off.setdefault(c.name, [0.0] * len(groups))[k] = values[c.name] - had
    return rounded_imitation(sizes_off), lowest


def _refutes(group: ExperimentSet, candidate: Candidate, values: Values) -> bool:
    """True if data are worse by APART standard deviations with the effect than without it."""
    target = group.lasting()
    target.settle({})
    mine = {c.name: values[c.name] for c in candidate.coordinates}
    return square(target.whitened(mine)) > square(target.whitened({})) + APART**2


def unseen(
    groups: Sequence[ExperimentSet], tried: Sequence[Candidate], model: VehicleModel
) -> dict[str, dict[str, float]]:
    """The lowest limit of what has none in the model that all drives leave open, in the unit of the key: the car may
    have it without the twin's knowing. One that is noticed at its highest already is left out."""
    present = {a.name for a in model.effects}
    found: dict[str, dict[str, float]] = {}
    for candidate in tried:
        for c in candidate.coordinates:
            if candidate.name not in present and isinf(c.key.neutral):
                open_at = max((_open_down_to(group.lasting(), candidate, c) for group in groups), default=-inf)
                if isfinite(open_at):
                    found.setdefault(candidate.name, {})[c.key.name] = as_measured(open_at)
    return found


def _open_down_to(target: ExperimentSet, candidate: Candidate, c: Coordinate) -> float:
    """The lowest limit with which the data are not worse by APART standard deviations than without it; inf if there is
    none in the range."""
    target.settle({})
    free = square(target.whitened({}))
    others = {key: value for key, value in candidate.points[-1].items() if key != c.name}  # where they limit least

    def is_open(u: float) -> bool:
        return square(target.whitened({**others, c.name: c.value(u)})) < free + APART**2

    low, high = c.to_unit(c.key.low), c.to_unit(c.key.high)
    if is_open(low):
        return c.value(low)
    if not is_open(high):
        return inf
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if is_open(middle) else (middle, high)
    return c.value(high)


def of_other_drives(model: VehicleModel, tried: Iterable[Candidate]) -> dict[str, dict[str, float]]:
    """How far values lie apart that are of a drive and not of the car, by key. Another drive has a road and an air of
    its own, and the one draw that is known of them says that theirs may be as large, to either side. A force that
    differs from gear to gear is that of the gears in which it was met; the next one has as much less as it is longer.
    """
    present = {a.name: a.values for a in model.effects}
    longer = present.get("gear_changes", {}).get("step", 1.0) - 1.0
    found: dict[str, dict[str, float]] = {}
    for candidate in tried:
        by_gear = candidate.effect.diagnosed.by_gear
        if candidate.name in present and (candidate.effect.diagnosed.surroundings or by_gear):
            for c in sizes(candidate.coordinates):
                value = present[candidate.name].get(c.key.name, c.key.neutral)
                size = value * longer if by_gear else abs(value - c.key.neutral)
                if isfinite(size) and size > 0.0:
                    found.setdefault(candidate.name, {})[c.key.name] = as_measured(size)
    return found


def larger(
    some: Mapping[str, Mapping[str, float]], others: Mapping[str, Mapping[str, float]]
) -> dict[str, dict[str, float]]:
    """The larger value of each key of each effect."""
    found = {effect: dict(keys) for effect, keys in some.items()}
    for effect, keys in others.items():
        known = found.setdefault(effect, {})
        known |= {key: max(value, known.get(key, 0.0)) for key, value in keys.items()}
    return found
