"""Cars that other packages announce, and which stage drives a real car.

Nothing automatic may drive a real car; what is not known counts as one. A result of a stand-in says so in its label:
"rw-surrogate".
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from importlib.metadata import entry_points
from typing import TYPE_CHECKING

from pytest_dvp.drive.stages import REPLAY, SURROGATE, VEHICLES, StageError
from pytest_dvp.rooms import side_by_side
from pytest_dvp.text.spelling import unknown

if TYPE_CHECKING:
    from vehicle.adapter import Vehicle

ADAPTERS = "pytest_dvp.adapters"  # entry points


@dataclasses.dataclass(frozen=True)
class Adapter:
    """A vehicle of another package: `open(argument) -> Vehicle`, `is_real` unless it says that it is none.

    `place` is where it is found, "module:name"; `real_time` if it says that its steps take the wall clock's time.
    """

    name: str
    open: Callable[[str], Vehicle]
    is_real: bool
    place: str = ""
    real_time: bool = False


def find_adapter(name: str) -> Adapter:
    """The adapter that a package announces under this name (entry point `pytest_dvp.adapters`).

    The entry point is a class or function that takes what stands behind the colon of `--vehicle NAME:ARGUMENT` and
    gives a Vehicle. Its attribute `is_real` is False for what is no car; without it, it is taken for one. Raises
    StageError.
    """
    points = {point.name: point for point in entry_points(group=ADAPTERS)}
    if name not in points:
        text = unknown("vehicle", name, [*VEHICLES, REPLAY, *points])
        raise StageError(f"{text} (a car of yours: an entry point of {ADAPTERS})")
    try:
        found = side_by_side.load(points[name])
    except Exception as error:  # a foreign package may raise anything while it loads
        raise StageError(f"vehicle {name!r} cannot be loaded: {type(error).__name__}: {error}") from error
    real, real_time = getattr(found, "is_real", True) is not False, getattr(found, "real_time", False) is True
    return Adapter(name, found, real, side_by_side.own_value(points[name]), real_time)


def car_with_guard_apart(vehicle: str) -> Adapter | None:
    """The adapter of a real car whose guard gets a process of its own: one by the wall clock."""
    name = vehicle.partition(":")[0]
    if name in (*VEHICLES, REPLAY):
        return None
    adapter = find_adapter(name)
    return adapter if adapter.is_real and adapter.real_time else None


def label(stage: str, vehicle: str = SURROGATE) -> str:
    """What results of a stage are called: "dt", "pe-surrogate", "rw-surrogate"; of a real car "pe", "rw"; of another
    stand-in "rw-NAME"."""
    name = vehicle.partition(":")[0]
    if stage == "dt":
        return stage
    if name in VEHICLES:
        return f"{stage}-{SURROGATE}"
    return stage if is_real(stage, vehicle) else f"{stage}-{name}"


def is_real(stage: str, vehicle: str) -> bool:
    """Whether a stage drives a real car. What is not known counts as one."""
    name = vehicle.partition(":")[0]
    if stage == "dt" or name in (*VEHICLES, REPLAY):
        return False
    try:
        return find_adapter(name).is_real
    except StageError:
        return True


def may_repeat(stage: str, vehicle: str) -> bool:
    """Whether something automatic may drive this stage: everything but a real car."""
    return not is_real(stage, vehicle)


def refuse_repetition(what: str, stage: str, vehicle: str) -> None:
    """Raises StageError if `what` ("fuzzing", "tuning", "--lf") would drive a real car again and again.

    Nothing automatic drives a real car: one listed scenario for each confirmation by a human.
    """
    if is_real(stage, vehicle):
        raise StageError(
            f"{what} is refused: vehicle {vehicle!r} is real, and nothing automatic drives a real car; "
            f"name one scenario: pytest X.xosc::{label(stage, vehicle)}"
        )
