"""The command of a simulation or replay: the `dvp run` or `dvp compare` that gives again what was judged of it."""

from __future__ import annotations

import dataclasses
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.text.paths import shown
from pytest_dvp.tuning.objective import Metrics
from pytest_dvp.tuning.tuned_parameter import split, typed
from pytest_dvp.workers.job import Job

if TYPE_CHECKING:
    from pytest_dvp.tuning.study import Study
    from pytest_dvp.tuning.tune import Tuning
    from pytest_dvp.tuning.tuned_parameter import Point


@dataclasses.dataclass(frozen=True, slots=True)
class RepeatableRun:
    """One simulation of a point: metrics that its study looks at, score of it alone, the command that repeats it."""

    job: Job
    metrics: Metrics
    score: float
    broken: tuple[str, ...]
    command: str

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it: the log, or scenario, seed and parameters; score, broken bounds, metrics and command."""
        what: dict[str, Any] = {"log": shown(Path(self.job.log))} if self.job.log is not None else {
            "scenario": shown(Path(self.job.scenario)), "seed": self.job.seed, "set": dict(self.job.parameters),
        }  # fmt: skip
        return {
            **what,
            "score": self.score,
            "broken": list(self.broken),
            "metrics": dict(self.metrics),
            "command": self.command,
        }


def repeatable_runs(found: Tuning, model: Path) -> list[RepeatableRun]:
    """The simulations of the best point, worst first. model: where an alignment's best twin is, `best_model`."""
    objective = found.study.objective
    names = objective.metrics
    jobs = found.study.jobs(found.best.point)
    rows = []
    for job, metrics in zip(jobs, found.best.each, strict=True):
        score = objective.score([metrics])
        told = command(job) if job.log is None else f"dvp compare {_path(job.log)} --model {_path(model)}"
        seen = {name: metrics.get(name) for name in names}
        rows.append(RepeatableRun(job, seen, score.value, score.broken, told))
    return sorted(rows, key=lambda row: -row.score)


def best_model(study: Study, point: Point) -> str:
    """Text of the model file of an alignment's twin with S of a point. Raises ModelError."""
    from vehicle.model.model_file import model_text, read_model
    from vehicle.model.simulator_parameters import apply_s
    from vehicle.sensors import default_sensors

    assert study.model is not None
    model = read_model(study.model)
    # In the order of `Job`: S of one effect each, so that nothing hangs on it but the text.
    values = dict(sorted({**study.fixed_S, **split(point)[1]}.items()))
    return model_text(apply_s(model, default_sensors(car=model.car), values)[0])


def _path(name: str | Path) -> str:
    return shlex.quote(shown(Path(name)))


def command(job: Job) -> str:
    """One line for a shell, with all that decides the result: scenario, seed, stage, model, parameters, P and S.

    P that `dvp run` has anyway on this stage are left out. Paths are as a user would type them here. For what no
    command line can do, a sentence that says so. Raises ValueError for a replayed log, and AdsError.
    """
    from pytest_dvp.drive.request import Request
    from pytest_dvp.drive.result import replay_command
    from pytest_dvp.drive.run_spec import RunSpec
    from pytest_dvp.drive.stack_host import find_ads
    from pytest_dvp.drive.stack_parameters import as_plain, in_force

    if job.log is not None:
        raise ValueError(f"{job.title}: a replayed log is no run")
    ads = find_ads(job.ads)
    usual = as_plain(in_force(ads, {}, job.stage))
    spec = RunSpec(
        stage=job.stage,
        seed=job.seed,
        model=None if job.model is None else Path(job.model),
        gates=None if job.gates is None else Path(job.gates),
        library=tuple(map(Path, job.library)),
        vehicle=job.vehicle,
        gated=job.gated,
        duration=job.duration,
    )
    request = Request(
        path=Path(job.scenario),
        spec=spec,
        parameters={name: typed(value) for name, value in job.parameters},
        P={name: typed(value) for name, value in job.P if value != usual[name]},
        S={name: typed(value) for name, value in job.S},
        ads=None if job.ads is None else ads,
    )
    return replay_command(request)
