"""What an error that no effect explains looks like: what it follows, its rhythm, its trend, and where it comes back."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pytest_dvp.log import FloatArray
from pytest_dvp.reality_gap.error_terms import READINGS, Axis, Term, terms
from pytest_dvp.reality_gap.experiment import Campaign, Experiment, Values
from pytest_dvp.reality_gap.motion import Motion, bridged, mean_around, motion
from pytest_dvp.reality_gap.projection import BoolArray
from pytest_dvp.reality_gap.regimes import speed_bins
from pytest_dvp.reality_gap.rhythm import Peak, peaks
from pytest_dvp.reality_gap.segments import CHANNELS

MISFIT = 1.5  # chi^2/N of a channel that is told
MOST = 3  # terms of an axis
WORTH = 0.05  # of the excess error on segments left out, for a further term
READ = 0.15  # of it, for a term to be read as an explanation
_NEAR = 0.92  # of the best score: the term with fewer columns is taken
_ELSEWHERE = 4  # alternatives that are told
_FOLDS = 5
_CELLS = 8  # along the longer side of the map
_AXES: Mapping[Axis, tuple[str, ...]] = {"longitudinal": ("v", "ax"), "lateral": ("yaw_rate", "yaw", "ay")}
WITH_FOUND, AS_GIVEN = "with the effects found", "model as given"
_CRAWL = 2.0  # m/s, below which a yaw rate says little of an angle


def signature(target: Campaign, values: Values) -> dict[str, Any]:
    """What is left unexplained with `values`, as a JSON-able document; empty if every channel is explained.

    channels: chi^2/N of those above 1.5, worst first. axes ("longitudinal", "lateral"), worst first, each with
    basis: what the error is judged on, the model with the effects of `values` or as it was given, whichever leaves less
    once the regressors are in it (a wrong effect bends an error out of its shape).
    regressors: up to 3 terms by forward selection with the share of the excess error (chi^2 - N of the channels named)
    that they explain together, on the segments fitted and on segments left out; alternatives to the first one; rhythm:
    peak over time [Hz] and over distance [1/m]; trend over time; share of the error that comes back at the same place,
    and in the same direction of travel; the worst speed bin. reading, look_at: one sentence, and what to examine.

    A term is judged in acceleration or road-wheel angle, integrated where the channel is (speed, yaw): noise is then
    white, as measured. Shares on segments left out may be negative: such a term explains nothing.
    """
    wrong = _wrong(target.by_channel(values))
    if not wrong:
        return {}
    motions = [motion(e.log, e.model) for e in target.experiments]
    own = {a.name for e in target.experiments for a in e.model.effects} | {"inputs", "parameters"}
    given = {key: value for key, value in values.items() if key[0] in own}
    bases = [(WITH_FOUND, values)] if given == dict(values) else [(WITH_FOUND, values), (AS_GIVEN, given)]
    axes = []
    for axis, channels in _AXES.items():
        if set(channels) & set(wrong):
            entries = [_axis(axis, name, target, some, motions) for name, some in bases]
            axes.append(min(entries, key=lambda entry: entry["chi2_per_n_with_regressors"]))
    axes.sort(key=lambda entry: -max(wrong.get(c, 0.0) for c in entry["channels"]))
    first = axes[0] if axes else None
    return {
        "channels": wrong,
        "axes": axes,
        "reading": first["reading"] if first else f"error in {next(iter(wrong))} that speed and yaw rate do not show",
        "look_at": first["look_at"] if first else "the sensor of that channel",
    }


def _wrong(chi2: Mapping[str, float]) -> dict[str, float]:
    return {c: chi2[c] for c in sorted(chi2, key=lambda c: -chi2[c]) if chi2[c] > MISFIT}


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class _Sums:
    """Normal equations by segment: a (m, p, p), b (m, p); chi2 (m,), count (m,) of samples; fold (m,); slices by term."""

    a: FloatArray
    b: FloatArray
    chi2: FloatArray
    count: FloatArray
    fold: FloatArray
    places: tuple[slice, ...]

    @property
    def excess(self) -> float:
        return max(float(self.chi2.sum() - self.count.sum()), 1e-9)

    def fitted(self, chosen: Sequence[int]) -> tuple[float, FloatArray]:
        """Share of the excess that terms explain, and their coefficients."""
        own = self._columns(chosen)
        a, b = self.a.sum(axis=0)[np.ix_(own, own)], self.b.sum(axis=0)[own]
        theta = _solved(a, b)
        return float(2.0 * theta @ b - theta @ a @ theta) / self.excess, theta

    def held_out(self, chosen: Sequence[int]) -> float:
        """Share of the excess that terms explain on segments which they were not fitted on."""
        own = self._columns(chosen)
        a, b = self.a[:, own][:, :, own], self.b[:, own]
        total_a, total_b, gain = a.sum(axis=0), b.sum(axis=0), 0.0
        for fold in np.unique(self.fold):
            out = self.fold == fold
            a_out, b_out = a[out].sum(axis=0), b[out].sum(axis=0)
            theta = _solved(total_a - a_out, total_b - b_out)
            gain += float(2.0 * theta @ b_out - theta @ a_out @ theta)
        return gain / self.excess

    def _columns(self, chosen: Sequence[int]) -> list[int]:
        return [k for term in chosen for k in range(self.places[term].start, self.places[term].stop)]


def _solved(a: FloatArray, b: FloatArray) -> FloatArray:
    scale = np.sqrt(np.maximum(np.diag(a), 1e-30))
    scaled = a / np.outer(scale, scale) + 1e-6 * np.eye(len(b))
    return np.asarray(np.linalg.solve(scaled, b / scale) / scale)


def _axis(axis: Axis, basis: str, target: Campaign, values: Values, motions: Sequence[Motion]) -> dict[str, Any]:
    rest = [e.residuals(values).values for e in target.experiments]
    series = [_series(axis, e, r, m) for e, r, m in zip(target.experiments, rest, motions, strict=True)]
    rhythm = peaks(series, [m.t for m in motions], [m.way for m in motions])
    tried = terms(axis, motions, [(p.kind, p.frequency) for p in rhythm])
    sums = _sums(axis, target, rest, motions, tried)
    names = tried[0]
    alone = [sums.held_out([k]) for k in range(len(names))]
    chosen: list[int] = []
    told: list[dict[str, Any]] = []
    so_far = 0.0
    while len(chosen) < MOST:
        scores = [sums.held_out([*chosen, k]) if k not in chosen else -np.inf for k in range(len(names))]
        best = max(scores)
        if best - so_far < WORTH:
            break
        near = [k for k, s in enumerate(scores) if s - so_far >= _NEAR * (best - so_far)]
        k = min(near, key=lambda i: (names[i].columns.shape[1], -scores[i]))
        chosen.append(k)
        share, theta = sums.fitted(chosen)
        told.append({"term": names[k].name, "key": names[k].key, "share": share, "held_out_share": scores[k],
                     "coefficient": float(theta[-1])})  # fmt: skip
        so_far = scores[k]
    others = sorted((k for k in range(len(names)) if not chosen or names[k].key != names[chosen[0]].key),
                    key=lambda k: -alone[k])  # fmt: skip
    place, heading = _place(series, motions), _direction(series, motions)
    entry: dict[str, Any] = {
        "axis": axis,
        "basis": basis,
        "channels": {c: value for c, value in target.by_channel(values).items() if c in _AXES[axis]},
        "chi2_per_n_with_regressors": float(sums.chi2.sum() - so_far * sums.excess) / max(float(sums.count.sum()), 1.0),
        "regressors": told,
        "alternatives": [{"term": names[k].name, "held_out_share": alone[k]} for k in _distinct(others, names)],
        "rhythm": {p.kind: {"frequency": p.frequency, "unit": p.unit, "share": p.share} for p in rhythm},
        "trend": _trend(target, sums),
        "same_place": place,
        "same_direction": heading,
        "speed": _speed(series, motions),
    }
    entry["reading"], entry["look_at"] = _read(axis, told, rhythm, place, entry["speed"])
    return entry


def _distinct(order: Sequence[int], names: Sequence[Term]) -> list[int]:
    """The first of each family."""
    found: dict[str, int] = {}
    for k in order:
        found.setdefault(names[k].key, k)
    return list(found.values())[:_ELSEWHERE]


def _series(axis: Axis, e: Experiment, rest: FloatArray, m: Motion) -> FloatArray:
    """The error (n,) as an acceleration [m/s^2] or a road-wheel angle [rad]; 0 where it is not known."""
    def of(name: str) -> FloatArray:
        return rest[:, CHANNELS.index(name)]

    if axis == "longitudinal":
        found = of("ax") if "ax" in e.channels else _slope(e, of("v"), m)
    else:
        rate = of("yaw_rate") if "yaw_rate" in e.channels else _slope(e, of("yaw"), m)
        v = np.where(np.abs(m.v) > _CRAWL, m.v, np.inf)
        found = rate * m.wheelbase / v
    return np.where(np.isfinite(found) & m.moving, found, 0.0)


def _slope(e: Experiment, values: FloatArray, m: Motion) -> FloatArray:
    """Time derivative of a residual within its segments, over about 0.3 s."""
    found = np.full(len(values), np.nan)
    window = max(1, round(0.15 / m.step))
    for first, end in zip(e.segments.starts, e.segments.ends, strict=True):
        if end - first > 4 * window:
            found[first:end] = np.gradient(mean_around(bridged(m.t[first:end], values[first:end]), window),
                                           m.t[first:end])  # fmt: skip
    return found


def _sums(axis: Axis, target: Campaign, rest: Sequence[FloatArray], motions: Sequence[Motion],
          tried: Sequence[Sequence[Term]]) -> _Sums:  # fmt: skip
    a, b, chi2, count = [], [], [], []
    for e, r, m, own in zip(target.experiments, rest, motions, tried, strict=True):
        phi = np.concatenate([t.columns for t in own], axis=1)
        if axis == "lateral":
            phi = phi * (m.v / m.wheelbase)[:, None]
        rows = list(_channels(axis, e, r, m, phi))
        for first, end in zip(e.segments.starts, e.segments.ends, strict=True):
            aa, bb, cc, nn = np.zeros((phi.shape[1],) * 2), np.zeros(phi.shape[1]), 0.0, 0.0
            for y, x, free_start in rows:
                known = np.isfinite(y[first:end])
                yy, xx = y[first:end][known], x[first:end][known]
                if not len(yy):
                    continue
                nn += len(yy)
                cc += float(yy @ yy)
                if free_start:
                    cc -= len(yy) * float(yy.mean()) ** 2
                    yy, xx = yy - yy.mean(), xx - xx.mean(axis=0)
                aa += xx.T @ xx
                bb += xx.T @ yy
            a.append(aa)
            b.append(bb)
            chi2.append(cc)
            count.append(nn)
    ends = np.cumsum([t.columns.shape[1] for t in tried[0]])
    places = tuple(slice(int(end) - t.columns.shape[1], int(end)) for end, t in zip(ends, tried[0], strict=True))
    return _Sums(np.array(a), np.array(b), np.array(chi2), np.array(count), np.arange(len(a)) % _FOLDS, places)


def _channels(axis: Axis, e: Experiment, rest: FloatArray, m: Motion,
              phi: FloatArray) -> Iterator[tuple[FloatArray, FloatArray, bool]]:  # fmt: skip
    """Whitened residual (n,), what the terms do to it (n, p), and whether its start is free; of each channel."""
    integral = np.cumsum(phi * np.append(np.diff(m.t), 0.0)[:, None], axis=0)
    whole: tuple[str, ...] = ("ax",) if axis == "longitudinal" else ("yaw_rate",)
    summed = "v" if axis == "longitudinal" else "yaw"
    for name in (*whole, summed):
        if name in e.channels:
            k = CHANNELS.index(name)
            yield rest[:, k] / e.sigma[k], (integral if name == summed else phi) / e.sigma[k], name == summed


def _trend(target: Campaign, sums: _Sums) -> dict[str, float]:
    """Rank correlation of a segment's error with its time, -1..1, weighted over the logs; and how much is in the
    second half of each."""
    size = np.maximum(sums.chi2 - sums.count, 0.0) / np.maximum(sums.count, 1.0)
    found, weights, late, offset = [], [], 0.0, 0
    for e in target.experiments:
        m = len(e.segments.starts)
        own = size[offset : offset + m]
        offset += m
        if m < 4 or not own.any():
            continue
        ranks = np.argsort(np.argsort(own, kind="stable"), kind="stable")
        found.append(float(np.corrcoef(np.arange(m), ranks)[0, 1]))
        weights.append(float(own.sum()))
        late += float(own[m // 2 :].sum())
    if not found:
        return {"rank_correlation": 0.0, "share_in_second_half": 0.5}
    return {"rank_correlation": float(np.average(found, weights=weights)),
            "share_in_second_half": late / sum(weights)}  # fmt: skip


def _place(series: Sequence[FloatArray], motions: Sequence[Motion]) -> float | None:
    """Share of the smoothed error that is the same whenever the car comes back to a place; None if it never does."""
    x, y = (np.concatenate([getattr(m, name) for m in motions]) for name in ("x", "y"))
    side = max(float(np.ptp(x)), float(np.ptp(y)), 1e-6) / _CELLS / 4.0
    cell = np.unique(np.floor(np.column_stack([x, y]) / side), axis=0, return_inverse=True)[1].reshape(-1)
    return _comes_back(series, motions, cell)


def _direction(series: Sequence[FloatArray], motions: Sequence[Motion]) -> float | None:
    """Share of the smoothed error that is the same whenever the car travels in the same direction."""
    yaw = np.concatenate([m.yaw for m in motions])
    return _comes_back(series, motions, np.floor((yaw % (2.0 * np.pi)) / (np.pi / 4.0)).astype(np.int64))


def _comes_back(series: Sequence[FloatArray], motions: Sequence[Motion], cell: FloatArray) -> float | None:
    """Each visit of a cell predicted by the mean of the other visits of it (20 s apart at least, or in another log)."""
    offset, visits = 0.0, []
    start = 0
    for error, m in zip(series, motions, strict=True):
        smooth = mean_around(error, max(1, round(0.25 / m.step)))
        own = cell[start : start + len(m.t)]
        start += len(m.t)
        cuts = np.flatnonzero(np.diff(own)) + 1
        for first, end in zip([0, *cuts], [*cuts, len(own)], strict=True):
            if m.moving[first:end].any() and end - first > 3:
                visits.append((int(own[first]), offset + float(m.t[first]), end - first,
                               float(smooth[first:end].mean())))  # fmt: skip
        offset += float(m.t[-1]) + 1e6
    left = total = 0.0
    for k, when, rows, value in visits:
        others = [(r, w) for c, t, r, w in visits if c == k and abs(t - when) > 20.0]
        if others:
            mean = sum(r * w for r, w in others) / sum(r for r, _ in others)
            total += rows * value * value
            left += rows * (value - mean) ** 2
    return 1.0 - left / total if total > 0.0 and len(visits) >= 6 else None


def _speed(series: Sequence[FloatArray], motions: Sequence[Motion]) -> dict[str, Any]:
    error, v = np.concatenate(list(series)) ** 2, np.concatenate([m.v for m in motions])
    moving = np.concatenate([m.moving for m in motions])
    bins: dict[str, BoolArray] = speed_bins(v)
    total = max(float(error[moving].sum()), 1e-30)
    found = [(float(error[mask & moving].sum()) / total, float((mask & moving).sum()) / max(int(moving.sum()), 1), name)
             for name, mask in bins.items()]  # fmt: skip
    share, time, name = max(found, key=lambda f: f[0] - f[1])
    return {"bin": name, "share_of_error": share, "share_of_time": time}


def _read(axis: Axis, told: Sequence[Mapping[str, Any]], rhythm: Sequence[Peak], place: float | None,
          speed: Mapping[str, Any]) -> tuple[str, str]:  # fmt: skip
    if told and told[0]["held_out_share"] >= READ:
        first = told[0]
        says, look = READINGS[first["key"]]
        more = ""
        if first["key"] in ("speed_passed", "steer_rings", "drive_rings", "wave_time", "wave_distance"):
            more = f" ({first['term']})"
        return (f"{axis} error {says}{more}, {100.0 * first['held_out_share']:.0f} % of it on segments left out", look)
    if place is not None and place > 0.5:
        says, look = READINGS["place"]
        return f"{axis} error {says}, {100.0 * place:.0f} % of it", look
    if rhythm and rhythm[0].share > 0.2:
        p = rhythm[0]
        says, look = READINGS[f"wave_{p.kind}"]
        return f"{axis} error {says}: {p.frequency:.3g} {p.unit}", look
    return (f"{axis} error that no term of the list explains, most of it at {speed['bin']}",
            "the worst segments, beside a video or the driver's notes")  # fmt: skip
