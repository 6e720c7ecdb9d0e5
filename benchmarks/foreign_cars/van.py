"""A fourth car, made after the rule of the diagnosis stood: a van on trailing arms whose wheels steer by Ackermann.

Front-wheel drive like the hatchback, but long, soft, tall and loaded in front; its wheels hang on arms that turn, so
that they move ahead when they spring in, and its inner front wheel steers by as much more as the bend asks for.
"""

from __future__ import annotations

from benchmarks.foreign_cars.car import ForeignCar

VAN = ForeignCar(
    2350.0, 3.45, 1.42, 1.70, 0.82, 0.345, (1150.0, 5600.0, 6100.0), 40e3, 3400.0, 12e3, 0.035, 0.030,
    (0.5, 0.5, 0.0, 0.0), 0.62, (8.2, 1.33), (11.0, 1.58), 0.95, 1.95, 0.011, arm=0.45, ackermann=1.0,
)  # fmt: skip
