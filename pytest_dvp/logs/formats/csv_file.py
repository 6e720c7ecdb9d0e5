"""CSV -> Table. Every complaint has its line and column; nothing is guessed, shifted or filled in.

numpy's own reader: exact, 0.4 s for an hour at 100 Hz, and `dvp check` need not import pandas.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from openscenario.findings import Findings
from pytest_dvp.logs.account import open_account
from pytest_dvp.logs.budget import Budget
from pytest_dvp.logs.column_names import Header, canonical, parse_header
from pytest_dvp.logs.formats.log_format import LogFormat
from pytest_dvp.logs.infinite_values import without_infinite
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.plain_rows import named, separated
from pytest_dvp.logs.signals import SIGNALS
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.table import RawColumn, Table
from pytest_dvp.logs.text_times import seconds_of
from pytest_dvp.logs.texts import Texts, texts_of
from pytest_dvp.logs.two_part_time import one_time
from pytest_dvp.logs.units import find_unit

EMPTY = frozenset(("", "nan", "na", "n/a", "null", "none", "-", "#n/a", "-nan", "nil"))
LOGIC = {"true": 1.0, "false": 0.0}
_DECIMAL_COMMA = re.compile(rb'"[-+]?\d+,(\d{1,2}|\d{4,})"')
RECOVER = "`dvp recover` writes the whole rows to a new file"
_CLOCK = re.compile(r"\d:\d")  # of a time in words, which is no unit
_COMMENT = re.compile(
    rb"(?mi)^[ \t]*#(?!N/A|DIV/0!|VALUE!|REF!|NUM!|NAME\?|NULL!|SPILL!|CALC!).*$"
)  # and no error value of a sheet
_NUMBERS = "a number such as 1.5 or -2e-3; empty where nothing was measured"
_TIMES = "a number, or a time such as 12:03:04.5, 2026-05-01T12:03:04.5+02:00 or 01.05.2026 12:03:04"
_HEAD = 1 << 16  # bytes, and
_LINES = 60  # among which the header is
_BLOCK = 1 << 22  # bytes looked at together: small beside the file, so that counting costs no memory
_MOST_COLUMNS = 10_000  # chosen, not measured: far more than a recorder writes; a file with more is no table
_LONGEST = 1000  # characters of a name


def read_csv(path: Path, budget: Budget | None = None, *, nameless: bool = False) -> Table:
    """Read a CSV file: separator `,` `;`, tab, bars or blanks, decimal comma with `;` or tab, a row of units, quotes,
    comments `#`. nameless: rows without a header are taken, their columns called c1, c2, ...

    Raises LogError; findings that do not forbid reading on are in the table.
    """
    table = Table(str(path), "csv", [], place="column t")
    account = open_account(path, budget)
    account.rows(_least_rows(path, account.size))
    account.unpack(account.size)
    text = separated(_whole_text(path))
    head = read_head(named(text) if nameless else text, table)
    account.table(head.body.count(b"\n"), len(head.headers))
    body, separator, width = head.body, head.separator, len(head.headers)
    if b"#" in body:
        body = _COMMENT.sub(b"", body)  # an empty line: the rows below keep their numbers
    ended = body.endswith(b"\n")
    if separator != "," and b"," in body:
        body = body.replace(b",", b".")
    if b'"' in body:
        try:
            body = _unquoted(body, separator)
        except csv.Error as error:
            start = _open_quote(body)
            _refuse(
                table, "log.open_quote", head.line + start, "", f"a quote that is not closed: {error}", hint=RECOVER
            )
    if not ended:
        body = _without_cut_row(table, body, head.line, width, separator)
    lines = _check_shape(table, body, head.line, width, separator)
    table.lines = lines
    table.columns = one_time(_columns(table, body, lines, list(head.headers), separator))
    return table


def read_stream(path: Path, findings: Findings, msg_dirs: Sequence[Path], budget: Budget | None) -> list[Stream]:
    """The whole file as one stream; its receive times are NaN if no column is called like a time.

    Raises LogError, also for a table without a column of numbers.
    """
    table = read_csv(path, budget, nameless=True)
    if not table.columns:
        findings.add("log.no_numbers", str(path), table.header_line, "", "no column of numbers in it")
        raise LogError.of(findings.in_order())
    kept = {f"column {name}" for name in table.texts}  # told with the fields that are not mapped
    findings.found.extend(f for f in table.findings.found if f.code != "log.text_column" or f.element not in kept)
    fields = {column.header.name: column.values for column in table.columns}
    units = {column.header.name: column.header.unit for column in table.columns if column.header.unit}
    clock = next((c for c in table.columns if canonical(c.header.name) == "t"), None)
    if clock is None:
        receive = np.full(len(next(iter(fields.values()))), np.nan)  # a mapping says which column it is
    else:
        unit = find_unit(clock.header.unit or "s")
        receive = clock.values * (unit.scale if unit is not None else 1.0)
    return [Stream("", "", receive, fields, units, texts=table.texts)]


_ENDINGS = (".csv", ".txt", ".tsv")
FORMAT = LogFormat("csv", _ENDINGS, (), read_stream, table=read_csv, common=_ENDINGS)


def _least_rows(path: Path, size: int) -> int:
    """How many rows a file has if none is twice as long as the longest of its first ones; 0 for a short file."""
    try:
        with path.open("rb") as file:
            longest = max(map(len, file.read(_HEAD).split(b"\n")))
    except OSError:
        return 0  # reading it tells why
    return size // (2 * longest + 2) if size > _HEAD else 0


class Head(NamedTuple):
    """Of a CSV file: its columns, what separates them, the rows, and the line of the first of them."""

    headers: tuple[Header, ...]
    separator: str
    body: bytes
    line: int


def read_head(text: bytes, table: Table) -> Head:
    """The head of a CSV file as `normalised` gives it. Raises LogError for one that names no columns."""
    start, line = _skip_comments(text)
    start, line = _skip_words(table, text, start, line)
    end = text.find(b"\n", start)
    head = text[start : end if end >= 0 else len(text)]
    table.header_line = line
    if not head.strip():
        table.findings.add(
            "log.empty", table.file, None, "", "the file is empty", allowed="a header and rows of numbers"
        )
        raise LogError.of(table.findings.in_order())
    separator = _separator(head)
    if (count := head.count(separator.encode()) + 1) > _MOST_COLUMNS:
        _refuse(table, "log.too_many_columns", line, "", f"{count} columns", f"at most {_MOST_COLUMNS}")
    if len(head) > _LONGEST * _MOST_COLUMNS:
        said = f"the header is a line of {len(head)} characters"
        _refuse(table, "log.header_missing", line, "", said, "a header `t [s],v [m/s],...`")
    try:
        names = [name.strip() for name in next(csv.reader([_text(head)], delimiter=separator))]
    except csv.Error as error:
        _refuse(table, "log.header_missing", line, "", f"the header cannot be read: {error}", "`name [unit],...`")
    while names and not names[-1] and len(names) > 1:
        names.pop()  # a separator at the end of each line
    if names and not names[0] and len(names) > 1:
        first = next(name for name in ("index", "index_1") if name not in names)
        names[0] = f"{first} [-]"  # pandas writes its index without a name
    _refuse_headless(table, names, line)
    body = text[end + 1 :] if end >= 0 else b""
    headers, body, line = _units_row([parse_header(name) for name in names], body, line + 1, separator)
    return Head(tuple(headers), separator, body, line)


def _without_cut_row(table: Table, body: bytes, line: int, width: int, separator: str) -> bytes:
    """Without a last row that has neither all its fields nor an end: the recorder was killed while it wrote."""
    start = body.rstrip(b"\n").rfind(b"\n") + 1
    fields = body.count(separator.encode(), start) + 1
    if fields >= width or not body[start:].strip():
        return body
    table.findings.add(
        "log.truncated", table.file, line + body.count(b"\n", 0, start), "",
        "the end of the file is missing: the last row is cut and left out", found=f"{fields} fields",
        allowed=f"{width} fields, as the header names", hint="the recording was not finished", severity="warning",
    )  # fmt: skip
    return body[:start]


def _refuse(
    table: Table, code: str, line: int | None, element: str, text: str, allowed: str = "", hint: str = ""
) -> NoReturn:
    table.findings.add(code, table.file, line, element, text, allowed=allowed, hint=hint)
    raise LogError.of(table.findings.in_order())


def _whole_text(path: Path) -> bytes:
    """The file as UTF-8 (or Latin-1: only headers hold more than ASCII) with `\\n` at the end of lines."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise LogError(f"{path}: the log cannot be read: {error.strerror or error}", "log.unreadable") from error
    data = normalised(data, path)
    if b"\x00" in data:
        hint = " (a disk that was full or a file that was not closed? `dvp recover` keeps its whole rows)"
        text = f"{path}: not a text file (a zero byte at {data.index(0)})"
        raise LogError(text + (hint if b"\n" in data[: data.index(0)] else ""), "log.not_csv")
    return data


def normalised(data: bytes, path: Path) -> bytes:
    """Bytes of a text file as UTF-8 without a byte order mark, lines ending with `\\n`. Raises LogError."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        try:
            data = data.decode("utf-16").encode()
        except UnicodeDecodeError:
            raise LogError(f"{path}: UTF-16 by its first bytes but not readable as such", "log.bad_encoding") from None
    elif data[:3] == b"\xef\xbb\xbf":
        data = data[3:]
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data


def _text(raw: bytes) -> str:
    try:
        return raw.decode()
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def _skip_comments(text: bytes) -> tuple[int, int]:
    """Offset and line of the header: leading empty lines and comments are passed over. A comment with as many fields as
    the row of numbers under it is the header (`# t [s],...` or `# time(s),x(m),...`)."""
    position, line = 0, 1
    while position < len(text):
        end = text.find(b"\n", position)
        end = len(text) if end < 0 else end
        row = text[position:end].strip()
        if row.startswith(b"#") and (row.count(b"[") > 1 or _names(row, text[end + 1 : end + 1 + _HEAD])):
            return text.index(b"#", position) + 1, line
        if row and not row.startswith(b"#"):
            break
        position, line = end + 1, line + 1
    return position, line


def _names(comment: bytes, rest: bytes) -> bool:
    """True if a comment holds a word for each number of the row that follows it."""
    under = rest[: rest.find(b"\n")] if b"\n" in rest else rest
    mark = _separator(under)
    names, numbers = (_text(row.strip(b"# \t")).split(mark) for row in (comment, under))
    return len(names) == len(numbers) > 1 and all(map(_is_number, numbers)) and not any(map(_is_number, names))


def _skip_words(table: Table, text: bytes, start: int, line: int) -> tuple[int, int]:
    """Offset and line of the header below lines about the drive ("Driver: XY"), which have other fields than the rows.

    The header is the first line with as many fields as a row further down, most of them words.
    """
    sample = text[start : start + _HEAD].split(b"\n")
    rows = [row for row in sample[:_LINES] if row.strip()]
    if len(rows) < 3:
        return start, line
    usual = rows[len(rows) // 2]
    offset = 0
    for k, row in enumerate(sample[:_LINES]):
        mark = _separator(row)
        cells = [cell.strip(' "') for cell in _text(row).split(mark)]
        wide = row.count(mark.encode()) == usual.count(mark.encode()) > 0
        if wide and 2 * sum(_is_number(cell) for cell in cells) < len(cells):
            if k:
                lines = "1 line above the header is" if k == 1 else f"{k} lines above the header are"
                table.findings.add(
                    "log.lines_above_header", table.file, line, "", f"{lines} left out",
                    found=_text(sample[0])[:60], severity="warning",
                )  # fmt: skip
            return start + offset, line + k
        offset += len(row) + 1
    return start, line


def _separator(head: bytes) -> str:
    outside = re.sub(rb"\[[^\]]*\]", b"", head)
    return max((",", ";", "\t"), key=lambda mark: (outside.count(mark.encode()), mark == ","))


def _refuse_headless(table: Table, names: list[str], line: int) -> None:
    if len(names) == 1 and (names[0].count("[") > 1 or "|" in names[0]):
        allowed = "fields separated by `,`, `;` or a tab"
        _refuse(table, "log.one_field", line, "", "nothing in the header separates its fields", allowed)
    for number, name in enumerate(names, 1):
        if len(name) > _LONGEST:
            text = f"column {number} has a name of {len(name)} characters"
            _refuse(table, "log.header_missing", line, f"column {number}", text, "a header `t [s],v [m/s],...`")
    for number, name in enumerate(names, 1):
        if not name:
            _refuse(
                table, "log.name_missing", line, f"column {number}", f"column {number} has no name", "`name [unit]`"
            )
    if all(_is_number(name) for name in names):
        _refuse(
            table,
            "log.header_missing",
            line,
            "",
            "the first row holds numbers, not names",
            "a header `t [s],v [m/s],...`",
            "`dvp map` can tell many columns by their numbers",
        )


def _units_row(headers: list[Header], body: bytes, line: int, separator: str) -> tuple[list[Header], bytes, int]:
    """Takes a row of units under a header of bare names."""
    end = body.find(b"\n")
    under = body[: end if end >= 0 else len(body)]
    if under.count(separator.encode()) > len(headers) + 1:  # a ragged row; taken apart, it could take much memory
        return headers, body, line
    try:
        cells = [cell.strip() for cell in next(csv.reader([_text(under)], delimiter=separator), [])]
    except csv.Error:  # a field of more than 131,072 characters is no unit
        return headers, body, line
    words = [cell for cell in cells if cell.lower() not in EMPTY or cell == "-"]
    numbers = any((_is_number(cell) and cell != "1") or _CLOCK.search(cell) for cell in words)
    if len(cells) != len(headers) or not words or numbers:
        return headers, body, line
    if any(header.unit is None for header in headers) and not any(cell.startswith("=") for cell in cells):
        filled = [
            Header(header.text, header.text.strip(), cell.strip("[]() ") or "-") if header.unit is None else header
            for header, cell in zip(headers, cells, strict=True)
        ]
        return filled, body[end + 1 :] if end >= 0 else b"", line + 1
    return headers, body, line


def _unquoted(body: bytes, separator: str) -> bytes:
    if separator == "," and _DECIMAL_COMMA.search(body):  # "0,25" can only be a decimal comma, "1,250" could be both
        body = re.sub(rb'"([-+]?\d+),(\d+)"', rb"\1.\2", body)
    out = io.StringIO()
    writer = csv.writer(out, delimiter=separator, quoting=csv.QUOTE_NONE, escapechar="\\", lineterminator="\n")
    for row in csv.reader(io.StringIO(_text(body)), delimiter=separator):
        writer.writerow([cell.replace("\n", " ").replace(separator, " ") for cell in row])
    return out.getvalue().encode()


def _open_quote(body: bytes) -> int:
    """Index of the first line with a quote too many."""
    return next((k for k, row in enumerate(body.split(b"\n")) if row.count(b'"') % 2), 0)


def _counts(body: bytes, mark: int) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Marks on, and length of, each line; a last line without its end counts."""
    data = np.frombuffer(body, np.uint8)
    carried, length = 0, 0
    for begin in range(0, len(data), _BLOCK):
        block = data[begin : begin + _BLOCK]
        ends = np.flatnonzero(block == 10)
        marks = np.flatnonzero(block == mark)
        if not len(ends):
            carried, length = carried + len(marks), length + len(block)
            continue
        upto = np.searchsorted(marks, ends)
        count, size = np.diff(upto, prepend=0), np.diff(ends, prepend=-1) - 1
        count[0] += carried
        size[0] += length
        carried, length = len(marks) - int(upto[-1]), len(block) - int(ends[-1]) - 1
        yield count, size
    if length:
        yield np.array([carried]), np.array([length])


def _check_shape(table: Table, body: bytes, line: int, width: int, separator: str) -> NDArray[np.int64]:
    """Line of each row. Raises LogError for the first row that has not one field a column."""
    pairs = list(_counts(body, ord(separator)))
    if not pairs:
        return np.zeros(0, np.int64)
    counts, sizes = (np.concatenate(parts) for parts in zip(*pairs, strict=True))
    lines = np.arange(line, line + len(counts), dtype=np.int64)
    full = sizes > 0
    counts, lines = counts[full], lines[full]
    extra = 1 if len(counts) and np.all(counts == width) and width > 1 else 0  # a separator at the end of each line
    ragged = np.flatnonzero(counts != width - 1 + extra)
    if len(ragged):
        at = int(ragged[0])
        which = (
            "the last row is cut"
            if at == len(counts) - 1
            else f"fields and columns differ in number ({len(ragged)} rows)"
        )
        table.findings.add(
            "log.ragged_row", table.file, int(lines[at]), "", which, found=f"{counts[at] + 1} fields",
            allowed=f"{width} fields, as the header names",
            hint=f"an empty field means: not measured; {RECOVER}",
        )  # fmt: skip
        raise LogError.of(table.findings.in_order())
    return lines


def _columns(
    table: Table, body: bytes, lines: NDArray[np.int64], headers: list[Header], separator: str
) -> list[RawColumn]:
    """The columns of numbers; one of words that no signal needs is left out."""
    width = len(headers)
    if not len(lines):
        return [RawColumn(header, np.zeros(0)) for header in headers]
    raw = separator.encode()
    mark = re.escape(raw)
    if raw + raw in body or raw + b"\n" in body or b"\n" + raw in body or body[:1] == raw or body[-1:] == raw:
        body = re.sub(rb"(?<=" + mark + rb")(?=" + mark + rb"|\n|\Z)", b"nan", body)
        body = re.sub(rb"(?m)^(?=" + mark + rb")", b"nan", body)
    try:
        matrix = np.loadtxt(
            io.BytesIO(body), delimiter=separator, comments=None, ndmin=2, usecols=range(width), encoding="latin-1"
        )
        return [
            RawColumn(
                headers[i],
                without_infinite(matrix[:, i], table.file, lines, f"column {headers[i].name}", table.findings),
            )
            for i in range(width)
        ]
    except ValueError:
        pass
    return _slowly(table, body, lines, headers, separator)


def _slowly(
    table: Table, body: bytes, lines: NDArray[np.int64], headers: list[Header], separator: str
) -> list[RawColumn]:
    """Cell by cell, for files with words in them: finds the first cell of each column that is no number."""
    width = len(headers)
    values = np.full((width, len(lines)), np.nan)
    bad: dict[int, tuple[int, str]] = {}
    numbers = [0] * width
    for i, row in enumerate(_rows(body)):
        cells = row.split(separator)
        for j in range(width):
            cell = cells[j].strip()
            value = number(cell)
            if value is not None:
                values[j, i] = value
                numbers[j] += value == value  # an empty field says nothing of what the column holds
            elif cell.lower() not in EMPTY:
                bad.setdefault(j, (i, cell))
    result: list[RawColumn] = []
    for j, header in enumerate(headers):
        if j not in bad:
            result.append(
                RawColumn(
                    header, without_infinite(values[j], table.file, lines, f"column {header.name}", table.findings)
                )
            )
            continue
        i, cell = bad[j]
        stamps = seconds_of([row.split(separator)[j] for row in _rows(body)])
        if stamps is not None:
            result.append(RawColumn(Header(header.text, header.name, "s"), stamps))
            continue
        words_only = numbers[j] == 0 and header.name not in SIGNALS and not cell.startswith("=")
        if words_only and (texts := _words(body, j, separator)) is not None:
            table.texts[header.name] = texts
        table.findings.add(
            "log.text_column" if words_only else "value.not_a_number",
            table.file, int(lines[i]), f"column {header.name}",
            "a column of words is left out" if words_only else "this is not a number",
            found=cell, allowed=_TIMES if canonical(header.name) == "t" else "" if words_only else _NUMBERS,
            severity="warning" if words_only else "error",
        )  # fmt: skip
    if table.findings.errors:
        raise LogError.of(table.findings.in_order())
    return result


def _words(body: bytes, column: int, separator: str) -> Texts | None:
    """The words of a column, none for an empty field; None if they are no few short ones."""
    cells = (row.split(separator)[column].strip() for row in _rows(body))
    return texts_of(None if cell.lower() in EMPTY else cell for cell in cells)


def _rows(body: bytes) -> Iterator[str]:
    """The rows one after the other: all of them as words would take ten times the memory of the file."""
    return (_text(row).rstrip("\n") for row in io.BytesIO(body) if row != b"\n")


def number(cell: str) -> float | None:
    """The number that a cell holds, true and false as 1 and 0; None for a word, and for what only Python takes for a
    number: 1_000, digits of other scripts."""
    text = cell.strip()
    try:
        return float(text) if text.isascii() and "_" not in text else None
    except ValueError:
        return LOGIC.get(text.lower())


def _is_number(cell: str) -> bool:
    value = number(cell.replace(",", "."))
    return value is not None and cell.strip().lower() not in LOGIC
