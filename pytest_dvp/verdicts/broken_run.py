"""Verdicts that say that the run itself broke or lost messages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_RUN_ITSELF = ("run", "wire", "dry run")


def is_of_the_run(verdict: Mapping[str, Any]) -> bool:
    """Whether a verdict says that the run itself broke or lost messages: no choice of gates leaves it out."""
    return not verdict["metric"] and verdict["gate"] in _RUN_ITSELF
