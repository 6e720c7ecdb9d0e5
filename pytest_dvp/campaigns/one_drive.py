"""One drive of a campaign, in a worker process: it drives, judges, and keeps the log if that is wanted."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pytest_dvp.campaigns.store import EXCLUDED, LOGS, Row


@dataclasses.dataclass(frozen=True)
class Drive:
    """What is to be driven.

    options    keywords of `pytest_dvp.run`, without the parameters
    keep       the log is kept of a failure, and of a drive whose objective is below this; None: of none
    """

    key: str
    base: str
    purpose: str
    scenario: str
    parameters: dict[str, str]
    options: Mapping[str, Any]
    folder: str
    commit_id: str = ""
    keep: float | None = None


def drive(order: Drive) -> Row:
    """Drive once. A stack that breaks is a row with verdict ERROR; values that the scenario's own constraints exclude
    are a row with verdict EXCLUDED, without a drive.

    Raises what `pytest_dvp.run` raises about a user's file.
    """
    from openscenario.findings import ScenarioError
    from pytest_dvp.campaigns.cases import excluded_by, outside
    from pytest_dvp.campaigns.criticality import criticality
    from pytest_dvp.drive.run import run
    from pytest_dvp.verdicts.statuses import worst_first

    before = time.process_time()
    try:
        result = run(order.scenario, **{**order.options, "parameters": _parameters(order)})
    except ScenarioError as error:
        why = outside(error)
        # What is set for every drive and is excluded itself is a slip of whoever set it, and no case.
        if not why or excluded_by(Path(order.scenario), order.options.get("parameters", {})):
            raise
        return _undriven(order, EXCLUDED, why)
    found = criticality(result)
    log = ""
    near = found.objective is not None and order.keep is not None and found.objective < order.keep
    if order.keep is not None and (near or result.status in ("FAIL", "ERROR")):
        log = f"{LOGS}/{order.key}.mcap"
        place = Path(order.folder) / log
        place.parent.mkdir(parents=True, exist_ok=True)
        result.log.save(place)
    worst = worst_first(result.as_dict()["verdicts"])
    return Row(
        key=order.key,
        scenario=order.scenario,
        parameters=order.parameters,
        seed=result.seed,
        verdict=result.status,
        margins={name: _finite(value) for name, value in found.margins.items()},
        # How long a tick took is another figure in each drive.
        metrics={name: _finite(value) for name, value in result.metrics.items() if name != "tick_time"},
        vacuous=found.vacuous,
        cpu=time.process_time() - before,
        commit_id=order.commit_id,
        log=log,
        base=order.base,
        purpose=order.purpose,
        objective=found.objective,
        gate=found.gate,
        object=found.object,
        message=worst[0]["short"] if worst else "",
    )


def broken(order: Drive, why: str) -> Row:
    """The row of a drive that ended its worker process."""
    return dataclasses.replace(_undriven(order, "ERROR", why), objective=-1.0, gate="error")


def _undriven(order: Drive, verdict: str, why: str) -> Row:
    return Row(
        key=order.key, scenario=order.scenario, parameters=order.parameters, seed=int(order.options["seed"]),
        verdict=verdict, margins={}, metrics={}, vacuous=False, cpu=0.0, commit_id=order.commit_id, log="",
        base=order.base, purpose=order.purpose, objective=None, gate="", object="", message=why,
    )  # fmt: skip


def _parameters(order: Drive) -> dict[str, Any]:
    return {**order.options.get("parameters", {}), **order.parameters}


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
