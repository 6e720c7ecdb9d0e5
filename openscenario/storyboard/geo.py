"""Latitude and longitude to the coordinates of a road file, through the projection that its header names."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

from openscenario.storyboard.unsupported import Unsupported

Project = Callable[[float, float], tuple[float, float]]
"""longitude, latitude [deg, WGS 84] -> x, y [m]"""


@functools.cache
def projection(geo_reference: str) -> Project:
    """The projection of an OpenDRIVE geoReference (a PROJ string or WKT).

    Raises:
        Unsupported: there is none, it cannot be read, or pyproj is not installed.
    """
    if not geo_reference.strip():
        raise Unsupported("the road network has no geoReference: where on the earth it lies is not known")
    try:
        from pyproj import CRS, Transformer
        from pyproj.exceptions import ProjError
    except ImportError:
        raise Unsupported("geographic positions need pyproj: pip install -e '.[geo]' from the checkout") from None
    try:
        transformer = Transformer.from_crs(CRS.from_epsg(4326), CRS.from_user_input(geo_reference), always_xy=True)
    except ProjError as error:
        raise Unsupported(
            "the geoReference of the road network is no projection", str(error).splitlines()[0][:120]
        ) from None

    def project(longitude: float, latitude: float) -> tuple[float, float]:
        x, y = transformer.transform(longitude, latitude)
        if not (math.isfinite(x) and math.isfinite(y)):
            raise Unsupported("outside the projection of the road network", f"{latitude}, {longitude} deg")
        return float(x), float(y)

    return project
