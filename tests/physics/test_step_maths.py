"""Lags, limits, dead times and records of the past that effects share, against fine steps and drawn lines."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vehicle.model.step_maths import (
    DELAY_LINE,
    arrived,
    clip,
    delayed,
    lag,
    lag_end,
    limit_rate,
    recall,
    remember,
)


@pytest.mark.parametrize(("value", "clipped"), [(-3.0, -1.0), (-1.0, -1.0), (0.5, 0.5), (2.0, 2.0), (2.1, 2.0)])
def test_clip(value: float, clipped: float) -> None:
    assert clip(value, -1.0, 2.0) == clipped


def test_a_lag_ends_at_its_exponential() -> None:
    assert lag_end(1.0, 3.0, 0.5, 0.1) == pytest.approx(3.0 - 2.0 * math.exp(-0.2))
    assert lag_end(1.0, 3.0, 0.0, 0.1) == lag_end(1.0, 3.0, -1.0, 0.1) == 3.0


@pytest.mark.parametrize("lead", [0.0, 0.7, -1.3])
@pytest.mark.parametrize("tau", [0.02, 0.5])
def test_a_lag_of_a_straight_input_is_exact(lead: float, tau: float) -> None:
    """Against 20,000 steps of a held input; from 1, the input runs from 3 + lead to 3 - lead in 0.1 s."""
    y, total, n = 1.0, 0.0, 20_000
    h = 0.1 / n
    for k in range(n):
        u = 3.0 + lead * (1.0 - 2.0 * (k + 0.5) / n)
        after = u + (y - u) * math.exp(-h / tau)
        total += 0.5 * (y + after) * h
        y = after
    assert lag(1.0, 3.0, lead, tau, 0.1) == pytest.approx((total / 0.1, y), rel=1e-6)


@pytest.mark.parametrize(
    ("y", "u", "lead", "mean", "end"),
    [
        (0.0, 2.0, 0.0, 0.25, 0.5),  # 5 / s x 0.1 s and no more
        (0.0, -2.0, 0.0, -0.25, -0.5),
        (0.0, 2.0, 1.0, 0.25, 0.5),
        (0.0, 0.4, 0.0, 0.4 - 0.5 * 0.16 / 0.5, 0.4),  # there after 0.8 of the step
        (0.0, -0.4, 0.0, -0.4 + 0.5 * 0.16 / 0.5, -0.4),
        (0.3, 0.3, 0.0, 0.3, 0.3),
        (0.2, 0.3, 0.1, 0.3, 0.2),  # its end is reached: it follows
        (0.0, 0.3, -0.1, 0.3, 0.4),
    ],
)
def test_what_is_limited_in_its_rate_follows_no_faster(
    y: float, u: float, lead: float, mean: float, end: float
) -> None:
    assert limit_rate(y, u, lead, 5.0, 0.1) == pytest.approx((mean, end))


def test_a_limit_of_zero_stands_still() -> None:
    assert limit_rate(0.3, 2.0, 0.0, 0.0, 0.1) == (0.3, 0.3)
    assert limit_rate(0.3, 0.3, 0.0, 0.0, 0.1) == (0.3, 0.3)


def line(before: float = 0.0) -> Any:
    """Memory of a dead time."""
    return SimpleNamespace(head=0.0, tail=0.0, before=before, **{
        name: np.zeros(DELAY_LINE) for name in ("ring", "leads", "ends", "spans")
    })  # fmt: skip


STEPS = (0.1, 0.05, 0.2, 0.1, 0.1, 0.15, 0.1, 0.1)
INPUTS = ((1.0, 0.0), (3.0, -1.0), (2.0, 0.5), (-1.0, 0.0), (0.0, 0.0), (4.0, 2.0), (4.0, 0.0), (1.0, 1.0))


def passed(t: float, before: float) -> float:
    """The input at time t: straight within its steps, `before` ahead of the first."""
    begin = 0.0
    if t < 0.0:
        return before
    for dt, (mean, lead) in zip(STEPS, INPUTS, strict=True):
        if t < begin + dt:
            return mean + lead * (1.0 - 2.0 * (t - begin) / dt)
        begin += dt
    raise AssertionError


@pytest.mark.parametrize("delay", [0.03, 0.1, 0.15, 0.237, 0.4])
@pytest.mark.parametrize("before", [0.0, 2.5])
def test_a_dead_time_shows_the_input_of_before(delay: float, before: float) -> None:
    """Steps of several lengths; the mean over each by 4,000 samples, the lead by the value at its start."""
    m, t = line(before), 0.0
    for dt, (u, lead) in zip(STEPS, INPUTS, strict=True):
        mean, ahead = delayed(m, u, lead, delay, t, dt)
        samples = [passed(t - delay + dt * (k + 0.5) / 4000, before) for k in range(4000)]
        assert mean == pytest.approx(sum(samples) / 4000, abs=3e-3)
        assert mean + ahead == pytest.approx(passed(t - delay + 1e-12, before), abs=1e-6)
        t += dt


@pytest.mark.parametrize("delay", [0.0, -1.0])
def test_without_a_dead_time_the_input_passes(delay: float) -> None:
    m = line()
    assert delayed(m, 3.0, 0.5, delay, 0.0, 0.1) == (3.0, 0.5)
    assert (m.head, m.tail, m.ring[0], m.ends[0], m.spans[0]) == (1.0, 0.0, 3.0, 0.1, 0.1)


def test_a_dead_time_survives_the_end_of_its_line() -> None:
    """More steps than the line is long: 0.25 s of 0.01 s are 25 steps."""
    m, n = line(), DELAY_LINE + 300
    seen = [delayed(m, float(k), 0.0, 0.25, 0.01 * k, 0.01)[0] for k in range(n)]
    assert seen[25:] == pytest.approx([float(k) for k in range(n - 25)], abs=1e-4)


@pytest.mark.parametrize(("delay", "arrives"), [(0.0, 3.0), (0.05, 3.0), (0.1, 2.0), (0.15, 2.0), (0.25, 1.0)])
def test_what_has_arrived_is_the_input_that_holds_at_the_end_of_the_step(delay: float, arrives: float) -> None:
    """1, 2 and 3 over 0.1 s each; at 0.3 s the one of `delay` ago, at its end still that of before."""
    m = line()
    for k in range(3):
        delayed(m, k + 1.0, 0.0, delay, 0.1 * k, 0.1)
    assert arrived(m, delay, 0.2, 0.1) == arrives


def record() -> Any:
    return SimpleNamespace(head=0.0, tail=0.0, times=np.zeros(DELAY_LINE))


@pytest.mark.parametrize(
    ("t", "found"),
    [(-1.0, (0, 1, 0.0)), (0.0, (0, 1, 0.0)), (0.05, (0, 1, 0.5)), (0.1, (1, 2, 0.0)), (0.25, (1, 2, 0.75)),
     (0.3, (2, 3, 0.0)), (0.4, (3, 3, 0.0)), (0.9, (3, 3, 0.0))],
)  # fmt: skip
def test_a_record_is_read_between_its_stamps(t: float, found: tuple[int, int, float]) -> None:
    m = record()
    assert [remember(m, time) for time in (0.0, 0.1, 0.3, 0.4)] == [0, 1, 2, 3]
    assert recall(m, t) == pytest.approx(found)


def test_a_record_of_one_stamp_is_that_stamp() -> None:
    m = record()
    remember(m, 0.5)
    assert recall(m, 0.2) == recall(m, 0.7) == (0, 0, 0.0)


def test_a_record_forgets_what_its_line_cannot_hold() -> None:
    m = record()
    for k in range(DELAY_LINE + 5):
        assert remember(m, 0.1 * k) == k % DELAY_LINE
    assert recall(m, 0.0)[:2] == (5, 6)
    last = 0.1 * (DELAY_LINE + 3.25)
    assert recall(m, last) == (3, 4, pytest.approx(0.25))
    assert recall(m, last)[:2] == (3, 4)  # once it has gone on it does not look back
    assert recall(m, 0.0)[0] == 3
