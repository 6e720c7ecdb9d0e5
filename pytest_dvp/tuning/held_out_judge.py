"""The judge: drives that nothing was learnt from, and whether a change of twin or stack is for the better on them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from scipy.stats import t as student_t

from pytest_dvp.tuning.iteration_plan import Drive, Plan, State, drives
from pytest_dvp.tuning.objective import Score, metrics_of
from pytest_dvp.tuning.stage_gap import Gap, gap
from pytest_dvp.workers.job import Job
from pytest_dvp.workers.pool import Workers

TWIN_GAIN = 0.01  # of log10(chi^2/N): 2 % of the error
STACK_GAIN = 0.005  # of the score of the performance
LEAST_PAIRS = 3  # drives from which their scatter is known at all
SURE = 0.95  # one-sided: a loss that one choice of drives in twenty makes by chance refuses no better twin
Change: TypeAlias = Literal["better", "alike", "worse"]


@dataclasses.dataclass(frozen=True, slots=True)
class HeldOutScore:
    """A state on held-out drives: performance of the stack on the car, chi^2/N and position error of the twin on its
    logs (log10 of the geometric mean over logs; [m] RMS over logs, and the noise of the position [m]), the gap.

    incidents: what happened that must not, a sentence a drive of the car: scenario, seed, event or object, time.
    costs: the performance of each drive of the car, in the order of variants and seeds; its mean is `performance`.
    """

    state: State
    performance: Score
    log_chi2: float
    position: float
    position_noise: float
    gap: Gap
    logs: tuple[Path, ...]
    incidents: tuple[str, ...] = ()
    costs: tuple[float, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The score as JSON holds it, with the gap's keys; `chi2_per_n` itself, not its logarithm."""
        return {
            "performance": self.performance.value,
            "parts": dict(self.performance.parts),
            "broken": list(self.performance.broken),
            "incidents": list(self.incidents),
            "chi2_per_n": 10.0**self.log_chi2,
            "position_at_2s": self.position,
            "position_noise": self.position_noise,
            **self.gap.as_dict(),
        }


def judge(plan: Plan, state: State, seeds: Sequence[int], workers: Workers, logs: Path) -> HeldOutScore:
    """Drive the held-out variants on all stages and look at them."""
    from pytest_dvp.tuning.structure_search import thinned

    asked = drives(plan, state, plan.held_out, tuple(seeds), logs)
    results = workers.run([drive.job for drive in asked])
    on_car = [(drive, result) for drive, result in zip(asked, results, strict=True) if drive.stage == "rw"]
    files = tuple(drive.log for drive, _ in on_car)
    position, noise = _position(state.model, {file.name: thinned(file) for file in files})
    return HeldOutScore(
        state=state,
        performance=plan.performance.score([metrics_of(result) for _, result in on_car]),
        log_chi2=log_chi2(state.model, files, workers),
        position=position,
        position_noise=noise,
        gap=gap(asked),
        logs=files,
        costs=tuple(plan.performance.score([metrics_of(result)]).value for _, result in on_car),
        incidents=tuple(
            f"{drive.variant.title}, seed {drive.seed}: {'; '.join(result['incidents'])}"
            for drive, result in on_car
            if result.get("incidents")
        ),
    )


def log_chi2(model: Path, logs: Sequence[Path], workers: Workers) -> float:
    """Mean over logs of log10(chi^2/N) of a twin driven by their commands; infinite if one cannot be compared."""
    results = workers.run([Job("", model=str(model), log=str(log)) for log in logs])
    values = [result["metrics"].get("log10.chi2_per_n") for result in results]
    return math.inf if any(value is None for value in values) else sum(values) / len(values)


def _position(model: Path, logs: Mapping[str, Any]) -> tuple[float, float]:
    from pytest_dvp.gap.compare.position_error import position_error
    from pytest_dvp.gap.diagnose.experiment import experiment_set
    from vehicle.model.model_file import read_model

    twin = read_model(model)
    noise = experiment_set(logs, twin).noise()
    return position_error(logs, twin, {}), math.hypot(noise.get("x", math.nan), noise.get("y", math.nan))


def twin_change(old: float, new: float) -> Change:
    """Of log10(chi^2/N) on the same logs; within the noise of the sensors all twins are alike."""
    old, new = max(old, 0.0), max(new, 0.0)
    return "better" if new < old - TWIN_GAIN else "worse" if new > old + TWIN_GAIN else "alike"


def stack_change(old: float, new: float) -> Change:
    """Of the score of the performance on the same variants and seeds."""
    margin = STACK_GAIN * abs(old)
    return "better" if new < old - margin else "worse" if new > old + margin else "alike"


def same_stack_change(old: HeldOutScore, new: HeldOutScore) -> Change:
    """Of the performance of one stack after a change of its twin alone.

    The twin translates the stack's accelerations to pedals, so the car's drives differ a little, and the stack decides
    some ticks earlier or later. As `stack_change`, but a difference that the scatter of the drives explains (t-test of
    pairs, one-sided) is alike. What must not happen is never chance.
    """
    change = stack_change(old.performance.value, new.performance.value)
    pairs = len(new.costs)
    if not (old.performance.allowed and new.performance.allowed) or not len(old.costs) == pairs >= LEAST_PAIRS:
        return change
    apart = np.subtract(new.costs, old.costs)
    by_chance = student_t.ppf(SURE, pairs - 1) * apart.std(ddof=1) / math.sqrt(pairs)
    return change if abs(apart.mean()) > by_chance else "alike"


def rw_logs(asked: Sequence[Drive]) -> list[Path]:
    """The car's logs of a set of drives."""
    return [drive.log for drive in asked if drive.stage == "rw"]
