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
        ("", False),
    ],
)  # fmt: skip
def test_who_excludes_a_stage_does_not_ask_for_it(marks: str, asked: bool) -> None:
    config: Any = SimpleNamespace(option=SimpleNamespace(markexpr=marks, keyword=""), args=["scenarios"])
    assert asked_stage("rw", config) is asked


def test_a_node_id_asks() -> None:
    config: Any = SimpleNamespace(option=SimpleNamespace(markexpr="", keyword=""), args=["a.xosc::rw"])
    assert asked_stage("rw", config)
