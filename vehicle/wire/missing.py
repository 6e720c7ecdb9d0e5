"""Which messages of a topic are missing: fewer messages than periods, told from their stamps alone.

Stamps taken at sending jitter, come in bursts, and stand still while the operating system is elsewhere; nothing is
missing then. So one long interval proves nothing. It is weighed once enough messages have followed: a loss leaves all
of them a whole period behind the grid of the messages before, a delay that is made up for does not. How many must
follow depends on how the topic's stamps scatter: six where they are exact (of one missing message; two more for each
other one), up to MOST where they jitter.

Two kinds of sources are told apart by their residuals from the grid. Those of a timer scatter about it, and the level
of many is compared. Those of a loop that sleeps between its messages wander, and only the next few tell anything.

What cannot be known: a message missing among the last ones of a run, as too few follow; one of the first nine, from
which the rhythm is learnt; one or a few of the first ENOUGH where stamps scatter; a single one in bursts of two, or
where the intervals of a loop that sleeps vary by more than 10 % (twice as many missing in a row can, and of a loop with
25 % about four), and at 10 % one of three. Of single ones in a jitter of 25 % one in ten is missed, and how many are
missing is then known to one or two. Where every second, third or fourth message is missing for long, that is named at
its beginning, and the count is too small. A source that leaves out a period itself looks like a loss, and is one to
whoever reads. False alarms: none in 25 minutes at 100 Hz of each kind of jitter in `tests/unit/wire/test_missing.py`,
but 5 of the loop with 25 %.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import NamedTuple

import numpy as np

from vehicle.messages import FloatArray

GAP = 1.5  # periods; an interval that is weighed: between the usual one and that with one message missing
BEFORE = 64  # messages before it that make the grid; chosen: a jitter of 25 % then leaves its level 0.1 period unsure
MOST = 32  # messages after it at most; chosen: 0.3 s at 100 Hz
ENOUGH = 32  # messages before it where stamps scatter; chosen: what has fewer is taken for a loop, which may wander
EXACT = 0.05  # periods of scatter, below which the few messages that the rhythm is learnt from are enough; chosen
STEP = 0.75  # periods behind that count as one missing; chosen: less is a loop that was held up
SURE = 5.0  # standard deviations that the step must exceed: one false alarm in 10^6 weighings
WANDERS = 2.0  # times that residuals far apart differ more than neighbours (variance): 1 of a timer, BEFORE/4 of a loop
KEPT = BEFORE + 2 * MOST  # stamps


def period_of(stamps: FloatArray, places: FloatArray | None = None) -> float:
    """Period [s] of stamps (n,) [s] at whole places (n,) of a grid (default: in a row): median of slopes over half of
    them, which bursts, jitter and a few delays leave alone."""
    places = np.arange(len(stamps), dtype=np.float64) if places is None else places
    half = len(stamps) // 2
    return float(np.median((stamps[half:] - stamps[:-half]) / (places[half:] - places[:-half])))


class _Gap(NamedTuple):
    """An interval that is to be weighed: the stamp [s] at its end, in how many messages from there what was held up
    has come, and how many must have come."""

    end: float
    reach: int
    wait: int


class Missing:
    """Counts what is missing of one topic."""

    def __init__(self) -> None:
        self._stamps: list[float] = []
        self._places: list[float] = []  # on the grid: number of messages and missing ones before
        self._gaps: list[_Gap] = []

    def take(self, stamp: float, period: float | None) -> int:
        """How many messages are known to be missing now that one stamped `stamp` [s] has come, in whichever order.

        `period` [s] is about that of the topic; None: not learnt yet, and nothing is judged.
        """
        at = bisect_left(self._stamps, stamp)
        if stamp in self._stamps[at : at + 1]:  # it came twice
            return 0
        self._stamps.insert(at, stamp)
        place = self._places[at - 1] + 1.0 if at else (self._places[0] if self._places else 0.0)
        self._places.insert(at, place)
        self._places[at + 1 :] = [each + 1.0 for each in self._places[at + 1 :]]
        if period is None or at == 0:
            return 0
        length = (stamp - self._stamps[at - 1]) / period
        if length > GAP and at == len(self._stamps) - 1:
            reach = min(math.ceil(length - EXACT) + 1, MOST)
            self._gaps.append(_Gap(stamp, reach, reach))
        missing = 0
        for gap in tuple(self._gaps):
            missing += self._weigh(gap)
        if len(self._stamps) > KEPT:
            del self._stamps[0], self._places[0]
        return missing

    def _weigh(self, gap: _Gap) -> int:
        """How many messages are missing in a gap; 0 as long as too few have followed."""
        at = bisect_left(self._stamps, gap.end)
        after, begin = len(self._stamps) - at, max(0, at - BEFORE)
        if after < gap.wait:
            return 0
        self._gaps.remove(gap)
        stamps, places, known = np.array(self._stamps[begin:]), np.array(self._places[begin:]), at - begin
        behind = stamps / period_of(stamps[:known], places[:known]) - places  # the grid, periods
        behind -= _level(behind[:known])
        scatter = 1.25 * float(np.mean(np.abs(behind[:known])))  # of a Gaussian: mean deviation to standard deviation
        lag = known // 4
        near = float(np.mean(np.diff(behind[:known]) ** 2))
        far = float(np.mean((behind[lag:known] - behind[: known - lag]) ** 2))
        few = scatter > EXACT and known < ENOUGH
        if few or (scatter > EXACT and far > WANDERS * near):
            step = float(behind[known + gap.reach - 1] - behind[known - 1])
            step = min(step, gap.reach - 2.0) if few else step  # no more than the gap holds: a hold-up may follow it
            unsure = math.sqrt(near * (gap.reach + gap.reach**2 / known))
        else:
            count = min(2 * gap.reach + math.floor((SURE * 1.25 * scatter / (1.0 - STEP)) ** 2), MOST)
            if after < count:
                self._gaps.append(gap._replace(wait=count))
                return 0
            step = _level(behind[known : known + count])
            away = 0.5 * (known + count)
            unsure = 1.1 * scatter * math.sqrt(1.0 / count + 1.0 / known + 12.0 * away**2 / known**3)
        if step < max(2.0 * STEP if few else STEP, SURE * unsure):
            return 0
        missing = max(1, round(step))
        self._places[at:] = [each + missing for each in self._places[at:]]
        return missing


def _level(values: FloatArray) -> float:
    """Mean of the middle half, which a few delayed messages leave alone."""
    cut = len(values) // 4
    return float(np.mean(np.sort(values)[cut : len(values) - cut]))
