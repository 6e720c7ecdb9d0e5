"""Logs set up for trying: residuals in units of the noise."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from gap_logs import NOISE, baseline, drive

from pytest_dvp.gap.compare.compared_model import CompareError
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose.experiment import Experiment, ExperimentSet, Values, _without_settling, experiment_set
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import parse_model

WEAK = {("drive_gain", "g"): 0.85}


@pytest.fixture(scope="module")
def one() -> ExperimentSet:
    return experiment_set({"one": drive(drive_gain=0.85)}, baseline())


@pytest.fixture(scope="module")
def two() -> ExperimentSet:
    logs = {"one": drive(drive_gain=0.85), "two": drive(30.0, drive_gain=0.85, noise=2.0, seed=2)}
    return experiment_set(logs, baseline())


def test_the_true_values_leave_one_unit_of_noise(one: ExperimentSet) -> None:
    r = one.whitened(WEAK)
    assert float(r @ r) / one.count == pytest.approx(1.0, abs=0.08)
    for name, chi2 in one.by_channel(WEAK).items():
        assert chi2 == pytest.approx(1.0, abs=0.2), name


def test_without_the_effect_far_more_is_left_where_it_shows(one: ExperimentSet) -> None:
    left = one.by_channel({})
    assert left["v"] > 10.0
    assert left["yaw_rate"] < 1.2  # no one turns the wheel while accelerating


def test_every_sample_of_every_channel_is_judged(one: ExperimentSet) -> None:
    """60 s at 50 Hz, seven channels; what the start of each segment takes out is at most four numbers a segment."""
    segments = len(one.starts())
    assert one.channels == tuple(name for name in CHANNELS if name in NOISE)
    assert 7 * 3000 * 0.8 <= one.count <= 7 * 3000
    assert 10 <= segments <= 14  # of about 5 s


def test_the_noise_of_several_logs_is_that_of_each(two: ExperimentSet) -> None:
    quiet, loud = two.experiments
    for name, sigma in NOISE.items():
        k = CHANNELS.index(name)
        assert quiet.sigma[k] == pytest.approx(sigma, rel=0.12), name
        assert loud.sigma[k] == pytest.approx(2.0 * sigma, rel=0.15), name
        assert two.noise()[name] == pytest.approx(sigma * np.sqrt(2.5), rel=0.15), name


def test_several_logs_are_one_after_the_other(two: ExperimentSet, one: ExperimentSet) -> None:
    first, second = (e.whitened(WEAK) for e in two.experiments)
    assert np.array_equal(two.whitened(WEAK), np.concatenate([first, second]))
    assert two.count == sum(e.count for e in two.experiments)
    assert two.experiments[0].count == one.count


def test_the_segments_share_out_the_sum_of_squares(two: ExperimentSet) -> None:
    r = two.whitened({})
    shares = two.by_segment(r)
    assert len(shares) == len(two.starts())
    assert float(shares.sum()) == pytest.approx(float(r @ r))


def test_rmse_is_in_the_unit_of_the_channel(one: ExperimentSet) -> None:
    found = one.rmse(WEAK)
    assert found["v"] == pytest.approx(NOISE["v"], rel=0.05)
    assert found["yaw_rate"] == pytest.approx(NOISE["yaw_rate"], rel=0.05)


def test_a_channel_of_which_nothing_is_judged_has_no_error(one: ExperimentSet) -> None:
    """0 would read as a perfect prediction."""
    (e,) = one.experiments
    nothing = SimpleNamespace(values=np.full((50, len(CHANNELS)), np.nan))
    unjudged = SimpleNamespace(channels=e.channels, residuals=lambda values: nothing)
    assert ExperimentSet((unjudged,)).rmse(WEAK) == {}  # type: ignore[arg-type]
    assert ExperimentSet((e, unjudged)).rmse(WEAK) == one.rmse(WEAK)  # type: ignore[arg-type]


def test_small_steps_of_integration_change_next_to_nothing(one: ExperimentSet) -> None:
    """Piecewise constant acceleration and angle: what differs between 20 ms and 2 ms is far below the noise."""
    change = one.exact(WEAK) - one.whitened(WEAK)
    assert float(change @ change) / one.count < 1e-3


def test_settling_moves_starts_to_where_the_model_would_have_been() -> None:
    target = experiment_set({"one": drive(drive_gain=0.85)}, baseline())
    before = target.whitened(WEAK)
    target.settle(WEAK)
    settled = target.whitened(WEAK)
    assert float(settled @ settled) <= float(before @ before) * 1.02
    target.settle(WEAK)
    again = target.whitened(WEAK)
    assert float(again @ again) == pytest.approx(float(settled @ settled), rel=1e-3)


def test_effects_that_the_model_does_not_have_are_off(one: ExperimentSet) -> None:
    neutral = {
        (e.name, k.name): k.neutral for e in catalogue().values() if e.slot != "perception" for k in e.parameters
    }
    kinematic = {key: value for key, value in neutral.items() if not catalogue()[key[0]].tyres}
    assert np.allclose(one.whitened(kinematic), one.whitened({}), atol=1e-9)


def test_a_lost_sample_is_not_judged() -> None:
    log = drive()
    v = log.columns["v"].copy()
    v[500:600] = np.nan
    whole, part = (
        experiment_set({"a": log}, baseline()),
        experiment_set({"a": Log({**log.columns, "v": v})}, baseline()),
    )
    rows = part.whitened({}).reshape(-1, len(CHANNELS))
    assert not rows[500:600, CHANNELS.index("v")].any()
    assert whole.count - 8 * 200 <= part.count < whole.count


def test_where_the_command_jumps_either_acceleration_is_right() -> None:
    """One logger samples before the jump, another after it; no physics is missing in either."""
    log = drive(drive_gain=0.85)
    accel, ax = log.columns["accel_cmd"], log.columns["ax"].copy()
    jumps = np.flatnonzero(np.abs(np.diff(accel, prepend=accel[:1])) > 1.0)
    assert len(jumps) >= 10
    ax[jumps] = ax[jumps - 1]
    early = experiment_set({"a": Log({**log.columns, "ax": ax})}, baseline())
    assert early.by_channel(WEAK)["ax"] == pytest.approx(1.0, abs=0.1)
    assert early.by_channel({})["ax"] > 2.0  # what is weak still shows


def test_a_missing_input_is_said() -> None:
    columns = {name: values for name, values in drive().columns.items() if name != "accel_cmd"}
    with pytest.raises(CompareError, match="accel_cmd"):
        experiment_set({"a": Log(columns)}, baseline())


def test_a_motion_asked_for_again_is_kept_until_the_segments_begin_elsewhere() -> None:
    e = experiment_set({"one": drive(drive_gain=0.85)}, baseline()).experiments[0]
    asked: list[object] = []
    machine = e.machine

    class Counted:
        def run(self, values: Values | None = None, **starts: Any) -> FloatArray:
            asked.append(values)
            return machine.run(values, **starts)

    e.machine = Counted()
    first = e.motion(WEAK)
    assert e.motion(dict(WEAK)) is first
    assert e.motion({}) is not first
    assert len(asked) == 2
    before = e.segments
    e.settle(WEAK)
    assert not np.array_equal(e.motion(WEAK), first, equal_nan=True)
    e.segments = before
    assert np.array_equal(e.motion(WEAK), first, equal_nan=True)
    assert len(asked) == 4


@pytest.mark.parametrize(("change", "settles"), [(0.05, False), (0.15, True), (-0.15, True)])
def test_a_turn_does_not_count_just_after_a_start_amid_its_change(change: float, settles: bool) -> None:
    """change: rad/s^2 of the yaw rate; the first start is the log's own."""
    t = np.arange(0.0, 10.0, 0.02)
    measured = np.ones((len(t), 8))
    measured[:, 4] = change * t
    found = _without_settling(measured, t, np.array([0, 250]))
    gone = np.isnan(found)
    assert gone.sum() == (2 * 10 if settles else 0)  # 0.2 s of two channels
    assert not gone[:, [0, 1, 2, 3, 5, 7]].any()
    if settles:
        assert set(np.flatnonzero(gone[:, 4])) == set(np.flatnonzero(gone[:, 6])) == set(range(250, 260))
    assert np.isfinite(measured).all()  # the log itself is left as it is


@pytest.mark.parametrize(("known", "settles"), [(3, True), (2, False)])
def test_two_rows_around_a_start_say_nothing_of_a_change(known: int, settles: bool) -> None:
    """At 0.15 s a row there are three within 0.2 s, and here the yaw rate of one of them is not known."""
    t = 0.15 * np.arange(40)
    measured = np.ones((len(t), 8))
    measured[:, 4] = 0.5 * t
    measured[19, 4] = measured[19, 4] if known == 3 else np.nan
    found = _without_settling(measured, t, np.array([0, 20]))
    assert np.isnan(found[20:, 4]).sum() == (2 if settles else 0)  # at 0 and 0.15 s


def test_a_road_is_flat_to_a_model_that_is_told_the_speed() -> None:
    told = parse_model("[model]\nname = 'car'\n[inputs]\nlongitudinal = 'v'\n[parameters]\nwheelbase = 2.5\n")
    assert Experiment("one", drive(8.0, hills=0.5), told).slopes == 0.0
