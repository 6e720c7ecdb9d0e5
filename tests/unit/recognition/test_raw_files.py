"""`dvp map` works out names, units, signs and frames of files that state none of them, and says why."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from raw_files import FILES, WHEELBASE, Columns, RawFile, csv, headless, truth

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.read_log import read_log
from pytest_dvp.logs.stream import Stream
from pytest_dvp.recognition.columns import columns_of
from pytest_dvp.recognition.recognise import recognise
from pytest_dvp.recognition.starting_model import measured_drive, starting_model

CLOSE = 0.12  # of the truth: units are further apart than that; a steering ratio is an estimate


def mapped(tmp_path: Path, file: RawFile, seed: int = 7) -> tuple[Path, Path]:
    log, mapping = tmp_path / file.name, tmp_path / "map.toml"
    file.write(log, truth(seed))
    wheelbase = ["--wheelbase", str(WHEELBASE)] if file.wheelbase else []
    assert main(["map", str(log), "--out", str(mapping), *wheelbase]) == 0
    return log, mapping


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
@pytest.mark.nightly(by_day=4)
def test_units_signs_and_frames_come_out_right(tmp_path: Path, file: RawFile) -> None:
    log = read_log(*mapped(tmp_path, file)[:1], mapping=tmp_path / "map.toml")
    true = truth()
    turned = set()
    for name in file.signals:
        of = {"steer": "steer_cmd", "steer_cmd_norm": "steer_cmd", "speed_cmd": "v"}.get(name, name)
        scale = 1.0 / file.full_steer if name == "steer_cmd_norm" else 1.0
        values = log.columns[name]
        seen = np.isfinite(values)
        if name == "throttle_cmd":
            of, target = "", np.clip(true["accel_cmd"] / 3.0, 0.0, 1.0)
        else:
            target = scale * true[of]
        known = np.interp(log.t[seen] - log.t[0], true["t"], target)
        shown = values[seen]
        if name in ("x", "y", "yaw"):  # from an origin of its own
            known, shown = np.diff(known), np.diff(shown)
        ratio = shown @ known / (known @ known)
        assert abs(ratio) == pytest.approx(1.0, abs=CLOSE), name
        if name in ("y", "yaw", "yaw_rate", "ay", "steer", "steer_cmd", "steer_cmd_norm"):
            turned.add(ratio < 0.0)
    assert turned <= {file.mirrored}


def test_each_line_says_why(tmp_path: Path) -> None:
    file = next(f for f in FILES if f.name == "can_bus.csv")
    text = mapped(tmp_path, file)[1].read_text()
    assert "# left to you: nothing" in text
    for name, words in {"ay": "speed times turn rate", "ax": "dv/dt", "steer": "the hand wheel"}.items():
        entry = next(part for part in text.split("\n\n") if f'name = "{name}"' in part)
        assert entry.startswith("# by the data: ")
        assert words in entry.replace("\n# ", " ")


def test_steering_in_percent_is_a_share_of_the_greatest_angle(tmp_path: Path) -> None:
    """As Apollo's: 100 % are 0.5 rad at the road wheel. A diagnosis fits the scale of the command; that of what was
    measured is the car's own, and waits with an estimate."""
    true = truth()
    log, mapping = tmp_path / "apollo.csv", tmp_path / "map.toml"
    csv(log, {"t": true["t"], "pose.x": true["x"], "pose.y": true["y"], "heading": true["yaw"], "speed_mps": true["v"],
              "chassis.steering_percentage": 200.0 * true["steer_cmd"],
              "control.steering_target [%]": 200.0 * true["steer_cmd"]})  # fmt: skip
    assert main(["map", str(log), "--out", str(mapping), "--wheelbase", str(WHEELBASE)]) == 0
    found = read_log(log, mapping=mapping).columns
    assert found["steer_cmd_norm"] == pytest.approx(2.0 * true["steer_cmd"])
    assert "steer" not in found
    entry = next(part for part in mapping.read_text().split("\n\n") if '# name = "steer"' in part)
    assert float(entry.rpartition("scale = ")[2].split()[0]) == pytest.approx(0.005, rel=CLOSE)


def test_what_a_name_alone_tells_is_left_to_the_user_in_the_file_and_in_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An acceleration that shakes so much that it follows from nothing else."""
    true = truth()
    shaken = 9.0 * np.random.default_rng(7).standard_normal(len(true["t"]))
    columns = [true[name] for name in ("t", "x", "y", "yaw", "v", "yaw_rate")]
    log, mapping = tmp_path / "shaken.csv", tmp_path / "map.toml"
    head = "t,x [m],y [m],yaw [rad],v [m/s],yaw_rate [rad/s],acc x (IMU)"
    np.savetxt(log, np.column_stack([*columns, shaken]), delimiter=",", header=head, comments="", fmt="%.9g")
    assert main(["map", str(log), "--out", str(mapping)]) == 0
    assert "# left to you below: ax\n" in mapping.read_text()
    assert "left to you: ax from 'acc x (IMU)' by its name; it is not read until you decide" in capsys.readouterr().out


def test_what_the_data_cannot_decide_is_left_to_the_user(tmp_path: Path) -> None:
    true = truth()
    log = tmp_path / "few.csv"
    rows = np.column_stack([true["t"], true["v"], true["yaw_rate"]])
    np.savetxt(log, rows, delimiter=",", header="t,v,yaw_rate", comments="", fmt="%.9g")
    mapping = tmp_path / "map.toml"
    assert main(["map", str(log), "--out", str(mapping)]) == 0
    units = [line for line in mapping.read_text().splitlines() if line.startswith("unit")]
    assert all(line.startswith('unit = "?"  # one of ') for line in units)
    with pytest.raises(LogError, match="no unit; add unit = one of m/s, km/h"):
        read_log(log, mapping=mapping)


def test_without_names_and_positions_nothing_is_decided(tmp_path: Path) -> None:
    """Turn rate, lateral acceleration and steering are nearly proportional: which is which, only geometry tells."""
    text = mapped(tmp_path, RawFile("headless.csv", headless, ()))[1].read_text()
    assert "# by the data: " not in text
    assert "its name does not say what it is" in text


def test_the_least_model_drives_by_what_the_log_has(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = next(f for f in FILES if f.name == "foxglove.csv")
    log, mapping = mapped(tmp_path, file)
    model = tmp_path / "car.toml"
    asked = ["--wheelbase", "2.6", "--mass", "1400", "--model", str(model)]
    assert main(["map", str(log), "--out", str(tmp_path / "again.toml"), *asked]) == 0
    assert main(["compare", str(log), "--map", str(mapping), "--model", str(model)]) == 0
    assert "yaw_rate" in capsys.readouterr().out


def turned(path: Path, d: Columns) -> None:
    """The inertial unit looks to the left: its x axis is the car's y axis."""
    csv(path, {"t": d["t"], "x": d["x"], "y": d["y"], "yaw": d["yaw"], "v": d["v"], "yaw_rate": d["yaw_rate"],
                     "imu/ax": d["ay"], "imu/ay": -d["ax"], "delta": d["steer_cmd"], "V": d["v"]})  # fmt: skip


def test_what_an_engineer_must_confirm_is_said_in_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, model = tmp_path / "turned.csv", tmp_path / "car.toml"
    turned(log, truth())
    asked = ["--wheelbase", str(WHEELBASE), "--model", str(model), "--out", str(tmp_path / "map.toml")]
    assert main(["map", str(log), *asked]) == 0
    said = capsys.readouterr()
    assert "imu/ax is taken as ay, because its numbers follow it, although its name says ax: " in said.out
    assert f"next: dvp doctor {log} --map {tmp_path / 'map.toml'} --model {model}\n" in said.err
    mapping = (tmp_path / "map.toml").read_text()
    assert "although its name says ax" in " ".join(mapping.replace("#", "").split())
    told = f"{model} takes the speed from the log; its line `longitudinal` says how to judge the drive, too"
    assert (told in said.out) == ('"speed_cmd"' in model.read_text())


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("v", "speed_cmd"), '"speed_cmd", with [[effect]] name = "speed_controller" below'),
        (("v", "throttle_cmd", "brake_cmd"), '"throttle_cmd + brake_cmd"'), (("v", "accel_cmd", "speed_cmd"), ""),
        (("v",), ""),
    ],
)  # fmt: skip
def test_what_could_drive_the_model_is_named(names: tuple[str, ...], said: str) -> None:
    assert measured_drive(names) == said
    text = starting_model(names, 2.7, None)
    assert (said in text) if said else ("to look at the drive" not in text)


@pytest.mark.parametrize(("option", "text"), [("--wheelbase", "2600"), ("--mass", "heavy"), ("--wheelbase", "nan")])
def test_a_wrong_figure_of_the_car_is_one_line(
    tmp_path: Path, option: str, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log.csv"
    log.write_text("t,v\n0,1\n1,2\n")
    assert main(["map", str(log), option, text]) == 2
    assert f"{option}: found {text!r}, allowed:" in capsys.readouterr().err


def test_the_speed_and_turn_rate_that_were_asked_for_are_not_those_of_the_car() -> None:
    """A planner's twist is smoother, faster and at a higher rate than the odometry."""
    true = truth()
    later = np.minimum(np.arange(len(true["t"])) + 15, len(true["t"]) - 1)  # 0.3 s ahead of the car
    odom = {
        "pose.x": true["x"], "pose.y": true["y"], "pose.yaw": true["yaw"], "twist.linear.x": true["v"],
        "twist.angular.z": true["yaw_rate"],
    }  # fmt: skip
    asked = {"twist.linear.x": 1.1 * true["v"][later], "twist.angular.z": 1.2 * true["yaw_rate"][later]}
    streams = [
        Stream("/cmd_vel", "", true["t"], asked),
        Stream("/odom", "", true["t"][::2], {field: values[::2] for field, values in odom.items()}),
    ]
    found = {one.name: one.column.topic for one in recognise(columns_of(streams, "receive"), WHEELBASE).signals}
    assert found["yaw_rate"] == found["v"] == "/odom"
    assert found["speed_cmd"] == "/cmd_vel"


def test_a_brake_pressure_without_a_unit_is_no_percentage(tmp_path: Path) -> None:
    """Air brakes have 0 to 10 bar, which is a percentage by its size alone."""
    true = truth()
    log, mapping = tmp_path / "bus.csv", tmp_path / "map.toml"
    pressure = np.clip(-true["accel_cmd"], 0.0, None)
    csv(log, {name: true[name] for name in ("t", "x", "y", "yaw", "v", "yaw_rate")} | {"BrakePressure": pressure})
    assert main(["map", str(log), "--out", str(mapping)]) == 0
    text = mapping.read_text()
    assert "brake_cmd" not in text
    assert "# left to you below: brake_pressure\n" in text
    assert '# name = "brake_pressure"' in text
    assert "MPa, kPa or psi: put the unit in" in text.replace("\n# ", " ")


@pytest.mark.parametrize(("noise", "derived"), [(0.0, True), (0.01, False)])
def test_fixes_of_a_fast_car_were_not_integrated_from_its_speed(noise: float, derived: bool) -> None:
    """At 25 to 35 m/s the noise of an RTK fix is less than 0.4 % of the way."""
    t = 0.02 * np.arange(4000)
    v, yaw = 30.0 + 5.0 * np.sin(0.5 * t), 2.0 * np.sin(0.2 * t)
    place = np.cumsum(0.02 * v * np.exp(1j * yaw))
    place = place + noise * (np.random.default_rng(1).standard_normal((2, len(t))).T @ np.array([1.0, 1j]))
    fields = {"x": place.real, "y": place.imag, "v": v, "yaw": yaw}
    stream = Stream("", "", t, fields, {"x": "m", "y": "m", "v": "m/s", "yaw": "rad"})
    remarks = recognise(columns_of([stream], "receive"), WHEELBASE).remarks
    assert any("integrated from it" in remark for remark in remarks) is derived
