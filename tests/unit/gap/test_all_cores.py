"""Simulations side by side: the same results in the same order, whatever the number of cores."""

from __future__ import annotations

import multiprocessing
import threading
from collections.abc import Iterator

import numba
import pytest

from pytest_dvp.gap.diagnose import all_cores
from pytest_dvp.gap.diagnose.all_cores import MOST, cores, mapped
from tests.unit.gap.linear_world import World, a_search, direction


@pytest.fixture
def three_cores(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", 3)
    all_cores._pool.cache_clear()
    yield
    all_cores._pool.cache_clear()


def test_no_more_threads_than_cores_and_than_are_of_use(monkeypatch: pytest.MonkeyPatch) -> None:
    for given, used in ((1, 1), (3, 3), (64, MOST)):
        monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", given)
        assert cores() == used


def test_results_come_in_the_order_of_the_items_from_several_threads(three_cores: None) -> None:
    together = threading.Barrier(3, timeout=30.0)  # breaks unless three wait at once

    def waited(item: int) -> tuple[int, str]:
        together.wait()
        return item * item, threading.current_thread().name

    found = mapped(waited, range(6))
    assert [square for square, _ in found] == [0, 1, 4, 9, 16, 25]
    assert len({name for _, name in found}) == 3


def test_within_itself_it_stays_in_its_thread(three_cores: None) -> None:
    """Threads that wait for threads of the same pool would wait for ever."""

    def inner(item: int) -> str:
        return threading.current_thread().name

    for names in mapped(lambda item: mapped(inner, range(4)), range(6)):
        assert len(set(names)) == 1


def test_an_error_is_the_callers(three_cores: None) -> None:
    with pytest.raises(ZeroDivisionError):
        mapped(lambda item: 1 // item, [2, 1, 0, 1])


def _in_a_child(answers: multiprocessing.queues.SimpleQueue[list[int]]) -> None:
    answers.put(mapped(lambda item: item + 1, range(4)))


def test_a_forked_process_has_threads_of_its_own(three_cores: None) -> None:
    assert mapped(lambda item: item, range(4)) == [0, 1, 2, 3]
    context = multiprocessing.get_context("fork")
    answers = context.SimpleQueue()
    child = context.Process(target=_in_a_child, args=(answers,))
    child.start()
    child.join(30.0)
    assert child.exitcode == 0
    assert answers.get() == [1, 2, 3, 4]


def test_a_search_finds_the_same_with_one_core_and_with_three(monkeypatch: pytest.MonkeyPatch) -> None:
    does = {(name, "g"): direction(k) * 10.0 * (k + 1) for k, name in enumerate(("drive_gain", "brake_gain"))}
    told = []
    for threads in (1, 3):
        monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", threads)
        all_cores._pool.cache_clear()
        world = World(does, dict.fromkeys(does, 0.8))
        found = a_search(world, "drive_gain", "brake_gain", "steer_ratio", "mass").run()
        told.append((found.final.names, dict(found.final.values), found.final.chi2, found.rivals, found.not_excited))
    all_cores._pool.cache_clear()
    assert told[0] == told[1]
