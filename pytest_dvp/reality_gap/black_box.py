"""Models as something that answers a log's commands with motion: ours, a second log, a Python function, an FMU."""

from __future__ import annotations

import importlib
import importlib.util
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np

from pytest_dvp.log import FloatArray, Log
from pytest_dvp.reality_gap.segments import CHANNELS, Segments, posed

if TYPE_CHECKING:
    from openscenario.findings import Finding
    from vehicle.model.effect import Effect
    from vehicle.model.model import VehicleModel

State: TypeAlias = dict[str, float]
StepFunction: TypeAlias = Callable[[State, Mapping[str, float], float], Mapping[str, float]]

MOTION = ("x", "y", "yaw", "v", "vy", "yaw_rate")
"""What is set at the start of a segment, in the order of `Segments.states`."""


class CompareError(ValueError):
    """A log and a model cannot be compared; the message is one line and says what is missing."""


class Subject(Protocol):
    """What `compare` compares a log with.

    name    for tables
    inputs  log columns it is driven by; these are not compared
    held    channels that say nothing about it, as they are imposed or follow from what is
    restarts  True if its output begins each segment in the segment's state
    """

    name: str
    inputs: tuple[str, ...]
    held: tuple[str, ...]
    restarts: bool

    def output(self, log: Log, segments: Segments) -> FloatArray:
        """The channels (n, 8) at the log's stamps, NaN where it has none, each segment from its measured start."""
        ...


class ModelSubject:
    """A vehicle model of ours, restarted at each segment; actuators run on."""

    restarts = True

    def __init__(self, model: VehicleModel, name: str = "") -> None:
        self.model = model
        self.name = name or model.name or model.base
        self.inputs: tuple[str, ...] = (model.inputs.steer, *model.inputs.longitudinal)
        self.held: tuple[str, ...] = ("v", "ax") if "v" in self.inputs else ()

    def output(self, log: Log, segments: Segments) -> FloatArray:
        from vehicle.model.replay import Replay

        commands = {name: held(log, name, self.name) for name in self.inputs}
        replay = Replay(self.model, log.t, commands)
        return np.asarray(replay.run(starts=segments.starts, states=segments.states))


class LogSubject:
    """A model's own output, on the same clock as the measured log; only pose and speed are matched in each segment."""

    held: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    restarts = False

    def __init__(self, log: Log, name: str = "second log", findings: tuple[Finding, ...] = ()) -> None:
        self.log, self.name, self.findings = log, name, findings

    def output(self, log: Log, segments: Segments) -> FloatArray:
        t = self.log.t
        if len(t) < 2 or t[-1] < log.t[0] or t[0] > log.t[-1]:
            raise CompareError(
                f"{self.name}: has no time in common with the log "
                f"({_span(self.log)} and {_span(log)}); cut or shift one of them"
            )
        inside = (log.t >= t[0] - 1e-9) & (log.t <= t[-1] + 1e-9)
        found = np.full((len(log.t), len(CHANNELS)), np.nan)
        for k, name in enumerate(CHANNELS):
            values = self.log.columns.get(name)
            if values is not None and np.isfinite(values).sum() > 1:
                known = np.isfinite(values)
                found[inside, k] = np.interp(log.t[inside], t[known], values[known])
        return posed(found, segments)


class StepSubject:
    """A Python function `step(state, inputs, dt) -> state`.

    state: x, y [m], yaw [rad], v, vy [m/s], yaw_rate [rad/s] and whatever the function adds; inputs: the log's other
    columns by name, in SI, held over dt [s]. The returned state may also hold ax, ay [m/s^2], steer [rad]. The motion
    is set to the measured one at the start of each segment; what the function added runs on.
    """

    inputs: tuple[str, ...] = ()
    held: tuple[str, ...] = ()
    restarts = True

    def __init__(self, step: StepFunction, name: str = "step") -> None:
        self.step, self.name = step, name

    def output(self, log: Log, segments: Segments) -> FloatArray:
        names = [name for name in log.columns if name != "t" and name not in CHANNELS]
        columns = [held(log, name, self.name) for name in names]
        found = np.full((len(log.t), len(CHANNELS)), np.nan)
        restart = dict(zip(segments.starts.tolist(), segments.states.tolist(), strict=True))
        state: State = {"vy": 0.0}
        dts = np.diff(log.t).tolist()
        for i in range(len(log.t)):
            if i:
                inputs = {name: float(column[i - 1]) for name, column in zip(names, columns, strict=True)}
                try:
                    state = {**state, **self.step(dict(state), inputs, dts[i - 1])}
                except KeyError as error:
                    known = ", ".join([*names, *MOTION])
                    text = f"{self.name}: asks for {error}, which is neither input nor state ({known})"
                    raise CompareError(text) from error
                except Exception as error:  # a user's function may raise anything
                    text = f"{self.name}: failed at t={log.t[i]:.2f} s: {type(error).__name__}: {error}"
                    raise CompareError(text) from error
            if i in restart:
                given = zip(MOTION, restart[i], strict=True)
                state |= {name: value for name, value in given if math.isfinite(value)}
            for k, name in enumerate(CHANNELS):
                value = state.get(name)
                if value is not None:
                    found[i, k] = value
        return found


class FmuSubject:
    """An FMU 2 or 3 whose inputs and outputs carry the log's column names; needs the extra `fmi`.

    It runs once through the log with its commands held; an FMU cannot be set to a measured motion in general, so pose
    and speed are matched in each segment.
    """

    inputs: tuple[str, ...] = ()
    held: tuple[str, ...] = ()
    restarts = False

    def __init__(self, path: Path) -> None:
        self.path, self.name = path, path.name

    def output(self, log: Log, segments: Segments) -> FloatArray:
        try:
            fmpy: Any = importlib.import_module("fmpy")
        except ImportError as error:
            raise CompareError(f"{self.name}: FMUs need the extra fmi: pip install 'pytest-dvp[fmi]'") from error
        try:
            variables = fmpy.read_model_description(str(self.path)).modelVariables
            wanted = [v.name for v in variables if v.causality == "input"]
            given = [v.name for v in variables if v.name in CHANNELS and v.causality in ("output", "local")]
        except Exception as error:  # FMPy raises bare Exception for a bad archive
            raise CompareError(f"{self.name}: not a readable FMU: {error}") from error
        if not given:
            raise CompareError(f"{self.name}: none of its outputs is named like a channel ({', '.join(CHANNELS)})")
        even = log.t - log.t[0]
        fields = [("time", np.float64), *((name, np.float64) for name in wanted)]
        signals = np.zeros(2 * len(even) - 1, dtype=fields)
        # Two rows a stamp, old value and new: FMPy draws straight lines between rows, but a command is held
        signals["time"] = np.repeat(even, 2)[1:]
        for name in wanted:
            signals[name] = np.repeat(held(log, name, self.name), 2)[:-1]
        step = float(np.median(np.diff(even)))
        try:
            result = fmpy.simulate_fmu(
                str(self.path),
                start_time=0.0,
                stop_time=float(even[-1]),
                input=signals if wanted else None,
                output=given,
                output_interval=step,
            )
        except Exception as error:
            raise CompareError(f"{self.name}: the FMU failed: {error}") from error
        found = np.full((len(even), len(CHANNELS)), np.nan)
        for name in given:
            found[:, CHANNELS.index(name)] = np.interp(even, result["time"], result[name])
        return posed(found, segments)


def load_subject(
    argument: str,
    effects: Mapping[str, Effect] | None = None,
    *,
    mapping: Path | None = None,
    msg_dirs: Sequence[Path] = (),
) -> Subject:
    """What the option --model names: M.toml, step.py (or step.py:function), model.fmu, else a second log.

    `effects`: those of the user's own by name, which M.toml may use beside the catalogue's.
    `mapping`, `msg_dirs`: how to read a second log, as of read_log; its warnings are in `.findings` of the subject.

    Raises CompareError, ModelError or LogError, the last also for a log that the doctor finds errors in.
    """
    path, _, function = argument.partition(".py:")
    if function or argument.endswith(".py"):
        return StepSubject(
            load_step(Path(path + ".py" if function else argument), function or "step"), Path(argument).name
        )
    if argument.endswith(".toml"):
        from vehicle.model.model_file import read_model

        return ModelSubject(read_model(argument, extra=effects), Path(argument).name)
    if argument.endswith(".fmu"):
        if not Path(argument).is_file():
            raise CompareError(f"{argument}: no such file")
        return FmuSubject(Path(argument))
    from pytest_dvp.doctor import read_sound

    log, findings = read_sound(argument, mapping=mapping, msg_dirs=msg_dirs)
    return LogSubject(log, Path(argument).name, findings)


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


def held(log: Log, name: str, who: str) -> FloatArray:
    """A command of the log at each stamp (n,), held where it was not logged. Raises CompareError if it is not there."""
    values = log.columns.get(name)
    if values is None or not np.isfinite(values).any():
        import difflib

        near = difflib.get_close_matches(name, [c for c in log.columns if c != "t"], n=1)
        hint = f"; nearest is {near[0]!r}" if near else f"; it has {', '.join(c for c in log.columns if c != 't')}"
        raise CompareError(f"{who}: is driven by {name!r}, which the log does not have{hint}")
    known = np.isfinite(values)
    if known.all():
        return values
    last = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return np.asarray(values[np.where(last < 0, int(np.argmax(known)), last)])


def _span(log: Log) -> str:
    return f"{log.t[0]:.1f} to {log.t[-1]:.1f} s" if len(log.t) else "empty"
