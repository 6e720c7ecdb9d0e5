"""A process that hangs is told from one that has to wait: for messages, for a processor, for a disk."""

from __future__ import annotations

import os
from collections.abc import Iterator
from itertools import count

import pytest

from vehicle.liveness import APART, ASLEEP, WORKING, Life, Pulse, life


def told(*lives: Life | None, steps: Iterator[int] | None = None) -> list[str]:
    """What each look says of lives that follow one another in time, all in step 1 unless said otherwise."""
    readings, times = iter(lives), count()
    pulse = Pulse(1, lambda _: next(readings), lambda: 2.0 * APART * next(times))
    return [pulse.look(next(steps) if steps is not None else 1) for _ in lives]


def test_one_that_sleeps_and_never_wakes_hangs() -> None:
    said = told(*[Life("S", 40, 1.0)] * (ASLEEP + 1))
    assert said[:-1] == [""] * ASLEEP
    assert said[-1].startswith("hangs: it is asleep")


def test_one_that_wakes_up_to_look_for_messages_is_waiting_however_long() -> None:
    assert not any(told(*[Life("S", k, 1.0) for k in range(1000)]))


def test_many_looks_at_once_find_the_same_sleep_and_do_not_count() -> None:
    """Frames of the harness's own that come back from a CAN bus had it look six times within a millisecond."""
    looked_at = [0.0]
    pulse = Pulse(1, lambda _: Life("S", 40, 1.0), lambda: looked_at[0])
    said = []
    for _ in range(100 * (ASLEEP - 1)):
        looked_at[0] += APART / 100
        said.append(pulse.look(1))
    assert not any(said)
    for _ in range(2 * ASLEEP):
        looked_at[0] += 2.0 * APART
        said.append(pulse.look(1))
    assert said[-1].startswith("hangs: it is asleep")


@pytest.mark.parametrize("state", ["R", "D", "T"])
def test_one_that_waits_for_a_processor_or_a_disk_does_not_hang(state: str) -> None:
    """On a machine with a load of 20 it may be runnable for seconds without having slept again."""
    assert not any(told(*[Life(state, 40, 1.0)] * 1000))


def test_a_wait_for_the_processor_between_two_sleeps_begins_the_count_anew() -> None:
    before, after = [Life("S", 40, 1.0)] * ASLEEP, [Life("S", 41, 1.0)] * ASLEEP
    assert not any(told(*before, Life("R", 40, 1.0), *after))


def test_one_that_works_for_longer_than_any_answer_takes_hangs() -> None:
    said = told(*[Life("R", 40, 5.0 + k * WORKING / 8) for k in range(9)])
    assert said[:-1] == [""] * 8
    assert said[-1] == f"hangs: it has worked for {WORKING:.1f} s of processor time on one answer"


def test_work_counts_for_each_step_by_itself() -> None:
    assert not any(told(*[Life("R", k, k * WORKING / 2) for k in range(40)], steps=iter(range(40))))


def test_where_the_system_tells_nothing_nothing_is_found() -> None:
    assert not any(told(*[None] * 100))


@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="no /proc")
def test_linux_tells() -> None:
    me = life(os.getpid())
    assert me is not None
    assert me.state == "R"
    assert me.cpu > 0.0
    assert life(2**22 + 1) is None  # beyond the greatest number of a process
