"""The surrogate over ROS 1: rospy behind a bridge, on a roscore (`vehicle/wire/ros1.py` says how it is reached).

--dvp-vehicle ros1             on the roscore of ROS_MASTER_URI
--dvp-vehicle ros1:ros1.toml   reached as the file says; `hidden = "hidden.toml"` in it: what is hidden in the car
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from vehicle.adapter import VehicleLost
from vehicle.wire.end import Opener
from vehicle.wire.ros1 import Ros1Error, Ros1Settings, on_ros1, read_settings

FAREWELL = 8.0  # s; its bridge has 5 of them
HIDDEN = {"hidden": str}  # further keys of the file of a surrogate


def settings_of(file: Path | None) -> tuple[Ros1Settings, Path | None]:
    """How a surrogate is reached over ROS 1, and what is hidden in it. Raises Ros1Error."""
    settings = read_settings(file, HIDDEN)
    if "hidden" not in settings.others:
        return settings, None
    hidden = Path(settings.others["hidden"])
    if not hidden.is_file():
        raise Ros1Error(f"{file}: hidden: no file {hidden}")
    return settings, hidden


def by_ros1(settings: Ros1Settings) -> dict[str, Any]:
    """What CarProcess takes for a car on a roscore, which keeps whoever does not leave it."""
    return {"wire": partial(_by_ros1, settings), "farewell": FAREWELL}


def _by_ros1(settings: Ros1Settings, number: int) -> tuple[list[str], Opener]:
    within = f"/dvp{number}"
    words = ["--ros1", within, *(["--ros1-file", str(settings.file)] if settings.file is not None else [])]
    return words, on_ros1(settings, "harness", within=within, error=VehicleLost)
