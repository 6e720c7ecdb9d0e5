"""The ego's box at the times of an object track."""

from __future__ import annotations

import math

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray, ObjectTrack
from pytest_dvp.logs.undefined import Undefined

_SAME_TIME = 1e-6  # s


def ego_size(log: Log) -> tuple[float, float, float]:
    """Length, width [m] of the ego's box and how far its middle is ahead of the reference point. Raises Undefined."""
    ego = log.meta.get("ego")
    if not isinstance(ego, dict):
        raise Undefined("the log does not tell the size of the ego (meta: ego)")
    values = []
    for key in ("length", "width", "center_x"):
        value = ego.get(key)
        if not isinstance(value, int | float) or not math.isfinite(value):
            raise Undefined(f"the log does not tell the {key} of the ego (meta: ego)")
        values.append(float(value))
    if values[0] <= 0.0 or values[1] <= 0.0:
        raise Undefined("the ego has no size (meta: ego)")
    return values[0], values[1], values[2]


def pair_boxes(log: Log, name: str, track: ObjectTrack) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times (n,) at which both are known, and boxes (n, 7) of the ego and of the object, for time_to_collision.

    The ego's velocity is that of the middle of its box (reference point plus turn rate times lever), so that the
    straight motion that TTC assumes is the best one for the whole box. Raises Undefined where one is not measured.

    Times in [s]; a box is x, y [m], yaw [rad], length, width [m], vx, vy [m/s] in the frame of the world.
    """
    length, width, ahead = ego_size(log)
    inside = (track.t >= log.t[0] - _SAME_TIME) & (track.t <= log.t[-1] + _SAME_TIME)
    t = track.t[inside]
    x, y, yaw = (np.interp(t, log.t, log[column]) for column in ("x", "y", "yaw"))
    if "vx" in log.columns and "vy" in log.columns and "yaw_rate" in log.columns:
        forward, left = np.interp(t, log.t, log["vx"]), np.interp(t, log.t, log["vy"])
        left = left + ahead * np.interp(t, log.t, log["yaw_rate"])
    else:
        forward, left = np.interp(t, log.t, log["v"]), np.zeros(len(t))
    cos, sin = np.cos(yaw), np.sin(yaw)
    ego = np.empty((len(t), 7))
    ego[:, 0], ego[:, 1], ego[:, 2] = x + ahead * cos, y + ahead * sin, yaw
    ego[:, 3], ego[:, 4] = length, width
    ego[:, 5], ego[:, 6] = forward * cos - left * sin, forward * sin + left * cos
    box = np.empty((len(t), 7))
    for i, values in ((0, track.x), (1, track.y), (2, track.yaw), (5, track.vx), (6, track.vy)):
        box[:, i] = values[inside]
    box[:, 3], box[:, 4] = track.length, track.width
    for who, values in (("the ego", ego), (name, box)):
        bad = ~np.isfinite(values).all(axis=1)
        if bad.any():
            raise Undefined(f"position or speed of {who} is not measured at t={t[bad][0]:.2f} s")
    return t, ego, box
