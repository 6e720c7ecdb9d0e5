"""A driving stack in a process of its own, over ROS 2 messages (`--ads ros2:stack.toml`), in lock-step.

    command = ["ros2", "launch", "my_stack", "drive.launch.py"]   # {python}, {domain} are filled in
    answer = 20.0                                                 # s of wall time for a tick
    start = 60.0                                                  # s until it must have answered for the first time
    [parameters]                                                  # of its own, with defaults: --set P.NAME=VALUE
    LK_look = 1.2
    [origin]                                                      # of the map; default: what its geoReference says
    latitude = 48.137
    longitude = 11.575
    [environment]
    RMW_IMPLEMENTATION = "rmw_cyclonedds_cpp"

ROS_DOMAIN_ID is set. In a test, `RemoteStack("stack.toml")` as `ads` of several runs keeps the process and resets it
for each run. A command without pedals gets those of the reference stack.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from pytest_dvp.drive.stack_faults import AdsError, AdsFault
from pytest_dvp.drive.stack_parameters import as_plain
from pytest_dvp.text.spelling import unknown
from vehicle.messages import TICK
from vehicle.toml_file import TomlError, read_toml

if TYPE_CHECKING:
    from vehicle.messages import Command, Detection, FloatArray, Observation
    from vehicle.wire.geodetic import Origin

KEYS = ("command", "answer", "start", "environment", "parameters", "origin")
DAY = 86400.0  # s
CALL = 0.2  # s between two calls to a stack that does not answer yet
STANDING = 0.05  # m/s


class RemoteStack:
    """The stack that a file describes; called with (parameters, network, description) it gives a driver.

    keep  its process goes on from run to run, until `close`; else it ends with its run

    Raises AdsError for a file that is wrong.
    """

    has_own_deadline = True  # `answer`, and not --tick-limit

    def __init__(self, file: str | Path, *, keep: bool = True) -> None:
        self._file, self._keep = Path(file), keep
        self._command, self._environment, self._answer, self._start, self.parameters, self.origin = _read(self._file)
        self._wire: _Wire | None = None

    def __call__(self, parameters: Any, network: Any, description: Any) -> _Drive:
        return _Drive(self, parameters, network, description)

    def __enter__(self) -> RemoteStack:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def wire(self) -> _Wire:
        """The wire to the running process, which is started if it is not. Raises AdsFault."""
        if self._wire is None:
            self._wire = _Wire(self._command, self._environment, self._answer, self._start)
        return self._wire

    def close(self, *, run_over: bool = False) -> None:
        """End the process; after a run only if it is not to be kept."""
        if self._wire is not None and not (run_over and self._keep):
            self._wire.close()
            self._wire = None


class _Drive:
    """One run of the stack. Its process starts with the first tick: what is never driven starts nothing."""

    def __init__(self, stack: RemoteStack, parameters: Any, network: Any, description: Any) -> None:
        from ads.control.pedals import PiPedals
        from pytest_dvp.drive.map_origin import map_origin
        from vehicle.wire.geodetic import DEFAULT_ORIGIN

        self._stack = stack
        self._run = {
            "parameters": as_plain(parameters),
            "map": str(Path(network.file.path).absolute()),
            "origin": stack.origin or map_origin(network)[0] or DEFAULT_ORIGIN,
            "vehicle": msgspec.to_builtins(description),
        }
        self._reset = False
        self._pedals = PiPedals(description)
        self._speed: float | None = None
        self.trace: Mapping[str, float] = {}
        self.detections: Sequence[Detection] = ()
        self.path: FloatArray | None = None

    def tick(self, observation: Observation) -> Command:
        """The stack's command for this observation. Raises AdsFault if it does not come."""
        wire = self._stack.wire()
        try:
            if not self._reset:
                wire.reset(self._run, observation.t)
                self._reset = True
            command, state = wire.tick(observation)
        except AdsFault:
            self._stack.close()
            raise
        self.trace, self.detections = state.trace, state.detections
        if state.path is not None:
            self.path = np.array(state.path, dtype=np.float64).reshape(-1, 2)
        return self._with_pedals(command, observation)

    def close(self) -> None:
        """The run is over."""
        self._stack.close(run_over=True)

    def _with_pedals(self, command: Command, seen: Observation) -> Command:
        if seen.odometry:
            self._speed = seen.odometry[-1].v
        if self._speed is None:  # before the first word of the wheels: keep rolling
            return msgspec.structs.replace(command, t=seen.t)
        standing = abs(self._speed) < STANDING and command.accel <= 0.0
        throttle, brake = self._pedals.press(command.accel, self._speed, standing, TICK)
        return msgspec.structs.replace(command, t=seen.t, throttle=throttle, brake=brake)


class _Wire:
    """The process, and the end of the wire to it."""

    def __init__(self, command: list[str], environment: dict[str, str], answer: float, start: float) -> None:
        from vehicle.adapters.process import Lease
        from vehicle.child_process import Child
        from vehicle.wire import stack_topics as wire
        from vehicle.wire.dds import on_domain
        from vehicle.wire.end import End, Silence

        self._answer, self._number = answer, 0
        self._lease = Lease()
        domain = str(self._lease.domain)
        words = [word.replace("{python}", sys.executable).replace("{domain}", domain) for word in command]
        try:
            self._child = Child(words, "the stack", AdsFault, {"ROS_DOMAIN_ID": domain, **environment})
        except BaseException:
            self._lease.release()
            raise
        steps = (wire.STEP, wire.DONE)
        self._end: End | None = None
        try:
            self._end = End(on_domain(self._lease.domain), wire.TO_STACK, wire.FROM_STACK, steps, self._child.check)
            waited = 0.0
            while True:
                if self._end.matched():
                    self._end.step(0, 0)
                try:
                    self._end.next_step(CALL)
                    return
                except Silence:
                    waited += CALL
                    if waited >= start:
                        raise AdsFault(f"the stack did not answer within {start:g} s of its start") from None
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._child.process.pid

    def reset(self, run: Mapping[str, Any], t: float) -> None:
        """A new run begins."""
        from vehicle.wire import stack_topics as wire
        from vehicle.wire.ros2_types import String

        assert self._end is not None
        self._origin = run["origin"]
        self._end.send(wire.RESET, String(msgspec.json.encode(run).decode()))
        self._go_on(t)
        self._end.take(wire.STATE)

    def tick(self, seen: Observation) -> tuple[Command, Any]:
        """Observation in, command and state out."""
        from vehicle.wire import convert, topics
        from vehicle.wire import stack_topics as wire

        assert self._end is not None
        wire.send_observation(self._end, seen, self._origin)
        self._go_on(seen.t)
        commands, states = self._end.take(topics.COMMAND), self._end.take(wire.STATE)
        if not commands:
            raise AdsFault(f"the stack sent no command for t = {seen.t:.2f} s")
        state = msgspec.json.decode(states[-1].data, type=wire.State) if states else wire.State()
        return convert.command_from_ros(commands[-1]), state

    def close(self) -> None:
        """Leave the wire, and end the process."""
        if self._end is not None:
            self._end.close()
        self._child.end()
        self._lease.release()

    def _go_on(self, t: float) -> None:
        from vehicle.wire.end import Silence

        assert self._end is not None
        self._number += 1
        self._end.step(self._number, round(t * 1e9))
        try:
            self._end.next_step(self._answer, at_least=self._number)
        except Silence:
            raise AdsFault(f"the stack did not answer within {self._answer:g} s at t = {t:.2f} s") from None


def _read(file: Path) -> tuple[list[str], dict[str, str], float, float, dict[str, float], Origin | None]:
    from vehicle.wire.geodetic import read_origin

    try:
        given, _ = read_toml(file)
    except TomlError as error:
        raise AdsError(f"{error.at(file)}: no stack: {error}") from None
    for key in given:
        if key not in KEYS:
            raise AdsError(f"{file}: {unknown('key', key, KEYS)}")
    command, environment = given.get("command"), given.get("environment", {})
    if not isinstance(command, list) or not command or not all(isinstance(word, str) for word in command):
        raise AdsError(f"{file}: command: found {command!r}, allowed: a list of words")
    if not isinstance(environment, dict) or not all(isinstance(value, str) for value in environment.values()):
        raise AdsError(f"{file}: [environment]: found {environment!r}, allowed: names with words")
    times = []
    for key, default in (("answer", 20.0), ("start", 60.0)):
        value = given.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value <= DAY:
            raise AdsError(f"{file}: {key}: found {value!r}, allowed: seconds > 0, a day at most")
        times.append(float(value))
    parameters = given.get("parameters", {})
    if not isinstance(parameters, dict):
        raise AdsError(f"{file}: [parameters]: found {parameters!r}, allowed: names with numbers")
    try:
        origin = read_origin(given["origin"]) if "origin" in given else None
    except ValueError as error:
        raise AdsError(f"{file}: [origin]: {error}") from None
    return command, environment, times[0], times[1], parameters, origin
