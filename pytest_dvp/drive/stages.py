"""Stages: what stands in for the car, and what a result of it is called.

DT is the digital twin in simulated time. In PE a car drives and the simulator supplies the road users; in RW everything
is the car's own. Both need a vehicle, and without a real one they take the surrogate: a car in a process of its own,
with other physics than the twin, on the other side of ROS 2 topics, and of a CAN bus if it is to have a drive-by-wire
there. A result of it says so: "rw-surrogate".
"""

from __future__ import annotations

import dataclasses
import functools
import importlib.util
import os
import subprocess
from collections.abc import Callable, Sequence
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.drive.option import STAGES
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.rooms import side_by_side
from pytest_dvp.text.spelling import unknown

if TYPE_CHECKING:
    from vehicle.adapter import Vehicle
    from vehicle.model.vehicle_model import AppliedEffect
    from vehicle.wire.health import Trouble

SURROGATE = "surrogate"
CAN = "can"  # the surrogate with its drive-by-wire on CAN
ROS1 = "ros1"  # the surrogate over ROS 1
VEHICLES = (SURROGATE, CAN, ROS1)
REPLAY = "replay"  # a recording
ADAPTERS = "pytest_dvp.adapters"  # entry points
STEPPED, REAL = CLOCKS = ("stepped", "real")
MISSING = "needs ROS 2 messages on DDS: pip install -e '.[ros2]' from the checkout"
MISSING_ROS1 = "needs message types and rosbags: pip install -e '.[ros1]' from the checkout"
MISSING_CAN = "needs python-can and cantools: pip install -e '.[ros2,can]' from the checkout"


class StageError(ValueError):
    """A stage that does not exist, or for which nothing can stand in for the car."""


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


def check_hidden(vehicle: str) -> None:
    """Raises StageError if what is to be hidden in a surrogate is a file that it refuses."""
    name, _, argument = vehicle.partition(":")
    if name in (SURROGATE, CAN) and argument and Path(argument).is_file():
        _check_hidden(Path(argument))


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


def wire_installed() -> bool:
    """Whether the extra `ros2` is there."""
    return importlib.util.find_spec("cyclonedds") is not None


def label(stage: str, vehicle: str = SURROGATE) -> str:
    """What results of a stage are called: "dt", "pe-surrogate", "rw-surrogate"; of a real car "pe", "rw"; of another
    stand-in "rw-NAME"."""
    name = vehicle.partition(":")[0]
    if stage == "dt":
        return stage
    if name in VEHICLES:
        return f"{stage}-{SURROGATE}"
    return stage if is_real(stage, vehicle) else f"{stage}-{name}"


@dataclasses.dataclass(frozen=True)
class Adapter:
    """A vehicle of another package: `open(argument) -> Vehicle`, `is_real` unless it says that it is none.

    `place` is where it is found, "module:name"; `real_time` if it says that its steps take the wall clock's time.
    """

    name: str
    open: Callable[[str], Vehicle]
    is_real: bool
    place: str = ""
    real_time: bool = False


def find_adapter(name: str) -> Adapter:
    """The adapter that a package announces under this name (entry point `pytest_dvp.adapters`).

    The entry point is a class or function that takes what stands behind the colon of `--vehicle NAME:ARGUMENT` and
    gives a Vehicle. Its attribute `is_real` is False for what is no car; without it, it is taken for one. Raises
    StageError.
    """
    points = {point.name: point for point in entry_points(group=ADAPTERS)}
    if name not in points:
        text = unknown("vehicle", name, [*VEHICLES, REPLAY, *points])
        raise StageError(f"{text} (a car of yours: an entry point of {ADAPTERS})")
    try:
        found = side_by_side.load(points[name])
    except Exception as error:  # a foreign package may raise anything while it loads
        raise StageError(f"vehicle {name!r} cannot be loaded: {type(error).__name__}: {error}") from error
    real, real_time = getattr(found, "is_real", True) is not False, getattr(found, "real_time", False) is True
    return Adapter(name, found, real, side_by_side.own_value(points[name]), real_time)


def gate_apart(vehicle: str) -> Adapter | None:
    """The adapter of a real car whose guard gets a process of its own: one by the wall clock."""
    name = vehicle.partition(":")[0]
    if name in (*VEHICLES, REPLAY):
        return None
    adapter = find_adapter(name)
    return adapter if adapter.is_real and adapter.real_time else None


def is_real(stage: str, vehicle: str) -> bool:
    """Whether a stage drives a real car. What is not known counts as one."""
    name = vehicle.partition(":")[0]
    if stage == "dt" or name in (*VEHICLES, REPLAY):
        return False
    try:
        return find_adapter(name).is_real
    except StageError:
        return True


def may_repeat(stage: str, vehicle: str) -> bool:
    """Whether something automatic may drive this stage: everything but a real car."""
    return not is_real(stage, vehicle)


def refuse_repetition(what: str, stage: str, vehicle: str) -> None:
    """Raises StageError if `what` ("fuzzing", "tuning", "--lf") would drive a real car again and again.

    Nothing automatic drives a real car: one listed scenario for each confirmation by a human.
    """
    if is_real(stage, vehicle):
        raise StageError(
            f"{what} is refused: vehicle {vehicle!r} is real, and nothing automatic drives a real car; "
            f"name one scenario: pytest X.xosc::{label(stage, vehicle)}"
        )


def hidden_in(vehicle: str) -> Path | None:
    """What is hidden in a surrogate that `check_stage` has let through: a file, or nothing."""
    name, _, argument = vehicle.partition(":")
    if name == ROS1:
        from vehicle.adapters.ros1 import settings_of

        return settings_of(Path(argument) if argument else None)[1]
    return Path(argument) if argument else None


def open_vehicle(
    stage: str,
    vehicle: str,
    seed: int,
    dbc: Path | None = None,
    fault: str | None = None,
    *,
    clock: str = STEPPED,
    record: Callable[[Trouble], None] = lambda _: None,
    perception: Sequence[AppliedEffect] = (),
) -> tuple[Vehicle, Callable[[], dict[str, Any]]]:
    """The car of stage "pe" or "rw", running and waiting; arguments as of `check_stage`, which comes before.

    `record` gets every trouble with its messages; with the effects `perception` the car of stage "pe" sees the virtual
    road users. The second result tells how punctual it was, for the log; empty in
    stepped time. Raises VehicleLost if it does not come.
    """
    from vehicle.adapters.mirror import in_parallel

    name, _, hidden = vehicle.partition(":")
    if name not in VEHICLES:
        return _open_adapter(stage, vehicle, seed, perception)
    within, options = hidden_in(vehicle), dict[str, Any](record=record)
    if name == ROS1:
        from vehicle.adapters.ros1 import by_ros1, settings_of

        options |= by_ros1(settings_of(Path(hidden) if hidden else None)[0])
    if name == CAN:
        from vehicle.wire.can_map import find_map

        options["can"] = find_map(dbc)
    if fault is not None:
        from vehicle.wire.faults import parse_fault

        options["fault"] = parse_fault(fault)
    if clock == REAL:
        from vehicle.adapters.live import live_surrogate

        live = live_surrogate(seed, within, **options)
        return (in_parallel(live, seed, perception) if stage == "pe" else live), lambda: live.punctuality.as_dict()
    from vehicle.adapters.process import surrogate

    car = surrogate(seed, within, **options)
    return (in_parallel(car, seed, perception) if stage == "pe" else car), dict


def _open_adapter(
    stage: str, vehicle: str, seed: int, perception: Sequence[AppliedEffect]
) -> tuple[Vehicle, Callable[[], dict[str, Any]]]:
    from vehicle.adapter import Vehicle
    from vehicle.adapters.mirror import in_parallel

    name, _, argument = vehicle.partition(":")
    adapter = find_adapter(name)
    car = adapter.open(argument)
    if not isinstance(car, Vehicle):
        raise StageError(f"vehicle {vehicle!r}: {type(car).__name__} is no Vehicle (vehicle.adapter.Vehicle)")
    if car.is_real and not adapter.is_real:
        car.close()
        raise StageError(f"vehicle {vehicle!r} announces that it is not real, and its car says it is")

    def told() -> dict[str, Any]:
        """A method of the car, or what has one: a new object for each run."""
        kept = getattr(car, "punctuality", dict)
        return dict(getattr(kept, "as_dict", kept)())

    return (in_parallel(car, seed, perception) if stage == "pe" else car), told
