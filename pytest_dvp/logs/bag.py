"""Bags of ROS 1 and ROS 2 opened with rosbags, which unpacks only what an account allows."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from openscenario.findings import Findings
from pytest_dvp.logs.account import Account
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mcap_scan import Scan, scan_mcap
from pytest_dvp.logs.memory_map import mapped
from pytest_dvp.logs.unpack import ZSTD_WINDOW, TooLargeError, unpack

_CHUNK = 256 << 20  # bytes of an unpacked chunk or message; recorders begin a new chunk after 1 to 8 MB
_PIECE = 1 << 20  # bytes that are unpacked together where only their number counts
_INDEX = 160  # bytes in memory of an entry of a ROS 1 index (CPython 3.11: a tuple of three numbers), 12 in the file
_METADATA = 1 << 20  # bytes of metadata.yaml, which is read by a slow parser


@contextlib.contextmanager
def open_bag(path: Path, store: Any, account: Account) -> Iterator[Any]:
    """A rosbags AnyReader of a .bag file or of the folder of a ROS 2 bag.

    store: types of messages that the bag does not define. Raises LogError for what the account does not allow, and
    whatever rosbags raises.
    """
    from rosbags import rosbag1
    from rosbags.highlevel import AnyReader
    from rosbags.rosbag1 import reader as chunks_of_ros1
    from rosbags.rosbag2 import storage_mcap

    class Charged(rosbag1.Reader):
        """A reader of ROS 1 bags that charges its index: its entries may be named again and again."""

        def read_index_data(self, pos: int, indexes: Any) -> None:
            begin = self.bio.tell() if self.bio else 0
            super().read_index_data(pos, indexes)
            account.hold((self.bio.tell() - begin) // 12 * _INDEX if self.bio else 0)

    _check_metadata(path, account)
    for name in storage_mcap.DECOMPRESSORS:  # rosbags would unpack a chunk to whatever it says
        storage_mcap.DECOMPRESSORS[name] = functools.partial(_of_size, name)
    bag = AnyReader([path], default_typestore=store)
    if not bag.is2:
        bag.readers = [Charged(path)]
    names = {function: name.replace("none", "") for name, function in chunks_of_ros1.decompressors.items()}
    with bag:
        readers: list[Any] = [] if bag.is2 else list(bag.readers)
        for reader in readers:
            for place, chunk in reader.chunks.items():
                reader.chunks[place] = chunk._replace(decompressor=_charged(names[chunk.decompressor], account))
        yield bag


def messages(bag: Any, account: Account, wanted: Any = ()) -> Iterator[tuple[Any, int, bytes]]:
    """Connection, stamp [ns] and content of the messages of some connections (none named: all), in order of time.

    Raises LogError for what the account does not allow.
    """
    storage = getattr(bag.readers[0], "storage", None)
    each = False
    if storage is not None:
        for one in getattr(storage, "storages", [storage]):
            _charge_storage(one, account)
        each = storage.metadata.compression_mode == "message"
        if each:  # rosbags would unpack each message to whatever it says
            storage.metadata = storage.metadata._replace(compression_mode=None)
    unpacked = _charged("zstd", account)
    for connection, came, content in bag.messages(connections=wanted):
        yield connection, came, unpacked(content) if each else content


def _charge_storage(storage: Any, account: Account) -> None:
    """A file of a ROS 2 bag: the chunks of an MCAP file are charged, the rows of a database limited."""
    connection = getattr(storage, "dbconn", None)
    if connection is not None:  # a database may compute its messages: SQLite refuses to make longer ones
        import apsw

        connection.limit(apsw.SQLITE_LIMIT_LENGTH, _CHUNK)
    elif storage.chunks:
        account.unpack(sum(chunk.uncompressed_size for chunk in storage.chunks))
    else:  # without an index
        scan_mcap(mapped(storage.path), str(storage.path), Findings(), Scan(account))


def _check_metadata(path: Path, account: Account) -> None:
    """What metadata.yaml says: its files, if compressed as a whole, must not unpack to more than is allowed."""
    file = path / "metadata.yaml"
    if not path.is_dir() or not file.is_file():
        return
    if file.stat().st_size > _METADATA:
        found = f"{file.stat().st_size} bytes"
        raise LogError(f"{file}: too long for the description of a bag: {found}, allowed: {_METADATA}", "log.corrupt")
    for packed in sorted(path.glob("*.zstd")):
        _count_unpacked(packed, account)


def _count_unpacked(path: Path, account: Account) -> None:
    import zstandard

    decompressor = zstandard.ZstdDecompressor(max_window_size=ZSTD_WINDOW)
    with path.open("rb") as file, decompressor.stream_reader(file, read_across_frames=True) as content:
        while piece := content.read(_PIECE):
            account.unpack(len(piece))


def _of_size(name: str, content: bytes, size: int) -> bytes:
    return unpack(name, content, min(size, _CHUNK))


def _charged(name: str, account: Account) -> Callable[[bytes], bytes]:
    """Unpacks a block that says nothing of its size, and charges it."""

    def unpacked(content: bytes) -> bytes:
        most = min(account.left, _CHUNK)
        try:
            found = unpack(name, content, most)
        except TooLargeError:
            account.unpack(most + 1)
            raise
        account.unpack(len(found))
        return found

    return unpacked
