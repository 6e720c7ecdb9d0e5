"""Drives held against each other: which are compared, what is said of the others, and what a session shares."""

from __future__ import annotations

import dataclasses
import multiprocessing
from collections.abc import Callable
from pathlib import Path

import pytest

import scenarios
from pytest_dvp.cli.command_line import main
from pytest_dvp.cli.run import across_text
from pytest_dvp.drive.result import RunResult
from pytest_dvp.drive.run import run
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.drive.stage_comparison import (
    Files,
    StageDrive,
    compare_stages,
    gates_between,
    pair_name,
    pairs_driven,
    replay,
)
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.plugin.shared_runs import SharedRuns, key_of
from pytest_dvp.verdicts.diagnose_command import gap_command
from pytest_dvp.verdicts.judging import Gate, GateError, Stage
from pytest_dvp.verdicts.result_text import failure
from tests.plugin.conftest import write_scenario
from tests.unit.harness.conftest import OneTrick, coast
from vehicle.adapter import VehicleLost

Write = Callable[..., Path]
ABOUT = {"scenario": "s.xosc", "line": 1, "seed": 7, "replay": "dvp run s.xosc --stage dt,rw"}
LIKE = Gate("mncc", min=0.9, between=("dt", "rw"), options={"signal": "v"})
PAIR: tuple[Stage, Stage] = ("dt", "rw")


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    """A second of coasting."""
    path = write_scenario(tmp_path_factory.mktemp("drive"))
    return run(path, duration=1.0, ads=OneTrick(coast), log_dir=path.parent / "runs")


def staged(log: Log, stage: str, **meta: object) -> StageDrive:
    return StageDrive(dataclasses.replace(log, meta={**log.meta, "stage": stage, **meta}))


def test_two_drives_are_judged_and_tabled(drive: RunResult, tmp_path: Path) -> None:
    drives = {"dt": staged(drive.log, "dt"), "rw": staged(drive.log, "rw-surrogate")}
    held = compare_stages(drives, [LIKE], [PAIR], ABOUT, files=Files(tmp_path))
    assert (held.stage, held.status) == ("dt-rw-surrogate", "PASS")
    assert held.table is not None
    assert held.table.stages == ("dt", "rw-surrogate")
    assert held.folder == tmp_path / "0001-s-dt-rw-surrogate"
    assert {file.name for file in held.folder.iterdir()} == {"result.json", "report.html"}
    assert held.as_dict()["metrics"]["rw-surrogate.mncc(v).lag"] == 0.0


def test_the_folder_of_a_comparison_has_no_log_and_says_where_they_are(drive: RunResult, tmp_path: Path) -> None:
    here = {stage: dataclasses.replace(staged(drive.log, stage), place=Path(f"runs/{stage}")) for stage in ("dt", "rw")}
    folder = compare_stages(here, [LIKE], [PAIR], ABOUT, files=Files(tmp_path)).folder
    assert folder is not None
    with pytest.raises(LogError, match=r"holds stages against each other, their logs are in runs/dt, runs/rw$"):
        Log.load(folder)
    assert main(["report", str(folder)]) == 2


def test_a_missing_drive_is_inconclusive_and_says_how_to_get_it(drive: RunResult) -> None:
    held = compare_stages({"dt": staged(drive.log, "dt")}, [LIKE], [PAIR], ABOUT, missing={"rw": "drive it with -m rw"})
    assert (held.status, held.table) == ("INCONCLUSIVE", None)
    assert held.verdicts[0].short == "mncc(v) INCONCLUSIVE: drive it with -m rw"


def test_without_a_gate_between_them_nothing_passes(drive: RunResult) -> None:
    drives = {"dt": staged(drive.log, "dt"), "rw": staged(drive.log, "rw")}
    assert compare_stages(drives, [], [PAIR], ABOUT).status == "INCONCLUSIVE"
    assert compare_stages(drives, [], [], ABOUT).status == "INCONCLUSIVE"


def test_an_earlier_drive_of_another_version_of_the_scenario_is_not_compared(drive: RunResult) -> None:
    old = dataclasses.replace(staged(drive.log, "rw", scenario_sha256="0" * 64), place=Path("runs/0001"), before=True)
    held = compare_stages({"dt": staged(drive.log, "dt"), "rw": old}, [LIKE], [PAIR], ABOUT)
    assert held.status == "INCONCLUSIVE"
    assert "runs/0001 was driven with another version of the scenario" in held.verdicts[0].short


@pytest.mark.parametrize(
    ("spoilt", "says"),
    [
        (
            {"events": (LogEvent(0.5, "fault", "VehicleLost", "the car is gone"),)},
            "broke off at t=0.50 s: the car is gone",
        ),
        ({"events": (LogEvent(0.5, "wire", "/gnss/fix", "lost 3 messages"),)}, "faults on the wire: lost on /gnss/fix"),
        ({"meta": {"stage": "rw", "vehicle": {"armed": False}}}, "was a dry run: no command reached the car"),
    ],
)
def test_a_log_that_is_no_evidence_is_not_compared(drive: RunResult, spoilt: dict[str, object], says: str) -> None:
    meta = {**drive.log.meta, "stage": "rw", **spoilt.get("meta", {})}  # type: ignore[dict-item]
    log = dataclasses.replace(drive.log, **{**spoilt, "meta": meta})  # type: ignore[arg-type]
    held = compare_stages({"dt": staged(drive.log, "dt"), "rw": StageDrive(log)}, [LIKE], [PAIR], ABOUT)
    assert held.status == "INCONCLUSIVE"
    assert says in held.verdicts[0].short


def test_other_parameters_of_the_stack_are_said(drive: RunResult) -> None:
    other = staged(drive.log, "rw", P={**drive.log.meta["P"], "LQR_q11": 99.0})
    held = compare_stages({"dt": staged(drive.log, "dt"), "rw": other}, [LIKE], [PAIR], ABOUT)
    assert held.notes == (f"dt and rw differ in P: LQR_q11 {drive.log.meta['P']['LQR_q11']} and 99.0",)


def test_stages_are_named_once_each_and_the_surrogate_once() -> None:
    assert pair_name(["dt", "pe-surrogate", "rw-surrogate"]) == "dt-pe-rw-surrogate"
    assert pair_name(["dt", "rw"]) == "dt-rw"


def test_only_pairs_that_were_driven_are_compared() -> None:
    gates = [LIKE, Gate("mncc", min=0.9, between=("pe", "rw"), options={"signal": "v"}), LIKE]
    assert pairs_driven(gates, ["dt", "rw"]) == [("dt", "rw")]
    assert pairs_driven(gates, ["dt", "pe"]) == [("dt", "rw"), ("pe", "rw")]  # none: then each is INCONCLUSIVE


def test_gates_that_none_of_the_logs_can_answer_are_inconclusive_and_say_which_stage_is_missing(
    drive: RunResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = []
    for stage in ("dt", "rw-surrogate"):
        staged(drive.log, stage).log.save(tmp_path / f"{stage}.mcap")
        logs.append(str(tmp_path / f"{stage}.mcap"))
    gates = tmp_path / "stages.toml"
    elsewhere = '[[gate]]\nmetric = "max_jerk"\nbetween = ["dt", "pe"]\nmax_difference = 1\n'
    gates.write_text(elsewhere)
    assert main(["stages", *logs, "--gates", str(gates)]) == 1
    said = capsys.readouterr().out
    assert "max_jerk difference INCONCLUSIVE: none of the logs is of stage pe" in said
    gates.write_text(elsewhere + elsewhere.replace("pe", "rw"))
    assert main(["stages", *logs, "--gates", str(gates)]) == 0
    said = capsys.readouterr().out
    assert "!! not judged: 1 gate between dt and pe (no drive of stage pe)" in said
    gates.write_text('[[gate]]\nmetric = "tet"\nmax = 1\n')
    assert main(["stages", *logs, "--gates", str(gates)]) == 1
    assert "no gate is between stages" in capsys.readouterr().err


def test_gates_between_stages_come_from_beside_the_scenario_and_from_the_session(scenario: Write) -> None:
    path = scenario()
    text = '[[gate]]\nmetric = "{}"\nbetween = ["dt", "rw"]\nmax_difference = 1\n'
    path.with_name(f"{path.stem}.gates.toml").write_text(text.format("tet"))
    more = path.with_name("more.toml")
    more.write_text(text.format("max_jerk"))
    assert [gate.metric for gate in gates_between(path, None, more)] == ["tet", "max_jerk"]
    more.write_text('[[gate]]\nmetric = "tet"\nmax = 1\n')
    with pytest.raises(GateError, match="no gate is between stages"):
        gates_between(path, None, more)


class Drives:
    """Counts how often it drives."""

    def __init__(self, result: RunResult) -> None:
        self.result, self.count = result, 0

    def __call__(self) -> RunResult:
        self.count += 1
        return self.result


def test_who_needs_a_run_first_drives_it_and_the_others_read_its_log(drive: RunResult, tmp_path: Path) -> None:
    runs, drives = SharedRuns(tmp_path / "session"), Drives(drive)
    first = runs.shared("a", drives)
    second = SharedRuns(tmp_path / "session").shared("a", drives)
    assert drives.count == 1
    assert first is not None
    assert second is not None
    assert second.as_dict() == first.as_dict()
    assert (second.log.columns["v"] == first.log.columns["v"]).all()


def test_a_test_of_a_run_takes_what_another_had_to_drive_once_and_drives_when_it_is_repeated(
    drive: RunResult, tmp_path: Path
) -> None:
    runs, drives = SharedRuns(tmp_path / "session"), Drives(drive)
    runs.shared("a", drives)
    runs.own("a", drives)
    assert drives.count == 1
    runs.own("a", drives)
    assert drives.count == 2


def test_what_must_not_be_driven_is_only_read(drive: RunResult, tmp_path: Path) -> None:
    runs, drives = SharedRuns(tmp_path / "session"), Drives(drive)
    assert runs.shared("a", None) is None
    runs.own("a", drives)
    assert runs.shared("a", None) is not None


def test_a_run_that_could_not_be_made_is_made_by_the_next(drive: RunResult, tmp_path: Path) -> None:
    runs = SharedRuns(tmp_path / "session")

    def broken() -> RunResult:
        raise ValueError("no car")

    with pytest.raises(ValueError, match="no car"):
        runs.shared("a", broken)
    assert runs.shared("a", Drives(drive)) is not None


def _die(folder: Path) -> None:
    import os

    def crash() -> RunResult:
        os._exit(1)

    SharedRuns(folder).shared("a", crash)


def test_a_worker_that_dies_while_it_drives_holds_nobody_up(drive: RunResult, tmp_path: Path) -> None:
    worker = multiprocessing.get_context("fork").Process(target=_die, args=(tmp_path / "session",))
    worker.start()
    worker.join()
    assert SharedRuns(tmp_path / "session").shared("a", Drives(drive)) is not None


def test_the_name_of_a_run_is_all_that_it_depends_on() -> None:
    assert key_of("a", 7, None) == key_of("a", 7, None)
    assert key_of("a", 7, None) != key_of("a", 8, None)


@pytest.fixture
def parked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who drives all the same fails."""

    def drives(*_: object, **__: object) -> None:
        raise AssertionError("it drove")

    monkeypatch.setattr("pytest_dvp.drive.run.run", drives)


@pytest.mark.usefixtures("parked")
def test_dvp_run_tells_of_a_wrong_gate_file_before_it_drives(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = tmp_path / "stages.toml"
    wrong.write_text('[[gate]]\nmetric = "mnc"\nsignal = "v"\nbetween = ["dt", "rw"]\nmin = 0.9\n')
    assert main(["run", str(scenarios.path("overtaking.xosc")), "--stage", "all", "--stage-gates", str(wrong)]) == 1
    assert f"{wrong}:2: error dvp.gates.unknown_metric" in capsys.readouterr().err


@pytest.mark.usefixtures("parked")
@pytest.mark.parametrize("vehicle", ["surrogate", "can"])
def test_dvp_run_tells_of_a_wrong_hidden_file_before_it_drives(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], vehicle: str
) -> None:
    wrong = tmp_path / "car.toml"
    wrong.write_text("[hidden.steer_delay]\nT = -1\n")
    scenario = str(scenarios.path("overtaking.xosc"))
    assert main(["run", scenario, "--stage", "all", "--vehicle", f"{vehicle}:{wrong}"]) == 2
    said = f"--stage pe: {wrong}:1: steer_delay.T = -1 is out of range, allowed is 0 to 1 s"
    assert capsys.readouterr().err.strip().splitlines() == [said]


def test_a_stage_that_did_not_begin_is_missing_for_its_own_reason(
    scenario: Write, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_car(*_: object, **__: object) -> None:
        raise VehicleLost("the car is gone")

    monkeypatch.setattr("pytest_dvp.drive.preparation._car", no_car)
    path = scenario()
    gates = path.with_name(f"{path.stem}.gates.toml")
    gates.write_text('[[gate]]\nmetric = "tet"\nbetween = ["dt", "rw"]\nmax_difference = 1\n')
    assert main(["run", str(path), "--stage", "dt,rw", "--duration", "1", "--no-report"]) == 1
    assert "INCONCLUSIVE: the drive of stage rw did not begin: the car is gone" in capsys.readouterr().out


def test_a_drive_of_another_scenario_is_named_and_its_reason_told_once(drive: RunResult) -> None:
    other = dataclasses.replace(
        staged(drive.log, "rw", scenario="town.xosc", scenario_sha256="0" * 64), place=Path("runs/0001")
    )
    drives = {"dt": dataclasses.replace(staged(drive.log, "dt"), place=Path("runs/0000")), "rw": other}
    held = compare_stages(drives, [LIKE] * 4, [PAIR], ABOUT)
    why = f"runs/0001 is a drive of town.xosc, runs/0000 one of {drive.log.meta['scenario']}"
    assert [verdict.reason for verdict in held.verdicts] == [why] * 4
    said = across_text(held).splitlines()
    told = f"4 gates (mncc(v), mncc(v), mncc(v), ...) INCONCLUSIVE: {why}"
    assert said[1] == f"  INCONCLUSIVE {told}"
    assert sum(why in line for line in said) == 1
    message = failure(held.as_dict())
    assert message is not None
    assert message.count("another version") == 0
    assert f"  INCONCLUSIVE {told}\n  0 of 4 gates passed" in message
    two = across_text(compare_stages(drives, [LIKE] * 2, [PAIR], ABOUT)).splitlines()
    assert two[1] == f"  INCONCLUSIVE mncc(v), mncc(v) INCONCLUSIVE: {why}"


def saved(drive: StageDrive, place: Path, **meta: object) -> str:
    dataclasses.replace(drive.log, meta={**drive.log.meta, **meta}).save(place)
    return str(place)


def test_logs_of_two_scenarios_are_compared_scenario_by_scenario(
    drive: RunResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = []
    for scenario in ("town.xosc", "hill.xosc"):
        for stage in ("dt", "rw-surrogate"):
            logs.append(saved(staged(drive.log, stage), tmp_path / f"{scenario}{stage}.mcap", scenario=scenario))
    gates = tmp_path / "stages.toml"
    gates.write_text('[[gate]]\nmetric = "mncc"\nsignal = "v"\nbetween = ["dt", "rw"]\nmin = 0.9\n')
    assert main(["stages", *logs, "--gates", str(gates)]) == 0
    said = capsys.readouterr()
    assert [line for line in said.out.splitlines() if line.endswith("PASS")] == [
        "town.xosc [dt-rw-surrogate]: PASS",
        "hill.xosc [dt-rw-surrogate]: PASS",
    ]
    assert main(["stages", *logs[:3]]) == 0
    said = capsys.readouterr()
    assert said.err == f"dvp stages: {logs[2]} left out: no other stage of hill.xosc is among the logs\n"
    assert main(["stages", *logs, "--out", str(tmp_path / "page.html")]) == 2


def test_the_iteration_before_is_compared_with_the_first_stage_in_whatever_order_the_logs_are_named(
    drive: RunResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    dt, rw = (saved(staged(drive.log, stage), tmp_path / f"{stage}.mcap") for stage in ("dt", "rw-surrogate"))
    for logs in ((dt, rw), (rw, dt)):
        assert main(["stages", *logs, "--before", dt]) == 0
        head = capsys.readouterr().out.splitlines()[2]
        assert head.split() == ["dt", "to", "dt", "before", "rw-surrogate", "to", "dt"]


@pytest.mark.parametrize("spoilt", ["a log", "before"])
@pytest.mark.parametrize(
    ("events", "meta", "says"),
    [
        ((LogEvent(0.5, "fault", "Stack", "boom"),), {}, "broke off at t=0.50 s: boom"),
        ((), {"scenario": "hill.xosc"}, "is a drive of hill.xosc"),
        ((), {"road_sha256": "0" * 64}, "was driven with another version of the road"),
    ],
)
def test_a_drive_that_is_not_compared_has_no_figure_in_the_table_and_is_told(
    drive: RunResult, events: tuple[LogEvent, ...], meta: dict[str, str], says: str, spoilt: str
) -> None:
    """Without a gate there is no verdict that could say so."""
    good, rw = staged(drive.log, "dt"), staged(drive.log, "rw")
    log = rw.log if spoilt == "a log" else good.log
    bad = StageDrive(dataclasses.replace(log, events=(*log.events, *events), meta={**log.meta, **meta}))
    drives, before = ({"dt": good, "rw": bad}, good) if spoilt == "a log" else ({"dt": good, "rw": rw}, bad)
    held = compare_stages(drives, [], [], ABOUT, before=before)
    assert held.table is not None
    assert held.table.against == (("dt before",) if spoilt == "a log" else ("", "dt"))
    (note,) = [note for note in held.notes if note.startswith("not compared: ")]
    assert says in note


def test_a_gate_between_stages_that_is_bounded_on_the_harmless_side_is_told(drive: RunResult) -> None:
    drives = {"dt": staged(drive.log, "dt"), "rw": staged(drive.log, "rw")}
    slip = Gate("mncc", max=1.0, between=("dt", "rw"), options={"signal": "v"}, file="s.toml", line=1)
    for gates, told in (([slip], 1), ([LIKE], 0), ([slip, LIKE], 0)):
        notes = compare_stages(drives, gates, [PAIR], ABOUT).notes
        assert sum("smaller mncc is worse; max = 1 alone passes worse drives" in note for note in notes) == told


def test_a_gate_that_fails_between_twin_and_car_prints_the_command_that_says_why(
    drive: RunResult, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    never = Gate("twin_error", max=-1.0, between=("dt", "rw"), options={"signal": "v"})
    places = {stage: tmp_path / "runs" / stage for stage in ("dt", "rw")}
    drives = {stage: dataclasses.replace(staged(drive.log, stage), place=place) for stage, place in places.items()}
    shipped = scenarios.path("models/tabby_evo.toml")
    held = compare_stages(drives, [never], [PAIR], ABOUT)
    command = f"dvp diagnose runs/rw --model {shipped} --twin runs/dt"
    assert held.why == (command,)
    assert f"  what the twin lacks: {command}" in across_text(held).splitlines()
    assert f"  what the twin lacks: {command}\n  replay: " in str(failure(held.as_dict()))
    own = tmp_path / "models" / "tabby_evo.toml"
    own.parent.mkdir()
    own.write_bytes(shipped.read_bytes())
    assert compare_stages(drives, [never], [PAIR], ABOUT).why == (
        "dvp diagnose runs/rw --model models/tabby_evo.toml --twin runs/dt",
    )
    assert compare_stages(drives, [LIKE], [PAIR], ABOUT).why == ()
    assert compare_stages({stage: staged(drive.log, stage) for stage in drives}, [never], [PAIR], ABOUT).why == ()


def test_a_model_file_that_is_not_there_any_more_is_named(drive: RunResult) -> None:
    lost = dataclasses.replace(drive.log, meta={**drive.log.meta, "model": {"toml": "", "file": "my.toml"}})
    bad = dataclasses.replace(drive.verdicts[0], status="FAIL")
    command = gap_command([bad], (lost, None), (drive.log, Path("runs/rw")))
    assert command == "dvp diagnose runs/rw --model MODEL.toml (MODEL.toml: my.toml, which is not here)"


def test_a_twin_by_pedals_beside_a_car_by_accelerations_is_said_in_place_of_a_diagnosis(drive: RunResult) -> None:
    """The default twin, the TABBY EVO, is driven by pedals; the surrogate on topics by accelerations."""
    car = {key: value for key, value in drive.log.meta.items() if key != "model"}
    log = dataclasses.replace(drive.log, meta={**car, "stage": "rw-surrogate", "vehicle": {"name": "surrogate"}})
    drives = {"dt": staged(drive.log, "dt"), "rw": StageDrive(log, Path("runs/0001"))}
    never = Gate("twin_error", max=-1.0, between=("dt", "rw"), options={"signal": "v"})
    held = compare_stages(drives, [never], [PAIR], ABOUT)
    assert held.why == ()
    (note,) = held.notes
    asked = "tabby_evo.toml is driven by throttle_cmd + brake_cmd, the car by accel_cmd; take --model "
    assert note.startswith(f"dt and rw-surrogate differ in what asks the car: {asked}")
    assert note.endswith("models/surrogate.toml")
    assert f"  {note}\n" in str(failure(held.as_dict()))


def test_the_command_to_see_a_comparison_again_says_all_that_was_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    given = RunSpec(
        rootdir=tmp_path,
        ads=f"{tmp_path}/mine.py:Stack",
        vehicle="can",
        dbc=tmp_path / "car.dbc",
        fault="drop@5",
        model=tmp_path / "twin.toml",
    )
    words = "dvp run s.xosc --stage dt,rw --seed 7 --vehicle can --fault drop@5 --ads mine.py:Stack --dbc car.dbc"
    assert replay(tmp_path / "s.xosc", {}, ("dt", "rw"), given) == f"{words} --model twin.toml"
