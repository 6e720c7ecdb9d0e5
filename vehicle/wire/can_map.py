"""The signal map of a drive-by-wire: which signal of a DBC is what. `drive_by_wire.toml` beside this file shows all.

Raises CanMapError throughout: one line with file, key, what was found and the nearest name that exists.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vehicle.toml_file import TomlError, read_toml
from vehicle.wire.checksum import CHECKSUMS

OURS = Path(__file__).with_name("drive_by_wire.dbc")

COMMANDS = {"steer": "rad", "throttle": "-", "brake": "-", "accel": "m/s^2", "mode": "", "heartbeat": ""}
REPORTS = {"steer": "rad", "speed": "m/s", "mode": "", "override": "", "emergency_stop": "", "refused": ""}
MODES = ("manual", "automatic", "fault")
UNITS: Mapping[str, tuple[str, float]] = {
    "rad": ("rad", 1.0), "deg": ("rad", math.pi / 180.0), "°": ("rad", math.pi / 180.0),
    "degree": ("rad", math.pi / 180.0), "degrees": ("rad", math.pi / 180.0),
    "m/s": ("m/s", 1.0), "km/h": ("m/s", 1.0 / 3.6), "kph": ("m/s", 1.0 / 3.6), "mph": ("m/s", 0.44704),
    "m/s^2": ("m/s^2", 1.0), "m/s2": ("m/s^2", 1.0), "m/s²": ("m/s^2", 1.0), "g": ("m/s^2", 9.80665),
    "-": ("-", 1.0), "": ("-", 1.0), "1": ("-", 1.0), "%": ("-", 0.01), "percent": ("-", 0.01),
}  # fmt: skip
"""Unit of a signal -> the SI unit and how much of it one is."""


class CanMapError(ValueError):
    """What is wrong with a DBC or its signal map; one line."""


@dataclass(frozen=True)
class Place:
    """One signal: value in SI = `factor` times what the signal says."""

    message: str
    signal: str
    factor: float = 1.0


@dataclass(frozen=True)
class SignalMap:
    """What a drive-by-wire's messages mean.

    file, dbc         where it was read from
    command, report   name (COMMANDS, REPORTS) -> signal
    always            signals outside of those, with the value they have in each frame
    automatic         likewise, in automatic mode only; else 0
    mode              "manual", "automatic", "fault" -> value of the mode signals
    counter, checksum names of the protecting signals, "" without; `kind` of CHECKSUMS
    """

    file: Path
    dbc: Path
    database: Any
    command: Mapping[str, Place]
    report: Mapping[str, Place]
    always: Mapping[Place, float]
    automatic: Mapping[Place, float]
    mode: Mapping[str, int]
    counter: str
    checksum: str
    kind: str

    @property
    def pedals(self) -> bool:
        """Whether it takes throttle and brake; else an acceleration."""
        return "throttle" in self.command


def find_map(path: Path | None = None) -> SignalMap:
    """The map for `--dvp-dbc path`: a DBC with its map beside it, or a map that names its DBC; None: our own.

    Raises CanMapError if the map cannot be read, or if its `dbc` is not a name.
    """
    path = OURS if path is None else path
    file = path if path.suffix == ".toml" else path.with_suffix(".toml")
    try:
        text, _ = read_toml(file)
    except TomlError as error:
        raise CanMapError(f"{error.at(file)}: no signal map for {path.name}: {error}") from None
    named = text.pop("dbc", None)
    if named is not None and not isinstance(named, str):
        raise CanMapError(f"{file}: dbc: found {named!r}, allowed: the name of a .dbc file")
    dbc = path.with_suffix(".dbc") if named is None else file.parent / named
    return read_map(dbc if path.suffix == ".toml" or named else path, file, text)


def read_map(dbc: Path, file: Path, text: Mapping[str, Any]) -> SignalMap:
    """The map that `text`, the content of `file`, makes of a DBC.

    Raises CanMapError if a key is unknown, a needed one is missing, or keys do not go together.
    """
    database = _database(dbc)
    _known(file, "", text, ("command", "report", "always", "automatic", "mode", "protection", "unit", "ratio"))
    for part in ("unit", "ratio"):  # of the quantities that are mapped
        _known(file, part, _table(file, text, part), {**_table(file, text, "command"), **_table(file, text, "report")})
    command = _places(file, database, text, "command", COMMANDS)
    report = _places(file, database, text, "report", REPORTS)
    for table, needed in ((command, ("steer",)), (report, ("steer", "speed"))):
        for name in needed:
            if name not in table:
                raise CanMapError(f"{file}: [{'command' if table is command else 'report'}] {name} is missing")
    if ("accel" in command) == ("throttle" in command) or ("throttle" in command) != ("brake" in command):
        raise CanMapError(f"{file}: [command] needs throttle and brake, or accel alone; found {', '.join(command)}")
    if ("mode" in command) != ("mode" in report):
        raise CanMapError(f"{file}: [command] mode and [report] mode come together: who asks must hear the answer")
    modes = _table(file, text, "mode")
    _known(file, "mode", modes, MODES)
    for name in MODES[:2]:
        if "mode" in command and type(modes.get(name)) is not int:
            raise CanMapError(f"{file}: [mode] {name}: found {modes.get(name)!r}, allowed: an integer")
    counter, checksum, kind = _protection(file, database, text)
    constants = [
        {_place(file, database, f"[{part}]", name): _constant(file, database, part, name, value)
         for name, value in given.items()}
        for part in ("always", "automatic")
        for given in [_table(file, text, part)]
    ]  # fmt: skip
    places = (*command.values(), *report.values(), *constants[0], *constants[1])
    _check_signals(file, database, {place.message for place in places}, counter)
    return SignalMap(
        file, dbc, database, command, report, constants[0], constants[1], dict(modes), counter, checksum, kind
    )  # fmt: skip


def _database(dbc: Path) -> Any:
    try:
        import cantools
    except ImportError:
        raise CanMapError("CAN needs python-can and cantools: pip install -e '.[can]' from the checkout") from None
    try:
        return cantools.database.load_file(dbc, database_format="dbc", strict=True)
    except OSError as error:
        raise CanMapError(f"{dbc}: cannot be read: {error.strerror}") from None
    except (cantools.database.Error, UnicodeDecodeError, ValueError, KeyError) as error:
        raise CanMapError(f"{dbc}: no DBC: {' '.join(str(error).split())[:200]}") from None


def _places(
    file: Path, database: Any, text: Mapping[str, Any], part: str, allowed: Mapping[str, str]
) -> dict[str, Place]:
    given, units, ratios = _table(file, text, part), _table(file, text, "unit"), _table(file, text, "ratio")
    _known(file, part, given, allowed)
    places = {}
    for name, where in given.items():
        place = _place(file, database, f"[{part}] {name}", where)
        factor = 1.0
        if allowed[name]:
            stated = database.get_message_by_name(place.message).get_signal_by_name(place.signal).unit or ""
            factor = _factor(file, f"[{part}] {name}", str(units.get(name, stated)), allowed[name])
        ratio = _number(file, "ratio", name, ratios.get(name, 1.0))
        if ratio == 0.0:
            raise CanMapError(f"{file}: [ratio] {name} is 0")
        places[name] = Place(place.message, place.signal, factor / ratio)
    return places


def _place(file: Path, database: Any, key: str, where: Any) -> Place:
    message, dot, signal = where.partition(".") if isinstance(where, str) else ("", "", "")
    if not dot:
        raise CanMapError(f'{file}: {key}: found {where!r}, allowed: "MESSAGE.SIGNAL"')
    messages = {m.name: m for m in database.messages}
    if message not in messages:
        raise CanMapError(f"{file}: {key}: no message {message} in the DBC{near(message, messages)}")
    signals = [s.name for s in messages[message].signals]
    if signal not in signals:
        raise CanMapError(f"{file}: {key}: no signal {signal} in {message}{near(signal, signals)}")
    if messages[message].is_multiplexed():
        raise CanMapError(f"{file}: {key}: {message} is multiplexed, which is not supported")
    return Place(message, signal)


def _factor(file: Path, key: str, unit: str, wanted: str) -> float:
    found = UNITS.get(unit.strip())
    if found is None or found[0] != wanted:
        allowed = ", ".join(name for name, (si, _) in UNITS.items() if si == wanted and name)
        raise CanMapError(f"{file}: {key}: unit {unit!r}, allowed: {allowed}; [unit] in the map overrules the DBC")
    return found[1]


def _protection(file: Path, database: Any, text: Mapping[str, Any]) -> tuple[str, str, str]:
    given = _table(file, text, "protection")
    _known(file, "protection", given, ("counter", "checksum", "kind"))
    names = {signal.name for message in database.messages for signal in message.signals}
    for key, value in given.items():
        if not isinstance(value, str):
            raise CanMapError(f"{file}: [protection] {key}: found {value!r}, allowed: a name in quotes")
    for key in ("counter", "checksum"):
        if key in given and given[key] not in names:
            raise CanMapError(f"{file}: [protection] {key}: no signal {given[key]!r}{near(str(given[key]), names)}")
    kind = given.get("kind", "crc8_j1850")
    if kind not in CHECKSUMS:
        raise CanMapError(f"{file}: [protection] kind: found {kind!r}, allowed: {', '.join(CHECKSUMS)}")
    checksum = given.get("checksum", "")
    for message in database.messages:
        for signal in message.signals:
            if signal.name == checksum and (signal.length != 8 or _first_bit(signal) % 8):
                raise CanMapError(f"{file}: [protection] checksum: {message.name}.{checksum} is no whole byte")
    return given.get("counter", ""), checksum, kind


def _check_signals(file: Path, database: Any, messages: set[str], counter: str) -> None:
    """Raises CanMapError if a signal can carry no value, or a counter is not one from 0 to what its bits hold.

    All signals of the `messages` count: who sends a frame fills each of them.
    """
    for name in sorted(messages):
        for signal in database.get_message_by_name(name).signals:
            if signal.scale == 0:
                raise CanMapError(f"{file}: {name}.{signal.name} has scale 0 in the DBC, allowed: any other number")
            plain = (signal.is_signed, signal.is_float, signal.scale, signal.offset) == (False, False, 1, 0)
            if signal.name == counter and not plain:
                kind = "a float" if signal.is_float else "signed" if signal.is_signed else "scaled"
                allowed = "unsigned, with scale 1 and offset 0"
                raise CanMapError(f"{file}: [protection] counter: {name}.{counter} is {kind}, allowed: {allowed}")


def _first_bit(signal: Any) -> int:
    """Number of its lowest bit, counted through the bytes."""
    return int(signal.start) - 7 if signal.byte_order == "big_endian" else int(signal.start)


def _table(file: Path, text: Mapping[str, Any], part: str) -> Mapping[str, Any]:
    given = text.get(part, {})
    if not isinstance(given, Mapping):
        raise CanMapError(f"{file}: {part}: found {given!r}, allowed: a table [{part}]")
    return given


def _number(file: Path, part: str, name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise CanMapError(f"{file}: [{part}] {name}: found {value!r}, allowed: a number")
    return float(value)


def _constant(file: Path, database: Any, part: str, name: str, value: Any) -> float:
    """A value that the bits of its signal can hold."""
    number = _number(file, part, name, value)
    message, _, signal = name.partition(".")
    bits = database.get_message_by_name(message).get_signal_by_name(signal)
    low, high = held_range(bits)
    if not low <= number <= high:
        raise CanMapError(f"{file}: [{part}] {name}: found {value!r}, allowed: {low:g} to {high:g}, as its bits hold")
    return number


def held_range(signal: Any) -> tuple[float, float]:
    """Least and greatest value of a DBC's signal, in its unit, that its bits can hold."""
    if signal.is_float:
        most = float(np.finfo(f"f{signal.length // 8}").max)
        least = -most
    else:
        least = -(1 << signal.length - 1) if signal.is_signed else 0
        most = least + (1 << signal.length) - 1
    low, high = sorted((least * signal.scale + signal.offset, most * signal.scale + signal.offset))
    return low, high


def _known(file: Path, part: str, given: Iterable[str], allowed: Iterable[str]) -> None:
    for name in given:
        if name not in tuple(allowed):
            where = f"[{part}] " if part else ""
            raise CanMapError(f"{file}: {where}{name} is unknown{near(name, allowed)}")


def near(name: str, known: Iterable[str]) -> str:
    """The end of a line about a name that is not known: the nearest that is, or all."""
    known = sorted(known)
    close = difflib.get_close_matches(name, known, 1, 0.5)
    return f"; did you mean {close[0]}?" if close else f"; there is {', '.join(known[:12])}"
