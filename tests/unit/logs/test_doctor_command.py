"""dvp doctor on the command line: exit codes, one JSON document, part of a log."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from drives import UNITS, drive, scaled, without, write_csv

from pytest_dvp.cli.command_line import main
from pytest_dvp.doctor import read_checked_log
from pytest_dvp.logs.log_error import LogError


def test_a_sound_log_is_answered_with_0(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", str(write_csv(tmp_path / "a.csv", drive(30.0)))]) == 0
    out = capsys.readouterr()
    assert "nothing wrong found" in out.out
    assert "steer_delay" in out.out
    assert "0 errors, 0 warnings" in out.err


def test_an_error_is_answered_with_1_and_json_holds_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_csv(tmp_path / "a.csv", scaled(drive(30.0), 3.6, "v"))
    assert main(["doctor", "--json", str(path)]) == 1
    (entry,) = json.loads(capsys.readouterr().out)["logs"]
    (finding,) = entry["findings"]
    assert (finding["code"], finding["severity"], finding["file"]) == ("log.unit_suspect", "error", str(path))
    assert "v [km/h]" in finding["message"]
    assert entry["excitation"]["facts"]["duration"] == {"value": 29.98, "unit": "s"}


def test_a_file_that_cannot_be_read_is_a_finding_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,v\n0,1\n", encoding="utf-8")
    assert main(["doctor", "--json", str(path)]) == 1
    (entry,) = json.loads(capsys.readouterr().out)["logs"]
    assert [f["code"] for f in entry["findings"]] == ["log.unit_missing", "log.unit_missing"]


def test_a_line_that_cannot_be_read_is_named_with_its_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t [s],v [m/s]\n0,1\n0.1,abc\n", encoding="utf-8")
    assert main(["doctor", str(path)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{path}: cannot be read"
    assert lines[1].startswith("  error value.not_a_number line 3 column v: ")


def test_only_the_named_part_is_examined(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = drive(60.0)
    v = np.where(columns["t"] < 30.0, columns["v"], 3.6 * columns["v"])
    path = write_csv(tmp_path / "a.csv", {**columns, "v": v})
    assert main(["doctor", f"{path}@30:"]) == 1
    assert main(["doctor", f"{path}@0:30"]) == 0
    capsys.readouterr()


@pytest.mark.parametrize(
    "words", [["absent.csv"], ["absent.csv@0:3"], ["{log}", "--map", "no.toml"], ["{log}", "--msg", "no"]]
)
def test_a_missing_argument_file_is_answered_with_2(
    tmp_path: Path, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_csv(tmp_path / "a.csv", drive(10.0))
    assert main(["doctor", *(word.format(log=path) for word in words)]) == 2
    assert capsys.readouterr().out == ""


def test_a_vehicle_model_driven_by_the_measured_speed_leaves_the_drive_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_csv(tmp_path / "a.csv", drive(30.0))
    model = tmp_path / "m.toml"
    model.write_text(
        '[model]\nbase = "kinematic_bicycle"\n[inputs]\nsteer = "steer_cmd"\nlongitudinal = "v"\n'
        "[parameters]\nwheelbase = 2.7\n",
        encoding="utf-8",
    )
    assert main(["doctor", "--json", str(path), "--model", str(model)]) == 0
    shown = json.loads(capsys.readouterr().out)["logs"][0]["excitation"]
    assert "drive_delay" in shown["out_of_reach"]
    assert "steer_delay" in shown["within_reach"]


def test_read_sound_refuses_what_a_model_would_be_bent_to_explain(tmp_path: Path) -> None:
    with pytest.raises(LogError) as error:
        read_checked_log(write_csv(tmp_path / "a.csv", scaled(drive(30.0), 3.6, "v")))
    assert error.value.code == "log.unit_suspect"
    log, findings = read_checked_log(write_csv(tmp_path / "b.csv", drive(30.0)))
    assert len(log.t) == 1500
    assert findings == ()


def test_a_folder_check_looks_at_logs_and_leaves_other_tables_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_csv(tmp_path / "a.csv", scaled(drive(30.0), 3.6, "v"))
    (tmp_path / "prices.csv").write_text("item,price\napple,1\n", encoding="utf-8")
    assert main(["check", "--json", str(tmp_path)]) == 1
    findings = json.loads(capsys.readouterr().out)["findings"]
    assert [Path(f["file"]).name for f in findings] == ["a.csv"]


OWN = """from vehicle.model.effect import Key, effect


@effect(
    name="magnet", slot="{slot}",
    physics="a magnet at the end of the road pulls the car", equation="a = c", source="a notebook",
    parameters=(Key("c", "m/s^2", low=0.1, high=1.0, neutral=0.0, least=0.05, meaning="pull"),),
    reveals="stand still with released brake",
)
def magnet(x, p, m):
    x.drag += p.c * x.mass
"""
MODEL = (
    '[model]\nbase = "kinematic_bicycle"\n[inputs]\nsteer = "steer_cmd"\nlongitudinal = "accel_cmd"\n'
    '[parameters]\nwheelbase = 2.7\n[[effect]]\nname = "magnet"\n[effect.parameters.c]\nvalue = 0.5\nunit = "m/s^2"\n'
)


def test_a_model_with_an_effect_of_ones_own_needs_its_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = write_csv(tmp_path / "a.csv", drive(30.0))
    (tmp_path / "my_effect.py").write_text(OWN.format(slot="force"), encoding="utf-8")
    (tmp_path / "m.toml").write_text(MODEL, encoding="utf-8")
    own = ["--effects", str(tmp_path / "my_effect.py")]
    assert main(["check", str(tmp_path / "m.toml")]) == 1
    assert "magnet" in capsys.readouterr().out
    assert main(["check", str(tmp_path / "m.toml"), *own]) == 0
    assert main(["doctor", str(log), "--model", str(tmp_path / "m.toml")]) == 1
    capsys.readouterr()
    assert main(["doctor", str(log), "--model", str(tmp_path / "m.toml"), "--json", *own]) == 0
    assert "magnet" in json.loads(capsys.readouterr().out)["logs"][0]["excitation"]["within_reach"]


def test_an_effect_of_ones_own_is_judged_by_its_slot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "my_effect.py").write_text(OWN.format(slot="command"), encoding="utf-8")
    log = write_csv(tmp_path / "a.csv", without(drive(30.0), "steer_cmd", "accel_cmd"))
    assert main(["doctor", str(log), "--json", "--effects", str(tmp_path / "my_effect.py")]) == 0
    assert "steer_cmd" in json.loads(capsys.readouterr().out)["logs"][0]["excitation"]["out_of_reach"]["magnet"]


def test_advice_speaks_of_the_columns_own_header(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = scaled(drive(60.0), 16.0 * 180.0 / np.pi, "steer")
    headers = {"steer": "wheel_angle [deg]", "yaw_rate": "yawrate [deg/s]"}  # yaw rate in rad/s

    def header(name: str) -> str:
        return headers.get(name, f"{name} [{UNITS[name]}]")

    assert main(["doctor", str(write_csv(tmp_path / "a.csv", columns, header))]) == 1
    gyro, wheel = [line for line in capsys.readouterr().out.splitlines() if "log.implausible_range" in line]
    assert "column yaw_rate: radians stored as degrees" in gyro
    assert "write `yawrate [rad/s]`" in gyro
    assert "column steer: the hand wheel's angle for the road wheel's" in wheel
    assert "`ratio = 16`" in wheel
    assert "[deg]" not in wheel


def test_what_drives_the_model_and_is_not_there_is_told_with_what_could_instead(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = str(write_csv(tmp_path / "a.csv", without(drive(30.0), "steer_cmd", "accel_cmd")))
    model = tmp_path / "car.toml"
    model.write_text('[inputs]\nsteer = "steer_cmd"\nlongitudinal = "accel_cmd"\n[parameters]\nwheelbase = 2.5\n')
    assert main(["doctor", log, "--model", str(model)]) == 0
    assert "cannot drive the model: has no steer_cmd and no accel_cmd" in capsys.readouterr().out
    assert main(["compare", log, "--model", str(model)]) == 1
    told = capsys.readouterr().err
    assert told.startswith("car.toml: is driven by 'steer_cmd', which a.csv does not have; nearest of its ")
    assert 'can drive the model instead: [inputs] steer = "steer"' in told


def test_a_column_that_drives_the_model_is_not_one_that_is_not_known(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = write_csv(tmp_path / "a.csv", drive(30.0))
    log.write_text(log.read_text().replace("steer_cmd [rad]", "wheel_request [rad]", 1))
    model = tmp_path / "car.toml"
    inputs = '[inputs]\nsteer = "{}"\nlongitudinal = "accel_cmd"\n[parameters]\nwheelbase = 2.5\n'
    model.write_text(inputs.format("wheel_request"))
    assert main(["doctor", str(log), "--model", str(model)]) == 0
    told = capsys.readouterr().out
    assert "drives the model: wheel_request, accel_cmd\n" in told
    assert "kept, not known" not in told
    assert main(["doctor", str(log)]) == 0
    told = capsys.readouterr().out
    assert "kept, not known: wheel_request\n" in told
    assert "drives the model" not in told
    model.write_text(inputs.format("steer_cmd"))
    assert main(["doctor", str(log), "--model", str(model)]) == 0
    assert "drives the model" not in capsys.readouterr().out
