"""The process of one driving stack:  python stack_child.py SOCKET TRACES, started by `pytest_dvp.drive.stack_process`.

It loads the stack once, makes it anew for each run, and answers ticks. What the stack prints goes to the harness by
standard output and error, never on the socket. Where it hangs is asked by a signal and written to the file TRACES, even
while C code holds Python's lock.
"""

from __future__ import annotations

import contextlib
import faulthandler
import json
import math
import os
import signal
import socket
import struct
import sys
from typing import Any, NoReturn

HEAD = struct.Struct("<cI")
KILLED_FIRST = "500"  # of -1000 to 1000: short of memory, the system ends this process and not the harness


class Line:
    """The socket: frames in and out."""

    def __init__(self, number: int) -> None:
        os.set_inheritable(number, False)  # a program that the stack starts must not keep it open
        self._socket = socket.socket(fileno=number)
        self._came = bytearray()

    def take(self) -> tuple[bytes, bytes]:
        """The next frame: what it is, and its body. Ends this process when the harness is gone."""
        came = self._came
        while True:
            if len(came) >= HEAD.size:
                what, length = HEAD.unpack_from(came)
                end = HEAD.size + length
                if len(came) >= end:
                    body = bytes(memoryview(came)[HEAD.size : end])
                    del came[:end]
                    return what, body
            try:
                part = self._socket.recv(1 << 18)
            except OSError:
                part = b""
            if not part:
                _leave()
            came += part

    def say(self, what: bytes, body: bytes = b"") -> None:
        """Send a frame."""
        try:
            self._socket.sendall(HEAD.pack(what, len(body)) + body)
        except OSError:
            _leave()


class Served:
    """What this process holds: the stack that it loaded, and the one that it made for this run."""

    def __init__(self, line: Line) -> None:
        self._line = line
        self._ads: Any = None
        self._driver: Any = None
        self._sent: Any = None  # the path that was sent last
        self._variables = set(os.environb)

    def serve(self) -> NoReturn:
        """Answer until the harness is gone."""
        from pytest_dvp.drive import checked_stack, stack_host, stack_parameters  # noqa: F401  (loaded before any deadline)
        from pytest_dvp.drive import stack_wire as wire
        from pytest_dvp.drive.compile_time import COMPILING
        from pytest_dvp.drive.stack_faults import AdsError, AdsFault, StackRaised, raised

        self._line.say(wire.ANSWER)  # to the first frame: ready
        COMPILING.tell = lambda begins: self._line.say(wire.COMPILES if begins else wire.COMPILED)
        answer = {wire.LOAD: self._load, wire.MAKE: self._make, wire.TICK: self._tick, wire.CLOSE: self._close}
        while True:
            what, body = self._line.take()
            COMPILING.attach()
            try:
                reply, failed = answer[what](body), None
            except AdsFault as error:
                failed = wire.Failed("fault", str(error))
            except StackRaised as error:
                failed = wire.Failed("raised", error.said, error.kind, error.trace)
            except BaseException as error:
                if isinstance(error, AdsError) or type(error).__name__ in ("SettingError", "ScenarioError"):
                    failed = wire.Failed("load", str(error))
                else:
                    own = raised(error)
                    failed = wire.Failed("raised", own.said, own.kind, own.trace)
            with contextlib.suppress(Exception):  # the stack may have closed or replaced them
                sys.stdout.flush()
                sys.stderr.flush()
            if failed is None:
                self._line.say(wire.ANSWER, reply)
            else:
                self._line.say(wire.ERROR, wire.encode(failed))

    def _load(self, body: bytes) -> bytes:
        from pathlib import Path

        from pytest_dvp.drive import stack_wire as wire
        from pytest_dvp.drive.stack_host import find_ads
        from pytest_dvp.drive.stack_parameters import declared
        from pytest_dvp.drive.stack_sensors import read_by

        told = wire.decode(body, wire.Load)
        os.chdir(told.here)
        self._ads = find_ads(told.text, [Path(folder) for folder in told.folders], process="off", tick_limit=math.inf)
        reads = read_by(self._ads)
        return wire.encode(wire.Loaded(declared(self._ads), None if reads is None else sorted(reads), _files()))

    def _make(self, body: bytes) -> bytes:
        from pytest_dvp.drive import stack_wire as wire
        from pytest_dvp.drive.compile_time import COMPILING
        from pytest_dvp.drive.stack_host import make_driver, wants

        told = wire.decode(body, wire.Make)
        os.chdir(told.here)
        self._take_over(told.environment)
        self._driver = self._sent = None
        parameters: Any = told.parameters
        network = None
        if wants(self._ads):
            with COMPILING.apart():
                network = _network(*told.road)
                if not told.own:
                    from ads.parameters import Parameters

                    parameters = Parameters().with_values(told.parameters)
        self._driver = make_driver(self._ads, parameters, network, told.description)
        return wire.encode(wire.Made(self._driver.nets))

    def _tick(self, body: bytes) -> bytes:
        from pytest_dvp.drive import stack_wire as wire
        from vehicle.messages import Detection

        driver = self._driver
        command = driver.tick(wire.observation_of(body))
        path, points = wire.NO_PATH, b""
        if driver.path is not None:
            path = wire.LAST_PATH
            if driver.path is not self._sent:
                self._sent, path, points = driver.path, wire.NEW_PATH, driver.path.tobytes()
        detections = [[getattr(found, name) for name in Detection.__struct_fields__] for found in driver.detections]
        asked = (command.t, command.steer, command.accel, command.throttle, command.brake)
        return wire.encode(wire.Ticked(asked, dict(driver.trace), detections, path, points, driver.seconds))

    def _close(self, body: bytes) -> bytes:
        driver, self._driver, self._sent = self._driver, None, None
        if driver is not None:
            driver.close()
        return b""

    def _take_over(self, environment: dict[bytes, bytes]) -> None:
        for name in self._variables - set(environment):
            os.environb.pop(name, None)
        os.environb.update(environment)
        self._variables = set(environment)


_NETWORKS: dict[tuple[str, str], Any] = {}


def _network(path: str, digest: str) -> Any:
    """The map that the harness drives on. Raises AdsError if the file has changed since it was read there."""
    import hashlib
    from pathlib import Path

    from openscenario.road.network import load_network
    from pytest_dvp.drive.compile_time import COMPILING
    from pytest_dvp.drive.stack_faults import AdsError

    if (path, digest) not in _NETWORKS:
        if hashlib.sha256(Path(path).read_bytes()).hexdigest() != digest:
            raise AdsError(f"{path}: changed while the run was made ready")
        _NETWORKS.clear()
        _NETWORKS[path, digest] = load_network(path)
        COMPILING.attach()
    return _NETWORKS[path, digest]


def _files() -> list[tuple[str, int, int]]:
    """Source files of modules that are not of Python or of an installed package: those that may be edited."""
    places = {sys.prefix, sys.base_prefix}
    installed = tuple(place + os.sep for place in places | {os.path.realpath(place) for place in places})
    found = []
    for module in list(sys.modules.values()):
        file = getattr(module, "__file__", None)
        if not isinstance(file, str) or file.startswith(installed):
            continue
        try:
            status = os.stat(file)
        except OSError:
            continue
        found.append((file, status.st_mtime_ns, status.st_size))
    return sorted(set(found))


def _leave() -> NoReturn:
    """The harness is gone, or wants no more: what the stack has registered for its end is done."""
    sys.exit(0)


def main(arguments: list[str]) -> NoReturn:
    """Serve a stack until the harness ends the line.

    arguments  file descriptors, as text, of the line to the harness and of the file for tracebacks
    """
    traces = open(int(arguments[1]), "w", closefd=False)  # noqa: SIM115  (open as long as the process)
    os.set_inheritable(int(arguments[1]), False)
    faulthandler.enable(traces)
    if hasattr(faulthandler, "register"):
        faulthandler.register(signal.SIGUSR1, traces, all_threads=True)
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w") as score:
        score.write(KILLED_FIRST)
    line = Line(int(arguments[0]))
    _, places = line.take()
    sys.path[:] = json.loads(places)
    sys.argv[:] = [sys.argv[0]]  # a stack that reads it finds nothing for it
    Served(line).serve()


if __name__ == "__main__":
    main(sys.argv[1:])
