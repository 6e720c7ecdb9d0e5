"""What an MDF file says that it holds, read from its blocks before asammdf makes room for it.

Source: ASAM MDF 4.2.0, chapter 5 (block structure), and MDF 3.3.1, chapter 3.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from typing import NamedTuple

from pytest_dvp.logs.account import Account
from pytest_dvp.logs.memory_map import Mapped
from pytest_dvp.logs.unpack import unpack

_PIECE = 1 << 16  # bytes unpacked at once; chosen, not measured: it bounds memory, no result depends on it
_ZSTD, _LZ4 = (2, 3), (4, 5)  # zip types of asammdf; 0 and 1 are deflate and transposed deflate
_DATA = frozenset((b"##DT", b"##DV", b"##DI", b"##SD", b"##RD"))
_CHANNEL = 3  # blocks of a chain of channels nest no deeper: a structure in a structure in an array


class MdfError(ValueError):
    """What the blocks say cannot be."""


class _Block(NamedTuple):
    """A block of MDF 4: its kind, its links, and where the rest of it begins."""

    kind: bytes
    links: tuple[int, ...]
    start: int
    size: int


def charge_mdf(data: Mapped, account: Account) -> None:
    """Charge all that a file unpacks to and holds.

    Raises LogError for more than the account allows, MdfError for chains of blocks that return to themselves and for
    data that are not as long as they say.
    """
    try:
        if data[8:9] == b"4":
            _Blocks(data, account).charge()
        elif data[8:9] == b"3":
            _charge_3(data, account)
    except (struct.error, zlib.error) as error:
        raise MdfError(f"damaged: {error}") from None


class _Blocks:
    """MDF 4."""

    def __init__(self, data: Mapped, account: Account) -> None:
        self._data, self._account = data, account
        self._checked: set[int] = set()  # compressed blocks that are as long as they say

    def charge(self) -> None:
        head = self._block(64)
        for group in self._chain(head.links[0] if head and head.links else 0):
            self._charge_data(group.links[2])
            for records in self._chain(group.links[1]):
                _, cycles, _, _, size, _ = struct.unpack_from("<QQHH4xII", self._data, records.start)
                channels = sum(1 for _ in self._channels(records.links[1], 0))
                self._account.rows(cycles)
                self._account.hold(cycles * max(8 * channels, size))

    def _channels(self, place: int, depth: int) -> Iterator[_Block]:
        if depth > _CHANNEL:
            raise MdfError("channels nest too deeply")
        for channel in self._chain(place):
            yield channel
            if channel.kind == b"##CN":
                yield from self._channels(channel.links[1], depth + 1)
                self._charge_data(channel.links[5])

    def _block(self, place: int) -> _Block | None:
        """None if there is none, or if the file was cut before its end."""
        if not 0 < place <= len(self._data) - 24:
            return None
        kind, size, count = struct.unpack_from("<4s4xQQ", self._data, place)
        if place + size > len(self._data) or 24 + 8 * count > size:
            return None
        return _Block(kind, struct.unpack_from(f"<{count}Q", self._data, place + 24), place + 24 + 8 * count, size)

    def _chain(self, place: int) -> Iterator[_Block]:
        """Blocks of one kind, each of which names the next."""
        return _chain(place, self._block, lambda block: block.links[0] if block.links else 0)

    def _charge_data(self, place: int) -> None:
        first = self._block(place)
        if first is None:
            return
        if first.kind == b"##HL":
            self._charge_data(first.links[0])
        elif first.kind in (b"##DL", b"##LD"):
            for part in self._chain(place):
                for link in part.links[1:]:
                    block = self._block(link)
                    if block is not None and block.kind not in (b"##DL", b"##LD", b"##HL"):
                        self._charge_data(link)
        elif first.kind == b"##DZ":
            self._charge_packed(first)
        elif first.kind in _DATA:
            self._account.unpack(first.size - 24)

    def _charge_packed(self, block: _Block) -> None:
        _, zip_type, _, size, packed = struct.unpack_from("<2sB1xIQQ", self._data, block.start)
        self._account.unpack(size)
        start = block.start + 24
        if block.start in self._checked:
            return
        self._checked.add(block.start)
        if zip_type in _LZ4 or zip_type in _ZSTD:
            found = len(unpack("lz4" if zip_type in _LZ4 else "zstd", self._data[start : start + packed], size))
        else:
            found = _inflated(self._data, start, start + packed, size)
        if found != size:
            raise MdfError(f"a block that says {size} bytes unpacks to {found} or more")


def _inflated(data: Mapped, start: int, end: int, most: int) -> int:
    """How many bytes a deflated block unpacks to, counted no further than is allowed."""
    inflate, count = zlib.decompressobj(), 0
    for place in range(start, end, _PIECE):
        packed = data[place : min(place + _PIECE, end)]
        while packed and count <= most:
            count += len(inflate.decompress(packed, _PIECE))
            packed = inflate.unconsumed_tail
    return count


def _chain(place: int, read: Callable[[int], _Block | None], following: Callable[[_Block], int]) -> Iterator[_Block]:
    seen: set[int] = set()
    block = read(place)
    while block is not None:
        if place in seen:
            raise MdfError("a chain of blocks returns to itself")
        seen.add(place)
        yield block
        place = following(block)
        block = read(place)


def _charge_3(data: Mapped, account: Account) -> None:
    """MDF 3: nothing is compressed; data groups, channel groups and channels are chains."""
    order = "<" if data[24:26] == b"\0\0" else ">"

    def read(place: int) -> _Block | None:
        if not 0 < place <= len(data) - 28:
            return None
        kind, size = struct.unpack_from(f"{order}2sH", data, place)
        return _Block(kind, struct.unpack_from(f"{order}4I", data, place + 4), place, size)

    def chain(place: int) -> Iterator[_Block]:
        return _chain(place, read, lambda block: block.links[0])

    for group in chain(struct.unpack_from(f"{order}I", data, 68)[0]):
        for records in chain(group.links[1]):
            _, _, size, cycles = struct.unpack_from(f"{order}HHHI", data, records.start + 16)
            channels = sum(1 for _ in chain(records.links[1]))
            account.rows(cycles)
            account.hold(cycles * max(8 * channels, size))
