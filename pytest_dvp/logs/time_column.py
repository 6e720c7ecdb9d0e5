"""Which column of a file holds the time, and in which unit, where the file does not say it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from openscenario.findings import listed
from pytest_dvp.logs.column_names import canonical
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.units import UNITS, find_unit


def clock_of(streams: Sequence[Stream]) -> tuple[list[Stream], str, str]:
    """What `time` of the mapping is to be, and a remark; the streams with those stamps, if their file names none."""
    remark = '"header": stamp of the sender; "receive": stamp of the recorder; or a field'
    if any(s.header is not None for s in streams):
        return list(streams), "header", remark
    if len(streams) != 1 or (np.isfinite(streams[0].receive).any() and not bare_time(streams[0])):
        return list(streams), "receive", remark
    (stream,) = streams
    if bare := bare_time(stream):
        stamps = stream.fields[bare] * UNITS[unit_of_steps(stream.fields[bare])].scale
        return [dataclasses.replace(stream, receive=stamps)], bare, remark
    steps = {field: _even_step(values) for field, values in stream.fields.items()}
    rising = [field for field, step in steps.items() if step > 0.0]
    counts = {field for field in rising if steps[field] == 1.0 and stream.units.get(field, "-") == "-"}  # 1, 2, 3
    clocks = [field for field in rising if field not in counts] or rising
    if not clocks:
        return [stream], "receive", "no field rises from row to row: put in the one with the time"
    unit = find_unit(stream.units.get(clocks[0], "")) or UNITS[unit_of_steps(stream.fields[clocks[0]])]
    stamps = stream.fields[clocks[0]] * (unit.scale if unit.si == "s" else 1.0)
    others = f"; so does {listed(clocks[1:], 3)}" if len(clocks) > 1 else ""
    said = f"a guess: rises by about {steps[clocks[0]]:.4g} from row to row{others}"
    return [dataclasses.replace(stream, receive=stamps)], clocks[0], said


def bare_time(stream: Stream) -> str:
    """The column of a CSV file that is called a time and does not say its unit; "" if there is none."""
    return next((f for f in stream.fields if not stream.topic and canonical(f) == "t" and f not in stream.units), "")


def unit_of_steps(stamps: FloatArray) -> str:
    """The unit in which a log with these stamps (n,) has 0.5 to 20,000 rows a second, seconds first."""
    steps = np.diff(stamps[np.isfinite(stamps)])
    usual = float(np.median(steps)) if len(steps) else 0.0
    return next((name for name in ("s", "ms", "us", "ns") if 5e-5 <= usual * UNITS[name].scale <= 2.0), "s")


def time_unit(streams: Sequence[Stream], clock: str) -> list[str]:
    """The line that says the unit of the column with the time, where the file does not."""
    stream = next((s for s in streams if clock in s.fields), None)
    if stream is None or clock in stream.units:
        return []
    usual = unit_of_steps(stream.fields[clock])
    return [f'time_unit = "{usual}"           # the file does not say it; a guess by the steps from row to row']


def _even_step(values: FloatArray) -> float:
    """The usual step of what rises all along, in steps that are mostly alike; 0 for anything else."""
    steps = np.diff(values)
    if len(steps) < 2 or not np.all(steps > 0.0):
        return 0.0
    usual = float(np.median(steps))
    return round(usual, 9) if np.mean(np.abs(steps - usual) < 0.5 * usual) > 0.9 else 0.0
