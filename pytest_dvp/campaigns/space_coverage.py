"""How much of the space of a campaign was tried, and where nothing was: is it tested enough?"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from pytest_dvp.campaigns.cases import excluded_by
from pytest_dvp.campaigns.parameter_space import Axis, Space
from pytest_dvp.campaigns.sampling import sobol
from pytest_dvp.campaigns.store import EXCLUDED, Row
from pytest_dvp.logs.log_contents import FloatArray

PARTS = 10  # of a range: a tenth is what a person takes for "about the same value"; a list has its own values
LEAST = 10  # drives below which a share says nothing
CANDIDATES = 4096  # points of the space of which the emptiest are looked for; a gap is known to some percent of a range
SHOWN = 3  # gaps
LOOKED_AT = 1000  # places of an axis at which it is asked for its value
FEW = 100  # different values below which an axis is a list: ten in each part, and each has a place of its own
ROUNDING = 1e-5  # of a part: numbers have six digits or more, and one on the edge of a part belongs to the upper one


@dataclasses.dataclass(frozen=True)
class Gap:
    """A place where nothing was driven: values, and how far [share of every range, 0 to 1] it is to the next drive in
    the parameter in which they differ most."""

    values: dict[str, str]
    radius: float


@dataclasses.dataclass(frozen=True)
class Coverage:
    """What was tried of a space.

    drives      how many were driven
    tried       shares 0 to 1 of all combinations of parts of the ranges: of single parameters, pairs, triples
    unevenness  centred L2 discrepancy, squared, over what as many independent draws have on average: below 1 is more
                even, above 1 less; None where an axis is a list, or draws were excluded
    gaps        the emptiest places within the scenario's constraints, the largest first
    """

    drives: int
    tried: tuple[float, ...]
    unevenness: float | None
    gaps: tuple[Gap, ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return dataclasses.asdict(self)

    def sentences(self) -> list[str]:
        """What a person wants to know, a sentence each."""
        names = ("single values", "pairs", "triples")
        tried = ", ".join(f"{100.0 * share:.0f} % of {name}" for share, name in zip(self.tried, names, strict=False))
        found = [f"tried, with each range in {PARTS} parts: {tried}"]
        if self.unevenness is not None:
            found.append(f"unevenness {self.unevenness:.2g}: independent draws have 1 on average, even ones less")
        for gap in self.gaps:
            where = ", ".join(f"{name}={value}" for name, value in gap.values.items())
            found.append(f"no drive has all parameters within {100.0 * gap.radius:.0f} % of their ranges of {where}")
        return found


def coverage(space: Space, rows: Sequence[Row], seed: int = 0) -> Coverage | None:
    """What the rows of a campaign have tried of its space; None below LEAST drives.

    A combination that only draws outside the scenario's constraints met is not counted as missing. Source of the
    shares: total t-way coverage, Kuhn, Mendoza, Kacker, Lei, Combinatorial coverage measurement concepts and
    applications, IEEE ICSTW 2013. Of the discrepancy: Hickernell, Math. Comp. 67 (1998).
    """
    driven = [row for row in rows if row.verdict != EXCLUDED]
    if len(driven) < LEAST:
        return None
    points = np.array([[axis.share_of(row.parameters) for axis in space.axes] for row in driven])
    outside = np.array(
        [[axis.even_share_of(row.parameters) for axis in space.axes] for row in rows if row.verdict == EXCLUDED]
    )
    parts = [min(axis.count or PARTS, PARTS) for axis in space.axes]
    size = len(parts)
    listed = [_listed(axis) for axis in space.axes]
    even = np.array([[axis.even_share_of(row.parameters) for axis in space.axes] for row in driven])
    # A part in which no value of a list lies cannot be tried.
    known = [
        parts[k] if places is None else len({*_part(np.array(places), parts[k]), *_part(even[:, k], parts[k])})
        for k, places in enumerate(listed)
    ]
    tried = tuple(_tried(even, outside, parts, known, many) for many in range(1, min(size, 3) + 1))
    plain = all(places is None for places in listed) and not len(outside)
    gaps = _gaps(space, points, listed, seed)
    return Coverage(len(driven), tried, _unevenness(points) if plain else None, gaps)


def _listed(axis: Axis) -> list[float] | None:
    """The places of the values of an axis that has few different ones, each taking as much as any other if they are
    known by number; None of any other axis."""
    if axis.count is not None:
        number = min(axis.count, LOOKED_AT)  # spread over the whole axis, so that each part holds one
        return [(k + 0.5) / number for k in range(number)]
    values = {tuple(axis.at((k + 0.5) / LOOKED_AT).items()) for k in range(LOOKED_AT)}
    return [axis.share_of(dict(each)) for each in values] if len(values) < FEW else None


def _part(shares: FloatArray, parts: int) -> list[int]:
    """In which of equal parts of 0 to 1 shares (n,) lie."""
    found: list[int] = np.minimum((shares * parts + ROUNDING).astype(int), parts - 1).tolist()
    return found


def _shares(space: Space, rows: Sequence[Row]) -> FloatArray:
    """Where drives lie, as the share of each axis (n, m)."""
    return np.array([[axis.share_of(row.parameters) for axis in space.axes] for row in rows], dtype=float)


def _cells(points: FloatArray, parts: Sequence[int], axes: Sequence[int]) -> set[tuple[int, ...]]:
    """The combinations of parts of some axes that points (n, m) lie in."""
    if not len(points):
        return set()
    columns = [_part(points[:, k], parts[k]) for k in axes]
    return set(zip(*columns, strict=True))


def _tried(
    points: FloatArray, outside: FloatArray, parts: Sequence[int], known: Sequence[int], many: int
) -> float:  # fmt: skip
    """known: in how many of the parts of each axis a value lies."""
    met = every = 0
    for axes in itertools.combinations(range(len(parts)), many):
        here = _cells(points, parts, axes)
        met += len(here)
        every += int(np.prod([known[k] for k in axes])) - len(_cells(outside, parts, axes) - here)
    return met / max(every, 1)


def _unevenness(points: FloatArray) -> float:
    from scipy.stats import qmc

    n, size = points.shape
    expected = ((5.0 / 4.0) ** size - (13.0 / 12.0) ** size) / n
    return float(qmc.discrepancy(np.clip(points, 0.0, 1.0), method="CD") / expected)


def _gaps(
    space: Space, points: FloatArray, listed: Sequence[list[float] | None], seed: int
) -> tuple[Gap, ...]:  # fmt: skip
    """The emptiest places, each at least its own radius from those before. A value of a list has one place."""
    from scipy.spatial import cKDTree  # here, for the summary of a campaign needs this file and no tree

    candidates = np.array(sobol(len(space.axes), CANDIDATES, seed))
    for k, axis in enumerate(space.axes):
        if axis.count is not None and not axis.weights:
            number = np.minimum(np.floor(candidates[:, k] * axis.count), axis.count - 1)
            candidates[:, k] = (number + 0.5) / axis.count
        elif listed[k] is not None:
            known: dict[tuple[tuple[str, str], ...], float] = {}
            for row in candidates:
                values = axis.at(float(row[k]))
                if (key := tuple(values.items())) not in known:
                    known[key] = axis.share_of(values)
                row[k] = known[key]
    away = np.asarray(cKDTree(points).query(candidates, p=np.inf)[0], dtype=float)
    found: list[Gap] = []
    taken: list[FloatArray] = []
    for k in np.argsort(-away, kind="stable"):
        if away[k] <= 0.0:
            break  # every other value was driven
        if any(np.abs(candidates[k] - each).max() < away[k] for each in taken):
            continue
        values = space.values(tuple(float(share) for share in candidates[k]))
        if excluded_by(space.scenario, values):
            continue
        taken.append(candidates[k])
        found.append(Gap(values, float(away[k])))
        if len(found) == SHOWN:
            break
    return tuple(found)
