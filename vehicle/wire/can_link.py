"""One end of a CAN bus, and lock-step with the other end in simulation.

CAN keeps the order of all frames, so a step needs no count of each kind: STEP and DONE say its number and how many
frames their sender has put on the bus, which shows a bus that loses frames, and TIME when what follows happened. These
three are of this program, on extended identifiers that no drive-by-wire uses, and never go to a real car.

Buses: "virtual:NAME" within a process, "udp_multicast:239.74.163.2:PORT" between processes of a machine (it never
leaves it), "socketcan:can0" and whatever else python-can knows.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from typing import Any, NamedTuple

from vehicle.wire.can_codec import Frame

STEP, DONE, TIME = 0x1DB50000, 0x1DB50001, 0x1DB50002
POLL = 0.02  # s, between two looks at whether the other end is still there
NUMBER = struct.Struct("<II")
NANOSECONDS = struct.Struct("<q")


class BusError(ValueError):
    """A bus that cannot be opened, or that lost frames; one line."""


class Silence(Exception):
    """The other end did not say in time what was waited for."""


class Stamped(NamedTuple):
    """A frame, and when it was sent [ns]: simulated time, or that of the bus."""

    ns: int
    frame: Frame


def open_bus(address: str) -> Any:
    """The python-can bus "INTERFACE:CHANNEL", for udp_multicast "...:GROUP:PORT". Raises BusError."""
    try:
        import can
    except ImportError:
        raise BusError("CAN needs python-can and cantools: pip install -e '.[can]' from the checkout") from None
    interface, colon, channel = address.partition(":")
    if not colon or not channel:
        raise BusError(f"CAN bus {address!r}: expected INTERFACE:CHANNEL, as socketcan:can0")
    options: dict[str, Any] = {}
    if interface == "udp_multicast":
        channel, colon, port = channel.rpartition(":")
        if not colon or not port.isdigit() or not 1024 <= int(port) < 65536:
            raise BusError(f"CAN bus {address!r}: expected udp_multicast:GROUP:PORT")
        options = {"port": int(port), "hop_limit": 0, "fd": False}
    try:
        return can.Bus(channel=channel, interface=interface, **options)
    except (can.CanError, OSError, ValueError, ImportError) as error:
        reason = error.__cause__ or error
        raise BusError(f"CAN bus {address!r} cannot be opened: {' '.join(str(reason).split())[:200]}") from None


class Link:
    """One end of `bus`; `own` are the identifiers it sends, which some buses hand back to their sender.

    `alive` is asked while it waits, and says by an exception that waiting is in vain.
    """

    def __init__(self, bus: Any, own: frozenset[tuple[int, bool]], alive: Callable[[], None], *, steps: bool) -> None:
        self._bus, self._alive = bus, alive
        self._own = own | {(STEP, True)} if steps else own | {(DONE, True), (TIME, True)}
        self._sent = self._got = 0
        self._ns = 0

    def send(self, frame: Frame) -> None:
        """Put a frame on the bus. Raises BusError if the bus does not take it."""
        import can

        self._sent += 1
        message = can.Message(arbitration_id=frame.id, is_extended_id=frame.extended, data=frame.data)
        try:
            self._bus.send(message)
        except can.CanError as error:
            raise BusError(f"CAN: {error}") from None

    def say(self, mark: int, number: int) -> None:
        """Send STEP or DONE with the number of the step, or TIME with nanoseconds."""
        if mark == TIME:
            self.send(Frame(mark, True, NANOSECONDS.pack(number)))
        else:
            self.send(Frame(mark, True, NUMBER.pack(number % 2**32, (self._sent + 1) % 2**32)))

    def until(self, mark: int, number: int, timeout: float) -> list[Stamped]:
        """All frames up to the STEP or DONE of that number, stamped with the TIME that stood before each.

        Raises Silence after `timeout` [s] of wall time, BusError if a frame was lost.
        """
        deadline = time.monotonic() + timeout
        came: list[Stamped] = []
        while True:
            message = self._recv(POLL)
            frame = None if message is None else self._of_others(message)
            if frame is None:
                if time.monotonic() > deadline:
                    raise Silence(f"nothing came for {timeout:g} s")
                if message is None:  # else a frame of this end, handed back by the bus: no silence of the other
                    self._alive()
                continue
            self._got += 1
            if frame.id == TIME and frame.extended:
                (self._ns,) = NANOSECONDS.unpack(frame.data)
            elif frame.id == mark and frame.extended:
                said, count = NUMBER.unpack(frame.data)
                if count != self._got % 2**32:
                    raise BusError(f"the CAN bus lost {(count - self._got) % 2**32} frames before step {said}")
                if said == number % 2**32:
                    return came
            else:
                came.append(Stamped(self._ns, frame))

    def waiting(self) -> list[Stamped]:
        """All frames that have come, with the bus's own stamps on this machine's monotonic clock; without lock-step.

        Raises BusError.
        """
        import can

        came, shift = [], time.time_ns() - time.monotonic_ns()  # buses stamp by the wall clock, which may be set
        try:
            while (message := self._bus.recv(0.0)) is not None:
                frame = _plain(message)
                if frame is not None and (frame.id, frame.extended) not in self._own:
                    came.append(Stamped(round(message.timestamp * 1e9) - shift, frame))
        except can.CanError as error:
            raise BusError(f"CAN: {error}") from None
        return came

    def close(self) -> None:
        """Leave the bus."""
        self._bus.shutdown()

    def _recv(self, timeout: float) -> Any:
        import can

        try:
            return self._bus.recv(timeout)
        except can.CanError as error:
            raise BusError(f"CAN: {error}") from None

    def _of_others(self, message: Any) -> Frame | None:
        """The frame, unless this end has sent it or it carries no data."""
        frame = _plain(message)
        return None if frame is None or (frame.id, frame.extended) in self._own else frame


def _plain(message: Any) -> Frame | None:
    if message.is_error_frame or message.is_remote_frame:
        return None
    return Frame(int(message.arbitration_id), bool(message.is_extended_id), bytes(message.data))
