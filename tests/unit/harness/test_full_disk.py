"""A disk that is full loses files, never a verdict: `run` and `dvp run` say in one line which, and why."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from pytest_dvp.logs.difference import first_difference
from pytest_dvp.logs.log import Log
from tests.unit.harness.conftest import OneTrick, coast

Write = Callable[..., Path]
FULL = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def fill_disk(monkeypatch: pytest.MonkeyPatch, *names: str) -> None:
    """No file whose name holds one of `names` finds room for its bytes any more."""
    sync = os.fsync

    def full(file: int) -> None:
        if any(name in os.readlink(f"/proc/self/fd/{file}") for name in names):
            raise FULL
        sync(file)

    monkeypatch.setattr("reports.whole_file.os.fsync", full)


def driven(scenario: Write, root: Path | None) -> RunResult:
    return run(scenario(), ads=OneTrick(coast), log_dir=root)


@pytest.mark.parametrize(
    ("name", "left"),
    [
        (".log.mcap", ["log.mcap.part"]),
        (".result.json", ["log.mcap", "report.html"]),
        (".report.html", ["log.mcap", "result.json"]),
        ("plotly-", ["log.mcap", "report.html", "result.json"]),
    ],
)
def test_a_file_is_lost_and_no_verdict(
    scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, left: list[str]
) -> None:
    whole = driven(scenario, None)
    monkeypatch.chdir(tmp_path)
    fill_disk(monkeypatch, name)
    result = driven(scenario, Path("runs"))
    assert (result.status, result.verdicts) == (whole.status, whole.verdicts)
    (note,) = (note for note in result.notes if note.startswith("not written: "))
    file = "runs/assets/plotly-" if name == "plotly-" else f"runs/0001-x-dt/{name[1:]}"
    assert note.startswith(f"not written: {file}")
    assert "cannot be written: No space left on device" in note
    assert sorted(path.name for path in Path("runs/0001-x-dt").iterdir()) == left
    assert (result.folder is None) == (name == ".log.mcap")
    assert not list(Path("runs").glob(".*"))


def test_the_part_then_holds_the_whole_log(scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fill_disk(monkeypatch, ".log.mcap")
    result = driven(scenario, tmp_path)
    monkeypatch.undo()
    assert main(["recover", str(tmp_path / "0001-x-dt"), "--out", str(tmp_path / "out.mcap")]) == 0
    assert first_difference(Log.load(tmp_path / "out.mcap"), result.log) is None


def test_the_command_prints_the_verdict_and_exits_by_it(
    scenario: Write, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = scenario()
    monkeypatch.chdir(tmp_path)
    words = ["run", str(path), "--ads", "s.py:Coasting", "--stack-process", "off"]
    Path("s.py").write_text(
        "from vehicle.messages import Command\n"
        "class Coasting:\n    def tick(self, seen):\n        return Command(seen.t, 0.0, 0.0, 0.0, 0.0)\n"
    )
    code = main(words)
    before = capsys.readouterr().out.splitlines()
    fill_disk(monkeypatch, ".log.mcap", ".result.json", ".report.html")
    assert main(words) == code
    after = capsys.readouterr().out.splitlines()
    lost = [line for line in after if line.startswith("  !! not written: ")]
    assert lost == [
        "  !! not written: runs/0002-x-dt/log.mcap: cannot be written: No space left on device; "
        "what there is of the log: dvp recover runs/0002-x-dt --out FILE.mcap"
    ]
    assert [line for line in after if line not in lost] == [line for line in before if "report: " not in line]


def test_no_room_for_a_folder_costs_no_verdict(
    scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make = Path.mkdir

    def full(path: Path, *rest: object, **more: object) -> None:
        if tmp_path / "runs" in (path, *path.parents):
            raise FULL
        make(path, *rest, **more)  # type: ignore[arg-type]

    path = scenario()
    monkeypatch.setattr(Path, "mkdir", full)
    result = run(path, ads=OneTrick(coast), log_dir=tmp_path / "runs")
    assert result.folder is None
    assert result.verdicts
    assert [note for note in result.notes if "No space left" in note] == [
        f"not written: {tmp_path / 'runs'}: no run folder can be made: No space left on device"
    ]
