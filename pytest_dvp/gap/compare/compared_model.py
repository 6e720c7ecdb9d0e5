"""Models as something that answers a log's commands with motion: ours, and a second log; see also step_function, fmu.

Around a model made elsewhere the command path and the sensors of our kernel can be wrapped: `output(..., values=...)`
with values of effects, as of `vehicle.model.open_loop.Replay.run`, and `why_not` says which effects that cannot judge.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Protocol, TypeAlias

import numpy as np

from pytest_dvp.gap.compare.segments import CHANNELS, Segments, longest_step, posed
from pytest_dvp.gap.compare.start_correction import BoolArray
from pytest_dvp.logs.engagement import asks, driven_by_others
from pytest_dvp.logs.held_values import held
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.obeyed_commands import obeyed_command
from pytest_dvp.logs.signals import SIGNALS, describe
from vehicle.model.command_inputs import MEASURED as MEASURED_INPUTS

if TYPE_CHECKING:
    from openscenario.findings import Finding
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel
    from vehicle.model.wrapped_model import Wrapped

Values: TypeAlias = Mapping[tuple[str, str], float]
"""(effect, key) -> value."""

MEASURED = {"steer_cmd": ("steer", 'steer = "steer"'), "accel_cmd": ("v", 'longitudinal = "v"')}
"""What is measured of a command's answer, and how the model file says that this drives it."""

NEAREST = 3  # columns that a message names

MOTION = ("x", "y", "yaw", "v", "vy", "yaw_rate")
"""What is set at the start of a segment, in the order of `Segments.states`."""


class CompareError(ValueError):
    """A log and a model cannot be compared; the message is one line and says what is missing."""


class ComparedModel(Protocol):
    """What `compare` compares a log with.

    name    for tables
    inputs  log columns it is driven by; these are not compared
    held    channels that say nothing about it, as they are imposed or follow from what is
    restarts  True if its output begins each segment in the segment's state
    """

    name: str
    imposed_channels: tuple[str, ...]
    restarts: bool

    @property
    def inputs(self) -> tuple[str, ...]:
        """The columns that drive it, as above."""
        ...

    def output(self, log: Log, segments: Segments, values: Values | None = None) -> FloatArray:
        """Channels (n, 8) in their units at the stamps of the log, NaN where it has none, from each segment's start.

        `values` of effects are added to the model or wrapped around it. Raises CompareError, and ModelError for an
        effect, key or value that is not there or that cannot be judged.
        """
        ...

    def why_not(self, effect: Effect, log: Log, given: Collection[str]) -> str:
        """Why an effect cannot be judged with this model and log, empty if it can; `given`: channels of its output."""
        ...


def at_place_of(log: Log, model: VehicleModel) -> VehicleModel:
    """The model with its accelerometer where that of the log is: a run of the twin logs what its reference point does,
    wherever the car that the model is of has its accelerometer (ax_x, ay_x)."""
    return model.with_car({"ax_x": 0.0, "ay_x": 0.0}) if log.meta.get("stage") == "dt" else model


class ModelSubject:
    """A vehicle model of ours, restarted at each segment; actuators run on. `extra` are effects of the user's own."""

    restarts = True

    def __init__(self, model: VehicleModel, name: str = "", extra: Iterable[Effect] = ()) -> None:
        self.model = model
        self.name = name or model.name or model.base
        self.inputs: tuple[str, ...] = (model.inputs.steer, *model.inputs.longitudinal)
        self.imposed_channels: tuple[str, ...] = ("v", "ax") if "v" in self.inputs else ()
        self._extra = tuple(extra)

    def output(self, log: Log, segments: Segments, values: Values | None = None) -> FloatArray:
        """Channels (n, 8) in their units that the log's commands make the model show, restarted at each segment.

        Raises CompareError for a command that the log lacks, ModelError for an effect, key or value that is not there.
        """
        from vehicle.model.open_loop import Replay

        commands = {name: command_at_stamps(log, name, self.name) for name in self.inputs}
        replay = Replay(at_place_of(log, self.model), log.t, commands, extra=self._extra)
        return np.asarray(replay.run(values, starts=segments.starts, states=segments.states))

    def why_not(self, effect: Effect, log: Log, given: Collection[str]) -> str:
        """Why an effect cannot be judged, empty if it can: all can but those that act on detected objects."""
        return "acts on detected objects" if effect.slot == "perception" else ""


class LogSubject:
    """A model's own output, on the same clock as the measured log; only pose and speed are matched in each segment.

    Sensor effects can be wrapped around it; what its commands would have done otherwise, nobody knows.
    """

    imposed_channels: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    restarts = False

    def __init__(
        self, log: Log, name: str = "second log", findings: tuple[Finding, ...] = (), extra: Iterable[Effect] = ()
    ) -> None:
        self.log, self.name, self.findings = log, name, findings
        self._extra = tuple(extra)

    def output(self, log: Log, segments: Segments, values: Values | None = None) -> FloatArray:
        """Channels (n, 8) of the second log at the stamps of `log`, in their units, from each segment's measured start.

        Raises CompareError if the two logs have no time in common, ModelError for an effect that cannot be wrapped
        around one.
        """
        t = self.log.t
        if len(t) < 2 or t[-1] < log.t[0] or t[0] > log.t[-1]:
            raise CompareError(
                f"{self.name}: has no time in common with the log "
                f"({_span(self.log)} and {_span(log)}); cut or shift one of them"
            )
        found = self.at(log.t)
        return posed(wrapping(log, values, self._extra, self.name, ()).sensors(found, values or {}), segments)

    def at(self, t: FloatArray) -> FloatArray:
        """The channels (n, 8) at the stamps t (n,) [s] by straight lines; NaN before, after and in holes, which are
        longer than longest_step of the channel."""
        found = np.full((len(t), len(CHANNELS)), np.nan)
        for k, name in enumerate(CHANNELS):
            column = self.log.columns.get(name)
            if column is None or np.isfinite(column).sum() < 2:
                continue
            known = np.isfinite(column)
            stamps, values = self.log.t[known], column[known]
            if name == "yaw":
                values = np.unwrap(values)
            after = np.clip(np.searchsorted(stamps, t), 1, len(stamps) - 1)
            spans = stamps[after] - stamps[after - 1]
            inside = (t >= stamps[0] - 1e-9) & (t <= stamps[-1] + 1e-9)
            on_one = np.minimum(np.abs(t - stamps[after]), np.abs(t - stamps[after - 1])) < 1e-9
            there = inside & ((spans <= longest_step(stamps)) | on_one)
            found[there, k] = np.interp(t[there], stamps, values)
        return found

    def why_not(self, effect: Effect, log: Log, given: Collection[str]) -> str:
        """Why an effect cannot be judged, empty if it can: only sensor effects can, as a log is not driven again."""
        from vehicle.model.wrapped_model import why_not

        if effect.slot in ("command", "actuator"):
            return "acts on commands, and a log is not driven again"
        return why_not(effect, (), given)


def command_at_stamps(log: Log, name: str, who: str, called: str = "the log") -> FloatArray:
    """A command of the log at each stamp (n,) in its SI unit, held where it was not logged; of what is measured in
    place of a command, the straight line between its samples.

    `who` is driven by it, `called` names the log in the error. Of a run with a command gate before the car it is what
    the gate let out: its limits are not the car's. Raises CompareError if the log does not have the command.
    """
    values = obeyed_command(log, name)
    if values is not None and not np.isfinite(values).any():
        never = " while the stack drives (column engaged)" if driven_by_others(log).any() else ""
        raise CompareError(f"{who}: is driven by {name!r}, of which {called} has the column but no value{never}")
    if values is None:
        raise CompareError(f"{who}: is driven by {name!r}, which {called} does not have{_instead(log, name)}")
    known = np.isfinite(values)
    if known.all():
        return values
    if name in MEASURED_INPUTS:
        return np.asarray(np.interp(log.t, log.t[known], values[known]))
    first = values[np.argmax(known)]  # what was asked for before the first message is not known
    return np.nan_to_num(held(values), nan=first)


def _instead(log: Log, name: str) -> str:
    """What the log has instead, and how to say that it is the command."""
    import difflib

    from pytest_dvp.logs.column_names import resembling

    names = [c for c in log.columns if c != "t"]
    near = resembling(name, [c for c in names if c not in SIGNALS]) or next(
        iter(difflib.get_close_matches(name, names, n=1)), ""
    )
    others = difflib.get_close_matches(name, [c for c in names if c != near], n=NEAREST, cutoff=0.0)
    few = [c for c in (near, *others) if c][:NEAREST]
    said = f"; nearest of its {len(names)} columns: {', '.join(few)}" if few else ""
    answer, stated = MEASURED.get(name, ("", ""))
    if answer in log.columns:
        said += f"; what was measured can drive the model instead: [inputs] {stated}"
    say = "; say which column it is in a mapping (`dvp map LOG > map.toml`, then --map map.toml)"
    return f"{said}{f'; did you mean {near!r}?' if near and near not in SIGNALS else ''}{say}"


def rows_with_commands(log: Log, subject: ComparedModel) -> list[BoolArray]:
    """Masks (n,) of the rows in which a command that drives the model was logged, and not while somebody else drove;
    none for a command without gaps. A model that does not say what drives it takes every column of a command."""
    names = subject.inputs or tuple(name for name in log.columns if asks(name))
    obeyed = ~driven_by_others(log)
    found = [
        np.isfinite(log.columns[name]) & (obeyed if _commands(name) else True) for name in names if name in log.columns
    ]
    return [rows for rows in found if not rows.all()]


def unheeded_rows(log: Log, subject: ComparedModel) -> BoolArray:
    """Rows (n,) of the log in which somebody else drove than what drives the model; none if only measured motion does.

    True or False, without a unit.
    """
    names = subject.inputs or tuple(name for name in log.columns if asks(name))
    driven = any(_commands(name) for name in names if name in log.columns)
    return driven_by_others(log) if driven else np.zeros(len(log.t), dtype=np.bool_)


def _commands(name: str) -> bool:
    """Whether a column may be a command: what is known to be measured is none."""
    return name not in SIGNALS or describe(name).keeps_value


def rows_with_motion(log: Log, subject: ComparedModel) -> list[BoolArray]:
    """Mask (n,) of the rows in which a model that is a log has all the motion that it ever has.

    Empty for a model that is driven by commands, and for a log without gaps.
    """
    if not isinstance(subject, LogSubject):
        return []
    there = np.isfinite(subject.at(log.t)[:, :5])
    rows: BoolArray = np.asarray(there[:, there.any(axis=0)].all(axis=1))
    return [] if rows.all() else [rows]


def wrapping(log: Log, values: Values | None, extra: Iterable[Effect], who: str, commands: Collection[str]) -> Wrapped:
    """The kernel's command path and sensors for the stamps of a log, with `values` checked.

    `commands`: columns that drive the box. Raises ModelError for an effect that cannot be wrapped around `who`.
    """
    from vehicle.model.effect import SLOTS
    from vehicle.model.errors import ModelError
    from vehicle.model.wrapped_model import Wrapped, why_not

    wrapped = Wrapped(log.t, extra)
    for effect in wrapped.active(values or {}, SLOTS):
        reason = why_not(effect, commands, CHANNELS)
        if reason:
            raise ModelError(f"cannot be wrapped around {who}: {reason}", key=effect.name)
    return wrapped


def _span(log: Log) -> str:
    return f"{log.t[0]:.1f} to {log.t[-1]:.1f} s" if len(log.t) else "empty"
