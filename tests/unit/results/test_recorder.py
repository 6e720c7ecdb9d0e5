"""LogRecorder: ticks and rows in, a Log out."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.logs.recorder import LogRecorder
from vehicle.messages import TRACE_COLUMNS, Command, Detection, Surroundings


def rows(start: float, count: int = 5) -> np.ndarray:
    table = np.zeros((count, len(TRACE_COLUMNS)))
    table[:, 0] = start + 0.01 * np.arange(1, count + 1)
    return table


def surroundings(*boxes: tuple[str, float, int]) -> Surroundings:
    table = np.zeros((len(boxes), 9))
    table[:, 4:7] = 1.0
    table[:, 0] = [x for _, x, _ in boxes]
    kinds = np.array([kind for _, _, kind in boxes], dtype=np.int64)
    return Surroundings(table, kinds, tuple(name for name, _, _ in boxes))


def test_command_holds_from_its_tick_to_the_next() -> None:
    recorder = LogRecorder()
    for tick in (0, 1):
        t = 0.05 * tick
        recorder.tick(t, command=Command(t, 0.1 * (tick + 1), 1.0, 0.5, 0.0))
        recorder.ego_rows(rows(t))
    log = recorder.finish()
    # rows at 0.01 ... 0.10 s; the second command is given at 0.05 s
    assert log["steer_cmd"].tolist() == [0.1] * 4 + [0.2] * 6


def test_what_changes_between_ticks_holds_from_its_own_time_on() -> None:
    recorder = LogRecorder()
    for t, value in ((0.03, 1.0), (0.05, 2.0), (0.07, 3.0)):
        recorder.hold(t, {"gate.steer_cmd": value})
    recorder.tick(0.0)
    recorder.ego_rows(rows(0.0, 8))  # 0.01 ... 0.08 s
    values = recorder.finish()["gate.steer_cmd"]
    assert np.isnan(values[:2]).all()
    assert values[2:].tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]


def test_quantity_is_not_measured_before_its_first_tick() -> None:
    recorder = LogRecorder()
    recorder.ego_rows(rows(-0.05))
    recorder.tick(0.05, ads={"v": 3.0})
    recorder.ego_rows(rows(0.05))
    values = recorder.finish()["ads.v"]
    assert np.isnan(values[:5]).all()
    assert values[5:].tolist() == [3.0] * 5


def test_rounding_of_the_tick_time_does_not_delay_a_command() -> None:
    recorder = LogRecorder()
    recorder.ego_rows(rows(0.29, 1))  # 0.30 s
    recorder.tick(0.1 + 0.2, held={"on_road": 1.0})  # 0.30000000000000004 s
    assert recorder.finish()["on_road"].tolist() == [1.0]


def test_trace_of_the_stack_may_change_its_names() -> None:
    recorder = LogRecorder()
    recorder.tick(0.0, ads={"a": 1.0})
    recorder.ego_rows(rows(0.0))
    recorder.tick(0.05, ads={"a": 2.0, "b": 5.0})
    recorder.ego_rows(rows(0.05))
    log = recorder.finish()
    assert np.isnan(log["ads.b"][0])
    assert log["ads.b"][-1] == 5.0


def test_objects_come_and_go() -> None:
    recorder = LogRecorder()
    recorder.tick(0.00, surroundings=surroundings(("car", 1.0, 0)))
    recorder.tick(0.05, surroundings=surroundings(("car", 2.0, 0), ("walker", 9.0, 1)))
    recorder.tick(0.10, surroundings=surroundings(("walker", 8.0, 1)))
    objects = recorder.finish().objects
    assert {name: track.t.tolist() for name, track in objects.items()} == {"car": [0.0, 0.05], "walker": [0.05, 0.1]}
    assert objects["car"].x.tolist() == [1.0, 2.0]
    assert objects["walker"].kind == "pedestrian"


def test_arrays_that_the_caller_reuses_are_copied() -> None:
    recorder = LogRecorder()
    around, trace = surroundings(("car", 1.0, 0)), rows(0.0)
    recorder.tick(0.0, surroundings=around)
    recorder.ego_rows(trace)
    around.boxes[:] = 99.0
    trace[:] = 99.0
    log = recorder.finish()
    assert log.objects["car"].x.tolist() == [1.0]
    assert log.t[-1] == pytest.approx(0.05)


def test_path_is_recorded_when_it_changes() -> None:
    recorder = LogRecorder()
    first, second = np.zeros((3, 2)), np.ones((4, 4))
    for t, path in ((0.0, first), (0.05, first), (0.10, second)):
        recorder.tick(t, path=path)
    paths = recorder.finish().paths
    assert [(t, points.shape) for t, points in paths] == [(0.0, (3, 2)), (0.10, (4, 2))]


def test_detections_are_a_table() -> None:
    recorder = LogRecorder()
    box = Detection(0.0, "pedestrian", 5.0, 1.0, 0.2, 0.6, 0.5, 0.0, -2.0)
    recorder.tick(0.05, detections=(box, box))
    table = recorder.finish().detections
    assert table.t.tolist() == [0.05, 0.05]
    assert table.kind == ("pedestrian", "pedestrian")
    assert table.vy.tolist() == [-2.0, -2.0]


def test_run_that_broke_off_at_once_is_a_log_without_rows() -> None:
    recorder = LogRecorder({"stage": "dt"})
    recorder.event(0.0, "fault", "ZeroDivisionError")
    log = recorder.finish()
    assert len(log.t) == 0
    assert log.events[0].kind == "fault"
