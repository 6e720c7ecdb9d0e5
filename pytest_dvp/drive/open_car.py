"""Opens the car of the stages PE and RW, running and waiting for commands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.drive.announced_cars import find_adapter
from pytest_dvp.drive.stages import CAN, REAL, ROS1, VEHICLES, StageError

if TYPE_CHECKING:
    from pytest_dvp.drive.run_spec import RunSpec
    from vehicle.adapter import Vehicle
    from vehicle.model.vehicle_model import AppliedEffect
    from vehicle.wire.geodetic import Origin
    from vehicle.wire.health import Trouble


def hidden_in(vehicle: str) -> Path | None:
    """What is hidden in a surrogate that `check_stage` has let through: a file, or nothing."""
    name, _, argument = vehicle.partition(":")
    if name == ROS1:
        from vehicle.adapters.ros1 import settings_of

        return settings_of(Path(argument) if argument else None)[1]
    return Path(argument) if argument else None


def open_vehicle(
    spec: RunSpec,
    *,
    record: Callable[[Trouble], None] = lambda _: None,
    perception: Sequence[AppliedEffect] = (),
    origin: tuple[Origin | None, str] = (None, ""),
) -> tuple[Vehicle, Callable[[], dict[str, Any]]]:
    """The car of stage "pe" or "rw" of a run, running and waiting; `check_asked` comes before.

    `record` gets every trouble with its messages; with the effects `perception` the car of stage "pe" sees the virtual
    road users; `origin` is where the map lies, or why that is not known. The second result tells how punctual it was,
    for the log; empty in stepped time. Raises VehicleLost if it does not come.
    """
    from vehicle.adapters.mirror import in_parallel

    stage, seed = spec.stage, spec.seed
    name, _, hidden = spec.vehicle.partition(":")
    if name not in VEHICLES:
        return _open_adapter(stage, spec.vehicle, seed, perception, record, origin)
    within, options = hidden_in(spec.vehicle), dict[str, Any](record=record)
    if spec.truth is not None:
        options["truth"] = spec.truth
    if name == ROS1:
        from vehicle.adapters.ros1 import by_ros1, settings_of

        options |= by_ros1(settings_of(Path(hidden) if hidden else None)[0])
    if name == CAN:
        from vehicle.wire.can_map import find_map

        options["can"] = find_map(spec.dbc)
    if spec.fault is not None:
        from vehicle.wire.faults import parse_fault

        options["fault"] = parse_fault(spec.fault)
    if spec.clock == REAL:
        from vehicle.adapters.live import live_surrogate

        live = live_surrogate(seed, within, **options)
        return (in_parallel(live, seed, perception) if stage == "pe" else live), lambda: live.punctuality.as_dict()
    from vehicle.adapters.process import surrogate

    car = surrogate(seed, within, **options)
    return (in_parallel(car, seed, perception) if stage == "pe" else car), dict


def _open_adapter(
    stage: str,
    vehicle: str,
    seed: int,
    perception: Sequence[AppliedEffect],
    record: Callable[[Trouble], None],
    origin: tuple[Origin | None, str],
) -> tuple[Vehicle, Callable[[], dict[str, Any]]]:
    from vehicle.adapter import KnowsItsMap, ReportsMessageFaults, Vehicle
    from vehicle.adapters.mirror import in_parallel

    name, _, argument = vehicle.partition(":")
    adapter = find_adapter(name)
    car = adapter.open(argument)
    if not isinstance(car, Vehicle):
        raise StageError(f"vehicle {vehicle!r}: {type(car).__name__} is no Vehicle (vehicle.adapter.Vehicle)")
    if car.is_real and not adapter.is_real:
        car.close()
        raise StageError(f"vehicle {vehicle!r} announces that it is not real, and its car says it is")
    if isinstance(car, ReportsMessageFaults):
        car.tell(record)
    if isinstance(car, KnowsItsMap):
        car.locate_map(*origin)

    def told() -> dict[str, Any]:
        """A method of the car, or what has one: a new object for each run."""
        kept = getattr(car, "punctuality", dict)
        return dict(getattr(kept, "as_dict", kept)())

    return (in_parallel(car, seed, perception) if stage == "pe" else car), told
