"""Elements that no file holds: made for readers of another format."""

from __future__ import annotations

from openscenario.xml import Node


def element(tag: str, line: int, *children: Node, **attributes: str | float) -> Node:
    """An element with the line of the one that it stands for; numbers are written with all their digits."""
    text = {name: value if isinstance(value, str) else repr(float(value)) for name, value in attributes.items()}
    node = Node(tag, line, text, "", None)
    for child in children:
        child.parent = node
        node.children.append(child)
    return node
