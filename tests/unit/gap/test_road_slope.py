"""Hills that no model knows: what the car's own sensors tell of them, and that they are no error of the model."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from gap_logs import baseline, drive

from pytest_dvp.gap.compare.road_slope import LEAST, LEAST_TOLD, slope_spread, told_spread
from pytest_dvp.gap.compare.segments import measured_array
from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.gap.diagnose.experiment import LITTLE_ELSE, experiment_set, on_same_roads
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_part import cut_log
from vehicle.model.remainder_shape import RemainderShape

LONG = 120.0  # s


def spread(log: Log) -> float:
    return slope_spread(log.t, measured_array(log.columns))


@pytest.mark.parametrize("seed", [1, 2])
def test_a_flat_road_has_no_slope_however_wrong_the_brakes_are(seed: int) -> None:
    assert spread(drive(LONG, seed=seed, brake_gain=0.8, steer_ratio=0.9)) == 0.0


@pytest.mark.parametrize("hills", [0.1, 0.3])
def test_hills_are_told_by_their_spread(hills: float) -> None:
    """A quarter of it is the windows', which are 2.5 s long, and where this drive happened to be."""
    assert spread(drive(LONG, hills=hills, wave=240.0)) == pytest.approx(hills, rel=0.25)


def test_hills_count_from_their_least_spread_on() -> None:
    assert spread(drive(LONG, noise=0.1, hills=0.7 * LEAST, wave=240.0)) == 0.0
    assert spread(drive(LONG, noise=0.1, hills=1.4 * LEAST, wave=240.0)) > 0.0


def test_without_an_accelerometer_or_on_a_short_drive_nothing_tells() -> None:
    log = drive(LONG, hills=0.3)
    assert spread(Log({name: column for name, column in log.columns.items() if name != "ax"})) == 0.0
    assert spread(drive(20.0, hills=0.3)) == 0.0


@pytest.mark.parametrize(("lag", "told"), [(0.1, True), (2.0, False)])
def test_an_acceleration_that_a_filter_makes_late_tells_no_slope(lag: float, told: bool) -> None:
    log = drive(LONG, hills=0.1, wave=90.0)
    column = log["ax"].copy()
    for i in range(1, len(column)):
        column[i] = column[i - 1] + 0.02 / lag * (log["ax"][i] - column[i - 1])
    assert (spread(Log({**log.columns, "ax": column})) > 0.0) == told


def test_one_plane_is_an_effect_and_no_hills() -> None:
    turning = drive(LONG, plane=0.4, steer_offset=0.02)
    assert spread(turning) == 0.0


def test_what_shows_in_the_accelerometer_too_is_a_force_that_the_model_lacks() -> None:
    lasts = np.full(20, 5.0)
    rng = np.random.default_rng(3)
    hill, force = 0.05 * rng.normal(size=20), 0.3 * rng.normal(size=20)
    assert told_spread([(lasts, force, force)]) == 0.0
    assert told_spread([(lasts, hill, 0.0 * hill)]) == pytest.approx(hill.std(), rel=1e-9)
    assert told_spread([(lasts, hill + 0.2, 0.0 * hill + 0.5)]) == pytest.approx(hill.std(), rel=1e-9)
    assert told_spread([]) == 0.0


def test_a_spread_is_told_from_its_least_on() -> None:
    lasts, wave = np.full(20, 5.0), np.tile([1.0, -1.0], 10)
    assert told_spread([(lasts, 0.99 * LEAST_TOLD * wave, 0.0 * wave)]) == 0.0
    assert told_spread([(lasts, 1.01 * LEAST_TOLD * wave, 0.0 * wave)]) == pytest.approx(1.01 * LEAST_TOLD)


def test_a_model_that_brakes_too_hard_tells_the_same_hills() -> None:
    def told(**hidden: float) -> float:
        target = experiment_set({"log": drive(LONG, **hidden)}, baseline())
        return told_spread(e.hills({}) for e in target.experiments)

    assert told(brake_gain=0.9) == 0.0
    assert told(brake_gain=0.9, hills=0.1, wave=240.0) == pytest.approx(0.1, rel=0.25)


def test_on_hills_a_start_that_no_row_tells_stays_where_it_was_measured() -> None:
    """A car that stands at the beginning of a segment has no rows in which its way counts."""
    target = experiment_set({"log": drive(LONG, hills=0.1, wave=240.0)}, baseline())
    target.settle({})
    assert np.abs(target.experiments[0].residuals({}).start[:, 3]).max() < 0.2


@pytest.mark.parametrize(
    ("told", "remainder", "expected"),
    [(None, {}, None), (0.0, {}, 0.0), (0.07, {}, 0.07), (0.07, {"v": {"cruise": 0.1}}, 0.07),
     (None, {"v": {"cruise": 0.1}}, 0.0)],
)  # fmt: skip
def test_a_twin_tells_the_slopes_that_it_knows_and_a_log_those_of_a_model_that_lacks_no_more(
    told: float | None, remainder: dict[str, dict[str, float]], expected: float | None
) -> None:
    log = drive(LONG, hills=0.1, wave=240.0)
    twin = dataclasses.replace(baseline(), remainder=remainder, remainder_shape=RemainderShape(slopes=told))
    assert experiment_set({"log": log}, twin).slopes == (spread(log) if expected is None else expected)


def test_hills_count_only_where_the_model_leaves_little_else() -> None:
    log = drive(LONG, hills=0.1, wave=240.0, steer_offset=0.1)
    assert spread(log) > 0.0
    far = experiment_set({"log": log}, baseline())
    near = experiment_set({"log": drive(LONG, hills=0.1, wave=240.0, steer_ratio=0.99)}, baseline())
    assert (far.slopes, near.slopes > 0.0) == (0.0, True)
    assert float(np.sum(far.whitened({}) ** 2)) / far.count > LITTLE_ELSE


def test_drives_that_judge_and_parts_of_drives_are_on_the_same_roads() -> None:
    """A part of 20 s is too short to tell its slopes."""
    logs = {"hills": drive(LONG, hills=0.1, wave=240.0), "flat": drive(LONG)}
    target = experiment_set(logs, baseline())
    assert [e.slopes for e in target.experiments] == [target.slopes] * 2
    assert target.slopes == spread(logs["hills"])
    part = {"part": cut_log(logs["hills"], 40.0, 60.0)}
    assert experiment_set(part, baseline()).slopes == 0.0
    assert experiment_set(part, on_same_roads(baseline(), target)).slopes == target.slopes
    flat = experiment_set({"flat": logs["flat"]}, baseline())
    assert on_same_roads(baseline(), flat) == baseline()


def test_on_hills_as_many_samples_are_counted_as_are_judged() -> None:
    """Of a set, the flat drive loses rows in which it is slow, too."""
    logs = {"hills": drive(LONG, hills=0.1, wave=240.0), "flat": drive(LONG)}
    alone = experiment_set({"flat": logs["flat"]}, baseline()).count
    flat = experiment_set(logs, baseline()).experiments[1]
    assert flat.count == np.isfinite(flat.residuals({}).values[:, :7]).sum() < alone
    flat.on_hills(0.0)
    assert flat.count == alone


def test_on_hills_of_1_percent_a_right_model_lacks_nothing() -> None:
    found = diagnose({"log": drive(LONG, hills=0.1, wave=240.0)}, baseline())
    assert (found.verdict, found.effects) == ("NOTHING_MISSING", ())
    assert found.samples.slopes == pytest.approx(0.1, rel=0.25)


def test_on_hills_a_wrong_gain_is_named_with_its_value() -> None:
    (named,) = diagnose({"log": drive(LONG, hills=0.1, wave=90.0, drive_gain=0.9)}, baseline()).effects
    assert named.name == "drive_gain"
    assert named.parameters["g"].low < 0.9 < named.parameters["g"].high
    assert named.parameters["g"].high - named.parameters["g"].low < 0.03


def test_on_hills_a_bias_of_the_accelerometer_is_told_from_a_force() -> None:
    log = drive(LONG, hills=0.1, wave=240.0)
    (named,) = diagnose({"log": Log({**log.columns, "ax": log["ax"] + 0.1})}, baseline()).effects
    assert named.name == "accelerometer_bias"
    assert named.parameters["b"].value == pytest.approx(0.1, abs=0.01)
