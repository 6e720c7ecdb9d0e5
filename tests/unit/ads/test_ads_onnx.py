"""ONNX hook: a model made here that boxes the middle of all points; what a wrong model is told."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from ads_loop import TABBY

from ads.localization import Estimate
from ads.parameters import Parameters
from ads.perception.onnx_detector import DetectorError, OnnxDetector
from ads.perception.pipeline import TrackingPerception
from vehicle.messages import LidarScan, Observation

pytest.importorskip("onnxruntime", reason="extra `onnx` is not installed")
onnx = pytest.importorskip("onnx", reason="package onnx, which makes the model, is not installed")

SEEN = (0.4, 4.4, 1.8, 0.0, 0.9)  # yaw, length, width, kind, score of the model's box


def made(folder: Path, tail: tuple[float, ...] = SEEN, columns: int = 3, rows: int = 1) -> Path:
    """A model: mean of the points' x and y, then `tail`; `rows` equal boxes."""
    helper, F = onnx.helper, onnx.TensorProto.FLOAT
    nodes = [
        helper.make_node("ReduceMean", ["points"], ["middle"], axes=[0], keepdims=1),
        helper.make_node("Slice", ["middle", "from", "to", "axis"], ["xy"]),
        helper.make_node("Concat", ["xy", "tail"], ["one"], axis=1),
        helper.make_node("Tile", ["one", "times"], ["boxes"]),
    ]
    ints = {"from": [0], "to": [2], "axis": [1], "times": [rows, 1]}
    constants = [helper.make_tensor(name, onnx.TensorProto.INT64, [len(v)], v) for name, v in ints.items()]
    constants.append(helper.make_tensor("tail", F, [1, len(tail)], tail))
    graph = helper.make_graph(
        nodes, "middle of all", [helper.make_tensor_value_info("points", F, ["n", columns])],
        [helper.make_tensor_value_info("boxes", F, ["k", 2 + len(tail)])], constants,
    )  # fmt: skip
    file = folder / "middle.onnx"
    onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9), file)
    return file


def scan(t: float, x: float, y: float) -> LidarScan:
    """Four points around a place in the sensor frame."""
    return LidarScan(t, np.array([(x + dx, y + dy, -0.8) for dx in (-1.0, 1.0) for dy in (-0.5, 0.5)]))


def test_the_models_box_is_moved_from_the_sensor_to_the_base(tmp_path):
    (box,) = OnnxDetector(made(tmp_path), TABBY).boxes(scan(0.0, 12.0, 3.0))
    assert box == pytest.approx([12.0 + TABBY.lidar_x, 3.0, *SEEN], abs=1e-5)


def test_its_boxes_are_fused_and_tracked_with_kind_size_and_velocity(tmp_path):
    perception = TrackingPerception(Parameters(), TABBY, detector=OnnxDetector(made(tmp_path), TABBY))
    found = ()
    for k in range(20):
        t = 0.1 * k
        estimate = Estimate(t, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.01)
        found = perception.update(
            Observation(t, lidar=scan(t, 12.0 + 5.0 * t * math.cos(0.4), 5.0 * t * math.sin(0.4))), estimate
        )
    (d,) = found
    assert (d.kind, d.length, d.width) == ("vehicle", pytest.approx(4.4), pytest.approx(1.8))
    assert (d.x, d.y) == pytest.approx((12.0 + TABBY.lidar_x + 9.5 * math.cos(0.4), 9.5 * math.sin(0.4)), abs=0.2)
    assert (d.vx, d.vy) == pytest.approx((5.0 * math.cos(0.4), 5.0 * math.sin(0.4)), abs=0.3)


@pytest.mark.parametrize(
    ("tail", "left"),
    [
        ((0.0, 4.0, 2.0, 0.0, 0.49), 0),  # less sure than asked for
        ((math.nan, 4.0, 2.0, 0.0, 0.9), 0),
        ((0.0, 4.0, 2.0, 17.0, 0.9), 1),  # a kind that there is not: unknown
    ],
)
def test_what_is_unsure_or_no_number_is_left_out(tmp_path, tail, left):
    boxes = OnnxDetector(made(tmp_path, tail), TABBY).boxes(scan(0.0, 10.0, 0.0))
    assert len(boxes) == left
    assert all(box[5] == -1.0 for box in boxes)


def test_the_same_scan_gives_the_same_bytes(tmp_path):
    detector = OnnxDetector(made(tmp_path, rows=3), TABBY)
    one = scan(0.0, 11.3, -2.7)
    assert detector.boxes(one).tobytes() == detector.boxes(one).tobytes()
    assert len(detector.boxes(one)) == 3


class TestWrongModels:
    def test_a_missing_file(self, tmp_path):
        with pytest.raises(DetectorError, match=r"none\.onnx: no such file"):
            OnnxDetector(tmp_path / "none.onnx", TABBY)

    def test_a_file_that_is_no_model(self, tmp_path):
        (tmp_path / "text.onnx").write_text("hello")
        with pytest.raises(DetectorError, match=r"text\.onnx: not an ONNX model: .+"):
            OnnxDetector(tmp_path / "text.onnx", TABBY)

    def test_points_of_four_columns(self, tmp_path):
        with pytest.raises(
            DetectorError, match=r"input is tensor\(float\) \['n', 4\], expected tensor\(float\) \(n, 3\)"
        ):
            OnnxDetector(made(tmp_path, columns=4), TABBY)

    def test_boxes_of_six_columns(self, tmp_path):
        with pytest.raises(DetectorError, match=r"output is .*, expected tensor\(float\) \(n, 7\)"):
            OnnxDetector(made(tmp_path, tail=(0.0, 4.0, 2.0, 0.0)), TABBY)

    def test_without_the_extra_it_says_what_to_install(self, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "onnxruntime", None)
        with pytest.raises(DetectorError, match=r"pip install -e '\.\[onnx\]' from the checkout"):
            OnnxDetector(made(tmp_path), TABBY)
