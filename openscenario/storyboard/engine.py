"""The storyboard as it runs: states, triggers, priorities and execution counts; one `step` moves everything by dt.

A step goes from t to t + dt. Conditions see time and poses at t, actions that they start act over the whole step,
and what is over with the step ends at t + dt. Source: ASAM OpenSCENARIO XML 1.3, sections "Storyboard", "Event
priority", "Conflicting actions".
"""

from __future__ import annotations

import math
import random
from collections.abc import Collection
from typing import Any, NamedTuple

from openscenario import model
from openscenario.findings import Finding, ScenarioError
from openscenario.road.network import RoadNetwork
from openscenario.storyboard.actions.placing import leave_out
from openscenario.storyboard.build import Builder, walk
from openscenario.storyboard.crowd import Crowd
from openscenario.storyboard.drivers import assign, drive
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.ground import Ground
from openscenario.storyboard.held_controls import operate
from openscenario.storyboard.init_order import in_order
from openscenario.storyboard.motion import move
from openscenario.storyboard.nodes import (
    COMPLETE,
    END,
    INIT,
    RUNNING,
    SKIP,
    STANDBY,
    START,
    STOP,
    TO_STANDBY,
    Node,
    Transition,
)
from openscenario.storyboard.reading import EVENT_AGAIN, USUAL, Reading
from openscenario.storyboard.registry import action_factories
from openscenario.storyboard.report import report
from openscenario.storyboard.requests import Asked, Request
from openscenario.storyboard.road_watch import RoadWatch
from openscenario.storyboard.runner import Instant, Runner
from openscenario.storyboard.selections import selections
from openscenario.storyboard.signals import programs
from openscenario.storyboard.trailers import couple, couple_named, draw, line_up, trains
from openscenario.storyboard.values import Values
from openscenario.storyboard.world import World


class Held(NamedTuple):
    """A runner and the entity it acts on."""

    runner: Runner
    entity: Entity | None


class Storyboard:
    """A scenario under way on a road network.

    `external`: names of entities that something else moves (the ego in the closed loop): after Init, actions on
    them become `requests`. `lane_friction`: whether the material of a lane limits those that drive on it. `acted`: the
    actions that acted in the last step, with whom each of them acted on.
    Raises ScenarioError if the scenario holds an element that cannot run.
    """

    def __init__(
        self,
        scenario: model.Scenario,
        network: RoadNetwork | None,
        *,
        external: Collection[str] = (),
        seed: int = 0,
        reading: Reading = USUAL,
        lane_friction: bool = True,
    ) -> None:
        self.scenario = scenario
        self.reading = reading
        self.network = network
        self.ground = Ground(network)
        self._lane_friction = lane_friction
        self.random = random.Random(seed)
        self.time = 0.0
        self.dt = 0.0
        self.steps = 0
        self.done = False
        self.running = False  # Init is over
        self._settled = False  # the triggers of this instant have been evaluated
        self._crowd: Crowd | None = None
        self.entities: dict[str, Entity] = {}
        for entity, ahead in trains(scenario, external):
            self.entities[entity.name] = entity
            if ahead is not None:
                couple(ahead, entity)
        couple_named(scenario, self.entities)
        for entity in self.entities.values():
            if entity.drawn_by is None:
                line_up(entity)
        self.selections = selections(scenario)
        self.parameters = Values(
            (each.name, each.parameter_type, each.value) for each in scenario.parameter_declarations
        )
        self.variables = Values((each.name, each.variable_type, each.value) for each in scenario.variable_declarations)
        self.world = World(() if network is None else network.signals)
        self.world.monitors = {each.name: each.value for each in scenario.monitor_declarations}
        for each in scenario.entities:
            assign(self.entities[each.name], each.object_controllers, self)
        self.programs = programs(scenario.road_network.traffic_signals)
        self.transitions: list[Transition] = []
        self.requests: list[Request] = []
        self.warnings: list[Finding] = []
        self.root = Node("storyboard", "storyBoard", None, scenario.storyboard.at)
        self.road_watch = RoadWatch(self.ground)
        self._active: list[tuple[Node, list[Held]]] = []
        self._begun: list[tuple[Node, tuple[Held, ...]]] = []  # in the instant of the last triggers
        self.acted: tuple[tuple[Node, tuple[Held, ...]], ...] = ()
        self._movers = [entity for entity in self.entities.values() if not entity.external]
        self._externals = [entity for entity in self.entities.values() if entity.external]
        builder = Builder(self)
        self._init = in_order(builder.init_nodes(scenario.storyboard.init.actions, self.root))
        builder.stories(scenario.storyboard.stories, self.root)
        if scenario.storyboard.stop_trigger is not None:
            self.root.stop = builder.trigger(self.root, scenario.storyboard.stop_trigger)
        if builder.findings:
            raise ScenarioError(builder.findings)
        leave_out(walk(self.root), self.entities, [entity for _, entity in self._init])
        for order, node in enumerate((*(node for node, _ in self._init), *walk(self.root))):
            node.order = order

    # --- from outside

    def start(self) -> None:
        """Carry out the Init actions at t = 0 and start the stories; the first step evaluates the triggers of t = 0."""
        for node, entity in self._init:
            self._begin(node, [entity])
        self.running = True
        if self._crowd is not None:
            self._crowd.come_and_go()
        self._draw(0.0)
        self._enter(self.root)
        self._end_finished()
        for entity in self.entities.values():
            entity.vx, entity.vy = self.velocity(entity)  # conditions see it at t = 0, before anybody has moved
            self.road_watch.note(entity, self.time)

    def place(self, name: str, x: float, y: float, z: float, h: float, speed: float, ax: float = 0.0) -> None:
        """The true pose of an external entity's reference point [m, rad, m/s, m/s^2], before a step."""
        entity = self.entities[name]
        entity.ax = ax
        self.ground.place(entity, x, y, z, h, speed)
        self.road_watch.note(entity, self.time)

    def velocity(self, entity: Entity) -> tuple[float, float]:
        """vx, vy [m/s] of the motion seen last; before the first step none has been: of the speed at the start."""
        if self.steps:
            return entity.vx, entity.vy
        return entity.speed * math.cos(entity.h), entity.speed * math.sin(entity.h)

    def settle(self) -> None:
        """Evaluate the triggers of this instant before the next step does: what starts at once shows in the poses."""
        if not self.done and not self._settled:
            self._stops()
            self._settled = True

    def step(self, dt: float) -> None:
        """Go on by `dt` [s]."""
        if self.done:
            return
        self.dt = dt
        if not self._settled and self._stops():
            return
        self._settled = False
        begun = {id(node) for node, _ in self._begun}
        still = ((node, tuple(held)) for node, held in self._active if id(node) not in begun)
        self.acted = (*self._begun, *still)
        if self._crowd is not None:
            self._crowd.come_and_go()
        if self.steps == 0:
            for entity in self._movers:
                entity.vx, entity.vy = self.velocity(entity)
        self.time = round(self.time + dt, 9)
        self.steps += 1
        for entity in self._movers:
            entity.speed_before = entity.speed
            entity.moved = entity.late = False
        if self._lane_friction:
            self.ground.spread_friction(self._movers, self.world.friction)
        if self._active:
            self._step_actions(dt)
        if self._crowd is not None:
            self._crowd.drive(dt)
        drive(self, dt)
        ground = self.ground
        for entity in self._movers:
            if entity.active:
                if entity.controls is not None:
                    operate(entity, dt, ground)
                if not entity.moved and entity.drawn_by is None:
                    move(entity, dt, ground)
                entity.placed = False
                self.road_watch.note(entity, self.time)
        self._draw(dt)
        for entity in self._externals:
            entity.travelled += abs(entity.speed) * dt
        if self._active:
            self._end_finished()

    def _draw(self, dt: float) -> None:
        """Let the trailers follow."""
        for entity in self._movers:
            if entity.trailer is not None and entity.drawn_by is None:
                draw(entity, dt)

    def _stops(self) -> bool:
        """Evaluate the triggers and end what is over at once; whether the stop trigger fired."""
        self._begun.clear()
        for program in self.programs.values():
            program.show(self.time, self.world)
        self._evaluate(self.root)
        if self._active:
            self._end_finished()
        return self.done

    def crowd(self) -> Crowd:
        """The traffic that comes and goes."""
        if self._crowd is None:
            self._crowd = Crowd(self)
        return self._crowd

    def admit(self, entity: Entity) -> None:
        """One more entity from now on."""
        self.entities[entity.name] = entity
        self._movers.append(entity)

    def dismiss(self, entity: Entity) -> None:
        """An entity that came is gone."""
        entity.active = False
        del self.entities[entity.name]
        self._movers.remove(entity)

    def events_of(self, entity: Entity) -> list[str]:
        """Names of the events that acted on an entity in the last step; `Init` of what Init has begun."""
        events = (node.parent for node, held in self.acted if any(each.entity is entity for each in held))
        return [event.name if event.kind == "event" else "Init" for event in events if event is not None]

    def report(self) -> tuple[Finding, ...]:
        """Doubts about the scenario: events that never fired, edges true from the start, acts that never ended."""
        return (*self.warnings, *report(self.root))

    def warn(self, element: model.Element, code: str, text: str) -> None:
        """Something that went otherwise than the scenario wants; part of `report()`."""
        self._doubt(element.at, code, text)

    def _doubt(self, at: model.At, code: str, text: str) -> None:
        """A warning, once for a place."""
        found = Finding(
            code=code, severity="warning", file=at.file, line=at.line or None, element=at.element, text=text
        )
        if found not in self.warnings:
            self.warnings.append(found)

    def request(self, entity: Entity, kind: str, values: dict[str, Any]) -> None:
        """Ask whoever moves an external entity for something."""
        self.requests.append(Request(self.time, entity.name, kind, values))

    # --- states

    def _change(self, node: Node, transition: str, state: str) -> None:
        at = node.at
        self.transitions.append(
            Transition(self.time, node.name, node.kind, transition, node.state, state, at.file, at.line, node.path)
        )
        node.state = state
        node.changes[transition] = (self.steps, len(self.transitions))

    def _enter(self, node: Node) -> None:
        """The parent has started: wait for the own start trigger, or start."""
        if node.waits:
            self._change(node, TO_STANDBY, STANDBY)
        else:
            self._start(node)

    def _start(self, node: Node) -> None:
        if node.kind == "event":
            self._start_event(node)
            return
        node.executions += 1
        self._change(node, START, RUNNING)
        for child in node.children:
            self._enter(child)
        self._completed(node)

    def _evaluate(self, node: Node) -> None:
        if node.state == RUNNING and node.stop is not None and node.stop.evaluate(self.time):
            self._stop(node)
            if node is self.root:
                self.done = True
            elif node.parent is not None:
                self._completed(node.parent)
            return
        if node.state == STANDBY and (node.start is None or node.start.evaluate(self.time)):
            self._start(node)
        if node.state == RUNNING and node.kind != "event":
            for child in node.children:
                if child.state != COMPLETE:
                    self._evaluate(child)

    def _start_event(self, node: Node) -> None:
        maneuver = node.parent
        assert maneuver is not None
        if node.priority == "skip" and maneuver.event_running():
            # a skip counts as an execution (8.4.2.1)
            node.executions += 1
            self._change(node, SKIP, STANDBY if node.executions < node.maximum else COMPLETE)
            self._completed(maneuver)
            return
        if node.priority == "override":
            for sibling in maneuver.children:
                if sibling is not node and sibling.state == RUNNING:
                    self._override(sibling)
        actors = self._actors(node)
        node.executions += 1
        self._change(node, START, RUNNING)
        for child in node.children:
            self._begin(child, actors)
        self._completed(node)

    def _override(self, event: Node) -> None:
        if self.reading == "standard" or event.executions >= event.maximum:
            self._stop(event)
            return
        for child in event.children:
            if child.state != COMPLETE:
                self._stop(child)
        self._again(event)
        self._doubt(event.at, "reading-event-again", f"event {event.name!r} {EVENT_AGAIN}")

    def _actors(self, event: Node) -> list[Entity | None]:
        """Who carries out an event: the group's actors and, if it says so, the entities that triggered its act (7.3.1).

        Where no entities did, those that triggered the event itself.
        """
        group = event.parent.parent if event.parent else None
        actors = group.actors if group else None
        if actors is None:
            return []
        names: list[str] = []
        for reference in actors.entity_refs:
            names.extend(self.selections.get(reference.entity_ref, (reference.entity_ref,)))
        if actors.select_triggering_entities and group is not None and group.parent is not None:
            act, own = group.parent.start, event.start
            names.extend((act.entities if act is not None else ()) or (own.entities if own is not None else ()))
        return [self.entities[name] for name in dict.fromkeys(names)]

    # --- actions

    def _begin(self, node: Node, actors: list[Entity | None]) -> None:
        """Start an action for all actors; over at once if nothing is left to do."""
        element = node.element
        node.executions += 1
        self._change(node, START, RUNNING)
        factory = action_factories()[type(element)]
        held: list[Held] = []
        begun: list[Held] = []
        private = type(element).XML.startswith("PrivateAction")  # type: ignore[attr-defined]
        for entity in actors if private else (None,):
            runner: Runner = factory(element, entity, self)
            if entity is not None:
                if not entity.active:
                    continue
                if entity.external and self.running:
                    runner = Asked(runner, element, entity, self)
                else:
                    self._displace(entity, runner)
            begun.append(Held(runner, entity))
            if not runner.start():
                held.append(Held(runner, entity))
                self._hold(entity, runner, node.order)
        self._active.append((node, held))
        self._begun.append((node, tuple(begun)))

    def _hold(self, entity: Entity | None, runner: Runner, order: int) -> None:
        if entity is not None:
            for domain in runner.domains:
                entity.hold(domain, runner, order)

    def _release(self, held: Held) -> None:
        if held.entity is not None:
            for domain in held.runner.domains:
                if held.entity.holder(domain) is held.runner:
                    held.entity.hold(domain, None)

    def _displace(self, entity: Entity, runner: Runner) -> None:
        """A new action in a domain ends the one that runs there, for all of a selection if it acts on one (7.5.1)."""
        for domain in runner.domains:
            old = entity.holder(domain)
            if old is None:
                continue
            for node, held in list(self._active):
                mine = [each for each in held if each.runner is old]
                if mine:
                    together = self._together(node, entity)
                    mine += [each for each in held if each.runner is not old and each.entity in together]
                for each in mine:
                    each.runner.stop()
                    self._release(each)
                    held.remove(each)
                if mine and not held:
                    self._drop(node)
                    self._change(node, STOP, COMPLETE)
                    if node.parent is not None and node.parent.kind == "event":
                        self._completed(node.parent)

    def _together(self, action: Node, entity: Entity) -> list[Entity]:
        """The entities of the selections of which an action has this one as its actor."""
        event = action.parent
        group = event.parent.parent if event is not None and event.parent is not None else None
        actors = None if group is None else group.actors
        names = () if actors is None else (each.entity_ref for each in actors.entity_refs)
        selections = [self.selections.get(name, ()) for name in names]
        return [self.entities[name] for members in selections if entity.name in members for name in members]

    def _drop(self, node: Node) -> None:
        self._active = [each for each in self._active if each[0] is not node]

    def _step_actions(self, dt: float) -> None:
        """Step what runs. Speeds change before positions: lateral actions use the new speed."""
        for lateral in (False, True):
            for _, held in list(self._active):
                for each in list(held):
                    if (each.runner.domains == ("lateral",)) is lateral and each in held and each.runner.step(dt):
                        self._release(each)
                        held.remove(each)

    def _end_finished(self) -> None:
        """End the actions of which nothing runs any more."""
        for node, held in list(self._active):
            if not held and node.state == RUNNING:
                self._drop(node)
                self._change(node, END, COMPLETE)
                if node.parent is not None and node.parent.kind == "event":
                    self._completed(node.parent)

    # --- endings

    def _completed(self, node: Node) -> None:
        """End a node whose children are all complete, and go on with its parent."""
        if node.kind == "storyboard" or node.state != RUNNING or not node.finished():
            return
        if node.kind in ("event", "maneuverGroup") and node.executions < node.maximum:
            self._again(node)
            return
        self._change(node, END, COMPLETE)
        if node.parent is not None:
            self._completed(node.parent)

    def _again(self, node: Node) -> None:
        """An execution has ended, and more are allowed."""
        self._change(node, END, STANDBY)
        for child in node.children:
            child.reset()
        if node.start is not None:
            node.start.reset()

    def _stop(self, node: Node) -> None:
        """Stop a node and everything below it."""
        for child in node.children:
            if child.state != COMPLETE:
                self._stop(child)
        if node.kind == "action":
            for active, held in list(self._active):
                if active is node:
                    for each in held:
                        each.runner.stop()
                        self._release(each)
                    self._drop(node)
        if node is self.root:
            for active, held in self._active:  # Init actions that still run
                for each in held:
                    each.runner.stop()
                active.state = COMPLETE
            self._active = []
        if (
            node.kind in ("event", "maneuverGroup")
            and node.state == RUNNING
            and node.executions < node.maximum
            and node.finished()
        ):
            self._change(node, END, STANDBY)  # what was stopped below has ended this execution; more were allowed
        if node.state == INIT:
            node.state = COMPLETE
        else:
            self._change(node, STOP, COMPLETE)


__all__ = ["Instant", "Request", "Storyboard", "Transition"]
