"""MCAP of others through a mapping, and damaged files: what is whole is read, what is lost is said."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import CompressionType
from mcaps import states, write_json

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log

MAPPING = """
[log]
time = "receive"
[[signal]]
name = "v"
topic = "/car"
field = "speed"
unit = "km/h"
[[signal]]
name = "x"
topic = "/car"
field = "pose.x"
unit = "m"
"""


def mapping(folder: Path, text: str = MAPPING) -> Path:
    path = folder / "map.toml"
    path.write_text(text, encoding="utf-8")
    return path


def codes(log: Log) -> list[str]:
    return [finding["code"] for finding in log.meta["import"]["findings"]]


@pytest.mark.parametrize("compression", list(CompressionType))
def test_a_mapping_makes_signals_of_fields(tmp_path: Path, compression: CompressionType) -> None:
    path = write_json(tmp_path / "a.mcap", {"/car": states()}, compression=compression)
    log = read_log(path, mapping=mapping(tmp_path))
    assert list(log.columns) == ["t", "v", "x"]
    assert log["v"][0] == pytest.approx(10.0)
    assert log["x"][100] == pytest.approx(20.0)
    assert log.t[100] == pytest.approx(2.0)


def test_a_foreign_file_without_units_asks_for_a_mapping(tmp_path: Path) -> None:
    path = write_json(tmp_path / "a.mcap", {"/car": states()})
    with pytest.raises(LogError, match="dvp map") as error:
        read_log(path)
    assert error.value.code == "log.mapping_needed"


def test_a_schema_that_states_units_needs_no_mapping(tmp_path: Path) -> None:
    properties = {"speed": {"type": "number", "unit": "km/h"}, "x": {"type": "number", "description": "[m] east"}}
    rows = [(t, {"speed": 36.0, "x": 10.0 * t}) for t in np.arange(0, 4, 0.02).tolist()]
    log = read_log(write_json(tmp_path / "a.mcap", {"/car": rows}, properties=properties))
    assert log["v"][0] == pytest.approx(10.0)


def test_a_slower_channel_is_not_measured_between_its_samples_and_a_command_holds(tmp_path: Path) -> None:
    fast = [(t, {"v": 5.0}) for t in np.arange(0, 2, 0.02).tolist()]
    slow = [(t, {"r": 0.1}) for t in np.arange(0, 2, 0.1).tolist()]
    command = [(t, {"a": 1.0 + t}) for t in np.arange(0, 2, 0.1).tolist()]
    path = write_json(tmp_path / "a.mcap", {"/v": fast, "/r": slow, "/c": command})
    text = '[log]\ntime = "receive"\n' + "".join(
        f'[[signal]]\nname = "{name}"\ntopic = "{topic}"\nfield = "{field}"\nunit = "{unit}"\n'
        for name, topic, field, unit in (
            ("v", "/v", "v", "m/s"), ("yaw_rate", "/r", "r", "rad/s"), ("accel_cmd", "/c", "a", "m/s^2"),
        )
    )  # fmt: skip
    log = read_log(path, mapping=mapping(tmp_path, text))
    assert np.count_nonzero(np.isfinite(log["yaw_rate"])) == 20
    assert log["accel_cmd"][:6] == pytest.approx([1.0, 1.0, 1.0, 1.0, 1.0, 1.1])


def test_sign_scale_ratio_delay_and_antenna_are_applied(tmp_path: Path) -> None:
    t = np.arange(0, 4, 0.02).tolist()
    rows = [(s, {"hand_wheel": -160.0, "east": 3.0, "north": 10.0 * s, "course": 0.0}) for s in t]
    path = write_json(tmp_path / "a.mcap", {"/car": rows})
    text = """
[log]
time = "receive"
antenna = [1.0, 0.5]
[[signal]]
name = "steer"
field = "hand_wheel"
unit = "deg"
sign = -1
ratio = 16
[[signal]]
name = "yaw"
field = "course"
unit = "deg"
frame = "ned"
[[signal]]
name = "x"
field = "east"
unit = "m"
[[signal]]
name = "y"
field = "north"
unit = "m"
delay = 0.1
"""
    log = read_log(path, mapping=mapping(tmp_path, text))
    seen = np.isfinite(log["steer"])
    assert log["steer"][seen] == pytest.approx(np.radians(10.0))
    assert log["yaw"][seen] == pytest.approx(np.pi / 2)  # north is y
    assert log["x"][seen] == pytest.approx(3.0 + 0.5)  # antenna 0.5 m to the left: west of a car that heads north
    at = np.isfinite(log["y"])
    assert log["y"][at] == pytest.approx(10.0 * (log.t[at] + 0.1) - 1.0)


def test_latitude_and_longitude_become_metres(tmp_path: Path) -> None:
    # One minute of latitude is 1855.3 m at 52 degrees, one of longitude 1144.3 m (WGS 84).
    rows = [(s, {"lat": 52.0 + s / 60.0, "lon": 4.0 + s / 60.0}) for s in np.arange(0, 1.01, 0.02).tolist()]
    path = write_json(tmp_path / "a.mcap", {"/fix": rows})
    text = """
[log]
time = "receive"
origin = [52.0, 4.0]
[[signal]]
name = "x"
field = "lon"
unit = "longitude"
[[signal]]
name = "y"
field = "lat"
unit = "latitude"
"""
    log = read_log(path, mapping=mapping(tmp_path, text))
    assert log["x"][-1] == pytest.approx(1144.3, abs=0.5)
    assert log["y"][-1] == pytest.approx(1854.5, abs=1.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[[signal]]\nname = "v"\nfeild = "speed"\n', "did you mean 'field'"),
        ('[[signal]]\nname = "v"\ntopic = "/cat"\nfield = "speed"\nunit = "m/s"\n', "/car"),
        ('[[signal]]\nname = "v"\nfield = "sped"\nunit = "m/s"\n', "did you mean 'speed'"),
        ('[[signal]]\nname = "v"\nfield = "speed"\nunit = "rad"\n', "km/h"),
        ('[[signal]]\nname = "v"\nfield = "speed"\n', "no unit"),
        ('[[signal]]\nname = "v"\nfield = "speed"\nunit = "m/s"\nratio = 0\n', "not 0"),
        ('[[signal]]\nname = "v"\nscale = "2"\n', "a number"),
        ("[log]\n", r"no \[\[signal\]\]"),
        ("nonsense", "not TOML"),
    ],
)
def test_a_wrong_mapping_is_told(tmp_path: Path, text: str, said: str) -> None:
    path = write_json(tmp_path / "a.mcap", {"/car": states()})
    with pytest.raises(LogError, match=said):
        read_log(path, mapping=mapping(tmp_path, text))


def test_the_proposed_mapping_reads_once_its_units_are_filled_in(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_json(tmp_path / "a.mcap", {"/car": states()})
    assert main(["map", str(path)]) == 0
    text = capsys.readouterr().out
    assert "0 to 79.8" in text  # what was seen in the field x
    keys = ("# [[signal", "# name", "# topic", "# field", "# unit")
    lines = [line.removeprefix("# ") if line.startswith(keys) else line for line in text.split("\n")]
    units = {"x": "m", "y": "m", "v": "km/h"}
    name, out = "", []
    for line in lines:
        name = line.split('"')[1] if line.startswith("name") else name
        out.append(f'unit = "{units[name]}"' if line.startswith("unit") else line)
    log = read_log(path, mapping=mapping(tmp_path, "\n".join(out)))
    assert log["v"][0] == pytest.approx(10.0)


def test_a_hand_wheel_is_proposed_with_its_ratio_to_fill_in(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [(0.02 * i, {"hand_wheel_angle": 90.0}) for i in range(100)]
    assert main(["map", str(write_json(tmp_path / "a.mcap", {"/car": rows}))]) == 0
    text = capsys.readouterr().out
    assert '# name = "steer"' in text
    assert "# ratio = " in text


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9, 0.999])
def test_a_cut_file_yields_every_whole_chunk_and_says_what_is_missing(tmp_path: Path, share: float) -> None:
    path = write_json(tmp_path / "a.mcap", {"/car": states()})
    whole = len(read_log(path, mapping=mapping(tmp_path)).t)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    log = read_log(path, mapping=mapping(tmp_path))
    assert codes(log) == ["log.truncated"]
    assert len(log.t) <= whole
    assert np.allclose(log["v"], (36.0 + log.t) / 3.6)
    assert "messages over" in log.meta["import"]["findings"][0]["text"]


def test_a_flipped_bit_in_a_chunk_loses_that_chunk_and_says_how_much(tmp_path: Path) -> None:
    path = write_json(tmp_path / "a.mcap", {"/car": states()}, compression=CompressionType.NONE)
    whole = len(read_log(path, mapping=mapping(tmp_path)).t)
    data = bytearray(path.read_bytes())
    data[data.index(b'"speed": 38') + 9] ^= 1  # 38 km/h turn into 28
    path.write_bytes(bytes(data))
    log = read_log(path, mapping=mapping(tmp_path))
    (finding,) = log.meta["import"]["findings"]
    assert finding["code"] == "log.corrupt"
    assert f"{whole - len(log.t)} messages" in finding["text"]


def test_no_flipped_bit_is_silent(tmp_path: Path) -> None:
    path = write_json(tmp_path / "a.mcap", {"/car": states(2.0)})
    reference = read_log(path, mapping=mapping(tmp_path))
    data = path.read_bytes()
    rng = np.random.default_rng(5)
    for position in rng.integers(8, len(data) - 8, 300).tolist():
        spoilt = bytearray(data)
        spoilt[position] ^= 1 << int(rng.integers(8))
        path.write_bytes(bytes(spoilt))
        try:
            log = read_log(path, mapping=mapping(tmp_path))
        except LogError:
            continue
        same = len(log.t) == len(reference.t) and all(np.array_equal(log[n], reference[n]) for n in reference.columns)
        assert same or codes(log), position


def test_a_log_of_ours_that_was_cut_is_recovered_and_told_in_seconds(tmp_path: Path) -> None:
    rows = 60_000
    t = np.arange(rows) * 0.01
    rng = np.random.default_rng(0)
    path = tmp_path / "log.mcap"
    Log({"t": t, "v": rng.normal(size=rows), "steer_cmd": np.round(t)}, meta={"seed": 7}).save(path)
    data = path.read_bytes()
    path.write_bytes(data[: int(0.7 * len(data))])
    log = read_log(path)
    assert 0.4 * rows < len(log.t) < 0.7 * rows
    assert np.array_equal(log.t, t[: len(log.t)])
    assert log.meta["seed"] == 7
    told = [finding["text"] for finding in log.meta["import"]["findings"]]
    assert any(f"{rows - len(log.t)} rows, about {0.01 * (rows - len(log.t)):.2f} s, are lost" in text for text in told)


def test_a_record_longer_than_the_file_is_refused_without_room_for_it(tmp_path: Path) -> None:
    path = write_json(tmp_path / "a.mcap", {"/car": states(1.0)})
    data = bytearray(path.read_bytes())
    struct.pack_into("<Q", data, 9, 2**63 - 1)
    path.write_bytes(bytes(data))
    with pytest.raises(LogError) as error:
        read_log(path)
    assert error.value.code == "log.record_too_long"
    assert error.value.findings[0].element == "Header"
