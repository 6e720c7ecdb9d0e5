"""A nightly run that was killed goes on where it was, and mutant n is the same whoever makes it."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from fuzz import KEEP_EVERY, numbers, random_of


def test_an_interrupted_run_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DVP_FUZZ", str(3 * KEEP_EVERY))
    first = list(itertools.islice(numbers("some", 1, folder=tmp_path), KEEP_EVERY + 7))
    second = list(numbers("some", 1, folder=tmp_path))
    assert first[-1] == KEEP_EVERY + 6
    assert second == list(range(KEEP_EVERY, 3 * KEEP_EVERY))  # at most KEEP_EVERY are tried twice
    assert next(numbers("some", 1, folder=tmp_path)) == 0  # a finished run begins anew


def test_make_test_keeps_no_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DVP_FUZZ", raising=False)
    assert list(numbers("some", 5, folder=tmp_path)) == [0, 1, 2, 3, 4]
    assert list(tmp_path.iterdir()) == []


def test_a_mutant_is_made_again_from_its_number() -> None:
    assert random_of("some", 7).random() == random_of("some", 7).random() != random_of("some", 8).random()
