"""Units of log columns: what is written in a header -> SI.

Source of the factors: SI brochure, 9th edition, tables 8 and 9; knot and mile: BIPM/NIST SP 811, appendix B.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Unit(NamedTuple):
    """A unit: value in SI = value * scale + offset; `si` is the SI unit that it becomes."""

    si: str
    scale: float = 1.0
    offset: float = 0.0


_DEG = math.pi / 180.0
_G = 9.80665  # standard gravity, CGPM 1901 [m/s^2]

_TABLE: dict[str, Unit] = {}
for _si, _names in {
    "s": {
        "s sec second seconds": 1.0,
        "ms msec": 1e-3,
        "us µs μs usec": 1e-6,
        "ns nsec": 1e-9,
        "min": 60.0,
        "h": 3600.0,
    },
    "m": {"m meter metre meters metres": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048},
    "rad": {"rad radian radians": 1.0, "mrad": 1e-3, "deg ° degree degrees": _DEG},
    "m/s": {
        "m/s mps meter/s": 1.0,
        "km/h kmh kph kmph": 1 / 3.6,
        "mph mi/h": 0.44704,
        "kn kt knot knots": 1852 / 3600,
        "cm/s": 1e-2,
        "mm/s": 1e-3,
        "ft/s": 0.3048,
    },
    "m/s^2": {
        "m/s^2 m/s2 mps2 m/s/s meter/s^2 m.s^-2": 1.0,
        "g": _G,
        "mg": _G * 1e-3,
        "cm/s^2 cm/s2": 1e-2,
        "mm/s^2 mm/s2": 1e-3,
        "ft/s^2 ft/s2": 0.3048,
    },
    "m/s^3": {"m/s^3 m/s3 mps3": 1.0},
    "rad/s": {
        "rad/s rads radps rad/sec": 1.0,
        "deg/s °/s dps degps deg/sec": _DEG,
        "mrad/s": 1e-3,
        "rpm 1/min": math.pi / 30,
    },
    "rad/s^2": {"rad/s^2 rad/s2": 1.0, "deg/s^2 deg/s2 °/s^2": _DEG},
    "-": {"- 1 bool none unitless": 1.0, "% pct percent": 1e-2},
    "N": {"N": 1.0, "kN": 1e3},
    "Nm": {"Nm N.m N*m": 1.0, "kNm": 1e3},
    "Pa": {"Pa": 1.0, "hPa mbar": 1e2, "kPa": 1e3, "bar": 1e5, "MPa": 1e6, "psi": 6894.757},
    "A": {"A": 1.0, "mA": 1e-3},
    "V": {"V": 1.0, "mV": 1e-3},
    "W": {"W": 1.0, "kW": 1e3},
    "Hz": {"Hz": 1.0},
    "kg": {"kg": 1.0},
    "1/m": {"1/m m^-1": 1.0, "1/km": 1e-3},
    "K": {"K": 1.0},
}.items():
    for _spellings, _scale in _names.items():
        for _spelling in _spellings.split():
            _TABLE[_spelling] = Unit(_si, _scale)
_TABLE["degC"] = _TABLE["°C"] = Unit("K", 1.0, 273.15)

UNITS: Mapping[str, Unit] = MappingProxyType(_TABLE)
"""Every known spelling."""

# Lower-case spellings that can mean one thing only; "MA" or "Mg" stay unknown rather than guessed.
_LOWER: Mapping[str, str] = MappingProxyType({name.lower(): name for name in reversed(list(_TABLE))})

SUFFIXES: Mapping[str, str] = MappingProxyType(
    {
        **{
            name: name
            for name in ("mps", "kmh", "kph", "mph", "mps2", "rad", "deg", "radps", "degps", "dps", "rpm", "pct")
        },
        "rads": "rad/s",
        "ms2": "m/s^2",
        "ms": "ms",
        "us": "us",
        "ns": "ns",
        "percent": "%",
        "kpa": "kPa",
        "bar": "bar",
        "rad_s": "rad/s",
        "deg_s": "deg/s",
        "m_s": "m/s",
        "km_h": "km/h",
        "m_s2": "m/s^2",
        "mm": "mm",
        "cm": "cm",
        "km": "km",
        "nm": "Nm",
        "sec": "s",
        "s": "s",
        "m": "m",
        "g": "g",
        "a": "A",
        "n": "N",
        "v": "V",
    }
)
"""`v_mps`: endings of a name that state its unit."""

LETTERS = frozenset(("s", "m", "g", "a", "n", "v", "nm", "ms"))
"""Endings so short that they count only behind a name of the signal table or an alias."""


def find_unit(text: str) -> Unit | None:
    """The unit that `text` spells, None if it is not known."""
    word = text.strip().replace("²", "^2").replace("³", "^3").replace("**", "^").replace("·", ".").replace(" ", "")
    if word in _TABLE:
        return _TABLE[word]
    known = _LOWER.get(word.lower())
    return _TABLE[known] if known is not None else None


def units_of(si: str) -> tuple[str, ...]:
    """Spellings that become this SI unit, one of each size, for an error message."""
    seen: dict[float, str] = {}
    for name, unit in _TABLE.items():
        if unit.si == si:
            seen.setdefault(unit.scale, name)
    return tuple(seen.values())
