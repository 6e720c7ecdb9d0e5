"""Speed and turn rate of a log without positions: what other columns are made of.

The lateral acceleration is speed times turn rate, the longitudinal one the change of speed, and the turn rate goes with
steering times speed. The pair that explains most of the other columns is taken.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from pytest_dvp.logs.column_names import canonical
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.mapping import QUATERNION
from pytest_dvp.recognition.columns import Column
from pytest_dvp.recognition.grid import Grid
from pytest_dvp.recognition.words import families

MOST = 8  # columns that are tried for one quantity
EXPLAINS = 0.85  # correlation with another column, from which a pair without telling names is taken
BY_NAME = 0.3  # of a correlation that a name is worth


def speed_and_turn(
    columns: Sequence[Column], grid: Grid, *, with_rate: bool
) -> tuple[Column | None, Column | None]:  # fmt: skip
    """The columns of speed and turn rate (None where nothing tells); with_rate: False if a turn rate is known."""
    plain = [c for c in columns if c.unit != QUATERNION and not c.is_command]
    speeds = _candidates(plain, "speed", {"v", "vx"})
    rates = _candidates(plain, "rate", {"yaw_rate"}) if with_rate else []
    means = {c.key: grid.mean(c) for c in plain}
    best: tuple[float, Column | None, Column | None] = (0.0, None, None)
    for speed, rate in itertools.product(speeds, [*rates, None]):
        if speed is rate:
            continue
        told, gain = _explained(speed, rate, plain, means, grid)
        named = _named(speed, "speed") + (_named(rate, "rate") if rate is not None else 0.0)
        if told < EXPLAINS and not (_named(speed, "speed") and (rate is None or _named(rate, "rate"))):
            continue
        if gain + BY_NAME * named > best[0]:
            best = (gain + BY_NAME * named, speed, rate)
    return best[1], best[2]


def _candidates(columns: Sequence[Column], family: str, usual: set[str]) -> list[Column]:
    """Columns that may be it, those with the usual name first; where some have a telling name, only these."""
    may = [c for c in columns if not (said := families(c.name, c.unit)) or family in said]
    telling = [c for c in may if _named(c, family)]
    return sorted(telling or may, key=lambda c: canonical(c.name) not in usual)[:MOST]


def _named(column: Column, family: str) -> float:
    said = families(column.name, column.unit)
    return 0.0 if family not in said else 1.0 if len(said) == 1 else 0.5


def _explained(
    speed: Column, rate: Column | None, columns: Sequence[Column], means: dict[tuple[str, str], FloatArray], grid: Grid
) -> tuple[float, float]:  # fmt: skip
    """The best correlation of another column with what the pair makes, and the sum over what it makes."""
    v = means[speed.key]
    if float(np.nanmedian(v)) <= 0.0 or float(np.nanpercentile(v, 5)) < -0.2 * float(np.nanpercentile(v, 95)):
        return 0.0, 0.0  # a car drives forwards most of the time
    others = [c for c in columns if c is not speed and c is not rate]
    forces = [means[c.key] for c in others if not (said := families(c.name, c.unit)) or "accel" in said]
    steers = [means[c.key] for c in others if not (said := families(c.name, c.unit)) or "steer" in said]
    along = grid.slope(v)
    found = [max((abs(grid.match(a, along).alike) for a in forces), default=0.0)]
    if rate is not None:
        r = means[rate.key]
        found.append(max((abs(grid.match(a, v * r).alike) for a in forces), default=0.0))
        found.append(max((abs(grid.match(d * v, r).alike) for d in steers), default=0.0))
    return max(found), sum(found)
