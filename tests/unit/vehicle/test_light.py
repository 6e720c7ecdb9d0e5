"""The light of the sun: darkness shortens what a camera sees, glare hides what stands before the sun."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vehicle.messages import Light, Surroundings
from vehicle.sensors.light import (
    DARK,
    LOW_BEAM,
    REFLECTANCE,
    SKY,
    SUNSET,
    blinded,
    clear_sky,
    glare_angle,
    is_dark,
    lit_range,
    sun_place,
    sunlight,
)
from vehicle.sensors.suite import default_sensors

DEGREE = math.pi / 180.0


@pytest.mark.parametrize(
    ("day", "hour", "latitude", "azimuth", "elevation"),
    [
        (81, 12.0, 50.0, 180.0, 40.0),  # equinox, noon: 90 - 50
        (172, 12.0, 50.0, 180.0, 63.45),  # solstice, noon: 90 - 50 + 23.45
        (81, 18.0, 50.0, 270.0, 0.0),  # equinox: the sun goes down in the west
        (81, 6.0, 50.0, 90.0, 0.0),
    ],
)
def test_the_sun_stands_where_the_almanac_says(
    day: int, hour: float, latitude: float, azimuth: float, elevation: float
) -> None:
    found = sun_place(day, hour, latitude * DEGREE)
    assert found[0] / DEGREE == pytest.approx(azimuth, abs=0.2)
    assert found[1] / DEGREE == pytest.approx(elevation, abs=0.1)


@pytest.mark.parametrize(("elevation", "expected"), [(0.0, SUNSET), (-6.0, DARK), (-3.0, math.sqrt(SUNSET * DARK))])
def test_twilight(elevation: float, expected: float) -> None:
    light = sunlight(0.0, elevation * DEGREE, clear_sky(elevation * DEGREE))
    assert light.on_road == pytest.approx(expected)
    assert light.direct == 0.0


@pytest.mark.parametrize(("illuminance", "dark"), [(100_000.0, False), (40.0, False), (20.0, True), (0.0, True)])
def test_it_is_dark_below_3_4_lux_on_the_road(illuminance: float, dark: bool) -> None:
    """With the sun on the horizon the sky gives 12 %: 28.3 lx make 3.4."""
    light = sunlight(0.0, 0.0, illuminance)
    assert is_dark(light) is dark
    assert lit_range(80.0, light) == (LOW_BEAM if dark else 80.0)
    assert lit_range(30.0, light) == 30.0


@pytest.mark.parametrize("elevation", [1.0, 3.0, 6.0])
def test_the_angle_of_glare_in_closed_form(elevation: float) -> None:
    """10 E / a^2 = 19 x 0.18 (sin h + 0.12) E / pi, whatever E is."""
    expected = math.sqrt(10.0 * math.pi / (19.0 * REFLECTANCE * (math.sin(elevation * DEGREE) + SKY)))
    assert glare_angle(sunlight(0.0, elevation * DEGREE, 70_000.0)) / DEGREE == pytest.approx(expected)
    assert glare_angle(sunlight(0.0, elevation * DEGREE, 700.0)) / DEGREE == pytest.approx(expected)


@pytest.mark.parametrize(("off", "hidden"), [(0.0, True), (0.95, True), (1.05, False), (-1.05, False), (20.0, False)])
def test_who_stands_before_the_sun_is_not_found(off: float, hidden: bool) -> None:
    """`off`: in parts of the angle of glare, beside a sun on the horizon to the north (+y)."""
    light = sunlight(0.0, 1e-9, 50_000.0)
    angle = off * glare_angle(light)
    box = np.array([[60.0 * math.sin(angle), 60.0 * math.cos(angle), 1.4, 0.0, 4.5, 1.8, 1.5, 0.0, 0.0]])
    assert blinded(box, (0.0, 0.0, 1.4), light, 0.0) == [hidden]
    assert blinded(box, (0.0, 0.0, 1.4), None, 0.0) == [False]


def seen(light: Light | None, distance: float) -> bool:
    """Whether the camera of the default car sees a car ahead of it, to the east (+x); half a second of looks."""
    running = default_sensors().start([0.0] * 12, 7)
    box = np.array([[distance, 0.0, 0.75, 0.0, 4.5, 1.8, 1.5, 0.0, 0.0]])
    around = Surroundings(box, np.zeros(1, dtype=np.int64), ("a",), light=light)
    looks = [running.observe(0.05 * k, around).camera for k in range(12)]
    return any(look is not None and look.boxes for look in looks)


def test_the_camera_of_a_car() -> None:
    low_east = sunlight(0.5 * math.pi, 2.0 * DEGREE, 20_000.0)
    low_west = sunlight(1.5 * math.pi, 2.0 * DEGREE, 20_000.0)
    overcast = sunlight(0.5 * math.pi, 2.0 * DEGREE, 20_000.0, cloud_cover=1.0)
    night = sunlight(0.0, -0.5, 0.0)
    assert [seen(light, 60.0) for light in (None, low_east, low_west, overcast, night)] == [
        True,
        False,
        True,
        True,
        False,
    ]
    assert seen(night, 40.0)
