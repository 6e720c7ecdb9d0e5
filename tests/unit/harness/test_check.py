"""dvp check of folders, of gate files beside their scenario, and of what a run needs besides a valid file."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from pytest_dvp import run
from pytest_dvp.cli.command_line import main
from pytest_dvp.cli.shared import runnable_scenarios
from pytest_dvp.cli.shared.checkable_files import files_of
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.logs.formats.log_format import log_formats
from scenarios import path as shipped
from tests.unit.harness.test_event_names import at, group

Write = Callable[..., Path]
GATE = '[[gate]]\nmetric = "collision"\nmax = 0\n'
BROKEN = '[[gate]]\nmetric = "tetx"\nmax = 1\n'
NEEDS_GOAL = '[[gate]]\nmetric = "goal_reached"\nmin = 1\n'


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(tmp_path)


@pytest.fixture(autouse=True)
def asked_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """What runs is asked in this process; test_check_runnable.py asks the process that a check starts for it."""

    def ask(files: Sequence[str], settings: RunSpec) -> dict[str, tuple[str, int | None]]:
        return {file: runnable_scenarios._refusal(Path(file), settings) for file in files}

    monkeypatch.setattr(runnable_scenarios, "_ask", ask)


@pytest.fixture
def check(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, list[dict[str, Any]]]]:
    def run(*words: str) -> tuple[int, list[dict[str, Any]]]:
        code = main(["check", *words, "--json"])
        return code, json.loads(capsys.readouterr().out)["findings"]

    return run


def test_a_scenario_is_checked_with_its_gate_file(scenario: Write, check: Callable[..., Any]) -> None:
    scenario().with_name("x.gates.toml").write_text(BROKEN)
    code, (found,) = check("x.xosc")
    assert (code, found["file"], found["line"]) == (1, "x.gates.toml", 2)
    assert check("x.xosc", "x.gates.toml") == (code, [found])  # once, though named as well


def test_what_has_no_place_in_its_file_leaves_no_gap(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "empty.xosc").write_text("")
    main(["check", "empty.xosc"])
    assert capsys.readouterr().out == "empty.xosc:1: error xml.empty: the file is empty\n"


@pytest.mark.parametrize("ending", [".dat", ".txt", ".mat", ".tsv", ".mf4"])
def test_a_named_file_with_the_ending_of_a_log_is_read_as_one(
    tmp_path: Path, check: Callable[..., Any], ending: str
) -> None:
    (tmp_path / f"drive{ending}").write_text("nothing of the kind")
    code, found = check(f"drive{ending}")
    assert code == 1
    assert {each["code"].partition(".")[0] for each in found} == {"log"}  # and not that it is no XML


def test_a_folder_holds_the_logs_of_every_format_and_no_others(tmp_path: Path) -> None:
    endings = [ending for one in log_formats() for ending in one.endings]
    for ending in endings:
        (tmp_path / f"a{ending}").write_text("t [s],v [m/s]\n")
        (tmp_path / f"b{ending}").write_text("Ada,Lovelace\n")
    common = {ending for one in log_formats() for ending in one.common}
    assert {".csv", ".txt", ".dat", ".mat"} <= common
    found = {path.name for path in files_of(tmp_path)}
    assert found == {f"a{ending}" for ending in endings} | {f"b{ending}" for ending in endings if ending not in common}


def test_allowed_roads_are_listed_as_one_counts(scenario: Write, check: Callable[..., Any]) -> None:
    path = scenario(('roadId="1"', 'roadId="99"'))
    road = path.with_name("straight.xodr")
    text = road.read_text()
    one = text[text.index("  <road ") : text.index("</OpenDRIVE>")]
    many = "".join(one.replace('id="1" junction', f'id="{number}" junction') for number in ("11", "2", "1"))
    road.write_text(text.replace(one, many))
    assert "allowed: 1, 2, 11" in check("x.xosc")[1][0]["message"]


def test_folders_of_others_are_not_looked_at(scenario: Write, check: Callable[..., Any]) -> None:
    for folder in (".hidden", "node_modules", "runs/0001-x-dt", ".venv/lib"):
        place = scenario().parent / folder
        place.mkdir(parents=True)
        (place / "x.gates.toml").write_text(BROKEN)
    assert check(".") == (0, [])


def test_a_virtual_environment_of_any_name_is_not_looked_at(scenario: Write, check: Callable[..., Any]) -> None:
    place = scenario().parent / "env"
    place.mkdir()
    (place / "pyvenv.cfg").write_text("")
    (place / "x.gates.toml").write_text(BROKEN)
    assert check(".") == (0, [])


def test_other_toml_files_are_none_of_ours(scenario: Write, check: Callable[..., Any]) -> None:
    folder = scenario().parent
    (folder / "pyproject.toml").write_text("[model]\n[[gate]]\n")
    (folder / "tool.toml").write_text('[tool]\nname = "x"\n')
    assert check(".") == (0, [])


def test_a_toml_file_with_a_model_table_is_a_vehicle_model(scenario: Write, check: Callable[..., Any]) -> None:
    (scenario().parent / "car.toml").write_text('[model]\nbase = "hovercraft"\n')
    code, found = check(".")
    assert code == 1
    assert Path(found[0]["file"]).name == "car.toml"


@pytest.mark.parametrize("content", [None, "notes.txt"])
def test_a_folder_with_nothing_to_check_is_a_usage_error(
    content: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "wrong").mkdir()
    if content:
        (tmp_path / "wrong" / content).write_text("hello")
    assert main(["check", "wrong"]) == 2
    assert capsys.readouterr().err.startswith("wrong: nothing to check here")


def test_a_gate_file_that_a_run_would_not_find_is_an_error(scenario: Write, check: Callable[..., Any]) -> None:
    scenario().with_name("x.gate.toml").write_text(GATE)
    code, found = check(".")
    assert (code, [f["code"] for f in found]) == (1, ["dvp.gates.name"])
    assert "did you mean x.gates.toml?" in found[0]["message"]


@pytest.mark.parametrize("right", [True, False])
def test_a_gate_file_of_a_wrong_name_is_a_warning_where_no_scenario_loses_its_gates(
    right: bool, scenario: Write, check: Callable[..., Any]
) -> None:
    """The scenario x.xosc has its file of gates, or the wrong name is that of no scenario at all."""
    path = scenario()
    path.with_name("x.gates.toml").write_text(GATE)
    path.with_name("x.gate.toml" if right else "y.gate.toml").write_text(GATE)
    code, found = check(".")
    assert (code, [(f["code"], f["severity"]) for f in found]) == (0, [("dvp.gates.name", "warning")])


def test_a_gate_file_without_its_scenario_is_a_warning_with_the_nearest_one(
    scenario: Write, check: Callable[..., Any]
) -> None:
    scenario(name="overtaking.xosc").with_name("overtakin.gates.toml").write_text(GATE)
    code, found = check(".")
    assert (code, [(f["code"], f["severity"]) for f in found]) == (0, [("dvp.gates.orphan", "warning")])
    assert "did you mean 'overtaking.xosc'?" in found[0]["message"]


@pytest.mark.parametrize(
    ("goal", "element", "said"),
    [
        ('{ road = "29", lane = -1, s = 10 }', "task.goal.road", "no road 29 in x.xosc; allowed: 1"),
        ('{ road = "1", lane = -7, s = 10 }', "task.goal.lane", "no lane -7 on road 1 at s = 10 m"),
        ('{ road = "1", lane = -1, s = 99999 }', "task.goal.s", "beyond the end of the road"),
    ],
)
def test_a_goal_off_the_road_is_found_at_its_line(
    goal: str, element: str, said: str, scenario: Write, check: Callable[..., Any]
) -> None:
    scenario().with_name("x.gates.toml").write_text(f"[task]\n# where to\ngoal = {goal}\n{GATE}")
    code, (found,) = check(".")
    assert (code, found["line"], found["element"]) == (1, 3, element)
    assert said in found["message"]


def test_a_gate_on_reaching_a_goal_that_nobody_names_is_a_warning_because_the_run_starts(
    scenario: Write, check: Callable[..., Any]
) -> None:
    path = scenario()
    path.with_name("x.gates.toml").write_text(GATE + NEEDS_GOAL)
    for named in (".", "x.xosc"):
        code, (found,) = check(named)
        assert (code, found["severity"], found["line"]) == (0, "warning", 4)
        assert found["code"] == "dvp.gates.no_goal"
    verdicts = {verdict.metric: verdict.status for verdict in run(path, duration=0.1).verdicts}
    assert verdicts["goal_reached"] == "INCONCLUSIVE"  # as the warning says
    assert 'goal = { road = "1", lane = -1, s = 500.0 }' in found["message"]  # a place of that road: its middle


def test_a_gate_on_reaching_the_goal_of_the_task_is_fine(scenario: Write, check: Callable[..., Any]) -> None:
    task = '[task]\ngoal = { road = "1", lane = -1, s = 50 }\n'
    scenario().with_name("x.gates.toml").write_text(task + NEEDS_GOAL)
    assert check(".") == (0, [])


def storyboard_with(event: str) -> tuple[str, str]:
    """Replacement that gives the small scenario a story with one event."""
    story = f"""<Story name="s"><Act name="a">{group("g", event, at(1.0))}<StartTrigger>
      <ConditionGroup><Condition name="c" delay="0" conditionEdge="none">{at(0.0)}</Condition></ConditionGroup>
    </StartTrigger></Act></Story><StopTrigger>"""
    return "<StopTrigger>", story


STARTED = '[[gate]]\nmetric = "event_started"\nmin = 1\nevent = "wlk"\n'
LET_BE = '[[gate]]\nmetric = "events_fired"\nmax = 0\noptional = ["walk", "wlk"]\n'


@pytest.mark.parametrize(("text", "option"), [(STARTED, "event"), (LET_BE, "optional")])
def test_an_event_that_the_scenario_does_not_have_is_found_with_the_nearest_one(
    text: str, option: str, scenario: Write, check: Callable[..., Any], capsys: pytest.CaptureFixture[str]
) -> None:
    gates = scenario(storyboard_with("walk")).with_name("x.gates.toml")
    gates.write_text(text)
    code, (found,) = check("x.xosc")
    place = (1, "dvp.gates.unknown_event", "x.gates.toml", 4, f"gate[1].{option}")
    assert (code, found["code"], found["file"], found["line"], found["element"]) == place
    said = "x.xosc has no storyboard event of this name; found 'wlk'; allowed: walk (did you mean 'walk'?)"
    assert found["message"] == said
    assert main(["run", "x.xosc"]) == 1  # and drives nothing
    assert said in capsys.readouterr().err
    assert not Path("runs").exists()
    gates.write_text(text.replace("wlk", "walk"))
    assert check("x.xosc") == (0, [])


@pytest.mark.parametrize(("name", "severity"), [("Eggo", "error"), ("swarm.3", "warning")])
def test_an_entity_that_the_scenario_does_not_have_is_found(
    name: str, severity: str, scenario: Write, check: Callable[..., Any]
) -> None:
    """What appears only while the scenario runs cannot be told from a wrong name: a warning."""
    text = f'[[gate]]\nmetric = "mncc"\nsignal = "object.{name}.x"\nbetween = ["dt", "rw"]\nmin = 0.9\n'
    scenario().with_name("x.gates.toml").write_text(text)
    _, (found,) = check("x.xosc")
    assert (found["code"], found["severity"], found["line"]) == ("dvp.gates.unknown_entity", severity, 3)
    assert ("did you mean 'Ego'?" in found["message"]) == (severity == "error")


def test_a_file_of_the_traffic_that_is_not_there_is_found(scenario: Write, check: Callable[..., Any]) -> None:
    gates = scenario().with_name("x.gates.toml")
    gates.write_text(f'{GATE}[traffic]\nnet = "twn.net.xml"\nroutes = "town.rou.xml"\n')
    for name in ("town.net.xml", "town.rou.xml"):
        gates.with_name(name).touch()
    code, (found,) = check("x.xosc")
    assert (code, found["code"], found["line"], found["element"]) == (1, "dvp.gates.traffic", 4, "traffic.net")
    assert "did you mean 'town.net.xml'?" in found["message"]


def test_a_scenario_without_an_ego_is_refused_as_a_run_refuses_it(scenario: Write, check: Callable[..., Any]) -> None:
    path = scenario()
    path.write_text(path.read_text().replace('"Ego"', '"Hero"'))
    line = next(i for i, text in enumerate(path.read_text().splitlines(), start=1) if "<Entities>" in text)
    code, (found,) = check(".")
    assert (code, found["severity"], found["line"]) == (1, "error", line)
    assert "call the vehicle under test Ego" in found["message"]
    assert check(".", "--ego", "Hero") == (0, [])


def test_what_is_wrong_in_a_catalogue_is_said_once_with_the_scenarios_that_use_it(
    scenario: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    text = scenario(name="a.xosc").read_text()
    start, end = text.index("<Vehicle "), text.index("</Vehicle>") + len("</Vehicle>")
    folder = Path("catalogs")
    folder.mkdir()
    head = text[: text.index("<ParameterDeclarations>")]
    entry = text[start:end].replace('vehicleCategory="car"', 'vehicleCategory="cart"')
    (folder / "cars.xosc").write_text(f'{head}<Catalog name="cars">\n{entry}</Catalog></OpenSCENARIO>')
    used = text.replace(text[start:end], '<CatalogReference catalogName="cars" entryName="car"/>').replace(
        "<CatalogLocations/>",
        '<CatalogLocations><VehicleCatalog><Directory path="catalogs"/></VehicleCatalog></CatalogLocations>',
    )
    for name in ("a.xosc", "b.xosc"):
        Path(name).write_text(used)
    assert main(["check", "."]) == 1
    said = [line for line in capsys.readouterr().out.splitlines() if "cart" in line]
    assert len(said) == 1
    assert said[0].startswith("catalogs/cars.xosc:")
    assert said[0].endswith("(used by a.xosc, b.xosc)")


STUDY = """[study]
budget = 10

[[scenario]]
file = "x.xosc"

[parameters]
"P.LQR_q11" = [20, 30]
"""
ALIGNMENT = """[study]
objective = "alignment"
model = "models/surrogate.toml"
logs = ["drive.mcap"]

[parameters]
"S.EGO_mass" = { values = [600, 730], start = 600 }
"""


@pytest.mark.parametrize("word", ["study.toml", "."])
def test_a_study_is_read_as_one(word: str, scenario: Write, check: Callable[..., Any]) -> None:
    """Named, and found in a folder; what is wrong in it has its line."""
    file = scenario().with_name("study.toml")
    file.write_text(STUDY)
    assert check(word) == (0, [])
    file.write_text(STUDY.replace("LQR_q11", "LQR_q12").replace("[study]\nbudget = 10\n", ""))
    code, (found,) = check(word)
    assert (code, found["code"], found["line"]) == (1, "study.invalid", 6)
    assert found["message"].startswith("unknown ADS parameter 'LQR_q12'; did you mean")


def test_a_plan_is_read_as_one(tmp_path: Path, check: Callable[..., Any]) -> None:
    plan = shipped("mcrpg/paper.toml").read_text(encoding="utf-8")
    (tmp_path / "plan.toml").write_text(plan)
    assert check("plan.toml") == (0, [])
    (tmp_path / "plan.toml").write_text(plan.replace("budget_P", "budgets_P", 1))
    code, (found,) = check("plan.toml")
    assert (code, found["code"]) == (1, "plan.invalid")
    assert "did you mean 'budget_P'" in found["message"]


def test_what_a_study_names_is_looked_at_too(scenario: Write, check: Callable[..., Any]) -> None:
    """What its run would refuse: a scenario without a road, and a log that is none."""
    file = scenario(('<LogicFile filepath="straight.xodr"/>', "")).with_name("study.toml")
    file.write_text(STUDY)
    code, (found,) = check("study.toml")
    assert (code, found["code"], found["file"]) == (1, "scenario.refused", "x.xosc")
    assert "names no road network" in found["message"]
    file.with_name("drive.mcap").write_bytes(b"none")
    file.write_text(ALIGNMENT)
    code, (found,) = check("study.toml")
    assert (code, found["code"], found["file"]) == (1, "log.not_mcap", "drive.mcap")


def test_what_a_plan_hides_is_looked_at_too(tmp_path: Path, check: Callable[..., Any]) -> None:
    plan = shipped("mcrpg/paper.toml").read_text(encoding="utf-8")
    (tmp_path / "plan.toml").write_text(plan.replace("[iterate]\n", '[iterate]\nvehicle = "surrogate:car.toml"\n', 1))
    (tmp_path / "car.toml").write_text("[hidden.drive_gan]\ng = 0.8\n")
    code, (found,) = check("plan.toml")
    assert (code, found["code"]) == (1, "vehicle.invalid")
    assert "did you mean drive_gain?" in found["message"]


def test_a_parameter_that_the_scenario_of_a_study_lacks_has_its_line(
    scenario: Write, check: Callable[..., Any]
) -> None:
    scenario().with_name("study.toml").write_text(
        STUDY.replace('file = "x.xosc"', 'file = "x.xosc"\nset = { no_such = 1 }')
    )
    code, (found,) = check("study.toml")
    assert (code, found["line"]) == (1, 6)
    assert "no_such: unknown parameter of x.xosc" in found["message"]
