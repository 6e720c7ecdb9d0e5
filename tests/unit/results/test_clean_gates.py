"""Bounds of clean drives: read from the table [clean], and silent about any other drive."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from results_logs import log_of

from pytest_dvp.verdicts.gate import Gate
from pytest_dvp.verdicts.judging import GateError, judge, read_gates
from pytest_dvp.verdicts.result_text import without_clean

TEXT = """# of a.xosc
[[gate]]
metric = "road_departure"
max = 0

[clean]
only_if_logged = "ads.position_sigma"
parameters = { ego_speed = 5.5 }
[clean.max]
localization_error = 0.1
"localization_error statistic=greatest" = 0.3
[clean.min]
localization_error = 0.01
"""


def written(tmp_path: Path, text: str = TEXT) -> Path:
    file = tmp_path / "a.gates.toml"
    file.write_text(text)
    return file


def statuses(tmp_path: Path, sigma: float = 0.02, error: float = 0.05, **meta: object) -> list[str]:
    columns = {"on_road": 1.0, "ads.x": np.where(np.arange(1001) % 2 == 0, error, error + 1e-9), "ads.y": 0.0}
    columns["ads.position_sigma"] = sigma
    log = log_of(columns=columns, meta={"parameters": {"ego_speed": "5.5"}, **meta})
    return [verdict.status for verdict in judge(read_gates(written(tmp_path)), log)]


def test_each_bound_is_a_gate_with_its_line_and_options(tmp_path: Path) -> None:
    _, both, greatest = read_gates(written(tmp_path)).gates
    assert (both.metric, both.min, both.max, both.stages, both.line) == ("localization_error", 0.01, 0.1, ("dt",), 10)
    assert (greatest.options, greatest.max, greatest.line) == ({"statistic": "greatest"}, 0.3, 11)


def test_a_drive_like_the_clean_ones_is_judged_by_them(tmp_path: Path) -> None:
    assert statuses(tmp_path) == ["PASS", "PASS", "PASS"]
    assert statuses(tmp_path, error=0.2) == ["PASS", "FAIL", "PASS"]
    assert statuses(tmp_path, error=0.001) == ["PASS", "FAIL", "PASS"]


def test_a_verdict_says_that_it_is_of_a_clean_bound_and_which_of_them(tmp_path: Path) -> None:
    columns = {"on_road": 1.0, "ads.x": 0.2, "ads.y": 0.0, "ads.position_sigma": 0.02}
    log = log_of(columns=columns, meta={"parameters": {"ego_speed": "5.5"}})
    verdicts = judge(read_gates(written(tmp_path)), log)
    assert [(verdict.name, verdict.clean) for verdict in verdicts] == [
        ("road_departure", False), ("localization_error", True), ("localization_error(statistic=greatest)", True),
    ]  # fmt: skip
    assert verdicts[1].message.endswith(f"clean bound {tmp_path / 'a.gates.toml'}:10")


def test_bounds_of_clean_drives_that_hold_are_one_phrase() -> None:
    gate = {"status": "PASS", "metric": "a", "short": "a 1 <= 2 at t=1.00 s", "margin": 1.0, "bound": 2.0, "used": 0.5}
    near = {**gate, "metric": "b", "short": "b 9 <= 10 at t=3.00 s", "used": 0.9, "clean": True}
    far = {**near, "short": "b 1 <= 10", "used": 0.1}
    broken = {**near, "status": "FAIL", "used": 1.2}
    assert without_clean([gate, far, broken, near]) == ([gate, broken], "2 bounds of clean drives; nearest: b 9 <= 10")
    assert without_clean([gate]) == ([gate], "")


@pytest.mark.parametrize(
    "other",
    [{"parameters": {"ego_speed": "5.0"}}, {"parameters": {}}, {"stage": "rw-surrogate"}, {"S": {"EGO_mass": "900"}}],
)
def test_another_drive_is_not(tmp_path: Path, other: dict[str, object]) -> None:
    assert statuses(tmp_path, error=0.2, **other) == ["PASS"]


def test_nor_is_a_stack_that_does_not_state_the_column(tmp_path: Path) -> None:
    assert statuses(tmp_path, sigma=float("nan"), error=0.2) == ["PASS"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("localization_error = 0.1", "localisation_error = 0.1", "nearest is 'localization_error'"),
        ("statistic=greatest", "statistik=greatest", "nearest is 'statistic'"),
        ("= 0.3", '= "much"', "max must be a finite number"),
        ('"ads.position_sigma"', "3", "only_if_logged must name a column"),
        ("5.5 }", '"fast" }', "parameters must be numbers by name"),
        ("localization_error = 0.01", "localization_error = 0.2", "min 0.2 is greater than max 0.1"),
        ("[clean.min]", "[clean.least]", "unknown key 'least'"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(GateError, match=r"a\.gates\.toml:") as told:
        read_gates(written(tmp_path, TEXT.replace(old, new)))
    assert said in str(told.value)


def test_clean_bounds_leave_the_gates_that_every_drive_has() -> None:
    """Gates between stages alone leave a stage to the default gates, with a table [clean] beside them as without."""
    between = Gate("lateral_rmse", max=0.2, between=("dt", "rw"))
    clean = Gate("localization_error", max=0.1, only_if_logged="ads.position_sigma", only_with={})
    log = log_of(columns={"on_road": 0.0, "ads.x": 0.0, "ads.y": 0.0, "ads.position_sigma": 0.1})
    plain = [verdict.metric for verdict in judge([between], log)]
    assert plain == ["collision", "road_departure", "scenario_ended"]
    assert {verdict.metric: verdict.status for verdict in judge([between, clean], log)}["road_departure"] == "FAIL"


def test_clean_bounds_alone_pass_no_stage() -> None:
    elsewhere = Gate("collision", max=0.0, stages=("rw",))
    clean = Gate("localization_error", max=9.0, only_if_logged="ads.position_sigma", only_with={})
    log = log_of(columns={"ads.x": 0.0, "ads.y": 0.0, "ads.position_sigma": 0.1})
    (verdict,) = judge([elsewhere, clean], log)
    assert (verdict.status, verdict.short) == ("INCONCLUSIVE", "no gate applies to stage dt: nothing was judged")


@pytest.mark.parametrize(
    ("about", "statuses"),
    [
        ({"parameters": {"ego_speed": "5.5"}}, ["PASS", "FAIL"]),
        ({"parameters": {"ego_speed": "5.0"}}, ["PASS"]),  # another variant of the scenario
        ({"parameters": {"ego_speed": "5.5"}, "S": {"EGO_mass": "900"}}, ["PASS"]),  # another twin
        ({"parameters": {"ego_speed": "5.5"}, "stage": "pe-surrogate"}, ["PASS"]),
    ],
)
def test_one_gate_may_be_a_bound_of_clean_drives(tmp_path: Path, about: dict[str, object], statuses: list[str]) -> None:
    """As dvp mutate writes it: of any stack, with the parameters of the clean drives, on dt."""
    text = """[[gate]]
metric = "road_departure"
max = 0

[[gate]]
metric = "localization_error"
min = 0.1
clean = { ego_speed = 5.5 }
"""
    log = log_of(columns={"on_road": 1.0, "ads.x": 0.05, "ads.y": 0.0}, meta=about)
    verdicts = judge(read_gates(written(tmp_path, text)), log)
    assert [verdict.status for verdict in verdicts] == statuses
    assert [verdict.clean for verdict in verdicts] == [False, True][: len(statuses)]
