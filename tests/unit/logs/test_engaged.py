"""Who drives: what the car did not obey is no command of it, and a command that rests while the car steers is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drives import Columns, drive, write_csv

from pytest_dvp.doctor import comparable, examine, read_checked_log
from pytest_dvp.gap.compare.compared_model import CompareError, command_at_stamps
from pytest_dvp.logs.engagement import driven_by_others
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_error import LogError
from pytest_dvp.logs.mapping import MappingFile, SignalMap, mapping_rows
from pytest_dvp.logs.read_log import read_log
from tests.truth.generate import make_log

COMMANDS = ("steer_cmd", "accel_cmd")


@pytest.fixture
def by_hand() -> Columns:
    """From 20 to 35 s somebody else drives and the stack stands by."""
    columns = drive(60.0)
    hands = (columns["t"] >= 20.0) & (columns["t"] < 35.0)
    for name in COMMANDS:
        columns[name][hands] = 0.0
    return {**columns, "engaged": np.where(hands, 0.0, 1.0)}


def test_commands_that_were_not_obeyed_are_not_known_and_the_motion_is(by_hand: Columns) -> None:
    found = comparable(Log(columns=by_hand)).columns
    hands = by_hand["engaged"] == 0.0
    for name in COMMANDS:
        assert np.array_equal(np.isnan(found[name]), hands)
        assert np.array_equal(found[name][~hands], by_hand[name][~hands])
    assert np.array_equal(found["v"], by_hand["v"])


def test_a_state_holds_until_the_next_and_before_the_first_one_nobody_is_known_to_obey() -> None:
    engaged = np.array([np.nan, 1.0, np.nan, 0.0, np.nan, np.nan, 1.0])
    log = Log(columns={"t": np.arange(7.0), "engaged": engaged})
    assert driven_by_others(log).tolist() == [True, False, False, True, True, True, False]
    assert not driven_by_others(Log(columns={"t": np.arange(7.0)})).any()


def test_the_doctor_says_for_how_long(by_hand: Columns) -> None:
    (told,) = examine(Log(columns=by_hand))
    assert (told.code, told.severity) == ("log.not_engaged", "warning")
    assert "for 25 % of the log, longest from t = 20 to 34.98 s" in told.message


def test_the_share_is_one_of_time_and_not_of_rows(by_hand: Columns) -> None:
    """Three rows of four are missing while the stack drives, as where a recorder writes less then."""
    few = (by_hand["engaged"] == 0.0) | (np.arange(len(by_hand["t"])) % 4 == 0)
    log = Log(columns={name: values[few] for name, values in by_hand.items()})
    (told,) = [each for each in examine(log) if each.code == "log.not_engaged"]
    assert "for 25 % of the log" in told.message


@pytest.mark.parametrize("name", ["steer_cmd", "steer_cmd_norm"])
def test_without_the_column_the_resting_command_is_told(by_hand: Columns, name: str) -> None:
    del by_hand["engaged"]
    by_hand[name] = by_hand.pop("steer_cmd")
    (told,) = [each for each in examine(Log(columns=by_hand)) if each.code == "log.resting_command"]
    assert f"{name} stays at 0 from t = 20" in told.message


def test_a_log_of_a_driver_alone_or_without_a_command_has_no_resting_command(by_hand: Columns) -> None:
    alone = {**by_hand, "engaged": np.zeros(len(by_hand["t"]))}
    assert [each.code for each in examine(Log(columns=alone))] == ["log.not_engaged"]
    columns = drive(60.0)
    columns["steer_cmd"][:] = np.nan
    assert [each.code for each in examine(Log(columns=columns))] == ["log.empty_column"]


@pytest.mark.parametrize("emptied", [True, False])
def test_a_command_that_is_the_same_before_and_after_a_driver_does_not_rest_meanwhile(
    by_hand: Columns, emptied: bool
) -> None:
    t, hands = by_hand["t"], by_hand["engaged"] == 0.0
    by_hand["steer_cmd"][(t >= 18.0) & (t < 37.0)] = 0.0  # handed over, and back, on a straight road
    if emptied:
        del by_hand["engaged"]
        for name in COMMANDS:
            by_hand[name][hands] = np.nan
    assert "log.resting_command" not in [each.code for each in examine(Log(columns=by_hand))]


@pytest.mark.parametrize("noise", [0.1, 0.3])
def test_noise_of_positions_is_no_bend(noise: float) -> None:
    """A straight test at 3 m/s with GNSS alone: neither a yaw rate nor a heading."""
    t, rng = np.arange(0.0, 60.0, 0.1), np.random.default_rng(3)
    zeros = np.zeros(len(t))
    columns = {
        "t": t, "x": 3.0 * t + rng.normal(0.0, noise, len(t)), "y": rng.normal(0.0, noise, len(t)),
        "v": 3.0 + rng.normal(0.0, 0.03, len(t)), "steer_cmd": zeros, "accel_cmd": zeros,
    }  # fmt: skip
    assert not examine(Log(columns=columns))


@pytest.mark.parametrize("seed", range(3))
def test_noise_of_a_heading_of_a_slow_car_is_no_bend_and_a_bend_is_one_all_the_same(seed: int) -> None:
    """2 degrees of noise at 10 Hz and 2.05 m/s, without a yaw rate; then somebody drives bends of 8 m to both sides."""
    t, rng = np.arange(0.0, 60.0, 0.1), np.random.default_rng(seed)
    for curvature in (np.zeros(len(t)), np.where(np.sin(0.5 * t) > 0.0, 0.125, -0.125)):
        yaw = np.cumsum(2.05 * curvature) * 0.1
        columns = {
            "t": t, "x": np.cumsum(np.cos(yaw)) * 0.205, "y": np.cumsum(np.sin(yaw)) * 0.205,
            "yaw": yaw + rng.normal(0.0, 0.035, len(t)), "v": 2.05 + rng.normal(0.0, 0.03, len(t)),
            "steer_cmd": np.zeros(len(t)), "accel_cmd": np.zeros(len(t)),
        }  # fmt: skip
        told = "log.resting_command" in [each.code for each in examine(Log(columns=columns))]
        assert told == bool(curvature.any())


def test_a_mode_that_is_stated_where_it_changes_lacks_nothing(by_hand: Columns) -> None:
    t, engaged = by_hand["t"], by_hand["engaged"]
    by_hand["engaged"] = np.where(np.concatenate([[True], np.diff(engaged) != 0.0]), engaged, np.nan)
    assert np.count_nonzero(np.isfinite(by_hand["engaged"])) == 3
    assert np.array_equal(driven_by_others(Log(columns=by_hand)), (t >= 20.0) & (t < 35.0))
    assert [each.code for each in examine(Log(columns=by_hand))] == ["log.not_engaged"]


@pytest.mark.parametrize("rate", [10.0, 50.0])
@pytest.mark.parametrize("seed", range(5))
def test_a_car_that_obeys_has_no_resting_command(seed: int, rate: float) -> None:
    columns = drive(60.0, seed=seed, rate=rate)
    columns["steer_cmd"] = np.round(columns["steer_cmd"], 2)  # a coarse command rests often
    assert not [each for each in examine(Log(columns=columns)) if each.code == "log.resting_command"]


def test_a_held_wheel_on_a_circle_is_no_driver() -> None:
    columns = make_log({"understeer": {"K": 0.004}}, "rich", 3)
    v = np.linspace(3.0, 20.0, len(columns["t"]))  # a circle, ever faster: the curvature falls with the speed
    turn = v * 0.2 / (2.5 + 0.01 * v**2)
    yaw = np.cumsum(turn) * 0.02
    rng = np.random.default_rng(1)
    circle = {
        "t": columns["t"], "steer_cmd": np.full(len(v), 0.2), "accel_cmd": np.full(len(v), 0.15),
        "v": v + rng.normal(0.0, 0.03, len(v)), "yaw_rate": turn + rng.normal(0.0, 0.005, len(v)), "yaw": yaw,
        "x": np.cumsum(v * np.cos(yaw)) * 0.02, "y": np.cumsum(v * np.sin(yaw)) * 0.02,
    }  # fmt: skip
    assert not [each for each in examine(Log(columns=circle)) if each.code == "log.resting_command"]


def test_a_car_that_never_obeyed_cannot_be_compared_by_its_commands(by_hand: Columns) -> None:
    by_hand["engaged"] = np.zeros(len(by_hand["t"]))
    with pytest.raises(CompareError, match=r"has the column but no value while the stack drives \(column engaged\)"):
        command_at_stamps(comparable(Log(columns=by_hand)), "steer_cmd", "car.toml")


def test_a_mode_is_no_answer_and_a_mapping_makes_it_one(by_hand: Columns, tmp_path: Path) -> None:
    mode = np.where(by_hand.pop("engaged") == 1.0, 1.0, 4.0)  # as Autoware counts: autonomous, manual
    (told,) = examine(Log(columns={**by_hand, "engaged": mode}))[:1]
    assert (told.code, told.severity) == ("log.bad_engaged", "error")
    file = write_csv(tmp_path / "log.csv", by_hand)
    lines = file.read_text("utf-8").splitlines()
    written = [f"{lines[0]},mode", *(f"{line},{value:g}" for line, value in zip(lines[1:], mode, strict=True))]
    file.write_text("\n".join(written) + "\n", encoding="utf-8")
    mapping = tmp_path / "map.toml"
    mapping.write_text('[[signal]]\nname = "engaged"\nfield = "mode"\nwhen = [1]\n', encoding="utf-8")
    assert np.array_equal(driven_by_others(read_log(file, mapping=mapping)), mode == 4.0)
    log, findings = read_checked_log(file, mapping=mapping)
    assert [each.code for each in findings] == ["log.not_engaged"]
    assert np.array_equal(np.isnan(log.columns["steer_cmd"]), mode == 4.0)


def test_of_two_modes_both_have_to_be_on(by_hand: Columns, tmp_path: Path) -> None:
    t = by_hand["t"]
    del by_hand["engaged"]
    file = write_csv(tmp_path / "log.csv", by_hand)
    lat, long = (t < 20.0) | (t >= 35.0), t < 50.0
    lines = file.read_text("utf-8").splitlines()
    rows = zip(lines[1:], lat, long, strict=True)
    written = [f"{lines[0]},latActive,longActive", *(f"{line},{a:d},{b:d}" for line, a, b in rows)]
    file.write_text("\n".join(written) + "\n", encoding="utf-8")
    mapping = tmp_path / "map.toml"
    mapping.write_text('[[signal]]\nname = "engaged"\nfield = "latActive + longActive"\nwhen = [1]\n', encoding="utf-8")
    assert np.array_equal(driven_by_others(read_log(file, mapping=mapping)), ~(lat & long))
    mapping.write_text('[[signal]]\nname = "engaged"\nfield = "latActive + longActiv"\nwhen = [1]\n', encoding="utf-8")
    with pytest.raises(LogError, match="no field 'latActive \\+ longActiv'"):
        read_log(file, mapping=mapping)


@pytest.mark.parametrize("when", ["[]", "1", '[""]', "[true]"])
def test_modes_are_a_list_of_numbers_or_words(by_hand: Columns, tmp_path: Path, when: str) -> None:
    file = write_csv(tmp_path / "log.csv", {n: c for n, c in by_hand.items() if n != "engaged"})
    mapping = tmp_path / "map.toml"
    mapping.write_text(f'[[signal]]\nname = "engaged"\nfield = "v"\nwhen = {when}\n', encoding="utf-8")
    with pytest.raises(LogError, match=r"signal\[0\]\.when: found .*, allowed: a list of numbers or of words"):
        read_log(file, mapping=mapping)


def test_the_table_of_a_mapping_says_which_modes_are_obeyed() -> None:
    (row,) = mapping_rows(MappingFile((SignalMap("engaged", field="mode", when=(1.0, 5.0)),)))
    assert row["change"] == "1 where it is 1 or 5, else 0"
