"""How large effects may be that hide in what a twin is known not to explain.

That nothing is missing is said of a twin with its known remainder. How much that leaves open, these sizes say: what the
remainder imitates of an effect on drives with nothing hidden, so many times as a name asks for.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite
from typing import TYPE_CHECKING

from pytest_dvp.gap.diagnose.beyond_remainder import times_beyond
from pytest_dvp.gap.diagnose.candidates import Candidate, sizes
from pytest_dvp.gap.diagnose.diagnosis import HiddenSize
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.quiet_effects import is_placed

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel


def hidden_sizes(model: VehicleModel, tried: Iterable[Candidate], judges: Sequence[Fold]) -> tuple[HiddenSize, ...]:
    """Sizes that a twin's known remainder hides and that are worth a name, the largest shares of their ranges first;
    none without a known remainder.

    They bound what can be seen from below only: a larger effect may hide, too, on drives that hardly ask for it, and
    where the remainder is larger than on the drives that the twin was learnt from. Of effects in a finer form, or of a
    place, and of limits that the twin has not, none is told; none is larger than the equation allows.
    """
    imitates = model.remainder_shape.imitates
    found = []
    for candidate in tried:
        if not imitates.get(candidate.name) or candidate.detail or is_placed(candidate):
            continue
        for c in sizes(candidate.coordinates):
            size = times_beyond(judges) * imitates[candidate.name].get(c.key.name, 0.0)
            at = candidate.own.get(c.name, c.key.neutral)
            size = min(size, max(c.key.maximum - at, at - c.key.minimum)) if isfinite(at) else size
            if size > c.key.least:
                share = size / (c.key.high - c.key.low)
                found.append((-share, HiddenSize(c.effect, c.key.name, size, c.key.unit)))
    return tuple(one for _, one in sorted(found, key=lambda entry: (entry[0], entry[1].effect, entry[1].key)))
