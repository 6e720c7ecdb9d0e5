"""What is built holds all that git has, and the version stands in one place."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest
from hatchling.builders.plugin.interface import BuilderInterface
from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder

import pytest_dvp

ROOT = Path(__file__).parents[3]
NOT_SHIPPED = {".ci/run", ".gitignore"}
"""What only a checkout needs."""


def settings() -> dict[str, object]:
    found: dict[str, object] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


@pytest.fixture(scope="module")
def tracked() -> set[str]:
    if not (ROOT / ".git").exists():
        pytest.skip("no git checkout")
    done = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    return {name for name in done.stdout.split("\0") if name and (ROOT / name).exists()}


def built(builder: type[BuilderInterface]) -> set[str]:  # type: ignore[type-arg]
    return {file.distribution_path for file in builder(str(ROOT)).recurse_included_files()}


def test_the_wheel_holds_every_file_of_the_packages(tracked: set[str]) -> None:
    packages = {path.parent.name for path in ROOT.glob("*/__init__.py")} - {"scripts", "tests", "benchmarks"}
    assert {"pytest_dvp", "vehicle", "scenarios"} <= packages
    wanted = {name for name in tracked if name.partition("/")[0] in packages}
    assert {Path(name).suffix for name in wanted} >= {".py", ".typed", ".toml", ".dbc", ".html", ".xosc", ".xodr"}
    assert wanted - built(WheelBuilder) == set()


def test_the_sdist_holds_every_file(tracked: set[str]) -> None:
    assert tracked - built(SdistBuilder) - {"pyproject.toml"} == NOT_SHIPPED  # hatchling adds pyproject.toml by itself


def test_the_version_is_that_of_the_installed_package() -> None:
    assert pytest_dvp.__version__ == version("pytest-dvp") == settings()["version"]


def test_the_changelog_has_a_section_for_the_version() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert "\n## [Unreleased]\n" in text
    assert f"\n## [{settings()['version']}] - " in text


def test_the_version_loads_nothing_heavy() -> None:
    heavy = {"numpy", "numba", "pandas", "vehicle"}
    code = f"import pytest_dvp, sys; pytest_dvp.__version__; print(sorted({heavy} & {{*sys.modules}}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
