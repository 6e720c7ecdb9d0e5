"""Map frame and latitude, longitude: against PROJ, an independent implementation, and there and back."""

from __future__ import annotations

import pytest

from vehicle.wire.geodetic import Origin, to_geodetic, to_map

ORIGIN = Origin(40.512, -3.348, 590.0)
PLACES = [(0.0, 0.0, 0.0), (1000.0, 0.0, 0.0), (-350.0, 820.0, 12.0), (5000.0, -7000.0, 100.0)]


@pytest.mark.parametrize("place", PLACES)
def test_there_and_back_is_exact_to_a_micrometre(place: tuple[float, float, float]) -> None:
    assert to_map(*to_geodetic(*place, ORIGIN), ORIGIN) == pytest.approx(place, abs=1e-6)


@pytest.mark.parametrize("place", PLACES)
def test_proj_agrees_to_a_micrometre(place: tuple[float, float, float]) -> None:
    pyproj = pytest.importorskip("pyproj")
    pipeline = pyproj.Transformer.from_pipeline(
        "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
        f"+step +proj=topocentric +ellps=WGS84 +lat_0={ORIGIN.latitude} +lon_0={ORIGIN.longitude} +h_0={ORIGIN.height}"
    )
    latitude, longitude, height = to_geodetic(*place, ORIGIN)
    assert pipeline.transform(longitude, latitude, height) == pytest.approx(place, abs=1e-6)
