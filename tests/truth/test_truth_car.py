"""The truth simulator against closed forms: what it hides must be what it says."""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np
import pytest

from tests.truth.car import N_STATE, PERIOD, SUBSTEPS, H, V, advance
from tests.truth.effects import (
    CATALOGUE,
    KNOWN,
    OUTSIDE,
    TYRE_EFFECTS,
    Effects,
    FloatArray,
    TruthCar,
    checked,
    parameters,
    typical,
)
from tests.truth.generate import DRIFT_SIGMA, SIGMA, drift, fine_truth, make_log, write_csv
from tests.truth.tracks import TYPICAL, make_tracks

CAR = TruthCar()
STAMPS = slice(None, None, SUBSTEPS)


def drive(effects: Effects, accel: FloatArray, steer: FloatArray, speed: float = 0.0) -> FloatArray:
    """Fine motion under given commands, from `speed` straight ahead."""
    p = parameters(CAR, checked(effects))
    s = np.zeros(N_STATE)
    s[V] = speed
    commands = np.column_stack([accel, steer, np.zeros(len(accel))])
    fine = np.empty((len(accel) * SUBSTEPS, 8))
    for k in range(len(accel)):
        advance(s, p, commands, k, fine[k * SUBSTEPS : (k + 1) * SUBSTEPS])
    return fine


@cache
def clean_rich() -> dict[str, FloatArray]:
    return make_log({}, "rich", 1, "none")


@cache
def urban(body: str) -> dict[str, FloatArray]:
    return make_log({}, "urban", 3, "low", body=body)


def seconds(count: float) -> int:
    return round(count / PERIOD)


def test_without_effects_it_is_the_kinematic_bicycle() -> None:
    n = seconds(4.0)
    fine = drive({}, np.zeros(n), np.full(n, 0.1), speed=5.0)
    rate = 5.0 * math.tan(0.1) / CAR.wheelbase
    assert fine[:, 4] == pytest.approx(rate, rel=1e-9)
    t = len(fine) * H - H
    assert fine[-1, 0] == pytest.approx(5.0 / rate * math.sin(rate * t), rel=1e-7)
    assert fine[-1, 6] == pytest.approx(5.0 * rate, rel=1e-9)


def test_a_delay_is_exact_to_a_part_of_a_step() -> None:
    accel = np.zeros(seconds(1.0))
    accel[seconds(0.2) :] = 2.0
    fine = drive({"drive_delay": {"T": 0.1234}}, accel, np.zeros(len(accel)))
    t_end = (len(fine) - 1) * H
    assert fine[-1, 3] == pytest.approx(2.0 * (t_end - 0.2 - 0.1234), abs=1e-9)


def test_a_lag_answers_as_an_exponential() -> None:
    n = seconds(1.0)
    fine = drive({"drive_lag": {"tau": 0.3}}, np.full(n, 2.0), np.zeros(n))
    t = (len(fine) - 1) * H
    assert fine[-1, 3] == pytest.approx(2.0 * (t - 0.3 * (1.0 - math.exp(-t / 0.3))), rel=1e-5)


def test_a_steering_lag_turns_the_car_late_by_its_time_constant() -> None:
    n = seconds(3.0)
    fine = drive({"steer_lag": {"tau": 0.2}}, np.zeros(n), np.full(n, 0.05), speed=8.0)
    t = (len(fine) - 1) * H
    rate = 8.0 * 0.05 / CAR.wheelbase
    assert fine[-1, 2] == pytest.approx(rate * (t - 0.2), rel=2e-3)


def test_understeer_holds_the_steady_state_of_its_definition() -> None:
    n = seconds(6.0)
    for k in (0.005, -0.001):
        fine = drive({"understeer": {"K": k}}, np.zeros(n), np.full(n, 0.02), speed=10.0)
        v, r = fine[-1, 3], fine[-1, 4]
        assert r == pytest.approx(v * 0.02 / (CAR.wheelbase + k * v * v), rel=2e-3)


def test_compliance_adds_the_understeer_of_the_front_force() -> None:
    n, c = seconds(6.0), 0.008
    fine = drive({"steer_compliance": {"c": c}}, np.zeros(n), np.full(n, 0.03), speed=10.0)
    v, r = fine[-1, 3], fine[-1, 4]
    share = (CAR.wheelbase - CAR.cg_to_front_axle) / CAR.wheelbase
    gradient = c / 1000.0 * CAR.mass * share
    assert r == pytest.approx(v * 0.03 / (CAR.wheelbase + gradient * v * v), rel=3e-3)


def test_saturated_tyres_turn_no_harder_than_their_limit() -> None:
    n = seconds(4.0)
    fine = drive({"tyre_saturation": {"limit": 3.0}}, np.zeros(n), np.full(n, 0.15), speed=11.0)
    assert 2.6 < abs(fine[-1, 4] * fine[-1, 3]) < 3.01


def test_power_over_mass_bounds_speed_times_acceleration() -> None:
    n = seconds(8.0)
    fine = drive({"power_limit": {"limit": 8.0}}, np.full(n, 3.0), np.zeros(n))
    assert np.max(fine[:, 3] * fine[:, 5]) <= 8.0 + 1e-9
    assert fine[-1, 3] * fine[-1, 5] == pytest.approx(8.0, rel=1e-3)


def test_rolling_resistance_stops_the_car_after_v_over_c() -> None:
    n = seconds(12.0)
    fine = drive({"rolling_resistance": {"c": 0.2}}, np.zeros(n), np.zeros(n), speed=2.0)
    assert fine[-1, 0] == pytest.approx(2.0**2 / (2.0 * 0.2), rel=1e-3)
    assert fine[-1, 3] == 0.0


def test_an_accelerometer_feels_the_slope() -> None:
    n = seconds(2.0)
    fine = drive({"road_grade": {"slope": 0.05, "heading": 0.0}}, np.zeros(n), np.zeros(n), speed=6.0)
    pull = 9.80665 * math.sin(0.05)
    assert fine[-1, 3] == pytest.approx(6.0 - pull * (len(fine) - 1) * H, rel=1e-6)
    assert fine[-1, 5] == pytest.approx(0.0, abs=1e-9)


def test_play_swallows_twice_its_half_width_at_a_reversal() -> None:
    there = np.linspace(0.0, 0.05, 100)
    steer = np.concatenate([there, there[::-1]])
    fine = drive({"steer_backlash": {"half_width": 0.01}}, np.zeros(200), steer, speed=2.0)
    wheel = fine[STAMPS, 7]
    assert wheel[99] == pytest.approx(0.04, abs=1e-9)
    assert np.all(wheel[101:135] == wheel[101])
    assert wheel[-1] == pytest.approx(0.01, abs=1e-9)


@pytest.mark.parametrize("name", OUTSIDE)
@pytest.mark.nightly(by_day=2)
def test_an_unknown_effect_shows_in_a_rich_log_and_stays_in_bounds(name: str) -> None:
    base = clean_rich()
    log = make_log({name: typical(name)}, "rich", 1, "none")
    shared = [c for c in SIGMA if c in log]
    assert any(np.max(np.abs(log[c] - base[c])) > SIGMA[c] for c in shared)
    assert all(np.all(np.isfinite(log[c])) for c in log)
    assert np.max(np.abs(log["v"])) < 15.0
    assert np.max(np.abs(log["ay"])) < 9.0


def test_effects_at_their_neutral_values_hide_nothing() -> None:
    """Tyre effects bring the dynamic body along: three of them on tyres that slip, whose neutral car is `body`."""
    neutral = {
        name: {key: off for key, (off, _, _) in KNOWN[name].items()}
        for name in CATALOGUE
        if name not in TYRE_EFFECTS | {"speed_controller"}
    }
    base, log = urban("auto"), make_log(neutral, "urban", 3, "low")
    assert all(np.array_equal(log[c], base[c]) for c in base)
    for name in ("tyre_relaxation", "load_transfer", "yaw_inertia"):
        off = {key: value for key, (value, _, _) in KNOWN[name].items()}
        log = make_log({name: off}, "urban", 3, "low")
        assert all(np.array_equal(log[c], urban("dynamic")[c]) for c in log)


def test_noise_has_its_sigma_and_position_drifts_slowly() -> None:
    for noise, factor in (("low", 0.5), ("mid", 1.0), ("high", 2.0)):
        clean, log = make_log({}, "rich", 5, "none"), make_log({}, "rich", 5, noise)  # type: ignore[arg-type]
        for name, sigma in SIGMA.items():
            step = np.diff(log[name] - clean[name])
            assert np.std(step) / math.sqrt(2.0) == pytest.approx(factor * sigma, rel=0.05), name
    wander = drift(200_000, DRIFT_SIGMA, np.random.default_rng(1))
    assert np.all(np.isfinite(wander))


def test_drift_keeps_its_size_however_long_the_log() -> None:
    wander = drift(400_000, 0.02, np.random.default_rng(2))
    assert np.std(wander) == pytest.approx(0.02, rel=0.25)


def test_a_measurement_is_that_of_its_stamp() -> None:
    log = make_log({}, "rich", 2, "none")
    jump = int(np.argmax(np.abs(np.diff(log["accel_cmd"])))) + 1
    assert log["ax"][jump] == pytest.approx(log["accel_cmd"][jump], abs=1e-6)


def test_same_arguments_give_the_same_bytes() -> None:
    logs = [make_log({"steer_delay": {"T": 0.2}}, "urban", 4, "mid") for _ in range(2)]
    assert all(np.array_equal(logs[0][c], logs[1][c]) for c in logs[0])


def test_seeds_differ_in_noise_and_in_drive() -> None:
    one, two = make_log({}, "urban", 1, "none"), make_log({}, "urban", 2, "none")
    assert np.max(np.abs(one["v"] - two["v"])) > 0.1


def test_the_header_is_that_of_the_blind_cases(tmp_path, shared_dir) -> None:  # type: ignore[no-untyped-def]
    write_csv(tmp_path / "log.csv", make_log({}, "urban", 1))
    with (shared_dir / "blind" / "case_01" / "urban.csv").open() as blind, (tmp_path / "log.csv").open() as ours:
        assert ours.readline() == blind.readline()


def test_a_wrong_name_or_key_is_refused() -> None:
    with pytest.raises(ValueError, match="no truth effect called 'steer_dely'"):
        make_log({"steer_dely": {"T": 0.2}})
    with pytest.raises(ValueError, match="steer_delay has no key 'tau'"):
        make_log({"steer_delay": {"tau": 0.2}})


def test_the_catalogue_and_the_unknown_share_no_name() -> None:
    assert not set(CATALOGUE) & set(OUTSIDE)
    assert len(CATALOGUE) == 53


def test_a_finer_record_of_motion_agrees_with_the_columns() -> None:
    _, fine = fine_truth({"steer_lag": {"tau": 0.2}}, "urban", 1)
    course = np.diff(fine[:, 0]) * np.cos(fine[:-1, 2]) + np.diff(fine[:, 1]) * np.sin(fine[:-1, 2])
    assert course / H == pytest.approx(fine[:-1, 3], abs=0.01)


@pytest.mark.parametrize("name", sorted(TYPICAL))
def test_a_perception_effect_shows_in_the_detections_alone(name: str) -> None:
    base, hit = make_tracks({}, 1), make_tracks({name: TYPICAL[name]}, 1)
    assert base.detections.shape != hit.detections.shape or not np.allclose(base.detections, hit.detections)
    assert np.array_equal(base.ego, hit.ego)
    assert all(np.array_equal(base.truth[n], hit.truth[n]) for n in base.names)


def test_detections_without_effects_are_the_truth() -> None:
    tracks = make_tracks({}, 2)
    for k, name in enumerate(tracks.names):
        seen = tracks.detections[tracks.detections[:, 1] == k]
        assert seen[:, [0, 2, 3]] == pytest.approx(tracks.truth[name])


def test_late_detections_lie_behind_by_speed_times_latency() -> None:
    tracks = make_tracks({"detection_latency": {"T": 0.2}}, 2)
    k = tracks.names.index("oncoming")
    seen = tracks.detections[tracks.detections[:, 1] == k]
    for (t, _, x, _), (t_true, x_true, _) in itertools.islice(zip(seen, tracks.truth["oncoming"], strict=True), 60, 90):
        assert t == t_true
        assert x - x_true == pytest.approx(5.0 * 0.2)
