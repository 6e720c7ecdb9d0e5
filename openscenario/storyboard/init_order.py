"""The order of Init actions: that of the file, but what is relative to another entity waits for that one's own.

The standard names no order. Files put an entity relative to one that they place further down; done in the order of the
file it would stand relative to the origin.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import NamedTuple

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.nodes import Node

Step = tuple[Node, Entity | None]
NEEDS_SPEED = (model.SpeedAction, model.SpeedProfileAction, model.LongitudinalDistanceAction)


class Wish(NamedTuple):
    """What an action gives its entity (place, speed or nothing), and what it wants of which others."""

    gives: str
    wants: str
    of: frozenset[str]


def in_order(steps: list[Step]) -> list[Step]:
    """The steps, each after those that give other entities what it needs; as in the file where that is a circle."""
    left = [(step, _wish(*step)) for step in steps]
    if not any(wish.of for _, wish in left):
        return steps
    done: list[Step] = []
    while left:
        free = next((i for i in range(len(left)) if not _waits(i, left)), 0)
        done.append(left.pop(free)[0])
    return done


def _waits(i: int, left: list[tuple[Step, Wish]]) -> bool:
    (_, entity), wish = left[i]
    if any(left[j][0][1] is entity for j in range(i)):
        return True  # an entity's own actions keep their order
    return bool(wish.of) and any(
        giver is not entity and giver is not None and giver.name in wish.of and other.gives == wish.wants
        for (_, giver), other in left
    )


def _wish(node: Node, entity: Entity | None) -> Wish:
    element = node.element
    gives = "place" if isinstance(element, model.TeleportAction) else ""
    gives = "speed" if isinstance(element, model.SpeedAction) else gives
    wants = "speed" if isinstance(element, NEEDS_SPEED) else "place"
    return Wish(gives, wants, frozenset(_names(element)) - {entity.name} if entity is not None else frozenset())


def _names(element: object) -> Iterator[str]:
    """Names of entities anywhere in an element."""
    if isinstance(element, tuple):
        for item in element:
            yield from _names(item)
    elif is_dataclass(element):
        for field in fields(element):
            value = getattr(element, field.name)
            if field.name in ("entity_ref", "master_entity_ref") and isinstance(value, str):
                yield value
            elif is_dataclass(value) or isinstance(value, tuple):
                yield from _names(value)
