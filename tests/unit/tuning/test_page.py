"""The page of an iteration: both tables of the paper, nothing that a file says becomes markup."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pytest_dvp.tuning.iteration_page import iterate_page
from pytest_dvp.tuning.iteration_plan import STAGES
from reports.mcrpg import render_mcrpg_report, twin_figure, write_mcrpg_report

SCRIPT = "</script><img src=x onerror=document.title='owned'>"


def figure(mean: float) -> dict[str, Any]:
    return {"mean": mean, "half_width": 0.01, "worst": mean, "known": 4, "count": 4}


def entry(number: int, q11: float) -> dict[str, Any]:
    rows = ("ego x", "ego y", "steer", "velocity", "object x", "object y")
    alike = {
        k: figure(v) for name in rows for k, v in ((name, 0.99987), (f"{name}.lag", 0.02), (f"{name}.gain", 0.004))
    }
    return {
        "number": number,
        "P": {stage: {"LQR_q11": q11 + (stage == "dt")} for stage in STAGES},
        "S": {"EGO_mass": 1000.0},
        "effects": {"steer_delay": {"T": 0.18}},
        "tuned": {"P": {"course": [[2, 1e6], [4, 1.5], [6, 1.2]],
                        "sensitivity": {"P.LQR_q11": {"max_jerk": {"mean": 0.25, "spread": 0.1, "count": 3}}}}},
        "suspicions": [],
        "held_out": {
            "likeness": {"dt-rw": alike, "pe-rw": alike},
            "metrics": {stage: {"max jerk": figure(1.5)} for stage in STAGES},
            "chi2_per_n": 100.0 / 10.0**number, "position_at_2s": 0.01, "position_noise": 0.02, "performance": 1.6,
        },
        "structure": {"verdict": "NAMED", "taken": ["+ steer_delay T = 0.18 s"], "refusal": ""} if number else {},
        "changes": [f"P {SCRIPT}", "guard: S.EGO_mass = 8500 kg is outside 650 to 1100 kg"],
        "accepted": "twin and stack",
    }  # fmt: skip


def document() -> dict[str, Any]:
    bound = {"what": "MNCC ego x", "where": "dt-rw", "value": 0.99987, "half_width": None, "worst": 0.99987,
             "bound": ">= 0.9999", "holds": False, "paper": "0.9970", "first": None, "undecided": False}  # fmt: skip
    return {
        "plan": SCRIPT, "vehicle": "surrogate heavy", "ended": "3 iterations", "structure": True, "preset": 1,
        "bounds": [bound],
        "ledger": [entry(0, 20.0), entry(1, 30.0)],
    }  # fmt: skip


def test_stages_that_differ_stand_side_by_side() -> None:
    row = next(r for r in iterate_page(document())["parameters"] if r["name"] == "LQR_q11")
    assert row["cells"] == ["21; 20; 20", "31; 30; 30"]
    assert row["paper"] == ["20", "30"]  # Arango et al., 1st and 10th iteration


def test_what_is_not_set_has_no_number() -> None:
    """A wind of which no direction is given comes from ahead."""
    given = document()
    given["ledger"][1]["effects"]["headwind"] = {"speed": 3.0, "heading": None}
    page = iterate_page(given)
    assert page["ledger"][1]["effects"] == ["steer_delay T = 0.18", "headwind speed = 3, heading = not set"]
    row = next(r for r in page["parameters"] if r["name"] == "headwind heading")
    assert row["cells"] == ["", "not set"]
    assert "not set" in render_mcrpg_report(page)


def test_an_mncc_never_stands_without_lag_and_gain() -> None:
    row = next(r for r in iterate_page(document())["metrics"] if r["name"] == "MNCC steer to RW")
    assert row["cells"][1] == ["0.99987 (0.02 s, 0.4 %)", "0.99987 (0.02 s, 0.4 %)", ""]


def test_what_the_twin_lacked_stands_with_the_error_before_and_after() -> None:
    (row,) = iterate_page(document())["lacked"]
    assert (row["number"], row["verdict"], row["effects"]) == (1, "NAMED", ["+ steer_delay T = 0.18 s"])
    assert (row["before"], row["after"], row["taken"]) == (100.0, 10.0, True)


def test_a_log_without_measured_positions_has_no_bound_on_them() -> None:
    unknown = document()
    unknown["ledger"][-1]["held_out"]["position_noise"] = None
    figure = twin_figure(iterate_page(unknown)["course"])
    assert [shape["yref"] for shape in figure["layout"]["shapes"]] == ["y"]


def test_a_forbidden_score_has_no_place_on_the_axis() -> None:
    page = iterate_page(document())
    text = render_mcrpg_report(page)
    assert "1000000" not in text.split('id="data"')[1].split("</script>")[0]


def test_what_a_file_says_is_no_markup(tmp_path: Path) -> None:
    write_mcrpg_report(tmp_path / "a.html", iterate_page(document()))
    assert SCRIPT not in (tmp_path / "a.html").read_text(encoding="utf-8")


def test_same_document_same_bytes() -> None:
    assert render_mcrpg_report(iterate_page(document())) == render_mcrpg_report(iterate_page(document()))
