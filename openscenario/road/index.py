"""Index: a uniform grid over sampled reference lines, and the search for the road position of a point.

A reference line is sampled to chords; each cell lists the chords that may be nearest to a point in it, sorted by road.
A search takes each road's nearest chord, refines s by Newton's method, and prefers the road whose lane holds the point.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from machine_code import compiled
from openscenario.road.lanes import centre_offset, nearest_lane, outer_border, section_at
from openscenario.road.pose import reference, slopes
from openscenario.road.profile import Floats, Ints
from openscenario.road.shapes import KIND, LENGTH, LINE, S
from openscenario.road.tables import (
    LANE_DIRECTION,
    ROAD_FLAT,
    ROAD_GEOMETRY,
    ROAD_GEOMETRY_END,
    SECTION_CENTRE,
    SECTION_LEFT,
    SECTION_RIGHT,
    Tables,
)

# chords (n, 7): x, y of both ends, s of both ends, largest |t| of a lane border; road of each chord; cell -> range of
# items; items -> chord; (x, y of the corner, cell size); (columns, rows)
Index: TypeAlias = tuple[Floats, Ints, Ints, Ints, Floats, Ints]

CHORD = 8.0  # m, longest chord
SAGITTA = 0.05  # m, largest distance of a chord from its curve
MARGIN = 6.0  # m beyond the outermost lane that the grid still covers
CELL = 10.0  # m
MOST_CELLS = 400_000  # chosen, not measured: it bounds memory
MOST_CHORDS = 20_000  # of one geometry row
MOST_REACH = 200.0  # m
ITERATIONS = 12  # at most, of the search for TOLERANCE; chosen, not measured
TOLERANCE = 1e-9  # m along the reference line
INSIDE = 1e-6  # m outside a lane that still counts as on it
ALIGNED = 0.98  # cos of the largest heading difference at which the hint's road is kept unseen
_X0, _Y0, _X1, _Y1, _S0, _S1, _REACH = range(7)


@compiled
def reach(tables: Tables, road: int, s: float) -> float:
    """Largest |t| [m] of any lane border at s [m]."""
    sections = tables[5]
    section = section_at(tables, road, s)
    start = centre_offset(tables, road, s)
    most = abs(start[0])
    for side in (-1, 1):
        count = sections[section, SECTION_RIGHT] if side < 0 else sections[section, SECTION_LEFT]
        border = start
        for step in range(1, count + 1):
            border = outer_border(tables, sections[section, SECTION_CENTRE] - side * step, side, s, border)
        most = max(most, abs(border[0]))
    return min(most, MOST_REACH)  # a slip in a width must not spread every chord over every cell


@compiled
def chord_count(tables: Tables, road: int, row: int) -> int:
    """Number of chords for a geometry row."""
    geometry = tables[0]
    length = float(geometry[row, LENGTH])
    step = CHORD
    if geometry[row, KIND] != LINE:
        most = 0.0
        for part in range(5):
            most = max(most, abs(reference(tables, road, geometry[row, S] + 0.2499 * part * length)[3]))
        if most > 0.0:
            step = min(CHORD, max(0.3, math.sqrt(8.0 * SAGITTA / most)))
    return max(1, math.ceil(min(length / step, MOST_CHORDS)))


@compiled
def make_chords(tables: Tables) -> tuple[Floats, Ints]:
    """Chords of all roads, in order of road and s."""
    geometry, roads = tables[0], tables[3]
    total = 0
    for road in range(roads.shape[0]):
        for row in range(roads[road, ROAD_GEOMETRY], roads[road, ROAD_GEOMETRY_END]):
            total += chord_count(tables, road, row)
    chords = np.empty((total, 7))
    owners = np.empty(total, dtype=np.int64)
    n = 0
    for road in range(roads.shape[0]):
        for row in range(roads[road, ROAD_GEOMETRY], roads[road, ROAD_GEOMETRY_END]):
            count = chord_count(tables, road, row)
            for part in range(count):
                s0 = geometry[row, S] + geometry[row, LENGTH] * part / count
                s1 = geometry[row, S] + geometry[row, LENGTH] * (part + 1) / count
                start = reference(tables, road, s0)
                end = reference(tables, road, s1 - 1e-9)
                chords[n, 0], chords[n, 1] = start[0], start[1]
                chords[n, 2], chords[n, 3] = end[0], end[1]
                chords[n, 4], chords[n, 5] = s0, s1
                chords[n, 6] = max(reach(tables, road, s0), reach(tables, road, s1))
                owners[n] = road
                n += 1
    return chords, owners


@compiled
def cell_range(chords: Floats, chord: int, grid: Floats, shape: Ints) -> tuple[int, int, int, int]:
    """Columns and rows (first, last + 1) of the cells that a chord may matter to."""
    far = chords[chord, 6] + MARGIN
    low_x = min(chords[chord, 0], chords[chord, 2]) - far
    high_x = max(chords[chord, 0], chords[chord, 2]) + far
    low_y = min(chords[chord, 1], chords[chord, 3]) - far
    high_y = max(chords[chord, 1], chords[chord, 3]) + far
    return (
        max(0, int((low_x - grid[0]) / grid[2])),
        min(shape[0], int((high_x - grid[0]) / grid[2]) + 1),
        max(0, int((low_y - grid[1]) / grid[2])),
        min(shape[1], int((high_y - grid[1]) / grid[2]) + 1),
    )


@compiled
def fill_cells(chords: Floats, grid: Floats, shape: Ints) -> tuple[Ints, Ints]:
    """For each cell the range of its items, and the items: chords in ascending order."""
    starts = np.zeros(shape[0] * shape[1] + 1, dtype=np.int64)
    for chord in range(chords.shape[0]):
        x0, x1, y0, y1 = cell_range(chords, chord, grid, shape)
        for column in range(x0, x1):
            for row in range(y0, y1):
                starts[column * shape[1] + row + 1] += 1
    for cell in range(shape[0] * shape[1]):
        starts[cell + 1] += starts[cell]
    items = np.empty(starts[-1], dtype=np.int64)
    filled = starts[:-1].copy()
    for chord in range(chords.shape[0]):
        x0, x1, y0, y1 = cell_range(chords, chord, grid, shape)
        for column in range(x0, x1):
            for row in range(y0, y1):
                cell = column * shape[1] + row
                items[filled[cell]] = chord
                filled[cell] += 1
    return starts, items


def make_index(tables: Tables) -> Index:
    """Index over all roads."""
    chords, owners = make_chords(tables)
    far = float(chords[:, 6].max()) + MARGIN
    low = np.minimum(chords[:, 0:2], chords[:, 2:4]).min(axis=0) - far
    high = np.maximum(chords[:, 0:2], chords[:, 2:4]).max(axis=0) + far
    span = high - low
    cell = max(CELL, math.sqrt(float(span[0] * span[1]) / MOST_CELLS))
    shape = np.array([int(span[0] / cell) + 1, int(span[1] / cell) + 1], dtype=np.int64)
    grid = np.array([low[0], low[1], cell])
    starts, items = fill_cells(chords, grid, shape)
    return chords, owners, starts, items, grid, shape


@compiled
def project(tables: Tables, road: int, x: float, y: float, s: float) -> tuple[float, float, float, float]:
    """s, t [m] of a point (x, y) near s on a road, how far [m] it lies beyond the road's ends, road heading [rad]."""
    length = tables[2][road]
    flat = tables[3][road, ROAD_FLAT]
    t = along = heading = 0.0
    for _ in range(ITERATIONS):
        x0, y0, heading, kappa, _ = reference(tables, road, s)
        c, sn = math.cos(heading), math.sin(heading)
        dx, dy = x - x0, y - y0
        along = dx * c + dy * sn
        t = across = -dx * sn + dy * c
        if not flat:
            _, z1, _, roll, _ = slopes(tables, road, s)
            t = across / max(math.cos(roll), 0.1)
            along += t * math.sin(roll) * z1 / math.sqrt(1.0 + z1 * z1)
        step = along / max(1.0 - kappa * across, 0.2)
        target = min(max(s + min(max(step, -50.0), 50.0), 0.0), length)
        moved = abs(target - s)
        s = target
        if moved < TOLERANCE:
            break
    beyond = abs(along) if (s <= 0.0 or s >= length) else 0.0
    return s, t, beyond, heading


@compiled
def match(
    tables: Tables, road: int, x: float, y: float, z: float, h: float, s: float, drivable: bool
) -> tuple[float, int, float, float, float, float, float]:
    """How a point fits on a road near s: cost, lane, s, t, t of the lane's middle, heading, distance outside [m]."""
    s, t, beyond, heading = project(tables, road, x, y, s)
    lane, middle, width, outside = nearest_lane(tables, road, s, t, drivable, 0)
    outside = math.sqrt(outside * outside + beyond * beyond)
    cost = 10.0 * outside + 0.2 * abs(t - middle) / max(width, 1.0)
    if not math.isnan(z):
        elevation, z1, _, roll, _ = slopes(tables, road, s)
        gap = abs(z - elevation - t * math.sin(roll) / math.sqrt(1.0 + z1 * z1))
        cost += 10.0 * max(0.0, gap - 1.0)  # within 1 m it is the same road surface, whatever its kerbs
    if not math.isnan(h):
        row = tables[5][section_at(tables, road, s), SECTION_CENTRE] - lane
        cost += 2.0 * (1.0 - tables[6][row, LANE_DIRECTION] * math.cos(h - heading))
    return cost, lane, s, t, middle, heading, outside


@compiled
def locate(
    tables: Tables,
    index: Index,
    x: float,
    y: float,
    z: float,
    h: float,
    hint_road: int,
    hint_s: float,
    drivable: bool,
) -> tuple[int, int, float, float, float, float, bool]:
    """Road, lane, s, t, offset from the lane's middle [m], road heading [rad], whether a lane holds the point.

    z, h: NaN if unknown; hint_road: -1 for none. Road -1: no lane anywhere.
    """
    chords, owners, starts, items, grid, shape = index
    if hint_road >= 0:
        cost, lane, s, t, middle, heading, outside = match(tables, hint_road, x, y, z, h, hint_s, drivable)
        known = math.isnan(h) or abs(math.cos(h - heading)) > ALIGNED
        if outside <= 0.0 and known and cost < 10.0 and abs(s - hint_s) < 30.0:
            return hint_road, lane, s, t, t - middle, heading, True
    best_road, best = -1, (math.inf, 0, 0.0, 0.0, 0.0, 0.0, math.inf)
    column, line = math.floor((x - grid[0]) / grid[2]), math.floor((y - grid[1]) / grid[2])
    for everywhere in (False, True):
        first, last = 0, 0
        if everywhere:
            last = chords.shape[0]
        elif 0 <= column < shape[0] and 0 <= line < shape[1]:
            cell = int(column) * shape[1] + int(line)
            first, last = starts[cell], starts[cell + 1]
        # no chord seen yet; not -1, whose literal type would compile all of `match` twice
        road, near, near_s, near_reach = hint_road, math.inf, 0.0, 0.0
        for item in range(first, last + 1):
            chord = -1
            if item < last:
                chord = item if everywhere else items[item]
            if chord < 0 or owners[chord] != road:
                if (near - near_reach) * 10.0 < best[0]:
                    fit = match(tables, road, x, y, z, h, near_s, drivable)
                    cost = fit[0] - (0.05 if road == hint_road and fit[6] <= INSIDE else 0.0)
                    if fit[6] < math.inf and cost < best[0]:
                        best_road = road
                        best = (cost, fit[1], fit[2], fit[3], fit[4], fit[5], fit[6])
                if chord < 0:
                    break
                road, near = owners[chord], math.inf
            ax, ay = chords[chord, 0], chords[chord, 1]
            bx, by = chords[chord, 2] - ax, chords[chord, 3] - ay
            u = ((x - ax) * bx + (y - ay) * by) / max(bx * bx + by * by, 1e-12)
            u = min(max(u, 0.0), 1.0)
            away = math.hypot(x - ax - u * bx, y - ay - u * by)
            if away < near:
                near = away
                near_s = chords[chord, 4] + u * (chords[chord, 5] - chords[chord, 4])
                near_reach = chords[chord, 6]
        if best_road >= 0 and best[6] < MARGIN - 1.0:
            break
    return best_road, best[1], best[2], best[3], best[3] - best[4], best[5], best[6] <= INSIDE
