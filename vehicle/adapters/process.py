"""A car that is a process of this machine: started for a run, heard of when it dies, gone when the run is over."""

from __future__ import annotations

import socket
import subprocess
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from vehicle.adapter import Hands, VehicleLost
from vehicle.adapters.can_bus import CanActuators
from vehicle.adapters.ros2 import STEP_TIMEOUT, Ros2Vehicle
from vehicle.child_process import Child, own_module, own_path
from vehicle.liveness import Pulse
from vehicle.wire.can_map import SignalMap
from vehicle.wire.dds import on_domain
from vehicle.wire.end import End, Opener
from vehicle.wire.faults import Fault, FaultyEnd
from vehicle.wire.health import Trouble

GROUP, FIRST_PORT = "239.74.163.2", 43113  # of CAN frames between processes; a port for each domain
LEASED_PORT = 43_300  # and up: whoever has it has the domain
TRUTH_WRITTEN = 20.0  # s to write what was true at its end; chosen: a minute of driving takes a tenth of one
DOMAINS = range(100, 0, -1)  # of DDS: up to 101 on Linux, says ROS 2; low ones are those that people type


class Lease:
    """A DDS domain number that no other run on this machine has, until it is released or this process ends.

    Held by a port of the loopback interface, which all who could meet on it share, whatever their folders.
    """

    def __init__(self) -> None:
        for number in DOMAINS:
            held = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
            try:
                held.bind(("127.0.0.1", LEASED_PORT + number))
            except OSError:
                held.close()
                continue
            self.domain, self._held = number, held
            return
        raise VehicleLost(f"all {len(DOMAINS)} DDS domains of this machine are in use")

    def release(self) -> None:
        """Give the number back."""
        self._held.close()


def by_dds(number: int) -> tuple[list[str], Opener]:
    """What a car process is told to be on DDS domain `number`, and the way there."""
    return ["--dds", str(number)], on_domain(number)


class CarProcess(Ros2Vehicle):
    """The car that `python -m MODULE --dds DOMAIN ARGUMENTS` is; `timeout` [s] wall time for a step.

    wire      where it is, by a number that no other run has; as `by_dds`
    can       the messages of its drive-by-wire, if it has one: it is told `--can BUS --dbc FILE` too
    record    gets every trouble with its messages
    fault     what is to go wrong on the wire, by chance of `seed` where by chance
    end       opens the end of the wire where nothing is to go wrong
    farewell  [s] that its process has to leave the wire before it is killed

    It leads a process group of its own, is killed with it, and ends by itself when this process does: its standard
    input is a pipe from here. One that hangs is lost as soon as `vehicle.liveness` tells, at the latest after
    `timeout`.
    Raises VehicleLost if it does not come.
    """

    def __init__(
        self,
        module: str,
        arguments: Sequence[str] = (),
        *,
        wire: Callable[[int], tuple[list[str], Opener]] = by_dds,
        timeout: float = STEP_TIMEOUT,
        can: SignalMap | None = None,
        record: Callable[[Trouble], None] = lambda _: None,
        fault: Fault | None = None,
        seed: int = 0,
        end: Callable[..., End] = End,
        farewell: float = 0.0,
    ) -> None:
        self._farewell = farewell
        self._lease = Lease()
        where, opener = wire(self._lease.domain)
        command = [*own_module(module), *where, *arguments]
        if can is not None:
            bus = f"udp_multicast:{GROUP}:{FIRST_PORT + self._lease.domain}"
            command += ["--can", bus, "--dbc", str(can.file)]
        self._child = Child(command, "the car", VehicleLost, own_path())
        self._pulse = Pulse(self._child.process.pid)
        self._serves = False
        self.by_wire: CanActuators | None = None
        try:
            if can is not None:
                self.by_wire = CanActuators(bus, can, self._alive, timeout=timeout)
            opened = end if fault is None else partial(FaultyEnd, fault, seed, self.process.send_signal)
            super().__init__(opener, self._alive, timeout=timeout, by_wire=self.by_wire, record=record, end=opened)
            self._serves = True
        except BaseException:
            self._end_process()
            raise

    @property
    def process(self) -> subprocess.Popen[bytes]:
        """The process that the car is."""
        return self._child.process

    def close(self) -> None:
        """End the process, and leave the domain."""
        super().close()
        self._end_process()

    def _alive(self) -> None:
        self._child.check()
        why = self._pulse.look(self._number) if self._serves and self.stepped else ""  # before, it loads what it needs
        if why:
            raise VehicleLost(f"the car's process {why}")

    def _end_process(self) -> None:
        self._child.end(after=self._farewell)
        self._lease.release()


class DriveByWireProcess(CarProcess):
    """A car process with a drive-by-wire, which tells of its driver's hands."""

    @property
    def hands(self) -> Hands:
        """As last reported."""
        return Hands(False, False) if self.by_wire is None else self.by_wire.hands


def told_of(hidden: Path | None, truth: Path | None, options: dict[str, Any]) -> list[str]:
    """What the surrogate is told besides its seed; one that is to write what was true gets the time for it."""
    if truth is not None:
        options["farewell"] = max(options.get("farewell", 0.0), TRUTH_WRITTEN)
    named = {"--hidden": hidden, "--truth": truth}
    return [word for name, file in named.items() if file is not None for word in (name, str(file))]


def surrogate(
    seed: int = 0,
    hidden: Path | None = None,
    *,
    can: SignalMap | None = None,
    truth: Path | None = None,
    **options: Any,
) -> CarProcess:
    """The surrogate car in a process of its own; `hidden` what is hidden in it, `seed` of its sensors' noise, `can` the
    messages of the drive-by-wire that it is to have, `truth` the file (.mcap) into which it writes what was true when
    it ends, options as of CarProcess."""
    extra = told_of(hidden, truth, options)
    kind = CarProcess if can is None else DriveByWireProcess
    return kind("vehicle.surrogate", ["--seed", str(seed), *extra], can=can, seed=seed, **options)
