"""Stages: what stands in for the car, and what a result of it is called.

DT is the digital twin in simulated time. In PE a car drives and the simulator supplies the road users; in RW everything
is the car's own. Both need a vehicle, and without a real one they take the surrogate: a car in a process of its own,
with other physics than the twin, on the other side of ROS 2 topics. A result of it says so: "rw-surrogate".
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.settings import STAGES, unknown

if TYPE_CHECKING:
    from vehicle.adapter import Vehicle

SURROGATE = "surrogate"
MISSING = "needs ROS 2 messages on DDS: pip install 'pytest-dvp[ros2]'"


class StageError(ValueError):
    """A stage that does not exist, or for which nothing can stand in for the car."""


def check_stage(stage: str, vehicle: str = SURROGATE, *, require_real: bool = False) -> None:
    """Raises StageError unless a vehicle for `stage` exists and may stand in.

    `vehicle` is "surrogate" or "surrogate:HIDDEN.toml"; `require_real` refuses a surrogate.
    """
    if stage not in STAGES:
        raise StageError(unknown("stage", stage, STAGES))
    if stage == "dt":
        return
    name, colon, hidden = vehicle.partition(":")
    if name != SURROGATE:
        raise StageError(f"{unknown('vehicle', name, [SURROGATE])}; a real car needs real time, which is not built yet")
    if colon and not Path(hidden).is_file():
        raise StageError(f"vehicle {vehicle!r}: no file {hidden}")
    if require_real:
        raise StageError(f"{label(stage)} ERROR: a real vehicle is required, a surrogate is no evidence about a car")
    if not wire_installed():
        raise StageError(f"stage {stage!r} {MISSING}")


def wire_installed() -> bool:
    """Whether the extra `ros2` is there."""
    return importlib.util.find_spec("cyclonedds") is not None


def label(stage: str) -> str:
    """What results of a stage are called: "dt", "pe-surrogate", "rw-surrogate"."""
    return stage if stage == "dt" else f"{stage}-{SURROGATE}"


def open_vehicle(stage: str, vehicle: str, seed: int) -> Vehicle:
    """The car of stage "pe" or "rw", running and waiting. Raises VehicleLost if it does not come."""
    from vehicle.adapters.mirror import Parallel
    from vehicle.adapters.process import surrogate

    hidden = vehicle.partition(":")[2]
    car = surrogate(seed, Path(hidden) if hidden else None)
    return Parallel(car, seed) if stage == "pe" else car
