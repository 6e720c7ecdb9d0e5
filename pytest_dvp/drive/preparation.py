"""Everything a run needs, read and checked before anything moves: scenario, road, task, vehicle, stack, traffic."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import importlib.metadata
import itertools
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from openscenario.findings import Finding, ScenarioError
from openscenario.model.entities import ScenarioObject
from openscenario.model.scenario import Scenario
from openscenario.read import read_scenario
from openscenario.road.network import RoadNetwork, load_network
from openscenario.road.repairs import LENIENT, Roads
from openscenario.road.route import RouteError
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.reading import USUAL
from pytest_dvp.drive.announced_cars import label
from pytest_dvp.drive.compute_delay import Delayed
from pytest_dvp.drive.deadline import Deadline
from pytest_dvp.drive.ego_model import fitted_model, with_model_text
from pytest_dvp.drive.ego_task import EgoTask, find_ego, task_of
from pytest_dvp.drive.guard_log import GuardLog
from pytest_dvp.drive.guarded_car import guarded_car
from pytest_dvp.drive.open_car import hidden_in
from pytest_dvp.drive.parameter_checks import declared_names
from pytest_dvp.drive.prepared_run import Ready
from pytest_dvp.drive.request import Request
from pytest_dvp.drive.stack_host import find_ads, make_driver
from pytest_dvp.drive.stack_parameters import as_plain, in_force
from pytest_dvp.drive.stack_sensors import read_by
from pytest_dvp.drive.stages import CAN, REPLAY, ROS1, STEPPED, SURROGATE, VEHICLES, StageError
from pytest_dvp.drive.stop_lines import stop_lines
from pytest_dvp.drive.target_reference import TargetReference
from pytest_dvp.drive.world import World
from pytest_dvp.logs.event_names import EventNames
from pytest_dvp.logs.obeyed_commands import ARRIVED
from pytest_dvp.logs.recorder import LogRecorder
from pytest_dvp.text.paths import shown
from pytest_dvp.verdicts.gate_references import unknown_names
from pytest_dvp.verdicts.judging import GateError, GateFile, default_gates, read_gates
from vehicle.adapter import Vehicle
from vehicle.messages import Command, FloatArray, RoadPoint, VehicleDescription, VehicleState
from vehicle.model.effect_catalogue import effects_of_files
from vehicle.model.model_file import read_model
from vehicle.toml_file import read_toml

if TYPE_CHECKING:
    from ads.parameters import Parameters
    from pytest_dvp.drive.chosen_stack import Ads
    from pytest_dvp.drive.driver import Driver
    from pytest_dvp.drive.run_spec import RunSpec
    from pytest_dvp.drive.stack_parameters import Own
    from vehicle.model.vehicle_model import AppliedEffect

ON_ROAD = 0.01  # m beyond the end of a road: lengths in files are rounded
KEPT_LANE = 2000  # m of reference line ahead of an ego without a goal, a point every metre


def prepare(request: Request) -> Ready:
    """Read and check everything. Raises what `pytest_dvp.drive.run.run` says.

    That includes GateError, of a gate file or of a name in it that the scenario does not have.
    """
    gates, gate_folder = _gates(request)
    parameters = {**_of_the_scenario(request), **request.parameters}
    scenario = read_scenario(request.path, library=request.spec.library, rootdir=request.rootdir, parameters=parameters)
    wrong = [name for name in unknown_names(gates, scenario, request.path.name) if name.severity == "error"]
    if wrong:  # before the drive, which such a gate could not judge
        raise GateError(wrong)
    network = network_of(scenario, request.spec.roads)
    ego = find_ego(scenario, request.spec.ego)
    ads = request.ads or find_ads()
    P = in_force(ads, request.P, request.spec.stage)
    vehicle, about, gate_log = _vehicle(request, network, ego, read_by(ads))
    try:
        parts = _Parts(scenario, network, gates, gate_folder, ego, ads, P, vehicle, about)
        return dataclasses.replace(_ready(request, parts), gate_log=gate_log, targets=_targets(request))
    except BaseException:
        vehicle.close()
        raise


@dataclasses.dataclass(frozen=True)
class _Parts:
    """What a run is made of. about: what the log says of the vehicle."""

    scenario: Scenario
    network: RoadNetwork
    gates: GateFile
    gate_folder: Path
    ego: ScenarioObject
    ads: Ads
    P: Parameters | Own
    vehicle: Vehicle
    about: Mapping[str, Any]


@dataclasses.dataclass(frozen=True)
class _Start:
    """How a run begins. armed: of a car that needs keys, whether it has them."""

    begun: Begun
    state: VehicleState
    armed: bool | None


@dataclasses.dataclass(frozen=True)
class Begun:
    """A storyboard after its Init, the task of the ego in it, and the line (n, 2) [m] that it is to drive."""

    storyboard: Storyboard
    task: EgoTask
    reference: FloatArray


def begin(scenario: Scenario, network: RoadNetwork, gates: GateFile, ego: str, spec: RunSpec) -> Begun:
    """Carry out the Init of a scenario and work out the task of the ego.

    A run begins with this, and `dvp check` asks it whether one could.

    Raises:
        ScenarioError: an element that cannot run, a place of the task that is not on the road, or no way to the goal.
    """
    storyboard = Storyboard(scenario, network, external=[ego], seed=spec.seed, reading=spec.reading)
    storyboard.start()
    asked = gates.task
    start, goal = (asked.start, asked.goal) if asked else (None, None)
    task = task_of(storyboard.entities[ego], network, start, goal)
    check_place(network, task.start, gates.file)
    if task.goal is not None:
        check_place(network, task.goal, gates.file)
    return Begun(storyboard, task, _reference(network, task, gates.file))


def _ready(request: Request, parts: _Parts) -> Ready:
    """The run, its vehicle at its start."""
    spec, network, gates, vehicle = request.spec, parts.network, parts.gates, parts.vehicle
    begun = begin(parts.scenario, network, gates, parts.ego.name, spec)
    entity = begun.storyboard.entities[parts.ego.name]
    state = VehicleState(t=0.0, x=entity.x, y=entity.y, yaw=entity.h, v=entity.speed, z=entity.z, vx=entity.speed)
    armed = _reset(vehicle, state, request)
    limit = math.inf if getattr(parts.ads.factory, "has_own_deadline", False) else spec.tick_limit
    watch = Deadline(parts.ads.name, limit)
    driver: Driver = make_driver(parts.ads, parts.P, network, _known(vehicle.description, request), watch)
    try:
        return _with_driver(request, parts, _Start(begun, state, armed), driver)
    except BaseException:
        driver.close()
        raise


def _with_driver(request: Request, parts: _Parts, start: _Start, driver: Driver) -> Ready:
    """The run, its stack made."""
    scenario, network, gates, vehicle = parts.scenario, parts.network, parts.gates, parts.vehicle
    name, task, state = parts.ego.name, start.begun.task, start.state
    storyboard = start.begun.storyboard
    meta = {
        "scenario": request.path.name,
        "scenario_sha256": scenario.sha256,
        "road_sha256": _sha256(scenario.road_network.logic_file),
        "parameters": {declared.name: declared.value for declared in scenario.parameter_declarations},
        "P": as_plain(parts.P),
        "S": {name: str(value) for name, value in request.S.items()},
        "ads": parts.ads.name,
        "seed": request.spec.seed,
        "stage": label(request.spec.stage, request.spec.vehicle),
        "versions": versions(),
        "storyboard_events": list(EventNames(scenario)),
        "collision_events": EventNames(scenario).of_collisions(name),
        "task": _task_meta(task),
        **parts.about,
    }
    if request.spec.reading != USUAL:
        meta["reading"] = request.spec.reading
    if request.compute_delay is not None:
        meta["compute_delay"] = str(request.compute_delay)
    if start.armed is not None:
        meta["vehicle"] = {**meta["vehicle"], "armed": start.armed}
    if lines := stop_lines(network):
        meta["stop_lines"] = lines
    if driver.nets:
        meta["nets"] = driver.nets
    road: list[dict[str, Any]] = [{"kind": border.kind, "points": border.points} for border in network.boundaries(1.0)]
    road += [{"kind": "crosswalk", "points": crosswalk.outline} for crosswalk in network.crosswalks]
    recorder = LogRecorder(meta, reference=start.begun.reference, road=road)
    traffic = None
    if gates.traffic is not None:
        from pytest_dvp.drive.sumo_traffic import SumoTraffic

        traffic = SumoTraffic(
            parts.gate_folder / gates.traffic.net, parts.gate_folder / gates.traffic.routes, request.spec.seed
        )
    world = World(storyboard, name, vehicle.description, masses(scenario), traffic)
    row = np.array([[0.0, state.x, state.y, state.z, state.yaw, state.v, state.vx, 0, 0, 0, 0, 0]], dtype=np.float64)
    if request.compute_delay is not None:
        vehicle = _delayed(vehicle, request, recorder, state)
    return Ready(scenario, network, gates, name, task, storyboard, world, vehicle, driver, recorder, row)


def _delayed(vehicle: Vehicle, request: Request, recorder: LogRecorder, state: VehicleState) -> Delayed:
    """The vehicle behind the time that the stack takes; what arrives goes into the log, if no gate does so."""

    def record(t: float, command: Command) -> None:
        if not request.spec.gated:
            asked = {name: getattr(command, name) for name in ("steer", "accel", "throttle", "brake")}
            recorder.hold(t, {f"{ARRIVED}{name}_cmd": value for name, value in asked.items()})

    record(0.0, Command(0.0, state.steer, 0.0, 0.0, 0.0))  # before the first one arrives
    assert request.compute_delay is not None
    return Delayed(vehicle, request.compute_delay, request.spec.seed, record)


def network_of(scenario: Scenario, roads: Roads = LENIENT) -> RoadNetwork:
    """The road of a scenario. Raises ScenarioError if it names none or a broken one (of which `roads` decides)."""
    file = scenario.road_network.logic_file
    if file is None:
        at = scenario.road_network.at
        text = "the scenario names no road network (RoadNetwork/LogicFile)"
        finding = Finding("dvp.no_road", "error", str(scenario.path), at.line or None, "RoadNetwork", text=text)
        raise ScenarioError([finding])
    stat = file.stat()
    return _network(file, roads, stat.st_mtime_ns, stat.st_size)


@functools.lru_cache(maxsize=4)
def _network(path: Path, roads: Roads, changed: int, size: int) -> RoadNetwork:
    """Networks are immutable, and the variants of one scenario share theirs."""
    return load_network(path, roads)


def reference_line(network: RoadNetwork, task: EgoTask) -> FloatArray:
    """Centre line (n, 2) of the task's route in driving direction; without a goal, of the lane as far as it leads.

    Points x, y in [m], not to be written to.
    """
    return _line(network, task.start, task.route, task.goal)


@functools.lru_cache(maxsize=4)
def _line(network: RoadNetwork, start: RoadPoint, route: tuple[RoadPoint, ...], goal: RoadPoint | None) -> FloatArray:
    """The variants of one scenario share it as they share their network: it takes up to a tenth of a drive to draw."""
    line = _kept_lane(network, start) if goal is None else _way(network, (start, *route, goal))
    line.flags.writeable = False
    return line


def _way(network: RoadNetwork, points: tuple[RoadPoint, ...]) -> FloatArray:
    legs = [network.centreline(network.route(a, b))[:, :2] for a, b in itertools.pairwise(points)]
    return np.concatenate([legs[0], *(leg[1:] for leg in legs[1:])])


def _kept_lane(network: RoadNetwork, start: RoadPoint) -> FloatArray:
    pose = network.lane_pose(*start)
    place = network.locate(pose.x, pose.y, pose.h)._replace(road=start.road, lane=start.lane, s=start.s)
    line = [(pose.x, pose.y)]
    while len(line) < KEPT_LANE and not network.dead_end(place):
        place = network.advance(place._replace(offset=0.0), 1.0)
        pose = network.lane_pose(place.road, place.lane, place.s)
        line.append((pose.x, pose.y))
    return np.array(line)


def _reference(network: RoadNetwork, task: EgoTask, file: str) -> FloatArray:
    try:
        return reference_line(network, task)
    except RouteError as error:
        raise ScenarioError([Finding("dvp.task", "error", file, None, "task", text=str(error))]) from None


def check_place(network: RoadNetwork, place: RoadPoint, file: str) -> None:
    """Raises ScenarioError if a place of the task is not on the road."""
    try:
        network.lane_pose(place.road, place.lane, place.s)
        if place.s > network.roads[place.road].length + ON_ROAD:
            raise KeyError(f"s = {place.s:g} m is beyond the end of road {place.road}")
    except KeyError as error:
        text = f"a place of the task is not on the road: {error.args[0]}"
        raise ScenarioError([Finding("dvp.task", "error", file, None, "task", text=text)]) from None


def masses(scenario: Scenario) -> dict[str, float]:
    """Masses [kg] of the entities whose file states one."""
    stated = {entity.name: getattr(entity.entity, "mass", None) for entity in scenario.entities}
    return {name: float(mass) for name, mass in stated.items() if mass}


@functools.cache
def versions() -> dict[str, str]:
    """Versions of what could change a result."""
    return {name: importlib.metadata.version(name) for name in ("pytest-dvp", "numpy", "numba", "pymunk", "daqp")}


def _gates(request: Request) -> tuple[GateFile, Path]:
    path = request.spec.gates
    if path is None:
        beside = request.path.with_name(f"{request.path.stem}.gates.toml")
        path = beside if beside.is_file() else None
    if path is None:
        return default_gates(), request.path.parent
    if not path.is_file():  # what reads it says what is missing
        return read_gates(shown(path)), path.parent
    stat = path.stat()
    gates = _unchanged_gates(path.absolute(), shown(path), stat.st_mtime_ns, stat.st_size)
    if any("model" in gate.options for gate in gates.gates):  # whether that file is there may have changed
        gates = read_gates(shown(path))
    return gates, path.parent


@functools.lru_cache(maxsize=4)
def _unchanged_gates(path: Path, name: str, changed: int, size: int) -> GateFile:
    """Gates are immutable, and the variants of one scenario share theirs."""
    return read_gates(name)


def _of_the_scenario(request: Request) -> dict[str, str]:
    """Parameters S of the paper that the scenario declares: it is the scenario that moves the pedestrian."""
    from vehicle.model.simulator_parameters import scenario_parameters

    values = scenario_parameters(request.S)
    declared = declared_names(request.path) if values else ()
    return {name: repr(value) for name, value in values.items() if name in declared}


def _vehicle(
    request: Request, network: RoadNetwork, ego: ScenarioObject, reads: frozenset[str] | None
) -> tuple[Vehicle, dict[str, Any], GuardLog]:
    if request.spec.stage != "dt":
        return _car(request, network, ego)
    from vehicle.model.simulator_parameters import apply_s
    from vehicle.sensors import default_sensors
    from vehicle.twin import Twin

    model, about = fitted_model(request.spec.model, ego, request.spec.effects)
    model, sensors = apply_s(model, default_sensors(car=model.car), request.S)
    twin: Vehicle = Twin(model, sensors, request.spec.seed, reads)
    gate_log = GuardLog()
    if request.spec.gated:
        from vehicle.guard.guarded_vehicle import GuardedVehicle, limits_of

        limits = limits_of(twin.description)
        twin = GuardedVehicle(twin, limits, name="twin", scenario=request.path.name, record=gate_log.record)
    return (
        twin,
        {"model": with_model_text(model, about), "ego": {"name": ego.name, **_size(twin.description)}},
        gate_log,
    )


def _car(request: Request, network: RoadNetwork, ego: ScenarioObject) -> tuple[Vehicle, dict[str, Any], GuardLog]:
    """The car of stages pe and rw behind the guard; its body is its own, not the scenario's."""
    from vehicle.guard.envelope import read_envelope
    from vehicle.model.simulator_parameters import scenario_parameters

    if request.spec.vehicle.partition(":")[0] == REPLAY:
        return _replayed(request, ego)
    if refused := sorted(set(request.S) - set(scenario_parameters(request.S))):
        raise StageError(f"S.{refused[0]} changes the twin; the car of stage {request.spec.stage} is what it is")
    envelope = (
        None if request.spec.envelope is None else read_envelope(request.spec.envelope)
    )  # before waiting for the car
    gate_log = GuardLog()
    perception = _mirrored_with(request)
    car = guarded_car(request, network, envelope, gate_log, perception)
    name = request.spec.vehicle.partition(":")[0]
    allowed: dict[str, Any] = (
        {} if envelope is None or envelope.max_speed is None else {"envelope_speed": envelope.max_speed}
    )
    if perception:
        allowed["mirrored_with"] = {applied.name: dict(applied.values) for applied in perception}
    if name not in VEHICLES:
        about = {"name": request.spec.vehicle, "clock": request.spec.clock, **allowed}
        return car, {"vehicle": about, "ego": {"name": ego.name, **_size(car.description)}}, gate_log
    hidden = hidden_in(request.spec.vehicle)
    about = {"name": SURROGATE, "hidden_sha256": "" if hidden is None else _sha256(hidden)}
    about |= allowed
    about |= {"clock": request.spec.clock} if request.spec.clock != STEPPED else {}
    if name == ROS1:
        about |= {"wire": ROS1}
    if name == CAN:
        about |= {"wire": CAN, "dbc_sha256": _sha256(request.spec.dbc) if request.spec.dbc is not None else ""}
    return car, {"vehicle": about, "ego": {"name": ego.name, **_size(car.description)}}, gate_log


def _targets(request: Request) -> TargetReference | None:
    """What measures the road users on stage rw of the surrogate, unless its own reference system is said to be ideal.

    On stage pe they are the simulator's own, which knows where they are.
    """
    spec = request.spec
    if spec.stage != "rw" or spec.vehicle.partition(":")[0] not in VEHICLES:
        return None
    hidden = hidden_in(spec.vehicle)
    about = {} if hidden is None else read_toml(hidden)[0].get("reference", {})
    return None if about.get("unit") == "ideal" else TargetReference(spec.seed)


def _mirrored_with(request: Request) -> list[AppliedEffect]:
    """The perception effects of the twin, with which the virtual road users of stage pe are shown to the stack."""
    from vehicle.model.perception_effects import perception_in

    if request.spec.stage != "pe" or request.spec.model is None:
        return []
    return perception_in(read_model(request.spec.model, extra=effects_of_files(request.spec.effects)).effects)


def _replayed(request: Request, ego: ScenarioObject) -> tuple[Vehicle, dict[str, Any], GuardLog]:
    """A recording in the place of the car. No gate: nothing hangs on it that could move."""
    from pytest_dvp.drive.playback_log import PlaybackLog
    from pytest_dvp.drive.playback_source import open_recording
    from vehicle.adapters.mirror import Parallel
    from vehicle.adapters.replay import Replay
    from vehicle.sensors import default_sensors
    from vehicle.twin import Twin

    argument = request.spec.vehicle.partition(":")[2]
    model, _ = fitted_model(request.spec.model, ego, request.spec.effects)
    recording, looks = open_recording(
        argument, Twin(model, default_sensors(car=model.car), request.spec.seed).description
    )
    replay_log = PlaybackLog(recording.duration)
    replay: Vehicle = Replay(recording, replay_log.compare)
    if request.spec.stage == "pe" or not looks:
        replay = Parallel(replay, request.spec.seed, _mirrored_with(request))
    about = {"name": REPLAY, "log": Path(argument).name, "commands": len(recording.commands) > 0}
    return replay, {"vehicle": about, "ego": {"name": ego.name, **_size(replay.description)}}, replay_log


def _reset(vehicle: Vehicle, state: VehicleState, request: Request) -> bool | None:
    """Put the vehicle at its start. Of a car that needs keys, whether it is armed: with both; with one a dry run.

    Raises ArmingRefused.
    """
    from vehicle.guard.arming import take
    from vehicle.guard.guarded_vehicle import GuardedVehicle
    from vehicle.guard.process import GuardProcess

    if not isinstance(vehicle, GuardedVehicle | GuardProcess) or not vehicle.needs_keys:
        vehicle.reset(state)
        return None
    if request.spec.arming is None:
        vehicle.reset(state)
    else:
        vehicle.reset(state, named=request.spec.vehicle.partition(":")[0], arming=take(request.spec.arming))
    return vehicle.armed


def _known(car: VehicleDescription, request: Request) -> VehicleDescription:
    """What the stack is told of the car: its data sheet; in pe and rw with the delays that the twin has learnt of it.

    They were identified on that car's logs, so that the same stack drives twin and car.
    """
    if request.spec.stage == "dt" or request.spec.model is None:
        return car
    twin = read_model(request.spec.model, extra=effects_of_files(request.spec.effects)).description()
    return msgspec.structs.replace(car, steer_delay=twin.steer_delay, drive_delay=twin.drive_delay)


def _size(d: VehicleDescription) -> dict[str, float]:
    return {"length": d.length, "width": d.width, "height": d.height, "center_x": d.center_x, "wheelbase": d.wheelbase}


def _sha256(file: Path | None) -> str:
    return "" if file is None else hashlib.sha256(file.read_bytes()).hexdigest()


def _task_meta(task: EgoTask) -> dict[str, Any]:
    def place(point: RoadPoint) -> dict[str, Any]:
        return {"road": point.road, "lane": point.lane, "s": point.s}

    return {
        "start": place(task.start),
        "goal": None if task.goal is None else place(task.goal),
        "route": [place(point) for point in task.route],
        "set_speed": task.set_speed,
    }
