"""Which bounds a comparison can be held against, for `assert_matches` and for gates of the kind `model` alike."""

from __future__ import annotations

import math
from numbers import Real

KINDS = ("rmse", "mncc", "lag", "gain")
"""What may be bounded. rmse, lag and gain from above (lag: |lag| [s]; gain: |gain - 1|), mncc from below."""


def wrong_bound(kind: str, bound: object) -> str:
    """What a bound of a kind in KINDS must be, as "must be a finite number >= 0"; "" if it is that.

    All that is bounded is a size, so nothing is ever below 0; a correlation is never above 1.
    """
    value = float(bound) if not isinstance(bound, bool) and isinstance(bound, Real) else math.nan
    if math.isfinite(value) and 0.0 <= value <= (1.0 if kind == "mncc" else math.inf):
        return ""
    return "must be a number from 0 to 1" if kind == "mncc" else "must be a finite number >= 0"
