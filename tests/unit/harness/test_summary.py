"""What a session says at its end, from plain results: what comes first, what counts, what to do next."""

from __future__ import annotations

from typing import Any

import pytest

from pytest_dvp.plugin import session_summary
from pytest_dvp.plugin.run_summary import RunSummary
from pytest_dvp.verdicts.result_text import failure
from pytest_dvp.verdicts.statuses import worst_first
from reports.verdicts import SEVERITY, headline, rows


def verdict(metric: str, value: float, bound: float, status: str, **more: Any) -> dict[str, Any]:
    short = f"{metric} {value:g} against {bound:g}"
    return {"gate": f"{metric} <= {bound:g}", "metric": metric, "name": metric, "value": value, "bound": bound,
            "unit": "-", "status": status, "margin": bound - value, "used": value / bound if bound else None, "t": 1.0,
            "object": "", "reason": "", "file": "x.gates.toml", "line": 1, "short": short, "message": short,
            **more}  # fmt: skip


def result(*verdicts: dict[str, Any], **more: Any) -> dict[str, Any]:
    status = min((each["status"] for each in verdicts), key=list(SEVERITY).index)
    return {"scenario": "x.xosc", "line": 1, "stage": "dt", "seed": 7, "ads": "reference", "status": status,
            "verdicts": list(verdicts), "metrics": {}, "set": {}, "folder": None, "error": None, "simulated": 3.0,
            "replay": "dvp run x.xosc --seed 7", "nodeid": "x.xosc::dt", **more}  # fmt: skip


CRASH = result(
    verdict("max_ttc_inverse", 100.0, 0.4, "FAIL"),  # 250 times its bound
    verdict("jerk", 5.0, 4.0, "FAIL"),
    verdict("road_departure", 0.1, 0.0, "FAIL"),
    verdict("collision", 1.0, 0.0, "FAIL"),
    verdict("rmse", 0.1, 0.4, "PASS"),
)


def test_a_crash_is_the_headline_everywhere() -> None:
    harm_first = ["collision", "road_departure", "max_ttc_inverse", "jerk", "rmse"]
    assert [each["metric"] for each in worst_first(CRASH["verdicts"])] == harm_first
    table = rows(CRASH["verdicts"])
    assert [row.metric for row in table] == harm_first
    assert "Worst: collision 1" in headline("FAIL", table)
    assert (failure(CRASH) or "").startswith("collision 1 against 0")
    assert "collision" in session_summary.lines([CRASH])[1]
    assert "::collision 1 against 0" in session_summary.github_annotations([CRASH])[0]


def test_what_broke_the_run_itself_stands_before_a_crash() -> None:
    broken = verdict("", 0.0, 0.0, "FAIL", short="the car is lost")
    assert (failure(result(*CRASH["verdicts"], broken)) or "").startswith("the car is lost")


LEFT_OUT = result(
    verdict("collision", 1.0, 0.0, "FAIL"), verdict("max_ttc_inverse", 0.2, 0.4, "PASS"), verdict("jerk", 1, 4, "PASS")
)


def test_a_gate_that_a_passed_test_left_out_is_no_failure_and_the_replay_says_which_was_meant() -> None:
    noted = RunSummary(LEFT_OUT)
    noted.add_request(["max_ttc_inverse"], passed=True)
    lines = session_summary.lines([noted.reported_run(failed=False)])
    assert lines[0] == "1 run, 3 gates: 2 PASS, 1 NOT ASKED"
    assert lines[1].startswith("NOT ASKED    x.xosc::dt collision 1 against 0")  # harm stands first
    assert len(lines) == 5  # and nothing says that it was never judged
    assert lines[-1] == "see it again: dvp run x.xosc --seed 7 --gate max_ttc_inverse"
    assert session_summary.github_annotations([noted.reported_run(failed=False)]) == []


def test_a_passed_test_that_asks_for_no_gate_has_no_failures() -> None:
    told = RunSummary(LEFT_OUT).reported_run(failed=False)
    assert told["status"] == "PASS"
    assert session_summary.lines([told])[-1] == "see it again: dvp run x.xosc --seed 7"


def test_what_was_not_asked_for_and_did_not_pass_stands_before_what_passed() -> None:
    harsh = verdict("jerk", 9.0, 4.0, "FAIL")
    noted = RunSummary(result(verdict("rmse", 0.1, 0.4, "PASS"), harsh, verdict("collision", 1.0, 0.0, "FAIL")))
    told = noted.reported_run(failed=False)
    slow = result(verdict("completion_time", 80.0, 70.0, "FAIL"), nodeid="y.xosc::dt")
    lines = session_summary.lines([slow, told])
    metrics = ["collision", "completion_time", "jerk", "rmse"]
    assert [next(m for m in metrics if f" {m} " in line) for line in lines[1:5]] == metrics
    assert lines[5] == "x.xosc::dt: never judged: 2 gates did not pass, and the test never calls gate(result)"
    assert lines[-1].startswith("replay the worst: ")  # of the test that failed


def test_a_run_that_nobody_judged_and_that_would_have_passed_is_no_warning() -> None:
    told = RunSummary(result(verdict("jerk", 1.0, 4.0, "PASS"))).reported_run(failed=False)
    assert not session_summary.never_judged([told])
    assert not session_summary.never_judged([RunSummary(LEFT_OUT).reported_run(failed=True)])  # its failure says it


def test_a_failed_test_that_asks_for_no_gate_shows_what_its_gates_say() -> None:
    told = RunSummary(LEFT_OUT).reported_run(failed=True)
    assert session_summary.lines([told])[-1] == "replay the worst: dvp run x.xosc --seed 7"


@pytest.mark.parametrize(("gate", "status"), [("run", "ERROR"), ("wire", "INCONCLUSIVE"), ("dry run", "INCONCLUSIVE")])
def test_no_choice_of_gates_leaves_out_what_breaks_the_run_itself(gate: str, status: str) -> None:
    broken = verdict("", 0.0, 0.0, status, gate=gate, short=f"{gate} broke")
    run = result(broken, verdict("jerk", 1.0, 4.0, "PASS"))
    assert (failure(run, ["jerk"]) or "").startswith(f"{gate} broke")
    assert RunSummary(run).reported_run(failed=False)["status"] == status


def test_the_tightest_of_a_passed_tests_runs_stands_for_all_and_the_last_of_a_failed_ones() -> None:
    def drive(ttc: float, jerk: float, name: str) -> dict[str, Any]:
        verdicts = verdict("max_ttc_inverse", ttc, 0.4, "PASS"), verdict("jerk", jerk, 4.0, "PASS")
        return result(*verdicts, replay=f"dvp run x.xosc --set lead={name}")

    noted = RunSummary(drive(0.1, 1.0, "a"))
    noted.add_request(["max_ttc_inverse"], passed=True)
    for each in (drive(0.36, 1.0, "b"), drive(0.2, 3.9, "c")):  # 90 % of what is asked for, and 97 % of what is not
        noted.add_run(each)
    lines = session_summary.lines([{**noted.reported_run(failed=False), "nodeid": "test_x.py::test_fuzz"}])
    assert lines[0] == "3 runs, 2 gates: 2 PASS"
    assert lines[1].startswith("PASS         test_x.py::test_fuzz x (tightest of 3 runs) max_ttc_inverse 0.36")
    assert lines[-1] == "see it again: dvp run x.xosc --set lead=b --gate max_ttc_inverse"
    assert "lead=c" in noted.reported_run(failed=True)["replay"]


def test_where_what_is_asked_for_does_not_tell_runs_apart_the_other_gates_do() -> None:
    near, far = (result(verdict("collision", 0, 0, "PASS"), verdict("jerk", j, 4.0, "PASS")) for j in (3.9, 1.0))
    noted = RunSummary(far)
    noted.add_request(["collision"], passed=True)
    noted.add_run(near)
    noted.add_run(far)
    assert [v["value"] for v in noted.reported_run(failed=False)["verdicts"]] == [0, 3.9]
