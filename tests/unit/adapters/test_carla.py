"""CARLA's frame and its car, against the objects of its own package; no server is asked."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openscenario.road.network import load_network
from tests.unit.vehicle.test_bridge import old_interpreters
from vehicle.adapter import Vehicle, VehicleLost
from vehicle.adapters.carla import CarlaVehicle, connect, with_s
from vehicle.messages import Command, VehicleState, no_surroundings
from vehicle.wire import carla_frame as frame

carla: Any = pytest.importorskip("carla", reason="needs the extra carla")

URBAN = Path(__file__).parents[3] / "scenarios" / "urban.xodr"
YAWS = [0.0, 0.4, math.pi / 2, -2.0, 3.0]


@pytest.mark.parametrize("yaw", YAWS)
def test_ahead_and_left_are_where_carla_has_ahead_and_minus_right(yaw: float) -> None:
    """CARLA's own matrix of the transform is asked; its y is ours with the other sign."""
    place = frame.to_carla(10.0, 5.0, 0.5, yaw, rear=0.8)
    transform = carla.Transform(carla.Location(x=place.x, y=place.y, z=place.z), carla.Rotation(yaw=place.yaw))
    ahead, right = transform.get_forward_vector(), transform.get_right_vector()
    assert (ahead.x, -ahead.y) == pytest.approx((math.cos(yaw), math.sin(yaw)), abs=1e-6)
    assert (-right.x, right.y) == pytest.approx((-math.sin(yaw), math.cos(yaw)), abs=1e-6)
    axle = transform.transform(carla.Location(x=-0.8, y=0.0, z=0.0))  # 0.8 m behind the origin
    assert (axle.x, -axle.y, axle.z) == pytest.approx((10.0, 5.0, 0.5), abs=1e-5)
    assert frame.from_carla(place, rear=0.8) == pytest.approx((10.0, 5.0, 0.5, yaw))


@pytest.mark.parametrize("yaw", YAWS)
def test_a_velocity_is_turned_into_the_body(yaw: float) -> None:
    """3 m/s ahead and 1 m/s to the left, in CARLA's world."""
    x = 3.0 * math.cos(yaw) - 1.0 * math.sin(yaw)
    y = 3.0 * math.sin(yaw) + 1.0 * math.cos(yaw)
    assert frame.body_vector(x, -y, yaw) == pytest.approx((3.0, 1.0))


def test_steering_is_the_share_of_the_lock_to_the_right() -> None:
    lock = math.radians(70.0)
    assert frame.to_steer(math.radians(7.0), lock) == pytest.approx(-0.1)
    assert frame.to_steer(-2.0, lock) == 1.0
    assert frame.from_steer(-0.1, lock) == pytest.approx(math.radians(7.0))
    assert frame.yaw_rate(-90.0) == pytest.approx(math.pi / 2)


def test_parameters_s_are_set_in_carlas_physics() -> None:
    physics = carla.VehiclePhysicsControl()
    physics.wheels = [carla.WheelPhysicsControl() for _ in range(4)]
    rear = physics.wheels[2].max_steer_angle
    with_s(physics, {"EGO_mass": 730.0, "EGO_moi": 0.75, "EGO_dr_full_throttle": 0.2, "EGO_max_steer_angle": 25.0})
    assert (physics.mass, physics.moi, physics.damping_rate_full_throttle) == pytest.approx((730.0, 0.75, 0.2))
    assert [wheel.max_steer_angle for wheel in physics.wheels] == pytest.approx([25.0, 25.0, rear, rear])
    with pytest.raises(VehicleLost, match=r"^S\.EGO_colour has no place in CARLA's physics"):
        with_s(physics, {"EGO_colour": 1.0})


class World:
    """Stands in for a server: an actor that goes on straight with the speed it was given; writes down every call."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.transform, self.velocity, self.control = carla.Transform(), carla.Vector3D(), carla.VehicleControl()
        self.bounding_box = carla.BoundingBox(carla.Location(x=0.1), carla.Vector3D(x=1.5, y=0.7, z=0.8))

    def tick(self, patience: float) -> None:
        self.calls.append("tick")
        at = self.transform.location
        self.transform.location = carla.Location(x=at.x + 0.01 * self.velocity.x, y=at.y + 0.01 * self.velocity.y)

    def get_physics_control(self) -> Any:
        physics = carla.VehiclePhysicsControl()
        physics.mass = 730.0
        physics.wheels = [carla.WheelPhysicsControl(max_steer_angle=angle) for angle in (50.0, 50.0, 0.0, 0.0)]
        return physics

    def set_transform(self, transform: Any) -> None:
        self.calls.append("set_transform")
        self.transform = transform

    def set_target_velocity(self, velocity: Any) -> None:
        self.calls.append("set_target_velocity")
        self.velocity = velocity

    def apply_control(self, control: Any) -> None:
        self.calls.append("apply_control")
        self.control = control

    def get_transform(self) -> Any:
        return self.transform

    def get_velocity(self) -> Any:
        return self.velocity

    def get_acceleration(self) -> Any:
        return carla.Vector3D()

    def get_angular_velocity(self) -> Any:
        return carla.Vector3D()


def test_a_tick_of_the_harness_is_five_of_the_server() -> None:
    world = World()
    car = CarlaVehicle(carla, world, world, rear=0.8)
    assert isinstance(car, Vehicle)
    assert not car.is_real
    car.reset(VehicleState(t=0.0, x=10.0, y=5.0, yaw=0.5, v=4.0))
    car.apply(Command(0.0, math.radians(5.0), 1.0, 0.3, 0.0))
    rows = car.step(0.05)
    assert world.calls == ["set_transform", "set_target_velocity", "apply_control", *["tick"] * 5]
    assert (world.control.steer, world.control.throttle) == pytest.approx((-0.1, 0.3))
    assert rows[:, 0] == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05])
    assert rows[-1, 1:3] == pytest.approx([10.0 + 0.2 * math.cos(0.5), 5.0 + 0.2 * math.sin(0.5)], abs=1e-4)
    assert rows[-1, [4, 5, 11]] == pytest.approx([0.5, 4.0, math.radians(5.0)], abs=1e-5)
    seen = car.observe(no_surroundings())
    assert [one.v for one in seen.odometry] == pytest.approx([4.0] * 5, abs=1e-5)
    assert seen.gnss[0].yaw == pytest.approx(0.5, abs=1e-5)


def test_the_brake_takes_the_throttle_away() -> None:
    world = World()
    car = CarlaVehicle(carla, world, world, rear=0.8)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=4.0))
    car.apply(Command(0.0, 0.0, 2.0, 1.0, 0.25))
    assert (world.control.throttle, world.control.brake) == (0.0, 0.25)


def test_its_road_reader_and_ours_agree_on_every_lane() -> None:
    """CARLA's map of the same file: each of its waypoints lies on our road, lane and s, to a few millimetres."""
    network = load_network(URBAN)
    theirs = carla.Map("urban", URBAN.read_text(encoding="utf-8"))
    apart: list[float] = []
    lanes: set[tuple[int, int]] = set()
    for point in theirs.generate_waypoints(10.0):
        ours = network.lane_pose(str(point.road_id), point.lane_id, point.s)
        at = point.transform.location
        apart.append(math.hypot(ours.x - at.x, ours.y + at.y))
        lanes.add((point.road_id, point.lane_id))
    of_cars = re.findall(r'<lane id="-?\d+" type="driving"', URBAN.read_text(encoding="utf-8"))
    assert len(lanes) == len(of_cars)
    assert np.max(apart) < 0.01


def test_without_a_server_it_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vehicle.adapters.carla.PATIENCE", 0.2)
    file = tmp_path / "carla.toml"
    file.write_text("port = 1\n")
    with pytest.raises(VehicleLost, match=r"^CARLA at 127\.0\.0\.1:1: ") as lost:
        connect(str(file))
    assert "\n" not in str(lost.value)
    file.write_text("prot = 1\n")
    with pytest.raises(VehicleLost, match=r"carla\.toml: prot = 1: allowed: host, port"):
        connect(str(file))


SCRIPTED = """
import math


class Thing:
    def __init__(self, **given):
        self.__dict__.update(given)


def made(**defaults):
    return lambda **given: Thing(**dict(defaults, **given))


Location = Vector3D = made(x=0.0, y=0.0, z=0.0)
Rotation = made(pitch=0.0, yaw=0.0, roll=0.0)
VehicleControl = made(throttle=0.0, steer=0.0, brake=0.0)


def Transform(location=None, rotation=None):
    return Thing(location=location or Location(), rotation=rotation or Rotation())


class World:
    def __init__(self):
        self.settings = Thing(synchronous_mode=False, fixed_delta_seconds=None)
        self.transform, self.velocity, self.broken = Transform(), Vector3D(), False
        self.bounding_box = Thing(location=Location(x=0.1), extent=Vector3D(x=1.5, y=0.7, z=0.8))
        self.physics = Thing(mass=900.0, wheels=[Thing(max_steer_angle=angle) for angle in (70.0, 70.0, 0.0, 0.0)])

    def tick(self, patience):
        if self.velocity.x > 90.0:
            raise RuntimeError("time-out of 10000ms while waiting\\nfor the simulator")
        at = self.transform.location
        self.transform.location = Location(x=at.x + 0.01 * self.velocity.x, y=at.y + 0.01 * self.velocity.y)

    def get_settings(self):
        return self.settings

    def apply_settings(self, settings):
        self.settings = settings

    def get_blueprint_library(self):
        return self

    def find(self, name):
        return Thing(name=name)

    def get_map(self):
        return self

    def get_spawn_points(self):
        return [Transform()]

    def spawn_actor(self, blueprint, place):
        return self

    def get_physics_control(self):
        return self.physics

    def apply_physics_control(self, physics):
        self.physics = physics

    def set_transform(self, transform):
        self.transform = transform

    def set_target_velocity(self, velocity):
        self.velocity = velocity

    def apply_control(self, control):
        self.control = control

    def get_transform(self):
        return self.transform

    def get_velocity(self):
        return self.velocity

    def get_acceleration(self):
        return Vector3D()

    def get_angular_velocity(self):
        return Vector3D()

    def destroy(self):
        pass


class Client(World):
    def __init__(self, host, port):
        World.__init__(self)
        self.port = port

    def set_timeout(self, seconds):
        pass

    def get_world(self):
        if self.port == 1:
            raise RuntimeError("no server")
        return self
"""


@pytest.fixture
def bridged(tmp_path: Path) -> Callable[..., CarlaVehicle]:
    """Opens a scripted server's module that only the interpreter of a bridge finds; the oldest one that is here."""
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "carla.py").write_text(SCRIPTED)
    python = next(iter(old_interpreters()), sys.executable)

    def opened(**more: object) -> CarlaVehicle:
        given = {"python": python, "path": [str(tmp_path / "far")], **more}
        text = "\n".join(f"{key} = {json.dumps(value)}" for key, value in given.items())
        (tmp_path / "carla.toml").write_text(f"{text}\n[S]\nEGO_mass = 730.0\nEGO_max_steer_angle = 50.0\n")
        return connect(str(tmp_path / "carla.toml"))

    return opened


def test_over_a_bridge_it_is_driven_as_without_one(bridged: Callable[..., CarlaVehicle]) -> None:
    """The numbers of the tick above; mass and lock are those of S."""
    car = bridged()
    try:
        assert car.description.mass == 730.0
        assert car.description.max_steer == pytest.approx(math.radians(50.0))
        car.reset(VehicleState(t=0.0, x=10.0, y=5.0, yaw=0.5, v=4.0))
        car.apply(Command(0.0, math.radians(5.0), 1.0, 0.3, 0.0))
        rows = car.step(0.05)
        assert rows[:, 0] == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05])
        assert rows[-1, 1:3] == pytest.approx([10.0 + 0.2 * math.cos(0.5), 5.0 + 0.2 * math.sin(0.5)], abs=1e-6)
        assert rows[-1, [4, 5, 11]] == pytest.approx([0.5, 4.0, math.radians(5.0)], abs=1e-6)
        car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=95.0))
        with pytest.raises(VehicleLost, match=r"^CARLA did not tick: time-out of 10000ms while waiting for the simul"):
            car.step(0.05)
    finally:
        car.close()
        car.close()


def test_over_a_bridge_what_is_missing_is_one_line(bridged: Callable[..., CarlaVehicle]) -> None:
    with pytest.raises(VehicleLost, match=r"^CARLA at 127\.0\.0\.1:1: no server$"):
        bridged(port=1)
    if old_interpreters():  # this one has it
        with pytest.raises(VehicleLost, match=r"^the bridge to CARLA: \S+ lacks a module: No module named 'carla'$"):
            bridged(path=[])
    with pytest.raises(VehicleLost, match=r"^the bridge to CARLA's process cannot be started: /no/python: No such"):
        bridged(python="/no/python")
