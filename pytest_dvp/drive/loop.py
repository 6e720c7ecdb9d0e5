"""The closed loop: 20 ticks a second of storyboard, world, sensors, driving stack and vehicle, recorded as it runs.

Order of a tick at time t: the ego's truth goes into the storyboard, the world is looked at, the vehicle's sensors
observe it, the stack decides, the vehicle takes the command; then storyboard and vehicle both move on to t + 0.05 s.
So every condition and every sensor sees all things as they are at one instant.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

import msgspec
import numpy as np

from openscenario.road.footprint import Footprint
from openscenario.road.route import RouteError
from openscenario.storyboard.plausibility import Plausibility
from pytest_dvp.drive.command_range import CommandRange
from pytest_dvp.drive.ego_task import route_from_here
from pytest_dvp.drive.overridden import overridden
from pytest_dvp.drive.stack_faults import StackHung, told_of
from pytest_dvp.drive.terrain import NeedsTerrain, Terrain
from pytest_dvp.drive.weather import NeedsFriction, NeedsWind, Weather
from pytest_dvp.logs.event_names import EventNames
from vehicle.adapter import position_sigma_of
from vehicle.adapters.mirror import SAME, Mirror
from vehicle.messages import TICK, FloatArray, RoadPoint, SignalState, Surroundings, Task

if TYPE_CHECKING:
    from openscenario.road.network import RoadNetwork
    from openscenario.road.positions import RoadPosition
    from pytest_dvp.drive.prepared_run import Ready

RATE = round(1.0 / TICK)  # 1/s
STANDING = 0.05  # m/s
SETTLING = 10.0  # s that a run waits at its goal for the ego to stand

Ending = Literal["stop", "goal", "timeout", "collision", "wall", "fault", "interrupt"]


@dataclasses.dataclass(frozen=True)
class Limits:
    """Ends of a run [s]: simulated, wall, and simulated time from a collision."""

    duration: float
    wall: float
    after_collision: float


class Part(Protocol):
    """Keeps what is recorded so far; `pytest_dvp.logs.partial_log.LogPart` is one."""

    def reached(self, t: float) -> None:
        """The run has come to `t` [s]: everything before it may be kept."""
        ...


class Loop:
    """One run; `drive` runs it to its end and says which end that was.

    part      is told how far the run has come: the log on disk
    error     the traceback of a stack or vehicle that broke, or the one line of what it did wrong, after a "fault"
    seconds   wall time [s] that each tick of the stack took
    commands  what the stack asked for beyond the car
    plausibility  what the storyboard's entities did that nobody could
    """

    def __init__(self, ready: Ready, limits: Limits, part: Part | None = None) -> None:
        self._part, self._t = part, 0.0
        self._whole = ready.recorder.mark()  # what was recorded before the tick that is under way
        self._storyboard, self._ego, self._world = ready.storyboard, ready.ego, ready.world
        self._vehicle, self._driver, self._network = ready.vehicle, ready.driver, ready.network
        self._recorder, self._first, self._limits = ready.recorder, ready.first_row, limits
        self._events = EventNames(ready.scenario)
        self._folder = ready.scenario.path.parent.absolute()
        self._goal = Zone(ready.network, ready.task.goal) if ready.task.goal is not None else None
        self._start = Zone(ready.network, ready.task.start, at_once=True)
        self._task: Task | None = ready.task.message()
        d = ready.vehicle.description
        ahead, behind, side = d.center_x + 0.5 * d.length, d.center_x - 0.5 * d.length, 0.5 * d.width
        corners = ((ahead, side), (behind, side), (behind, -side), (ahead, -side))
        self._footprint = Footprint(ready.network, np.array(corners))
        terrain = Terrain(ready.network)
        self._terrain = None if terrain.flat else terrain
        self._weather = Weather(ready.network.geo_reference)
        self._monitors = {each.name: each.value for each in ready.scenario.monitor_declarations}
        self._here: RoadPosition | None = None
        self._lights: tuple[dict[str, str], tuple[SignalState, ...]] = ({}, ())
        self._transitions = 0
        self._mirror, self._gate_log = Mirror(), ready.gate_log
        self._targets = ready.targets
        self._unplaced = ready.vehicle.is_real  # it stands as it stands: its own word of the beginning counts
        self.error: str | None = None
        self.seconds: list[float] = []
        self.commands = CommandRange(ready.vehicle.description)
        self.plausibility = Plausibility(ready.storyboard)

    def drive(self) -> Ending:
        """Run to the end. An interruption (SIGINT) is one, too: the car is stopped, and the log so far is kept."""
        try:
            return self._drive()
        except KeyboardInterrupt:
            self.error = f"interrupted at t={self._t:.2f} s"
            # The car may be gone, or have been interrupted in the middle of a word: it then stops by itself.
            with contextlib.suppress(Exception):
                self._vehicle.stop()
            self._recorder.cut(self._whole)
            self._recorder.event(self._t, "fault", "harness", "interrupted")
            return self._end(self._t, "interrupt")

    def _drive(self) -> Ending:
        rows = self._first
        deadline = time.monotonic() + self._limits.wall
        self._driver.end_by(deadline, self._limits.wall)
        ticks = round(self._limits.duration / TICK)
        before: Surroundings | None = None
        collided: float | None = None
        if not self._unplaced:
            self._recorder.ego_rows(rows)
        for k in range(ticks + 1):
            t = self._t = k / RATE  # the nearest double, not a sum of rounded steps
            self._whole = self._recorder.mark()
            if self._part is not None:
                self._part.reached(t)
            rows = self._mirror.show(t, rows)
            state = rows[-1]
            self._place(state)
            self._change_weather(t, state)
            around = self._world.look(t, self._signals(), self._weather.extinction, self._weather.light)
            if before is not None and self._touched(rows, before, around) and collided is None:
                collided = t
            before = around
            ending = self._ending(t, state, ticks * TICK, collided, deadline)
            if ending is not None:
                self._gate_log.drain(self._recorder)  # of the last step
                return self._end(t, ending)
            try:
                rows = self._advance(t, around, state)
            except Exception as error:  # the thing under test broke: a finding of this run, not of the harness
                told = told_of(error)
                self.error = told.error
                with contextlib.suppress(Exception):  # a car that is lost stops by itself
                    self._vehicle.stop()
                self._gate_log.drain(self._recorder)  # what it decided meanwhile
                if isinstance(error, StackHung) and error.wall:
                    return self._end(t, "wall")
                self._recorder.event(t, "fault", told.kind, told.said)
                return self._end(t, "fault")
        raise AssertionError("unreachable: the last tick ends by its duration")

    def _signals(self) -> tuple[SignalState, ...]:
        """States of the traffic signals the storyboard has set; a change goes into the log."""
        now = self._storyboard.world.signals
        if now != self._lights[0]:
            for name in sorted(now):
                if self._lights[0].get(name) != now[name]:
                    self._recorder.event(self._t, "signal", name, now[name])
            self._lights = dict(now), tuple(SignalState(name, state) for name, state in sorted(now.items()))
        return self._lights[1]

    def _change_weather(self, t: float, state: FloatArray) -> None:
        """What an EnvironmentAction has set, and the material of the lane, to the car and into the log."""
        environment = self._storyboard.world.environment
        changed = self._weather.look(environment, t)
        slips = self._network.states_friction and self._weather.drive_on(self._lane_friction(state))
        if not (changed or slips):
            return
        if isinstance(self._vehicle, NeedsFriction):
            self._vehicle.limit_friction(self._weather.friction)
        if isinstance(self._vehicle, NeedsWind):
            self._vehicle.blow(*self._weather.wind)
        name = environment.name if environment is not None and changed else "road"
        self._recorder.event(t, "environment", name, str(self._weather))

    def _lane_friction(self, state: FloatArray) -> float:
        """Friction coefficient [-] of the lane under the reference point; 1 beside the road."""
        place = self._here = self._network.locate(float(state[1]), float(state[2]), float(state[4]), self._here)
        return self._network.lane_friction(place.road, place.lane, place.s) if place.on_road else 1.0

    def _place(self, state: FloatArray) -> None:
        # TRACE_COLUMNS: t x y z yaw v vx vy yaw_rate ax ay steer
        _, x, y, z, yaw, speed, _, _, _, ax, _, _ = state.tolist()
        self._storyboard.place(self._ego, x, y, z, yaw, speed, ax)

    def _advance(self, t: float, around: Surroundings, state: FloatArray) -> FloatArray:
        observation = self._vehicle.observe(around)
        if self._task is not None:
            observation = msgspec.structs.replace(observation, task=self._task)
            self._task = None
        driver = self._driver
        command = driver.tick(observation)
        self.seconds.append(driver.seconds)
        self.commands.look(t, command)
        ego = self._storyboard.entities[self._ego]
        command = overridden(command, ego.controls, self._vehicle.description)
        self._vehicle.apply(command)
        self._gate_log.drain(self._recorder)
        self._recorder.tick(
            t,
            command=command,
            ads=driver.trace,
            surroundings=around if self._targets is None else self._targets.measured(t, around),
            detections=driver.detections,
            path=driver.path,
            held=self._held(state) | {"command_age": t - command.t},
        )
        self._storyboard.step(TICK)
        if ego.controls is not None:
            ego.controls.step(TICK)
        self.plausibility.look(TICK)
        self._drain(t)
        if self._terrain is not None and isinstance(self._vehicle, NeedsTerrain):
            self._vehicle.place_on_road(*self._terrain.under(float(state[1]), float(state[2]), float(state[4])))
        rows = self._vehicle.step(TICK)
        if self._unplaced and len(rows):
            self._unplaced, first = False, rows[:1].copy()
            first[0, 0] = t
            self._recorder.ego_rows(first)
        self._recorder.ego_rows(rows)
        return rows

    def _held(self, state: FloatArray) -> dict[str, float]:
        on_road, width, limit = self._footprint.under(float(state[1]), float(state[2]), float(state[4]))
        held = {"on_road": 1.0 if on_road else 0.0, "lane_width": width, "speed_limit": limit}
        held |= self._gate_log.output
        if self._mirror.latency > SAME:
            held |= {"mirror_error": self._mirror.error, "mirror_latency": self._mirror.latency}
        sigma = position_sigma_of(self._vehicle)
        return held | {"position_sigma": sigma} if sigma > 0.0 else held

    def _drain(self, t: float) -> None:
        """Transitions, monitors and requests of this tick into the log; requests into the next observation."""
        transitions = self._storyboard.transitions
        while self._transitions < len(transitions):
            step = transitions[self._transitions]
            self._transitions += 1
            text = f"{step.from_state} -> {step.to_state}"
            self._recorder.event(
                step.time, f"story.{step.kind}", self._events.of(step), text, self._file(step.file), step.line
            )
        for name, value in self._storyboard.world.monitors.items():
            if self._monitors.get(name) != value:
                self._monitors[name] = value
                self._recorder.event(t, "monitor", name, str(value).lower())
        if self._storyboard.requests:
            for request in self._storyboard.requests:
                said = _said(request.values)
                try:
                    self._task = self._requested(request.kind, request.values)
                except RouteError as error:  # the stack could not plan it either; the log says what was not done
                    said = f"refused: {error}"
                self._recorder.event(request.time, "request", request.kind, said)
            self._storyboard.requests.clear()

    def _requested(self, kind: str, values: Mapping[str, Any]) -> Task | None:
        task = self._task or Task()
        if kind == "speed":
            return msgspec.structs.replace(task, set_speed=max(0.0, float(values["target"])))
        if kind == "route" and values["places"]:
            ego = self._storyboard.entities[self._ego]
            points = route_from_here(self._network, ego.x, ego.y, ego.h, values["places"])
            return msgspec.structs.replace(task, goal=points[-1], route=points[:-1])
        return self._task

    def _touched(self, rows: FloatArray, before: Surroundings, after: Surroundings) -> bool:
        if not after.names:
            return False
        contacts = self._world.contacts(rows, before, after)
        for contact in contacts:
            self._recorder.event(contact.t, "collision", contact.name, f"impulse {contact.impulse:.1f} N s")
        return bool(contacts)

    def _ending(
        self, t: float, state: FloatArray, last: float, collided: float | None, deadline: float
    ) -> Ending | None:
        if self._storyboard.done:
            return "stop"
        if collided is not None and t >= collided + self._limits.after_collision - 1e-9:
            return "collision"
        x, y = float(state[1]), float(state[2])
        if self._start.since == math.inf and self._start.passed(t, x, y):
            self._recorder.event(t, "start", self._ego)
        if self._goal is not None and self._goal.passed(t, x, y):
            if self._goal.since == t:
                self._recorder.event(t, "goal", self._ego)
            if abs(float(state[5])) < STANDING or t >= self._goal.since + SETTLING:
                return "goal"
        if t >= last - 1e-9:
            return "timeout"
        if time.monotonic() > deadline:
            self.error = f"the wall limit of {self._limits.wall:g} s ended the run"
            return "wall"
        return None

    def _end(self, t: float, ending: Ending) -> Ending:
        if ending in ("stop", "goal"):
            self._recorder.event(t, "stop", "storyboard" if ending == "stop" else "goal")
        elif ending in ("timeout", "wall"):
            self._recorder.event(t, "timeout", "duration" if ending == "timeout" else "wall-limit")
        return ending

    def _file(self, file: str) -> str:
        """Place of a file as the log may hold it: relative to the scenario's folder, never absolute."""
        path = Path(file)
        try:
            return path.absolute().relative_to(self._folder).as_posix()
        except ValueError:
            return path.name


class Zone:
    """Where the task begins or ends: within `radius` [m] of a place, or past its line within that of the lane's centre.

    at_once: counts for an ego that stands in it from the beginning; else it must have been outside before, so that a
    round trip does not end where it starts.
    """

    def __init__(self, network: RoadNetwork, place: RoadPoint, *, at_once: bool = False, radius: float = 3.0) -> None:
        pose = network.lane_pose(place.road, place.lane, place.s)
        sign = network.driving_sign(place.road, place.lane)
        self._x, self._y = pose.x, pose.y
        self._cos, self._sin = sign * math.cos(pose.h), sign * math.sin(pose.h)
        self._radius = radius
        self._behind = False
        self._counts = at_once
        self.since = math.inf

    def passed(self, t: float, x: float, y: float) -> bool:
        """True from the first time on that the point was in the zone."""
        if math.isfinite(self.since):
            return True
        dx, dy = x - self._x, y - self._y
        ahead = dx * self._cos + dy * self._sin
        beside = abs(dy * self._cos - dx * self._sin)
        crossed = self._behind and ahead >= 0.0
        self._behind = -4.0 * self._radius < ahead < 0.0 and beside <= self._radius
        inside = dx * dx + dy * dy <= self._radius**2
        if self._counts and (inside or (crossed and beside <= self._radius)):
            self.since = t
            return True
        self._counts = self._counts or not inside
        return False


def _said(values: Mapping[str, Any]) -> str:
    """Scalars of a request; its lists of points are in the storyboard's file."""
    plain = ((name, value) for name, value in values.items() if isinstance(value, int | float | str))
    return ", ".join(f"{name}={value:.6g}" if isinstance(value, float) else f"{name}={value}" for name, value in plain)
