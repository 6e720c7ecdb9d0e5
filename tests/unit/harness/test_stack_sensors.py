"""Sensors that a driving stack declares to read: the others stay silent, and these measure what they always do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stack_faults import AdsError
from pytest_dvp.drive.stack_host import find_ads
from pytest_dvp.drive.stack_sensors import read_by
from pytest_dvp.mutation.catalogue import FAULTS
from pytest_dvp.mutation.faulty_stack import behind
from vehicle.messages import TRACE_COLUMNS, Command, Observation, Reading
from vehicle.sensors.suite import RunningSensor, SensorSuite, default_sensors

Write = Callable[..., Path]
COUNTS = """
from vehicle.messages import Command


class Counts:
    reads = ["gnss", "lidar"]

    def __init__(self):
        self.trace = dict.fromkeys(("gnss", "odometry", "imu", "lidar", "camera", "x"), 0.0)

    def tick(self, observation):
        for name in ("gnss", "odometry", "imu"):
            self.trace[name] += len(getattr(observation, name))
        for name in ("lidar", "camera"):
            self.trace[name] += getattr(observation, name) is not None
        self.trace["x"] += sum(fix.x for fix in observation.gnss)
        return Command(observation.t, 0.0, 0.0, 0.2, 0.0)


class All(Counts):
    reads = None
"""


class Stack:
    """Coasts; `reads` is what a test gives it."""

    reads: Any = None

    def tick(self, observation: Observation) -> Command:
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)


def declaring(reads: Any) -> Any:
    return find_ads(type("Mine", (Stack,), {"reads": reads}))


@pytest.mark.parametrize("process", ["on", "off"])
def test_only_what_it_reads_is_simulated_and_measures_the_same(
    process: str, scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario()
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(COUNTS)
    some, every = (
        run("x.xosc", ads=f"mine.py:{name}", duration=1.0, stack_process=process).log for name in ("Counts", "All")
    )
    for name in ("odometry", "imu", "camera"):
        assert (some[f"ads.{name}"][-1], every[f"ads.{name}"][-1] > 0.0) == (0.0, True)
    for name in ("gnss", "lidar", "x"):
        np.testing.assert_array_equal(some[f"ads.{name}"], every[f"ads.{name}"])
    assert some["ads.gnss"][-1] >= 9.0


def test_a_misspelt_sensor_is_one_line(
    scenario: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario()
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(COUNTS.replace('"lidar"]', '"lidr"]'))
    assert main(["run", "x.xosc", "--ads", "mine.py:Counts"]) == 2
    said = "ADS mine.py:Counts: reads: unknown sensor 'lidr', did you mean 'lidar'?"
    assert said in capsys.readouterr().err.splitlines()[-1]


def test_one_name_without_a_tuple_is_told() -> None:
    with pytest.raises(AdsError, match=r"reads: found 'gnss', expected names in a tuple: \('gnss',\)"):
        read_by(declaring("gnss"))


def test_a_name_beside_what_is_none_is_told() -> None:
    with pytest.raises(AdsError, match=r"reads: found 3 \(int\) among the names, expected names of sensors"):
        read_by(declaring(("gnss", 3)))


@pytest.mark.parametrize("reads", [None, 3, property(lambda _: ()), lambda self: (), (1, 2), {"gnss": 1}])
def test_an_attribute_that_means_another_thing_declares_nothing(reads: Any) -> None:
    assert read_by(declaring(reads)) is None


def test_none_of_them_is_declared_by_an_empty_tuple() -> None:
    assert read_by(declaring(())) == frozenset()


def test_a_stack_behind_a_fault_reads_what_it_reads_without() -> None:
    assert read_by(find_ads(behind(declaring(("imu",)), FAULTS[0]))) == {"imu"}


class Dice:
    """A further sensor that shows the first number it draws."""

    def start(self, t: float, seed: np.random.SeedSequence) -> RunningSensor:
        first = float(np.random.default_rng(seed).random())

        class Shown:
            def measure(self, row: Sequence[float]) -> None:
                pass

            def arrived(self, t: float) -> tuple[Reading, ...]:
                return (Reading(t, (first,)),)

        return Shown()


def test_a_further_sensor_draws_the_same_whoever_else_is_silent() -> None:
    from vehicle.messages import Surroundings

    suite = SensorSuite(gnss=default_sensors().gnss, further={"one": Dice(), "two": Dice()})
    row = [0.0] * len(TRACE_COLUMNS)
    around = Surroundings(np.zeros((0, 9)), np.zeros(0, dtype=np.int64), ())
    seen = {
        reads: suite.start(row, 7, reads).observe(0.1, around).readings for reads in (None, ("two",), ("gnss", "one"))
    }
    assert seen["two",] == {"two": seen[None]["two"]}
    assert seen["gnss", "one"] == {"one": seen[None]["one"]}
    assert seen[None]["one"] != seen[None]["two"]
