"""`dvp campaign` from a scenario to its map, with drives of a fifth of a second."""

from __future__ import annotations

import csv
import json
import sqlite3
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.campaigns.campaign import Campaign, Progress
from pytest_dvp.campaigns.store import SHRINKING
from pytest_dvp.cli.command_line import main
from scenarios import path as shipped
from tests.plugin.conftest import write_scenario

GATES = '[[gate]]\nmetric = "max_jerk"\nmax = 100\n[[gate]]\nmetric = "events_fired"\nmin = 0\n'


def campaign(folder: Path, *more: str) -> int:
    gates = folder / "any.gates.toml"
    gates.write_text(GATES)
    words = ["campaign", str(shipped("follow.xosc")), "--out", str(folder / "out"), "--jobs", "1", "--no-ini"]
    return main([*words, "--duration", "0.2", "--gates", str(gates), *more])


def test_a_campaign_is_driven_read_and_exported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = campaign(tmp_path, "--runs", "3", "--json")
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert code == 0, err
    assert (told["runs"], sum(told["verdicts"].values())) == (3, 3)
    assert "3 of 3 driven, 0 failed" in err
    assert (tmp_path / "out" / "map.html").read_text().startswith("<!DOCTYPE html>")
    with sqlite3.connect(tmp_path / "out" / "campaign.sqlite") as file:
        values = json.loads(file.execute("SELECT parameters FROM runs").fetchone()[0])
    assert 4.0 <= values["ego_speed"] <= 6.0  # the range that follow.xosc declares
    assert main(["campaign", str(tmp_path / "out"), "--status"]) == 0
    assert capsys.readouterr().out.startswith("3 runs: ")
    assert main(["campaign", str(tmp_path / "out"), "--export", "csv"]) == 0
    with (tmp_path / "out" / "runs.csv").open() as table:
        assert len(list(csv.DictReader(table))) == 3


def test_progress_tells_drives_that_shrink_a_failure_apart_from_those_that_were_asked_for() -> None:
    """60 were asked for, 2 failed; 44 more drives, 13 of which failed too, find the smallest variants."""
    done = Progress(wanted=60, driven=60, failed=2, shrinking=44)
    said = "60 of 60 driven, 2 failed; 44 more to find the smallest variant of each kind of failure"
    assert done.text() == said


def test_a_drive_that_shrinks_a_failure_counts_as_nothing_else() -> None:
    counted = SimpleNamespace(progress=Progress(wanted=3))
    for purpose in ("sample", SHRINKING, SHRINKING):
        row: Any = SimpleNamespace(purpose=purpose, failed=True, vacuous=False, verdict="FAIL")
        Campaign._count(counted, row, known=False)  # type: ignore[arg-type]
    assert (counted.progress.driven, counted.progress.failed, counted.progress.shrinking) == (1, 1, 2)


def test_a_campaign_in_which_nothing_was_decided_does_not_pass(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    elsewhere = tmp_path / "elsewhere.gates.toml"
    elsewhere.write_text(f'{GATES.splitlines()[0]}\nmetric = "max_jerk"\nmax = 100\nstages = ["rw"]\n')
    assert campaign(tmp_path, "--runs", "2", "--gates", str(elsewhere)) == 1
    out, err = capsys.readouterr()
    assert out.startswith("2 runs: 2 INCONCLUSIVE")
    assert err.endswith("dvp campaign: not one drive decided anything\n")


def test_a_baseline_of_another_seed_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its drives would not be those of this campaign, and nothing would be compared."""
    assert campaign(tmp_path, "--out", str(tmp_path / "before"), "--runs", "1", "--seed", "8") == 0
    capsys.readouterr()
    assert campaign(tmp_path, "--baseline", str(tmp_path / "before")) == 2
    assert capsys.readouterr().err == "--baseline: driven with seed 8, this campaign with 7; allowed: --seed 8\n"
    assert campaign(tmp_path, "--baseline", str(tmp_path / "before"), "--seed", "8") == 0
    assert capsys.readouterr().out.startswith("1 variants driven before and now: 0 passed before and fail now")
    assert campaign(tmp_path, "--out", str(tmp_path / "now"), "--runs", "1") == 0
    capsys.readouterr()
    assert main(["campaign", str(tmp_path / "now"), "--status", "--baseline", str(tmp_path / "before")]) == 1
    assert capsys.readouterr().err.endswith("nothing was compared\n")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--method", "sobel"], "--method: unknown value 'sobel', did you mean 'sobol'?"),
        (["--runs", "0"], "--runs is 0, expected a whole number >= 1"),
        (["--keep-logs", "some"], "--keep-logs: unknown value 'some'"),
        (["--baseline", "nowhere"], "--baseline: nowhere: no campaign: it holds no campaign.sqlite"),
    ],
)
def test_a_wrong_option_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    assert campaign(tmp_path, *words) == 2
    err = capsys.readouterr().err
    assert err.startswith(said)
    assert err.count("\n") == 1


def test_an_out_below_a_file_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "taken").write_text("")
    assert campaign(tmp_path, "--out", str(tmp_path / "taken" / "below")) == 2
    assert capsys.readouterr().err == f"--out {tmp_path / 'taken' / 'below'}: {tmp_path / 'taken'} is no folder\n"


def test_a_folder_that_is_no_campaign_has_no_status(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", str(tmp_path), "--status"]) == 2
    assert capsys.readouterr().err == f"{tmp_path}: no campaign: it holds no campaign.sqlite\n"


def test_parts_put_together_are_the_whole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    keys = {}
    for name, more in (("whole", []), ("one", ["--shard", "1/2"]), ("two", ["--shard", "2/2"])):
        assert campaign(tmp_path, "--out", str(tmp_path / name), "--runs", "3", *more) == 0
        keys[name] = keys_of(tmp_path / name)
    assert (len(keys["one"]), len(keys["two"])) == (2, 1)
    words = ["campaign", str(tmp_path / "one"), str(tmp_path / "two"), "--merge", "--out", str(tmp_path / "both")]
    assert main(words) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[-1] != ""
    assert f"without --shard, with --out {tmp_path / 'both'}, drives nothing again" in err
    assert keys_of(tmp_path / "both") == keys["whole"] == keys["one"] | keys["two"]
    assert campaign(tmp_path, "--out", str(tmp_path / "both"), "--runs", "3") == 0
    assert "3 of 3 driven" in capsys.readouterr().err
    assert keys_of(tmp_path / "both") == keys["whole"]
    assert (tmp_path / "both" / "map.html").is_file()
    assert main(["campaign", str(tmp_path / "one"), "--merge", "--out", str(tmp_path / "one")]) == 2


def keys_of(folder: Path) -> set[str]:
    with sqlite3.connect(folder / "campaign.sqlite") as file:
        return {row[0] for row in file.execute("SELECT key FROM runs")}


@pytest.mark.parametrize("part", ["3/2", "0/2", "1", "a/b", "-1/2"])
def test_a_part_that_is_none_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str], part: str) -> None:
    assert campaign(tmp_path, f"--shard={part}") == 2
    assert capsys.readouterr().err.startswith(f"--shard: found {part!r}, expected ")


def test_reproducers_of_scenarios_of_one_name_are_kept_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    files = [write_scenario(tmp_path / folder) for folder in ("north", "south")]
    for file in files:  # no car brakes or speeds up without jerk
        file.with_name("good.gates.toml").write_text('[[gate]]\nmetric = "max_jerk"\nmax = 0.001\n')
    words = ["campaign", *map(str, files), "--runs", "1", "--jobs", "1", "--duration", "2", "--out", "out"]
    assert main(words) == 1
    written = sorted(path.name for path in (tmp_path / "out" / "reproducers").iterdir())
    assert [name.partition("-max")[0] for name in written] == ["north--good", "south--good"]
