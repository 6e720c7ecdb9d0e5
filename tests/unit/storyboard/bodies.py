"""Entities without a scenario round them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from openscenario.storyboard.entity import Entity


def car(name: str = "A", *, bare: bool = False, **more: Any) -> Any:
    """4 m by 2 m, its middle 1 m ahead of the reference point; or one of which the file says nothing."""
    box = SimpleNamespace(dimensions=SimpleNamespace(length=4.0, width=2.0, height=1.5),
                          center=SimpleNamespace(x=1.0, y=0.0, z=0.75))  # fmt: skip
    able = SimpleNamespace(max_speed=50.0, max_acceleration=3.0, max_deceleration=6.0, max_acceleration_rate=None,
                           max_deceleration_rate=2.0)  # fmt: skip
    told: dict[str, Any] = {} if bare else {"properties": {}, "performance": able}
    told |= more
    made: Any = SimpleNamespace(name=name, kind=told.pop("kind", "vehicle"), category="car",
                                bounding_box=None if bare else box, entity=SimpleNamespace(**told))  # fmt: skip
    return Entity(made, external=False)
