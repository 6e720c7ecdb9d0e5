"""SynchronizeAction: be at the target position when the master is at its own, with a final speed if one is given.

The way to go, s, and the master's time to its target, t, are taken anew in every step; the speed profile between
now (v0) and the target (v1) consists of ramps of constant acceleration:
 - one ramp if s = (v0 + v1) t / 2;
 - two ramps of equal magnitude otherwise, first away from v1's line and back to it. With the speed vx between them
   2 t vx^2 - 4 s vx + 2 s (v0 + v1) - t (v0^2 + v1^2) = 0, from x + y = t, (vx - v0) / x = (vx - v1) / y and the
   ways of both;
 - if vx would be negative: brake to a stand with (v0^2 + v1^2) / (2 s), wait, and start when one ramp fits; who is
   faster than v1 would be beyond half of the way by then and brakes with STOP.
A steady state takes its distance off s and its time off t. Without final speed the one ramp that arrives in time is
taken.

The master's pace is that of its last motion; being put somewhere is none. To an action that begins with the scenario,
or with the master's trajectory, the master stands: who has a final speed stands as well, for that instant, and starts
when the last ramp fits. (The standard names no profile. This is how the field's tools drive it.)

A vehicle goes no faster than its Performance says. Its accelerations are not limited, for it would come too late; where
they are beyond its Performance the run says so.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

from openscenario import model
from openscenario.storyboard.actions.trajectory import FollowTrajectory
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.places import Place
from openscenario.storyboard.positions import Where, resolver
from openscenario.storyboard.registry import action, entity_called
from openscenario.storyboard.runner import Runner

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

SMALL = 1e-6  # m or m/s; against rounding only
NEVER = 1e10  # s
ON_RAMP = 0.1  # m/s: nearer than this to the final ramp counts as on it
STOP = 8.0  # m/s^2

Phase = Literal["new", "two ramps", "last ramp", "braking", "stopped", "steady"]


class Synchronize:
    """See the module."""

    __slots__ = (
        "_board",
        "_element",
        "_entity",
        "_final",
        "_last",
        "_last_master",
        "_linger",
        "_master",
        "_master_target",
        "_phase",
        "_target",
        "_told",
    )
    domains: tuple[str, ...] = ("longitudinal",)

    def __init__(self, element: model.SynchronizeAction, entity: Entity, board: Board) -> None:
        self._element = element
        self._entity = entity
        self._board = board
        self._master = entity_called(element.master_entity_ref, board)
        self._master_target: Where = resolver(element.target_position_master, board)
        self._target: Where = resolver(element.target_position, board)
        self._final = element.final_speed
        self._phase: Phase = "new"
        self._linger = False  # slower first
        self._last = self._last_master = math.inf
        self._told = False  # that it does more than the vehicle can

    def start(self) -> bool:
        """Before the first step an entity with a final speed stands still. Never over yet."""
        if self._board.steps == 0 and self._final is not None:
            self._phase = "stopped"
            self._entity.jump_to_speed(0.0)
        return False

    def stop(self) -> None:
        """Do nothing: the entity keeps its speed."""

    def _final_speed(self) -> float | None:
        """The final speed [m/s], no faster than the vehicle can."""
        final, top = self._final, self._entity.max_speed
        if final is None:
            return None
        if isinstance(final, model.AbsoluteSpeed):
            speed = final.value
        else:
            master = self._master.speed
            speed = master + final.value if final.speed_target_value_type == "delta" else master * final.value
        return min(max(speed, -top), top)

    def _steady(self, final: float) -> tuple[float, float]:
        """Way [m] and time [s] at the final speed before the target."""
        state = self._final.steady_state if self._final is not None else None
        if state is None or final <= SMALL:
            return 0.0, 0.0
        way = state.distance if isinstance(state, model.TargetDistanceSteadyState) else state.time * final
        return way, way / final

    def _way(self, entity: Entity, target: Place) -> float:
        """Way [m] to go: along its trajectory, else along the road, else straight where no road leads there."""
        if isinstance(entity.lateral, FollowTrajectory):
            return entity.lateral.way_to(target)
        straight = math.hypot(target.x - entity.x, target.y - entity.y)
        ground = self._board.ground
        if ground.network is None:
            return straight
        along = ground.distance(ground.position(entity), ground.position_of(target))
        return abs(along) if along == along else straight

    def step(self, dt: float) -> bool:
        """Set the speed for `dt` [s]; True when it is over. A warning if it takes more than the Performance allows."""
        entity, before = self._entity, self._entity.speed
        done = self._go_on(dt)
        entity.speed = min(entity.speed, entity.max_speed)
        change = entity.speed - before
        limit = entity.max_acceleration if change > 0.0 else entity.max_deceleration
        if abs(change) > limit * dt + SMALL and not self._told:
            self._told = True
            text = f"{entity.name}: to be there in time takes {abs(change) / dt:.1f} m/s^2, beyond its Performance"
            self._board.warn(self._element, "beyond-performance", text)
        return done

    def _go_on(self, dt: float) -> bool:
        entity, element = self._entity, self._element
        tolerance = element.target_tolerance or 0.0
        tolerance_master = element.target_tolerance_master or 0.0
        master_way = self._way(self._master, self._master_target())
        way = self._way(entity, self._target())
        final = self._final_speed()
        missed = way > self._last + SMALL or master_way > self._last_master + SMALL
        self._last, self._last_master = way, master_way
        there = way < tolerance + SMALL or master_way < tolerance_master + SMALL
        way = max(way - tolerance, SMALL)
        pace = self._pace(self._master)
        time = max(master_way - tolerance_master, SMALL) / pace if pace > SMALL else NEVER
        if there or missed or time < dt:
            if final is not None:
                entity.speed = final
            return True
        if final is None:
            if time < NEVER:
                # speed after dt on the ramp that covers the way in time
                entity.speed = max(0.0, entity.speed + 2.0 * (way / time - entity.speed) / time * dt)
            return False
        entity.speed = max(0.0, self._next_speed(way, time, entity.speed, final, dt))
        return False

    def _pace(self, entity: Entity) -> float:
        """Speed [m/s] that the last step's motion shows, whichever way it went."""
        return math.hypot(entity.vx, entity.vy)

    def _next_speed(self, way: float, time: float, speed: float, final: float, dt: float) -> float:
        steady_way, steady_time = self._steady(final)
        if self._phase == "steady" or (steady_way > 0.0 and (way - steady_way < SMALL or time - steady_time < SMALL)):
            self._phase = "steady"
            return final
        way -= steady_way
        time -= steady_time
        if self._phase == "braking":
            if speed - STOP * dt < 0.0:
                self._phase = "stopped"
            return speed - STOP * dt
        if time > 0.5 * NEVER and self._phase in ("last ramp", "stopped"):
            return 0.0  # the master stands: wait for it
        if self._phase == "stopped":
            if final <= SMALL or time >= 2.0 * way / final:
                return 0.0
            self._phase = "last ramp"
        on_ramp = 2.0 * way / time - final  # the speed that one ramp to the final speed begins with
        if self._phase == "new":
            self._phase = "two ramps"
            self._linger = 0.5 * (speed + final) > way / time
        elif self._phase == "two ramps" and abs(speed - on_ramp) < ON_RAMP:
            self._phase = "last ramp"
        if self._phase == "last ramp":
            after = time - dt
            return on_ramp + (final - on_ramp) * dt / time if after > 0.0 else final
        return self._two_ramps(way, time, speed, final, dt)

    def _two_ramps(self, way: float, time: float, speed: float, final: float, dt: float) -> float:
        between, first = _corner(way, time, speed, final)
        change = (between - speed) / first
        if change > 0.0 if self._linger else change < 0.0:
            # beyond the corner between the two ramps, or never before it
            self._phase = "last ramp"
            return speed
        if between < 0.0:
            change = -(speed * speed + final * final) / (2.0 * way)
            if speed > final:
                self._phase = "braking"
                return speed - STOP * dt
            if speed + change * dt < 0.0:
                self._phase = "stopped"
                return 0.0
        return speed + change * dt


def _corner(way: float, time: float, speed: float, final: float) -> tuple[float, float]:
    """Speed [m/s] between the two ramps, and the time [s] until then; the present speed if there is none."""
    if abs(final - speed) < SMALL:
        return 2.0 * way / time - speed, 0.5 * time
    square = 4.0 * way * way - 2.0 * time * (2.0 * way * (speed + final) - time * (speed * speed + final * final))
    root = math.sqrt(max(square, 0.0))
    for term in (root, -root):
        first = (2.0 * final * time - 2.0 * way - term) / (2.0 * (final - speed))
        if 0.0 < first < time:
            return (2.0 * way - term) / (2.0 * time), first
    return speed, time


@action(model.SynchronizeAction)
def synchronize(element: model.SynchronizeAction, entity: Entity, board: Board) -> Runner:
    """Ramps of constant acceleration; see below."""
    return Synchronize(element, entity, board)
