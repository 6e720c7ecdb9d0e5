"""What the reference systems of the road users say of them on stage rw: what the log holds in place of the truth.

A road user of a test on a proving ground carries a receiver of its own. With the surrogate the harness plays the road
users and knows the truth; the surrogate's sensors meet that, and the log holds what such a receiver would have said.
"""

from __future__ import annotations

import math

import numpy as np

from vehicle.messages import FloatArray, Surroundings

# 1 sigma. An RTK receiver with two antennas, as makers print it: 0.02 m of place, 0.1 deg of heading, 0.03 m/s of
# speed. How long its errors last is chosen, as is the split of the place into what wanders and what is white.
DRIFT, WHITE = 0.018, 0.008  # m, of x and of y
HEADING, SPEED = 0.0017, 0.03  # rad, m/s
DRIFT_TIME = 60.0  # s


class TargetReference:
    """Road users as their own receivers measure them; same seed and looks, same errors. `t` [s] of the looks grows."""

    def __init__(self, seed: int) -> None:
        self._rng = np.random.default_rng([seed, 6131])
        self._drift: dict[str, FloatArray] = {}
        self._looked = 0.0

    def measured(self, t: float, around: Surroundings) -> Surroundings:
        """The same road users with the errors of `t` [s]; their sizes are as they are."""
        keep = math.exp(-max(t - self._looked, 0.0) / DRIFT_TIME)
        self._looked = t
        kick = math.sqrt(1.0 - keep * keep)
        boxes = around.boxes.copy()
        for name, box in zip(around.names, boxes, strict=True):
            white = self._rng.standard_normal(7)
            before = self._drift.get(name)
            drift = DRIFT * white[:2] if before is None else keep * before + kick * DRIFT * white[:2]
            self._drift[name] = drift
            box[:2] += drift + WHITE * white[2:4]
            box[3] += HEADING * white[4]
            if box[7] or box[8]:  # a receiver knows that it stands
                box[7:9] += SPEED * white[5:7]
        return Surroundings(boxes, around.kinds, around.names, around.signals, around.hidden, around.extinction)
