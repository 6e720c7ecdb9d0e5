"""A gate between stages speaks only for what the drives excited; what they did not is said beside it."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_dvp.drive.stage_comparison import StageDrive, compare_stages
from pytest_dvp.logs.log import Log
from pytest_dvp.verdicts.excited_parameters import not_validated, wrong_parameters
from pytest_dvp.verdicts.gate import Gate, GateError
from pytest_dvp.verdicts.idle_claims import idle_claims
from pytest_dvp.verdicts.judging import judge_between, read_gates
from reports.stages import render_stages_report
from tests.truth.generate import make_log
from vehicle.model.effect_catalogue import catalogue

PAIR = ("dt", "rw")
ABOUT: dict[str, object] = {
    "scenario": "a.xosc", "line": 1, "seed": 1, "ads": "reference", "set": {}, "replay": "dvp run a.xosc"
}  # fmt: skip


@pytest.fixture(scope="module")
def logs() -> Mapping[str, Log]:
    """Twice a drive about town, which steers, brakes and turns."""
    drive = make_log({}, "urban", 1)
    return {stage: Log(drive, meta={"stage": stage, "scenario": "a.xosc"}) for stage in PAIR}


@pytest.fixture(scope="module")
def straight(logs: Mapping[str, Log]) -> Mapping[str, Log]:
    """The same without any steering: only the time, the speed and the wish for it are known."""
    kept = ("t", "v", "vx", "accel_cmd", "ax")
    return {
        stage: dataclasses.replace(log, columns={n: c for n, c in log.columns.items() if n in kept})
        for stage, log in logs.items()
    }


def gate(*parameters: str, bound: float = 1.0) -> Gate:
    return Gate("mncc", min=-bound, between=PAIR, options={"signal": "v"}, file="g.toml", line=1, parameters=parameters)


def test_a_gate_passes_for_what_the_drives_excite(logs: Mapping[str, Log]) -> None:
    (verdict,) = judge_between([gate("steer_delay", "drive_lag.tau")], PAIR, logs)
    assert verdict.status == "PASS"


def test_a_gate_is_inconclusive_for_what_they_do_not_and_names_the_manoeuvre(straight: Mapping[str, Log]) -> None:
    plain, listing = judge_between([gate(), gate("drive_lag", "steer_delay.T")], PAIR, straight)
    assert plain.status == "PASS"
    assert listing.status == "INCONCLUSIVE"
    assert listing.value == plain.value
    assert "steer_delay.T (needs " in listing.reason
    assert catalogue()["steer_delay"].reveals in listing.reason
    assert "dvp plan --model MODEL.toml --excite steer_delay" in listing.reason
    assert "drive_lag" not in listing.reason


def test_one_drive_that_did_not_excite_it_is_enough(logs: Mapping[str, Log], straight: Mapping[str, Log]) -> None:
    for mixed in ({"dt": logs["dt"], "rw": straight["rw"]}, {"dt": straight["dt"], "rw": logs["rw"]}):
        assert judge_between([gate("steer_delay")], PAIR, mixed)[0].status == "INCONCLUSIVE"


TWIN = """
[model]
base = "dynamic_bicycle"
[inputs]
steer = "steer_cmd"
longitudinal = "accel_cmd"
[parameters]
wheelbase = 2.36
mass = 730.0
"""
LATE = """
[[effect]]
name = "steer_delay"
[effect.parameters.T]
value = 0.2
unit = "s"
"""


@pytest.mark.parametrize(
    ("more", "named"),
    [
        ("", ""),
        (LATE, "steer_delay"),
        (LATE.replace('"steer_delay"', '"steer_delay"\nfitted_on = ["a log"]'), ""),
        ("yaw_inertia = 2000.0\n", "yaw_inertia"),
        ("cornering_stiffness_rear = 90000.0\n" + LATE, "cornering_stiffness_rear"),
    ],
    ids=["data sheet", "said", "learnt", "no maker prints it", "both"],
)
def test_model_stands_for_what_the_twin_claims_without_evidence(
    straight: Mapping[str, Log], more: str, named: str
) -> None:
    """On a drive without steering, a delay of it that nobody has fitted is a claim."""
    twin = dataclasses.replace(straight["dt"], meta={**straight["dt"].meta, "model": {"toml": TWIN + more}})
    (verdict,) = judge_between([gate("model")], PAIR, {**straight, "dt": twin})
    assert verdict.status == ("INCONCLUSIVE" if named else "PASS")
    assert f"{named} (needs " in verdict.reason if named else not verdict.reason


def test_a_gate_that_fails_stays_a_failure(straight: Mapping[str, Log]) -> None:
    assert judge_between([gate("steer_delay", bound=-2.0)], PAIR, straight)[0].status == "FAIL"


def test_others_are_told_and_change_no_verdict(straight: Mapping[str, Log]) -> None:
    drives = {stage: StageDrive(log) for stage, log in straight.items()}
    result = compare_stages(drives, [gate()], [PAIR], ABOUT)
    assert result.status == "PASS"
    told = {one["parameter"]: one for one in result.as_dict()["not_validated"]}
    assert told["steer_delay"]["between"] == ["dt", "rw"]
    assert told["steer_delay"]["manoeuvre"] == catalogue()["steer_delay"].reveals
    assert told["detection_offset"]["command"] == ""  # no manoeuvre of the car alone shows it
    assert "drive_lag" not in told
    page = render_stages_report(result.as_dict(), {})
    assert "Not validated by these drives" in page
    assert page.count("dvp plan --model MODEL.toml --excite EFFECT") == 1
    (row,) = re.findall(r"<b>steer_delay</b>.*?</tr>", page, re.DOTALL)
    assert "dt and rw" in row


def test_an_effect_that_several_pairs_cannot_show_is_one_row_of_the_page(straight: Mapping[str, Log]) -> None:
    logs = {**straight, "pe": straight["rw"]}
    pairs: list[Any] = [("dt", "rw"), ("dt", "pe")]
    document = {**ABOUT, "status": "PASS", "stage": "", "not_validated": not_validated([gate()], pairs, logs)}
    (row,) = re.findall(r"<b>steer_delay</b>.*?</tr>", render_stages_report(document, {}), re.DOTALL)
    assert "dt and rw, dt and pe" in row


def test_what_a_gate_lists_is_not_told_twice(straight: Mapping[str, Log]) -> None:
    told = {one["parameter"] for one in not_validated([gate("steer_delay.T")], [PAIR], straight)}
    assert "steer_delay" not in told
    assert "steer_lag" in told


def test_a_pair_that_was_not_driven_tells_nothing(straight: Mapping[str, Log]) -> None:
    assert not_validated([gate()], [PAIR], {"dt": straight["dt"]}) == []


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("steer_delay", "parameters must be a list"),
        ([], "parameters must be a list"),
        ([3], "parameters must be a list"),
        (["steer_dely"], "steer_delay"),
        (["steer_delay.tau"], "key of steer_delay"),
    ],
)
def test_a_wrong_list_is_told_in_one_line(value: object, says: str) -> None:
    told = wrong_parameters(value)
    assert says in told
    assert "\n" not in told


def test_a_gate_file_holds_them_between_stages_only(tmp_path: Path) -> None:
    text = '[[gate]]\nmetric = "{}"\n{}\nmax = 0.1\nparameters = ["steer_delay", "brake_gain.g"]\n'
    file = tmp_path / "stages.toml"
    file.write_text(text.format("path_distance", 'between = ["dt", "rw"]'))
    assert read_gates(file).gates[0].parameters == ("steer_delay", "brake_gain.g")
    file.write_text(text.format("max_jerk", ""))
    with pytest.raises(GateError, match=r"stages.toml:5.*between stages"):
        read_gates(file)


def test_a_drive_without_a_fix_judges_no_twin(logs: Mapping[str, Log]) -> None:
    """The car's reference system did not know where it was: no gate passes and none fails."""
    car = logs["rw"]
    lost = {**car.columns, "position_sigma": np.where(car.t < 0.5 * car.t[-1], 0.01, 0.3)}
    bad = {**logs, "rw": dataclasses.replace(car, columns=lost)}
    for bound in (1.0, -2.0):  # the second one is missed by any drive
        (verdict,) = judge_between([gate(bound=bound)], PAIR, bad)
        assert verdict.status == "INCONCLUSIVE"
        assert verdict.reason.startswith("stage rw: its reference system had no fix for ")
    assert judge_between([gate(bound=-2.0)], PAIR, logs)[0].status == "FAIL"


def test_a_twin_that_was_scaled_to_another_car_is_no_evidence_about_its_file(logs: Mapping[str, Log]) -> None:
    about = {"toml": TWIN, "file": "car.toml", "scaled": True, "wheelbase": 2.5, "mass": 900.0, "to": "other"}
    twin = dataclasses.replace(logs["dt"], meta={**logs["dt"].meta, "model": about})
    (verdict,) = judge_between([gate()], PAIR, {**logs, "dt": twin})
    assert verdict.status == "INCONCLUSIVE"
    assert "not car.toml" in verdict.reason
    assert "wheelbase 2.5 m, mass 900 kg" in verdict.reason


RESISTANCE = """
[[effect]]
name = "rolling_resistance"
[effect.parameters.c]
value = {c}
unit = "m/s^2"
"""


@pytest.mark.parametrize(("c", "idle"), [(0.0005, True), (0.3, False)])
def test_what_changes_nothing_in_the_twin_is_not_validated_by_the_drive(
    logs: Mapping[str, Log], c: float, idle: bool
) -> None:
    """0.5 mm/s^2 are a two-hundredth of the noise of the accelerometer, and 2.5 mm/s after 5 s; 0.3 m/s^2 are not."""
    about = {"toml": TWIN + RESISTANCE.format(c=c)}
    twin = dataclasses.replace(logs["dt"], meta={**logs["dt"].meta, "model": about})
    assert idle_claims(twin, logs["rw"]) == (("rolling_resistance",) if idle else ())
    (verdict,) = judge_between([gate("model")], PAIR, {**logs, "dt": twin})
    assert verdict.status == ("INCONCLUSIVE" if idle else "PASS")
    assert ("rolling_resistance (without it the twin answers" in verdict.reason) == idle
