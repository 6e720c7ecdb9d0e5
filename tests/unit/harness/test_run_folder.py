"""`dvp run FOLDER`, a path that leads nowhere, and the ini file of a project, which counts for a run as for pytest."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.ini_file import find_ini
from tests.plugin.conftest import CATALOG

Write = Callable[..., Path]
SHORT = ("--duration", "0.1", "--no-report")
STACK = """
from vehicle.messages import Command

class Stack:
    def tick(self, observation):
        return Command(observation.t, 0.0, 0.0, 0.0, 0.0)
"""
INI = {
    "pytest.ini": "[pytest]\ndvp_ads = stacks/mine.py:Stack\ndvp_seed = 11\n",
    ".pytest.ini": "[pytest]\ndvp_ads = stacks/mine.py:Stack\ndvp_seed = 11\n",
    "tox.ini": "[tox]\n[pytest]\ndvp_ads = stacks/mine.py:Stack\ndvp_seed = 11\n",
    "setup.cfg": "[tool:pytest]\ndvp_ads = stacks/mine.py:Stack\ndvp_seed = 11\n",
    "pyproject.toml": '[tool.pytest.ini_options]\ndvp_ads = "stacks/mine.py:Stack"\ndvp_seed = 11\n',
}


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "project"
    folder.mkdir()
    (folder / "pytest.ini").write_text("[pytest]\n")
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def below(scenario: Write, here: Path) -> Callable[[str], Path]:
    """Puts the small scenario at a path below the project."""

    def write(name: str) -> Path:
        made = scenario()
        path = here / name
        path.parent.mkdir(parents=True, exist_ok=True)
        for file in (made, made.with_name("straight.xodr")):
            (path if file == made else path.with_name(file.name)).write_text(file.read_text())
        return path

    return write


def banners(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return [line for line in capsys.readouterr().err.splitlines() if line.startswith("dvp run: ")]


def test_a_folder_is_all_its_scenarios_in_the_order_of_their_paths(
    below: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """Each once; catalogues, hidden folders and earlier runs are none of them, as for dvp check and pytest."""
    for name in ("all/b.xosc", "all/a.xosc", "all/deep/c.xosc", "all/.hidden/d.xosc", "all/runs/e.xosc", "z.xosc"):
        below(name)
    Path("all/cars.xosc").write_text(CATALOG)
    main(["run", "z.xosc", "all/deep/c.xosc", "all", *SHORT, "--json"])
    out, err = capsys.readouterr()
    order = ["z.xosc", "all/deep/c.xosc", "all/a.xosc", "all/b.xosc"]
    assert [document["scenario"] for document in json.loads(out)] == order
    assert [line.split(",")[0] for line in err.splitlines() if "stage dt" in line] == [f"dvp run: {n}" for n in order]


@pytest.mark.parametrize("name", ["bad.xosc", "sweep.xosc"])
def test_of_a_folder_with_a_broken_file_the_others_run(
    name: str, below: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    below("all/x.xosc")
    distribution = CATALOG.replace("<Catalog ", "<ParameterValueDistribution ")
    Path("all", name).write_text("<OpenSCENARIO" if name == "bad.xosc" else distribution)
    assert main(["run", "all", "--set", "ego_speed=3", *SHORT, "--json"]) == 1
    first, second = json.loads(capsys.readouterr().out)
    assert (first["status"], first["scenario"]) == ("ERROR", f"all/{name}")
    assert (second["set"], second["error"]) == ({"ego_speed": "3"}, None)


def test_a_folder_without_a_scenario_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    Path("empty").mkdir()
    Path("empty", "cars.xosc").write_text(CATALOG)
    assert main(["run", "empty"]) == 2
    assert capsys.readouterr().err == "empty: no scenario in this folder or below it, expected .xosc files\n"


def test_a_real_car_drives_no_folder(below: Callable[[str], Path], capsys: pytest.CaptureFixture[str]) -> None:
    below("all/x.xosc")
    assert main(["run", "all", "--stage", "rw", "--vehicle", "ros2_car:7"]) == 2
    assert "all: a folder is refused: vehicle 'ros2_car:7' is real" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "path", "says"),
    [
        ("run", "all/overtakin.xosc", "no such scenario; looked in {here}/all; did you mean 'all/overtaking.xosc'?"),
        ("run", "al/overtaking.xosc", "no such scenario; no folder {here}/al; did you mean 'all/overtaking.xosc'?"),
        ("run", "al/overtakin.xosc", "no such scenario; no folder {here}/al; did you mean 'all/overtaking.xosc'?"),
        ("run", "overtaking.xosc", "no such scenario; looked in {here}; did you mean 'all/overtaking.xosc'?"),
        ("run", "all/zzz.xosc", "no such scenario; looked in {here}/all"),
        ("run", "al", "no such scenario; looked in {here}; did you mean 'all'?"),
        ("play", "all/overtakin.xosc", "no such scenario; looked in {here}/all; did you mean 'all/overtaking.xosc'?"),
        ("check", "all/overtakin.xosc", "no such file; looked in {here}/all; did you mean 'all/overtaking.xosc'?"),
    ],
)
def test_a_misspelt_path_is_told_with_the_nearest_and_where_it_was_looked_for(
    command: str, path: str, says: str, below: Callable[[str], Path], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    below("all/overtaking.xosc")
    assert main([command, path]) == 2
    assert capsys.readouterr().err == f"{path}: {says.format(here=here)}\n"


def test_a_misspelt_file_of_an_option_is_told_with_the_nearest(
    below: Callable[[str], Path], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    below("x.xosc").with_name("strict.gates.toml").write_text('[[gate]]\nmetric = "collision"\nmax = 0\n')
    assert main(["run", "x.xosc", "--gates", "strct.gates.toml"]) == 2
    assert capsys.readouterr().err.endswith(f"; looked in {here}; did you mean 'strict.gates.toml'?\n")


@pytest.mark.parametrize("name", INI)
@pytest.mark.nightly(by_day=4)
def test_the_ini_file_counts_for_a_run_and_the_banner_says_so(
    name: str, below: Callable[[str], Path], here: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Its paths start at the ini file; the command line stands above it."""
    below("all/x.xosc")
    (here / "stacks").mkdir()
    (here / "stacks" / "mine.py").write_text(STACK)
    (here / "pytest.ini").unlink()
    (here / name).write_text(INI[name])
    monkeypatch.chdir(here / "all")
    ini = here / name
    main(["run", "x.xosc", *SHORT, "--json"])
    out, err = capsys.readouterr()
    result = json.loads(out)
    assert (result["seed"], result["ads"]) == (11, "mine.py:Stack")
    ads = f"ADS {here}/stacks/mine.py:Stack ({ini}: dvp_ads); {ini}: dvp_seed"
    assert err.splitlines()[0] == f"dvp run: x.xosc, stage dt, seed 11, {ads}"
    main(["run", "x.xosc", *SHORT, "--json", "--seed", "12", "--ads", "reference"])
    out, err = capsys.readouterr()
    result = json.loads(out)
    assert (result["seed"], result["ads"]) == (12, "reference")
    assert err.splitlines()[0] == "dvp run: x.xosc, stage dt, seed 12, ADS reference"
    assert result["replay"] == "dvp run x.xosc --seed 12 --duration 0.1 --no-ini"  # or it were the other stack
    main(["run", "x.xosc", *SHORT, "--json", "--no-ini"])
    assert json.loads(capsys.readouterr().out)["seed"] == 7


def test_without_an_ini_file_the_banner_names_the_stack_and_the_environment(
    below: Callable[[str], Path], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    below("x.xosc")
    main(["run", "x.xosc", *SHORT])
    assert banners(capsys) == ["dvp run: x.xosc, stage dt, seed 7, ADS reference"]
    monkeypatch.setenv("DVP_ADS", "reference")
    main(["run", "x.xosc", *SHORT])
    assert banners(capsys) == ["dvp run: x.xosc, stage dt, seed 7, ADS reference (environment DVP_ADS)"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[pytest]\ndvp_sed = 7\n", "unknown setting 'dvp_sed', did you mean 'dvp_seed'?"),
        ("[pytest]\ndvp_seed = x\n", "pytest.ini: dvp_seed is 'x', expected a whole number"),
        ("[pytest]\ndvp_ads = mine.py:Stack\n", "pytest.ini: dvp_ads: no file "),
        ("[pytest]\ndvp_set = ego_sped=3\n", "pytest.ini: dvp_set ego_sped: unknown parameter of x.xosc 'ego_sped'"),
        ("[pytest]\ndvp_set = 'ego_speed=3\n", 'pytest.ini: dvp_set is "\'ego_speed=3": No closing quotation'),
        ("[pytest]\ndvp_max_log_rows = x\n", "pytest.ini: dvp_max_log_rows is 'x', expected a whole number"),
        ("dvp_seed = 7\n", "pytest.ini: cannot be read: File contains no section headers."),
    ],
)
def test_what_is_wrong_in_the_ini_file_is_one_line(
    text: str, says: str, below: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    below("x.xosc")
    Path("pytest.ini").write_text(text)
    assert main(["run", "x.xosc", *SHORT]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(says)


def test_a_misspelt_variable_is_told(
    below: Callable[[str], Path], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    below("x.xosc")
    monkeypatch.setenv("DVP_SED", "7")
    assert main(["run", "x.xosc", *SHORT]) == 2
    assert capsys.readouterr().err == "unknown setting 'DVP_SED', did you mean 'DVP_SEED'?\n"


FILES = {
    "pyproject.toml": ("", "[tool.pytest.ini_options]\ndvp_seed = 1\n", "[tool.pytest.ini_options]\n"),
    "pytest.ini": ("", "[pytest]\ndvp_seed = 1\n", "[other]\n"),
    "tox.ini": ("[tox]\n", "[pytest]\ndvp_seed = 1\n", "[pytest]\n"),
    "setup.cfg": ("[metadata]\n", "[tool:pytest]\ndvp_seed = 1\n", "[tool:pytest]\n"),
}


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("number", range(3))
def test_the_ini_file_is_the_one_that_pytest_takes(
    name: str, number: int, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a file in this folder and one above; pytest itself is asked."""
    from _pytest.config.findpaths import locate_config

    for other in FILES:
        (here / "below" / "deep").mkdir(parents=True, exist_ok=True)
        (here / other).write_text(FILES[other][1] if other == "tox.ini" else FILES[other][0])
    (here / "pytest.ini").unlink()
    (here / "below" / name).write_text(FILES[name][number])
    monkeypatch.chdir(here / "below" / "deep")
    _, expected, keys, *_ = locate_config(Path(os.getcwd()), [Path.cwd()])
    found = find_ini(Path.cwd())
    assert found is not None
    assert (found.file, set(found.keys)) == (expected, set(keys))


def test_the_replay_says_how_long_a_collision_may_last(
    below: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    below("x.xosc")
    main(["run", "x.xosc", *SHORT, "--json", "--after-collision", "2.5"])
    replay = "dvp run x.xosc --seed 7 --duration 0.1 --after-collision 2.5"
    assert json.loads(capsys.readouterr().out)["replay"] == replay
