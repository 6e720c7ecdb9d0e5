"""A reference system that lost its satellites: it says so itself, or its positions leave the way that was driven."""

from __future__ import annotations

import numpy as np
import pytest
from drives import drive

from pytest_dvp.doctor import examine
from pytest_dvp.gap.compare.segments import CHANNELS, measured_array
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.lost_fix import lost_fix, lost_for, no_evidence_of_place

Columns = dict[str, np.ndarray]
LOST = (20.0, 30.0)  # s


def out(t: np.ndarray) -> np.ndarray:
    return (t >= LOST[0]) & (t < LOST[1])


def drifting(columns: Columns, metres: float) -> Columns:
    """The position drifts away by `metres` while satellites are lost, and takes as long to come back."""
    t, (begin, end) = columns["t"], LOST
    away = np.interp(t, [begin, end, 2.0 * end - begin], [0.0, 1.0, 0.0])
    return {**columns, "x": columns["x"] + metres * away}


def stated(columns: Columns, lost: float, usual: float = 0.01) -> Columns:
    return {**columns, "position_sigma": np.where(out(columns["t"]), lost, usual)}


def codes(columns: Columns) -> list[str]:
    return [finding.code for finding in examine(Log(columns))]


@pytest.mark.parametrize(("sigma", "lost"), [(0.0199, False), (0.0201, True)])
def test_a_fix_is_lost_above_twice_the_best(sigma: float, lost: bool) -> None:
    columns = stated(drive(), sigma)
    assert lost_fix(columns).any() == lost
    assert np.array_equal(lost_fix(columns), out(columns["t"]) & lost)


def test_a_receiver_that_is_better_than_any_while_standing_has_not_lost_its_fix_when_it_drives() -> None:
    assert not lost_fix(stated(drive(), 0.019, usual=0.005)).any()


def test_a_log_that_states_nothing_has_lost_nothing() -> None:
    columns = drive()
    assert not lost_fix(columns).any()
    assert not lost_fix({**columns, "position_sigma": np.full_like(columns["t"], np.nan)}).any()
    assert no_evidence_of_place(Log(columns)) == ""


def test_place_heading_and_speed_of_those_rows_are_not_compared_and_the_rest_is() -> None:
    columns = stated(drive(), 0.2)
    found, lost = measured_array(columns), out(columns["t"])
    for name in ("x", "y", "yaw", "v"):
        assert np.array_equal(np.isnan(found[:, CHANNELS.index(name)]), lost)
    assert np.isfinite(found[:, CHANNELS.index("yaw_rate")]).all()
    assert lost_for(Log(columns)) == pytest.approx(10.0)


def test_a_drive_that_lost_a_third_or_never_had_a_fix_is_no_evidence() -> None:
    columns = drive()
    t = columns["t"]
    part = {**columns, "position_sigma": np.where(t < 0.32 * t[-1], 0.2, 0.01)}
    most = {**columns, "position_sigma": np.where(t < 0.35 * t[-1], 0.2, 0.01)}
    assert no_evidence_of_place(Log(part)) == ""
    assert no_evidence_of_place(Log(most)).startswith("its reference system had no fix for ")
    never = {**columns, "position_sigma": np.full_like(t, 0.4)}
    assert no_evidence_of_place(Log(never)).startswith("its reference system states no position better than 0.4 m")


def test_the_doctor_repeats_what_the_log_states() -> None:
    told = next(finding for finding in examine(Log(stated(drive(), 0.2))) if finding.code == "log.lost_fix")
    assert told.severity == "warning"
    assert "10 s, first at t = 20 s" in told.text


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("metres", [0.6, 3.0])
def test_the_doctor_finds_a_drift_that_nothing_states(metres: float, seed: int) -> None:
    found = codes(drifting(drive(120.0, seed=seed, noise=0.2), metres))
    assert "log.position_drift" in found


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
@pytest.mark.parametrize("noise", [0.2, 1.0, 3.0])
@pytest.mark.nightly(by_day=6)
def test_noise_alone_is_no_drift(noise: float, seed: int) -> None:
    assert "log.position_drift" not in codes(drive(120.0, seed=seed, noise=noise))


def test_a_wheel_that_is_off_and_an_antenna_elsewhere_are_no_drift() -> None:
    columns = drive(120.0, noise=0.2)
    ahead = {
        **columns,
        "v": 1.02 * columns["v"],
        "x": columns["x"] + 1.5 * np.cos(columns["yaw"]),
        "y": columns["y"] + 1.5 * np.sin(columns["yaw"]),
    }
    assert "log.position_drift" not in codes(ahead)


def test_a_drift_that_is_stated_is_told_once() -> None:
    found = codes(stated(drifting(drive(120.0, noise=0.2), 0.6), 0.3))
    assert "log.lost_fix" in found
    assert "log.position_drift" not in found


def test_a_deviation_that_is_stated_seldom_holds_until_the_next() -> None:
    columns = stated(drive(), 0.5)
    t = columns["t"]
    seldom = np.where(np.isclose(t % 1.0, 0.0, atol=1e-6), columns["position_sigma"], np.nan)
    assert lost_for(Log({**columns, "position_sigma": seldom})) == pytest.approx(10.0, abs=0.1)
