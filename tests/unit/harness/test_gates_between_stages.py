"""Gates between stages that ship: a twin that learnt from the car's logs passes, one that did not does not.

The first 20 s of overtaking, with a bend in them; all scenarios to their ends, and more wrong twins: `make stages`. It
also asks for the car whose drive-by-wire is on CAN (DVP_STAGES=all).
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds")

import scenarios
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stage_comparison import gates_between
from pytest_dvp.logs.log import Log
from pytest_dvp.verdicts.judging import Verdict, judge_between
from scripts.stage_twins import HIDDEN, WIRES, twin_of
from vehicle.model.model_file import write_model

SCENARIO = scenarios.path("overtaking.xosc")
WHOLE_DRIVE = (
    "completion_time",
    "localization_error",
    "heading_error",
    "track_position_error",
    "track_latency",
    "track_speed_error",
    "track_yaw_error",
    "track_coasting",
)  # whom it meets, it meets later
LIMIT = 20.0  # s
over_can = pytest.mark.skipif(os.environ.get("DVP_STAGES") != "all", reason="a second car, on CAN: make stages")


def car_on(wire: str, folder: Path) -> Log:
    """The car with what is hidden in it, on stage rw."""
    car = folder / "car.toml"
    car.write_text(HIDDEN)
    extended = scenarios.path(WIRES[wire].extended)
    return run(SCENARIO, stage="rw", vehicle=f"{WIRES[wire].vehicle}:{car}", model=extended, duration=LIMIT).log


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return car_on("ros2", tmp_path_factory.mktemp("car"))


@pytest.fixture(scope="module")
def measured_over_can(tmp_path_factory: pytest.TempPathFactory) -> Log:
    pytest.importorskip("can")
    pytest.importorskip("cantools")
    return car_on("can", tmp_path_factory.mktemp("car"))


def judged(measured: Log, twin: str, folder: Path, wire: str = "ros2") -> dict[str, Verdict]:
    """The verdicts by name, of a twin on stage dt against the car."""
    model = folder / "twin.toml"
    write_model(twin_of(twin, WIRES[wire]), model)
    simulated = run(SCENARIO, model=model, duration=LIMIT).log
    gates = gates_between(SCENARIO, None, scenarios.path("stages.toml"))
    found = judge_between(gates, ("dt", "rw"), {"dt": simulated, "rw": measured})
    return {verdict.name: verdict for verdict in found if not {verdict.metric, verdict.name} & set(WHOLE_DRIVE)}


@pytest.mark.nightly
def test_the_twin_that_learnt_passes(measured: Log, tmp_path: Path) -> None:
    verdicts = judged(measured, "extended", tmp_path)
    assert {name: verdict.short for name, verdict in verdicts.items() if verdict.status != "PASS"} == {}
    assert len(verdicts) >= 12


@pytest.mark.parametrize(
    ("twin", "shown_by"),
    [
        ("baseline", ["twin_error", "response_lag difference", "response_gain difference", "twin_gain(yaw_rate)"]),
        ("gain", ["twin_error", "response_gain difference", "gain(steer_cmd)"]),
        ("lag", ["twin_error", "response_lag difference"]),
        ("speed", ["twin_error"]),
        ("gnss", ["twin_error"]),
        ("heading", ["twin_error"]),
    ],
)
@pytest.mark.nightly(by_day=4)
def test_a_wrong_twin_fails_by_the_gates_that_see_what_is_wrong(
    measured: Log, tmp_path: Path, twin: str, shown_by: list[str]
) -> None:
    verdicts = judged(measured, twin, tmp_path)
    assert {name: verdicts[name].status for name in shown_by} == dict.fromkeys(shown_by, "FAIL")


def test_mncc_alone_would_let_a_quarter_of_the_steering_pass(measured: Log, tmp_path: Path) -> None:
    verdicts = judged(measured, "gain", tmp_path)
    assert (verdicts["mncc(x)"].status, verdicts["mncc(y)"].status) == ("PASS", "PASS")


@over_can
def test_over_can_the_twin_that_learnt_over_can_passes(measured_over_can: Log, tmp_path: Path) -> None:
    verdicts = judged(measured_over_can, "extended", tmp_path, "can")
    assert {name: verdict.short for name, verdict in verdicts.items() if verdict.status != "PASS"} == {}
    assert len(verdicts) >= 12


@over_can
def test_over_can_the_twin_from_the_data_sheet_fails(measured_over_can: Log, tmp_path: Path) -> None:
    verdicts = judged(measured_over_can, "baseline", tmp_path, "can")
    seen = ["twin_error", "response_lag difference", "response_gain difference"]
    assert {name: verdicts[name].status for name in seen} == dict.fromkeys(seen, "FAIL")
