"""What is taken for granted where a file errs and only one thing can be meant; each case is a warning.

None of it decides where somebody goes: what does is an error.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from openscenario import model
from openscenario.model.kinds import Element
from openscenario.plan import RENAMED, AttributePlan

NOT_GIVEN: Final = ("", "None", "null")
"""How tools write an optional attribute that they have no value for; `None` is that of scenariogeneration 0.16."""

WITHOUT: Final[Mapping[type[Element], Mapping[str, str]]] = {
    model.Condition: {"name": "", "delay": "0"},
    model.Actors: {"selectTriggeringEntities": "false"},
    model.ManeuverGroup: {"maximumExecutionCount": "1"},
    model.Property: {"value": ""},
    model.Environment: {"name": ""},
    model.MiscObject: {"mass": "0"},
    model.Pedestrian: {"mass": "0"},
    model.Trajectory: {"closed": "false"},
    model.Route: {"closed": "false"},
}
"""What required attributes are when they are missing: nobody uses them, or the same as for every similar element."""

EMPTY: Final[tuple[type[Element], ...]] = (model.Private, model.Story)
"""Elements that need something inside, and without it ask nothing of anybody."""

DESCRIBING: Final[tuple[type[Element], ...]] = (
    model.Controller,
    model.Environment,
    model.EnvironmentAction,
    model.License,
    model.MiscObject,
    model.Pedestrian,
    model.Property,
    model.ScenarioObject,
    model.Vehicle,
)
"""Elements that say what something is, not what it does: an attribute of a tool's own changes no way there."""


def meant(attribute: AttributePlan, text: str) -> str | None:
    """The allowed word of which a text differs in the case of its letters only, or None."""
    former = (old for old, new in RENAMED.items() if new in attribute.allowed)
    words = ("true", "false") if attribute.truth else (*attribute.allowed, *former)
    return next((word for word in words if word.casefold() == text.strip().casefold()), None)
