"""`dvp tune` of the parameters that a driving stack of one's own declares."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.tuning.searchers.search import make_searcher
from pytest_dvp.tuning.study_file import read_study
from pytest_dvp.workers.errors import TuneError
from pytest_dvp.workers.job import Job

STACK = """
from vehicle.messages import Command


class Keeper:
    parameters = {"LK_throttle": 0.0, "LK_ticks": 10}

    def __init__(self, parameters, network, description):
        self.throttle = parameters["LK_throttle"]

    def tick(self, observation):
        return Command(observation.t, 0.0, 0.0, self.throttle, 0.0)
"""
STUDY = """[study]
ads = "mine.py:Keeper"
budget = 4

[[scenario]]
file = "follow.xosc"

[parameters]
"P.LK_throttle" = [0, 0.02]

[[term]]
metric = "completion_time"

[[constraint]]
metric = "road_departure"
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    (tmp_path / "mine.py").write_text(STACK)
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


def test_its_start_is_the_default_and_each_job_drives_it(study: Path) -> None:
    found = read_study(study)
    assert found.start == {"P.LK_throttle": 0.0}
    (job,) = found.jobs({"P.LK_throttle": 0.02})
    assert job.ads is not None
    assert job.ads.endswith("mine.py:Keeper")
    assert job.P == (("LK_throttle", 0.02), ("LK_ticks", 10.0))


@pytest.mark.parametrize("search", ["descent", "cma", "tpe"])
def test_a_parameter_whose_default_is_an_integer_is_searched_in_whole_numbers(study: Path, search: str) -> None:
    """The stack refuses any other: the search would end with its first point."""
    if search != "descent":
        pytest.importorskip({"cma": "cma", "tpe": "optuna"}[search], reason="needs the extra tune")
    study.write_text(
        STUDY.replace('"P.LK_throttle" = [0, 0.02]', '"P.LK_throttle" = [0, 0.02]\n"P.LK_ticks" = [5, 40]')
    )
    found = read_study(study)
    searcher = make_searcher(search, found.knobs, found.start, 3)
    points = []
    for _ in range(4):
        points += (asked := searcher.ask())
        searcher.tell(asked, [abs(point["P.LK_ticks"] - 33.0) for point in asked])
    ticks = {point["P.LK_ticks"] for point in points}
    assert len(ticks) > 3
    assert all(value.is_integer() and 5.0 <= value <= 40.0 for value in ticks)
    assert not all(point["P.LK_throttle"].is_integer() for point in points)


def test_each_candidate_is_looked_at_before_anything_runs(study: Path) -> None:
    study.write_text(STUDY.replace('"P.LK_throttle" = [0, 0.02]', '"P.LK_ticks" = [5, 7.5, 40]'))
    with pytest.raises(TuneError, match=r"study.toml:9: .*LK_ticks: found 7\.5, expected a whole number"):
        read_study(study)


@pytest.mark.nightly
def test_candidates_reach_the_stack_and_the_command_repeats_it(study: Path, tmp_path: Path, capsys) -> None:
    text = STUDY.replace("completion_time", "collision").replace("road_departure", "collision")
    study.write_text(text)
    folders = ["--out", str(tmp_path / "out"), "--cache", str(tmp_path / "cache"), "--jobs", "1"]
    main(["tune", str(study), "--json", *folders])
    result = json.loads(capsys.readouterr().out)
    assert {trial["point"]["P.LK_throttle"] for trial in result["trials"]} == {0.0, 0.02}
    command = result["again"][0]["command"]
    assert "mine.py:Keeper" in command
    assert "P.LK_ticks" not in command  # as its default


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('"P.LK_throttle"', '"P.LK_throtle"', r"study.toml:9: .*'LK_throtle', did you mean 'LK_throttle'\?"),
        ('"P.LK_throttle"', '"P.LQR_q11"', r"study.toml:9: .*unknown parameter 'LQR_q11', allowed: LK_thr"),
        ("mine.py:Keeper", "mine.py:Keper", r"study.toml:2: .*unknown class 'Keper', did you mean 'Keeper'\?"),
        ("mine.py:Keeper", "mine", r"study.toml:2: ads is 'mine', expected FILE.py:Class"),
        ("mine.py:Keeper", "yours.py:Keeper", r"study.toml:2: ads: no file"),
    ],
)
def test_a_slip_is_one_line_with_its_place(study: Path, old: str, new: str, says: str) -> None:
    study.write_text(STUDY.replace(old, new))
    with pytest.raises(TuneError, match=says) as refused:
        read_study(study)
    assert "\n" not in str(refused.value)


def test_a_kept_simulation_is_another_ones_when_a_source_of_the_stack_changes(tmp_path: Path) -> None:
    keys = []
    for number, text in enumerate(["GAIN = 1\n", "GAIN = 1\n", "GAIN = 2\n"]):
        folder = tmp_path / str(number)
        (folder / "parts").mkdir(parents=True)
        (folder / "mine.py").write_text(STACK)
        (folder / "parts" / "gain.py").write_text(text)
        scenario = tmp_path / "x.xosc"
        scenario.write_text("<OpenSCENARIO/>")
        keys.append(Job(str(scenario), ads=f"{folder / 'mine.py'}:Keeper").key)
    assert keys[0] == keys[1] != keys[2]
