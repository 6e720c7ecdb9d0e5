"""What a job needs is packed by what it holds, and put down as it lies: not less, and not what nobody asked for."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from pytest_dvp.workers import file_transfer as parcel_module
from pytest_dvp.workers.errors import TuneError
from pytest_dvp.workers.file_transfer import Packing, moved, placed, put_down
from pytest_dvp.workers.installation import first_difference, installed
from pytest_dvp.workers.job import Job


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    files = (
        "scenes/a.xosc", "scenes/a.gates.toml", "scenes/town.xodr", "scenes/catalogs/cars.xosc",  # what a run may open
        "scenes/film.mp4", "scenes/.git/b.xosc", "scenes/runs/0001/result.xml", "scenes/.venv/c.toml",  # not
        "twins/car.toml", "twins/other.toml", "logs/drive.mcap", "logs/other.mcap", "hidden.toml",
        "ground/steps.xosc", "ground/steps_robot.py", "ground/steps_commands.csv", "stack/mine.py",
    )  # fmt: skip
    for name in files:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name, encoding="utf-8")
    return tmp_path


def carried(folder: Path, job: Job) -> set[str]:
    found = Packing().parcels(job)
    return {(Path(each.root) / name).relative_to(folder).as_posix() for each in found for name, _ in each.files}


def test_of_a_drive_go_the_files_that_a_scenario_can_reach_its_model_and_what_is_hidden_in_the_car(
    folder: Path,
) -> None:
    drive = Job(
        str(folder / "scenes/a.xosc"), "rw", model=str(folder / "twins/car.toml"),
        vehicle=f"surrogate:{folder / 'hidden.toml'}",
    )  # fmt: skip
    assert carried(folder, drive) == {
        "scenes/a.xosc", "scenes/a.gates.toml", "scenes/town.xodr", "scenes/catalogs/cars.xosc", "twins/car.toml",
        "hidden.toml",
    }  # fmt: skip


def test_of_a_replay_go_one_log_and_one_model(folder: Path) -> None:
    replay = Job("", model=str(folder / "twins/car.toml"), log=str(folder / "logs/drive.mcap"))
    assert carried(folder, replay) == {"twins/car.toml", "logs/drive.mcap"}


def test_a_robot_goes_with_its_commands_and_a_stack_of_ones_own_stays(folder: Path) -> None:
    robot = Job(str(folder / "ground/steps.xosc"), ads=f"{folder / 'ground/steps_robot.py'}:Robot")
    assert carried(folder, robot) == {"ground/steps.xosc", "ground/steps_robot.py", "ground/steps_commands.csv"}
    own = Job(str(folder / "ground/steps.xosc"), ads=f"{folder / 'stack/mine.py'}:Stack")
    assert "stack/mine.py" not in carried(folder, own)


def test_what_a_link_reaches_outside_the_folder_is_left_as_a_scenario_may_not_reach_it(folder: Path) -> None:
    (folder / "scenes" / "secret.toml").symlink_to(folder / "hidden.toml")
    (folder / "scenes" / "again.xodr").symlink_to(folder / "scenes" / "town.xodr")
    found = carried(folder, Job(str(folder / "scenes/a.xosc")))
    assert "scenes/again.xodr" in found
    assert "scenes/secret.toml" not in found


def test_a_folder_that_holds_too_much_is_one_line(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    size = sum(len(name) for name in ("scenes/a.xosc", "scenes/a.gates.toml", "scenes/town.xodr"))
    monkeypatch.setattr(parcel_module, "MOST", size)  # the catalogue is one file too many
    with pytest.raises(TuneError, match=f"^{folder}/scenes: .* put the scenario into a folder of its own$"):
        Packing().parcels(Job(str(folder / "scenes/a.xosc")))


def test_a_parcel_is_known_by_what_it_holds(folder: Path) -> None:
    job = Job("", model=str(folder / "twins/car.toml"))
    (before,) = Packing().parcels(job)
    (same,) = Packing().parcels(job)
    (folder / "twins/car.toml").write_text("another car", encoding="utf-8")
    (after,) = Packing().parcels(job)
    assert before.name == same.name != after.name


def test_a_job_put_down_elsewhere_is_the_same_job(folder: Path) -> None:
    job = Job(str(folder / "scenes/a.xosc"), model=str(folder / "twins/car.toml"), P=(("MPC_w", 3.0),))
    contents = [parcel.contents() for parcel in Packing().parcels(job)]
    root = put_down(contents, folder / "elsewhere")
    there = moved(job, lambda path: placed(path, root))
    assert there.scenario != job.scenario
    assert there.key == job.key
    assert put_down(contents, folder / "elsewhere") == root  # it is there already
    Path(there.scenario).write_text("edited", encoding="utf-8")
    assert there.key != job.key


def test_every_file_that_a_job_names_is_moved(folder: Path) -> None:
    """All fields but these are values, and `save` is where the result goes."""
    job = Job(
        "a", model="b", gates="c", vehicle="surrogate:d", library=("e",), log="f", ads="g:Stack", save="h", stage="rw"
    )
    there = dataclasses.asdict(moved(job, lambda path: f"/{path}"))
    changed = {name: value for name, value in there.items() if value != getattr(job, name)}
    assert changed == {
        "scenario": "/a", "model": "/b", "gates": "/c", "vehicle": "surrogate:/d", "library": ("/e",), "log": "/f",
        "ads": "/g:Stack",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("there", "told"),
    [
        ({"numpy": "2", "a/b.py": "1"}, ""),
        ({"numpy": "3", "a/b.py": "1"}, "numpy is 3 there, 2 here"),
        ({"a/b.py": "1"}, "numpy is missing there, 2 here"),
        ({"numpy": "2", "a/b.py": "2"}, "its a/b.py differs"),
        ({"numpy": "2"}, "it has no a/b.py"),
        ({"numpy": "2", "a/b.py": "1", "a/c.py": "1"}, "it has a/c.py, which is not here"),
    ],
)
def test_the_first_difference_is_named(there: dict[str, str], told: str) -> None:
    assert first_difference({"numpy": "2", "a/b.py": "1"}, there) == told


def test_what_decides_a_result_is_compared(folder: Path) -> None:
    found = installed()
    assert {"Python", "processor", "system", "numpy", "numba", "scipy", "pytest-dvp"} <= set(found)
    assert {"pytest_dvp/drive/run.py", "pytest_dvp/workers/run_job.py", "vehicle/wire/drive_by_wire.dbc"} <= set(found)
    assert not any("__pycache__" in name for name in found)
