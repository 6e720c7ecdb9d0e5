"""The proposal of `dvp map` as a TOML file: what is certain, what the data say, and what is left to the user."""

from __future__ import annotations

import dataclasses
import textwrap
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from openscenario.findings import listed
from pytest_dvp.logs.column_names import canonical
from pytest_dvp.logs.engagement import ENGAGED
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.mapped_modes import held_in, shown_mode
from pytest_dvp.logs.mapping import SignalMap
from pytest_dvp.logs.mapping_proposal import (
    HAND_WHEEL,
    fix_of,
    guessed,
    is_mode,
    named_by_unit,
    propose,
    quaternions_of,
)
from pytest_dvp.logs.signals import describe
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.time_column import clock_of, time_unit
from pytest_dvp.logs.units import units_of

_SHOWN = 60  # fields that are listed
_WIDTH = 110  # characters of a comment
_NEEDED = {"x", "y", "yaw", "v", "yaw_rate"}  # without their unit nothing can be compared: one line to edit each
_PLAIN = {"scale": 1.0, "sign": 1.0, "offset": 0.0, "ratio": 1.0}  # of a signal that needs none of these


@dataclasses.dataclass(frozen=True, slots=True)
class Told:
    """What the data say of one signal. evidence: why it is that; doubt: what would do as well, "" if nothing does: a
    doubtful one is written behind a #, for the user to decide."""

    signal: SignalMap
    evidence: str
    doubt: str = ""


class _ByName(NamedTuple):
    """Signals that names and units in the file tell beside what the data say. certain: with a unit; the others stand
    behind a # in the file: unsure without a unit, fix of a satellite receiver, guesses with what else they may be."""

    certain: tuple[SignalMap, ...]
    unsure: tuple[SignalMap, ...]
    fix: Sequence[SignalMap]
    guesses: Sequence[tuple[SignalMap, Sequence[str]]]

    @property
    def open(self) -> tuple[SignalMap, ...]:
        """What is left to the user."""
        return (*self.unsure, *self.fix, *(signal for signal, _ in self.guesses))


def _by_name(streams: Sequence[Stream], told: Sequence[Told]) -> _ByName:
    named = {one.signal.name for one in told if not one.doubt}
    mapping, found = propose(_without(streams, {(one.signal.topic, one.signal.field) for one in told}))
    certain = tuple(signal for signal in mapping.signals if signal.name not in named)
    unsure = tuple(signal for signal in found if signal.name not in named)
    taken = [*(one.signal for one in told), *certain, *unsure]
    fix = fix_of([(s, f) for s in streams for f in s.fields], {signal.name for signal in taken})
    return _ByName(certain, unsure, fix, guessed(streams, (*taken, *fix)))


def open_signals(streams: Sequence[Stream], told: Sequence[Told]) -> tuple[SignalMap, ...]:
    """Signals behind a # in the file, for names alone tell them: they are not read until the user decides."""
    return _by_name(clock_of(streams)[0], told).open


def open_modes(streams: Sequence[Stream], told: Sequence[Told]) -> tuple[SignalMap, ...]:
    """Fields that may say who drives, each as `engaged`; none where the data or the file's names tell it."""
    by_name = _by_name(streams, told)
    taken = [*(one.signal for one in told), *by_name.certain, *by_name.open]
    if any(signal.name == ENGAGED for signal in taken):
        return ()
    used = {(signal.topic, signal.field) for signal in taken}
    return tuple(
        SignalMap(ENGAGED, stream.topic, field)
        for stream in streams for field in (*stream.fields, *stream.texts)
        if (stream.topic, field) not in used and is_mode(stream, field)
    )  # fmt: skip


def mapping_text(streams: Sequence[Stream], told: Sequence[Told] = (), remarks: Sequence[str] = ()) -> str:
    """The proposal as a TOML file. told: what the data say of signals; it goes before what names say. remarks: further
    sentences on what was seen.

    What is certain comes first; what is likely is commented out until the user decides it.
    """
    streams, clock, why = clock_of(streams)
    by_name = _by_name(streams, told)
    unsure, fix, guesses = by_name.unsure, by_name.fix, by_name.guesses
    certain = [*(one.signal for one in told), *by_name.certain, *unsure]
    modes = open_modes(streams, told)
    fields = [(s, f) for s in streams for f in s.fields]
    lines = [
        *_head(told, by_name.certain, (*by_name.open, *modes[:1]), remarks),
        "[log]",
        f'time = "{_quoted(clock)}"             # {why}',
        *time_unit(streams, clock),
        "# origin = [52.0, 4.3]        # latitude, longitude [deg] of x = y = 0; default: the first fix",
        "# antenna = [1.2, 0.0]        # of what measures x, y: [m] ahead and left of the rear axle's middle",
        "# only = true                # leave out what is not named here; default: recognised fields are taken as well",
        "# a signal also takes: scale, sign = -1, offset, ratio (hand wheel to road wheel), time,",
        "# delay [s] by which its stamps are too late,",
        '# frame = "frd" (y to the right) or "ned" (the same, and yaw is a compass heading)',
    ]
    for one in told:
        if one.doubt and one.signal.name in _NEEDED:
            asked = dataclasses.replace(one.signal, unit="?")
            lines += [
                "",
                *_comment(f"left to you ({one.signal.unit} or {one.doubt}): put the unit in. {one.evidence}"),
                *_entry(asked, streams, measured=True),
            ]
        elif one.doubt:
            lines += [
                "",
                *_comment(f"not decided ({one.doubt}): take the # away if this is so, or change it"),
                *_comment(one.evidence),
                *(f"# {line}" for line in _entry(one.signal, streams, measured=True)),
            ]
        else:
            lines += ["", *_comment(f"by the data: {one.evidence}"), *_entry(one.signal, streams, measured=True)]
    for signal in by_name.certain:
        lines += ["", *_entry(signal, streams)]
    for signal in unsure:
        lines += [
            "",
            "# the file does not say the unit: fill it in",
            *(f"# {line}" for line in _entry(signal, streams)),
        ]
    for signal in fix:
        lines += ["", "# a guess by its name: take the # away if it is so"]
        lines += [f"# {line}" for line in _entry(signal, streams)]
    for signal, others in guesses:
        also = f" (or {listed(others, 4)})" if others else ""
        said = f"a guess by unit and range{also}: take the # away if it is so"
        if signal.unit == "?":
            said = "a guess by its name: fill in the unit, and take the # away if it is so"
        lines += [
            "",
            f"# {said}",
            *(f"# {line}" for line in _entry(signal, streams)),
        ]
    used = {(s.topic, s.field) for s in (*certain, *fix, *(signal for signal, _ in guesses))}
    for stream in streams:
        used |= {
            (stream.topic, f) for name, four in quaternions_of(stream) if (stream.topic, name) in used for f in four
        }
    rest = [(s, f) for s, f in fields if (s.topic, f) not in used and f != clock and (s.topic or canonical(f) != "t")]
    for stream, field, names in named_by_unit(rest, (*certain, *fix)):
        lines += [
            "",
            f"# by its unit this may be {' or '.join(names)}: put the name in and take the # away",
            *(f"# {line}" for line in _entry(SignalMap("?", stream.topic, field, stream.units[field]), streams)),
            *(["# ratio = 16.0  # hand wheel to road wheel, if it is that"] if "steer_cmd" in names else []),
        ]
        rest.remove((stream, field))
    for signal in modes:
        stream = next(s for s in streams if s.topic == signal.topic)
        lines += ["", *_mode(stream, signal.field)]
    shown = {(signal.topic, signal.field) for signal in modes}
    rest = [(s, f) for s, f in rest if (s.topic, f) not in shown]
    if rest:
        lines += ["", *_not_mapped(rest)]
    return "\n".join(lines) + "\n"


def _head(
    told: Sequence[Told], certain: Sequence[SignalMap], unsure: Sequence[SignalMap], remarks: Sequence[str]
) -> list[str]:
    """unsure: without a unit, or guessed; all of them stand behind a # in the file."""
    if not told:
        words = "names and units are taken from the file, and were not checked against the motion."
        return [f"# Proposed by `dvp map`. Look at every line: {words}"]
    sure = [one.signal.name for one in told if not one.doubt]
    left = [one.signal.name for one in told if one.doubt] + [signal.name for signal in unsure]
    lines = [
        "# Proposed by `dvp map`. What is `by the data` follows from what the columns tell of one motion: confirm it."
    ]
    if sure:
        lines += _comment(f"decided by the data: {', '.join(sure)}")
    if certain:
        lines += _comment(
            f"by the names and units in the file, not checked against the motion: {', '.join(s.name for s in certain)}"
        )
    lines += _comment(f"left to you below: {', '.join(left)}" if left else "left to you: nothing")
    for remark in remarks:
        lines += _comment(remark)
    return lines


def _without(streams: Sequence[Stream], taken: set[tuple[str, str]]) -> list[Stream]:
    """The streams without fields that are signals already; of a quaternion without its parts."""
    found = []
    for stream in streams:
        parts = {part for name, four in quaternions_of(stream) if (stream.topic, name) in taken for part in four}
        fields = {f: v for f, v in stream.fields.items() if (stream.topic, f) not in taken and f not in parts}
        found.append(dataclasses.replace(stream, fields=fields))
    return found


def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(text, _WIDTH)]


def _not_mapped(fields: Sequence[tuple[Stream, str]]) -> list[str]:
    """Fields by name; those of a file without topics with their range, and how an entry for one of them looks."""
    lines = []
    for stream, field in fields[:_SHOWN]:
        known = stream.fields[field][np.isfinite(stream.fields[field])]
        span = f": {known.min():.4g} to {known.max():.4g}" if len(known) and not stream.topic else ""
        lines.append(f"#   {stream.topic} {field}{span}".replace("  ", " "))
    lines += [f"#   ... and {len(fields) - _SHOWN} more"] if len(fields) > _SHOWN else []
    if fields[0][0].topic:
        return ["# not mapped:", *lines]
    example = '[[signal]] name = "v" field = "COLUMN" unit = "km/h", each in a line of its own'
    return [f"# not mapped; an entry for one of them is: {example}", *lines]


def _rate(stream: Stream, values: FloatArray) -> float:
    """Values a second [Hz] of a field, which in a joined file has fewer of them than the file has rows."""
    known = np.flatnonzero(np.isfinite(values))
    span = float(stream.receive[known[-1]] - stream.receive[known[0]]) if len(known) > 1 else 0.0
    return (len(known) - 1) / span if span > 0.0 else stream.rate


def _entry(signal: SignalMap, streams: Sequence[Stream], *, measured: bool = False) -> list[str]:
    """The lines of a signal; measured: its values are those of the data, so that no ratio is put in for the user."""
    stream = next(s for s in streams if s.topic == signal.topic)
    values = stream.fields.get(signal.field)
    seen = ""
    if values is not None and np.isfinite(values).any():
        seen = f"  # {np.nanmin(values):.6g} to {np.nanmax(values):.6g}, {_rate(stream, values):.4g} Hz"
    topic = [f'topic = "{_quoted(signal.topic)}"'] if signal.topic else []
    allowed = f"  # one of {', '.join(units_of(describe(signal.name).unit))}" if signal.unit == "?" else ""
    more = [
        f"{key} = {value!r}"
        for key in ("scale", "sign", "offset", "ratio")
        if (value := getattr(signal, key)) != _PLAIN[key]
    ]
    more += [f'frame = "{signal.frame}"'] if signal.frame != "flu" else []
    if HAND_WHEEL.search(signal.field) and not measured:
        more.append("ratio = 16.0  # hand wheel to road wheel: put in that of the car")
    if signal.when:
        return [
            "[[signal]]",
            f'name = "{signal.name}"',
            *topic,
            f'field = "{_quoted(signal.field)}"',
            _when(signal.when),
        ]
    return [
        "[[signal]]", f'name = "{signal.name}"', *topic, f'field = "{_quoted(signal.field)}"{seen}',
        f'unit = "{_quoted(signal.unit)}"{allowed}', *more,
    ]  # fmt: skip


def _mode(stream: Stream, field: str) -> list[str]:
    """The lines of a mode that may say whether the car obeys its commands."""
    first = stream.texts[field].words[0] if field in stream.texts else 1.0
    topic = [f'topic = "{_quoted(stream.topic)}"'] if stream.topic else []
    entry = ["[[signal]]", f'name = "{ENGAGED}"', *topic, f'field = "{_quoted(field)}"', _when((first,))]
    return [
        *_comment(
            f"perhaps who drives: it holds {held_in(stream, field)}; write those into `when` with which the car "
            "obeys its commands"
        ),
        *(f"# {line}" for line in entry),
    ]


def _when(modes: Sequence[float | str]) -> str:
    return f"when = [{', '.join(shown_mode(mode) for mode in modes)}]"


def _quoted(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"')
