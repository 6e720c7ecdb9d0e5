"""The library that the reports of a folder of runs share: there once, whole, and of the version that is installed."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from reports.frame import ASSETS, has_library, library_address, library_name, place_library, plotly_js


def test_the_library_is_placed_once_and_whole(tmp_path: Path) -> None:
    assert not has_library(tmp_path)
    place_library(tmp_path)
    file = tmp_path / ASSETS / library_name()
    assert library_address() == f"../{file.relative_to(tmp_path)}"
    assert file.read_text(encoding="utf-8") == plotly_js()
    written = file.stat().st_mtime_ns, file.stat().st_ino
    place_library(tmp_path)
    assert (file.stat().st_mtime_ns, file.stat().st_ino) == written
    assert has_library(tmp_path)


def test_a_library_that_is_cut_short_is_replaced(tmp_path: Path) -> None:
    place_library(tmp_path)
    file = tmp_path / ASSETS / library_name()
    file.write_text("half")
    place_library(tmp_path)
    assert file.read_text(encoding="utf-8") == plotly_js()


def test_writers_at_once_leave_one_whole_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("reports.frame.plotly_js", lambda: "x" * 100_000)
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(place_library, [tmp_path] * 32))
    assert [file.stat().st_size for file in (tmp_path / ASSETS).iterdir()] == [100_000]
