"""A driver of which only `tick` is required: what it returns and offers is checked, and its time is taken."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pytest_dvp.drive.compile_time import COMPILING
from pytest_dvp.drive.deadline import Deadline
from pytest_dvp.drive.stack_faults import AdsFault, StackHung, one_line, raised, what
from pytest_dvp.rooms.own_package_advice import other_class

if TYPE_CHECKING:
    from vehicle.messages import Command, Detection, FloatArray, Observation

_FIELDS = ("t", "steer", "accel", "throttle", "brake")  # of a Command
_NUMBERS = ("t", "x", "y", "yaw", "length", "width", "vx", "vy")  # of a Detection, as the log keeps them


class OnlyTick:
    """The stack `driver`. After a `tick`, what it offers besides is here, as it was then.

    nets        that the stack decides by, as plain data, for the report; empty if it tells none
    trace       names with numbers
    detections  of `vehicle.messages.Detection`
    path        array (n, 2) of x, y [m], the same one until the stack gives another; or None
    seconds     wall time [s] that its `tick` took, without what numba compiled in it
    """

    def __init__(self, driver: Any, name: str, deadline: Deadline | None = None) -> None:
        from vehicle.messages import Command, Detection

        self._driver, self._name, self._command, self._detection = driver, name, Command, Detection
        self._deadline = deadline if deadline is not None else Deadline(name, math.inf)
        with self._deadline.within("nets", first=True):
            self._tick: Callable[[Observation], Command] = driver.tick
            nets = getattr(driver, "nets", None)
            self.nets: list[Any] = list(nets) if isinstance(nets, list | tuple) else []
        COMPILING.attach()
        self._first = True
        self._given: object = None
        self.trace: Mapping[str, float] = {}
        self.detections: Sequence[Detection] = ()
        self.path: FloatArray | None = None
        self.seconds = 0.0

    def end_by(self, wall: float, limit: float) -> None:
        """The whole run must be over at `wall` (`time.monotonic`), after its `limit` [s]."""
        self._deadline.wall, self._deadline.wall_limit = wall, limit

    def tick(self, observation: Observation) -> Command:
        """The stack's command for an observation.

        Raises AdsFault if it returns anything but a Command of finite numbers, offers something in another form, or
        does not return in time; StackRaised with what the stack itself raised.
        """
        first, self._first = self._first, False
        with self._deadline.within("tick", first=first):
            try:
                compiled, begin = COMPILING.seconds, time.perf_counter()
                command = self._tick(observation)
                self.seconds = max(0.0, time.perf_counter() - begin - (COMPILING.seconds - compiled))
                command = self._checked(command)
                self.trace, self.detections, self.path = self._traced(), self._detected(), self._planned()
                return command
            except SystemExit as error:  # it would end the harness, with an exit code that looks like a verdict
                raise AdsFault(f"ADS {self._name}: tick ended the program: {one_line(error)}") from None
            except AdsFault:
                raise
            except Exception as error:
                raise raised(error) from error

    def close(self) -> None:
        """Free what the stack holds, if it has something to free: its method close()."""
        self._deadline.wall = math.inf
        try:
            with self._deadline.within("close", first=True):
                close = getattr(self._driver, "close", None)
                if callable(close):
                    close()
        except StackHung as error:
            print(error, file=sys.stderr)
        except (Exception, SystemExit) as error:  # what it drove is driven, and is kept
            print(f"ADS {self._name}: close: {one_line(error)}", file=sys.stderr)
        finally:
            self._deadline.close()

    def _checked(self, command: Any) -> Command:
        if not isinstance(command, self._command):
            if type(command).__name__ == self._command.__name__:  # of another package of the name of ours
                raise AdsFault(f"ADS {self._name}: tick returned {other_class(type(command), self._command)}")
            raise AdsFault(f"ADS {self._name}: tick returned {what(command)}, expected a vehicle.messages.Command")
        steer, accel, throttle, brake = command.steer, command.accel, command.throttle, command.brake
        try:
            finite = math.isfinite(steer) and math.isfinite(accel) and math.isfinite(throttle) and math.isfinite(brake)
            if type(steer) is type(accel) is type(throttle) is type(brake) is type(command.t) is float:
                plain = command
            else:
                asked = (float(value) for value in (command.t, steer, accel, throttle, brake))
                plain = self._command(*asked)
        except (TypeError, ValueError, OverflowError):
            fields = {name: getattr(command, name) for name in _FIELDS}
            wrong = {name: value for name, value in fields.items() if not _is_number(value)}
            raise AdsFault(f"ADS {self._name}: {_with(wrong or fields)}, expected numbers") from None
        if not finite:
            given = {name: getattr(plain, name) for name in _FIELDS[1:]}
            wrong = {name: value for name, value in given.items() if not math.isfinite(value)}
            raise AdsFault(f"ADS {self._name}: {_with(wrong)}, expected finite numbers")
        return plain

    def _traced(self) -> Mapping[str, float]:
        trace = getattr(self._driver, "trace", None) or {}
        if not isinstance(trace, Mapping):
            raise AdsFault(f"ADS {self._name}: trace is {what(trace)}, expected names with numbers")
        plain = True
        for name, value in trace.items():
            if type(name) is not str or (type(value) is not float and not _is_number(value)):
                raise AdsFault(f"ADS {self._name}: trace has {name!r}: {what(value)}, expected names with numbers")
            plain = plain and type(value) is float
        return trace if plain else {name: float(value) for name, value in trace.items()}

    def _detected(self) -> Sequence[Detection]:
        found = getattr(self._driver, "detections", None)
        if found is None:
            return ()
        if not isinstance(found, Sequence) or not all(isinstance(each, self._detection) for each in found):
            expected = "vehicle.messages.Detection in a list"
            raise AdsFault(f"ADS {self._name}: detections is {what(found)}, expected {expected}")
        for each in found:
            for name in _NUMBERS:
                value = getattr(each, name)
                if type(value) is not float and not _is_number(value):
                    raise AdsFault(f"ADS {self._name}: a detection has {name} = {what(value)}, expected a number")
            if type(each.kind) is not str:
                raise AdsFault(f"ADS {self._name}: a detection has kind = {what(each.kind)}, expected a word")
        return tuple(found)  # the stack may fill the same list anew in its next tick

    def _planned(self) -> FloatArray | None:
        path = getattr(self._driver, "path", None)
        if path is self._given:
            return self.path
        import numpy as np

        self._given = path
        if path is None:
            return None
        try:
            array = np.asarray(path, dtype=np.float64)
        except (TypeError, ValueError):
            raise AdsFault(f"ADS {self._name}: path is {what(path)}, expected an array (n, 2): x, y [m]") from None
        if array.ndim != 2 or array.shape[1] != 2:
            raise AdsFault(f"ADS {self._name}: path has the shape {array.shape}, expected (n, 2): x, y [m]")
        return array


def _with(fields: Mapping[str, object]) -> str:
    """What is wrong with a Command, field by field: `tick returned a Command with brake = None`."""
    return "tick returned a Command with " + ", ".join(f"{name} = {what(value)}" for name, value in fields.items())


def _is_number(value: Any) -> bool:
    try:
        float(value)
    except (TypeError, ValueError, OverflowError):
        return False
    return not isinstance(value, str | bytes)
