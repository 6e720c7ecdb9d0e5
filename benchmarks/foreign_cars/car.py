"""Three cars as bodies, joints and springs, and the data sheet that a user would have of each."""

from __future__ import annotations

import dataclasses

GRAVITY = 9.80665
WHEELS = ("fl", "fr", "rl", "rr")
WHEEL_MASS, CARRIER_MASS = 22.0, 18.0  # kg


@dataclasses.dataclass(frozen=True)
class ForeignCar:
    """A car in SI units. spring, damper: of each wheel; anti_roll: N/m between the wheels of an axle; torque_lag,
    brake_lag [s]; drive: share of the drive force at fl, fr, rl, rr; brake_front: share of the brakes in front;
    lateral, longitudinal: stiffness and shape of the tyres' characteristic; friction: at the usual load. arm: length of
    trailing arms on which the wheels hang, 0 for vertical slides; ackermann: share of what the inner wheel of a bend
    needs more of steering, that it has."""

    mass: float
    wheelbase: float
    cg_to_front_axle: float
    track: float
    cg_height: float
    wheel_radius: float
    inertia: tuple[float, float, float]
    spring: float
    damper: float
    anti_roll: float
    torque_lag: float
    brake_lag: float
    drive: tuple[float, float, float, float]
    brake_front: float
    lateral: tuple[float, float]
    longitudinal: tuple[float, float]
    friction: float
    drag_area: float
    rolling: float
    payload: float = 0.0
    arm: float = 0.0
    ackermann: float = 0.0

    @property
    def cg_to_rear_axle(self) -> float:
        """Centre of gravity to rear axle [m]."""
        return self.wheelbase - self.cg_to_front_axle

    @property
    def measures_front(self) -> bool:
        """True if the speed is taken from the front wheels: those that are not driven, rear ones if all are."""
        return self.drive[0] == 0.0


CARS = {
    "hatchback": ForeignCar(
        1180.0, 2.55, 1.02, 1.48, 0.54, 0.300, (420.0, 1500.0, 1750.0), 24e3, 1900.0, 9e3, 0.030, 0.025,
        (0.5, 0.5, 0.0, 0.0), 0.66, (9.5, 1.35), (12.0, 1.60), 1.02, 0.79, 0.012,
    ),
    "pickup": ForeignCar(
        2150.0, 3.25, 1.55, 1.62, 0.78, 0.370, (900.0, 4200.0, 4700.0), 38e3, 3000.0, 4e3, 0.040, 0.040,
        (0.0, 0.0, 0.5, 0.5), 0.60, (7.5, 1.30), (10.0, 1.55), 0.90, 1.65, 0.014,
    ),
    "electric": ForeignCar(
        1850.0, 2.85, 1.40, 1.60, 0.48, 0.335, (650.0, 2700.0, 3000.0), 42e3, 3600.0, 14e3, 0.020, 0.020,
        (0.2, 0.2, 0.3, 0.3), 0.60, (11.0, 1.40), (13.0, 1.60), 1.10, 0.66, 0.009,
    ),
}  # fmt: skip


def mjcf(car: ForeignCar) -> str:
    """The car as a MuJoCo model: a free chassis, four carriers on vertical slides, steered in front, and wheels."""
    unsprung = 4.0 * (WHEEL_MASS + CARRIER_MASS)
    sprung = car.mass + car.payload - unsprung
    arm = (0.5 * car.wheelbase) ** 2 + (0.5 * car.track) ** 2
    ix, iy, iz = car.inertia
    spin = 0.5 * WHEEL_MASS * car.wheel_radius**2
    parts = [
        '<mujoco><compiler angle="radian"/>',
        f'<option timestep="0.001" gravity="0 0 -{GRAVITY}" integrator="implicitfast"/><worldbody>',
        f'<body name="chassis" pos="0 0 {car.cg_height}"><freejoint/>',
        f'<inertial pos="0 0 0" mass="{sprung}" diaginertia="{ix} {iy} {iz - 0.9 * unsprung * arm}"/>',
    ]
    for name in WHEELS:
        front = name[0] == "f"
        x = car.cg_to_front_axle if front else -car.cg_to_rear_axle
        y = 0.5 * car.track * (1.0 if name[1] == "l" else -1.0)
        share = (car.cg_to_rear_axle if front else car.cg_to_front_axle) / car.wheelbase
        rest = -0.5 * sprung * GRAVITY * share / car.spring
        steers = f'<joint name="steer_{name}" type="hinge" axis="0 0 1" damping="60"/>' if front else ""
        hangs = f'type="slide" axis="0 0 1" stiffness="{car.spring}" damping="{car.damper}" springref="{rest}"'
        if car.arm:  # turns about an axis ahead of the wheel, as stiff at the wheel
            square = car.arm**2
            hangs = (
                f'type="hinge" axis="0 1 0" pos="{car.arm} 0 0" stiffness="{car.spring * square}" '
                f'damping="{car.damper * square}" springref="{rest / car.arm}"'
            )
        parts.append(
            f'<body name="carrier_{name}" pos="{x} {y} {car.wheel_radius - car.cg_height}">'
            f'<joint name="slide_{name}" {hangs}/>{steers}'
            f'<inertial pos="0 0 0" mass="{CARRIER_MASS}" diaginertia=".5 .5 .5"/>'
            f'<body name="wheel_{name}"><joint name="spin_{name}" type="hinge" axis="0 1 0"/>'
            f'<inertial pos="0 0 0" mass="{WHEEL_MASS}" diaginertia="{0.55 * spin} {spin} {0.55 * spin}"/>'
            "</body></body>"
        )
    return "".join([*parts, "</body></worldbody></mujoco>"])


def data_sheet(car: ForeignCar) -> str:
    """The model file of a user who has the car's data sheet, its accelerometer being at the centre of gravity."""
    rows = {
        "wheelbase": car.wheelbase,
        "cg_to_front_axle": car.cg_to_front_axle,
        "cg_height": car.cg_height,
        "mass": car.mass,
        "track": car.track,
        "wheel_radius": car.wheel_radius,
        "ax_x": round(car.cg_to_rear_axle, 3),
        "ay_x": round(car.cg_to_rear_axle, 3),
    }
    numbers = "\n".join(f"{name} = {value}" for name, value in rows.items())
    inputs = '[inputs]\nsteer = "steer_cmd"\nlongitudinal = "accel_cmd"'
    return f'[model]\nbase = "kinematic_bicycle"\n{inputs}\n[parameters]\n{numbers}\n'
