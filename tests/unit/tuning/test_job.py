"""The key of a job: another one as soon as a file that the run can open is another one, and not before."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from pytest_dvp.workers import job as job_module
from pytest_dvp.workers.job import Job
from pytest_dvp.workers.run_job import work
from scenarios import path as shipped


@pytest.fixture
def job(tmp_path: Path) -> Job:
    files = ("town/a.xosc", "town/b.xosc", "town/town.xodr", "town/a.gates.toml", "town/catalogs/cars.xosc",
             "town/maps/old town.xodr", "town/near.xosc",
             "town/runs/0001/a.xosc", "town/film.mp4", "lib/xodr/road.xodr", "lib/notes.txt")  # fmt: skip
    for name in files:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    (tmp_path / "town/near.xosc").write_text('<OpenSCENARIO>\n<Catalog name="near">')
    (tmp_path / "town/b.xosc").write_text("<OpenSCENARIO>\n<CatalogLocations />")
    return Job(str(tmp_path / "town/a.xosc"), library=(str(tmp_path / "lib"),))


def changed(job: Job, tmp_path: Path, name: str) -> bool:
    before = job.key
    (tmp_path / name).write_text("something else")
    job_module._library.cache_clear()  # kept for a process, in which no library changes
    return job.key != before


@pytest.mark.parametrize(
    "name",
    [
        "town/a.xosc",
        "town/town.xodr",
        "town/a.gates.toml",
        "town/catalogs/cars.xosc",
        "lib/xodr/road.xodr",
        "town/maps/old town.xodr",
        "town/near.xosc",
    ],
)
def test_what_a_run_can_open_makes_another_job(job: Job, tmp_path: Path, name: str) -> None:
    assert changed(job, tmp_path, name)


@pytest.mark.parametrize("name", ["town/b.xosc", "town/runs/0001/a.xosc", "town/film.mp4", "lib/notes.txt"])
def test_what_it_cannot_open_does_not(job: Job, tmp_path: Path, name: str) -> None:
    assert not changed(job, tmp_path, name)


def test_where_the_log_goes_and_where_the_files_lie_is_no_matter(job: Job, tmp_path: Path) -> None:
    moved = tmp_path.with_name(f"{tmp_path.name}-moved")
    tmp_path.rename(moved)
    there = dataclasses.replace(
        job, scenario=str(moved / "town/a.xosc"), library=(str(moved / "lib"),), save=str(moved / "log.mcap")
    )
    key = there.key
    moved.rename(tmp_path)
    assert job.key == key


def test_a_drive_tells_which_event_never_fired_and_when_it_ended() -> None:
    """The car has not met anybody after two seconds."""
    found = work(Job(str(shipped("pedestrian_crossing.xosc")), duration=2.0))
    (event, *_), last = found["incidents"][:-1], found["incidents"][-1]
    assert event.startswith("event '")
    assert event.endswith(" never fired")
    assert found["incidents"][-2] == "it did not reach its goal"
    assert last.startswith("it ended after 2.0 s by")
    assert found["metrics"]["missed_events"] > 0.0
