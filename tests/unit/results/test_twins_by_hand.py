"""What is left of a twin's answer, row by row: the regime that is judged, the slope, the distance."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from results_logs import log_of

from pytest_dvp.gap.words import comparison as words
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics import twin_chi2, twin_error, twin_gain

LOG = log_of(1.0)
ROWS = np.arange(8)


def left(monkeypatch: pytest.MonkeyPatch, module: Any, **more: Any) -> None:
    """Eight rows of half a second: cruise, then braking; the last one is not known. The noise is 0.5 rad/s."""
    found = {
        "t": 0.5 * ROWS, "signals": {"yaw_rate": SimpleNamespace(unit="rad/s")}, "not_compared": {"ax": "not measured"},
        "noise": {"yaw_rate": 0.5}, "regimes": {"cruise": ROWS < 4, "braking": ROWS >= 4},
        "residuals": {"yaw_rate": np.array([0.5, 0.5, -0.75, 0.5, -1.0, 1.5, 1.0, np.nan])},
    }  # fmt: skip
    found["measured"] = dict.fromkeys((found | more)["signals"], np.zeros(len((found | more)["t"])))
    monkeypatch.setattr(module, "compared", lambda model, measured: SimpleNamespace(**found | more))


CRUISE, BRAKING = (1.0 + 1.0 + 2.25 + 1.0) / 4.0, (4.0 + 9.0 + 4.0) / 3.0  # squares of residuals over the noise
ALL = (5.25 + 17.0) / 7.0


@pytest.mark.parametrize(
    ("asked", "value", "regime", "t"),
    [
        ({}, CRUISE, "cruise", 1.0),  # braking has three known rows: 1.5 s; the whole drive is no regime
        ({"least": 1.5}, BRAKING, "braking", 2.5),
        ({"regime": "all"}, ALL, "all", 2.5),
        ({"regime": "cruise", "least": 1.5}, CRUISE, "cruise", 1.0),
        ({"least": 3.5}, ALL, "all", 2.5),  # no regime was driven so long: then the whole drive
    ],
)
def test_the_worst_regime_that_lasted_long_enough_is_judged(
    asked: dict[str, Any], value: float, regime: str, t: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    left(monkeypatch, twin_chi2)
    found = twin_chi2.twin_chi2(LOG, LOG, **asked)
    assert (found.value, found.object, found.t) == (pytest.approx(value), regime, t)
    each = {"all": (ALL, 3.5), "cruise": (CRUISE, 2.0), "braking": (BRAKING, 1.5)}
    long = {name: mean for name, (mean, seconds) in each.items() if seconds >= asked.get("least", 2.0)}
    assert found.extra == pytest.approx(long)


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"regime": "braking"}, "braking lasted less than 2 s"), ({"least": 3.6}, "the drive lasted less than 3.6 s"),
        ({"regime": "launch"}, "no regime 'launch'; there are cruise, braking, all and worst"),
        ({"signal": "ax"}, "ax is not compared: not measured"), ({"signal": "q"}, "q is not compared: no such signal"),
    ],
)  # fmt: skip
def test_what_of_a_twin_cannot_be_judged(asked: dict[str, Any], says: str, monkeypatch: pytest.MonkeyPatch) -> None:
    left(monkeypatch, twin_chi2)
    with pytest.raises(Undefined) as refused:
        twin_chi2.twin_chi2(LOG, LOG, **asked)
    assert str(refused.value) == says


@pytest.mark.parametrize(("noise", "told"), [(0.25, True), (0.2501, False)])
def test_a_slope_is_told_by_an_answer_that_varies_by_four_times_the_noise(
    noise: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The twin goes from -1 to 1 and back, which is a standard deviation of 1; the car by 0.8 of it, 3 above."""
    twin = np.where(ROWS % 2 == 0, -1.0, 1.0)
    twin[7] = 50.0  # where the car is not known
    car = np.where(ROWS == 7, np.nan, 3.0 + 0.8 * twin)
    twin[0] = np.nan
    rest = car - twin
    left(monkeypatch, twin_gain, noise={"yaw_rate": noise}, residuals={"yaw_rate": rest}, modelled={"yaw_rate": twin},
         measured={"yaw_rate": car})  # fmt: skip
    if not told:
        with pytest.raises(Undefined, match="yaw_rate of the twin hardly varies"):
            twin_gain.twin_gain(LOG, LOG)
        return
    found = twin_gain.twin_gain(LOG, LOG)
    assert (found.value, found.t) == (pytest.approx(0.8), None)
    assert found.series is not None
    assert found.series.t.tolist() == [0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    assert found.series.value == pytest.approx([2.8, 3.2] * 3)  # 3 -+ 0.2


@pytest.mark.parametrize("place", [None, "a place"])
def test_a_distance_is_that_in_the_plane_where_both_are_known(
    place: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """3-4-5, 0, and two rows of which one half is not known."""
    rest = {"x": np.array([3.0, 0.0, np.nan, 9.0]), "y": np.array([-4.0, 0.0, 9.0, np.nan]), "v": np.full(4, np.nan)}
    units = {name: SimpleNamespace(unit="m/s" if name == "v" else "m") for name in rest}
    left(monkeypatch, twin_error, t=np.arange(4.0), residuals=rest, signals=units, where=())
    monkeypatch.setattr(words, "worst_place", lambda where, signal: place and (place, signal))
    monkeypatch.setattr(words, "sentence", lambda found: f"{found[1]} in {found[0]}")
    found = twin_error.twin_error(LOG, LOG)
    assert (found.value, found.t, found.unit) == (pytest.approx(math.sqrt(12.5)), 0.0, "m")
    assert (found.object, found.extra) == ("x in a place" if place else "", {"greatest": 5.0})
    along = twin_error.twin_error(LOG, LOG, signal="x")
    assert (along.value, along.t, along.extra) == (pytest.approx(math.sqrt(30.0)), 3.0, {"greatest": 9.0})
    for signal, says in (("v", "v is known nowhere"), ("ax", "ax is not compared: not measured")):
        with pytest.raises(Undefined, match=says):
            twin_error.twin_error(LOG, LOG, signal=signal)


@pytest.mark.parametrize(
    "judged",
    [(twin_chi2, twin_chi2.twin_chi2), (twin_gain, twin_gain.twin_gain), (twin_error, twin_error.twin_error)],
)
def test_a_signal_of_which_most_was_not_measured_judges_no_twin(judged: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of eight rows, and the last value holds for the usual half second: three eighths of 3.5 s."""
    module, metric = judged
    rest = {"yaw_rate": np.where(ROWS < 2, 0.5, np.nan)}
    left(monkeypatch, module, residuals=rest, measured=rest)
    with pytest.raises(Undefined, match=r"yaw_rate was measured for 1\.3 s of 3\.5 s only"):
        metric(LOG, LOG, signal="yaw_rate")
