"""A model that does not match: the failure names the missing effect, its rivals and the command that adds it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.logs.signals import SIGNALS
from tests.truth.generate import make_log

CAR = "[parameters]\nwheelbase = 2.45\ncg_to_front_axle = 1.15\nmass = 1150.0\nyaw_inertia = 1400.0\n"

MATCHES = """
from pytest_dvp import assert_matches

def test_twin():
    assert_matches("drive.csv", "car.toml", rmse={"yaw_rate": 0.01})
"""

GATE = """
import dataclasses
from pathlib import Path

import pytest

from pytest_dvp.verdicts.judging import judge, overall, read_gates
from pytest_dvp.logs.read_log import read_log
from pytest_dvp.drive.result import RunResult


def test_gate(gate):
    log = read_log("drive.csv")
    log = dataclasses.replace(log, meta={**log.meta, "stage": "rw"})
    verdicts = tuple(judge(read_gates("drive.gates.toml"), log))
    gate(RunResult(
        log=log, verdicts=verdicts, status=overall(verdicts), folder=Path.cwd() / "runs" / "0001-drive-rw",
        scenario="drive.xosc", line=1, stage="rw", ads="reference", seed=7, ending="stop", ended="the stop trigger",
        set={}, replay="dvp replay drive.csv", metrics={},
    ))
"""


@pytest.fixture(scope="module")
def late_steering(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive through town of a car that steers 0.2 s late, written by the truth that shares nothing with the model."""
    path = tmp_path_factory.mktemp("late") / "drive.csv"
    columns = make_log({"steer_delay": {"T": 0.2}}, "urban", seed=2)
    head = ",".join(f"{name} [{SIGNALS[name].unit}]" for name in columns)
    np.savetxt(path, np.column_stack(list(columns.values())), fmt="%.6g", delimiter=",", header=head, comments="")
    return path


@pytest.fixture
def twin(pytester: pytest.Pytester, late_steering: Path) -> pytest.Pytester:
    (pytester.path / "drive.csv").write_bytes(late_steering.read_bytes())
    (pytester.path / "car.toml").write_text(CAR)
    (pytester.path / "drive.gates.toml").write_text(
        '[[gate]]\nmodel = "car.toml"\nrmse = { yaw_rate = 0.01, v = 0.1 }\nlag = 0.05\nstages = ["rw"]\n'
    )
    return pytester


COMMAND = "dvp extend --model car.toml --add steer_delay --fit {log} --out car.extended.toml"


@pytest.mark.nightly
def test_assert_matches_names_the_effect_and_the_command(twin: pytest.Pytester) -> None:
    twin.makepyfile(MATCHES)
    result = twin.runpytest_inprocess()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([
        "*AssertionError: car.toml does not match the log*",
        "*diagnosis: NAMED: car.toml lacks steer_delay*",
        "*steer_delay: T = 0.20* s (*), explains * % of the error, no rivals",
        f"*add it: {COMMAND.format(log='drive.csv')}",
    ])  # fmt: skip


def test_the_command_makes_the_test_pass(twin: pytest.Pytester, capsys: pytest.CaptureFixture[str]) -> None:
    from pytest_dvp.cli.command_line import main

    assert main(COMMAND.format(log="drive.csv").split()[1:]) == 0
    twin.makepyfile(MATCHES.replace("car.toml", "car.extended.toml"))
    twin.runpytest_inprocess().assert_outcomes(passed=1)


def test_model_gate_names_the_effect_once_before_the_command_to_replay(twin: pytest.Pytester) -> None:
    twin.makepyfile(GATE)
    result = twin.runpytest_inprocess("-rN")  # under CI the summary repeats whole messages
    result.assert_outcomes(failed=1)
    text = result.stdout.str()
    assert text.count("diagnosis: NAMED: car.toml lacks steer_delay") == 1  # two of the gate's bounds fail
    result.stdout.fnmatch_lines([
        "*GateFailed: *",
        f"*add it: {COMMAND.format(log='runs/0001-drive-rw/log.mcap')}",
        "*replay: dvp replay drive.csv*",
    ])  # fmt: skip


@pytest.mark.parametrize("how", ["option", "ini", "environment"])
@pytest.mark.parametrize("test", [MATCHES, GATE], ids=["assert_matches", "gate"])
def test_the_diagnosis_can_be_switched_off(
    twin: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, test: str, how: str
) -> None:
    twin.makepyfile(test)
    monkeypatch.setattr("pytest_dvp.gap.words.failure_explanation._answer", None)
    if how == "environment":
        monkeypatch.setenv("DVP_NO_DIAGNOSIS", "1")
    if how == "ini":
        twin.makeini("[pytest]\ndvp_no_diagnosis = true")
    result = twin.runpytest_inprocess(*(["--dvp-no-diagnosis"] if how == "option" else []))
    result.assert_outcomes(failed=1)
    assert "diagnosis:" not in result.stdout.str()


@pytest.mark.parametrize("test", [MATCHES, GATE], ids=["assert_matches", "gate"])
def test_a_diagnosis_that_breaks_leaves_a_failure(
    twin: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, test: str
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("of the diagnosis")

    monkeypatch.setattr("pytest_dvp.gap.words.failure_explanation._answer", broken)
    twin.makepyfile(test)
    result = twin.runpytest_inprocess("-W", "error")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*no diagnosis: ZeroDivisionError: of the diagnosis"])


def test_nothing_is_diagnosed_where_the_model_matches(twin: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []
    monkeypatch.setattr("pytest_dvp.gap.words.failure_explanation._answer", asked.append)
    twin.makepyfile(MATCHES.replace("0.01", "1.0"))
    twin.runpytest_inprocess().assert_outcomes(passed=1)
    assert asked == []
