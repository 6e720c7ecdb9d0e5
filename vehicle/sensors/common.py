"""What all sensors share: where they sit, when they measure, what gets lost, and their noise."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from math import isfinite
from typing import Generic, TypeVar

import numpy as np

from vehicle.messages import FloatArray
from vehicle.model.errors import ModelError

T = TypeVar("T")

TIME_SLACK = 1e-6  # s, a sample this much early is due


@dataclass(frozen=True, slots=True)
class Mount:
    """Pose of a sensor on the car: x ahead, y left of the reference point, z above ground [m]; yaw [rad]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True, slots=True)
class Timing:
    """When a sensor measures and what becomes of it.

    `rate` [Hz] of measurements, on the grid on which it is asked: 100 Hz of the trace, 20 Hz of the ticks; `latency`
    [s] from measurement to delivery; `dropout` share of them lost, 0..1.
    """

    rate: float
    latency: float = 0.0
    dropout: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.rate <= 1000.0:
            raise ModelError("value not allowed", key="rate", found=f"{self.rate:g}", allowed="more than 0 to 1000 Hz")
        if not 0.0 <= self.latency <= 5.0:
            raise ModelError("value not allowed", key="latency", found=f"{self.latency:g}", allowed="0 to 5 s")
        if not 0.0 <= self.dropout <= 1.0:
            raise ModelError("value not allowed", key="dropout", found=f"{self.dropout:g}", allowed="0 to 1")


class Noise:
    """Standard normal and uniform numbers, each from an own generator, drawn in blocks, as a call for each costs more.

    normal, uniform   give the next number: of the standard normal distribution, of [0, 1)
    """

    BLOCK = 1024

    def __init__(self, seed: np.random.SeedSequence) -> None:
        normal, uniform = (np.random.Generator(np.random.PCG64(each)) for each in seed.spawn(2))
        self.normal: Callable[[], float] = chain.from_iterable(_blocks(normal.standard_normal, self.BLOCK)).__next__
        self.uniform: Callable[[], float] = chain.from_iterable(_blocks(uniform.random, self.BLOCK)).__next__


def _blocks(draw: Callable[[int], FloatArray], size: int) -> Iterator[list[float]]:
    """Blocks without end, each from its last number to its first."""
    while True:
        yield draw(size)[::-1].tolist()


class NoiseArray:
    """Standard normal numbers as array slices from an own generator, drawn in blocks."""

    BLOCK = 1 << 15

    def __init__(self, seed: np.random.SeedSequence) -> None:
        self._rng = np.random.Generator(np.random.PCG64(seed))
        self._block = np.zeros(0)
        self._at = 0

    def take(self, count: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """The next `count` numbers (count,), in units of the standard deviation; valid until the next call."""
        if self._at + count > len(self._block):
            self._block = self._rng.standard_normal(max(self.BLOCK, count))
            self._at = 0
        self._at += count
        return self._block[self._at - count : self._at]


class Clock:
    """Decides when a sensor measures: at start, then every 1/rate, on the grid of the start time."""

    def __init__(self, timing: Timing, start: float) -> None:
        self._start, self._period, self._count = start, 1.0 / timing.rate, 0
        self._next = start
        self.earliest = start - TIME_SLACK  # s, before which `due` is False

    def due(self, t: float) -> bool:
        """True once for each measurement that is due at `t` [s]; overdue ones are skipped."""
        if t < self.earliest:
            return False
        while self._next <= t + TIME_SLACK:
            self._count += 1
            self._next = self._start + self._count * self._period
        self.earliest = self._next - TIME_SLACK
        return True


class Line(Generic[T]):
    """Messages on their way: delivered in order, each when its latency has passed."""

    def __init__(self, timing: Timing) -> None:
        self._latency = timing.latency
        self._waiting: deque[tuple[float, T]] = deque()

    def send(self, t: float, message: T) -> None:
        """Put a message measured at `t` [s] on its way."""
        self._waiting.append((t + self._latency - TIME_SLACK, message))

    def arrived(self, t: float) -> tuple[T, ...]:
        """Messages that have arrived by `t` [s], oldest first; each only once."""
        waiting = self._waiting
        if not waiting or waiting[0][0] > t:
            return ()
        out = []
        while waiting and waiting[0][0] <= t:
            out.append(waiting.popleft()[1])
        return tuple(out)


def check_sigma(name: str, value: float) -> float:
    """A noise figure that is finite and not negative. Raises ModelError."""
    if not (isfinite(value) and value >= 0.0):
        raise ModelError("value not allowed", key=name, found=f"{value:g}", allowed="0 or more")
    return value
