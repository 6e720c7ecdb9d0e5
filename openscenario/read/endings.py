"""Whether anything can ever end a scenario: its stop trigger, or at least the end of all its acts.

"Never" is said only of what follows from the file: of times that lie before the beginning, of parameters that nothing
sets, and of elements that wait for such. What depends on motion can happen. What can happen is collected until nothing
more follows, so that elements which wait for each other are found to wait for ever.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from openscenario.model.actions import (
    LaneOffsetAction,
    LateralDistanceAction,
    LongitudinalDistanceAction,
    RelativeTargetLaneOffset,
    RelativeTargetSpeed,
    SpeedAction,
)
from openscenario.model.conditions import (
    Condition,
    ParameterCondition,
    SimulationTimeCondition,
    StoryboardElementStateCondition,
    Trigger,
)
from openscenario.model.declarations import ParameterDeclaration
from openscenario.model.entities import ScenarioObject, ego_among
from openscenario.model.global_actions import ParameterAction
from openscenario.model.kinds import Element
from openscenario.model.storyboard import Act, Action, Event, Maneuver, ManeuverGroup, Story, Storyboard
from openscenario.read.context import Context

_STARTED = ("startTransition", "runningState")
_OVER = ("endTransition", "completeState")
_TYPES = {
    Story: "story",
    Act: "act",
    ManeuverGroup: "maneuverGroup",
    Maneuver: "maneuver",
    Event: "event",
    Action: "action",
}


def check_endings(
    storyboard: Storyboard,
    parameters: Sequence[ParameterDeclaration],
    entities: Sequence[ScenarioObject],
    context: Context,
) -> None:
    """Warns of a scenario that runs until somebody ends it from outside."""
    found = _Possible(storyboard, parameters, entities)
    stop = storyboard.stop_trigger
    if found.fires(stop):
        return
    acts = [act for story in storyboard.stories for act in story.acts]
    endless = [act for act in acts if act not in found.over]
    if acts and not endless:
        return
    given = stop is not None and stop.condition_groups
    why = "its stop trigger can never become true" if given else "it has no stop trigger"
    acting = f"act {endless[0].name!r} can never end{found.reason(endless[0])}" if endless else "there are no acts"
    context.warning(
        "storyboard.never_ends",
        stop.at if stop is not None and stop.at.line else storyboard.at,
        "",
        f"nothing in the scenario ever ends it: {why}, and {acting}",
        hint="a StopTrigger with a SimulationTimeCondition ends it; a run ends with its goal or after --duration",
    )


class _Identities:
    """Elements by identity: two of them may be equal."""

    def __init__(self) -> None:
        self._held: dict[int, Element] = {}

    def __contains__(self, element: Element) -> bool:
        return id(element) in self._held

    def __len__(self) -> int:
        return len(self._held)

    def add(self, element: Element) -> None:
        self._held[id(element)] = element


class _Possible:
    """Which elements can start, and which can be over: the least sets that the file allows."""

    def __init__(
        self,
        storyboard: Storyboard,
        parameters: Sequence[ParameterDeclaration],
        entities: Sequence[ScenarioObject],
    ) -> None:
        self._storyboard = storyboard
        self._events = [
            (act, group, event)
            for story in storyboard.stories
            for act in story.acts
            for group in act.maneuver_groups
            for maneuver in group.maneuvers
            for event in maneuver.events
        ]
        actions = [action for _, _, event in self._events for action in event.actions]
        init = (action for action in storyboard.init.actions.global_actions)
        every = [*(action.action for action in actions), *init]
        changed = {each.parameter_ref.removeprefix("$") for each in every if isinstance(each, ParameterAction)}
        self._constant = {each.name: each.value for each in parameters if each.name not in changed}
        self._alone = len(actions) == 1
        names = [entity.name for entity in entities]
        self._ego = ego_among(names)
        self._named: dict[tuple[str, str], list[Element]] = {}
        for element in self._elements():
            key = (_TYPES[type(element)], element.name)  # type: ignore[attr-defined]
            self._named.setdefault(key, []).append(element)
        self.begun, self.over = _Identities(), _Identities()
        known = -1
        while known != len(self.begun) + len(self.over):
            known = len(self.begun) + len(self.over)
            for story in storyboard.stories:
                self._story(story)

    def _elements(self) -> Iterator[Element]:
        for story in self._storyboard.stories:
            yield story
            for act in story.acts:
                yield act
                for group in act.maneuver_groups:
                    yield group
                    for maneuver in group.maneuvers:
                        yield maneuver
                        for event in maneuver.events:
                            yield event
                            yield from event.actions

    def _story(self, story: Story) -> None:
        self.begun.add(story)
        for act in story.acts:
            if self._starts(act.start_trigger):
                self._act(act)
        self._all_over(story, story.acts)

    def _act(self, act: Act) -> None:
        stopped = self.fires(act.stop_trigger)
        self.begun.add(act)
        for group in act.maneuver_groups:
            self.begun.add(group)
            for maneuver in group.maneuvers:
                self.begun.add(maneuver)
                for event in maneuver.events:
                    if self._starts(event.start_trigger):
                        self._event(event, group)
                    if stopped:
                        for element in (event, *event.actions):
                            self.over.add(element)
                self._all_over(maneuver, maneuver.events)
            self._all_over(group, group.maneuvers)
        self._all_over(act, act.maneuver_groups)
        if stopped:
            self.over.add(act)

    def _event(self, event: Event, group: ManeuverGroup) -> None:
        self.begun.add(event)
        for action in event.actions:
            self.begun.add(action)
            if not self._endless(action, group):
                self.over.add(action)
        self._all_over(event, event.actions)

    def _all_over(self, parent: Element, children: Sequence[Element]) -> None:
        """An element without children does not end by itself."""
        if children and all(child in self.over for child in children):
            self.over.add(parent)

    def _endless(self, action: Action, group: ManeuverGroup) -> bool:
        """An action without an end of its own that no other one can take the place of.

        Actions on the driven car are only asked for, and over with that.
        """
        if not self._alone or self._ego is None or not goes_on(action.action):
            return False
        return any(each.entity_ref != self._ego for each in group.actors.entity_refs)

    def _starts(self, trigger: Trigger | None) -> bool:
        """No trigger, or an empty one, holds nothing back."""
        return trigger is None or not trigger.condition_groups or self.fires(trigger)

    def fires(self, trigger: Trigger | None) -> bool:
        """Whether a trigger can become true; none, or an empty one, cannot."""
        groups = () if trigger is None else trigger.condition_groups
        return any(all(self._possible(each) for each in group.conditions) for group in groups)

    def _possible(self, condition: Condition) -> bool:
        inner = condition.condition
        if isinstance(inner, SimulationTimeCondition):
            return _time_comes(inner, condition.condition_edge)
        if isinstance(inner, ParameterCondition):
            name = inner.parameter_ref.removeprefix("$")
            if name not in self._constant:
                return True
            # what is constant has no edge
            return condition.condition_edge == "none" and _holds(self._constant[name], inner.rule, inner.value)
        if isinstance(inner, StoryboardElementStateCondition):
            return self._state_comes(inner)
        return True

    def _state_comes(self, condition: StoryboardElementStateCondition) -> bool:
        name = condition.storyboard_element_ref.rpartition("::")[2]
        elements = self._named.get((condition.storyboard_element_type, name))
        if elements is None or condition.state not in (*_STARTED, *_OVER):
            return True
        reached = self.begun if condition.state in _STARTED else self.over
        return any(element in reached for element in elements)

    def reason(self, act: Act) -> str:
        """Why an act cannot end."""
        if act not in self.begun:
            return ": it can never start"
        for owner, _, event in self._events:
            if owner is act and event not in self.begun:
                return f": event {event.name!r} (line {event.at.line}) can never start"
            if owner is act and event not in self.over:
                return f": event {event.name!r} (line {event.at.line}) goes on for ever"
        return ": it has no events"


def goes_on(action: object) -> bool:
    """Whether an action has no regular ending."""
    if isinstance(action, SpeedAction):
        target = action.speed_action_target
        return isinstance(target, RelativeTargetSpeed) and target.continuous
    if isinstance(action, LaneOffsetAction):  # to an absolute offset it ends in one reading
        return action.continuous and isinstance(action.lane_offset_target, RelativeTargetLaneOffset)
    return isinstance(action, LongitudinalDistanceAction | LateralDistanceAction) and action.continuous


def _time_comes(condition: SimulationTimeCondition, edge: str) -> bool:
    """Time begins at 0 and only grows; the first evaluation has no edge."""
    value, rule = condition.value, condition.rule
    if rule in ("greaterThan", "greaterOrEqual"):
        later = value > 0.0 or (value == 0.0 and rule == "greaterThan")
        return edge == "none" or (edge != "falling" and later)
    if rule in ("lessThan", "lessOrEqual"):
        first = value > 0.0 or (value == 0.0 and rule == "lessOrEqual")
        return edge != "rising" and first
    if edge == "none":
        return rule == "notEqualTo" or value >= 0.0
    return value >= 0.0


def _holds(found: str, rule: str, wanted: str) -> bool:
    """Whether a value compares so; numbers compare as numbers, texts only as equal or not."""
    try:
        left, right = float(found), float(wanted)
    except ValueError:
        return (found == wanted) is (rule != "notEqualTo") if rule in ("equalTo", "notEqualTo") else True
    return {
        "equalTo": left == right,
        "notEqualTo": left != right,
        "greaterThan": left > right,
        "greaterOrEqual": left >= right,
        "lessThan": left < right,
        "lessOrEqual": left <= right,
    }[rule]
