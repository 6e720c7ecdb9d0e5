"""What a car's perception loses of objects that are partly behind others, next to what a run of its model loses.

Sensors lose such objects by themselves, a little or wholly, so a border is looked for in what the car sees over what
the twin does: c f(h) with f of the twin for a hidden share h below the border, c what the car sees of clear objects
over what the twin does, and a part q of that beyond. Where camera and LiDAR both lose what is hidden, nothing is left
(q = 0). Where the camera alone does, the LiDAR goes on hitting what sticks out, and a stack keeps some of it, badly
placed.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pytest_dvp.gap.compare.start_correction import BoolArray, IntArray
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import AppliedEffect

NAME = "detection_occlusion"
SHARE, LIDAR = (NAME, "share"), (NAME, "lidar")
NEAR = 40.0  # m, in which a stack acts on what it sees; farther ones are lost for other reasons, too; chosen
BLOCK = 1.0  # s; of one object: how much of it is hidden changes about as fast; chosen
LEFT = 0.2  # of what the twin sees, that a car sees beyond the border: with less its LiDAR loses it, too; chosen: 0.1
# at most in three drives of a car that loses all, 0.3 and more in three whose camera alone does
LEAST_ROWS = 20  # of each drive, as where a log alone shows a border; chosen
GAIN = 3.0  # log-likelihood that a border brings: 95 % for one, as of a range
_WIDE = 1.92  # log-likelihood of a 95 % interval
_RAMP = 0.1  # of the share, over which what is seen falls: boxes do not fill what they stand for; chosen
_BINS = 9  # of shares, in which the twin's part is counted
_BORDERS, _LEFT = np.arange(0.05, 1.0, 0.05), np.arange(0.0, 1.0, 0.05)

Value = tuple[float, float, float]


class Behind(NamedTuple):
    """Rows of objects that are partly behind others, near and in view (n,): hidden share, whether they were seen, and
    which rows depend on each other. clear: part that is seen of near objects in view that nothing hides."""

    share: FloatArray
    seen: BoolArray
    block: IntArray
    clear: float = 1.0


class Lost(NamedTuple):
    """share, lidar: values of `detection_occlusion` with intervals; gain: log-likelihood over no border at all."""

    share: Value
    lidar: Value
    gain: float


def lost_behind(car: Behind, twin: Behind) -> Lost | None:
    """What the car loses that the twin sees; None if too few rows of either tell."""
    if min(len(car.share), len(twin.share)) < LEAST_ROWS:
        return None
    seen = _usual(twin)[_bin(car.share)] * min(car.clear / max(twin.clear, 1e-3), 1.0)
    weight = len(np.unique(car.block)) / len(car.block)
    fall = np.clip((car.share - _BORDERS[:, None]) / _RAMP, 0.0, 1.0)[:, None]
    part = np.clip(seen * (1.0 - (1.0 - _LEFT[:, None]) * fall), 5e-3, 1.0 - 5e-3)  # (borders, left, rows)
    likely = weight * np.where(car.seen, np.log(part), np.log(1.0 - part)).sum(axis=2)
    whole = np.clip(seen, 5e-3, 1.0 - 5e-3)
    none = weight * float(np.where(car.seen, np.log(whole), np.log(1.0 - whole)).sum())
    border, left = np.unravel_index(int(np.argmax(likely)), likely.shape)
    near = likely > likely[border, left] - _WIDE
    borders = _BORDERS[near.any(axis=1)] + 0.5 * _RAMP
    lefts = _LEFT[near.any(axis=0)]
    middle = float(_BORDERS[border]) + 0.5 * _RAMP
    share = (middle, float(borders.min()) - 0.5 * _RAMP, min(float(borders.max()) + 0.5 * _RAMP, 1.0))
    lidar = (float(_LEFT[left] < LEFT), float(lefts.max() < LEFT), float(lefts.min() < LEFT))
    return Lost(share, lidar, float(likely[border, left]) - none)


def needed_behind(car: Behind, twin: Behind, effects: Iterable[AppliedEffect]) -> tuple[Lost | None, bool]:
    """What a model needs whose own run shows `twin`, and whether it lacks that.

    A model that has the effect keeps what it has while the two lose the same. If it loses too much, its LiDAR sees
    again, and at last its camera does, too; then a border is looked for anew.
    """
    lost = lost_behind(car, twin)
    has = next((a.values for a in effects if a.name == NAME), None)
    if lost is None or has is None:
        return lost, lost is not None and lost.gain >= GAIN
    too_much = lost_behind(twin, car)
    if too_much is not None and too_much.gain >= max(GAIN, lost.gain):
        none = (1.0, 1.0, 1.0)
        seen = (has["share"],) * 3 if has["lidar"] >= 0.5 else none
        return Lost(seen, none if seen is none else (0.0, 0.0, 0.0), too_much.gain), True
    if lost.gain < GAIN:
        return Lost((has["share"],) * 3, (has["lidar"],) * 3, lost.gain), False
    share = min(has["share"], lost.share[0])
    return Lost((share, min(share, lost.share[1]), lost.share[2]), lost.lidar, lost.gain), True


def _usual(twin: Behind) -> FloatArray:
    """Part that is seen, by bins of the hidden share."""
    count = np.bincount(_bin(twin.share), minlength=_BINS)
    return np.asarray((np.bincount(_bin(twin.share), weights=twin.seen, minlength=_BINS) + 0.5) / (count + 1.0))


def _bin(share: FloatArray) -> IntArray:
    return np.clip((share * (_BINS + 1)).astype(np.int64) - 1, 0, _BINS - 1)
