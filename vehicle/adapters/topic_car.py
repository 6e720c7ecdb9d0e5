"""A real car that speaks the topics of `vehicle/wire/topics.py`, by the wall clock: over ROS 2 or over ROS 1.

    --dvp-vehicle ros2_car:7           on DDS domain 7 of the network that CYCLONEDDS_URI describes
    --dvp-vehicle ros2_car:car.toml    on the one that the file says, `domain = 7`
    --dvp-vehicle ros1_car:car.toml    on ROS 1, reached as the file says (vehicle/wire/ros1.py)

A file may say where the map lies, which a road file says by its geoReference:

    origin = { latitude = 48.137, longitude = 11.575 }     # vehicle/wire/geodetic.py

Its driver's hands are two topics; who says nothing there for `vehicle.adapter.STALE`, or has not yet, has the wheel.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vehicle.adapter import STALE, Hands, VehicleLost
from vehicle.adapters.live import LiveCar, Punctuality
from vehicle.messages import VehicleDescription, VehicleState
from vehicle.toml_file import TomlError, read_toml
from vehicle.wire import topics
from vehicle.wire.end import Opener
from vehicle.wire.geodetic import DEFAULT_ORIGIN, Origin, read_origin
from vehicle.wire.live import LiveEnd

MOST_DOMAIN = 232  # DDSI-RTPS 2.5, 9.6.2.3: its ports would lie above 65535
EXAMPLE = "origin = { latitude = 48.137, longitude = 11.575 }"
_ASKED = (
    f"a node that answers {topics.STEP.name} by {topics.DONE.name} and {topics.DESCRIPTION.name}, listens to "
    f"{topics.COMMAND.name} and says {topics.ODOMETRY.name} and {topics.FEEDBACK.name}"
)


class TopicCar(LiveCar):
    """A real car on the wire that `opener` opens. Raises VehicleLost if it does not come, naming `where` it was."""

    reads = (*topics.FROM_CAR, *topics.HANDS)

    def __init__(self, opener: Opener, where: str, *, origin: Origin | None = None, **options: Any) -> None:
        self.punctuality = Punctuality()
        self._held: dict[topics.Topic, bool] = {}
        self._heard_at: dict[topics.Topic, float] = {}
        self._where = where
        super().__init__(opener, alive=lambda: None, is_real=True, end=LiveEnd, **options)
        self._stated = origin
        self.locate_map(None, "")

    def locate_map(self, origin: Origin | None, why_not: str) -> None:
        """Where the map lies, unless the car's file states it. Raises VehicleLost if neither can be known."""
        if self._stated is None and why_not:
            self.close()
            raise VehicleLost(f"{why_not}; or state it in the car's file: {EXAMPLE}")
        self._origin = self._stated or origin or DEFAULT_ORIGIN

    def _call(self, ready: float) -> VehicleDescription:
        try:
            return super()._call(ready)
        except VehicleLost as error:
            raise VehicleLost(f"{error}; expected {self._where}") from None

    def reset(self, state: VehicleState) -> None:
        """Learn the car's clock, and see that it stands at `state`; hands of before do not count."""
        self._heard_at = {}
        super().reset(state)

    def _discard(self) -> set[topics.Topic]:
        _ = self.hands  # these are of now, whatever else is under way
        return super()._discard()

    @property
    def hands(self) -> Hands:
        """As last said; the driver's where that is stale."""
        now = self._clock()
        for topic in topics.HANDS:
            for message in self._wire().take(topic):
                self._held[topic], self._heard_at[topic] = bool(message.data), now
        fresh = all(now - self._heard_at.get(topic, -STALE) < STALE for topic in topics.HANDS)
        return Hands(not fresh or self._held[topics.OVERRIDE], self._held.get(topics.EMERGENCY_STOP, False))


class Ros2Car(TopicCar):
    """`ros2_car:DOMAIN`."""

    @staticmethod
    def waits_for(argument: str) -> str:
        """What is looked for, and where, for who waits."""
        argument = str(_domain(argument)[0])
        network = os.environ.get("CYCLONEDDS_URI") or "not set: the network that the system prefers"
        return f"{_ASKED} on DDS domain {argument} (ROS_DOMAIN_ID there; CYCLONEDDS_URI {network})"

    def __init__(self, argument: str, **options: Any) -> None:
        from vehicle.wire.dds import on_domain

        domain, origin = _domain(argument)
        super().__init__(on_domain(domain, network=True), self.waits_for(argument), origin=origin, **options)


class Ros1Car(TopicCar):
    """`ros1_car:FILE`."""

    @staticmethod
    def waits_for(argument: str) -> str:
        """What is looked for, and where, for who waits."""
        return f"{_ASKED} at the ROS master that {argument or 'ROS_MASTER_URI'} names"

    def __init__(self, argument: str, **options: Any) -> None:
        from vehicle.wire.ros1 import Ros1Error, on_ros1, read_settings

        try:
            settings = read_settings(Path(argument) if argument else None, {"origin": dict})
        except Ros1Error as error:
            raise VehicleLost(f"vehicle ros1_car:{argument}: {error}") from None
        origin = _origin(settings.others, f"vehicle ros1_car:{argument}")
        opener = on_ros1(settings, "harness", error=VehicleLost)
        super().__init__(opener, self.waits_for(argument), origin=origin, **options)


def _domain(argument: str) -> tuple[int, Origin | None]:
    """DDS domain, and where the map lies if a file says it, of `ros2_car:ARGUMENT`. Raises VehicleLost."""
    who = f"vehicle ros2_car:{argument}"
    given: dict[str, Any] = {"domain": int(argument)} if argument.isdigit() else {}
    if argument.endswith(".toml"):
        try:
            given, _ = read_toml(Path(argument))
        except TomlError as error:
            raise VehicleLost(f"{who}: {error.at(Path(argument))}: {error}") from None
        if unknown := sorted(set(given) - {"domain", "origin"}):
            raise VehicleLost(f"{who}: {unknown[0]} is unknown, allowed: domain, origin")
    domain = given.get("domain")
    if isinstance(domain, bool) or not isinstance(domain, int) or not 0 <= domain <= MOST_DOMAIN:
        if argument.endswith(".toml"):
            found = f"found {domain!r}" if "domain" in given else "it is missing"
            raise VehicleLost(f"{who}: domain: {found}, allowed: a DDS domain, 0 to {MOST_DOMAIN}")
        raise VehicleLost(f"{who}: expected a DDS domain, 0 to {MOST_DOMAIN}, as ros2_car:7")
    return domain, _origin(given, who)


def _origin(given: Mapping[str, Any], who: str) -> Origin | None:
    try:
        return read_origin(given["origin"]) if "origin" in given else None
    except ValueError as error:
        raise VehicleLost(f"{who}: origin: {error}") from None
