"""Faults on the wire to the surrogate: named, never a PASS, and over with their run."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds")

from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from pytest_dvp.drive.stages import StageError
from pytest_dvp.drive.wire_log import wire_verdict
from pytest_dvp.logs.log_contents import LogEvent
from tests.unit.harness.conftest import OneTrick, coast
from tests.unit.harness.test_loop import WITH_TARGET

Write = Callable[..., Path]
PASSING = "[[gate]]\nmetric = 'collision'\nmax = 0\n"


def drive(path: Path, fault: str | None = None, **options: object) -> RunResult:
    gates = path.with_name("gates.toml")
    gates.write_text(PASSING)
    options.setdefault("duration", 2.5)
    return run(path, stage="rw", gates=gates, ads=OneTrick(coast), fault=fault, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("fault", "name", "topic"),
    [
        ("silence@1+5", "silent", "/vehicle/odom"),
        ("nan:/vehicle/odom@1.5+1", "not_finite", "/vehicle/odom"),
        ("no_commands@1+1", "not_obeyed", "/vehicle/command"),
    ],
)
@pytest.mark.nightly(by_day=3)
def test_a_fault_is_named_and_its_run_does_not_pass(scenario: Write, fault: str, name: str, topic: str) -> None:
    path = scenario(*WITH_TARGET)
    result = drive(path, fault)
    events = [event for event in result.log.events if event.kind == "wire"]
    assert (name, topic) in {(event.text.split(" ")[0], event.element) for event in events}
    assert events[0].t >= 1.0
    assert result.status == "INCONCLUSIVE"
    assert result.error is None


@pytest.mark.nightly
def test_the_same_fault_gives_the_same_bytes_and_leaves_the_next_run_alone(scenario: Write, tmp_path: Path) -> None:
    path = scenario(*WITH_TARGET)
    logs = []
    for fault in (None, "drop@0.4+1", "drop@0.4+1", None):
        result = drive(path, fault, duration=0.8, log_dir=tmp_path / "runs")
        assert result.folder is not None
        logs.append((result.folder / "log.mcap").read_bytes())
    assert logs[0] == logs[3]
    assert logs[1] == logs[2]
    assert logs[0] != logs[1]


@pytest.mark.nightly
def test_a_stopped_car_is_an_error_at_once(scenario: Write) -> None:
    result = drive(scenario(), "stopped@1")
    assert (result.status, result.error) == ("ERROR", "the car's process is stopped (SIGSTOP)")
    assert result.log.duration == pytest.approx(0.95, abs=0.06)


@pytest.mark.nightly
def test_a_log_with_troubles_never_passes(scenario: Write) -> None:
    log = drive(scenario()).log
    assert wire_verdict(log) is None
    troubled = dataclasses.replace(log, events=[*log.events, LogEvent(1.0, "wire", "/gnss/fix", "lost 2 messages")])
    verdict = wire_verdict(troubled)
    assert verdict is not None
    assert (verdict.status, verdict.short) == (
        "INCONCLUSIVE", "faults on the wire: lost on /gnss/fix; first at t=1.00 s",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"fault": "dropp"}, r"^fault 'dropp': expected NAME@FROM\+LENGTH \[s\], NAME one of drop, delay"),
        ({"fault": "drop:/gnss/fxi"}, r"no topic /gnss/fxi; there is /vehicle/odom"),
        ({"dbc": Path("car.dbc")}, r"^--dbc car\.dbc is for a vehicle on CAN: --vehicle can; found surrogate$"),
        ({"vehicle": "can", "dbc": Path("no.dbc")}, r"no\.toml: no signal map for no\.dbc"),
    ],
)
def test_what_does_not_exist_is_one_line(scenario: Write, options: dict[str, object], says: str) -> None:
    with pytest.raises(StageError, match=says):
        run(scenario(), stage="rw", **options)  # type: ignore[arg-type]
