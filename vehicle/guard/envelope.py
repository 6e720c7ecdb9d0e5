"""The envelope of a real car: a file that says how fast and where it may drive at most."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vehicle.guard.messages import Area
from vehicle.toml_file import TomlError, read_toml

CORNERS = 3  # of an area, at least


class EnvelopeError(ValueError):
    """An envelope file cannot be used; one line that names the file."""


@dataclass(frozen=True, slots=True)
class Envelope:
    """`area`: corners (x, y) [m] in the map, in order; `max_speed` [m/s], None: the car's own."""

    area: Area
    max_speed: float | None = None


def read_envelope(path: Path) -> Envelope:
    """Read an envelope file.

        max_speed = 5.0
        area = [[-10.0, -20.0], [180.0, -20.0], [180.0, 60.0], [-10.0, 60.0]]

    Raises EnvelopeError.
    """
    try:
        table, _ = read_toml(path)
    except TomlError as error:
        raise EnvelopeError(f"{error.at(path)}: no envelope file: {error}") from None
    if not {"area"} <= set(table) <= {"area", "max_speed"}:
        raise EnvelopeError(f"{path}: found {sorted(table)}, allowed: area, and max_speed if you like")
    corners = table["area"]
    if not isinstance(corners, list) or len(corners) < CORNERS or not all(map(_corner, corners)):
        raise EnvelopeError(f"{path}: area must be a list of at least {CORNERS} corners [x, y] in m")
    speed = table.get("max_speed")
    if speed is not None and (not _number(speed) or speed <= 0.0):
        raise EnvelopeError(f"{path}: max_speed is {speed!r}, expected a number > 0 [m/s]")
    area = tuple((float(x), float(y)) for x, y in corners)
    return Envelope(area, None if speed is None else float(speed))


def _corner(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(_number, value))


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
