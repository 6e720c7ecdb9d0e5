"""The coordinate search of the paper: one parameter after the other, all its candidates."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_dvp.tuning.tuned_parameter import Knob, Point

LEAST_GAIN = 1e-9  # of a score: what is less is rounding


class CoordinateSearch:
    """For each knob all its candidates are tried with the others held, the best is kept; repeated until a whole
    round improves nothing.

    Source: Arango et al., Sensors 2026, 26, 1338 (derivative-free coordinate search).
    """

    def __init__(self, knobs: Sequence[Knob], start: Point) -> None:
        self.knobs, self.best = tuple(knobs), dict(start)
        self._score: float | None = None
        self._next = 0
        self._idle = 0  # knobs in a row that improved nothing

    def ask(self) -> list[Point]:
        """The start alone first, then all other values of one knob; empty when no knob improves any more."""
        if self._score is None:
            return [dict(self.best)]
        while self._idle < len(self.knobs):
            knob = self.knobs[self._next]
            others = [value for value in knob.values if value != self.best[knob.name]]
            if others:
                return [{**self.best, knob.name: value} for value in others]
            self._advance(improved=False)
        return []

    def tell(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of the batch, smaller is better; a gain of LEAST_GAIN or less does not count as one."""
        if self._score is None:
            self._score = scores[0]
            return
        k = min(range(len(scores)), key=lambda i: (scores[i], i))
        improved = scores[k] < self._score - LEAST_GAIN
        if improved:
            self.best, self._score = dict(points[k]), scores[k]
        self._advance(improved)

    def _advance(self, improved: bool) -> None:
        self._idle = 1 if improved else self._idle + 1
        self._next = (self._next + 1) % len(self.knobs)


def make(knobs: Sequence[Knob], start: Point, seed: int) -> CoordinateSearch:
    """The search from `start` on; it draws nothing, so `seed` changes nothing."""
    return CoordinateSearch(knobs, start)
