"""Pose: from (road, s, t) to x, y, z, heading, pitch, roll.

The cross-section is turned by pitch (elevation) and roll (superelevation) about the reference line, so a point at t
lies at R(heading, pitch, roll) (0, t, 0) from it. The heading is that of the reference line plus the angle by which the
lane leaves it, atan(dt/ds). In a bend that differs from the tangent of the lane's middle, atan(dt/ds / (1 - kappa t)),
by a few mrad where the width changes: positions on a lane refer to the road's s axis. A path's tangent is `path.py`'s.
A road's shape is a height above the cross-section, in the direction of its normal.
Source: ASAM OpenDRIVE 1.8, 10.3 (elevation), 10.5 (superelevation, shape).
"""

from __future__ import annotations

import math

from machine_code import compiled
from openscenario.road.geometry import evaluate
from openscenario.road.lanes import lane_centre, section_at
from openscenario.road.profile import profile, record_at
from openscenario.road.tables import (
    LANE_HEIGHT,
    LANE_HEIGHT_END,
    ROAD_ELEVATION,
    ROAD_ELEVATION_END,
    ROAD_FLAT,
    ROAD_GEOMETRY,
    ROAD_GEOMETRY_END,
    ROAD_SHAPE,
    ROAD_SHAPE_END,
    ROAD_SUPERELEVATION,
    ROAD_SUPERELEVATION_END,
    SECTION_CENTRE,
    Tables,
)


@compiled
def reference(tables: Tables, road: int, s: float) -> tuple[float, float, float, float, float]:
    """x, y [m], heading [rad], curvature [1/m], its rate [1/m^2] of a road's reference line at s [m]."""
    roads = tables[3]
    return evaluate(tables[0], roads[road, ROAD_GEOMETRY], roads[road, ROAD_GEOMETRY_END], s)


@compiled
def slopes(tables: Tables, road: int, s: float) -> tuple[float, float, float, float, float]:
    """Elevation [m], its first and second derivative, superelevation [rad] and its derivative at s [m]."""
    cubics, roads = tables[1], tables[3]
    z, z1, z2 = profile(cubics, roads[road, ROAD_ELEVATION], roads[road, ROAD_ELEVATION_END], s)
    roll, roll1, _ = profile(cubics, roads[road, ROAD_SUPERELEVATION], roads[road, ROAD_SUPERELEVATION_END], s)
    return z, z1, z2, roll, roll1


@compiled
def _cross_section(tables: Tables, section: int, t: float) -> tuple[float, float]:
    """Height [m] of a cross-section at t [m] and its slope; right of its first record it goes on level."""
    cubics = tables[1]
    first, last = int(cubics[section, 1]), int(cubics[section, 2])
    if t <= cubics[first, 0]:
        return float(cubics[first, 1]), 0.0
    height, slope, _ = profile(cubics, first, last, t)
    return height, slope


@compiled
def shape_height(tables: Tables, road: int, s: float, t: float) -> tuple[float, float, float]:
    """Height [m] of a road's shape above its cross-section at (s, t), its slopes along s and along t.

    Cross-sections are joined by straight lines in s; beyond the last one it goes on level, before the first it is 0.
    """
    cubics, roads = tables[1], tables[3]
    first, last = roads[road, ROAD_SHAPE], roads[road, ROAD_SHAPE_END]
    if last <= first or s < cubics[first, 0] - 1e-9:
        return 0.0, 0.0, 0.0
    row = record_at(cubics, first, last, s)
    height, slope = _cross_section(tables, row, t)
    if row + 1 == last:
        return height, 0.0, slope
    apart = cubics[row + 1, 0] - cubics[row, 0]
    share = (s - cubics[row, 0]) / apart
    height2, slope2 = _cross_section(tables, row + 1, t)
    return height + share * (height2 - height), (height2 - height) / apart, slope + share * (slope2 - slope)


@compiled
def surface_pose(
    tables: Tables, road: int, s: float, t: float, t1: float, height: float
) -> tuple[float, float, float, float, float, float]:
    """x, y, z [m], heading, pitch, roll [rad] at (s, t), `height` [m] above the road; t1: dt/ds of the line there."""
    x, y, heading, kappa, _ = reference(tables, road, s)
    c, sn = math.cos(heading), math.sin(heading)
    if tables[3][road, ROAD_FLAT]:
        heading += math.atan(t1) if t1 != 0.0 else 0.0
        return x - sn * t, y + c * t, height, heading, 0.0, 0.0
    z, z1, z2, roll, roll1 = slopes(tables, road, s)
    shape, shape1, bank = shape_height(tables, road, s, t)
    height += shape
    run2 = 1.0 + z1 * z1
    cp = 1.0 / math.sqrt(run2)
    sp = -z1 * cp  # uphill is a negative pitch: x forward, y left, z up
    cr, sr = math.cos(roll), math.sin(roll)
    along = t * sp * sr + height * sp * cr
    across = t * cr - height * sr
    up = t * cp * sr + height * cp * cr
    sp1, cp1 = -z2 * cp / run2, -z1 * z2 * cp / run2
    along1 = t1 * sp * sr + t * (sp1 * sr + sp * cr * roll1)
    across1 = t1 * cr - t * sr * roll1
    forward, sideways = 1.0 - kappa * across + along1, across1 + kappa * along
    rise = z1 + t1 * cp * sr + t * (cp1 * sr + cp * cr * roll1) + (shape1 + t1 * bank) * cp * cr
    return (
        x + c * along - sn * across,
        y + sn * along + c * across,
        z + up,
        heading + math.atan(across1),
        -math.atan2(rise, math.sqrt(forward * forward + sideways * sideways)),
        roll + math.atan(bank),
    )


@compiled
def lane_height(tables: Tables, row: int, s: float, share: float) -> float:
    """Height [m] of a lane (a kerb, say) above the road; share 0 at its inner, 1 at its outer edge."""
    cubics, lanes = tables[1], tables[6]
    first, last = lanes[row, LANE_HEIGHT], lanes[row, LANE_HEIGHT_END]
    if last <= first or s < cubics[first, 0]:  # before the first record a lane is as high as the road
        return 0.0
    record = record_at(cubics, first, last, s)
    return float((1.0 - share) * cubics[record, 1] + share * cubics[record, 2])


@compiled
def lane_pose(
    tables: Tables, road: int, lane: int, s: float, offset: float
) -> tuple[float, float, float, float, float, float]:
    """x, y, z [m], heading, pitch, roll [rad] `offset` [m] left of a lane's middle; NaN where there is no such lane."""
    section = section_at(tables, road, s)
    t, t1, _, width = lane_centre(tables, road, section, lane, s)
    height = 0.0
    if lane != 0 and not tables[3][road, ROAD_FLAT] and not math.isnan(t):
        share = 0.5 + (offset if lane > 0 else -offset) / max(width, 1e-6)
        row = tables[5][section, SECTION_CENTRE] - lane
        height = lane_height(tables, row, s, min(max(share, 0.0), 1.0))
    return surface_pose(tables, road, s, t + offset, t1, height)
