"""Laws that no catalogue has, as effects of the twin's kernel: from the literature or plainly possible.

Most of them are products that the grammar of `discover` has, or two of these; three are not (an exponential, a
threshold, a power taken from the axle). The last six kinds were written after the method stood; nothing was changed
after them.
Two kinds of earlier draws are gone: what the catalogue has as cornering_drag and lift_off_braking is not outside it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import exp
from typing import Any

from vehicle.model.effect import Effect, Key, Memory, Slot
from vehicle.model.step_maths import lag_end


def torque_steer(x: Any, p: Any, m: Any) -> None:
    x.steer += p.c * max(x.accel, 0.0)


def brake_pull(x: Any, p: Any, m: Any) -> None:
    x.steer += p.c * max(-x.accel, 0.0) * x.vx


def lift_steer(x: Any, p: Any, m: Any) -> None:
    x.steer += p.c * x.steer * x.ax


def speed_gain(x: Any, p: Any, m: Any) -> None:
    x.accel += p.c * x.vx * max(x.accel, 0.0)


def churning(x: Any, p: Any, m: Any) -> None:
    x.drag -= p.c * x.mass_ref * x.vx * x.vx * x.vx


def hot_motor(x: Any, p: Any, m: Any) -> None:
    m.h = lag_end(m.h, x.vx * max(x.accel, 0.0), p.tau, x.dt)
    x.accel -= p.c * max(x.accel, 0.0) * m.h


def tyre_heat(x: Any, p: Any, m: Any) -> None:
    m.h = lag_end(m.h, abs(x.ay) * x.vx, p.tau, x.dt)
    x.steer -= p.c * x.steer * m.h


def root_drag(x: Any, p: Any, m: Any) -> None:
    x.drag -= p.c * x.mass_ref * max(x.vx, 0.0) ** 0.5


def exponential_gain(x: Any, p: Any, m: Any) -> None:
    x.steer *= 1.0 - p.c * (1.0 - exp(-abs(x.steer) / 0.05))


def brake_threshold(x: Any, p: Any, m: Any) -> None:
    if x.accel < -1.0:
        x.accel += p.c * (-x.accel - 1.0)


def drive_and_turn(x: Any, p: Any, m: Any) -> None:
    x.steer += p.c * x.steer * max(x.accel, 0.0)
    x.accel -= 10.0 * p.c * abs(x.steer) * max(x.accel, 0.0)


def gyro_by_acceleration(x: Any, p: Any, m: Any) -> None:
    x.meas_yaw_rate += p.c * x.ax


def speed_by_cornering(x: Any, p: Any, m: Any) -> None:
    x.meas_v += p.c * abs(x.ay)


def boost(x: Any, p: Any, m: Any) -> None:
    m.h = lag_end(m.h, max(x.accel, 0.0), p.tau, x.dt)
    x.accel += p.c * max(x.accel, 0.0) * m.h


def cubic_steer(x: Any, p: Any, m: Any) -> None:
    x.steer += p.c * x.steer * x.steer * x.steer


def cross_axis_gyro(x: Any, p: Any, m: Any) -> None:
    x.meas_yaw_rate += p.c * x.ay


def servo_sag(x: Any, p: Any, m: Any) -> None:
    x.steer -= p.c * x.steer * abs(x.ay)


def wet_disc(x: Any, p: Any, m: Any) -> None:
    x.accel += p.c * x.vx * max(-x.accel, 0.0)


def slosh(x: Any, p: Any, m: Any) -> None:
    m.h = lag_end(m.h, x.ay, p.tau / 20.0, x.dt)
    x.steer += p.c * m.h


def wheel_growth(x: Any, p: Any, m: Any) -> None:
    x.meas_v += p.c * x.vx * x.vx


def alternator(x: Any, p: Any, m: Any) -> None:
    x.drag -= p.c * x.mass_ref * min(x.vx, 1.0) / max(x.vx, 1.0)


def surge(x: Any, p: Any, m: Any) -> None:
    pedal = max(-x.accel, 0.0)
    m.h = lag_end(m.h, pedal, p.tau / 20.0, x.dt)
    x.accel += p.c * (pedal - m.h)


_LAWS: Mapping[str, tuple[Slot, Callable[[Any, Any, Any], None], float, float, str]] = {
    # slot, law, range of c, and the form that is true ("" where the grammar has none)
    "torque_steer": ("command", torque_steer, 0.003, 0.012, "a+"),
    "brake_pull": ("command", brake_pull, 0.0006, 0.002, "v a-"),
    "lift_steer": ("command", lift_steer, -0.4, -0.15, "d ax"),
    "speed_gain": ("command", speed_gain, -0.05, -0.015, "v a+"),
    "churning": ("force", churning, 1e-4, 6e-4, "v v v"),
    "hot_motor": ("command", hot_motor, 0.01, 0.04, "a+ lag(v a+)"),
    "tyre_heat": ("command", tyre_heat, 0.01, 0.03, "d lag(v |ay|)"),
    "root_drag": ("force", root_drag, 0.05, 0.2, "sqrt(v)"),
    "exponential_gain": ("command", exponential_gain, 0.08, 0.25, ""),
    "brake_threshold": ("command", brake_threshold, 0.2, 0.6, ""),
    "drive_and_turn": ("command", drive_and_turn, -0.5, -0.2, "d a+; |d| a+"),
    "gyro_by_acceleration": ("sensor", gyro_by_acceleration, 0.01, 0.03, "ax"),
    "speed_by_cornering": ("sensor", speed_by_cornering, 0.03, 0.08, "|ay|"),
    "boost": ("command", boost, 0.15, 0.4, "a+ lag(a+)"),
    "cubic_steer": ("command", cubic_steer, -4.0, -1.0, "d d d"),
    "cross_axis_gyro": ("sensor", cross_axis_gyro, 0.006, 0.015, "ay"),
    "servo_sag": ("command", servo_sag, 0.01, 0.04, "d |ay|"),
    "wet_disc": ("command", wet_disc, 0.01, 0.04, "v a-"),
    "slosh": ("command", slosh, 0.001, 0.004, "lag(ay)"),
    "wheel_growth": ("sensor", wheel_growth, 0.001, 0.004, "v v"),
    "alternator": ("force", alternator, 0.2, 0.8, ""),
    "surge": ("command", surge, 0.1, 0.4, "change(a-)"),
}
NAMES = tuple(_LAWS)
TAU = (8.0, 60.0)  # s, of the laws that remember


def hidden(name: str) -> Effect:
    """The law as an effect with parameters c and tau."""
    slot, function, low, high, _ = _LAWS[name]
    keys = (Key("c", "-", low, high, neutral=0.0, least=0.0), Key("tau", "s", *TAU, neutral=20.0, least=0.1))
    return Effect(
        name=f"hidden_{name}", slot=slot, physics="hidden", equation="hidden", source="this benchmark", reveals="",
        parameters=keys, function=function, memory=(Memory("h"),), order=80,
    )  # fmt: skip


def bounds(name: str) -> tuple[float, float]:
    """Range of c."""
    return _LAWS[name][2:4]


def true_form(name: str) -> str:
    """The form as `discover` would write it, "" if its grammar has none."""
    return _LAWS[name][4]
