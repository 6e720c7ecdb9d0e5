"""What the environment of a scenario means for a simulated car: friction under its wheels, wind, range of its sensors.

Friction and weather are independent unless the file couples them: rain alone does not make the road slippery.
"""

from __future__ import annotations

import contextlib
import math
import re
from datetime import timedelta
from typing import TYPE_CHECKING, Final, Protocol, runtime_checkable

from openscenario.values import moment
from pytest_dvp.logs.log import Log
from vehicle.messages import Light
from vehicle.model.bus import GRAVITY
from vehicle.sensors.air import LEFT, extinction_of_fog, extinction_of_precipitation
from vehicle.sensors.light import EFFICACY, clear_sky, glare_angle, is_dark, sun_place, sunlight

if TYPE_CHECKING:
    from openscenario import model

NOMINAL: Final = 1.0
"""Friction coefficient [-] of a road with a frictionScaleFactor of 1: dry asphalt has 0.9 to 1.1."""
LATITUDE: Final = 50.0  # deg, where the road does not say where on the earth it lies: the middle of Europe
OKTAS: Final = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
CLEAR: Final = "dry road, clear air"
MOST: Final = 3  # changes of the environment that the notes of a run tell: roads of changing friction have many
COVERED: Final = ("overcast", "rainy")  # states of the clouds that let no sun through


@runtime_checkable
class NeedsFriction(Protocol):
    """A vehicle that must be told how slippery the road is; a real one feels it."""

    def limit_friction(self, friction: float | None) -> None:
        """Say the friction coefficient [-, >= 0] of the road; None: the road that the model was made for."""
        ...


@runtime_checkable
class NeedsWind(Protocol):
    """A vehicle that must be told how the air moves; a real one feels it."""

    def blow(self, x: float, y: float) -> None:
        """Say the velocity of the air [m/s, map frame]."""
        ...


class Weather:
    """The last environment that the storyboard has set, as numbers.

    friction    coefficient [-] of the road; None where the file states none, or one that is not below nominal
    extinction  of the air [1/m]
    wind        velocity of the air [m/s, map frame]
    light       of the sun; None where the file states neither sun nor time of day
    """

    def __init__(self, geo_reference: str = "") -> None:
        found = re.search(r"\+lat_0=(-?[0-9.]+)", geo_reference)
        self._latitude = math.radians(float(found[1]) if found and float(found[1]) else LATITUDE)
        self._seen: model.Environment | None = None
        self._scale = self._lane = 1.0
        self._time: model.TimeOfDay | None = None
        self._since = 0.0
        self._sun: model.Sun | None = None
        self._cover = 0.0
        self._fog = self._rain = 0.0
        self.extinction = 0.0
        self.wind = (0.0, 0.0)
        self.light: Light | None = None

    @property
    def friction(self) -> float | None:
        """Coefficient [-] of the road under the car; None: as much as the tyres need."""
        friction = NOMINAL * self._scale * self._lane
        return friction if friction < NOMINAL else None

    def look(self, environment: model.Environment | None, t: float = 0.0) -> bool:
        """Take over what the storyboard has set by `t` [s]; whether it is another environment than before.

        An element that an EnvironmentAction leaves out stays as it was (1.1 and later, class EnvironmentAction).
        """
        if environment is None or environment is self._seen:
            if self._time is not None and self._time.animation:
                self._shine(t)
            return False
        self._seen = environment
        if environment.road_condition is not None:
            self._scale = min(environment.road_condition.friction_scale_factor, 1.0)
        if environment.time_of_day is not None:
            self._time, self._since = environment.time_of_day, t
        weather = environment.weather
        if weather is not None:
            fog, rain, wind = weather.fog, weather.precipitation, weather.wind
            if fog is not None:
                self._fog = extinction_of_fog(fog.visual_range)
            if rain is not None and rain.precipitation_intensity is not None:
                self._rain = extinction_of_precipitation(rain.precipitation_type, rain.precipitation_intensity)
            self.extinction = self._fog + self._rain
            if wind is not None:
                self.wind = (wind.speed * math.cos(wind.direction), wind.speed * math.sin(wind.direction))
            self._sun = weather.sun or self._sun
            if weather.fractional_cloud_cover is not None or weather.cloud_state is not None:
                self._cover = _cover(weather)
        self._shine(t)
        return True

    def drive_on(self, friction: float) -> bool:
        """Take over the friction coefficient [-] of the lane's material; whether that changes what the road holds."""
        before, self._lane = self.friction, min(friction, 1.0)
        return self.friction != before

    def _shine(self, t: float) -> None:
        """The light at `t` [s]: of the sun that the file states, else of where it stands at the time of day."""
        sun = self._sun
        if sun is not None:
            stated = sun.illuminance if sun.intensity is None else EFFICACY * sun.intensity
            unit = math.radians(1.0) if sun.in_degrees else 1.0
            azimuth, elevation = sun.azimuth * unit, sun.elevation * unit
            illuminance = clear_sky(elevation) if stated is None else stated
            self.light = sunlight(azimuth, elevation, illuminance, self._cover)
        elif self._time is not None:
            now = moment(self._time.date_time)
            with contextlib.suppress(OverflowError):  # on the last day of the year 9999 it stays what it was
                now += timedelta(seconds=t - self._since if self._time.animation else 0.0)
            hour = now.hour + now.minute / 60.0 + now.second / 3600.0
            azimuth, elevation = sun_place(now.timetuple().tm_yday, hour, self._latitude)
            self.light = sunlight(azimuth, elevation, clear_sky(elevation), self._cover)

    def __str__(self) -> str:
        said = []
        if self.friction is not None:
            most = self.friction * GRAVITY
            said.append(f"friction coefficient {self.friction:.3g}, which brakes with {most:.3g} m/s^2 at most")
        if self.extinction > 0.0:
            sight = math.log(1.0 / LEFT) / self.extinction
            said.append(f"visual range {sight:.3g} m (extinction {self.extinction:.3g} 1/m)")
        if self.wind != (0.0, 0.0):
            direction = math.atan2(self.wind[1], self.wind[0]) % (2.0 * math.pi)
            said.append(f"wind {math.hypot(*self.wind):.3g} m/s towards {direction:.3g} rad")
        if self.light is not None:
            said += ["darkness"] if is_dark(self.light) else []
            angle = glare_angle(self.light)
            said += [f"glare within {angle:.3g} rad of the sun"] if angle > self.light.elevation > 0.0 else []
        return ", ".join(said) or CLEAR


def weather_notes(log: Log) -> tuple[str, ...]:
    """A line for each of the first changes of the environment that limits car or sensors; nothing in fair weather."""
    told = [each for each in log.events if each.kind == "environment" and each.text != CLEAR]
    lines = [f"environment {each.element} from t={each.t:.2f} s: {each.text}" for each in told[:MOST]]
    more = len(told) - MOST
    return (*lines, *([f"environment: {more} further changes, see the report"] if more > 0 else []))


def _cover(weather: model.Weather) -> float:
    """Share of the sky that clouds cover."""
    if weather.fractional_cloud_cover is not None:
        # nine: the sky cannot be seen, so it lets no more sun through than eight (WMO code table 2700)
        return min(1.0, OKTAS.index(weather.fractional_cloud_cover.removesuffix("Oktas")) / 8.0)
    return 1.0 if weather.cloud_state in COVERED else 0.0
