"""Thresholds of what may judge a fit, of the points that a search begins at, and of a comparison, from both sides."""

from __future__ import annotations

import dataclasses
from math import sqrt
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.compare import _lag, _score, noise_floor
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose import held_out
from pytest_dvp.gap.diagnose.candidates import Candidate, candidates
from pytest_dvp.gap.diagnose.held_out import Fold, fold_excites, folds
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log import Log
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

MODEL = parse_model("[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n")
GAIN = ("drive_gain", "g")


def candidate(name: str) -> Candidate:
    (found,) = candidates(MODEL, [find_effect(name)])
    return found


@dataclasses.dataclass
class Data:
    """Samples that a change of the drive's gain moves: by so many noises each, and by nothing at a gain of 0.9."""

    count: int
    moved_by: float

    def starts(self) -> Any:
        return np.zeros(1, int)

    def whitened(self, values: dict[tuple[str, str], float]) -> Any:
        return np.full(self.count, self.moved_by if values[GAIN] == 1.0 else 0.0)


def shown(fitted: Data, judging: Data) -> bool:
    tried = candidate("drive_gain")
    search = Search(fitted, [tried])  # type: ignore[arg-type]
    fit = Fit(tried.coordinates, {GAIN: 0.9}, np.zeros(1), 0.0, np.zeros((1, 1)))
    trial = Trial(("drive_gain",), {GAIN: 0.9}, fit, np.zeros(1))
    return fold_excites(search, Fold(fitted, judging), trial, "drive_gain")  # type: ignore[arg-type]


@pytest.mark.parametrize(("change", "seen"), [(0.049, False), (0.051, True)])
def test_data_show_an_effect_that_changes_a_twentieth_of_the_noise(change: float, seen: bool) -> None:
    data = Data(1000, sqrt(change))
    assert shown(data, data) is seen


@pytest.mark.parametrize(("share", "judges"), [(0.29, False), (0.31, True)])
def test_data_that_feel_an_effect_less_than_a_third_as_much_do_not_predict_it(share: float, judges: bool) -> None:
    """0.3 for each sample, however many there are on either side."""
    assert shown(Data(1000, sqrt(2.0 * share)), Data(400, sqrt(2.0))) is judges


def even_log(rows: int) -> Log:
    return Log({"t": np.arange(rows) * 0.02, "v": np.ones(rows)})


@pytest.mark.parametrize(("rows", "parts"), [(498, 0), (503, 1)])
def test_either_side_of_a_single_log_has_two_hundred_rows(
    rows: int, parts: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last 40 % judge: of 498 rows 199, of 503 rows 201."""
    monkeypatch.setattr(held_out, "experiment_set", lambda logs, model, extra: logs)
    assert len(folds({"log": even_log(rows)}, None, MODEL)) == parts


def test_the_last_two_fifths_of_a_single_log_judge_the_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(held_out, "experiment_set", lambda logs, model, extra: logs)
    ((fitted, judging),) = [(fold.fitted, fold.judge) for fold in folds({"log": even_log(1001)}, None, MODEL)]
    assert fitted is not None
    assert fitted["log"].t[-1] == pytest.approx(12.0, abs=0.021)  # type: ignore[index]
    assert judging["log"].t[0] == pytest.approx(12.0, abs=0.021)  # type: ignore[index]


@pytest.mark.parametrize(
    ("name", "fine", "coarse"),
    [("rolling_resistance", 5, 3), ("brake_limit", 9, 3), ("steer_stiction", 60, 60)],
)
def test_an_effect_of_one_parameter_begins_at_five_points_a_limit_at_nine_and_a_rough_one_at_sixty(
    name: str, fine: int, coarse: int
) -> None:
    found = candidate(name)
    assert (len(found.points), len(found.coarse)) == (fine, coarse)


def test_an_effect_of_two_parameters_begins_at_four_by_four_points_and_coarsely_at_three_by_three() -> None:
    """Left and right of an asymmetry have a neutral value within their range: an even number would put a point there,
    so the next odd number is spread and the middle left out, which makes four of five and two of three."""
    found = candidate("steer_asymmetry")
    assert (len(found.points), len(found.coarse)) == (4 * 4, 2 * 2)


@pytest.mark.parametrize(
    ("parameters", "fine", "coarse"), [(1, 5, 3), (2, 4**2, 3**2), (3, 2**3, 2**3), (4, 2**4, 2**4)]
)
def test_an_effect_begins_at_fewer_points_of_each_parameter_the_more_it_has(
    parameters: int, fine: int, coarse: int
) -> None:
    """Each does nothing at the lower end of its range, so that no point falls on its neutral value and is left out."""
    keys = tuple(Key(f"k{n}", "-", 0.0, 1.0, neutral=0.0, least=0.1) for n in range(parameters))
    (found,) = candidates(MODEL, [dataclasses.replace(find_effect("drive_gain"), name="mine", parameters=keys)])
    assert (len(found.points), len(found.coarse)) == (fine, coarse)


@pytest.mark.parametrize(("times", "seen"), [(3.9, False), (4.1, True)])
def test_a_signal_tells_a_lag_if_it_varies_by_four_times_its_noise(times: float, seen: bool) -> None:
    """A sine of amplitude A varies by A / sqrt(2); the measurement comes 0.1 s after the model."""
    sigma = np.full(len(CHANNELS), 0.05)
    even = np.arange(2000) * 0.02
    amplitude = times * 0.05 * sqrt(2.0)
    real, twin = (amplitude * np.sin(2.0 * np.pi * (even - late) / 2.0) for late in (0.1, 0.0))
    lag = _lag({"yaw_rate": real}, {"yaw_rate": twin}, sigma, even, even)
    assert lag == (pytest.approx(0.1, abs=0.005) if seen else 0.0)


@pytest.mark.parametrize(("noise", "seen"), [(0.0625, False), (0.06, True)])
def test_a_signal_that_varies_by_just_four_times_its_noise_tells_no_lag(noise: float, seen: bool) -> None:
    """As long at 0.25 as at -0.25, it varies by 0.25; the measurement comes 0.1 s after the model."""
    even = np.arange(2000) * 0.02
    twin = np.where(np.arange(2000) % 100 < 50, 0.25, -0.25)
    lag = _lag({"yaw_rate": np.roll(twin, 5)}, {"yaw_rate": twin}, np.full(len(CHANNELS), noise), even, even)
    assert lag == (pytest.approx(0.1, abs=0.005) if seen else 0.0)


@pytest.mark.parametrize(("samples", "rated"), [(49, False), (50, True)])
def test_a_rating_needs_ten_means_over_a_tenth_of_a_second(samples: int, rated: bool) -> None:
    """Ten points are the fewest that ISO/TS 18571 can be applied to; at 50 Hz five samples make one."""
    t = np.arange(samples) * 0.02
    y = np.sin(3.0 * t)
    score = _score(y, y, np.zeros(samples), 1.0, t, t, "m")
    assert (score.iso18571 is not None) is rated


@pytest.mark.parametrize(("gain", "matters"), [(0.059, False), (0.061, True)])
def test_a_value_below_the_least_size_matters_if_it_gains_twice_what_a_first_effect_must(
    gain: float, matters: bool
) -> None:
    """Least gain of a first effect: 3 %; the gain of 0.995 is nearer to 1 than is worth naming."""
    tried = candidate("drive_gain")
    (key,) = tried.effect.parameters
    value = 1.0 - 0.5 * key.least
    data = Data(1000, sqrt(gain))
    search = Search(data, [tried])  # type: ignore[arg-type]
    fit = Fit((Coordinate("drive_gain", key),), {GAIN: value}, np.zeros(1000), 0.0, np.zeros((1, 1000)))
    assert search._matters(Trial(("drive_gain",), {GAIN: value}, fit, np.zeros(1)), "drive_gain", data) is matters  # type: ignore[arg-type]


def test_a_signal_without_noise_gets_that_of_the_best_sensors_of_road_cars() -> None:
    """A centimetre, half a milliradian, 1 cm/s, half a milliradian a second, 2 cm/s^2, a milliradian of steering."""
    t = np.arange(500) * 0.02
    best = {"x": 0.01, "y": 0.01, "yaw": 0.0005, "v": 0.01, "yaw_rate": 0.0005, "ax": 0.02, "ay": 0.02, "steer": 0.001}
    found = noise_floor(t, np.zeros((len(t), len(CHANNELS))), CHANNELS)
    assert dict(zip(CHANNELS, found.tolist(), strict=True)) == best
