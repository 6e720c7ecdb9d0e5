"""Effects that stay in a set although how large they are stays open.

Far from the car, one wild part of a drive holds most of the error, and a value that explains it has a wide interval.
Without the effect nearly all that was explained comes back: a motorhome came to 88 times the noise in place of 22 when
the lag of its drive was taken out, and three more effects went with it. Data held out judge such an effect, and what is
left over makes it provisional. What nearly every car has stays as well where a search began with it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from pytest_dvp.gap.diagnose.usual_car import USUAL

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.experiment import ExperimentSet
    from pytest_dvp.gap.diagnose.trial import Trial

CARRIES = 1.5  # times as much is left without it; chosen: a wind that was none left 1.3 times as much, a drag that was
# there 1.8, a lag of the drive 3.8


class Judging(Protocol):
    """What a search says of an effect of a set; see `pytest_dvp.gap.diagnose.search.Search`."""

    target: ExperimentSet
    count: int
    bare: bool

    def is_credible(self, trial: Trial, name: str, *, certain: bool) -> bool:
        """True if its values mean something; `certain`: and are known."""
        ...

    def without(self, best: Trial, name: str) -> Trial:
        """The set without it."""
        ...


def carries(search: Judging, best: Trial, name: str, far: float) -> bool:
    """True if much more is left without an effect whose value means something, and more than `far` [chi^2/N] is left
    anyway of a model without a known remainder; or if a search began bare, and it is one that nearly every car has."""
    if search.target.excused or best.chi2 <= far * search.count or not search.is_credible(best, name, certain=False):
        return False
    return (search.bare and name in USUAL) or search.without(best, name).chi2 > CARRIES * best.chi2
