"""The scenario that each test spoils or extends in one place."""

from __future__ import annotations

from pathlib import Path

import pytest
from xosc_samples import ROAD, SCENARIO, Spoil


@pytest.fixture
def spoil(tmp_path: Path) -> Spoil:
    """Writes the scenario with one text replaced by another, its road beside it, and gives its path."""

    def write(old: str = "", new: str = "") -> Path:
        assert SCENARIO.count(old) >= 1
        (tmp_path / "road.xodr").write_text(ROAD)
        path = tmp_path / "scenario.xosc"
        path.write_text(SCENARIO.replace(old, new, 1) if old else SCENARIO, encoding="utf-8")
        return path

    return write
