"""Several logs as one answer: each figure by its definition, over the samples of all of them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.compare import SignalScore
from pytest_dvp.gap.compare.error_location import Where
from pytest_dvp.gap.words.pooled_comparison import pooled
from pytest_dvp.logs.log_contents import FloatArray

N = np.nan


def score(rmse: float, unit: str = "m/s", **more: Any) -> SignalScore:
    fields: dict[str, Any] = {"nrmse": 0.1, "chi2_per_n": 2.0, "mncc": 0.9, "lag": 0.2, "gain": 1.0, "iso18571": 0.5}
    return SignalScore(rmse, unit=unit, **fields | more)


def one(signals: dict[str, SignalScore], residuals: dict[str, list[float]], where: tuple[Where, ...] = (),
        lag: float = 0.0, coverage: float = 1.0, seconds: float = 1.0) -> Any:  # fmt: skip
    t: FloatArray = np.linspace(5.0, 5.0 + seconds, max(len(v) for v in residuals.values()))
    return SimpleNamespace(
        t=t, alignment=SimpleNamespace(lag=lag, coverage=coverage), signals=signals, where=where,
        residuals={name: np.array(values) for name, values in residuals.items()}, as_dict=lambda: {"own": lag},
    )  # fmt: skip


def test_one_log_is_its_own_answer() -> None:
    assert pooled({"a": one({}, {"v": [1.0]}, lag=0.3)}) == {"own": 0.3}


def test_lag_counts_by_samples_and_coverage_by_time_and_each_log_is_told() -> None:
    logs = {"a": one({}, {"v": [1.0] * 3}, lag=0.1, coverage=0.5, seconds=9.0),
            "b": one({}, {"v": [1.0] * 9}, lag=0.5, coverage=0.9, seconds=3.0)}  # fmt: skip
    found = pooled(logs)
    assert found["alignment"]["lag"] == pytest.approx((3 * 0.1 + 9 * 0.5) / 12)
    assert found["alignment"]["coverage"] == pytest.approx((9 * 0.5 + 3 * 0.9) / 12)
    assert found["logs"] == [{"log": "a", "own": 0.1}, {"log": "b", "own": 0.5}]


def test_errors_are_pooled_as_squares_and_other_figures_as_means_by_samples() -> None:
    logs = {
        "a": one({"v": score(1.0, nrmse=0.2, chi2_per_n=4.0, gain=0.9), "ax": score(7.0, "m/s^2")},
                 {"v": [1.0, N, 1.0, 1.0], "ax": [N] * 4}),
        "b": one({"v": score(3.0, nrmse=0.6, chi2_per_n=8.0, gain=None)}, {"v": [3.0]}),
        "c": one({"r": score(5.0, "rad/s", lag=N)}, {"r": [1.0]}),
    }  # fmt: skip
    found = pooled(logs)["signals"]
    assert list(found) == ["v", "ax", "r"]
    assert found["v"]["rmse"] == pytest.approx(np.sqrt((3 * 1.0 + 9.0) / 4))
    assert found["v"]["nrmse"] == pytest.approx(np.sqrt((3 * 0.04 + 0.36) / 4))
    assert found["v"]["chi2_per_n"] == pytest.approx((3 * 4.0 + 8.0) / 4)
    assert found["v"]["gain"] == pytest.approx(0.9)  # the other log has none
    assert (found["v"]["unit"], found["ax"]["unit"]) == ("m/s", "m/s^2")
    assert found["ax"]["rmse"] is None  # nothing was compared
    assert found["r"]["lag"] is None


def test_where_the_error_sits_is_a_share_of_the_error_and_the_time_of_all_logs() -> None:
    def where(regime: str, error: float, time: float, kind: str = "regime") -> Where:
        return Where("v", regime, error, time, kind)

    logs = {
        "a": one({}, {"v": [2.0, N, 2.0, 0.0]},
                 (where("braking", 0.5, 1 / 3), where("segment 1", 1.0, 0.25, "segment"))),
        "b": one({}, {"v": [1.0, 1.0], "ax": [1.0, 1.0]},
                 (where("braking", 0.5, 0.5), where("slow", 0.25, 0.75, "speed"), Where("ax", "braking", 0.1, 0.2))),
    }  # fmt: skip
    found = {(w["channel"], w["regime"]): (w["share_of_error"], w["share_of_time"]) for w in pooled(logs)["where"]}
    assert found["v", "braking"] == pytest.approx(((0.5 * 8.0 + 0.5 * 2.0) / 10.0, (1.0 + 1.0) / 5.0))
    assert found["v", "a segment 1"] == pytest.approx((8.0 / 10.0, 0.75 / 5.0))
    assert found["v", "slow"] == pytest.approx((0.5 / 10.0, 1.5 / 5.0))
    assert found["ax", "braking"] == pytest.approx((0.1, 0.2))
    excess = [w["share_of_error"] - w["share_of_time"] for w in pooled(logs)["where"]]
    assert excess == sorted(excess, reverse=True)
    none = {"a": one({}, {"v": [N, N]}, (where("braking", 0.5, 0.5),)), "b": one({}, {"v": [N, N]})}
    assert pooled(none)["where"] == [{"channel": "v", "regime": "braking", "share_of_error": 0.0, "share_of_time": 0.0}]


def test_a_single_sample_of_all_logs_is_all_of_their_time() -> None:
    logs = {"a": one({}, {"v": [2.0, N]}, (Where("v", "braking", 1.0, 1.0, "regime"),)), "b": one({}, {"v": [N, N]})}
    (where,) = pooled(logs)["where"]
    assert (where["share_of_error"], where["share_of_time"]) == (1.0, 1.0)
