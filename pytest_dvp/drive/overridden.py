"""What is left of a stack's command where the scenario holds pedals, wheel or gear of the ego."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from openscenario.storyboard.controls import Controls
    from vehicle.messages import Command, VehicleDescription


def overridden(command: Command, controls: Controls | None, car: VehicleDescription) -> Command:
    """The command with what an OverrideControllerValueAction has set in the place of the stack's wishes.

    Full throttle stands for the car's largest acceleration, full brake for its largest deceleration. A clutch that is
    pressed and a neutral gear take the drive away; the model has no reverse gear, so neither drives it backwards.
    """
    if controls is None or not controls.held:
        return command
    throttle, brake, angle = controls.value("throttle"), controls.braked, controls.road_wheel
    share = max(controls.engaged, 0.0)
    pull = max(command.accel, 0.0) if throttle is None else throttle * car.max_acceleration
    slow = min(command.accel, 0.0) if brake is None else -brake * car.max_deceleration
    if controls.value("brake") is None and command.brake > 0.0:  # a parking brake does not release the pedal
        slow = min(slow, command.accel)
        brake = max(brake or 0.0, command.brake)
    return msgspec.structs.replace(
        command,
        steer=command.steer if angle is None else min(max(angle, -car.max_steer), car.max_steer),
        accel=slow if slow < 0.0 else share * pull,
        throttle=share * (command.throttle if throttle is None else throttle),
        brake=command.brake if brake is None else brake,
    )
