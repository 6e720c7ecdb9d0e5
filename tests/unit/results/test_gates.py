"""Verdicts: margins, messages, and nothing vacuous that passes."""

from __future__ import annotations

import dataclasses
import json
import re

import numpy as np
import pytest
from results_logs import drive_straight, log_of, times, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.metrics import Measured, known_metrics, metric, registry
from pytest_dvp.metrics.metric import REQUIRED
from pytest_dvp.verdicts.judging import Gate, GateFile, Verdict, default_gates, judge, judge_between, overall

CLOSING = drive_straight(5.0, objects={"target": track(times()[::5], 62.0, 0.0)})
"""Greatest inverse TTC 5.0 / 7.3 = 0.685 1/s at t = 10 s."""


def one(gate: Gate, log: Log = CLOSING) -> Verdict:
    (verdict,) = judge([gate], log)
    return verdict


def test_value_inside_its_bound_passes_with_the_distance_as_margin() -> None:
    verdict = one(Gate("max_ttc_inverse", max=1.0))
    assert verdict.status == "PASS"
    assert verdict.margin == pytest.approx(1.0 - 5.0 / 7.3)


def test_value_beyond_its_bound_fails_with_a_negative_margin() -> None:
    verdict = one(Gate("max_ttc_inverse", max=0.5))
    assert verdict.status == "FAIL"
    assert verdict.margin == pytest.approx(0.5 - 5.0 / 7.3)
    assert (verdict.bound, verdict.t, verdict.object, verdict.unit) == (0.5, 10.0, "target", "1/s")


def test_bounds_are_inclusive() -> None:
    assert one(Gate("collision", max=0.0)).status == "PASS"
    assert one(Gate("scenario_ended", min=0.0)).status == "PASS"


def test_nearer_of_two_bounds_gives_the_margin() -> None:
    verdict = one(Gate("max_ttc_inverse", min=0.6, max=2.0))
    assert (verdict.status, verdict.bound) == ("PASS", 0.6)


def test_share_of_a_bound_is_of_what_it_allows() -> None:
    """A slope of 0.98 where 1 is right is a tenth of the fifth that is allowed; else value over bound."""
    assert one(Gate("max_ttc_inverse", max=1.0)).used == pytest.approx(5.0 / 7.3)
    assert one(Gate("max_ttc_inverse", min=0.5)).used == pytest.approx(0.5 / (5.0 / 7.3))
    assert one(Gate("collision", max=0.0)).used is None
    t = times(40.0)
    bell = (t - 20.0) * np.exp(-(((t - 20.0) / 3.0) ** 2))
    drives = {"dt": log_of(40.0, columns={"v": bell}), "rw": log_of(40.0, columns={"v": 0.98 * bell})}
    gain = Gate("gain", min=0.8, max=1.4, between=("dt", "rw"), options={"signal": "v"})
    like = Gate("mncc", min=0.5, between=("dt", "rw"), options={"signal": "v"})
    found = judge_between([gain, like], ("dt", "rw"), drives)
    assert [verdict.used for verdict in found] == [pytest.approx(0.1), pytest.approx(0.0, abs=1e-6)]


def test_message_of_a_failure_leads_to_value_bound_time_object_and_gate() -> None:
    verdict = one(Gate("max_ttc_inverse", max=0.5, file="overtaking.gates.toml", line=12))
    assert verdict.short == "max_ttc_inverse 0.68 1/s > 0.50 at t=10.00 s (target)"
    assert verdict.message == f"{verdict.short}, margin -0.18 1/s, gate overtaking.gates.toml:12"


def test_counts_are_written_without_decimals() -> None:
    log = drive_straight(5.0, events=(LogEvent(3.0, "collision", "target"),))
    assert one(Gate("collision", max=0.0), log).short == "collision 1 > 0 at t=3.00 s (target)"


def test_failing_value_never_reads_like_its_bound() -> None:
    log = log_of(columns={"yaw_rate": 0.5000004})
    assert one(Gate("max_yaw_rate", max=0.5), log).short.startswith("max_yaw_rate 0.5000004 rad/s > 0.5 ")


def test_label_says_what_was_asked() -> None:
    assert one(Gate("max_ttc_inverse", min=0.0, max=0.5)).gate == "max_ttc_inverse >= 0.00 and <= 0.50 1/s"


def test_control_characters_of_a_name_do_not_reach_the_terminal() -> None:
    log = drive_straight(5.0, events=(LogEvent(3.0, "collision", "\x1b[31mred"),))
    assert "\x1b" not in one(Gate("collision", max=0.0), log).message


def test_undefined_metric_is_inconclusive_with_its_reason() -> None:
    verdict = one(Gate("completion_time", max=100.0, file="a.gates.toml", line=3))
    assert (verdict.status, verdict.value, verdict.margin) == ("INCONCLUSIVE", None, None)
    assert verdict.message == "completion_time INCONCLUSIVE: the goal was never reached, gate a.gates.toml:3"


@pytest.mark.parametrize("name", sorted(n for n, m in known_metrics().items() if REQUIRED not in m.options.values()))
@pytest.mark.parametrize("bound", [{"max": 1e9}, {"min": -1e9}])
def test_log_without_samples_passes_no_gate(name: str, bound: dict[str, float]) -> None:
    assert one(Gate(name, **bound), log_of(0.0)).status == "INCONCLUSIVE"


def test_gate_of_another_stage_is_not_judged() -> None:
    verdicts = judge([Gate("collision", max=0.0), Gate("collision", max=0.0, stages=("rw",), line=9)], CLOSING)
    assert [verdict.line for verdict in verdicts] == [None]


@pytest.mark.parametrize("gates", [[], [Gate("collision", max=0.0, stages=("rw",))], GateFile(None, ())])
def test_no_gate_that_applies_is_inconclusive(gates: list[Gate]) -> None:
    verdicts = judge(gates, CLOSING)
    assert overall(verdicts) == "INCONCLUSIVE"
    assert verdicts[0].message == "no gate applies to stage dt: nothing was judged"


def test_surrogate_is_judged_by_the_gates_of_its_stage() -> None:
    log = drive_straight(5.0, meta={"stage": "rw-surrogate"})
    assert one(Gate("collision", max=0.0, stages=("rw",)), log).status == "PASS"


LIKE = Gate("mncc", min=0.9, between=("dt", "rw"), options={"signal": "x"}, file="a.gates.toml", line=3)


def test_a_stage_alone_is_not_judged_by_gates_across_stages() -> None:
    assert [verdict.metric for verdict in judge([LIKE, Gate("collision", max=0.0)], CLOSING)] == ["collision"]


def test_a_file_of_gates_across_stages_leaves_each_stage_to_the_default_gates() -> None:
    assert [verdict.metric for verdict in judge([LIKE], CLOSING)] == ["collision", "road_departure", "scenario_ended"]


def test_gate_across_stages_is_inconclusive_without_the_other_log_and_says_how_to_get_it() -> None:
    (verdict,) = judge_between([LIKE], ("dt", "rw"), {"dt": CLOSING}, {"rw": "no drive of stage rw: pytest -m rw"})
    assert verdict.status == "INCONCLUSIVE"
    assert verdict.message == "mncc(x) INCONCLUSIVE: no drive of stage rw: pytest -m rw, gate a.gates.toml:3"
    assert judge_between([LIKE], ("dt", "rw"), {"rw": CLOSING})[0].status == "INCONCLUSIVE"


def test_gate_across_stages_is_judged_with_both_logs() -> None:
    (verdict,) = judge_between([LIKE], ("dt", "rw"), {"dt": CLOSING, "rw": CLOSING})
    assert (verdict.status, verdict.value) == ("PASS", pytest.approx(1.0))


def test_no_gate_between_two_stages_is_inconclusive() -> None:
    (verdict,) = judge_between([LIKE], ("dt", "pe"), {"dt": CLOSING, "pe": CLOSING})
    assert (verdict.status, verdict.short) == ("INCONCLUSIVE", "no gate is between dt and pe: nothing was judged")


def test_lag_between_stages_has_the_sign_of_the_second_one() -> None:
    wave = np.exp(-(((times() - 4.0) / 0.8) ** 2)) * (times() - 4.0)
    late = np.exp(-(((times() - 4.4) / 0.8) ** 2)) * (times() - 4.4)
    dt, rw = log_of(columns={"v": wave}), log_of(columns={"v": late}, meta={"stage": "rw"})
    gate = Gate("lag", max=0.1, between=("dt", "rw"), options={"signal": "v"})
    (verdict,) = judge_between([gate], ("dt", "rw"), {"dt": dt, "rw": rw})
    assert (verdict.status, verdict.value) == ("FAIL", pytest.approx(0.4))


@pytest.mark.parametrize(("allowed", "status"), [(0.49, "FAIL"), (0.51, "PASS")])
def test_a_metric_may_differ_between_stages_by_so_much_and_no_more(allowed: float, status: str) -> None:
    dt, rw = log_of(columns={"yaw_rate": 0.2}), log_of(columns={"yaw_rate": -0.7}, meta={"stage": "rw"})
    gate = Gate("max_yaw_rate", between=("dt", "rw"), max_difference=allowed)
    (verdict,) = judge_between([gate], ("dt", "rw"), {"dt": dt, "rw": rw})
    assert (verdict.status, verdict.value, verdict.unit) == (status, pytest.approx(0.5), "rad/s")
    assert verdict.name == "max_yaw_rate difference"
    assert verdict.object == "dt 0.20, rw 0.70"


def test_a_metric_that_one_stage_does_not_define_differs_by_nothing_that_passes() -> None:
    gate = Gate("completion_time", between=("dt", "rw"), max_difference=100.0)
    (verdict,) = judge_between([gate], ("dt", "rw"), {"dt": CLOSING, "rw": CLOSING})
    assert (verdict.status, verdict.short) == (
        "INCONCLUSIVE",
        "completion_time difference INCONCLUSIVE: stage dt: the goal was never reached",
    )


def test_metric_that_raises_is_an_error_and_the_others_are_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    @metric(name="broken", unit="-", bigger_is_worse=True)
    def broken(log: Log) -> Measured:
        """Broken."""
        raise ZeroDivisionError("division by zero")

    table = {**known_metrics(), "broken": broken}
    monkeypatch.setattr(registry, "known_metrics", lambda: table)
    verdicts = judge([Gate("broken", max=1.0), Gate("collision", max=0.0)], CLOSING)
    assert [verdict.status for verdict in verdicts] == ["ERROR", "PASS"]
    said = r"the metric failed: ZeroDivisionError: division by zero \(test_gates\.py:\d+\)"
    assert re.fullmatch(said, verdicts[0].reason)
    assert overall(verdicts) == "ERROR"


@pytest.mark.parametrize(
    ("statuses", "worst"),
    [
        (["PASS", "PASS"], "PASS"),
        (["PASS", "INCONCLUSIVE"], "INCONCLUSIVE"),
        (["INCONCLUSIVE", "FAIL", "PASS"], "FAIL"),
        (["FAIL", "ERROR"], "ERROR"),
        ([], "INCONCLUSIVE"),
    ],
)
def test_overall_is_the_worst(statuses: list[str], worst: str) -> None:
    base = one(Gate("collision", max=0.0))
    verdicts = [dataclasses.replace(base, status=status) for status in statuses]  # type: ignore[arg-type]
    assert overall(verdicts) == worst


def test_default_gates_are_contact_road_and_end() -> None:
    log = drive_straight(5.0, events=(LogEvent(9.0, "stop", "storyboard"),))
    log.columns["on_road"] = np.ones(len(log.t))
    assert [v.gate for v in judge(default_gates(), log)] == [
        "collision <= 0",
        "road_departure <= 0.00 s",
        "scenario_ended >= 1",
    ]
    assert overall(judge(default_gates(), log)) == "PASS"


def test_scenario_that_only_the_time_limit_ended_fails_the_default_gates() -> None:
    log = drive_straight(5.0, events=(LogEvent(10.0, "timeout", "duration"),))
    log.columns["on_road"] = np.ones(len(log.t))
    assert overall(judge(default_gates(), log)) == "FAIL"


def test_verdict_is_plain_data() -> None:
    assert json.loads(json.dumps(one(Gate("tet", max=0.0)).as_dict()))["status"] == "FAIL"
