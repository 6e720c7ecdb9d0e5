"""Gates between stages as pytest items: when they exist, run and are skipped, and what they share."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds")

# See conftest.py: what inner sessions would import must be here before them.
import ads.stack  # noqa: F401
import pytest_dvp.cli.run
import pytest_dvp.drive.preparation
import pytest_dvp.drive.stage_comparison
import pytest_dvp.plugin.shared_runs  # noqa: F401
import reports.html
import reports.stages  # noqa: F401
import vehicle.adapters.process
import vehicle.twin  # noqa: F401
from tests.plugin.conftest import write_scenario

GATES = """
[[gate]]
metric = "collision"
max = 0

[[gate]]
metric = "path_distance"
between = ["dt", "rw"]
max = {most}
"""
ACROSS = "s.xosc::dt-rw-surrogate"


@pytest.fixture
def stages(pytester: pytest.Pytester) -> pytest.Pytester:
    """A project with one short scenario whose gate file holds a gate between dt and rw."""
    pytester.makeini("[pytest]\naddopts = --strict-markers --strict-config -W error\ndvp_duration = 1.5")
    write_scenario(pytester.path, "s.xosc")
    (pytester.path / "s.gates.toml").write_text(GATES.format(most=1.0))
    return pytester


def driven(project: pytest.Pytester) -> list[str]:
    return sorted(folder.name[5:] for folder in (project.path / "runs").glob("0*"))


def test_it_is_an_item_of_its_own_that_is_skipped_until_the_car_is_asked_for(stages: pytest.Pytester) -> None:
    result = stages.runpytest_inprocess("--collect-only", "-q", "s.xosc")
    assert [line for line in result.outlines if "::" in line] == [
        "s.xosc::dt", "s.xosc::pe-surrogate", "s.xosc::rw-surrogate", ACROSS,
    ]  # fmt: skip
    result = stages.runpytest_inprocess("-rs", "s.xosc")
    result.assert_outcomes(passed=1, skipped=3)
    result.stdout.fnmatch_lines(["SKIPPED*as rw-surrogate does: ask for both, -m 'dt or rw'"])


@pytest.mark.nightly
def test_with_workers_each_stage_is_driven_once_and_the_comparison_is_in_junit(stages: pytest.Pytester) -> None:
    """With two of them, where a stage may be needed by both; the next tests have none."""
    result = stages.runpytest_subprocess("-m", "dt or rw", "-n", "2", "--junitxml=out.xml", "s.xosc")
    result.assert_outcomes(passed=3)
    assert driven(stages) == ["s-dt", "s-dt-rw-surrogate", "s-rw-surrogate"]
    cases = {case.get("name"): case for case in ET.parse(stages.path / "out.xml").iter("testcase")}
    numbers = {p.get("name"): p.get("value") for p in cases["dt-rw-surrogate"].iter("property")}
    assert numbers["path_distance.status"] == "PASS"
    assert float(numbers["rw-surrogate.mncc(x)"] or 0.0) > 0.99
    result.stdout.fnmatch_lines(
        ["*= dvp stages =*", "* dt *rw-surrogate to dt*", "MNCC ego x*", "page: runs/*/report.html"]
    )


def test_alone_it_drives_what_it_compares(stages: pytest.Pytester) -> None:
    result = stages.runpytest_inprocess(ACROSS)
    result.assert_outcomes(passed=1)
    assert driven(stages) == ["s-dt", "s-dt-rw-surrogate", "s-rw-surrogate"]


@pytest.mark.nightly
def test_one_that_failed_is_run_again_by_lf(stages: pytest.Pytester) -> None:
    (stages.path / "s.gates.toml").write_text(GATES.format(most=1e-9))
    failed = stages.runpytest_inprocess("-m", "dt or rw", "s.xosc")
    failed.assert_outcomes(passed=2, failed=1)
    assert driven(stages) == ["s-dt", "s-dt-rw-surrogate", "s-rw-surrogate"]
    failed.stdout.fnmatch_lines(
        [
            f"FAILED {ACROSS} - path_distance *",
            "*",
        ]
    )
    failed.stdout.fnmatch_lines(["replay the worst: dvp run s.xosc --stage dt,rw --seed 7 --duration 1.5"])
    (stages.path / "s.gates.toml").write_text(GATES.format(most=1.0))
    again = stages.runpytest_inprocess("-m", "dt or rw", "--lf", "s.xosc")
    again.assert_outcomes(passed=1)


def test_a_log_of_an_earlier_session_stands_for_a_drive(stages: pytest.Pytester) -> None:
    stages.runpytest_inprocess("s.xosc::rw-surrogate").assert_outcomes(passed=1)
    (log,) = (stages.path / "runs").glob("0*")
    result = stages.runpytest_inprocess(ACROSS, "--dvp-stage-logs", str(log))
    result.assert_outcomes(passed=1)
    assert driven(stages) == ["s-dt", "s-dt-rw-surrogate", "s-rw-surrogate"]


def test_the_header_names_the_model_of_the_log_that_stands_for_the_twin(stages: pytest.Pytester) -> None:
    """And the model that is driven where the twin is driven."""
    (stages.path / "mine.toml").write_text("[parameters]\nwheelbase = 2.36\nmass = 800.0\n")
    stages.runpytest_inprocess("s.xosc::dt", "--dvp-model", "mine.toml").stdout.fnmatch_lines(
        ["dvp: *, model mine.toml"]
    )
    (log,) = (stages.path / "runs").glob("0*")
    alone = stages.runpytest_inprocess(ACROSS, "--dvp-stage-logs", str(log), "--collect-only")
    alone.stdout.fnmatch_lines([f"dvp: *, model mine.toml of {log.name}"])
    driven_too = stages.runpytest_inprocess("s.xosc::dt", ACROSS, "--dvp-stage-logs", str(log), "--collect-only")
    driven_too.stdout.fnmatch_lines([f"dvp: *, model tabby_evo.toml, mine.toml of {log.name}"])


@pytest.mark.nightly
def test_a_log_of_another_scenario_is_not_replaced_by_a_drive(stages: pytest.Pytester) -> None:
    """Whoever named the wrong log would take the car of a new drive for the one of the log."""
    for name in ("s.xosc", "s.gates.toml"):
        (stages.path / f"other{name[1:]}").write_text((stages.path / name).read_text())
    stages.runpytest_inprocess("other.xosc::rw-surrogate").assert_outcomes(passed=1)
    (log,) = (stages.path / "runs").glob("0*")
    result = stages.runpytest_inprocess(ACROSS, "--dvp-stage-logs", str(log))
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*INCONCLUSIVE: no log given is a drive of s.xosc on rw (they are of other.xosc)*"])
    assert driven(stages) == ["other-rw-surrogate", "s-dt", "s-dt-rw"]


def test_what_cannot_be_driven_leaves_it_inconclusive_and_says_why(stages: pytest.Pytester) -> None:
    result = stages.runpytest_inprocess(ACROSS, "--dvp-require-real")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*INCONCLUSIVE: rw-surrogate ERROR: a real vehicle is required*"])


def test_a_session_leaves_nothing_behind(
    stages: pytest.Pytester, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    stages.runpytest_inprocess(ACROSS).assert_outcomes(passed=1)
    assert not list(tmp_path.glob("dvp-session-*"))


def test_a_hidden_file_that_is_wrong_is_told_before_anything_drives(stages: pytest.Pytester) -> None:
    (stages.path / "car.toml").write_text("[hidden.steer_dely]\nT = 0.2\n")
    result = stages.runpytest_inprocess("-m", "dt or rw", "--dvp-vehicle", "surrogate:car.toml", "s.xosc")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --dvp-vehicle: car.toml:1: no hidden effect 'steer_dely'; did you mean *?"])
    assert not (stages.path / "runs").exists()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("s.xosc::rw",), "s.xosc: unknown item 'rw', allowed: dt, dt-rw-surrogate, pe-surrogate, rw-surrogate"),
        (("s.xosc::dt-rw-surogate",), "s.xosc: unknown item 'dt-rw-surogate', did you mean 'dt-rw-surrogate'?"),
        (
            ("s.xosc::rw-surrogate", "--dvp-vehicle=surogate"),
            "--dvp-vehicle: unknown vehicle 'surogate', did you mean 'surrogate'? *",
        ),
        (("-m", "rw", "s.xosc", "--dvp-vehicle=surogate"), "--dvp-vehicle: unknown vehicle 'surogate', *"),
    ],
)
def test_an_item_or_vehicle_that_does_not_exist_is_told_at_collection(
    stages: pytest.Pytester, arguments: tuple[str, ...], says: str
) -> None:
    result = stages.runpytest_inprocess(*arguments)
    assert result.ret in (pytest.ExitCode.USAGE_ERROR, pytest.ExitCode.INTERRUPTED)
    result.stdout.fnmatch_lines([says])
