"""Background traffic: SUMO in process (libsumo), with the ego and the storyboard's actors mirrored into it.

SUMO steps at 10 Hz; between its steps its cars move on at constant velocity. A pedestrian is mirrored as a small
vehicle, because SUMO's drivers mind what stands on their lane, not who walks beside a crossing.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import libsumo

STEP = 0.1  # s
_PREFIX = "dvp."  # of mirrored objects, so that they cannot meet a name of the route file
_OFFSET = re.compile(r'netOffset="([-+.\deE]+),([-+.\deE]+)"')
_PLACE = re.compile(r" In file '([^']+)' At line/column (\d+)/\d+\.?")
_ROUTES = re.compile(rb"<(routes|additional)[\s>/]")
_CODED = (b"\xff\xfe", b"\xfe\xff", b"\x1f\x8b")  # UTF-16, gzip: for SUMO to read
_REACH = 10.0  # m around a box in which SUMO looks for a lane; its default of 100 m costs five times as much
_KINDS = {
    "bicycle": "bicycle",
    "moped": "bicycle",
    "motorcycle": "bicycle",
    "scooter": "bicycle",
    "pedestrian": "pedestrian",
}  # of SUMO's vehicle classes; all others are vehicles
_ANYWHERE = 2  # keepRoute of moveToXY: put it there, on its route or not


class TrafficError(ValueError):
    """Traffic that cannot be run; one line that names the file."""


class Mirrored(NamedTuple):
    """A box of ours that SUMO's drivers shall see: centre [m], yaw [rad], size [m], speed [m/s]."""

    name: str
    x: float
    y: float
    yaw: float
    length: float
    width: float
    speed: float


class Car(NamedTuple):
    """A box of SUMO's: centre [m], yaw [rad], size [m], velocity in the map frame [m/s]; kind: of OBJECT_KINDS."""

    name: str
    x: float
    y: float
    yaw: float
    length: float
    width: float
    height: float
    vx: float
    vy: float
    kind: str = "vehicle"


class SumoTraffic:
    """One SUMO simulation; the library holds only one a process. `close` it, also after a failure.

    Raises TrafficError for a missing file or a net or route file that SUMO refuses.
    """

    def __init__(self, net: Path, routes: Path | None, seed: int) -> None:
        self._next = 0.0
        self._file = net if routes is None else routes
        self._sizes: dict[str, tuple[float, float, float]] = {}
        self._kinds: dict[str, str] = {}
        self._cars: list[Car] = []
        self._mirrored: dict[str, Mirrored | None] = {}  # as SUMO last heard of it
        for file in (net, routes):
            if file is not None and not file.is_file():
                raise TrafficError(f"{file}: no such file")
        match = _OFFSET.search(net.read_text(encoding="utf-8", errors="replace")[:100_000])
        if match is None:
            raise TrafficError(f"{net}: no SUMO net, it has no location with netOffset")
        begin = b"" if routes is None else routes.read_bytes()[:100_000]
        if routes is not None and begin[:2] not in _CODED and not _ROUTES.search(begin):
            raise TrafficError(f"{routes}: no SUMO routes, it has no element <routes>")
        self._offset = (float(match[1]), float(match[2]))
        options = ["sumo", "--net-file", str(net), "--step-length", str(STEP), "--seed", str(seed)]
        options += ["--route-files", str(routes)] if routes is not None else []
        options += ["--collision.action", "none", "--time-to-teleport", "-1", "--no-step-log", "--no-warnings"]
        # Without this SUMO fetches its schemas from the network.
        options += ["--xml-validation", "never", "--xml-validation.net", "never", "--xml-validation.routes", "never"]
        options += ["--duration-log.disable", "--pedestrian.model", "nonInteracting"]
        if libsumo.isLoaded():
            raise TrafficError(f"{net}: another SUMO simulation is running in this process")
        try:
            libsumo.start(options)
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            self.close()
            text = " ".join(str(error).split())
            place = _PLACE.search(text)
            where = f"{place[1]}:{place[2]}" if place else str(net)
            raise TrafficError(f"{where}: SUMO refuses it: {_PLACE.sub('', text)}") from None

    def step(self, t: float, mirrored: Callable[[], Iterable[Mirrored]]) -> list[Car]:
        """Cars at time `t` [s]; call it with t = 0, 0.05, 0.1, ... `mirrored` is only asked when SUMO steps.

        Raises TrafficError for a route that SUMO finds out only now that nobody can drive.
        """
        if t < self._next - 1e-9:
            ahead = t - (self._next - STEP)
            return [car._replace(x=car.x + car.vx * ahead, y=car.y + car.vy * ahead) for car in self._cars]
        self._next += STEP
        self._mirror(list(mirrored()))
        try:
            libsumo.simulationStep()
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            raise TrafficError(f"{self._file}: SUMO ends at t={t:.2f} s: {' '.join(str(error).split())}") from None
        self._cars = [self._car(name) for name in libsumo.vehicle.getIDList() if not name.startswith(_PREFIX)]
        return self._cars

    def close(self) -> None:
        """End the simulation; may be called more than once."""
        if libsumo.isLoaded():
            libsumo.close()

    def _mirror(self, mirrored: list[Mirrored]) -> None:
        vehicle = libsumo.vehicle
        for box in mirrored:
            name = _PREFIX + box.name
            if name not in self._mirrored:
                self._add(name, box)
            elif self._mirrored[name] == box and box.speed == 0.0:
                continue  # it stands where it stood, and moving it would be the dearest call of all
            # SUMO's position is the middle of the front bumper, its angle runs clockwise from north in degrees.
            x = box.x + 0.5 * box.length * math.cos(box.yaw) + self._offset[0]
            y = box.y + 0.5 * box.length * math.sin(box.yaw) + self._offset[1]
            try:
                vehicle.moveToXY(name, "", -1, x, y, 90.0 - math.degrees(box.yaw), _ANYWHERE, _REACH)
                vehicle.setSpeed(name, max(0.0, box.speed))
                self._mirrored[name] = box
            except libsumo.TraCIException:
                del self._mirrored[name]  # SUMO dropped it (end of its road): put it back at the next step
        for name in [name for name in self._mirrored if name.removeprefix(_PREFIX) not in {b.name for b in mirrored}]:
            vehicle.remove(name)
            del self._mirrored[name]

    def _add(self, name: str, box: Mirrored) -> None:
        kind = f"{name}.type"
        if kind not in libsumo.vehicletype.getIDList():
            libsumo.vehicletype.copy("DEFAULT_VEHTYPE", kind)
            libsumo.vehicletype.setLength(kind, box.length)
            libsumo.vehicletype.setWidth(kind, box.width)
        libsumo.vehicle.add(name, "", typeID=kind)
        libsumo.vehicle.setSpeedMode(name, 0)
        libsumo.vehicle.setLaneChangeMode(name, 0)
        self._mirrored[name] = None

    def _car(self, name: str) -> Car:
        vehicle: Any = libsumo.vehicle
        size = self._sizes.get(name)
        if size is None:
            size = (vehicle.getLength(name), vehicle.getWidth(name), vehicle.getHeight(name))
            self._sizes[name] = size
            self._kinds[name] = _KINDS.get(vehicle.getVehicleClass(name), "vehicle")
        x, y = vehicle.getPosition(name)
        yaw = math.radians(90.0 - vehicle.getAngle(name))
        yaw = math.atan2(math.sin(yaw), math.cos(yaw))
        speed = vehicle.getSpeed(name)
        cos, sin = math.cos(yaw), math.sin(yaw)
        back = 0.5 * size[0]
        x, y = x - self._offset[0] - back * cos, y - self._offset[1] - back * sin
        return Car(name, x, y, yaw, *size, speed * cos, speed * sin, self._kinds[name])
