"""Compiled: whether two oriented boxes touch."""

from __future__ import annotations

import math

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray


@compiled
def touch(one: FloatArray, other: FloatArray) -> bool:
    """Whether two boxes touch or overlap: no normal of an edge separates them.

    A box is an array (5,) or longer of x, y [m] of its middle, yaw [rad], length, width [m]. The same as
    `_box_gaps.overlap`, which takes many at once.
    Source: separating axis theorem, Gottschalk, Lin and Manocha, OBBTree, SIGGRAPH 1996.
    """
    dx, dy = other[0] - one[0], other[1] - one[1]
    turn = other[2] - one[2]
    cos, sin = abs(math.cos(turn)), abs(math.sin(turn))
    for box, second in ((one, other), (other, one)):
        c, s = math.cos(box[2]), math.sin(box[2])
        along, across = dx * c + dy * s, dy * c - dx * s
        if abs(along) > 0.5 * (box[3] + second[3] * cos + second[4] * sin):
            return False
        if abs(across) > 0.5 * (box[4] + second[3] * sin + second[4] * cos):
            return False
    return True
