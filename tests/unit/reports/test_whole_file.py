"""A file that is written appears whole or not at all; where it cannot, one line says why."""

from __future__ import annotations

import os
import stat
import threading
from pathlib import Path

import pytest

from reports.whole_file import WriteError, write_page, write_whole

FULL = Path("/dev/full")  # takes no byte, as a disk without room


def test_a_file_is_written_and_nothing_else_is_left(tmp_path: Path) -> None:
    write_whole(tmp_path / "a.csv", b"1")
    write_whole(tmp_path / "a.csv", b"2")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("a.csv", b"2")]


def test_a_link_stays_one_and_what_it_points_to_is_written(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("real")
    write_whole(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"


def test_a_pipe_is_written_to_and_stays_a_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write_whole(pipe, b"through")
    reader.join(10)
    assert read == [b"through"]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@pytest.mark.parametrize("name", ["folder", "none/a.csv", "file/a.csv", "x" * 300])
def test_what_cannot_be_written_is_named_with_the_reason_and_leaves_nothing(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("mine")
    path = tmp_path / name
    with pytest.raises(WriteError) as caught:
        write_whole(path, b"1")
    assert str(caught.value).startswith(f"{path}: cannot be written: ")
    assert ".part" not in str(caught.value)
    assert sorted(each.name for each in tmp_path.rglob("*")) == ["file", "folder"]
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.skipif(not FULL.exists(), reason="this system has no /dev/full")
def test_a_full_disk_is_said(tmp_path: Path) -> None:
    (tmp_path / "a.csv").symlink_to(FULL)
    with pytest.raises(WriteError, match=r"a\.csv: cannot be written: No space left on device$"):
        write_whole(tmp_path / "a.csv", b"1")
    assert stat.S_ISCHR(FULL.stat().st_mode)


def test_a_name_as_long_as_names_may_be_is_written(tmp_path: Path) -> None:
    write_whole(tmp_path / ("x" * 255), b"1")
    assert (tmp_path / ("x" * 255)).read_bytes() == b"1"


def test_a_file_name_that_is_no_utf8_is_spelled_out(tmp_path: Path) -> None:
    write_page(tmp_path / "a.html", "f\udcfcr.csv")
    assert (tmp_path / "a.html").read_bytes() == b"f\\udcfcr.csv"
