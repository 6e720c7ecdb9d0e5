"""What a camera's detector sees by the light of the sun: not far in the dark, and nothing close beside the sun.

- Dark is where less light falls on the road than at the end of civil twilight, 3.4 lx (RCA Electro-Optics Handbook,
  1974, table 6-2; the Glossary of Meteorology of the AMS has 3.5 to 2 lx there, and 585 to 410 lx at sunset). A camera
  then sees as far as its own low beams shine, 50 m: the distance at which UN Regulation No. 149 measures them. Lamps of
  others and of the street are not modelled.
- Glare: light of the sun that is scattered in lens and eye lies over the image as a veil of 10 E / a^2 [cd/m^2], E the
  illuminance [lx] across the line of sight, a the angle to the sun [deg] (Stiles and Holladay; CIE 146:2002, for 1 to
  30 degrees; ANSI/IES RP-8 has the same for lamps of roads). That is for eyes; that lenses are like them is an
  assumption. It leaves L / (L + veil) of a contrast, L the luminance of the surroundings: 18 % of the light that falls
  on the road, over pi. That a detector needs 5 % of a contrast, as in fog, is an assumption as well.
- The sky gives 12 % of what a surface that faces the sun gets from it (clear sky; 10 to 15 %, an estimate).
- Where a file states only the time of day: declination by P. I. Cooper (Solar Energy 12, 1969), and the light of a
  clear sky by the IES (Recommended practice for the calculation of daylight availability, Journal of the IES 13,
  1984): 127.5 klx exp(-0.21 / sin h) at the elevation h. Its print was not at hand to compare these two constants.

LiDARs bring their own light; what the sun adds to their noise is not modelled. Nor are shadows.
"""

from __future__ import annotations

import math
from typing import Final

from vehicle.messages import FloatArray, Light
from vehicle.sensors.air import LEFT

DARK: Final = 3.4  # lx
SUNSET: Final = 400.0  # lx on the road with the sun on the horizon; same source as DARK
CIVIL: Final = math.radians(6.0)  # below the horizon, at the end of civil twilight
LOW_BEAM: Final = 50.0  # m
REFLECTANCE: Final = 0.18  # of the surroundings: the grey that exposure meters take for a scene (ISO 2720)
SKY: Final = 0.12  # of the sun's illuminance
VEIL: Final = 10.0  # cd/m^2 deg^2 / lx
OUTSIDE: Final = 127_500.0  # lx, of the sun above the air
CLEAR: Final = 0.21  # what air of one thickness takes of it
EFFICACY: Final = 110.0  # lm/W of daylight; P. J. Littlefair, Lighting Research and Technology 17, 1985: 104 to 120
NEAREST: Final = 1.0  # deg: nearer to the sun the veil does not grow (the formula ends there)


def sunlight(azimuth: float, elevation: float, illuminance: float, cloud_cover: float = 0.0) -> Light:
    """The light of a sun at an azimuth (clockwise from +y, north) and elevation [rad].

    illuminance [lx] is that of a surface that faces it. Clouds that cover a share of the sky, 0 to 1, take this share
    of what comes straight, and leave the sky's; below the horizon nothing comes straight.
    """
    direct = illuminance * (1.0 - cloud_cover) if elevation > 0.0 else 0.0
    return Light(azimuth, elevation, direct, direct * math.sin(elevation) + SKY * illuminance)


def clear_sky(elevation: float) -> float:
    """Illuminance [lx] of a surface that faces the sun at an elevation [rad], through clear air.

    Near and below the horizon it is the one whose sky gives the road the twilight: SUNSET, and DARK at -6 degrees.
    """
    twilight: float = SUNSET * (DARK / SUNSET) ** (max(-elevation, 0.0) / CIVIL) / SKY
    return max(OUTSIDE * math.exp(-CLEAR / math.sin(elevation)), twilight) if elevation > 0.0 else twilight


def sun_place(day: int, hour: float, latitude: float) -> tuple[float, float]:
    """Azimuth (clockwise from north) and elevation [rad] of the sun: day of the year, hour of solar time, latitude
    [rad]."""
    declination = math.radians(23.45) * math.sin(2.0 * math.pi * (284 + day) / 365.0)
    turned = math.radians(15.0) * (hour - 12.0)
    east = -math.cos(declination) * math.sin(turned)
    north = math.cos(latitude) * math.sin(declination) - math.sin(latitude) * math.cos(declination) * math.cos(turned)
    up = math.sin(latitude) * math.sin(declination) + math.cos(latitude) * math.cos(declination) * math.cos(turned)
    return math.atan2(east, north) % (2.0 * math.pi), math.asin(min(max(up, -1.0), 1.0))


def is_dark(light: Light | None) -> bool:
    """Whether cameras need their headlamps; not where nothing is said of the light."""
    return light is not None and light.on_road < DARK


def lit_range(reach: float, light: Light | None) -> float:
    """How far [m] a camera sees in this light that reaches `reach` [m] by day."""
    return min(reach, LOW_BEAM) if is_dark(light) else reach


def glare_angle(light: Light | None) -> float:
    """Angle [rad] about the sun within which a detector finds nothing in clear air; 0 without glare.

    Of an object in the plane of the sun; the illuminance across the line of sight is taken as that of the sun.
    """
    if light is None or light.direct <= 0.0:
        return 0.0
    scene = REFLECTANCE * light.on_road / math.pi
    least = scene * (1.0 / LEFT - 1.0)  # the veil that leaves 5 % of the contrast
    return math.radians(math.sqrt(VEIL * light.direct / least))


def blinded(boxes: FloatArray, place: tuple[float, float, float], light: Light | None, extinction: float) -> list[bool]:
    """Which of some boxes, of shape (n, 9) as in Surroundings, a camera at `place` [m] misses for the sun behind them.

    extinction: of the air [1/m]; what fog leaves of a contrast, glare takes from.
    """
    if light is None or light.direct <= 0.0:
        return [False] * len(boxes)
    flat = math.cos(light.elevation)
    sun = flat * math.sin(light.azimuth), flat * math.cos(light.azimuth), math.sin(light.elevation)
    scene = REFLECTANCE * light.on_road / math.pi
    found = []
    for box in boxes.tolist():
        to = [there - here for there, here in zip(box[:3], place, strict=True)]
        distance = math.hypot(*to)
        ahead = sum(a * b for a, b in zip(to, sun, strict=True)) / max(distance, 1e-9)
        angle = max(math.degrees(math.acos(min(max(ahead, -1.0), 1.0))), NEAREST)
        veil = VEIL * light.direct * max(ahead, 0.0) / angle**2
        found.append(scene / (scene + veil) * math.exp(-extinction * distance) < LEFT)
    return found
