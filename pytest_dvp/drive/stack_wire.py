"""What goes between the harness and the process of a stack: frames on a socket, MessagePack in them, no pickle.

The harness asks one thing at a time; the process answers it. Meanwhile the process says when numba begins and ends to
compile, as this is no time of the stack's own.
"""

from __future__ import annotations

import struct
from typing import Any

import msgspec

from vehicle.guard.process_messages import array, raw
from vehicle.messages import Observation, VehicleDescription

HEAD = struct.Struct("<cI")  # what it is, length of what follows
BEGIN, LOAD, MAKE, TICK, CLOSE = b"P", b"L", b"M", b"T", b"C"  # asked
ANSWER, ERROR, COMPILES, COMPILED = b"A", b"E", b"B", b"N"  # said

NO_PATH, LAST_PATH, NEW_PATH = 0, 1, 2


class Load(msgspec.Struct, frozen=True):
    """Load the stack that `text` names; `folders` are searched too, from the current folder `here`."""

    text: str
    folders: list[str]
    here: str


class Loaded(msgspec.Struct, frozen=True):
    """It is loaded.

    parameters  that it declares, with their defaults
    reads       the sensors that it declares to read
    files       that were loaded for it, and time of change [ns] and size of each
    """

    parameters: dict[str, int | float] | None
    reads: list[str] | None
    files: list[tuple[str, int, int]]


class Make(msgspec.Struct, frozen=True):
    """Make the stack for a new run.

    own           whether `parameters` are those that it declares itself, or those of the reference stack
    road          the OpenDRIVE file, and the hash of its content
    environment   variables as they are in the harness now
    """

    parameters: dict[str, int | float]
    own: bool
    road: tuple[str, str]
    description: VehicleDescription
    here: str
    environment: dict[bytes, bytes]


class Made(msgspec.Struct, frozen=True):
    """It is made; `nets` as it tells them."""

    nets: list[Any]


class Ticked(msgspec.Struct, frozen=True, array_like=True):
    """What a tick brought.

    command     t, steer, accel, throttle, brake
    detections  fields of `vehicle.messages.Detection` in their order
    path        NO_PATH; LAST_PATH, the one that was sent last; NEW_PATH with `points`, float64 x, y, x, y, ...
    seconds     that it took there
    """

    command: tuple[float, float, float, float, float]
    trace: dict[str, float]
    detections: list[list[Any]]
    path: int
    points: bytes
    seconds: float


class Failed(msgspec.Struct, frozen=True):
    """What went wrong. kind: "load" or "fault", whose line is `said`; "raised", an exception of class `name` with the
    first line `said` and its traceback."""

    kind: str
    said: str
    name: str = ""
    trace: str = ""


_ENCODER = msgspec.msgpack.Encoder(enc_hook=raw)
encode = _ENCODER.encode
observation_of = msgspec.msgpack.Decoder(Observation, dec_hook=array).decode
ticked_of = msgspec.msgpack.Decoder(Ticked).decode


def decode(data: bytes, kind: Any) -> Any:
    """A message of a kind. Raises msgspec.ValidationError."""
    return msgspec.msgpack.decode(data, type=kind)


def fill(buffer: bytearray, what: bytes, message: Any) -> None:
    """Make `buffer` the frame of a message, or of bytes: a cloud of points is not copied more often than it must be."""
    if isinstance(message, bytes):
        buffer[:] = HEAD.pack(what, len(message)) + message
        return
    _ENCODER.encode_into(message, buffer, HEAD.size)
    HEAD.pack_into(buffer, 0, what, len(buffer) - HEAD.size)
