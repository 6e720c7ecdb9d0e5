"""All cars of another make, by name."""

from __future__ import annotations

from benchmarks.foreign_cars.car import CARS
from benchmarks.foreign_cars.van import VAN

FLEET = {**CARS, "van": VAN}
