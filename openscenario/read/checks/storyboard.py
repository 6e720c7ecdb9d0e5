"""Storyboard elements: their names, and actions that nobody would carry out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import get_args

from openscenario.model.actions import PrivateAction
from openscenario.model.conditions import ByEntityCondition, Trigger
from openscenario.model.kinds import Element
from openscenario.model.storyboard import Act, Action, Event, Maneuver, ManeuverGroup, Story, Storyboard
from openscenario.read.checks.registry import check
from openscenario.read.context import Context

_PRIVATE = get_args(PrivateAction)


@check(Storyboard)
def unique_stories(storyboard: Storyboard, context: Context) -> None:
    """Refuse two stories of one name."""
    _unique(storyboard.stories, context)


@check(Story)
def unique_acts(story: Story, context: Context) -> None:
    """Refuse two acts of one name in a story."""
    _unique(story.acts, context)


@check(Act)
def unique_groups(act: Act, context: Context) -> None:
    """Check that no two groups of an act have one name, and that each has actors where it needs them."""
    _unique(act.maneuver_groups, context)
    for group in act.maneuver_groups:
        _has_actors(group, act, context)


@check(ManeuverGroup)
def unique_maneuvers(group: ManeuverGroup, context: Context) -> None:
    """Refuse two maneuvers of one name in a group."""
    _unique(group.maneuvers, context)


@check(Maneuver)
def unique_events(maneuver: Maneuver, context: Context) -> None:
    """Refuse two events of one name in a maneuver."""
    _unique(maneuver.events, context)


@check(Event)
def unique_actions(event: Event, context: Context) -> None:
    """Refuse two actions of one name in an event."""
    _unique(event.actions, context)


def _unique(elements: Sequence[Story | Act | ManeuverGroup | Maneuver | Event | Action], context: Context) -> None:
    """Two siblings of one name make references to them ambiguous; they run all the same (see `check_scenario`)."""
    seen: set[str] = set()
    for element in elements:
        if element.name in seen:
            context.warning(
                "reference_control.unique_element_names_on_same_level",
                element.at,
                "@name",
                "a sibling has the same name",
                found=element.name,
            )
        seen.add(element.name)


def _has_actors(group: ManeuverGroup, act: Act, context: Context) -> None:
    """A private action needs somebody: a listed actor, or an entity that triggered the event."""
    if group.actors.entity_refs:
        return
    by_entity = group.actors.select_triggering_entities and _selects(act.start_trigger)
    for maneuver in group.maneuvers:
        for event in maneuver.events:
            private: Element | None = next((a for a in event.actions if isinstance(a.action, _PRIVATE)), None)
            selected = by_entity or (group.actors.select_triggering_entities and _selects(event.start_trigger))
            if private is not None and not selected:
                context.error(
                    "reference_control.valid_actor_reference_in_private_actions",
                    group.at,
                    "",
                    f"private action at line {private.at.line} has no actor",
                    allowed="an EntityRef in Actors, or selectTriggeringEntities with a condition by entity",
                )
                return


def _selects(trigger: Trigger | None) -> bool:
    groups = () if trigger is None else trigger.condition_groups
    return any(isinstance(c.condition, ByEntityCondition) for group in groups for c in group.conditions)
