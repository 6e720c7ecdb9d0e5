"""The car of stages pe and rw behind its guard: in this process, or a real one by the wall clock in its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pytest_dvp.drive.announced_cars import car_with_guard_apart
from pytest_dvp.drive.map_origin import map_origin
from pytest_dvp.drive.open_car import open_vehicle

if TYPE_CHECKING:
    from openscenario.road.network import RoadNetwork
    from pytest_dvp.drive.guard_log import GuardLog
    from pytest_dvp.drive.request import Request
    from vehicle.guard.envelope import Envelope
    from vehicle.guard.guarded_vehicle import GuardedVehicle
    from vehicle.guard.process import GuardProcess
    from vehicle.model.vehicle_model import AppliedEffect


def guarded_car(
    request: Request,
    network: RoadNetwork,
    envelope: Envelope | None,
    gate_log: GuardLog,
    perception: Sequence[AppliedEffect] = (),
) -> GuardedVehicle | GuardProcess:
    """The car that is asked for, on the roads of `network`; `gate_log` gets what its gate decides.

    On stage pe it sees the virtual road users with the effects `perception`. Raises VehicleLost if it does not come.
    """
    name, _, argument = request.spec.vehicle.partition(":")
    max_speed, area = (None, None) if envelope is None else (envelope.max_speed, envelope.area)
    origin = map_origin(network)
    scenario, apart = request.path.name, car_with_guard_apart(request.spec.vehicle)
    if apart is None:
        from vehicle.guard.guarded_vehicle import GuardedVehicle, limits_of

        car, gate_log.punctuality = open_vehicle(
            request.spec, record=gate_log.wire.record, perception=perception, origin=origin
        )
        limits = limits_of(car.description, max_speed=max_speed, area=area)
        keys = request.spec.arming is not None
        return GuardedVehicle(car, limits, name=name, scenario=scenario, record=gate_log.record, keys=keys)
    from vehicle.guard.process import GuardProcess
    from vehicle.guard.process_messages import Opening

    place, parallel = apart.place, request.spec.stage == "pe"
    opening = Opening(place, argument, parallel, request.spec.seed, name, scenario, max_speed, area,
                      {applied.name: dict(applied.values) for applied in perception}, *origin)  # fmt: skip
    held = GuardProcess(opening, record=gate_log.record, trouble=gate_log.wire.record)
    gate_log.punctuality = held.punctuality
    return held
