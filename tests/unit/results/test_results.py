"""Run folders: numbered, whole or absent."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from results_logs import content, drive_straight, log_of, times, track

from pytest_dvp.drive.run_folder import Extent, ResultError, write_run
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.verdicts.judging import Gate, judge

LOG = drive_straight(
    5.0, objects={"target": track(times()[::5], 62.0, 0.0)}, meta={"scenario": "overtaking.xosc", "seed": 7}
)
VERDICTS = judge([Gate("max_ttc_inverse", max=0.5, file="a.gates.toml", line=3)], LOG)


def save(root: Path, name: str = "overtaking", log: Log = LOG) -> Path:
    return write_run(root, name, log, VERDICTS, extent=Extent(report=False))


def test_folder_has_number_name_and_stage(tmp_path: Path) -> None:
    assert [save(tmp_path / "runs").name for _ in range(2)] == ["0001-overtaking-dt", "0002-overtaking-dt"]


def test_number_follows_the_greatest_one_there(tmp_path: Path) -> None:
    (tmp_path / "0041-other-rw").mkdir()
    (tmp_path / "notes").mkdir()
    assert save(tmp_path).name == "0042-overtaking-dt"


def test_log_in_the_folder_is_the_log(tmp_path: Path) -> None:
    assert content(Log.load(save(tmp_path) / "log.mcap")) == content(LOG)


def test_result_holds_verdicts_and_metrics(tmp_path: Path) -> None:
    result = json.loads((save(tmp_path) / "result.json").read_text())
    assert (result["status"], result["scenario"], result["stage"], result["seed"]) == (
        "FAIL",
        "overtaking.xosc",
        "dt",
        7,
    )
    assert result["verdicts"][0]["line"] == 3
    assert result["metrics"]["max_ttc_inverse"]["value"] == pytest.approx(5.0 / 7.3)
    assert result["metrics"]["completion_time"]["valid"] is False


def test_same_run_gives_the_same_bytes(tmp_path: Path) -> None:
    one, two = save(tmp_path), save(tmp_path)
    for name in ("log.mcap", "result.json"):
        assert (one / name).read_bytes() == (two / name).read_bytes()


def test_runs_at_the_same_time_share_no_number(tmp_path: Path) -> None:
    with ThreadPoolExecutor(8) as pool:
        folders = list(pool.map(lambda i: save(tmp_path, f"case-{i}", log_of(1.0)), range(24)))
    assert sorted(int(folder.name[:4]) for folder in folders) == list(range(1, 25))


def test_run_that_fails_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(LogError):
        save(tmp_path, log=log_of(1.0, meta={"thing": object()}))
    assert list(tmp_path.iterdir()) == []


def test_report_that_breaks_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_dvp.drive.run_folder.write_report", _broken)
    with pytest.raises(RuntimeError):
        write_run(tmp_path, "overtaking", LOG, VERDICTS)
    assert list(tmp_path.iterdir()) == []


def test_finished_folder_holds_no_partial_files(tmp_path: Path) -> None:
    assert sorted(path.name for path in save(tmp_path).iterdir()) == ["log.mcap", "result.json"]


def test_number_of_a_run_under_way_is_not_taken(tmp_path: Path) -> None:
    (tmp_path / ".0007.part").mkdir()
    assert save(tmp_path).name == "0008-overtaking-dt"


def test_name_is_safe_in_a_shell(tmp_path: Path) -> None:
    assert save(tmp_path, "../a b;rm *ü").name == "0001-a-b-rm-dt"


def test_folder_that_cannot_be_made_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "runs").write_text("a file")
    with pytest.raises(ResultError, match="runs: no run folder can be made"):
        save(tmp_path / "runs")


def _broken(*_: object, **__: object) -> None:
    raise RuntimeError("no template")
