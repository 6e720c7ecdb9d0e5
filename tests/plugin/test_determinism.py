"""Same scenario, same seed, same bytes: in another process, under another hash seed, after other runs."""

from __future__ import annotations

import io
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from mcap.reader import make_reader

from pytest_dvp.drive.run import run
from scenarios import path

SCENARIO = "urban.xosc"  # everything at once: storyboard, SUMO, all sensors, both manoeuvres
# The log only: the report has its own time, and DESIGN promises bytes for the log.
DRIVE = f"""
import sys
from pytest_dvp.drive.run import run
from scenarios import path
run(path({SCENARIO!r}), seed=11, rootdir=path({SCENARIO!r}).parent).log.save(sys.argv[1])
"""


def logged_elsewhere(file: Path, hash_seed: str) -> bytes:
    """Bytes of the log of a drive in a process of its own."""
    folder = file.parent / f"cwd-{hash_seed}"
    folder.mkdir()
    environment = {**os.environ, "PYTHONHASHSEED": hash_seed, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", DRIVE, str(file)]
    subprocess.run(command, cwd=folder, env=environment, check=True, timeout=300)
    return file.read_bytes()


def logged_here(file: Path, seed: int) -> bytes:
    run(path(SCENARIO), seed=seed, rootdir=path(SCENARIO).parent).log.save(file)
    return file.read_bytes()


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return logged_here(tmp_path_factory.mktemp("first") / "log.mcap", 11)


def test_two_processes_and_two_hash_seeds_give_the_same_bytes(first: bytes, tmp_path: Path) -> None:
    """The hash seed of this process is drawn, unless it was started with one."""
    other = "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"
    assert logged_elsewhere(tmp_path / "log.mcap", other) == first


@pytest.mark.nightly
def test_a_process_that_has_driven_before_gives_the_same_bytes(first: bytes, tmp_path: Path) -> None:
    other = logged_here(tmp_path / "other.mcap", 12)
    assert logged_here(tmp_path / "log.mcap", 11) == first
    assert other != first  # the seed does reach the sensors: equal bytes mean something


def test_a_log_names_no_place_of_the_machine(first: bytes) -> None:
    reader = make_reader(io.BytesIO(first))
    text = b"".join(message.data for _, _, message in reader.iter_messages())
    text += b"".join(str(record.metadata).encode() for record in reader.iter_metadata())
    text += b"".join(attachment.data for attachment in reader.iter_attachments())
    assert SCENARIO.encode() in text  # this is the text that could name it
    machine = (str(Path(__file__).parents[2]), str(Path.home()), tempfile.gettempdir(), platform.node())
    assert [place for place in machine if len(place) > 3 and place.encode() in text] == []
