"""Hardened, located XML reading: limits, DOCTYPE refused before parsing, no entity, no network, no include.

No other module touches lxml: a file comes out as a tree of plain `Node`s.
"""

from __future__ import annotations

import codecs
import hashlib
import os
import re
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from xml.parsers import expat

import msgspec
from lxml import etree

from openscenario.file_budget import most_bytes, most_elements
from openscenario.findings import Finding, ScenarioError

MAX_DEPTH: Final = 128  # OpenSCENARIO nests about 25 deep
MAX_ATTRIBUTE: Final = 65_536  # characters of one attribute value
MAX_ATTRIBUTES: Final = 256  # attributes of one element

_ENCODINGS: Final = re.compile(
    r"utf-?8|utf-?16(-?[lb]e)?|utf-?32(-?[lb]e)?|us-ascii|ascii|latin-?1|iso-?8859-?\d{1,2}|windows-?125\d|cp125\d"
    r"|gb2312|gbk|gb18030|big5|shift_jis|euc-jp|euc-kr|koi8-r",
    re.IGNORECASE,
)
_ESCAPES: Final = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
)
_BOMS: Final = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_DECLARATION: Final = re.compile(r"\s*<\?xml\s[^>]{0,400}?\?>")
_DECLARED: Final = re.compile(rb"""^\s*<\?xml\s[^>]{0,400}?encoding\s*=\s*["']([A-Za-z0-9_.\-]{1,40})["']""")
_DSL: Final = re.compile(r"\s*(?:#.*\s+)*(?:import\s+osc|scenario\s+\w|actor\s+\w|struct\s+\w|action\s+\w)")
_ASSIGNED: Final = re.compile(r"""[\w:.\-]\s*=\s*["']""")
_WIDE: Final = 4 * MAX_ATTRIBUTES  # characters of a tag, from which its attributes are counted
_BROKEN_TAG: Final = re.compile(r"<[^<>!?\n]*\n")  # a tag that goes on in the next line
_PROLOG: Final = re.compile(r"\s+|<!--.*?-->|<\?.*?\?>", re.DOTALL)
_TAG: Final = re.compile(r"<([A-Za-z_][\w.:\-]*)")
_ATTRIBUTE: Final = re.compile(r"""([A-Za-z_][\w.:\-]*)\s*=\s*(?:"[^"]*|'[^']*)$""")


class Node(msgspec.Struct, eq=False):
    """One element: tag (with its prefix, if it has one), 1-based line, attributes, text, parent, children."""

    tag: str
    line: int
    attributes: dict[str, str]
    text: str
    parent: Node | None
    children: list[Node] = []

    def get(self, name: str, default: str = "") -> str:
        """The value of an attribute, or the default."""
        return self.attributes.get(name, default)

    def find(self, tag: str) -> Node | None:
        """The first child with that tag, or None."""
        for child in self.children:
            if child.tag == tag:
                return child
        return None

    def findall(self, tag: str) -> list[Node]:
        """All children with that tag, in the file's order."""
        return [child for child in self.children if child.tag == tag]

    def walk(self) -> Iterator[Node]:
        """This node and all below it, in the file's order."""
        stack = [self]
        while stack:
            node = stack.pop()
            yield node
            stack.extend(reversed(node.children))

    def release(self) -> None:
        """Lets go of the parents below: a tree that is not needed any more then leaves memory without a collection."""
        for node in self.walk():
            node.parent = None

    @property
    def path(self) -> str:
        """Path of the element from the root; a repeated tag carries its 1-based number, `road/planView/geometry[2]`."""
        steps: list[str] = []
        node = self
        while node.parent is not None:
            same = node.parent.findall(node.tag)
            steps.append(node.tag if len(same) == 1 else f"{node.tag}[{1 + same.index(node)}]")
            node = node.parent
        steps.append(node.tag)
        return "/".join(reversed(steps))


@dataclass(frozen=True, slots=True)
class Document:
    """A file as read: its name as findings show it, the root element, and the hash of its bytes."""

    file: str
    root: Node
    sha256: str


def read_xml(
    path: str | os.PathLike[str], *, max_bytes: int | None = None, texts: frozenset[str] | None = None
) -> Document:
    """Reads an XML file into located nodes; `texts`: tags whose texts are wanted (None: of all elements); `max_bytes`:
    of the file (None: as `openscenario.file_budget` says).

    Raises:
        ScenarioError: no such file, too big, not well formed, wrong encoding, a DOCTYPE, too deep.
    """
    file = os.fspath(path)
    data = read_bytes(Path(file), file, max_bytes)
    return parse_xml(data, file, texts)


def parse_xml(data: bytes, file: str, texts: frozenset[str] | None = None) -> Document:
    """The same for bytes already read; `file` is the name that findings show."""
    if not data.strip():
        raise _error("xml.empty", file, 1, "", "the file is empty")
    text = _text(data, file)
    head = _DECLARATION.match(text)
    body = 0 if head is None else head.end()
    _refuse_doctype(text, body, file)
    # the declaration has done its work, and a wrong one must not confuse the parser; its line breaks stay for the count
    clean = "\n" * text.count("\n", 0, body) + text[body:]
    return Document(file, _parse(clean, file, texts), hashlib.sha256(data).hexdigest())


def write_xml(root: Node, path: Path) -> None:
    """Writes a tree of nodes as UTF-8, by rename: the file appears whole or not at all."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_text(render(root), encoding="utf-8", newline="\n")
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def render(root: Node) -> str:
    """A tree of nodes as the text of a file."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>']
    _render(root, 0, lines)
    return "\n".join(lines) + "\n"


def _render(node: Node, depth: int, lines: list[str]) -> None:
    indent = "  " * depth
    attributes = "".join(f' {name}="{_escaped(value)}"' for name, value in node.attributes.items())
    if node.children:
        lines.append(f"{indent}<{node.tag}{attributes}>")
        for child in node.children:
            _render(child, depth + 1, lines)
        lines.append(f"{indent}</{node.tag}>")
    elif node.text:
        lines.append(f"{indent}<{node.tag}{attributes}>{_escaped(node.text)}</{node.tag}>")
    else:
        lines.append(f"{indent}<{node.tag}{attributes}/>")


def _escaped(text: str) -> str:
    return text.translate(_ESCAPES)


def read_bytes(path: Path, file: str, max_bytes: int | None = None) -> bytes:
    """The bytes of a regular file of at most that size, None: as in `read_xml`; else ScenarioError."""
    if max_bytes is None:
        max_bytes = most_bytes()
    try:
        info = path.stat()
        if not stat.S_ISREG(info.st_mode):
            raise _error("path.not_a_file", file, None, "", "not a regular file")
        if info.st_size > max_bytes:
            raise _error(
                "xml.too_big",
                file,
                None,
                "",
                "the file is too big",
                f"{info.st_size} bytes",
                f"up to {max_bytes} bytes",
                "--max-file-bytes allows more",
            )
        with path.open("rb") as stream:
            return stream.read(max_bytes)
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or "not a file name"
        raise _error("path.not_found", file, None, "", f"cannot be read: {reason}") from None


def decoded(head: bytes) -> str:
    """The start of a file as text, for a look at what it is; what cannot be decoded there is replaced."""
    try:
        return head.decode(_encoding(head, ""), "replace")
    except (ScenarioError, LookupError):
        return head.decode("utf-8", "replace")


def _encoding(data: bytes, file: str) -> str:
    """The encoding that a byte order mark, the declaration or the first bytes tell."""
    encoding = next((name for bom, name in _BOMS if data.startswith(bom)), "")
    if not encoding:
        declared = _DECLARED.match(data[:512])
        encoding = "utf-8" if declared is None else declared.group(1).decode("ascii")
        if data[:4] in (b"<\0?\0", b"<\0!\0") or (data[:1] == b"<" and data[1:2] == b"\0"):
            encoding = "utf-16-le"
        elif data[:2] == b"\0<":
            encoding = "utf-16-be"
        elif data[:1] == b"<" and encoding.lower() in ("utf-16", "utf16"):
            encoding = (
                "utf-8"  # one byte a character: what .NET's StringWriter declares, whatever the file is written in
            )
        elif not _ENCODINGS.fullmatch(encoding) or encoding.lower().startswith(("utf-16", "utf16", "utf-32", "utf32")):
            raise _error(
                "xml.bad_encoding", file, 1, "", "unknown encoding", encoding, "UTF-8, UTF-16, ISO-8859-1, ..."
            )
    return encoding


def _text(data: bytes, file: str) -> str:
    encoding = _encoding(data, file)
    try:
        text = data.decode(encoding)
    except (UnicodeDecodeError, LookupError) as error:
        start = error.start if isinstance(error, UnicodeDecodeError) else 0
        line, element = _place(data[:start].decode(encoding, "replace"))
        shown = f"byte 0x{data[start]:02x}"
        raise _error("xml.bad_encoding", file, line, element, f"not valid {encoding}", shown) from None
    nul = text.find("\0")
    if nul >= 0:
        line, element = _place(text[:nul])
        raise _error("xml.not_well_formed", file, line, element, "the file holds a NUL character")
    return text


def _place(before: str) -> tuple[int, str]:
    """Line and element@attribute of the character that follows `before`."""
    line = before.count("\n") + 1
    tail = before[-(2 * MAX_ATTRIBUTE) :]
    opened = tail[tail.rfind("<") :] if "<" in tail else ""
    tag = _TAG.match(opened)
    if tag is None or ">" in opened:
        return line, ""
    attribute = _ATTRIBUTE.search(opened)
    return line, tag.group(1) + (f"@{attribute.group(1)}" if attribute else "")


def _refuse_doctype(text: str, start: int, file: str) -> None:
    while match := _PROLOG.match(text, start):
        start = match.end()
    if text[start : start + 9].upper() == "<!DOCTYPE":
        line = text.count("\n", 0, start) + 1
        raise _error(
            "xml.dtd_forbidden",
            file,
            line,
            "DOCTYPE",
            "a DOCTYPE is refused: it can expand or open files",
            hint="remove it",
        )


def _parse(text: str, file: str, texts: frozenset[str] | None) -> Node:
    odd = not _refuse_wide_tags(text, file) or ("xml" in text and ("xmlns" in text or "xml:" in text))
    if not odd and _BROKEN_TAG.search(text) is None:
        top = _parse_plain(text, texts)
        if top is not None:
            return top
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
        collect_ids=False,
    )
    try:
        root = etree.fromstring(text.encode("utf-8", "surrogatepass"), parser)
    except etree.XMLSyntaxError as error:
        line = max(1, int(error.lineno or 1))
        reason = (error.msg or "not well formed").split(", line ")[0]
        if "depth" in reason.lower():
            raise _too_deep(file, line) from None
        hint = "this looks like OpenSCENARIO DSL: export OpenSCENARIO XML" if _DSL.match(text) else ""
        element = _element_at(text, *error.position)
        reason = f"not well-formed XML: {reason[:200]}"
        raise _error("xml.not_well_formed", file, line, element, reason, hint=hint) from None
    except ValueError as error:
        raise _error("xml.not_well_formed", file, 1, "", f"not well-formed XML: {str(error)[:200]}") from None
    return _nodes(root, file, odd)


def _parse_plain(text: str, texts: frozenset[str] | None) -> Node | None:
    """The tree of a file without namespaces, wide tags and tags over several lines, in half of lxml's time.

    None for whatever is wrong with it: lxml has the better messages, and numbers the last line of a tag, not its first.
    """
    parser = expat.ParserCreate("utf-8", " ")  # a prefix that is not declared is an error
    parser.buffer_text = True
    above = Node("", 0, {}, "", None)
    open_nodes, pieces = [above], list[str]()

    def start(tag: str, attributes: dict[str, str]) -> None:
        parent = open_nodes[-1]
        siblings = parent.children
        if pieces:
            if not siblings:  # as lxml has it, the text of an element is what stands before its first child
                parent.text = "".join(pieces)
            pieces.clear()
        node = Node(tag, parser.CurrentLineNumber, attributes, "", parent)
        siblings.append(node)
        open_nodes.append(node)
        if len(open_nodes) > MAX_DEPTH:
            raise _NotPlainError
        if texts is not None and tag in texts:
            parser.CharacterDataHandler = pieces.append

    def end(_: str) -> None:
        node = open_nodes.pop()
        if pieces:
            if not node.children:
                node.text = "".join(pieces)
            pieces.clear()
            if texts is not None:
                parser.CharacterDataHandler = None

    parser.StartElementHandler, parser.EndElementHandler = start, end
    if texts is None:
        parser.CharacterDataHandler = pieces.append
    try:
        parser.Parse(text.encode("utf-8", "surrogatepass"), True)
    except (expat.ExpatError, _NotPlainError):
        return None
    finally:  # the parser, its handlers and the tree would hold each other
        parser.StartElementHandler = parser.EndElementHandler = parser.CharacterDataHandler = None
    top = above.children[0]
    top.parent = None
    return top


class _NotPlainError(Exception):
    """The file is for the parser with the better messages."""


def _refuse_wide_tags(text: str, file: str) -> bool:
    """Before parsing: comparing the names of 20,000 attributes with each other would take the parser seconds.

    Returns whether the file has neither wide tags nor more than so many.
    """
    parts = text.split("<")
    if max(map(len, parts)) < _WIDE:
        return len(parts) <= most_elements(most_bytes())
    line = 1
    for part in parts:
        tag, ended, _ = part.partition(">")
        if len(tag) >= _WIDE and ended and tag[:1] not in "!?" and len(_ASSIGNED.findall(tag)) > MAX_ATTRIBUTES:
            raise _error("xml.too_big", file, line, tag.split(None, 1)[0], f"more than {MAX_ATTRIBUTES} attributes")
        line += part.count("\n")
    return False


def _element_at(text: str, line: int, column: int) -> str:
    """The element, and attribute, in whose tag a parser stopped (1-based line and column); empty outside of tags."""
    start = 0
    for _ in range(line - 1):
        start = text.find("\n", start) + 1
        if start == 0:
            return ""
    return _place(text[: start + max(0, column - 1)])[1]


def _nodes(root: Any, file: str, odd: bool) -> Node:
    """`odd`: an attribute of the file may be too long, one of too many, or have a namespace."""
    own = _namespace(root)
    top = _node(root, None, file, odd, own)
    parent, count, allowed = top, 1, most_elements(most_bytes())
    open_nodes = [top]
    # one element at a time: lxml reuses its proxies
    events = etree.iterwalk(root, events=("start", "end"))
    next(events)
    for event, element in events:
        if event == "end":
            open_nodes.pop()
            parent = open_nodes[-1] if open_nodes else top
            continue
        tag = element.tag
        if odd or not isinstance(tag, str) or tag[0] == "{":
            node = _node(element, parent, file, odd, own)
        else:
            node = Node(tag, element.sourceline or 0, dict(element.items()), element.text or "", parent)
        parent.children.append(node)
        open_nodes.append(node)
        parent = node
        count += 1
        if len(open_nodes) > MAX_DEPTH:
            raise _too_deep(file, open_nodes[-2].line)
        if count > allowed:
            hint = "--max-file-bytes allows more, in proportion"
            raise _error("xml.too_big", file, node.line, "", f"more than {allowed} elements", hint=hint)
    return top


def _namespace(element: Any) -> str:
    """The namespace of an element with its braces; empty for none."""
    tag = str(element.tag)
    return tag[: tag.index("}") + 1] if tag[0] == "{" else ""


def _node(element: Any, parent: Node | None, file: str, odd: bool, own: str) -> Node:
    """`own`: the namespace of the root, in which a prefix distinguishes nothing."""
    tag = element.tag
    if not isinstance(tag, str):  # an entity reference that was not resolved
        line = element.sourceline or 1
        raise _error("xml.entity_forbidden", file, line, "", "an entity reference is refused")
    if tag[0] == "{":
        local = tag[tag.index("}") + 1 :]
        tag = f"{element.prefix}:{local}" if element.prefix and not tag.startswith(own or "}") else local
    attributes: dict[str, str] = dict(element.items())
    if attributes and max(map(len, attributes.values())) > MAX_ATTRIBUTE:
        name, value = max(attributes.items(), key=lambda item: len(item[1]))
        found, allowed = f"{len(value)} characters", f"up to {MAX_ATTRIBUTE}"
        text = "the value is too long"
        raise _error("xml.attribute_too_long", file, element.sourceline, f"{tag}@{name}", text, found, allowed)
    if odd:  # xsi:noNamespaceSchemaLocation and the like say nothing about the scenario
        attributes = {name: value for name, value in attributes.items() if name[0] != "{"}
    if len(attributes) > MAX_ATTRIBUTES:
        raise _error("xml.too_big", file, element.sourceline, tag, f"more than {MAX_ATTRIBUTES} attributes")
    return Node(tag, element.sourceline or 0, attributes, element.text or "", parent)


def _too_deep(file: str, line: int) -> ScenarioError:
    return _error("xml.too_deep", file, line, "", f"elements nest deeper than {MAX_DEPTH}")


def _error(
    code: str,
    file: str,
    line: int | None,
    element: str,
    text: str,
    found: str = "",
    allowed: str = "",
    hint: str = "",
) -> ScenarioError:
    return ScenarioError([Finding(code, "error", file, line, element, found, allowed, hint, text)])
