"""What is told of one axis of an error that no effect explains, from parts that are given."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.compare.smoothed_motion import Motion
from pytest_dvp.gap.diagnose import residual_signature as module
from pytest_dvp.gap.diagnose.residual_signature import _axis
from pytest_dvp.gap.diagnose.residual_spectrum import Peak
from pytest_dvp.gap.diagnose.residual_terms import Term

ROWS, SEGMENTS = 300, 3
CHI2, COUNT = np.array([90.0, 20.0, 5.0, 60.0, 30.0, 0.0]), np.array([30.0, 30.0, 10.0, 20.0, 20.0, 0.0])
EXCESS = [2.0, 0.0, 0.0, 2.0, 0.5, 0.0]  # chi^2/N beyond 1, of six segments of two logs; the last one has no rows


class Sums:
    """Two terms: the first explains 0.5 of the error on segments left out, the second 0.3, both together 0.8."""

    chi2, count = CHI2, COUNT

    def __init__(self, explains: float = 1.0) -> None:
        self.explains = explains

    def held_out(self, chosen: Any) -> float:
        return self.explains * sum((0.5, 0.3)[k] for k in chosen)

    def fitted(self, chosen: Any) -> tuple[float, Any]:
        return self.held_out(chosen) + 0.01, np.array([0.2, 0.7])

    def left(self, share: float) -> float:
        return 11.0 - 10.0 * share


def a_motion(v: float) -> Motion:
    t = 0.05 * np.arange(ROWS)
    none, every = 0.0 * t, np.ones(ROWS, dtype=bool)
    return Motion(t=t, step=0.05, x=v * t, y=none, yaw=none, v=v + none, yaw_rate=0.2 + none, accel=None, steer=None,
                  moving=every, way=v * t, braked=t, driven=t, wheelbase=2.5)  # fmt: skip


def a_rest(**channels: float) -> Any:
    found = np.full((ROWS, 8), np.nan)
    for name, value in channels.items():
        found[:, CHANNELS.index(name)] = value
    return found


def an_experiment(name: str, **rest: float) -> Any:
    edges = np.arange(0, ROWS + 1, ROWS // SEGMENTS)
    found = SimpleNamespace(
        name=name, channels=tuple(rest), segments=SimpleNamespace(starts=edges[:-1], ends=edges[1:])
    )
    found.residuals = lambda values: SimpleNamespace(values=a_rest(**rest))
    found.model = SimpleNamespace(inputs=SimpleNamespace(steer=f"wheel of {name}"))
    return found


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> Any:
    """_axis, with what it asked others for."""

    def use(axis: str, explains: float = 1.0) -> tuple[dict[str, Any], dict[str, Any]]:
        asked: dict[str, Any] = {}
        names = [Term("speed", "v", np.zeros((ROWS, 1))), Term("force", "a", np.zeros((ROWS, 1)))]

        def peaks(errors: Any, t: Any, way: Any) -> Any:
            asked["errors"], asked["t"], asked["way"] = errors, t, way
            return [Peak("time", 1.5, "Hz", 0.4)]

        def terms(axis: str, motions: Any, periods: Any, steer: str) -> Any:
            asked["terms"] = (axis, len(motions), periods, steer)
            return [names, names]

        def term_sums(axis: str, target: Any, rest: Any, motions: Any, tried: Any) -> Any:
            asked["rest"] = rest
            return Sums(explains)

        def over_time(excess: Any) -> Any:
            asked["excess"] = [list(one) for one in excess]
            return 0.25

        for name, replaced in (("peaks", peaks), ("terms", terms), ("term_sums", term_sums), ("over_time", over_time),
                               ("at_same_place", lambda errors, motions: 0.11),
                               ("in_same_direction", lambda errors, motions: 0.12),
                               ("at_speed", lambda errors, motions: {"bin": "5 to 10 m/s"})):  # fmt: skip
            monkeypatch.setattr(module, name, replaced)
        target: Any = SimpleNamespace(
            experiments=[an_experiment("a", v=0.5, ax=0.3, yaw_rate=0.06), an_experiment("b", v=0.5, ax=-0.2, yaw=0.1)],
            by_channel=lambda values: {"v": 3.0, "ax": 2.0, "yaw_rate": 4.0, "x": 9.0},
        )
        return _axis(axis, "as it is", target, {}, [a_motion(10.0), a_motion(5.0)]), asked  # type: ignore[arg-type]

    return use


def test_an_axis_tells_its_channels_and_what_is_left_with_all_terms(told: Any) -> None:
    found, asked = told("longitudinal")
    assert (found["axis"], found["basis"]) == ("longitudinal", "as it is")
    assert found["channels"] == {"v": 3.0, "ax": 2.0}
    assert found["chi2_per_n"] == 11.0
    assert found["chi2_per_n_with_regressors"] == pytest.approx(3.0)  # 0.8 of 10 are explained by both
    assert [one["term"] for one in found["regressors"]] == ["v", "a"]
    assert found["alternatives"] == [{"term": "a", "held_out_share": 0.3}]
    assert found["rhythm"] == [{"over": "time", "frequency": 1.5, "unit": "Hz", "share": 0.4}]
    assert (found["trend"], found["same_place"], found["same_direction"]) == (0.25, 0.11, 0.12)
    assert found["speed"] == {"bin": "5 to 10 m/s"}
    assert "slip" not in found
    assert found["reading"].endswith("; 50 % of it on segments left out")
    assert asked["terms"] == ("longitudinal", 2, [("time", 1.5)], "wheel of a")


def test_without_a_term_all_of_it_is_left(told: Any) -> None:
    found, _ = told("longitudinal", explains=0.05)
    assert found["regressors"] == found["alternatives"] == []
    assert found["chi2_per_n_with_regressors"] == found["chi2_per_n"] == 11.0
    assert found["reading"].startswith("longitudinal error that shakes") or "1.5 Hz" in found["reading"]


def test_the_trend_is_that_of_what_each_segment_has_beyond_its_noise_log_by_log(told: Any) -> None:
    """Without rows there is nothing, and what is below the noise is not less than nothing."""
    _, asked = told("longitudinal")
    assert asked["excess"] == [EXCESS[:3], EXCESS[3:]]


def test_an_error_along_is_an_acceleration_and_one_across_an_angle_at_the_measured_speed(told: Any) -> None:
    """0.06 rad/s at 10 m/s, of which 0.5/10 of 0.2 are those of the speed: 0.05 rad/s x 2.5 m / 10 m/s. The second log
    has no yaw rate: its yaw of 0.1 rad loses 0.5/5 x 0.2 rad/s and so falls by 0.02 rad/s."""
    _, asked = told("longitudinal")
    assert [error[150] for error in asked["errors"]] == pytest.approx([0.3, -0.2])
    assert [way[1] for way in asked["way"]] == pytest.approx([0.5, 0.25])
    assert [t[1] for t in asked["t"]] == pytest.approx([0.05, 0.05])
    found, asked = told("lateral")
    assert [error[150] for error in asked["errors"]] == pytest.approx([0.05 * 2.5 / 10.0, -0.02 * 2.5 / 5.0])
    assert asked["rest"][0][150, CHANNELS.index("yaw_rate")] == pytest.approx(0.05)
    assert found["channels"] == {"yaw_rate": 4.0}
    assert found["slip"] == pytest.approx(0.0, abs=1e-9)
