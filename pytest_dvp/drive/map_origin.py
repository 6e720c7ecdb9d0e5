"""Where on the earth the map of a scenario lies, from its road file's geoReference: what fixes are converted by.

A PROJ string of a projection that is true at its own origin (tmerc and others, WGS 84 or GRS 80, scale 1) is read here;
UTM, WKT and all else by pyproj if that is installed. Numbers of the road network are those of the projection, as the
header's offset has been applied to them. The map is taken for a plane at that place: within 10 km of it that differs
by less than 2 cm from a transverse Mercator, and by 40 cm (4 mm within 1 km) from UTM near the edge of its zone. A
projection that distorts shapes, such as Web Mercator, is refused.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from openscenario.road.network import RoadNetwork

if TYPE_CHECKING:
    from vehicle.wire.geodetic import Origin

PLANES = ("tmerc", "etmerc", "aeqd", "stere", "sterea", "ortho", "laea")  # touch the ellipsoid at lat_0, lon_0
ELLIPSOIDS = ("WGS84", "GRS80")  # differ by 0.1 mm
NAMES = {"proj", "lat_0", "lon_0", "k", "k_0", "x_0", "y_0", "ellps", "datum", "units"}  # all else may change the plane
HARMLESS = {"no_defs", "type", "wktext", "geoidgrids", "vunits"}  # of heights, or for the reader of the string
FAR = 10_000.0  # m between the roads and such an origin: there the plane is less than 2 cm off
BASE = 100.0  # m over which the direction and scale of a projection are measured; chosen: bends by less than 0.1 mm
DISTORTS = 1e-4  # of a length or rad of a right angle, at the roads; chosen: 10 cm in 1 km
_TERM = re.compile(r"\+(\w+)(?:=(\S+))?")


def map_origin(network: RoadNetwork) -> tuple[Origin | None, str]:
    """Origin of a road network's map; None without a geoReference, or, with one sentence why, if it cannot be read."""
    text = network.geo_reference.strip()
    if not text:
        return None, ""
    try:
        return _of_plane(text, network) or _by_pyproj(text, network), ""
    except ValueError as error:
        return None, f"where the map lies is not known: geoReference {text.split()[0][:40]!r} of the road file {error}"


def _of_plane(text: str, network: RoadNetwork) -> Origin | None:
    from vehicle.wire.geodetic import Origin

    terms = {name: value or "" for name, value in _TERM.findall(text)}
    named = {"proj", "lat_0", "lon_0"} <= set(terms) and terms["proj"] in PLANES
    usual = {terms.get("ellps", "WGS84"), terms.get("datum", "WGS84")} <= set(ELLIPSOIDS)
    if not named or not usual or terms.get("units", "m") != "m" or set(terms) - NAMES - HARMLESS:
        return None
    try:
        latitude, longitude, x, y, k, k_0 = (
            float(terms.get(name, default))
            for name, default in (("lat_0", 0), ("lon_0", 0), ("x_0", 0), ("y_0", 0), ("k", 1), ("k_0", 1))
        )
    except ValueError:
        return None
    away = math.dist(_place(network), (x, y))
    there = abs(latitude) <= 90.0 and k == k_0 == 1.0 and away <= FAR
    return Origin(latitude, longitude, None, x, y) if there else None


def _by_pyproj(text: str, network: RoadNetwork) -> Origin:
    """Raises ValueError, which says why not."""
    from vehicle.wire.geodetic import Origin, to_map

    try:
        from pyproj import CRS, Transformer
        from pyproj.exceptions import ProjError
    except ImportError:
        raise ValueError("needs pyproj (pip install -e '.[geo]' from the checkout)") from None
    try:
        given = CRS.from_user_input(text)
        back = Transformer.from_crs(given, CRS.from_epsg(4326), always_xy=True)
    except ProjError as error:
        raise ValueError(f"is no projection ({str(error).splitlines()[0][:80]})") from None
    if not given.is_projected:
        raise ValueError("is no projection to a plane")
    x, y = _place(network)
    longitude, latitude = back.transform(x, y)
    ahead, beside = back.transform(x + BASE, y), back.transform(x, y + BASE)
    if not all(map(math.isfinite, (longitude, latitude, *ahead, *beside))):
        raise ValueError("has no place for the roads of the file")
    here = Origin(latitude, longitude, None)
    east, north, _ = to_map(ahead[1], ahead[0], 0.0, here)
    if math.dist((-north, east), to_map(beside[1], beside[0], 0.0, here)[:2]) > DISTORTS * math.hypot(east, north):
        raise ValueError("distorts the shape of the roads")
    scale = BASE / math.hypot(east, north)
    return Origin(latitude, longitude, None, x, y, math.atan2(north, east), scale)


def _place(network: RoadNetwork) -> tuple[float, float]:
    """A place [m] among the roads: the middle of where they begin."""
    begins = [road.geometries[0] for road in network.file.roads if road.geometries]
    xs, ys = [each.x for each in begins], [each.y for each in begins]
    return 0.5 * (min(xs) + max(xs)), 0.5 * (min(ys) + max(ys))
