"""MATLAB .mat (v4 to v7) -> streams: vectors of one length belong together; a struct of vectors is a group, whose time
may stand in a struct around it, and one of a time and `Data` is a signal that has the name of the struct."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from openscenario.findings import Findings, listed
from pytest_dvp.logs.account import open_account
from pytest_dvp.logs.budget import Budget
from pytest_dvp.logs.column_names import canonical, parse_header
from pytest_dvp.logs.formats.log_format import LogFormat
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mat_scan import numbers_in
from pytest_dvp.logs.memory_map import mapped
from pytest_dvp.logs.signals import SIGNALS
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.units import find_unit


def read_mat(path: Path, findings: Findings, msg_dirs: Sequence[Path], budget: Budget | None) -> list[Stream]:
    """Streams by struct (top level: the file). Names state units as in CSV, `v_mps`; others need a mapping.

    Raises LogError: not a .mat file, version 7.3 (HDF5), too large, or no vectors with a time.
    """
    account = open_account(path, budget)
    data = mapped(path)
    if b"MATLAB 7.3" in data[:128]:
        raise LogError(f"{path}: version 7.3; save it with -v7", "log.mat_version")
    try:
        names = numbers_in(data, account)
        from scipy.io import loadmat

        found = loadmat(str(path), squeeze_me=True, struct_as_record=False, variable_names=names) if names else {}
    except LogError:
        raise
    except Exception as error:  # scipy raises many kinds on a damaged file; all mean: not readable
        raise LogError(f"{path}: not a .mat file: {error}".split("\n")[0], "log.not_mat") from None
    streams: list[Stream] = []
    _group(str(path), "", {k: v for k, v in found.items() if not k.startswith("__")}, {}, streams, findings)
    if not streams:
        raise LogError(f"{path}: no vectors with a time of the same length (`t_s`, `time`)", "log.time_missing")
    return streams


_DATA = ("data", "value", "values")  # of one signal beside its time
_UNIT = ("unit", "units")

FORMAT = LogFormat("mat", (".mat",), ((b"MATLAB ", "a .mat file"),), read_mat, common=(".mat",))


def _group(
    file: str, topic: str, items: dict[str, Any], around: Mapping[int, FloatArray], streams: list[Stream],
    findings: Findings,
) -> None:  # fmt: skip
    """Add the streams of a struct, and of the structs in it. around: times [s] of the structs around it, by length."""
    items = _labelled(items)
    vectors = {
        name: value.astype(np.float64)
        for name, value in items.items()
        if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "fiub" and len(value) > 2
    }
    own: dict[int, tuple[str, FloatArray]] = {}
    for name, values in vectors.items():
        header = parse_header(name)
        if canonical(header.name) == "t" and len(values) not in own:
            unit = find_unit(header.unit or "s")
            own[len(values)] = name, values * (unit.scale if unit is not None and unit.si == "s" else 1.0)
    times = {**around, **{length: t for length, (_, t) in own.items()}}
    for name, value in items.items():
        for part, inner in _structs(name, value):
            if _label(inner):  # is a signal of this struct
                continue
            _group(file, f"{topic}/{part}" if topic else part, _named(part, inner), times, streams, findings)
    for length, t in times.items():
        time = own[length][0] if length in own else ""
        if fields := {n: v for n, v in vectors.items() if n != time and len(v) == length}:
            units = {n: u for n in fields if (u := parse_header(n).unit) is not None}
            beside = time and length != next(iter(own))  # a second rate beside the first
            streams.append(Stream(f"{topic}/{time}".strip("/") if beside else topic, "mat", t, fields, units))
    lost = [n for n, v in vectors.items() if canonical(parse_header(n).name) in SIGNALS and len(v) not in times]
    if lost and times:
        found = listed([f"{name} ({len(vectors[name])} values)" for name in lost], 8)
        findings.add(
            "log.time_missing", file, None, topic, "signals without a time of their length are left out", found=found,
            allowed=f"as many values as a time of this struct or one around it, {listed(sorted(map(str, times)), 4)}",
            severity="warning",
        )  # fmt: skip


def _structs(name: str, value: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """The struct of a value, or each of an array of them, with its fields."""
    several = isinstance(value, np.ndarray) and value.dtype.kind == "O"
    for k, one in enumerate(value.ravel() if several else [value], 1):
        if hasattr(one, "_fieldnames"):
            yield f"{name}({k})" if several else name, {str(n): getattr(one, n) for n in one._fieldnames}


def _named(part: str, items: dict[str, Any]) -> dict[str, Any]:
    """The fields of a struct; of one that holds a time and the `Data` of one signal, with its unit if it tells it, as
    `timeseries` do, the signal under the name of the struct."""
    data = [name for name in items if name.lower() in _DATA]
    if len(data) != 1 or not any(canonical(parse_header(name).name) == "t" for name in items):
        return items
    signal = part.rsplit("/", 1)[-1]
    unit = next((items[name] for name in items if name.lower() in _UNIT and isinstance(items[name], str)), "").strip()
    if unit and parse_header(signal).unit is None:
        signal = f"{signal} [{unit}]"
    return {signal if name == data[0] else name: value for name, value in items.items()}


def _labelled(items: dict[str, Any]) -> dict[str, Any]:
    """The fields of a struct, with the `values` of Simulink's `signals` ("Structure With Time") under their `label`."""
    found = {}
    for name, value in items.items():
        for _, inner in _structs(name, value):
            if label := _label(inner):
                found[label] = inner["values"]
    return {**items, **found}


def _label(items: dict[str, Any]) -> str:
    label = items.get("label")
    return label.strip() if isinstance(label, str) and "values" in items else ""
