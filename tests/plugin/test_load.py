"""The plugin costs nothing when it is not used, and gives way when it is not wanted."""

from __future__ import annotations

import pytest

from tests.plugin.conftest import write_scenario

HEAVY = ("numpy", "scipy", "pandas", "numba", "lxml", "hypothesis", "libsumo", "pymunk", "mcap", "plotly", "jinja2")

PROBE = f"""
import sys

def pytest_sessionfinish(session):
    loaded = [name for name in {HEAVY!r} if name in sys.modules]
    ours = [name for name in sys.modules if name.split(".")[0] in ("openscenario", "vehicle", "ads", "reports")]
    assert not loaded and not ours, (loaded, ours)
"""


@pytest.mark.parametrize("arguments", [(), ("--collect-only",), ("--markers",)])
def test_a_run_without_scenarios_imports_nothing_heavy(pytester: pytest.Pytester, arguments: tuple[str, ...]) -> None:
    pytester.makepyfile(probe=PROBE, test_plain="def test_plain(): pass")
    result = pytester.runpytest_subprocess("-p", "probe", *arguments)
    assert result.ret == pytest.ExitCode.OK
    assert "AssertionError" not in result.stderr.str() + result.stdout.str()


def test_the_plugin_can_be_switched_off(pytester: pytest.Pytester) -> None:
    pytester.makepyfile("def test_plain(run): pass")
    result = pytester.runpytest_subprocess("-p", "no:dvp")
    result.stdout.fnmatch_lines(["*fixture 'run' not found*"])


def test_markers_are_registered(pytester: pytest.Pytester) -> None:
    result = pytester.runpytest_inprocess("--markers")
    result.stdout.fnmatch_lines(["@pytest.mark.dt: *", "@pytest.mark.pe: *", "@pytest.mark.rw: *"])


def test_every_option_has_an_ini_twin(pytester: pytest.Pytester) -> None:
    text = pytester.runpytest_inprocess("--help").stdout.str()
    options = {word for word in text.replace("=", " ").split() if word.startswith("--dvp-")}
    missing = [option for option in options if option[2:].replace("-", "_") not in text]
    assert options
    assert missing == []


@pytest.mark.nightly
def test_a_run_in_a_plain_test_does_not_load_hypothesis(pytester: pytest.Pytester) -> None:
    write_scenario(pytester.path)
    pytester.makepyfile(
        """
        import sys

        def test_it(run, gate):
            gate(run("good.xosc", log_dir=None))
            assert "hypothesis" not in sys.modules
        """
    )
    pytester.runpytest_subprocess().assert_outcomes(passed=1)
