"""A drive-by-wire on CAN: what carries the commands of a car, and brings its speed, steering angle and driver's hands.

CAN carries no LiDAR, camera or GNSS: those come over ROS 2, as in most research cars. So this is the part of a
`Ros2Vehicle` that its topics `/vehicle/command` and `/vehicle/feedback` would else be. Needs the extra `can`.
"""

from __future__ import annotations

from collections.abc import Callable

from vehicle.adapter import STALE, Hands, VehicleLost
from vehicle.messages import Command, Odometry
from vehicle.wire.can_codec import Codec, sent_range
from vehicle.wire.can_link import DONE, STEP, BusError, Link, Silence, Stamped, open_bus
from vehicle.wire.can_map import SignalMap
from vehicle.wire.health import Trouble

BEATS = 256  # the heartbeat counts to this, or to what its signal can hold
GRANTED = 100_000_000  # ns that a car has to grant automatic mode
GRANTED_LIVE = 300_000_000  # ns, by the wall clock
SILENT = 150_000_000  # ns of wall time without a valid report after which a car is lost that was commanded
SECOND = 1_000_000_000  # ns
HANDS = ("override", "emergency_stop")  # reports


class CanActuators:
    """The harness's end of CAN bus `address`, with the messages of `car`.

    Nothing is sent before the first command: a dry run leaves the bus alone. From then on every cycle sends all
    commands, asks for automatic mode and beats. Once a driver has taken over it asks for manual mode, until `reset`.
    Time [ns] is simulated, in lock-step with the surrogate (`stepped`), or that of a run by the wall clock
    (`listen`).
    `alive` raises VehicleLost if the car is known to be gone.
    """

    def __init__(self, address: str, car: SignalMap, alive: Callable[[], None], *, timeout: float) -> None:
        self._map, self._timeout = car, timeout
        self._codec = Codec(car, sends="command")
        self._link = Link(_opened(address), self._codec.sends, alive, steps=True)
        self._beat = 0
        self._beats = _beats(car)
        self._troubles: list[Trouble] = []
        self.reset()

    def reset(self) -> None:
        """Ask for nothing any more; forget what was measured."""
        self._command: Command | None = None
        self._since: int | None = None
        self._taken = False  # by the driver, since the first command
        self._now = 0
        self._listens: int | None = None  # since when [ns]
        self._last = 0
        self._mode: str = ""
        self._heard: dict[str, float] = {}
        self._heard_at: dict[str, int] = {}
        self._reports: list[Odometry] = []

    @property
    def hands(self) -> Hands:
        """As last reported. If a report is older than STALE, the driver counts as having taken over."""
        fresh = all(self._fresh(name) for name in HANDS if name in self._map.report)
        override, emergency_stop = (self._heard.get(name, 0.0) != 0.0 for name in HANDS)
        return Hands(override or not fresh, emergency_stop)

    def apply(self, command: Command) -> None:
        """Hold a command, from the next cycle on."""
        self._command = command

    def cycle(self, now: int) -> None:
        """Send the frames of a cycle that begins at `now` [ns]; nothing before the first command.

        Raises VehicleLost if the bus does not take a frame.
        """
        command = self._command
        if command is None:
            return
        self._since = now if self._since is None else self._since
        self._beat = (self._beat + 1) % len(self._beats)
        mode = float(self._map.mode.get("manual", 0) if self._taken else self._map.mode.get("automatic", 1))
        values = {
            "steer": command.steer, "accel": command.accel, "throttle": command.throttle, "brake": command.brake,
            "heartbeat": self._beats[self._beat], "mode": mode,
        }  # fmt: skip
        try:
            for frame in self._codec.frames(values, automatic=not self._taken):
                self._link.send(frame)
        except BusError as error:
            raise VehicleLost(str(error)) from None

    def step(self, number: int) -> None:
        """Say that all frames of step `number` are sent."""
        self._link.say(STEP, number)

    def stepped(self, number: int, now: int) -> None:
        """Take what the car sent in step `number`, which ends at `now` [ns]. Raises VehicleLost."""
        try:
            came = self._link.until(DONE, number, self._timeout)
        except Silence:
            raise VehicleLost(f"the car's CAN said nothing within {self._timeout:g} s") from None
        except BusError as error:
            raise VehicleLost(str(error)) from None
        self._take(came, now)
        self._check_mode(now, GRANTED)

    def listen(self, epoch: int, now: int) -> None:
        """Take what has come by `now` [ns], the monotonic clock's time less `epoch`. Raises VehicleLost."""
        try:
            came = self._link.waiting()
        except BusError as error:
            raise VehicleLost(str(error)) from None
        self._take([Stamped(ns - epoch, frame) for ns, frame in came], now)
        self._check_mode(now, GRANTED_LIVE)
        if self._since is not None and now - max(self._last, self._since) > SILENT:
            raise VehicleLost(f"the car's CAN has been silent for {(now - self._last) / SECOND:.2f} s")

    def reports(self) -> list[Odometry]:
        """Measured speed and steering angle since the last call, oldest first."""
        reports, self._reports = self._reports, []
        return reports

    def troubles(self) -> list[Trouble]:
        """Frames since the last call that did not count ("checksum", "length", "repeated"), or were lost before one."""
        troubles, self._troubles = self._troubles, []
        return troubles

    def close(self) -> None:
        """Leave the bus; a car in automatic mode stops when its heart no longer beats."""
        self._link.close()

    def _fresh(self, name: str) -> bool:
        """Whether a report is not older than it may be; one that has not come yet is waited for as long."""
        since = self._now if self._listens is None else self._listens
        return self._now - self._heard_at.get(name, since) < STALE * SECOND

    def _take(self, came: list[Stamped], now: int) -> None:
        """Only valid reports of the car count as its life; other frames may be on the bus as well."""
        self._now = now
        self._listens = now if self._listens is None else self._listens
        for ns, frame in came:
            said = self._codec.read(frame)
            if said is None:
                continue
            if said.wrong or said.lost:
                what = said.wrong or "lost"
                self._troubles.append(Trouble(ns / SECOND, f"CAN {said.message}", what, float(max(said.lost, 1))))
            if said.wrong:
                continue
            self._last = now
            self._heard.update(said.values)
            self._heard_at.update(dict.fromkeys(said.values, now))
            heard = self._heard
            if "mode" in said.values:
                value = round(said.values["mode"])
                self._mode = next((name for name, number in self._map.mode.items() if number == value), f"{value}")
            if "speed" in said.values and "steer" in heard and self._fresh("steer"):
                self._reports.append(Odometry(ns / SECOND, heard["speed"], heard["steer"]))

    def _check_mode(self, now: int, granted: int) -> None:
        """Raise VehicleLost if the car does not obey and no driver's hand is the reason."""
        self._taken = self._taken or (self._since is not None and self.hands.override)
        if self._since is None or "mode" not in self._map.report or self._taken or any(self.hands):
            return
        mode = self._mode if self._fresh("mode") else ""
        if mode != "automatic" and now - self._since >= granted:
            raise VehicleLost(f"the car's drive-by-wire is in mode {mode or 'unknown'}, asked for was automatic")


def _beats(car: SignalMap) -> tuple[float, ...]:
    """Values of the heartbeat, one after the other, from the least one on that is not negative."""
    place = car.command.get("heartbeat")
    if place is None:
        return tuple(map(float, range(BEATS)))
    signal = car.database.get_message_by_name(place.message).get_signal_by_name(place.signal)
    low, high = sent_range(signal)
    first, apart = max(low, 0.0), abs(signal.scale)
    count = min(BEATS, int((high - first) / apart + 1e-9) + 1)
    return tuple((first + k * apart) * place.factor for k in range(max(count, 1)))


def _opened(address: str) -> object:
    try:
        return open_bus(address)
    except BusError as error:
        raise VehicleLost(str(error)) from None
