"""Map frame to latitude and longitude: a tangent plane on WGS84 at an origin, x east and y north unless it is turned.

Source: NIMA TR8350.2 (WGS84); P. Groves, Principles of GNSS, 2nd ed., secs. 2.4.3 and C.2 (ECEF to geodetic).
"""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, cos, degrees, hypot, radians, sin, sqrt
from typing import Any, NamedTuple

A = 6378137.0  # m
F = 1.0 / 298.257223563  # flattening of WGS 84
E2 = F * (2.0 - F)


class Origin(NamedTuple):
    """Where a place of the map lies: latitude, longitude [deg], height above the ellipsoid [m].

    height None: the map's metres are those of the ellipsoid, as of any projection; heights then change no x and y
    x, y        that place in the map [m]
    turn        of the map's x axis from east, counter-clockwise [rad]
    scale       metres of the map in a metre
    """

    latitude: float
    longitude: float
    height: float | None = 0.0
    x: float = 0.0
    y: float = 0.0
    turn: float = 0.0
    scale: float = 1.0


DEFAULT_ORIGIN = Origin(40.512, -3.348, 590.0)  # for maps without a georeference: any place would do
LARGEST: Mapping[str, float] = {"latitude": 90.0, "longitude": 180.0, "height": 9000.0, "x": 1e8, "y": 1e8, "turn": 6.3}
"""Keys of an origin in a user's file, with how large each may be; latitude and longitude are needed."""


def read_origin(given: Any) -> Origin:
    """The origin that a user's file states: a table with keys of LARGEST, without a height that of the ellipsoid.

    Raises ValueError, with what is allowed.
    """
    if not isinstance(given, dict) or not {"latitude", "longitude"} <= set(given):
        raise ValueError(f"found {given!r}, allowed: a table with latitude and longitude, and {', '.join(OTHERS)}")
    for key, value in given.items():
        if key not in LARGEST:
            raise ValueError(f"{key} is unknown, allowed: {', '.join(LARGEST)}")
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not abs(value) <= LARGEST[key]:
            raise ValueError(f"{key}: found {value!r}, allowed: {-LARGEST[key]:g} to {LARGEST[key]:g}")
    height = None if "height" not in given else float(given["height"])
    return Origin(**{key: float(value) for key, value in given.items() if key != "height"})._replace(height=height)


OTHERS = tuple(LARGEST)[2:]


def to_geodetic(x: float, y: float, z: float, origin: Origin) -> tuple[float, float, float]:
    """Latitude, longitude [deg], height [m] of the point x, y of the map, z (up) [m] from the origin."""
    lat, lon = radians(origin.latitude), radians(origin.longitude)
    x, y = (x - origin.x) / origin.scale, (y - origin.y) / origin.scale
    x, y = cos(origin.turn) * x - sin(origin.turn) * y, sin(origin.turn) * x + cos(origin.turn) * y
    sl, cl, so, co = sin(lat), cos(lat), sin(lon), cos(lon)
    ox, oy, oz = _ecef(lat, lon, origin.height or 0.0)
    px = ox - so * x - sl * co * y + cl * co * z
    py = oy + co * x - sl * so * y + cl * so * z
    pz = oz + cl * y + sl * z
    across = hypot(px, py)
    found, height = atan2(pz, across * (1.0 - E2)), 0.0
    for _ in range(8):  # contracts by e^2 each time: below 1e-12 rad after five
        n = A / sqrt(1.0 - E2 * sin(found) ** 2)
        height = across / cos(found) - n
        found = atan2(pz, across * (1.0 - E2 * n / (n + height)))
    return degrees(found), degrees(atan2(py, px)), height


def to_map(latitude: float, longitude: float, height: float, origin: Origin) -> tuple[float, float, float]:
    """Place in the map x, y, and up from the origin [m], of a place [deg, deg, m]."""
    lat, lon = radians(origin.latitude), radians(origin.longitude)
    sl, cl, so, co = sin(lat), cos(lat), sin(lon), cos(lon)
    ox, oy, oz = _ecef(lat, lon, origin.height or 0.0)
    px, py, pz = _ecef(radians(latitude), radians(longitude), 0.0 if origin.height is None else height)
    dx, dy, dz = px - ox, py - oy, pz - oz
    east, north = -so * dx + co * dy, -sl * co * dx - sl * so * dy + cl * dz
    x, y = cos(origin.turn) * east + sin(origin.turn) * north, cos(origin.turn) * north - sin(origin.turn) * east
    return origin.x + origin.scale * x, origin.y + origin.scale * y, cl * co * dx + cl * so * dy + sl * dz


def _ecef(lat: float, lon: float, height: float) -> tuple[float, float, float]:
    n = A / sqrt(1.0 - E2 * sin(lat) ** 2)
    return (n + height) * cos(lat) * cos(lon), (n + height) * cos(lat) * sin(lon), (n * (1.0 - E2) + height) * sin(lat)
