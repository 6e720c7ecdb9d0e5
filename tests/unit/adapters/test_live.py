"""A car by the wall clock: its clock is found, its motion put on the log's grid, its death an ERROR with a log.

How punctual it is depends on the machine and is measured elsewhere (docs/reliability.md); nothing here asserts times.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stages import StageError
from tests.unit.harness.conftest import OneTrick, coast
from tests.unit.harness.conftest import scenario as scenario
from tests.unit.harness.test_loop import WITH_TARGET
from vehicle.adapters import live
from vehicle.adapters.live import LiveCarProcess, Punctuality
from vehicle.messages import Command, Observation
from vehicle.wire.live import Ping

Write = Callable[..., Path]


def drive(path: Path, stage: str = "rw", **options: object) -> RunResult:
    return run(path, stage=stage, clock="real", duration=1.0, **options)  # type: ignore[arg-type]


@pytest.fixture
def cars(monkeypatch: pytest.MonkeyPatch) -> list[LiveCarProcess]:
    """The cars that were started."""
    found: list[LiveCarProcess] = []
    start = live.live_surrogate

    def started(*arguments: object, **options: object) -> LiveCarProcess:
        found.append(start(*arguments, **options))  # type: ignore[arg-type]
        return found[-1]

    monkeypatch.setattr(live, "live_surrogate", started)
    return found


@pytest.mark.nightly
def test_a_run_has_a_log_at_100_hz_on_the_harnesss_clock(scenario: Write, cars: list[LiveCarProcess]) -> None:
    """The car's own clock begins elsewhere; at 5 m/s the car has rolled 5 m after a second."""
    seen: list[Observation] = []

    def watch(observation: Observation) -> Command:
        seen.append(observation)
        return coast(observation)

    log = drive(scenario(*WITH_TARGET), ads=OneTrick(watch)).log
    assert np.diff(log.t) == pytest.approx(0.01, abs=1e-9)
    assert log.t[-1] > 0.8
    rolled = np.hypot(log.columns["x"][-1] - log.columns["x"][0], log.columns["y"][-1] - log.columns["y"][0])
    assert rolled == pytest.approx(5.0 * log.t[-1], rel=0.1)
    stamps = [fix.t for observation in seen for fix in observation.gnss]
    assert stamps == sorted(stamps)
    assert -0.1 < stamps[0] <= stamps[-1] <= log.t[-1] + 0.1
    assert any(observation.lidar is not None and len(observation.lidar.points) for observation in seen)
    assert log.meta["timing"]["commands"] >= 50
    assert cars[0].process.returncode is not None  # nothing is left


@pytest.mark.nightly
def test_over_can_it_drives_by_the_wall_clock_too(scenario: Write, cars: list[LiveCarProcess]) -> None:
    """Pedals go out, speed and steering angle come in; motion comes from the reference system as ever."""
    pytest.importorskip("cantools")
    seen: list[Observation] = []

    def push(observation: Observation) -> Command:
        seen.append(observation)
        return Command(observation.t, 0.0, 1.0, 0.4, 0.0)

    log = drive(scenario(), ads=OneTrick(push), vehicle="can").log
    assert log.columns["v"][-1] > log.columns["v"][0]
    stamps = [wheels.t for observation in seen for wheels in observation.odometry]
    assert len(stamps) > 20
    assert stamps == sorted(stamps)
    assert -0.1 < stamps[0] <= stamps[-1] <= log.t[-1] + 0.1
    assert log.meta["vehicle"] | {"wire": "can", "clock": "real"} == log.meta["vehicle"]
    assert cars[0].process.returncode is not None


@pytest.mark.nightly
def test_in_parallel_execution_the_mirror_follows(scenario: Write) -> None:
    """5 cm and what the car drives during the latency, the promise, with much room: it rolls straight on."""
    log = drive(scenario(), "pe", ads=OneTrick(coast)).log
    error, latency = log.columns["mirror_error"], log.columns["mirror_latency"]
    known = np.isfinite(error)
    assert known.any()
    assert (error[known] <= 0.05 + latency[known] * 5.0).all()


@pytest.mark.parametrize(
    ("how", "says"),
    [
        (signal.SIGKILL, "ended (killed by SIGKILL)"),
        *([(signal.SIGSTOP, "stopped (SIGSTOP)|silent for")] if "DVP_NIGHTLY" in os.environ else []),
    ],
)
def test_a_car_that_dies_or_hangs_is_an_error_with_its_log_so_far(
    scenario: Write, cars: list[LiveCarProcess], how: signal.Signals, says: str
) -> None:
    def strike(observation: Observation) -> Command:
        if observation.t >= 0.5:
            os.kill(cars[-1].process.pid, how)
        return coast(observation)

    result = drive(scenario(), ads=OneTrick(strike))
    assert result.status == "ERROR"
    assert result.error is not None
    assert any(part in result.error for part in says.split("|"))
    assert 0.3 < result.log.duration < 0.8
    assert cars[-1].process.returncode is not None
    if how is signal.SIGSTOP:
        assert drive(scenario(), ads=OneTrick(coast)).error is None  # the next one is untouched


def test_of_round_trips_the_share_that_missed_is_told() -> None:
    kept = Punctuality()
    kept.lateness = [0.001] * 97 + [0.011, 0.02, 0.05]
    kept.pings = [Ping(200_000, 1_000_000_050), Ping(900_000, 1_000_400_000)]
    kept.offset = 1_000_000_000
    told = kept.as_dict()
    assert (told["commands"], told["missed"], told["lateness_worst"]) == (100, pytest.approx(0.03), 0.05)
    assert told["round_trip_median"] == pytest.approx(550e-6)
    assert told["clock_offset_drift"] == pytest.approx(50e-9)  # the slow one tells nothing about the clock


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"clock": "wall"}, r"^unknown clock 'wall', did you mean 'real'"),
        ({"clock": "real", "fault": "drop@1+1"}, r"fault drop@1\+1 runs in stepped time"),
    ],
)
def test_what_does_not_run_in_real_time_is_said(scenario: Write, options: dict[str, object], says: str) -> None:
    with pytest.raises(StageError, match=says):
        run(scenario(), stage="rw", **options)  # type: ignore[arg-type]
