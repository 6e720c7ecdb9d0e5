"""The second key of a real car: a file that a human writes for one vehicle and one scenario, and that is used up."""

from __future__ import annotations

from pathlib import Path

from vehicle.guard.guard import ArmingRefused
from vehicle.guard.messages import Arming
from vehicle.toml_file import TomlError, read_toml


def read(path: Path, vehicle: str, scenario: str) -> Arming:
    """Read an arming file and leave it where it is, to tell what is wrong with it before anyone waits for a car.

        vehicle = "tabby"
        scenario = "overtaking.xosc"

    Raises ArmingRefused, naming the file, if it is not there, not of this form, or not for this vehicle and scenario.
    """
    arming = _read(path)
    for key, found, expected in (("vehicle", arming.vehicle, vehicle), ("scenario", arming.scenario, scenario)):
        if found != expected:
            raise ArmingRefused(f"{path}: arming file: {key} = {found!r}, this drive is of {expected!r}")
    return arming


def take(path: Path) -> Arming:
    """Read an arming file and put it out of reach as `NAME.used`, so that nothing automatic arms twice.

    Raises ArmingRefused, naming the file, if it is not there or not of this form. Whether it fits, the gate says.
    """
    arming = _read(path)
    try:
        path.replace(_used(path))
    except OSError as error:
        raise ArmingRefused(f"{path}: cannot be used up: {error}") from None
    return arming


def _read(path: Path) -> Arming:
    try:
        written = path.stat().st_mtime_ns
        keys, _ = read_toml(path)
    except OSError as error:
        raise ArmingRefused(f"{path}: no arming file: {error}{_said_if_used(path)}") from None
    except TomlError as error:
        raise ArmingRefused(f"{error.at(path)}: no arming file: {error}{_said_if_used(path)}") from None
    if set(keys) != {"vehicle", "scenario"} or not all(isinstance(value, str) for value in keys.values()):
        raise ArmingRefused(f"{path}: found {sorted(keys)}, allowed: vehicle and scenario, both strings")
    return Arming(keys["vehicle"], keys["scenario"], written)


def _said_if_used(path: Path) -> str:
    return " (there is one that was used up: write a new one)" if _used(path).exists() else ""


def _used(path: Path) -> Path:
    return path.with_name(path.name + ".used")
