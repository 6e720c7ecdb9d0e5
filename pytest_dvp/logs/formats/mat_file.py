"""MATLAB .mat (v4 to v7) -> streams: vectors of one length belong together; a struct of vectors is a group."""

from __future__ import annotations

from collections.abc import Sequence
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
    _group(str(path), "", {k: v for k, v in found.items() if not k.startswith("__")}, streams, findings, 0)
    if not streams:
        raise LogError(f"{path}: no vectors with a time of the same length (`t_s`, `time`)", "log.time_missing")
    return streams


FORMAT = LogFormat("mat", (".mat",), ((b"MATLAB ", "a .mat file"),), read_mat, common=(".mat",))


def _group(
    file: str, topic: str, items: dict[str, Any], streams: list[Stream], findings: Findings, depth: int
) -> None:  # fmt: skip
    vectors: dict[str, FloatArray] = {}
    for name, value in items.items():
        if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "fiub" and len(value) > 2:
            vectors[name] = value.astype(np.float64)
        elif hasattr(value, "_fieldnames") and depth < 4:
            inner = {str(n): getattr(value, n) for n in value._fieldnames}
            _group(file, f"{topic}/{name}" if topic else name, inner, streams, findings, depth + 1)
    lengths: set[int] = set()
    for name, values in vectors.items():
        header = parse_header(name)
        if canonical(header.name) != "t" or len(values) in lengths:
            continue
        unit = find_unit(header.unit or "s")
        t = values * (unit.scale if unit is not None and unit.si == "s" else 1.0)
        fields = {n: v for n, v in vectors.items() if n != name and len(v) == len(t)}
        units = {n: u for n in fields if (u := parse_header(n).unit) is not None}
        own = f"{topic}/{name}".strip("/") if lengths else topic  # a second rate beside the first
        streams.append(Stream(own, "mat", t, fields, units))
        lengths.add(len(t))
    lost = [n for n, v in vectors.items() if canonical(parse_header(n).name) in SIGNALS and len(v) not in lengths]
    if lost and lengths:
        found = listed([f"{name} ({len(vectors[name])} values)" for name in lost], 8)
        findings.add(
            "log.time_missing", file, None, topic, "signals without a time of their length are left out", found=found,
            allowed=f"as many values as a time of the same struct, {listed(sorted(map(str, lengths)), 4)}",
            severity="warning",
        )  # fmt: skip
