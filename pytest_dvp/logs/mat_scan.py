"""What a .mat file says that it holds, read from its headers before scipy makes room for it.

Source: MAT-File Format (MathWorks, R2021a), "Level 5 MAT-Files" and "Level 4 MAT-Files".
"""

from __future__ import annotations

import math
import struct
import zlib

from pytest_dvp.logs.account import Account
from pytest_dvp.logs.memory_map import Mapped

_MATRIX, _COMPRESSED = 14, 15  # types of data elements
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE = 1, 2, 3, 4, 5  # array classes
_NUMBERS = frozenset(range(6, 16))  # array classes: double, single, whole numbers
_COMPLEX = 0x08  # flag of a complex array
_PLACE = 600  # bytes in memory of a cell or a struct of an array (CPython 3.11: an object with a dictionary, an array)
_DEEPEST = 16  # matrices inside matrices; scipy goes down without a limit of its own
_SIZES = (8, 4, 4, 2, 2, 1)  # bytes of a number of a level 4 matrix, by the tens digit of its type
_PIECE = 1 << 16  # bytes unpacked at once; chosen, not measured: it bounds memory, no result depends on it


class MatError(ValueError):
    """What a header says cannot be."""


class _Source:
    """The bytes of a file, or what an element of it unpacks to, in order."""

    def __init__(self, data: Mapped, start: int, end: int, packed: bool = False) -> None:
        self._data, self._at, self._end = data, start, end
        self._inflate = zlib.decompressobj() if packed else None
        self._ready = b""

    def read(self, count: int) -> bytes:
        if self._inflate is None:
            found = self._data[self._at : min(self._at + count, self._end)]
            self._at += count
        else:
            while len(self._ready) < count and (piece := self._next()):
                self._ready += piece
            found, self._ready = self._ready[:count], self._ready[count:]
        if len(found) < count:
            raise MatError("the file is cut")
        return found

    def skip(self, count: int) -> None:
        if self._inflate is None:
            self._at += count
            return
        while count > 0:
            part = min(count, _PIECE)
            self.read(part)
            count -= part

    def _next(self) -> bytes:
        assert self._inflate is not None
        packed = self._inflate.unconsumed_tail
        if not packed:
            packed = self._data[self._at : min(self._at + _PIECE, self._end)]
            self._at += len(packed)
        return self._inflate.decompress(packed, _PIECE) or (self._next() if self._at < self._end else b"")


def numbers_in(data: Mapped, account: Account) -> list[str]:
    """Names of the variables that are vectors of numbers or structs, after all that these hold was charged.

    Raises LogError for more than the account allows, MatError for what cannot be.
    """
    try:
        return _level_4(data, account) if 0 in data[:4] else _level_5(data, account)
    except (struct.error, zlib.error) as error:
        raise MatError(f"damaged: {error}") from None


def _level_4(data: Mapped, account: Account) -> list[str]:
    kind = struct.unpack_from("<i", data, 0)[0]
    order = "<" if 0 <= kind <= 5000 else ">"
    names, position = [], 0
    while position + 20 <= len(data):
        kind, rows, columns, complex_, length = struct.unpack_from(f"{order}5i", data, position)
        form, size = kind % 10, (kind // 10) % 10
        if not 0 <= kind <= 5000 or rows < 0 or columns < 0 or length < 1 or size >= len(_SIZES):
            raise MatError("a header that cannot be")
        start = position + 20 + length
        position = start + rows * columns * _SIZES[size] * (2 if complex_ else 1)
        if position > len(data):
            raise MatError(f"{rows} x {columns} numbers do not fit into the file")
        if form == 0 and rows * columns == max(rows, columns):
            account.table(rows * columns, 2 if complex_ else 1)
            names.append(data[start - length : start - 1].decode("latin-1"))
    return names


def _level_5(data: Mapped, account: Account) -> list[str]:
    order = "<" if data[126:128] == b"IM" else ">"
    names, position = [], 128
    while position + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, position)
        start, position = position + 8, position + 8 + size
        if position > len(data):
            raise MatError("the file is cut")
        packed = kind == _COMPRESSED
        if kind not in (_MATRIX, _COMPRESSED):
            continue
        source = _Source(data, start, position, packed)
        if packed:
            kind, size, _ = _tag(source, order)
            if kind != _MATRIX:
                raise MatError("a compressed element holds no matrix")
        account.unpack(size)
        name = _Walk(source, order, account).matrix(size, 0)
        if name is not None:
            names.append(name)
    return names


def _tag(source: _Source, order: str) -> tuple[int, int, bytes | None]:
    """Type, bytes, and the content of a small element, which is in the tag itself."""
    raw = source.read(8)
    kind, size = struct.unpack(f"{order}II", raw)
    if kind >> 16:
        return kind & 0xFFFF, min(kind >> 16, 4), raw[4:]
    return kind, size, None


class _Walk:
    """Goes through the elements of a matrix, and of the matrices in it."""

    def __init__(self, source: _Source, order: str, account: Account) -> None:
        self._source, self._order, self._account = source, order, account

    def matrix(self, size: int, depth: int) -> str | None:
        """Charges a matrix of `size` bytes; its name if it is a vector of numbers or a struct."""
        if size == 0:  # an empty cell
            return None
        if depth > _DEEPEST:
            raise MatError(f"matrices nest deeper than {_DEEPEST}")
        left = size
        flags, left = self._content(left, 8)
        (word,) = struct.unpack_from(f"{self._order}I", flags)
        kind = word & 0xFF
        if kind > 15:  # a function or an object of a class: other fields, and nothing that is read
            self._inside(left, depth)
            return None
        raw, left = self._content(left, 256)
        dims = struct.unpack(f"{self._order}{len(raw) // 4}i", raw[: len(raw) // 4 * 4])
        count, longest = math.prod(max(0, d) for d in dims), max(dims, default=0)
        name, left = self._content(left, 4096)
        if kind in _NUMBERS:
            if count > left:
                raise MatError(f"{count} numbers do not fit into {left} bytes")
            if depth:
                self._account.hold(16 * count)  # complex numbers have 16 bytes
                self._source.skip(left)
            elif count == longest:
                self._account.table(count, 2 if (word >> 8) & _COMPLEX else 1)
            else:
                return None
        else:
            if kind != _SPARSE and count > max(left, 1000):
                raise MatError(f"{count} values do not fit into {left} bytes")
            self._account.hold(count * (4 if kind == _CHAR else _PLACE if kind in (_CELL, _STRUCT, _OBJECT) else 0))
            self._inside(left, depth)
        return name.decode("latin-1") if kind in _NUMBERS or kind == _STRUCT else None

    def _content(self, left: int, most: int) -> tuple[bytes, int]:
        _, size, small = _tag(self._source, self._order)
        if small is not None:
            return small[:size], left - 8
        if size > most or size > left:
            raise MatError(f"a field of {size} bytes in a header")
        content = self._source.read(size)
        self._source.skip(-size % 8)
        return content, left - 8 - size - (-size % 8)

    def _inside(self, left: int, depth: int) -> None:
        while left >= 8:
            kind, size, small = _tag(self._source, self._order)
            left -= 8
            if small is not None:
                continue
            if size > left:
                raise MatError("an element is longer than the matrix that holds it")
            if kind == _MATRIX:
                self._account.hold(_PLACE)
                self.matrix(size, depth + 1)
            else:
                self._source.skip(size)
            self._source.skip(-size % 8)
            left -= size + (-size % 8)
        self._source.skip(max(left, 0))
