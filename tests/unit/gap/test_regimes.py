"""Regimes of a drive whose phases are known."""

from __future__ import annotations

import numpy as np
from gap_logs import drive

from pytest_dvp.gap.compare.regimes import LONGITUDINAL, REGIMES, regimes, ribbon, speed_bins

LOG = drive(40.0, noise=0.3)
MASKS = regimes(LOG.t, LOG["v"], LOG["yaw_rate"], LOG["accel_cmd"])
SECOND = LOG.t - 20.0  # of the second round: launch 0-5 s, cruise with a turn, braking 12-17 s, standstill


def share(name: str, begin: float, end: float) -> float:
    return float(MASKS[name][(begin <= SECOND) & (end > SECOND)].mean())


def test_every_sample_has_exactly_one_longitudinal_regime() -> None:
    assert (sum(MASKS[name].astype(int) for name in LONGITUDINAL) == 1).all()


def test_the_names_are_those_of_the_contract() -> None:
    assert tuple(MASKS) == REGIMES


def test_launch_is_where_it_starts_from_standstill() -> None:
    assert share("launch", 0.5, 2.0) > 0.9
    assert share("launch", 8.0, 20.0) == 0.0


def test_lift_off_follows_the_withdrawn_demand() -> None:
    assert share("lift_off", 5.1, 6.8) > 0.9
    assert share("lift_off", 8.0, 12.0) == 0.0


def test_cruise_has_no_demand() -> None:
    assert share("cruise", 7.5, 11.5) > 0.9


def test_braking_ends_at_standstill() -> None:
    assert share("braking", 12.5, 15.5) > 0.9
    assert share("standstill", 17.0, 19.5) > 0.9


def test_turns_are_turn_in_or_steady() -> None:
    turning = MASKS["turn_in"] | MASKS["steady_turn"]
    assert turning[(SECOND > 6.5) & (SECOND < 10.5)].mean() > 0.8
    assert turning[(SECOND > 1.0) & (SECOND < 5.5)].mean() < 0.05


def test_constant_turn_is_steady_after_its_beginning() -> None:
    t = np.arange(0.0, 20.0, 0.02)
    rate = np.where(t > 5.0, 0.3, 0.0)
    masks = regimes(t, np.full(len(t), 8.0), rate)
    assert masks["turn_in"][(t > 4.9) & (t < 5.2)].any()
    assert masks["steady_turn"][t > 7.0].all()


def test_negative_speed_is_reverse() -> None:
    t = np.arange(0.0, 20.0, 0.02)
    masks = regimes(t, np.where(t < 10.0, 2.0, -2.0), np.zeros(len(t)))
    assert masks["reverse"][t > 11.0].all()
    assert not masks["reverse"][t < 9.0].any()


def test_speed_bins_cover_every_sample_once_with_round_edges() -> None:
    bins = speed_bins(np.linspace(0.0, 19.0, 500))
    assert list(bins) == ["speed 0-5 m/s", "speed 5-10 m/s", "speed 10-15 m/s", "speed 15-20 m/s"]
    assert (sum(mask.astype(int) for mask in bins.values()) == 1).all()


def test_ribbon_tells_runs_in_order_of_time() -> None:
    runs = ribbon(MASKS, LONGITUDINAL, LOG.t)
    assert [begin for _, begin, _ in runs] == sorted(begin for _, begin, _ in runs)
    assert {name for name, *_ in runs} <= set(LONGITUDINAL)
