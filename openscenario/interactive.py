"""Which controllers of a scenario ask for a driver that reacts to traffic."""

from __future__ import annotations

import re
from typing import Final

from openscenario.model.entities import Controller

ASKED: Final = re.compile(
    r"(^|[^a-z])acc([^a-z]|controller|$)|adaptive.?cruise|interactive|(^|[^a-z])idm([^a-z]|$)|intelligent.?driver"
    r"|natural.?driver|npc_vehicle_control|car.?following|lane.?keep",
    re.IGNORECASE,
)
TELLING: Final = ("esminiController", "module", "type", "controller", "controllerType")  # properties that name a kind


def is_interactive(controller: Controller | None) -> bool:
    """Whether a controller asks for a driver that reacts to traffic."""
    if controller is None:
        return False
    names = (controller.name, *(controller.properties.get(name) or "" for name in TELLING))
    return any(ASKED.search(name) for name in names)
