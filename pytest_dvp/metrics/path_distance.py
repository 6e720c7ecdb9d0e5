"""How far apart two drives of one task are as lines on the ground, whatever their timing."""

from __future__ import annotations

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.lost_fix import lost_fix
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import Measured, Series, metric

LEAST = 0.5  # share of the measured path that must lie beside the model's, and of its length; chosen
STRIDE = 0.05  # m between two points of a line, so that a standing car is one point


@metric(name="path_distance", unit="m", bigger_is_worse=True, note="root mean square, per metre driven")
def path_distance(model: Log, measured: Log) -> Measured:
    """Root mean square of the distance of the measured path of the reference point from the model's, per metre driven.

    Timing does not count: a slower drive along the same line is no distance. A part in which the reference system had
    lost its fix (`position_sigma`) counts neither. Undefined if less than half of the measured path lies beside the
    model's, or if the measured path is less than half as long as the model's.
    """
    from pytest_dvp.metrics._polyline import lateral_offsets

    _, line = _line(model)
    t, points = _line(measured)
    if len(points) < LEAST * len(line):
        length, other = STRIDE * len(points), STRIDE * len(line)
        raise Undefined(f"the measured path is {length:.0f} m long, the model's {other:.0f} m")
    offsets = lateral_offsets(points[:, 0].copy(), points[:, 1].copy(), line)
    known = np.isfinite(offsets) & (np.interp(t, measured.t, lost_fix(measured.columns).astype(np.float64)) == 0.0)
    if known.mean() < LEAST:
        raise Undefined(f"only {100 * known.mean():.0f} % of the measured path lie beside the model's")
    worst = int(np.argmax(np.where(known, np.abs(offsets), -1.0)))
    rms = float(np.sqrt(np.mean(offsets[known] ** 2)))
    mean = float(np.mean(offsets[known]))
    return Measured(
        rms, float(t[worst]), "", Series(t, offsets), {"greatest": abs(float(offsets[worst])), "mean": mean}
    )


def _line(log: Log) -> tuple[np.ndarray, np.ndarray]:
    known = np.isfinite(log["x"]) & np.isfinite(log["y"])
    t, points = log.t[known], np.column_stack((log["x"][known], log["y"][known]))
    if len(points) < 2:
        raise Undefined("x and y were not measured")
    driven = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    grid = np.arange(0.0, driven[-1], STRIDE)
    if len(grid) < 2:
        raise Undefined("the car did not move")
    rising = np.concatenate([[True], np.diff(driven) > 0.0])
    return (
        np.interp(grid, driven[rising], t[rising]),
        np.column_stack([np.interp(grid, driven[rising], points[rising, k]) for k in range(2)]),
    )
