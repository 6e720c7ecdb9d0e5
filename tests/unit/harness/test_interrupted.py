"""SIGINT is an end of a run: the car is stopped, the log so far is kept, one line says so."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.run import Interrupted, run
from pytest_dvp.logs.log import Log
from tests.unit.harness.conftest import OneTrick, coast
from vehicle.messages import Command, Observation
from vehicle.twin import Twin

Write = Callable[..., Path]

STACK = """
import signal
from vehicle.messages import Command

class Interrupting:
    def tick(self, observation):
        if observation.t >= 1.0:
            signal.raise_signal(signal.SIGINT)
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)
"""


@pytest.fixture(autouse=True)
def heard() -> Iterator[None]:
    """A session that a shell has put into the background ignores SIGINT; here it is heard."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupted_at(t: float) -> Callable[[Observation], Command]:
    def tick(observation: Observation) -> Command:
        if observation.t >= t:
            signal.raise_signal(signal.SIGINT)
        return coast(observation)

    return tick


def test_the_car_is_stopped_and_the_log_so_far_is_kept(
    scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stopped: list[bool] = []
    monkeypatch.setattr(Twin, "stop", lambda _: stopped.append(True))
    with pytest.raises(Interrupted, match=r"x\.xosc \[dt\] interrupted at t=2\.00 s; its log so far: .*0001-x-dt$"):
        run(scenario(), ads=OneTrick(interrupted_at(2.0)), log_dir=tmp_path / "runs")
    assert stopped == [True]
    folder = tmp_path / "runs" / "0001-x-dt"
    assert sorted(path.name for path in folder.iterdir()) == ["log.mcap", "result.json"]
    log = Log.load(folder)
    assert log.t[-1] == pytest.approx(2.0)
    assert [(event.kind, event.text) for event in log.events][-1] == ("fault", "interrupted")
    result = json.loads((folder / "result.json").read_text())
    assert (result["status"], result["ended"]) == ("ERROR", "an interruption (SIGINT)")


def test_an_interruption_in_the_middle_of_a_record_leaves_a_whole_log(
    scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between what the recorder keeps of one tick: a command without the traffic that belongs to it."""

    class Breaking(list[object]):
        def append(self, value: object) -> None:
            if len(self) == 30:
                signal.raise_signal(signal.SIGINT)
            super().append(value)

    def begun(recorder: object, *rest: object, **more: object) -> None:
        original(recorder, *rest, **more)  # type: ignore[arg-type]
        recorder._boxes = Breaking()  # type: ignore[attr-defined]

    from pytest_dvp.logs.recorder import LogRecorder

    original = LogRecorder.__init__
    monkeypatch.setattr(LogRecorder, "__init__", begun)
    with pytest.raises(Interrupted):
        run(scenario(), ads=OneTrick(coast), log_dir=tmp_path)
    log = Log.load(next(tmp_path.glob("0001-*")))
    assert log.t[-1] == pytest.approx(1.5)
    assert len(log["steer_cmd"]) == len(log.t)


def test_the_command_says_it_in_one_line_and_exits_with_130(
    scenario: Write, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = scenario()
    monkeypatch.chdir(tmp_path)
    Path("s.py").write_text(STACK)
    assert main(["run", str(path), "--ads", "s.py:Interrupting", "--stack-process", "off"]) == 130
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.splitlines()[1:] == [
        "dvp: x.xosc [dt] interrupted at t=1.00 s; its log so far: runs/0001-x-dt",
    ]


def test_a_second_interruption_leaves_the_part(
    scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def again(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("pytest_dvp.drive.run_folder.write_run", again)
    with pytest.raises(KeyboardInterrupt):
        run(scenario(), ads=OneTrick(interrupted_at(2.0)), log_dir=tmp_path)
    assert main(["recover", str(tmp_path / "0001-x-dt"), "--out", str(tmp_path / "out.mcap")]) == 0
    assert Log.load(tmp_path / "out.mcap").t[-1] == pytest.approx(2.0)
