"""The second key of a real car: a file that a human writes for one vehicle and one scenario, and that is used up."""

from __future__ import annotations

import tomllib
from pathlib import Path

from vehicle.command_gate import ArmingRefused
from vehicle.gate_messages import Arming


def take(path: Path) -> Arming:
    """Read an arming file and put it out of reach as `NAME.used`, so that nothing automatic arms twice.

        vehicle = "tabby"
        scenario = "overtaking.xosc"

    Raises ArmingRefused, naming the file, if it is not there or not of this form.
    """
    try:
        written = path.stat().st_mtime_ns
        keys = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ArmingRefused(f"{path}: no arming file: {error}") from None
    if set(keys) != {"vehicle", "scenario"} or not all(isinstance(value, str) for value in keys.values()):
        raise ArmingRefused(f"{path}: found {sorted(keys)}, allowed: vehicle and scenario, both strings")
    try:
        path.replace(path.with_name(path.name + ".used"))
    except OSError as error:
        raise ArmingRefused(f"{path}: cannot be used up: {error}") from None
    return Arming(keys["vehicle"], keys["scenario"], written)
