"""Column names as people write them: which signal is meant, and what is said of a name that nobody knows."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.cli.command_line import main
from pytest_dvp.logs.column_names import ALIASES, canonical, parse_header, resembling
from pytest_dvp.logs.read_log import read_log
from pytest_dvp.logs.signals import SIGNALS

DOCS = Path(__file__).parents[3] / "docs" / "logs.md"


@pytest.mark.parametrize(
    ("header", "signal"),
    [
        *((name, "yaw_rate") for name in ("yaw rate [deg/s]", "Yaw Rate", "yaw-rate", "YawRate", "YAW_RATE")),
        *((name, "steer_cmd") for name in (
            "steering angle command", "steering_angle_command", "SteerCmd", "steer angle command", "wheel_angle_cmd",
            "steering command", "steering_angle_cmd", "commanded steering angle")),
        ("Vehicle Speed [km/h]", "v"), ("Longitudinal Acceleration", "ax"), ("wheelSpeed FL", "wheel_speed_fl"),
    ],
)  # fmt: skip
def test_case_blanks_and_hyphens_do_not_matter(header: str, signal: str) -> None:
    assert canonical(parse_header(header).name) == signal


@pytest.mark.parametrize("name", ["steering_wheel_angle", "steer_rate", "brake", "battery", "yaw_acceleration"])
def test_what_is_another_quantity_keeps_its_name(name: str) -> None:
    assert canonical(name) == name


def test_a_name_that_says_the_same_in_other_words_is_the_nearest() -> None:
    assert resembling("steer_cmd", ["battery", "steering wish", "v"]) == "steering wish"
    assert resembling("accel_cmd", ["battery", "lamp"]) == ""


def test_the_page_lists_the_names_that_are_known() -> None:
    """The table of the page, read as a reader would: it has every name that is understood, and no other."""
    page = DOCS.read_text(encoding="utf-8")
    asked = re.findall(r"`(\w+)`", page[page.index("Command words, before or after the name") :].split("\n\n")[0])
    listed: dict[str, str] = {}
    for signal, unit, names in re.findall(r"^\| `(\w+)` \| (\S+) \| (.+) \|$", page, re.MULTILINE):
        assert unit == SIGNALS[signal].unit
        for name in re.findall(r"`(\w+)`", names):
            if "with a command word" in names and not name.endswith("_cmd"):
                listed |= {form: signal for word in asked for form in (f"{name}_{word}", f"{word}_{name}")}
            else:
                listed[name] = signal
    assert {name: signal for name, signal in listed.items() if name not in SIGNALS} == dict(ALIASES)


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """A log with a name that is nobody's: `lenkwunsch` [deg] and `tempo` [km/h]; `lamp` has no unit."""
    t = np.arange(0.0, 4.0, 0.02)
    columns = (t, 36.0 + t, 5.0 * np.sin(t), 3.0 * np.cos(t), t > 2.0)
    path = tmp_path / "foreign.csv"
    head = "t [s],tempo [km/h],steering wish [deg],yaw rate [deg/s],lamp [-]"
    np.savetxt(path, np.column_stack(columns), fmt="%.6g", delimiter=",", header=head, comments="")
    return path


def test_a_proposal_guesses_by_unit_and_range_and_leaves_the_guess_commented(
    foreign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["map", str(foreign)]) == 0
    told = capsys.readouterr().out
    for name, field, unit in (("v", "tempo", "km/h"), ("steer", "steering wish", "deg")):
        assert f'# [[signal]]\n# name = "{name}"\n# field = "{field}"' in told
        assert f'# unit = "{unit}"' in told
    assert "(or yaw, steer_cmd)" in told or "(or steer_cmd)" in told
    assert '"lamp"' not in told  # a number without a unit may be anything


def test_a_guess_that_is_taken_is_read(foreign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["map", str(foreign)]) == 0
    text = capsys.readouterr().out
    entry = text[text.index('# name = "v"') :].split("\n\n")[0]
    mapping = foreign.with_name("map.toml")
    mapping.write_text("[[signal]]\n" + "\n".join(line.removeprefix("# ") for line in entry.splitlines()))
    log = read_log(foreign, mapping=mapping)
    assert log["v"][0] == pytest.approx(10.0)


def test_a_command_that_is_not_there_is_answered_with_the_nearest_column_and_the_way_to_name_it(
    foreign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    car = foreign.with_name("car.toml")
    car.write_text("[parameters]\nwheelbase = 2.5\n")
    assert main(["diagnose", str(foreign), "--model", str(car)]) != 0
    told = capsys.readouterr().err
    assert "Traceback" not in told
    assert "--map" in told
