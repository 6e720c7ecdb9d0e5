"""Mapping files: which field of a foreign log is which signal, in which unit, sign and frame, by which clock."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from openscenario.findings import Findings, listed, nearest
from pytest_dvp.logs.column_names import Header, canonical
from pytest_dvp.logs.combined_fields import MARK, combined, way_of, yaw_of_quaternion
from pytest_dvp.logs.held_values import held
from pytest_dvp.logs.infinite_values import without_infinite
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mapped_modes import MODES, check_modes, has_modes, is_mode_value, obeyed_in
from pytest_dvp.logs.signals import SIGNALS, describe
from pytest_dvp.logs.stream import Stream, is_stamp
from pytest_dvp.logs.table import RawColumn, Table
from pytest_dvp.logs.time_column import clock_of
from pytest_dvp.logs.topic_clocks import check_stamps, on_one_clock
from pytest_dvp.logs.units import find_unit, units_of
from vehicle.toml_file import TomlError, read_toml

EARTH = 6378137.0  # WGS 84 semi-major axis [m]
FLATTENING = 1 / 298.257223563  # WGS 84
QUATERNION, LATITUDE, LONGITUDE = "quaternion", "latitude", "longitude"
LATITUDE_DDMM, LONGITUDE_DDMM = "latitude ddmm", "longitude ddmm"
_FIXES = {LATITUDE: LATITUDE, LONGITUDE: LONGITUDE, LATITUDE_DDMM: LATITUDE, LONGITUDE_DDMM: LONGITUDE}
_IN_THE_CAR = frozenset(("vy", "ay", "yaw_rate", "steer", "steer_cmd"))  # turned round by y to the right, z downwards
_FLIPPED = {"frd": _IN_THE_CAR | {"y", "yaw"}, "ned": _IN_THE_CAR, "flu": frozenset[str]()}
STAMP = 1e-6  # [s]: stamps nearer than this are one


@dataclasses.dataclass(frozen=True)
class SignalMap:
    """One signal of the log from one field of the file: SI value = sign * scale * (unit -> SI) / ratio + offset.

    unit    of the field; "quaternion" (yaw from `FIELD.x` .. `.w`), "latitude", "longitude" (x, y from degrees),
            "latitude ddmm", "longitude ddmm" (from degrees and minutes as NMEA 0183 writes them: 5213.14 is 52.219);
            of these, sign * scale * field are the degrees
            "mean of UNIT", "norm of UNIT", "rate of UNIT" for `field = "A + B"`
    ratio   hand wheel to road wheel, for steering
    frame   "flu" (x forward, y left; yaw counter-clockwise from the x axis), "frd" (y to the right, yaw clockwise) or
            "ned" (as "frd", but yaw is a compass heading, clockwise from north; not for x and y, whose fields say it)
    time    "header", "receive" or the name of a field with the time [s]
    delay   [s] that the stamps come too late; taken off them
    when    the signal is 1 where the field (each one of "A + B") is one of these numbers or words, else 0: a mode in
            which the car obeys its commands
    """

    name: str
    topic: str = ""
    field: str = ""
    unit: str = ""
    scale: float = 1.0
    sign: float = 1.0
    offset: float = 0.0
    ratio: float = 1.0
    frame: str = "flu"
    time: str = ""
    delay: float = 0.0
    when: tuple[float | str, ...] = ()


@dataclasses.dataclass(frozen=True)
class MappingFile:
    """A mapping.

    time     default clock of the signals; time_unit: of a field that holds it, where the file does not state one
    origin   latitude, longitude [deg] of x = y = 0; None: the first fix
    antenna  x ahead, y left of the reference point [m] of what measured x, y
    only     leave out every field that is not named; else those that state their signal and unit are taken as well
    """

    signals: tuple[SignalMap, ...]
    time: str = "header"
    origin: tuple[float, float] | None = None
    antenna: tuple[float, float] = (0.0, 0.0)
    file: str = ""
    only: bool = False
    time_unit: str = ""


def read_mapping(path: Path) -> MappingFile:
    """Raises LogError naming file and key, with the nearest valid name."""
    try:
        raw, _ = read_toml(path)
    except TomlError as error:
        text = f"the mapping cannot be read: {error}" if error.kind == "unreadable" else str(error)
        raise LogError(f"{error.at(path)}: {text}", "log.bad_mapping") from None
    head = _table(path, raw, {"log": dict, "signal": list}, "")
    log = _table(
        path,
        head.get("log", {}),
        {"time": str, "time_unit": str, "origin": list, "antenna": list, "only": bool},
        "log.",
    )
    known: dict[str, type] = {
        field.name: {"str": str, "float": float}.get(str(field.type), list) for field in dataclasses.fields(SignalMap)
    }
    signals = tuple(
        SignalMap(**_table(path, entry, known, f"signal[{i}].")) for i, entry in enumerate(head.get("signal", []))
    )
    signals = tuple(dataclasses.replace(signal, name=canonical(signal.name)) for signal in signals)
    if not signals:
        raise LogError(
            f"{path}: no [[signal]]; `dvp map LOG` proposes some; its guesses stand behind a # that is to go",
            "log.bad_mapping",
        )
    names = [signal.name for signal in signals]
    for signal in signals:
        if names.count(signal.name) > 1:
            raise LogError(f"{path}: {signal.name} is named {names.count(signal.name)} times", "log.bad_mapping")
        if signal.frame not in _FLIPPED:
            raise _bad(path, f"{signal.name}.frame", signal.frame, "flu, frd, ned")
        if signal.frame == "ned" and signal.name in ("x", "y"):
            raise _bad(path, f"{signal.name}.frame", "ned", "none; x takes the field of the east, y that of the north")
        if signal.frame != "flu" and signal.unit in _FIXES:
            raise _bad(path, f"{signal.name}.frame", signal.frame, "none; degrees of latitude and longitude have one")
        plain = SignalMap(
            signal.name, signal.topic, signal.field, time=signal.time, delay=signal.delay, when=signal.when
        )
        if signal.when and signal != plain:
            raise _bad(
                path,
                f"{signal.name}.when",
                str(list(signal.when)),
                "no unit, scale, sign, offset, ratio or frame beside it: a mode has none",
            )
        if signal.ratio == 0.0 or signal.scale == 0.0 or signal.sign not in (1.0, -1.0):
            raise _bad(path, signal.name, "", "ratio and scale not 0, sign 1 or -1")
    unit = find_unit(log.get("time_unit", "s"))
    if unit is None or unit.si != "s":
        raise _bad(path, "log.time_unit", log["time_unit"], ", ".join(units_of("s")))
    return MappingFile(
        signals,
        log.get("time", "header"),
        _pair(path, log, "origin"),
        _pair(path, log, "antenna") or (0.0, 0.0),
        str(path),
        log.get("only", False),
        log.get("time_unit", ""),
    )


def _bad(path: Path, key: str, found: str, allowed: str) -> LogError:
    return LogError(f"{path}: {key}: found {found!r}, allowed: {allowed}", "log.bad_mapping")


def _pair(path: Path, log: dict[str, Any], key: str) -> tuple[float, float] | None:
    value = log.get(key)
    if value is None:
        return None
    if len(value) != 2 or not all(isinstance(v, int | float) and np.isfinite(v) for v in value):
        raise _bad(path, f"log.{key}", str(value), "two numbers")
    return float(value[0]), float(value[1])


def _table(path: Path, raw: Any, known: dict[str, type], prefix: str) -> dict[str, Any]:
    if not isinstance(raw, dict):
        raise _bad(path, prefix.rstrip("."), str(raw), "a table")
    out: dict[str, Any] = {}
    for key, value in raw.items():
        kind = known.get(key)
        if kind is None:
            hint = nearest(key, known)
            raise LogError(
                f"{path}: unknown key {prefix}{key}; allowed: {', '.join(known)}" + (f" ({hint})" if hint else ""),
                "log.bad_mapping",
            )
        if kind is list and prefix.startswith("signal"):
            value = tuple(value) if isinstance(value, list) and all(map(is_mode_value, value)) else None
            if not value:
                raise _bad(path, prefix + key, str(raw[key]), MODES)
            out[key] = value
            continue
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if not isinstance(value, kind) or (isinstance(value, float) and not np.isfinite(value)):
            raise _bad(path, prefix + key, str(value), f"a {'number' if kind is float else kind.__name__}")
        out[key] = value
    if prefix.startswith("signal") and "name" not in out:
        raise LogError(f"{path}: {prefix[:-1]} has no name", "log.bad_mapping")
    return out


def table_of(streams: Sequence[Stream], mapping: MappingFile, file: str, kind: str, findings: Findings) -> Table:
    """The mapped signals on the union of their stamps: NaN between the samples of a slower channel, a command holds.

    Raises LogError for a topic or field that is not there.
    """
    parts: list[tuple[SignalMap, FloatArray, FloatArray]] = []
    checked: set[tuple[str, str]] = set()
    told: set[str] = set()
    streams = _on_one_clock(streams, mapping, file, findings)
    for signal in mapping.signals:
        stream = stream_of(streams, signal, mapping, file)
        t = _stamps(stream, signal, mapping)
        values = _values(stream, signal, streams, mapping, file)
        check_modes(stream, signal.field, signal.when, file, findings)
        values = without_infinite(values, file, None, f"{signal.topic} {signal.field}".strip(), findings)
        if (stream.topic, signal.time) not in checked:
            checked.add((stream.topic, signal.time))
            # The recorder's clock too: what was set back between two messages may be seen in one of them only.
            check_stamps(t if np.any(np.diff(t) < 0) else stream.receive, stream, file, findings)
        if (timeless := int(np.count_nonzero(~np.isfinite(t)))) and stream.topic not in told:
            told.add(stream.topic)
            findings.add("log.time_missing", file, None, stream.topic, f"{timeless} rows have no time and are left out",
                         severity="warning")  # fmt: skip
        kept = _first_of_equal(t)
        parts.append((signal, t[kept], values[kept]))
    stamps = np.unique(np.concatenate([np.round(t / STAMP).astype(np.int64) for _, t, _ in parts]))
    base = stamps * STAMP
    columns = [RawColumn(Header("t", "t", "s"), base)]
    for signal, t, values in parts:
        column = np.full(len(base), np.nan)
        rows = np.searchsorted(stamps, np.round(t / STAMP).astype(np.int64))
        column[rows] = values
        if describe(signal.name).keeps_value:
            column = held(column)
        known = SIGNALS.get(signal.name)
        target = known.unit if known is not None else _si(way_of(signal.unit)[1])
        columns.append(RawColumn(Header(f"{signal.topic}:{signal.field}", signal.name, target), column))
    _move_antenna(columns, mapping.antenna)
    place = mapping.signals[0].topic if len({s.topic for s in mapping.signals}) == 1 else ""
    notes = {
        "mapping": [dataclasses.asdict(signal) for signal in mapping.signals],
        "unmapped": _left(streams, mapping, file),
    }
    return Table(file, kind, columns, place=place, findings=findings, notes=notes)


def _on_one_clock(streams: Sequence[Stream], mapping: MappingFile, file: str, findings: Findings) -> Sequence[Stream]:
    of_header = [s for s in mapping.signals if (s.time or mapping.time) == "header"]
    return on_one_clock(streams, [(stream_of(streams, s, mapping, file), s.delay) for s in of_header], file, findings)


def _left(streams: Sequence[Stream], mapping: MappingFile, file: str) -> list[str]:
    """Fields that no signal comes from; stamps are none."""
    taken = {(stream_of(streams, signal, mapping, file).topic, signal.field) for signal in mapping.signals}
    return [
        f"{stream.topic} {field}".strip()
        for stream in streams
        for field in (*stream.fields, *(f for f, texts in stream.texts.items() if len(texts.words) > 1))
        if not any((stream.topic, field[:end]) in taken for end in (len(field), field.rfind(".")))
        and canonical(field) != "t" and not is_stamp(field) and field != mapping.time
    ]  # fmt: skip


def fitting(mapping: MappingFile, streams: Sequence[Stream], file: str) -> MappingFile:
    """What of a mapping made for another file fits this one: the fields that it has, unless it states another unit.

    The rest is for recognition, so `only` no longer holds; an antenna is moved if x, y and yaw come from the mapping.
    """
    kept = []
    for signal in mapping.signals:
        try:
            stream = stream_of(streams, signal, mapping, file)
        except LogError:
            continue
        stated = stream.units.get(signal.field, "")
        names = signal.field.split(MARK) if way_of(signal.unit)[0] else [signal.field]
        there = (
            all(name in stream.fields for name in names)
            or (signal.when and has_modes(stream, signal.field))
            or bool(quaternion_parts(signal.field, stream))
        )
        if there and (not stated or not signal.unit or find_unit(stated) == find_unit(signal.unit)):
            kept.append(signal)
    moved = {"x", "y", "yaw"} <= {signal.name for signal in kept}
    antenna = mapping.antenna if moved else (0.0, 0.0)
    return dataclasses.replace(mapping, signals=tuple(kept), antenna=antenna, only=False)


def quaternion_parts(field: str, stream: Stream) -> list[str]:
    """Fields x, y, z, w of the quaternion that a mapping calls `field`: `q.x`, `q_x` or `qx`; [] if there are none."""
    for mark in (".", "_", ""):
        parts = [f"{field}{mark}{axis}" for axis in "xyzw"]
        if all(part in stream.fields for part in parts):
            return parts
    return []


def _si(unit: str) -> str:
    known = find_unit(unit) if unit else None
    return known.si if known is not None else "-"


def stream_of(streams: Sequence[Stream], signal: SignalMap, mapping: MappingFile, file: str) -> Stream:
    """The stream that a signal comes from: its topic; without a topic the only stream, or the only one that has its
    field.

    Raises LogError (`log.no_field`) if there is none, with the topics that the file has and the nearest one.
    """
    for stream in streams:
        if stream.topic == signal.topic or (not signal.topic and len(streams) == 1):
            return stream
    prefix = signal.field + "."  # of a quaternion
    names = signal.field.split(MARK) if way_of(signal.unit)[0] or signal.when else [signal.field]
    holders = [s for s in streams if any(f in names or f.startswith(prefix) for f in (*s.fields, *s.texts))]
    if not signal.topic and len(holders) == 1:
        return holders[0]
    topics = [stream.topic for stream in streams]
    where = mapping.file or file
    raise LogError(
        f"{where}: {signal.name}: no topic {signal.topic!r} in {file}; it has {', '.join(topics[:8])} "
        + nearest(signal.topic, topics), "log.no_field",
    )  # fmt: skip


def _stamps(stream: Stream, signal: SignalMap, mapping: MappingFile) -> FloatArray:
    choice = signal.time or mapping.time
    header = stream.header
    if choice in stream.fields:
        unit = find_unit(stream.units.get(choice) or mapping.time_unit or "s")
        t = stream.fields[choice] * (unit.scale if unit is not None and unit.si == "s" else 1.0)
    elif choice == "header" and header is not None:
        t = header
    elif choice == "header" and stream.si and "t" in stream.fields:
        t = stream.fields["t"]
    else:
        t = stream.receive
    if len(t) and not np.isfinite(t).any():
        _, guess, why = clock_of([stream])
        which = f'"{guess}"? ({why})' if guess in stream.fields else f"one of {listed(list(stream.fields), 8)}"
        text = f"{mapping.file or stream.topic}: no field holds the time; say which: [log] time = {which}"
        raise LogError(text, "log.time_missing")
    return t - signal.delay


def _field(stream: Stream, name: str, signal: SignalMap, mapping: MappingFile, file: str) -> FloatArray:
    values = stream.fields.get(name)
    if values is None:
        place = f"{stream.topic} of {file}" if stream.topic else file
        text = f"{mapping.file or file}: {signal.name}: no field {name!r} in {place}"
        if not name:
            text = f"{mapping.file or file}: {signal.name}: the entry has no field"
        if name in stream.texts:
            raise LogError(
                f"{text}; it holds words, which only `when` takes: {listed(stream.texts[name].words, 6)}",
                "log.no_field",
            )
        names = [*stream.fields, *stream.texts]
        few = difflib.get_close_matches(name, names, n=3, cutoff=0.0)
        near = nearest(name, names) or f"nearest of its {len(names)}: {', '.join(few)}"
        raise LogError(f"{text}; {near}", "log.no_field")
    return values


def _values(
    stream: Stream, signal: SignalMap, streams: Sequence[Stream], mapping: MappingFile, file: str
) -> FloatArray:
    if signal.when and has_modes(stream, signal.field):
        return obeyed_in(stream, signal.field, signal.when, f"{mapping.file or file}: {signal.name}")
    if signal.unit == QUATERNION:
        parts = quaternion_parts(signal.field, stream) or [f"{signal.field}.{axis}" for axis in "xyzw"]
        x, y, z, w = (_field(stream, part, signal, mapping, file) for part in parts)
        raw = _unwrapped(yaw_of_quaternion(x, y, z, w))
    elif (way := way_of(signal.unit))[0]:
        fields = [_field(stream, name, signal, mapping, file) for name in signal.field.split(MARK)]
        per = {"m": "m/s", "rad": "rad/s"} if way[0] == "rate of" else {}
        unit = find_unit(way[1])
        known = SIGNALS.get(signal.name)
        if unit is None or (known is not None and per.get(unit.si, unit.si) != known.unit):
            text = f"{mapping.file or file}: {signal.name}: unit {signal.unit!r}, allowed: a unit of {signal.name}"
            raise LogError(f"{text} behind `{way[0]}`", "log.unit_mismatch")
        fields = [unit.scale * values for values in fields]
        if unit.si == "rad" and way[0] == "rate of":
            fields = [_unwrapped(values) for values in fields]
        raw = combined(way[0], _stamps(stream, signal, mapping), fields)
    else:
        raw = _field(stream, signal.field, signal, mapping, file)
        if signal.unit in _FIXES:
            return _metres(_degrees(stream, signal, mapping), stream, signal, mapping) / signal.ratio + signal.offset
        raw = _converted(raw, stream, signal, mapping)
    values = signal.sign * signal.scale * raw / signal.ratio + signal.offset
    if signal.frame == "ned" and signal.name == "yaw":
        values = np.pi / 2.0 - values
    if signal.name in _FLIPPED[signal.frame]:
        values = -values
    return _unwrapped(values) if signal.name == "yaw" else values


def _unwrapped(angle: FloatArray) -> FloatArray:
    """The angle (n,) [rad] without turns of 2 pi; rows that were not measured stay NaN and stop nothing."""
    known = np.isfinite(angle)
    found = angle.copy()
    found[known] = np.unwrap(angle[known])
    return found


def _converted(raw: FloatArray, stream: Stream, signal: SignalMap, mapping: MappingFile) -> FloatArray:
    text = signal.unit or stream.units.get(signal.field, "") or (describe(signal.name).unit if stream.si else "")
    known = SIGNALS.get(signal.name)
    where = mapping.file or stream.topic or signal.field
    if not text or text == "?":
        allowed = ", ".join(units_of(known.unit)) if known is not None else "a unit"
        raise LogError(
            f"{where}: {signal.name} = {signal.field}: no unit; add unit = one of {allowed}", "log.unit_missing"
        )
    unit = find_unit(text)
    if unit is None or (known is not None and unit.si != known.unit):
        allowed = ", ".join(units_of(known.unit)) if known is not None else "a known unit"
        raise LogError(f"{where}: {signal.name}: unit {text!r}, allowed: {allowed}", "log.unit_mismatch")
    return raw * unit.scale + unit.offset


def _metres(raw: FloatArray, stream: Stream, signal: SignalMap, mapping: MappingFile) -> FloatArray:
    """East or north of the origin [m]: radii of curvature of the WGS 84 ellipsoid there; good to 1 cm within 2 km."""
    fixes = raw[np.isfinite(raw)]
    if not len(fixes):
        text = f"{mapping.file or stream.topic}: {signal.name}: field {signal.field!r} holds no value"
        raise LogError(text, "log.empty_column")
    e2 = FLATTENING * (2.0 - FLATTENING)
    if _FIXES[signal.unit] == LATITUDE:
        origin = mapping.origin[0] if mapping.origin else float(fixes[0])
        w = 1.0 - e2 * np.sin(np.radians(origin)) ** 2
        return np.asarray(np.radians(raw - origin) * (EARTH * (1.0 - e2) / w**1.5))
    latitude = mapping.origin[0] if mapping.origin else _first_latitude(stream, mapping)
    origin = mapping.origin[1] if mapping.origin else float(fixes[0])
    w = 1.0 - e2 * np.sin(np.radians(latitude)) ** 2
    east = (raw - origin + 180.0) % 360.0 - 180.0  # the short way, also across the meridian of 180 degrees
    return np.asarray(np.radians(east) * (EARTH / np.sqrt(w) * np.cos(np.radians(latitude))))


def _degrees(stream: Stream, signal: SignalMap, mapping: MappingFile) -> FloatArray:
    """Degrees (n,), positive to the north and east, of a latitude's or longitude's field, whose are sign and scale. NaN
    where both are 0: no car is there, receivers write it while they have no fix."""
    degrees = signal.sign * in_degrees(signal.scale * stream.fields[signal.field], signal.unit)
    other = next(
        (one for one in mapping.signals
         if _FIXES.get(one.unit, "") not in ("", _FIXES[signal.unit]) and one.field in stream.fields), None
    )  # fmt: skip
    return (
        degrees if other is None else np.where((degrees == 0.0) & (stream.fields[other.field] == 0.0), np.nan, degrees)
    )


def in_degrees(values: FloatArray, unit: str) -> FloatArray:
    """Degrees (n,) of latitudes or longitudes (n,) in a unit of a mapping: degrees, or degrees and minutes of NMEA."""
    if unit not in (LATITUDE_DDMM, LONGITUDE_DDMM):
        return values
    whole = np.trunc(values / 100.0)
    return np.asarray(whole + (values - 100.0 * whole) / 60.0)


def _first_latitude(stream: Stream, mapping: MappingFile) -> float:
    for signal in mapping.signals:
        if _FIXES.get(signal.unit) == LATITUDE and signal.field in stream.fields:
            values = _degrees(stream, signal, mapping)
            if np.isfinite(values).any():
                return float(values[np.isfinite(values)][0])
    raise LogError(
        f"{mapping.file}: a longitude needs a latitude of the same topic, or origin = [lat, lon]", "log.bad_mapping"
    )


def _first_of_equal(t: FloatArray) -> Any:
    known = np.flatnonzero(np.isfinite(t))
    _, first = np.unique(np.round(t[known] / STAMP).astype(np.int64), return_index=True)
    return known[first]


def _move_antenna(columns: list[RawColumn], antenna: tuple[float, float]) -> None:
    """Position of the reference point from that of the antenna; between its samples the yaw is interpolated."""
    if antenna == (0.0, 0.0):
        return
    by_name = {column.header.name: column.values for column in columns}
    if not {"x", "y", "yaw"} <= by_name.keys():
        raise LogError("mapping: an antenna position needs x, y and yaw", "log.bad_mapping")
    if not (known := np.isfinite(by_name["yaw"])).any():
        raise LogError("mapping: an antenna position needs a yaw, and its field holds no value", "log.empty_column")
    yaw = np.interp(by_name["t"], by_name["t"][known], by_name["yaw"][known])
    ahead, left = antenna
    by_name["x"] -= ahead * np.cos(yaw) - left * np.sin(yaw)
    by_name["y"] -= ahead * np.sin(yaw) + left * np.cos(yaw)


def mapping_rows(mapping: MappingFile) -> list[dict[str, str]]:
    """What a mapping says of each signal, for a table: name, field, unit in the file, and what changes its values."""
    rows = []
    for one in mapping.signals:
        changes = [
            *([f"1 where it is {' or '.join(f'{mode:g}' for mode in one.when)}, else 0"] if one.when else []),
            *([f"times {one.scale:g}"] if one.scale != 1.0 else []),
            *(["turned round"] if one.sign == -1.0 else []),
            *([f"divided by {one.ratio:g}"] if one.ratio != 1.0 else []),
            *([f"plus {one.offset:g}"] if one.offset else []),
            *([f"frame {one.frame}"] if one.frame != "flu" else []),
            *([f"stamps {one.delay:g} s earlier"] if one.delay else []),
        ]
        unit = one.unit or "as the file states"
        field = f"{one.topic} {one.field}".strip()
        rows.append({"name": one.name, "field": field, "unit": unit, "change": ", ".join(changes)})
    return rows
