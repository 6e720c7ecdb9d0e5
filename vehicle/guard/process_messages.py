"""What goes between a harness and the process that holds the guard: MessagePack, arrays as their bytes."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np

from vehicle.guard.messages import Area, Arming, Decision
from vehicle.messages import VehicleDescription
from vehicle.wire.geodetic import Origin
from vehicle.wire.health import Trouble


class Opening(msgspec.Struct, frozen=True):
    """Which car: class or function `adapter` ("module:name"), called with `argument`; among virtual road users, with
    noise of `seed`, if `parallel`. The limits of the gate: `max_speed` [m/s], `area`. `perception` holds the values of
    the effects, by name, that the virtual road users are seen with. `origin`, `why_not`: of
    `KnowsItsMap.locate_map`."""

    adapter: str
    argument: str
    parallel: bool
    seed: int
    name: str
    scenario: str
    max_speed: float | None
    area: Area | None
    perception: dict[str, dict[str, float]] = {}
    origin: Origin | None = None
    why_not: str = ""


class Opened(msgspec.Struct, frozen=True):
    """The car is there."""

    description: VehicleDescription
    is_real: bool


class Keys(msgspec.Struct, frozen=True):
    """The two keys, or not."""

    named: str | None = None
    arming: Arming | None = None


class Untold(msgspec.Struct, frozen=True):
    """What the gate has decided and the wire has told of since the last answer; it goes with an error too."""

    decisions: tuple[Decision, ...]
    troubles: tuple[Trouble, ...]


class Answer(msgspec.Struct, frozen=True):
    """What a question brought; `position_sigma` [m]: what the car states of its newest row of motion."""

    value: msgspec.Raw
    untold: Untold
    armed: bool
    position_sigma: float


def pack(value: Any) -> bytes:
    """As bytes."""
    return _ENCODER.encode(value)


def unpack(data: bytes | msgspec.Raw, kind: Any) -> Any:
    """A value of a kind. Raises msgspec.ValidationError."""
    return msgspec.msgpack.decode(data, type=kind, dec_hook=array)


def raw(value: Any) -> Any:
    """An array as what MessagePack knows; numbers of numpy as Python's.

    Raises NotImplementedError for anything else.
    """
    if isinstance(value, np.ndarray):
        return (value.dtype.str, value.shape, np.ascontiguousarray(value).reshape(-1).view(np.uint8).data)
    if isinstance(value, np.generic):
        return value.item()
    raise NotImplementedError(type(value).__name__)


def array(kind: Any, value: Any) -> Any:
    """The array again; it may be written to."""
    dtype, shape, data = value
    return np.frombuffer(data, dtype=dtype).reshape(shape).copy()


_ENCODER = msgspec.msgpack.Encoder(enc_hook=raw)
