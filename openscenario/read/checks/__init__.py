"""Checks of single elements beyond names and numbers; one file a family, found through the `check` decorator."""

from __future__ import annotations

from openscenario.read.checks import (
    actions,
    conditions,
    distributions,
    entities,
    environment,
    positions,
    shapes,
    storyboard,
)
from openscenario.read.checks.registry import CHECKS, check

__all__ = [
    "CHECKS",
    "actions",
    "check",
    "conditions",
    "distributions",
    "entities",
    "environment",
    "positions",
    "shapes",
    "storyboard",
]
