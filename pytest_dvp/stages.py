"""Stages: what stands in for the car.

DT is the digital twin in simulated time. PE and RW need a vehicle adapter; until one exists they raise StageError.
"""

from __future__ import annotations

from pytest_dvp.settings import STAGES, unknown


class StageError(ValueError):
    """A stage that does not exist, or for which nothing can stand in for the car."""


def check_stage(stage: str) -> None:
    """Raises StageError unless a vehicle for `stage` exists."""
    if stage not in STAGES:
        raise StageError(unknown("stage", stage, STAGES))
    if stage != "dt":
        raise StageError(f"stage {stage!r} needs a vehicle adapter, and none exists yet; allowed now: 'dt'")
