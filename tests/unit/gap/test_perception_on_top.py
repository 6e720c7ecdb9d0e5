"""What a perception effect must be worth in a model so that its own run, through the same tracker, shows the car's."""

from __future__ import annotations

import dataclasses
from math import inf
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.gap.extend.perception import judge_perception
from pytest_dvp.gap.perception.diagnose_perception import diagnose_perception, perceived_in
from pytest_dvp.gap.perception.fresh_detections import fresh, measured_only
from pytest_dvp.gap.perception.on_top import on_top
from pytest_dvp.gap.perception.perceived_values import Perceived
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, FloatArray, ObjectTrack
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import read_model
from vehicle.model.vehicle_model import VehicleModel


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> VehicleModel:
    path: Path = tmp_path_factory.mktemp("model") / "model.toml"
    path.write_text('[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.45\nmass = 1150.0\n')
    return read_model(path)


def shown(**values: float) -> Perceived:
    """Values by effect and key, written effect__key, of intervals without width."""
    return Perceived({(n.partition("__")[0], n.partition("__")[2]): (v, v, v) for n, v in values.items()}, {}, {})


@pytest.mark.parametrize(
    ("key", "car", "twin", "has", "needs"),
    [
        ("detection_latency__T", 0.25, 0.02, 0.0, 0.23),  # dead times add up
        ("detection_latency__T", 0.25, 0.22, 0.2, 0.23),
        ("detection_offset__x", 0.5, -0.1, 0.0, 0.6),
        ("detection_range__R", 35.0, 80.0, inf, 35.0),  # the twin's own range is none of its model's
        ("detection_range__R", 35.0, 33.0, 34.0, 36.0),
        ("detection_range__R", inf, 33.0, 34.0, inf),
        ("detection_misses__rate", 0.64, 0.1, 0.0, 0.6),  # 0.4 seen of the 0.9 that the twin sees: 0.36
        ("detection_false__rate", 0.4, 0.2, 0.3, 0.6),  # the tracker lets two thirds through
        ("detection_yaw__b", 0.08, 0.0, 0.0, 0.08),
        ("detection_yaw__b", 0.15, 0.05, 0.1, 0.3),
        ("detection_noise__sigma0", 0.5, 0.3, 0.0, 0.4),  # 0.5^2 = 0.3^2 + 0.4^2
        ("detection_noise__sigma0", 0.1, 0.3, 0.0, 0.0),
        # the tracker lets half of it through, so the variances 0.25 + 0.16 - 0.04 = 0.37 are less than the ratio says
        ("detection_noise__sigma0", 0.4, 0.2, 0.5, 1.0),
        ("detection_noise__sigma0", 0.2, 0.4, 0.5, 0.25),
        ("detection_noise__sigma0", 0.5, 0.4, 0.1, 0.31622776601683794),  # 0.01 + 0.25 - 0.16: more than the ratio
    ],
)
def test_the_trackers_share_is_taken_out(
    model: VehicleModel, key: str, car: float, twin: float, has: float, needs: float
) -> None:
    name, _, parameter = key.partition("__")
    given = model.with_effect(name, {parameter: has})
    value = on_top(shown(**{key: car}), shown(**{key: twin}), given).values[name, parameter][0]
    assert value == pytest.approx(needs)


def test_intervals_of_both_runs_count(model: VehicleModel) -> None:
    car = Perceived({("detection_latency", "T"): (0.25, 0.22, 0.28)}, {}, {})
    twin = Perceived({("detection_latency", "T"): (0.05, 0.01, 0.09)}, {}, {})
    assert on_top(car, twin, model).values["detection_latency", "T"] == pytest.approx((0.2, 0.15, 0.25))


def table(t: FloatArray, track: FloatArray, vx: FloatArray, vy: FloatArray | None = None) -> DetectionTable:
    n = len(t)
    zero = np.zeros(n)
    return DetectionTable(t, ("vehicle",) * n, zero, zero, zero, zero, zero, vx, zero if vy is None else vy, track)


def test_a_row_with_the_velocity_of_the_one_before_is_only_moved_on() -> None:
    t = np.repeat([0.0, 0.05, 0.1, 0.15], 2)
    track = np.tile([1.0, 2.0], 4)
    vx = np.array([5.0, 3.0, 5.0, 3.1, 5.2, 3.1, 5.2, 3.2])
    assert fresh(table(t, track, vx)).tolist() == [True, True, False, True, True, False, False, True]


def test_a_velocity_across_counts_against_that_of_the_row_before_as_well() -> None:
    """It comes back to its first value in the last row but one: that was measured, and the last row was not."""
    t, vy = np.arange(6) * 0.05, np.array([1.0, 2.0, 2.0, 3.0, 1.0, 1.0])
    assert fresh(table(t, np.ones(6), np.full(6, 5.0), vy)).tolist() == [True, True, False, True, True, False]


def test_without_numbers_or_with_velocities_that_never_change_all_rows_count() -> None:
    t, still = np.arange(4) * 0.05, np.zeros(4)
    for boxes in (table(t, np.full(4, np.nan), still), table(t, np.ones(4), still)):
        assert measured_only(boxes) is boxes


def test_a_rounded_velocity_that_stays_does_not_make_a_measured_row_a_moved_on_one() -> None:
    """A tracker that moved on is at v dt from the row before; a measurement beside it was seen, whatever its speed."""
    t, track = np.arange(5) * 0.1, np.ones(5)
    vx, zero = np.array([5.0, 5.0, 5.0, 5.0, 6.0]), np.zeros(5)
    x = np.array([0.0, 0.53, 1.03, 1.46, 2.1])  # the third alone is 0.5 m on
    boxes = DetectionTable(t, ("vehicle",) * 5, x, zero, zero, zero, zero, vx, zero, track)
    assert fresh(boxes).tolist() == [True, True, False, True, True]
    aside = DetectionTable(t, ("vehicle",) * 5, 5.0 * t, 0.02 * (np.arange(5) % 2), zero, zero, zero, vx, zero, track)
    assert fresh(aside).all()  # as far on, but 2 cm to a side


def street(misses: float = 0.0, ratio: tuple[float, float] = (1.0, 1.0), turn: float = 0.0) -> Log:
    """A drive of 40 s past six parked cars, seen at 10 Hz; the boxes carry numbers of tracks, a missed one is moved on.

    ratio: of length and width; turn: of the boxes [rad].
    """
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 40.0, 0.05)
    columns = {"t": t, "x": 3.0 * t, "y": 0.0 * t, "yaw": 0.0 * t}
    nought, objects = np.zeros(len(t)), {}
    for k in range(6):
        at = np.full(len(t), 25.0 + 20.0 * k)
        objects[f"car {k}"] = ObjectTrack(
            "vehicle", 4.0, 1.8, 1.5, t, at, nought + 4.0, nought, nought, nought, nought
        )  # fmt: skip
    rows = []
    for k, object_ in enumerate(objects.values()):
        speed = 0.0
        for i in range(0, len(t), 2):
            if np.hypot(object_.x[i] - columns["x"][i], 4.0) > 50.0 or object_.x[i] < columns["x"][i] + 2.0:
                continue
            if rng.random() >= misses:
                speed = float(rng.normal(0.0, 0.01))
            wide = rng.normal(1.0, 0.01)
            rows.append((t[i], object_.x[i], 4.0, turn, 4.0 * ratio[0] * wide, 1.8 * ratio[1], speed, float(k)))
    t_, x, y, yaw, length, width, vx, track = np.array(rows).T
    boxes = DetectionTable(t_, ("vehicle",) * len(t_), x, y, yaw, length, width, vx, np.zeros(len(t_)), track)
    order = np.argsort(boxes.t, kind="stable")
    arrays = {f.name: getattr(boxes, f.name) for f in dataclasses.fields(boxes) if f.name not in ("kind",)}
    return Log(columns, objects=objects, detections=DetectionTable(
        kind=boxes.kind, **{n: v[order] for n, v in arrays.items() if v is not None}
    ))  # fmt: skip


def test_a_tracker_that_bridges_misses_does_not_hide_them() -> None:
    seen = perceived_in(street(misses=0.4))
    assert seen is not None
    assert seen.values["detection_misses", "rate"][0] == pytest.approx(0.4, abs=0.05)


def test_size_and_yaw_are_told_by_the_boxes(model: VehicleModel) -> None:
    found = {e.name: e for e in diagnose_perception(street(ratio=(1.3, 0.8), turn=0.15), model)}
    size = found["detection_size"].parameters
    assert size["length_ratio"].value == pytest.approx(1.3, abs=0.02)
    assert size["width_ratio"].value == pytest.approx(0.8, abs=0.02)
    assert found["detection_yaw"].parameters["b"].value == pytest.approx(0.15, abs=0.01)


def test_a_box_turned_by_half_a_turn_is_the_same_box(model: VehicleModel) -> None:
    assert "detection_yaw" not in {e.name for e in diagnose_perception(street(turn=np.pi), model)}


def test_the_border_of_occlusion_is_where_boxes_end_to_be_seen(model: VehicleModel) -> None:
    """A wall of 4 m to the left of the way hides a car behind it more and more, and less again."""
    t = np.arange(0.0, 40.0, 0.1)
    nought = np.zeros(len(t))
    columns = {"t": t, "x": 0.5 * t, "y": nought, "yaw": nought}

    def parked(x: float, y: float) -> ObjectTrack:
        return ObjectTrack("vehicle", 4.0, 1.8, 1.5, t, nought + x, nought + y, nought, nought, nought, nought)

    objects = {"near": parked(25.0, 4.0), **{f"far {k}": parked(34.0 + 5.0 * k, 8.0 + 0.5 * k) for k in range(3)}}
    from vehicle.model.occlusion import hidden_share
    from vehicle.model.perception_effects import Tracks

    n, k = len(t), len(objects)
    x, y = (np.tile([getattr(o, c)[0] for o in objects.values()], n) for c in ("x", "y"))
    none = np.zeros(n * k)
    share = hidden_share(Tracks(
        np.repeat(t, k), np.tile(np.arange(k), n), x, y, none, none, none, np.repeat(0.5 * t, k), none, none,
        none + 4.0, none + 1.8,
    ))  # fmt: skip
    assert (share > 0.6).sum() > 50
    rows = np.flatnonzero(share <= 0.4)
    boxes = DetectionTable(
        np.repeat(t, k)[rows], ("vehicle",) * len(rows), x[rows], y[rows], *(np.zeros(len(rows)) for _ in range(5))
    )  # fmt: skip
    found = {e.name: e for e in diagnose_perception(Log(columns, objects=objects, detections=boxes), model)}
    assert found["detection_occlusion"].parameters["share"].value == pytest.approx(0.4, abs=0.05)


def test_an_extended_model_gets_the_value_beside_the_twins_run(model: VehicleModel) -> None:
    """The twin's own boxes are 1.1 times as long: of 1.3 in the car's log the model needs 0.2."""
    car = dataclasses.replace(street(ratio=(1.3, 1.0)), meta={"stage": "rw-surrogate", "scenario": "street.xosc"})
    twin = dataclasses.replace(street(ratio=(1.1, 1.0)), meta={"stage": "dt", "scenario": "street.xosc"})
    size = find_effect("detection_size")
    (alone,) = judge_perception(model, {"car": car}, {}, [size], [])
    assert "do not show it" in alone.wrong
    (taken,) = judge_perception(model, {"car": car}, {}, [size], [], {"street.xosc": twin})
    assert not taken.wrong
    assert taken.effect.parameters["length_ratio"].value == pytest.approx(1.2, abs=0.02)
