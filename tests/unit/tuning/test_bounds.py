"""Whether two stages are alike in a metric: by the interval of their difference, not by how little is known of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.tuning.held_out_judge import HeldOutScore
from pytest_dvp.tuning.iteration_plan import State
from pytest_dvp.tuning.objective import Score
from pytest_dvp.tuning.result_bounds import DRIVE, EQUIVALENT, LIKENESS, Bound, bounds
from pytest_dvp.tuning.stage_gap import Figure, Gap, figure

JERK = "max jerk"  # its bound is 1.8 m/s^3: 2 % are 0.036
TIME = "completion time"  # has none; 40 s here: 2 % are 0.8 s


def judged(name: str, twin: Sequence[float | None], car: Sequence[float | None]) -> HeldOutScore:
    """What the judge says after repeats that gave these values of one metric; every other one is 0 on all stages."""
    nought = [0.0] * len(twin)
    metrics = {
        stage: {row: _figure(row, values if row == name else nought) for row in (*DRIVE, *EQUIVALENT)}
        for stage, values in (("dt", twin), ("pe", car), ("rw", car))
    }
    difference = {
        pair: {
            row: _figure(row, [b - a for a, b in zip(one, car, strict=True) if a is not None and b is not None])
            if row == name
            else _figure(row, nought)
            for row in EQUIVALENT
        }
        for pair, one in (("dt-rw", twin), ("pe-rw", car))
    }
    alike = {f"{row}{part}": Figure(1.0 if not part else 0.0, 0.0, 1.0, 1, 1)
             for row in LIKENESS for part in ("", ".lag", ".gain")}  # fmt: skip
    gap = Gap({}, metrics, difference, {"dt-rw": alike, "pe-rw": alike})
    return HeldOutScore(State(Path("twin.toml"), {}, {}), Score(0.0, {}), 0.0, 0.01, 0.01, gap, ())


def _figure(name: str, values: Sequence[float | None]) -> Figure:
    return figure(name, list(enumerate(values)))


def row(found: HeldOutScore, name: str, pair: str = "dt-rw") -> Bound:
    return next(b for b in bounds(found, found) if b.what == f"{name}, between stages" and b.where == pair)


def test_stages_that_are_the_same_hold_every_bound() -> None:
    same = judged(JERK, [1.2, 1.21, 1.19], [1.2, 1.21, 1.19])
    assert all(bound.holds for bound in bounds(same, same))


@pytest.mark.parametrize(("name", "base"), [(JERK, 1.2), (TIME, 40.0)])
@pytest.mark.parametrize("share", [0.0, 0.7, 0.8])
def test_alike_is_an_interval_that_lies_within_the_margin(name: str, base: float, share: float) -> None:
    """Differences d - e, d, d + e: mean d, half width t(0.975, 2) e / sqrt(3) = 4.3027 e / 1.7321."""
    margin = 0.036 if name == JERK else 0.02 * base / (1.0 - 0.02 * share)  # 2 % of 1.8, or of base + share * margin
    d, e = share * margin, 0.1 * margin
    half = 4.30265 * e / 3**0.5  # 0.248 of the margin
    found = row(judged(name, [base] * 3, [base + d - e, base + d, base + d + e]), name)
    assert found.value == pytest.approx(d)
    assert found.half_width == pytest.approx(half, rel=1e-4)
    assert found.holds is (share < 0.75)


def test_few_repeats_that_scatter_are_no_evidence_of_likeness() -> None:
    """Their intervals meet, and far apart the stages may be all the same."""
    found = row(judged(JERK, [1.1, 1.3], [1.15, 1.35]), JERK)
    assert found.value == pytest.approx(0.05)
    assert not found.holds


def test_too_few_repeats_are_undecided_and_a_difference_beyond_the_margin_is_not() -> None:
    scattered = row(judged(JERK, [1.1, 1.3], [1.3, 1.1]), JERK)  # difference 0, half width 12.7 * 0.2
    assert (scattered.holds, scattered.undecided) == (False, True)
    apart = row(judged(JERK, [1.2, 1.2, 1.2], [1.3, 1.3, 1.301]), JERK)
    assert (apart.holds, apart.undecided) == (False, False)
    alike = row(judged(JERK, [1.2, 1.2], [1.2, 1.2]), JERK)
    assert (alike.holds, alike.undecided) == (True, False)


def test_a_difference_that_can_be_told_but_does_not_matter_is_alike() -> None:
    draw = np.random.default_rng(1)
    twin, car = (mean + 0.003 * draw.standard_normal(25) for mean in (1.18, 1.2))
    found = row(judged(JERK, twin.tolist(), car.tolist()), JERK)
    assert found.half_width is not None
    assert found.value is not None
    assert abs(found.value) > 5.0 * found.half_width
    assert found.holds


def test_one_repeat_alone_decides_nothing() -> None:
    assert not row(judged(JERK, [1.2], [1.2]), JERK).holds


def test_a_drive_that_leaves_the_metric_undefined_is_not_passed_over() -> None:
    found = row(judged(JERK, [1.2, 1.2, None], [1.2, 1.2, 1.2]), JERK)
    assert not found.holds
    assert found.value is None
