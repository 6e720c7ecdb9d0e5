"""FollowTrajectoryAction, with the trajectory's own time or with the entity's speed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from openscenario import model
from openscenario.storyboard.entity import Entity
from openscenario.storyboard.motion import way
from openscenario.storyboard.places import Place
from openscenario.storyboard.positions import place, resolver
from openscenario.storyboard.registry import action
from openscenario.storyboard.runner import Runner
from openscenario.storyboard.trajectories import Course, course

if TYPE_CHECKING:
    from openscenario.storyboard.board import Board

JUMP = 1e-3  # m


class FollowTrajectory:
    """Moves the reference point along the trajectory.

    With timing the trajectory's time stamps give the way along it, and the entity's speed follows from that;
    without, the entity goes on with its own speed, which other actions may change meanwhile. The following modes
    differ in how the default controller gets from vertex to vertex of a polyline: `follow` turns and accelerates
    evenly, `position` turns at the vertices and has constant speed between them.

    An initial distance offset cuts the trajectory: it begins there, with relative timing at once, with absolute timing
    at that place's own time.

    Properties of the vehicle that esmini knows count here too: `refpoint_x_offset` [m] (the point that follows lies so
    far ahead of another that is drawn along), `ignoreHeadingForTrajMotion`, `plineInterpolation`.
    """

    __slots__ = (
        *("_aim", "_board", "_clock", "_course", "_cut", "_element", "_entity", "_hilly", "_reverse", "_s"),
        "domains",
    )

    def __init__(self, element: model.FollowTrajectoryAction, entity: Entity, board: Board) -> None:
        self._element = element
        self._entity = entity
        self._board = board
        shape = element.trajectory.shape
        timed = isinstance(element.time_reference, model.Timing) and _stamped(shape)
        self.domains: tuple[str, ...] = ("longitudinal", "lateral") if timed else ("lateral",)
        self._course: Course | None = None
        self._s = 0.0
        self._cut = 0.0  # [m] of the trajectory that are left out at its beginning
        self._clock = 0.0
        self._reverse = False
        self._hilly = False
        self._aim = (math.nan, math.nan, 0.0)  # where `way_to` was asked for last
        for position in _positions(shape):
            resolver(position, board)

    def _begin(self) -> Course:
        board = self._board
        entity = self._entity
        here = Place(entity.x, entity.y, entity.z, entity.h)
        follow = abs(entity.speed) if self._element.trajectory_following_mode.following_mode == "follow" else None
        turning = entity.properties.get("plineInterpolation")
        along = course(
            self._element.trajectory, lambda position: place(position, board), here, follow=follow, turning=turning
        )
        self._course = along
        self._hilly = min(along.z) != max(along.z)
        timing = self._element.time_reference
        if isinstance(timing, model.Timing):
            # domain relative: time stamps count from the start of the action
            self._clock = 0.0 if timing.domain_absolute_relative == "relative" else board.time
        self._cut = min(self._element.initial_distance_offset, along.length)
        if self._cut > 0.0 and isinstance(timing, model.Timing) and timing.domain_absolute_relative == "relative":
            self._clock = timing.scale * (along.time_at(self._cut) - along.start_time)
        return along

    def start(self) -> bool:
        """Put the entity on the trajectory. A warning if timing is asked for and the trajectory has no time stamps."""
        along = self._begin()
        element, entity = self._element, self._entity
        if len(self.domains) == 1 and isinstance(element.time_reference, model.Timing):
            text = "the trajectory has no time stamps, but its action asks for timing: followed at the own speed"
            self._board.warn(element.trajectory, "no-time-stamps", text)
        if along.explicit and entity.properties.get("ignoreHeadingForTrajMotion") != "true":
            self._reverse = math.cos(along.h[0] - along.tangent(0.0)) < 0.0
        else:
            self._reverse = len(self.domains) == 1 and entity.speed < 0.0
        self._s = max(self._cut, along.s_at(self._trajectory_time())) if len(self.domains) > 1 else self._cut
        x, y = entity.x, entity.y
        self._go(along)
        if math.hypot(entity.x - x, entity.y - y) > JUMP:
            entity.vx = entity.vy = 0.0  # being put there is no motion
        return along.length <= 0.0 and len(self.domains) == 1

    def _trajectory_time(self) -> float:
        timing = self._element.time_reference
        assert isinstance(timing, model.Timing)
        return (self._clock - timing.offset) / timing.scale

    def step(self, dt: float) -> bool:
        """Go on along the trajectory for `dt` [s]; True at its end, where the rest of the step goes straight on."""
        entity, along = self._entity, self._course
        assert along is not None
        x, y = entity.x, entity.y
        before = self._s
        if len(self.domains) > 1:
            over = self._step_timed(dt, along)
        else:
            over = self._step_untimed(dt, along)
        done = over >= -1e-9
        self._go(along)
        if done and over > 0.0:
            # what is left of the step: straight on
            rest = math.copysign(over, entity.speed)
            entity.put(entity.x + rest * math.cos(entity.h), entity.y + rest * math.sin(entity.h), entity.z, entity.h)
        if done and self._board.network is None:
            entity.end_of_road = True  # no lane to keep from here on
        entity.moved = True
        entity.travelled += abs(self._s - before) + max(over, 0.0)
        entity.vx, entity.vy = (entity.x - x) / dt, (entity.y - y) / dt
        return done

    def _step_timed(self, dt: float, along: Course) -> float:
        """Go on by time; the metres beyond the end, negative before it."""
        entity = self._entity
        before = self._s
        self._clock += dt
        time = self._trajectory_time()
        self._s = max(self._cut, along.s_at(time))
        late = time - along.end_time
        if late > 1e-9:
            return late * abs(entity.speed)
        if along.explicit and entity.properties.get("ignoreHeadingForTrajMotion") != "true" and self._s > before:
            # headings that turn round against the curve make it reverse from there on
            self._reverse = math.cos(along.at(self._s)[3] - along.tangent(0.5 * (before + self._s))) < 0.0
        speed = (before - self._s if self._reverse else self._s - before) / dt
        entity.ax = (speed - entity.speed) / dt
        entity.speed = speed
        return 0.0 if late >= -1e-9 else -1.0

    def _step_untimed(self, dt: float, along: Course) -> float:
        """Go on by the entity's own speed, back if it has turned since the start; a closed trajectory goes round.

        A vehicle that reverses from the start, or whose headings look back, goes the same way, rear first.
        """
        entity = self._entity
        entity.ax = (entity.speed - entity.speed_before) / dt
        entity.late = entity.lateral_order < entity.longitudinal_order
        step = way(entity, dt)
        s = self._s + (-step if self._reverse else step)
        if self._element.trajectory.closed and along.length > 0.0:
            self._s = s % along.length
            return -1.0
        self._s = min(max(s, 0.0), along.length)
        if step == 0.0:
            return -1.0
        return max(s - along.length, -s) if (step < 0.0) != self._reverse else s - along.length

    def _go(self, along: Course) -> None:
        entity = self._entity
        x, y, z, h = along.at(self._s)
        before = entity.x, entity.y, entity.h
        entity.put(x, y, z, h + math.pi if self._reverse and not along.explicit else h)
        if self._hilly:
            entity.pitch = -along.pitch(self._s) if self._reverse else along.pitch(self._s)
        if entity.leads > 0.0:
            entity.draw_behind(*before)

    def axis(self) -> tuple[float, float]:
        """Direction and pitch [rad] of the trajectory here."""
        assert self._course is not None
        return self._course.tangent(self._s), self._course.pitch(self._s)

    def way_to(self, target: Place) -> float:
        """Way [m] along the trajectory between here and the point of it that lies nearest to `target`."""
        assert self._course is not None
        if self._aim[:2] != (target.x, target.y):
            self._aim = target.x, target.y, self._course.nearest(target.x, target.y)
        return abs(self._aim[2] - self._s)

    def beside(self, x: float, y: float) -> tuple[float, float, float]:
        """s and t [m] of a place in the trajectory's coordinates, s from here, and the trajectory's direction there
        [rad]; beyond its ends it goes straight on."""
        along = self._course
        assert along is not None
        s = along.nearest(x, y)
        h = along.tangent(s)
        at_x, at_y, _, _ = along.at(s)
        dx, dy = x - at_x, y - at_y
        ahead = dx * math.cos(h) + dy * math.sin(h) if s <= 0.0 or s >= along.length else 0.0
        return s + ahead - self._s, dy * math.cos(h) - dx * math.sin(h), h

    def stop(self) -> None:
        """Do nothing: the entity goes on from where it is."""

    def ask(self) -> tuple[str, dict[str, Any], float]:
        """A request "trajectory" with points (x, y [m], h [rad]) and times [s] or None; it lasts until the last."""
        along = self._begin()
        timed = len(self.domains) > 1
        left = max(along.end_time - self._trajectory_time(), 0.0) if timed else 0.0
        points = tuple(zip(along.x, along.y, along.h, strict=True))
        return "trajectory", {"points": points, "times": tuple(along.t) if timed and along.t else None}, left


def _positions(shape: model.Shape) -> list[model.Position]:
    if isinstance(shape, model.Polyline):
        return [vertex.position for vertex in shape.vertices]
    if isinstance(shape, model.Clothoid):
        return [shape.position]
    if isinstance(shape, model.ClothoidSpline):
        return [each.position_start for each in shape.segments if each.position_start is not None]
    return [point.position for point in shape.control_points]


def _stamped(shape: model.Shape) -> bool:
    if isinstance(shape, model.Polyline):
        return all(vertex.time is not None for vertex in shape.vertices)
    if isinstance(shape, model.Clothoid):
        return shape.start_time is not None and shape.stop_time is not None
    if isinstance(shape, model.ClothoidSpline):
        return shape.time_end is not None and all(each.time_start is not None for each in shape.segments)
    return all(point.time is not None for point in shape.control_points)


@action(model.FollowTrajectoryAction)
def follow_trajectory(element: model.FollowTrajectoryAction, entity: Entity, board: Board) -> Runner:
    """In the time of the time stamps, or at the own speed; see below."""
    return FollowTrajectory(element, entity, board)
