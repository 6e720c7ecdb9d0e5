"""The stack as a whole: replaceable parts, trace, determinism, what it may import."""

from __future__ import annotations

import ast
import itertools
import math
from pathlib import Path

import pytest
from ads_loop import TABBY, Car, drive, new_stack, observe
from ads_plane import PlaneMap
from ads_traffic import SeeingAll, parked

import ads
from ads.planning.nets import NETS
from vehicle.messages import Observation, RoadPoint, SignalState, Task

ALLOWED = ("ads", "vehicle.messages", "openscenario.road", "machine_code", "numpy", "daqp")


def test_before_the_first_fix_it_neither_brakes_nor_accelerates():
    command = new_stack(PlaneMap([(100.0, 0.0)])).tick(Observation(0.0))
    assert (command.steer, command.accel, command.throttle, command.brake) == (0.0, 0.0, 0.0, 0.0)


def test_the_planned_path_is_one_object_until_it_changes():
    stack, paths = new_stack(PlaneMap([(300.0, 0.0)]), perception=SeeingAll([parked(70.0)])), []
    drive(stack, Car(TABBY, 5.0, -1.75, 0.0, 5.0), 40.0, Task(goal=RoadPoint("1", -1, 150.0)),
          watch=lambda t, car: paths.append(stack.path))  # fmt: skip
    changes = sum(a is not b for a, b in itertools.pairwise(paths))
    assert 2 <= changes <= 40
    assert paths[-1].shape[1] == 2


def test_the_trace_has_the_estimate_and_every_place():
    stack = new_stack(PlaneMap([(100.0, 0.0)]))
    stack.tick(observe(Car(TABBY, 5.0, -1.75, 0.0, 5.0), 0.0))
    assert {"x", "y", "yaw", "v", "path_error", "target_speed"} <= set(stack.trace)
    assert {f"net.{net.name}.{place}" for net in NETS for place in net.places} <= set(stack.trace)
    assert stack.trace["net.main.drive"] == 1.0


def test_what_the_map_holds_ahead_is_published_with_the_signals_state():
    stack = new_stack(PlaneMap([(300.0, 0.0)], crosswalk_at=80.0, signal_at=60.0))
    assert stack.view is None
    car = Car(TABBY, 5.0, -1.75, 0.0, 5.0)
    stack.tick(observe(car, 0.0, signals=(SignalState("lamp", "red"),)))
    stack.tick(observe(car, 0.05))
    assert [(s.id, s.state) for s in stack.view.signals] == [("lamp", "red")]
    assert stack.view.signals[0].distance == pytest.approx(55.0, abs=0.3)
    assert stack.view.crossings[0].distance == pytest.approx(73.5, abs=0.3)


def test_the_same_observations_give_the_same_commands():
    def run():
        stack = new_stack(PlaneMap([(300.0, 0.0)]), perception=SeeingAll([parked(70.0)]))
        return drive(stack, Car(TABBY, 5.0, -1.75, 0.0, 5.0), 20.0).rows

    assert run() == run()


def test_a_part_can_be_replaced():
    class Straight:
        def steer(self, estimate, path, index):
            return 0.0

    stack = new_stack(PlaneMap([(20.0, 0.0), (30.0, 0.05)]), steering=Straight())
    log = drive(stack, Car(TABBY, 5.0, -1.75, 0.0, 5.0), 8.0)
    assert all(row[6] == 0.0 for row in log.rows)


def test_every_command_is_finite_and_within_the_cars_limits():
    stack = new_stack(PlaneMap([(40.0, 0.0), (25.0, 1 / 12), (80.0, 0.0)]), perception=SeeingAll([parked(30.0, -0.5)]))
    car = Car(TABBY, 2.0, -3.2, 0.3, 6.0)
    for k in range(300):
        command = stack.tick(observe(car, k * 0.05))
        assert abs(command.steer) <= TABBY.max_steer
        assert 0.0 <= command.throttle <= 1.0
        assert 0.0 <= command.brake <= 1.0
        assert math.isfinite(command.accel)
        car.step(command.steer, command.accel)


@pytest.mark.parametrize("file", sorted(Path(ads.__file__).parent.rglob("*.py")), ids=lambda f: f.stem)
def test_the_stack_sees_messages_and_the_map_only(file):
    for node in ast.walk(ast.parse(file.read_text())):
        names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
        for name in names:
            ours = name.split(".")[0] in ("ads", "vehicle", "openscenario", "machine_code", "pytest_dvp", "reports")
            assert not ours or name.startswith(ALLOWED), f"{file.name} imports {name}"
