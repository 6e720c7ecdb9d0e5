"""The catalogue of metrics and the one way to evaluate them."""

from __future__ import annotations

import dataclasses
import difflib
import functools
import importlib
import math
import pkgutil
import traceback
import weakref
from collections.abc import Iterable, Iterator, Mapping
from importlib.metadata import entry_points
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, TypeVar

import numpy as np

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, FloatArray, ObjectTrack
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.obeyed_commands import divergence_time
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics.metric import REQUIRED, Measured, Metric, MetricError, MetricValue

ENTRY_POINTS = "pytest_dvp.metrics"
Table = TypeVar("Table", ObjectTrack, DetectionTable)

# By log: the columns and tracks that it had, and the log of views made of them
_VIEWS: weakref.WeakKeyDictionary[Log, tuple[dict[str, Any], dict[str, Any], Log]] = weakref.WeakKeyDictionary()


@functools.cache
def known_metrics() -> Mapping[str, Metric]:
    """All metrics by name: ours, then those of other packages (entry point: a module or a Metric).

    Raises MetricError if two have the same name or an entry point cannot be loaded.
    """
    found: dict[str, Metric] = {}
    for origin, candidate in _candidates():
        if candidate.name in found and found[candidate.name] is not candidate:
            raise MetricError(f"two metrics are named {candidate.name!r}, one of them from {origin}")
        found[candidate.name] = candidate
    return MappingProxyType(found)


def _candidates() -> Iterator[tuple[str, Metric]]:
    for module in sorted(m.name for m in pkgutil.iter_modules(importlib.import_module(str(__package__)).__path__)):
        if not module.startswith("_") and module not in ("metric", "registry"):
            yield from _metrics_of(importlib.import_module(f"{__package__}.{module}"), module)
    for point in sorted(entry_points(group=ENTRY_POINTS), key=lambda p: p.name):
        try:
            loaded = point.load()
        except Exception as error:  # a foreign package may raise anything while it loads
            raise MetricError(f"entry point {point.name!r} of {ENTRY_POINTS} cannot be loaded: {error}") from error
        yield from _metrics_of(loaded, point.name)


def _metrics_of(thing: object, origin: str) -> Iterator[tuple[str, Metric]]:
    values: Iterable[object] = vars(thing).values() if isinstance(thing, ModuleType) else [thing]
    yield from ((origin, value) for value in values if isinstance(value, Metric))


def find_metric(name: str) -> Metric:
    """Metric by name. Raises MetricError with the nearest name."""
    known = known_metrics()
    if name in known:
        return known[name]
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    raise MetricError(f"unknown metric {name!r}; " + (f"nearest is {near[0]!r}" if near else f"known: {sorted(known)}"))


def check_options(chosen: Metric, options: Mapping[str, Any]) -> None:
    """Raises MetricError for an option the metric does not have, one of the wrong type or out of its range,
    or a missing one."""
    for key, value in options.items():
        if key not in chosen.options:
            near = difflib.get_close_matches(key, chosen.options, n=1)
            hint = f"nearest is {near[0]!r}" if near else f"it has {sorted(chosen.options) or 'none'}"
            raise MetricError(f"metric {chosen.name!r} has no option {key!r}; {hint}")
        default = chosen.options[key]
        kind = chosen.types.get(key, type(default))
        if issubclass(kind, float) and not _is_number(value):
            raise MetricError(f"option {key!r} of metric {chosen.name!r} must be a finite number, found {value!r}")
        if key in chosen.ranges and _is_number(value) and not chosen.ranges[key].holds(value):
            held = chosen.ranges[key]
            raise MetricError(f"option {key!r} of metric {chosen.name!r} must be {held}, found {value:g}")
        if issubclass(kind, str) and not isinstance(value, str):
            raise MetricError(f"option {key!r} of metric {chosen.name!r} must be a word, found {value!r}")
        if key in chosen.words and value not in chosen.words[key]:
            allowed = ", ".join(chosen.words[key])
            raise MetricError(f"option {key!r} of metric {chosen.name!r}: found {value!r}, allowed: {allowed}")
        if isinstance(default, tuple) and not (
            isinstance(value, list | tuple) and all(isinstance(v, str) for v in value)
        ):
            raise MetricError(f"option {key!r} of metric {chosen.name!r} must be a list of words, found {value!r}")
    missing = [key for key, default in chosen.options.items() if default is REQUIRED and key not in options]
    if missing:
        raise MetricError(f"metric {chosen.name!r} needs the option {missing[0]!r}")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _unwritable(log: Log) -> Log:
    """The log as metrics see it: they cannot write its numbers, or replace its columns or tracks.

    Made once for all metrics, and again when the owner of the log has replaced a column or a track.
    """
    kept = _VIEWS.get(log)
    if kept is None or not (_same(kept[0], log.columns) and _same(kept[1], log.objects)):
        kept = _VIEWS[log] = (dict(log.columns), dict(log.objects), _views(log))
    return kept[2]


def _same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return one.keys() == other.keys() and all(one[name] is other[name] for name in one)


def _views(log: Log) -> Log:
    return dataclasses.replace(
        log,
        columns=MappingProxyType({name: _locked(column) for name, column in log.columns.items()}),
        objects=MappingProxyType({name: _of_locked(track) for name, track in log.objects.items()}),
        detections=_of_locked(log.detections),
        paths=tuple((t, _locked(points)) for t, points in log.paths),
        reference=_locked(log.reference),
    )


def _of_locked(table: Table) -> Table:
    held = {field.name: getattr(table, field.name) for field in dataclasses.fields(table)}
    arrays: dict[str, Any] = {name: _locked(value) for name, value in held.items() if isinstance(value, np.ndarray)}
    return dataclasses.replace(table, **arrays)


def _locked(array: FloatArray) -> FloatArray:
    view = np.asarray(array).view()
    view.setflags(write=False)
    return view


def measured(name: str, log: Log) -> MetricValue:
    """A metric of one log with its defaults; one that fails, perhaps a user's, is not valid and says where."""
    try:
        return compute(name, log)
    except Exception as error:  # it must not cost the run and all other metrics
        return MetricValue(name, None, find_metric(name).unit, None, "", False, why_failed(error), None, {}, "")


def why_failed(error: Exception) -> str:
    """What to say of a metric that raised, with FILE:LINE of what raised; a MetricError says it all itself."""
    if isinstance(error, MetricError):
        return str(error)
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"the metric failed: {type(error).__name__}: {error} ({Path(last.filename).name}:{last.lineno})"


def compute(name: str, log: Log, other: Log | None = None, **options: Any) -> MetricValue:
    """Evaluate a metric of one log, or of two: `log` is then the model's and `other` the measured one.

    Undefined metrics are not valid and say why; a value that is not finite never is. It is given a log whose columns,
    tracks, detections and paths it cannot write. Raises MetricError for an unknown name or option, or for a metric that
    gives no Measured, and what the metric raises.
    """
    chosen = find_metric(name)
    check_options(chosen, options)
    note = chosen.note.format(**{**chosen.options, **options}) if chosen.note else ""

    def invalid(reason: str) -> MetricValue:
        return MetricValue(name, None, chosen.unit, None, "", False, reason, None, {}, note)

    if chosen.logs == 2 and other is None:
        return invalid("the log to compare with is not there")
    logs = [log] if chosen.logs == 1 or other is None else [log, other]
    if any(len(one.t) < 2 for one in logs):
        return invalid("the log has no samples")
    apart = next((t for one in logs if (t := divergence_time(one)) is not None), None)
    if not chosen.open_loop and apart is not None:
        return invalid(f"the ego's motion is a recording's, and from t={apart:.2f} s on the stack asked for another")
    try:
        with np.errstate(all="ignore"):  # an absurd log may overflow: not finite is not valid
            result = chosen(*map(_unwritable, logs), **options)
    except (Undefined, LogError) as error:
        return invalid(str(error).removeprefix("log: "))
    if not isinstance(result, Measured):
        raise MetricError(f"metric {name!r} gave {type(result).__name__}, expected Measured")
    value = float(result.value)
    if not math.isfinite(value):
        return invalid(f"the value is {value}")
    t = None if result.t is None or not math.isfinite(result.t) else float(result.t)
    extra = {key: float(number) for key, number in result.extra.items()}
    unit = result.unit or chosen.unit
    return MetricValue(name, value, unit, t, result.object, True, "", result.series, extra, note)
