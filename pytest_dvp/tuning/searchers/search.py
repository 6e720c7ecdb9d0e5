"""What a searcher is, and how one is found by the name of its file."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Protocol, cast, runtime_checkable

from pytest_dvp.tuning.tuned_parameter import Knob, Point
from pytest_dvp.workers.errors import TuneError


class Searcher(Protocol):
    """Proposes points in batches whose size does not depend on the machine; same scores told, same points asked."""

    def ask(self) -> list[Point]:
        """The next batch; empty when there is nothing left to try."""
        ...

    def tell(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of the batch, smaller is better."""
        ...


@runtime_checkable
class Learner(Protocol):
    """A searcher that can begin with scores of points that it did not ask for."""

    def learn(self, points: Sequence[Point], scores: Sequence[float]) -> None:
        """Scores of earlier points, before the first batch; smaller is better. The start need not be asked for then."""
        ...


def make_searcher(name: str, knobs: Sequence[Knob], start: Point, seed: int) -> Searcher:
    """The searcher of the file `name`, one of `search_names()`. Raises TuneError if what it needs is not installed."""
    try:
        module = importlib.import_module(f"{__package__}.{name}")
        return cast("Searcher", module.make(knobs, start, seed))
    except ModuleNotFoundError as error:
        raise TuneError(f"search {name!r} needs {error.name}: pip install -e '.[tune]' from the checkout") from None
