"""The trials as a table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.arch_comp.published import SEARCHES, ZLSCHECK
from benchmarks.arch_comp.trial import Trial


def table(trials: Sequence[Trial]) -> str:
    """A row a problem, a column a method, as Markdown: searches that falsified; mean, median of their simulations."""
    problems = list(dict.fromkeys(one.problem for one in trials))
    methods = list(dict.fromkeys(one.method for one in trials))
    head = ["", *(f"`{method}`" for method in methods), "zlscheck, published"]
    lines = [_line(head), "|" + "---|" * len(head)]
    for problem in problems:
        cells = [_cell([t for t in trials if (t.problem, t.method) == (problem, method)]) for method in methods]
        lines.append(_line([problem, *cells, _published(problem)]))
    return "\n".join([*lines, _line(["falsified in all", *(_share(trials, method) for method in methods), ""])])


def _cell(trials: Sequence[Trial]) -> str:
    found = [one.found for one in trials if one.found is not None]
    if not found:
        return f"0 of {len(trials)}"
    return f"{len(found)} of {len(trials)}; {np.mean(found):.1f}, {np.median(found):g}"


def _share(trials: Sequence[Trial], method: str) -> str:
    mine = [one for one in trials if one.method == method]
    return f"{sum(one.found is not None for one in mine)} of {len(mine)}"


def _published(problem: str) -> str:
    known = ZLSCHECK.get(problem)
    return f"{known.found} of {SEARCHES}; {known.mean:.1f}" if known else ""


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def written_into(page: str, name: str, text: str) -> str:
    """The page with what stands between its marks of this name replaced by the text."""
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    before, rest = page.split(begin, 1)
    return f"{before}{begin}\n{text}\n{end}{rest.split(end, 1)[1]}"
