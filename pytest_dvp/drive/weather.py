"""What the environment of a scenario means for a simulated car: friction under its wheels, range of its sensors.

Friction and weather are independent unless the file couples them: rain alone does not make the road slippery.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

from vehicle.sensors.air import extinction_of_fog, extinction_of_precipitation

if TYPE_CHECKING:
    from openscenario.model import Environment

NOMINAL = 1.0
"""Friction coefficient [-] of a road with a frictionScaleFactor of 1: dry asphalt has 0.9 to 1.1."""


@runtime_checkable
class NeedsFriction(Protocol):
    """A vehicle that must be told how slippery the road is; a real one feels it."""

    def limit_friction(self, friction: float | None) -> None:
        """Say the friction coefficient [-, >= 0] of the road; None: the road that the model was made for."""
        ...


class Weather:
    """The last environment that the storyboard has set, as numbers.

    friction    coefficient [-] of the road; None where the file states none, or one that is not below nominal
    extinction  of the air [1/m]
    """

    def __init__(self) -> None:
        self._seen: Environment | None = None
        self.friction: float | None = None
        self.extinction = 0.0

    def look(self, environment: Environment | None) -> bool:
        """Take over what the storyboard has set; whether it is another environment than before.

        An element that an EnvironmentAction leaves out stays as it was (1.1 and later, class EnvironmentAction).
        """
        if environment is None or environment is self._seen:
            return False
        self._seen = environment
        if environment.road_condition is not None:
            scale = environment.road_condition.friction_scale_factor
            self.friction = NOMINAL * scale if scale < 1.0 else None
        weather = environment.weather
        if weather is not None:
            fog, rain = weather.fog, weather.precipitation
            self.extinction = 0.0 if fog is None else extinction_of_fog(fog.visual_range)
            if rain is not None and rain.precipitation_intensity is not None:
                self.extinction += extinction_of_precipitation(rain.precipitation_type, rain.precipitation_intensity)
        return True

    def __str__(self) -> str:
        said = [] if self.friction is None else [f"friction coefficient {self.friction:.3g}"]
        said += [f"extinction {self.extinction:.3g} 1/m"] if self.extinction > 0.0 else []
        return ", ".join(said) or "dry road, clear air"
