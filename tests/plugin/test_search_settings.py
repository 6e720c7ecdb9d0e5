"""Settings of Hypothesis for tests whose examples are runs."""

from __future__ import annotations

import pytest

SEARCH = """
from hypothesis import given, settings, strategies as st


@given(x=st.none())
def test_as_it_comes(run, x):
    pass


@settings(deadline=500)
@given(x=st.none())
def test_of_its_own(run, x):
    pass


def test_deadlines():
    for test in (test_as_it_comes, test_of_its_own):
        print("deadline", test.__name__, test._hypothesis_internal_use_settings.deadline)
"""


@pytest.mark.parametrize(("profile", "as_it_comes"), [("default", "None"), ("mine", "0:00:03")])
def test_a_deadline_that_nobody_set_is_none(pytester: pytest.Pytester, profile: str, as_it_comes: str) -> None:
    # In a process of its own: profiles are global, and on CI Hypothesis begins with another one.
    pytester.makeconftest(
        "from hypothesis import settings\n"
        "settings.register_profile('mine', settings.get_profile('default'), deadline=3000)\n"
        f"settings.load_profile({profile!r})\n"
    )
    pytester.makepyfile(SEARCH)
    result = pytester.runpytest_subprocess("-s", "-p", "no:cacheprovider", "-k", "deadlines")
    result.assert_outcomes(passed=1, deselected=2)
    result.stdout.fnmatch_lines(
        [f"*deadline test_as_it_comes {as_it_comes}", "deadline test_of_its_own 0:00:00.500000"]
    )
