"""Noise floor of a measured signal, from the signal itself."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log_contents import FloatArray

_GAIN = 20.0**0.5  # standard deviation of the third difference of white noise of standard deviation 1
_WHITE = -0.6  # correlation of neighbouring third differences; -15/20 for white noise, towards +1 for a smooth signal
_ECHO = -0.25  # correlation at a later lag; chosen halfway to -0.5, that of a moving window with both of its ends
_LONGEST = 0.12  # s: over longer strides a car's motion shows, not noise
_SPAN = 0.5  # s
_UNBROKEN = 1.5  # times 2 _SPAN that three samples so far apart may cover; in more lies a gap. Chosen
_FILTERED_FLOOR = 0.005
"""Of the signal's usual bend over 2 _SPAN, for signals that were smoothed before they were logged. What a filter took
away cannot be seen; without a floor such a signal would be trusted without end (tests/truth/test_noise_floor.py)."""
_WHITE_FLOOR = 0.0002
"""The same for white noise, which the differences show as it is; this floor only keeps a division by nothing away."""
_STEADY = 0.9  # of the changes: where more of them are the same, and not 0, the signal climbs steadily
_CLIP = 2.5  # standard deviations beyond which a difference is an event, not noise


def sigma(t: FloatArray, y: FloatArray, residual: FloatArray | None = None, *, filtered: bool = False) -> float:
    """Standard deviation of the noise in y (n,), in its unit; t (n,) [s] ascending, NaN = not measured.

    Third differences (y[i+3k] - 3 y[i+2k] + 3 y[i+k] - y[i]) remove what a car can do in 3k samples; white noise leaves
    sqrt(20) sigma in them. Median instead of mean, so that jerks do not count. A signal that was filtered before it was
    logged has smooth noise and would seem noiseless: the stride k grows until neighbouring differences look like those
    of white noise, and the result gets a floor of 0.5 % of the signal's usual departure from a straight
    line within a second. A quantised signal
    is never better than its step / sqrt(12). A jittery command shakes the car itself, which looks like noise; so where
    there is a model's `residual` (n,), measured - model, the smaller of the two estimates is taken: a model adds error
    to the noise, never takes it away. `filtered`: it is known to come out of a filter, however white what is left.
    Slow drift is not seen. NaN with fewer than 16 samples; 0 for a constant.

    Source: von Neumann et al., Ann. Math. Stat. 12 (1941) 153, with differences of third instead of first order.
    """
    known = np.isfinite(y) & np.isfinite(t)
    if residual is not None:
        residual = residual[known & np.isfinite(residual)]
    t, y = t[known], y[known]
    if len(y) < 16:
        return float("nan")
    step = float(np.median(np.diff(t)))
    if step <= 0.0:
        return float("nan")
    reach = max(1, min(len(y) // 8, round(_LONGEST / step)))
    found, smooth = _white_level(y, reach)
    filtered = filtered or smooth
    if residual is not None and len(residual) >= 16:
        left, smooth_rest = _white_level(residual, reach)
        if smooth or not smooth_rest:
            found = min(found, left)
    swing = _swing(t, y, max(1, min(len(y) // 2 - 1, round(_SPAN / step))))
    floor = (_FILTERED_FLOOR if filtered else _WHITE_FLOOR) * swing
    return float(max(found, floor, _quantum(y) / 12.0**0.5))


def _white_level(y: FloatArray, reach: int) -> tuple[float, bool]:
    """Level at the shortest stride at which the differences look white, and whether that took more than one sample; the
    level at one sample if they never do."""
    first = 0.0
    for stride in _strides(reach):
        d = y[3 * stride :] - 3.0 * y[2 * stride : -stride] + 3.0 * y[stride : -2 * stride] - y[: -3 * stride]
        if len(d) <= 2 * stride:
            break
        spread = 1.482602 * float(np.median(np.abs(d)))
        if spread == 0.0:  # mostly quantised away; the quantum is the floor
            spread = float(np.sqrt(np.mean(d * d)))
            if spread == 0.0:
                continue
        c = np.clip(d / spread, -_CLIP, _CLIP)
        power = float(np.mean(c * c))
        if float(np.mean(c[stride:] * c[:-stride])) <= _WHITE * power and not _echoes(c, power, stride):
            return spread / _GAIN, stride > 1
        first = first or spread / _GAIN
    return first, True


def _echoes(c: FloatArray, power: float, stride: int) -> bool:
    """True if the differences come back with the other sign some samples later, as behind a moving window's end."""
    lags = range(4 * stride, min(4 * stride + 32, len(c) // 4))
    return any(float(np.mean(c[lag:] * c[:-lag])) < _ECHO * power for lag in lags)


def _strides(reach: int) -> list[int]:
    strides, k = [], 1
    while k <= reach:
        strides.append(k)
        k = max(k + 1, round(1.4 * k))
    return strides


def _swing(t: FloatArray, y: FloatArray, lag: int) -> float:
    """Range from the 1st to the 99th percentile of how far the signal leaves a straight line over 2 `lag` samples, in
    its unit; t (n,) [s]. What the car did in a gap is left out."""
    change = y[2 * lag :] - 2.0 * y[lag:-lag] + y[: -2 * lag]
    unbroken = t[2 * lag :] - t[: -2 * lag] <= _UNBROKEN * 2 * lag * np.median(np.diff(t))
    change = change[unbroken] if unbroken.any() else change
    return float(np.subtract(*np.percentile(change, [99.0, 1.0]))) if len(change) else 0.0


def _quantum(y: FloatArray) -> float:
    """Step of a quantised signal: most samples differ from the next by whole multiples of it; 0 if there is none.

    A steady climb, such as a position at constant speed, changes by much the same from sample to sample; a grid shows
    only where the multiples differ.
    """
    changes = np.diff(y)
    jumps = np.abs(changes)
    jumps = jumps[jumps > 0.0]
    if len(jumps) < 8:
        return 0.0
    least = float(np.quantile(jumps, 0.02))
    ratio = jumps / least
    if float(np.mean(np.abs(ratio - np.round(ratio)) < 0.02)) <= 0.95:
        return 0.0
    multiples = np.round(changes / least)
    usual = float(np.median(multiples))
    return 0.0 if usual != 0.0 and float(np.mean(multiples == usual)) > _STEADY else least
