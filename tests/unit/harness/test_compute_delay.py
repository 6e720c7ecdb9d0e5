"""--compute-delay: commands that take their time in simulated time, and some that never arrive."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.compute_delay import ComputeDelay, Delayed, parse_delay
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stages import StageError
from pytest_dvp.logs.obeyed_commands import obeyed_command
from pytest_dvp.text.errors import SettingError
from tests.unit.harness.conftest import OneTrick
from vehicle.messages import Command, FloatArray, Observation

Write = Callable[..., Path]


class Car:
    """Notes when [ms] which command takes hold."""

    def __init__(self) -> None:
        self.now = 0
        self.got: list[tuple[int, float]] = []

    def apply(self, command: Command) -> None:
        self.got.append((self.now, command.steer))

    def step(self, dt: float) -> FloatArray:
        assert dt > 0.0
        self.now += round(1000 * dt)
        return np.zeros((0, 12))


def drive(text: str, ticks: int = 400, seed: int = 7) -> list[tuple[int, float]]:
    """Arrivals of commands 0, 1, 2, ... that are given every 50 ms."""
    car = Car()
    delayed = Delayed(car, parse_delay(text), seed, lambda t, command: None)  # type: ignore[arg-type]
    for k in range(ticks):
        delayed.apply(Command(k / 20, float(k), 0.0, 0.0, 0.0))
        delayed.step(0.05)
    assert car.now == 50 * ticks
    return car.got


@pytest.mark.parametrize("late", [0, 1, 49, 50, 51, 80, 137, 230])
def test_a_command_takes_hold_that_much_later_also_within_a_tick(late: int) -> None:
    got = drive(f"{late / 1000}", ticks=10)
    assert got == [(50 * k + late, float(k)) for k in range(10) if 50 * k + late < 500]


def test_jitter_varies_evenly_and_never_turns_the_order_round() -> None:
    got = drive("0.03+-0.02")
    late = np.array([t - 50 * k for t, k in got])
    assert [k for _, k in got] == [float(k) for k in range(len(got))]
    assert (late.min(), late.max()) == (pytest.approx(10, abs=1), pytest.approx(50, abs=1))
    assert late.mean() == pytest.approx(30, abs=2.0)  # 3 standard errors: 20 / sqrt(3) / sqrt(400) * 3
    wild = drive("0.2+-0.2")
    assert [k for _, k in wild] == sorted({k for _, k in wild})
    assert [t for t, _ in wild] == sorted(t for t, _ in wild)


def test_a_share_of_the_commands_never_arrives_and_the_last_one_stays() -> None:
    got = drive("0.01,drop=0.25")
    assert len(got) == pytest.approx(300, abs=26)  # 3 sqrt(400 * 0.25 * 0.75)
    assert all(t == 50 * k + 10 for t, k in got)
    assert drive("0.01,drop=1") == []


def test_the_draws_are_those_of_the_seed() -> None:
    assert drive("0.1+-0.05,drop=0.1") == drive("0.1+-0.05,drop=0.1")
    assert drive("0.1+-0.05,drop=0.1") != drive("0.1+-0.05,drop=0.1", seed=8)


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("0.08", ComputeDelay(0.08)),
        (" 0.08+-0.03 ", ComputeDelay(0.08, 0.03)),
        ("0.08±0.03", ComputeDelay(0.08, 0.03)),
        ("0,drop=0.5", ComputeDelay(0.0, 0.0, 0.5)),
        ("1e-2+-5e-3, drop=1", ComputeDelay(0.01, 0.005, 1.0)),
    ],
)
def test_what_is_allowed_is_read_and_told_again(text: str, read: ComputeDelay) -> None:
    assert parse_delay(text) == read == parse_delay(str(read))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("soon", "'soon' is no number, expected SECONDS[+-JITTER][,drop=SHARE]"),
        ("0.1+0.2", "is '0.1+0.2', expected SECONDS"),
        ("0.1,lose=0.2", "is '0.1,lose=0.2', expected SECONDS"),
        ("-0.1", "-0.1 s, expected 0 to 10 s"),
        ("99", "99 s, expected 0 to 10 s"),
        ("nan", "'nan' is not finite"),
        ("0.1+-0.2", "a jitter of 0.2 s, expected 0 to 0.1 s, the delay"),
        ("0.1,drop=5", "drop=5, expected a share from 0 to 1"),
        ("", "expected SECONDS"),
    ],
)
def test_what_is_not_allowed_is_one_line(text: str, says: str) -> None:
    with pytest.raises(SettingError) as caught:
        parse_delay(text)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def turn(observation: Observation) -> Command:
    return Command(observation.t, 0.05 if observation.t > 0.4 else 0.0, 0.0, 0.0, 0.0)


def test_a_run_turns_later_and_its_log_has_what_the_car_got(scenario: Write) -> None:
    path = scenario()
    soon, late = (run(path, ads=OneTrick(turn), duration=1.5, compute_delay=d) for d in (None, "0.137"))
    begin = [float(r.log.t[np.flatnonzero(np.abs(r.log["steer"]) > 1e-4)[0]]) for r in (soon, late)]
    assert begin[1] - begin[0] == pytest.approx(0.137, abs=0.011)  # the log has a row every 10 ms
    got = obeyed_command(late.log, "steer_cmd")
    assert got is not None
    assert late.log.t[np.flatnonzero(got)[0]] == pytest.approx(0.45 + 0.137, abs=0.011)
    assert np.isfinite(got).all()
    assert (late.log.meta["compute_delay"], late.compute_delay) == ("0.137", "0.137")
    assert "compute_delay" not in soon.log.meta


def test_it_is_repeated_byte_for_byte_by_the_command_that_is_printed(
    scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    scenario()
    assert main(["run", "x.xosc", "--compute-delay", "0.08±0.03,drop=0.1"]) == 0
    out = capsys.readouterr().out
    assert "--compute-delay 0.08+-0.03,drop=0.1" in out.splitlines()[-1]
    assert main(["replay", str(next(tmp_path.glob("runs/*")))]) == 0


def test_a_car_with_a_time_of_its_own_is_refused_in_one_line(scenario: Write) -> None:
    with pytest.raises(StageError, match=r"^--compute-delay is refused: stage pe drives a car that has its own time"):
        run(scenario(), stage="pe", compute_delay="0.1")
