"""A deadline on calls in the harness's own process: what is late is told as such, and nothing else comes out."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from pytest_dvp.drive.deadline import Deadline
from pytest_dvp.drive.stack_faults import StackHung

LIMIT = 0.02  # s
ROUNDS = 3  # each late by some tenths of a second, so that the interruption is sure to wait at the end


def late(deadline: Deadline) -> None:
    with deadline.within("tick"):
        sum(range(6_000_000))  # one call of C code: it can be interrupted at its end only, where the deadline looks


def endless(deadline: Deadline) -> None:
    with deadline.within("tick"):
        while True:
            pass


@pytest.mark.parametrize("call", [late, endless])
@pytest.mark.parametrize("main", [True, False])
def test_a_late_call_is_told_as_such_and_the_next_one_is_not(call: Callable[[Deadline], None], main: bool) -> None:
    found: list[Any] = []

    def tries() -> None:
        deadline = Deadline("s", LIMIT)
        try:
            for _ in range(ROUNDS):
                try:
                    call(deadline)
                except BaseException as error:
                    found.append(type(error))
                with deadline.within("tick"):
                    pass
        finally:
            deadline.close()

    if main:
        tries()
    else:
        thread = threading.Thread(target=tries)
        thread.start()
        thread.join()
    assert found == [StackHung] * ROUNDS


def test_who_watches_itself_is_not_interrupted_at_the_end_of_the_run() -> None:
    """A stack in a process of its own ends what is late there, and says where; an interruption here would lose that."""
    deadline = Deadline("s", math.inf)
    deadline.wall, deadline.wall_limit = time.monotonic() + LIMIT, LIMIT
    try:
        with deadline.within("tick"):
            while time.monotonic() < deadline.wall + 2.0 * LIMIT:
                pass
    finally:
        deadline.close()
