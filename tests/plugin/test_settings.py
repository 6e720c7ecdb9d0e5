"""Settings: where they come from, which wins, and what a wrong one says."""

from __future__ import annotations

import pytest

from tests.plugin.conftest import XOSC, write_scenario

PRINT_SEED = """
from pytest_dvp.plugin.item_notes import settings_of

def test_settings(request):
    settings = settings_of(request.config)
    print("seed", settings.seed, "duration", settings.duration, "set", settings.set.words())
"""


@pytest.fixture
def told(pytester: pytest.Pytester) -> pytest.Pytester:
    pytester.makepyfile(test_told=PRINT_SEED)
    return pytester


def seed(pytester: pytest.Pytester, *arguments: str) -> str:
    result = pytester.runpytest_inprocess("-s", *arguments)
    assert result.ret == pytest.ExitCode.OK
    return next(line for line in result.outlines if "seed" in line).split("seed ")[1]


def test_the_defaults(told: pytest.Pytester) -> None:
    assert seed(told).startswith("7 duration None set []")


def test_an_ini_key_is_read(told: pytest.Pytester) -> None:
    told.makeini("[pytest]\ndvp_seed = 11")
    assert seed(told).startswith("11 ")


def test_the_environment_wins_over_the_ini_file(told: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    told.makeini("[pytest]\ndvp_seed = 11")
    monkeypatch.setenv("DVP_SEED", "12")
    assert seed(told).startswith("12 ")


def test_the_command_line_wins_over_the_environment(told: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DVP_SEED", "12")
    assert seed(told, "--dvp-seed=13").startswith("13 ")


@pytest.mark.parametrize(
    ("arguments", "ini", "alone"),
    [((), "", False), (("--dvp-single-file",), "", True), ((), "dvp_single_file = true", True)],
)
def test_reports_of_one_file_are_asked_for_by_option_and_ini(
    pytester: pytest.Pytester, arguments: tuple[str, ...], ini: str, alone: bool
) -> None:
    pytester.makeini(f"[pytest]\n{ini}")
    told = f"def test_settings(request):\n    assert settings_of(request.config).single_file is {alone}\n"
    pytester.makepyfile(test_told=f"from pytest_dvp.plugin.fixtures import settings_of\n\n{told}")
    pytester.runpytest_inprocess(*arguments).assert_outcomes(passed=1)


def test_assignments_add_up(told: pytest.Pytester) -> None:
    found = seed(told, "--dvp-set=a=1", "--dvp-set=P.LQR_q11=30", "--dvp-set=S.EGO_mass=900")
    assert found.endswith("set ['a=1', 'P.LQR_q11=30', 'S.EGO_mass=900']")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--dvp-seed=x",), "*--dvp-seed is 'x', expected a whole number*"),
        (("--dvp-seed=-1",), "*--dvp-seed is -1, expected a whole number >= 0*"),
        (("--dvp-duration=nan",), "*--dvp-duration is nan, expected a number >= 0.05*"),
        (("--dvp-gates=",), "*--dvp-gates is empty, expected FILE*"),  # of a variable without a value: no gates
        (("--dvp-library=",), "*--dvp-library is empty, expected DIR*"),
        (("--dvp-set=nothing",), "*--dvp-set 'nothing': expected NAME=VALUE*"),
        (("--dvp-library=nowhere",), "*--dvp-library: no folder*nowhere*"),
        (("--dvp-effects=nowhere.py",), "*--dvp-effects: no file*nowhere.py*"),
        (("--dvp-model=nowhere.toml",), "*--dvp-model: no file*nowhere.toml*"),
        (("--dvp-set=P.LQR_q1=30",), "*unknown ADS parameter 'LQR_q1'*LQR_q11*"),
        (("--dvp-set=P.LQR_q11=-1",), "*LQR_q11*outside its range*"),
        (("--dvp-set=P.LQR_q11=abc",), "*LQR_q11 = 'abc' is no number; its range is *0, 10000* 1/m^2*"),
        (("--dvp-set=S.EGO_mas=900",), "*EGO_mass*"),
    ],
)
def test_a_wrong_option_is_a_usage_error(pytester: pytest.Pytester, arguments: tuple[str, ...], message: str) -> None:
    result = pytester.runpytest_inprocess(*arguments)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([message])


def test_a_misspelt_ini_key_names_the_right_one(pytester: pytest.Pytester) -> None:
    pytester.makeini("[pytest]\ndvp_sed = 7")
    result = pytester.runpytest_inprocess()
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*unknown setting 'dvp_sed', did you mean 'dvp_seed'?"])


def test_the_place_of_shared_material_is_no_misspelt_setting(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DVP_SHARED", str(pytester.path))  # nearly DVP_SHARD
    pytester.makepyfile("def test_plain(): pass")
    assert pytester.runpytest_subprocess().ret == pytest.ExitCode.OK


def test_a_misspelt_variable_names_the_right_one(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DVP_SED", "7")
    result = pytester.runpytest_inprocess()
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*unknown setting 'DVP_SED', did you mean 'DVP_SEED'?"])


def test_a_parameter_that_no_scenario_declares_names_the_nearest(project: pytest.Pytester) -> None:
    result = project.runpytest_inprocess("--dvp-set=ego_sped=3", ".")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*unknown parameter 'ego_sped', did you mean 'ego_speed'?"])


def test_a_value_need_not_suit_a_scenario_that_is_deselected(project: pytest.Pytester) -> None:
    """good.xosc allows 2 to 6 m/s; narrow.xosc, which allows 4 to 6, counts only where it is to run."""
    write_scenario(project.path, "narrow.xosc", XOSC.replace('value="2.0"', 'value="4.0"'))
    project.runpytest_inprocess("--dvp-set=ego_speed=3", "-k", "good", "-m", "dt", ".").assert_outcomes(
        passed=1, deselected=8
    )
    result = project.runpytest_inprocess("--dvp-set=ego_speed=3", "-k", "good or narrow", "-m", "dt", ".")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: narrow.xosc: --dvp-set ego_speed: found 3; allowed: >= 4.0 and <= 6.0"])


@pytest.mark.nightly
def test_with_workers_it_fails_the_scenarios_instead(project: pytest.Pytester) -> None:
    result = project.runpytest_subprocess("-n", "1", "--dvp-set=ego_sped=3", ".")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines(["*unknown parameter 'ego_sped', did you mean 'ego_speed'?"])
    assert "INTERNALERROR" not in result.stdout.str()


def test_a_path_behind_an_option_that_pytest_takes_for_its_root_is_told(
    told: pytest.Pytester, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """pytest reads its ini file before it knows our options; in silence it would run nothing and say so in a word."""
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "pytest.ini").write_text("[pytest]\n")
    (elsewhere / "runs").mkdir()
    told.makeini("[pytest]\ndvp_seed = 11")
    result = told.runpytest_inprocess("--dvp-runs", str(elsewhere / "runs"))
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    root = f"pytest takes this path for what to run (root folder {elsewhere}); write --dvp-runs={elsewhere}/runs"
    result.stderr.fnmatch_lines([f"ERROR: --dvp-runs {elsewhere}/runs: {root}"])
    assert seed(told, f"--dvp-runs={elsewhere}/runs").startswith("11 ")
    assert told.runpytest_inprocess("--dvp-runs", str(elsewhere / "runs"), "test_told.py").ret == result.ret
    (told.path / "runs").mkdir()
    assert seed(told, "--dvp-runs", str(told.path / "runs"), "test_told.py").startswith("11 ")
    assert seed(told, "--dvp-runs", "runs").startswith("11 ")
