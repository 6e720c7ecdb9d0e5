"""Units of length that are wrong by powers of ten: the column that is wrong is told, and not the clock."""

from __future__ import annotations

import numpy as np
import pytest
from known_motion import findings, rate_and_integral, times, way

from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.units import find_unit

RATE, INTEGRAL = rate_and_integral(0.05, 0.3)
SUSPECT = ("log.unit_suspect", "log.implausible_rate")


def log(scale: dict[str, float], every: int = 1) -> dict[str, FloatArray]:
    """A drive of 120 s with 50 rows a second, or every n-th of them; some columns in another unit."""
    t = times(120.0)
    v, yaw = 10.0 + INTEGRAL(t), 0.1 * INTEGRAL(t)
    columns = {"t": t, **way(t, v, yaw), "v": v, "yaw": yaw, "yaw_rate": 0.1 * RATE(t), "ax": RATE(t)}
    columns["ay"] = v * columns["yaw_rate"]
    return {name: (values * scale.get(name, 1.0))[::every] for name, values in columns.items()}


@pytest.mark.parametrize("every", [1, 5])
@pytest.mark.parametrize(
    ("scale", "element", "says"),
    [
        ({"v": 1e3}, "column v", "mm/s stored as m/s"),
        ({"v": 1e2}, "column v", "cm/s stored as m/s"),
        ({"v": 1 / 0.3048}, "column v", "ft/s stored as m/s"),
        ({"v": 3.6}, "column v", "km/h stored as m/s"),
        ({"x": 1e3, "y": 1e3}, "column x, y", "mm stored as m"),
        ({"x": 1e2, "y": 1e2}, "column x, y", "cm stored as m"),
        ({"x": 1e-3, "y": 1e-3}, "column v", "or x and y in km"),
        ({"ax": 1e3 / 9.80665}, "column ax", "mg or cm/s^2 stored as m/s^2"),
        ({"ay": 1e2}, "column ay", "mg or cm/s^2 stored as m/s^2"),
        ({"ax": 1e3}, "column ax", "mm/s^2 stored as m/s^2"),
    ],
)
def test_a_wrong_unit_of_length_is_the_only_finding(
    every: int, scale: dict[str, float], element: str, says: str
) -> None:
    (told,) = findings(log(scale, every), *SUSPECT)
    assert (told.code, told.element) == ("log.unit_suspect", element)
    assert says in told.message


@pytest.mark.parametrize("every", [1, 5, 25])
def test_milliseconds_for_seconds_are_still_the_clock(every: int) -> None:
    (told,) = findings(log({"t": 1e3}, every), *SUSPECT)
    assert told.code == "log.implausible_rate"


@pytest.mark.parametrize(
    ("unit", "metres"), [("mm/s", 1e-3), ("cm/s", 1e-2), ("ft/s", 0.3048), ("mm/s^2", 1e-3), ("ft/s2", 0.3048)]
)
def test_speeds_and_accelerations_have_the_units_of_lengths(unit: str, metres: float) -> None:
    known = find_unit(unit)
    assert known is not None
    assert known.scale == pytest.approx(metres)
    assert np.isclose(known.offset, 0.0)
