"""A run by the wall clock is put first where the system allows it, and leaves no trace of that."""

from __future__ import annotations

import gc
import os
import subprocess
import sys

import pytest

from pytest_dvp.drive.real_time_priority import punctual


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int]]:
    """(thread, policy) of every wish, all granted."""
    wishes: list[tuple[int, int]] = []
    monkeypatch.setattr(os, "sched_setscheduler", lambda thread, policy, _: wishes.append((thread, policy)))
    return wishes


def test_this_process_and_what_it_started_come_first_and_it_steps_back_afterwards(asked: list[tuple[int, int]]) -> None:
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as child:
        with punctual() as granted:
            assert granted
            assert not gc.isenabled()
            assert {(os.getpid(), os.SCHED_RR), (child.pid, os.SCHED_RR)} <= set(asked)
            asked.clear()
        assert child.stdin is not None
        child.stdin.write(b"\n")
    assert gc.isenabled()
    assert (os.getpid(), os.SCHED_OTHER) in asked
    assert {policy for _, policy in asked} == {os.SCHED_OTHER}


def test_without_permission_it_goes_on_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    with punctual() as granted:
        assert not granted
    monkeypatch.delattr(os, "sched_setscheduler")  # no Linux
    with punctual() as granted:
        assert not granted
