"""How much more than noise a residual holds, judged by the noise that it shows itself."""

from __future__ import annotations

import numpy as np

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
from pytest_dvp.gap.diagnose.linear_algebra import square

FEWEST = 50  # third differences of a channel, below which they tell no level; 50 know it to 30 %
_GAIN = 20.0  # variance of third differences of white noise of variance 1: 1 + 9 + 9 + 1


def beyond_noise(data: ExperimentSet, values: Values) -> float:
    """chi^2/N over all channels with the noise taken from third differences of the residuals, 1 for white noise.

    The noise of a signal alone is known to some 4 %, which makes 0.08 of chi^2/N; a model's residuals show theirs
    without the motion, and what chance does to both drops out. An error that lasts longer than a few samples stays.
    """
    total, count = 0.0, 0
    for e in data.experiments:
        rest = e.residuals(values).values
        white = e.white(rest).reshape(-1, len(CHANNELS))
        for name in e.channels:
            k = CHANNELS.index(name)
            known = np.isfinite(rest[:, k])
            y = np.where(known, white[:, k], np.nan)
            d = np.diff(y, n=3)
            d = d[np.isfinite(d)]
            level = square(d) / (_GAIN * len(d)) if len(d) >= FEWEST else 1.0
            total += square(y[known]) / max(level, 1e-9)
            count += int(known.sum())
    return total / max(count, 1)


def settle(data: ExperimentSet, values: Values) -> None:
    """Begin the segments where the model with these values would have them begin, in the logs where that leaves less:
    from a standstill it may leave more."""
    for e in data.experiments:
        before, left = e.segments, square(e.whitened(values))
        e.settle(values)
        if square(e.whitened(values)) > left:
            e.segments = before
