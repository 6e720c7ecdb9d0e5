"""Segments: a wrong start is taken out, an effect is not."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from gap_logs import NOISE, baseline, drive

from pytest_dvp.gap.compare.segments import (
    CHANNELS,
    Residuals,
    Segments,
    cut,
    measured_array,
    posed,
    residuals,
    restarted,
)
from pytest_dvp.logs.log import Log
from vehicle.model.open_loop import Replay

SIGMA = np.array([*NOISE.values(), np.inf])


def judged(log: Log, shift: np.ndarray | None = None) -> tuple[Residuals, Segments]:
    measured = measured_array(log.columns)
    segments = cut(log.t, measured)
    states = segments.states if shift is None else segments.states + shift
    commands = {name: log[name] for name in ("steer_cmd", "accel_cmd")}
    output = np.asarray(Replay(baseline(), log.t, commands).run(starts=segments.starts, states=states))
    return residuals(output, measured, log.t, SIGMA, segments), segments


@pytest.mark.parametrize("seed", range(4))
def test_car_at_rest_does_not_start_backwards(seed: int) -> None:
    log = drive(seed=seed)
    assert cut(log.t, measured_array(log.columns)).states[:, 3].min() >= 0.0


def test_car_that_reverses_starts_backwards() -> None:
    log = drive()
    backwards = measured_array({**log.columns, "v": -log["v"]})
    assert cut(log.t, backwards).states[:, 3].min() < -1.0


def test_model_without_error_leaves_the_noise() -> None:
    found, _ = judged(drive())
    assert found.total == pytest.approx(1.0, abs=0.06)


def test_second_simulation_from_the_best_start_comes_to_rest_in_time() -> None:
    log = drive()
    measured = measured_array(log.columns)
    shift = np.array([0.0, 0.0, 0.0, 0.2, 0.0, 0.0])
    first, segments = judged(log, shift)
    commands = {name: log[name] for name in ("steer_cmd", "accel_cmd")}
    better = restarted(dataclasses.replace(segments, states=segments.states + shift), first)
    output = np.asarray(Replay(baseline(), log.t, commands).run(starts=better.starts, states=better.states))
    second = residuals(output, measured, log.t, SIGMA, segments)
    assert first.total > 1.1
    assert second.total == pytest.approx(1.0, abs=0.06)


def test_acceleration_does_not_count_where_the_model_comes_to_rest() -> None:
    found, _ = judged(drive())
    _, segments = judged(drive())
    stop = int(np.flatnonzero(drive(noise=0.0)["v"][600:] < 1e-3)[0]) + 600
    skipped = np.flatnonzero(np.isnan(found.values[:, 5]) & segments.counted)
    assert np.abs(skipped - stop).min() <= 2
    assert len(skipped) <= 3 * 3  # three rows at each of three stops


def test_wrong_start_pose_is_taken_out() -> None:
    right, _ = judged(drive())
    wrong, segments = judged(drive(), np.array([0.5, -0.3, 0.01, 0.0, 0.0, 0.0]))
    assert wrong.total == pytest.approx(right.total, abs=0.01)
    assert wrong.start[:, 0] == pytest.approx(right.start[:, 0] - 0.5, abs=0.02)
    assert len(segments.starts) == len(wrong.start)


def test_wrong_start_speed_is_taken_out_to_first_order() -> None:
    log = drive()
    right, segments = judged(log)
    moving = np.array([np.abs(log["v"][a:b]).min() > 1.0 for a, b in zip(segments.starts, segments.ends, strict=True)])
    wrong, _ = judged(log, np.array([0.0, 0.0, 0.0, 0.1, 0.0, 0.0]))
    assert moving.sum() >= 3
    assert wrong.start[moving, 3] == pytest.approx(right.start[moving, 3] - 0.1, abs=0.01)


def test_brake_gain_is_not_taken_out() -> None:
    found, _ = judged(drive(brake_gain=0.9))
    assert found.chi2[CHANNELS.index("v")] > 3.0
    assert found.chi2[CHANNELS.index("yaw")] < 1.3


def test_segments_cover_the_log_and_are_about_five_seconds() -> None:
    _, segments = judged(drive())
    assert segments.starts[0] == 0
    assert segments.ends[-1] == len(drive().t)
    assert (segments.starts[1:] == segments.ends[:-1]).all()
    lengths = (segments.ends - segments.starts) * 0.02
    assert lengths.min() > 3.9
    assert lengths.max() < 6.1


def test_standstill_counts_only_at_its_ends() -> None:
    t = np.arange(0.0, 30.0, 0.02)
    measured = np.full((len(t), 8), np.nan)
    measured[:, 3] = np.where((t > 10.0) & (t < 20.0), 0.0, 5.0)
    counted = cut(t, measured).counted
    assert not counted[(t > 11.1) & (t < 18.9)].any()
    assert counted[(t > 0.5) & (t < 10.9) | (t > 19.1)].all()


def test_spin_does_not_count() -> None:
    t = np.arange(0.0, 30.0, 0.02)
    measured = np.zeros((len(t), 8))
    measured[:, 3] = 5.0
    measured[700:720, 4] = 6.0
    counted = cut(t, measured, wheelbase=2.5).counted
    assert not counted[700:720].any()
    assert counted[25:600].all()


@pytest.mark.parametrize(("speed", "first"), [(5.0, 25), (0.0, 0)])
def test_a_log_that_begins_on_the_move_counts_from_half_a_second_on(speed: float, first: int) -> None:
    """What its actuators had been told before, nobody logged; a car that stands had been told nothing."""
    t = np.arange(0.0, 30.0, 0.02)
    measured = np.full((len(t), 8), np.nan)
    measured[:, 3] = np.where(t < 0.5, speed, 5.0)
    assert int(np.argmax(cut(t, measured).counted)) == first


def test_values_not_measured_are_left_out() -> None:
    log = drive()
    log.columns["x"][::3] = np.nan
    found, _ = judged(log)
    assert np.isnan(found.values[::3, 0]).all()
    assert found.total == pytest.approx(1.0, abs=0.06)


def test_imposed_speed_leaves_no_free_start_speed() -> None:
    log = drive()
    measured = measured_array(log.columns)
    segments = cut(log.t, measured)
    found = residuals(measured + 0.0, measured, log.t, SIGMA, segments, free_speed=False)
    assert (found.start[:, 3] == 0.0).all()


def test_output_that_cannot_be_restarted_is_moved_onto_each_start() -> None:
    log = drive(noise=0.0)
    measured = measured_array(log.columns)
    segments = cut(log.t, measured)
    turned = measured.copy()
    turned[:, 0], turned[:, 1] = 100.0 - measured[:, 1], 50.0 + measured[:, 0]
    turned[:, 2] += np.pi / 2.0
    assert posed(turned, segments)[:, :3] == pytest.approx(measured[:, :3], abs=0.02)
