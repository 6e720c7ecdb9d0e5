"""The kernel's command path and sensors alone, to be put around a model whose inside is its own affair.

    wrapped = Wrapped(t)
    acting = wrapped.commands({"steer_cmd": ...}, values)     # what reaches the box: slots command and actuator
    shown = wrapped.sensors(motion, values)                   # what a log of the box would show: slot sensor

The effects are the kernel's own, called by address in its order; the box takes the place of forces, body and road.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from machine_code import compiled
from vehicle.messages import FloatArray
from vehicle.model.bus import BUS_FIELDS
from vehicle.model.effect import Effect, Slot
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.effect_compiler import BUS_DTYPE
from vehicle.model.kernel import SETTLING, SETTLING_STEPS, call_effect
from vehicle.model.kernel_layout import Layout, check_delay
from vehicle.model.open_loop import LONGEST_STEP, MEASURED_COLUMNS, Values

COMMANDS = ("steer_cmd", "accel_cmd")
"""Columns whose way to the wheels can be wrapped: [rad] at the road wheel, [m/s^2]."""

SHOWN = MEASURED_COLUMNS[:7]

_PATH: tuple[Slot, ...] = ("command", "actuator")
_CLOCK = {"t", "t_start", "count", "dt", "settle"}
_STEER = {name for name in BUS_FIELDS if name.startswith("steer")}
_DRIVE = {name for name in BUS_FIELDS if name.startswith("accel")}
_PAST = {"moved", "old_x", "old_y", "old_yaw"}
_SEEN = {name: "v" if name == "vx" else name for name in ("x", "y", "yaw", "vx", "yaw_rate", "ax", "ay")} | {
    f"meas_{name}": name for name in SHOWN
}


@dataclass(frozen=True, eq=False, slots=True)
class Acting:
    """What reaches the box, by column, (n,) each: `mean` over the time from stamp to stamp, `start` at the stamp."""

    mean: Mapping[str, FloatArray]
    start: Mapping[str, FloatArray]


def why_not(effect: Effect, commands: Collection[str], shown: Collection[str]) -> str:
    """Why an effect cannot be judged around a box, empty if it can.

    `commands`: columns that drive the box; `shown`: channels that it gives.
    """
    if effect.slot == "perception":
        return "acts on detected objects"
    if effect.slot not in (*_PATH, "sensor"):
        return f"acts inside the model ({effect.slot})"
    used = fields_of(effect)
    if effect.slot == "sensor":
        inside = sorted(used - set(_SEEN) - _PAST - _CLOCK)
        missing = sorted({_SEEN[name] for name in used if name in _SEEN} - set(shown))
        if missing:
            return f"the model gives no {', '.join(missing)}"
    else:
        inside = sorted(used - _STEER - _DRIVE - _CLOCK)
        if not inside:
            for column, fields in zip(COMMANDS, (_STEER, _DRIVE), strict=True):
                if used & fields and column not in commands:
                    return f"the model is not driven by {column}"
    return f"needs what only the model itself knows ({', '.join(inside)})" if inside else ""


def fields_of(effect: Effect) -> set[str]:
    """Fields of the bus that an effect's function names."""
    own = {k.name for k in effect.parameters} | {m.name for m in effect.memory}
    return (set(effect.function.__code__.co_names) & set(BUS_FIELDS)) - own


class Wrapped:
    """Effects around a box at the stamps t (n,) [s], strictly increasing; `extra` are effects of the user's own."""

    def __init__(self, t: FloatArray, extra: Iterable[Effect] = ()) -> None:
        self.t = np.ascontiguousarray(t, dtype=np.float64)
        self._extra = {effect.name: effect for effect in extra}
        self._shortest = min(float(np.median(np.diff(self.t))), LONGEST_STEP)

    def active(self, values: Values, slots: Collection[str]) -> dict[Effect, dict[str, float]]:
        """The effects of these slots that `values` switch on. Raises ModelError: no such name or key, wrong value."""
        given: dict[str, dict[str, float]] = {}
        for (name, key), value in values.items():
            given.setdefault(name, {})[key] = value
        found = {}
        for name, some in given.items():
            effect = find_effect(name, self._extra)
            full = effect.complete(some)
            if effect.slot in slots and not effect.is_off(full):
                check_delay(effect, full, self._shortest)
                found[effect] = full
        return found

    def commands(self, columns: Mapping[str, FloatArray], values: Values) -> Acting:
        """What of `columns` (n,), held from stamp to stamp, arrives behind the command path and the actuators.

        In SI units. Columns other than COMMANDS arrive as they are.
        """
        active = self.active(values, _PATH)
        if not active:
            return Acting(columns, columns)
        nothing = np.zeros(len(self.t))
        given = np.column_stack([columns.get(name, nothing) for name in COMMANDS])
        found = np.empty((len(self.t), 4))
        _act(*_numbers(active), self.t, given, LONGEST_STEP, found)
        names = [(k, name) for k, name in enumerate(COMMANDS) if name in columns]
        mean = {name: np.ascontiguousarray(found[:, 2 * k]) for k, name in names}
        start = {name: np.ascontiguousarray(found[:, 2 * k + 1]) for k, name in names}
        return Acting({**columns, **mean}, {**columns, **start})

    def sensors(
        self,
        motion: FloatArray,
        values: Values,
        *,
        starts: npt.NDArray[np.int64] | None = None,
        before: FloatArray | None = None,
    ) -> FloatArray:
        """What the sensors show of a motion (n, 8): MEASURED_COLUMNS, steer as it is.

        `starts` (m,): rows at which the box was put elsewhere, where it had been at `before` (m, 3: x, y, yaw).
        """
        active = self.active(values, ("sensor",))
        if not active:
            return motion.copy()
        shown = np.ascontiguousarray(motion, dtype=np.float64).copy()
        at = np.zeros(0, dtype=np.int64) if starts is None else np.ascontiguousarray(starts, dtype=np.int64)
        old = np.zeros((len(at), 3)) if before is None else np.ascontiguousarray(before, dtype=np.float64)
        _sense(*_numbers(active), self.t, at, old, shown)
        return shown


@lru_cache(maxsize=64)
def _layout(effects: frozenset[Effect]) -> Layout:
    return Layout(effects)


def _numbers(active: Mapping[Effect, Mapping[str, float]]) -> tuple[Any, Any, Any, FloatArray, FloatArray]:
    """Bus, table, bounds, parameters and memory of these effects."""
    layout = _layout(frozenset(active))
    parameters = layout.parameters({effect.name: values for effect, values in active.items()})
    return np.zeros(1, dtype=BUS_DTYPE), layout.table, layout.bounds, parameters, np.zeros(layout.memory_size)


@compiled
def _slots(first: int, end: int, bus: Any, table: Any, bounds: Any, parameters: Any, memory: Any) -> None:
    for j in range(bounds[first], bounds[end]):
        call_effect(table[j, 0], bus, parameters, table[j, 1], memory, table[j, 2])  # type: ignore[call-arg]


@compiled
def _act(
    bus: Any, table: Any, bounds: Any, parameters: Any, memory: Any, t: Any, given: Any, longest: float, found: Any
) -> None:
    """Slots command and actuator, as `kernel.replay` calls them. found (n, 4): mean, start of steer, of accel."""
    x = bus[0]
    n = t.shape[0]
    x.t_start = t[0]
    x.settle = 1.0
    x.dt = SETTLING
    for k in range(-SETTLING_STEPS, n):
        if k == 0:
            x.settle = 0.0
        i = max(k, 0)
        span = SETTLING if k < 0 else t[i + 1] - t[i] if i + 1 < n else longest
        pieces = 1 if k < 0 else max(math.ceil(span / longest - 1e-6), 1)
        begin = t[0] + k * SETTLING if k < 0 else t[i]
        x.dt = span / pieces
        steer = accel = 0.0
        x.steer_cmd, x.accel_cmd = given[i, 0], given[i, 1]
        for j in range(pieces):
            x.t = begin + j * x.dt
            x.steer, x.accel = x.steer_cmd, x.accel_cmd
            x.steer_lead = x.accel_lead = x.steer_glides = 0.0
            _slots(0, 2, bus, table, bounds, parameters, memory)
            if j == 0:
                found[i, 1], found[i, 3] = x.steer + x.steer_lead, x.accel + x.accel_lead
            steer += x.steer
            accel += x.accel
        found[i, 0], found[i, 2] = steer / pieces, accel / pieces


@compiled
def _sense(
    bus: Any, table: Any, bounds: Any, parameters: Any, memory: Any, t: Any, starts: Any, before: Any, shown: Any
) -> None:
    """Slot sensor on the motion in `shown` (n, 8), which it overwrites with what is seen of it."""
    x = bus[0]
    x.t_start = t[0]
    segment = 0
    for k in range(t.shape[0]):
        row = shown[k]
        x.moved = 0.0
        if segment < starts.shape[0] and starts[segment] == k:
            if k > 0:
                x.moved = 1.0
                x.old_x, x.old_y, x.old_yaw = before[segment, 0], before[segment, 1], before[segment, 2]
            segment += 1
        x.t = t[k]
        x.dt = t[k] - t[k - 1] if k > 0 else t[1] - t[0]
        x.x, x.y, x.yaw, x.vx, x.yaw_rate, x.ax, x.ay = row[0], row[1], row[2], row[3], row[4], row[5], row[6]
        x.meas_x, x.meas_y, x.meas_yaw, x.meas_v = x.x, x.y, x.yaw, x.vx
        x.meas_yaw_rate, x.meas_ax, x.meas_ay = x.yaw_rate, x.ax, x.ay
        _slots(5, 6, bus, table, bounds, parameters, memory)
        row[0], row[1], row[2], row[3] = x.meas_x, x.meas_y, x.meas_yaw, x.meas_v
        row[4], row[5], row[6] = x.meas_yaw_rate, x.meas_ax, x.meas_ay
