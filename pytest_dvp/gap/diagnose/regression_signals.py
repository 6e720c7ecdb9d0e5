"""Measured signals as equations see them: averages and differences over windows of 0.2 s, with their noise.

Over the window from row i - w to row i + w, the difference of a measured speed is the mean of the acceleration in it,
exactly; so an equation is judged on means of its right side and on means or differences of what was measured.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from machine_code import compiled
from pytest_dvp.gap.compare.compared_model import ModelSubject, rows_with_commands, unheeded_rows
from pytest_dvp.gap.compare.noise_floor import sigma
from pytest_dvp.gap.compare.segments import AWAKE, CHANNELS, longest_step, measured_array, stands_for
from pytest_dvp.gap.compare.smoothed_motion import bridged, mean_around, motion
from pytest_dvp.gap.compare.start_correction import BoolArray, IntArray
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.vehicle_model import VehicleModel

HALF_WINDOW = 0.1  # s
SLOWEST = 0.8  # m/s, below which no equation is judged; of a small car
SLOW_SHARE = 0.1  # of its usual top speed, if that is less
MOSTLY = 0.5  # of a log, in which a channel is known whose holes are looked at: else little would be left. Chosen
SERIES = ("dv", "ax", "r", "dyaw", "ay", "forward", "sideways")
"""Rows of equations: dv/dt; accelerometer; yaw rate; d yaw/dt; lateral acceleration less v r; speed over ground ahead,
less v; speed over ground to the left."""
STEERED = ("r", "dyaw")
"""Of SERIES, those that follow from the commanded steering."""


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Signals:
    """A log on a uniform time base of `step` [s].

    cg_front [m] from the front axle to the centre of gravity, gyration [m^2] yaw inertia over mass.
    (n,): v, rate, yaw smoothed; accel, steer commanded (None: not known). rows (m,): where equations are judged, none
    beside a hole of the log or where somebody else drove; w half the window in rows. measured, noise: by name of SERIES
    what was measured at those rows and its standard deviation.
    """

    step: float
    w: int
    rows: IntArray
    t: FloatArray
    v: FloatArray
    rate: FloatArray
    yaw: FloatArray
    accel: FloatArray | None
    steer: FloatArray | None
    wheelbase: float
    cg_front: float
    gyration: float
    measured: dict[str, FloatArray]
    noise: dict[str, float]

    def mean(self, y: FloatArray) -> FloatArray:
        """Mean (m,) of y (n,) over each window, in the unit of y."""
        total = np.concatenate([[0.0], np.cumsum(y)])
        return np.asarray((total[self.rows + self.w] - total[self.rows - self.w]) / (2 * self.w))

    def late_mean(self, y: FloatArray, by: float) -> FloatArray:
        """Mean of y (n,), held from row to row, `by` [s] old."""
        total = np.concatenate([[0.0], np.cumsum(y)])
        place = np.arange(len(total), dtype=np.float64)
        shift = by / self.step
        end = np.interp(self.rows + self.w - shift, place, total)
        return np.asarray((end - np.interp(self.rows - self.w - shift, place, total)) / (2 * self.w))


def signals(log: Log, model: VehicleModel) -> Signals:
    """Signals of a log. Raises CompareError if a command that drives the model is not there."""
    m = motion(log, model)
    t = np.arange(log.t[0], log.t[-1] + 0.5 * m.step, m.step)
    last = np.clip(np.searchsorted(log.t, t + 0.25 * m.step, side="right") - 1, 0, len(log.t) - 1)
    raw = measured_array(log.columns)
    w = max(2, round(HALF_WINDOW / m.step))
    known = {c: np.isfinite(raw[:, k]).sum() > 100 for k, c in enumerate(CHANNELS)}
    of = {c: np.interp(t, log.t, bridged(log.t, raw[:, k])) for k, c in enumerate(CHANNELS) if known[c]}
    noise = {c: max(sigma(log.t, raw[:, CHANNELS.index(c)]), 1e-9) for c in of}
    v, rate, yaw = (np.interp(t, log.t, y) for y in (m.v, m.yaw_rate, m.yaw))
    slowest = min(SLOWEST, SLOW_SHARE * float(np.quantile(np.abs(v), 0.95)))
    moves = mean_around((np.abs(v) > slowest).astype(np.float64), 2 * w) > 0.999
    told = _told(log, model, raw)[last] & (t - log.t[last] <= longest_step(log.t))
    holes = np.concatenate([[0], np.cumsum(~told)])
    asleep = round(AWAKE / m.step)  # rows in which an actuator still follows the commands of the hole before them
    told = holes[np.minimum(np.arange(len(t)) + w + 1, len(t))] == holes[np.maximum(np.arange(len(t)) - w - asleep, 0)]
    rows = np.arange(w, len(t) - w, w)
    rows = rows[moves[rows] & told[rows]]
    found = Signals(t=t, step=m.step, w=w, rows=rows, v=v, rate=rate, yaw=mean_around(yaw, w),
                    accel=None if m.accel is None else m.accel[last], steer=None if m.steer is None else m.steer[last],
                    wheelbase=m.wheelbase,
                    cg_front=model.car.cg_to_front_axle, gyration=model.car.yaw_inertia / model.car.mass,
                    measured={}, noise={})  # fmt: skip
    _judged(found, of, noise)
    return found


def _told(log: Log, model: VehicleModel, raw: FloatArray) -> BoolArray:
    """Rows (n,) of a log in which the car obeys known commands and no channel is bridged that the log mostly has.

    raw (n, 8): the measured channels in their units.
    """
    subject = ModelSubject(model, "model")
    commands = [stands_for(log.t, rows) for rows in rows_with_commands(log, subject)]
    channels = [stands_for(log.t, rows) for rows in np.isfinite(raw).T if rows.any()]
    mostly = [rows for rows in channels if rows.mean() > MOSTLY]
    return np.asarray(np.logical_and.reduce([~unheeded_rows(log, subject), *commands, *mostly]))


def _judged(s: Signals, of: dict[str, FloatArray], noise: dict[str, float]) -> None:
    average, difference = 1.0 / np.sqrt(2.0 * s.w), np.sqrt(2.0) / (2.0 * s.w * s.step)

    def put(name: str, values: FloatArray, level: float) -> None:
        s.measured[name], s.noise[name] = values, level

    def slope(y: FloatArray) -> FloatArray:
        return np.asarray((y[s.rows + s.w] - y[s.rows - s.w]) / (2.0 * s.w * s.step))

    if "v" in of and s.accel is not None:
        put("dv", slope(of["v"]), noise["v"] * difference)
    if "ax" in of and s.accel is not None:
        put("ax", s.mean(of["ax"]), noise["ax"] * average)
    if "yaw_rate" in of and s.steer is not None:
        put("r", s.mean(of["yaw_rate"]), noise["yaw_rate"] * average)
    if "yaw" in of and s.steer is not None:
        put("dyaw", slope(of["yaw"]), noise["yaw"] * difference)
    if "ay" in of:
        usual = float(np.sqrt(np.mean(s.v**2)))
        rate = of.get("yaw_rate", s.rate)  # as measured: smoothed twice it would fall short of ay
        put("ay", s.mean(of["ay"] - s.v * rate), average * float(np.hypot(noise["ay"],
            usual * noise.get("yaw_rate", 0.0))))  # fmt: skip
    if "x" in of and "y" in of and "yaw" in of and "v" in of:
        x, y, c, d = slope(of["x"]), slope(of["y"]), s.mean(np.cos(s.yaw)), s.mean(np.sin(s.yaw))
        level = max(noise["x"], noise["y"]) * difference
        put("forward", c * x + d * y - s.mean(of["v"]), level)
        put("sideways", c * y - d * x, float(np.hypot(level, noise["yaw"] * average * float(np.mean(np.abs(s.v))))))


@compiled
def lagged(u: FloatArray, share: FloatArray) -> FloatArray:
    """First-order lag (n,) of held u (n,), mean over each step, in the unit of u; share (n,): step by time constant."""
    y = np.empty_like(u)
    state = u[0]
    for i in range(len(u)):
        s = share[i]
        rest = np.exp(-s)
        y[i] = u[i] + (state - u[i]) * (1.0 - rest) / s if s > 1e-9 else state
        state = u[i] + (state - u[i]) * rest
    return y


@compiled
def rate_limited(u: FloatArray, most: float) -> FloatArray:
    """u (n,) followed with at most `most` a step, mean over each step; result (n,) and `most` in the unit of u."""
    y = np.empty_like(u)
    state = u[0]
    for i in range(len(u)):
        moved = min(max(u[i] - state, -most), most)
        y[i] = state + moved * (1.0 - 0.5 * abs(moved) / most)
        state += moved
    return y


@compiled
def with_play(u: FloatArray, half: float) -> FloatArray:
    """u (n,) behind play of +-half; result (n,) and `half` in the unit of u."""
    y = np.empty_like(u)
    state = u[0]
    for i in range(len(u)):
        state = min(max(state, u[i] - half), u[i] + half)
        y[i] = state
    return y


@compiled
def with_stiction(u: FloatArray, width: float) -> FloatArray:
    """u (n,) followed only when it is `width` away; result (n,) and `width` in the unit of u."""
    y = np.empty_like(u)
    state = u[0]
    for i in range(len(u)):
        if abs(u[i] - state) >= width:
            state = u[i]
        y[i] = state
    return y
