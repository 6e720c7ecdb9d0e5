"""The summary of our own suite is short: one line for all tests that are skipped for one reason, and ten in all."""

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
def test_skips_take_one_line_a_reason(pytester: pytest.Pytester, workers: int) -> None:
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
        "SKIPPED [5] .: no browser",
    ]


def test_the_rarest_reasons_share_the_tenth_line(pytester: pytest.Pytester) -> None:
    """Twelve reasons, the twelfth of which twelve tests have, the eleventh eleven, and so on."""
    pytester.makeconftest("from tests.conftest import pytest_terminal_summary")
    test = "import pytest\n@pytest.mark.parametrize('k', range({0}))\ndef test_{0}(k):\n    pytest.skip('reason {0}')\n"
    pytester.makepyfile(**{f"test_{n}": test.format(n) for n in range(1, 13)})
    result = pytester.runpytest_inprocess("-rs")
    lines = [line for line in result.outlines if line.startswith("SKIPPED")]
    assert len(lines) == 10
    assert "SKIPPED [12] test_12.py: reason 12" in lines
    assert "SKIPPED [6] .: rarer reasons, which -rs tells for a single file" in lines  # 1 + 2 + 3 tests
