"""The part of a log that a run writes while it drives: what is recovered of it is the log so far, bit for bit."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.difference import first_difference
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.partial_log import PERIOD, LogPart
from pytest_dvp.logs.recorder import LogRecorder
from pytest_dvp.logs.recovery import recover
from pytest_dvp.logs.unfinished_run import PART
from vehicle.messages import TRACE_COLUMNS, Command, Detection, Surroundings

TICK = 0.05  # s
NAN, INF = float("nan"), float("inf")


def new_recorder() -> LogRecorder:
    road = [{"kind": "edge", "points": [[0.0, 1.0], [9.0, 1.0]]}]
    return LogRecorder(
        {"scenario": "x.xosc", "stage": "dt", "seed": 7, "model": {"toml": "a = 1\n"}},
        reference=np.array([[0.0, 0.0], [50.0, 0.0]]),
        road=road,
    )


def record(recorder: LogRecorder, k: int) -> None:
    """Tick number k with whatever a recorder takes."""
    t = k * TICK
    names = ("car", "walker")[: 1 + k % 2]
    boxes = np.full((len(names), 9), 1.0 + k)
    path = np.array([[k, 0.0], [k + 5.0, 1.0]]) if k % 7 == 0 else None
    detections = [Detection(t, "vehicle", 5.0 + k, 0.5, 0.1, 4.0, 1.8, 1.0, NAN)] * (k % 3)
    recorder.hold(t + 0.01, {"gate.steer_cmd": 0.1 * k})
    recorder.tick(
        t, command=None if k == 0 else Command(t, 0.1, -INF, 0.0, 0.5), ads={"v": np.float64(k), f"x{k % 5}": k},
        surroundings=Surroundings(boxes, np.zeros(len(names), dtype=np.int64), names), detections=detections,
        path=path, held={"on_road": 1.0},
    )  # fmt: skip
    rows = np.zeros((5, len(TRACE_COLUMNS)))
    rows[:, 0] = t + 0.01 * np.arange(1, 6)
    rows[:, 1:] = np.random.default_rng(k).normal(size=(5, len(TRACE_COLUMNS) - 1))
    recorder.ego_rows(rows)
    if k % 10 == 3:
        recorder.event(t, "request", "speed", f"tick {k}", "x.xosc", k)


def so_far(ticks: int) -> Log:
    recorder = new_recorder()
    for k in range(ticks):
        record(recorder, k)
    return recorder.finish()


def drive(path: Path, ticks: int) -> LogPart:
    """A run that is ended in tick number `ticks`: its part is told of the time first, as the loop does it."""
    recorder = new_recorder()
    part = LogPart(path, recorder)
    for k in range(ticks):
        part.reached(k * TICK)
        record(recorder, k)
    part.reached(ticks * TICK)
    part.close()  # which writes nothing
    return part


@pytest.mark.parametrize("ticks", [25, 100, 107])
def test_all_but_the_last_second_is_recovered_bit_for_bit(tmp_path: Path, ticks: int) -> None:
    drive(tmp_path / PART, ticks)
    recover(tmp_path / PART, tmp_path / "out.mcap")
    log = Log.load(tmp_path / "out.mcap")
    assert ticks * TICK - 1.0 <= log.t[-1] <= ticks * TICK
    whole = round(log.t[-1] / TICK)
    assert first_difference(log, so_far(whole)) is None


def test_a_part_that_was_cut_in_a_chunk_yields_the_chunks_before(tmp_path: Path) -> None:
    drive(tmp_path / PART, 100)
    data = (tmp_path / PART).read_bytes()
    (tmp_path / PART).write_bytes(data[:-100])
    recover(tmp_path / PART, tmp_path / "out.mcap")
    assert first_difference(Log.load(tmp_path / "out.mcap"), so_far(72)) is None  # of chunks of 18 ticks, four


def test_a_part_without_its_beginning_is_one_line(tmp_path: Path) -> None:
    drive(tmp_path / PART, 100)
    data = bytearray((tmp_path / PART).read_bytes())
    data[data.index(b"lz4") + 60] ^= 0xFF
    (tmp_path / PART).write_bytes(data)
    with pytest.raises(
        LogError,
        match=r"log\.mcap\.part: nothing can be recovered: what says of which topics its messages are is lost$",
    ):
        recover(tmp_path / PART, tmp_path / "out.mcap")


def test_a_full_disk_costs_the_part_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    recorder = new_recorder()
    part = LogPart(tmp_path / PART, recorder)
    monkeypatch.setattr("pytest_dvp.logs.partial_log.os.write", full)
    for k in range(50):
        part.reached(k * TICK)
        record(recorder, k)
    monkeypatch.undo()
    part.close()
    assert part.failed == f"{tmp_path / PART}: cannot be written: No space left on device"
    assert first_difference(recorder.finish(), so_far(50)) is None


def test_a_chunk_follows_each_second(tmp_path: Path) -> None:
    assert 0.5 < PERIOD + TICK <= 1.0
    sizes = [drive(tmp_path / f"{n}", n).path.stat().st_size for n in (1, 17, 18, 36)]
    assert sizes[0] == sizes[1] < sizes[2] < sizes[3]


@pytest.mark.parametrize(
    "words",
    [
        ["report", "RUN"], ["replay", "RUN"], ["doctor", "RUN"], ["stages", "RUN"], ["report", "RUN/log.mcap.part"],
        ["doctor", "RUN/log.mcap.part"], ["compare", "--model", "m.toml", "RUN"],
        ["run", "x.xosc", "--stage-logs", "RUN"],
    ],
)  # fmt: skip
def test_a_run_that_was_killed_is_one_line_with_the_command_that_reads_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, words: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("RUN").mkdir()
    drive(Path("RUN") / PART, 30)
    for name in ("x.xosc", "m.toml"):
        Path(name).write_text("")
    assert main(words) in (1, 2)
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    place = tmp_path / "RUN" if words[0] == "run" else "RUN"  # a setting knows where it was said
    assert said[0].endswith(f"what there is of it: dvp recover {place} --out FILE.mcap")


def test_the_folder_of_a_killed_run_is_recovered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drive(tmp_path / PART, 100)
    assert main(["recover", str(tmp_path), "--out", str(tmp_path / "out.mcap")]) == 0
    assert capsys.readouterr().out.splitlines()[1:] == ["  lost: what came after the last whole second"]


KILLED = """
import os, signal, sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from tests.unit.results.test_log_part import drive
drive(Path(sys.argv[1]), 100)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_sigkill_leaves_the_part(tmp_path: Path) -> None:
    root = str(Path(__file__).parents[3])
    command = [sys.executable, "-c", KILLED.format(tests=root), str(tmp_path / PART)]
    assert subprocess.run(command, check=False, timeout=60).returncode == -9
    recover(tmp_path / PART, tmp_path / "out.mcap")
    assert Log.load(tmp_path / "out.mcap").t[-1] >= 4.0
