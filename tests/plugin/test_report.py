"""What a session says: verdicts, reasons, numbers for JUnit, annotations for GitHub."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from tests.plugin.conftest import FAKE_RUN, write_scenario


def test_pe_and_rw_are_skipped_unless_asked_for(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("-rs", "good.xosc")
    result.assert_outcomes(passed=1, skipped=2)
    result.stdout.fnmatch_lines(["SKIPPED*ask for it with -m pe"])


@pytest.mark.parametrize(
    "asked", [("-m", "rw", "good.xosc"), ("-k", "good and rw", "good.xosc"), ("good.xosc::rw-surrogate",)]
)
def test_rw_runs_when_asked_for(project: pytest.Pytester, asked: tuple[str, ...]) -> None:
    project.runpytest_inprocess(*asked).assert_outcomes(passed=1, deselected=0 if len(asked) == 1 else 2)


def test_the_short_summary_says_why(project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    result = project.runpytest_inprocess("bad.xosc")
    result.stdout.fnmatch_lines(["FAILED bad.xosc::dt - max_ttc_inverse 1.31 1/s > 1.00 at t=7.42 s (Target)"])


def test_a_failure_ends_with_the_command_to_replay(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("bad.xosc", "-rN", "-p", "no:terminalreporter")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    shown = project.runpytest_inprocess("bad.xosc")
    shown.stdout.fnmatch_lines(["*gate x.toml:3*", "*replay: dvp run bad.xosc --seed 7"])
    assert "Traceback" not in shown.stdout.str()


def test_the_section_shows_the_worst_margin_first_and_ends_with_an_action(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess(".")
    lines = result.outlines
    start = next(i for i, line in enumerate(lines) if line.strip("= ") == "dvp")
    assert lines[start + 1] == "2 runs, 2 gates: 1 FAIL, 1 PASS"
    assert lines[start + 2].startswith("FAIL         bad.xosc::dt")
    assert lines[start + 3].startswith("PASS         good.xosc::dt")
    assert lines[start + 4] == "replay the worst: dvp run bad.xosc --seed 7"


def test_a_session_without_scenarios_says_nothing_of_dvp(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("def test_one(): pass")
    result = pytester.runpytest_inprocess()
    result.stdout.no_fnmatch_line("*dvp:*")
    result.stdout.no_fnmatch_line("= dvp =")


def test_the_header_tells_the_conditions(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("good.xosc", "--dvp-seed", "11")
    result.stdout.fnmatch_lines(
        ["dvp: 1 scenario, stage dt, pe, rw, vehicle twin, surrogate, ADS reference, seed 11, model tabby_evo.toml"]
    )


@pytest.mark.parametrize("workers", [(), *([("-n", "2")] if "DVP_NIGHTLY" in os.environ else [])])
def test_numbers_reach_junit(project: pytest.Pytester, workers: tuple[str, ...]) -> None:
    run = project.runpytest_subprocess if workers else project.runpytest_inprocess
    run("--junitxml=out.xml", *workers, ".")
    cases = {
        case.get("classname"): case
        for case in ET.parse(project.path / "out.xml").iter("testcase")
        if case.get("name") == "dt"
    }
    properties = {p.get("name"): p.get("value") for p in cases["bad.xosc"].iter("property")}
    assert properties["max_ttc_inverse"] == "1.31"
    assert properties["verdict"] == "FAIL"
    passed = {p.get("name"): p.get("value") for p in cases["good.xosc"].iter("property")}
    gate = {key: passed[f"max_ttc_inverse.{key}"] for key in ("value", "unit", "bound", "margin")}
    assert gate == {"value": "0.25", "unit": "1/s", "bound": "1.0", "margin": "0.75"}
    assert (passed["seed"], passed["replay"]) == ("7", "dvp run good.xosc --seed 7")


def test_results_survive_workers_and_are_told_once(
    project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    table = tmp_path / "summary.md"
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(table))
    result = project.runpytest_subprocess("-n", "2", ".")
    result.assert_outcomes(passed=1, failed=1, skipped=4)
    result.stdout.fnmatch_lines(
        [
            "2 runs, 2 gates: 1 FAIL, 1 PASS",
            "replay the worst: dvp run bad.xosc --seed 7",
            "FAILED bad.xosc::dt - max_ttc_inverse 1.31 1/s > 1.00 at t=7.42 s (Target)",
        ]
    )
    text, output = table.read_text(), result.stdout.str() + result.stderr.str()
    assert [text.count(part) for part in ("### dvp", "| good.xosc | dt |", "| bad.xosc | dt |")] == [1, 1, 1]
    assert output.count("::error file=bad.xosc") == 1


def test_github_gets_an_annotation_at_the_line_and_a_table(
    project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    table = tmp_path / "summary.md"
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(table))
    result = project.runpytest_inprocess(".")
    (line,) = [line for line in result.outlines if line.startswith("::error")]
    assert line.startswith("::error file=bad.xosc,line=40,title=bad.xosc%3A%3Adt::max_ttc_inverse 1.31 1/s > 1.00")
    assert line.endswith("%0Areplay: dvp run bad.xosc --seed 7")
    assert "| bad.xosc | dt | max_ttc_inverse &lt;= 1.00 1/s | FAIL | 1.31 1/s | 1 1/s | -0.31 |" in table.read_text()


def test_a_step_summary_that_cannot_be_written_changes_no_verdict(
    project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(project.path))
    result = project.runpytest_inprocess("-m", "dt", "good.xosc")
    assert result.ret == pytest.ExitCode.OK
    assert f"GITHUB_STEP_SUMMARY {project.path}: cannot be written: Is a directory" in result.outlines


def test_at_most_twenty_lines(project: pytest.Pytester) -> None:
    for k in range(30):
        write_scenario(project.path, f"good{k:02}.xosc")
    lines = project.runpytest_inprocess("-m", "dt", ".").outlines
    start = next(i for i, line in enumerate(lines) if line.strip("= ") == "dvp")
    end = next(i for i, line in enumerate(lines) if line.startswith("replay the worst"))
    assert end - start == 20


def test_a_test_of_ones_own_uses_run_and_gate(project: pytest.Pytester) -> None:
    project.makepyfile(
        """
        def test_good(run, gate):
            gate(run("good.xosc"))

        def test_bad(run, gate):
            gate(run("bad.xosc", seed=3))
        """
    )
    result = project.runpytest_inprocess("test_a_test_of_ones_own_uses_run_and_gate.py")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*- replay -*", "dvp run bad.xosc --seed 3"])


def test_a_missing_gate_never_passes(project: pytest.Pytester) -> None:
    project.makepyfile("def test_it(run, gate): gate(run('good.xosc'), metrics=['tet'])")
    result = project.runpytest_inprocess("test_a_missing_gate_never_passes.py")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*no gate on tet*"])
    result.stdout.fnmatch_lines(["dvp run good.xosc --seed 7 --gate tet"])


def test_a_misspelt_gate_is_told_the_nearest(project: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    project.makepyfile("def test_it(run, gate): gate(run('good.xosc'), metrics=['max_ttc_invers'])")
    result = project.runpytest_inprocess("test_a_misspelt_gate_is_told_the_nearest.py")
    result.stdout.fnmatch_lines(["*no gate on max_ttc_invers; did you mean 'max_ttc_inverse' *"])
    result.stdout.fnmatch_lines(["dvp run good.xosc --seed 7"])  # a replay with the slip in it would be refused


def test_notes_of_runs_are_shown_at_most_five_lines_what_is_not_judged_first(project: pytest.Pytester) -> None:
    notes = [f"x.xosc:{k}: event 'E{k}' never fired" for k in range(8)] + ["not judged: road_departure 1.00 s"]
    project.makeconftest(FAKE_RUN.replace('"set": {}', f'"notes": {notes!r}, "set": {{}}'))
    lines = project.runpytest_inprocess("good.xosc").outlines
    start = next(i for i, line in enumerate(lines) if line.startswith("PASS  "))
    assert lines[start + 1] == "good.xosc::dt: not judged: road_departure 1.00 s"
    assert lines[start + 2] == "good.xosc::dt: x.xosc:0: event 'E0' never fired"
    assert lines[start + 5] == "... 5 more notes"
    assert lines[start + 6].startswith("see it again")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_junit_file_that_a_full_disk_does_not_take_changes_no_verdict(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("-m", "dt", "good.xosc", "bad.xosc", "--junitxml=/dev/full")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    assert "/dev/full: cannot be written: No space left on device" in result.outlines
    result.assert_outcomes(passed=1, failed=1, deselected=4)
    assert any(line.startswith("replay the worst") for line in result.outlines)


def test_an_interrupted_run_ends_the_session_in_one_line(project: pytest.Pytester) -> None:
    project.makepyfile(
        """
        from pytest_dvp.plugin.session import Session

        def test_one(request, monkeypatch):
            def interrupted(*_, **__):
                raise KeyboardInterrupt("x.xosc [dt] interrupted at t=1.00 s; its log so far: runs/0001-x-dt")
            monkeypatch.setattr("pytest_dvp.plugin.session.Session._run", interrupted)
            Session(request.config)("good.xosc")

        def test_two():
            raise AssertionError("the session is over")
        """
    )
    result = project.runpytest_inprocess()
    assert result.ret == pytest.ExitCode.INTERRUPTED
    said = [line for line in result.outlines if "interrupted at" in line]
    assert len(said) == 1
    assert "Exit: dvp: x.xosc [dt] interrupted at t=1.00 s; its log so far: runs/0001-x-dt" in said[0]
    assert not any("Traceback" in line or "session.py" in line for line in result.outlines + result.errlines)
