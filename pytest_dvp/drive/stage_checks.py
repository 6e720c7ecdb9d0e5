"""What must hold before a stage is driven: its vehicle is known, has usable files, and may stand in for the car.

Every refusal is a StageError in one line. Nothing is opened and nothing drives here.
"""

from __future__ import annotations

import functools
import importlib.util
import os
import subprocess
from pathlib import Path

from pytest_dvp.drive.announced_cars import find_adapter, label
from pytest_dvp.drive.option import STAGES
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.drive.stages import CAN, CLOCKS, REAL, REPLAY, ROS1, STEPPED, SURROGATE, VEHICLES, StageError
from pytest_dvp.text.spelling import unknown

MISSING = "needs ROS 2 messages on DDS: pip install -e '.[ros2]' from the checkout"
MISSING_ROS1 = "needs message types and rosbags: pip install -e '.[ros1]' from the checkout"
MISSING_CAN = "needs python-can and cantools: pip install -e '.[ros2,can]' from the checkout"


def check_stage(
    stage: str,
    vehicle: str = SURROGATE,
    *,
    require_real: bool = False,
    dbc: Path | None = None,
    fault: str | None = None,
    clock: str = STEPPED,
) -> None:
    """Raises StageError unless a vehicle for `stage` exists and may stand in.

    `vehicle` is "surrogate" or "can", with ":HIDDEN.toml" behind if something is hidden in it, "ros1" or
    "ros1:FILE.toml", which says how ROS 1 is reached, or "replay:LOG", or the name of an adapter of another package,
    with ":ARGUMENT"; `require_real` refuses what is no real car; `dbc` is read, for a vehicle on CAN; `fault` goes on
    the wire of a surrogate; `clock` is "stepped" or "real".
    """
    if stage not in STAGES:
        raise StageError(unknown("stage", stage, STAGES))
    if clock not in CLOCKS:
        raise StageError(unknown("clock", clock, CLOCKS))
    if stage == "dt":
        return
    name, colon, hidden = vehicle.partition(":")
    if name == REPLAY:
        _check_replay(stage, hidden, require_real, dbc, fault, clock)
        return
    if name not in VEHICLES:
        real = find_adapter(name).is_real
        if require_real and not real:
            raise StageError(f"{label(stage, vehicle)} ERROR: a real vehicle is required, {name} says it is none")
        if dbc is not None or fault is not None:
            raise StageError(f"{'--dbc' if dbc is not None else '--fault'} is for the surrogate; found {vehicle}")
        return
    if clock == REAL and fault is not None:
        raise StageError(f"fault {fault} runs in stepped time")
    if colon and not Path(hidden).is_file():
        raise StageError(f"vehicle {vehicle!r}: no file {hidden or f'({name}:FILE.toml)'}")
    if require_real:
        raise StageError(f"{label(stage)} ERROR: a real vehicle is required, a surrogate is no evidence about a car")
    if colon and name != ROS1:
        _check_hidden(Path(hidden))
    if not wire_installed():
        raise StageError(f"stage {stage!r} {MISSING}")
    _check_fault(fault)
    if name == ROS1:
        _check_ros1(hidden)
    if name == CAN:
        _check_can(dbc)
    elif dbc is not None:
        raise StageError(f"--dbc {dbc} is for a vehicle on CAN: --vehicle {CAN}; found {vehicle}")


def check_delay(stage: str) -> None:
    """Raises StageError unless commands can be delayed on this stage."""
    if stage != "dt":
        raise StageError(
            f"--compute-delay is refused: stage {stage} drives a car that has its own time; "
            "it delays commands on stage dt, in simulated time"
        )


def check_asked(stage: str, settings: RunSpec) -> None:
    """As `check_stage`, with everything else as the settings of a session say it."""
    check_stage(
        stage,
        settings.vehicle,
        require_real=settings.require_real,
        dbc=settings.dbc,
        fault=settings.fault,
        clock=settings.clock,
    )
    if settings.compute_delay is not None:
        check_delay(stage)
    if settings.truth is not None:
        check_truth(stage, settings.vehicle, settings.truth)


def check_truth(stage: str, vehicle: str, file: Path) -> None:
    """Raises StageError unless the car of this stage knows the truth, and can write it there. The log of dt is true."""
    if stage == "dt":
        return
    if vehicle.partition(":")[0] not in VEHICLES:
        raise StageError(f"--truth {file} is of the surrogate; {vehicle} does not know what is true")
    if file.suffix != ".mcap":
        raise StageError(f"--truth {file}: the file of what was true is an MCAP file, as truth.mcap")
    if not file.parent.is_dir():
        raise StageError(f"--truth {file}: no folder {file.parent}")


def check_hidden(vehicle: str) -> None:
    """Raises StageError if what is to be hidden in a surrogate is a file that it refuses."""
    name, _, argument = vehicle.partition(":")
    if name in (SURROGATE, CAN) and argument and Path(argument).is_file():
        _check_hidden(Path(argument))


def wire_installed() -> bool:
    """Whether the extra `ros2` is there."""
    return importlib.util.find_spec("cyclonedds") is not None


def _check_replay(
    stage: str, recording: str, require_real: bool, dbc: Path | None, fault: str | None, clock: str
) -> None:
    from pytest_dvp.logs.log_error import LogError
    from pytest_dvp.logs.log_part import parse_argument

    try:
        file = parse_argument(recording).path
    except LogError as error:
        raise StageError(str(error)) from None
    if not recording or not file.exists():
        raise StageError(f"vehicle {REPLAY}:{recording}: no log {recording or '(replay:LOG or replay:LOG@FROM:TO)'}")
    if require_real:
        raise StageError(f"{stage}-{REPLAY} ERROR: a real vehicle is required, a recording cannot be driven")
    if dbc is not None or fault is not None or clock != STEPPED:
        option = "--dbc" if dbc is not None else "--fault" if fault is not None else f"--clock {clock}"
        raise StageError(f"{option} is not for a recording; found vehicle {REPLAY}:{recording}")


def _check_fault(fault: str | None) -> None:
    if fault is not None:
        from vehicle.wire.faults import FaultError, parse_fault

        try:
            parse_fault(fault)
        except FaultError as error:
            raise StageError(str(error)) from None


def _check_ros1(file: str) -> None:
    if importlib.util.find_spec("rosbags") is None:
        raise StageError(f"vehicle {ROS1!r} {MISSING_ROS1}")
    from vehicle.adapters.ros1 import settings_of
    from vehicle.wire.ros1 import Ros1Error

    try:
        within = settings_of(Path(file) if file else None)[1]
    except Ros1Error as error:
        raise StageError(str(error)) from None
    if within is not None:
        _check_hidden(within)


def _check_hidden(file: Path) -> None:
    """Raises StageError with what the surrogate says of a file that it cannot hide: before anything drives."""
    try:
        said = _refused(file, file.read_bytes())
    except OSError as error:
        raise StageError(f"{file}: cannot be read: {error.strerror}") from None
    if said:
        raise StageError(said)


@functools.lru_cache(maxsize=4)
def _refused(file: Path, content: bytes) -> str:
    """What is wrong with a file of hidden effects, in one line; only the surrogate knows, and it is another process."""
    from vehicle.child_process import own_module, own_path

    command = [*own_module("vehicle.surrogate"), "--check", "--hidden", str(file)]
    there = {**os.environ, **own_path()}
    asked = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False, env=there)
    if asked.returncode == 0:
        return ""
    last = (asked.stderr.strip().splitlines() or [f"exit code {asked.returncode}"])[-1]
    return last if last.startswith(str(file)) else f"{file}: {last}"


def _check_can(dbc: Path | None) -> None:
    from vehicle.wire.can_map import CanMapError, find_map

    if not all(importlib.util.find_spec(module) for module in ("can", "cantools", "msgpack")):
        raise StageError(f"vehicle {CAN!r} {MISSING_CAN}")
    try:
        find_map(dbc)
    except CanMapError as error:
        raise StageError(str(error)) from None
