"""Where the error sits: channel by regime, speed, segment of time and place on the map."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pytest_dvp.gap.compare.regimes import speed_bins
from pytest_dvp.gap.compare.segments import Segments
from pytest_dvp.gap.compare.start_correction import BoolArray
from pytest_dvp.logs.log_contents import FloatArray

WORST = 3  # segments and places named for a channel
PLACES = 8  # cells along the longer side of the map
LEAST_TIME = 0.002  # share of the time below which a group is not worth a line


@dataclasses.dataclass(frozen=True, slots=True)
class Where:
    """share_of_error: of the channel's squared residuals; share_of_time: of its samples; both 0..1.

    kind: "regime", "speed", "segment" or "place"; groups of one kind do not add up to 1 where they overlap.
    """

    channel: str
    regime: str
    share_of_error: float
    share_of_time: float
    kind: str = "regime"

    @property
    def excess(self) -> float:
        """Share of the error beyond the share of the time."""
        return self.share_of_error - self.share_of_time

    def as_dict(self) -> dict[str, Any]:
        """The entry of `compare --json`."""
        return {
            "channel": self.channel,
            "regime": self.regime,
            "share_of_error": self.share_of_error,
            "share_of_time": self.share_of_time,
        }


def locate(
    residuals: Mapping[str, FloatArray],
    chi2: Mapping[str, float],
    regimes: Mapping[str, BoolArray],
    t: FloatArray,
    v: FloatArray,
    xy: tuple[FloatArray, FloatArray] | None,
    segments: Segments,
) -> tuple[Where, ...]:
    """All groups worth a line, those that hold most error for their time first, channels far off before near ones.

    residuals (n,) by channel (NaN = not compared) with their chi^2/N; regimes: masks (n,) by name; t (n,) [s];
    v (n,) [m/s]; xy: map position (n,), (n,) [m] if measured.
    """
    groups: list[tuple[str, str, BoolArray]] = [("regime", name, mask) for name, mask in regimes.items()]
    groups += [("speed", name, mask) for name, mask in speed_bins(v).items()]
    pieces = _segments(segments, t)
    cells = _places(*xy) if xy is not None else None
    worst = max((value for value in chi2.values() if np.isfinite(value)), default=1.0)
    found: list[tuple[float, Where]] = []
    for channel, values in residuals.items():
        known = np.isfinite(values)
        power = np.where(known, values, 0.0) ** 2
        total, samples = float(power.sum()), int(known.sum())
        if total <= 0.0 or samples == 0:
            continue
        entries = [
            Where(channel, name, float(power[mask].sum()) / total, float(known[mask].sum()) / samples, kind)
            for kind, name, mask in groups
        ]
        entries += _top(channel, "segment", *pieces, power, known)
        if cells is not None:
            entries += _top(channel, "place", *cells, power, known)
        rank = (min(max(chi2.get(channel, 1.0), 0.0), worst) / worst) ** 0.5 if worst > 0.0 else 1.0
        found += [(entry.excess * rank, entry) for entry in entries if entry.share_of_time >= LEAST_TIME]
    found.sort(key=lambda pair: (-pair[0], pair[1].channel, pair[1].regime))
    return tuple(entry for _, entry in found)


def _top(
    channel: str, kind: str, index: FloatArray, names: Sequence[str], power: FloatArray, known: BoolArray
) -> list[Where]:
    """The groups of a partition (index (n,), -1 = none) that hold most error for their time."""
    inside = index >= 0
    place = index[inside].astype(np.int64)
    error = np.bincount(place, weights=power[inside], minlength=len(names)) / power.sum()
    time = np.bincount(place, weights=known[inside].astype(np.float64), minlength=len(names)) / known.sum()
    order = np.argsort(-(error - time), kind="stable")[:WORST]
    return [Where(channel, names[k], float(error[k]), float(time[k]), kind) for k in order if error[k] > time[k]]


def _segments(segments: Segments, t: FloatArray) -> tuple[FloatArray, list[str]]:
    index = np.zeros(len(t))
    names = []
    for j, (first, end) in enumerate(zip(segments.starts, segments.ends, strict=True)):
        index[first:end] = j
        names.append(f"segment {t[first]:.1f}-{t[end - 1]:.1f} s")
    return index, names


def _places(x: FloatArray, y: FloatArray) -> tuple[FloatArray, list[str]]:
    """Square cells of a round size."""
    index = np.full(len(x), -1.0)
    known = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return index, []
    size = max(float(np.ptp(x[known])), float(np.ptp(y[known])), 1e-6) / PLACES
    magnitude = 10.0 ** np.floor(np.log10(size))
    side = next(m for m in (1.0, 2.0, 5.0, 10.0) if m * magnitude >= size) * magnitude
    column, row = np.floor(x[known] / side), np.floor(y[known] / side)
    cells, inverse = np.unique(np.column_stack([column, row]), axis=0, return_inverse=True)
    index[known] = inverse.reshape(-1)
    names = [
        f"place x {side * c:g}..{side * (c + 1):g}, y {side * r:g}..{side * (r + 1):g} m" for c, r in cells.tolist()
    ]
    return index, names
