"""What a session says of runs of fixtures and subtests, that are expected to fail, or that a test repeats."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

OF_FIXTURES = """
import pytest

@pytest.fixture
def before(run, gate):
    gate(run("bad.xosc"))

@pytest.fixture
def after(run, gate):
    yield
    gate(run("bad.xosc", seed=3))

@pytest.fixture
def judged_late(run, gate):
    result = run("bad.xosc", seed=4)
    yield
    gate(result)

def test_before(before):
    pass

def test_after(after, run, gate):
    gate(run("good.xosc"))

def test_late(judged_late):
    pass
"""


def _properties(project: pytest.Pytester, test: str) -> list[tuple[str | None, str | None]]:
    cases = ET.parse(project.path / "out.xml").iter("testcase")
    return [
        (p.get("name"), p.get("value")) for case in cases if case.get("name") == test for p in case.iter("property")
    ]


def test_a_gate_that_fails_in_a_fixture_is_told_as_that_of_a_test_is(
    project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    project.makepyfile(test_it=OF_FIXTURES)
    result = project.runpytest_inprocess("test_it.py", "--junitxml=out.xml")
    result.assert_outcomes(passed=2, errors=3)
    lines = result.outlines
    start = next(i for i, line in enumerate(lines) if line.strip("= ") == "dvp")
    assert lines[start + 1] == "4 runs, 4 gates: 3 FAIL, 1 PASS"
    failed = [line for line in lines if line.startswith("FAIL  ")]
    assert sorted(line.split()[1] for line in failed) == [
        f"test_it.py::test_{one}" for one in ("after", "before", "late")
    ]
    assert sum(line.startswith("::error file=bad.xosc") for line in lines) == 3
    assert lines.count("dvp run bad.xosc --seed 3") == 1  # the section `replay` of the teardown
    assert ("verdict", "FAIL") in _properties(project, "test_before")
    assert {("good.verdict", "PASS"), ("bad.verdict", "FAIL")} <= set(_properties(project, "test_after"))
    late = _properties(project, "test_late")
    assert ("verdict", "FAIL") in late
    assert len({name for name, _ in late}) == len(late)  # each once, though the call told of the run as well


def test_a_failure_that_is_expected_is_no_error_on_github_and_not_the_worst(
    project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    project.makepyfile(
        test_it="""
        import pytest

        @pytest.mark.xfail(reason="known")
        def test_known(run, gate):
            gate(run("bad.xosc"))

        def test_good(run, gate):
            gate(run("good.xosc"))
        """
    )
    result = project.runpytest_inprocess("test_it.py")
    result.assert_outcomes(passed=1, xfailed=1)
    result.stdout.fnmatch_lines(
        ["FAIL * test_it.py::test_known bad (expected) max_ttc_inverse 1.31*", "see it again: *good*"]
    )
    result.stdout.no_fnmatch_line("*::error*")


def test_a_skipped_test_has_failed_at_nothing(project: pytest.Pytester) -> None:
    project.makepyfile(
        test_it="""
        import pytest

        def test_it(run):
            run("bad.xosc")
            pytest.skip("not today")
        """
    )
    project.runpytest_inprocess("test_it.py").stdout.fnmatch_lines(["1 run, 1 gate: 1 NOT ASKED"])


def test_a_test_that_is_repeated_is_told_by_its_last_time(project: pytest.Pytester) -> None:
    project.makeconftest(
        (project.path / "conftest.py").read_text()
        + """

def pytest_runtest_protocol(item, nextitem):
    from _pytest.runner import runtestprotocol

    runtestprotocol(item, nextitem=nextitem, log=False)  # as plugins do that run a test again
    item._initrequest()
"""
    )
    project.makepyfile("def test_it(run, gate): gate(run('good.xosc'))")
    result = project.runpytest_inprocess("--junitxml=out.xml")
    result.stdout.fnmatch_lines(["1 run, 1 gate: 1 PASS"])
    names = [name for name, _ in _properties(project, "test_it")]
    assert len(set(names)) == len(names)


RERUN = """
from _pytest.runner import runtestprotocol


def pytest_runtest_protocol(item, nextitem):  # as pytest-rerunfailures has it
    for again in (False, True):
        reports = runtestprotocol(item, nextitem=nextitem, log=False)
        for report in reports:
            if report.failed and not again:
                report.outcome = "rerun"
            item.ihook.pytest_runtest_logreport(report=report)
            if report.outcome == "rerun":
                break
        else:
            break
        item._initrequest()
    return True


def pytest_report_teststatus(report):
    return ("rerun", "R", "RERUN") if report.outcome == "rerun" else None
"""


def test_a_failure_that_a_rerun_passed_is_not_the_verdict(
    project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    project.makeconftest((project.path / "conftest.py").read_text() + RERUN)
    project.makepyfile("""
        import itertools

        scenarios = itertools.chain(["bad.xosc"], itertools.repeat("good.xosc"))

        def test_flaky(run, gate):
            gate(run(next(scenarios)))
    """)
    result = project.runpytest_inprocess("test_a_failure_that_a_rerun_passed_is_not_the_verdict.py")
    result.stdout.fnmatch_lines(["1 run, 1 gate: 1 PASS", "PASS *good*", "*1 passed, 1 rerun*"])
    result.stdout.no_fnmatch_line("*::error*")


def test_a_stroke_in_the_value_of_a_parameter_is_no_folder(project: pytest.Pytester) -> None:
    project.makepyfile(
        test_it="""
        import pytest

        @pytest.mark.parametrize("road", ["north/a", "south"])
        def test_it(run, gate, road):
            gate(run("good.xosc"))
        """
    )
    result = project.runpytest_inprocess("test_it.py")
    told = {line.split(" good ")[0] for line in result.outlines if line.startswith("PASS  ")}
    assert told == {"PASS         test_it.py::test_it[north/a]", "PASS         test_it.py::test_it[south]"}


@pytest.mark.skipif(not hasattr(pytest, "Subtests"), reason="pytest has subtests from version 9 on")
def test_runs_of_subtests_are_told_once_by_the_worst(project: pytest.Pytester) -> None:
    project.makepyfile(
        test_it="""
        def test_it(run, gate, subtests):
            for name, seed in (("good.xosc", 1), ("bad.xosc", 2), ("good.xosc", 3)):
                with subtests.test(seed=seed):
                    gate(run(name, seed=seed))
        """
    )
    result = project.runpytest_inprocess("test_it.py")
    lines = result.outlines
    start = next(i for i, line in enumerate(lines) if line.strip("= ") == "dvp")
    assert lines[start + 1] == "3 runs, 2 gates: 1 FAIL, 1 PASS"
    assert lines[start + 2].startswith("FAIL         test_it.py::test_it bad max_ttc_inverse 1.31")
    assert lines[start + 4] == "replay the worst: dvp run bad.xosc --seed 2"
