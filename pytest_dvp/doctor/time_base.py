"""The time base: rate, jitter, gaps, jumps of the state that time does not explain, and clocks that disagree."""

from __future__ import annotations

import itertools

import numpy as np

from openscenario.findings import Findings
from pytest_dvp.doctor.redundant_motion import ALIKE, Motion, best_lag, correlation, far_lag, part_of
from pytest_dvp.doctor.smoothing import time_constant
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

SLOWEST = 0.5  # Hz: below, no manoeuvre of a car can be seen
FASTEST = 20_000.0  # Hz: above, the stamps are in another unit
USUAL = (1e-3, 0.5)  # [s] between rows: milliseconds for seconds, or the reverse, are never in between; chosen
JITTER = 0.04  # share of the sample interval: standard deviation that bends a derivative by as much
GAP = 2.5  # sample intervals
PAUSE = 86400.0  # [s] between two rows of one log: a day, chosen; after a longer one the stamps are of another clock
PARTED = 0.5  # share of the time without rows: no one recording any more
OFFSET = 0.08  # [s]: least disagreement of two clocks that is told; two intervals if that is more
RETURN = 30.0  # [s] within which a position that jumped away must come back; then
HOME = 0.1  # of the jump it may miss the way that speed and heading lead, for
SEEN = 5  # rows; all three chosen
LONGEST = 2.0  # [s] looked for; farther only where nothing fits there
PART = 30.0  # [s] of a long log that is looked at alone: a clock that is late for a while only
ALONE = 2  # parts in a row that must say so

# Two channels that tell one thing, the least standard deviation [SI] to judge them by, and the lag [s] that no clock is
# needed for: a sensor ahead of the rear axle sees a turn d/v earlier, side slip moves ay against v * yaw_rate.
PAIRS = (
    ("turn", "yaw_rate", 0.02, OFFSET), ("path_turn", "turn", 0.03, 0.4), ("ay", "v*yaw_rate", 0.3, 0.16),
    ("ax", "accel", 0.3, 0.15), ("path_speed", "v", 0.5, OFFSET),
)  # fmt: skip
_TOLERANCE = {(first, second): tolerance for first, second, _, tolerance in PAIRS}
_CHANNELS = {
    "turn": ("yaw",), "yaw_rate": ("yaw_rate",), "path_turn": ("x, y",), "ay": ("ay",), "v*yaw_rate": ("yaw_rate",),
    "ax": ("ax",), "accel": ("v",), "path_speed": ("x, y",), "v": ("v",),
}  # fmt: skip
_ONE = (
    ("yaw_rate",),
    ("yaw",),
    ("v",),
    ("x, y",),
    ("ay",),
    ("ax",),
    ("x, y", "yaw"),
    ("ax", "ay"),
    ("ax", "ay", "yaw_rate"),
)
_EXPLANATIONS: tuple[tuple[tuple[str, ...], ...], ...] = (
    *((one,) for one in _ONE),
    *((one, two) for one, two in itertools.combinations(_ONE, 2) if not set(one) & set(two)),
)


def check_rate(log: Log, file: str, line: int | None, findings: Findings) -> bool:
    """False if the stamps cannot be seconds."""
    steps = np.diff(log.t)
    median = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
    ratio = _travel_ratio(log, median)
    slow, fast = median > 1.0 / SLOWEST, 0 < median < 1.0 / FASTEST
    longest = int(np.argmax(steps))
    if steps[longest] > PAUSE and not slow:
        findings.add(
            "log.gap", file, line, "column t",
            f"the stamps leap by {steps[longest]:.6g} s at t = {log.t[longest]:.6g} s: no drive pauses so long",
            allowed=f"{PAUSE:g} s", hint="rows that another clock stamped, or none (0): leave them out, LOG@FROM:TO",
        )  # fmt: skip
        return False
    # At a usual rate a ratio is one of v or of x and y: check_speed tells it.
    if not (slow or fast or (ratio > 100.0 and median >= USUAL[1]) or (0.0 < ratio < 0.01 and median <= USUAL[0])):
        return True
    guess = " milliseconds stored as seconds?" if 0.5 < median < 1e4 and (ratio > 100.0 or slow) else ""
    against = f"; v * dt is {ratio:.3g} times the distance between positions" if ratio > 0.0 else ""
    findings.add(
        "log.implausible_rate",
        file,
        line,
        "column t",
        f"the stamps do not fit seconds:{guess or ' wrong unit'}{against}",
        found=f"{median:.6g} s between rows, {1 / median if median else 0:.3g} Hz",
        allowed=f"{SLOWEST} to {FASTEST:g} Hz",
        hint='correct the unit of the column: `t [ms]`, or time_unit = "ms" in a mapping',
    )
    return False


def _travel_ratio(log: Log, median: float) -> float:
    """Distance by v over distance by x, y, row by row; 0 if it cannot be said."""
    if not {"x", "y", "v"} <= log.columns.keys():
        return 0.0
    x, y, v = (log.columns[name] for name in "xyv")
    told = v[np.isfinite(v)]
    if not len(told) or (np.ptp(told) == 0.0 and abs(told[0]) < 0.5):
        return 0.0  # a dead sensor says nothing of the clock
    every = max(1, round(0.5 / median)) if median > 0 else 1
    moved = np.hypot(np.diff(x[::every]), np.diff(y[::every]))
    driven = np.abs(v[::every][1:]) * np.diff(log.t[::every])
    known = np.isfinite(moved) & np.isfinite(driven) & (moved > 0) & (driven > 0)
    return float(np.median(driven[known] / moved[known])) if np.count_nonzero(known) > 5 else 0.0


def check_stamps(log: Log, file: str, findings: Findings) -> None:
    """Jitter and gaps; duplicated and reversed stamps are the reader's findings."""
    steps = np.diff(log.t)
    steps = steps[steps > 0]
    if len(steps) < 10:
        return
    median = float(np.median(steps))
    gaps = np.flatnonzero(np.diff(log.t) > max(GAP * median, median + 0.02))
    regular = steps[steps < 1.6 * median]  # without rows that are missing
    share = float(np.std(regular)) / median
    mixed = any(np.isnan(values).mean() > 0.2 for values in log.columns.values())
    if share > JITTER and not mixed:
        findings.add(
            "log.jitter",
            file,
            None,
            "column t",
            "the sample interval scatters",
            found=f"{100 * share:.1f} % of {median:.4g} s (standard deviation)",
            allowed=f"up to {100 * JITTER:.0f} %",
            hint="these are stamps of reception: record the sender's stamps, or allow for as much in every delay found",
            severity="warning",
        )
    spans = np.diff(log.t)[gaps]
    if mixed:  # topics of several rates: their common stamps are uneven
        gaps = gaps[spans > max(1.0, 10.0 * median)]
        spans = np.diff(log.t)[gaps]
    if len(gaps):
        lost, longest = float(np.sum(spans - median)), int(np.argmax(spans))
        parted = lost > PARTED * log.duration
        count = "a gap" if len(gaps) == 1 else f"{len(gaps)} gaps, {lost:.3g} s in all, the longest"
        findings.add(
            "log.gap",
            file,
            None,
            "column t",
            f"{count} of {spans[longest]:.3g} s at t = {log.t[gaps[longest]]:.6g} s"
            + (": most of the time is missing, these are several recordings" if parted else ""),
            hint="cut the log there: LOG@START:STOP",
            severity="error" if parted else "warning",
        )


def check_jumps(log: Log, file: str, findings: Findings) -> None:
    """A state that jumps farther than its rates allow: another run begins, or a position fix jumped."""
    fixes = _fixes(log)
    if fixes is None:
        return
    t, x, y, v, yaw = fixes
    steps, top = np.diff(t), float(np.percentile(np.abs(v), 95))
    moved = np.hypot(np.diff(x), np.diff(y))
    beyond = moved - np.maximum(np.abs(v[1:]), np.abs(v[:-1])) * np.abs(steps)
    usual = float(np.median(np.abs(beyond)))
    jumps = np.flatnonzero(beyond > max(20.0 * usual, 0.25, 0.05 * top) + 0.5 * top * np.maximum(steps - 0.1, 0.0))
    if not len(jumps):
        return
    row = int(jumps[np.argmax(beyond[jumps])])
    turned = abs(float(np.angle(np.exp(1j * (yaw[row + 1] - yaw[row]))))) > max(0.15, 5.0 * abs(float(steps[row])))
    faster = abs(v[row + 1] - v[row]) > 15.0 * abs(steps[row]) + 0.1 * top + 0.05
    far = beyond[row] > max(1.5 * top, 5.0 if top > 3.0 else 0.0)
    others = [name for name, jumped in (("yaw", turned), ("v", faster)) if jumped]
    back = not others and "yaw" in log.columns and _comes_back(t, x, y, v, yaw, row, float(beyond[row]))
    if back:
        findings.add(
            "log.position_jump", file, None, "column x",
            f"the position jumps {len(jumps)} times, most by {beyond[row]:.3g} m at t = {t[row + 1]:.6g} s; some "
            "seconds before and after it is where speed and heading lead",
            hint="a fix that was lost and held, or written as 0: leave x and y empty there, or cut the log",
            severity="error" if far else "warning",
        )  # fmt: skip
        return
    if far or (others and beyond[row] > 0.3 * top):
        findings.add(
            "log.concatenated", file, None, "column x",
            f"{' and '.join(['x, y', *others])} jump by {beyond[row]:.3g} m at t = {t[row + 1]:.6g} s: "
            "another run begins there", hint=f"split it: LOG@:{t[row + 1]:.6g} and LOG@{t[row + 1]:.6g}:",
        )  # fmt: skip
        return
    findings.add(
        "log.position_jump", file, None, "column x",
        f"the position jumps {len(jumps)} times, most by {beyond[row]:.3g} m at t = {t[row + 1]:.6g} s, "
        "while speed and heading go on", hint="a position fix that jumped, or two runs in one file: cut the log there",
        severity="warning",
    )  # fmt: skip


def _comes_back(
    t: FloatArray, x: FloatArray, y: FloatArray, v: FloatArray, yaw: FloatArray, row: int, jump: float
) -> bool:
    """Whether the position after a jump [m], or before it, is where speed and heading lead from a position less than
    RETURN earlier, or later: what lies in between is wrong, and no other run begins."""
    steps = np.diff(t)
    east, north = (
        np.concatenate([[0.0], np.cumsum(0.5 * (part[1:] + part[:-1]) * steps)])
        for part in (v * np.cos(yaw), v * np.sin(yaw))
    )
    off_x, off_y = x - east, y - north  # constant where the position goes as speed and heading say
    for here, others in (
        (row + 1, (t < t[row]) & (t > t[row] - RETURN)),
        (row, (t > t[row + 1]) & (t < t[row + 1] + RETURN)),
    ):
        miss = np.hypot(off_x[others] - off_x[here], off_y[others] - off_y[here])
        if np.count_nonzero(miss < HOME * jump) >= SEEN:
            return True
    return False


def _fixes(log: Log) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray] | None:
    """t, x, y and the speed and yaw at those times, where the position was measured; None without enough of them."""
    if not {"x", "y", "v"} <= log.columns.keys():
        return None
    x, y, v = (log.columns[name] for name in "xyv")
    seen, known = np.isfinite(x) & np.isfinite(y), np.isfinite(v)
    if np.count_nonzero(seen) < 20 or np.count_nonzero(known) < 20:
        return None
    t = log.t[seen]
    yaw = log.columns.get("yaw", np.zeros(len(x)))
    turned = np.isfinite(yaw)
    heading = np.interp(t, log.t[turned], np.unwrap(yaw[turned])) if np.count_nonzero(turned) > 1 else np.zeros(len(t))
    return t, x[seen], y[seen], np.interp(t, log.t[known], v[known]), heading


def check_commands(motion: Motion, file: str, findings: Findings) -> None:
    """Steering and drive that answer equally late: two actuators, or one clock of the commands."""
    turn = next((name for name in ("yaw_rate", "turn", "path_turn") if name in motion.of), None)
    if turn is None or not motion.has("v", "steer_cmd", "accel_cmd"):
        return
    of, at = motion.of, motion.moving
    steering, steered = best_lag(
        np.where(at, of[turn], np.nan), np.where(at, of["steer_cmd"] * of["v"], np.nan), motion.step, 1.0, positive=True
    )
    drive, driven = best_lag(
        np.where(at, of["accel"], np.nan), np.where(at, of["accel_cmd"], np.nan), motion.step, 1.0, positive=True
    )
    if min(steered, driven) < 0.8 or abs(steering - drive) > 0.06:
        return
    late = 0.5 * (steering + drive)
    if max(steering, drive) < -OFFSET:
        when, cause = "before", "no car does that: the clock of the commands is off, or they are stamped when read back"
    elif min(steering, drive) >= 1.5 * OFFSET:
        when = "after"
        cause = "the clock of the commands is off, or both actuators are equally late, the data cannot say which"
    else:
        return
    findings.add(
        "log.clock_offset", file, None, "column steer_cmd, accel_cmd",
        f"steering and drive both answer {abs(late):.2f} s {when} their commands",
        hint=f"{cause}: look how the commands are stamped", severity="warning",
    )  # fmt: skip


def check_offsets(motion: Motion, median: float, file: str, findings: Findings) -> None:
    """Channels whose clock disagrees with the others'."""
    lags = pair_lags(motion)
    allowed = {pair: max(_TOLERANCE[pair], 2.0 * median) for pair in lags}
    # A place of the antenna moves the path's turn against yaw as a clock would: that pair only helps to tell channels.
    off = {pair: lag for pair, lag in lags.items() if abs(lag) > allowed[pair] and pair[0] != "path_turn"}
    if not off:
        _check_parts(motion, allowed, lags, file, findings)
        return
    best: tuple[float, dict[tuple[str, ...], float]] | None = None
    for sources in _EXPLANATIONS:
        if best is not None and len(sources) > len(best[1]):
            break  # one channel that explains all is better than two
        delays = {source: _delay(source, sources, lags) for source in sources}
        if any(abs(delay) <= 0.75 * OFFSET for delay in delays.values()):
            continue
        miss = [
            (lag - sum(delays[source] * _sign(pair, source) for source in sources)) / (allowed[pair] + 0.25 * abs(lag))
            for pair, lag in lags.items()
        ]
        score = float(np.sum(np.square(miss)))
        if max(map(abs, miss)) <= 1.0 and (best is None or score < best[0] - 1e-9):
            best = (score, delays)
    if best is not None:
        for source, delay in best[1].items():
            name = ", ".join(source)
            if not _is_smoothed(motion, name, delay, file, findings):
                _tell(name, delay, "the other channels", file, findings)
        return
    for (first, second), lag in off.items():
        name = ", ".join(_CHANNELS[first])
        if not _is_smoothed(motion, name, lag, file, findings):
            _tell(name, lag, ", ".join(_CHANNELS[second]), file, findings)


def _is_smoothed(motion: Motion, channel: str, lag: float, file: str, findings: Findings) -> bool:
    """True if the channel comes late as a low-pass of another one does, which is then told."""
    of = _with_turning(motion)
    for first, second, _, _ in PAIRS:
        late, prompt = (first, second) if _CHANNELS[first] == (channel,) else (second, first)
        if lag <= 0.0 or _CHANNELS[late] != (channel,) or not {late, prompt} <= set(of):
            continue
        if (tau := time_constant(motion, of[late], of[prompt], lag)) is None:
            continue
        findings.add(
            "log.clock_offset",
            file,
            None,
            f"column {channel}",
            f"{channel} is smoothed: a low-pass of {tau:.2g} s explains it better than a delay of {lag:.2f} s",
            hint="no other stamps undo that; leave the channel out (a mapping with `only = true` and no entry for it), "
            "or log it unfiltered",
            severity="warning",
        )
        return True
    return False


def _with_turning(motion: Motion) -> dict[str, FloatArray]:
    """The channels of a motion, and the lateral acceleration that speed and yaw rate tell."""
    of = dict(motion.of)
    if motion.has("v", "yaw_rate"):
        of["v*yaw_rate"] = of["v"] * of["yaw_rate"]
    return of


def _check_parts(
    motion: Motion, allowed: dict[tuple[str, str], float], whole: dict[tuple[str, str], float], file: str,
    findings: Findings,
) -> None:  # fmt: skip
    """Channels whose clock agrees with the others' over the whole log, but not for a while."""
    rows = round(PART / motion.step)
    if rows < 1 or len(motion.t) < 2 * ALONE * rows:
        return
    begins = range(0, len(motion.t) - rows + 1, rows)
    parts = [pair_lags(part_of(motion, begin, begin + rows)) for begin in begins]
    for pair in whole:
        if pair[0] == "path_turn":
            continue
        off = [lag if abs(lag := part.get(pair, 0.0)) > 1.5 * allowed[pair] else 0.0 for part in parts]
        for first in range(len(off) - ALONE + 1):
            run = off[first : first + ALONE]
            if all(run) and min(run) * max(run) > 0.0 and max(map(abs, run)) - min(map(abs, run)) < allowed[pair]:
                last = first + ALONE
                while last < len(off) and off[last] * run[0] > 0.0:
                    last += 1
                times = motion.t[begins[first]], motion.t[min(begins[last - 1] + rows, len(motion.t)) - 1]
                lag = float(np.median(off[first:last]))
                one, other = (", ".join(_CHANNELS[name]) for name in pair)
                _tell(one, lag, other, file, findings, f" from t = {times[0]:.0f} to {times[1]:.0f} s only")
                break


def _delay(source: tuple[str, ...], sources: tuple[tuple[str, ...], ...], lags: dict[tuple[str, str], float]) -> float:
    """Delay of a source by the sharpest pair that it takes part in alone; 0 if there is none."""
    own = [
        (_TOLERANCE[pair], lag * _sign(pair, source))
        for pair, lag in lags.items()
        if _sign(pair, source) and not any(_sign(pair, other) for other in sources if other != source)
    ]
    return min(own, default=(0.0, 0.0), key=lambda entry: entry[0])[1]


def pair_lags(motion: Motion) -> dict[tuple[str, str], float]:
    """Lag [s] of each pair of channels that can be judged: both there, moving enough, and of one shape."""
    of = _with_turning(motion)
    lags: dict[tuple[str, str], float] = {}
    for first, second, least, _ in PAIRS:
        if first not in of or second not in of:
            continue
        needs_motion = first in ("path_turn", "ay")
        a = np.where(motion.moving, of[first], np.nan) if needs_motion else of[first]
        b = of[second]
        known = np.isfinite(a) & np.isfinite(b)
        if np.count_nonzero(known) < 100 or min(np.std(a[known]), np.std(b[known])) < least:
            continue
        lag, top = best_lag(a, b, motion.step, LONGEST, positive=True)
        near = top if abs(lag) < LONGEST - motion.step else 0.0
        if near < ALIKE and (far := far_lag(a, b, motion.step, near)) is not None:
            lags[first, second] = far
            continue
        if top < 0.6 or abs(lag) >= LONGEST - motion.step:
            continue
        if top**2 - correlation(a[known], b[known]) ** 2 < 0.05 * (1.0 - top**2):
            lag = 0.0  # no better than together
        lags[first, second] = lag
    return lags


def _sign(pair: tuple[str, str], source: tuple[str, ...]) -> int:
    """+1 if the source is the pair's first channel alone, -1 if its second, 0 if both or none."""
    first = any(channel in source for channel in _CHANNELS[pair[0]])
    second = any(channel in source for channel in _CHANNELS[pair[1]])
    return int(first) - int(second)


_EARLY = {
    "v": "a clock offset, or the speed of driven wheels, which slip while they drive, the data cannot say which",
    "ay": "a clock offset, or an accelerometer ahead of the rear axle (ay_x of a model), the data cannot say which",
}
"""What else makes a channel seem early: two authors of foreign cars were told of a latency where there was none."""


def _tell(channel: str, lag: float, other: str, file: str, findings: Findings, when: str = "") -> None:
    late = "a clock offset, a sensor's latency or its filter, the data cannot say which"
    cause = late if lag > 0 else _EARLY.get(channel, "a clock offset, or the other channels are late")
    model = "; or let the model have the latency" if lag > 0 else ""
    findings.add(
        "log.clock_offset",
        file,
        None,
        f"column {channel}",
        f"{channel} comes {abs(lag):.2f} s {'later' if lag > 0 else 'earlier'} than {other} tell{when}",
        hint=f"{cause}: with `delay = {lag:.2f}` in its table of a mapping the stamps are corrected{model}",
        severity="warning",
    )
