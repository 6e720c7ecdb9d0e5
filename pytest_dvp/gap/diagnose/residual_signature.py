"""What an error that no effect explains looks like: what it follows, its rhythm, its trend, and where it comes back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.compare.smoothed_motion import Motion, bridged, mean_around, motion
from pytest_dvp.gap.diagnose.experiment import Experiment, ExperimentSet, Values
from pytest_dvp.gap.diagnose.residual_recurrence import at_same_place, at_speed, in_same_direction, over_time
from pytest_dvp.gap.diagnose.residual_regression import TermSums, term_sums
from pytest_dvp.gap.diagnose.residual_spectrum import Peak, peaks
from pytest_dvp.gap.diagnose.residual_terms import READINGS, Axis, Term, terms
from pytest_dvp.logs.log_contents import FloatArray

MISFIT = 1.5  # chi^2/N of a channel that is told
MOST = 3  # terms of an axis
WORTH = 0.05  # of the excess error on segments left out, for a further term
READ = 0.15  # of it, for a term to be read as an explanation
SLIDES = 0.12  # rad between where the rear axle points and where it goes
WITH_FOUND, AS_GIVEN = "with the effects found", "model as given"
_NEAR = 0.05  # of max(1, chi^2/N) worse than the best term: then the one with fewer columns is taken
_ELSEWHERE = 4  # alternatives that are told
_CRAWL = 2.0  # m/s, below which a yaw rate says little of an angle; of a small car
_CRAWL_SHARE = 0.25  # of its usual top speed, if that is less
_AXES: Mapping[Axis, tuple[str, ...]] = {"longitudinal": ("v", "ax"), "lateral": ("yaw_rate", "yaw", "ay")}
_NUMBERED = ("speed_passed", "steer_rings", "drive_rings", "wave_time", "wave_distance")


def signature(target: ExperimentSet, values: Values) -> dict[str, Any]:
    """What is left unexplained with `values`, as a JSON-able document; empty if every channel is explained.

    channels: chi^2/N of those above 1.5, worst first. axes ("longitudinal", "lateral"), worst first, each with
    basis: what the error is judged on, the model with the effects of `values` or as it was given, whichever leaves less
    once the regressors are in it (a wrong effect bends an error out of its shape);
    chi2_per_n of what is judged (lateral: at the measured speed), with and without the regressors;
    regressors: up to 3 terms by forward selection with the share of the excess error (chi^2 - N) that they explain
    together, on the segments fitted and on segments left out (a negative share: worse than nothing);
    alternatives to the first one; rhythm: peak over time [Hz] and over distance [1/m], the sharper first; trend over
    time; share of the error that comes back at the same place, and in the same direction of travel; worst speed bin;
    slip [rad]: between the heading and the direction of motion, 99th percentile (lateral).
    reading, look_at: one sentence, and what to examine.

    Terms are regressions on measured motion: they say what an error goes along with, not what causes it.
    """
    chi2 = target.by_channel(values)
    wrong = {c: chi2[c] for c in sorted(chi2, key=lambda c: -chi2[c]) if chi2[c] > MISFIT}
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
            axes.append(min(entries, key=lambda entry: float(entry["chi2_per_n_with_regressors"])))
    axes.sort(key=lambda entry: -max(wrong.get(c, 0.0) for c in _AXES[entry["axis"]]))
    sensor = next(iter(wrong))
    return {
        "channels": wrong,
        "axes": axes,
        "reading": axes[0]["reading"] if axes else f"error in {sensor} that neither speed nor yaw rate shows",
        "look_at": axes[0]["look_at"] if axes else f"the sensor of {sensor}",
    }


def _axis(axis: Axis, basis: str, target: ExperimentSet, values: Values, motions: Sequence[Motion]) -> dict[str, Any]:
    rest = [e.residuals(values).values for e in target.experiments]
    if axis == "lateral":
        rest = [_at_measured_speed(r, m) for r, m in zip(rest, motions, strict=True)]
    errors = [_error(axis, e, r, m) for e, r, m in zip(target.experiments, rest, motions, strict=True)]
    rhythm = peaks(errors, [m.t for m in motions], [m.way for m in motions])
    steer = target.experiments[0].model.inputs.steer
    tried = terms(axis, motions, [(p.kind, p.frequency) for p in rhythm], steer)
    sums = term_sums(axis, target, rest, motions, tried)
    chosen, told = _selected(sums, tried[0])
    others = _others(sums, tried[0], chosen)
    excess = np.maximum(sums.chi2 - sums.count, 0.0) / np.maximum(sums.count, 1.0)
    ends = np.cumsum([len(e.segments.starts) for e in target.experiments])
    entry: dict[str, Any] = {
        "axis": axis,
        "basis": basis,
        "channels": {c: value for c, value in target.by_channel(values).items() if c in _AXES[axis]},
        "chi2_per_n": sums.left(0.0),
        "chi2_per_n_with_regressors": sums.left(told[-1]["held_out_share"] if told else 0.0),
        "regressors": told,
        "alternatives": others,
        "rhythm": [{"over": p.kind, "frequency": p.frequency, "unit": p.unit, "share": p.share} for p in rhythm],
        "trend": over_time(np.split(excess, ends[:-1])),
        "same_place": at_same_place(errors, motions),
        "same_direction": in_same_direction(errors, motions),
        "speed": at_speed(errors, motions),
    }
    if axis == "lateral":
        entry["slip"] = max(_slip(m) for m in motions)
    entry["reading"], entry["look_at"] = _read(entry, rhythm)
    return entry


def _selected(sums: TermSums, names: Sequence[Term]) -> tuple[list[int], list[dict[str, Any]]]:
    """Forward selection on segments left out."""
    chosen: list[int] = []
    told: list[dict[str, Any]] = []
    so_far = 0.0
    while len(chosen) < MOST:
        gains = [-np.inf if k in chosen else sums.held_out([*chosen, k]) - so_far for k in range(len(names))]
        best = max(gains)
        if best < WORTH:
            break
        left = sums.left(so_far + best)
        near = [k for k, gain in enumerate(gains) if sums.left(so_far + gain) - left < _NEAR * max(1.0, left)]
        k = min(near, key=lambda i: (names[i].columns.shape[1], -gains[i]))
        chosen.append(k)
        so_far += gains[k]
        share, theta = sums.fitted(chosen)
        told.append({"term": names[k].name, "key": names[k].key, "share": min(share, 1.0),
                     "held_out_share": min(so_far, 1.0),
                     "coefficient": float(theta[-1])})  # fmt: skip
    return chosen, told


def _others(sums: TermSums, names: Sequence[Term], chosen: Sequence[int]) -> list[dict[str, Any]]:
    """What else explains something on its own, one of each family."""
    best: dict[str, tuple[float, str]] = {}
    first = names[chosen[0]].key if chosen else ""
    for k, term in enumerate(names):
        share = min(sums.held_out([k]), 1.0)
        if share > WORTH and term.key != first and share > best.get(term.key, (0.0, ""))[0]:
            best[term.key] = share, term.name
    ranked = sorted(best.values(), key=lambda pair: -pair[0])[:_ELSEWHERE]
    return [{"term": name, "held_out_share": share} for share, name in ranked]


def _error(axis: Axis, e: Experiment, rest: FloatArray, m: Motion) -> FloatArray:
    """The error (n,) as an acceleration [m/s^2] or a road-wheel angle [rad]; 0 where it is not known."""
    direct, summed = ("ax", "v") if axis == "longitudinal" else ("yaw_rate", "yaw")
    found = rest[:, CHANNELS.index(direct)] if direct in e.channels else _slope(e, rest[:, CHANNELS.index(summed)], m)
    if axis == "lateral":
        found = found * m.wheelbase / np.where(np.abs(m.v) > _crawl(m), m.v, np.inf)
    return np.where(np.isfinite(found) & m.moving, found, 0.0)


def _at_measured_speed(rest: FloatArray, m: Motion) -> FloatArray:
    """Residuals (n, 8) without what a wrong speed does to yaw rate and yaw: a car that is too fast turns too fast."""
    found = rest.copy()
    slow = np.abs(m.v) < _crawl(m)
    turned = np.where(np.isfinite(rest[:, 3]) & ~slow, rest[:, 3] * m.yaw_rate / np.where(slow, 1.0, m.v), 0.0)
    found[:, 4] -= turned
    found[:, 2] -= np.cumsum(turned * np.append(np.diff(m.t), 0.0))
    return found


def _slope(e: Experiment, values: FloatArray, m: Motion) -> FloatArray:
    """Time derivative of a residual within its segments, over about 0.3 s."""
    found = np.full(len(values), np.nan)
    window = max(1, round(0.15 / m.step))
    for first, end in zip(e.segments.starts, e.segments.ends, strict=True):
        if end - first > 4 * window:
            t = m.t[first:end]
            found[first:end] = np.gradient(mean_around(bridged(t, values[first:end]), window), t)
    return found


def _crawl(m: Motion) -> float:
    return min(_CRAWL, _CRAWL_SHARE * float(np.quantile(np.abs(m.v), 0.95)))


def _slip(m: Motion) -> float:
    """99th percentile of the angle [rad] between heading and motion, ahead or astern, not at a crawl; 0 without
    positions."""
    window = max(1, round(0.2 / m.step))
    vx, vy = (np.gradient(mean_around(p, window), m.t) for p in (m.x, m.y))
    fast = np.hypot(vx, vy) > _crawl(m)
    astern = np.where(m.v < 0.0, np.pi, 0.0)
    angle = np.angle(np.exp(1j * (np.arctan2(vy, vx) - m.yaw - astern)))[fast]
    return float(np.percentile(np.abs(angle), 99.0)) if len(angle) > 50 else 0.0


def _read(entry: Mapping[str, Any], rhythm: Sequence[Peak]) -> tuple[str, str]:
    axis, told, place = entry["axis"], entry["regressors"], entry["same_place"]
    slip = float(entry.get("slip", 0.0))
    if axis == "lateral" and entry["chi2_per_n"] < MISFIT and not told:
        return "lateral error that follows from the wrong speed", "what is said of the longitudinal error"
    if told and told[0]["held_out_share"] >= READ and not (slip > SLIDES and told[-1]["held_out_share"] < 0.5):
        first = told[0]
        says, look = READINGS[first["key"]]
        more = f" ({first['term']})" if first["key"] in _NUMBERED else ""
        return f"{axis} error {says}{more}; {100.0 * first['held_out_share']:.0f} % of it on segments left out", look
    if slip > SLIDES:
        return (
            f"{axis} error where the car slides: it moves up to {slip:.2f} rad off its heading",
            "grip of the tyres and the road, a spin; `dvp compare` says when: cut it out with LOG@from:to",
        )
    if place is not None and place > 0.5:
        says, look = READINGS["place"]
        return f"{axis} error {says}, {100.0 * place:.0f} % of it", look
    if rhythm and rhythm[0].share > 0.2:
        says, look = READINGS[f"wave_{rhythm[0].kind}"]
        return f"{axis} error {says}: {rhythm[0].frequency:.3g} {rhythm[0].unit}", look
    return (f"{axis} error that no term of the list explains, most of it at {entry['speed']['bin']}",
            "the worst segments, beside a video or the driver's notes")  # fmt: skip
