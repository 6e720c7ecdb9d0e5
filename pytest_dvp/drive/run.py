"""From a scenario file to a judged run: one function, one result."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from openscenario.storyboard.reading import USUAL
from pytest_dvp.drive.chosen_stack import Ads
from pytest_dvp.drive.command_range import said_of as said_of_command
from pytest_dvp.drive.compute_delay import parse_delay
from pytest_dvp.drive.deadline import TICK_LIMIT
from pytest_dvp.drive.guard_log import said_of as said_of_gate
from pytest_dvp.drive.loop import TICK, Ending, Limits, Loop
from pytest_dvp.drive.playback_log import ReplayLog
from pytest_dvp.drive.playback_log import said_of as said_of_replay
from pytest_dvp.drive.real_time_priority import punctual
from pytest_dvp.drive.result import AFTER_COLLISION, RunResult, assigned, replay_command
from pytest_dvp.drive.result_file import read_result
from pytest_dvp.drive.run_files import Kept
from pytest_dvp.drive.stack_host import find_ads
from pytest_dvp.drive.stages import (
    REAL,
    REPLAY,
    STEPPED,
    SURROGATE,
    StageError,
    check_delay,
    check_stage,
    is_real,
    label,
)
from pytest_dvp.drive.tick_time import said_of as said_of_ticks
from pytest_dvp.drive.tick_time import tick_time
from pytest_dvp.logs.log import Log
from pytest_dvp.text.paths import shown
from pytest_dvp.verdicts.result_text import NOT_WRITTEN

if TYPE_CHECKING:
    from ads.parameters import Parameters
    from openscenario.findings import Finding
    from openscenario.road.network import RoadNetwork
    from openscenario.storyboard.reading import Reading
    from pytest_dvp.verdicts.judging import Verdict
    from vehicle.messages import VehicleDescription

DriverFactory: TypeAlias = (
    "Callable[[Parameters, RoadNetwork, VehicleDescription], object]"
    "| Callable[[dict[str, int | float], RoadNetwork, VehicleDescription], object] | Callable[[], object]"
)

DURATION = 60.0  # s, of a run that nothing else ends
DURATION_TO_GOAL = 300.0  # s, of a run that has a goal to reach


def run(
    scenario_path: str | Path,
    *,
    stage: str = "dt",
    seed: int = 7,
    parameters: Mapping[str, str | float | bool] | None = None,
    P: Mapping[str, str | float] | None = None,
    S: Mapping[str, str | float] | None = None,
    model: str | Path | None = None,
    effects: Sequence[str | Path] = (),
    gates: str | Path | None = None,
    library: Sequence[Path] = (),
    rootdir: Path | None = None,
    ego: str | None = None,
    duration: float | None = None,
    wall_limit: float = 600.0,
    tick_limit: float = TICK_LIMIT,
    stack_process: str | None = None,
    compute_delay: str | None = None,
    after_collision: float = AFTER_COLLISION,
    ads: DriverFactory | Ads | str | None = None,
    vehicle: str = SURROGATE,
    dbc: Path | None = None,
    fault: str | None = None,
    clock: str = STEPPED,
    arming: Path | None = None,
    envelope: Path | None = None,
    passed: Sequence[Path] = (),
    require_real: bool = False,
    log_dir: Path | None = None,
    single_file: bool = False,
    folder_name: str | None = None,
    gated: bool = False,
    reading: Reading = USUAL,
) -> RunResult:
    """Drive one scenario with the ADS in the loop and judge it.

    parameters       declared parameters of the scenario; P of the ADS (its own, if it declares some), S of the
                     simulator, by name
    model            vehicle model file; default the TABBY EVO that ships
    effects          Python files with effects of your own that the model file uses; they are run
    gates            gate file; default NAME.gates.toml beside the scenario, else the default gates
    duration         longest simulated time [s], > 0; default 60, or 300 if there is a goal to reach
    wall_limit       longest wall time [s]; a run that it ends is an ERROR
    tick_limit       longest wall time of a tick of the stack [s]; six times that for the first one, for its
                     constructor and for loading it. A stack that takes longer is ended, and the run is an ERROR
    stack_process    "on": a stack that is given by name runs in a process of its own, and can be ended whatever it
                     does; "off": in this one. Default "on", of the reference stack "off"; a class or an object always
                     runs in this process, where its Python code is interrupted
    compute_delay    of stage "dt": "SECONDS[+-JITTER][,drop=SHARE]": `pytest_dvp.drive.compute_delay`
    after_collision  simulated time [s] from a collision to the end of the run
    ads              another driving stack: an entry point of `pytest_dvp.ads`, "module:Class", "file.py:Class", or
                     the class or function itself; called with (parameters, network, description) if it takes them,
                     else with nothing; needs `tick(observation) -> Command`, may have trace, path, detections
    vehicle          of stages "pe" and "rw": "surrogate", "can" (the same with its drive-by-wire on CAN), each with
                     ":FILE" behind if something is hidden in it; "ros1", "ros1:FILE": the same over ROS 1;
                     "replay:LOG"; "ros1_car:FILE", "ros2_car:DOMAIN" or another adapter: a car
    dbc              messages of a vehicle on CAN, with a signal map of the same name beside it; default our own
    fault            what is to go wrong on the wire to the surrogate, as "drop@5+3": `vehicle.wire.faults`
    require_real     a surrogate is refused
    log_dir          folder for a numbered run folder; None writes nothing
    single_file      the report there carries the library that draws, and needs no other file
    clock            of stages "pe" and "rw": "stepped", or "real" by the wall clock; before that it is rehearsed on the
                     twin, so that everything is loaded, and a real car drives only what passed there
    arming           second key of a real car, used up by the run; without it a dry run, which never passes; a
                     surrogate that is given one needs both keys and an area, too: a rehearsal
    envelope         file that says where and how fast a real car may drive
    passed           run folders of earlier drives: on stage "rw" a real car drives only what passed on "pe" with it
    folder_name      what is between number and stage in its name; default the scenario's
    gated            of stage "dt": the twin behind the command gate, as the car of the other stages is
    reading          "esmini" or "standard", where the two differ in what a scenario means

    Raises ScenarioError, GateError, ModelError, ParameterError, TrafficError, StageError, AdsError, VehicleLost: one
    line each about a user's file or value, before anything runs or is written. A stack or a car that breaks while it
    drives is an ERROR verdict. What cannot be written afterwards is a note: the verdicts stand. ResultError if no run
    folder can be made; Interrupted, a KeyboardInterrupt, after SIGINT, with the car stopped and the log so far kept.
    """
    check_stage(stage, vehicle, require_real=require_real, dbc=dbc, fault=fault, clock=clock)
    delay = None if compute_delay is None else parse_delay(compute_delay)
    if delay is not None:
        check_delay(stage)
    from pytest_dvp.drive.preparation import prepare
    from pytest_dvp.drive.request import Request

    request = Request(
        path=Path(scenario_path),
        stage=stage,
        seed=seed,
        parameters=dict(parameters or {}),
        P=dict(P or {}),
        S=dict(S or {}),
        model=None if model is None else Path(model),
        gates=None if gates is None else Path(gates),
        library=tuple(library),
        rootdir=rootdir,
        effects=tuple(Path(file) for file in effects),
        ego=ego,
        ads=find_ads(ads, [rootdir] if rootdir is not None else [], process=stack_process, tick_limit=tick_limit),
        vehicle=vehicle,
        dbc=dbc,
        fault=fault,
        clock=clock,
        arming=None if arming is None else Path(arming),
        envelope=None if envelope is None else Path(envelope),
        gated=gated,
        reading=reading,
        tick_limit=tick_limit,
        stack_process=stack_process,
        compute_delay=delay,
    )
    keys = _needs_keys(request)
    if keys and request.arming is not None:
        from vehicle.guard.arming import read
        from vehicle.guard.guard import ArmingRefused

        if request.envelope is None:
            raise ArmingRefused(f"{request.arming}: a real car needs a declared area: --envelope FILE")
        read(request.arming, vehicle.partition(":")[0], request.path.name)  # told before anything runs or waits
    if keys and request.envelope is not None:
        from vehicle.guard.envelope import read_envelope

        read_envelope(request.envelope)
    live = stage != "dt" and (clock == REAL or keys)
    if live:
        _rehearse(request, duration, after_collision, passed)
    ready = prepare(request)
    limit = duration if duration is not None else (DURATION if ready.task.goal is None else DURATION_TO_GOAL)
    recorded = ready.gate_log.length if isinstance(ready.gate_log, ReplayLog) else float("inf")
    whole = recorded <= limit
    limit = min(limit, recorded)
    kept: Kept | None = None
    try:
        kept = Kept.reserve(log_dir, folder_name or request.path.stem, ready.recorder, single_file=single_file)
        loop = Loop(ready, Limits(limit, wall_limit, after_collision), None if kept is None else kept.part)
        with punctual() if live else contextlib.nullcontext(False) as first:
            ending = loop.drive()
        if timing := ready.gate_log.punctuality():
            ready.recorder.meta["timing"] = {**timing, "scheduling": "real time" if first else "ordinary"}
    except BaseException:
        if kept is not None:
            kept.drop()
        raise
    finally:
        ready.close()
    ended = _ended(ending, limit, "default " if duration is None else "", wall_limit)
    if whole and ending == "timeout":
        ended = "the end of the recording"
    again = replay_command(request, duration, after_collision)
    if ending == "interrupt":
        result = _interrupted(request, ready, loop, ended, again)
        raise Interrupted(result if kept is None else kept.finish(result, brief=True))
    result = _judged(request, ready, (ending, ended), loop, again)
    return result if kept is None else kept.finish(result)


class Interrupted(KeyboardInterrupt):
    """A run that SIGINT has ended: one line with when, and where its log is. `result`: of what it drove until then."""

    def __init__(self, result: RunResult) -> None:
        place = "no log was asked for" if result.folder is None else f"its log so far: {shown(result.folder)}"
        unwritten = [note for note in result.notes if note.startswith(NOT_WRITTEN)]
        where = "; ".join(unwritten) if unwritten else place
        super().__init__(f"{result.scenario} [{result.stage}] {result.error}; {where}")
        self.result = result


def _needs_keys(request: Any) -> bool:
    """Whether the car is armed by two keys: a real one, or another that is given an arming file to rehearse it."""
    if request.stage == "dt" or request.vehicle.partition(":")[0] == REPLAY:
        return False
    return request.arming is not None or is_real(request.stage, request.vehicle)


def _rehearse(request: Any, duration: float | None, after_collision: float, passed: Sequence[Path]) -> None:
    """Drive the same on the twin: what compiles or loads when it is first used must not do so by the wall clock.

    A stack that is one object, not a class that makes them, keeps its state for the car: the reference stack rehearses.
    Raises StageError if a real car is armed for what does not pass there, or did not pass in parallel execution before.
    """
    result = run(
        request.path,
        seed=request.seed,
        parameters=request.parameters,
        P=request.P,
        S=request.S,
        model=request.model,
        effects=request.effects,
        gates=request.gates,
        library=request.library,
        rootdir=request.rootdir,
        reading=request.reading,
        ego=request.ego,
        duration=duration,
        after_collision=after_collision,
        tick_limit=request.tick_limit,
        ads=request.ads if _makes_anew(request.ads.factory) else None,
    )
    if request.arming is None or not _needs_keys(request):
        return
    if result.status != "PASS":
        from pytest_dvp.verdicts.statuses import worst_first

        worst = worst_first(result.as_dict()["verdicts"])[0]["short"]
        raise StageError(
            f"stage {request.stage} is refused: a real car drives only what passed on the twin, "
            f"and that is {result.status}: {worst}"
        )
    before = label("pe", request.vehicle)
    if request.stage == "rw" and not any(_same_test(folder, before, request, result.log) for folder in passed):
        raise StageError(
            f"stage rw is refused: a real car drives only what passed on stage {before} with the same settings; "
            "name that run folder: --stage-logs RUN"
        )


def _makes_anew(factory: object) -> bool:
    """Whether each run gets a stack of its own; one that is an object keeps its state."""
    from pytest_dvp.drive.stack_process import NamedStack

    return inspect.isclass(factory) or inspect.isfunction(factory) or isinstance(factory, NamedStack)


def _same_test(folder: Path, stage: str, request: Any, rehearsed: Log) -> bool:
    """Whether a run folder holds a PASS of this stage, of the same scenario, road and settings."""
    try:
        kept = read_result(folder / "result.json")
        meta = Log.load(folder).meta
    except (OSError, ValueError):
        return False
    same = all(meta.get(key) == rehearsed.meta.get(key) for key in ("scenario_sha256", "road_sha256"))
    same = same and meta.get("ads") == request.ads.name
    return same and (kept.get("status"), kept.get("stage"), kept.get("set")) == ("PASS", stage, assigned(request))


def _interrupted(request: Any, ready: Any, loop: Loop, ended: str, replay: str) -> RunResult:
    """The result of a run that SIGINT has ended: its log, and an ERROR. Nothing is measured: the user waits."""
    log, error = ready.recorder.finish(), str(loop.error)
    verdict = _broken(error, log.duration)
    return RunResult(
        log=log,
        verdicts=(verdict,),
        status=verdict.status,
        folder=None,
        scenario=shown(request.path),
        line=ready.scenario.storyboard.at.line or 1,
        stage=log.meta["stage"],
        ads=log.meta["ads"],
        seed=request.seed,
        ending="interrupt",
        ended=ended,
        set=assigned(request),
        replay=replay,
        metrics={},
        error=error,
    )


def _judged(
    request: Any,
    ready: Any,
    end: tuple[Ending, str],
    loop: Loop,
    replay: str,
) -> RunResult:
    from openscenario.no_effect import without_effect
    from pytest_dvp.drive.run_folder import measure
    from pytest_dvp.drive.wire_log import wire_verdict
    from pytest_dvp.metrics.task_outcome import storyboard_events
    from pytest_dvp.verdicts.judging import judge, never_fired, overall, unjudged

    error, times, findings = loop.error, tick_time(loop.seconds, TICK), loop.commands.findings()
    log = dataclasses.replace(ready.recorder.finish(), tick_time=times)
    measured = measure(log)
    verdicts = tuple(judge(ready.gates, log))
    if (troubled := wire_verdict(log)) is not None:
        verdicts = (troubled, *verdicts)
    if log.meta.get("vehicle", {}).get("armed") is False:
        verdicts = (_dry(), *verdicts)
    if error is not None:
        verdicts = (_broken(error, log.duration), *verdicts)
    return RunResult(
        log=log,
        verdicts=verdicts,
        status=overall(verdicts),
        folder=None,
        scenario=shown(request.path),
        line=ready.scenario.storyboard.at.line or 1,
        stage=log.meta["stage"],
        ads=log.meta["ads"],
        seed=request.seed,
        ending=end[0],
        ended=end[1],
        set=assigned(request),
        replay=replay,
        metrics={
            **{verdict.metric: verdict.value for verdict in verdicts if verdict.metric},
            **{name: metric.value for name, metric in measured.items()},
        },
        error=error,
        notes=(
            *_unused_arming(request),
            *said_of_gate(log),
            *said_of_replay(log, measured),
            *_punctuality(log),
            *map(said_of_command, findings),
            *said_of_ticks(times),
            *unjudged(verdicts, log),
            *map(_note, (*ready.storyboard.report(), *without_effect(ready.scenario))),
        ),
        tick_time=times,
        findings=findings,
        compute_delay=None if request.compute_delay is None else str(request.compute_delay),
        events=tuple(storyboard_events(log)[0]),
        never_fired=never_fired(ready.gates, log),
    )


def _note(finding: Finding) -> str:
    """Place and sentence; the sentence names the element, so its path would only fill the line."""
    place = finding.file if finding.line is None else f"{finding.file}:{finding.line}"
    return f"{place}: {finding.message}"


def _ended(ending: Ending, limit: float, default: str, wall_limit: float) -> str:
    return {
        "stop": "the stop trigger",
        "goal": "the goal",
        "timeout": f"the {default}limit of {limit:g} s (--duration)",
        "collision": "a collision",
        "wall": f"the limit of {wall_limit:g} s of wall time (--wall-limit)",
        "fault": "a fault",
        "interrupt": "an interruption (SIGINT)",
    }[ending]


def _punctuality(log: Log) -> tuple[str, ...]:
    """One line about a run in real time."""
    timing = log.meta.get("timing")
    if not timing or "missed" not in timing:
        return ()
    ms = {name: f"{1000.0 * timing[name]:.1f}" for name in ("lateness_99", "lateness_worst", "round_trip_median")}
    return (
        f"real time: {timing['commands']} commands, {100.0 * timing['missed']:.2f} % over 10 ms late "
        f"(99 % within {ms['lateness_99']} ms, worst {ms['lateness_worst']} ms), "
        f"round trip {ms['round_trip_median']} ms, {timing.get('scheduling', 'ordinary')} scheduling",
    )


def _unused_arming(request: Any) -> tuple[str, ...]:
    """One line where a second key was given and nothing is armed."""
    if request.arming is None or _needs_keys(request):
        return ()
    what = "the twin" if request.stage == "dt" else "a recording"
    return (f"arming file {shown(request.arming)} is not used: stage {request.stage} drives {what}",)


def _dry() -> Verdict:
    """The verdict of a real car that was not armed: nothing that its log shows is the stack's doing."""
    from pytest_dvp.verdicts.judging import Verdict

    text = "dry run INCONCLUSIVE: no command reached the car; both keys arm it: --vehicle NAME and --arming FILE"
    return Verdict("dry run", "", "INCONCLUSIVE", None, "", None, None, None, "", text, text, "", None)


def _broken(error: str, t: float) -> Verdict:
    """The verdict of a run that broke off: an ERROR, whatever its gates say of the rest."""
    from pytest_dvp.verdicts.judging import Verdict

    text = f"run ERROR: {error.strip().splitlines()[-1]} at t={t:.2f} s"
    return Verdict("run", "", "ERROR", None, "", None, None, t, "", text, text, "", None)
