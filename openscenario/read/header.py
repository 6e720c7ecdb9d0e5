"""File header: the version decides whether the rest can be understood."""

from __future__ import annotations

from typing import Final

from openscenario.model.declarations import FileHeader
from openscenario.model.kinds import At
from openscenario.parameters import Scope
from openscenario.plan import plan_of
from openscenario.read.elements import ElementReader
from openscenario.values import BadValue, to_moment
from openscenario.xml import Node

BEFORE_1_0: Final = (
    "before 1.0 elements had other names; convert the file to 1.0 with the style sheet for 0.9.1 that ASAM publishes "
    "with OpenSCENARIO 1.0, or export it anew"
)
_SAID: Final = ("author", "description")
VERSIONS: Final = ((1, 0), (1, 1), (1, 2), (1, 3))


def read_header(node: Node | None, reader: ElementReader, root: At) -> FileHeader | None:
    """The header, or None if there is none or its version is unknown: then nothing else is worth a finding."""
    context = reader.context
    if node is None:
        context.error(
            "xml.fileheader_is_present", root, "", "the file header is missing", allowed="<FileHeader> in the root"
        )
        return None
    at = At(reader.file, node.line, f"{root.element}/FileHeader")
    major, minor = node.get("revMajor").strip(), node.get("revMinor").strip()
    supported = ", ".join(f"{a}.{b}" for a, b in VERSIONS)
    if not (major.isascii() and major.isdigit() and minor.isascii() and minor.isdigit()):
        context.error(
            "xml.version_is_defined",
            at,
            "",
            "revMajor and revMinor must be numbers",
            found=f"{major or 'nothing'}.{minor or 'nothing'}",
            allowed=supported,
        )
        return None
    if (int(major[:9]), int(minor[:9])) not in VERSIONS:
        attribute = "@revMinor" if major == "1" else "@revMajor"
        found = f"{major}.{minor}"
        hint = BEFORE_1_0 if int(major[:9]) == 0 else ""
        context.error(
            "version.unsupported", at, attribute, "unsupported version", found=found, allowed=supported, hint=hint
        )
        return None
    for name in _SAID:
        if name not in node.attributes:
            context.warning("xml.missing_attribute", at, f"@{name}", "a required attribute is missing; nothing uses it")
            node.attributes[name] = ""
    header: FileHeader | None = reader.read(plan_of(FileHeader), node, Scope(), at.element)
    if header is not None:
        _check_date(header, reader)
    return header


def _check_date(header: FileHeader, reader: ElementReader) -> None:
    """Nothing depends on it: a run goes on with a warning (see `check_scenario`)."""
    try:
        to_moment(header.date)
    except BadValue as error:
        found = header.date or "nothing"
        reader.context.warning(error.code, header.at, "@date", error.text, found=found, allowed=error.allowed)
