"""PE and RW against the surrogate: named as such, the same bytes again, an ERROR with its log if the car is lost."""

from __future__ import annotations

import dataclasses
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
from pytest_dvp.logs.log import Log
from tests.plugin.conftest import XOSC, write_scenario
from tests.unit.harness.conftest import OneTrick, coast
from tests.unit.harness.test_loop import WITH_TARGET
from vehicle.adapters import process
from vehicle.messages import Command, LidarScan, Observation

Write = Callable[..., Path]


def drive(path: Path, stage: str, **options: object) -> RunResult:
    return run(path, stage=stage, duration=1.5, **options)  # type: ignore[arg-type]


@dataclasses.dataclass(frozen=True)
class Rolled:
    """A drive straight on towards the target, what its stack saw, and what was true."""

    stage: str
    result: RunResult
    seen: list[Observation]
    truth: Log


@pytest.fixture(scope="module", params=["pe", "rw"])
def rolled(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Rolled:
    """Each car is a process that has to start, so that several tests look at one drive."""
    folder, stack, text = tmp_path_factory.mktemp("rolled"), OneTrick(coast), XOSC
    for old, new in WITH_TARGET:
        text = text.replace(old, new)
    given = {"ads": stack, "log_dir": folder / "runs", "truth": folder / "truth.mcap"}
    result = drive(write_scenario(folder, text=text), request.param, **given)
    return Rolled(request.param, result, stack.seen, Log.load(folder / "truth.mcap"))


def test_a_result_says_that_it_is_of_a_surrogate(rolled: Rolled) -> None:
    stage, result = rolled.stage, rolled.result
    assert (result.stage, result.log.meta["stage"]) == (f"{stage}-surrogate", f"{stage}-surrogate")
    assert result.folder is not None
    assert result.folder.name.endswith(f"-{stage}-surrogate")


@pytest.mark.parametrize("stage", ["pe", "rw"])
@pytest.mark.nightly
def test_the_same_seed_gives_the_same_bytes(scenario: Write, stage: str, tmp_path: Path) -> None:
    """With the reference stack, which makes much of the smallest difference."""
    path = scenario(*WITH_TARGET)
    results = [drive(path, stage, log_dir=tmp_path / "runs") for _ in range(2)]
    first, second = (result.folder and (result.folder / "log.mcap").read_bytes() for result in results)
    assert first == second
    assert f" --stage {stage} " in results[0].replay


def test_the_stack_sees_the_target_through_the_cars_sensors(rolled: Rolled) -> None:
    """In RW the surrogate's own LiDAR meets it; in PE it is rendered into the LiDAR of a car on an empty place."""
    result = rolled.result
    assert result.error is None
    scans = scans_of(rolled.seen)
    assert len(scans) == 15  # 10 Hz for 1.5 s, 50 ms late
    target, ego = result.log.objects["Target"], result.log.columns
    scan = scans[-1]
    rear = target.x[0] - 2.0 - float(np.interp(scan.t, ego["t"], ego["x"])) - 1.18
    assert scan.points[:, 0].min() == pytest.approx(rear, abs=0.15)


@pytest.mark.parametrize("rolled", ["pe"], indirect=True)
def test_the_mirror_follows_the_measured_pose_to_its_noise(rolled: Rolled) -> None:
    """2 mm of white noise on each axis, of two measurements 20 ms apart: a Rayleigh distance of 2.8 mm each way."""
    log = rolled.result.log
    error, latency = log.columns["mirror_error"], log.columns["mirror_latency"]
    assert np.nanmax(latency) == pytest.approx(0.02)
    assert 0.0005 < np.nanmedian(error) < 0.007


def test_the_log_holds_what_was_measured_and_the_truth_is_in_a_file_of_its_own(rolled: Rolled) -> None:
    """Sigma of the default unit: 14 mm/s of white noise of the speed in 150 samples, known to 6 %."""
    log, truth = rolled.result.log, rolled.truth
    assert truth.meta["stage"] == "truth"
    missed = {n: (log.columns[n] - np.interp(log.t, truth.t, truth.columns[n]))[3:] for n in ("v", "x", "ax")}
    assert np.std(missed["v"]) == pytest.approx(0.014, rel=0.25)
    assert 1e-4 < np.abs(missed["x"]).mean() < 0.06
    assert np.std(missed["ax"]) == pytest.approx(0.03, rel=0.3)
    if rolled.stage == "rw":
        assert 1e-4 < np.abs(log.objects["Target"].x - truth.objects["Target"].x[0]).mean() < 0.09
    else:  # the simulator's own road users: it knows where they are, and the car does not
        assert not truth.objects


@pytest.mark.nightly
def test_a_car_that_dies_is_an_error_with_its_log_so_far(scenario: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    cars: list[process.CarProcess] = []
    start = process.surrogate

    def started(*arguments: object, **options: object) -> process.CarProcess:
        cars.append(start(*arguments, **options))  # type: ignore[arg-type]
        return cars[-1]

    monkeypatch.setattr(process, "surrogate", started)

    def kill(observation: Observation) -> Command:
        if observation.t >= 0.5:
            os.kill(cars[0].process.pid, signal.SIGKILL)
        return coast(observation)

    result = drive(scenario(), "rw", ads=OneTrick(kill))
    assert result.status == "ERROR"
    assert result.error == "the car's process ended (killed by SIGKILL)"
    assert result.log.duration == pytest.approx(0.5, abs=0.06)
    assert cars[0].process.returncode == -signal.SIGKILL
    assert drive(scenario(), "rw", ads=OneTrick(coast)).error is None  # the next one is untouched


def test_a_command_beyond_the_gate_is_clamped_and_logged(scenario: Write) -> None:
    """0.4 rad/s of the road wheel are 0.008 rad from one decision of the gate to the next, 20 ms later."""

    def jerk(observation: Observation) -> Command:
        return Command(t=observation.t, steer=0.3, accel=0.0, throttle=0.0, brake=0.0)

    log = drive(scenario(), "rw", ads=OneTrick(jerk)).log
    findings = [event for event in log.events if event.kind == "gate"]
    assert findings[0].element == "clamped"
    assert np.nanmax(log.columns["steer_cmd"]) == pytest.approx(0.3)
    assert np.nanmax(np.diff(log.columns["gate.steer_cmd"])) == pytest.approx(0.4 * 0.02)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"require_real": True}, r"^rw-surrogate ERROR: a real vehicle is required"),
        ({"vehicle": "surogate"}, r"^unknown vehicle 'surogate', did you mean 'surrogate'\?"),
        ({"vehicle": "surrogate:no.toml"}, r"no file no\.toml$"),
        ({"S": {"EGO_mass": 900.0}}, r"^S\.EGO_mass changes the twin"),
        ({"truth": "truth.csv"}, r"^--truth truth\.csv: the file of what was true is an MCAP file"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_starts(
    scenario: Write, options: dict[str, object], says: str
) -> None:
    with pytest.raises(StageError, match=says):
        drive(scenario(), "rw", **options)


@pytest.mark.parametrize("rolled", ["rw"], indirect=True)
def test_what_is_hidden_in_the_cars_perception_is_in_what_the_stack_gets(
    rolled: Rolled, scenario: Write, tmp_path: Path
) -> None:
    """A detector that shows everything 1 m too far ahead: the LiDAR meets the target's rear 1 m later."""
    stack = OneTrick(coast)
    (tmp_path / "car.toml").write_text("[hidden.detection_offset]\nx = 1.0\n")
    result = drive(scenario(*WITH_TARGET), "rw", ads=stack, vehicle=f"surrogate:{tmp_path / 'car.toml'}")
    assert result.error is None
    nothing_hidden, hidden = (float(scans_of(seen)[-1].points[:, 0].min()) for seen in (rolled.seen, stack.seen))
    assert hidden - nothing_hidden == pytest.approx(1.0, abs=0.1)


def scans_of(seen: list[Observation]) -> list[LidarScan]:
    return [observation.lidar for observation in seen if observation.lidar is not None]
