"""A LiDAR detector of the user's own as an ONNX model, run by onnxruntime (extra `onnx`)."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ads.perception.lidar import BOX
from ads.transforms import sensor_frames
from vehicle.messages import OBJECT_KINDS, FloatArray, LidarScan, VehicleDescription


class DetectorError(ValueError):
    """A model that cannot be used; the message is one line and says what is expected."""


class OnnxDetector:
    """Finds boxes in a scan by a model with one input and at least one output.

    Input: points, float32 (n, 3) of x, y, z [m] in the sensor frame, n free. First output: boxes, float32 (k, 7) of
    x, y [m], yaw [rad], length, width [m], kind (index into messages.OBJECT_KINDS, -1 unknown), score [0, 1] in the
    sensor frame. Boxes below `least_score`, or with a number that is none, are left out. One thread, so that the same
    scan gives the same bytes.

    Raises: DetectorError if onnxruntime is not installed, or the file is no such model.
    """

    def __init__(self, model: Path | str, car: VehicleDescription, least_score: float = 0.5) -> None:
        try:
            import onnxruntime as ort
        except ImportError:
            raise DetectorError(
                "an ONNX detector needs onnxruntime: pip install -e '.[onnx]' from the checkout"
            ) from None
        if not Path(model).is_file():
            raise DetectorError(f"{model}: no such file")
        options = ort.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.use_deterministic_compute = True
        options.log_severity_level = 3
        try:
            self._session = ort.InferenceSession(str(model), options, providers=["CPUExecutionProvider"])
        except Exception as error:  # onnxruntime has a class of its own for each way a file can be wrong
            raise DetectorError(f"{model}: not an ONNX model: {str(error).splitlines()[0]}") from error
        inputs, outputs = self._session.get_inputs(), self._session.get_outputs()
        for what, given, columns in (("input", inputs, 3), ("output", outputs, BOX)):
            if not given or given[0].type != "tensor(float)" or not _fits(given[0].shape, columns):
                shown = f"{given[0].type} {given[0].shape}" if given else "none"
                raise DetectorError(f"{model}: {what} is {shown}, expected tensor(float) (n, {columns})")
        if len(inputs) != 1:
            raise DetectorError(f"{model}: {len(inputs)} inputs, expected 1, the points")
        self._file, self._input, self._output = model, inputs[0].name, outputs[0].name
        self._mount, self._least = sensor_frames(car)["lidar"], least_score

    def boxes(self, scan: LidarScan) -> FloatArray:
        """Boxes (k, BOX) of a scan in the base frame: x, y [m], yaw [rad], length, width [m], kind, score (0 to 1).

        Raises DetectorError if the model returns another shape.
        """
        points = np.ascontiguousarray(scan.points, dtype=np.float32).reshape(-1, 3)
        found = np.asarray(self._session.run([self._output], {self._input: points})[0], dtype=np.float64)
        if not _fits(found.shape, BOX):
            raise DetectorError(f"{self._file}: returned {found.shape}, expected (k, {BOX})")
        found = found[np.isfinite(found).all(axis=1) & (found[:, 6] >= self._least)]
        found[:, :2] = self._mount.apply(found[:, :2])
        found[:, 2] = (found[:, 2] + self._mount.yaw) % (2.0 * math.pi)
        found[:, 3:5] = np.maximum(found[:, 3:5], 0.0)
        known = (found[:, 5] >= 0.0) & (found[:, 5] < len(OBJECT_KINDS))
        found[:, 5] = np.where(known, np.floor(found[:, 5]), -1.0)
        found[:, 6] = np.minimum(found[:, 6], 1.0)
        return found


def _fits(shape: object, columns: int) -> bool:
    """Whether a shape is (anything, `columns`); a model may leave the second open."""
    sizes = list(shape) if isinstance(shape, list | tuple) else []
    return len(sizes) == 2 and (not isinstance(sizes[1], int) or sizes[1] == columns)
