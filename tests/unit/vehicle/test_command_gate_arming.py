"""The arming file: read once, for one vehicle and one scenario; whatever is wrong with it is one line."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from vehicle.guard.arming import read, take
from vehicle.guard.guard import ArmingRefused
from vehicle.guard.messages import Arming

GOOD = 'vehicle = "tabby"\nscenario = "overtaking.xosc"\n'


def written(folder: Path, text: str) -> Path:
    path = folder / "arming.toml"
    path.write_bytes(text.encode("latin-1"))
    os.utime(path, ns=(5, 7_000))
    return path


def test_it_says_vehicle_scenario_and_when_it_was_written(tmp_path: Path) -> None:
    assert take(written(tmp_path, GOOD)) == Arming("tabby", "overtaking.xosc", 7_000)


def test_it_is_used_up_by_reading(tmp_path: Path) -> None:
    path = written(tmp_path, GOOD)
    take(path)
    assert [p.name for p in tmp_path.iterdir()] == ["arming.toml.used"]
    with pytest.raises(ArmingRefused, match=r"arming\.toml: no arming file"):
        take(path)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("vehicle = ", r"arming\.toml:1: no arming file: not TOML: Invalid value$"),
        ("\xff", "no arming file"),
        ('vehicle = "tabby"\n', r"found \['vehicle'\], allowed: vehicle and scenario"),
        (GOOD + "more = 1\n", "allowed: vehicle and scenario"),
        ('vehicle = 1\nscenario = "a"\n', "both strings"),
    ],
)
def test_what_is_wrong_with_it_is_said_and_it_stays(tmp_path: Path, text: str, why: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(ArmingRefused, match=why):
        take(path)
    assert path.exists()


def test_one_that_cannot_be_used_up_arms_nothing(tmp_path: Path) -> None:
    path = written(tmp_path, GOOD)
    (tmp_path / "arming.toml.used").mkdir()
    with pytest.raises(ArmingRefused, match="cannot be used up"):
        take(path)


def test_it_can_be_read_before_the_drive_and_stays(tmp_path: Path) -> None:
    path = written(tmp_path, GOOD)
    assert read(path, "tabby", "overtaking.xosc") == Arming("tabby", "overtaking.xosc", 7_000)
    assert path.exists()


@pytest.mark.parametrize(
    ("vehicle", "scenario", "why"),
    [
        ("tabi", "overtaking.xosc", r"arming\.toml: arming file: vehicle = 'tabby', this drive is of 'tabi'"),
        (
            "tabby",
            "urban.xosc",
            r"arming\.toml: arming file: scenario = 'overtaking\.xosc', this drive is of 'urban\.xosc'",
        ),
    ],
)
def test_one_for_something_else_is_told_with_both_names(tmp_path: Path, vehicle: str, scenario: str, why: str) -> None:
    with pytest.raises(ArmingRefused, match=why):
        read(written(tmp_path, GOOD), vehicle, scenario)


def test_one_that_was_used_up_is_called_so_and_one_that_never_was_there_is_not(tmp_path: Path) -> None:
    path = written(tmp_path, GOOD)
    take(path)
    with pytest.raises(ArmingRefused, match=r"no arming file: .* \(there is one that was used up: write a new one\)$"):
        read(path, "tabby", "overtaking.xosc")
    with pytest.raises(ArmingRefused, match=r"No such file or directory: '[^']*other\.toml'$"):
        read(tmp_path / "other.toml", "tabby", "overtaking.xosc")
    written(tmp_path, "vehicle = ")
    with pytest.raises(ArmingRefused, match=r"Invalid value \(there is one that was used up: write a new one\)$"):
        read(path, "tabby", "overtaking.xosc")
