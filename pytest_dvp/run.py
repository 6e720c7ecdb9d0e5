"""From a scenario file to a judged run: one function, one result."""

from __future__ import annotations

import dataclasses
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeAlias

from pytest_dvp.log import Log
from pytest_dvp.loop import Driver, Ending, Limits, Loop
from pytest_dvp.paths import shown
from pytest_dvp.settings import Assignments
from pytest_dvp.stages import check_stage

if TYPE_CHECKING:
    from ads.parameters import Parameters
    from openscenario.road.network import RoadNetwork
    from pytest_dvp.gates import Verdict
    from vehicle.messages import VehicleDescription

DriverFactory: TypeAlias = "Callable[[Parameters, RoadNetwork, VehicleDescription], Driver]"

DURATION = 60.0  # s, of a run that nothing else ends
DURATION_TO_GOAL = 300.0  # s, of a run that has a goal to reach


@dataclasses.dataclass(frozen=True)
class RunResult:
    """What a run left: the log, the verdicts of its gates, and how to do it again.

    status    PASS only if at least one gate was judged and all of them passed
    folder    run folder with log.mcap, result.json and report.html, if one was asked for
    scenario  the file as a command line names it; line: its storyboard
    error     traceback of a stack or vehicle that broke, or the limit that ended the run
    notes     what in the scenario is doubtful: events that never fired, acts that never ended
    """

    log: Log
    verdicts: tuple[Verdict, ...]
    status: str
    folder: Path | None
    scenario: str
    line: int
    stage: str
    seed: int
    ending: Ending
    set: Mapping[str, str]
    replay: str
    metrics: Mapping[str, float | None]
    error: str | None = None
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON-able data: what crosses processes and stands in result.json; no series."""
        return {
            "scenario": self.scenario,
            "line": self.line,
            "stage": self.stage,
            "seed": self.seed,
            "status": self.status,
            "ending": self.ending,
            "simulated": self.log.duration,
            "set": dict(self.set),
            "verdicts": [verdict.as_dict() for verdict in self.verdicts],
            "metrics": dict(self.metrics),
            "folder": None if self.folder is None else shown(self.folder),
            "replay": self.replay,
            "error": self.error,
            "notes": list(self.notes),
        }


def run(
    scenario_path: str | Path,
    *,
    stage: str = "dt",
    seed: int = 7,
    parameters: Mapping[str, str | float | bool] | None = None,
    P: Mapping[str, str | float] | None = None,
    S: Mapping[str, str | float] | None = None,
    model: str | Path | None = None,
    gates: str | Path | None = None,
    library: Sequence[Path] = (),
    rootdir: Path | None = None,
    ego: str | None = None,
    duration: float | None = None,
    wall_limit: float = 600.0,
    after_collision: float = 1.0,
    ads: DriverFactory | None = None,
    log_dir: Path | None = None,
) -> RunResult:
    """Drive one scenario with the ADS in the loop and judge it.

    parameters       declared parameters of the scenario; P of the ADS, S of the simulator, by name
    model            vehicle model file; default the TABBY EVO that ships
    gates            gate file; default NAME.gates.toml beside the scenario, else the default gates
    duration         longest simulated time [s], > 0; default 60, or 300 if there is a goal to reach
    wall_limit       longest wall time [s]; a run that it ends is an ERROR
    after_collision  simulated time [s] from a collision to the end of the run
    ads              factory of another driving stack: (parameters, network, description) -> Driver
    log_dir          folder for a numbered run folder; None writes nothing

    Raises ScenarioError, GateError, ModelError, ParameterError, TrafficError, StageError: one line each about a user's
    file or value, before anything runs or is written. A stack that breaks while it drives is an ERROR verdict.
    """
    check_stage(stage)
    from pytest_dvp.prepare import Request, prepare

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
        ego=ego,
    )
    ready = prepare(request, ads)
    limit = duration if duration is not None else (DURATION if ready.task.goal is None else DURATION_TO_GOAL)
    try:
        loop = Loop(ready, Limits(limit, wall_limit, after_collision))
        ending = loop.drive()
    finally:
        ready.close()
    return _judged(request, ready, ending, loop.error, replay_command(request, duration), log_dir)


def _judged(
    request: Any, ready: Any, ending: Ending, error: str | None, replay: str, log_dir: Path | None
) -> RunResult:
    from pytest_dvp.gates import judge, overall

    log = ready.recorder.finish()
    verdicts = tuple(judge(ready.gates, log))
    if error is not None:
        verdicts = (_broken(error, log.duration), *verdicts)
    result = RunResult(
        log=log,
        verdicts=verdicts,
        status=overall(verdicts),
        folder=None,
        scenario=shown(request.path),
        line=ready.scenario.storyboard.at.line or 1,
        stage=request.stage,
        seed=request.seed,
        ending=ending,
        set=assigned(request),
        replay=replay,
        metrics={verdict.metric: verdict.value for verdict in verdicts if verdict.metric},
        error=error,
        notes=tuple(str(finding) for finding in ready.storyboard.report()),
    )
    if log_dir is None:
        return result
    from pytest_dvp.results import save_run

    return dataclasses.replace(result, folder=save_run(result, log_dir))


def _broken(error: str, t: float) -> Verdict:
    """The verdict of a run that broke off: an ERROR, whatever its gates say of the rest."""
    from pytest_dvp.gates import Verdict

    text = f"run ERROR: {error.strip().splitlines()[-1]} at t={t:.2f} s"
    return Verdict("run", "", "ERROR", None, "", None, None, t, "", text, text, "", None)


def assigned(request: Any) -> dict[str, str]:
    """Everything that was set, under the names `--set` takes."""
    named = {name: str(value) for name, value in request.parameters.items()}
    named.update((f"P.{name}", str(value)) for name, value in request.P.items())
    named.update((f"S.{name}", str(value)) for name, value in request.S.items())
    return named


def replay_command(request: Any, duration: float | None) -> str:
    """The `dvp run` that does the same again."""
    words = ["dvp", "run", shown(request.path), "--seed", str(request.seed)]
    for name, value in sorted(assigned(request).items()):
        words += ["--set", f"{name}={value}"]
    for option, path in (("--model", request.model), ("--gates", request.gates)):
        words += [option, shown(path)] if path is not None else []
    words += [word for folder in request.library for word in ("--library", shown(folder))]
    words += ["--ego", request.ego] if request.ego is not None else []
    words += ["--duration", f"{duration:g}"] if duration is not None else []
    return shlex.join(words)


class _CallableModule(ModuleType):
    """`pytest_dvp.run` is this module once it is imported, and the function for whoever uses the package."""

    def __call__(self, *arguments: Any, **options: Any) -> RunResult:
        return run(*arguments, **options)


sys.modules[__name__].__class__ = _CallableModule

__all__ = ["Assignments", "DriverFactory", "RunResult", "run"]
