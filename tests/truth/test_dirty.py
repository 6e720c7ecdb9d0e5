"""Dirt is what it says, and leaves the clean log alone."""

from __future__ import annotations

import numpy as np
import pytest

from tests.truth.dirty import KINDS, dirty
from tests.truth.generate import make_log


@pytest.mark.parametrize("name", sorted(KINDS))
def test_each_kind_changes_the_log_and_not_the_original(name: str) -> None:
    clean = make_log({}, "urban", 1)
    before = {c: values.copy() for c, values in clean.items()}
    log = dirty(clean, name, 3)
    assert set(log) != set(clean) or any(not np.array_equal(log[c], clean[c], equal_nan=True) for c in clean)
    assert all(np.array_equal(before[c], clean[c]) for c in clean)
    assert len({len(values) for values in log.values()}) == 1
    again = dirty(clean, name, 3)
    assert all(np.array_equal(log[c], again[c], equal_nan=True) for c in log)


def test_jitter_keeps_the_order_and_five_percent() -> None:
    clean = make_log({}, "rich", 1)
    steps = np.diff(dirty(clean, "jitter")["t"])
    assert np.all(steps > 0.0)
    assert np.std(steps) == pytest.approx(0.05 * 0.02 * np.sqrt(2.0), rel=0.1)


def test_a_late_clock_shifts_what_is_measured() -> None:
    clean = make_log({}, "urban", 1)
    late = dirty(clean, "clock_offset")
    assert np.array_equal(late["v"][10:], clean["v"][:-10])
    assert np.array_equal(late["accel_cmd"], clean["accel_cmd"])


def test_unknown_dirt_is_refused() -> None:
    with pytest.raises(ValueError, match="no kind of dirt called 'mud'"):
        dirty({}, "mud")
