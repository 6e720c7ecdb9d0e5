"""Which cell a row of a log belongs to when an error is looked for again, and which segments a false heading takes."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare import segments as segments_module
from pytest_dvp.gap.compare.segments import cut
from pytest_dvp.gap.diagnose import residual_recurrence as recurrence


@pytest.fixture
def cells(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function that gives the cells of the rows of some logs."""
    monkeypatch.setattr(recurrence, "_comes_back", lambda errors, motions, cell: cell)

    def of(ask: Any, *motions: Any) -> list[int]:
        return [int(one) for one in ask([], [SimpleNamespace(**motion) for motion in motions])]

    return of


def test_directions_are_eighths_of_a_turn_whichever_way_it_was_counted(cells: Any) -> None:
    eighth = math.pi / 4.0
    yaw = np.array(
        [0.01, 0.99 * eighth, 1.01 * eighth, 3.5 * eighth, 7.99 * eighth, -0.01, 8.01 * eighth, -8.5 * eighth]
    )
    found = cells(recurrence.in_same_direction, {"yaw": yaw[:5]}, {"yaw": yaw[5:]})
    assert found == [0, 0, 1, 3, 7, 7, 0, 7]


@pytest.mark.parametrize("wide", [False, True])
def test_places_are_squares_of_a_thirtysecond_of_the_longer_side(wide: bool, cells: Any) -> None:
    """A map of 64 m: squares of 2 m; two logs share them."""
    long, short = np.array([0.5, 1.99, 2.01, 64.5]), np.array([0.1, 1.99, 0.1, 0.1])
    again, beside = np.array([1.0, 1.0]), np.array([0.5, 2.01])
    first = {"x": long, "y": short} if wide else {"x": short, "y": long}
    second = {"x": again, "y": beside} if wide else {"x": beside, "y": again}
    a, b, c, d, e, f = cells(recurrence.at_same_place, first, second)
    assert a == b == e
    assert len({a, c, d, f}) == 4


def test_a_segment_whose_heading_is_contradicted_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    t = np.arange(1280) / 64.0
    measured = np.zeros((1280, 8))
    measured[:, 0], measured[:, 3], measured[:, 2], measured[:, 4] = 10.0 * t, 10.0, 0.25, 0.125
    asked: list[Any] = []

    def faults(t: Any, yaw: Any, rate: Any, starts: Any, ends: Any, counted: Any) -> Any:
        asked.append(
            (float(yaw[0]), float(rate[0]), starts.tolist(), int(counted[:64].sum()), bool(counted[64:].all()))
        )
        return np.arange(len(starts)) == 1

    monkeypatch.setattr(segments_module, "heading_faults", faults)
    found = cut(t, measured)
    starts = found.starts.tolist()
    assert asked == [(0.25, 0.125, starts, 32, True)]  # what is lost is not asked about: half a second at the start
    assert np.flatnonzero(~found.counted).tolist() == [*range(32), *range(starts[1], starts[2])]
    assert np.flatnonzero(found.lost).tolist() == list(range(32))
