"""Stages: what stands in for the car, and what a result of it is called.

DT is the digital twin in simulated time. In PE a car drives and the simulator supplies the road users; in RW everything
is the car's own. Both need a vehicle, and without a real one they take the surrogate: a car in a process of its own,
with other physics than the twin, on the other side of ROS 2 topics, and of a CAN bus if it is to have a drive-by-wire
there. A result of it says so: "rw-surrogate".
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.settings import STAGES, unknown

if TYPE_CHECKING:
    from vehicle.adapter import Vehicle
    from vehicle.wire.health import Trouble

SURROGATE = "surrogate"
CAN = "can"  # the surrogate with its drive-by-wire on CAN
VEHICLES = (SURROGATE, CAN)
MISSING = "needs ROS 2 messages on DDS: pip install 'pytest-dvp[ros2]'"
MISSING_CAN = "needs python-can and cantools: pip install 'pytest-dvp[ros2,can]'"


class StageError(ValueError):
    """A stage that does not exist, or for which nothing can stand in for the car."""


def check_stage(
    stage: str,
    vehicle: str = SURROGATE,
    *,
    require_real: bool = False,
    dbc: Path | None = None,
    fault: str | None = None,
) -> None:
    """Raises StageError unless a vehicle for `stage` exists and may stand in.

    `vehicle` is "surrogate" or "can", with ":HIDDEN.toml" behind if something is hidden in it; `require_real` refuses a
    surrogate; `dbc` is read, for a vehicle on CAN; `fault` goes on the wire of a surrogate.
    """
    if stage not in STAGES:
        raise StageError(unknown("stage", stage, STAGES))
    if stage == "dt":
        return
    name, colon, hidden = vehicle.partition(":")
    if name not in VEHICLES:
        raise StageError(f"{unknown('vehicle', name, VEHICLES)}; a real car needs real time, which is not built yet")
    if colon and not Path(hidden).is_file():
        raise StageError(f"vehicle {vehicle!r}: no file {hidden}")
    if require_real:
        raise StageError(f"{label(stage)} ERROR: a real vehicle is required, a surrogate is no evidence about a car")
    if not wire_installed():
        raise StageError(f"stage {stage!r} {MISSING}")
    _check_fault(fault)
    if name == CAN:
        _check_can(dbc)
    elif dbc is not None:
        raise StageError(f"--dbc {dbc} is for a vehicle on CAN: --vehicle {CAN}; found {vehicle}")


def _check_fault(fault: str | None) -> None:
    if fault is not None:
        from vehicle.wire.faults import FaultError, parse_fault

        try:
            parse_fault(fault)
        except FaultError as error:
            raise StageError(str(error)) from None


def _check_can(dbc: Path | None) -> None:
    from vehicle.wire.can_map import CanMapError, find_map

    if not all(importlib.util.find_spec(module) for module in ("can", "cantools", "msgpack")):
        raise StageError(f"vehicle {CAN!r} {MISSING_CAN}")
    try:
        find_map(dbc)
    except CanMapError as error:
        raise StageError(str(error)) from None


def wire_installed() -> bool:
    """Whether the extra `ros2` is there."""
    return importlib.util.find_spec("cyclonedds") is not None


def label(stage: str) -> str:
    """What results of a stage are called: "dt", "pe-surrogate", "rw-surrogate"."""
    return stage if stage == "dt" else f"{stage}-{SURROGATE}"


def may_repeat(stage: str, vehicle: str) -> bool:
    """Whether something automatic may drive this stage: everything but a real car."""
    return stage == "dt" or vehicle.partition(":")[0] in VEHICLES


def open_vehicle(
    stage: str,
    vehicle: str,
    seed: int,
    dbc: Path | None = None,
    fault: str | None = None,
    *,
    record: Callable[[Trouble], None] = lambda _: None,
) -> Vehicle:
    """The car of stage "pe" or "rw", running and waiting; arguments as of `check_stage`, which comes before.

    `record` gets every trouble with its messages. Raises VehicleLost if it does not come.
    """
    from vehicle.adapters.mirror import Parallel
    from vehicle.adapters.process import surrogate

    name, _, hidden = vehicle.partition(":")
    can = None
    if name == CAN:
        from vehicle.wire.can_map import find_map

        can = find_map(dbc)
    put = None
    if fault is not None:
        from vehicle.wire.faults import parse_fault

        put = parse_fault(fault)
    car = surrogate(seed, Path(hidden) if hidden else None, can=can, record=record, fault=put)
    return Parallel(car, seed) if stage == "pe" else car
