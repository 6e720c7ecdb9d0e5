"""LaneChangeAction and LaneOffsetAction: from one line along the road to another."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.dynamics import Transition, lateral_span, span
from openscenario.storyboard.entity import STILL, Entity
from openscenario.storyboard.motion import lean, way
from openscenario.storyboard.positions import shifted_lane
from openscenario.storyboard.reading import OFFSET_ENDED
from openscenario.storyboard.registry import action, entity_called
from openscenario.storyboard.runner import Runner
from openscenario.storyboard.unsupported import Unsupported

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

NEAR = 1e-6  # m, and m/s


class Shift:
    """Moves the offset from the lane's middle along a shape. Base of what follows.

    The offsets that actions name are those of the road's t axis: to the left where s increases, whichever way the
    entity faces (as in LanePosition). Under way they count to the left of the entity, so that a road that runs the
    other way changes nothing. Who moves sideways heads where it goes.
    """

    __slots__ = ("_board", "_change", "_entity")
    domains: tuple[str, ...] = ("lateral",)

    def __init__(self, entity: Entity, board: Board) -> None:
        self._entity = entity
        self._board = board
        self._change = Transition("step", 0.0, 0.0, 0.0)

    def _begin(self, shape: str, over: float, target: float) -> bool:
        """Start a change to an offset `target` of the road's t axis."""
        entity = self._entity
        self._change = Transition(shape, over, entity.offset * entity.sense, target * entity.sense)
        if self._change.span <= 0.0:
            self._change.advance(0.0)
            self._settle()
            self._board.ground.drive(entity, 0.0)
            return True
        return False

    def _settle(self) -> None:
        """The change is over: straight on from here."""
        entity = self._entity
        entity.offset = self._change.value * entity.sense
        entity.drift = entity.twist = 0.0
        entity.shifted = True

    def _track(self) -> None:
        if not self._entity.tracked:  # it was put somewhere else meanwhile
            self._board.ground.track(self._entity)

    def _close(self) -> bool:
        """Whether the change is over, or so near its end that the rest cannot be seen."""
        change = self._change
        return change.done or abs(change.value - change.target) < NEAR

    def stop(self) -> None:
        """End the sideways motion: the entity heads along its lane again."""
        self._entity.drift = 0.0


class LaneChange(Shift):
    """The entity keeps the target lane from the start on; its offset goes from where it is to the target offset.

    Its speed is that of the oblique path: over time, what it moves sideways it does not move ahead; over a distance,
    the distance is that along the lane. Who stands does not change lanes. While the shape asks for more than the
    speed allows, all of the way goes to the side and a straight line takes the place of the shape.
    """

    __slots__ = ("_by_distance", "_element", "_other")

    def __init__(self, element: model.LaneChangeAction, entity: Entity, board: Board) -> None:
        super().__init__(entity, board)
        self._element = element
        self._by_distance = element.lane_change_action_dynamics.dynamics_dimension == "distance"
        target = element.lane_change_target
        self._other: Entity | None = None
        if isinstance(target, model.RelativeTargetLane):
            self._other = entity_called(target.entity_ref, board, target)
        if board.network is None:
            raise Unsupported("the scenario has no road network")

    def _lane(self) -> int:
        target = self._element.lane_change_target
        if self._other is None:
            return target.value
        entity, other, ground = self._entity, self._other, self._board.ground
        ours, theirs = ground.position(entity), ground.position(other)
        lane, linked = ground.lane_onwards(theirs, ours)
        if not linked:
            text = f"no lane links lead from the lane of {other.name} to {entity.name} on road {ours.road}"
            self._board.warn(self._element, "no-lane-link", f"{text}; its lane is taken for the one of its id")
        # lanes are counted to the left of the referenced entity
        left = other.sense * ground.turned(ours, theirs)
        return shifted_lane(lane, target.value if left > 0.0 else -target.value)

    def start(self) -> bool:
        """Take the target lane. True if there is no such lane (a warning) or nothing to move."""
        entity, ground = self._entity, self._board.ground
        ground.track(entity)
        network = ground.network
        assert network is not None
        lane = self._lane()
        # t of the new lane's middle, seen from the old one's
        apart = network.lane_t(entity.road, lane, entity.s) - network.lane_t(entity.road, entity.lane, entity.s)
        if apart != apart:
            self._board.warn(
                self._element,
                "no-such-lane",
                f"{entity.name}: no lane {lane} on road {entity.road} at s = {entity.s:.1f} m: no lane change",
            )
            return True
        entity.lane = lane
        entity.offset -= apart
        element = self._element
        target = element.target_lane_offset
        dynamics = element.lane_change_action_dynamics
        over = span(dynamics.dynamics_shape, dynamics.dynamics_dimension, dynamics.value, target - entity.offset)
        entity.twist = 0.0
        return self._begin(dynamics.dynamics_shape, over, target)

    def step(self, dt: float) -> bool:
        """Go on along the shape for `dt` [s]; True at the target offset. Who stands does not go on."""
        entity, change = self._entity, self._change
        self._track()
        entity.late = entity.lateral_order < entity.longitudinal_order
        ahead = abs(way(entity, dt))
        if ahead < NEAR * dt:
            return False
        rate = change.rate()
        if self._by_distance:
            ahead /= math.hypot(1.0, rate)
            change.advance(ahead)
            lean(entity, rate * ahead / dt, dt)
        elif lean(entity, rate, dt):
            change.advance(dt)
        else:
            change.advance_straight(ahead)
        if self._close():
            self._settle()
            return True
        entity.offset = change.value * entity.sense
        return False

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "lane_change" with lane, offset [m] and duration [s]; it lasts as long as the change would."""
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
    """The entity goes to an offset from its lane's middle or from another entity; `continuous` keeps it there, and the
    action goes on (in esmini's reading only if the offset is from an entity).

    Its speed is that along the lane. A step takes it to where the shape was at its beginning, so the action is over
    with the step that begins at the target (the standard does not count steps; this is how the field's tools do).
    It follows another entity no harder than `maxLateralAcc`, as closely as that allows.
    """

    __slots__ = ("_before", "_element", "_goes_on", "_other", "_rate", "_target")

    def __init__(self, element: model.LaneOffsetAction, entity: Entity, board: Board) -> None:
        super().__init__(entity, board)
        self._element = element
        self._target = 0.0
        self._rate = 0.0  # of the own offset [m/s]
        self._before: float | None = None  # where the other one wanted it a step ago, once it was there
        self._other: Entity | None = None
        target = element.lane_offset_target
        ends = board.reading == "esmini" and not isinstance(target, model.RelativeTargetLaneOffset)
        self._goes_on = element.continuous and not ends
        if isinstance(target, model.RelativeTargetLaneOffset):
            self._other = entity_called(target.entity_ref, board, target)
        if board.network is None:
            raise Unsupported("the scenario has no road network")

    def _wanted(self) -> float:
        """Target offset; a relative one is to the other's left."""
        entity, other, ground = self._entity, self._other, self._board.ground
        value = self._element.lane_offset_target.value
        if other is None:
            return value
        ours, theirs = ground.position(entity), ground.position(other)
        apart = ground.turned(ours, theirs) * (theirs.t + value * other.sense) - ours.t
        return entity.offset + apart

    def start(self) -> bool:
        """Begin the way to the offset; True if it is over at once."""
        entity, ground = self._entity, self._board.ground
        ground.track(entity)
        self._target = self._wanted()
        dynamics = self._element.lane_offset_action_dynamics
        change = self._target - entity.offset
        if dynamics.max_lateral_acc is None:
            over = 0.0
        else:
            over = lateral_span(dynamics.dynamics_shape, dynamics.max_lateral_acc, change)
        return self._begin(dynamics.dynamics_shape, over, self._target) and self._ends()

    def step(self, dt: float) -> bool:
        """Go on along the shape for `dt` [s], then follow the target; True at it unless `continuous`."""
        entity, change = self._entity, self._change
        self._track()
        if self._element.continuous and self._other is not entity:  # an offset from oneself is taken once
            change.target = self._wanted() * entity.sense
        if self._close():
            change.value = self._kept(change.value, change.target, dt)  # which may have moved since
            self._settle()
            return self._ends()
        entity.twist = 0.0
        entity.drift = math.atan(change.rate() / entity.speed) if abs(entity.speed) > STILL else 0.0
        entity.shifted = True
        entity.offset = change.value * entity.sense
        before = change.value
        self._rate = self._next_rate((change.advance(dt) - before) / dt, dt)
        change.value = before + self._rate * dt
        return False

    def _limit(self) -> float:
        """The lateral acceleration that limits who follows another entity [m/s^2]: class LaneOffsetActionDynamics,
        `used to initially reach and afterwards keep the lane offset`. To an offset of its own the shape keeps to it."""
        limit = self._element.lane_offset_action_dynamics.max_lateral_acc
        return math.inf if limit is None or not self._goes_on or self._other is self._entity else limit

    def _next_rate(self, wanted: float, dt: float) -> float:
        """The wanted speed to the side [m/s], or as near to it as the limit lets it come; a line has corners."""
        limit = self._limit()
        if limit == math.inf or (
            not self._change.done and self._element.lane_offset_action_dynamics.dynamics_shape == "linear"
        ):
            return wanted
        return self._rate + min(max(wanted - self._rate, -limit * dt), limit * dt)

    def _kept(self, value: float, target: float, dt: float) -> float:
        """The next offset of who is at its target and follows it [m], within its lateral acceleration.

        It moves as its place does, and draws nearer at the speed from which it can still stop there, sqrt(2 a e).
        """
        limit = self._limit()
        if limit == math.inf:
            return target
        before, self._before = self._before, target
        if before is None:  # where the step before has already brought it
            return value
        left = before - value
        closing = math.copysign(min(math.sqrt(2.0 * limit * abs(left)), abs(left) / dt), left)
        self._rate = self._next_rate((target - before) / dt + closing, dt)
        return value + self._rate * dt

    def _ends(self) -> bool:
        """Whether the action is over at its target."""
        if self._element.continuous and not self._goes_on:
            self._board.warn(self._element, "reading-offset-ended", OFFSET_ENDED)
        return not self._goes_on

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "lane_offset" with the offset [m]; over at once."""
        return "lane_offset", {"offset": self._element.lane_offset_target.value}, 0.0


@action(model.LaneChangeAction)
def lane_change(element: model.LaneChangeAction, entity: Entity, board: Board) -> Runner:
    """Change to a lane of the road, counted from the entity's own or another's, or by its id."""
    return LaneChange(element, entity, board)


@action(model.LaneOffsetAction)
def lane_offset(element: model.LaneOffsetAction, entity: Entity, board: Board) -> Runner:
    """Go to an offset from the middle of the lane, or from another entity."""
    return LaneOffset(element, entity, board)
