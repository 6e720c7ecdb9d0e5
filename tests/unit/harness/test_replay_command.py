"""`dvp replay RUN`: the same bytes again, or the first difference by name and time."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.run import run
from pytest_dvp.logs.difference import first_difference
from pytest_dvp.logs.log_contents import LogEvent
from tests.unit.harness.conftest import OneTrick, coast
from vehicle.messages import Command, Observation

Write = Callable[..., Path]


@pytest.fixture
def folder(scenario: Write, tmp_path: Path) -> Path:
    assert main(["run", str(scenario()), "--duration", "0.5", "--runs", str(tmp_path / "runs")]) in (0, 1)
    return tmp_path / "runs" / "0001-x-dt"


def test_an_untouched_run_gives_the_same_bytes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["replay", str(folder)]) == 0
    assert capsys.readouterr().out == f"{folder}: the same bytes again\n"
    assert sorted(path.name for path in folder.parent.iterdir()) == [folder.name, "assets"]


def test_the_environment_of_another_shell_changes_nothing(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DVP_COMPUTE_DELAY", "0.1")
    capsys.readouterr()
    assert main(["replay", str(folder)]) == 0
    assert capsys.readouterr().out == f"{folder}: the same bytes again\n"
    assert os.environ["DVP_COMPUTE_DELAY"] == "0.1"


class Coasting:
    """A stack that a test brings as a class, and that a command line can name as well."""

    def tick(self, observation: Observation) -> Command:
        return coast(observation)


def test_a_stack_that_was_given_as_a_class_gives_the_same_bytes_by_its_name(
    scenario: Write, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = run(scenario(), ads=Coasting, duration=0.5, log_dir=tmp_path / "runs")
    assert result.ads == "test_replay_command.py:Coasting"
    assert "test_replay_command.py:Coasting --duration 0.5" in result.replay
    assert main(["replay", str(result.folder)]) == 0
    assert capsys.readouterr().out.endswith(": the same bytes again\n")


def test_another_seed_is_the_first_difference(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = json.loads((folder / "result.json").read_text())
    result["replay"] = result["replay"].replace("--seed 7", "--seed 8")
    (folder / "result.json").write_text(json.dumps(result))
    capsys.readouterr()
    assert main(["replay", str(folder), "--json"]) == 1
    said = json.loads(capsys.readouterr().out)
    assert not said["same_bytes"]
    assert said["first_difference"] == {"t": None, "what": "meta.seed", "before": "7", "now": "8"}


RUN = {"scenario": "x.xosc", "status": "PASS", "verdicts": []}


@pytest.mark.parametrize(
    ("result", "says"),
    [
        (None, "No such file or directory; a run's folder is expected"),
        ("{}", "not the result of a run: Object missing required field `scenario`"),
        ("", "not the result of a run: Input data was truncated"),
        (RUN | {"replay": 5}, "not the result of a run: Expected `str`, got `int` - at `$.replay`"),
        (RUN, "how it was driven is not said"),
        (RUN | {"replay": "dvp run 'x"}, 'replay is "dvp run \'x", which is no command: No closing quotation'),
        (RUN | {"replay": "dvp run x.xosc --sead 3"}, "which is no command: dvp: unrecognized arguments: --sead 3"),
        (RUN | {"replay": "dvp run --help"}, "which is no command: dvp run: --help"),
        (RUN | {"replay": "no command line can name the ADS OneTrick"}, "no command line can name the ADS OneTrick"),
        (
            RUN | {"replay": "dvp run x.xosc", "logs": {"dt": "runs/0001-x-dt", "rw": "runs/0002-x-rw"}},
            "holds stages against each other; replay the runs: runs/0001-x-dt, runs/0002-x-rw",
        ),
        (
            RUN | {"replay": "dvp run x.xosc --stage rw --vehicle tabby"},
            "dvp replay is refused: vehicle 'tabby' is real",
        ),
    ],
)
def test_what_cannot_be_driven_again_is_one_line(
    tmp_path: Path, result: str | dict[str, object] | None, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "log.mcap").write_bytes(b"")
    if result is not None:
        (tmp_path / "result.json").write_text(result if isinstance(result, str) else json.dumps(result))
    assert main(["replay", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert says in said
    assert said.count("\n") == 1


def test_a_damaged_log_is_told_before_the_drive(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.mcap").write_bytes(b"")
    (tmp_path / "result.json").write_text(json.dumps(RUN | {"replay": "dvp run x.xosc --seed 7"}))
    assert main(["replay", str(tmp_path)]) == 1
    assert capsys.readouterr().err == f"{tmp_path / 'log.mcap'}: not an MCAP file\n"


def test_the_earliest_difference_is_the_one_that_is_named(scenario: Write) -> None:
    log = run(scenario(), duration=0.5, ads=OneTrick(coast)).log
    assert first_difference(log, log) is None
    later, sooner = np.array(log["v"]), np.array(log["yaw"])
    later[40] += 1e-6
    sooner[20] += 1e-6
    changed = dataclasses.replace(log, columns={**log.columns, "v": later, "yaw": sooner})
    found = first_difference(log, changed)
    assert found is not None
    assert (found.what, found.t) == ("column yaw", pytest.approx(float(log.t[20])))
    event = dataclasses.replace(log, events=[LogEvent(0.1, "wire", "/gnss/fix", "lost 1"), *log.events])
    assert str(first_difference(log, event)).startswith("first difference at t=")
