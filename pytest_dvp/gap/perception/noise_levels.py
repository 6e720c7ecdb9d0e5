"""Noise of detections by its level in bands of distance, beside the run of a twin that passes the same tracker.

The two values of the effect, sigma0 and slope, can hardly be told apart by one log, and far away a sensor's resolution
stands for both. So levels nearby are compared, and the values are the line through what the model needs there.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pytest_dvp.gap.perception.position_fit import BANDS
from pytest_dvp.logs.log_contents import FloatArray

SIGMA0, SLOPE = ("detection_noise", "sigma0"), ("detection_noise", "slope")
LEAST = 0.02  # m, by which a level must differ in a band; as detection_noise says of sigma0
SURE = 2.24  # standard deviations: 95 % that neither of two bands is as far off by chance
LIKELY = 0.67  # standard deviations: more likely than not
UNSETTLED = 0.1  # of a level; chosen: what a circle of diagnosis and drive is asked to reach


def noise_differs(found: FloatArray, twin: FloatArray, has_noise: bool) -> bool:
    """Whether the noise of two runs, levels [m] and standard deviations (bands, 2), differs for sure, and by LEAST.

    has_noise: the model of the twin has a noise already. What its tracker dampens was guessed, and such a value is not
    only unsure but wrong to one side, of which an interval says nothing; so it is moved on as long as it is more likely
    than not another one, by UNSETTLED or more.
    """
    apart = np.abs(found[:, 0] - twin[:, 0])
    unsure = np.hypot(found[:, 1], twin[:, 1])
    moves = (apart >= UNSETTLED * found[:, 0]) & (apart >= LIKELY * unsure)
    return bool(((apart >= LEAST) & (apart >= SURE * unsure)).any() or (has_noise and moves.any()))


def noise_needed(
    found: FloatArray, twin: FloatArray, base: tuple[float, float], needed: Callable[[float, float, float], float]
) -> tuple[float, float]:
    """sigma0 [m] and slope [-] that a model needs which has `base`, so that its run shows what was found.

    found, twin: levels [m] and standard deviations (bands, 2); needed: level [m] of the model from that found, that
    which the model's run shows, and that which the model has.
    """
    at = np.array([0.5 * (least + most) for least, most in BANDS])
    has = base[0] + base[1] * at
    levels = [needed(*level) for level in zip(found[:, 0].tolist(), twin[:, 0].tolist(), has.tolist(), strict=True)]
    slope, sigma0 = (float(value) for value in np.polyfit(at, levels, 1))
    if slope < 0.0:
        return float(np.mean(levels)), 0.0
    return (sigma0, slope) if sigma0 >= 0.0 else (0.0, float(np.dot(at, levels) / np.dot(at, at)))
