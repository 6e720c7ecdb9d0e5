"""What a diagnosis leaves open is driven on a proving ground by the car; what it settles is not.

The diagnosis is replaced by what it would say, the car by what it would log; which drives follow is what is tested.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest

from pytest_dvp.tuning import proving_ground
from pytest_dvp.tuning.iteration_plan import Plan
from pytest_dvp.tuning.iteration_plan_file import read_plan
from pytest_dvp.workers.cache import Cache
from pytest_dvp.workers.errors import TuneError
from pytest_dvp.workers.job import Job
from pytest_dvp.workers.pool import Workers
from scenarios import path as shipped

LIFT_OFFS = {
    "lift_offs.xosc": "<OpenSCENARIO/>", "lift_offs.xodr": "<OpenDRIVE/>", "lift_offs_commands.csv": "t [s]\n0\n",
    "lift_offs_robot.py": "Robot = None\n",
}  # fmt: skip


@pytest.fixture
def plan() -> Plan:
    return dataclasses.replace(read_plan(shipped("mcrpg/paper.toml")), vehicle="surrogate")


def driven(
    plan: Plan,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    verdict: str,
    files: dict[str, str],
    ending: str = "stop",
    error: str | None = None,
) -> tuple[proving_ground.ProvingGroundResult, list[Job]]:
    log, jobs = folder / "town.mcap", list[Job]()
    log.write_bytes(b"log")
    monkeypatch.setattr(proving_ground, "thinned", lambda path: None)
    monkeypatch.setattr(proving_ground, "_planned", lambda *arguments: (verdict, files))

    def work(job: Job) -> dict[str, Any]:
        jobs.append(job)
        Path(job.save or "").parent.mkdir(exist_ok=True)
        Path(job.save or "").write_bytes(b"log")
        return {"metrics": {}, "ending": ending, "error": error}

    with Workers(Cache(folder / "cache"), work=work) as workers:
        found = proving_ground.on_proving_ground(
            plan, [log], plan.model, proving_ground.Folders(folder / "ground", folder / "logs"), workers, presets=True
        )
    return found, jobs


def test_what_is_open_is_driven_by_the_car_and_its_log_is_kept(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, jobs = driven(plan, tmp_path, monkeypatch, "PARTIAL", LIFT_OFFS)
    assert found.names == ("lift_offs",)
    assert [(job.stage, job.vehicle, Path(job.ads or "").name) for job in jobs] == [
        ("rw", "surrogate", "lift_offs_robot.py:Robot")
    ]
    assert [log.is_file() for log in found.logs] == [True]


@pytest.mark.parametrize(
    ("ending", "error", "why"),
    [("fault", "the guard stopped the car", "the guard stopped the car"), ("timeout", None, "timeout")],
)
def test_a_manoeuvre_that_broke_off_is_not_taken_as_driven(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, error: str | None, why: str
) -> None:
    """What was driven of it is learnt from, but it may be asked for again."""
    found, _ = driven(plan, tmp_path, monkeypatch, "PARTIAL", LIFT_OFFS, ending, error)
    assert found.names == ()
    assert found.unfinished == (f"lift_offs did not come to its end: {why}",)
    assert [log.is_file() for log in found.logs] == [True]


def test_what_is_settled_costs_no_drive(plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, jobs = driven(plan, tmp_path, monkeypatch, "NAMED", {})
    assert (found.names, found.logs, jobs) == ((), (), [])


def test_driven_once_it_is_known(plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, _ = driven(plan, tmp_path, monkeypatch, "PARTIAL", LIFT_OFFS)
    again, jobs = driven(plan, tmp_path, monkeypatch, "NAMED", {})
    assert again == first
    assert jobs == []


def test_other_commands_are_another_drive(plan: Plan, tmp_path: Path) -> None:
    for name, text in LIFT_OFFS.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    before = proving_ground.job(tmp_path, "lift_offs", plan, tmp_path).key
    (tmp_path / "lift_offs_commands.csv").write_text("t [s]\n0\n0.05\n", encoding="utf-8")
    assert proving_ground.job(tmp_path, "lift_offs", plan, tmp_path).key != before


def test_an_unknown_manoeuvre_is_told_with_the_nearest(tmp_path: Path) -> None:
    text = shipped("mcrpg/paper.toml").read_text(encoding="utf-8").replace('"lift_offs"', '"lift_off"')
    file = tmp_path / "plan.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(TuneError, match=r"plan.toml:\d+: .*'lift_off', did you mean 'lift_offs'"):
        read_plan(file)
