"""pytest and a car that says it is real: one scenario, named by a human, and nothing that repeats by itself."""

from __future__ import annotations

from pathlib import Path

import pytest

# See conftest.py: what inner sessions would import must be here before them.
import ads.stack  # noqa: F401
import pytest_dvp.drive.preparation
import pytest_dvp.drive.stage_comparison
import pytest_dvp.plugin.scenario_strategy  # noqa: F401
import vehicle.twin  # noqa: F401
from tests.plugin.conftest import write_scenario
from tests.unit.harness.test_real_vehicle import CAR

REFUSED = "*is refused: vehicle 'tabby' is real, and nothing automatic drives a real car*"


@pytest.fixture
def project(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """Two short scenarios, and a package with a real car named tabby that writes down each reset."""
    pytester.makeini("[pytest]\naddopts = --strict-markers --strict-config -W error\ndvp_duration = 0.5")
    for name in ("a.xosc", "b.xosc"):
        write_scenario(pytester.path, name)
        (pytester.path / name.replace("xosc", "gates.toml")).write_text('[[gate]]\nmetric = "collision"\nmax = 0\n')
    site = pytester.mkdir("site")
    info = site / "mycar-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mycar\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[pytest_dvp.adapters]\ntabby = mycar_of_plugin_tests:Car\n")
    reset = """
    def reset(self, state):
        with open("driven.txt", "a") as file:
            file.write("reset ")
        super().reset(state)
"""
    (site / "mycar_of_plugin_tests.py").write_text(CAR.replace("    def apply", f"{reset}\n    def apply", 1))
    monkeypatch.syspath_prepend(site)
    monkeypatch.setenv("PYTHONPATH", str(site))
    return pytester


def driven(project: pytest.Pytester) -> bool:
    return (project.path / "driven.txt").exists()


def session(project: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    return project.runpytest_inprocess("--dvp-vehicle", "tabby", *arguments)


def test_one_named_scenario_runs_dry_and_never_passes(project: pytest.Pytester) -> None:
    result = session(project, "a.xosc::rw")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["FAILED a.xosc::rw - dry run INCONCLUSIVE: no command reached the car*"])
    assert driven(project)


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("-m", "rw", "a.xosc", "b.xosc"), "2 scenarios at once"),
        (("-m", "pe or rw", "a.xosc"), "2 scenarios at once"),
        (("a.xosc::rw", "--ff"), "--ff"),
        (("a.xosc::rw", "--stepwise"), "--stepwise"),
    ],
)
def test_what_repeats_or_chooses_by_itself_is_refused(
    project: pytest.Pytester, arguments: tuple[str, ...], what: str
) -> None:
    result = session(project, *arguments)
    assert result.ret != pytest.ExitCode.OK
    result.stdout.fnmatch_lines([f"*{what} is refused: vehicle 'tabby' is real*"])
    assert not driven(project)


def test_lf_is_refused(project: pytest.Pytester) -> None:
    session(project, "-m", "rw", "a.xosc", "b.xosc").assert_outcomes(failed=2)
    result = session(project, "a.xosc::rw", "--lf")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*--lf is refused: vehicle 'tabby' is real*"])
    assert not driven(project)


@pytest.mark.nightly
def test_several_workers_are_refused(project: pytest.Pytester) -> None:
    result = project.runpytest_subprocess("--dvp-vehicle", "tabby", "-n", "2", "a.xosc::rw")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*-n 2 is refused: vehicle 'tabby' is real*"])
    assert not driven(project)


def test_fuzzing_and_shrinking_are_refused(project: pytest.Pytester) -> None:
    project.makepyfile(
        """
        from hypothesis import given, settings
        from pytest_dvp import scenario_variants

        @settings(database=None, max_examples=3)
        @given(variant=scenario_variants("a.xosc"))
        def test_it(variant, run):
            run(variant, stage="rw")
        """
    )
    result = session(project)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([f"*fuzzing {REFUSED[1:]}"])
    assert not driven(project)


def test_a_second_drive_in_a_session_is_refused(project: pytest.Pytester) -> None:
    project.makepyfile(
        """
        def test_it(run):
            run("a.xosc", stage="rw")
            run("a.xosc", stage="rw")
        """
    )
    result = session(project)
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([f"*a second drive in one session {REFUSED[1:]}"])


def test_a_comparison_of_stages_never_drives_it(project: pytest.Pytester) -> None:
    text = '[[gate]]\nmetric = "path_distance"\nbetween = ["dt", "rw"]\nmax = 1\n'
    Path(project.path / "a.gates.toml").write_text(text)
    result = session(project, "a.xosc::dt-rw")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*INCONCLUSIVE: no drive of stage rw in this session, and its own test alone drives*"])
    assert not driven(project)
