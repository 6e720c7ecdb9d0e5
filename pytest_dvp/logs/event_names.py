"""What the events of a storyboard are called where each must be one: in logs, gates and summaries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from openscenario.model.conditions import ByEntityCondition, CollisionCondition
from openscenario.model.entities import EntityRef

if TYPE_CHECKING:
    from openscenario.model.scenario import Scenario
    from openscenario.model.storyboard import Event
    from openscenario.storyboard.nodes import Transition

Path = tuple[str, ...]


class EventNames:
    """Names of a scenario's events, in file order, no two alike.

    An event whose name another one has, as those of a catalogue manoeuvre that is used several times, is qualified by
    as many of its parents as it takes, as a reference of the standard is: `GroupOfB::CutIn::CutInEvent`.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._events = [
            ((story.name, act.name, group.name, maneuver.name, event.name), event)
            for story in scenario.storyboard.stories
            for act in story.acts
            for group in act.maneuver_groups
            for maneuver in group.maneuvers
            for event in maneuver.events
        ]
        self._names = unique_names([path for path, _ in self._events])

    def __iter__(self) -> Iterator[str]:
        return iter(self._names.values())

    def of_collisions(self, ego: str) -> list[str]:
        """Those that can only fire once the ego hits something: that they never did is what a test wants to see."""
        return list(
            dict.fromkeys(self._names[path] for path, event in self._events if _waits_for_collision(event, ego))
        )

    def of(self, step: Transition) -> str:
        """What is said of the element of a transition: for an event its name here, for others their own."""
        return self._names.get(step.path, step.element) if step.kind == "event" else step.element


def _waits_for_collision(event: Event, ego: str) -> bool:
    groups = event.start_trigger.condition_groups if event.start_trigger is not None else ()
    return bool(groups) and all(any(_is_collision(c.condition, ego) for c in group.conditions) for group in groups)


def _is_collision(condition: object, ego: str) -> bool:
    if not isinstance(condition, ByEntityCondition) or not isinstance(condition.entity_condition, CollisionCondition):
        return False
    named = {reference.entity_ref for reference in condition.triggering_entities.entity_refs}
    target = condition.entity_condition.target
    return named == {ego} or (isinstance(target, EntityRef) and target.entity_ref == ego)


def unique_names(paths: Sequence[Path]) -> dict[Path, str]:
    """The shortest end of each path that no other path has, its parts joined by `::`."""
    different = list(dict.fromkeys(paths))
    ends: dict[Path, int] = {}
    for path in different:
        for length in range(1, len(path) + 1):
            ends[path[-length:]] = ends.get(path[-length:], 0) + 1
    return {
        path: "::".join(next((path[-n:] for n in range(1, len(path)) if ends[path[-n:]] == 1), path))
        for path in different
    }
