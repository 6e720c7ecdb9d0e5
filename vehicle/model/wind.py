"""How hard the wind takes hold of a car: coefficients along and across, from its model and its size."""

from __future__ import annotations

from typing import Final

from vehicle.model.vehicle_model import VehicleModel

DENSITY: Final = 1.225  # kg/m^3, air at 15 degrees Celsius and sea level; ISO 2533, standard atmosphere
FRONTAL: Final = 0.81  # of width times height; 0.79 to 0.84 for passenger cars: J. Y. Wong, Theory of Ground Vehicles
DRAG: Final = 0.3  # c_d of a passenger car; W.-H. Hucho, Aerodynamik des Automobils, 5th ed., ch. 4: 0.25 to 0.4
SIDE: Final = 2.2  # 1/rad, side force over the angle of the air; same source, ch. 5: 0.04 per degree; an assumption


def air_coefficients(model: VehicleModel) -> tuple[float, float]:
    """Force of the wind along and across, over `command_mass` and squared speed [1/m].

    Along it is the k of the effect `aero_drag`, if the model has it; else, as across, that of a passenger car of this
    size. Not valid for trucks, open cars and trailers.
    The coefficients were not compared with the print of the named books.
    """
    car = model.car
    pressure = 0.5 * DENSITY * FRONTAL * car.width * car.height / car.command_mass
    return model.value("aero_drag", "k") or DRAG * pressure, SIDE * pressure
