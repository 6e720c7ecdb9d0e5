"""A driving stack that is given by name, in a process of its own: whatever it does, the harness goes on.

The process is started once, loads the stack, and makes it anew for each run of this session, so that a search does not
pay for its start each time. It is replaced when a file that it has loaded changes, and after a hang or a crash. What
the stack prints comes through here to `sys.stdout` and `sys.stderr`, so that pytest captures it as if it were printed
here.
"""

from __future__ import annotations

import atexit
import codecs
import contextlib
import hashlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NoReturn

import numpy as np

from pytest_dvp.drive import stack_wire as wire
from pytest_dvp.drive.deadline import TICK_LIMIT, Deadline, limit_of, overdue
from pytest_dvp.drive.stack_faults import AdsError, AdsFault, StackDied, StackHung, StackRaised, place_of
from pytest_dvp.drive.stack_trace import crashed, hanging
from vehicle.child_process import Child, is_stopped
from vehicle.messages import Command, Detection, VehicleDescription

if TYPE_CHECKING:
    from openscenario.road.network import RoadNetwork
    from pytest_dvp.drive.stack_parameters import Own
    from vehicle.messages import FloatArray, Observation

PROGRAM = Path(__file__).with_name("stack_child.py")
START = 60.0  # s until Python and what this package needs are loaded there; a machine under load takes seconds
LOOK = 0.5  # s between two looks at whether the process is still there
TRACED = 1.0  # s that it has to write where it hangs; it takes a millisecond
FAREWELL = 1.0  # s that it has to end by itself
MOST_IDLE = 2  # processes kept for the next run
LAST_WORDS = 2000  # characters of standard error kept for the message after a crash


class StackProcess:
    """The process of the stack that `text` names, loaded. Raises AdsError, one line, if it cannot be loaded.

    name    of the stack, for messages
    limit   [s] of wall time that a tick has, and its multiple for loading
    """

    def __init__(self, name: str, text: str, folders: Sequence[Path], limit: float) -> None:
        self.name, self.key = name, key_of(text, folders)
        self.dead = False
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        here.setblocking(False)
        self._socket = here
        self._traces: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115  (lives as long as the process)
        ends = [os.pipe(), os.pipe()]
        try:
            command = [sys.executable, "-P", "-u", str(PROGRAM), str(there.fileno()), str(self._traces.fileno())]
            self._child = Child(
                command,
                f"ADS {name}",
                AdsError,
                keep_open=[there.fileno(), self._traces.fileno()],
                streams=(ends[0][1], ends[1][1]),
            )
        except BaseException:
            here.close()
            self._traces.close()
            os.close(ends[0][0])
            os.close(ends[1][0])
            raise
        finally:
            there.close()
            os.close(ends[0][1])
            os.close(ends[1][1])
        self._streams = {fd: _Stream(fd, out) for (fd, _), out in zip(ends, ("stdout", "stderr"), strict=True)}
        self._poll = select.poll()
        for descriptor in (self._socket.fileno(), *self._streams):  # the socket first: see _drain
            self._poll.register(descriptor, select.POLLIN)
        self._came, self._out = bytearray(), bytearray()
        try:
            places = json.dumps([str(place) for place in sys.path]).encode()
            self.ask(wire.BEGIN, places, "start", Deadline(name, START))
            told = wire.Load(text, [str(folder) for folder in folders], str(Path.cwd()))
            self.loaded: wire.Loaded = wire.decode(
                self.ask(wire.LOAD, told, "import", Deadline(name, limit), first=True), wire.Loaded
            )
        except (StackHung, StackDied) as error:
            self.end()
            said = str(error).removeprefix(f"ADS {name}: ")
            raise AdsError(f"ads: {text} cannot be loaded: {said}{place_of(error.trace)}") from None
        except BaseException:
            self.end()
            raise

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._child.process.pid

    def fits(self, key: object) -> bool:
        """Whether it can serve the next run: it lives, is of that stack, and no file that it loaded has changed."""
        return self.key == key and not self.dead and not self._child.how_it_ended() and all(
            _unchanged(*file) for file in self.loaded.files
        )  # fmt: skip

    def ask(self, what: bytes, message: Any, call: str, watch: Deadline, *, first: bool = False) -> bytes:
        """The answer of the process. `call`: what it does for it, as "tick".

        Raises StackHung, after which the process is ended, if it does not come in the time that `watch` gives;
        StackDied, AdsFault, StackRaised, AdsError.
        """
        limit = limit_of(watch.limit, first=first)
        until = time.monotonic() + limit
        compiled, since = 0.0, None
        try:
            wire.fill(self._out, what, message)
            with memoryview(self._out) as data:
                self._send(data, min(until, watch.wall))
            while True:
                frame = self._frame()
                if frame is None:
                    now = time.monotonic()
                    spent = compiled + (now - since if since is not None else 0.0)
                    left = min(until + spent, watch.wall) - now
                    if left <= 0.0:
                        self._hung(call, limit, watch.wall_limit if watch.wall <= until + spent else None)
                    self._receive(min(left, LOOK), call)
                    continue
                kind, answer = frame
                if kind == wire.ANSWER:
                    return answer
                if kind == wire.ERROR:
                    raise _failure(wire.decode(answer, wire.Failed))
                if kind == wire.COMPILES:
                    since = time.monotonic()
                elif since is not None:
                    compiled, since = compiled + time.monotonic() - since, None
        except (AdsError, AdsFault, StackRaised) as error:
            if isinstance(error, StackHung | StackDied):
                self.end()
            raise
        except BaseException:  # an interrupt: nobody knows what it does now
            self.end()
            raise

    def end(self) -> None:
        """End the process. May be called again."""
        if self.dead:
            return
        self.dead = True
        self._socket.close()
        for stream in self._streams.values():
            stream.close()
        self._child.end()
        self._traces.close()

    def leave(self) -> None:
        """Let the process end by itself, with what the stack has registered for that."""
        if not self.dead:
            with contextlib.suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._child.process.wait(FAREWELL)
            self._drain()
            self.end()

    def new_run(self) -> None:
        """What it said before is none of the last words of this run."""
        for stream in self._streams.values():
            stream.tail = ""

    def _send(self, left: memoryview, until: float) -> None:
        while left:
            try:
                left = left[self._socket.send(left) :]
            except BlockingIOError:  # the process does not read: it hangs, or is slow
                if time.monotonic() > until:
                    return  # who waits for the answer says so
                self._drain()
                select.select([], [self._socket], [], 0.02)
            except OSError:
                return  # it has ended: who waits for the answer hears of it

    def _frame(self) -> tuple[bytes, bytes] | None:
        came, head = self._came, wire.HEAD.size
        if len(came) < head:
            return None
        what, length = wire.HEAD.unpack_from(came)
        if len(came) < head + length:
            return None
        body = bytes(came[head : head + length])
        del came[: head + length]
        return what, body

    def _receive(self, wait: float, call: str) -> None:
        """Wait for more, and pass on what is printed meanwhile."""
        events = self._poll.poll(1000.0 * wait)
        if not events and (how := self._child.how_it_ended()):
            self._died(how, call)
        # What was printed before an answer stands before it, whoever prints next.
        for descriptor, _ in events:
            if descriptor in self._streams and not self._streams[descriptor].take():
                self._poll.unregister(descriptor)
        if any(descriptor == self._socket.fileno() for descriptor, _ in events):
            try:
                part = self._socket.recv(1 << 20)
            except BlockingIOError:
                return
            except OSError:
                part = b""
            if not part:
                self._died("", call)
            self._came += part

    def _drain(self) -> None:
        """Pass on what has been printed. The socket was looked at first, so nothing printed before an answer is left
        behind it."""
        for stream in self._streams.values():
            while select.select([stream.descriptor], [], [], 0)[0] and stream.take():
                pass

    def _hung(self, call: str, limit: float, wall_limit: float | None) -> NoReturn:
        line = overdue(self.name, call, limit, wall_limit)
        if is_stopped(self.pid):
            raise StackHung(f"{line}: its process is stopped (SIGSTOP)", line, wall=wall_limit is not None)
        begin = os.fstat(self._traces.fileno()).st_size
        text = ""
        self._child.process.send_signal(signal.SIGUSR1)
        patience = time.monotonic() + TRACED
        while time.monotonic() < patience:
            time.sleep(0.01)
            said = os.pread(self._traces.fileno(), 1 << 20, begin).decode(errors="replace")
            if said and said == text:
                break
            text = said
        self._drain()
        raise StackHung(line, hanging(text, line), wall=wall_limit is not None)

    def _died(self, how: str, call: str) -> NoReturn:
        if not how:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._child.process.wait(TRACED)
            how = self._child.how_it_ended() or "it closed its socket"
        self._drain()
        more = ", as the system does when memory runs out" if how.endswith("SIGKILL") else ""
        tail = self._streams_tail()
        line = f"ADS {self.name}: its process ended in {call} ({how}{more})" + (f": {tail}" if tail else "")
        text = os.pread(self._traces.fileno(), 1 << 20, 0).decode(errors="replace")
        raise StackDied(line, crashed(text, line))

    def _streams_tail(self) -> str:
        lines = [stream.tail.strip().splitlines() for stream in self._streams.values() if stream.name == "stderr"]
        return lines[0][-1][:200] if lines and lines[0] else ""


class _Stream:
    """Standard output or error of the process, passed on to this one's."""

    def __init__(self, descriptor: int, name: str) -> None:
        self.descriptor, self.name, self.tail = descriptor, name, ""
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")

    def take(self) -> bool:
        """Pass on what is there; False at its end."""
        data = os.read(self.descriptor, 1 << 16)
        text = self._decoder.decode(data, final=not data)
        self.tail = (self.tail + text)[-LAST_WORDS:]
        if text:
            getattr(sys, self.name).write(text)
        return bool(data)

    def close(self) -> None:
        os.close(self.descriptor)


class NamedStack:
    """The stack that `text` names; its process is started and has loaded it. Makes drivers.

    parameters  that it declares, with their defaults, or None
    reads       the sensors that it declares to read, or None
    """

    def __init__(self, name: str, text: str, folders: Sequence[Path], limit: float = TICK_LIMIT) -> None:
        self.name, self._text, self._folders, self._limit = name, text, tuple(folders), limit
        process = self._borrowed()
        self.parameters: Own | None = process.loaded.parameters
        self.reads: list[str] | None = process.loaded.reads
        give_back(process)

    def __call__(self, parameters: Any, network: RoadNetwork, description: VehicleDescription) -> ProcessDriver:
        return self.drive(parameters, network, description, Deadline(self.name, self._limit))

    def drive(
        self, parameters: Any, network: RoadNetwork, description: VehicleDescription, watch: Deadline
    ) -> ProcessDriver:
        """The stack made for a run. Raises AdsError if it cannot be made."""
        from pytest_dvp.drive.stack_parameters import as_plain

        road = Path(network.file.path).absolute()
        told = wire.Make(
            as_plain(parameters),
            isinstance(parameters, Mapping),
            (str(road), hashlib.sha256(road.read_bytes()).hexdigest()),
            description,
            str(Path.cwd()),
            dict(os.environb),
        )
        process = self._borrowed()
        process.new_run()
        try:
            made = wire.decode(process.ask(wire.MAKE, told, "__init__", watch, first=True), wire.Made)
        except (StackHung, StackDied) as error:
            said = str(error).removeprefix(f"ADS {self.name}: ")
            raise AdsError(f"ADS {self.name}: cannot be made: {said}{place_of(error.trace)}") from None
        except BaseException:
            give_back(process)
            raise
        return ProcessDriver(process, watch, made.nets)

    def _borrowed(self) -> StackProcess:
        return borrow(self._text, self._folders) or StackProcess(self.name, self._text, self._folders, self._limit)


class ProcessDriver:
    """A stack in its process, as `pytest_dvp.drive.checked_stack.OnlyTick` is one in this."""

    def __init__(self, process: StackProcess, watch: Deadline, nets: list[Any]) -> None:
        self._process, self._watch, self.nets = process, watch, nets
        self._first = True
        self._last_path: FloatArray | None = None
        self.trace: Mapping[str, float] = {}
        self.detections: Sequence[Detection] = ()
        self.path: FloatArray | None = None
        self.seconds = 0.0

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid

    def end_by(self, wall: float, limit: float) -> None:
        """The whole run must be over at `wall` (`time.monotonic`), after its `limit` [s]."""
        self._watch.wall, self._watch.wall_limit = wall, limit

    def tick(self, observation: Observation) -> Command:
        """The stack's command for an observation. Raises as OnlyTick, and StackDied."""
        first, self._first = self._first, False
        body = self._process.ask(wire.TICK, observation, "tick", self._watch, first=first)
        told = wire.ticked_of(body)
        self.trace, self.seconds = told.trace, told.seconds
        self.detections = tuple(Detection(*fields) for fields in told.detections)
        if told.path == wire.NEW_PATH:
            self._last_path = np.frombuffer(told.points, dtype=np.float64).reshape(-1, 2)
        self.path = None if told.path == wire.NO_PATH else self._last_path
        return Command(*told.command)

    def close(self) -> None:
        """The run is over: the stack frees what it holds, the process serves the next one."""
        process = self._process
        if process.dead:
            return
        self._watch.wall = float("inf")
        try:
            process.ask(wire.CLOSE, None, "close", self._watch, first=True)
        except (StackHung, StackDied) as error:  # what it drove is driven, and is kept
            print(error, file=sys.stderr)
        give_back(process)


_IDLE: list[StackProcess] = []
_OWNER = [0]  # whose they are: a process that was forked from this one has copies, and no part in them


def key_of(text: str, folders: Sequence[Path]) -> object:
    """All that decides what a name loads."""
    return text, tuple(map(str, folders)), str(Path.cwd()), tuple(sys.path)


def borrow(text: str, folders: Sequence[Path]) -> StackProcess | None:
    """A process that has loaded the stack and is free, if there is one."""
    if _OWNER[0] != os.getpid():
        _IDLE.clear()
    key = key_of(text, folders)
    for process in list(_IDLE):
        if process.key == key:
            _IDLE.remove(process)
            if process.fits(key):
                return process
            process.leave()
    return None


def give_back(process: StackProcess) -> None:
    """The process is free for the next run."""
    if process.dead:
        return
    if _OWNER[0] != os.getpid():
        _OWNER[0] = os.getpid()
        _IDLE.clear()
    _IDLE.append(process)
    while len(_IDLE) > MOST_IDLE:
        _IDLE.pop(0).leave()


@atexit.register
def _end_all() -> None:
    if _OWNER[0] == os.getpid():
        while _IDLE:
            _IDLE.pop().leave()


def _failure(failed: wire.Failed) -> Exception:
    if failed.kind == "raised":
        return StackRaised(failed.name, failed.said, failed.trace)
    return AdsError(failed.said) if failed.kind == "load" else AdsFault(failed.said)


def _unchanged(file: str, changed: int, size: int) -> bool:
    try:
        status = os.stat(file)
    except OSError:
        return False
    return (status.st_mtime_ns, status.st_size) == (changed, size)
