"""An FMU 2 or 3 as the model of a car; needs the extra `fmi` (FMPy)."""

from __future__ import annotations

import importlib
import math
import shutil
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pytest_dvp.gap.compare.compared_model import CompareError, Values, command_at_stamps, wrapping
from pytest_dvp.gap.compare.fmu_units import declared_unit
from pytest_dvp.gap.compare.segments import CHANNELS, Segments, posed
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.effect import Effect

GLANCE = 1e-3
"""Share of a sample after which a co-simulation FMU is asked what follows a command at once; the step then goes on."""


START = {"x0": "x", "y0": "y", "yaw0": "yaw", "v0": "v"}
"""Parameters by which an FMU is put where a log begins, as those of `dvp export` are, and the channel of each."""


class FmuSubject:
    """An FMU 2 or 3 whose inputs and outputs carry the log's column names; values in a unit that it declares for one of
    our signals are converted, others are SI.

    It runs once through the log with its commands held, from the measured start if it has parameters for that (START).
    An FMU cannot be set to a measured motion in general, so pose and speed are matched in each segment. A row shows the
    outputs at its stamp with the command of the stamp already acting. An FMU that only takes steps of one length is
    asked at its own steps, before each; what it computes in steps alone then shows the command before.
    """

    imposed_channels: tuple[str, ...] = ()
    restarts = False

    def __init__(self, path: Path, extra: Iterable[Effect] = ()) -> None:
        self.path, self.name = path, path.name
        self._extra = tuple(extra)
        self._last: tuple[bytes, FloatArray] | None = None

    @property
    def inputs(self) -> tuple[str, ...]:
        """The columns that drive it. Raises CompareError if the FMU cannot be read."""
        return tuple(v.name for v in _inputs(self._read()[1]))

    def output(self, log: Log, segments: Segments, values: Values | None = None) -> FloatArray:
        """Channels (n, 8) in their units of one run of the FMU, moved onto the measured start of each segment.

        NaN where the FMU has no such output. Raises CompareError if the FMU cannot be read, fails, or needs an input
        that the log lacks, ModelError for an effect that cannot be wrapped around it.
        """
        fmpy, description = self._read()
        columns = {v.name: command_at_stamps(log, v.name, self.name) for v in _inputs(description)}
        wrapped = wrapping(log, values, self._extra, self.name, columns)
        acting = wrapped.commands(columns, values or {})
        first = segments.states[0]
        key = b"".join(np.ascontiguousarray(part).tobytes() for part in (log.t, first, *acting.mean.values()))
        if self._last is None or self._last[0] != key:  # other sensors need no other run
            start = self._start(description, dict(zip(CHANNELS, first[:4].tolist(), strict=False)))
            self._last = key, self._run(fmpy, description, log.t, acting.mean, start)
        return posed(wrapped.sensors(self._last[1], values or {}), segments)

    def why_not(self, effect: Effect, log: Log, given: Collection[str]) -> str:
        """Why an effect cannot be judged, empty if it can; one on commands needs a command that the FMU takes.

        Raises CompareError if the FMU cannot be read.
        """
        from vehicle.model.wrapped_model import why_not

        return why_not(effect, [v.name for v in _inputs(self._read()[1])], given)

    def _read(self) -> tuple[Any, Any]:
        try:
            fmpy: Any = importlib.import_module("fmpy")
        except ImportError as error:
            raise CompareError(
                f"{self.name}: FMUs need the extra fmi: pip install -e '.[fmi]' from the checkout"
            ) from error
        try:
            description = fmpy.read_model_description(str(self.path))
        except Exception as error:  # FMPy raises bare Exception for a bad archive
            raise CompareError(f"{self.name}: not a readable FMU: {_line(error)}") from error
        if not _outputs(description):
            raise CompareError(f"{self.name}: none of its outputs is named like a channel ({', '.join(CHANNELS)})")
        odd = [v.name for v in _inputs(description) if v.type not in ("Real", "Float64")]
        if odd:
            raise CompareError(f"{self.name}: input {odd[0]!r} is no real number; only such can be driven by a log")
        for variable in (*_inputs(description), *_outputs(description)):
            declared_unit(variable, description, self.name)  # refused before anything runs
        return fmpy, description

    def _start(self, description: Any, measured: Mapping[str, float]) -> dict[str, float]:
        """Values of the parameters of START that an FMU has, in its units, where the log tells them."""
        found = {}
        for v in description.modelVariables:
            value = measured[START[v.name]] if v.name in START and v.causality == "parameter" else math.nan
            if math.isfinite(value):
                unit = declared_unit(v, description, self.name, START[v.name])
                found[v.name] = (value - unit.offset) / unit.scale
        return found

    def _run(
        self, fmpy: Any, description: Any, t: FloatArray, columns: Mapping[str, FloatArray], start: Mapping[str, float]
    ) -> FloatArray:
        folder = None
        taken = (*_inputs(description), *_outputs(description))
        unit = {v.name: declared_unit(v, description, self.name) for v in taken}
        columns = {name: (column - unit[name].offset) / unit[name].scale for name, column in columns.items()}
        try:
            folder = fmpy.extract(str(self.path))
            if description.coSimulation is not None and description.fmiVersion != "1.0":
                found = _stepped(fmpy, folder, description, t, columns, start)
            else:
                found = _simulated(fmpy, folder, t, columns, [v.name for v in _outputs(description)], start)
        except Exception as error:
            raise CompareError(f"{self.name}: the FMU failed: {_line(error)}") from error
        finally:
            if folder is not None:
                shutil.rmtree(folder, ignore_errors=True)
        for v in _outputs(description):
            k = CHANNELS.index(v.name)
            found[:, k] = found[:, k] * unit[v.name].scale + unit[v.name].offset
        return found


def _inputs(description: Any) -> list[Any]:
    return [v for v in description.modelVariables if v.causality == "input"]


def _outputs(description: Any) -> list[Any]:
    return [v for v in description.modelVariables if v.name in CHANNELS and v.causality in ("output", "local")]


def _stepped(
    fmpy: Any, folder: str, description: Any, t: FloatArray, columns: Mapping[str, FloatArray],
    start: Mapping[str, float],
) -> FloatArray:  # fmt: skip
    """Co-simulation from stamp to stamp; the channels (n, 8)."""
    free = bool(description.coSimulation.canHandleVariableCommunicationStepSize)
    step = float(np.median(np.diff(t)))
    times = t - t[0] if free else step * np.arange(math.ceil((t[-1] - t[0]) / step - 1e-6) + 1)
    row = np.clip(np.searchsorted(t - t[0], times + 1e-9, side="right") - 1, 0, len(t) - 1)
    names, outputs = [v.name for v in _inputs(description)], _outputs(description)
    given = np.column_stack([columns[name][row] for name in names]) if names else np.zeros((len(times), 0))
    into, out_of = [v.valueReference for v in _inputs(description)], [v.valueReference for v in outputs]
    simulation = importlib.import_module("fmpy.simulation")
    fmu = simulation.instantiate_fmu(folder, description, "CoSimulation")
    second = description.fmiVersion == "2.0"
    put, get = (fmu.setReal, fmu.getReal) if second else (fmu.setFloat64, fmu.getFloat64)
    found = np.full((len(times), len(CHANNELS)), np.nan)
    places = [CHANNELS.index(v.name) for v in outputs]
    try:
        if start:
            reference = {v.name: v.valueReference for v in description.modelVariables}
            put([reference[name] for name in start], list(start.values()))
        if second:
            fmu.setupExperiment(startTime=0.0)
            fmu.enterInitializationMode()
        else:
            fmu.enterInitializationMode(startTime=0.0)
        if into:
            put(into, given[0].tolist())
        fmu.exitInitializationMode()
        for i, now in enumerate(times.tolist()):
            span = float(times[i + 1]) - now if i + 1 < len(times) else step
            if into:
                put(into, given[i].tolist())
            glance = GLANCE * span if free else 0.0
            if glance:
                fmu.doStep(currentCommunicationPoint=now, communicationStepSize=glance)
            found[i, places] = get(out_of)
            if i + 1 < len(times):
                fmu.doStep(currentCommunicationPoint=now + glance, communicationStepSize=span - glance)
        fmu.terminate()
    finally:
        fmu.freeInstance()
    return found if free else _between(times, found, t - t[0])


def _simulated(
    fmpy: Any, folder: str, t: FloatArray, columns: Mapping[str, FloatArray], given: list[str],
    start: Mapping[str, float],
) -> FloatArray:  # fmt: skip
    """Model exchange, integrated by FMPy with an event at each stamp; the channels (n, 8)."""
    even = t - t[0]
    fields = [("time", np.float64), *((name, np.float64) for name in columns)]
    signals = np.zeros(2 * len(even) - 1, dtype=fields)
    # Two rows a stamp, old value and new: FMPy draws straight lines between rows, but a command is held
    signals["time"] = np.repeat(even, 2)[1:]
    for name, column in columns.items():
        signals[name] = np.repeat(column, 2)[:-1]
    result = fmpy.simulate_fmu(
        folder,
        start_time=0.0,
        stop_time=float(even[-1]),
        start_values=dict(start),
        input=signals if columns else None,
        output=given,
        output_interval=float(np.median(np.diff(even))),
        record_events=True,
    )
    # Of two rows of one time the second is the one after the event
    last = np.append(np.diff(result["time"]) > 1e-9, True)
    found = np.full((len(even), len(CHANNELS)), np.nan)
    for name in given:
        found[:, CHANNELS.index(name)] = np.interp(even, result["time"][last], result[name][last])
    return found


def _between(times: FloatArray, found: FloatArray, wanted: FloatArray) -> FloatArray:
    """Rows (n, 8) at `wanted` on straight lines between those at `times`."""
    return np.column_stack([np.interp(wanted, times, found[:, k]) for k in range(found.shape[1])])


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:300]
