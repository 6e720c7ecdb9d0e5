"""What a command is to write is asked for before it works, and is never a file that it reads."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main

CSV = "t [s],accel_cmd [m/s^2],steer_cmd [rad],x [m],y [m],yaw [rad],v [m/s]\n"
LOG = CSV + "".join(f"{k / 50},0,0,{k / 10},0,0,5\n" for k in range(200))
FULL = Path("/dev/full")

WRITES: dict[str, tuple[str, tuple[str, ...]]] = {
    "play --csv": ("x.xosc", ("play", "x.xosc", "--csv")),
    "play --events": ("x.xosc", ("play", "x.xosc", "--events")),
    "map": ("a.csv", ("map", "a.csv", "--out")),
    "recover": ("a.csv", ("recover", "a.csv", "--out")),
    "compare": ("a.csv", ("compare", "a.csv@0:2", "--model", "m.toml", "--report")),
    "diagnose": ("m.toml", ("diagnose", "a.csv", "--model", "m.toml", "--report")),
    "extend": ("a.csv", ("extend", "--fit", "a.csv@0:2", "--model", "m.toml", "--force", "--out")),
    "report": ("log.mcap", ("report", "log.mcap", "--out")),
    "stages": ("log.mcap", ("stages", ".", "--out")),
    "iterate": ("plan.toml", ("iterate", "plan.toml", "--report")),
}

Say = Callable[..., tuple[int, str]]


@pytest.fixture
def say(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
        scenarios_dir: Path) -> Say:  # fmt: skip
    """Exit code and complaint of a command in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(scenarios_dir / "overtaking.xosc", "x.xosc")
    Path("a.csv").write_text(LOG)
    Path("m.toml").write_text('[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.5\n')
    for name in ("log.mcap", "plan.toml"):
        Path(name).write_text("mine")

    def said(*words: str) -> tuple[int, str]:
        code = main(words)
        return code, capsys.readouterr().err

    return said


@pytest.mark.parametrize("command", WRITES)
def test_a_file_that_is_read_is_not_written_over(say: Say, command: str) -> None:
    read, words = WRITES[command]
    before = Path(read).read_bytes()
    assert say(*words, read) == (2, f"{words[-1]} {read} is a file that is read: name another\n")
    assert Path(read).read_bytes() == before
    Path(f"link{Path(read).suffix}").symlink_to(read)  # nor under another name
    assert say(*words, f"link{Path(read).suffix}")[0] == 2
    assert Path(read).read_bytes() == before


@pytest.mark.parametrize("command", WRITES)
def test_a_place_that_takes_no_file_is_said_before_the_work(say: Say, command: str) -> None:
    read, words = WRITES[command]
    end, option = Path(read).suffix, words[-1]
    Path(f"folder{end}").mkdir()
    Path(f"away{end}").symlink_to(f"none/there{end}")
    wrong = {
        f"folder{end}": "a folder, expected a file",
        f"none/x{end}": "no folder none",
        f"{read}/x{end}": f"{read} is no folder",
        f"away{end}": f"no folder {Path.cwd() / 'none'}",
    }
    assert {text: say(*words, text) for text in wrong} == {
        text: (2, f"{option} {text}: {why}\n") for text, why in wrong.items()
    }
    assert say(*words, "") == (2, f"{option}: no name, expected a file\n")
    assert say(*words, "x" * 300 + end) == (2, f"{option} {'x' * 300}{end}: File name too long\n")


@pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")
@pytest.mark.parametrize("command", ["map", "recover"])
def test_a_full_disk_is_one_line_and_leaves_nothing(say: Say, command: str) -> None:
    read, words = WRITES[command]
    end = Path(read).suffix
    Path(f"full{end}").symlink_to(FULL)
    code, said = say(*words, f"full{end}")
    assert (code, said.splitlines()[-1]) == (2, f"full{end}: cannot be written: No space left on device")
    assert stat.S_ISCHR(FULL.stat().st_mode)
    assert [path.name for path in Path().iterdir() if path.suffix == ".part"] == []


def test_two_tables_do_not_go_to_one_place(say: Say) -> None:
    assert say("play", "x.xosc", "--csv", "a.txt", "--events", "./a.txt") == (
        2, "--csv and --events both name a.txt; name two files\n",
    )  # fmt: skip
    assert say("play", "x.xosc", "--csv", "-", "--json") == (
        2, "--csv and --json both go to stdout; name a FILE for one of them\n",
    )  # fmt: skip


@pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")
def test_a_full_disk_behind_stdout_is_one_line() -> None:
    with FULL.open("w") as full:
        command = [sys.executable, "-m", "pytest_dvp.cli", "metrics"]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (1, "the output: No space left on device\n")


def test_a_reader_that_has_seen_enough_is_told_nothing() -> None:
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "pytest_dvp.cli", "metrics"]
    done = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    os.close(write)
    assert done.stderr == ""


def test_a_name_that_the_terminal_cannot_show_is_spelled_out(tmp_path: Path) -> None:
    (tmp_path / "früh.csv").write_text(LOG)
    command = [sys.executable, "-m", "pytest_dvp.cli", "doctor", "früh.csv"]
    ascii_only = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, cwd=tmp_path, env=ascii_only, capture_output=True, timeout=120, check=False)
    assert b"Traceback" not in done.stderr
    assert b"fr\\xfch.csv" in done.stdout


def test_a_scenario_whose_name_is_no_utf8_leaves_a_run(tmp_path: Path, scenario: Callable[..., Path]) -> None:
    path = scenario()
    other = os.fsencode(path.parent) + b"/f\xfcr.xosc"
    try:
        os.rename(path, other)
    except OSError:
        pytest.skip("this file system takes UTF-8 names only")
    runs = tmp_path / "runs"
    assert main(["run", os.fsdecode(other), "--duration", "0.5", "--runs", str(runs)]) in (0, 1)
    (folder,) = runs.glob("0*")
    assert sorted(file.name for file in folder.iterdir()) == ["log.mcap", "report.html", "result.json"]
    assert b"f\\\\udcfcr.xosc" in (folder / "result.json").read_bytes()
