"""How long a stack takes for a tick: wall time of its own computing, in the process it runs in.

It stands in a run's result, never in its log: a log knows no wall clock, so that the same seed gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def tick_time(seconds: Sequence[float], cycle: float) -> dict[str, Any]:
    """Figures of the wall times [s] of all ticks, in their order, against the `cycle` [s] of a run.

    median, p99, worst  of all ticks but the first, which may load what it needs; None if there is no other
    first               the first tick; None if there is none
    exceeded            how many ticks, the first aside, took longer than the cycle
    ticks               how many there are, the first aside
    """
    later = np.array(seconds[1:], dtype=np.float64)
    known = len(later) > 0
    return {
        "median": float(np.median(later)) if known else None,
        "p99": float(np.quantile(later, 0.99, method="inverted_cdf")) if known else None,
        "worst": float(later.max()) if known else None,
        "cycle": cycle,
        "exceeded": int(np.count_nonzero(later > cycle)),
        "first": float(seconds[0]) if len(seconds) else None,
        "ticks": len(later),
    }


def tick_time_notes(figures: Mapping[str, Any]) -> tuple[str, ...]:
    """One line about a stack that was slower than the cycle; nothing else."""
    if not figures["exceeded"]:
        return ()
    ms = {name: f"{1000.0 * figures[name]:.3g}" for name in ("cycle", "median", "p99", "worst")}
    return (
        f"tick time: {figures['exceeded']} of {figures['ticks']} ticks took longer than the cycle of {ms['cycle']} ms "
        f"(median {ms['median']} ms, 99 % within {ms['p99']} ms, worst {ms['worst']} ms); "
        "a car would not have waited: --compute-delay lets it count",
    )
