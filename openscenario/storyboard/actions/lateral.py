"""LaneChangeAction and LaneOffsetAction: from one line along the road to another."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.dynamics import Transition, lateral_span, span
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.positions import shifted_lane
from openscenario.storyboard.registry import Runner, Unsupported, action

if TYPE_CHECKING:
    from openscenario.storyboard.engine import Storyboard


class Shift:
    """Moves the offset from the lane's middle along a shape; time or distance drives it. Base of what follows."""

    __slots__ = ("_board", "_by_distance", "_change", "_entity")
    _oblique = True  # the speed is that along the oblique path; else that along the lane
    domains: tuple[str, ...] = ("lateral",)

    def __init__(self, entity: Entity, board: Storyboard) -> None:
        self._entity = entity
        self._board = board
        self._change = Transition("step", 0.0, 0.0, 0.0)
        self._by_distance = False

    def _begin(self, shape: str, over: float, target: float, *, by_distance: bool = False) -> bool:
        """Offsets count to the left of the way the entity faces: a road that runs the other way changes nothing."""
        entity = self._entity
        self._by_distance = by_distance
        self._change = Transition(shape, over, entity.offset * entity.sense, target)
        if self._change.span <= 0.0:
            self._change.advance(0.0)
            self._settle()
            return True
        return False

    def _settle(self) -> None:
        entity = self._entity
        entity.offset = self._change.value * entity.sense
        entity.offset_rate = entity.drift = 0.0
        self._board.ground.drive(entity, 0.0)

    def step(self, dt: float) -> bool:
        entity, change = self._entity, self._change
        if not entity.tracked:  # it was put somewhere else meanwhile
            self._board.ground.track(entity)
        entity.oblique = self._oblique
        pace = abs(0.5 * (entity.speed + entity.speed_before)) if self._by_distance else 1.0
        if self._by_distance and self._oblique:
            # the distance is that along the lane
            pace /= math.hypot(1.0, change.rate())
        change.advance(pace * dt)
        if change.done:
            self._settle()
        else:
            entity.offset = change.value * entity.sense
            entity.offset_rate = change.rate() * pace
        return change.done

    def stop(self) -> None:
        self._entity.offset_rate = 0.0


class LaneChange(Shift):
    """The entity keeps the target lane from the start on; its offset goes from where it is to the target offset."""

    __slots__ = ("_element", "_other")

    def __init__(self, element: model.LaneChangeAction, entity: Entity, board: Storyboard) -> None:
        super().__init__(entity, board)
        self._element = element
        target = element.lane_change_target
        self._other: Entity | None = None
        if isinstance(target, model.RelativeTargetLane):
            if target.entity_ref not in board.entities:
                raise Unsupported("no entity of this name", target.entity_ref, ", ".join(board.entities), target)
            self._other = board.entities[target.entity_ref]
        if board.network is None:
            raise Unsupported("the scenario has no road network")

    def _lane(self) -> int:
        target = self._element.lane_change_target
        if self._other is None:
            return target.value
        self._board.ground.track(self._other)
        # lanes are counted to the left of the referenced entity
        return shifted_lane(self._other.lane, target.value if self._other.sense > 0.0 else -target.value)

    def start(self) -> bool:
        entity, ground = self._entity, self._board.ground
        ground.track(entity)
        network = ground.network
        assert network is not None
        lane = self._lane()
        old = network.lane_pose(entity.road, entity.lane, entity.s, 0.0)
        try:
            new = network.lane_pose(entity.road, lane, entity.s, 0.0)
        except KeyError:
            self._board.warn(
                self._element,
                "no-such-lane",
                f"{entity.name}: no lane {lane} on road {entity.road} at s = {entity.s:.1f} m: no lane change",
            )
            return True
        # t of the new lane's middle, seen from the old one's
        apart = -(new.x - old.x) * math.sin(old.h) + (new.y - old.y) * math.cos(old.h)
        entity.lane = lane
        entity.offset -= apart
        element = self._element
        target = element.target_lane_offset
        dynamics = element.lane_change_action_dynamics
        over = span(
            dynamics.dynamics_shape, dynamics.dynamics_dimension, dynamics.value, target - entity.offset * entity.sense
        )
        by_distance = dynamics.dynamics_dimension == "distance"
        return self._begin(dynamics.dynamics_shape, over, target, by_distance=by_distance)

    def ask(self) -> tuple[str, dict[str, Any], float]:
        entity = self._entity
        self._board.ground.track(entity)
        dynamics = self._element.lane_change_action_dynamics
        over = span(dynamics.dynamics_shape, dynamics.dynamics_dimension, dynamics.value, 3.5)
        if dynamics.dynamics_dimension == "distance":
            over = over / entity.speed if entity.speed > 0.0 else 0.0
        values = {
            "lane": self._lane(),
            "offset": self._element.target_lane_offset,
            "duration": over if math.isfinite(over) else 0.0,
        }
        return "lane_change", values, values["duration"]


class LaneOffset(Shift):
    """The entity goes to an offset from its lane's middle or from another entity; `continuous` keeps it there."""

    __slots__ = ("_element", "_other", "_target")
    _oblique = False

    def __init__(self, element: model.LaneOffsetAction, entity: Entity, board: Storyboard) -> None:
        super().__init__(entity, board)
        self._element = element
        self._target = 0.0
        self._other: Entity | None = None
        target = element.lane_offset_target
        if isinstance(target, model.RelativeTargetLaneOffset):
            if target.entity_ref not in board.entities:
                raise Unsupported("no entity of this name", target.entity_ref, ", ".join(board.entities), target)
            self._other = board.entities[target.entity_ref]
        if board.network is None:
            raise Unsupported("the scenario has no road network")

    def _wanted(self) -> float:
        """Target offset to the left of the way the entity faces; a relative one is to the other's left."""
        entity, other, ground = self._entity, self._other, self._board.ground
        value = self._element.lane_offset_target.value
        if other is None:
            return value
        ours, theirs = ground.position(entity), ground.position(other)
        apart = theirs.t + value * other.sense - ours.t
        return (entity.offset + apart) * entity.sense

    def start(self) -> bool:
        entity, ground = self._entity, self._board.ground
        ground.track(entity)
        self._target = self._wanted()
        dynamics = self._element.lane_offset_action_dynamics
        change = self._target - entity.offset * entity.sense
        if dynamics.max_lateral_acc is None:
            over = 0.0
        else:
            over = lateral_span(dynamics.dynamics_shape, dynamics.max_lateral_acc, change)
        return self._begin(dynamics.dynamics_shape, over, self._target) and not self._element.continuous

    def step(self, dt: float) -> bool:
        if self._element.continuous:
            self._change.target = self._wanted()
        return super().step(dt) and not self._element.continuous

    def ask(self) -> tuple[str, dict[str, Any], float]:
        return "lane_offset", {"offset": self._element.lane_offset_target.value}, 0.0


@action(model.LaneChangeAction)
def lane_change(element: model.LaneChangeAction, entity: Entity, board: Storyboard) -> Runner:
    return LaneChange(element, entity, board)


@action(model.LaneOffsetAction)
def lane_offset(element: model.LaneOffsetAction, entity: Entity, board: Storyboard) -> Runner:
    return LaneOffset(element, entity, board)
