"""Map frame to latitude and longitude: east, north, up of a tangent plane on WGS84 at an origin, exact both ways.

Source: NIMA TR8350.2 (WGS84); P. Groves, Principles of GNSS, 2nd ed., secs. 2.4.3 and C.2 (ECEF to geodetic).
"""

from __future__ import annotations

from math import atan2, cos, degrees, hypot, radians, sin, sqrt
from typing import NamedTuple

A = 6378137.0  # m
F = 1.0 / 298.257223563  # flattening of WGS 84
E2 = F * (2.0 - F)


class Origin(NamedTuple):
    """Where the map frame's origin lies: latitude, longitude [deg], height above the ellipsoid [m]."""

    latitude: float
    longitude: float
    height: float = 0.0


DEFAULT_ORIGIN = Origin(40.512, -3.348, 590.0)  # for maps without a georeference: any place would do


def to_geodetic(x: float, y: float, z: float, origin: Origin) -> tuple[float, float, float]:
    """Latitude, longitude [deg], height [m] of the point x (east), y (north), z (up) [m] from the origin."""
    lat, lon = radians(origin.latitude), radians(origin.longitude)
    sl, cl, so, co = sin(lat), cos(lat), sin(lon), cos(lon)
    ox, oy, oz = _ecef(lat, lon, origin.height)
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
    """East, north, up [m] of a place [deg, deg, m] from the origin."""
    lat, lon = radians(origin.latitude), radians(origin.longitude)
    sl, cl, so, co = sin(lat), cos(lat), sin(lon), cos(lon)
    ox, oy, oz = _ecef(lat, lon, origin.height)
    px, py, pz = _ecef(radians(latitude), radians(longitude), height)
    dx, dy, dz = px - ox, py - oy, pz - oz
    return -so * dx + co * dy, -sl * co * dx - sl * so * dy + cl * dz, cl * co * dx + cl * so * dy + sl * dz


def _ecef(lat: float, lon: float, height: float) -> tuple[float, float, float]:
    n = A / sqrt(1.0 - E2 * sin(lat) ** 2)
    return (n + height) * cos(lat) * cos(lon), (n + height) * cos(lat) * sin(lon), (n * (1.0 - E2) + height) * sin(lat)
