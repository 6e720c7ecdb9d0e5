"""Perception effects of a model at work: what the LiDAR and the camera of a twin are shown in place of the objects."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import scenarios
from vehicle.adapter import Vehicle
from vehicle.adapters.mirror import Parallel
from vehicle.messages import Surroundings, VehicleState
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import read_model
from vehicle.model.vehicle_model import AppliedEffect
from vehicle.sensors import SensorSuite, default_sensors
from vehicle.sensors.perceived import Perceived
from vehicle.twin import Twin

PERIOD = 0.05  # s between two looks
CAR = (0.0, 0.0, 0.0)  # pose of the ego: x, y [m], yaw [rad]


def scene(*boxes: tuple[float, float, float], kind: int = 0) -> Surroundings:
    """Cars of 4 m x 2 m x 1.5 m at (x, y) [m] that drive on along x at v [m/s]."""
    rows = np.array([[x, y, 0.75, 0.0, 4.0, 2.0, 1.5, v, 0.0] for x, y, v in boxes], dtype=np.float64).reshape(-1, 9)
    return Surroundings(rows, np.full(len(rows), kind, dtype=np.int64), tuple(f"car {k}" for k in range(len(rows))))


def applied(name: str, **values: float) -> AppliedEffect:
    effect = catalogue()[name]
    return AppliedEffect(effect, effect.complete(values))


def looks(
    effects: list[AppliedEffect], seconds: float, *boxes: tuple[float, float, float], seed: int = 1
) -> list[Surroundings]:
    """What is seen of cars that drive on from where they are, at each look."""
    perceived = Perceived(effects, seed)
    return [
        perceived.seen(PERIOD * k, *CAR, scene(*((x + v * PERIOD * k, y, v) for x, y, v in boxes)))
        for k in range(round(seconds / PERIOD))
    ]


def test_without_effects_the_surroundings_are_the_same_object() -> None:
    around = scene((20.0, 0.0, 0.0))
    for effects in ([], [applied("steer_delay", T=0.2)], [applied("detection_misses", rate=0.0)]):
        assert Perceived(effects).seen(0.0, *CAR, around) is around


def test_a_late_car_is_where_it_was() -> None:
    (last,) = looks([applied("detection_latency", T=0.3)], 2.0, (20.0, 0.0, 5.0))[-1].boxes
    assert last[0] == pytest.approx(20.0 + 5.0 * (1.95 - 0.3))
    assert not len(looks([applied("detection_latency", T=0.3)], 0.3, (20.0, 0.0, 5.0))[-1].boxes)


def test_a_car_that_has_come_during_the_drive_is_late_too() -> None:
    perceived = Perceived([applied("detection_latency", T=0.2)])
    shown = [perceived.seen(PERIOD * k, *CAR, scene(*[(20.0, 0.0, 0.0)] * (k >= 10))) for k in range(20)]
    assert [len(s.names) for s in shown] == [0] * 14 + [1] * 6


def test_an_offset_is_in_the_egos_frame() -> None:
    shown = Perceived([applied("detection_offset", x=1.0, y=0.5)]).seen(
        0.0, 0.0, 0.0, math.pi / 2, scene((20.0, 3.0, 0.0))
    )
    assert shown.boxes[0, :2] == pytest.approx([19.5, 4.0])


def test_nothing_is_seen_beyond_the_range() -> None:
    shown = looks([applied("detection_range", R=30.0)], 0.1, (20.0, 0.0, 0.0), (40.0, 0.0, 0.0))[-1]
    assert shown.names == ("car 0",)


def test_misses_are_the_share_of_looks_that_was_asked_for() -> None:
    count = sum(len(s.names) for s in looks([applied("detection_misses", rate=0.3)], 100.0, (20.0, 0.0, 0.0)))
    assert count == pytest.approx(1400, abs=4 * math.sqrt(2000 * 0.21))


def test_misses_grow_with_distance_and_by_class() -> None:
    effect = applied("detection_misses", rate=0.1, slope=0.01, pedestrian=0.3)
    perceived, seen = Perceived([effect]), {"car": 0, "walker": 0}
    for k in range(2000):
        seen["car"] += len(perceived.seen(PERIOD * k, *CAR, scene((20.0, 0.0, 0.0))).names)
    perceived = Perceived([effect])
    for k in range(2000):
        seen["walker"] += len(perceived.seen(PERIOD * k, *CAR, scene((20.0, 0.0, 0.0), kind=1)).names)
    assert seen["car"] == pytest.approx(2000 * (1 - 0.3), abs=90)
    assert seen["walker"] == pytest.approx(2000 * (1 - 0.6), abs=90)


def test_size_and_yaw_change_the_box_about_its_middle() -> None:
    effects = [applied("detection_size", length_ratio=1.5, width_ratio=0.5), applied("detection_yaw", b=0.2)]
    (box,) = looks(effects, 0.1, (20.0, 0.0, 0.0))[-1].boxes
    assert box.tolist() == pytest.approx([20.0, 0.0, 0.75, 0.2, 6.0, 1.0, 1.5, 0.0, 0.0])


def test_a_car_behind_another_is_seen_while_little_of_it_is_hidden() -> None:
    """The nearer car fills the angle atan(1 / 8) to both sides, the one behind it from atan(y - 1 over 28) on."""
    for y, hidden in ((0.0, 1.0), (10.0, 0.0)):
        names = looks([applied("detection_occlusion", share=0.5)], 0.1, (10.0, 0.0, 0.0), (30.0, y, 0.0))[-1].names
        assert len(names) == (1 if hidden > 0.5 else 2)
    half = 30.0 * math.tan(math.atan2(1.0, 8.0))  # its middle is where the edge of the nearer one's shadow is
    for share, count in ((0.3, 1), (0.7, 2)):
        names = looks([applied("detection_occlusion", share=share)], 0.1, (10.0, 0.0, 0.0), (30.0, half, 0.0))[-1].names
        assert len(names) == count


def test_what_the_camera_alone_loses_stays_there_for_the_lidar() -> None:
    both, camera = (
        looks([applied("detection_occlusion", share=0.5, lidar=lidar)], 0.1, (10.0, 0.0, 0.0), (30.0, 0.0, 0.0))[-1]
        for lidar in (1.0, 0.0)
    )
    assert [both.seen_by(sensor).names for sensor in ("lidar", "camera")] == [("car 0",)] * 2
    assert [camera.seen_by(sensor).names for sensor in ("lidar", "camera")] == [("car 0", "car 1"), ("car 0",)]
    clear = looks([applied("detection_occlusion", share=0.5, lidar=0.0)], 0.1, (10.0, 0.0, 0.0), (30.0, 10.0, 0.0))[-1]
    assert clear.hidden == {}


def test_what_a_scenario_hides_stays_hidden_beside_what_the_camera_loses() -> None:
    one = scene((10.0, 0.0, 0.0), (30.0, 0.0, 0.0), (20.0, 15.0, 0.0))
    hidden = {"camera": frozenset({"car 2"}), "lidar": frozenset({"car 0"})}
    around = Surroundings(one.boxes, one.kinds, one.names, hidden=hidden)
    shown = Perceived([applied("detection_occlusion", share=0.5, lidar=0.0)]).seen(0.0, *CAR, around)
    assert shown.hidden == {"camera": frozenset({"car 1", "car 2"}), "lidar": frozenset({"car 0"})}


def test_false_objects_come_at_their_rate_and_stay_a_second() -> None:
    shown = looks([applied("detection_false", rate=0.5)], 400.0)
    boxes = sum(len(s.names) for s in shown)
    assert boxes == pytest.approx(0.5 * 400.0 * 20, rel=4 / math.sqrt(200))
    assert {int(k) for s in shown for k in s.kinds} == {1}
    assert max(math.hypot(b[0], b[1]) for s in shown for b in s.boxes) <= 50.0


def test_an_effect_does_not_shift_the_dice_of_another() -> None:
    alone = looks([applied("detection_misses", rate=0.4)], 5.0, (20.0, 0.0, 0.0))
    both = looks([applied("detection_misses", rate=0.4), applied("detection_false", rate=3.0)], 5.0, (20.0, 0.0, 0.0))
    assert [("car 0" in s.names) for s in alone] == [("car 0" in s.names) for s in both]
    assert len({len(s.names) for s in both}) > 2


def test_hidden_objects_and_fog_stay_what_they_are() -> None:
    around = Surroundings(
        scene((20.0, 0.0, 0.0)).boxes, np.zeros(1, dtype=np.int64), ("car",), hidden={"lidar": frozenset({"car"})},
        extinction=0.01,
    )  # fmt: skip
    shown = Perceived([applied("detection_offset", x=1.0)]).seen(0.0, *CAR, around)
    assert (shown.hidden, shown.extinction, len(shown.seen_by("lidar").names)) == (around.hidden, 0.01, 0)


@pytest.fixture(scope="module")
def tabby() -> Path:
    return Path(scenarios.path("models/tabby_evo.toml"))


def test_the_twins_lidar_meets_a_car_where_the_offset_puts_it(tabby: Path) -> None:
    model, suite = read_model(tabby), default_sensors()
    plain, moved = (nearest(Twin(m, suite)) for m in (model, model.with_effect("detection_offset", {"x": 2.0})))
    assert moved - plain == pytest.approx(2.0, abs=0.1)


def test_the_mirror_shows_virtual_cars_with_the_twins_effects(tabby: Path) -> None:
    cars = [Twin(read_model(tabby), default_sensors()) for _ in range(2)]
    plain, moved = nearest(Parallel(cars[0])), nearest(Parallel(cars[1], 0, [applied("detection_offset", x=2.0)]))
    assert moved - plain == pytest.approx(2.0, abs=0.1)


def nearest(car: Vehicle) -> float:
    """How far ahead of the LiDAR [m] a car that stands 20 m ahead begins."""
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    car.observe(scene((20.0, 0.0, 0.0)))
    car.step(PERIOD)
    scan = car.observe(scene((20.0, 0.0, 0.0))).lidar
    assert scan is not None
    return float(scan.points[:, 0].min())


def test_suite_without_eyes_is_driven_all_the_same(tabby: Path) -> None:
    twin = Twin(read_model(tabby).with_effect("detection_misses", {"rate": 0.5}), SensorSuite())
    assert twin.observe(scene((20.0, 0.0, 0.0))).lidar is None


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_car_on_a_hill_meets_its_false_objects(mirrored: bool, tabby: Path) -> None:
    model = read_model(tabby)
    false = applied("detection_false", rate=50.0)
    twin = Twin(model if mirrored else model.with_effect("detection_false", {"rate": 50.0}), default_sensors())
    car = Parallel(twin, 0, [false]) if mirrored else twin
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0, z=120.0))
    twin.place_on_road(120.0)
    met = 0
    for _ in range(20):
        scan = car.observe(scene()).lidar
        met += 0 if scan is None else len(scan.points)
        car.step(PERIOD)
    assert met > 100
