"""One field of RunSpec declares an option of a run: every way to set it, to repeat it and to read about it follows."""

from __future__ import annotations

import dataclasses
import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from pytest_dvp.drive.chosen_stack import Ads
from pytest_dvp.drive.deadline import TICK_LIMIT
from pytest_dvp.drive.option import LISTS
from pytest_dvp.drive.replay_words import COMPARISON
from pytest_dvp.drive.replay_words import RUN as REPEATED
from pytest_dvp.drive.request import KEYWORDS, UnknownKeyword, request_of, spec_of
from pytest_dvp.drive.result import replay_command
from pytest_dvp.drive.run import run
from pytest_dvp.drive.run_options import RunOptions
from pytest_dvp.drive.run_spec import OPTIONS, RunSpec
from scripts.make_run_options import PAGE, RUN, TYPES, page, run_with_docstring, types
from tests.unit.harness.option_values import OF_A_RUN, changed, dvp_run, texts_of, words

OF_SEVERAL_RUNS = {"stage-gates", "cases"}  # they are no keywords of run(), which drives once
NOT_REPEATED = {
    "stage-logs": "says what a drive is compared with, not how it goes",
    "stage-gates": "the same",
    "cases": "the case is repeated by its values",
    "wall-limit": "ends a run early by an ERROR",
    "arming": "a key is used up: a human gives the next one",
    "require-real": "refuses a run and changes none",
    "runs": "where a result is written",
    "truth": "where the truth is written",
    "single-file": "how a result is written",
}

NOT_REHEARSED = {
    "stage": "the twin rehearses, on stage dt",
    "ads": "a stack that is one object keeps its state for the car",
    "wall-limit": "of the drive itself",
    "stack-process": "the stack is chosen already",
    "compute-delay": "of the twin alone: a car has its own time",
    "cases": "one case is driven",
    "stage-gates": "nothing is compared",
    "stage-logs": "the same",
    "runs": "nothing is written",
    "single-file": "the same",
    "folder-name": "the same",
    "gated": "of the twin alone",
}


@pytest.fixture
def by_dvp(tmp_path: Path) -> RunSpec:
    """All options given to `dvp run`."""
    texts = texts_of(tmp_path)
    return dvp_run(words({one.name: texts[one.name] for one in OF_A_RUN}, "--"))


def test_each_option_of_a_run_is_one_of_dvp_run(by_dvp: RunSpec) -> None:
    assert changed(by_dvp) == {one.name for one in OF_A_RUN}


def test_each_option_of_one_run_is_a_keyword_of_run(by_dvp: RunSpec) -> None:
    keywords = by_dvp.keywords()
    request = request_of(Path("x.xosc"), {**keywords, "ads": None})
    told = changed(request.spec) | ({"set"} if request.parameters == {"a": "1"} else set())
    told |= {"ads"} if keywords["ads"] == by_dvp.ads else set()
    assert told == {one.name for one in OF_A_RUN} - OF_SEVERAL_RUNS
    assert {keyword for setting in OPTIONS for keyword, *_ in setting.keywords} == set(RunOptions.__annotations__)


def test_each_option_is_repeated_by_the_printed_command_or_there_is_a_reason(by_dvp: RunSpec) -> None:
    asked = request_of(Path("x.xosc"), {**by_dvp.keywords(), "stage": "pe", "ads": None})
    asked = dataclasses.replace(asked, ads=Ads("Class", by_dvp.ads, None))
    repeated = {word[2:] for word in shlex.split(replay_command(asked)) if word.startswith("--")}
    assert {one.name for one in OF_A_RUN} - repeated == set(NOT_REPEATED)


def test_each_option_that_counts_on_the_twin_is_rehearsed_or_there_is_a_reason(by_dvp: RunSpec) -> None:
    told = request_of(Path("x.xosc"), {**by_dvp.keywords(), "stage": "pe", "ads": None}).rehearsal()
    of_the_twin = {one.name for one in OPTIONS if "dt" in one.stages and one.home in ("run", "python")}
    rehearsed = {KEYWORDS[keyword].name for keyword in told}
    assert of_the_twin - rehearsed == set(NOT_REHEARSED)
    assert rehearsed <= of_the_twin
    assert (told["duration"], told["model"], told["parameters"]) == (by_dvp.duration, by_dvp.model, {"a": "1"})


def test_the_printed_command_gives_the_same_options(by_dvp: RunSpec) -> None:
    asked = request_of(Path("x.xosc"), {**by_dvp.keywords(), "stage": "pe", "ads": None})
    asked = dataclasses.replace(asked, ads=Ads("Class", by_dvp.ads, None))
    again = dvp_run(shlex.split(replay_command(asked))[3:])
    names = [one.key for one in OF_A_RUN if one.name not in NOT_REPEATED]
    assert {name: getattr(again, name) for name in names} == {name: getattr(by_dvp, name) for name in names}


def test_a_wrong_keyword_names_the_nearest() -> None:
    with pytest.raises(TypeError, match=r"unknown option of run\(\) 'sead', did you mean 'seed'\?"):
        run("x.xosc", sead=3)  # type: ignore[call-arg]
    assert issubclass(UnknownKeyword, ValueError)  # a user's mistake, told in one line


@pytest.mark.parametrize(
    ("keywords", "values"),
    [
        ({"model": "m.toml", "dbc": "c.dbc"}, {"model": Path("m.toml"), "dbc": Path("c.dbc")}),
        ({"passed": ["a"], "log_dir": "runs"}, {"stage_logs": (Path("a"),), "runs": Path("runs")}),
        ({"effects": ["e.py"], "library": [Path("l")]}, {"effects": (Path("e.py"),), "library": (Path("l"),)}),
        ({"model": None, "seed": 4, "gated": True}, {"model": None, "seed": 4, "gated": True}),
    ],
)
def test_keywords_become_the_values_of_the_fields(keywords: dict[str, Any], values: dict[str, Any]) -> None:
    assert spec_of(keywords) == RunSpec(**values)


def test_what_is_generated_is_what_the_fields_say() -> None:
    again = "python -m scripts.make_run_options"
    assert TYPES.read_text(encoding="utf-8") == types(), again
    assert RUN.read_text(encoding="utf-8") == run_with_docstring(RUN.read_text(encoding="utf-8")), again
    assert PAGE.read_text(encoding="utf-8") == page(), again


def test_the_docstring_names_every_keyword() -> None:
    told = {line.split()[0] for line in str(run.__doc__).splitlines() if line.strip()}
    assert set(RunOptions.__annotations__) <= told


def test_the_limit_of_a_tick_is_that_of_the_stack_host() -> None:
    assert RunSpec().tick_limit == TICK_LIMIT


RUN_ORDER = """seed stage vehicle dbc fault clock envelope ads set model gates effects library reading ego compute-delay
stack-process tick-limit duration after-collision"""
COMPARISON_ORDER = """seed vehicle fault clock ads set dbc model gates stage-gates stage-logs effects library ego
duration reading stack-process tick-limit after-collision"""


def test_the_words_of_a_repeating_command_keep_their_order() -> None:
    """The command stands in result.json, and `dvp replay` and users read it there: a new option goes to the end."""
    for settings, order in ((REPEATED, RUN_ORDER.split()), (COMPARISON, COMPARISON_ORDER.split())):
        assert [one.name for one in settings][: len(order)] == order


def test_no_option_has_the_place_of_another() -> None:
    for places in ([one.replay for one in OPTIONS], [one.compared for one in OPTIONS]):
        given = [place for place in places if place]
        assert len(given) == len(set(given))


def test_lists_are_given_by_repeating_the_option() -> None:
    assert {one.name for one in OPTIONS if one.kind in LISTS} >= {"set", "effects", "library", "stage-logs"}
    assert [path.name for path in dvp_run([f"--library={Path.cwd()}", f"--library={Path.cwd().parent}"]).library] == [
        Path.cwd().name,
        Path.cwd().parent.name,
    ]


ONE_MORE_LINE = """
import sys, types
import pytest, pytest_dvp.drive
from pathlib import Path

name, before = "pytest_dvp.drive.run_spec", "    origins: Mapping"
file = Path(pytest_dvp.drive.__file__).with_name("run_spec.py")
line = '    wind: float = option("float", 0.0, "speed of the wind", "M/S", 0.0, unit="m/s", replay=300)\\n'
source = file.read_text(encoding="utf-8")
assert source.count(before) == 1
module = sys.modules[name] = types.ModuleType(name)
exec(compile(source.replace(before, line + before), str(file), "exec"), module.__dict__)
plugins = ["-p", "pytest_dvp.plugin.hooks", "-p", "no:cacheprovider"]
sys.exit(pytest.main(["-q", *plugins, "--dvp-wind=2.5", "test_wind.py"]))
"""
TRIED = """
import argparse
from pathlib import Path
import pytest
from pytest_dvp.cli.run import add_arguments
from pytest_dvp.cli.shared.arguments import settings_from
from pytest_dvp.drive.request import request_of
from pytest_dvp.drive.result import replay_command
from pytest_dvp.drive.run_spec import OF_A_RUN
from pytest_dvp.plugin.item_notes import settings_of
from scripts.make_run_options import docstring, page, types

def by_dvp(*arguments):
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return settings_from(parser.parse_args(["x.xosc", *arguments]), ini=OF_A_RUN).wind

def test_wind(request, monkeypatch, tmp_path):
    assert settings_of(request.config).wind == 2.5
    monkeypatch.chdir(tmp_path)
    assert (by_dvp(), by_dvp("--wind", "3")) == (0.0, 3.0)
    Path("pytest.ini").write_text("[pytest]\\ndvp_wind = 5")
    assert by_dvp() == 5.0
    monkeypatch.setenv("DVP_WIND", "4")
    assert by_dvp() == 4.0
    asked = request_of(Path("x.xosc"), {"wind": 6.0})
    assert asked.spec.wind == 6.0
    assert " --wind 6" in replay_command(asked)
    assert settings_of(request.config).keywords()["wind"] == 2.5
    assert "| `--wind` | `--dvp-wind` | `dvp_wind` | `DVP_WIND` | `wind` | m/s | 0 | number >= 0 |" in page()
    assert "    wind: float\\n" in types()
    assert "    wind             speed of the wind; default: 0\\n" in docstring()
    with pytest.raises(ValueError, match="--wind is -1, expected a number >= 0"):
        by_dvp("--wind", "-1")
"""


@pytest.mark.nightly
def test_one_more_line_is_one_more_option(tmp_path: Path) -> None:
    (tmp_path / "test_wind.py").write_text(TRIED)
    alone = {"PYTHONPATH": str(Path(__file__).parents[3]), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    environment = {**os.environ, **alone}
    asked = [sys.executable, "-c", ONE_MORE_LINE]
    tried = subprocess.run(asked, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert tried.returncode == 0, tried.stdout + tried.stderr
