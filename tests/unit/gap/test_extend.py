"""extend: the effect that is added has the truth's value, the error falls on data it was not fitted on, and what
loses there is refused. Logs come from a truth that shares nothing with the model."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Mapping
from functools import cache

import numpy as np
import pytest

from pytest_dvp.gap.extend import extend as extend_module
from pytest_dvp.gap.extend.extend import extend
from pytest_dvp.gap.extend.extension import Extension
from pytest_dvp.gap.words.extension import page, rest
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, ObjectTrack
from tests.truth.effects import REFINED, Effects
from tests.truth.generate import add_noise, make_log
from tests.truth.tracks import make_tracks
from vehicle.model.errors import ModelError
from vehicle.model.model_file import parse_model
from vehicle.model.vehicle_model import VehicleModel

CAR = "[parameters]\nwheelbase = 2.45\ncg_to_front_axle = 1.15\nmass = 1150.0\nyaw_inertia = 1400.0\n"


def model(*effects: tuple[str, str, float]) -> VehicleModel:
    entries = [f'[[effect]]\nname = "{name}"\n[effect.parameters.{key}]\nvalue = {v}\n' for name, key, v in effects]
    return parse_model(CAR + "".join(entries))


@cache
def town(*effects: tuple[str, str, float], seed: int = 1) -> Log:
    """45 s through town of a car with these effects."""
    hidden: Effects = {name: {key: value} for name, key, value in effects}
    return Log(make_log(hidden, "urban", seed))


DELAY = ("steer_delay", "T", 0.2)
BRAKES = ("brake_gain", "g", 0.8)


def logs(**named: Log) -> Mapping[str, Log]:
    return named


@pytest.fixture(scope="module", autouse=True)
def _without_shape() -> Iterator[None]:
    """What a remainder looks like takes nine tenths of an extension, and has tests of its own
    (test_beside_a_remainder.py)."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(extend_module, "with_shape", lambda twin, *more: twin)
        yield


@pytest.fixture(scope="module")
def with_delay() -> Extension:
    """The delay is added on one drive, with another one held out."""
    return extend(logs(a=town(DELAY)), model(), add=["steer_delay"], held_out=logs(b=town(DELAY, seed=2)))


@pytest.fixture(scope="module")
def with_both() -> Extension:
    """Delay and brakes are added on one drive."""
    return extend(logs(a=town(DELAY, BRAKES)), model(), add=["brake_gain", "steer_delay"])


def test_added_effect_has_the_value_of_the_truth_within_its_interval(with_delay: Extension) -> None:
    found = with_delay
    assert found.refusal == ""
    estimate = found.effects[0].parameters["T"]
    assert estimate.value == pytest.approx(0.2, rel=0.02)
    assert estimate.low < 0.2 < estimate.high
    assert found.model.value("steer_delay", "T") == estimate.value
    assert found.model.effects[0].intervals["T"].low == estimate.low


def test_error_falls_to_the_noise_on_data_that_were_not_fitted_on(with_delay: Extension) -> None:
    found = with_delay
    before, after = (rung.step for rung in (found.ladder[0], found.ladder[-1]))
    assert [rung.change for rung in found.ladder] == ["", "+ steer_delay"]
    assert before.held_out_chi2_per_n is not None
    assert before.held_out_chi2_per_n > 2.0
    assert after.held_out_chi2_per_n == pytest.approx(1.0, abs=0.1)
    assert after.held_out_rmse["yaw_rate"] == pytest.approx(0.005, rel=0.1)  # noise of the log's gyroscope
    assert found.explained


def test_two_effects_are_fitted_jointly(with_both: Extension) -> None:
    found = with_both
    assert found.model.value("steer_delay", "T") == pytest.approx(0.2, rel=0.03)
    assert found.model.value("brake_gain", "g") == pytest.approx(0.8, rel=0.03)
    assert [rung.change for rung in found.ladder] == ["", "+ brake_gain", "+ steer_delay"]


def test_error_that_is_left_is_not_called_noise() -> None:
    found = extend(logs(a=town(DELAY, BRAKES)), model(), add=["brake_gain"])
    assert found.refusal == ""
    assert not found.explained


def test_rival_that_explains_the_logs_fitted_on_but_not_the_others_is_no_end() -> None:
    """A steering that lags by 0.1 s looks like one that is 0.1 s late, until it is moved faster than in town."""
    hidden: Effects = {"steer_lag": {"tau": 0.1}}
    slow, fast = Log(make_log(hidden, "urban", 3, "high")), Log(make_log(hidden, "rich", 3, "high"))
    found = extend(logs(a=slow), model(), add=["steer_delay"], held_out=logs(b=fast))
    assert found.refusal == ""
    assert found.ladder[-1].step.chi2_per_n == pytest.approx(1.0, abs=0.1)
    assert not found.explained
    assert "only looks like this one" in rest(found)


@pytest.mark.parametrize(("refit", "delay"), [(False, 0.1), (True, 0.2)])
def test_effects_of_the_model_are_fitted_again_only_if_asked(refit: bool, delay: float) -> None:
    given = model(("steer_delay", "T", 0.1))
    found = extend(logs(a=town(DELAY, BRAKES)), given, add=["brake_gain"], refit=refit)
    assert found.model.value("steer_delay", "T") == pytest.approx(delay, rel=0.03)


def test_effect_that_the_model_has_is_fitted_again_when_it_is_named() -> None:
    found = extend(logs(a=town(DELAY)), model(("steer_delay", "T", 0.1)), add=["steer_delay"])
    assert [(e.name, e.action) for e in found.effects] == [("steer_delay", "change")]
    assert found.model.value("steer_delay", "T") == pytest.approx(0.2, rel=0.03)
    assert len(found.model.effects) == 1


def test_loss_on_held_out_data_is_refused() -> None:
    """The gyroscope's bias of one day is that of no other day."""
    one, other = town(("gyro_bias", "b", 0.02)), town(("gyro_bias", "b", -0.02), seed=2)
    found = extend(logs(a=one), model(), add=["gyro_bias"], held_out=logs(b=other))
    before, after = (rung.step for rung in (found.ladder[0], found.ladder[-1]))
    assert after.chi2_per_n < before.chi2_per_n
    assert found.refused == ("gyro_bias",)
    assert found.refusal.startswith("gyro_bias loses on held-out data, chi²/N ")
    assert "leave it out" in found.refusal
    assert "\n" not in found.refusal


def test_loss_is_found_without_a_held_out_log_too() -> None:
    one, other = town(("gyro_bias", "b", 0.02)), town(seed=2)
    found = extend(logs(a=one, b=other), model(), add=["gyro_bias"])
    assert "gyro_bias loses on held-out data" in found.refusal


@pytest.mark.parametrize(("effect", "why"), [("aero_drag", "too little"), ("understeer", "too little")])
@pytest.mark.nightly(by_day=2)
def test_effect_that_explains_nothing_is_refused_with_what_would_show_it(effect: str, why: str) -> None:
    found = extend(logs(a=town(DELAY)), model(), add=["steer_delay", effect])
    assert found.refused == (effect,)  # not steer_delay, which the sentence names as well
    assert f"{effect} explains {why} beside steer_delay" in found.refusal
    assert "drive what would show it" in found.refusal


def test_effect_that_the_car_lacks_can_be_removed() -> None:
    given = model(DELAY, ("brake_lag", "tau", 0.3))
    found = extend(logs(a=town(DELAY)), given, remove=["brake_lag"], held_out=logs(b=town(DELAY, seed=2)))
    assert found.refusal == ""
    assert [a.name for a in found.model.effects] == ["steer_delay"]
    assert found.ladder[-1].step.chi2_per_n == pytest.approx(1.0, abs=0.1)


def test_effect_that_the_car_has_is_not_removed() -> None:
    found = extend(logs(a=town(DELAY)), model(DELAY), remove=["steer_delay"])
    assert found.refused == ("steer_delay",)
    assert found.refusal.startswith("without steer_delay the error on the data fitted on grows, chi²/N 1")


def test_scale_of_a_normalised_input_is_fitted_along() -> None:
    columns = dict(town(DELAY).columns)
    columns["steer_cmd_norm"] = columns.pop("steer_cmd") / 0.5
    given = parse_model('[inputs]\nsteer = "steer_cmd_norm"\n' + CAR)  # 0.4 rad where nothing is declared
    found = extend(logs(a=Log(columns)), given, add=["steer_delay"])
    assert found.model.inputs.steer_scale == pytest.approx(0.5, rel=0.01)
    assert found.model.value("steer_delay", "T") == pytest.approx(0.2, rel=0.03)


def test_the_new_model_replays_as_the_ladder_says(with_both: Extension) -> None:
    found = with_both
    unexcused = dataclasses.replace(found.model, remainder={})
    again = extend(logs(a=town(DELAY, BRAKES)), unexcused, add=["steer_delay"])
    assert again.ladder[0].step.chi2_per_n == pytest.approx(found.ladder[-1].step.chi2_per_n, rel=0.02)


def test_what_a_twin_is_known_to_leave_is_not_called_noise_of_the_sensors(with_both: Extension) -> None:
    known, unknown = (rest(dataclasses.replace(with_both, excused=excused)) for excused in (True, False))
    assert "is no more than what the twin is known to leave" in known
    assert "is no more than the sensors' noise" in unknown


def test_provenance_is_that_of_what_was_fitted() -> None:
    found = extend(
        logs(a=town(DELAY, BRAKES)), model(DELAY), add=["brake_gain"], fitted_on=["a.csv sha256:00"]
    )  # fmt: skip
    assert [(a.name, a.fitted_on) for a in found.model.effects] == [
        ("steer_delay", ()),
        ("brake_gain", ("a.csv sha256:00",)),
    ]


@pytest.mark.parametrize(
    ("effect", "said"),
    [("steer_dely", "steer_delay"), ("speed_controller", "accel_cmd")],
)
def test_effect_that_cannot_be_fitted_is_one_line(effect: str, said: str) -> None:
    with pytest.raises(ModelError, match=said) as caught:
        extend(logs(a=town(DELAY)), model(), add=[effect])
    assert "\n" not in str(caught.value)


@pytest.mark.nightly
def test_same_logs_give_the_same_model(with_delay: Extension) -> None:
    again = extend(logs(a=town(DELAY)), model(), add=["steer_delay"], held_out=logs(b=town(DELAY, seed=2)))
    assert again.as_dict() == with_delay.as_dict()


@pytest.mark.nightly
def test_values_do_not_depend_on_the_order_in_which_effects_are_added() -> None:
    """Standstill makes the error jump as a brake's gain changes: a fit that stops at such a jump is off."""
    drive = Log(make_log({"steer_delay": {"T": 0.2}, "brake_gain": {"g": 0.8}}, "rich", 1))
    for order in (["steer_delay", "brake_gain"], ["brake_gain", "steer_delay"]):
        found = extend(logs(a=drive), model(), add=order)
        assert found.model.value("brake_gain", "g") == pytest.approx(0.8, abs=0.002)
        assert found.model.value("steer_delay", "T") == pytest.approx(0.2, abs=0.002)


@cache
def with_boxes(latency: float, seed: int) -> Log:
    """Town, with the boxes of a detector that is late and noisy."""
    hidden: Effects = {"detection_latency": {"T": latency}, "detection_noise": {"sigma0": 0.1}}
    tracks = make_tracks(hidden, seed)
    objects = {}
    for name, kind in zip(tracks.names, tracks.kinds, strict=True):
        t, x, y = (np.ascontiguousarray(column) for column in tracks.truth[name].T)
        none = np.zeros(len(t))
        objects[name] = ObjectTrack(kind, 4.0, 1.8, 1.5, t, x, y, none, none, none, none)
    t, _, x, y = (np.ascontiguousarray(column) for column in tracks.detections.T)
    one = np.ones(len(t))
    boxes = DetectionTable(t, ("misc",) * len(t), x, y, 0.0 * one, one, one, 0.0 * one, 0.0 * one)
    return Log(make_log({}, "urban", seed), objects=objects, detections=boxes)


def test_perception_effect_is_added_with_the_value_of_the_detections() -> None:
    found = extend(logs(a=with_boxes(0.2, 1)), model(), add=["detection_latency"], held_out=logs(b=with_boxes(0.2, 2)))
    assert (found.refusal, found.refused, found.notes) == ("", (), ())
    (applied,) = found.model.effects
    assert applied.values["T"] == pytest.approx(0.2, abs=0.01)
    assert applied.intervals["T"].low < 0.2 < applied.intervals["T"].high


@pytest.mark.nightly
def test_perception_effect_that_other_detections_do_not_show_is_refused() -> None:
    found = extend(logs(a=with_boxes(0.2, 1)), model(), add=["detection_latency"], held_out=logs(b=with_boxes(0.0, 2)))
    assert found.refused == ("detection_latency",)
    assert found.refusal.startswith("detection_latency loses on held-out data: T is ")


def test_perception_effect_that_is_not_there_is_refused() -> None:
    found = extend(logs(a=with_boxes(0.0, 1)), model(), add=["detection_latency"])
    assert "the detections of these logs do not show it" in found.refusal
    assert "  + detection_latency: these data give it no value" in page(found).splitlines()


@pytest.mark.nightly
def test_perception_effect_is_removed_where_the_detections_say_so() -> None:
    given = model(("detection_latency", "T", 0.2))
    assert extend(logs(a=with_boxes(0.0, 1)), given, remove=["detection_latency"]).model.effects == ()
    assert extend(logs(a=with_boxes(0.2, 1)), given, remove=["detection_latency"]).refusal.endswith("keep it")


@pytest.mark.nightly
def test_place_of_the_accelerometer_that_fits_better_is_written_and_told() -> None:
    """Where tyres slip it matters: this one sits in the centre of gravity, 1.3 m ahead of the rear axle.

    Differences at 50 Hz blur the yaw acceleration where the car turns in, so the value is not exact.
    """
    columns = make_log({"understeer": {"K": 0.006}}, "rich", 1, "none")
    columns["ay"] = columns["ay"] + 1.3 * np.gradient(columns["yaw_rate"], columns["t"])
    found = extend(logs(a=Log(add_noise(columns, "mid", 1))), model(), add=["understeer"])
    assert found.model.car.ay_x == pytest.approx(1.3)
    assert found.model.value("understeer", "K") == pytest.approx(0.006, rel=0.1)
    assert [note for note in found.notes if note.startswith("[parameters] ay_x is 1.3 in the new model")]


@pytest.mark.parametrize("name", sorted(REFINED) if "DVP_NIGHTLY" in os.environ else sorted(REFINED)[:1])
def test_an_effect_that_a_search_leaves_out_is_fitted_where_it_is_asked_for(name: str) -> None:
    """Fading of a brake, a ratio that changes with speed, a hill: its numbers come back from one rich log."""
    found = extend({"log": Log(make_log({name: REFINED[name]}, "rich", 11))}, model(), add=[name])
    (added,) = found.effects
    assert found.refusal == ""
    assert {key: e.value for key, e in added.parameters.items()} == pytest.approx(REFINED[name], rel=0.05)
