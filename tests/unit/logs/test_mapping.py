"""Mappings that name some fields only: what they name comes from them, the rest as without a mapping."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drives import drive, write_csv
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
