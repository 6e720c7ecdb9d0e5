"""One stride along a lane, compiled: moving and the pose at its end in a single call."""

from __future__ import annotations

from machine_code import compiled
from openscenario.road.path import advance
from openscenario.road.pose import lane_pose
from openscenario.road.tables import Tables


@compiled
def stride(
    tables: Tables, road: int, lane: int, s: float, offset: float, distance: float
) -> tuple[int, float, float, float, float, float, float, float, float]:
    """Move `distance` [m] (> 0 with increasing s) on one road: lane, s, distance left at its end, and the pose.

    The pose is x, y, z [m], heading, pitch, roll [rad] at the constant `offset` [m] from the lane's middle.
    """
    lane, s, _, _, left = advance(tables, road, lane, s, offset, distance)
    x, y, z, heading, pitch, roll = lane_pose(tables, road, lane, s, offset)
    return lane, s, left, x, y, z, heading, pitch, roll
