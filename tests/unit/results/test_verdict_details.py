"""Details of verdicts: which are of the run itself, what a command was told, whose detection is whose."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from pytest_dvp.metrics._track_matches import _assigned, _Pairs
from pytest_dvp.verdicts.broken_run import is_of_the_run
from pytest_dvp.verdicts.requirement import wrong_requirement
from pytest_dvp.verdicts.result_text import condition_of, on_condition


@pytest.mark.parametrize(
    ("metric", "gate", "own"),
    [
        ("", "run", True),
        ("", "wire", True),
        ("", "dry run", True),
        ("", "a.toml:3", False),
        ("collision", "run", False),
    ],
)
def test_a_verdict_is_of_the_run_if_it_has_no_metric_and_is_called_so(metric: str, gate: str, own: bool) -> None:
    assert is_of_the_run({"metric": metric, "gate": gate}) is own


def test_what_was_added_to_a_command_is_what_follows_it() -> None:
    plain = "dvp run a.xosc --seed 3"
    assert condition_of(plain) == ""
    for metrics, optional in ((["collision"], []), ([], ["stop here"]), (["a", "b"], ["c"])):
        whole = on_condition(plain, metrics, optional)
        assert condition_of(whole) == whole.removeprefix(plain)
        assert condition_of(whole).startswith(" --")
    assert condition_of("in the test" + on_condition(plain, ["collision"]).removeprefix(plain)) == ""


def test_what_is_no_id_of_a_requirement_is_shown_with_80_letters() -> None:
    shown = wrong_requirement(list(range(100)))
    assert repr(str(list(range(100)))[:80]) in shown
    assert len(repr(str(list(range(100)))[:80])) == 82


@pytest.mark.parametrize("instants", [1, 2])
def test_where_somebody_has_a_choice_most_are_served_and_then_the_sum_is_least(instants: int) -> None:
    """Three rows and three detections at each instant; against all ways to share them out."""
    rng = np.random.default_rng(8)
    instant = np.repeat(np.arange(instants), 9)
    row = np.concatenate([np.repeat([0, 1, 2], 3) + 3 * k for k in range(instants)])
    detection = np.concatenate([np.tile([0, 1, 2], 3) + 3 * k for k in range(instants)])
    for _ in range(20):
        apart = rng.uniform(0.0, 2.0, len(row))
        close = apart < 1.3
        found = _assigned(_Pairs(instant, row, detection, apart), close, 3 * instants)
        for first in range(0, 3 * instants, 3):
            cost = {(row[k], detection[k]): apart[k] for k in range(len(row)) if close[k]}
            ways = []
            for order in permutations(range(first, first + 3)):
                served = [(r, d) for r, d in zip(range(first, first + 3), order, strict=True) if (r, d) in cost]
                ways.append((-len(served), sum(cost[pair] for pair in served)))
            told = [(r, found[r]) for r in range(first, first + 3) if found[r] >= 0]
            fewest, least = min(ways)
            assert (-len(told), sum(cost[pair] for pair in told)) == (fewest, pytest.approx(least))
