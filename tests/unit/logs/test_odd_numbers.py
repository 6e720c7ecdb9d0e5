"""Numbers that writers of logs put where nothing was measured, or that no float holds, cost no log and no traceback."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer
from mcaps import write_json
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from pytest_dvp.logs.formats.ros_bag import _plain
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log
from pytest_dvp.logs.stream import Stream, flatten


def mapping(folder: Path, text: str = '[[signal]]\nname = "v"\nfield = "v"\nunit = "m/s"\n') -> Path:
    (folder / "map.toml").write_text(text, encoding="utf-8")
    return folder / "map.toml"


def log_with(folder: Path, odd: Any) -> Log:
    rows = [(0.02 * k, {"v": odd if k == 50 else float(k)}) for k in range(100)]
    return read_log(write_json(folder / "log.mcap", {"/car": rows}), mapping=mapping(folder))


@pytest.mark.parametrize("odd", [float("nan"), 10**400, None], ids=["nan", "huge", "null"])
def test_what_is_no_number_was_not_measured(tmp_path: Path, odd: Any) -> None:
    """NaN as Python's json writes it, and a whole number of 401 digits."""
    log = log_with(tmp_path, odd)
    assert np.flatnonzero(np.isnan(log.columns["v"])).tolist() == [50]
    assert log.meta["import"]["findings"] == []


def test_an_infinite_value_of_a_message_was_not_measured_and_is_told(tmp_path: Path) -> None:
    log = log_with(tmp_path, -float("inf"))
    assert np.flatnonzero(np.isnan(log.columns["v"])).tolist() == [50]
    (told,) = log.meta["import"]["findings"]
    assert (told["code"], told["severity"], told["found"]) == ("value.not_finite", "warning", "-inf")


def test_what_is_no_json_is_still_refused(tmp_path: Path) -> None:
    file = tmp_path / "log.mcap"
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel("/car", "json", writer.register_schema("S", "jsonschema", b"{}"))
        writer.add_message(channel, 0, b'{"v": 1.0', 0)
        writer.finish()
    with pytest.raises(LogError, match="/car: a message is not JSON"):
        read_log(file, mapping=mapping(tmp_path))


def test_an_antenna_without_any_yaw_is_refused_in_one_line(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("t,x,y,yaw\n" + "".join(f"{0.02 * k:.2f},{k},0,\n" for k in range(50)), encoding="utf-8")
    entries = "".join(
        f'[[signal]]\nname = "{name}"\nfield = "{name}"\nunit = "{unit}"\n'
        for name, unit in (("x", "m"), ("y", "m"), ("yaw", "rad"))
    )
    with pytest.raises(LogError, match="an antenna position needs a yaw"):
        read_log(log, mapping=mapping(tmp_path, f"[log]\nantenna = [1.2, 0.0]\n{entries}"))


@pytest.mark.parametrize(("whole", "part"), [("sec", "nanosec"), ("sec", "nsec"), ("secs", "nsecs")])
def test_the_stamps_of_headers_as_bridges_write_them(whole: str, part: str) -> None:
    fields = {f"header.stamp.{whole}": np.array([7.0, 7.0]), f"header.stamp.{part}": np.array([0.0, 5e8])}
    header = Stream("/car", "", np.array([0.0, 0.5]), fields).header
    assert header is not None
    assert header.tolist() == [7.0, 7.5]


@pytest.mark.parametrize(("clock", "kept"), [(1.7e9, 97), (0.0, 100)])
def test_a_stamp_that_was_not_set_is_no_time(tmp_path: Path, clock: float, kept: int) -> None:
    """Before a simulator's first /clock, headers hold 0; a simulator's own clock begins there."""
    rows: list[tuple[float, dict[str, Any]]] = []
    for k in range(100):
        t = clock + 0.02 * k if k > 2 or not clock else 0.0
        stamp = {"sec": int(t), "nanosec": round(t % 1.0 * 1e9)}
        rows.append((1.7e9 + 0.02 * k, {"header": {"stamp": stamp}, "v": float(k)}))
    log = read_log(write_json(tmp_path / "log.mcap", {"/car": rows}), mapping=mapping(tmp_path))
    assert np.diff(log.t) == pytest.approx(np.full(kept - 1, 0.02), abs=2e-6)
    told = [(one["code"], one["element"]) for one in log.meta["import"]["findings"]]
    assert told == ([("log.time_missing", "/car")] if clock else [])


@pytest.mark.parametrize("name", ["timestampSec", "timestamp_sec"])
def test_the_stamp_of_an_apollo_header_is_the_senders(tmp_path: Path, name: str) -> None:
    """The recorder got each message 0.3 s later, and some of them later still."""
    rows = [(0.3 + 0.02 * k + 0.005 * (k % 3), {"header": {name: 1.7e9 + 0.02 * k}, "v": float(k)}) for k in range(100)]
    file = write_json(tmp_path / "log.mcap", {"/apollo/canbus/chassis": rows})
    log = read_log(file, mapping=mapping(tmp_path))
    assert np.diff(log.t) == pytest.approx(np.full(99, 0.02), abs=1e-6)
    assert log.meta["import"]["unmapped"] == []


def test_constants_of_a_message_definition_are_no_fields() -> None:
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("uint8 AUTONOMOUS=1\nuint8 MANUAL=4\nuint8 mode\n", "their_msgs/msg/Mode"))
    assert flatten(_plain(store.types["their_msgs/msg/Mode"](4))) == {"mode": 4.0}
