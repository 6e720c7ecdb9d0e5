"""A table of stages for a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def table_lines(table: Mapping[str, Any]) -> list[str]:
    """A table of stages (StageTable.as_dict) for a terminal."""
    texts = [(_row_name(row), [cell["text"] for cell in row["cells"]]) for row in table["rows"]]
    heads = [f"{a} to {b}" if b else a for a, b in zip(table["stages"], table["against"], strict=True)]
    wide = [max(len(head), *(len(cells[k]) for _, cells in texts)) for k, head in enumerate(heads)]
    left = max(len(name) for name, _ in texts)
    out = [" " * left + "".join(f"  {head:>{w}}" for head, w in zip(heads, wide, strict=True))]
    for name, cells in texts:
        out.append(f"{name:<{left}}" + "".join(f"  {cell:>{w}}" for cell, w in zip(cells, wide, strict=True)))
    return out


def _row_name(row: Mapping[str, Any]) -> str:
    if row["metric"] == "mncc":
        return f"MNCC {row['name']}"
    return row["name"] if row["unit"] == "-" else f"{row['name']} [{row['unit']}]"
