"""Since when entities have been standing, off the road, or at the end of it."""

from __future__ import annotations

import math

from openscenario.storyboard.entity import Entity
from openscenario.storyboard.ground import Ground


class RoadWatch:
    """Looks at every entity in every step; at the road under it only if a condition asks for that (`add`)."""

    def __init__(self, ground: Ground) -> None:
        self._ground = ground
        self._watched: set[str] = set()

    def add(self, entity: Entity) -> None:
        """Look at the road under this entity, too."""
        self._watched.add(entity.name)

    def note(self, entity: Entity, time: float) -> None:
        """Keep since when [s] an entity is as it is; `time` [s] is now."""
        if entity.name in self._watched:
            if entity.external:  # the others are told so by what moves them
                entity.end_of_road = self._ground.at_end(entity)
            off = not self._ground.on_road(entity)
            entity.off_since = min(entity.off_since, time) if off else math.inf
        entity.note_rest(time)
