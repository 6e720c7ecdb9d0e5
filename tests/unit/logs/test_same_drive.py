"""Two logs of the same drive are recognised by what they hold."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pytest_dvp.cli.shared.same_drive import shared_rows
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_part import cut_log


def log(seed: int, *, noise: float = 0.01, rows: int = 200) -> Log:
    """A car that stands for the first half and then drives; two columns."""
    t = 0.02 * np.arange(rows)
    v = np.maximum(t - t[rows // 2], 0.0) + noise * np.random.default_rng(seed).standard_normal(rows)
    return Log({"t": t, "v": v, "x": np.cumsum(0.02 * v)})


def test_a_copy_is_the_same_drive_whatever_its_clock_and_further_columns() -> None:
    copy = log(1)
    other = dataclasses.replace(copy, columns={**copy.columns, "t": copy.t + 7.0, "soc": copy.t})
    assert shared_rows(log(1), other) == 200


def test_a_part_of_a_log_is_the_same_drive() -> None:
    assert shared_rows(log(1), cut_log(log(1), 1.0, 2.0)) == pytest.approx(50, abs=1)


def test_two_measured_drives_share_no_row() -> None:
    assert shared_rows(log(1), log(2)) == 0


def test_standstill_is_nobody_s_drive() -> None:
    """Without noise all rows at rest are alike; what is driven afterwards is not."""
    still = log(1, noise=0.0)
    faster = {name: values * (1.0 if name == "t" else 1.3) for name, values in still.columns.items()}
    assert shared_rows(still, Log(faster)) == 0


def test_a_short_common_beginning_is_not_the_same_drive() -> None:
    one, two = log(1), log(2)
    mixed = {name: np.concatenate([one.columns[name][:80], values[80:]]) for name, values in two.columns.items()}
    assert shared_rows(one, Log(mixed)) == 0
