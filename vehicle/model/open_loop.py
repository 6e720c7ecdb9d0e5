"""Replay of recorded commands through a model, open loop, showing what its log would hold.

    replay = Replay(model, log_t, {"steer_cmd": ..., "accel_cmd": ...})
    rows = replay.run({("steer_delay", "T"): 0.2})        # another value costs one more call of the kernel

Conventions. A command logged at stamp t holds from t to the next stamp; a measured input (`steer`, `v`) runs straight
from stamp to stamp. A row shows the motion at its stamp, with the command of that stamp already acting: an ideal car
turns with v tan(d)/L of its own row.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from vehicle.messages import FloatArray
from vehicle.model.command_inputs import command_table
from vehicle.model.effect import Effect
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.errors import ModelError, nearest_name
from vehicle.model.kernel import IMPOSED, replay
from vehicle.model.kernel_layout import Layout, body_kind, bus_of, check_delay, input_mode
from vehicle.model.vehicle_model import VehicleModel

MEASURED_COLUMNS: tuple[str, ...] = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")
"""Columns of what `Replay.run` returns: [m, m, rad, m/s, rad/s, m/s^2, m/s^2, rad]."""

LONGEST_STEP = 0.02  # s
LONGEST_SWING_STEP = 0.01  # s, of a car whose tyres or roll have a state of their own, or whose tyres saturate
MOST_PIECES = 10_000  # of one pause between stamps

Values: TypeAlias = Mapping[tuple[str, str], float]

_INPUTS = {name: name for name in ("steer_scale", "steer_zero", "full_throttle", "full_brake")}
_PARAMETERS = {
    "wheelbase": "wheelbase",
    "mass": "mass",
    "command_mass": "mass_ref",
    "yaw_inertia": "yaw_inertia",
    "cg_height": "cg_height",
    "track": "track",
    "ax_x": "ax_x",
    "ay_x": "ay_x",
    "cornering_stiffness_front": "stiffness_front",
    "cornering_stiffness_rear": "stiffness_rear",
}
_NO_STARTS = np.zeros(1, dtype=np.int64)


class Replay:
    """A model and the commands of one log, ready to be run with any values of any effects.

    `t` (n,) [s], strictly increasing, steps may differ; `commands` by log column name, (n,) each, NaN = as before;
    `step` [s] the longest integration step (default 0.02, with relaxing or saturating tyres 0.01):
    longer pauses are divided. `extra` are effects of the user's own. Raises ModelError: column missing or never finite,
    lengths or stamps wrong.
    """

    def __init__(
        self,
        model: VehicleModel,
        t: FloatArray,
        commands: Mapping[str, npt.ArrayLike],
        *,
        step: float | None = None,
        extra: Iterable[Effect] = (),
    ) -> None:
        self.model = model
        self.t = np.ascontiguousarray(t, dtype=np.float64)
        if self.t.ndim != 1 or len(self.t) < 2 or not np.isfinite(self.t).all() or (np.diff(self.t) <= 0.0).any():
            raise ModelError("stamps must be finite and increase, at least two", key="t")
        self._steps = (LONGEST_STEP, LONGEST_SWING_STEP) if step is None else (float(step), float(step))
        if not min(self._steps) > 0.0 or np.diff(self.t).max() / min(self._steps) > MOST_PIECES:
            raise ModelError("step does not suit the stamps", key="step", found=f"{min(self._steps):g} s")
        self._shortest = min(float(np.median(np.diff(self.t))), *self._steps)
        self._commands, self._slopes = command_table(model.inputs, self.t, commands)
        self._mode = input_mode(model.inputs.longitudinal)
        self._known = {a.name: a.effect for a in model.effects} | {e.name: e for e in extra}
        self._base = {(a.name, k): v for a in model.effects for k, v in a.values.items()}
        self._template = bus_of(model)
        self._template["steer_scale"] = model.inputs.steer_scale
        self._template["steer_zero"] = model.inputs.steer_zero
        self._layouts: dict[frozenset[str], Layout] = {}

    def run(
        self,
        values: Values | None = None,
        *,
        starts: npt.NDArray[np.int64] | None = None,
        states: FloatArray | None = None,
        out: FloatArray | None = None,
    ) -> FloatArray:
        """What the log would show, (n, 8): MEASURED_COLUMNS at the stamps.

        `values`: (effect, key) -> value, over those of the model; effects that the model lacks are added. The names
        "inputs" and "parameters" stand for the input map and the car: ("inputs", "full_brake"), ("parameters", "mass").

        `starts` (m,), increasing rows, and `states` (m, 6): there the motion takes x, y, yaw, v, vy (at the rear axle),
        yaw rate of states[j]; NaN runs on. Actuators (delay lines, lags, rate limits, play) always run on; sensors that
        show the past see a past moved along with the car. Without starts the car begins at rest at the origin (with an
        imposed speed, at that speed, whatever `states` say of it). `out` is filled and returned if given.

        Raises ModelError on an unknown effect or key, or a value that the equation does not allow.
        """
        wanted, constants = self._split(values or {})
        layout = self._layout(wanted)
        bus = self._template.copy()
        for name, value in constants.items():
            bus[name] = value
        if "mass" in constants and "mass_ref" not in constants and self._same_mass():
            bus["mass_ref"] = constants["mass"]
        parameters = layout.parameters(wanted)
        at = _NO_STARTS if starts is None else np.ascontiguousarray(starts, dtype=np.int64)
        if states is None:
            states = np.full((len(at), 6), np.nan)
        states = np.ascontiguousarray(states, dtype=np.float64)
        if states.shape != (len(at), 6) or (len(at) > 1 and (np.diff(at) <= 0).any()):
            raise ModelError("starts must increase, states be (m, 6)", key="starts", found=str(states.shape))
        if self._mode == IMPOSED:
            states = states.copy()
            states[:, 3] = np.nan
        if out is None:
            out = np.empty((len(self.t), len(MEASURED_COLUMNS)))
        replay(
            bus,
            body_kind(self.model, layout),
            self._mode,
            layout.table,
            layout.bounds,
            parameters,
            np.zeros(layout.memory_size),
            self.t,
            self._commands,
            self._slopes,
            self._steps[layout.swings],
            at,
            states,
            out,
        )
        return out

    def _same_mass(self) -> bool:
        return self.model.car.mass == self.model.car.command_mass

    def _split(self, values: Values) -> tuple[dict[str, dict[str, float]], dict[str, float]]:
        """Values of the active effects, and bus fields to set."""
        merged: dict[str, dict[str, float]] = {}
        constants: dict[str, float] = {}
        for (name, key), value in {**self._base, **values}.items():
            fields = {"inputs": _INPUTS, "parameters": _PARAMETERS}.get(name)
            if fields is None:
                merged.setdefault(name, {})[key] = self._effect(name).key(key).check(float(value))
            elif key not in fields:
                near = nearest_name(key, fields)
                raise ModelError(
                    f"no such value of {name}", key=key, found=key, allowed=", ".join(fields), nearest=near
                )
            else:
                constants[fields[key]] = float(value)
        active = {}
        for name, given in merged.items():
            effect = self._effect(name)
            full = {**effect.neutral(), **given}
            if not effect.is_off(full):
                check_delay(effect, full, self._shortest)
                active[name] = full
        return active, constants

    def _effect(self, name: str) -> Effect:
        found = self._known.get(name)
        if found is None:
            found = self._known[name] = find_effect(name)
        return found

    def _layout(self, wanted: Mapping[str, Any]) -> Layout:
        names = frozenset(wanted)
        found = self._layouts.get(names)
        if found is None:
            found = self._layouts[names] = Layout(self._known[name] for name in names)
        return found
