"""A bridge: a module that lives under another interpreter (rospy, carla), used from here through a process of its own.

    bridge = Bridge("/usr/bin/python3", who="ROS 1's bridge", error=VehicleLost)
    carla = bridge.module("carla")            # stands in for the module: attributes, calls, lists, exceptions
    client = carla.Client("127.0.0.1", 2000)

The far end is `interpreter_server.py`, which says how they talk. It beats every 20 ms: one that dies is known at once,
one that hangs after SILENT. It does not outlive this process.
"""

from __future__ import annotations

import contextlib
import json
import select
import socket
import struct
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from vehicle.child_process import Child

SERVER = Path(__file__).with_name("interpreter_server.py")
LENGTHS = struct.Struct("<II")
POLL = 0.02  # s, between two looks at the process
SILENT = 2.0  # s of listening without a beat; a machine with ten times too much to do has kept them for 0.2 s
FAREWELL = 5.0  # s of wall time that it has to leave what it is in
START, ANSWER = 30.0, 20.0  # s of wall time until it runs, and for an answer
RAISED = {kind.__name__: kind for kind in (RuntimeError, IndexError, KeyError, ValueError, AttributeError, TypeError)}


class Frame(NamedTuple):
    """What came: a head, and the bytes with it."""

    head: dict[str, Any]
    body: bytes


class Bridge:
    """The process under interpreter `python`, which looks in folders `path` too.

    who     it is, in what is said of it
    error   the kind of error that says that it is gone, hangs or cannot do what is asked
    server  what it runs: `interpreter_server.py`, or a program that speaks as it does
    silent  [s] of listening without a beat after which it hangs

    Raises `error` if it does not come.
    """

    def __init__(
        self,
        python: str = sys.executable,
        path: Sequence[str] = (),
        *,
        who: str,
        error: Callable[[str], Exception],
        environment: Mapping[str, str] | None = None,
        server: Sequence[str] = (str(SERVER),),
        silent: float = SILENT,
    ) -> None:
        self._silent = silent
        self._python, self._who, self._error = python, who, error
        self._number, self._quiet = 0, 0.0
        self._came: deque[Frame] = deque()
        self._buffer = bytearray()
        self._dropped: list[int] = []
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket = here
        command = [python, *server, str(there.fileno()), *path]
        try:
            self._child = Child(command, who, error, environment, [there.fileno()])
        except BaseException:
            here.close()
            raise
        finally:
            there.close()
        self._patience = START  # until its first beat
        try:
            self._first_beat()
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._child.process.pid

    def module(self, name: str) -> Any:
        """What stands in for a module there. Raises `error`, one line, if the interpreter does not have it."""
        return self._stand_in(self.ask("import", module=name))

    def ask(self, what: str, *, answer: float = ANSWER, **more: Any) -> Any:
        """The answer to a question, for which it has `answer` [s]. Raises what was raised there, if it is of a kind
        known here, or `error`."""
        if self._dropped:
            gone, self._dropped = self._dropped, []
            self.ask("drop", of=gone)
        self._number += 1
        self.send({"n": self._number, "do": what, **more})
        deadline, others = time.monotonic() + answer, []
        try:
            while True:
                for frame in self.receive(POLL):
                    if frame.head.get("n") != self._number:
                        others.append(frame)
                    elif "error" in frame.head:
                        raise self._raised(frame.head["error"], frame.head["text"])
                    else:
                        return frame.head["value"]
                if time.monotonic() > deadline:
                    raise self._error(f"{self._who} did not answer within {answer:g} s")
        finally:
            self._came.extendleft(reversed(others))

    def send(self, head: Mapping[str, Any], body: bytes = b"") -> None:
        """Send a frame."""
        text = json.dumps(head).encode()
        try:
            self._socket.sendall(LENGTHS.pack(len(text), len(body)) + text + body)
        except OSError:
            self._gone()

    def receive(self, wait: float) -> list[Frame]:
        """What has come since the last call, beats aside; if that is nothing, what comes within `wait` [s].

        Raises `error` if the process is gone, stopped, or has not beaten for SILENT while this was listening.
        """
        deadline = time.monotonic() + wait
        while True:
            left = max(0.0, deadline - time.monotonic())
            self._take(min(left, POLL))
            if self._came or left <= 0.0:
                came = list(self._came)
                self._came.clear()
                return came

    def close(self) -> None:
        """End the process; it has a moment to leave what it is in."""
        self._socket.close()
        self._child.end(after=FAREWELL)

    def _first_beat(self) -> None:
        deadline = time.monotonic() + START
        while self._patience == START:
            self._take(POLL)
            if time.monotonic() > deadline:
                raise self._error(f"{self._who} did not start within {START:g} s")

    def _take(self, wait: float) -> None:
        """Read what is there into `_came`; wait for it if there is nothing."""
        began = time.monotonic()
        if not select.select([self._socket], [], [], wait)[0]:
            self._quiet += time.monotonic() - began
            self._child.check()
            if self._quiet > self._patience:
                raise self._error(f"{self._who} hangs: no beat for {self._quiet:.2f} s")
            return
        try:
            part = self._socket.recv(1 << 20)
        except OSError:
            part = b""
        if not part:
            self._gone()
        self._quiet, self._patience = 0.0, self._silent
        self._buffer += part
        while len(self._buffer) >= LENGTHS.size:
            text, body = LENGTHS.unpack_from(self._buffer)
            end = LENGTHS.size + text + body
            if len(self._buffer) < end:
                break
            head = json.loads(self._buffer[LENGTHS.size : LENGTHS.size + text])
            if "beat" not in head:
                self._came.append(Frame(head, bytes(self._buffer[LENGTHS.size + text : end])))
            del self._buffer[:end]

    def _gone(self) -> NoReturn:
        """Raises `error`: the socket has closed, and soon the process has ended."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._child.process.wait(1.0)
        self._child.check()
        raise self._error(f"{self._who} has closed its socket")

    def _raised(self, kind: str, text: str) -> Exception:
        if kind in RAISED:
            return RAISED[kind](text)
        if kind in ("ImportError", "ModuleNotFoundError"):
            return self._error(f"{self._who}: {self._python} lacks a module: {text}")
        return self._error(f"{self._who}: {text or kind}")

    def _stand_in(self, value: Any) -> Any:
        if isinstance(value, list):
            return [self._stand_in(item) for item in value]
        return StandIn(self, value["$"]) if isinstance(value, dict) else value

    def _asked(self, what: str, of: int, **more: Any) -> Any:
        return self._stand_in(self.ask(what, of=of, **more))

    def _drop(self, number: int) -> None:
        self._dropped.append(number)


class StandIn:
    """Stands in for an object of the far end."""

    def __init__(self, bridge: Bridge, number: int) -> None:
        object.__setattr__(self, "_bridge", bridge)
        object.__setattr__(self, "_number", number)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self._bridge._asked("get", self._number, name=name)

    def __setattr__(self, name: str, value: Any) -> None:
        self._bridge.ask("set", of=self._number, name=name, to=_packed(value))

    def __call__(self, *given: Any, **named: Any) -> Any:
        packed = {name: _packed(value) for name, value in named.items()}
        return self._bridge._asked("call", self._number, given=_packed(given), named=packed)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._bridge._asked("list", self._number))

    def __getitem__(self, at: int) -> Any:
        return list(self)[at]

    def __del__(self) -> None:
        self._bridge._drop(self._number)


def _packed(value: Any) -> Any:
    if isinstance(value, StandIn):
        return {"$": value._number}
    if isinstance(value, list | tuple):
        return [_packed(item) for item in value]
    return value
