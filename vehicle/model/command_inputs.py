"""From log columns to the commands of the kernel: pedals, motor current, brake pressure, normalised steering.

The scales of a map are numbers of the model file's [inputs] and can be fitted like those of an effect: INPUT_KEYS,
under the name "inputs".
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vehicle.messages import FloatArray
from vehicle.model.effect import Key
from vehicle.model.errors import ModelError, nearest_name

PEDAL_ACCELERATION = 3.0  # m/s^2 of full throttle, where nothing is declared
PEDAL_DECELERATION = 6.0  # m/s^2 of full brake, where nothing is declared
NORMALISED_STEER = 0.4  # rad at the road wheel for 1 of a normalised steering input, where nothing is declared
FULL_CURRENT = 100.0  # A that count as full throttle, where nothing is declared
FULL_PRESSURE = 5e6  # Pa that count as full brake, where nothing is declared

LONGITUDINAL = (
    "accel_cmd",
    "throttle_cmd + brake_cmd",
    "throttle_cmd + brake_pressure",
    "throttle_cmd",
    "motor_current",
    "speed_cmd",
    "v",
)
MEASURED = ("steer", "v")  # columns that are measured, not commanded: straight between stamps instead of held

SMOOTHED = 0.1  # s; chosen: a body takes as long to pitch, and 0.02 m/s of noise at 50 Hz become 0.1 m/s^2, not 1
NEAREST = 3  # columns that a message names

INPUT_KEYS: tuple[Key, ...] = (
    Key("steer_scale", "rad", 0.02, 1.5, 1.0, 0.01, meaning="road-wheel angle per unit of the steering input"),
    Key("steer_zero", "rad", -0.1, 0.1, 0.0, 0.002, meaning="road-wheel angle at steering input 0"),
    Key("full_throttle", "m/s^2", 0.2, 15.0, PEDAL_ACCELERATION, 0.05, 0.0, 50.0, "acceleration of full throttle"),
    Key("full_brake", "m/s^2", 0.2, 15.0, PEDAL_DECELERATION, 0.05, 0.0, 50.0, "deceleration of full brake"),
)
"""What can be fitted of an input map, as ("inputs", name); `neutral` is the value where nothing is declared."""


@dataclass(frozen=True, slots=True)
class Inputs:
    """Which log columns drive the model, and what they mean.

    Road-wheel angle [rad] = steer_zero + steer_scale * column. Full throttle and brake ask for `full_throttle`,
    `full_brake` [m/s^2]; a motor current [A] of `full_current` is full throttle (negative: brake), a brake pressure
    [Pa] of `full_pressure` is full brake.
    """

    steer: str = "steer_cmd"
    longitudinal: tuple[str, ...] = ("accel_cmd",)
    full_throttle: float = PEDAL_ACCELERATION
    full_brake: float = PEDAL_DECELERATION
    steer_scale: float = 1.0
    steer_zero: float = 0.0
    full_current: float = FULL_CURRENT
    full_pressure: float = FULL_PRESSURE

    @property
    def columns(self) -> tuple[str, ...]:
        """The log columns that a replay needs."""
        return (self.steer, *self.longitudinal)

    @property
    def by_a_stack(self) -> bool:
        """Whether the commands of a driving stack, accelerations and pedals, can drive the model."""
        return self.longitudinal not in (("speed_cmd",), ("v",), ("motor_current",))


def default_steer_scale(column: str) -> float:
    """[rad] per unit: 1 for an angle, NORMALISED_STEER for a column that says it is normalised."""
    return NORMALISED_STEER if "norm" in column else 1.0


def command_table(inputs: Inputs, t: FloatArray, columns: Mapping[str, npt.ArrayLike]) -> tuple[FloatArray, FloatArray]:
    """Commands of the kernel (n, 6), and the slopes (n, 2) of steering [rad] and imposed speed [m/s] over each step.

    t: (n,) stamps [s]. The columns of the first are those of COMMAND_COLUMNS, in SI units; where the speed is imposed,
    accel_cmd is its smoothed slope [m/s^2], from which the loads of the axles and the forces of the wheels follow.

    Raises ModelError if a column is missing, has another length or no finite value.
    """
    count = len(t)
    table, slopes = np.zeros((count, 6)), np.zeros((count, 2))
    table[:, 0] = _column(columns, inputs.steer, count)
    if inputs.steer in MEASURED:
        slopes[:-1, 0] = np.diff(table[:, 0])
    for name in inputs.longitudinal:
        values = _column(columns, name, count)
        if name == "v":
            table[:, 5] = values
            slopes[:-1, 1] = np.diff(values)
            table[:, 1] = _smoothed_slope(t, values)
        elif name == "motor_current":
            table[:, 2] = np.maximum(values, 0.0) / inputs.full_current
            table[:, 3] = np.maximum(-values, 0.0) / inputs.full_current
        elif name == "brake_pressure":
            table[:, 3] = values / inputs.full_pressure
        else:
            table[:, {"accel_cmd": 1, "throttle_cmd": 2, "brake_cmd": 3, "speed_cmd": 4}[name]] = values
    return table, slopes


def _smoothed_slope(t: FloatArray, values: FloatArray) -> FloatArray:
    """Slope of the line through the values within SMOOTHED of each stamp and through both neighbours, (n,)."""
    count = len(t)
    total, ones = np.zeros((4, count)), np.ones(count)  # sums of t, v, t t, t v over what is near, from each stamp on
    for step in range(1, count):
        apart = t[step:] - t[:-step]
        near = (apart <= SMOOTHED + 1e-6) | (step == 1)  # stamps are rounded
        if not near.any():
            break
        change = np.where(near, values[step:] - values[:-step], 0.0)
        apart = np.where(near, apart, 0.0)
        for one, sign in ((slice(None, -step), 1.0), (slice(step, None), -1.0)):
            total[:, one] += (sign * apart, sign * change, apart * apart, apart * change)
            ones[one] += near
    spread = ones * total[2] - total[0] * total[0]
    return np.asarray(np.divide(ones * total[3] - total[0] * total[1], spread, out=np.zeros(count), where=spread > 0.0))


def _column(columns: Mapping[str, npt.ArrayLike], name: str, count: int) -> FloatArray:
    if name not in columns:
        near = nearest_name(name, columns)
        has = ", ".join(difflib.get_close_matches(name, list(columns), n=NEAREST, cutoff=0.0))
        text = f"the log lacks this input of the model; nearest of its {len(columns)} columns: {has}"
        raise ModelError(text, key=name, nearest=near)
    values = np.array(columns[name], dtype=np.float64)
    if values.shape != (count,):
        raise ModelError("column has another length than t", key=name, found=str(values.shape), allowed=f"({count},)")
    good = np.isfinite(values)
    if not good.any():
        raise ModelError("column has no value", key=name)
    if good.all():
        return values
    last = np.maximum.accumulate(np.where(good, np.arange(count), -1))
    return np.asarray(values[np.where(last < 0, int(np.argmax(good)), last)])
