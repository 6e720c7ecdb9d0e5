"""ROS 2 definitions as rosbags has them -> the XML that Fast DDS builds types of."""

from __future__ import annotations

from xml.sax.saxutils import quoteattr

from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore

BASE = {"bool": "boolean", "uint8": "byte", "int8": "byte", "byte": "byte", "char": "byte"}
MOST = 100_000  # elements of a sequence: Fast DDS wants a bound
LONGEST = 10_000  # characters of a string


def dds_name(name: str) -> str:
    """`pkg/msg/Type` as DDS calls it."""
    package, _, kind = name.split("/")
    return f"{package}::msg::dds_::{kind}_"


def types_xml(store: Typestore, names: list[str]) -> str:
    """All the messages of these names and what they are made of."""
    done: dict[str, str] = {}
    for name in names:
        _struct(store, name, done)
    body = "\n".join(done.values())
    return f'<?xml version="1.0"?>\n<types xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">\n{body}\n</types>\n'


def _struct(store: Typestore, name: str, done: dict[str, str]) -> None:
    if name in done:
        return
    lines = []
    for member, (node, what) in store.fielddefs[name][1]:
        more = ""
        if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            (node, what), size = what[0], what[1]
            more = f' arrayDimensions="{size}"' if size else f' sequenceMaxLength="{MOST}"'
        if node == Nodetype.NAME:
            _struct(store, what, done)
            kind = f'type="nonBasic" nonBasicTypeName={quoteattr(dds_name(what))}'
        else:
            word = BASE.get(what[0], what[0])
            kind = f'type="{word}"' + (f' stringMaxLength="{LONGEST}"' if word == "string" else "")
        lines.append(f'    <member name="{member}" {kind}{more}/>')
    done[name] = f"  <type><struct name={quoteattr(dds_name(name))}>\n" + "\n".join(lines) + "\n  </struct></type>"
