"""Line numbers of a gate file, which tomllib does not tell."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator

_HEADER = re.compile(r"\[\[?\s*([^\]\s]+)\s*\]")
_STRINGS = ('"""', "'''", '"', "'")


@dataclasses.dataclass(slots=True)
class Lines:
    """1-based lines: of top-level tables and keys, of the keys of [task], and of each [[gate]] with its keys."""

    top: dict[str, int] = dataclasses.field(default_factory=dict)
    task: dict[str, int] = dataclasses.field(default_factory=dict)
    gates: list[tuple[int, dict[str, int]]] = dataclasses.field(default_factory=list)


def locate_lines(text: str) -> Lines:
    """Lines of a text that tomllib accepted. A gate inside an inline array has the line of the array."""
    lines = Lines()
    keys = lines.top
    for line, statement in _statements(text):
        if statement.startswith("["):
            match = _HEADER.match(statement)
            name = match[1].strip("\"'") if match else ""
            lines.top.setdefault(name.split(".")[0], line)
            keys = {}
            if name == "gate":
                lines.gates.append((line, keys))
            elif name == "task":
                keys = lines.task
            elif name.startswith("task."):
                lines.task.setdefault(name.split(".")[1], line)
            elif name.startswith("gate.") and lines.gates:
                lines.gates[-1][1].setdefault(name.split(".")[1], line)
        else:
            name = statement.split("=", 1)[0].strip().split(".")[0].strip(" \"'")
            keys.setdefault(name, line)
    return lines


def _statements(text: str) -> Iterator[tuple[int, str]]:
    """(line, text) of each line that begins a statement: not inside a string, an array or an inline table."""
    depth = 0
    quote = ""
    for number, line in enumerate(text.split("\n"), start=1):
        stripped = line.strip()
        if not quote and depth == 0 and stripped and not stripped.startswith("#"):
            yield number, stripped
        position = 0
        while position < len(line):
            if quote:
                if line[position] == "\\" and quote[0] == '"':
                    position += 2
                elif line.startswith(quote, position):
                    position += len(quote)
                    quote = ""
                else:
                    position += 1
                continue
            if line[position] == "#":
                break
            quote = next((q for q in _STRINGS if line.startswith(q, position)), "")
            if not quote:
                depth += (line[position] in "[{") - (line[position] in "]}")
            position += len(quote) or 1
