"""The units that all columns can have at once: each relation of the motion fixes the ratio of two of them.

A speed that is 3.6 times the way between positions is in km/h if these are in m; with an acceleration that is v times
the turn rate in m/s^2, the metres are certain, too. All combinations are tried; the cheapest is proposed, and a unit is
decided if every other one costs clearly more.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence

from pytest_dvp.logs.units import find_unit

UNITS: Mapping[str, tuple[tuple[str, float], ...]] = {
    "m": (("m", 0.0), ("cm", 1.5), ("mm", 1.5), ("km", 2.0), ("ft", 2.0)),
    "m/s": (("m/s", 0.0), ("km/h", 0.3), ("mph", 1.0), ("kn", 1.5), ("cm/s", 2.0), ("mm/s", 2.0)),
    "m/s^2": (("m/s^2", 0.0), ("g", 0.3), ("mg", 2.5), ("cm/s^2", 2.5)),
    "rad/s": (("rad/s", 0.0), ("deg/s", 0.1), ("mrad/s", 3.0)),
    "rad": (("rad", 0.0), ("deg", 0.1)),
}
"""Units that a column may have, and what each costs: how seldom recorders write it. Chosen, not measured."""

FAR = 16.0  # the most that a relation costs: one that is wrong (a dead sensor) must not overrule all others
CLEAR = 3.0  # by which every other unit must cost more: 1.7 sigma, or a unit nobody uses against two sigma


@dataclasses.dataclass(frozen=True, slots=True)
class Relation:
    """column = ratio * what others tell: `ratio` as found, in the units of the file; sigma of its logarithm. upper: the
    ratio may be smaller, as for a limit that a car keeps; far: the most that it costs.

    powers: of each column's unit in the ratio that is to be expected; constant: in SI.
    """

    text: str
    ratio: float
    sigma: float
    powers: Mapping[str, float]
    constant: float = 1.0
    upper: bool = False
    far: float = FAR

    def cost(self, scales: Mapping[str, float]) -> float:
        """Squared distance of the ratio from what units of these scales give, in sigmas, up to FAR."""
        expected = math.log(self.constant) + sum(power * math.log(scales[name]) for name, power in self.powers.items())
        off = math.log(self.ratio) - expected
        return min(((max(off, 0.0) if self.upper else off) / self.sigma) ** 2, self.far)


@dataclasses.dataclass(frozen=True, slots=True)
class Choice:
    """The unit of a column; decided: no other one does as well; otherwise `rival` is as good."""

    unit: str
    decided: bool
    rival: str


def choose(kinds: Mapping[str, str], stated: Mapping[str, str], relations: Sequence[Relation]) -> dict[str, Choice]:
    """Units of columns by name. kinds: the SI unit of each; stated: what the file says, which is not doubted here."""
    used = [r for r in relations if math.isfinite(r.ratio) and r.ratio > 0.0 and set(r.powers) <= set(kinds)]
    names = list(kinds)
    options = [((stated[n], 0.0),) if n in stated else UNITS[kinds[n]] for n in names]
    costs: list[tuple[float, tuple[str, ...]]] = []
    for combination in itertools.product(*options):
        scales = {n: _scale(unit) for n, (unit, _) in zip(names, combination, strict=True)}
        total = sum(price for _, price in combination) + sum(r.cost(scales) for r in used)
        costs.append((total, tuple(unit for unit, _ in combination)))
    best, units = min(costs)
    found = {}
    for k, name in enumerate(names):
        others = [(total, them[k]) for total, them in costs if them[k] != units[k]]
        worse, rival = min(others, default=(math.inf, ""))
        scales = {n: _scale(u) for n, u in zip(names, units, strict=True)}
        of_it = [r for r in used if name in r.powers]
        touched = any(r.cost(scales) < r.far for r in of_it)
        beyond = any(r.upper and r.cost(scales) >= r.far for r in of_it)  # what no car does, and no unit mends
        decided = name in stated or (touched and not beyond and worse - best > CLEAR)
        found[name] = Choice(units[k], decided, "" if decided else rival)
    return found


def _scale(unit: str) -> float:
    known = find_unit(unit)
    assert known is not None
    return known.scale
