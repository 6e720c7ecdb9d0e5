"""What `faulthandler` wrote of a process, as a traceback of the stack in it: outermost call first, with its source."""

from __future__ import annotations

import re
import traceback
from pathlib import Path

from pytest_dvp.drive.stack_faults import hung

_FRAME = re.compile(r'  File "(.*)", line (\d+) in (.*)$')
_ESCAPED = re.compile(r"\\(x[0-9a-f]{2}|u[0-9a-f]{4}|U[0-9a-f]{8})")
_CHILD = str(Path(__file__).with_name("stack_child.py"))


def hanging(text: str, line: str) -> str:
    """The traceback of the thread that answers the harness, `line` at its end."""
    threads = [frames for _, frames in _threads(text)]
    mine = [frames for frames in threads if any(frame.filename == _CHILD for frame in frames)]
    chosen = mine[-1] if mine else threads[-1] if threads else []
    return hung(line, chosen).trace


def crashed(text: str, line: str) -> str:
    """The traceback of the thread in which the process crashed, `line` at its end; `line` alone if there is none."""
    fatal = text.rpartition("Fatal Python error")[2] if "Fatal Python error" in text else ""
    frames = next((frames for current, frames in _threads(fatal) if current), [])
    return hung(line, frames).trace


def _threads(text: str) -> list[tuple[bool, list[traceback.FrameSummary]]]:
    """For each thread that has frames, whether it is the one that ran, and they, the outermost first."""
    found: list[tuple[bool, list[traceback.FrameSummary]]] = []
    for line in text.splitlines():
        if line.startswith(("Thread ", "Current thread ")):
            found.append((line.startswith("Current"), []))
        elif found and (match := _FRAME.match(line)):
            file, number, name = match.groups()
            found[-1][1].insert(0, traceback.FrameSummary(_plain(file), int(number), _plain(name)))
    return [(current, frames) for current, frames in found if frames]


def _plain(text: str) -> str:
    """A name as it is: `faulthandler` writes signs beyond ASCII by their numbers."""
    return _ESCAPED.sub(lambda match: chr(int(match[1][1:], 16)), text)
