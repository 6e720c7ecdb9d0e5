"""The surrogate's drive-by-wire: what a car does with the frames of its CAN bus before an actuator moves.

Mode: manual -> automatic when asked for, with a beating heart, after manual was asked for since the last fault.
Automatic -> fault when heartbeat or command stay away for 100 ms: it brakes by itself, the wheel held, until manual is
asked for (without modes in its messages: until commands come again). A frame with a wrong checksum, or one that
repeats, is not taken; it is counted and reported.
"""

from __future__ import annotations

from math import inf

from vehicle.messages import Command, Odometry
from vehicle.wire.can_codec import Codec, Frame
from vehicle.wire.can_link import DONE, STEP, TIME, Link, open_bus
from vehicle.wire.can_map import SignalMap

PATIENCE = 100_000_000  # ns without heartbeat or command
HARD = 7.0  # m/s^2 that it brakes with by itself
STEP_TIMEOUT = 5.0  # s of wall time between a step's word on the other wire and its frames here
MANUAL, AUTOMATIC, FAULT = "manual", "automatic", "fault"


class DriveByWire:
    """The unit on CAN bus `address` with the messages of `car`. Times [ns] are the caller's."""

    def __init__(self, address: str, car: SignalMap) -> None:
        self._codec, self._map = Codec(car, sends="report"), car
        self._link = Link(open_bus(address), self._codec.sends, lambda: None, steps=False)
        self._refused = 0
        self._asks = "mode" in car.command  # else it obeys whoever sends
        self._names = {value: name for name, value in car.mode.items()}
        self.reset()

    @property
    def pedals(self) -> bool:
        """Whether it is told throttle and brake, not an acceleration."""
        return self._map.pedals

    def reset(self) -> None:
        """Stand in manual mode, with nothing asked for."""
        self.mode = MANUAL if self._asks else AUTOMATIC
        self._asked_manual = True
        self._asked: dict[str, float] = {}
        self._heard: dict[str, float] = {}

    def hear(self, number: int, now: int) -> None:
        """Take the frames that came with step `number`."""
        self._hear([frame for _, frame in self._link.until(STEP, number, STEP_TIMEOUT)], now)

    def listen(self, now: int) -> None:
        """Take the frames that have come, by the wall clock."""
        self._hear([frame for _, frame in self._link.waiting()], now)

    def watch(self, now: int) -> None:
        """Fall into fault if what automatic mode needs has stayed away."""
        fresh = all(now - self._heard.get(name, now) < PATIENCE for name in self._map.command if name != "mode")
        if self.mode == AUTOMATIC and not fresh:
            self.mode, self._asked_manual = FAULT, False
        elif self.mode == FAULT and fresh and not self._asks:
            self.mode = AUTOMATIC

    def command(self, now: float) -> Command | None:
        """What the actuators get; None: nobody asks for anything, or a driver has the car."""
        if self.mode == FAULT:
            return Command(now, self._asked.get("steer", 0.0), -HARD, 0.0, 1.0)
        if self.mode != AUTOMATIC or "steer" not in self._asked:
            return None
        asked = self._asked
        return Command(
            now, asked["steer"], asked.get("accel", 0.0), asked.get("throttle", 0.0), asked.get("brake", 0.0)
        )

    def report(self, now: int, wheels: Odometry, *, stamped: bool = True) -> None:
        """Send the measured motion and the state, as of `now`; `stamped`: and say that it is of then."""
        if stamped:
            self._link.say(TIME, now)
        values = {
            "steer": wheels.steer, "speed": wheels.v, "mode": float(self._map.mode.get(self.mode, 0)),
            "override": 0.0, "emergency_stop": 0.0, "refused": float(min(self._refused, 65535)),
        }  # fmt: skip
        for frame in self._codec.frames(values, automatic=self.mode == AUTOMATIC):
            self._link.send(frame)

    def done(self, number: int) -> None:
        """Say that all frames of step `number` are sent."""
        self._link.say(DONE, number)

    def close(self) -> None:
        """Leave the bus."""
        self._link.close()

    def _hear(self, frames: list[Frame], now: int) -> None:
        for frame in frames:
            said = self._codec.read(frame)
            if said is None:
                continue
            self._refused += bool(said.wrong) + said.lost
            if said.wrong:
                continue
            self._asked.update(said.values)
            self._heard.update(dict.fromkeys(said.values, float(now)))
            if "mode" in said.values:
                self._ask_mode(self._names.get(round(said.values["mode"]), MANUAL), now)
        self.watch(now)

    def _ask_mode(self, asked: str, now: int) -> None:
        if asked == MANUAL:
            self.mode, self._asked_manual = MANUAL, True
        elif asked == AUTOMATIC and self.mode == MANUAL and self._asked_manual and self._beats(now):
            self.mode = AUTOMATIC
            self._heard.update(dict.fromkeys(self._heard, float(now)))

    def _beats(self, now: int) -> bool:
        return "heartbeat" not in self._map.command or now - self._heard.get("heartbeat", -inf) < PATIENCE
