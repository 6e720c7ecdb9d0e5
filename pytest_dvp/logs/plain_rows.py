"""Tables of plain rows: fields between blanks or bars, and rows of numbers without a header (`numpy.savetxt`)."""

from __future__ import annotations

import re

_SAMPLE = 1 << 16  # bytes that are looked at, and
_FEWEST = 3  # rows that must agree: two numbers in a line of words are no table
_NUMBER = re.compile(rb"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf)", re.IGNORECASE)


def separated(text: bytes) -> bytes:
    """The text with commas where blanks or bars separate its fields; as it is if commas, semicolons or tabs do."""
    rows = [row.strip() for row in text[:_SAMPLE].split(b"\n")[:-1] if row.strip()]
    numbers = [row for row in rows if not row.startswith(b"#")]
    if len(numbers) < _FEWEST or any(mark in row for row in numbers[-_FEWEST:] for mark in (b",", b";", b"\t")):
        return text
    bars = all(b"|" in row for row in numbers[-_FEWEST:])
    split = re.compile(rb" *\| *" if bars else rb" +(?![\[(])")  # `v [m/s]` is one field
    last = [split.split(row.strip(b"| ")) for row in numbers[-_FEWEST:]]
    if len({len(cells) for cells in last}) != 1 or len(last[0]) < 2 or not all(map(_plain, last)):
        return text
    head = rows[0].lstrip(b"# ").strip(b"| ")
    if len(split.split(head)) != len(last[0]):  # names with blanks in them, or lines above the table
        return text
    return b"\n".join(_with_commas(row, split) for row in text.split(b"\n"))


def _with_commas(row: bytes, split: re.Pattern[bytes]) -> bytes:
    bare = row.strip(b"| ")
    mark = b"#" if bare.startswith(b"#") else b""
    return mark + split.sub(b",", bare.lstrip(b"# ")) if bare else b""


def _plain(cells: list[bytes]) -> bool:
    return all(_NUMBER.fullmatch(cell) for cell in cells)


def named(text: bytes) -> bytes:
    """The text with names `c1`, `c2`, ... above rows of numbers that have no header; else as it is."""
    rows = [row for row in text[:_SAMPLE].split(b"\n")[:-1] if row.strip() and not row.lstrip().startswith(b"#")]
    comment = text.lstrip().startswith(b"#")  # which may hold the names
    if comment or len(rows) < _FEWEST:
        return text
    mark = max((b",", b";", b"\t"), key=rows[0].count)
    first = [[cell.strip().replace(b",", b".") for cell in row.split(mark)] for row in rows[:_FEWEST]]
    if len({len(cells) for cells in first}) != 1 or len(first[0]) < 2 or not all(map(_plain, first)):
        return text
    return mark.join(b"c%d" % (k + 1) for k in range(len(first[0]))) + b"\n" + text
