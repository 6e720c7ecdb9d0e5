"""How the error falls from the model as given to the new one, step by step, and what each effect took of it."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Sequence

from pytest_dvp.gap.diagnose.diagnosis import Step
from pytest_dvp.gap.diagnose.held_out import Fold, step
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.gap.extend.extension import Rung


def ladder_of(search: Search, final: Trial, kept: int, lost: Sequence[str], judges: Sequence[Fold],
              present: Collection[str]) -> Iterator[Rung]:  # fmt: skip
    """From the model as given to the final one: what is removed, what is fitted again, then effect after effect."""
    plain = Search(search.target, ())
    yield Rung("", step(plain, plain.trial((), {}), judges))
    off: dict[tuple[str, str], float] = {}
    for name in lost:
        off |= {key: value for key, value in search.fixed.items() if key[0] == name}
        without = Search(search.target, (), fixed=off)
        yield Rung(f"- {name}", step(without, without.trial((), {}), judges, name))
    if search.nuisance or kept:
        yield Rung("~ fitted again", step(search, search.trial(final.names[:kept], final.values), judges))
    for count in range(kept + 1, len(final.names) + 1):
        names = final.names[:count]
        trial = final if count == len(final.names) else search.trial(names, final.values)
        yield Rung(f"{'~' if names[-1] in present else '+'} {names[-1]}", step(search, trial, judges, names[-1]))


def shares(steps: Sequence[Step]) -> dict[str, float]:
    """Share of the excess error (chi^2/N above 1) that each step took away, 0..1; less than the noise is no gain."""
    left = [max(step.chi2_per_n, 1.0) for step in steps]
    excess = max(left[0] - 1.0, 1e-9)
    return {
        step.added: float(min(max((before - after) / excess, 0.0), 1.0))
        for step, (before, after) in zip(steps[1:], itertools.pairwise(left), strict=True)
    }
