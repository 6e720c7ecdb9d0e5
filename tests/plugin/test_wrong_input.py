"""Wrong input costs one clear line and leaves nothing behind: no traceback, no run folder, not even a part of one."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

# See conftest.py: what inner sessions would import must be here before them.
import ads.stack  # noqa: F401
import pytest_dvp.drive.preparation
import pytest_dvp.drive.sumo_traffic
import pytest_dvp.plugin.scenario_strategy  # noqa: F401
import vehicle.twin  # noqa: F401
from pytest_dvp.cli.command_line import main
from pytest_dvp.drive.stage_checks import check_hidden
from pytest_dvp.drive.stages import StageError
from tests.plugin.conftest import XOSC, write_scenario

NAN_SPEED = XOSC.replace('AbsoluteTargetSpeed value="$ego_speed"', 'AbsoluteTargetSpeed value="NaN"')
FLAT_CAR = XOSC.replace('positionX="2.36"', 'positionX="0"')
UNKNOWN_ENTITY = XOSC.replace('<Private entityRef="Ego">', '<Private entityRef="Egon">')
UNKNOWN_METRIC = '[[gate]]\nmetric = "max_ttc_invers"\nmax = 1.0\n'
NAN_THRESHOLD = '[[gate]]\nmetric = "max_ttc_inverse"\nmax = nan\n'
ZERO_WHEELBASE = '[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 0.0\n'


def line_of(text: str, part: str) -> int:
    return next(i for i, line in enumerate(text.splitlines(), 1) if part in line)


@dataclasses.dataclass(frozen=True)
class Wrong:
    """A wrong input: files beside x.xosc, options (`--NAME`), exit code of dvp, and what its line must say."""

    code: int
    says: tuple[str, ...]
    xosc: str | None = XOSC
    files: dict[str, str] = dataclasses.field(default_factory=dict)
    options: tuple[str, ...] = ()


CASES = {
    "missing-file": Wrong(2, ("x.xosc",), xosc=None),
    "no-xml": Wrong(1, ("x.xosc:1:", "XML"), xosc="this is no XML"),
    "unknown-entity": Wrong(
        1, (f"x.xosc:{line_of(UNKNOWN_ENTITY, 'Egon')}:", "'Egon'", "did you mean 'Ego'?"), UNKNOWN_ENTITY
    ),
    "nan-speed": Wrong(1, (f"x.xosc:{line_of(NAN_SPEED, 'NaN')}:", "AbsoluteTargetSpeed@value", "finite"), NAN_SPEED),
    "nan-speed-set": Wrong(2, ("ego_speed", "nan"), options=("--set", "ego_speed=nan")),
    "zero-wheelbase-of-the-model": Wrong(
        1, ("m.toml:4:", "wheelbase", "found 0"), files={"m.toml": ZERO_WHEELBASE}, options=("--model", "m.toml")
    ),
    "zero-wheelbase-of-the-scenario": Wrong(
        1, (f"x.xosc:{line_of(FLAT_CAR, '<FrontAxle')}:", "FrontAxle", "positionX"), FLAT_CAR
    ),
    "unknown-metric": Wrong(
        1, ("x.gates.toml:2:", "max_ttc_invers", "'max_ttc_inverse'"), files={"x.gates.toml": UNKNOWN_METRIC}
    ),
    "nan-threshold": Wrong(1, ("x.gates.toml:3:", "max", "finite"), files={"x.gates.toml": NAN_THRESHOLD}),
    "unknown-parameter": Wrong(2, ("ego_sped", "'ego_speed'"), options=("--set", "ego_sped=3")),
    "unknown-stack-parameter": Wrong(2, ("LQR_q1", "'LQR_q11'"), options=("--set", "P.LQR_q1=3")),
    "outside-its-constraint": Wrong(2, ("ego_speed", "100", "2.0", "6.0"), options=("--set", "ego_speed=100")),
}
NAMES = tuple(CASES)


@pytest.fixture
def written(pytester: pytest.Pytester) -> Callable[[str], Wrong]:
    """Writes a case into the current folder, which is a rootdir of its own."""
    pytester.makeini("[pytest]\naddopts = --strict-config -W error -p no:cacheprovider")

    def write(name: str) -> Wrong:
        wrong = CASES[name]
        write_scenario(pytester.path, "x.xosc", wrong.xosc or "")
        if wrong.xosc is None:
            (pytester.path / "x.xosc").unlink()
        for file, text in wrong.files.items():
            (pytester.path / file).write_text(text)
        return wrong

    return write


def left_behind(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*") if "runs" in path.parts or path.suffix in (".mcap", ".part"))


@pytest.mark.parametrize("name", NAMES)
def test_dvp_run_says_one_line_and_leaves_nothing(
    name: str, written: Callable[[str], Wrong], pytester: pytest.Pytester, capsys: pytest.CaptureFixture[str]
) -> None:
    wrong = written(name)
    code = main(["run", "x.xosc", *wrong.options])
    out, err = capsys.readouterr()
    complaint = [line for line in err.splitlines() if not line.startswith("dvp run: ")]  # its own line of progress
    assert (code, out, len(complaint)) == (wrong.code, "", 1), err
    assert [part for part in wrong.says if part not in complaint[0]] == [], complaint[0]
    assert left_behind(pytester.path) == []


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.nightly(by_day=3)
def test_pytest_says_it_too_and_leaves_nothing(
    name: str, written: Callable[[str], Wrong], pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong = written(name)
    monkeypatch.setenv("COLUMNS", "250")
    options = [word.replace("--", "--dvp-", 1) if word.startswith("--") else word for word in wrong.options]
    result = pytester.runpytest_inprocess("x.xosc", "-m", "dt", *options)
    said = result.stdout.str() + result.stderr.str()
    assert result.ret in (pytest.ExitCode.TESTS_FAILED, pytest.ExitCode.INTERRUPTED, pytest.ExitCode.USAGE_ERROR)
    clear = [line for line in said.splitlines() if all(part in line for part in wrong.says)]
    assert clear != [], said
    assert "Traceback" not in said
    assert "pytest_dvp/" not in said  # no line of ours: the file named is the user's
    assert left_behind(pytester.path) == []


def test_a_process_of_its_own_ends_with_the_same_code_and_line(tmp_path: Path) -> None:
    write_scenario(tmp_path, "x.xosc", UNKNOWN_ENTITY)
    command = [sys.executable, "-m", "pytest_dvp.cli", "run", "x.xosc"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.splitlines()[-1].startswith(f"x.xosc:{line_of(UNKNOWN_ENTITY, 'Egon')}: error ")
    assert left_behind(tmp_path) == []


def test_json_is_one_document_also_for_wrong_input(
    written: Callable[[str], Wrong], capsys: pytest.CaptureFixture[str]
) -> None:
    written("unknown-entity")
    assert main(["run", "x.xosc", "--json"]) == 1
    (document,) = capsys.readouterr().out.splitlines()
    assert '"line": ' in document
    assert "Egon" in document


@pytest.mark.parametrize(
    ("call", "says"),
    [
        ('run("x.xosc", parameters={"ego_sped": 3})', "'ego_sped'"),
        ('run("nowhere.xosc")', "no scenario nowhere.xosc; looked in"),
        ('run("x.xosc", ads="referense")', "did you mean 'reference'?"),
    ],
)
def test_a_mistake_in_a_test_shows_the_line_of_the_test_and_none_of_ours(
    call: str, says: str, written: Callable[[str], Wrong], pytester: pytest.Pytester
) -> None:
    written("unknown-parameter")
    pytester.makepyfile(test_mine=f"def test_it(run):\n    {call}")
    result = pytester.runpytest_inprocess("test_mine.py")
    result.assert_outcomes(failed=1)
    shown = result.stdout.str()
    assert f">       {call}" in shown.replace(">   ", ">       ") or call in shown
    assert says in shown
    assert "session.py" not in shown
    assert "def _run" not in shown


def test_a_value_out_of_range_blames_the_option(written: Callable[[str], Wrong], pytester: pytest.Pytester) -> None:
    written("outside-its-constraint")
    result = pytester.runpytest_inprocess("x.xosc", "-m", "dt", "--dvp-set", "ego_speed=100")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --dvp-set ego_speed: found 100; allowed: >= 2.0 and <= 6.0"])


def test_an_unknown_stack_is_a_usage_error(written: Callable[[str], Wrong], pytester: pytest.Pytester) -> None:
    written("unknown-parameter")
    result = pytester.runpytest_inprocess("x.xosc", "--dvp-ads", "referense")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: --dvp-ads: unknown ADS 'referense', did you mean 'reference'?*"])


@pytest.mark.nightly
def test_what_checks_a_folder_finds_our_packages_whatever_stands_beside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """`dvp check FOLDER` asks a process of its own, and `python -m` would put the current folder first."""
    write_scenario(tmp_path, "s.xosc")
    (tmp_path / "vehicle").mkdir()
    (tmp_path / "vehicle" / "__init__.py").touch()
    monkeypatch.chdir(tmp_path)
    assert main(["check", "."]) == 0
    assert "s.xosc: runs" in capfd.readouterr().err


def test_a_car_of_its_own_finds_our_packages_whatever_stands_beside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "vehicle").mkdir()
    (tmp_path / "vehicle" / "__init__.py").touch()
    (tmp_path / "hidden.toml").write_text("[hidden.brake_gain]\ng = 0.8\n")
    monkeypatch.chdir(tmp_path)
    check_hidden(f"surrogate:{tmp_path / 'hidden.toml'}")
    (tmp_path / "hidden.toml").write_text("[hidden.brake_gane]\ng = 0.8\n")
    with pytest.raises(StageError, match="brake_gain"):
        check_hidden(f"surrogate:{tmp_path / 'hidden.toml'}")


def test_a_misspelt_scenario_of_a_test_is_told_with_the_nearest_and_where_it_was_looked_for(
    pytester: pytest.Pytester,
) -> None:
    pytester.makeini("[pytest]\naddopts = -p no:cacheprovider")
    write_scenario(pytester.path, "crossing.xosc")
    pytester.makepyfile("def test_it(run):\n    run('crosing.xosc')\n")
    said = pytester.runpytest_inprocess().stdout.str()
    assert f"no scenario crosing.xosc; looked in {pytester.path}; did you mean 'crossing.xosc'?" in said


@pytest.mark.parametrize(
    ("only", "told"),
    [
        ('["oncoming_sped"]', "x.xosc: unknown parameter 'oncoming_sped'"),
        ('"ego_speed"', "only: found 'ego_speed', expected a list of names: only=['ego_speed']"),
    ],
)
def test_a_wrong_parameter_of_a_search_is_one_line(pytester: pytest.Pytester, only: str, told: str) -> None:
    """Without the frames of Hypothesis, which validates the strategy before the test begins."""
    write_scenario(pytester.path, "x.xosc")
    pytester.makepyfile(
        f"""
        from hypothesis import given
        from pytest_dvp import scenario_variants


        @given(variant=scenario_variants("x.xosc", only={only}))
        def test_search(run, variant):
            run(variant)
        """
    )
    said = pytester.runpytest_inprocess("-q", "-p", "no:cacheprovider").stdout.str()
    assert told in said
    assert "another exception" not in said
    assert "hypothesis/" not in said


def test_a_value_of_the_session_for_what_a_search_varies_is_refused(pytester: pytest.Pytester) -> None:
    """A variant holds no nominal values; the session's value would be driven in their place, and another one told."""
    write_scenario(pytester.path, "x.xosc")
    pytester.makepyfile(
        """
        from hypothesis import given, settings
        from pytest_dvp import scenario_variants


        @settings(max_examples=1, database=None)
        @given(variant=scenario_variants("x.xosc"))
        def test_search(run, variant):
            run(variant)
        """
    )
    result = pytester.runpytest_inprocess("-q", "-p", "no:cacheprovider", "--dvp-set", "ego_speed=3")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["E*SettingError: --dvp-set ego_speed: the test varies it"])
