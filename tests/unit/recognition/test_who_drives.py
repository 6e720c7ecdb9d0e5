"""A log that is driven by hand in parts still tells its commands, and which of its modes says so."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from raw_files import DEG, WHEELBASE, csv, truth

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.engagement import driven_by_others
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.logs.mapped_modes import obeyed_in
from pytest_dvp.logs.read_log import read_log
from pytest_dvp.logs.stream import Stream
from pytest_dvp.logs.texts import texts_of
from pytest_dvp.recognition.columns import columns_of
from pytest_dvp.recognition.recognise import recognise
from pytest_dvp.recognition.recognised import Recognised
from pytest_dvp.recognition.who_drives import modes_of

TRUE = truth(seconds=100.0)
T = TRUE["t"]
BY_HAND = ((T >= 15.0) & (T < 40.0)) | ((T >= 60.0) & (T < 75.0))
MODE = np.where(BY_HAND, 4.0, 1.0)  # as Autoware counts: autonomous, manual


def asked(while_driven: str) -> dict[str, FloatArray]:
    """What the stack asks for. While somebody else drives it goes on with a plan of its own, or it rests."""
    own = 0.25 * np.sin(0.7 * T) + 0.1 * np.sin(1.7 * T) if while_driven == "plans" else np.zeros(len(T))
    return {
        "lateral.steering_tire_angle": np.where(BY_HAND, own, TRUE["steer_cmd"]),
        "longitudinal.acceleration": np.where(BY_HAND, 3.0 * own, TRUE["accel_cmd"]),
    }


def streams(mode: Stream, while_driven: str = "plans") -> list[Stream]:
    car = {"position.x": TRUE["x"], "position.y": TRUE["y"], "heading": TRUE["yaw"], "speed": TRUE["v"],
           "yaw_rate": TRUE["yaw_rate"]}  # fmt: skip
    return [Stream("/car", "", T, car), Stream("/control/command/control_cmd", "", T, asked(while_driven)), mode]


def found(of: list[Stream]) -> dict[str, Recognised]:
    return {one.name: one for one in recognise(columns_of(of, "receive"), WHEELBASE, modes_of(of, "receive")).signals}


@pytest.mark.parametrize("while_driven", ["plans", "rests"])
def test_the_commands_and_the_mode_in_which_they_are_obeyed(while_driven: str) -> None:
    signals = found(streams(Stream("/control_mode", "", T[::10], {"mode": MODE[::10]}), while_driven))
    assert (signals["steer_cmd"].unit, signals["steer_cmd"].decided, signals["steer_cmd"].sign) == ("rad", True, 1.0)
    assert (signals["accel_cmd"].unit, signals["accel_cmd"].decided) == ("m/s^2", True)
    engaged = signals["engaged"]
    assert (engaged.signal.topic, engaged.signal.field, engaged.signal.when) == ("/control_mode", "mode", (1.0,))
    assert engaged.evidence[0].startswith("with 1 the car follows lateral.steering_tire_angle")


def test_a_mode_that_is_sent_when_it_changes_only() -> None:
    changes = np.concatenate([[0], np.flatnonzero(np.diff(MODE)) + 1])
    assert len(changes) == 5
    signals = found(streams(Stream("/engage", "", T[changes], {"data": 1.0 * (MODE[changes] == 1.0)})))
    assert signals["engaged"].when == (1.0,)


def test_a_mode_of_the_steering_beside_one_of_the_pedals_is_obeyed_where_both_are() -> None:
    """As openpilot's latActive and longActive: from 15 to 40 s a hand steers, from 60 to 80 s a foot drives along."""
    foot, hand = (T >= 60.0) & (T < 80.0), (T >= 15.0) & (T < 40.0)
    own = 0.25 * np.sin(0.7 * T) + 0.1 * np.sin(1.7 * T)
    of = streams(Stream("carControl", "", T, {"latActive": 1.0 * ~hand, "longActive": 1.0 * ~foot}))
    of[1] = Stream("/control", "", T, {
        "steering_angle": np.where(hand, own, TRUE["steer_cmd"]), "accel": np.where(foot, 3.0 * own, TRUE["accel_cmd"]),
    })  # fmt: skip
    engaged = found(of)["engaged"]
    assert (engaged.signal.topic, engaged.signal.field) == ("carControl", "latActive + longActive")
    assert engaged.when == (1.0,)
    obeyed = obeyed_in(of[2], engaged.signal.field, engaged.when, "map")
    assert np.array_equal(obeyed == 1.0, ~foot & ~hand)


def test_a_mode_in_words() -> None:
    words = texts_of("COMPLETE_MANUAL" if hand else "COMPLETE_AUTO_DRIVE" for hand in BY_HAND)
    assert words is not None
    signals = found(streams(Stream("/chassis", "", T, {}, texts={"drivingMode": words})))
    assert signals["engaged"].when == ("COMPLETE_AUTO_DRIVE",)


def test_a_mode_that_changes_while_the_car_obeys_says_nothing() -> None:
    obedient = streams(Stream("/mode", "", T, {"mode": MODE}))
    obedient[1].fields.update({
        "lateral.steering_tire_angle": TRUE["steer_cmd"], "longitudinal.acceleration": TRUE["accel_cmd"],
    })  # fmt: skip
    signals = found(obedient)
    assert "engaged" not in signals
    assert signals["steer_cmd"].decided


def test_a_mode_with_too_little_driving_is_not_told_and_counts_as_not_obeyed() -> None:
    mode = MODE.copy()
    mode[(T >= 80.0) & (T < 83.0)] = 2.0
    signals = found(streams(Stream("/control_mode", "", T, {"mode": mode})))
    assert signals["engaged"].when == (1.0,)
    assert signals["engaged"].evidence[1] == "2 cannot be told and counts as not obeyed"


@pytest.mark.parametrize("words", [False, True])
def test_the_file_of_a_mapping_takes_the_mode(tmp_path: Path, words: bool, capsys: pytest.CaptureFixture[str]) -> None:
    log, mapping = tmp_path / "log.csv", tmp_path / "map.toml"
    command = asked("plans")["lateral.steering_tire_angle"] * DEG
    csv(log, {"t": T, "x": TRUE["x"], "y": TRUE["y"], "heading": TRUE["yaw"] * DEG, "speed": TRUE["v"],
              "steering_cmd": command, "driving_mode": MODE})  # fmt: skip
    if words:
        text = "\n".join(
            row[: row.rfind(",")] + (",MANUAL" if row.endswith(",4") else ",AUTO") if row[0].isdigit() else row
            for row in log.read_text().splitlines()
        )
        log.write_text(text + "\n")
    assert main(["map", str(log), "--wheelbase", str(WHEELBASE), "--out", str(mapping)]) == 0
    assert "left to you: engaged" not in capsys.readouterr().out
    read = read_log(log, mapping=mapping)
    assert np.array_equal(driven_by_others(read), BY_HAND)
    rows = ~BY_HAND
    assert read.columns["steer_cmd"][rows] == pytest.approx(TRUE["steer_cmd"][rows], abs=1e-6)


def test_a_mode_that_the_data_do_not_tell_is_left_to_the_user(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, mapping = tmp_path / "log.csv", tmp_path / "map.toml"
    csv(log, {"t": T, "x": TRUE["x"], "y": TRUE["y"], "heading": TRUE["yaw"], "speed": TRUE["v"], "mode": MODE})
    assert main(["map", str(log), "--out", str(mapping)]) == 0
    assert "left to you: engaged from 'mode' by its name" in capsys.readouterr().out
    assert "# left to you below: engaged" in mapping.read_text()
    assert main(["map", str(log), "--json"]) == 0
    signals = {one["name"]: one for one in json.loads(capsys.readouterr().out)["signals"]}
    assert (signals["engaged"]["field"], signals["engaged"]["certain"]) == ("mode", False)
