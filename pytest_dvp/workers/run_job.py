"""What a job gives: it drives or replays, and returns metrics. Runs in a worker process."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from pytest_dvp.workers.job import Job

SIGNALS = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")


def work(job: Job) -> dict[str, Any]:
    """`{"metrics": {name: value or None}, "ending", "error", "incidents"}`; a replayed log has no incidents.

    incidents: in words, what happened in a drive that must not: which event never fired, who was hit and when. A stack
    or car that breaks is a result, with `error`; its metrics are those of the part that was driven.

    Raises what `pytest_dvp.run` raises about a user's file, and CompareError for a log that cannot be compared.
    """
    return _replayed(job) if job.log is not None else _driven(job)


def _driven(job: Job) -> dict[str, Any]:
    from pytest_dvp.drive.run import run

    result = run(
        job.scenario,
        stage=job.stage,
        seed=job.seed,
        parameters=dict(job.parameters),
        P=dict(job.P),
        S=dict(job.S),
        model=job.model,
        gates=job.gates,
        vehicle=job.vehicle,
        library=[Path(folder) for folder in job.library],
        gated=job.gated,
        ads=job.ads,
        duration=job.duration,
    )
    # How long a tick took is another figure in each run, and a search goes the same way again.
    metrics = {name: _finite(value) for name, value in result.metrics.items() if name != "tick_time"}
    fired = metrics.get("events_fired")
    metrics["missed_events"] = 0.0 if fired is None else fired  # a scenario without events misses none
    if job.save is not None:
        _save(result.log, Path(job.save))
    error = result.error.strip().splitlines()[-1] if result.error else None
    return {"metrics": metrics, "ending": result.ending, "error": error, "incidents": _incidents(result, error)}


def _incidents(result: Any, error: str | None) -> list[str]:
    """Which event never fired, who was hit when, since when the car was off the road, whether it came to its goal, what
    broke off the drive."""
    found = [f"event {name!r} never fired" for name in result.never_fired]
    first: dict[str, float] = {}
    for event in result.log.events:
        if event.kind == "collision":
            first.setdefault(event.element, event.t)
    found += [f"it hit {name} at {t:.2f} s" for name, t in first.items()]
    if "on_road" in result.log.columns:
        off = result.log.t[result.log["on_road"] == 0.0]
        found += [f"it left the road at {t:.2f} s" for t in off[:1]]
    if result.metrics.get("goal_reached") == 0.0:  # of a task without a goal it is not defined
        found.append("it did not reach its goal")
    if found or error is not None:
        found.append(f"it ended after {result.log.t[-1]:.1f} s by {result.ended}")
    return found + ([f"it broke off: {error}"] if error is not None else [])


def _save(log: Any, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    log.save(path)


def _replayed(job: Job) -> dict[str, Any]:
    from pytest_dvp.doctor import comparable
    from pytest_dvp.gap.compare.compare import compare
    from pytest_dvp.logs.read_log import read_log
    from vehicle.model.model_file import read_model
    from vehicle.model.simulator_parameters import apply_s
    from vehicle.sensors import default_sensors

    assert job.log is not None
    assert job.model is not None
    model = read_model(job.model)
    model, _ = apply_s(model, default_sensors(car=model.car), dict(job.S))
    found = compare(comparable(read_log(job.log)), model)
    chi2 = _finite(found.chi2_per_n)
    metrics: dict[str, float | None] = {
        "chi2_per_n": chi2,
        "log10.chi2_per_n": None if chi2 is None else math.log10(max(chi2, 1e-6)),
    }
    for name, score in found.signals.items():
        for kind in ("rmse", "nrmse", "chi2_per_n", "mncc", "lag", "gain"):
            metrics[f"{kind}.{name}"] = _finite(getattr(score, kind))
    return {"metrics": metrics, "ending": "replay", "error": None}


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
