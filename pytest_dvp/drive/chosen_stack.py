"""A driving stack: what may be given for one, and which one was chosen."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Callable

    from ads.parameters import Parameters
    from openscenario.road.network import RoadNetwork
    from vehicle.messages import VehicleDescription

DriverFactory: TypeAlias = (
    "Callable[[Parameters, RoadNetwork, VehicleDescription], object]"
    "| Callable[[dict[str, int | float], RoadNetwork, VehicleDescription], object] | Callable[[], object]"
)


@dataclasses.dataclass(frozen=True)
class Ads:
    """A driving stack that was chosen.

    name     for people and the log, without a path
    word     what `--ads` takes to choose it again; None if no command line can name it
    factory  class or function that makes it, or the stack itself
    """

    name: str
    word: str | None
    factory: Any
