"""What a search can do with a set of effects, for those who build sets and leave the fitting to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

from pytest_dvp.gap.diagnose.candidates import Candidate

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values
    from pytest_dvp.gap.diagnose.trial import Trial


class Fitting(Protocol):
    """Fits and judges sets of effects; see `pytest_dvp.gap.diagnose.search.Search`, which does.

    count: independent samples of the target; start: values of what is fitted along with every set; tick: takes a line
    of progress.
    """

    target: ExperimentSet
    count: int
    start: dict[tuple[str, str], float]
    tick: Callable[[str], None]

    @property
    def tried(self) -> Mapping[str, Candidate]:
        """What is tried, by name."""
        ...

    @property
    def known(self) -> Mapping[str, Candidate]:
        """What is tried, and what refines it at the end, by name."""
        ...

    def trial(self, names: Sequence[str], start: Values, *, like: Trial | None = None) -> Trial:
        """The set fitted."""
        ...

    def unseen(self) -> tuple[str, ...]:
        """Effects of which not even the strongest would have changed anything that is worth a name, by name."""
        ...

    def cost(self, trial: Trial) -> float:
        """chi^2 and a price for each parameter."""
        ...

    def is_worth_adding(self, without: Trial, with_it: Trial) -> bool:
        """True if the step to the other set is worth an effect."""
        ...

    def pays(self, less: Trial, best: Trial) -> bool:
        """True if the effect by which the two sets differ is worth its place in the larger one."""
        ...

    def is_credible(self, trial: Trial, name: str) -> bool:
        """True if the effect's values mean something."""
        ...

    def contained(self, name: str) -> str:
        """The simpler effect that this one can do exactly, "" if there is none."""
        ...
