"""Terms that may explain an error: what each is computed from, how it reads, and what to look at when it fits.

A term stands for an idea ("the brakes fade"), not for an effect of the catalogue: it is meant for what no effect
explains. Its first columns are what the idea needs beside it (a fading brake has a strength, too), the last the idea.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np
from scipy.signal import lfilter

from pytest_dvp.gap.compare.smoothed_motion import Motion
from pytest_dvp.logs.log_contents import FloatArray

Axis: TypeAlias = Literal["longitudinal", "lateral"]

CROSSED = tuple(float(v) for v in range(2, 36))  # m/s, speeds on whose passing something may happen
CROSSED_FOR = (0.25, 0.5, 1.0)  # s
RINGING = (0.8, 1.2, 1.8, 2.5, 3.5, 5.0)  # Hz
DAMPING = 0.25  # of the ringing terms; chosen: a term only has to resemble what rings
CREEPING = (1.5, 2.5, 4.0)  # m/s
_SATURATES = (0.15, 0.5)  # of all the energy of a log, over which heat or charge may level off
_RELEASED = -0.3  # m/s^2, above it nobody brakes
_COAST = 0.05  # m/s^2


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Term:
    """key: family of the term; name: with its numbers; columns (n, q): of acceleration [m/s^2] or of road-wheel angle
    [rad], the last one the idea itself."""

    key: str
    name: str
    columns: FloatArray


def terms(
    axis: Axis, motions: Sequence[Motion], periods: Sequence[tuple[str, float]], steer: str = "steer_cmd"
) -> list[list[Term]]:
    """All terms of an axis for each log, the same names in the same order. steer: the signal that steers the model.

    periods: ("time", frequency [Hz]) or ("distance", frequency [1/m]) of waves to be tried, in every log with a phase
    of its own.
    """
    braked = max(float(m.braked[-1]) for m in motions)
    driven = max(float(m.driven[-1]) for m in motions)
    fastest = max(float(m.v.max()) for m in motions)
    found = []
    for place, m in enumerate(motions):
        own = _longitudinal(m, braked, driven, fastest) if axis == "longitudinal" else _lateral(m, steer)
        found.append([*own, *_anywhere(m), *_waves(m, periods, place, len(motions))])
    return found


def _waves(m: Motion, periods: Sequence[tuple[str, float]], log: int, logs: int) -> list[Term]:
    found = []
    for kind, frequency in periods:
        phase = 2.0 * np.pi * frequency * (m.t if kind == "time" else m.way)
        waves = np.zeros((len(m.t), 2 * logs))
        waves[:, 2 * log], waves[:, 2 * log + 1] = np.cos(phase), np.sin(phase)
        unit = "Hz" if kind == "time" else "1/m"
        found.append(Term(f"wave_{kind}", f"wave at {frequency:.3g} {unit}", waves * m.moving[:, None]))
    return found


def _longitudinal(m: Motion, braked: float, driven: float, fastest: float) -> list[Term]:
    """braked, driven: the most energy [m^2/s^2] of any log, the scale on which heat or charge may level off; fastest:
    speed [m/s] of any log."""
    one = m.moving.astype(np.float64)
    side = m.v * m.yaw_rate
    found = [
        _term("speed", "v", one, m.v * one),
        _term("speed_squared", "v^2", one, m.v * np.abs(m.v)),
        _term("cornering", "|ay|", np.abs(side)),
        _term("cornering_squared", "ay^2", side * side),
    ]
    if m.accel is None:
        return found
    a = m.accel * one
    drive, brake = np.maximum(a, 0.0), np.minimum(a, 0.0)
    before, long_before = _shifted(m, m.accel, 0.1), _shifted(m, m.accel, 0.4)
    free = m.accel > _RELEASED
    found += [
        _term("drive_command", "a_cmd > 0", drive),
        _term("brake_command", "a_cmd < 0", brake),
        _term("command_rate", "d a_cmd/dt", (m.accel - before) * one, (m.accel - long_before) * one),
        _term("coasting", "pedals released", one * (np.abs(m.accel) < _COAST)),
        _term("drive_by_speed", "v a_cmd > 0", drive, m.v * drive),
        _term("brake_by_speed", "v a_cmd < 0", brake, m.v * brake),
        _term("drive_by_size", "a_cmd^2 > 0", drive, drive * drive),
        _term("brake_by_size", "a_cmd^2 < 0", brake, brake * brake),
        _term("drive_by_time", "t a_cmd > 0", drive, m.t * drive),
        _term("brake_by_time", "t a_cmd < 0", brake, m.t * brake),
    ]
    for energy, most, key, of in ((m.braked, braked, "brake_heat", brake), (m.driven, driven, "drive_energy", drive)):
        total = max(most, 1e-9)
        name = "energy braked away" if key == "brake_heat" else "energy spent"
        found.append(_term(key, name, of, energy * of))
        found += [_term(key, f"{name}, levelling off", of, (1.0 - np.exp(-energy / (s * total))) * of)
                  for s in _SATURATES]  # fmt: skip
    for v in CREEPING:
        slow = np.maximum(1.0 - np.abs(m.v) / v, 0.0)
        found.append(_term("creeping", f"below {v:g} m/s without brake", slow * free))
        found.append(_term("creeping_any", f"below {v:g} m/s", slow * one))
    for v in (speed for speed in CROSSED if speed < fastest):
        found += [_term("speed_passed", f"the {span:g} s after passing {v:g} m/s", _passed(m, v, span) * drive)
                  for span in CROSSED_FOR]  # fmt: skip
    found += [_term("drive_rings", f"a_cmd rings at {f:g} Hz", _rings(m, m.accel, f) * one) for f in RINGING]
    return found


def _lateral(m: Motion, steer: str) -> list[Term]:
    one = m.moving.astype(np.float64)
    side = m.v * m.yaw_rate
    found = [
        _term("offset", "offset", one),
        _term("lateral_acceleration", "ay", side),
        _term("lateral_acceleration_cubed", "ay^3", side, side * side * side),
    ]
    if m.accel is not None:
        found.append(_term("accel_steer", "a_cmd", m.accel * one))
        found.append(_term("brake_pull", "a_cmd < 0", np.minimum(m.accel, 0.0) * one))
        found.append(_term("torque_steer", "a_cmd > 0", np.maximum(m.accel, 0.0) * one))
    if m.steer is None:
        return found
    d = m.steer
    before, long_before = _shifted(m, d, 0.1), _shifted(m, d, 0.3)
    rate = (d - before) / 0.1
    found += [
        _term("steer_command", steer, d),
        _term("steer_size", f"|{steer}|", d, np.abs(d)),
        _term("steer_cubed", f"{steer}^3", d, d * d * d),
        _term("steer_rate", f"d {steer}/dt", d - before, d - long_before),
        _term("steer_side", f"sign of d {steer}/dt", np.tanh(rate / 0.02)),
        _term("steer_by_speed", f"v {steer}", d, m.v * d),
        _term("steer_by_speed_squared", f"v^2 {steer}", d, m.v * m.v * d),
        _term("steer_by_time", f"t {steer}", d, m.t * d),
    ]
    found += [_term("steer_rings", f"{steer} rings at {f:g} Hz", d - before, _rings(m, d, f)) for f in RINGING]
    return found


def _anywhere(m: Motion) -> list[Term]:
    one = m.moving.astype(np.float64)
    return [
        _term("constant", "constant", one),
        _term("time", "t", one, m.t * one),
        _term("heading", "heading", np.cos(m.yaw) * one, np.sin(m.yaw) * one),
    ]


def _term(key: str, name: str, *columns: FloatArray) -> Term:
    return Term(key, name, np.column_stack(columns).astype(np.float64))


def _shifted(m: Motion, y: FloatArray, by: float) -> FloatArray:
    return np.asarray(np.interp(m.t - by, m.t, y))


def _passed(m: Motion, speed: float, span: float) -> FloatArray:
    """1 for `span` [s] from when the speed passes `speed` upward; again only after it was a quarter lower."""
    found = np.zeros(len(m.t))
    armed = True
    above = m.v >= speed
    changes = np.flatnonzero(np.diff(above.astype(np.int8)) != 0) + 1
    for row, end in zip(changes, np.append(changes[1:], len(m.t)), strict=False):
        if above[row] and armed:
            found[row : np.searchsorted(m.t, m.t[row] + span)] = 1.0
            armed = False
        elif not above[row] and float(m.v[row:end].min()) < 0.75 * speed:
            armed = True
    return found


def _rings(m: Motion, y: FloatArray, frequency: float) -> FloatArray:
    """What a second-order system of this frequency [Hz] and DAMPING adds to a command (n,)."""
    w, h = 2.0 * np.pi * frequency, m.step
    k = 2.0 / h  # bilinear
    a = np.array([k * k + 2.0 * DAMPING * w * k + w * w, 2.0 * (w * w - k * k), k * k - 2.0 * DAMPING * w * k + w * w])
    b = np.array([w * w, 2.0 * w * w, w * w])
    start = y[0]
    return np.asarray(lfilter(b / a[0], a / a[0], y - start) + start - y)


READINGS: dict[str, tuple[str, str]] = {
    "speed": ("grows with speed", "bearings, drag of a part that turns, speed sensor"),
    "speed_squared": ("grows with the square of speed", "aerodynamic drag, wind"),
    "cornering": ("grows in turns", "drag of slipping tyres, differential"),
    "cornering_squared": ("grows in turns", "drag of slipping tyres, differential"),
    "drive_command": ("follows the drive command", "torque map, payload"),
    "brake_command": ("follows the brake command", "brake balance, payload"),
    "command_rate": ("follows changes of the command", "delay or lag of the drive, rate limits"),
    "coasting": ("shows when both pedals are released", "regeneration, engine braking"),
    "drive_by_speed": ("of the drive depends on speed", "gear ratio, field weakening, power limit"),
    "brake_by_speed": ("of the brakes depends on speed", "blending of regeneration, friction of the pads"),
    "drive_by_size": ("of the drive is not in proportion to the command", "torque map, current limit"),
    "brake_by_size": ("of the brakes is not in proportion to the command", "brake booster, pressure limit"),
    "drive_by_time": ("of the drive changes over the run", "battery, temperature of the motor"),
    "brake_by_time": ("of the brakes changes over the run", "temperature of the brakes"),
    "brake_heat": ("grows with the energy already braked away: fade?", "temperature of the brakes"),
    "drive_energy": ("of the drive grows with the energy already spent: battery sag?", "battery voltage, motor heat"),
    "creeping": ("shows at walking speed while nobody brakes: creep?", "torque converter, creep function"),
    "creeping_any": ("shows at walking speed", "wheel speed sensor at low speed, creep, stick-slip"),
    "speed_passed": ("shows just after a speed was passed upward: gear change?", "gear box, traction interrupted"),
    "drive_rings": ("rings after each change of the command", "drive shafts, mounts, an under-damped controller"),
    "accel_steer": (
        "follows braking and driving alike: does the car pull to a side?",
        "suspension, drive shafts, tyres",
    ),
    "brake_pull": (
        "follows the brake command: does the car pull to a side?",
        "brakes left and right",
    ),
    "torque_steer": ("follows the drive command: torque steer?", "drive shafts, differential, suspension"),
    "offset": ("is a constant angle", "steering zero"),
    "lateral_acceleration": ("grows with lateral acceleration", "tyres, compliance, roll steer"),
    "lateral_acceleration_cubed": ("grows fast with lateral acceleration", "tyres near their limit"),
    "steer_command": ("follows the steering command", "steering ratio, wheelbase"),
    "steer_size": ("differs between left and right", "steering linkage, crossed zero"),
    "steer_cubed": ("grows with the steering angle", "non-linear steering gear, angle limit"),
    "steer_rate": ("follows changes of the steering command", "delay, lag or rate limit of the steering"),
    "steer_side": ("depends on which way the steering moves", "play, friction"),
    "steer_by_speed": ("of the steering gain depends on speed: speed-dependent ratio?", "power steering, tyres"),
    "steer_by_speed_squared": ("of the steering gain grows with the square of speed", "tyres, understeer gradient"),
    "steer_by_time": ("of the steering gain changes over the run", "tyre temperature, pressure loss"),
    "steer_rings": ("rings after each steering command: resonance?", "steering column, servo loop, under-damped"),
    "constant": ("is constant", "bias of a sensor, slope, drag"),
    "time": ("drifts over the run", "temperature, a sensor that drifts"),
    "heading": ("depends on the direction of travel", "wind, slope or bank, a heading-dependent sensor"),
    "wave_time": ("is periodic in time", "gusts, an oscillating controller, a clock"),
    "wave_distance": ("is periodic over the distance", "wheel or shaft out of round, torque ripple, joints of a road"),
    "place": ("comes back at the same places", "slope, bank, surface, satellite shadow"),
}
"""How a term reads after "longitudinal error" or "lateral error", and what to look at."""
