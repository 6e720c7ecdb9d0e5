"""What a fault of a road file means for those who drive on it: whether it forbids that, or what is assumed instead.

Two things make an error a warning. A rule that is younger than the file does not judge it: its authors could not keep
it. And a fault that leaves a geometry and a route is repaired, unless the reader is asked to be strict: the place that
finds a fault states what the reader assumes there (`Finding.repair`).
"""

from __future__ import annotations

import dataclasses
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any, Final, Literal, TypeAlias

from openscenario.findings import Finding

Roads: TypeAlias = Literal["strict", "lenient"]
LENIENT: Final[Roads] = "lenient"
CODE: Final = "road.repaired"

# An ASAM rule's UID names the version that it came with, as in asam.net:xodr:1.7.0:road.geometry.contact_point
_SINCE: Final = re.compile(r"asam\.net:xodr:(\d+)\.(\d+)\.\d+:")


def too_young(finding: Finding, version: tuple[int, int]) -> str:
    """The version of the standard that a finding's rule came with, if the file's version is older; else ""."""
    since = _SINCE.match(finding.code)
    if since is None or (int(since[1]), int(since[2])) <= version:
        return ""
    return f"{since[1]}.{since[2]}"


def forbids(finding: Finding, version: tuple[int, int], roads: Roads) -> bool:
    """Whether nobody may drive on a road with this fault."""
    if finding.severity != "error" or too_young(finding, version):
        return False
    return roads == "strict" or not finding.repair


def judged(findings: Iterable[Finding], version: tuple[int, int], roads: Roads) -> tuple[Finding, ...]:
    """The findings with the severity that they have for a file of this version, and what is assumed as their hint."""
    return tuple(_judged(finding, version, roads) for finding in findings)


def _judged(finding: Finding, version: tuple[int, int], roads: Roads) -> Finding:
    if finding.severity != "error" or forbids(finding, version, roads):
        return finding
    since = too_young(finding, version)
    why = f"a rule of OpenDRIVE {since}, the file is of {version[0]}.{version[1]}" if since else ""
    assumed = f"repaired: {finding.repair}" if finding.repair else "kept as it is written"
    return dataclasses.replace(finding, severity="warning", hint="; ".join(filter(None, (finding.hint, why, assumed))))


def repaired(findings: Iterable[Finding], version: tuple[int, int]) -> tuple[Finding, ...]:
    """Of a reader's findings, those in whose place it assumed something: what a verdict on this road stands on."""
    return tuple(
        each for each in findings if each.severity == "error" and each.repair and not forbids(each, version, LENIENT)
    )


def as_results(repairs: Iterable[Finding]) -> tuple[dict[str, Any], ...]:
    """Rows for result.json: each rule and what was assumed once, with the first place and the number of places.

    Keys: code, field (path of the element), t [s] (0: before the drive), found, allowed, count; also rule, file, line,
    text, assumed.
    """
    rows = list(repairs)
    counts = Counter((each.code, each.text, each.repair) for each in rows)
    first: dict[tuple[str, str, str], Finding] = {}
    for each in rows:
        first.setdefault((each.code, each.text, each.repair), each)
    return tuple(
        {
            "code": CODE,
            "field": each.element,
            "t": 0.0,
            "found": each.found,
            "allowed": each.allowed,
            "count": counts[key],
            "rule": each.code,
            "file": each.file,
            "line": each.line,
            "text": each.text,
            "assumed": each.repair,
        }
        for key, each in first.items()
    )


def note(row: Mapping[str, Any]) -> str:
    """One line about a row of `as_results`, for people: place, fault, what was assumed, how often."""
    more = f" ({row['count']} places, the first one here)" if row["count"] > 1 else ""
    return f"{row['file']}:{row['line']}: road repaired: {row['text']}; assumed: {row['assumed']}{more}"
