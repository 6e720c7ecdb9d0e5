"""Crosswalks: where pedestrians cross a road, with the outline in world coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import msgspec
import numpy as np

from openscenario.road.elements import Corner, Road, RoadObject
from openscenario.road.profile import Floats

PlaceOf = Callable[[float, float], tuple[float, float, float]]  # (s, t) -> x, y [m], heading [rad]
MAX_COPIES = 1000  # of a repeated object; chosen, not measured: a file with more is a mistake or an attack


class Crosswalk(NamedTuple):
    """A crosswalk: outline (k, 2) [m] in the world, and the range s_from..s_to [m] of its road that it covers."""

    id: str
    road: str
    s: float
    outline: Floats
    s_from: float
    s_to: float


def find_crosswalks(roads: Sequence[Road], place_of: Callable[[int], PlaceOf]) -> tuple[Crosswalk, ...]:
    """All crosswalk objects, in file order."""
    found = []
    for number, road in enumerate(roads):
        for item in road.objects:
            if item.type.lower() != "crosswalk":
                continue
            for copy in copies(item):
                corners = outline(copy, place_of(number))
                stations = [station for _, _, station in corners]
                points = np.array([(x, y) for x, y, _ in corners])
                s_from, s_to = max(0.0, min(stations)), min(road.length, max(stations))
                found.append(Crosswalk(item.id, road.id, copy.s, points, s_from, s_to))
    return tuple(found)


def copies(item: RoadObject) -> Iterator[RoadObject]:
    """The object itself, or each of its repetitions."""
    if not item.repeats:
        yield item
        return
    for repeat in item.repeats:
        if repeat.distance <= 0.0:  # one continuous object over the whole length
            middle = repeat.s + 0.5 * repeat.length
            width = item.width if math.isinf(repeat.width_start) else 0.5 * (repeat.width_start + repeat.width_end)
            t = 0.5 * (repeat.t_start + repeat.t_end)
            yield msgspec.structs.replace(
                item, s=middle, t=t, length=repeat.length, width=width, repeats=(), outlines=()
            )
            continue
        count = min(int(repeat.length / repeat.distance + 1e-9) + 1, MAX_COPIES)
        for index in range(count):
            along = index * repeat.distance
            share = along / repeat.length if repeat.length > 0.0 else 0.0
            t = repeat.t_start + share * (repeat.t_end - repeat.t_start)
            shifted = tuple(
                tuple(_shifted(corner, repeat.s + along - item.s, t - item.t) for corner in ring)
                for ring in item.outlines
            )
            yield msgspec.structs.replace(item, s=repeat.s + along, t=t, repeats=(), outlines=shifted)


def _shifted(corner: Corner, ds: float, dt: float) -> Corner:
    return Corner(corner.a + ds, corner.b + dt, True) if corner.on_road else corner


def outline(item: RoadObject, place: PlaceOf) -> list[tuple[float, float, float]]:
    """Corners of an object as (x, y, s) [m]: of its first outline, else of its length x width rectangle."""
    x0, y0, heading = place(item.s, item.t)
    heading += item.hdg
    c, sn = math.cos(heading), math.sin(heading)
    corners = item.outlines[0] if item.outlines else _rectangle(item)
    result = []
    for corner in corners:
        if corner.on_road:
            x, y, _ = place(corner.a, corner.b)
            result.append((x, y, corner.a))
        else:
            u, v = corner.a, corner.b
            station = item.s + u * math.cos(item.hdg) - v * math.sin(item.hdg)
            result.append((x0 + c * u - sn * v, y0 + sn * u + c * v, station))
    return result


def _rectangle(item: RoadObject) -> tuple[Corner, ...]:
    half_length = 0.5 * item.length or item.radius
    half_width = 0.5 * item.width or item.radius
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return tuple(Corner(a * half_length, b * half_width, False) for a, b in signs)
