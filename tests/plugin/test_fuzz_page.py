"""The fuzz tests that docs/your-project.md prints, with the lane follower that docs/your-ads.md prints."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

import scenarios

# See conftest.py: what inner sessions would import must be here before them.
import ads.stack  # noqa: F401  # isort: skip
import reports.html  # noqa: F401  # isort: skip
import vehicle.twin  # noqa: F401  # isort: skip

DOCS = Path(__file__).parents[2] / "docs"


def section(page: str, title: str) -> str:
    return (DOCS / page).read_text(encoding="utf-8").split(f"\n## {title}\n")[1].split("\n## ")[0]


def code(page: str, title: str) -> str:
    (found,) = re.findall(r"```python\n(.*?)```", section(page, title), re.DOTALL)
    return str(found)


@pytest.mark.nightly
def test_they_find_what_the_page_says_and_leave_the_file_and_command_that_replay_it(pytester: pytest.Pytester) -> None:
    from pytest_dvp.cli.command_line import main

    shutil.copytree(scenarios.path("urban.xodr").parent, pytester.path / "scenarios", ignore=lambda _, n: [*_py(n)])
    (pytester.path / "lane_keeper.py").write_text(code("your-ads.md", "A lane follower"))
    (pytester.path / "tests").mkdir()
    (pytester.path / "tests" / "test_crossing.py").write_text(code("your-project.md", "Fuzzing a scenario"))
    pytester.makeini("[pytest]\naddopts = -p no:cacheprovider")
    searched = ("-p", "_hypothesis_pytestplugin", "--hypothesis-seed=1")
    result = pytester.runpytest_inprocess("tests", "--dvp-ads", "lane_keeper.py:LaneKeeper", *searched)
    result.assert_outcomes(passed=1, failed=1)
    page = section("your-project.md", "Fuzzing a scenario")
    (command,) = re.findall(r"^dvp run runs/variants/.*$", page, re.MULTILINE)
    result.stdout.fnmatch_lines(["*GateFailed: max_ttc_inverse 0.51 1/s > 0.50 at t=35.05 s (Pedestrian)", command])
    assert "ego_speed=4.25" in result.stdout.str()
    (left,) = (pytester.path / "runs").rglob("*.xosc")
    assert left.relative_to(pytester.path).as_posix() == command.split()[2]
    assert not list((pytester.path / "runs").rglob("log.mcap"))
    assert main(command.split()[1:]) == 1  # it fails again, and this run writes its report
    assert len(list((pytester.path / "runs").rglob("report.html"))) == 1


def _py(names: list[str]) -> list[str]:
    return [name for name in names if name == "__pycache__" or name.endswith(".py")]
