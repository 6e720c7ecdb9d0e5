"""A Python function as the model of a car."""

from __future__ import annotations

import copy
import importlib.util
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from pytest_dvp.gap.compare.compared_model import MOTION, CompareError, Values, command_at_stamps, wrapping
from pytest_dvp.gap.compare.segments import CHANNELS, Segments
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.effect import Effect

State: TypeAlias = dict[str, float]
StepFunction: TypeAlias = Callable[[State, Mapping[str, float], float], Mapping[str, float]]

GLANCE = 1e-3  # of a sample: a step so short that nothing moves, which shows what follows a command at once
_NUMBERS = {*CHANNELS, *MOTION}
_STATED = ("x", "y", "yaw", "v")
"""Channels that no command moves at once: taken from the state, not from a glance."""


class StepSubject:
    """A Python function `step(state, inputs, dt) -> state`.

    state: x, y [m], yaw [rad], v, vy [m/s], yaw_rate [rad/s] and whatever the function adds; inputs: the log's other
    columns by name, in SI, held over dt [s]. The returned state may also hold ax, ay [m/s^2], steer [rad]. The motion
    is set to the measured one at the start of each segment; what the function added runs on, and so does vy, which no
    log has: it is 0 at first.

    A row shows the motion at its stamp with the command of that stamp already acting, as for every model here:
    position, heading and speed are those of the state; the rest is what the function returns for a glance of a
    thousandth of a sample, whose state is thrown away. So all that it remembers belongs into the state.
    """

    inputs: tuple[str, ...] = ()
    imposed_channels: tuple[str, ...] = ()
    restarts = True

    def __init__(self, step: StepFunction, name: str = "step", extra: Iterable[Effect] = ()) -> None:
        self.step, self.name = step, name
        self._extra = tuple(extra)
        self._last: tuple[bytes, tuple[FloatArray, FloatArray]] | None = None

    def output(self, log: Log, segments: Segments, values: Values | None = None) -> FloatArray:
        """Channels (n, 8) that the function gives, in their units, set to the measured motion at each segment's start.

        Raises CompareError if the function fails or returns something other than numbers, ModelError for an effect that
        cannot be wrapped around it.
        """
        names = [name for name in log.columns if name != "t" and name not in CHANNELS]
        columns = {
            name: command_at_stamps(log, name, self.name) for name in names if np.isfinite(log.columns[name]).any()
        }
        wrapped = wrapping(log, values, self._extra, self.name, columns)
        acting = wrapped.commands(columns, values or {})
        parts = (log.t, segments.starts, segments.states, *acting.mean.values(), *acting.start.values())
        key = b"".join(np.ascontiguousarray(part).tobytes() for part in parts)
        if self._last is None or self._last[0] != key:  # other sensors need no other drive
            self._last = key, self._drive(log.t, acting.mean, acting.start, segments)
        motion, before = self._last[1]
        return wrapped.sensors(motion, values or {}, starts=segments.starts, before=before)

    def why_not(self, effect: Effect, log: Log, given: Collection[str]) -> str:
        """Why an effect cannot be judged, empty if it can; one on commands needs the command as a column of the log."""
        from vehicle.model.wrapped_model import why_not

        return why_not(effect, [name for name in log.columns if name not in CHANNELS], given)

    def _drive(
        self, t: FloatArray, mean: Mapping[str, FloatArray], start: Mapping[str, FloatArray], segments: Segments
    ) -> tuple[FloatArray, FloatArray]:
        """The channels (n, 8), and the pose (m, 3) in which the model was when it was put onto each segment's start."""
        found = np.full((len(t), len(CHANNELS)), np.nan)
        before = np.zeros((len(segments.starts), 3))
        restart = {int(row): j for j, row in enumerate(segments.starts)}
        state: State = {}
        stamps = t.tolist()
        spans = [*np.diff(t).tolist(), float(np.median(np.diff(t)))]
        over, at = _rows(mean, len(t)), _rows(start, len(t))
        returned: set[str] = set()
        for i, span in enumerate(spans):
            if i:
                after = self._step(state, over[i - 1], spans[i - 1], stamps[i - 1])
                returned.update(after)
                state = {**state, **after}
            if i in restart:
                j = restart[i]
                before[j] = [state.get(name, np.nan) for name in MOTION[:3]]
                # What no log has, the sideways speed, runs on; a car begins without
                state = {**dict.fromkeys(MOTION, 0.0), **state}
                state |= {k: v for k, v in zip(MOTION, segments.states[j].tolist(), strict=True) if np.isfinite(v)}
            shown = {**state, **self._step(_apart(state), at[i], GLANCE * span, stamps[i])}
            for k, name in enumerate(CHANNELS):
                value = (state if name in _STATED else shown).get(name)
                if value is not None:
                    found[i, k] = value
        for k, name in enumerate(CHANNELS):
            if name in MOTION and name not in returned:  # the start of each segment, kept: nothing that it says
                found[:, k] = np.nan
        return found, before

    def _step(self, state: State, inputs: Mapping[str, float], dt: float, now: float) -> Mapping[str, float]:
        try:
            after: object = self.step(dict(state), inputs, dt)
        except KeyError as error:
            known = ", ".join([*inputs, *MOTION])
            text = f"{self.name}: asks for {error}, which is neither input nor state ({known})"
            raise CompareError(text) from error
        except Exception as error:  # a user's function may raise anything
            text = f"{self.name}: failed at t={now:.2f} s: {type(error).__name__}: {error}"
            raise CompareError(text) from error
        if not isinstance(after, Mapping):
            raise CompareError(f"{self.name}: returned a {type(after).__name__}, not a dict of the new state")
        for name in after.keys() & _NUMBERS:
            if not isinstance(after[name], float | int | np.number):
                kind = type(after[name]).__name__
                raise CompareError(f"{self.name}: returned {name} as a {kind} at t={now:.2f} s, not as a number")
        return after


def load_step(path: Path, name: str = "step") -> StepFunction:
    """The function `name` of a Python file, which is run to get it. Raises CompareError."""
    spec = importlib.util.spec_from_file_location(f"dvp_model_{path.stem}", path) if path.is_file() else None
    if spec is None or spec.loader is None:
        raise CompareError(f"{path}: no such Python file")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # a user's file may raise anything
        raise CompareError(f"{path}: cannot be loaded: {type(error).__name__}: {error}") from error
    function: Any = getattr(module, name, None)
    if not callable(function):
        raise CompareError(f"{path}: has no function {name}(state, inputs, dt)")
    return function  # type: ignore[no-any-return]


def _rows(columns: Mapping[str, FloatArray], count: int) -> list[dict[str, float]]:
    """Columns (count,) as one dict a row."""
    if not columns:
        return [{} for _ in range(count)]
    lists = [column.tolist() for column in columns.values()]
    return [dict(zip(columns, row, strict=True)) for row in zip(*lists, strict=True)]


def _apart(state: State) -> State:
    """A state whose queues and lists, if the function keeps any, are not those of the drive."""
    return state if all(isinstance(value, float | int) for value in state.values()) else copy.deepcopy(state)
