"""Mappings that name some fields only: what they name comes from them, the rest as without a mapping."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from drives import drive, write_csv
from mcap.writer import Writer
from mcaps import states, write_json

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log

WHEEL = '[[signal]]\nname = "steer"\nfield = "wheel"\nratio = 16.0\n'


def mapping(folder: Path, text: str) -> Path:
    path = folder / "map.toml"
    path.write_text(text, encoding="utf-8")
    return path


def own_csv(folder: Path) -> Path:
    columns = drive(20.0)
    names = {
        "t": ("time [ms]", 1e3), "v": ("speed [km/h]", 3.6), "yaw_rate": ("yaw_rate [deg/s]", 180 / np.pi),
        "steer": ("wheel [deg]", 16.0 * 180 / np.pi), "x": ("x [m]", 1.0), "y": ("y [m]", 1.0),
    }  # fmt: skip
    renamed = {text: scale * columns[name] for name, (text, scale) in names.items()}
    return write_csv(folder / "own.csv", {**renamed, "soc [%]": 50.0 + columns["t"]}, lambda name: name)


def test_one_entry_keeps_all_other_columns(tmp_path: Path) -> None:
    truth = drive(20.0)
    log = read_log(own_csv(tmp_path), mapping=mapping(tmp_path, WHEEL))
    assert set(log.columns) == {"t", "v", "yaw_rate", "steer", "x", "y", "soc"}
    for name in ("t", "v", "yaw_rate", "steer"):
        assert log[name] == pytest.approx(truth[name], abs=1e-6)
    assert log["soc"][0] == pytest.approx(0.5)
    assert log.meta["import"]["recognised"] == ["x", "y", "v", "yaw_rate", "soc"]


def test_only_what_is_named_is_read_if_the_mapping_says_so(tmp_path: Path) -> None:
    log = read_log(own_csv(tmp_path), mapping=mapping(tmp_path, "[log]\nonly = true\n" + WHEEL))
    assert set(log.columns) == {"t", "steer"}
    assert log.meta["import"]["unmapped"] == ["speed", "yaw_rate", "x", "y", "soc"]


def test_a_named_field_is_not_taken_twice_and_a_usual_name_is_its_signal(tmp_path: Path) -> None:
    text = '[[signal]]\nname = "ground_speed"\nfield = "speed"\nunit = "km/h"\n'
    assert "v" not in read_log(own_csv(tmp_path), mapping=mapping(tmp_path, text)).columns
    log = read_log(own_csv(tmp_path), mapping=mapping(tmp_path, text.replace("ground_speed", "velocity")))
    assert log["v"] == pytest.approx(drive(20.0)["v"], abs=1e-6)


def test_the_doctor_says_what_was_recognised_and_what_was_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = own_csv(tmp_path)
    main(["doctor", str(path), "--map", str(mapping(tmp_path, WHEEL))])
    said = capsys.readouterr().out
    assert "recognised by name and unit: x, y, v, yaw_rate\n" in said
    assert "kept, not known: soc\n" in said
    main(["doctor", str(path), "--map", str(mapping(tmp_path, "[log]\nonly = true\n" + WHEEL))])
    assert "not mapped, left out: speed, yaw_rate, x, y, soc" in capsys.readouterr().out


def test_a_field_without_a_topic_is_found_in_the_topic_that_has_it(tmp_path: Path) -> None:
    rows = [(t, {"gyro": 0.1}) for t in np.arange(0, 8, 0.02).tolist()]
    path = write_json(tmp_path / "a.mcap", {"/car": states(), "/imu": rows})
    text = '[log]\ntime = "receive"\n[[signal]]\nname = "yaw_rate"\nfield = "gyro"\nunit = "rad/s"\n'
    log = read_log(path, mapping=mapping(tmp_path, text))
    assert log["yaw_rate"] == pytest.approx(0.1)
    assert "/car speed" in log.meta["import"]["unmapped"]


def test_a_column_with_the_time_may_have_any_name_but_must_be_said(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("v [m/s],clock [ms]\n" + "".join(f"1,{20 * i}\n" for i in range(50)), encoding="utf-8")
    entry = '[[signal]]\nname = "v"\nfield = "v"\n'
    assert read_log(path, mapping=mapping(tmp_path, '[log]\ntime = "clock"\n' + entry)).t[1] == pytest.approx(0.02)
    with pytest.raises(LogError, match="clock") as error:
        read_log(path, mapping=mapping(tmp_path, entry))
    assert error.value.code == "log.time_missing"


def test_a_signal_named_twice_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="2 times"):
        read_log(own_csv(tmp_path), mapping=mapping(tmp_path, WHEEL + WHEEL))


def test_a_mapping_for_a_log_of_ours_is_told_to_be_idle(tmp_path: Path) -> None:
    t = np.arange(400) * 0.01
    Log({"t": t, "v": 5 + np.sin(t)}).save(tmp_path / "log.mcap")
    log = read_log(tmp_path / "log.mcap", mapping=mapping(tmp_path, WHEEL))
    assert [finding["code"] for finding in log.meta["import"]["findings"]] == ["log.mapping_unused"]


def test_a_topic_without_header_is_put_on_the_clock_of_the_headers(tmp_path: Path) -> None:
    """Headers count from 1970, the recorder from its first message."""
    rows = [(0.1 * k, {"header": {"stamp": {"sec": 1_700_000_000 + k // 10, "nanosec": k % 10 * 100_000_000}},
                       "v": float(k)}) for k in range(100)]  # fmt: skip
    bare = [(0.1 * k, {"w": float(k)}) for k in range(100)]
    file = write_json(tmp_path / "a.mcap", {"/a": rows, "/b": bare})
    entries = ('[[signal]]\nname = "v"\ntopic = "/a"\nfield = "v"\nunit = "m/s"\n'
               '[[signal]]\nname = "yaw_rate"\ntopic = "/b"\nfield = "w"\nunit = "rad/s"\n')  # fmt: skip
    log = read_log(file, mapping=mapping(tmp_path, '[log]\nonly = true\ntime = "header"\n' + entries))
    assert log.duration == pytest.approx(9.9)
    assert log["v"] == pytest.approx(log["yaw_rate"])


def test_one_header_without_a_time_does_not_part_the_clocks(tmp_path: Path) -> None:
    rows = [
        (
            float(k),
            {"v": float(k)} | ({"header": {"stamp": {"sec": 1_700_000_000 + k, "nanosec": 0}}} if k != 5 else {}),
        )
        for k in range(20)
    ]
    bare = [(float(k), {"w": float(k)}) for k in range(20)]
    file = write_json(tmp_path / "a.mcap", {"/a": rows, "/b": bare})
    entries = ('[[signal]]\nname = "v"\ntopic = "/a"\nfield = "v"\nunit = "m/s"\n'
               '[[signal]]\nname = "yaw_rate"\ntopic = "/b"\nfield = "w"\nunit = "rad/s"\n')  # fmt: skip
    log = read_log(file, mapping=mapping(tmp_path, '[log]\nonly = true\ntime = "header"\n' + entries))
    assert log.duration == pytest.approx(19.0)
    both = np.isfinite(log["v"]) & np.isfinite(log["yaw_rate"])
    assert both.sum() >= 19
    assert log["v"][both] == pytest.approx(log["yaw_rate"][both])


def test_a_rate_of_an_angle_has_its_sign(tmp_path: Path) -> None:
    t = np.arange(0.0, 20.0, 0.02)
    heading = np.angle(np.exp(-0.3j * t))  # to the right, past pi
    file = write_csv(tmp_path / "a.csv", {"t [s]": t, "heading [rad]": heading}, lambda name: name)
    entry = '[[signal]]\nname = "yaw_rate"\nfield = "heading"\nunit = "rate of rad"\n'
    rate = read_log(file, mapping=mapping(tmp_path, "[log]\nonly = true\n" + entry))["yaw_rate"]
    assert rate[np.isfinite(rate)] == pytest.approx(-0.3)


def test_rows_without_a_time_are_left_out(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("t [s],speed [m/s]\n0,1\n,2\n0.1,3\n0.2,4\n", encoding="utf-8")
    entry = '[[signal]]\nname = "v"\nfield = "speed"\nunit = "m/s"\n'
    log = read_log(file, mapping=mapping(tmp_path, '[log]\nonly = true\ntime = "t"\n' + entry))
    assert log.t.tolist() == pytest.approx([0.0, 0.1, 0.2])
    assert log["v"].tolist() == [1.0, 3.0, 4.0]


def stamped(ahead: int, name: str) -> list[tuple[float, dict[str, object]]]:
    """Ten messages a second whose header's clock is so many seconds ahead of the recorder's in 1970 + 54 years."""
    return [(0.1 * k, {"header": {"stamp": {"sec": 1_700_000_000 + ahead + k // 10, "nanosec": k % 10 * 100_000_000}},
                       name: float(k)}) for k in range(200)]  # fmt: skip


@pytest.mark.parametrize(("ahead", "said"), [(18, "18 s ahead of"), (-1_699_999_987, "1699999987 s behind")])
def test_topics_with_clocks_that_differ_are_told_with_the_seconds(tmp_path: Path, ahead: int, said: str) -> None:
    file = write_json(tmp_path / "a.mcap", {"/a": stamped(0, "v"), "/b": stamped(ahead, "w")})
    first = '[log]\nonly = true\n[[signal]]\nname = "v"\ntopic = "/a"\nfield = "v"\nunit = "m/s"\n'
    second = '[[signal]]\nname = "yaw_rate"\ntopic = "/b"\nfield = "w"\nunit = "rad/s"\n'
    with pytest.raises(LogError, match=f"log.clock_offset /b: its headers are {said} those of /a") as error:
        read_log(file, mapping=mapping(tmp_path, first + second))
    assert f"delay = {ahead}`" in str(error.value)
    log = read_log(file, mapping=mapping(tmp_path, f"{first}{second}delay = {ahead}\n"))
    assert log["v"] == pytest.approx(log["yaw_rate"])
    assert log.meta["import"]["findings"] == []


def test_a_topic_of_two_channels_is_one(tmp_path: Path) -> None:
    """As a recorder writes that was started again."""
    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        kind = writer.register_schema("their.State", "jsonschema", b"{}")
        for first in (0, 50):
            channel = writer.register_channel("/a", "json", kind, metadata={"from": str(first)})
            for k in range(first, first + 50):
                message = json.dumps({"speed": float(k)}).encode()
                writer.add_message(channel, k * 20_000_000, message, k * 20_000_000)
        writer.finish()
    entry = '[[signal]]\nname = "v"\ntopic = "/a"\nfield = "speed"\nunit = "m/s"\n'
    log = read_log(path, mapping=mapping(tmp_path, '[log]\nonly = true\ntime = "receive"\n' + entry))
    assert log["v"].tolist() == list(range(100))


@pytest.mark.parametrize(("empty", "said"), [("lat", "y: field 'lat'"), ("lon", "x: field 'lon'")])
def test_a_fix_without_a_value_is_one_line(tmp_path: Path, empty: str, said: str) -> None:
    rows = "".join(
        f"{0.1 * k:.1f},{'' if empty == 'lat' else 52.0},{'' if empty == 'lon' else 4.3},1\n" for k in range(9)
    )
    file = tmp_path / "a.csv"
    file.write_text(f"t [s],lat [deg],lon [deg],v [m/s]\n{rows}", encoding="utf-8")
    entries = "".join(f'[[signal]]\nname = "{name}"\nfield = "{field}"\nunit = "{unit}"\n' for name, field, unit in
                      (("y", "lat", "latitude"), ("x", "lon", "longitude")))  # fmt: skip
    with pytest.raises(LogError, match=f"map.toml: {said} holds no value$"):
        read_log(file, mapping=mapping(tmp_path, '[log]\nonly = true\ntime = "t"\n' + entries))
