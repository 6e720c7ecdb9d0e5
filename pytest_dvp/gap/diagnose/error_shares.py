"""How much of the error each effect explains, and how sure that is."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np

from pytest_dvp.gap.diagnose.diagnosis import Step
from pytest_dvp.logs.log_contents import FloatArray

_SEED = 11  # any; fixed, so that the same logs give the same interval
_DRAWS = 1000  # leaves the ends of a 95 % interval uncertain by some 1.4 % of its level
_LEAST = 0.05  # chi^2/N above 1 that there must be for a share of it to mean something
_LOST = 0.0095  # smaller shares need a decimal to be seen


@dataclasses.dataclass(frozen=True, slots=True)
class Share:
    """Share of the excess error (chi^2/N above 1) that an effect takes away, with its 95 % interval over draws of
    segments; below 0 where it makes things worse. shown: "87 %", which adds up with those of the other effects."""

    value: float
    low: float
    high: float
    shown: str = ""


def shares(ladder: Sequence[Step], *, held_out: bool = False) -> dict[str, Share]:
    """Share of each effect of a ladder, in its order, on the data fitted on or held out; empty if there is no excess.

    Segments are drawn with replacement, for all steps alike; the fits stay as they are.
    """
    rows = [step.held_out_segments if held_out else step.segments for step in ladder]
    level = ladder[0].held_out_chi2_per_n if held_out else ladder[0].chi2_per_n
    if level is None or level <= 1.0 + _LEAST or len({len(row) for row in rows}) > 1 or not rows[0]:
        return {}
    squares = np.array(rows)
    total: FloatArray = squares.sum(axis=1)
    samples = total[0] / level
    total = np.maximum(total, samples)  # less than the noise is no gain
    m = squares.shape[1]
    draws = np.random.default_rng(_SEED).multinomial(m, np.full(m, 1.0 / m), size=_DRAWS)
    drawn: FloatArray = draws @ squares.T  # (draws, steps)
    excess = np.maximum(drawn[:, 0] - samples, _LEAST * samples)
    found = {}
    for (k, _), (_, after) in itertools.pairwise(enumerate(ladder)):
        low, high = np.quantile((drawn[:, k] - drawn[:, k + 1]) / excess, [0.025, 0.975])
        value = min(float((total[k] - total[k + 1]) / (total[0] - samples)), 1.0)
        found[after.added] = Share(value, min(float(low), value), max(min(float(high), 1.0), value))
    words = percents([share.value for share in found.values()])
    return {name: dataclasses.replace(one, shown=w) for (name, one), w in zip(found.items(), words, strict=True)}


def percents(shares: Sequence[float]) -> list[str]:
    """Shares of a whole as "87 %", rounded so that those shown add up to their rounded sum (largest remainders first);
    all with a decimal if one of them would else be lost."""
    digits = int(any(0.0 < abs(share) < _LOST for share in shares))
    parts = np.array(shares, dtype=np.float64) * 100.0 * 10**digits
    units = np.floor(parts)
    more = round(float(parts.sum())) - int(units.sum())
    units[np.argsort(units - parts, kind="stable")[:more]] += 1.0
    return [f"{unit / 10**digits + 0.0:.{digits}f} %" for unit in units]
