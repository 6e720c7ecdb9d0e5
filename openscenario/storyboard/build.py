"""From the model of a storyboard to the tree that runs, with every unsupported element found before anything runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from openscenario import model
from openscenario.findings import Finding
from openscenario.storyboard.nodes import Node
from openscenario.storyboard.registry import Scope, action_factories, condition_factories
from openscenario.storyboard.triggers import ConditionState, Test, TriggerState
from openscenario.storyboard.unsupported import Unsupported

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board
    from openscenario.storyboard.entity import Entity


class Builder:
    """Builds the tree of a storyboard; what cannot run is collected in `findings`."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self.findings: list[Finding] = []
        self._triggers: list[tuple[Node, model.Trigger, str]] = []

    def init_nodes(self, actions: model.InitActions, root: Node) -> list[tuple[Node, Entity | None]]:
        """A node for every Init action, in the order of the file, with the entity it acts on."""
        nodes: list[tuple[Node, Entity | None]] = []
        for action in (*actions.global_actions, *actions.user_defined_actions):
            nodes.append((self._init_node(root, f"Init {_family(action)}", action), None))
            self._check_action(action, (None,))
        for private in actions.privates:
            entities = self._entities(private.entity_ref, private)
            for entity in entities:
                for private_action in private.private_actions:
                    name = f"Init {entity.name} {_family(private_action)}"
                    nodes.append((self._init_node(root, name, private_action), entity))
                    self._check_action(private_action, (entity,))
        return nodes

    @staticmethod
    def _init_node(root: Node, name: str, action: model.AnyAction) -> Node:
        node = Node("action", name, None, action.at, element=action)
        node.parent = root
        return node

    def stories(self, stories: Sequence[model.Story], root: Node) -> None:
        """Hang the stories below `root`, then compile all triggers (they may refer to any element)."""
        for story in stories:
            story_node = Node("story", story.name, root, story.at)
            for act in story.acts:
                act_node = Node("act", act.name, story_node, act.at)
                self._trigger(act_node, act.start_trigger, "start")
                self._trigger(act_node, act.stop_trigger, "stop")
                for group in act.maneuver_groups:
                    self._group(group, act_node)
        for node, trigger, which in self._triggers:
            state = self.trigger(node, trigger)
            if which == "start":
                node.start = state
            else:
                node.stop = state

    def _trigger(self, node: Node, trigger: model.Trigger | None, which: str) -> None:
        """Note a trigger for later. One without condition groups holds nothing back, and stops nothing."""
        if trigger is not None and which == "start":
            node.waits = True
        if trigger is not None and trigger.condition_groups:
            self._triggers.append((node, trigger, which))

    def _group(self, group: model.ManeuverGroup, act: Node) -> None:
        node = Node("maneuverGroup", group.name, act, group.at, maximum=group.maximum_execution_count)
        node.actors = group.actors
        actors: list[Entity | None] = []
        for reference in group.actors.entity_refs:
            actors.extend(self._entities(reference.entity_ref, reference))
        if group.actors.select_triggering_entities and not actors:
            actors.extend(self.board.entities.values())
        for maneuver in group.maneuvers:
            maneuver_node = Node("maneuver", maneuver.name, node, maneuver.at)
            for event in maneuver.events:
                event_node = Node(
                    "event",
                    event.name,
                    maneuver_node,
                    event.at,
                    maximum=event.maximum_execution_count,
                    priority=event.priority,
                )
                self._trigger(event_node, event.start_trigger, "start")
                for action in event.actions:
                    Node("action", action.name, event_node, action.at, element=action.action)
                    self._check_action(action.action, actors)

    def _check_action(self, action: model.AnyAction, actors: Sequence[Entity | None]) -> None:
        """Make the action once for every actor and throw it away: what it cannot do shows here."""
        factory = action_factories().get(type(action))
        if factory is None:
            self._unsupported(Unsupported("this action is not supported"), action)
            return
        private = _is_private(action)
        for entity in actors if private else (None,):
            try:
                factory(action, entity, self.board)
            except Unsupported as reason:
                self._unsupported(reason, action)
                return

    def trigger(self, node: Node, trigger: model.Trigger) -> TriggerState:
        """A trigger of `node`, ready to be evaluated."""
        groups = []
        for group in trigger.condition_groups:
            states = []
            for condition in group.conditions:
                entities: list[str] = []
                test = self._test(node, condition, entities)
                if test is not None:
                    states.append(ConditionState(condition, test, entities))
            groups.append(tuple(states))
        return TriggerState(tuple(groups))

    def _test(self, node: Node, condition: model.Condition, entities: list[str]) -> Test | None:
        """`entities` will hold for whom a condition on entities was true last."""
        scope = Scope(self.board, node)
        inner = condition.condition
        try:
            if isinstance(inner, model.ByEntityCondition):
                return self._by_entity(scope, inner, entities)
            factory = condition_factories().get(type(inner))
            if factory is None:
                raise Unsupported("this condition is not supported")
            return factory(inner, None, scope)
        except Unsupported as reason:
            self._unsupported(reason, inner.entity_condition if isinstance(inner, model.ByEntityCondition) else inner)
            return None

    def _by_entity(self, scope: Scope, condition: model.ByEntityCondition, entities: list[str]) -> Test:
        inner = condition.entity_condition
        factory = condition_factories().get(type(inner))
        if factory is None:
            raise Unsupported("this condition is not supported")
        tests: list[tuple[Entity, Test]] = []
        for reference in condition.triggering_entities.entity_refs:
            for entity in self._entities(reference.entity_ref, reference):
                tests.append((entity, factory(inner, entity, scope)))
        every = condition.triggering_entities.triggering_entities_rule == "all"
        if len(tests) == 1:
            return _single(*tests[0], entities)
        return _several(tuple(tests), every, entities)

    def _entities(self, name: str, element: model.Element) -> list[Entity]:
        """The entity called `name`, or the members of the selection called so."""
        board = self.board
        if name in board.entities:
            return [board.entities[name]]
        if name in board.selections:
            return [board.entities[member] for member in board.selections[name]]
        self._unsupported(Unsupported("no entity of this name", name, ", ".join(board.entities)), element)
        return []

    def _unsupported(self, reason: Unsupported, element: model.Element) -> None:
        culprit = reason.element if isinstance(reason.element, model.Element) else element
        at = culprit.at
        self.findings.append(
            Finding(
                code="unsupported",
                severity="error",
                file=at.file or element.at.file,
                line=at.line or element.at.line or None,
                element=at.element or element.at.element or type(culprit).__name__,
                found=reason.found,
                allowed=reason.allowed,
                text=f"{type(element).__name__}: {reason.text}",
            )
        )


def _single(entity: Entity, test: Test, entities: list[str]) -> Test:
    entities.append(entity.name)
    return lambda: entity.active and test()


def _several(tests: tuple[tuple[Entity, Test], ...], every: bool, entities: list[str]) -> Test:
    def run() -> bool:
        # no short cut: conditions with a memory (stand still, off road) must see every step
        true = [entity.name for entity, test in tests if entity.active and test()]
        if not true or (every and len(true) < len(tests)):
            return False
        entities[:] = true
        return True

    return run


def _is_private(action: model.AnyAction) -> bool:
    return type(action).XML.startswith("PrivateAction")


def _family(action: model.AnyAction) -> str:
    """The tag below PrivateAction or GlobalAction: what an Init action is called in transitions."""
    parts = type(action).XML.split("/")
    return parts[1] if len(parts) > 1 else type(action).__name__


def walk(node: Node) -> Iterator[Node]:
    """The node and everything below it, in the order of the file."""
    yield node
    for child in node.children:
        yield from walk(child)


Resolve = Callable[[], object]
