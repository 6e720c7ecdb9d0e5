"""Values to CAN frames and back, by a signal map: units, saturation, rolling counter, checksum.

codec = Codec(find_map(), sends="command")       # the harness; a car: sends="report"
frames = codec.frames({"steer": 0.1, "throttle": 0.2, "brake": 0.0}, automatic=True)
values = codec.read(frame)                       # of the other direction; None for a frame that is not of the map
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

from vehicle.wire.can_map import Place, SignalMap, held_range
from vehicle.wire.checksum import CHECKSUMS


class Frame(NamedTuple):
    """A CAN frame: identifier, whether it is one of 29 bits, up to 8 bytes."""

    id: int
    extended: bool
    data: bytes


class Reading(NamedTuple):
    """What a frame said. `wrong` is "" if it counts, else why it does not: "checksum", "repeated", "length"; `lost` is
    how many frames before it, by its counter, never came (up to one round of the counter)."""

    message: str
    values: Mapping[str, float]
    wrong: str = ""
    lost: int = 0


class Codec:
    """One end of a drive-by-wire; it counts what it sends and what it gets. Raises ValueError on what is no number."""

    def __init__(self, car: SignalMap, *, sends: Literal["command", "report"]) -> None:
        self._map = car
        out, back = (car.command, car.report) if sends == "command" else (car.report, car.command)
        self._out, self._in = _by_message(out), _by_message(back)
        self._messages = {name: car.database.get_message_by_name(name) for name in (*self._out, *self._in)}
        extra = {place.message for table in (car.always, car.automatic) for place in table}
        if sends == "command":
            for name in sorted(extra - set(self._out) - set(self._in)):  # frames that carry nothing but constants
                self._out[name] = {}
                self._messages[name] = car.database.get_message_by_name(name)
        self._names = {(m.frame_id, m.is_extended_frame): name for name, m in self._messages.items()}
        self._sent = dict.fromkeys(self._out, 0)
        self._got: dict[str, int] = {}

    @property
    def sends(self) -> frozenset[tuple[int, bool]]:
        """Identifiers (and whether extended) of what this end sends."""
        return frozenset((m.frame_id, m.is_extended_frame) for name, m in self._messages.items() if name in self._out)

    def frames(self, values: Mapping[str, float], *, automatic: bool) -> list[Frame]:
        """The frames of all messages that carry one of `values` (SI), in the order of the map.

        A value beyond a signal's range goes as the end of that range.
        """
        out = []
        for message, places in self._out.items():
            if not places.keys() <= values.keys() or (not places and not automatic):
                continue
            signals = {signal.name: _raw(signal, 0.0) for signal in self._messages[message].signals}
            for name, place in places.items():
                signals[place.signal] = self._as_signal(place, values[name])
            for table, active in ((self._map.always, True), (self._map.automatic, automatic)):
                for place, value in table.items():
                    if place.message == message and active:
                        signals[place.signal] = self._as_signal(place, value)
            out.append(self._frame(message, signals))
        return out

    def read(self, frame: Frame) -> Reading | None:
        """What a frame of the other end says, in SI."""
        name = self._names.get((frame.id, frame.extended))
        if name is None or name not in self._in:
            return None
        message = self._messages[name]
        if len(frame.data) < message.length:
            return Reading(name, {}, "length")
        checksum = self._signal(message, self._map.checksum)
        if checksum is not None:
            at = checksum.start // 8
            if frame.data[at] != self._checksum(frame, at):
                return Reading(name, {}, "checksum")
        signals = message.decode(frame.data, decode_choices=False, scaling=True)
        lost = self._counted(message, name, signals)
        if lost < 0:
            return Reading(name, {}, "repeated")
        values = {key: float(signals[place.signal]) * place.factor for key, place in self._in[name].items()}
        return Reading(name, values, "", lost)

    def _frame(self, name: str, signals: dict[str, float]) -> Frame:
        message = self._messages[name]
        counter = self._signal(message, self._map.counter)
        if counter is not None:
            first, last = (round(end) for end in sent_range(counter))
            signals[counter.name] = first + self._sent[name] % (last - first + 1)
            self._sent[name] += 1
        checksum = self._signal(message, self._map.checksum)
        frame = Frame(message.frame_id, message.is_extended_frame, bytes(message.encode(signals, strict=False)))
        if checksum is None:
            return frame
        at, data = checksum.start // 8, bytearray(frame.data)
        data[at] = self._checksum(frame, at)
        return frame._replace(data=bytes(data))

    def _checksum(self, frame: Frame, at: int) -> int:
        head = frame.id.to_bytes(4 if frame.extended else 2, "little")
        return CHECKSUMS[self._map.kind](head + frame.data[:at] + frame.data[at + 1 :])

    def _counted(self, message: Any, name: str, signals: Mapping[str, Any]) -> int:
        """Frames lost before this one; -1 if it repeats the last."""
        counter = self._signal(message, self._map.counter)
        if counter is None:
            return 0
        first, greatest = (round(end) for end in sent_range(counter))
        now = int(signals[counter.name])
        last, self._got[name] = self._got.get(name), now
        return 0 if last is None else (now - last) % (greatest - first + 1) - 1

    def _as_signal(self, place: Place, value: float) -> float:
        if not -1e12 < value < 1e12:
            raise ValueError(f"{place.message}.{place.signal}: {value!r} is no number that CAN could carry")
        message = self._messages[place.message]
        return _raw(message.get_signal_by_name(place.signal), value / place.factor)

    @staticmethod
    def _signal(message: Any, name: str) -> Any:
        return next((signal for signal in message.signals if signal.name == name), None) if name else None


def _by_message(places: Mapping[str, Place]) -> dict[str, dict[str, Place]]:
    found: dict[str, dict[str, Place]] = {}
    for name, place in places.items():
        found.setdefault(place.message, {})[name] = place
    return found


def sent_range(signal: Any) -> tuple[float, float]:
    """Least and greatest value of a DBC's signal, in its unit, within what its bits and its stated range can hold."""
    low, high = held_range(signal)
    if signal.minimum is not None and signal.maximum is not None and signal.minimum < signal.maximum:
        low, high = max(low, signal.minimum), min(high, signal.maximum)
    return low, high


def _raw(signal: Any, value: float) -> float:
    """`value` in the signal's unit, within the range of the signal, on its grid if it has one."""
    low, high = sent_range(signal)
    within = float(min(max(value, low), high))
    if signal.is_float:
        return within
    step = round((within - signal.offset) / signal.scale)
    return float(step * signal.scale + signal.offset)
