"""Whether Hypothesis searches for a failing example now."""

from __future__ import annotations

import sys


def searching() -> bool:
    """True inside a `@given` test: many runs, of which only a failing one is worth a folder."""
    hypothesis = sys.modules.get("hypothesis")
    return bool(hypothesis is not None and hypothesis.currently_in_test_context())
