"""The summary of our own suite is short: one line for all tests of a folder that are skipped for one reason."""

from __future__ import annotations

import pytest

NO_BROWSER = """
import pytest

@pytest.fixture
def browser():
    pytest.skip("no browser")

def test_a(browser):
    pass

def test_b(browser):
    pass

@pytest.mark.skip(reason="no roscore")
def test_c():
    pass
"""


@pytest.mark.parametrize("workers", [0, 2])
def test_skips_of_a_folder_take_one_line_a_reason(pytester: pytest.Pytester, workers: int) -> None:
    pytester.makeconftest("from tests.conftest import pytest_terminal_summary")
    one, other = (pytester.mkdir(name) for name in ("one", "other"))
    (one / "test_x.py").write_text(NO_BROWSER)
    (one / "test_y.py").write_text(NO_BROWSER.replace("no roscore", "no compiler"))
    (other / "test_z.py").write_text("import pytest\n\ndef test_d():\n    pytest.skip('no browser')\n")
    result = pytester.runpytest_inprocess("-rs", "--import-mode=importlib", *(["-n", str(workers)] * bool(workers)))
    result.assert_outcomes(skipped=7)
    assert sorted(line for line in result.outlines if line.startswith("SKIPPED")) == [
        "SKIPPED [1] one/test_x.py: no roscore",
        "SKIPPED [1] one/test_y.py: no compiler",
        "SKIPPED [1] other/test_z.py: no browser",
        "SKIPPED [4] one: no browser",
    ]
