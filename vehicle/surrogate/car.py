"""The numbers of the surrogate: a light electric car in the manner of the TABBY EVO."""

from __future__ import annotations

from dataclasses import dataclass, fields

# may be zero, or below it
_ANY_SIGN = {"rolling_coefficient", "drag_area", "load_sensitivity", "friction_sensitivity", "motor_inertia"}
_ANY_SIGN |= {"motor_rise", "brake_rise", "roll_centre_front", "roll_centre_rear", "curve_shape"}


@dataclass(frozen=True)
class Car:
    """SI units. [paper]: J. F. Arango et al., Sensors 2026, 26, 1338; the rest is plausible for the class.

    Raises ValueError if a length, mass, inertia, stiffness or the like is not positive.
    """

    mass: float = 730.0  # kg [paper]
    wheelbase: float = 2.36  # m [paper]
    cg_to_front_axle: float = 1.20  # m
    cg_height: float = 0.50  # m above ground
    track: float = 1.315  # m [paper]
    yaw_inertia: float = 850.0  # kg m^2
    roll_inertia: float = 230.0  # kg m^2, about the roll axis
    pitch_inertia: float = 800.0  # kg m^2
    roll_stiffness_front: float = 17_000.0  # N m/rad
    roll_stiffness_rear: float = 12_000.0  # N m/rad
    roll_damping: float = 2_200.0  # N m s/rad, both axles
    pitch_stiffness: float = 45_000.0  # N m/rad
    pitch_damping: float = 5_000.0  # N m s/rad
    roll_centre_front: float = 0.05  # m above ground
    roll_centre_rear: float = 0.12  # m
    wheel_radius: float = 0.287  # m [paper: 175/55R15]
    wheel_inertia: float = 0.7  # kg m^2, one wheel
    motor_inertia: float = 0.025  # kg m^2 at the motor shaft
    gear_ratio: float = 5.8  # - [paper]
    motor_torque: float = 128.0  # N m [paper]
    motor_power: float = 29_500.0  # W [paper]
    motor_speed: float = 576.0  # rad/s, 5500 rpm [paper]
    motor_rise: float = 0.02  # s, first-order rise of the motor's torque
    brake_rise: float = 0.05  # s, build-up of the brake's pressure
    brake_front: float = 0.65  # -, share of the front axle
    friction: float = 0.95  # -, at static load
    friction_sensitivity: float = 0.10  # -, loss of friction per relative load
    cornering_front: float = 13.0  # 1/rad, cornering stiffness over load, at static load
    cornering_rear: float = 15.0  # 1/rad
    load_sensitivity: float = 0.5  # -, loss of stiffness coefficient per relative load
    slip_coefficient: float = 18.0  # -, longitudinal stiffness over load
    curve_factor: float = 1.45  # -, C of the Magic Formula
    curve_shape: float = -0.6  # -, E of the Magic Formula
    relaxation_lateral: float = 0.30  # m
    relaxation_longitudinal: float = 0.12  # m
    rolling_coefficient: float = 0.011  # -
    drag_area: float = 0.75  # m^2, c_d A
    full_throttle: float = 3.5  # m/s^2 asked for by throttle 1
    full_brake: float = 7.0  # m/s^2 asked for by brake 1

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if f.name not in _ANY_SIGN and not value > 0.0:
                raise ValueError(f"car.{f.name} is {value:g}; it must be > 0")
        if self.cg_to_front_axle >= self.wheelbase:
            raise ValueError("car.cg_to_front_axle must be less than the wheelbase")

    @property
    def rotating_mass(self) -> float:
        """Mass that turning wheels and motor add along the road [kg]."""
        turning = 4.0 * self.wheel_inertia + self.motor_inertia * self.gear_ratio**2
        return turning / self.wheel_radius**2
