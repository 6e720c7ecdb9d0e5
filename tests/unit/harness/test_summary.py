"""What a session says at its end, from plain results: what comes first, what counts, what to do next."""

from __future__ import annotations

from typing import Any

from pytest_dvp import summary
from reports.verdicts import headline, rows


def verdict(metric: str, value: float, bound: float, status: str, **more: Any) -> dict[str, Any]:
    short = f"{metric} {value:g} against {bound:g}"
    return {"gate": f"{metric} <= {bound:g}", "metric": metric, "name": metric, "value": value, "bound": bound,
            "unit": "-", "status": status, "margin": bound - value, "used": value / bound if bound else None, "t": 1.0,
            "object": "", "reason": "", "file": "x.gates.toml", "line": 1, "short": short, "message": short,
            **more}  # fmt: skip


def result(*verdicts: dict[str, Any], **more: Any) -> dict[str, Any]:
    status = "FAIL" if any(each["status"] == "FAIL" for each in verdicts) else "PASS"
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
    assert [each["metric"] for each in summary.worst_first(CRASH["verdicts"])] == harm_first
    table = rows(CRASH["verdicts"])
    assert [row.metric for row in table] == harm_first
    assert "Worst: collision 1" in headline("FAIL", table)
    assert (summary.failure(CRASH) or "").startswith("collision 1 against 0")
    assert "collision" in summary.lines([CRASH])[1]
    assert "::collision 1 against 0" in summary.github_annotations([CRASH])[0]


def test_what_broke_the_run_itself_stands_before_a_crash() -> None:
    broken = verdict("", 0.0, 0.0, "FAIL", short="the car is lost")
    assert (summary.failure(result(*CRASH["verdicts"], broken)) or "").startswith("the car is lost")
