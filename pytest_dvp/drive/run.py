"""From a scenario file to a judged run: one function, one result."""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from pytest_dvp.drive.announced_cars import is_real, label
from pytest_dvp.drive.compute_delay import parse_delay
from pytest_dvp.drive.guard_log import guard_notes as said_of_gate
from pytest_dvp.drive.light_notes import light_notes as said_of_lights
from pytest_dvp.drive.loop import Ending, Limits, Loop
from pytest_dvp.drive.playback_log import PlaybackLog
from pytest_dvp.drive.playback_log import playback_notes as said_of_replay
from pytest_dvp.drive.real_time_priority import punctual
from pytest_dvp.drive.request import Request, request_of, spec_of
from pytest_dvp.drive.result import RunResult, assigned, replay_command
from pytest_dvp.drive.result_file import read_result
from pytest_dvp.drive.run_files import Kept
from pytest_dvp.drive.run_findings import of_road
from pytest_dvp.drive.run_findings import said as said_of_finding
from pytest_dvp.drive.stage_checks import check_delay, check_stage, check_truth
from pytest_dvp.drive.stages import REAL, REPLAY, StageError
from pytest_dvp.drive.tick_time import tick_time
from pytest_dvp.drive.tick_time import tick_time_notes as said_of_ticks
from pytest_dvp.drive.weather import weather_notes as said_of_weather
from pytest_dvp.drive.wire_log import wire_notes as said_of_wire
from pytest_dvp.logs.log import Log
from pytest_dvp.text.paths import shown
from pytest_dvp.verdicts.result_text import NOT_WRITTEN
from vehicle.messages import TICK

if TYPE_CHECKING:
    from openscenario.findings import Finding
    from pytest_dvp.drive.run_options import RunOptions

DURATION = 60.0  # s, of a run that nothing else ends
DURATION_TO_GOAL = 300.0  # s, of a run that has a goal to reach


def run(scenario: str | Path, /, **options: Unpack[RunOptions]) -> RunResult:
    """Drive one scenario with the ADS in the loop and judge it.

    stage            what is driven: dt the twin, pe and rw a car; dvp run has an option --stage that takes several,
                     pytest a marker for each; default: dt
    seed             seed of every random number of a run; default: 7
    ads              driving stack: entry point of pytest_dvp.ads, module:Class, FILE.py:Class, ros2:F.toml; run() also
                     takes the class or function itself; it is called with (parameters, network, description) if it
                     takes them, else with nothing, and what it makes needs `tick(observation) -> Command` and may have
                     trace, path and detections; default: reference
    model            vehicle model (TOML); default: the TABBY EVO
    effects          file with your effects that the model uses; it is executed
    gates            gate file; default: NAME.gates.toml beside the scenario; without that file the default gates hold
    passed           run folders of earlier drives: on stage rw a real car drives only what passed on pe in one of them
    library          folder that scenarios may refer to, besides their own and the rootdir
    reading          reading of three rules on which esmini and the standard differ: esmini or standard
                     (docs/conformance.md); default: esmini
    roads            how a faulty road file is read: strict refuses it, lenient repairs what leaves a geometry and a
                     route, and says what it assumed (docs/roads.md); default: lenient
    ego              entity that the ADS drives; default: Ego
    parameters       declared parameters of the scenario, by name
    P                parameters of the ADS (its own, if it declares some), by name
    S                parameters of the simulator, by name
    duration         longest simulated time [s]; default: 60, with a goal 300
    wall_limit       longest wall time of one run [s]; a run that it ends is an ERROR; default: 600
    tick_limit       longest wall time of one tick of the stack [s]; six times that for the first one and for loading
                     it; a stack that takes longer is ended, and the run is an ERROR; default: 10
    stack_process    whether a stack that is given by name runs in a separate process; default: on, for the reference
                     stack off; in a process of its own it can be ended whatever it does; a class or an object always
                     runs in this process, where its Python code is interrupted
    compute_delay    stage dt: commands reach the car later, and a share of them never: SECONDS[+-JITTER][,drop=SHARE]
    after_collision  simulated time from a collision to the end of the run [s]; default: 1
    vehicle          car of stages pe and rw: surrogate or can (:HIDDEN.toml), ros1 (:FILE), replay:LOG, ros2_car:N or
                     yours; can is the surrogate with its drive-by-wire on CAN, ros1 the surrogate over ROS 1; a file
                     behind the colon says what is hidden in it, of ros1 how it is reached; replay is a recording;
                     ros1_car:FILE, ros2_car:DOMAIN and other adapters are cars; default: surrogate
    truth            file (.mcap) into which the surrogate of stages pe and rw writes what was true, for grading; logs
                     of pe and rw hold what its reference system measured; of several drives the last one is kept
    dbc              stages pe and rw: messages of a vehicle on CAN, with the signal map next to them; default: those
                     that ship
    fault            stages pe and rw: wire fault to make between surrogate and harness, as drop@5+3 (seconds)
    clock            time of stages pe and rw: stepped (lock-step) or real (wall clock); before a drive by the wall
                     clock the twin rehearses it, so that everything is loaded; a real car drives only what passed
                     there; default: stepped
    arming           stages pe and rw: arming file that permits one run of this vehicle in this scenario; the run
                     renames it to .used; without it a real car makes a dry run, which never passes; a surrogate that is
                     given one needs both keys and an area, too: a rehearsal
    envelope         stages pe and rw: file with the area and the highest speed of a real car (TOML: area, max_speed)
    log_dir          folder for a numbered run folder; default: nothing is written
    single_file      a report of one file: it shares nothing with the other runs (2 MB more); default: False
    require_real     stages pe and rw: make it an ERROR if a surrogate takes the place of a real vehicle; default: False
    rootdir          folder that scenarios may refer to; files of a stack are looked for in it
    folder_name      what is between number and stage in the name of the run folder; default: the scenario's name
    gated            the twin drives behind the guard, as the car of the other stages does; default: False

    Raises ScenarioError, GateError, ModelError, ParameterError, TrafficError, StageError, AdsError, VehicleLost, and
    UnknownKeyword, a TypeError, for an option that is none: one line each about a user's file or value, before anything
    runs or is written. A stack or a car that breaks while it drives is an ERROR verdict. What cannot be written
    afterwards is a note: the verdicts stand. ResultError if no run folder can be made; Interrupted, which is a
    KeyboardInterrupt, after SIGINT, with the car stopped and the log so far kept.
    """
    spec = spec_of(options)
    check_stage(
        spec.stage, spec.vehicle, require_real=spec.require_real, dbc=spec.dbc, fault=spec.fault, clock=spec.clock
    )
    if spec.truth is not None:
        check_truth(spec.stage, spec.vehicle, spec.truth)
    if spec.compute_delay is not None:
        parse_delay(spec.compute_delay)
        check_delay(spec.stage)
    request = request_of(Path(scenario), options, spec)
    keys = _needs_keys(request)
    if keys:
        _check_keys(request)
    live = spec.stage != "dt" and (spec.clock == REAL or keys)
    if live:
        _rehearse(request)
    return _drive(request, live)


def _drive(request: Request, live: bool) -> RunResult:
    """Prepare the run, drive it and judge it. live: by the wall clock."""
    from pytest_dvp.drive.preparation import prepare

    spec = request.spec
    ready = prepare(request)
    limit = spec.duration if spec.duration is not None else (DURATION if ready.task.goal is None else DURATION_TO_GOAL)
    recorded = ready.gate_log.length if isinstance(ready.gate_log, PlaybackLog) else float("inf")
    whole = recorded <= limit
    limit = min(limit, recorded)
    kept: Kept | None = None
    try:
        kept = Kept.reserve(
            spec.runs, spec.folder_name or request.path.stem, ready.recorder, single_file=spec.single_file
        )
        loop = Loop(ready, Limits(limit, spec.wall_limit, spec.after_collision), None if kept is None else kept.part)
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
    ended = _ended(ending, limit, "default " if spec.duration is None else "", spec.wall_limit)
    if whole and ending == "timeout":
        ended = "the end of the recording"
    again = replay_command(request)
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


def _needs_keys(request: Request) -> bool:
    """Whether the car is armed by two keys: a real one, or another that is given an arming file to rehearse it."""
    if request.spec.stage == "dt" or request.spec.vehicle.partition(":")[0] == REPLAY:
        return False
    return request.spec.arming is not None or is_real(request.spec.stage, request.spec.vehicle)


def _check_keys(request: Request) -> None:
    """Read what a real car needs before anything runs or waits. Raises ArmingRefused, EnvelopeError."""
    spec = request.spec
    if spec.arming is not None:
        from vehicle.guard.arming import read
        from vehicle.guard.guard import ArmingRefused

        if spec.envelope is None:
            raise ArmingRefused(f"{spec.arming}: a real car needs a declared area: --envelope FILE")
        read(spec.arming, spec.vehicle.partition(":")[0], request.path.name)
    if spec.envelope is not None:
        from vehicle.guard.envelope import read_envelope

        read_envelope(spec.envelope)


def _rehearse(request: Request) -> None:
    """Drive the same on the twin: what compiles or loads when it is first used must not do so by the wall clock.

    A stack that is one object, not a class that makes them, keeps its state for the car: the reference stack rehearses.
    Raises StageError if a real car is armed for what does not pass there, or did not pass in parallel execution before.
    """
    ads = request.ads
    own = ads if ads is not None and _makes_anew(ads.factory) else None
    result = run(request.path, **request.rehearsal(), ads=own)
    if request.spec.arming is None or not _needs_keys(request):
        return
    if result.status != "PASS":
        from pytest_dvp.verdicts.statuses import worst_first

        worst = worst_first(result.as_dict()["verdicts"])[0]["short"]
        raise StageError(
            f"stage {request.spec.stage} is refused: a real car drives only what passed on the twin, "
            f"and that is {result.status}: {worst}"
        )
    before = label("pe", request.spec.vehicle)
    logs = request.spec.stage_logs
    if request.spec.stage == "rw" and not any(_same_test(folder, before, request, result.log) for folder in logs):
        raise StageError(
            f"stage rw is refused: a real car drives only what passed on stage {before} with the same settings; "
            "name that run folder: --stage-logs RUN"
        )


def _makes_anew(factory: object) -> bool:
    """Whether each run gets a stack of its own; one that is an object keeps its state."""
    from pytest_dvp.drive.stack_process import NamedStack

    return inspect.isclass(factory) or inspect.isfunction(factory) or isinstance(factory, NamedStack)


def _same_test(folder: Path, stage: str, request: Request, rehearsed: Log) -> bool:
    """Whether a run folder holds a PASS of this stage, of the same scenario, road and settings."""
    try:
        kept = read_result(folder / "result.json")
        meta = Log.load(folder).meta
    except (OSError, ValueError):
        return False
    same = all(meta.get(key) == rehearsed.meta.get(key) for key in ("scenario_sha256", "road_sha256", "reading"))
    same = same and meta.get("vehicle", {}).get("name") == request.spec.vehicle
    same = same and meta.get("ego", {}).get("name") == rehearsed.meta.get("ego", {}).get("name")
    same = same and (request.ads is None or meta.get("ads") == request.ads.name)
    return same and (kept.get("status"), kept.get("stage"), kept.get("set")) == ("PASS", stage, assigned(request))


def _interrupted(request: Request, ready: Any, loop: Loop, ended: str, replay: str) -> RunResult:
    """The result of a run that SIGINT has ended: its log, and an ERROR. Nothing is measured: the user waits."""
    from pytest_dvp.drive.run_verdicts import broken

    log, error = ready.recorder.finish(), str(loop.error)
    verdict = broken(error, log.duration)
    return RunResult(
        log=log,
        verdicts=(verdict,),
        status=verdict.status,
        folder=None,
        scenario=shown(request.path),
        line=ready.scenario.storyboard.at.line or 1,
        stage=log.meta["stage"],
        ads=log.meta["ads"],
        seed=request.spec.seed,
        ending="interrupt",
        ended=ended,
        set=assigned(request),
        replay=replay,
        metrics={},
        error=error,
    )


def _judged(
    request: Request,
    ready: Any,
    end: tuple[Ending, str],
    loop: Loop,
    replay: str,
) -> RunResult:
    from openscenario.no_effect import without_effect
    from pytest_dvp.drive.run_folder import measure
    from pytest_dvp.drive.run_verdicts import broken, spoilt
    from pytest_dvp.metrics.task_outcome import storyboard_events
    from pytest_dvp.verdicts.harmless_side import harmless_notes
    from pytest_dvp.verdicts.judging import judge, never_fired, overall, unjudged

    error, times = loop.error, tick_time(loop.seconds, TICK)
    monitors = ready.storyboard.world.monitors
    log = dataclasses.replace(ready.recorder.finish(), tick_time=times)
    of_commands = (*loop.commands.findings(), *loop.commands.ignored(log.meta.get("model", {})))
    findings = (*of_road(ready.network), *of_commands, *loop.plausibility.findings())
    measured = measure(log)
    verdicts = (*spoilt(log), *judge(ready.gates, log))
    if error is not None:
        verdicts = (broken(error, log.duration), *verdicts)
    return RunResult(
        log=log,
        verdicts=verdicts,
        status=overall(verdicts),
        folder=None,
        scenario=shown(request.path),
        line=ready.scenario.storyboard.at.line or 1,
        stage=log.meta["stage"],
        ads=log.meta["ads"],
        seed=request.spec.seed,
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
            *said_of_wire(log),
            *said_of_weather(log),
            *said_of_lights(log),
            *said_of_replay(log, measured),
            *_punctuality(log),
            *map(said_of_finding, findings),
            *said_of_ticks(times),
            *unjudged(verdicts, log),
            *harmless_notes(ready.gates.gates),
            *(f"monitor {name} is {str(on).lower()} at the end" for name, on in monitors.items()),
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


def _unused_arming(request: Request) -> tuple[str, ...]:
    """One line where a second key was given and nothing is armed."""
    if request.spec.arming is None or _needs_keys(request):
        return ()
    what = "the twin" if request.spec.stage == "dt" else "a recording"
    return (f"arming file {shown(request.spec.arming)} is not used: stage {request.spec.stage} drives {what}",)
