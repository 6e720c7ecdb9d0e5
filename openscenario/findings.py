"""What is wrong with a user's file, and where: one `Finding` a defect, `ScenarioError` carries all of them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypedDict, Unpack

Severity = Literal["error", "warning"]

_SHOWN = 80  # characters of a user's value that a message repeats; the rest is noise, or an attack on the terminal


@dataclass(frozen=True, slots=True)
class Finding:
    """One defect of one file.

    `line` is 1-based, of the start tag or the row (None: the file as a whole); `element` is the path of the element,
    with `@attribute` where one is meant; `found`, `allowed` and `hint` (nearest valid name, advice) may be empty.
    `repair`: what the reader assumes in the place of what is wrong; empty where nothing can be assumed.
    """

    code: str
    severity: Severity
    file: str
    line: int | None
    element: str
    found: str = ""
    allowed: str = ""
    hint: str = ""
    text: str = ""
    repair: str = ""

    @property
    def message(self) -> str:
        """One sentence: what is wrong, what was found, what is allowed, what to try."""
        parts = [self.text or self.code]
        if self.found:
            parts.append(f"found {shown(self.found)}")
        if self.allowed:
            parts.append(f"allowed: {self.allowed}")
        sentence = "; ".join(parts)
        return f"{sentence} ({self.hint})" if self.hint else sentence

    def as_dict(self) -> dict[str, str | int | None]:
        """The finding as `dvp check --json` prints it."""
        return {
            "code": self.code,
            "severity": self.severity,
            "file": self.file,
            "line": self.line,
            "element": self.element,
            "message": self.message,
        }

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        return f"{place}: {' '.join(filter(None, (self.severity, self.code, self.element)))}: {self.message}"


class ScenarioError(Exception):
    """A user's file cannot be used; `findings` say why, each with its place."""

    def __init__(self, findings: Iterable[Finding]) -> None:
        self.findings: tuple[Finding, ...] = tuple(findings)
        super().__init__("\n".join(str(finding) for finding in self.findings) or "the file cannot be used")

    def __reduce__(self) -> tuple[type[ScenarioError], tuple[tuple[Finding, ...]]]:
        return (ScenarioError, (self.findings,))


def shown(value: str) -> str:
    """A user's value as a message may repeat it: quoted, without control characters, cut to a readable length."""
    cut = value if len(value) <= _SHOWN else value[:_SHOWN] + "..."
    return "'" + "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in cut) + "'"


def nearest(name: str, names: Iterable[str]) -> str:
    """The hint "did you mean 'X'?", or an empty string if no known name is near `name`."""
    known = sorted(set(names))
    by_lower = {candidate.lower(): candidate for candidate in known}
    close = difflib.get_close_matches(name[:_SHOWN].lower(), list(by_lower)[:2000], n=1, cutoff=0.6)
    return f"did you mean '{by_lower[close[0]]}'?" if close else ""


def listed(names: Sequence[str], most: int = 12) -> str:
    """Names for the `allowed` part of a message, cut after `most`."""
    head = ", ".join(names[:most])
    return f"{head}, ... ({len(names)} in all)" if len(names) > most else head


def natural(name: str) -> tuple[tuple[int, int, str], ...]:
    """Sort key that counts: 1, 2, 11, and not 1, 11, 2."""
    return tuple((0, int(part), "") if part.isdecimal() else (1, 0, part) for part in re.split(r"(\d+)", name[:_SHOWN]))


class Details(TypedDict, total=False):
    """What a finding may say besides its place and its sentence."""

    found: str
    allowed: str
    hint: str
    severity: Severity


class Findings:
    """Collects findings while a file is read, so that one pass reports them all."""

    __slots__ = ("found",)

    MOST = 1_000  # a file with more defects than this has one: it is not what it claims to be

    def __init__(self) -> None:
        self.found: list[Finding] = []

    def add(
        self,
        code: str,
        file: str,
        line: int | None,
        element: str,
        text: str,
        **details: Unpack[Details],
    ) -> None:
        """Notes one finding; without a severity it is an error."""
        if len(self.found) < self.MOST:
            given: Details = {"severity": "error", **details}
            self.found.append(Finding(code=code, file=file, line=line, element=element, text=text, **given))

    @property
    def errors(self) -> tuple[Finding, ...]:
        """Those that forbid using the file."""
        return tuple(finding for finding in self.found if finding.severity == "error")

    def in_order(self) -> tuple[Finding, ...]:
        """All, without repetition, ordered by file (as first met) and line."""
        files = {finding.file: number for number, finding in reversed(list(enumerate(self.found)))}
        unique = dict.fromkeys(self.found)
        return tuple(sorted(unique, key=lambda finding: (files[finding.file], finding.line or 0)))
