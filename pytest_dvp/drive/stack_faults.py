"""What can go wrong with a driving stack of somebody else, and how a run says it."""

from __future__ import annotations

import itertools
import traceback
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from pytest_dvp.rooms import side_by_side
from pytest_dvp.rooms.own_package_advice import import_advice
from pytest_dvp.text.errors import SettingError

_OURS = frozenset(
    str(Path(__file__).with_name(name))
    for name in ("stack_host.py", "checked_stack.py", "deadline.py", "stack_child.py")
)
"""Files whose frames stand above those of a stack."""


class AdsError(SettingError):
    """A driving stack that cannot be found, loaded or made; one line."""


class AdsFault(Exception):
    """A driving stack that broke its contract while it drove; one line."""


class StackRaised(Exception):
    """An exception that a stack raised while it drove.

    kind   name of its class
    said   first line of its text
    trace  its traceback, from the stack's own first frame on
    """

    def __init__(self, kind: str, said: str, trace: str) -> None:
        super().__init__(f"{kind}: {said}")
        self.kind, self.said, self.trace = kind, said, trace


class StackHung(AdsFault):
    """A stack that did not return in time: one line, and the traceback of where it was.

    trace      traceback with that line at its end; the line alone where nothing is known of the place
    wall       True if the wall time of the whole run was over, and not that of one call
    """

    def __init__(self, line: str, trace: str, *, wall: bool = False) -> None:
        super().__init__(line)
        self.trace, self.wall = trace, wall


class StackDied(AdsFault):
    """A stack whose process ended while it drove: one line, and the traceback of the crash if there is one."""

    def __init__(self, line: str, trace: str) -> None:
        super().__init__(line)
        self.trace = trace


class Told(NamedTuple):
    """What a run says of a fault: kind and text of the event in its log, and its error, a traceback or one line."""

    kind: str
    said: str
    error: str


def told_of(error: Exception) -> Told:
    """What a run says of something that broke while it drove."""
    if isinstance(error, StackRaised):
        return Told(error.kind, error.said, error.trace)
    said = str(error).split("\n")[0]
    if isinstance(error, StackHung | StackDied):
        return Told("AdsFault", said, error.trace)
    plain = isinstance(error, AdsFault) or type(error).__name__ == "VehicleLost"
    return Told(type(error).__name__, said, str(error) if plain else "".join(traceback.format_exception(error)))


def raised(error: BaseException) -> StackRaised:
    """An exception of a stack, with its traceback but without the frames of the harness above it."""
    try:
        said = str(error).split("\n")[0]
    except Exception:  # an exception of somebody else may fail even in this
        said = ""
    frames = own_frames(error.__traceback__)
    lines = traceback.format_exception(type(error), error, frames)
    return StackRaised(type(error).__name__, said, "".join(lines))


def own_frames(frames: TracebackType | None) -> TracebackType | None:
    """The traceback from the stack's first frame on."""
    while frames is not None and frames.tb_frame.f_code.co_filename in _OURS:
        frames = frames.tb_next
    return frames


def hung(line: str, frames: Iterable[traceback.FrameSummary], *, wall: bool = False) -> StackHung:
    """`frames` from the outermost to where it was; those of the harness, which come first, are left out."""
    listed = list(frames)
    last = max((i for i, frame in enumerate(listed) if frame.filename in _OURS), default=-1)
    own = list(itertools.dropwhile(lambda frame: frame.filename.startswith("<frozen "), listed[last + 1 :]))
    return StackHung(line, with_frames(own, line), wall=wall)


def with_frames(frames: list[traceback.FrameSummary], line: str) -> str:
    """A traceback that ends with `line`; `line` alone without frames."""
    if not frames:
        return line
    return "".join(["Traceback (most recent call last):\n", *traceback.format_list(frames), line])


def place_of(trace: str) -> str:
    """` (my_stack.py:7)`: the innermost place that a traceback shows; "" if it shows none."""
    places = [line.split('"') for line in trace.splitlines() if line.startswith('  File "')]
    if not places:
        return ""
    file, rest = places[-1][1], places[-1][2]
    number = rest.removeprefix(", line ").split(",")[0]
    return f" ({Path(file).name}:{number})"


def one_line(error: BaseException) -> str:
    """Kind, text and innermost place of an error of somebody else's code, and the cure where it is known."""
    frames = [
        frame for frame in traceback.extract_tb(error.__traceback__)
        if not frame.filename.startswith("<") and frame.filename != side_by_side.__file__  # it passes imports on
    ]  # fmt: skip
    frames = frames if frames and frames[-1].filename not in _OURS else []
    place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    text = " ".join(str(error).split())
    told = f"{type(error).__name__}: {text}{place}" if text else f"{type(error).__name__}{place}"
    return told + import_advice(error)


def what(thing: object) -> str:
    """A value and its kind, short, for a message."""
    if thing is None:
        return "None"
    kind = type(thing)
    try:
        text = " ".join(repr(thing).split())
    except Exception:  # its own __repr__ may fail
        return f"a {kind.__name__}"
    said = text if len(text) <= 60 else text[:57] + "..."
    return f"{said} ({kind.__name__})"
