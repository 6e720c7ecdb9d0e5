"""What a stack does that no gate judges: commands beyond the car, and ticks that take longer than the cycle."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest

import scenarios
from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.run import run
from pytest_dvp.drive.tick_time import tick_time
from pytest_dvp.logs.log import Log
from pytest_dvp.metrics import compute
from tests.unit.harness.conftest import OneTrick, coast
from vehicle.messages import Command, Observation

Write = Callable[..., Path]

WILD = """
from vehicle.messages import Command

class Wild:
    def tick(self, o):
        if o.t < 0.99:
            return Command(o.t, 0.0, 0.0, 0.0, 0.0)
        return Command(o.t, steer=99 if o.t < 2.0 else -120, accel=1e9, throttle=5, brake=-3)
"""
GATES = '[[gate]]\nmetric = "tick_time"\nmax = 0.01\n[[gate]]\nmetric = "tick_time"\nstatistic = "median"\nmax = 0.01\n'


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    (tmp_path / "wild.py").write_text(WILD)
    monkeypatch.chdir(tmp_path)


def test_what_is_asked_beyond_the_car_is_found_with_field_and_time(
    scenario: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario()
    main(["run", "x.xosc", "--ads", "wild.py:Wild", "--stack-process", "off"])
    told = json.loads(next(Path("runs").glob("*/result.json")).read_text())
    found = {finding["field"]: finding for finding in told["findings"]}
    assert {finding["code"] for finding in told["findings"]} == {"dvp.command_out_of_range"}
    assert {name: (f["t"], f["found"], f["worst"]) for name, f in found.items()} == {
        "steer": (1.0, 99.0, -120.0),
        "accel": (1.0, 1e9, 1e9),
        "throttle": (1.0, 5.0, 5.0),
        "brake": (1.0, -3.0, -3.0),
    }
    assert {f["count"] for f in found.values()} == {42}  # from 1.0 s to the last tick before the stop at 3.1 s
    assert found["steer"]["allowed"] == "-0.3491 to 0.3491 rad"
    said = "command beyond the car: steer 99 rad at t=1.00 s, allowed -0.3491 to 0.3491 rad, in 42 ticks"
    assert said in capsys.readouterr().err
    assert said in next(Path("runs").glob("*/report.html")).read_text()


@pytest.mark.nightly
def test_it_is_said_in_a_session_with_workers_and_in_junit(scenario: Write, pytester: pytest.Pytester) -> None:
    path = scenario()
    ads = f"--dvp-ads={path.with_name('wild.py')}:Wild"
    pytester.makeini("[pytest]\n")
    ran = pytester.runpytest_subprocess("-n1", "-q", "--junitxml=out.xml", str(path), ads, "--dvp-stack-process=off")
    ran.stdout.fnmatch_lines(["*x.xosc::dt: command beyond the car: steer 99 rad at t=1.00 s*"])
    names = {p.get("name"): p.get("value") for p in ElementTree.parse("out.xml").iter("property")}
    assert str(names["finding.dvp.command_out_of_range.steer"]).startswith("command beyond the car: steer 99 rad")
    assert float(str(names["tick_time.median"])) >= 0.0


def test_a_car_with_pedals_that_is_only_asked_for_an_acceleration_coasts_and_the_run_says_why(scenario: Write) -> None:
    def by_accel(o: Observation) -> Command:
        return Command(o.t, 0.0, 0.0 if o.t < 0.99 else -2.0 if o.t < 2.0 else -3.0, 0.0, 0.0)

    result = run(scenario(), ads=OneTrick(by_accel))
    (found,) = result.findings
    assert (found["code"], found["field"], found["t"]) == ("dvp.command_ignored", "accel", 1.0)
    assert (found["found"], found["worst"]) == (-2.0, -3.0)
    (said,) = [note for note in result.notes if note.startswith("command that the car ignores: ")]
    assert "accel -2 m/s^2 at t=1.00 s" in said
    assert "driven by throttle_cmd + brake_cmd, and the stack never commands that" in said


def test_a_car_driven_by_acceleration_that_is_only_asked_by_pedals_is_told_likewise(
    scenario: Write, tmp_path: Path
) -> None:
    model = tmp_path / "accel.toml"
    text = (Path(scenarios.__file__).parent / "models" / "tabby_evo.toml").read_text()
    lines = [line for line in text.splitlines() if not line.startswith(("full_throttle", "full_brake"))]
    model.write_text("\n".join(lines).replace('"throttle_cmd + brake_cmd"', '"accel_cmd"'))
    pedals = run(scenario(), ads=OneTrick(lambda o: Command(o.t, 0.0, 0.0, 0.5, 0.0)), model=model)
    assert [(found["code"], found["field"]) for found in pedals.findings] == [("dvp.command_ignored", "throttle")]
    accel = run(scenario(), ads=OneTrick(lambda o: Command(o.t, 0.0, 1.0, 0.0, 0.0)), model=model)
    assert accel.findings == ()


@pytest.mark.parametrize("later", [Command(0.0, 0.0, 1.0, 0.3, 0.0), Command(0.0, 0.0, 0.0, 0.0, 0.0)])
def test_a_stack_that_sets_both_or_nothing_is_told_nothing(scenario: Write, later: Command) -> None:
    def both(o: Observation) -> Command:
        first = Command(o.t, 0.0, later.accel, 0.0, 0.0)
        return first if o.t < 1.0 else Command(o.t, 0.0, later.accel, later.throttle, 0.0)

    assert run(scenario(), ads=OneTrick(both)).findings == ()


def test_at_the_limits_of_the_car_nothing_is_found(scenario: Write) -> None:
    def most(o: Observation) -> Command:
        return Command(o.t, 0.3491 * (-1.0 if o.t > 1.0 else 1.0), 3.5 if o.t > 1.0 else -7.0, 1.0 + 1e-12, -1e-12)

    assert run(scenario(), ads=OneTrick(most)).findings == ()


def test_numbers_that_are_finite_one_by_one_are_a_command(scenario: Write) -> None:
    """Their sum is not: nothing may be concluded from it."""
    result = run(scenario(), ads=OneTrick(lambda o: Command(o.t, 1.5e308, 1.5e308, 0.0, 0.0)), duration=0.2)
    assert (result.error, {f["field"] for f in result.findings}) == (None, {"steer", "accel"})


def slow(observation: Observation) -> Command:
    time.sleep(0.06)  # longer than the cycle
    return coast(observation)


def test_a_stack_slower_than_its_cycle_is_said_measured_and_judged(scenario: Write) -> None:
    path = scenario()
    Path("limits.toml").write_text(GATES)
    result = run(path, ads=OneTrick(slow), duration=0.5, gates="limits.toml", log_dir=Path("runs"))
    figures = result.as_dict()["tick_time"]
    assert figures["median"] >= 0.06
    assert figures["median"] <= figures["p99"] <= figures["worst"]
    assert (figures["cycle"], figures["exceeded"], figures["ticks"]) == (0.05, 9, 9)
    assert [(v.metric, v.status) for v in result.verdicts] == [("tick_time", "FAIL")] * 2
    assert any(note.startswith("tick time: 9 of 9 ticks took longer than the cycle of 50 ms") for note in result.notes)
    assert result.folder is not None
    # The run folder knows its times, a log alone does not: it has no wall clock.
    assert main(["report", str(result.folder), "--gates", "limits.toml"]) == 1
    assert json.loads((result.folder / "result.json").read_text())["verdicts"][0]["status"] == "FAIL"
    bare = Path("bare.mcap")
    bare.write_bytes((result.folder / "log.mcap").read_bytes())
    assert not compute("tick_time", Log.load(bare)).valid
    assert main(["report", str(bare), "--gates", "limits.toml", "--out", "bare.html"]) == 1
    quick = run(path, ads=OneTrick(coast), duration=0.5)
    quick.log.save("quick.mcap")
    assert Path("quick.mcap").read_bytes() == run_again(path)


def run_again(path: Path) -> bytes:
    run(path, ads=OneTrick(coast), duration=0.5).log.save("again.mcap")
    return Path("again.mcap").read_bytes()


def test_the_figures_are_those_of_all_ticks_but_the_first() -> None:
    figures = tick_time([9.0, *[0.01] * 99, 0.2], 0.05)
    assert figures == {
        "median": 0.01, "p99": 0.01, "worst": 0.2, "cycle": 0.05, "exceeded": 1, "first": 9.0, "ticks": 100,
    }  # fmt: skip
    assert tick_time([0.3], 0.05)["median"] is None


def test_what_numba_compiles_in_a_tick_is_no_time_of_the_stack(scenario: Write) -> None:
    from numba.core import event

    def compiles(observation: Observation) -> Command:
        with event.trigger_event("numba:compiler_lock"):
            time.sleep(0.06)
        return coast(observation)

    result = run(scenario(), ads=OneTrick(compiles), duration=0.3, tick_limit=0.05)
    assert result.error is None
    assert result.tick_time["exceeded"] == 0
