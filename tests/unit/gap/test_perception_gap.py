"""Perception effects hidden in object tracks are named with their values."""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.diagnosis import NamedEffect
from pytest_dvp.gap.perception.diagnose_perception import diagnose_perception, diagnose_perceptions, perceived_in
from pytest_dvp.gap.perception.position_fit import _clustered
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, ObjectTrack, no_detections
from tests.truth.effects import Effects
from tests.truth.tracks import TYPICAL, make_tracks
from vehicle.model.model_file import read_model
from vehicle.model.vehicle_model import VehicleModel


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> VehicleModel:
    path: Path = tmp_path_factory.mktemp("perception") / "model.toml"
    path.write_text('[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.45\nmass = 1150.0\n')
    return read_model(path)


def with_detections(effects: Effects, seed: int = 1) -> Log:
    names = tuple(sorted(effects))
    return _log(names, tuple(tuple(sorted(effects[n].items())) for n in names), seed)


@cache
def _log(names: tuple[str, ...], values: tuple[tuple[tuple[str, float], ...], ...], seed: int) -> Log:
    tracks = make_tracks({name: dict(pairs) for name, pairs in zip(names, values, strict=True)}, seed)
    columns = {name: np.ascontiguousarray(tracks.ego[:, k]) for k, name in enumerate(("t", "x", "y", "yaw"))}
    objects = {}
    for name, kind in zip(tracks.names, tracks.kinds, strict=True):
        t, x, y = (np.ascontiguousarray(column) for column in tracks.truth[name].T)
        none = np.zeros(len(t))
        objects[name] = ObjectTrack(kind, 4.0, 1.8, 1.5, t, x, y, none, none, none, none)
    t, _, x, y = (np.ascontiguousarray(column) for column in tracks.detections.T)
    one = np.ones(len(t))
    boxes = DetectionTable(t, ("misc",) * len(t), x, y, 0.0 * one, one, one, 0.0 * one, 0.0 * one)
    return Log(columns, objects=objects, detections=boxes)


def named(effects: tuple[NamedEffect, ...]) -> set[str]:
    return {e.name for e in effects}


@pytest.mark.parametrize("hidden", list(TYPICAL))
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.nightly)])
def test_single_effect_is_named_alone(model: VehicleModel, hidden: str, seed: int) -> None:
    (found,) = diagnose_perception(with_detections({hidden: TYPICAL[hidden]}, seed), model)
    assert (found.name, found.action, found.gain) == (hidden, "add", 1.0)
    assert set(found.parameters) == set(TYPICAL[hidden])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_nothing_is_named_for_a_perfect_detector(model: VehicleModel, seed: int) -> None:
    assert diagnose_perception(with_detections({}, seed), model) == ()


def test_all_effects_at_once_are_told_apart(model: VehicleModel) -> None:
    found = diagnose_perception(with_detections(TYPICAL), model)
    assert named(found) == set(TYPICAL)
    assert sum(e.gain for e in found) == pytest.approx(1.0)


@pytest.mark.nightly
def test_intervals_hold_the_truth(model: VehicleModel) -> None:
    """95 % intervals of 8 values on 8 drives: fewer than 54 of 64 have a probability below 0.001."""
    held = []
    for seed in range(1, 9):
        for e in diagnose_perception(with_detections(TYPICAL, seed), model):
            for key, estimate in e.parameters.items():
                held.append(estimate.low <= TYPICAL[e.name][key] <= estimate.high)
    assert len(held) == 64
    assert sum(held) >= 54


def test_latency_is_exact_without_noise(model: VehicleModel) -> None:
    (found,) = diagnose_perception(with_detections({"detection_latency": {"T": 0.27}}), model)
    assert found.parameters["T"].value == pytest.approx(0.27, abs=0.003)


@pytest.mark.parametrize("age", [1.2, 2.5])
def test_a_latency_that_takes_objects_farther_than_a_gate_is_found(model: VehicleModel, age: float) -> None:
    (found,) = diagnose_perception(with_detections({"detection_latency": {"T": age}}), model)
    assert found.name == "detection_latency"
    assert found.parameters["T"].value == pytest.approx(age, abs=0.01)


def test_latency_of_objects_that_stand_is_not_told(model: VehicleModel) -> None:
    log = with_detections({"detection_offset": {"x": 0.4, "y": 0.0}})
    parked = {"parked": log.objects["parked"]}
    own = np.hypot(log.detections.x - 52.0, log.detections.y) < 1.0
    (found,) = diagnose_perception(dataclasses.replace(seen_where(log, own), objects=parked), model)
    assert found.name == "detection_offset"
    assert found.rivals == ("detection_latency",)


def test_frames_in_which_nothing_was_seen_count_as_missed(model: VehicleModel) -> None:
    (found,) = diagnose_perception(with_detections({"detection_misses": {"rate": 0.45}}), model)
    assert found.parameters["rate"].value == pytest.approx(0.45, abs=0.05)


def test_value_that_the_model_has_is_not_named(model: VehicleModel) -> None:
    log = with_detections({"detection_latency": {"T": 0.2}})
    assert diagnose_perception(log, model.with_effect("detection_latency", {"T": 0.2})) == ()
    (other,) = diagnose_perception(log, model.with_effect("detection_latency", {"T": 0.3}))
    assert (other.name, other.action) == ("detection_latency", "change")


def test_effect_that_only_the_model_has_is_to_be_removed(model: VehicleModel) -> None:
    (found,) = diagnose_perception(with_detections({}), model.with_effect("detection_range", {"R": 30.0}))
    assert (found.name, found.action) == ("detection_range", "remove")


def test_twin_is_compared_by_its_own_detections(model: VehicleModel) -> None:
    measured = with_detections({"detection_range": {"R": 35.0}, "detection_offset": {"x": 0.4, "y": -0.3}})
    twin = with_detections({"detection_range": {"R": 35.0}}, seed=2)
    assert named(diagnose_perception(measured, model, twin=twin)) == {"detection_offset"}


def test_detections_of_the_twin_itself_are_no_gap(model: VehicleModel) -> None:
    """Simulated cameras and LiDARs have a range, too: only against another twin's run do they tell something."""
    log = with_detections({"detection_range": {"R": 35.0}})
    own = dataclasses.replace(log, meta={"stage": "dt"})
    assert diagnose_perception(own, model) == ()
    assert diagnose_perception(dataclasses.replace(log, meta={"stage": "rw-surrogate"}), model) == ()
    assert named(diagnose_perception(own, model, twin=with_detections({}))) == {"detection_range"}


def test_each_run_is_compared_with_the_twin_in_its_scenario(model: VehicleModel) -> None:
    late = with_detections({"detection_latency": {"T": 0.2}})
    runs = [
        dataclasses.replace(late, meta={"stage": "rw-surrogate", "scenario": name}) for name in ("a.xosc", "b.xosc")
    ]
    assert named(diagnose_perceptions(runs, model, {"b.xosc": with_detections({})})) == {"detection_latency"}
    assert named(diagnose_perceptions(runs, model, {"b.xosc": late})) == set()
    assert named(diagnose_perceptions(runs, model)) == set()


@pytest.mark.parametrize("lacking", ["detections", "objects"])
def test_log_without_tracks_has_no_answer(model: VehicleModel, lacking: str) -> None:
    log = with_detections({"detection_latency": {"T": 0.2}})
    bare = dataclasses.replace(log, **({"objects": {}} if lacking == "objects" else {"detections": no_detections()}))
    assert diagnose_perception(bare, model) == ()


def test_effect_that_two_logs_show_is_named_once(model: VehicleModel) -> None:
    logs = [with_detections(TYPICAL, seed) for seed in (1, 2)]
    found = diagnose_perceptions(logs, model)
    assert sorted(e.name for e in found) == sorted(TYPICAL)
    widths = [e.parameters["T"].high - e.parameters["T"].low for log in logs for e in diagnose_perception(log, model)
              if e.name == "detection_latency"]  # fmt: skip
    (latency,) = (e for e in found if e.name == "detection_latency")
    assert latency.parameters["T"].high - latency.parameters["T"].low == min(widths)


def test_a_false_object_that_stays_counts_once(model: VehicleModel) -> None:
    """6 of them, each of them 3 s in view: 30 boxes each."""
    log = with_detections({})
    table = log.detections
    stamps = np.unique(table.t)
    length = len(stamps) * 0.1  # s
    t = np.concatenate([stamps[k : k + 30] for k in range(20, 370, 60)])
    assert len(t) == 6 * 30
    x, y = np.interp(t, log.t, log.columns["x"]) + 8.0, np.interp(t, log.t, log.columns["y"]) - 25.0
    one = np.ones(len(t))
    boxes = DetectionTable(
        np.concatenate([table.t, t]), (*table.kind, *("misc",) * len(t)),
        *(np.concatenate([getattr(table, name), added]) for name, added in
          (("x", x), ("y", y), ("yaw", 0.0 * one), ("length", one), ("width", one), ("vx", 0.0 * one),
           ("vy", 0.0 * one))),
    )  # fmt: skip
    (found,) = diagnose_perception(dataclasses.replace(log, detections=boxes), model)
    assert found.name == "detection_false"
    assert found.parameters["rate"].value == pytest.approx(6.0 / length)
    assert found.parameters["rate"].unit == "1/s"


def seen_where(log: Log, keep: np.ndarray) -> Log:
    """The log with only those of its detections."""
    return dataclasses.replace(log, detections=log.detections.rows(keep))


def distance(log: Log) -> np.ndarray:
    """From the ego to each detection [m]."""
    table = log.detections
    ego = [np.interp(table.t, log.t, log.columns[name]) for name in ("x", "y")]
    return np.hypot(table.x - ego[0], table.y - ego[1])


def test_objects_that_are_hidden_in_between_show_no_range(model: VehicleModel) -> None:
    """Nothing is seen from 40 to 60 m, and all beyond: something stood in the way, the detector reaches farther."""
    log = with_detections({})
    far = distance(log)
    hidden = seen_where(log, (far < 40.0) | (far > 60.0))
    found = perceived_in(hidden)
    assert found is not None
    reach, low, high = found.values["detection_range", "R"]
    assert (reach, high) == (np.inf, np.inf)
    assert low == pytest.approx(far.max(), abs=1.0)
    assert "detection_range" not in named(diagnose_perception(hidden, model))


def test_a_border_that_one_object_alone_has_crossed_is_known_to_two_metres(model: VehicleModel) -> None:
    """Twin and car see the same oncoming car 2.5 m sooner or later: one moment of one object tells no range."""
    log = with_detections({})
    objects = {name: log.objects[name] for name in ("parked", "oncoming")}
    ahead = objects["parked"].x > np.interp(objects["parked"].t, log.t, log.columns["x"])  # 52 m away at most
    objects["parked"] = dataclasses.replace(
        objects["parked"],
        **{f.name: values[ahead] for f in dataclasses.fields(ObjectTrack)
           if isinstance(values := getattr(objects["parked"], f.name), np.ndarray)},
    )  # fmt: skip
    last = objects["parked"].t[-1]
    table = log.detections
    to = {name: np.hypot(table.x - np.interp(table.t, o.t, o.x), table.y - np.interp(table.t, o.t, o.y))
          for name, o in objects.items()}  # fmt: skip
    far = distance(log)
    runs = [
        dataclasses.replace(
            seen_where(log, ((to["parked"] < 0.5) & (table.t <= last)) | ((to["oncoming"] < 0.5) & (far < reach))),
            objects=objects,
        )
        for reach in (60.0, 62.5, 75.0)
    ]
    for run, reach in zip(runs, (60.0, 62.5, 75.0), strict=True):
        found = perceived_in(run)
        assert found is not None
        value, low, high = found.values["detection_range", "R"]
        assert value == pytest.approx(reach, abs=0.6)
        assert (value - low, high - value) == pytest.approx((2.0, 2.0))
    assert named(diagnose_perception(runs[1], model, twin=runs[0])) == set()
    assert named(diagnose_perception(runs[2], model, twin=runs[0])) == {"detection_range"}


def test_with_few_independent_blocks_intervals_are_students(model: VehicleModel) -> None:
    """Of 10 s of one object there are two or three blocks: 12.7 or 4.3 standard deviations, not 1.96."""
    log = with_detections({"detection_noise": {"sigma0": 0.3}})
    table = log.detections
    start = float(table.t[0])
    parked = {"parked": log.objects["parked"]}
    own = (np.hypot(table.x - 52.0, table.y) < 2.0) & (table.t < start + 10.0)
    short = perceived_in(dataclasses.replace(seen_where(log, own), objects=parked))
    assert short is not None
    _, low, high = short.values["detection_offset", "x"]
    assert high - low > 2 * 4.3 * 0.3 / np.sqrt(own.sum())
    assert low < 0.0 < high


def test_what_stays_wrong_of_an_object_widens_as_much_as_few_objects_do() -> None:
    """Four objects, each wrong by half a metre in ten rows: a mean known to 0.5 / sqrt(3), not to 0.5 / sqrt(39)."""
    wrong = np.repeat([0.5, -0.5, 0.5, -0.5], 10)[:, None]
    rows, objects = np.arange(40), np.repeat(np.arange(4), 10)
    bread = np.array([[1.0 / 40.0]])
    assert _clustered(bread, wrong, rows) == pytest.approx(0.5 / np.sqrt(39.0))
    assert _clustered(bread, wrong, rows, objects) == pytest.approx(0.5 / np.sqrt(3.0))
