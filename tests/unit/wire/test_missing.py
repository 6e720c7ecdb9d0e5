"""Which messages are missing where stamps are taken at sending and jitter: 60 s at 100 Hz, generated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from vehicle.messages import FloatArray, Imu
from vehicle.wire.health import Health, Trouble

PERIOD, COUNT = 0.01, 6000
TICKS = PERIOD * np.arange(COUNT)
Sender = Callable[[np.random.Generator], FloatArray]


def on_time(rng: np.random.Generator) -> FloatArray:
    return TICKS


def gaussian(share: float) -> Sender:
    return lambda rng: np.sort(TICKS + share * PERIOD * rng.standard_normal(COUNT))


def uniform(share: float) -> Sender:
    return lambda rng: np.sort(TICKS + share * PERIOD * rng.uniform(-1.0, 1.0, COUNT))


def bursts_of_two(rng: np.random.Generator) -> FloatArray:
    """A loop at half the rate that sends two at a time, 0.1 ms apart."""
    return np.repeat(TICKS[1::2], 2) + np.tile([0.0, 1e-4], COUNT // 2)


def sleeping_loop(share: float) -> Sender:
    """Each interval varies for itself, and nothing brings the stamps back to a grid."""
    return lambda rng: np.cumsum(PERIOD * np.maximum(0.05, 1.0 + share * rng.standard_normal(COUNT)))


def hiccups(share: float) -> Sender:
    """Every two seconds the operating system is elsewhere for 3 periods; the timer then makes up for it."""

    def stamps(rng: np.random.Generator) -> FloatArray:
        sent = np.sort(TICKS + share * PERIOD * rng.standard_normal(COUNT))
        for first in range(150, COUNT - 10, 200):
            resumed = sent[first] + (3.0 + rng.uniform(0.0, 0.9)) * PERIOD
            for k in range(first, first + 10):
                sent[k] = max(sent[k], resumed + 1e-4 * (k - first))
        return sent

    return stamps


def named(stamps: FloatArray, keep: Callable[[int], bool] = lambda _: True) -> list[Trouble]:
    """What is said of the messages of these stamps, each 1 ms old when it comes, of those that are kept."""
    troubles: list[Trouble] = []
    health = Health(troubles.append)
    health.reset(["/imu/data"])
    for k, stamp in enumerate(np.maximum(stamps - stamps[0], 0.0).tolist()):
        if keep(k):
            health.sift("/imu/data", [Imu(stamp, 0.0, 0.0, 0.0)], stamp + 0.001)
            health.look(stamp + 0.001)
    return [trouble for trouble in troubles if trouble.what != "repeated"]


SENDERS = {
    "on time": on_time,
    "Gaussian, 10 %": gaussian(0.10),
    "Gaussian, 25 %": gaussian(0.25),
    "uniform, 30 %": uniform(0.30),
    "uniform, 50 %": uniform(0.50),
    "bursts of two": bursts_of_two,
    "hiccups": hiccups(0.0),
    "hiccups, 10 %": hiccups(0.10),
    "hiccups, 25 %": hiccups(0.25),
    "loop, 2 %": sleeping_loop(0.02),
    "loop, 10 %": sleeping_loop(0.10),
    "loop, 25 %": sleeping_loop(0.25),
}


@pytest.mark.parametrize("name", SENDERS)
def test_jitter_is_no_loss(name: str) -> None:
    assert named(SENDERS[name](np.random.default_rng(5))) == []


@pytest.mark.parametrize(
    ("name", "lost", "found"),
    [
        ("on time", 1, 1.0),
        ("Gaussian, 10 %", 1, 1.0),
        ("Gaussian, 25 %", 1, 0.9),
        ("uniform, 30 %", 1, 0.9),
        ("uniform, 50 %", 1, 0.85),
        ("loop, 2 %", 1, 1.0),
        ("Gaussian, 25 %", 2, 1.0),
        ("bursts of two", 2, 1.0),
        ("loop, 10 %", 2, 1.0),
    ],
)
def test_messages_missing_among_jitter_are_found(name: str, lost: int, found: float) -> None:
    """Every second `lost` of them in a row, in 50 places."""
    places = range(500, 5500, 100)
    gone = {place + k for place in places for k in range(lost)}
    troubles = named(SENDERS[name](np.random.default_rng(6)), lambda k: k not in gone)
    assert {trouble.what for trouble in troubles} == {"lost"}
    hits = sum(any(0.0 <= t.t - PERIOD * place <= 0.6 for t in troubles) for place in places)
    assert hits >= found * len(places)


def test_what_scatter_hides_is_not_named() -> None:
    """One message missing in bursts of two looks like the burst before, and one of a loop of 25 % like a slow turn."""
    for name in ("bursts of two", "loop, 25 %"):
        stamps = SENDERS[name](np.random.default_rng(7))
        assert len(named(stamps, lambda k: k % 100 != 50)) <= 3


def test_exact_stamps_tell_of_each_message() -> None:
    """One missing, told when six have followed: 60 ms later."""
    (lost,) = named(TICKS, lambda k: k != 1000)
    assert (lost.what, lost.amount, lost.t) == ("lost", 1.0, pytest.approx(10.061))


def test_half_of_all_messages_missing_is_named_at_once() -> None:
    """As `--dvp-fault drop` does it."""
    rng = np.random.default_rng(8)
    gone = {500 + k for k in range(300) if rng.uniform() < 0.5}
    lost = [trouble for trouble in named(TICKS, lambda k: k not in gone) if trouble.what == "lost"]
    assert lost[0].t < 5.3


@pytest.mark.parametrize("gone", [(20, 35), (12, 40)])
def test_many_missing_among_the_first_jittering_messages_are_named(gone: tuple[int, int]) -> None:
    """Else nothing would be named after them either, as they would count as jitter."""
    sent = gaussian(0.10)(np.random.default_rng(9))
    lost = [t for t in named(sent, lambda k: not gone[0] <= k < gone[1] and k != 150) if t.what == "lost"]
    assert [t.amount for t in lost] == [pytest.approx(gone[1] - gone[0], abs=1), 1.0]


def test_what_is_missing_while_the_rhythm_is_learnt_hides_no_later_loss() -> None:
    """The 6th and 7th of the first nine: the rhythm learnt from these is half as long again."""
    lost = named(TICKS, lambda k: k not in (5, 6, 500))
    assert [(t.what, t.amount, t.t) for t in lost] == [("lost", 1.0, pytest.approx(5.061))]


@pytest.mark.parametrize("seed", [67, 310, 401, 440, 586, 598])
def test_a_hold_up_among_the_first_messages_is_no_loss_of_the_gap_before(seed: int) -> None:
    """A gap of 1.6 to 1.8 periods that is jitter, and three messages later one that is made up for."""
    begin = int(np.random.default_rng(seed).integers(0, 4000))
    assert named(hiccups(0.25)(np.random.default_rng(5000 + seed))[begin : begin + 80]) == []
