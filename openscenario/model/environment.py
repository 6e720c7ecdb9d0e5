"""Environment: time of day, weather, road condition."""

from __future__ import annotations

from dataclasses import dataclass, field

from openscenario.model.declarations import File, ParameterDeclaration, Properties
from openscenario.model.entities import BoundingBox
from openscenario.model.enums import CloudState, FractionalCloudCover, PrecipitationType, Wetness
from openscenario.model.kinds import DateTime, Element, NonNegative, Radian, VisualRange, WindSpeed, xml

HALF_TURN = 3.1416  # rad; pi rounded up, as files write it


@dataclass(frozen=True, slots=True)
class TimeOfDay(Element):
    animation: bool
    date_time: DateTime


@dataclass(frozen=True, slots=True)
class Sun(Element):
    """`illuminance` [lx] since 1.2, `intensity` [W/m^2] before."""

    azimuth: Radian
    elevation: Radian
    illuminance: NonNegative | None = None
    intensity: NonNegative | None = None

    @property
    def in_degrees(self) -> bool:
        """True if the elevation is no angle in radians, which lies within half a turn: degrees are meant, of
        the azimuth as well."""
        return abs(self.elevation) > HALF_TURN


@dataclass(frozen=True, slots=True)
class Fog(Element):
    visual_range: VisualRange
    bounding_box: BoundingBox | None = None


@dataclass(frozen=True, slots=True)
class Precipitation(Element):
    """`precipitation_intensity` [mm/h] since 1.1, `intensity` [1] before."""

    precipitation_type: PrecipitationType
    precipitation_intensity: NonNegative | None = None
    intensity: NonNegative | None = None


@dataclass(frozen=True, slots=True)
class Wind(Element):
    """Direction [rad] the wind blows to, speed [m/s]."""

    direction: Radian
    speed: WindSpeed


@dataclass(frozen=True, slots=True)
class DomeImage(Element):
    dome_file: File
    azimuth_offset: Radian = 0.0


@dataclass(frozen=True, slots=True)
class Weather(Element):
    """`atmospheric_pressure` [Pa], `temperature` [K]."""

    cloud_state: CloudState | None = None
    fractional_cloud_cover: FractionalCloudCover | None = None
    atmospheric_pressure: NonNegative | None = None
    temperature: NonNegative | None = None
    sun: Sun | None = None
    fog: Fog | None = None
    precipitation: Precipitation | None = None
    wind: Wind | None = None
    dome_image: DomeImage | None = None


@dataclass(frozen=True, slots=True)
class RoadCondition(Element):
    friction_scale_factor: NonNegative
    wetness: Wetness | None = None
    properties: Properties | None = None


@dataclass(frozen=True, slots=True)
class Environment(Element):
    name: str
    time_of_day: TimeOfDay | None = None
    weather: Weather | None = None
    road_condition: RoadCondition | None = None
    parameter_declarations: tuple[ParameterDeclaration, ...] = field(
        metadata=xml("ParameterDeclarations/ParameterDeclaration"), default=()
    )
