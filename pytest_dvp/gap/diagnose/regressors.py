"""Effects as terms of equations of motion: what each adds to the rows of `equation_signals.SERIES`."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

from pytest_dvp.gap.diagnose.regression_signals import Signals, lagged, rate_limited, with_play, with_stiction
from pytest_dvp.gap.diagnose.tyre_regressors import RIGID, on_tyres
from pytest_dvp.logs.log_contents import FloatArray

Columns: TypeAlias = Mapping[str, FloatArray]
"""Name of a series -> what is added to it: (m,) fixed, or (m, q) in proportion to q unknowns."""

G = 9.80665  # m/s^2
_LOWEST = 5.0  # m/s, up to which the lowest gear is used
_IDLE = 0.05  # m/s^2, a smaller command means that no pedal is pressed


@dataclasses.dataclass(frozen=True, slots=True)
class Form:
    """An effect: `of(signals, p)` for a parameter p of `grid`; an empty grid: linear in its unknowns, p is not used."""

    name: str
    needs: tuple[str, ...]
    of: Callable[[Signals, float], Columns]
    grid: tuple[float, ...] = ()


def base(s: Signals) -> Columns:
    """What an ideal car would show: the command acts at once, r = v tan(d)/L, no slope, ideal sensors."""
    found = {name: np.zeros(len(s.rows)) for name in s.measured}
    if s.accel is not None:
        found |= {"dv": s.mean(s.accel), "ax": s.mean(s.accel)}
    if s.steer is not None:
        found |= {"r": s.mean(_turn(s, s.steer)), "dyaw": s.mean(_turn(s, s.steer))}
    return {name: values for name, values in found.items() if name in s.measured}


def _accel(s: Signals) -> FloatArray:
    assert s.accel is not None
    return s.accel


def _steer(s: Signals) -> FloatArray:
    assert s.steer is not None
    return s.steer


def _turn(s: Signals, steer: FloatArray) -> FloatArray:
    return np.asarray(s.v * np.tan(np.clip(steer, -1.2, 1.2)) / s.wheelbase)


def _along(s: Signals, accel: FloatArray) -> Columns:
    """Another acceleration in place of the commanded one."""
    change = s.mean(accel - _accel(s))
    return {"dv": change, "ax": change}


def _across(s: Signals, turn: FloatArray) -> Columns:
    """Another yaw rate."""
    change = s.mean(turn - _turn(s, _steer(s)))
    return {"r": change, "dyaw": change}


def _wheel(s: Signals, steer: FloatArray) -> Columns:
    return _across(s, _turn(s, steer))


def _force(s: Signals, *columns: FloatArray) -> Columns:
    found = np.column_stack([s.mean(c) for c in columns])
    return {"dv": found, "ax": found}


def _angle(s: Signals, *columns: FloatArray) -> Columns:
    found = np.column_stack([s.mean(c * s.v / s.wheelbase) for c in columns])
    return {"r": found, "dyaw": found}


def _column(y: FloatArray) -> FloatArray:
    return np.asarray(y[:, None])


def _late_drive(s: Signals, p: float) -> Columns:
    change = s.late_mean(_accel(s), p) - s.mean(_accel(s))
    return {"dv": change, "ax": change}


def _lagging(s: Signals, p: float) -> FloatArray:
    return lagged(_accel(s), np.full(len(s.t), s.step / p))


def _brake_lag(s: Signals, p: float) -> Columns:
    a = _accel(s)
    slow = np.where(a < 0.0, lagged(np.minimum(a, 0.0), np.full(len(a), s.step / p)), a)
    return _along(s, slow)


def _power(s: Signals, p: float) -> Columns:
    return _along(s, np.minimum(_accel(s), p / np.maximum(s.v, 0.1)))


def _dead(s: Signals, p: float) -> Columns:
    a = _accel(s)
    return _along(s, np.where(np.abs(a) < p, 0.0, a))


def _late_steer(s: Signals, p: float) -> Columns:
    late = np.interp(s.t - p, s.t + 0.5 * s.step, _steer(s))  # held: the middle of its step
    return _wheel(s, np.asarray(np.interp(s.t + 0.5 * s.step, s.t, late)))


def _tyres(s: Signals, front: float, rear: float, *, limit: float = np.inf, length: float = 0.0) -> Columns:
    rate, side = on_tyres(s, front, rear, limit=limit, length=length)
    moved = np.gradient(side, s.step)
    return {**_across(s, rate), "sideways": s.mean(side), "ay": s.mean(moved)}


def _understeer(s: Signals, p: float) -> Columns:
    return _tyres(s, RIGID + max(p, 0.0), RIGID + max(-p, 0.0))


def _roll_steer(s: Signals, p: float) -> Columns:
    lean = lagged(s.rate * s.v / G, np.full(len(s.v), s.step / p))
    return _angle(s, -lean)


def _late_gyro(s: Signals, p: float) -> Columns:
    turn = _turn(s, _steer(s))
    later = np.interp(s.t + p, s.t, s.rate)
    return {"r": s.late_mean(turn, p) - s.mean(turn), "ay": s.mean(s.v * (later - s.rate))}


def _late_pose(s: Signals, p: float) -> Columns:
    turn = _turn(s, _steer(s))
    return {"dyaw": s.late_mean(turn, p) - s.mean(turn), "forward": s.late_mean(s.v, p) - s.mean(s.v)}


def _misaligned(s: Signals, p: float) -> Columns:
    ay, ax = s.mean(s.v * s.rate), s.mean(_accel(s))
    return {"ax": _column(ay), "ay": _column(-ax)}


def _radius(s: Signals, p: float) -> Columns:
    found = {"forward": -s.mean(s.v), "ay": -s.mean(s.v * s.rate)}
    if s.accel is not None:
        found["dv"] = s.mean(s.accel)
    if s.steer is not None:
        found["r"] = found["dyaw"] = -s.mean(_turn(s, s.steer))
    return {name: _column(y) for name, y in found.items()}


def _one(s: Signals) -> FloatArray:
    return np.ones(len(s.t))


def _ones(s: Signals) -> FloatArray:
    return np.ones((len(s.rows), 1))


def _ratio(low: float, high: float, count: int = 7) -> tuple[float, ...]:
    return tuple(float(x) for x in np.geomspace(low, high, count))


def _both(low: float, high: float, count: int = 5) -> tuple[float, ...]:
    return (*(-x for x in _ratio(low, high, 3)), *_ratio(low, high, count))


_A, _D = ("accel",), ("steer",)
FORMS: tuple[Form, ...] = (
    Form("drive_delay", _A, _late_drive, _ratio(0.04, 0.6)),
    Form("drive_lag", _A, lambda s, p: _along(s, _lagging(s, p)), _ratio(0.05, 1.0)),
    Form("force_rise", _A, lambda s, p: _along(s, _lagging(s, p)), (0.01, 0.02, 0.04)),
    Form("brake_lag", _A, _brake_lag, _ratio(0.05, 1.0)),
    Form("drive_gain", _A, lambda s, p: _force(s, np.maximum(_accel(s), 0.0))),
    Form("brake_gain", _A, lambda s, p: _force(s, np.minimum(_accel(s), 0.0))),
    Form("mass", _A, lambda s, p: _force(s, _accel(s))),
    Form("gear_inertia", _A, lambda s, p: _force(s, -_accel(s) * np.minimum(_LOWEST / np.maximum(s.v, 0.1), 1.0) ** 2)),
    Form("jerk_limit", _A, lambda s, p: _along(s, rate_limited(_accel(s), p * s.step)), _ratio(0.7, 20.0, 9)),
    Form("power_limit", _A, _power, _ratio(1.0, 40.0, 9)),
    Form("brake_limit", _A, lambda s, p: _along(s, np.maximum(_accel(s), -p)), _ratio(0.7, 9.0, 9)),
    Form("pedal_deadband", _A, _dead, _ratio(0.05, 0.8)),
    Form("lift_off_braking", _A, lambda s, p: _force(s, -(np.abs(_accel(s)) < _IDLE).astype(np.float64))),
    Form("creep", _A, lambda s, p: _force(s, np.maximum(1.0 - s.v / p, 0.0) * (_accel(s) < _IDLE)), (1.0, 2.0, 4.0)),
    Form("rolling_resistance", _A, lambda s, p: _force(s, -_one(s))),
    Form("viscous_resistance", _A, lambda s, p: _force(s, -s.v)),
    Form("aero_drag", _A, lambda s, p: _force(s, -s.v * np.abs(s.v))),
    Form("cornering_drag", _A, lambda s, p: _force(s, -np.abs(s.v * s.rate))),
    Form("road_grade", _A, lambda s, p: {"dv": -G * np.column_stack([s.mean(np.cos(s.yaw)), s.mean(np.sin(s.yaw))])}),
    Form("road_bank", (), lambda s, p: {"ay": G * np.column_stack([s.mean(np.cos(s.yaw)), s.mean(np.sin(s.yaw))])}),
    Form("steer_delay", _D, _late_steer, _ratio(0.03, 0.6)),
    Form("steer_lag", _D, lambda s, p: _wheel(s, lagged(_steer(s), np.full(len(s.t), s.step / p))), _ratio(0.03, 0.8)),
    Form("steer_rate_limit", _D, lambda s, p: _wheel(s, rate_limited(_steer(s), p * s.step)), _ratio(0.04, 1.0, 9)),
    Form("steer_angle_limit", _D, lambda s, p: _wheel(s, np.clip(_steer(s), -p, p)), _ratio(0.05, 0.6, 9)),
    Form("steer_stiction", _D, lambda s, p: _wheel(s, with_stiction(_steer(s), p)), _ratio(0.002, 0.05)),
    Form("steer_backlash", _D, lambda s, p: _wheel(s, with_play(_steer(s), p)), _ratio(0.002, 0.05)),
    Form("steer_ratio", _D, lambda s, p: _angle(s, _steer(s))),
    Form("steer_asymmetry", _D, lambda s, p: _angle(s, np.maximum(_steer(s), 0.0), np.minimum(_steer(s), 0.0))),
    Form("steer_offset", _D, lambda s, p: _angle(s, _one(s))),
    Form("understeer", _D, _understeer, _both(0.0005, 0.02, 7)),
    Form("cornering_compliance", _D, lambda s, p: _tyres(s, p, p), _ratio(0.002, 0.03)),
    Form("tyre_saturation", _D, lambda s, p: _tyres(s, RIGID, RIGID, limit=p), _ratio(1.5, 12.0, 9)),
    Form("tyre_relaxation", _D, lambda s, p: _tyres(s, RIGID, RIGID, length=p), _ratio(0.1, 4.0)),
    Form("roll_dynamics", _D, lambda s, p: _roll_steer(s, 0.2)),
    Form("wheel_radius", (), _radius),
    Form("gyro_bias", (), lambda s, p: {"r": _ones(s), "ay": _column(-s.mean(s.v))}),
    Form("yaw_rate_latency", _D, _late_gyro, _ratio(0.02, 0.5)),
    Form("accelerometer_bias", _A, lambda s, p: {"ax": _ones(s)}),
    Form("lateral_accelerometer_bias", (), lambda s, p: {"ay": _ones(s)}),
    Form("imu_misalignment", _A, _misaligned),
    Form("pitch", _A, lambda s, p: {"ax": _column(s.mean(_accel(s)))}),
    Form("roll", (), lambda s, p: {"ay": _column(s.mean(s.v * s.rate))}),
    Form("heading_bias", (), lambda s, p: {"sideways": _column(-s.mean(s.v))}),
    Form("gnss_latency", _D, _late_pose, _ratio(0.03, 0.6)),
    Form("gnss_lever_arm", (), lambda s, p: {"forward": np.column_stack([0.0 * s.rows, -s.mean(s.rate)]),
                                             "sideways": np.column_stack([s.mean(s.rate), 0.0 * s.rows])}),
)  # fmt: skip
"""Every effect that has such a form. Actuator limits and lags use the commands, drags and sensors what was measured."""
