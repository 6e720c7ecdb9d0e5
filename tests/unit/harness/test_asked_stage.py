"""What asks for a stage that takes a car, and what only names it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.plugin.selection import asked_stage


@pytest.mark.parametrize(
    ("marks", "asked"),
    [
        ("rw", True),
        ("dt or rw", True),
        ("not rw", False),
        ("pe and not rw", False),
        ("not dt and rw", True),
        ("not (pe or rw)", False),
        ("not (rw and slow) and not pe", False),
        ("not (dt or (pe and not rw))", True),
        ("(dt or rw) and not slow", True),
        ("", False),
    ],
)  # fmt: skip
def test_who_excludes_a_stage_does_not_ask_for_it(marks: str, asked: bool) -> None:
    config: Any = SimpleNamespace(option=SimpleNamespace(markexpr=marks, keyword=""), args=["scenarios"])
    assert asked_stage("rw", config) is asked


@pytest.mark.parametrize(
    ("id", "asked"), [("a.xosc::rw", True), ("a.xosc::rw-surrogate", True), ("drive_a.py::rwanda", False)]
)
def test_a_node_id_asks(id: str, asked: bool) -> None:
    config: Any = SimpleNamespace(option=SimpleNamespace(markexpr="", keyword=""), args=[id])
    assert asked_stage("rw", config) is asked
