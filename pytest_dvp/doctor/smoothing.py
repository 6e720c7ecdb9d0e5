"""Whether a channel that comes late was delayed or smoothed: a filter cannot be undone by other stamps."""

from __future__ import annotations

import numpy as np

from pytest_dvp.doctor.redundant_motion import Motion, correlation
from pytest_dvp.logs.log_contents import FloatArray

SHORTEST, LONGEST = 0.03, 5.0  # s, of time constants that are tried; chosen: a logger had smoothed one signal by 2.6
STEPS = 24  # of them: neighbours are a quarter apart
CLEARER = 0.5  # of what the delay leaves unexplained (1 - r^2), that the filter must leave at most


def time_constant(motion: Motion, late: FloatArray, prompt: FloatArray, lag: float) -> float | None:
    """Time constant [s] of the first-order low-pass of `prompt` (n,) that `late` (n,) is; None if a delay of `lag` [s]
    does about as well."""
    shift = round(lag / motion.step)
    if shift < 1 or shift >= len(late):
        return None
    known = np.isfinite(prompt)
    if not known.any():
        return None
    whole = np.interp(motion.t, motion.t[known], prompt[known])
    tried = np.geomspace(SHORTEST, LONGEST, STEPS).tolist()
    best, tau = max((_likeness(late, _filtered(whole, motion.step / each)), each) for each in tried)
    # any filter takes noise away: the delayed signal is smoothed as well, forwards and backwards, which delays nothing
    both = [whole, *(_filtered(_filtered(whole, motion.step / t)[::-1], motion.step / t)[::-1] for t in tried)]
    blank = np.full(shift, np.nan)
    delayed = max(_likeness(late, np.concatenate([blank, one[:-shift]])) for one in both)
    return float(tau) if 1.0 - best**2 < CLEARER * (1.0 - delayed**2) else None


def _filtered(signal: FloatArray, share: float) -> FloatArray:
    """A signal (n,) behind a first-order low-pass; share: step by time constant."""
    from scipy.signal import lfilter

    keep = float(np.exp(-share))
    found, _ = lfilter([1.0 - keep], [1.0, -keep], signal, zi=[keep * signal[0]])
    return np.asarray(found)


def _likeness(one: FloatArray, other: FloatArray) -> float:
    known = np.isfinite(one) & np.isfinite(other)
    return max(correlation(one[known], other[known]), 0.0) if np.count_nonzero(known) > 2 else 0.0
