"""Re-initialised segments: the error a model makes in about five seconds, whatever pose and speed it started with.

A model that drives a whole log open loop is judged by its first error: half a degree becomes 50 m. So the motion is set
to the measured one every few seconds. The measured start is noisy; what a wrong start (x, y, yaw, speed) does to each
signal is known to first order from the modelled motion itself, and the start that suits the segment best is taken out
by weighted least squares, without another simulation. This is the objective of a diagnosis, called thousands of times.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping

import numpy as np

from pytest_dvp.gap.compare.heading_check import heading_faults
from pytest_dvp.gap.compare.start_correction import BoolArray, IntArray, project
from pytest_dvp.gap.compare.wheel_lock import locked
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.lost_fix import AFFECTED, SIGMA, lost_fix

CHANNELS = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")
"""Columns of a replay's output, and of everything here that has 8 columns."""

UNITS: Mapping[str, str] = {
    "x": "m", "y": "m", "yaw": "rad", "v": "m/s", "yaw_rate": "rad/s", "ax": "m/s^2", "ay": "m/s^2", "steer": "rad",
}  # fmt: skip

LENGTH = 5.0  # s
_GAP = 0.1  # s, and
_GAP_STEPS = 5.0  # usual steps without a value are a gap, after which a segment starts anew
AWAKE = 0.5  # s after a gap or a start on the move that do not count, of a short segment a quarter: actuators still do
# what was before it
_SETTLE = 1.0  # s of a standstill that still counts, at both ends: a late or early start shows there
_COURSE = 0.2  # s to either side, over which the direction of motion is taken
_GOES = 1.0  # m/s, from which on a path tells where a car points; chosen: twice the noise of a GNSS in 0.5 s
_SLIP = 0.3  # rad between where a car points and where it goes, that no wheel on the road allows
_FAST = 3.0  # m/s, below which an antenna off the axle can do the same
_FOREMOST = 1.3  # wheelbases ahead of the rear axle, at most, is an antenna: the front bumper of a lorry or a car
_FIT = 0.15  # s around a start from which its state is taken


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Segments:
    """How a log is cut: starts, ends (m,) row numbers (end excluded); states (m, 6) at the starts: x, y [m], yaw [rad],
    v, vy [m/s] (NaN: runs on, no log has it), yaw_rate [rad/s]; counted (n,): rows that count (not a standstill,
    not a spin); lost (n,): rows in which something is missing; slides (n,): rows in which the car slides or spins, or
    its wheels lock; abandoned (n,): those that do not count for it."""

    starts: IntArray
    ends: IntArray
    states: FloatArray
    counted: BoolArray
    lost: BoolArray
    slides: BoolArray
    abandoned: BoolArray


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Residuals:
    """values (n, 8) measured - model with the best start, NaN where nothing was compared; chi2 (8,) mean square of
    values/sigma of each channel (NaN without samples); count (8,) samples; start (m, 4) what the best start differs by
    in x, y [m], yaw [rad], v [m/s]; total: mean square over all channels."""

    values: FloatArray
    chi2: FloatArray
    count: IntArray
    start: FloatArray
    total: float


def measured_array(columns: Mapping[str, FloatArray]) -> FloatArray:
    """The measured channels of a log as one array (n, 8), NaN where not measured; yaw without turns of 2 pi.

    Columns: x, y [m], yaw [rad], v [m/s], yaw_rate [rad/s], ax, ay [m/s^2], steer [rad]. Place, heading and speed count
    as not measured where the reference system states that it lost its fix (`position_sigma`).
    """
    n = len(columns["t"])
    nothing = np.full(n, np.nan)
    found = np.ascontiguousarray(np.column_stack([columns.get(name, nothing) for name in CHANNELS]))
    if SIGMA in columns:
        lost = lost_fix(columns)
        for name in AFFECTED:
            found[lost, CHANNELS.index(name)] = np.nan
    known = np.isfinite(found[:, 2])
    found[known, 2] = np.unwrap(found[known, 2])
    return found


def cut(t: FloatArray, measured: FloatArray, *, length: float = LENGTH, wheelbase: float = 2.5,
        known: Iterable[BoolArray] = (), given: Iterable[BoolArray] = (),
        unheeded: BoolArray | None = None) -> Segments:  # fmt: skip
    """Cut a log of stamps t (n,) [s] and measured channels (n, 8) into segments of about `length` [s].

    A cut is put where the car turns least within half a second, so that the sideways motion has nothing to settle.
    `wheelbase` [m] says which yaw rate is a spin. Rows of a standstill but its first and last second do not count, nor
    those from a spin, a slide or locked wheels to the end of its segment.
    After a gap, in which there are no stamps, nothing is measured or a command is missing (`known`: rows (n,) in which
    each command was logged), a segment starts anew. Rows whose command is unknown do not count, nor the first after it.
    The same holds for a hole in what a start needs, by the usual step of that channel: without yaw, v or yaw_rate rows
    do not count until it is back; x and y are needed by nothing but themselves. `given` (n,): rows a second log has.
    `unheeded` (n,): rows in which the car did not obey what drives the model, which never count.
    """
    n = len(t)
    whole = filled(t, measured)
    v, rate = whole[:, 3], whole[:, 4]
    holes = [_gaps(t, np.asarray(np.isfinite(measured[:, k]))) for k in range(5)]
    posed: BoolArray = np.isfinite(measured[:, :3]).any(axis=0).all() & ~np.logical_or.reduce(
        [missing for _, missing in holes[:3]]
    )
    # Beside a hole or a pause, the direction of the path is that of the straight line over it
    ahead, behind = _around(t)
    posed &= posed[ahead] & posed[behind] & (t[ahead] - t[behind] <= 2.0 * _COURSE + longest_step(t))
    unknown = not has_speed(measured)  # nor can it be said then where the car stands or spins
    slides = np.zeros(n, dtype=np.bool_) if unknown else _slides(t, whole, wheelbase, posed=posed)
    # Nothing where v follows from the path: it is the speed over ground itself
    slides |= locked(t, v, _over_ground(t, whole), posed & ~holes[3][1])
    near = _near(t, slides)
    counted = np.ones(n, dtype=np.bool_) if unknown else ~standing(t, v)
    count = max(1, round((t[-1] - t[0]) / length))
    wanted = t[0] + (t[-1] - t[0]) * np.arange(1, count) / count
    cuts = [0]
    for time in wanted:
        low, high = np.searchsorted(t, [time - 0.5, time + 0.5])
        best = int(low) + int(np.argmin(np.abs(rate[low:high]))) if high > low else int(low)
        if cuts[-1] + 4 < best < n - 4:
            cuts.append(best)
    lost: BoolArray = np.zeros(n, dtype=np.bool_) if unheeded is None else unheeded.copy()
    every: BoolArray = np.ones(n, dtype=np.bool_)
    # A log that begins on the move is like one after a gap
    awake = {0} if n and not unknown and abs(v[0]) > still_speed(v) else set[int]()
    for rows in [every, *known]:
        resumes, missing = _gaps(t, rows)
        lost |= missing
        awake |= set(resumes)
    seen: BoolArray = np.asarray(np.isfinite(measured).any(axis=1))
    resumed = awake | set(_gaps(t, seen)[0])
    parted = [*holes, *(_gaps(t, rows) for rows in given)]
    resumed |= {row for resumes, _ in parted for row in resumes}
    for _, missing in parted[2:]:
        lost |= missing
    starts = np.union1d(np.array(cuts, dtype=np.int64), np.array(sorted(resumed), dtype=np.int64))
    ends = np.append(starts[1:], n).astype(np.int64)
    abandoned = np.zeros(n, dtype=np.bool_)
    for first, end in zip(starts, ends, strict=True):
        if near[first:end].any():  # where a car goes from there nobody can tell
            abandoned[first + int(np.argmax(near[first:end])) : end] = True
        if int(first) in awake:
            until = t[first] + min(AWAKE, 0.25 * (t[end - 1] - t[first]))
            lost[first : np.searchsorted(t, until)] = True
    counted &= ~abandoned
    for j in np.flatnonzero(heading_faults(t, measured[:, 2], measured[:, 4], starts, ends, counted & ~lost)):
        counted[starts[j] : ends[j]] = False
    return Segments(starts, ends, _states(t, measured, whole, starts), counted & ~lost, lost, slides, abandoned)


def longest_step(t: FloatArray) -> float:
    """Time between stamps t (n,) [s] above which something is missing in between."""
    return max(_GAP, _GAP_STEPS * float(np.median(np.diff(t)))) if len(t) > 1 else _GAP


def _gaps(t: FloatArray, known: BoolArray) -> tuple[list[int], BoolArray]:
    """Rows in which `known` (n,) begins again after a gap, and the rows (n,) of its gaps."""
    missing = np.zeros(len(t), dtype=np.bool_)
    rows = np.flatnonzero(known)
    if len(rows) < 2:
        return [], missing
    longest, usual = longest_step(t[rows]), float(np.median(np.diff(t[rows])))
    since, until = np.append(t[0], t[rows]), np.append(t[rows], t[-1])
    resumes = []
    for j in np.flatnonzero(until - since > longest):
        after = int(rows[j]) if j < len(rows) else len(t)
        before = int(rows[j - 1]) if j else -1
        # A value holds for its usual time
        missing[before + 1 : after] = (t[before + 1 : after] > since[j] + usual) if j else True
        if after < len(t):
            resumes.append(after)
    return resumes, missing


def stands_for(t: FloatArray, known: BoolArray) -> BoolArray:
    """Rows (n,) that the samples of a channel (`known` (n,)) stand for: all but those of its gaps. A slow channel
    has no gaps between its samples, however many stamps t (n,) [s] the log has there."""
    return ~_gaps(t, known)[1] if known.sum() >= 2 else known


def still_speed(v: FloatArray) -> float:
    """Speed [m/s] below which a car counts as standing: 0.3 m/s, less for a small car. v (n,) [m/s]: its speeds."""
    return min(0.3, 0.1 * float(np.quantile(np.abs(v), 0.95)) + 1e-6)


def standing(t: FloatArray, v: FloatArray) -> BoolArray:
    """Rows (n,) of standstills but their first and last second. t (n,) [s], v (n,) [m/s]."""
    return _interior(t, np.abs(v) < still_speed(v))


def residuals(output: FloatArray, measured: FloatArray, t: FloatArray, sigma: FloatArray, segments: Segments,
              *, free_speed: bool = True, slopes: float = 0.0) -> Residuals:  # fmt: skip
    """Residuals of a model's output (n, 8), re-initialised at the segments' starts, against the measured (n, 8).

    sigma (8,) noise of each channel in its unit, inf or NaN for a channel that does not count. `free_speed` False if
    the speed is imposed, so that no wrong start speed is to be taken out. `slopes`: standard deviation [m/s^2] of the
    slope of the road, which is taken out as well; 0: a flat road. t (n,) [s].
    """
    there = np.isfinite(output[:, :5])
    if not there.all():  # what a start does is told by the whole motion; what is not there is not judged
        measured = np.where(np.isfinite(output), measured, np.nan)
        output = np.where(np.isfinite(output), output, filled(t, output))
    weight = np.where(np.isfinite(sigma) & (sigma > 0.0), 1.0 / np.where(sigma > 0.0, sigma, 1.0), 0.0)
    values = np.empty_like(measured)
    start = np.zeros((len(segments.starts), 4))
    chi2, count = np.zeros(8), np.zeros(8, dtype=np.int64)
    project(output, measured, t, weight, segments.starts, segments.ends, segments.counted, free_speed, slopes,
             values, start, chi2, count)  # fmt: skip
    known = int(count.sum())
    total = float(chi2.sum() / known) if known else float("nan")
    mean = np.where(count > 0, chi2 / np.maximum(count, 1), np.nan)
    return Residuals(values, mean, count, start, total)


def restarted(segments: Segments, found: Residuals) -> Segments:
    """The same segments, begun with the start that suited best: a second simulation from there is exact where the
    first order is not, above all in when a car comes to rest."""
    states = segments.states.copy()
    states[:, :4] += found.start
    return dataclasses.replace(segments, states=states)


def posed(output: FloatArray, segments: Segments) -> FloatArray:
    """Output (n, 8) of a model that cannot be restarted, in channel units, with each segment on its measured start.

    A segment is turned and moved as a whole; one without a known pose or start stays where it is.
    """
    moved = output.copy()
    for first, end, state in zip(segments.starts, segments.ends, segments.states, strict=True):
        piece = output[first:end]
        known = np.flatnonzero(np.isfinite(piece[:, :3]).all(axis=1))
        if not len(known) or not np.isfinite(state[:3]).all():
            continue
        x, y, yaw = piece[known[0], :3]
        c, s = np.cos(state[2] - yaw), np.sin(state[2] - yaw)
        dx, dy = piece[:, 0] - x, piece[:, 1] - y
        moved[first:end, 0] = state[0] + c * dx - s * dy
        moved[first:end, 1] = state[1] + s * dx + c * dy
        moved[first:end, 2] = piece[:, 2] + state[2] - yaw
    return moved


def has_speed(measured: FloatArray) -> bool:
    """True if the channels (n, 8), in channel units, hold the speed, or a path from which it follows."""
    there: BoolArray = np.asarray(np.isfinite(measured).any(axis=0))
    return bool(there[3] or there[:2].all())


def filled(t: FloatArray, measured: FloatArray) -> FloatArray:
    """The channels (n, 8) at the stamps t (n,) [s] with gaps bridged by straight lines; zeros where one is not there at
    all, but speed, heading and yaw rate, which then follow from the path over _COURSE to either side."""
    whole: FloatArray = np.zeros(measured.shape)
    there: BoolArray = np.asarray(np.isfinite(measured).any(axis=0))
    for k in np.flatnonzero(there).tolist():
        known = np.isfinite(measured[:, k])
        whole[:, k] = np.interp(t, t[known], measured[known, k])
    placed = bool(there[:2].all())
    if len(t) < 2 or (there[3:5].all() and (there[2] or not placed)):
        return whole
    ahead, behind = _around(t)
    span = t[ahead] - t[behind]
    way = whole[ahead, :3] - whole[behind, :3]
    if not there[3] and placed:
        yaw = whole[:, 2]
        along = way[:, 0] * np.cos(yaw) + way[:, 1] * np.sin(yaw) if there[2] else np.hypot(way[:, 0], way[:, 1])
        whole[:, 3] = along / span
    if not there[2] and placed:
        goes = np.hypot(way[:, 0], way[:, 1]) > _GOES * span
        course = np.arctan2(way[:, 1], way[:, 0]) + np.where(whole[:, 3] < 0.0, np.pi, 0.0)
        if goes.any():
            whole[:, 2] = np.interp(t, t[goes], np.unwrap(course[goes]))
            way[:, 2] = whole[ahead, 2] - whole[behind, 2]
    if not there[4] and (there[2] or placed):
        whole[:, 4] = way[:, 2] / span
    return whole


def _around(t: FloatArray) -> tuple[IntArray, IntArray]:
    """Rows (n,) _COURSE [s] after and before each stamp."""
    ahead = np.minimum(np.searchsorted(t, t + _COURSE), len(t) - 1)
    return ahead, np.maximum(np.searchsorted(t, t - _COURSE) - 1, 0)


def _interior(t: FloatArray, stands: BoolArray) -> BoolArray:
    """True inside runs of `stands`, away from both ends by _SETTLE."""
    inside = np.zeros(len(t), dtype=np.bool_)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], stands.astype(np.int8), [0]]))).reshape(-1, 2)
    for first, end in edges:
        low, high = np.searchsorted(t, [t[first] + _SETTLE, t[end - 1] - _SETTLE])
        inside[low:high] = True
    return inside


def _slides(t: FloatArray, whole: FloatArray, wheelbase: float, *, posed: BoolArray) -> BoolArray:
    """True where the car spins or slides: it turns faster than any steering could make it, or goes where it does not
    point (`posed` (n,): position and heading are measured). In a turn an antenna ahead of the rear axle goes farther
    into the turn than the car points: that is no slide, whose course is farther out."""
    v, rate = whole[:, 3], whole[:, 4]
    ahead, behind = _around(t)
    dx, dy = whole[ahead, 0] - whole[behind, 0], whole[ahead, 1] - whole[behind, 1]
    goes = np.hypot(dx, dy) / np.maximum(t[ahead] - t[behind], 1e-9)
    slip = _folded(np.arctan2(dy, dx) - whole[:, 2], 2.0 * np.pi)
    backwards = np.abs(slip) > 0.5 * np.pi
    aside = np.where(backwards, -_folded(slip, np.pi), slip)
    leads = np.arctan2(np.abs(rate) * _FOREMOST * wheelbase, np.maximum(np.abs(v), 1e-9))
    allowed = _SLIP + np.where(aside * rate > 0.0, leads, 0.0)
    sideways = (np.abs(aside) > allowed) & (goes > _FAST) & (np.abs(v) > _FAST) & posed
    return np.asarray((np.abs(rate) > np.abs(v) / wheelbase * 1.2 + 0.5) | sideways)


def _folded(angle: FloatArray, turn: float) -> FloatArray:
    """Angles [rad] less whole turns of `turn` [rad]: within half of it to either side."""
    return np.asarray(angle - turn * np.rint(angle / turn))


def _over_ground(t: FloatArray, whole: FloatArray) -> FloatArray:
    """Speed [m/s] (n,) by which the position moves along the heading."""
    ahead, behind = _around(t)
    dx, dy = whole[ahead, 0] - whole[behind, 0], whole[ahead, 1] - whole[behind, 1]
    along = dx * np.cos(whole[:, 2]) + dy * np.sin(whole[:, 2])
    return np.asarray(along / np.maximum(t[ahead] - t[behind], 1e-9))


def _near(t: FloatArray, slides: BoolArray) -> BoolArray:
    """True half a second around the rows of a slide."""
    mask = np.zeros(len(t), dtype=np.bool_)
    rows = np.flatnonzero(slides)
    if len(rows):
        low, high = np.searchsorted(t, t[rows] - 0.5), np.searchsorted(t, t[rows] + 0.5)
        np.add.at(edges := np.zeros(len(t) + 1, dtype=np.int64), low, 1)
        np.subtract.at(edges, high, 1)
        mask = np.cumsum(edges[:-1]) > 0
    return mask


def _states(t: FloatArray, measured: FloatArray, whole: FloatArray, starts: IntArray) -> FloatArray:
    """Motion at the starts by a parabola through the samples around each."""
    states = np.zeros((len(starts), 6))
    states[:, 4] = np.nan  # tyres in a turn slip: a car put there without slip shows a jump in ay
    for j, row in enumerate(starts):
        low, high = np.searchsorted(t, [t[row] - _FIT, t[row] + _FIT + 1e-9])
        s = t[low:high] - t[row]
        for place, channel in ((0, 0), (1, 1), (2, 2), (3, 3), (5, 4)):
            piece = measured[low:high, channel]
            known = np.isfinite(piece)
            # One-sided or thin: a straight line; a parabola would swing at its end
            degree = 2 if known.sum() >= 7 and s[known][0] < 0.0 < s[known][-1] else 1 if known.sum() >= 3 else 0
            if degree and np.ptp(s[known]) > 0.0:
                states[j, place] = np.polynomial.polynomial.polyfit(s[known], piece[known], degree)[0]
            else:
                states[j, place] = whole[row, channel]
    if (whole[:, 3] > -still_speed(whole[:, 3])).all():  # it never reverses: what is below nought at rest is noise
        states[:, 3] = np.maximum(states[:, 3], 0.0)
    return states
