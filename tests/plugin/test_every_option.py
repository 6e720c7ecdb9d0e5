"""Each option that RunSpec declares is one of pytest, a key of its ini file and an environment variable."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.plugin.item_notes import settings_of
from tests.unit.harness.option_values import OF_A_RUN, changed, dvp_run, texts_of, words


def configured(pytester: pytest.Pytester, *arguments: str) -> RunSpec:
    """The options of a session."""
    config = pytester.parseconfigure(*arguments)
    config._ensure_unconfigure()  # a session tells its child processes by the environment how large a log may be
    return settings_of(config)


CASES = "cases"  # a campaign has none: the option stands alone


@pytest.fixture
def texts(tmp_path: Path) -> dict[str, str]:
    return {name: text for name, text in texts_of(tmp_path).items() if name != CASES}


@pytest.fixture
def by_pytest(pytester: pytest.Pytester, texts: dict[str, str]) -> RunSpec:
    """All options that go together, given to pytest."""
    return configured(pytester, *words(texts, "--dvp-"))


def test_each_option_is_one_of_pytest(by_pytest: RunSpec, texts: dict[str, str]) -> None:
    assert changed(by_pytest) == set(texts)


def test_the_number_of_cases_is_an_option_a_key_and_a_variable(
    pytester: pytest.Pytester, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = texts_of(tmp_path)[CASES]
    given = configured(pytester, f"--dvp-{CASES}", text)
    assert changed(given) == {CASES}
    pytester.makeini(f"[pytest]\ndvp_{CASES} = {text}")
    assert configured(pytester) == given
    pytester.makeini("[pytest]")
    monkeypatch.setenv(f"DVP_{CASES.upper()}", text)
    assert configured(pytester) == given


def test_each_option_is_a_key_of_the_ini_file(
    by_pytest: RunSpec, pytester: pytest.Pytester, texts: dict[str, str]
) -> None:
    lines = [f"dvp_{name.replace('-', '_')} = {value}" for name, value in texts.items()]
    pytester.makeini("\n".join(["[pytest]", *lines]))
    assert configured(pytester) == by_pytest


def test_each_option_is_an_environment_variable(
    by_pytest: RunSpec, pytester: pytest.Pytester, texts: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in texts.items():
        monkeypatch.setenv(f"DVP_{name.replace('-', '_').upper()}", value)
    assert configured(pytester) == by_pytest


def test_dvp_run_and_pytest_read_the_same_values(by_pytest: RunSpec, texts: dict[str, str]) -> None:
    of_both = [one for one in OF_A_RUN if one.name in texts]
    by_dvp = dvp_run(words({one.name: texts[one.name] for one in of_both}, "--"))
    assert {one.key: getattr(by_pytest, one.key) for one in of_both} == {
        one.key: getattr(by_dvp, one.key) for one in of_both
    }
