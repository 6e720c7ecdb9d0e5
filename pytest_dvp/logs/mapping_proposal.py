"""Proposes a mapping for a log that does not say which field is which signal."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Collection, Sequence

import numpy as np

from openscenario.findings import listed
from pytest_dvp.logs.column_names import ALIKE, canonical, likeness, parse_header
from pytest_dvp.logs.command_topics import carries_commands
from pytest_dvp.logs.engagement import asks
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mapping import (
    LATITUDE,
    LONGITUDE,
    QUATERNION,
    MappingFile,
    SignalMap,
    quaternion_parts,
    stream_of,
)
from pytest_dvp.logs.signals import SIGNALS
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.units import find_unit

# Message types whose definition states the unit (REP-103: SI, yaw counter-clockwise).
_ROS = {
    "nav_msgs/Odometry": {
        "x": ("pose.pose.position.x", "m"), "y": ("pose.pose.position.y", "m"),
        "yaw": ("pose.pose.orientation", QUATERNION), "v": ("twist.twist.linear.x", "m/s"),
        "vy": ("twist.twist.linear.y", "m/s"), "yaw_rate": ("twist.twist.angular.z", "rad/s"),
    },
    "sensor_msgs/Imu": {
        "yaw_rate": ("angular_velocity.z", "rad/s"), "ax": ("linear_acceleration.x", "m/s^2"),
        "ay": ("linear_acceleration.y", "m/s^2"),
    },
    "sensor_msgs/NavSatFix": {"x": ("longitude", LONGITUDE), "y": ("latitude", LATITUDE)},
    "geometry_msgs/PoseStamped": {
        "x": ("pose.position.x", "m"), "y": ("pose.position.y", "m"), "yaw": ("pose.orientation", QUATERNION),
    },
    "geometry_msgs/TwistStamped": {
        "v": ("twist.linear.x", "m/s"), "vy": ("twist.linear.y", "m/s"), "yaw_rate": ("twist.angular.z", "rad/s"),
    },
    "autoware_auto_vehicle_msgs/VelocityReport": {
        "v": ("longitudinal_velocity", "m/s"), "vy": ("lateral_velocity", "m/s"), "yaw_rate": ("heading_rate", "rad/s"),
    },
    "autoware_auto_vehicle_msgs/SteeringReport": {"steer": ("steering_tire_angle", "rad")},
    "autoware_auto_control_msgs/AckermannControlCommand": {
        "steer_cmd": ("lateral.steering_tire_angle", "rad"), "accel_cmd": ("longitudinal.acceleration", "m/s^2"),
        "speed_cmd": ("longitudinal.speed", "m/s"),
    },
    "autoware_auto_control_msgs/Control": {  # of autoware_control_msgs since 2024: longitudinal.velocity
        "steer_cmd": ("lateral.steering_tire_angle", "rad"), "accel_cmd": ("longitudinal.acceleration", "m/s^2"),
        "speed_cmd": ("longitudinal.velocity", "m/s"),
    },
    "ackermann_msgs/AckermannDriveStamped": {
        "steer_cmd": ("drive.steering_angle", "rad"), "speed_cmd": ("drive.speed", "m/s"),
        "accel_cmd": ("drive.acceleration", "m/s^2"),
    },
}  # fmt: skip
_PLACE = ("x", "y")
_FIX = {
    LATITUDE: re.compile(r"(gps|gnss|nav)?[ _]?lat(itude)?$", re.IGNORECASE),
    LONGITUDE: re.compile(r"(gps|gnss|nav)?[ _]?(lon|lng|long|longitude)$", re.IGNORECASE),
}
_MODE = re.compile(r"mode|engag|enabled|autonom|automat|autopilot|^(ad|lat|long)_?active", re.IGNORECASE)
_NAMELESS = frozenset(("data", "value", "state"))  # fields of messages whose topic says what they are
_MODES = 10  # of a car; chosen
HAND_WHEEL = re.compile(r"(hand|steering)_?wheel|\bswa\b|\bhwa\b", re.IGNORECASE)
_OTHER_MEANING = re.compile(
    r"(^|[\W_])(roll|pitch|phi_?[rp]|slip|sideslip|beta|temp(erature)?|press(ure)?|torque|current|voltage|fuel|gear|lap|curvature|"
    r"kappa|altitude|height|vz|wx|wy|az|std|sigma|cov\w*|error|err)(?=[\W_]|$)",
    re.IGNORECASE,
)
"""Words for what no signal of the table is, though its unit may be the same: roll is no steering angle."""
_NO_PLACE = re.compile(r"angular|linear|veloc|accel|twist|gyro|rate|magnet|orient|force|torque", re.IGNORECASE)
_RATE_OF_STEERING = re.compile(r"steer|delta|swa", re.IGNORECASE)
_SAME_AS = {
    "autoware_vehicle_msgs": "autoware_auto_vehicle_msgs",
    "autoware_control_msgs": "autoware_auto_control_msgs",
}


def certain(streams: Sequence[Stream], file: str) -> MappingFile:
    """The mapping of a file that states it: every unit given, by the schema or by the message definition.

    Raises LogError naming what the file has, if that is too little.
    """
    chosen, unsure = propose(streams)
    if not chosen.signals:
        named = [s.topic or listed(list(s.fields), 8) or "nothing but a time" for s in streams]
        topics = listed([f"{name} ({s.type or 'no type'})" for name, s in zip(named, streams, strict=True)], 6)
        names = sorted({signal.name for signal in unsure})
        raise LogError(
            f"{file}: a mapping is needed: no field states which signal it is and in which unit; it has {topics}"
            + (f"; perhaps {', '.join(names)}" if names else "")
            + f" (write one: `dvp map {file} > map.toml`, then --map map.toml)",
            "log.mapping_needed",
        )  # fmt: skip
    return chosen


def completed(mapping: MappingFile, streams: Sequence[Stream], file: str, kind: str) -> MappingFile:
    """The mapping and, unless it says `only`, all else that states its signal and its unit.

    Of a CSV file columns that are no signals are kept too, as without a mapping. What a mapping names comes before what
    is recognised; a field is taken once.
    """
    if mapping.only:
        return mapping
    named = {signal.name for signal in mapping.signals}
    used = {(stream_of(streams, signal, mapping, file).topic, signal.field) for signal in mapping.signals}
    fresh = [
        dataclasses.replace(s, fields={f: v for f, v in s.fields.items() if (s.topic, f) not in used}) for s in streams
    ]
    found = [signal for signal in propose(fresh)[0].signals if signal.name not in named]
    if kind == "csv":
        (stream,) = fresh
        found += [
            SignalMap(field, "", field, unit)
            for field, unit in stream.units.items()
            if field in stream.fields and canonical(field) not in SIGNALS and field not in named and find_unit(unit)
        ]
    return dataclasses.replace(mapping, signals=(*mapping.signals, *found))


def propose(streams: Sequence[Stream]) -> tuple[MappingFile, tuple[SignalMap, ...]]:
    """What is certain, and what is likely but lacks a unit (unit "?")."""
    best: dict[str, tuple[float, SignalMap]] = {}
    unsure: dict[str, tuple[float, SignalMap]] = {}
    for stream in streams:
        for signal in _candidates(stream):
            rank = _rank(stream, signal)
            book = unsure if signal.unit == "?" else best
            if signal.name not in book or rank > book[signal.name][0]:
                book[signal.name] = (rank, signal)
    if ("x" in best) != ("y" in best) or (
        "x" in best and best["x"][1].topic != best["y"][1].topic
    ):  # position is one thing: both from the better topic
        for name in ("x", "y"):
            best.pop(name, None)
    chosen = tuple(best[name][1] for name in SIGNALS if name in best)
    return MappingFile(chosen), tuple(unsure[name][1] for name in SIGNALS if name in unsure and name not in best)


# Largest magnitude of a road car's signal in SI; beyond it a column holds something else.
_LARGEST = {
    "v": 100.0, "yaw_rate": 3.0, "ax": 15.0, "ay": 15.0, "yaw": 1000.0, "steer": 1.0, "steer_cmd": 1.0,
    "accel_cmd": 15.0, "throttle_cmd": 1.0, "brake_cmd": 1.0, "speed_cmd": 100.0,
}  # fmt: skip


def guessed(streams: Sequence[Stream], taken: Sequence[SignalMap]) -> tuple[tuple[SignalMap, tuple[str, ...]], ...]:
    """What further fields may be, and which signals each might be as well: no name says it.

    First by name, unit and range, the name that is most like a signal's before all others; by the name alone (unit "?")
    where all its words are usual and no unit is stated; then what is the only field with the unit of a signal.
    """
    used = {(signal.topic, signal.field) for signal in taken}
    open_still = [name for name in SIGNALS if name in _LARGEST.keys() - {signal.name for signal in taken}]
    free = [
        (s, f) for s in streams for f in s.fields
        if (s.topic, f) not in used and not HAND_WHEEL.search(f) and not means_something_else(s, f)
    ]  # fmt: skip
    found: dict[str, tuple[SignalMap, tuple[str, ...]]] = {}

    def take(name: str, stream: Stream, field: str, unit: str) -> None:
        others = tuple(n for n in open_still if n != name and _unit_that_fits(stream, field, n))
        found[name] = SignalMap(name, stream.topic, field, unit), others
        used.add((stream.topic, field))

    named = sorted(
        ((alike, unit, name, s, f) for s, f in free for name in open_still
         if (alike := likeness(name, _last(s, f))) >= ALIKE
         and (unit := _unit_that_fits(s, f, name) or ("?" if alike == 1.0 and _bare(s, f) else ""))),
        key=lambda one: (-one[0], one[1] == "?", open_still.index(one[2])),
    )  # fmt: skip
    for _, unit, name, stream, field in named:
        if name not in found and (stream.topic, field) not in used:
            take(name, stream, field, unit)
    for name in open_still:
        fits = [(s, f, unit) for s, f in free if (s.topic, f) not in used and (unit := _unit_that_fits(s, f, name))]
        if len(fits) == 1 and name not in found and SIGNALS[name].unit != "-":  # without a unit it may be anything
            take(name, *fits[0])
    return tuple(found[name] for name in open_still if name in found)


def means_something_else(stream: Stream, field: str) -> bool:
    """True for a field that is no signal, whatever its unit: the roll of the body, a part of a quaternion."""
    return bool(_OTHER_MEANING.search(_last(stream, field))) or any(
        field in parts for _, parts in quaternions_of(stream)
    )


def quaternions_of(stream: Stream) -> list[tuple[str, list[str]]]:
    """Name and fields x, y, z, w of each quaternion: four fields whose squares sum to 1 in most rows."""
    found = []
    for field in stream.fields:
        if field[-1:] != "w":
            continue
        name = field[:-1].rstrip("._") if field[-2:-1] in "._" else field[:-1]
        parts = quaternion_parts(name, stream) if name else []
        if parts and parts[3] == field:
            norm = np.sqrt(sum(stream.fields[part] ** 2 for part in parts))
            if np.mean(np.abs(norm[np.isfinite(norm)] - 1.0) < 0.01) > 0.5:
                found.append((name, parts))
    return found


def _last(stream: Stream, field: str) -> str:
    """The name of a field in its message; a column of a CSV file is its own, with dots."""
    return parse_header(field.rpartition(".")[2]).name if stream.topic else field


def _bare(stream: Stream, field: str) -> bool:
    """Whether a column of a CSV file states no unit, and is more than a constant."""
    values = stream.fields[field][np.isfinite(stream.fields[field])]
    return not stream.topic and field not in stream.units and len(values) > 0 and float(np.ptp(values)) > 0.0


def _unit_that_fits(stream: Stream, field: str, name: str) -> str:
    """The unit that the file states for a field, if it and the range of values suit a signal; else ""."""
    stated = stream.units.get(field) or parse_header(field.rpartition(".")[2]).unit
    unit = find_unit(stated) if stated else None
    values = stream.fields[field]
    known = values[np.isfinite(values)]
    if unit is None or unit.si != SIGNALS[name].unit or not len(known):
        return ""
    if name == "yaw_rate" and _RATE_OF_STEERING.search(field):
        return ""
    inside = float(np.max(np.abs(known * unit.scale + unit.offset))) <= _LARGEST[name]
    return str(stated) if inside and float(np.ptp(known)) > 0.0 else ""


def _rank(stream: Stream, signal: SignalMap) -> float:
    metres = 0.0 if signal.unit in (LATITUDE, LONGITUDE) else 1e6  # a local position before a GNSS fix
    moving = (v for f, v in stream.fields.items() if f.startswith(signal.field) and np.isfinite(v).any())
    varies = 1e5 if any(np.nanmax(values) > np.nanmin(values) for values in moving) else 0.0
    exact = 1e4 if signal.field.rpartition(".")[2] == signal.name else 0.0
    return metres + varies + exact + min(stream.rate, 1e3)


def _candidates(stream: Stream) -> list[SignalMap]:
    package, _, kind = stream.type.replace("/msg/", "/").partition("/")
    asked = not stream.si and carries_commands(stream.topic, stream.type)
    table = _ROS.get(f"{_SAME_AS.get(package, package)}/{kind}")
    if table is not None:
        return [
            SignalMap(_asked_for(name) if asked else name, stream.topic, field, unit)
            for name, (field, unit) in table.items()
            if (not asked or _asked_for(name))
            and any(known == field or known.startswith(field + ".") for known in stream.fields)
        ]
    quaternions = quaternions_of(stream)
    parts = {part for _, four in quaternions for part in four}
    found = [SignalMap("yaw", stream.topic, name, QUATERNION) for name, _ in quaternions[:1] if not asked]
    for field in stream.fields:
        if field in parts:
            continue
        if HAND_WHEEL.search(field):  # never certain: the steering ratio is the car's
            found.append(SignalMap("steer_cmd" if asked else "steer", stream.topic, field, "?"))
            continue
        header = parse_header(field.rpartition(".")[2] if stream.topic else field)
        name = _asked_for(canonical(header.name)) if asked else canonical(header.name)
        if stream.topic and name in ("x", "y", "z") and _NO_PLACE.search(field.rpartition(".")[0]):
            continue  # a part of another vector
        if name not in SIGNALS or name == "t":
            continue
        stated = stream.units.get(field) or header.unit or (SIGNALS[name].unit if stream.si else None)
        unit = find_unit(stated) if stated else None
        fits = unit is not None and unit.si == SIGNALS[name].unit
        found.append(SignalMap(name, stream.topic, field, str(stated) if fits else "?"))
    return found


def _asked_for(name: str) -> str:
    """The command for a measured signal, `speed_cmd` for `v`; "" if there is none."""
    command = name if asks(name) else canonical(f"{name}_cmd")
    return command if command in SIGNALS else ""


def fix_of(fields: Sequence[tuple[Stream, str]], taken: Collection[str]) -> list[SignalMap]:
    """Latitude and longitude of a file without topics as y and x, if both are there and there is no other position."""
    found: dict[str, SignalMap] = {}
    for name, unit, most in (("x", LONGITUDE, 180.0), ("y", LATITUDE, 90.0)):
        for stream, field in fields:
            known = stream.fields[field][np.isfinite(stream.fields[field])]
            degrees = find_unit(stream.units.get(field, "deg")) == find_unit("deg")
            if not stream.topic and _FIX[unit].match(field) and degrees and len(known) and np.abs(known).max() <= most:
                found.setdefault(name, SignalMap(name, "", field, unit))
    return list(found.values()) if len(found) == 2 and not {"x", "y"} & set(taken) else []


def named_by_unit(
    fields: Sequence[tuple[Stream, str]], taken: Sequence[SignalMap]
) -> list[tuple[Stream, str, tuple[str, ...]]]:
    """Of fields in a file without topics, those whose unit some signals have that are still open, and which."""
    found = []
    still = [name for name in (*_PLACE, *_LARGEST) if name not in {signal.name for signal in taken}]
    for stream, field in fields:
        other = stream.topic or means_something_else(stream, field)
        unit = None if other else find_unit(stream.units.get(field, ""))
        rate = _RATE_OF_STEERING.search(field)
        names = tuple(
            name for name in still
            if unit is not None and SIGNALS[name].unit == unit.si != "-" and not (rate and name == "yaw_rate")
        )  # fmt: skip
        if names:
            found.append((stream, field, names))
    return found


def is_mode(stream: Stream, field: str) -> bool:
    """Whether a field may say who drives: its name says mode or automation, and it holds a few whole numbers or words.

    A field that is called `data` has the name of its topic."""
    if (texts := stream.texts.get(field)) is not None:
        few = 1 < len(texts.words) <= _MODES
    else:
        values = stream.fields[field]
        kinds = np.unique(values[np.isfinite(values)])
        few = 1 < len(kinds) <= _MODES and bool(np.all(kinds == np.round(kinds)))
    last = field.rpartition(".")[2]
    name = stream.topic.rpartition("/")[2] if last in _NAMELESS else last
    return few and bool(_MODE.search(name))
