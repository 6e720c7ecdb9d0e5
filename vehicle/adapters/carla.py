"""A car in CARLA 0.9.16 as a stand-in, in synchronous mode: `--dvp-vehicle carla:carla.toml`.

    host = "127.0.0.1"
    port = 2000
    blueprint = "vehicle.micro.microlino"
    rear = 0.8              # m from the actor's origin back to the rear axle
    python = "python3.8"    # an interpreter of your own that has CARLA's package; default: this one
    path = ["/opt/carla/PythonAPI/carla"]     # where that looks for it besides
    [S]                     # parameters S of the paper, set in CARLA's physics
    EGO_mass = 730.0

The server has the scenario's map loaded (`client.generate_opendrive_world`). CARLA moves the car; speed, pose and
inertial sensors are read from the actor, without noise. Tried against the objects of CARLA's Python package and a
script of calls; against a running server never, as none was at hand.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Mapping
from math import radians
from pathlib import Path
from typing import Any

import numpy as np

from vehicle.adapter import VehicleLost
from vehicle.messages import (
    CameraFrame,
    Command,
    FloatArray,
    GnssFix,
    Imu,
    LidarScan,
    Observation,
    Odometry,
    Surroundings,
    VehicleDescription,
    VehicleState,
    brake_first,
)
from vehicle.toml_file import TomlError, read_toml
from vehicle.wire import carla_frame as frame

TICK = 0.01  # s, of the server in synchronous mode
KEYS = {
    "host": "127.0.0.1",
    "port": 2000,
    "blueprint": "vehicle.micro.microlino",
    "rear": 0.8,
    "python": "",
    "path": [],
    "S": {},
}
PATIENCE = 10.0  # s for the server's answer
BUSY = 15.0  # s that CARLA's package may hold its interpreter
PHYSICS = {"EGO_mass": "mass", "EGO_moi": "moi", "EGO_dr_full_throttle": "damping_rate_full_throttle",
           "EGO_dr_zero_throttle": "damping_rate_zero_throttle_clutch_engaged"}  # fmt: skip
LOOK = 10  # ticks between two empty scans and images, for the mirror to fill
GNSS_SIGMA, YAW_SIGMA = 0.02, 0.005  # m, rad that the poses claim


class CarlaVehicle:
    """The actor of a world in synchronous mode; `connect` opens one. `carla` is CARLA's module, or what stands in;
    `leave` is called when the car is closed."""

    is_real = False

    def __init__(
        self, carla: Any, world: Any, actor: Any, rear: float, leave: Callable[[], None] = lambda: None
    ) -> None:
        self._leave = leave
        self._carla, self._world, self._actor, self._rear = carla, world, actor, rear
        physics = actor.get_physics_control()
        self._max_steer = radians(max(wheel.max_steer_angle for wheel in physics.wheels))
        box = actor.bounding_box
        self._description = VehicleDescription(
            length=2.0 * box.extent.x,
            width=2.0 * box.extent.y,
            height=2.0 * box.extent.z,
            wheelbase=2.0 * rear,
            center_x=rear + box.location.x,
            max_steer=self._max_steer,
            max_speed=40.0,
            max_acceleration=3.0,
            max_deceleration=7.0,
            mass=physics.mass,
        )
        self._t, self._ticks, self._steer = 0.0, 0, 0.0
        self._seen: list[VehicleState] = []

    @property
    def description(self) -> VehicleDescription:
        """Size, mass and steering lock of the actor; speed and accelerations are taken for a small car's."""
        return self._description

    def reset(self, state: VehicleState) -> None:
        """Put the actor there, rolling with `state.v`."""
        carla, place = self._carla, frame.to_carla(state.x, state.y, state.z, state.yaw, self._rear)
        rotation = carla.Rotation(pitch=0.0, yaw=place.yaw, roll=0.0)
        self._actor.set_transform(carla.Transform(carla.Location(x=place.x, y=place.y, z=place.z), rotation))
        forward = np.cos(state.yaw), np.sin(state.yaw)
        self._actor.set_target_velocity(carla.Vector3D(x=state.v * forward[0], y=-state.v * forward[1], z=0.0))
        self._t, self._ticks, self._steer, self._seen = state.t, 0, state.steer, []

    def observe(self, surroundings: Surroundings) -> Observation:
        """What ideal sensors at the rear axle show; scans and images are empty, for virtual road users."""
        seen, self._seen = self._seen, []
        looks = self._ticks % LOOK == 0
        return Observation(
            self._t,
            gnss=tuple(GnssFix(s.t, s.x, s.y, GNSS_SIGMA, s.yaw, YAW_SIGMA) for s in seen[-1:]),
            odometry=tuple(Odometry(s.t, s.v, s.steer) for s in seen),
            imu=tuple(Imu(s.t, s.ax, s.ay, s.yaw_rate) for s in seen),
            lidar=LidarScan(self._t, np.zeros((0, 3))) if looks else None,
            camera=CameraFrame(self._t, ()) if looks else None,
        )

    def apply(self, command: Command) -> None:
        """Pedals and steering."""
        steer = frame.to_steer(command.steer, self._max_steer)
        self._steer = frame.from_steer(steer, self._max_steer)
        command = brake_first(command, self._description.max_deceleration)
        throttle, brake = (min(max(value, 0.0), 1.0) for value in (command.throttle, command.brake))
        self._actor.apply_control(self._carla.VehicleControl(throttle=throttle, steer=steer, brake=brake))

    def step(self, dt: float) -> FloatArray:
        """Let the server make dt / 10 ms ticks, dt in [s]. Returns a row of TRACE_COLUMNS after each, (k, 12).

        Raises VehicleLost if the server does not tick.
        """
        rows = []
        for _ in range(round(dt / TICK)):
            try:
                self._world.tick(PATIENCE)
            except RuntimeError as error:
                raise VehicleLost(f"CARLA did not tick: {' '.join(str(error).split())[:200]}") from None
            self._ticks += 1
            self._t = round(self._t + TICK, 9)
            state = self._state()
            self._seen.append(state)
            rows.append([getattr(state, name) for name in _ROW])
        return np.array(rows, dtype=np.float64)

    def stop(self) -> None:
        """Full brake."""
        self.apply(Command(self._t, self._steer, -self._description.max_deceleration, 0.0, 1.0))

    def close(self) -> None:
        """Take the actor out of the world, and give the server its own time back."""
        actor, self._actor = self._actor, None
        if actor is not None:
            with contextlib.suppress(VehicleLost):  # a bridge that is gone has nothing to give back
                actor.destroy()
                settings = self._world.get_settings()
                settings.synchronous_mode, settings.fixed_delta_seconds = False, None
                self._world.apply_settings(settings)
            self._leave()

    def _state(self) -> VehicleState:
        transform, velocity = self._actor.get_transform(), self._actor.get_velocity()
        acceleration, turn = self._actor.get_acceleration(), self._actor.get_angular_velocity()
        at, turned = transform.location, transform.rotation
        x, y, z, yaw = frame.from_carla(frame.Place(at.x, at.y, at.z, turned.yaw), self._rear)
        rate = frame.yaw_rate(turn.z)
        vx, vy = frame.body_vector(velocity.x, velocity.y, yaw)
        ax, ay = frame.body_vector(acceleration.x, acceleration.y, yaw)
        return VehicleState(  # velocity and acceleration are those of the origin, `rear` ahead of the axle
            self._t, x, y, yaw, vx, z, vx, vy - self._rear * rate, rate, ax + self._rear * rate**2, ay, self._steer
        )


_ROW = ("t", "x", "y", "z", "yaw", "v", "vx", "vy", "yaw_rate", "ax", "ay", "steer")


def connect(argument: str) -> CarlaVehicle:
    """The car that a file describes, on a running server. Raises VehicleLost, one line."""
    settings = _read(Path(argument))
    carla, leave = _module(settings["python"], settings["path"])
    try:
        return _spawned(carla, settings, leave)
    except BaseException:
        leave()
        raise


def _module(python: str, path: list[str]) -> tuple[Any, Callable[[], None]]:
    """CARLA's module, and what is to be called when it is no longer needed. Raises VehicleLost."""
    if not python and not path:
        try:
            import carla
        except ImportError:
            raise VehicleLost(
                "CARLA needs its Python package: pip install -e '.[carla]' from the checkout, "
                'or python = "..." in its file'
            ) from None
        return carla, lambda: None
    from vehicle.interpreter_bridge import Bridge

    bridge = Bridge(python or sys.executable, path, who="the bridge to CARLA", error=VehicleLost, silent=BUSY)
    try:
        return bridge.module("carla"), bridge.close
    except BaseException:
        bridge.close()
        raise


def _spawned(carla: Any, settings: Mapping[str, Any], leave: Callable[[], None]) -> CarlaVehicle:
    try:
        client = carla.Client(settings["host"], settings["port"])
        client.set_timeout(PATIENCE)
        world = client.get_world()
        timing = world.get_settings()
        timing.synchronous_mode, timing.fixed_delta_seconds = True, TICK
        world.apply_settings(timing)
        blueprint = world.get_blueprint_library().find(settings["blueprint"])
        actor = world.spawn_actor(blueprint, world.get_map().get_spawn_points()[0])
    except (RuntimeError, IndexError) as error:
        where = f"{settings['host']}:{settings['port']}"
        raise VehicleLost(f"CARLA at {where}: {' '.join(str(error).split())[:200]}") from None
    if settings["S"]:
        actor.apply_physics_control(with_s(actor.get_physics_control(), settings["S"]))
    return CarlaVehicle(carla, world, actor, float(settings["rear"]), leave)


connect.is_real = False  # type: ignore[attr-defined]  # what the plugin asks of an adapter before it opens it


def with_s(physics: Any, values: Mapping[str, float]) -> Any:
    """CARLA's physics with parameters S of the paper in it: mass [kg], moi [kg m^2], damping rates [kg m^2/s],
    EGO_max_steer_angle [deg] at the front wheels. Raises VehicleLost for another name."""
    for name, value in values.items():
        if name == "EGO_max_steer_angle":
            wheels = physics.wheels
            for wheel in wheels[:2]:
                wheel.max_steer_angle = float(value)
            physics.wheels = wheels  # the package hands out copies
        elif name in PHYSICS:
            setattr(physics, PHYSICS[name], float(value))
        else:
            raise VehicleLost(
                f"S.{name} has no place in CARLA's physics; there is {', '.join(PHYSICS)}, EGO_max_steer_angle"
            )
    return physics


def _read(file: Path) -> dict[str, Any]:
    if not file.is_file():
        raise VehicleLost(f"vehicle carla:{file}: no file {file}; expected carla:FILE.toml, which may be empty")
    try:
        given, _ = read_toml(file)
    except TomlError as error:
        raise VehicleLost(f"vehicle carla:{error.at(file)}: {error}") from None
    for key, value in given.items():
        if key not in KEYS or not isinstance(value, type(KEYS[key])):
            raise VehicleLost(f"{file}: {key} = {value!r}: allowed: {', '.join(KEYS)}, as in {KEYS.get(key, KEYS)!r}")
    return {**KEYS, **given}
