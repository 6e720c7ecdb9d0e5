"""Waiting for what another process does, without a clock."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

LOOKS = 2000  # chosen: with a process start between two of them, some seconds on any machine


def wait_until(done: Callable[[], bool], otherwise: str) -> None:
    """Look again and again, other processes going on between; the test fails with `otherwise` if it never is so."""
    for _ in range(LOOKS):
        if done():
            return
        subprocess.run(["true"], check=True)
    pytest.fail(otherwise)


def is_gone(pid: int) -> bool:
    """Whether a process has ended, though nobody may have asked for how."""
    try:
        return "Z (zombie)" in Path(f"/proc/{pid}/status").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return True
