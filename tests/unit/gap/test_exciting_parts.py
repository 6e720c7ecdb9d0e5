"""Which parts of long logs a diagnosis looks at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gap_logs import drive

from pytest_dvp.cli.command_line import main
from pytest_dvp.gap.diagnose import part_selection as module
from pytest_dvp.gap.diagnose.part_selection import exciting_parts
from pytest_dvp.logs.log import Log
from tests.truth.generate import write_csv

COMMANDS = ("steer_cmd", "accel_cmd")


def eventful(where: tuple[tuple[float, float, str], ...], seconds: float = 600.0) -> Log:
    """A car that stands still but for sine commands of a kind from start to stop [s], at 50 Hz."""
    t = np.arange(0.0, seconds, 0.02)
    columns = {"t": t, **{name: np.zeros(len(t)) for name in (*COMMANDS, "v", "yaw_rate")}}
    for start, stop, name in where:
        inside = (t >= start) & (t < stop)
        columns[name][inside] = np.sin(t[inside])
    return Log(columns)


def test_logs_that_are_short_enough_are_looked_at_as_a_whole() -> None:
    log = drive(20.0)
    (part,) = exciting_parts({"a": log}, COMMANDS, most=len(log.t))
    assert part.whole
    assert part.log is log


def test_of_a_long_log_the_parts_where_something_happens_are_kept_whole() -> None:
    log = eventful(((100.0, 140.0, "steer_cmd"), (400.0, 440.0, "accel_cmd")))
    parts = exciting_parts({"a": log}, COMMANDS, most=6000)
    assert sum(len(part.log.t) for part in parts) <= 6000
    for start, stop in ((100.0, 140.0), (400.0, 440.0)):
        assert any(part.start <= start and stop <= part.stop for part in parts)
    assert all(np.allclose(np.diff(part.log.t), 0.02) for part in parts)  # no row left out within
    assert all(part.start % 5.0 == 0.0 for part in parts)


def test_what_has_been_seen_often_gives_way_to_another_kind_of_driving() -> None:
    steering = [(start, start + 40.0, "steer_cmd") for start in (0.0, 40.0, 80.0, 120.0)]
    log = eventful((*steering, (500.0, 540.0, "accel_cmd")))
    assert any(part.stop > 500.0 for part in exciting_parts({"a": log}, COMMANDS, most=6000))


@pytest.mark.nightly
def test_a_long_log_is_diagnosed_on_parts_that_are_named_and_stand_in_the_next_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(module, "LONGEST", 3000)
    monkeypatch.chdir(tmp_path)
    write_csv(tmp_path / "long.csv", dict(drive(100.0, drive_gain=0.85).columns))
    Path("car.toml").write_text("[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n")
    assert main(["diagnose", "long.csv", "--model", "car.toml"]) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("looked at 60 of 100 s: long.csv@")
    words = told[-1].split()
    fitted = words[words.index("--fit") + 1 : words.index("--out")]
    assert len(fitted) == 3
    assert words[words.index("--add") + 1] == "drive_gain"
    assert all(word in told[0] for word in fitted)
