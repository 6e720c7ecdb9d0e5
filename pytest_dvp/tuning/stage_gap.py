"""How far apart the stages are, over all drives of a set: means with intervals from repeats."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pytest_dvp.tuning.iteration_plan import STAGES, Drive

PAIRS = (("dt", "rw"), ("pe", "rw"))


@dataclasses.dataclass(frozen=True, slots=True)
class Figure:
    """A figure over repeats: mean, half width of its 95 % interval (None of fewer than two repeats), the least
    favourable value of all drives, how many drives define it, and how many there are."""

    mean: float | None
    half_width: float | None
    worst: float | None
    known: int
    count: int

    def as_dict(self) -> dict[str, Any]:
        """The fields as JSON holds them."""
        return dataclasses.asdict(self)


@dataclasses.dataclass(frozen=True, slots=True)
class Gap:
    """likeness: "dt-rw" -> row of the stage table -> MNCC; with ".lag" its size [s], with ".gain" its distance from
    1, drive by drive; metrics: stage -> row;
    difference: "dt-rw" -> row -> the metric of the second less that of the first
    ensemble: "dt-rw" -> row, with ".lag", ".gain" as above -> of the mean drives (`tuning.ensemble`)."""

    likeness: Mapping[str, Mapping[str, Figure]]
    metrics: Mapping[str, Mapping[str, Figure]]
    difference: Mapping[str, Mapping[str, Figure]]
    ensemble: Mapping[str, Mapping[str, Figure]] = dataclasses.field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """The tables as JSON holds them."""

        def plain(rows: Mapping[str, Mapping[str, Figure]]) -> dict[str, Any]:
            return {a: {b: f.as_dict() for b, f in inner.items()} for a, inner in rows.items()}

        return {
            "likeness": plain(self.likeness),
            "metrics": plain(self.metrics),
            "difference": plain(self.difference),
            "ensemble": plain(self.ensemble),
        }


def gap(drives: Sequence[Drive]) -> Gap:
    """Of drives of all three stages, their logs written. A repeat is a seed: the mean over its variants."""
    from pytest_dvp.logs.log import Log
    from pytest_dvp.verdicts.stage_table import stage_table

    cells: dict[tuple[str, str], list[tuple[int, float | None]]] = {}
    single: dict[tuple[str, str], list[tuple[int, float | None]]] = {}
    apart: dict[tuple[str, str], list[tuple[int, float | None]]] = {}
    by_case: dict[tuple[int, int], dict[str, Path]] = {}
    variants = {id(d.variant): k for k, d in reversed(list(enumerate(drives)))}
    for drive in drives:
        by_case.setdefault((drive.seed, variants[id(drive.variant)]), {})[drive.stage] = drive.log
    for (seed, _), logs in by_case.items():
        loaded = {stage: Log.load(path) for stage, path in logs.items()}
        for one, other in PAIRS:
            if one not in loaded or other not in loaded:
                continue
            table = stage_table({one: loaded[one], other: loaded[other]})
            for row in table.rows:
                first, second = row.cells
                if table.against[1] and (row.metric in ("mncc", "path_distance", "twin_error")):
                    pair = f"{one}-{other}"
                    cells.setdefault((pair, row.name), []).append((seed, second.value))
                    if row.metric == "mncc":
                        cells.setdefault((pair, f"{row.name}.lag"), []).append((seed, _size(second.lag)))
                        cells.setdefault((pair, f"{row.name}.gain"), []).append((seed, _size(second.gain, 1.0)))
                    continue
                if second.value is not None and first.value is not None:
                    apart.setdefault((f"{one}-{other}", row.name), []).append((seed, second.value - first.value))
                single.setdefault((one, row.name), []).append((seed, first.value))
                if (one, other) == PAIRS[0]:
                    single.setdefault((other, row.name), []).append((seed, second.value))
    stages = {stage: [drive for drive in drives if drive.stage == stage] for stage in STAGES}
    mean = {f"{one}-{other}": mean_alike(stages[one], stages[other]) for one, other in PAIRS}
    return Gap(_nested(cells), _nested(single), _nested(apart), mean)


def mean_alike(one: Sequence[Drive], other: Sequence[Drive]) -> dict[str, Figure]:
    """Likeness of the mean drives of two sets of repeats, as figures by row, row.lag and row.gain."""
    from pytest_dvp.tuning.mean_drives import ensemble

    found: dict[str, Figure] = {}
    for row, alike in ensemble(one, other).items():
        for part, name in enumerate((row, f"{row}.lag", f"{row}.gain")):
            found[name] = Figure(
                alike.values[part], alike.half_widths[part], alike.worst[part], alike.repeats, alike.repeats
            )
    return found


def _nested(rows: Mapping[tuple[str, str], list[tuple[int, float | None]]]) -> dict[str, dict[str, Figure]]:
    found: dict[str, dict[str, Figure]] = {}
    for (group, name), values in rows.items():
        found.setdefault(group, {})[name] = figure(name, values)
    return found


def figure(name: str, values: Sequence[tuple[int, float | None]]) -> Figure:
    """Of (seed, value): the mean over seeds of the means over variants, and its interval."""
    known = [(seed, value) for seed, value in values if value is not None and math.isfinite(value)]
    if not known:
        return Figure(None, None, None, 0, len(values))
    seeds = sorted({seed for seed, _ in known})
    means = np.array([np.mean([v for s, v in known if s == seed]) for seed in seeds])
    half = None
    if len(means) > 1:
        from scipy.stats import t

        half = float(t.ppf(0.975, len(means) - 1) * means.std(ddof=1) / math.sqrt(len(means)))
    every = [value for _, value in known]
    return Figure(float(means.mean()), half, _worst(name, every), len(known), len(values))


def _size(value: float | None, target: float = 0.0) -> float | None:
    """Distance from the target: a lag of -0.1 s and one of +0.1 s do not make a mean of none."""
    return None if value is None else abs(value - target)


def _worst(name: str, values: Sequence[float]) -> float:
    """The least MNCC, the greatest of everything else."""
    if name.endswith((".lag", ".gain")):
        return max(values)
    if name.startswith(("ego", "object")) or name in ("steer", "velocity"):
        return min(values)
    return max(values)
