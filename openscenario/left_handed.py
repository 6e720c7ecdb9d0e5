"""Positions in the left-handed coordinates of CARLA, turned into those of the standard.

A scenario whose description begins with `CARLA:` is written in the coordinates of CARLA, in which y points to the right
of x and headings count clockwise. The same place on the road has the opposite y and h in the standard and in OpenDRIVE.
Lanes, s, t and offsets are those of the road in both.

Source: CARLA's scenario runner, `OpenScenarioConfiguration._set_scenario_name` (the prefix) and
`OpenScenarioParser.convert_position_to_transform` (y, dy and h change their sign in files without it). That a bend to
the left becomes one to the right follows from it.
"""

from __future__ import annotations

import dataclasses
from typing import Any, Final, TypeVar

from openscenario.model.kinds import Element
from openscenario.model.positions import (
    Clothoid,
    ClothoidSplineSegment,
    Orientation,
    RelativeObjectPosition,
    RelativeWorldPosition,
    WorldPosition,
)

PREFIX: Final = "CARLA:"
_MIRRORED: Final[dict[type[Element], tuple[str, ...]]] = {
    WorldPosition: ("y", "h"),
    RelativeWorldPosition: ("dy",),
    RelativeObjectPosition: ("dy",),
    Orientation: ("h",),
    Clothoid: ("curvature", "curvature_prime"),
    ClothoidSplineSegment: ("curvature_start", "curvature_end", "h_offset"),
}
_E = TypeVar("_E", bound=Element)


def right_handed(element: _E) -> _E:
    """The element with all positions in it in the standard's coordinates; the element itself where none changes."""
    mirrored = _MIRRORED.get(type(element), ())
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(element):
        value = getattr(element, field.name)
        new = -value if field.name in mirrored and value else _inside(value)
        if new is not value:
            changes[field.name] = new
    return dataclasses.replace(element, **changes) if changes else element


def _inside(value: Any) -> Any:
    """The same for what a field holds: an element, several of them, or something else."""
    if isinstance(value, Element):
        return right_handed(value)
    if isinstance(value, tuple):
        new = tuple(_inside(each) for each in value)
        return new if any(one is not other for one, other in zip(new, value, strict=True)) else value
    return value
