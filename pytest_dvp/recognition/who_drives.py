"""Who drives, by the data: with which values of a mode the car follows the steering or acceleration asked for."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from openscenario.findings import listed
from pytest_dvp.logs.combined_fields import MARK
from pytest_dvp.logs.engagement import ENGAGED
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.mapping_proposal import is_mode
from pytest_dvp.logs.stream import Stream
from pytest_dvp.recognition.columns import Column
from pytest_dvp.recognition.commands import FOLLOWS, Motion, moving_speed
from pytest_dvp.recognition.recognised import Recognised
from pytest_dvp.recognition.words import families

_Asked: TypeAlias = list[tuple[Column, FloatArray, FloatArray]]

OBEYS = 0.8  # correlation from which the car follows a command; below FOLLOWS it does not, between it is open; chosen
SHORTEST = 5.0  # s of driving in a mode that can tell, chosen: a bend takes as long
LIVELY = 0.3  # of the motion while the car obeys: in a mode with less a command cannot be told from noise; chosen


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Mode:
    """A field with a few values. column: times (n,) [s] and the place of each value in `values`, a message each."""

    column: Column
    values: tuple[float | str, ...]


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Driver:
    """The mode that tells who drives, as a signal, and on the grid (n,) where the car obeys its commands."""

    signal: Recognised
    obeyed: NDArray[np.bool_]


def modes_of(streams: Sequence[Stream], clock: str) -> list[Mode]:
    """Fields of numbers or words that may say who drives, by their names; `clock` is that of the mapping."""
    found = []
    for stream in streams:
        header = stream.header if clock == "header" else None
        t = stream.receive if header is None else header
        for field in (*stream.fields, *stream.texts):
            if is_mode(stream, field):
                codes, values = _coded(stream, field)
                seen = np.isfinite(codes) & np.isfinite(t)
                order = np.argsort(t[seen], kind="stable")
                column = Column(stream.topic, field, "", t[seen][order], codes[seen][order])
                found.append(Mode(column, values))
    return found


def _coded(stream: Stream, field: str) -> tuple[FloatArray, tuple[float | str, ...]]:
    if (texts := stream.texts.get(field)) is not None:
        return texts.codes, texts.words
    numbers = stream.fields[field]
    kinds = np.unique(numbers[np.isfinite(numbers)])
    codes = np.where(np.isfinite(numbers), np.searchsorted(kinds, numbers), np.nan)
    return codes, tuple(kinds.tolist())


def driver_of(columns: Sequence[Column], modes: Sequence[Mode], motion: Motion) -> Driver | None:
    """The mode whose values part the drive best into one where a command is followed and one where it is not; None
    where none does: the car obeyed all the time, or the log does not tell.

    The steering tells more than the pedals, as a driver's foot may go with the plan. If it has a mode of its own beside
    that of the pedals (openpilot's latActive and longActive), the car obeys where both say so.
    """
    steers, pulls = _commands(columns, motion)
    aside, along = _best(steers, modes, motion), _best(pulls, modes, motion)
    if aside is None or along is None:
        return aside or along
    one, other = aside.signal, along.signal
    if one.column.key == other.column.key or one.column.topic != other.column.topic or one.when != other.when:
        return aside
    column = dataclasses.replace(one.column, field=MARK.join((one.column.field, other.column.field)))
    signal = dataclasses.replace(one, column=column, evidence=(*one.evidence, *other.evidence))
    return Driver(signal, aside.obeyed & along.obeyed)


def _best(commands: _Asked, modes: Sequence[Mode], motion: Motion) -> Driver | None:
    """The mode that parts best by the first command that any of them parts."""
    for command, asked, answer in commands:
        found = [one for mode in modes if (one := _parted(mode, command, asked, answer, motion)) is not None]
        if found:
            return max(found, key=lambda one: one[0])[1]
    return None


def _commands(columns: Sequence[Column], motion: Motion) -> tuple[_Asked, _Asked]:
    """Commands with what they ask for and what the car did, (n,) each on the grid: of the steering, and of the
    acceleration."""
    steers, pulls = [], []
    speed, along = moving_speed(motion), motion.along
    for column in columns:
        said = families(column.name, column.unit)
        if not column.is_command or motion.v is None:
            continue
        if "steer" in said and speed is not None and motion.turn is not None:
            steers.append((column, motion.grid.mean(column) * speed, motion.turn))
        elif "accel" in said and along is not None:
            pulls.append((column, motion.grid.mean(column), along))
    return steers, pulls


def _parted(
    mode: Mode, command: Column, asked: FloatArray, answer: FloatArray, motion: Motion
) -> tuple[float, Driver] | None:
    t = mode.column.t
    at = np.searchsorted(t, motion.grid.t, side="right") - 1  # a state holds until the next one
    state = np.where(at >= 0, mode.column.values[np.maximum(at, 0)], np.nan)
    alike: dict[int, float] = {}
    lively: dict[int, float] = {}
    for kind in range(len(mode.values)):
        rows = (state == kind) & np.isfinite(asked) & np.isfinite(answer)
        if np.count_nonzero(rows) * motion.grid.step < SHORTEST:
            continue
        alike[kind] = abs(motion.grid.match(np.where(rows, asked, np.nan), answer).alike)
        lively[kind] = float(np.std(answer[rows]))
    obeyed = [kind for kind, like in alike.items() if like >= OBEYS]
    if not obeyed:
        return None
    least = LIVELY * min(lively[kind] for kind in obeyed)
    others = [kind for kind, like in alike.items() if like < FOLLOWS and lively[kind] >= least]
    if not others:
        return None
    low, high = max(alike[kind] for kind in others), min(alike[kind] for kind in obeyed)
    text = (
        f"with {_named(mode, obeyed)} the car follows {command.field} (correlation {high:.2f}), "
        f"with {_named(mode, others)} it does not ({low:.2f})"
    )
    rest = [kind for kind in range(len(mode.values)) if kind not in (*obeyed, *others)]
    told = (text, f"{_named(mode, rest)} cannot be told and counts as not obeyed") if rest else (text,)
    when = tuple(mode.values[kind] for kind in obeyed)
    signal = Recognised(ENGAGED, mode.column, "", evidence=told, when=when)
    own = 0.01 * (mode.column.topic == command.topic)  # of modes that change together, that of the command itself
    # Of two that part it about as well, that of more obeyed driving: a mode of the pedals parts the steering by chance
    more = 0.1 * float(np.mean(np.isin(state, obeyed)))
    return high - low + own + more, Driver(signal, np.isin(state, obeyed))


def _named(mode: Mode, kinds: Sequence[int]) -> str:
    return listed([f"{v:g}" if isinstance(v, float) else v for v in (mode.values[kind] for kind in kinds)], 6)
