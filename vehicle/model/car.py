"""Base parameters of a car: everything known without driving it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from vehicle.model.bus import GRAVITY
from vehicle.model.declared_parameter import Declaration
from vehicle.model.errors import ModelError, nearest_name

STIFFNESS_PER_LOAD = 12.0  # 1/rad, cornering stiffness over axle load of a road tyre; Pacejka, 3rd ed., sec. 1.2: 5..25
STIFF_AXLE = 48.0  # 1/rad, of a kinematic car that gets tyres by an effect: 0.12 deg of slip at 1 m/s^2

CAR_DECLARATIONS: tuple[Declaration, ...] = (
    Declaration("wheelbase", "m", 0.0, 20.0, "front axle to rear axle", positive=True),
    Declaration("cg_to_front_axle", "m", 0.0, 20.0, "centre of gravity to front axle; default half the wheelbase"),
    Declaration("cg_height", "m", 0.0, 5.0, "centre of gravity above ground", 0.5),
    Declaration("mass", "kg", 0.0, 1e5, "mass as driven", 1000.0, positive=True),
    Declaration("command_mass", "kg", 0.0, 1e5, "mass for which commanded accelerations hold; default mass"),
    Declaration("yaw_inertia", "kg m^2", 0.0, 1e7, "about z at the centre of gravity; default m a b"),
    Declaration("cornering_stiffness_front", "N/rad", 0.0, 1e7, "of the front axle; default 12/rad of its load"),
    Declaration("cornering_stiffness_rear", "N/rad", 0.0, 1e7, "of the rear axle; default 12/rad of its load"),
    Declaration("wheel_radius", "m", 0.0, 2.0, "rolling radius of the driven wheels", 0.3, positive=True),
    Declaration("gear_ratio", "-", 0.0, 100.0, "motor turns per turn of the driven wheels", 1.0, positive=True),
    Declaration("length", "m", 0.0, 30.0, "of the bounding box", 4.0, positive=True),
    Declaration("width", "m", 0.0, 5.0, "of the bounding box", 1.8, positive=True),
    Declaration("height", "m", 0.0, 5.0, "of the bounding box", 1.5, positive=True),
    Declaration("center_x", "m", -10.0, 20.0, "rear axle forward to the middle of the box; default half the wheelbase"),
    Declaration("track", "m", 0.0, 5.0, "between the wheels of an axle", 1.5, positive=True),
    Declaration("ax_x", "m", -20.0, 20.0, "point ahead of the rear axle for which a log gives ax", 0.0),
    Declaration(
        "ay_x", "m", -20.0, 20.0, "the same for ay; often cg_to_rear_axle, = wheelbase - cg_to_front_axle", 0.0
    ),
    Declaration("max_speed", "m/s", 0.0, 150.0, "top speed", 50.0, positive=True),
)
_BY_NAME = {d.name: d for d in CAR_DECLARATIONS}


@dataclass(frozen=True, slots=True)
class Car:
    """Base parameters, complete and checked; units and meaning in CAR_DECLARATIONS."""

    wheelbase: float
    cg_to_front_axle: float
    cg_height: float
    mass: float
    command_mass: float
    yaw_inertia: float
    cornering_stiffness_front: float
    cornering_stiffness_rear: float
    wheel_radius: float
    gear_ratio: float
    length: float
    width: float
    height: float
    center_x: float
    track: float
    ax_x: float
    ay_x: float
    max_speed: float

    @property
    def cg_to_rear_axle(self) -> float:
        """[m]"""
        return self.wheelbase - self.cg_to_front_axle

    def stiffness(self, *, stiff: bool = False) -> tuple[float, float]:
        """Cornering stiffness of front and rear axle [N/rad]; `stiff`: STIFF_AXLE where only the default is known."""
        if stiff and self.at_default.issuperset(("cornering_stiffness_front", "cornering_stiffness_rear")):
            load = self.mass * GRAVITY / self.wheelbase
            return STIFF_AXLE * (load * self.cg_to_rear_axle), STIFF_AXLE * (load * self.cg_to_front_axle)
        return self.cornering_stiffness_front, self.cornering_stiffness_rear

    @property
    def at_default(self) -> frozenset[str]:
        """Names of yaw inertia and stiffnesses that are what follows from mass and axles if a file does not say."""
        defaults = _defaults_of_mass(self.mass, self.wheelbase, self.cg_to_front_axle)
        return frozenset(name for name, value in defaults.items() if getattr(self, name) == value)

    def values(self) -> dict[str, float]:
        """All parameters by name."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    def with_values(self, values: Mapping[str, float]) -> Car:
        """A car with some parameters changed. Raises ModelError.

        Yaw inertia and stiffnesses that follow from mass and axles (`at_default`) follow them again; all else is kept.
        """
        old = self.values()
        moved = any(values.get(name, old[name]) != old[name] for name in ("mass", "wheelbase", "cg_to_front_axle"))
        follow = self.at_default if moved else ()
        return make_car(
            {name: value for name, value in {**old, **values}.items() if name in values or name not in follow}
        )


def _defaults_of_mass(mass: float, wheelbase: float, front: float) -> dict[str, float]:
    """Yaw inertia and stiffnesses of a car whose centre of gravity is `front` [m] behind the front axle."""
    rear = wheelbase - front
    return {
        "yaw_inertia": mass * front * rear,
        "cornering_stiffness_front": STIFFNESS_PER_LOAD * (mass * GRAVITY / wheelbase * rear),
        "cornering_stiffness_rear": STIFFNESS_PER_LOAD * (mass * GRAVITY / wheelbase * front),
    }


def make_car(values: Mapping[str, float]) -> Car:
    """A car from the parameters given; the others get their declared defaults.

    Raises ModelError: unknown name (with the nearest), value out of range, wheelbase missing, centre of gravity not
    between the axles.
    """
    for name, value in values.items():
        if name not in _BY_NAME:
            raise ModelError(
                "unknown parameter",
                key=name,
                found=name,
                allowed=", ".join(_BY_NAME),
                nearest=nearest_name(name, _BY_NAME),
            )
        _BY_NAME[name].check(value)
    if "wheelbase" not in values:
        raise ModelError("missing", key="wheelbase", allowed="more than 0 to 20 m")
    full = {d.name: d.default for d in CAR_DECLARATIONS if d.default is not None}
    full |= values
    wheelbase, mass = full["wheelbase"], full["mass"]
    front = full.setdefault("cg_to_front_axle", wheelbase / 2)
    if not 0.0 < front < wheelbase:
        raise ModelError(
            "centre of gravity must lie between the axles",
            key="cg_to_front_axle",
            found=f"{front:g}",
            allowed=f"more than 0 and less than the wheelbase {wheelbase:g} m",
        )
    full.setdefault("command_mass", mass)
    full = {**_defaults_of_mass(mass, wheelbase, front), **full}
    full.setdefault("center_x", wheelbase / 2)
    for name in ("yaw_inertia", "cornering_stiffness_front", "cornering_stiffness_rear", "command_mass"):
        if full[name] <= 0.0:
            raise ModelError("must be more than zero", key=name, found=f"{full[name]:g}")
    return Car(**full)
