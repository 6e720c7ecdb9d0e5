"""A measured log of the surrogate: driven by the simple driver, written as CSV with units."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vehicle.messages import Command, FloatArray
from vehicle.surrogate.driver import PERIOD, Drive, Driver, Motion
from vehicle.surrogate.hidden import Hidden
from vehicle.surrogate.surrogate import MEASURED_UNITS, DoubleTrack
from vehicle.surrogate.truth import Truth

COLUMNS = {"t": "s", "accel_cmd": "m/s^2", "steer_cmd": "rad", **MEASURED_UNITS}


def record(hidden: Hidden, drive: Drive, seed: int = 0, truth: Truth | None = None) -> dict[str, FloatArray]:
    """Columns of one drive, each float64 (n,) with the unit that COLUMNS states, at 50 Hz.

    A command logged at t holds from t to the next stamp; a measurement is that of its stamp, after the command of that
    stamp has taken hold (an acceleration answers within the first millisecond). `truth` learns the true motion.
    """
    car = DoubleTrack(hidden, seed=seed)
    driver = Driver(drive, hidden.car.wheelbase, seed)
    table = np.empty((driver.samples, len(COLUMNS)))
    for k in range(driver.samples):
        t = k * PERIOD
        now = car.state
        if truth is not None:
            truth.car(now)
        wish = driver.wish(t, Motion(now.x, now.y, now.yaw, now.v))
        car.apply(Command(t=t, steer=wish.steer, accel=wish.accel, throttle=0.0, brake=0.0))
        car.step(PERIOD)
        shown = car.measure(back=PERIOD - car.dt)
        table[k] = (round(t, 6), wish.accel, wish.steer, *shown.values())
    return {name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(COLUMNS)}


def write_csv(path: Path, columns: dict[str, FloatArray]) -> None:
    """Write columns (n,) of the names in COLUMNS to a CSV file, with a header that names their units."""
    header = ",".join(f"{name} [{COLUMNS[name]}]" for name in columns)
    np.savetxt(path, np.column_stack(list(columns.values())), fmt="%.6g", delimiter=",", header=header, comments="")
