"""dvp tune and dvp iterate: one document, one line for a slip."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.signals import describe
from pytest_dvp.workers.job import Job
from pytest_dvp.workers.run_job import work
from scenarios import path as shipped

STUDY = """[study]
budget = 1

[[scenario]]
file = "follow.xosc"

[parameters]
"P.LQR_q11" = [20, 30]
"""


@pytest.fixture
def study(tmp_path: Path) -> str:
    file = tmp_path / "study.toml"
    file.write_text(STUDY, encoding="utf-8")
    return str(file)


def test_json_is_one_document_and_the_folder_can_be_read(
    study: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folders = ["--out", str(tmp_path / "out"), "--cache", str(tmp_path / "cache")]
    main(["tune", study, "--json", "--jobs", "1", *folders])
    document = json.loads(capsys.readouterr().out)
    assert document["best"]["point"] == {"P.LQR_q11": 30.0}
    assert document["simulations"] == 1
    assert document["ended"] == "budget"
    assert json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8")) == document
    assert (
        (tmp_path / "out" / "trials.csv").read_text(encoding="utf-8").startswith("trial,simulations,score,broken,P.LQR")
    )


AS_A_USER_WOULD = """[study]
preset = 1
model = "models/surrogate.toml"
seeds = [3, 4]
budget = 4

[[scenario]]
file = "follow.xosc"
set = { lead_speed = 3 }

[parameters]
"P.LQR_q11" = [20, 30]

[[term]]
metric = "max_jerk"

[[constraint]]
metric = "collision"
"""


def commands(text: str) -> list[list[str]]:
    """The words of the commands among the lines, after `dvp`."""
    told = [line.removeprefix("dvp tune: next: ") for line in text.splitlines()]
    return [shlex.split(line)[1:] for line in told if line.startswith(("dvp run", "dvp compare"))]


@pytest.mark.nightly
def test_the_printed_commands_drive_exactly_what_was_tuned(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """P, S and model of the study, values and seeds of its scenarios: the mean of the runs is that of the trials."""
    (tmp_path / "study.toml").write_text(AS_A_USER_WOULD, encoding="utf-8")
    out = tmp_path / "out"
    main([
        "tune", str(tmp_path / "study.toml"), "--jobs", "1", "--out", str(out), "--cache", str(tmp_path / "cache"),
    ])  # fmt: skip
    printed = commands(capsys.readouterr().err)
    result = json.loads((out / "result.json").read_text(encoding="utf-8"))
    assert commands((out / "best.txt").read_text(encoding="utf-8")) == printed
    assert [shlex.split(row["command"])[1:] for row in result["again"]] == printed
    jerks = []
    for words, row in zip(printed, result["again"], strict=True):
        main([*words, "--no-report", "--json"])
        metrics = json.loads(capsys.readouterr().out)["metrics"]
        assert {name: metrics[name] for name in row["metrics"]} == row["metrics"]
        jerks.append(metrics["max_jerk"])
    assert sum(jerks) / 2 == result["best"]["metrics"]["max_jerk"]
    scores = [row["score"] for row in result["again"]]
    assert scores == sorted(scores, reverse=True)  # the worst drive stands first
    best = result["trials"][result["best"]["number"]]
    in_table = (out / "trials.csv").read_text(encoding="utf-8").splitlines()[1 + best["number"]].split(",")[-1]
    assert float(in_table) == pytest.approx(sum(jerks) / 2, rel=1e-5)


@pytest.mark.nightly
def test_of_many_drives_the_worst_are_printed_and_all_are_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "study.toml"
    file.write_text(STUDY.replace("budget = 1", "budget = 4\nseeds = [1, 2, 3, 4]"), encoding="utf-8")
    main(["tune", str(file), "--jobs", "1", "--out", str(tmp_path), "--cache", str(tmp_path / "cache")])
    told = capsys.readouterr().err
    assert len(commands(told)) == 3
    assert f"and 1 more in {tmp_path / 'best.txt'}" in told
    assert len(commands((tmp_path / "best.txt").read_text(encoding="utf-8"))) == 4


@pytest.mark.parametrize("log", ["drive.mcap", "drive.csv"])
@pytest.mark.nightly(by_day=2)
def test_the_printed_command_of_an_alignment_compares_exactly_the_tuned_twin(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], log: str
) -> None:
    twin = str(shipped("models/surrogate.toml"))
    work(Job(str(shipped("follow.xosc")), model=twin, save=str(tmp_path / "drive.mcap"), duration=10.0))
    _as_csv(tmp_path / "drive.mcap")
    (tmp_path / "study.toml").write_text(
        f'[study]\nobjective = "alignment"\nmodel = "models/surrogate.toml"\nlogs = ["{log}"]\n'
        '[parameters]\n"S.EGO_mass" = { values = [730, 900.5], start = 1000 }\n',
        encoding="utf-8",
    )
    main([
        "tune", str(tmp_path / "study.toml"), "--jobs", "1", "--out", str(tmp_path / "out"), "--cache", str(tmp_path),
    ])  # fmt: skip
    said = capsys.readouterr()
    table = said.out.splitlines()  # 730 kg is the mass of the car that drove
    assert any(line.split() == ["S.EGO_mass", "1000", "730", "kg", "*"] for line in table)
    assert "  * moved from the start" in table
    (words,) = commands(said.err)
    main([*words, "--json"])
    signals = json.loads(capsys.readouterr().out)["signals"]
    tuned = json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))["best"]["metrics"]
    for name in ("x", "v", "steer", "yaw_rate"):
        assert signals[name]["nrmse"] == tuned[f"nrmse.{name}"]
        assert signals[name]["chi2_per_n"] == tuned[f"chi2_per_n.{name}"]


def test_a_log_that_the_doctor_refuses_tunes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Kilometres an hour in a column that says metres a second: a twin that fits them is of no car."""
    t = np.arange(1000) * 0.02
    v, yaw = 8.0 + 2.0 * np.sin(0.5 * t), 0.3 * np.sin(0.4 * t)
    x, y = (np.cumsum(v * part(yaw)) * 0.02 for part in (np.cos, np.sin))
    table = {"t [s]": t, "x [m]": x, "y [m]": y, "yaw [rad]": yaw, "v [m/s]": 3.6 * v}
    table |= {"steer_cmd [rad]": 0.1 * yaw, "accel_cmd [m/s^2]": np.cos(0.5 * t)}
    pd.DataFrame(table).to_csv(tmp_path / "drive.csv", index=False)
    (tmp_path / "study.toml").write_text(
        '[study]\nobjective = "alignment"\nmodel = "models/surrogate.toml"\nlogs = ["drive.csv"]\n'
        '[parameters]\n"S.EGO_mass" = { values = [700, 760], start = 730 }\n',
        encoding="utf-8",
    )
    words = ["tune", str(tmp_path / "study.toml"), "--out", str(tmp_path / "out"), "--cache", str(tmp_path / "cache")]
    assert main([*words, "--jobs", "1"]) == 1
    assert "error log.unit_suspect column v" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def _as_csv(path: Path) -> None:
    """The log beside itself as a table of what a car logs, each column with its unit."""
    log = Log.load(path)
    names = ("t", "x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer", "steer_cmd", "accel_cmd")
    units = {f"{name} [{describe(name).unit}]": log[name] for name in names}
    pd.DataFrame(units).to_csv(path.with_suffix(".csv"), index=False)


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (["tune", "nothing.toml"], 2, "nothing.toml: no such study"),
        (["iterate", "nothing.toml"], 2, "nothing.toml: no such plan"),
        (["tune", "{study}", "--search", "gradient"], 2, "unknown search 'gradient'"),
        (["tune", "{study}", "--budget", "0"], 2, "--budget is 0"),
        (["tune", "{study}", "--jobs", "0"], 2, "--jobs is 0"),
        (["iterate", "{plan}", "--vehicle", "surogate"], 2, "--vehicle: unknown vehicle 'surogate', did you mean"),
        (["iterate", "{study}"], 1, "study.toml:1: this is a study (dvp tune), not a plan"),
    ],
)
def test_a_slip_is_one_line(
    study: str, words: list[str], code: int, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = shipped("mcrpg/paper.toml")
    assert main([word.format(study=study, plan=plan) for word in words]) == code
    shown = capsys.readouterr()
    assert told in shown.err
    assert len(shown.err.strip().splitlines()) == 1
    assert shown.out == ""
