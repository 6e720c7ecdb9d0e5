"""Tuning: the best point is found, whoever searches, however many work on it, and however often it is killed."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

sys.path[:0] = [str(Path(__file__).parent)]
import bowl  # noqa: E402

from pytest_dvp.tuning.tune import Tuning  # noqa: E402
from pytest_dvp.workers.job import Job  # noqa: E402

SEARCHES = ("coordinate", "cma", "tpe")
DEAR = [pytest.param(name, marks=pytest.mark.nightly) if name == "cma" else name for name in SEARCHES]


@pytest.fixture(params=SEARCHES)
def search(request: pytest.FixtureRequest) -> str:
    if request.param != "coordinate":
        pytest.importorskip({"cma": "cma", "tpe": "optuna"}[request.param], reason="needs the extra tune")
    return str(request.param)


def course(found: Tuning) -> list[Any]:
    return [(trial.point, trial.score.value) for trial in found.trials]


def test_coordinate_search_finds_the_best_candidates_and_stops_there(tmp_path: Path) -> None:
    found = bowl.tuned(tmp_path)
    assert dict(found.best.point) == bowl.BEST
    assert found.best.score.value == pytest.approx(0.005)  # the mean of both seeds' 0 and 0.01
    assert found.ended == "nothing improves"


def test_coordinate_search_tries_each_candidate_of_one_parameter_with_the_others_held(tmp_path: Path) -> None:
    """Start, three other values of the first, three of the second, then the first again: all but one known by then."""
    points = [tuple(trial.point.values()) for trial in bowl.tuned(tmp_path).trials]
    assert points[:4] == [(10, 3.5), (20, 3.5), (30, 3.5), (50, 3.5)]
    assert points[4:7] == [(30, 1.5), (30, 2.5), (30, 3.0)]
    assert sorted(points[7:]) == [(10, 3.0), (20, 3.0), (50, 3.0)]


@pytest.mark.parametrize("search", ["coordinate", "cma", pytest.param("tpe", marks=pytest.mark.nightly)], indirect=True)
def test_continuous_searchers_come_close_to_the_bottom(tmp_path: Path, search: str) -> None:
    assert bowl.tuned(tmp_path, search, budget=240).best.score.value < 0.05


def test_what_must_hold_stands_before_everything_else(tmp_path: Path) -> None:
    """From a start that collides the search gets away; no point that collides is ever best."""
    found = bowl.tuned(tmp_path, start={"P.LQR_q11": 30.0, "P.MPC_w": 1.5})
    assert found.start.score.broken == ("collision > 0",)
    assert dict(found.best.point) == bowl.BEST


def breaks_beyond_3(job: Job) -> dict[str, Any]:
    """A stack that raises at once for w > 3: it has hardly moved, so it has no jerk and has hit nobody."""
    if dict(job.P)["MPC_w"] <= 3.0:
        return bowl.work(job)
    return {"metrics": {"max_jerk": 0.0, "collision": 0.0}, "ending": "fault", "error": "ValueError: boom"}


def test_a_point_at_which_the_stack_breaks_is_never_the_best(tmp_path: Path) -> None:
    """(30, 3) has a jerk of 0.005; that of the drives that broke off, 0, shows nothing."""
    found = bowl.tuned(tmp_path, what=breaks_beyond_3, start={"P.LQR_q11": 10.0, "P.MPC_w": 2.5})
    assert dict(found.best.point) == bowl.BEST
    broken = [trial for trial in found.trials if trial.point["P.MPC_w"] == 3.5]
    assert broken
    for trial in broken:
        assert trial.score.broken == ("the drive broke off", "collision undefined", "max_jerk undefined")
        assert trial.metrics == {"max_jerk": None, "collision": None}


def test_budget_counts_simulations_and_is_never_passed(tmp_path: Path, search: str) -> None:
    found = bowl.tuned(tmp_path, search, budget=15)
    assert found.simulations == 14  # two a point: seven points, and one simulation makes no point
    assert found.ended == "budget"


@pytest.mark.parametrize("search", DEAR, indirect=True)
def test_result_does_not_depend_on_the_number_of_workers(tmp_path: Path, search: str) -> None:
    alone, together = bowl.tuned(tmp_path / "a", search), bowl.tuned(tmp_path / "b", search, count=2)
    assert course(alone) == course(together)


@pytest.mark.parametrize("search", DEAR, indirect=True)
def test_killed_anywhere_it_ends_with_the_result_of_one_left_alone(tmp_path: Path, search: str) -> None:
    for last in (1, 2, 9) if search == "coordinate" else (13,):
        command = [sys.executable, str(Path(bowl.__file__)), str(tmp_path / "killed"), search, str(last)]
        assert subprocess.run(command, check=False).returncode == -signal.SIGKILL
    assert course(bowl.tuned(tmp_path / "killed", search)) == course(bowl.tuned(tmp_path / "alone", search))


def test_a_document_is_the_same_to_the_byte_whether_simulated_or_kept(tmp_path: Path) -> None:
    def told(job: Job) -> dict[str, Any]:
        return {"metrics": {"max_jerk": 1.0, "collision": 0.0}, "ending": "goal", "error": None}

    first, second = (json.dumps(bowl.tuned(tmp_path, what=told).as_dict()) for _ in range(2))
    assert first == second


def test_what_was_simulated_is_never_simulated_again(tmp_path: Path) -> None:
    bowl.tuned(tmp_path)

    def idle(job: Job) -> dict[str, Any]:
        raise AssertionError(f"{job} is known")

    assert dict(bowl.tuned(tmp_path, what=idle).best.point) == bowl.BEST


def test_a_file_cut_off_in_the_cache_counts_as_none(tmp_path: Path) -> None:
    before = course(bowl.tuned(tmp_path))
    for file in (tmp_path / "cache").rglob("*.json"):
        file.write_bytes(file.read_bytes()[:20])
    assert course(bowl.tuned(tmp_path)) == before


def test_a_changed_scenario_is_another_job(tmp_path: Path) -> None:
    file = tmp_path / "a.xosc"
    file.write_text("<OpenSCENARIO/>")
    one = Job(str(file)).key
    assert Job(str(file)).key == one
    file.write_text("<OpenSCENARIO a='1'/>")
    assert Job(str(file)).key != one


def test_a_job_is_known_by_what_its_files_hold_and_not_by_where_they_are(tmp_path: Path) -> None:
    keys = set()
    for name in ("here", "there"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.xosc").write_text("<OpenSCENARIO/>")
        keys.add(Job(str(tmp_path / name / "a.xosc")).key)
    assert len(keys) == 1
