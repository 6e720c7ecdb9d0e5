"""Scores of a comparison, the channels that are judged, and where an error sits: on rows that are written down here."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare import compare as module
from pytest_dvp.gap.compare.coloured_noise import Whitening
from pytest_dvp.gap.compare.compare import (
    _blocks,
    _check_finite,
    _lag,
    _score,
    _whitened,
    _why_nothing,
    as_subject,
    judged_channels,
    noise_floor,
)
from pytest_dvp.gap.compare.compared_model import CompareError, LogSubject, ModelSubject
from pytest_dvp.gap.compare.error_location import Where, _places, _segments, _top, locate
from pytest_dvp.gap.compare.segments import CHANNELS, Residuals
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.model_file import parse_model

NAN = math.nan
MODEL = parse_model("[model]\nname = 'twin'\n[parameters]\nwheelbase = 2.5\n")
V, AX = CHANNELS.index("v"), CHANNELS.index("ax")


def channels(rows: int = 4, **given: Any) -> Any:
    found = np.full((rows, 8), NAN)
    for name, values in given.items():
        found[:, CHANNELS.index(name)] = values
    return found


# --- which channels are judged


def subject(**more: Any) -> Any:
    return SimpleNamespace(**{"name": "M", "inputs": (), "imposed_channels": (), "restarts": True, **more})


def test_each_channel_is_judged_or_has_a_reason() -> None:
    measured = channels(x=1.0, y=[1.0, NAN, NAN, NAN], yaw=1.0, v=1.0, ax=1.0, steer=1.0)
    output = channels(x=1.0, y=[NAN, 1.0, 1.0, 1.0], yaw=1.0, v=1.0, yaw_rate=1.0, steer=1.0)
    model = subject(inputs=("steer",), imposed_channels=("yaw",))
    judged, left = judged_channels(model, measured, output, None)
    assert judged == ["x", "v"]
    assert left == {
        "y": "never known at the same time", "yaw": "follows from what drives the model", "yaw_rate": "not measured",
        "ax": "the model does not give it", "ay": "not measured", "steer": "drives the model",
    }  # fmt: skip
    assert judged_channels(model, measured, output, ["v"])[0] == ["v"]
    assert judged_channels(model, measured, output, ["v"])[1]["x"] == "not asked for"


@pytest.mark.parametrize(
    ("wanted", "says"),
    [
        (["yaw_raet"], "no channel 'yaw_raet'; nearest is 'yaw_rate'"),
        (["qqq"], "no channel 'qqq'; x, y, yaw, v, yaw_rate, ax, ay, steer"),
        (["v", "ax"], r"nothing to compare \(ax: the model does not give it\)"),
        (["ay"], r"nothing to compare \(ay: not measured\)"),
    ],
)
def test_what_is_asked_for_must_be_there(wanted: list[str], says: str) -> None:
    with pytest.raises(CompareError, match=says):
        judged_channels(subject(), channels(v=1.0, ax=1.0), channels(v=1.0), wanted)


def test_a_log_without_anything_in_common_is_refused_with_all_reasons() -> None:
    with pytest.raises(
        CompareError, match=r"nothing to compare \(x: not measured; y: not measured; .*ay: not measured"
    ):
        judged_channels(subject(), channels(), channels(v=1.0), None)


def test_a_model_must_stay_finite() -> None:
    t = np.array([0.0, 0.5, 1.0, 1.5])
    _check_finite(subject(), t, channels(v=1.0))  # what it never gives is no fault
    with pytest.raises(CompareError, match=r"M: v is not finite from t=1\.000 s on"):
        _check_finite(subject(), t, channels(v=[1.0, 1.0, math.inf, 1.0], ax=[1.0, 1.0, 1.0, NAN]))
    with pytest.raises(CompareError, match="M: gives no finite value at all"):
        _check_finite(subject(), t, channels())
    _check_finite(subject(restarts=False), t, channels())  # a log of another model has gaps of its own
    ours = ModelSubject(MODEL)
    with pytest.raises(CompareError, match=r"twin: ax is not finite from t=0\.000 s on"):
        _check_finite(ours, t, channels(v=1.0))


def test_a_model_and_a_log_are_subjects_and_a_subject_stays() -> None:
    assert isinstance(as_subject(MODEL), ModelSubject)
    assert as_subject(MODEL).name == "twin"
    assert isinstance(as_subject(Log({"t": np.arange(3.0)})), LogSubject)
    own = subject()
    assert as_subject(own) is own


@pytest.mark.parametrize(("lost", "words"), [([True] * 3, "never are the commands"), ([True, False, True], "wherever")])
def test_why_nothing_is_compared(lost: list[bool], words: str) -> None:
    assert _why_nothing(channels(3), SimpleNamespace(lost=np.array(lost))).startswith(words)  # type: ignore[arg-type]


# --- scores


def test_noise_that_repeats_itself_counts_once() -> None:
    values = channels(v=[1.0, 2.0, NAN, 2.0], ax=[3.0, NAN, NAN, NAN])
    count = np.isfinite(values).sum(axis=0)
    found = Residuals(values, np.zeros(8), count, np.zeros((1, 4)), 9.0)
    noise = Whitening(np.full(8, np.inf), np.zeros((8, 4, 3)), np.ones((8, 4)), np.ones(8))
    noise.sigma[V], noise.sigma[AX] = 0.5, 3.0
    white = _whitened(found, noise, np.array([True, False, False, False]))
    assert white.chi2[V] == pytest.approx((4.0 + 16.0 + 16.0) / 3.0)
    assert white.chi2[AX] == pytest.approx(1.0)
    assert np.isnan(white.chi2[0])
    assert white.total == pytest.approx(37.0 / 4.0)
    none = _whitened(Residuals(channels(), np.zeros(8), np.zeros(8, dtype=int), np.zeros((1, 4)), 9.0), noise,
                     np.zeros(4, dtype=bool))  # fmt: skip
    assert none.total == 0.0


@pytest.mark.parametrize(("n", "block", "found"), [(6, 2, [0.5, 2.5, 4.5]), (7, 3, [1.0, 4.0]), (2, 3, []),
                                                   (3, 1, [0.0, 1.0, 2.0])])  # fmt: skip
def test_blocks_are_means_and_what_is_left_at_the_end_is_cut_off(n: int, block: int, found: list[float]) -> None:
    assert _blocks(np.arange(float(n)), block).tolist() == found


def scored(rest: Any, measured: Any, *, step: float = 0.05) -> Any:
    t: FloatArray = step * np.arange(float(len(measured)))
    return _score(measured, measured - rest, rest, 2.5, t, t, "m/s")


def test_a_score_has_the_root_mean_square_and_its_share_of_the_span() -> None:
    t = 0.05 * np.arange(200)
    measured = 2.0 * np.sin(t)
    rest = np.where(np.arange(200) % 2 == 0, 0.3, NAN)
    found = scored(rest, measured)
    assert found.rmse == pytest.approx(0.3)
    assert found.nrmse == pytest.approx(0.3 / np.ptp(measured))
    assert (found.chi2_per_n, found.unit) == (2.5, "m/s")
    assert scored(0.1 * rest, 0.1 * measured).nrmse == pytest.approx(found.nrmse)  # of a range of less than 1, too
    same = scored(np.zeros(200), measured)
    assert (same.rmse, same.mncc, same.lag) == (0.0, pytest.approx(1.0), pytest.approx(0.0, abs=1e-9))
    assert (same.gain, same.iso18571) == (pytest.approx(1.0), pytest.approx(1.0))
    half = scored(0.5 * measured, measured)
    assert half.gain == pytest.approx(2.0)  # measured over modelled


def test_of_a_constant_there_is_no_share_and_of_nothing_no_score() -> None:
    flat = scored(np.full(50, 0.1), np.full(50, 3.0))
    assert (flat.nrmse, flat.mncc, flat.lag, flat.gain) == (None, None, None, None)
    nothing = scored(np.full(50, NAN), np.full(50, 3.0))
    assert math.isnan(nothing.rmse)
    assert (nothing.nrmse, nothing.mncc, nothing.iso18571, nothing.unit) == (None, None, None, "m/s")


def test_no_channel_is_quieter_than_the_best_sensor(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def level(t: Any, y: Any, rest: Any, *, filtered: bool) -> float:
        asked.append((y[0], None if rest is None else rest[0], filtered))
        return float(y[0])

    monkeypatch.setattr(module, "channel_sigma", level)
    measured = channels(x=5.0, yaw=1e-9, v=NAN, ax=0.5)
    found = noise_floor(np.arange(4.0), measured, ["x", "yaw", "v", "ax"], channels(x=2.0, yaw=2.0, v=2.0, ax=2.0))
    assert found.tolist() == [5.0, math.inf, 0.0005, math.inf, math.inf, 0.5, math.inf, math.inf]
    assert [one[1:] for one in asked] == [(2.0, True), (2.0, True), (2.0, False), (2.0, False)]
    noise_floor(np.arange(4.0), measured, ["x"])
    assert asked[-1] == (5.0, None, True)


@pytest.mark.parametrize(("known", "size", "told"), [(200, 1.0, True), (16, 1.0, False), (17, 9.0, True)])
def test_a_lag_is_told_by_signals_of_more_than_sixteen_samples(known: int, size: float, told: bool) -> None:
    t: FloatArray = 0.05 * np.arange(200.0)
    real = size * np.exp(-(((t - 0.45) / 0.15) ** 2))
    twin = size * np.exp(-(((t - 0.35) / 0.15) ** 2))
    twin[known:] = NAN
    found = _lag({"v": real}, {"v": twin}, np.full(8, 0.01), t, t)
    assert (abs(found) > 0.01) is told
    if known == 200:
        assert found == pytest.approx(0.1, abs=5e-3)
    assert _lag({"x": real}, {"x": twin}, np.full(8, 0.01), t, t) == 0.0  # positions tell none
    assert _lag({"v": real}, {"v": twin}, np.full(8, 9.9), t, t) == 0.0  # nor does what is in the noise


# --- where an error sits


def test_segments_are_named_by_their_first_and_last_stamp() -> None:
    cuts: Any = SimpleNamespace(starts=np.array([0, 3]), ends=np.array([3, 5]))
    index, names = _segments(cuts, np.array([0.0, 1.0, 2.0, 3.04, 4.06]))
    assert index.tolist() == [0, 0, 0, 1, 1]
    assert names == ["segment 0.0-2.0 s", "segment 3.0-4.1 s"]


@pytest.mark.parametrize(
    ("span", "side"), [(8.0, 1.0), (8.1, 2.0), (16.0, 2.0), (16.1, 5.0), (40.0, 5.0), (41.0, 10.0), (80.0, 10.0)]
)
def test_cells_have_a_round_side_of_an_eighth_of_the_map_or_more(span: float, side: float) -> None:
    index, names = _places(np.array([0.0, span, NAN]), np.array([0.0, 0.5, 0.0]))
    assert names[0] == f"place x 0..{side:g}, y 0..{side:g} m"
    assert index.tolist() == [0.0, 1.0, -1.0]
    _, turned = _places(np.array([0.0, 0.5]), np.array([0.0, span]))  # the longer side counts
    assert turned[0] == names[0]


def test_a_map_of_one_point_and_of_none() -> None:
    index, names = _places(np.array([3.0, 3.0]), np.array([4.0, 4.0]))
    assert index.tolist() == [0.0, 0.0]
    assert len(names) == 1
    index, names = _places(np.array([NAN, 1.0]), np.array([1.0, NAN]))
    assert (index.tolist(), names) == ([-1.0, -1.0], [])


def test_the_groups_that_hold_most_for_their_time_are_told() -> None:
    """Of 20 of error: 10 in a, 5 in b, 3 in c, 2 in d; of ten samples 2, 2, 1 and 5; one row is in none of them."""
    index = np.array([0, 0, 1, 1, 2, 3, 3, 3, 3, 3, -1], dtype=float)
    power = np.array([5.0, 5.0, 2.5, 2.5, 3.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    known = np.array([True] * 10 + [False])
    found = _top("v", "segment", index, ["a", "b", "c", "d"], power, known)
    assert [(w.channel, w.kind, w.regime) for w in found] == [("v", "segment", name) for name in "abc"]
    assert [w.share_of_error for w in found] == pytest.approx([0.5, 0.25, 0.15])
    assert [w.share_of_time for w in found] == pytest.approx([0.2, 0.2, 0.1])
    assert found[0].excess == pytest.approx(0.3)
    even = _top("v", "segment", np.array([0.0, 1.0]), ["a", "b"], np.array([1.0, 1.0]), np.array([True, True]))
    assert even == []


def located(chi2: dict[str, float], **rest: Any) -> list[Where]:
    """A log of 1,000 rows at 1 m/s in one segment; braking is its first hundred rows, a blink its first."""
    n = 1000
    cuts: Any = SimpleNamespace(starts=np.array([0]), ends=np.array([n]))
    masks = {"braking": np.arange(n) < 100, "blink": np.arange(n) < 1}
    values = {name: np.asarray(row, dtype=float) for name, row in rest.items()}
    return list(locate(values, chi2, masks, np.arange(float(n)), np.ones(n), None, cuts))


def test_errors_of_channels_far_off_come_first_and_a_moment_is_no_place() -> None:
    error = np.r_[np.full(100, 3.0), np.full(900, 1.0)]
    found = located(
        {"v": 4.0, "ax": 16.0, "yaw": NAN}, v=error, ax=error, nothing=np.zeros(1000), gone=np.full(1000, NAN)
    )
    braking = [w for w in found if w.regime == "braking"]
    assert [w.channel for w in braking] == ["ax", "v"]
    assert braking[0].share_of_error == pytest.approx(0.5)
    assert braking[0].share_of_time == pytest.approx(0.1)
    assert not any(w.regime == "blink" for w in found)  # a thousandth of the time
    assert {w.channel for w in found} == {"ax", "v"}
    assert braking[0].as_dict() == {"channel": "ax", "regime": "braking", "share_of_error": pytest.approx(0.5),
                                    "share_of_time": pytest.approx(0.1)}  # fmt: skip


def test_of_channels_as_far_off_as_each_other_names_decide_the_order() -> None:
    error = np.r_[np.full(100, 3.0), np.full(900, 1.0)]
    assert [w.channel for w in located({}, v=error, ax=error) if w.regime == "braking"] == ["ax", "v"]
    less = np.r_[np.full(100, 2.0), np.full(900, 1.0)]  # its excess is 4/13 less a tenth, of the root of a quarter
    order = [w.channel for w in located({"v": 1.0, "ax": 4.0}, v=error, ax=less) if w.regime == "braking"]
    assert order == ["ax", "v"]  # 0.21 before 0.5 x 0.4
    order = [w.channel for w in located({"v": 1.2, "ax": 4.0}, v=error, ax=less) if w.regime == "braking"]
    assert order == ["v", "ax"]  # 0.21 behind 0.55 x 0.4
