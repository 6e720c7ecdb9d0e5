"""Which files become items, under which names, and what a broken file costs."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.plugin.conftest import CATALOG, XOSC, write_scenario


def test_a_scenario_is_three_items_one_a_stage(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("--collect-only", "-q", ".")
    assert [line for line in result.outlines if "good" in line] == [
        f"good.xosc::{stage}" for stage in ("dt", "pe-surrogate", "rw-surrogate")
    ]


def test_a_catalogue_met_in_a_folder_is_passed_over(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("--collect-only", "-q", ".")
    assert result.ret == pytest.ExitCode.OK
    result.stdout.no_fnmatch_line("*catalog*")


def test_a_catalogue_named_on_the_command_line_is_an_error(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("catalog.xosc")
    assert result.ret == pytest.ExitCode.INTERRUPTED
    result.stdout.fnmatch_lines(["*catalog.xosc:*a catalogue*no storyboard*"])


def test_a_broken_file_is_one_error_with_its_line_and_others_still_run(project: pytest.Pytester) -> None:
    cut = XOSC.index("<Storyboard>") + 40
    (project.path / "cut.xosc").write_text(XOSC[:cut])
    result = project.runpytest_inprocess(".")
    result.stdout.re_match_lines([r".*cut\.xosc:\d+: error .*"])
    result.assert_outcomes(passed=1, failed=1, errors=1, skipped=4)
    assert "Traceback" not in result.stdout.str()


def test_an_unknown_entity_is_a_collection_error_that_names_it(project: pytest.Pytester) -> None:
    (project.path / "wrong.xosc").write_text(XOSC.replace('entityRef="Ego"', 'entityRef="Egon"'))
    result = project.runpytest_inprocess("wrong.xosc")
    result.stdout.fnmatch_lines(["*wrong.xosc:*Egon*Ego*"])


def test_scenarios_beside_the_tests_of_a_plain_run_are_not_collected(pytester: pytest.Pytester) -> None:
    write_scenario(pytester.path)
    assert pytester.runpytest_inprocess().ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_folders_of_the_ini_file_are_collected(pytester: pytest.Pytester) -> None:
    write_scenario(pytester.path / "scenarios")
    write_scenario(pytester.path / "elsewhere")
    pytester.makeini("[pytest]\ndvp_scenarios = scenarios")
    result = pytester.runpytest_inprocess("--collect-only", "-q")
    assert [line for line in result.outlines if "::dt" in line] == ["scenarios/good.xosc::dt"]


@pytest.mark.parametrize(
    ("scenarios", "runs"), [("scenarios", "scenarios"), ("drives/scenarios", "drives"), ("runs/scenarios", None)]
)
def test_a_runs_folder_that_hides_the_scenarios_is_one_line(
    pytester: pytest.Pytester, scenarios: str, runs: str | None
) -> None:
    write_scenario(pytester.path / scenarios)
    pytester.makeini(f"[pytest]\ndvp_scenarios = {scenarios}\n" + (f"dvp_runs = {runs}" if runs else ""))
    result = pytester.runpytest_inprocess()
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"*runs *{runs or 'runs'}: *, and ini dvp_scenarios *{scenarios} is in it; *"])


def test_testpaths_do_not_count_as_named_by_the_user(pytester: pytest.Pytester) -> None:
    write_scenario(pytester.path / "tests")
    pytester.makeini("[pytest]\ntestpaths = tests")
    assert pytester.runpytest_inprocess().ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_one_item_can_be_named(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("good.xosc::dt")
    result.assert_outcomes(passed=1)


@pytest.mark.parametrize(("expression", "items"), [("good", 3), ("good and dt", 1), ("not bad", 3)])
def test_k_selects_by_file_and_stage(project: pytest.Pytester, expression: str, items: int) -> None:
    result = project.runpytest_inprocess("--collect-only", "-q", "-k", expression, ".")
    assert sum("::" in line for line in result.outlines) == items


@pytest.mark.parametrize("stage", ["dt", "pe", "rw"])
def test_m_selects_a_stage(project: pytest.Pytester, stage: str) -> None:
    result = project.runpytest_inprocess("--collect-only", "-q", "-m", stage, ".")
    name = stage if stage == "dt" else f"{stage}-surrogate"
    assert [line for line in result.outlines if "::" in line] == [f"bad.xosc::{name}", f"good.xosc::{name}"]


def test_collecting_starts_no_simulator(project: pytest.Pytester) -> None:
    probe = "import sys\ndef pytest_sessionfinish():\n    assert not {'libsumo', 'pymunk'} & set(sys.modules)\n"
    project.makepyfile(probe=probe)
    result = project.runpytest_subprocess("--collect-only", "-q", "-p", "probe", ".")
    assert result.ret == pytest.ExitCode.OK


def test_names_hold_no_brackets_and_last_failed_finds_them(project: pytest.Pytester) -> None:
    project.makeini("[pytest]\naddopts = --strict-markers -W error")
    project.runpytest_inprocess(".").assert_outcomes(passed=1, failed=1, skipped=4)
    again = project.runpytest_inprocess("--lf", ".")
    again.assert_outcomes(failed=1)
    assert "[" not in "".join(line for line in project.runpytest_inprocess("--co", "-q", ".").outlines if "::" in line)


def test_the_order_does_not_depend_on_the_file_system(pytester: pytest.Pytester) -> None:
    for name in ("b.xosc", "c.xosc", "a.xosc"):
        write_scenario(pytester.path, name)
    result = pytester.runpytest_inprocess("--collect-only", "-q", "-m", "dt", ".")
    assert [line for line in result.outlines if "::" in line] == ["a.xosc::dt", "b.xosc::dt", "c.xosc::dt"]


def test_a_scenario_without_storyboard_is_passed_over(tmp_path: Path, pytester: pytest.Pytester) -> None:
    write_scenario(pytester.path)
    (pytester.path / "vehicles.xosc").write_text(CATALOG)
    result = pytester.runpytest_inprocess("--collect-only", "-q", ".")
    assert sum("::" in line for line in result.outlines) == 3


@pytest.mark.parametrize("workers", [(), pytest.param(("-n", "2"), marks=pytest.mark.nightly)])
def test_a_broken_scenario_does_not_stop_the_others_but_a_broken_test_does(
    project: pytest.Pytester, workers: tuple[str, ...]
) -> None:
    (project.path / "cut.xosc").write_text(XOSC[:900])
    run = project.runpytest_subprocess if workers else project.runpytest_inprocess
    result = run("-m", "dt", *workers, ".")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.assert_outcomes(passed=1, failed=1, errors=1, deselected=0 if workers else 4)
    if not workers:
        project.makepyfile(test_broken="import no_such_module_of_ours")
        result = run("-m", "dt", ".")
        assert result.ret == pytest.ExitCode.INTERRUPTED
        result.assert_outcomes(errors=2, deselected=4)


def test_the_runs_folder_is_not_collected_but_a_variant_in_it_can_be_named(project: pytest.Pytester) -> None:
    write_scenario(project.path / "runs" / "variants", "kept.xosc")
    found = project.runpytest_inprocess("--collect-only", "-q", "-m", "dt", ".").outlines
    assert [line for line in found if "::" in line] == ["bad.xosc::dt", "good.xosc::dt"]
    found = project.runpytest_inprocess("--collect-only", "-q", "-m", "dt", "runs/variants/kept.xosc").outlines
    assert [line for line in found if "::" in line] == ["runs/variants/kept.xosc::dt"]
