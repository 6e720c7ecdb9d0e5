"""MDF 3 and 4 (ASAM) -> streams: a channel group each. Needs the extra `mdf` (asammdf)."""

from __future__ import annotations

import gc
import re
import sys
import traceback
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from openscenario.findings import Findings, listed
from pytest_dvp.logs.account import open_account
from pytest_dvp.logs.budget import Budget
from pytest_dvp.logs.formats.log_format import LogFormat
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mdf_scan import charge_mdf
from pytest_dvp.logs.memory_map import mapped
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.texts import Texts, texts_of

_TIME = 1  # of a master channel that counts seconds; else angle, distance or index. ASAM MDF 4.2.0, cn_sync_type


def _forget(error: BaseException) -> None:
    """Lets go of the half-made file: its end fails in asammdf, and Python would print that below our line."""
    before, sys.unraisablehook = sys.unraisablehook, lambda _: None
    try:
        traceback.clear_frames(error.__traceback__)
        error.__traceback__ = None
        gc.collect()
    finally:
        sys.unraisablehook = before


def read_mdf(path: Path, findings: Findings, msg_dirs: Sequence[Path], budget: Budget | None) -> list[Stream]:
    """Streams by channel group, time from the group's master channel, units from the channels. A group whose master is
    no time is left out, with a warning.

    Raises LogError if asammdf is not installed, the file is too large or cannot be read.
    """
    try:
        from asammdf import MDF
    except ImportError:
        raise LogError(
            f"{path}: MDF files need the package asammdf: pip install -e '.[mdf]' from the checkout",
            "log.extra_missing",
        ) from None
    streams: list[Stream] = []
    why = ""
    try:
        charge_mdf(mapped(path), open_account(path, budget))
        with MDF(str(path)) as file:
            groups: list[Any] = list(file.groups)
            for index, group in enumerate(groups):
                name = _topic(getattr(group.channel_group, "acq_name", ""), index, {one.topic for one in streams})
                fields: dict[str, FloatArray] = {}
                units: dict[str, str] = {}
                texts: dict[str, Texts] = {}
                master = file.masters_db.get(index)
                if master is None or getattr(group.channels[master], "sync_type", _TIME) != _TIME:
                    # asammdf would give the numbers of the samples, or the angles, for seconds
                    if group.channel_group.cycles_nr > 2:
                        text = f"no time: left out with {listed([one.name for one in group.channels], 6)}"
                        findings.add("log.time_missing", str(path), None, name, text, severity="warning")
                    continue
                time = np.asarray(file.get_master(index), dtype=np.float64)
                for number, channel in enumerate(group.channels):
                    if number == master:
                        continue
                    # All samples, as many as stamps; asammdf would leave out those that their bit calls invalid.
                    signal = file.get(group=index, index=number, ignore_invalidation_bits=True)
                    values = np.asarray(signal.samples)
                    if values.ndim == 1 and values.dtype.kind in "fiub":
                        fields[channel.name] = _valid(values.astype(np.float64), signal.invalidation_bits)
                        if signal.unit:
                            units[channel.name] = str(signal.unit)
                    elif (found := _words(values, signal.invalidation_bits)) is not None:
                        texts[channel.name] = found
                if len(time) > 2 and (fields or texts):
                    streams.append(Stream(name, "mdf", time, fields, units, texts=texts))
    except LogError:
        raise
    except Exception as error:  # asammdf raises many kinds on a damaged file; all mean: not readable
        told = re.sub(r"'?<mmap[^>]*>'?", "it", str(error)) or type(error).__name__
        why = f"{path}: the MDF file cannot be read, cut or damaged: {told}".split("\n")[0]
        _forget(error)
    if why:
        raise LogError(why, "log.not_mdf")
    if not streams:
        raise LogError(f"{path}: no channel group with numbers over time", "log.foreign")
    return streams


def _topic(name: str, index: int, taken: Collection[str]) -> str:
    """The name of a group, with its number where it has none, or where an earlier one has the same (two messages of one
    bus). MDF 3 knows no names of groups."""
    return name if name and name not in taken else f"{name or 'group'} {index}"


def _valid(values: FloatArray, invalid: Any) -> FloatArray:
    """The values (n,), NaN where the file says by a bit (n,) that a sample does not count."""
    return values if invalid is None else np.where(np.asarray(invalid, dtype=np.bool_), np.nan, values)


def _words(values: Any, invalid: Any) -> Texts | None:
    """The words (n,) of a channel whose conversion gives text, as a table of a DBC does; None for other samples."""
    if values.ndim != 1 or values.dtype.kind not in "SUO":
        return None
    counted = np.ones(len(values), bool) if invalid is None else ~np.asarray(invalid, dtype=np.bool_)
    told = (v.decode("utf-8", "replace") if isinstance(v, bytes) else v for v in values.tolist())
    return texts_of(v.strip() if ok and isinstance(v, str) else None for v, ok in zip(told, counted, strict=True))


FORMAT = LogFormat(
    "mdf",
    (".mf4", ".mdf", ".dat"),
    ((b"MDF     ", "an MDF file"), (b"UnFinMF ", "an MDF file that was not finished")),
    read_mdf,
    common=(".dat",),
)
