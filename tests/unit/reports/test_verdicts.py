"""What the reader sees first: what failed, else what came closest to it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.verdicts.gate import Gate
from pytest_dvp.verdicts.judging import judge
from reports.verdicts import headline, rows


def verdict(metric: str, value: float | None, bound: float, status: str = "PASS", **more: Any) -> dict[str, Any]:
    sign = more.pop("sign", "<=")
    unit = more.pop("unit", "m")
    return {"gate": f"{metric} {sign} {bound}", "metric": metric, "value": value, "bound": bound, "status": status,
            "unit": unit, "margin": None, **more}  # fmt: skip


def test_failed_gate_comes_first() -> None:
    table = rows([verdict("near", 0.99, 1.0), verdict("broken", 1.1, 1.0, "FAIL")])
    assert [row.metric for row in table] == ["broken", "near"]


def test_gates_that_passed_come_by_the_share_of_their_bound() -> None:
    table = rows([verdict("far", 1.0, 10.0), verdict("near", 9.0, 10.0), verdict("middle", 2.0, 4.0)])
    assert [row.metric for row in table] == ["near", "middle", "far"]


def test_no_collision_is_not_close_to_failing() -> None:
    table = rows([verdict("collision", 0.0, 0.0, unit="-"), verdict("rmse", 0.3, 0.4)])
    assert [row.metric for row in table] == ["rmse", "collision"]


def test_least_value_uses_its_bound_the_other_way() -> None:
    (row,) = rows([verdict("mncc", 1.0, 0.5, sign=">=", unit="x")])
    assert row.used == 0.5
    assert row.limit == "≥ 0.5"


def test_the_share_is_the_one_that_the_verdict_tells() -> None:
    (row,) = rows([verdict("mncc", 0.9999, 0.999, sign=">=", used=0.1)])
    assert (row.used, row.used_percent) == (0.1, 10.0)


@pytest.mark.parametrize(("value", "limit"), [(1.0, "≥ 1"), (2.0, "≤ 2")])
def test_just_at_one_of_two_bounds_the_sign_is_of_that_one(value: float, limit: str) -> None:
    began = tuple(LogEvent(float(k), "story.event", "E", "> runningState") for k in range(int(value)))
    log = Log({"t": np.arange(10.0)}, events=began, meta={"storyboard_events": ["E"]})
    found = judge([Gate("event_started", min=1.0, max=2.0, options={"event": "E"})], log)
    (row,) = rows([found[0].as_dict()])
    assert (row.status, row.limit) == ("PASS", limit)


def test_inconclusive_stands_before_passes() -> None:
    table = rows([verdict("passed", 0.99, 1.0), verdict("unknown", None, 1.0, "INCONCLUSIVE")])
    assert table[0].metric == "unknown"


def test_headline_of_a_pass_names_the_closest() -> None:
    table = rows([verdict("jerk", 3.9, 4.0, t=7.42, object="Target", unit="m/s^3"), verdict("rmse", 0.1, 0.4)])
    assert headline("PASS", table) == (
        "All 2 gates passed. Closest to failing: jerk 3.9 m/s³ (must be ≤ 4) at 7.42 s, Target."
    )


def test_bounds_of_clean_drives_come_after_the_gates_and_are_not_what_nearly_failed() -> None:
    table = rows([verdict("habit", 0.99, 1.0, clean=True), verdict("rmse", 0.1, 0.4)])
    assert [(row.metric, row.is_folded) for row in table] == [("rmse", False), ("habit", True)]
    assert headline("PASS", table) == (
        "The gate passed, and so did 1 bound of clean drives. Closest to failing: rmse 0.1 m (must be ≤ 0.4)."
    )
    broken = rows([verdict("habit", 9.0, 1.0, "FAIL", clean=True), verdict("rmse", 0.5, 0.4, "FAIL")])
    assert [(row.metric, row.is_folded) for row in broken] == [("rmse", False), ("habit", False)]


def test_headline_of_a_failure_names_the_worst() -> None:
    table = rows([verdict("jerk", 9.0, 4.0, "FAIL", unit="m/s^3"), verdict("rmse", 0.1, 0.4)])
    assert headline("FAIL", table) == "1 of 2 gates did not pass. Worst: jerk 9 m/s³ (must be ≤ 4)."


def test_headline_without_gates_claims_nothing() -> None:
    assert headline("INCONCLUSIVE", []) == "No gate was judged."


def test_of_a_gate_with_two_bounds_the_nearer_one_is_shown_with_its_own_sign() -> None:
    both = "gain >= 0.95 and <= 1.05"
    (upper,) = rows([{**verdict("gain", 1.04, 1.05), "gate": both, "margin": 0.01}])
    (lower,) = rows([{**verdict("gain", 0.96, 0.95), "gate": both, "margin": 0.01}])
    (broken,) = rows([{**verdict("gain", 1.19, 1.05, "FAIL"), "gate": both, "margin": -0.14}])
    assert (upper.limit, lower.limit, broken.limit) == ("≤ 1.05", "≥ 0.95", "≤ 1.05")


def test_gates_that_share_a_reason_are_told_by_it() -> None:
    lost = {"status": "INCONCLUSIVE", "reason": "no log of stage rw"}
    table = rows([verdict(name, None, 1.0, **lost) for name in ("a", "b")])
    assert headline("INCONCLUSIVE", table) == "2 of 2 gates were not judged: no log of stage rw."


def test_what_broke_the_run_itself_is_said_and_is_no_gate() -> None:
    broken = verdict("", None, None, "ERROR", gate="run", message="run ERROR: ValueError: boom at t=1.50 s", t=1.5)
    table = rows([broken, verdict("jerk", None, 4.0, "INCONCLUSIVE"), verdict("rmse", 0.1, 0.4)])
    assert headline("ERROR", table) == "1 of 2 gates did not pass. Worst: run ERROR: ValueError: boom at t=1.50 s."
    assert table[0].name == "run"
    assert headline("ERROR", rows([broken])) == "Worst: run ERROR: ValueError: boom at t=1.50 s."


def test_bounds_of_clean_drives_are_counted_apart_from_gates() -> None:
    bounds = [verdict(f"habit{k}", 0.5, 1.0, clean=True) for k in range(3)]
    missed = verdict("habit", 9.0, 1.0, "FAIL", clean=True)
    table = rows([verdict("rmse", 0.5, 0.4, "FAIL"), verdict("jerk", 1.0, 4.0), missed, *bounds])
    assert headline("FAIL", table).startswith(
        "1 of 2 gates and 1 of 4 bounds of clean drives did not pass. Worst: rmse"
    )
    alone = rows([verdict("rmse", 0.1, 0.4), missed, *bounds])
    assert headline("FAIL", alone).startswith("1 of 4 bounds of clean drives did not pass. Worst: habit")


def test_a_ratio_with_a_whole_bound_is_no_count() -> None:
    (ratio, count) = rows(
        [verdict("nis", 2.97, 3.0, unit="-", used=0.99), verdict("missed", 1.0, 2.0, unit="-", used=0.5)]
    )
    assert (ratio.used, count.used) == (0.99, None)
    assert "Closest to failing: nis" in headline("PASS", [ratio, count])
