"""Motion that is known at every instant, so that one column of a log can come late or stand in another unit."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from openscenario.findings import Finding
from pytest_dvp.doctor import examine
from pytest_dvp.doctor.redundant_motion import Motion
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

STEP = 0.02  # s between two rows

Signal: TypeAlias = Callable[[FloatArray], FloatArray]


def times(seconds: float) -> FloatArray:
    """Stamps of a log of so many seconds."""
    return np.arange(round(seconds / STEP)) * STEP


def rate_and_integral(slowest: float, fastest: float, *, deviation: float = 1.0) -> tuple[Signal, Signal]:
    """Twelve sines between two frequencies [Hz], which never repeat together, with a standard deviation over a long
    time; and their integral."""
    frequencies = 2.0 * np.pi * np.linspace(slowest, fastest, 12) ** 1.01  # no multiples of each other
    phases = np.random.default_rng(7).uniform(0.0, 2.0 * np.pi, 12)
    amplitude = deviation * np.sqrt(2.0 / 12)

    def rate(t: FloatArray) -> FloatArray:
        return np.asarray(amplitude * np.sum(np.cos(np.outer(t, frequencies) + phases), axis=1))

    def integral(t: FloatArray) -> FloatArray:
        return np.asarray(amplitude * np.sum(np.sin(np.outer(t, frequencies) + phases) / frequencies, axis=1))

    return rate, integral


def way(t: FloatArray, v: FloatArray, course: FloatArray) -> dict[str, FloatArray]:
    """The positions of a car that goes with a speed (n,) [m/s] in a direction (n,) [rad]."""
    return {
        name: np.concatenate([[0.0], np.cumsum(0.5 * (each[1:] + each[:-1]) * np.diff(t))])
        for name, each in (("x", v * np.cos(course)), ("y", v * np.sin(course)))
    }


def motion(**of: FloatArray) -> Motion:
    """A motion that moves all along, of which nothing but these witnesses is known."""
    count = len(next(iter(of.values())))
    unknown = np.full(count, np.nan)
    return Motion(np.arange(count) * STEP, STEP, of, unknown, unknown, np.ones(count, bool))


def findings(columns: dict[str, FloatArray], *codes: str) -> list[Finding]:
    """What the doctor finds in a log, of some codes only."""
    return [finding for finding in examine(Log(columns)) if finding.code in codes]
