"""SpeedProfileAction: speeds over time, straight lines between them, corners rounded where jerk has a limit."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.limits import Limits, both, first, given, performance
from openscenario.storyboard.reading import CONSTRAINTS_CUT
from openscenario.storyboard.registry import action, entity_called
from openscenario.storyboard.runner import Runner
from openscenario.storyboard.speed_curve import Piece, Point, curve

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

LATE = 1e-3  # s: less is rounding


class SpeedProfile:
    """Piecewise constant acceleration through the entries; an entry's time [s] counts from the one before.

    A first entry with time 0 is where the profile begins: mode `position` jumps to its speed, unless the action limits
    the acceleration; mode `follow` starts from the present one and keeps to the limits of jerk. An entry without time
    is reached as soon as the limits allow. Limits are those of the action, and of the vehicle where the action has
    none; where they need more time than an entry gives, it and all that follow come later, and the run says so.
    Speeds may be relative to another entity's at the start.
    """

    __slots__ = ("_board", "_clock", "_element", "_entity", "_other", "_pieces", "_times")
    domains: tuple[str, ...] = ("longitudinal",)

    def __init__(self, element: model.SpeedProfileAction, entity: Entity, board: Board) -> None:
        self._element = element
        self._entity = entity
        self._board = board
        self._other = entity_called(element.entity_ref, board) if element.entity_ref else None
        self._pieces: list[Piece] = []
        self._times: list[float] = []

    def _limits(self) -> Limits:
        """Those of the action have precedence over the vehicle's (class SpeedProfileAction); in esmini's reading they
        can only be narrower. Strictly linear lines (mode `position`) have no limit of jerk."""
        own, able = given(self._element.dynamic_constraints), performance(self._entity)
        limits = first(own, able)
        if self._board.reading == "esmini":
            narrow = both(own, able)
            if narrow != limits:
                self._board.warn(self._element, "reading-constraints", CONSTRAINTS_CUT)
            limits = narrow
        if self._element.following_mode == "position":
            limits = limits._replace(rise=math.inf, fall=math.inf)
        return limits

    def start(self) -> bool:
        """Lay the pieces of constant or changing acceleration through the entries; True if that takes no time."""
        entity, element, limits = self._entity, self._element, self._limits()
        base = self._other.speed if self._other is not None else 0.0
        entries = list(element.speed_profile_entries)
        speed = entity.speed
        if entries[0].time is not None and entries[0].time <= 0.0:
            own = given(element.dynamic_constraints)
            if element.following_mode == "follow":
                entries = entries[1:]
            elif own.up == math.inf and own.down == math.inf:
                speed = min(max(base + entries[0].speed, -limits.speed), limits.speed)
                entity.jump_to_speed(speed)
        points: list[Point] = [(0.0, speed)]
        for entry in entries:
            points.append((points[-1][0] + (entry.time or 0.0), base + entry.speed))
        self._pieces = curve(points, entity.ax, limits)
        self._times = [piece.time for piece in self._pieces]
        self._clock = 0.0
        entity.set_speed = self._pieces[-1].speed
        self._tell(points, limits)
        return self._times[-1] <= 0.0

    def _tell(self, points: list[Point], limits: Limits) -> None:
        """What the limits change of what was asked for."""
        element = self._element
        fastest = max((abs(speed) for _, speed in points[1:]), default=0.0)
        if fastest > limits.speed:
            text = f"{self._entity.name}: {fastest:g} m/s is beyond the limit of {limits.speed:g} m/s, which holds"
            self._board.warn(element, "profile-limited", text)
        if any(entry.time is None for entry in element.speed_profile_entries):
            return
        late = self._times[-1] - points[-1][0]
        if len(points) > 2 and limits.smooth:  # a rounded corner ends half its length after its point
            corner = abs(self._pieces[-2].acceleration)
            late -= 0.5 * corner / min(limits.rise, limits.fall)
        if late > LATE:
            when = "never" if late == math.inf else f"{late:.2f} s later than its times say"
            text = f"{self._entity.name}: the limits let the last speed be reached {when}"
            self._board.warn(element, "profile-limited", text)

    def step(self, dt: float) -> bool:
        """Set the speed that the profile has after another `dt` [s]; True at its end."""
        self._clock += dt
        done = self._clock >= self._times[-1] - 1e-9
        piece = self._pieces[-1 if done else bisect_right(self._times, self._clock) - 1]
        self._entity.speed = piece.speed if done else piece.at(self._clock)
        return done

    def stop(self) -> None:
        """Do nothing: the entity keeps its speed."""

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "speed" with target and speeds [m/s] at times [s]; it lasts as long as the profile."""
        before = self._entity.speed, self._entity.speed_before
        self.start()
        self._entity.speed, self._entity.speed_before = before
        pieces = [piece for piece in self._pieces if piece.time < math.inf]
        speeds = tuple(piece.speed for piece in pieces)
        times = tuple(piece.time for piece in pieces)
        return "speed", {"target": speeds[-1], "times": times, "speeds": speeds}, times[-1]


@action(model.SpeedProfileAction)
def speed_profile(element: model.SpeedProfileAction, entity: Entity, board: Board) -> Runner:
    """Go through the entries of a speed profile."""
    return SpeedProfile(element, entity, board)
