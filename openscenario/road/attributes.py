"""Attributes: typed values of located XML elements, with a finding for each that is missing or wrong."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Unpack

from openscenario.findings import Details, Finding, Findings, listed, nearest
from openscenario.xml import Node

_MOST_ADVISED = 100  # unknown names of one file


class Told(Details, total=False):
    """What a finding at an element may say: `attribute` that is meant; `repair`: what is assumed in its place."""

    attribute: str
    repair: str


class Attributes:
    """Reads attributes of one file's elements and collects findings; a wrong value is replaced by a harmless one."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.findings: list[Finding] = []
        self._noted = {"error": 0, "warning": 0}
        self._advised = 0
        self._numbers: dict[int, dict[int, str]] = {}
        self._repair = ""

    def report(
        self,
        code: str,
        node: Node,
        text: str,
        **details: Unpack[Told],
    ) -> None:
        """Add a finding at an element, or at one of its attributes; without a severity it is an error."""
        attribute, severity = details.get("attribute", ""), details.get("severity", "error")
        found, allowed, hint = details.get("found", ""), details.get("allowed", ""), details.get("hint", "")
        self._noted[severity] += 1
        if self._noted[severity] > Findings.MOST:
            return  # a file with more defects than this has one: it is not what it claims to be
        element = self._path(node) + (f"@{attribute}" if attribute else "")
        assumed = details.get("repair", "") or self._repair
        self.findings.append(
            Finding(code, severity, self.file, node.line, element, found, allowed, hint, text, assumed)
        )

    @contextmanager
    def repairing(self, assumed: str) -> Iterator[None]:
        """Whatever is reported within is repaired in this way, if the one who reports it states no other."""
        before, self._repair = self._repair, assumed
        try:
            yield
        finally:
            self._repair = before

    def advice(self, found: str, known: Collection[str]) -> tuple[str, str]:
        """What is allowed in place of an unknown name, and the nearest; not for the hundredth: comparing takes time."""
        self._advised += 1
        if self._advised > _MOST_ADVISED:
            return "", ""
        return listed(sorted(known)) or "none is there", nearest(found, known)

    def _path(self, node: Node) -> str:
        """The node's path, as `Node.path` has it; the numbers of siblings are counted once."""
        if node.parent is None:
            return node.tag
        steps = self._numbers.get(id(node.parent))
        if steps is None:
            children = node.parent.children
            total, seen = Counter(child.tag for child in children), Counter[str]()
            steps = self._numbers[id(node.parent)] = {}
            for child in children:
                seen[child.tag] += 1
                steps[id(child)] = child.tag if total[child.tag] == 1 else f"{child.tag}[{seen[child.tag]}]"
        return f"{self._path(node.parent)}/{steps[id(node)]}"

    def number(self, node: Node, name: str, default: float | None = None) -> float:
        """A finite number; without a default the attribute must be there."""
        text = node.attributes.get(name)
        if text is None:
            if default is None:
                self.report("xml.valid_schema", node, f"attribute {name} is missing", attribute=name, allowed=name)
                return 0.0
            return default
        try:
            value = float(text)
            if value - value == 0.0 and "_" not in text and text.isascii():  # neither infinite nor NaN
                return value
        except ValueError:
            value = math.nan
        if (value != value and text.strip().lower() != "nan") or "_" in text or not text.isascii():
            self.report(
                "value.not_a_number",
                node,
                f"{name} is no number",
                attribute=name,
                found=text or "nothing",
                allowed="a number",
            )
            return 0.0
        if not math.isfinite(value):
            self.report(
                "value.not_finite", node, f"{name} is not finite", attribute=name, found=text, allowed="a finite number"
            )
            return 0.0
        return value

    def integer(self, node: Node, name: str, default: int | None = None) -> int:
        """A whole number; without a default the attribute must be there."""
        text = node.attributes.get(name)
        if text is None:
            if default is None:
                self.report("xml.valid_schema", node, f"attribute {name} is missing", attribute=name, allowed=name)
            return default or 0
        if not re.fullmatch(r"\s*[-+]?[0-9]{1,9}\s*", text):
            self.report(
                "value.not_a_number",
                node,
                f"{name} is no whole number",
                attribute=name,
                found=text or "nothing",
                allowed="a whole number",
            )
            return 0
        return int(text)

    def text(self, node: Node, name: str, default: str | None = None) -> str:
        """A string; without a default the attribute must be there."""
        value = node.attributes.get(name)
        if value is not None:
            return value
        if default is None:
            self.report("xml.valid_schema", node, f"attribute {name} is missing", attribute=name, allowed=name)
        return default or ""

    def choice(self, node: Node, name: str, allowed: tuple[str, ...], default: str | None = None) -> str:
        """One of the allowed strings."""
        value = self.text(node, name, default)
        if value not in allowed and name in node.attributes:
            self.report(
                "xml.valid_schema",
                node,
                f"{name} has an unknown value",
                attribute=name,
                found=value,
                allowed=", ".join(allowed),
                hint=nearest(value, allowed),
            )
            return default if default is not None else allowed[0]
        return value


def by_tag(node: Node | None) -> dict[str, list[Node]]:
    """Children of a node by tag."""
    found: dict[str, list[Node]] = {}
    if node is not None:
        for child in node.children:
            found.setdefault(child.tag, []).append(child)
    return found
