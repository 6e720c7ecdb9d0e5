"""Small files that unpack to more than memory holds, and large ones: refused in one line, before memory is taken."""

from __future__ import annotations

import io
import re
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.budget import Budget
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log
from pytest_dvp.logs.recovery import recover

MB = 1 << 20
ZEROS = bytes(4 * MB)


def mcap(path: Path, messages: int, size: int, compression: str = "ZSTD") -> Path:
    """A recording of `messages` of `size` zero bytes each, in a chunk each."""
    from mcap.writer import CompressionType, Writer

    writer = Writer(str(path), chunk_size=size, compression=CompressionType[compression])
    writer.start()
    schema = writer.register_schema("Speed", "jsonschema", b'{"type": "object"}')
    channel = writer.register_channel("/car", "json", schema)
    for k in range(messages):
        writer.add_message(channel, log_time=k * 10**7, data=bytes(size), publish_time=k * 10**7)
    writer.finish()
    return path


def mat(path: Path, variables: int, size: int) -> Path:
    """Vectors of `size` zero bytes, compressed as MATLAB saves them (-v7): the same compressed bytes each time."""
    from scipy.io import savemat

    held = io.BytesIO()
    savemat(held, {"v_mps": np.zeros(size, np.uint8)})
    plain = held.getvalue()
    packed = zlib.compress(plain[128:], 9)
    element = (15).to_bytes(4, "little") + len(packed).to_bytes(4, "little") + packed
    path.write_bytes(plain[:128] + variables * element)
    return path


def mdf(path: Path) -> Path:
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as file:
        t = np.arange(len(ZEROS) // 8) * 0.01
        file.append([asammdf.Signal(np.zeros(len(t)), t, unit="m/s", name="speed")])
        file.save(path, overwrite=True, compression=2)
    return path


def bag1(path: Path, messages: int = 1) -> Path:
    """A bag of `messages` texts of 4 MiB, in a chunk each."""
    pytest.importorskip("rosbags")
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    text = store.types["std_msgs/msg/String"](data="0" * len(ZEROS))
    writer = Writer(path)
    writer.set_compression(Writer.CompressionFormat.LZ4)
    with writer:
        connection = writer.add_connection("/car", "std_msgs/msg/String", typestore=store)
        for k in range(messages):
            writer.write(connection, k, store.serialize_ros1(text, "std_msgs/msg/String"))
    return path


def bag2(path: Path) -> Path:
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    text = store.types["std_msgs/msg/String"](data="0" * len(ZEROS))
    writer = Writer(path, version=9)
    writer.set_compression(CompressionMode.FILE, CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/car", "std_msgs/msg/String", typestore=store)
        writer.write(connection, 0, store.serialize_cdr(text, "std_msgs/msg/String"))
    return path


def csv(path: Path, rows: int = 60_000) -> Path:
    path.write_bytes(b"t [s],v [m/s]\n" + b"".join(b"%d,1\n" % k for k in range(rows)))
    return path


PACKED: dict[str, Callable[[Path], Path]] = {
    "zstd.mcap": lambda path: mcap(path, 1, len(ZEROS)),
    "lz4.mcap": lambda path: mcap(path, 1, len(ZEROS), "LZ4"),
    "a.mat": lambda path: mat(path, 1, len(ZEROS)),
    "a.mf4": mdf,
    "a.bag": bag1,
    "bag": bag2,
}


def refused(path: Path, budget: Budget | None = None) -> str:
    """What reading says; a single line with the name of the file."""
    with pytest.raises(LogError) as caught:
        read_log(path, budget=budget)
    assert caught.value.code == "log.too_large"
    text = str(caught.value)
    assert "\n" not in text
    assert text.startswith(str(path))
    return text


def outcome(path: Path, budget: Budget) -> str:
    """The code that reading ends with; "read" if it does not fail."""
    try:
        read_log(path, budget=budget)
    except LogError as error:
        return error.code
    return "read"


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", PACKED)
def test_what_unpacks_to_more_than_is_allowed_is_refused(tmp_path: Path, name: str) -> None:
    """4 MiB of zeros in a few kB, and 1 MB allowed. Where more is allowed, it is read, or refused for what it holds."""
    path = PACKED[name](tmp_path / name)
    files = list(path.iterdir()) if path.is_dir() else [path]
    assert sum(file.stat().st_size for file in files) < 200_000
    text = refused(path, Budget(log_bytes=10**6))
    assert re.search(r"allowed: (1 MB|1000000 bytes) \(--max-log-bytes allows more\)$", text)
    assert outcome(path, Budget(log_bytes=1 << 30)) != "log.too_large"


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", [*PACKED, "a.csv"])
def test_a_file_larger_than_is_allowed_is_refused_before_it_is_read(tmp_path: Path, name: str) -> None:
    path = (PACKED | {"a.csv": csv})[name](tmp_path / name)
    assert "allowed: 100 bytes (--max-file-bytes allows more)" in refused(path, Budget(file_bytes=100))


def test_chunks_are_charged_together(tmp_path: Path) -> None:
    """Three chunks of 4 MiB, of which each is allowed and all are not."""
    allowed = Budget(log_bytes=10 * MB)
    assert "unpacks to" in refused(bag1(tmp_path / "a.bag", 3), allowed)
    assert "unpacks to" in refused(mcap(tmp_path / "a.mcap", 3, len(ZEROS)), allowed)


def test_a_log_of_our_own_is_charged_before_its_chunks_are_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    Log({"t": np.arange(1000) * 0.01, "v": np.sin(np.arange(1000))}).save(path)  # 16 kB of numbers
    assert "unpacks to" in refused(path, Budget(log_bytes=1000))


def test_a_mat_is_charged_for_what_it_unpacks_to_and_for_the_numbers_that_come_of_it(tmp_path: Path) -> None:
    """4 MiB of numbers of one byte become 32 MiB of numbers of eight."""
    path = mat(tmp_path / "a.mat", 1, len(ZEROS))
    assert "unpacks to" in refused(path, Budget(log_bytes=4 * MB))
    assert "takes" in refused(path, Budget(log_bytes=31 * MB))


def peak_of(read: Callable[[], object]) -> int:
    """Most bytes that Python and numpy held at once while `read` ran."""
    tracemalloc.start()
    try:
        read()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_an_mcap_of_kilobytes_that_unpacks_to_a_gigabyte_is_refused(tmp_path: Path) -> None:
    """128 messages of 8 MiB. By default 32 MiB may come out of a file as small as that."""
    path = mcap(tmp_path / "bomb.mcap", 128, 8 * MB)
    assert path.stat().st_size < 150_000
    assert peak_of(lambda: refused(path)) < 80 * MB
    with pytest.raises(LogError, match="--max-log-bytes allows more"):
        recover(path, tmp_path / "out.mcap")
    assert not (tmp_path / "out.mcap").exists()


def test_a_mat_of_a_megabyte_that_unpacks_to_gigabytes_is_refused(tmp_path: Path) -> None:
    """30 vectors of 32 MiB of one byte each: 1 GB, which become 8 GB of numbers. 200 times the file are allowed."""
    path = mat(tmp_path / "bomb.mat", 30, 32 * MB)
    assert path.stat().st_size < 1.2 * MB
    assert peak_of(lambda: refused(path)) < 80 * MB


def test_a_csv_of_a_gigabyte_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    with path.open("wb") as file:
        file.write(b"t [s],v [m/s]\n0,1\n")
        file.truncate(10**9)  # sparse: it takes no room on the disk
    assert peak_of(lambda: refused(path)) < MB
    assert "a file of 1 GB, allowed: 537 MB" in refused(path)


def test_a_csv_of_more_rows_than_are_allowed_is_refused_by_its_first_ones(tmp_path: Path) -> None:
    rows = 300_000
    path = csv(tmp_path / "long.csv", rows)
    assert path.stat().st_size > 2 * MB
    assert peak_of(lambda: refused(path, Budget(log_rows=10_000))) < MB
    told = refused(path, Budget(log_rows=rows - 1))
    assert f"rows or more, allowed: {rows - 1} (--max-log-rows allows more)" in told
    assert len(read_log(path, budget=Budget(log_rows=rows)).t) == rows


def test_a_log_of_our_own_keeps_to_the_budget(tmp_path: Path) -> None:
    """A constant column is written as one number: 100,000 rows of it take next to nothing on the disk."""
    rows = 100_000
    path = tmp_path / "log.mcap"
    Log({"t": np.arange(rows) * 0.01, **{f"c{k}": np.zeros(rows) for k in range(20)}}).save(path)
    text = refused(path, Budget(log_bytes=10 * 10**6))
    assert re.search(r"allowed: (10 MB|10000000 bytes) \(--max-log-bytes allows more\)$", text)
    assert "100000 rows or more, allowed: 99999" in refused(path, Budget(log_rows=rows - 1))
    assert len(Log.load(path, Budget(log_bytes=10**9, log_rows=rows)).t) == rows


def test_the_command_names_the_option_and_obeys_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = csv(tmp_path / "long.csv", 5000)
    assert main(["doctor", str(path), "--max-log-rows", "4999"]) != 0
    told = "".join(capsys.readouterr())
    assert "rows or more, allowed: 4999 (--max-log-rows allows more)" in told
    assert "Traceback" not in told
    main(["doctor", str(path), "--max-log-rows", "5000"])
    assert "--max-log-rows" not in "".join(capsys.readouterr())
