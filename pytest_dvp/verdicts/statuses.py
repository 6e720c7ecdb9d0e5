"""Statuses of verdicts: which is worst, and which come first."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pytest_dvp.text.names import NOT_ASKED
from reports.verdicts import SEVERITY as ORDER
from reports.verdicts import urgency


def worst_first(verdicts: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Verdicts in the order of `reports.verdicts.urgency`."""
    return sorted(verdicts, key=urgency)


def worst_status(verdicts: Iterable[Mapping[str, Any]]) -> str:
    """The worst status of verdicts, as texts."""
    return min((verdict["status"] for verdict in verdicts), key=lambda status: ORDER.get(status, 0), default=NOT_ASKED)
