"""Faults put on the wire of a surrogate, the same for the same seed: what becomes of a run when messages do not come.

They act between the wire and the adapter, behind the lock-step, so that stepped time goes on. A fault is written
NAME, NAME@FROM or NAME@FROM+LENGTH (seconds; 5+3), on some topics only as NAME:/gnss/fix@5+3.
"""

from __future__ import annotations

import copy
import random
import re
import signal
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from vehicle.wire import topics
from vehicle.wire.end import End
from vehicle.wire.topics import Topic

SECOND = 1_000_000_000  # ns

FAULTS: Mapping[str, str] = {
    "drop": "each message is lost with a probability of a half",
    "delay": "messages come 0.3 s later",
    "duplicate": "each message comes twice",
    "reorder": "each message comes after the next one",
    "nan": "three of ten messages carry a value that is not a finite number",
    "clock_ahead": "the car's clock is 0.5 s ahead",
    "clock_back": "the car's clock is 0.5 s behind",
    "burst": "nothing comes, then all at once",
    "silence": "nothing comes any more",
    "freeze": "the last values come again and again, with new stamps",
    "spike": "one of ten positions is 50 m off",
    "no_commands": "commands do not reach the car",
    "killed": "the car's process is killed (SIGKILL)",
    "stopped": "the car's process is stopped (SIGSTOP)",
}
SIGNALS = {"killed": signal.SIGKILL, "stopped": signal.SIGSTOP}
FORM = re.compile(r"(?P<name>\w+)(:(?P<topic>/[\w/]+))?(@(?P<begin>\d+(\.\d+)?)(\+(?P<length>\d+(\.\d+)?))?)?")


class FaultError(ValueError):
    """A fault that does not exist; one line."""


@dataclass(frozen=True)
class Fault:
    """What goes wrong from `begin` to `end` [s] on which topics."""

    name: str
    begin: float
    end: float
    topics: tuple[Topic, ...]


def parse_fault(text: str) -> Fault:
    """Raises FaultError, with what is allowed."""
    found = FORM.fullmatch(text)
    if found is None or found["name"] not in FAULTS:
        raise FaultError(f"fault {text!r}: expected NAME@FROM+LENGTH [s], NAME one of {', '.join(FAULTS)}")
    on = tuple(topic for topic in topics.SENSED if found["topic"] in (None, topic.name))
    if not on:
        raise FaultError(
            f"fault {text!r}: no topic {found['topic']}; there is {', '.join(t.name for t in topics.SENSED)}"
        )
    begin = float(found["begin"] or 5.0)
    return Fault(found["name"], begin, begin + float(found["length"] or 3.0), on)


class FaultyEnd(End):
    """An end of the wire on which a fault happens; `send_signal` reaches the car's process."""

    def __init__(self, fault: Fault, seed: int, send_signal: Callable[[int], None], *wire: Any) -> None:
        super().__init__(*wire)
        self._fault, self._send_signal = fault, send_signal
        self._rng = random.Random(seed)
        self._now = 0.0
        self._held: dict[Topic, list[tuple[float, Any]]] = {topic: [] for topic in fault.topics}
        self._newest: dict[Topic, Any] = {}
        self._struck = False

    def send(self, topic: Topic, message: Any) -> None:
        """As of an End; commands do not arrive while they are not to."""
        if topic == topics.RESET:
            self._now, self._struck = 0.0, False
            self._held = {topic: [] for topic in self._fault.topics}
        if self._fault.name == "no_commands" and topic == topics.COMMAND and self._active():
            return
        super().send(topic, message)

    def step(self, number: int, stamp: int) -> None:
        """As of an End; a signal to the car's process strikes here."""
        self._now = stamp / SECOND
        if self._fault.name in SIGNALS and self._active() and not self._struck:
            self._struck = True
            self._send_signal(SIGNALS[self._fault.name])
        super().step(number, stamp)

    def take(self, topic: Topic) -> list[Any]:
        """The messages of a topic, as the fault leaves them."""
        came = super().take(topic)
        if topic not in self._held:
            return came
        return [message for each in came for message in self._struck_by(topic, each)] + self._due(topic)

    def _active(self) -> bool:
        return self._fault.begin <= self._now < self._fault.end

    def _struck_by(self, topic: Topic, message: Any) -> list[Any]:
        held, name = self._held[topic], self._fault.name
        if not self._active():
            self._newest[topic] = message
            late = [each for _, each in held]
            held.clear()
            return [*late, message]
        if name == "drop":
            return [] if self._rng.random() < 0.5 else [message]
        if name == "delay":
            held.append((self._now + 0.3, message))
            return []
        if name == "duplicate":
            return [message, message]
        if name == "reorder":
            if not held:
                held.append((float("inf"), message))
                return []
            return [message, held.pop()[1]]
        if name == "burst":
            held.append((self._fault.end, message))
            return []
        if name == "silence":
            return []
        return [self._spoilt(topic, message)]

    def _due(self, topic: Topic) -> list[Any]:
        held = self._held[topic]
        due = [message for t, message in held if t <= self._now + 1e-9]
        self._held[topic] = [(t, message) for t, message in held if t > self._now + 1e-9]
        return due

    def _spoilt(self, topic: Topic, message: Any) -> Any:
        name, stamp = self._fault.name, message.header.stamp
        if name == "freeze" and topic in self._newest:
            frozen = copy.deepcopy(self._newest[topic])
            frozen.header.stamp = stamp
            return frozen
        message = copy.deepcopy(message)
        if name in ("clock_ahead", "clock_back"):
            ns = stamp.sec * SECOND + stamp.nanosec + (SECOND // 2 if name == "clock_ahead" else -SECOND // 2)
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(ns, SECOND)
        elif name == "nan" and self._rng.random() < 0.3:
            _make_nan(topic, message)
        elif name == "spike" and self._rng.random() < 0.1:
            _make_far(topic, message)
        return message


def _make_nan(topic: Topic, message: Any) -> None:
    if topic == topics.ODOMETRY:
        message.pose.pose.position.x = float("nan")
    elif topic == topics.FIX:
        message.latitude = float("nan")
    elif topic == topics.HEADING:
        message.orientation.z = float("nan")
    elif topic in (topics.IMU, topics.REFERENCE_IMU):
        message.angular_velocity.z = message.linear_acceleration.x = float("nan")
    elif topic == topics.FEEDBACK:
        message.drive.speed = float("nan")
    elif topic == topics.CAMERA and message.detections:
        message.detections[0].bbox.center.position.x = float("nan")
    elif topic == topics.POINTS and len(message.data):
        message.data = struct.pack("<f", float("nan")) + bytes(message.data)[4:]


def _make_far(topic: Topic, message: Any) -> None:
    if topic == topics.ODOMETRY:
        message.pose.pose.position.y += 50.0
    elif topic == topics.FIX:
        message.latitude += 50.0 / 111_000.0  # m a degree
