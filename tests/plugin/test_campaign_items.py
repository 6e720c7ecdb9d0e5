"""`pytest --dvp-campaign`: one item a scenario that drives many of its variants, whole or in parts."""

from __future__ import annotations

import os
import sqlite3
from pathlib import Path

import pytest

from pytest_dvp.cli.command_line import main
from tests.plugin.conftest import write_scenario

WORDS = ("good.xosc", "--dvp-campaign", "--dvp-duration", "5")


@pytest.fixture(autouse=True)
def one_core(monkeypatch: pytest.MonkeyPatch) -> None:
    """No further processes, which would take longer to begin than these drives."""
    monkeypatch.setattr(os, "cpu_count", lambda: 1)


def keys(folder: Path) -> set[str]:
    with sqlite3.connect(folder / "campaign.sqlite") as file:
        return {key for (key,) in file.execute("SELECT key FROM runs")}


def test_a_campaign_is_one_item_and_goes_on(project: pytest.Pytester) -> None:
    folder = project.path / "runs" / "campaign-good"
    for runs in (2, 3):
        result = project.runpytest_inprocess(*WORDS, "--dvp-campaign-runs", str(runs))
        result.assert_outcomes(passed=1)
        result.stdout.fnmatch_lines([f"good.xosc::campaign: {runs} drives: 0 failed, {runs} passed; map: *"])
        assert len(keys(folder)) == runs
    assert (folder / "map.html").is_file()


def test_the_parts_of_a_campaign_are_the_whole(project: pytest.Pytester) -> None:
    words = (*WORDS, "--dvp-campaign-runs", "3")
    project.runpytest_inprocess(*words).assert_outcomes(passed=1)
    for part in (1, 2):
        project.runpytest_inprocess(*words, "--dvp-shard", f"{part}/2").assert_outcomes(passed=1)
    runs = project.path / "runs"
    parts = [runs / f"campaign-good-{part}-of-2" for part in (1, 2)]
    assert main(["campaign", *map(str, parts), "--merge", "--out", str(runs / "both")]) == 0
    assert keys(runs / "both") == keys(runs / "campaign-good")


def test_a_drive_that_fails_fails_the_item_with_a_reproducer(project: pytest.Pytester) -> None:
    (project.path / "good.gates.toml").write_text('[[gate]]\nmetric = "max_jerk"\nmax = 0.001\n')
    result = project.runpytest_inprocess(*WORDS, "--dvp-campaign-runs", "2")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["good.xosc: 2 drives: 2 failed, 0 passed; map: *", "*replay: dvp run *"])
    assert "Traceback" not in result.stdout.str()


@pytest.mark.parametrize("words", [("--dvp-campaign",), ()])
@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--dvp-campaign-method", "sobel"], "*method: unknown value 'sobel', did you mean 'sobol'?*"),
        (["--dvp-shard", "3/2"], "*--dvp-shard: found '3/2', expected a part between 1 and 2*"),
    ],
)
def test_a_wrong_option_is_one_line(
    project: pytest.Pytester, words: tuple[str, ...], more: list[str], said: str
) -> None:
    result = project.runpytest_inprocess("good.xosc", *words, *more)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([said])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--dvp-shard", "1/4"], "*--dvp-shard divides a campaign: add --dvp-campaign"),
        (["--dvp-campaign-runs", "9"], "*--dvp-campaign-runs is the size of a campaign: add --dvp-campaign"),
        (["--dvp-campaign-method", "grid"], "*--dvp-campaign-method chooses * of a campaign: add --dvp-campaign"),
        (["--dvp-campaign", "--dvp-cases", "3"], "*--dvp-cases chooses among cases * leave out --dvp-campaign"),
    ],
)
def test_an_option_that_would_do_nothing_is_one_line(project: pytest.Pytester, words: list[str], said: str) -> None:
    """Four jobs with a part each, and without --dvp-campaign, would drive everything four times."""
    result = project.runpytest_inprocess("good.xosc", *words)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([said])


def test_so_is_a_variable_and_a_line_of_the_ini_file_waits(
    project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    project.makeini("[pytest]\ndvp_shard = 1/4\ndvp_campaign_runs = 9\ndvp_campaign_method = rare\ndvp_cases = 3")
    project.runpytest_inprocess("good.xosc::dt").assert_outcomes(passed=1)
    result = project.runpytest_inprocess("good.xosc", "--dvp-campaign", "--dvp-campaign-method", "grid", "--co")
    result.stdout.fnmatch_lines(["*ScenarioItem campaign*"])
    monkeypatch.setenv("DVP_SHARD", "2/4")
    result = project.runpytest_inprocess("good.xosc")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*environment DVP_SHARD divides a campaign: add --dvp-campaign"])


def test_scenarios_of_one_name_have_a_folder_each(project: pytest.Pytester) -> None:
    for folder in ("north", "south"):
        write_scenario(project.path / folder)
    write_scenario(project.path / "south", "other.xosc")
    result = project.runpytest_inprocess("north", "south", "--dvp-campaign", "--dvp-campaign-runs", "1")
    result.assert_outcomes(passed=3)
    folders = {path.parent.name for path in project.path.glob("runs/*/campaign.sqlite")}
    assert folders == {"campaign-north--good", "campaign-south--good", "campaign-other"}
    assert all(len(keys(project.path / "runs" / folder)) == 1 for folder in folders)
