"""A stack without a simulator: its metrics are known functions of P, so that the best point is known on paper.

Run as a script it tunes and is killed (SIGKILL) before its n-th simulation:  python bowl.py FOLDER SEARCH N
"""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from typing import Any

from pytest_dvp.tuning.objective import Constraint, Objective, Term
from pytest_dvp.tuning.study import Study, Variant
from pytest_dvp.tuning.tune import Tuning, tune
from pytest_dvp.tuning.tuned_parameter import Knob
from pytest_dvp.workers.cache import Cache
from pytest_dvp.workers.job import Job
from pytest_dvp.workers.pool import Workers

BEST = {"P.LQR_q11": 30.0, "P.MPC_w": 3.0}


def work(job: Job) -> dict[str, Any]:
    """jerk = ((q11 - 30) / 20)^2 + ((w - 3) / 0.5)^2 + 0.01 (seed - 7); a collision for w < 2."""
    P = dict(job.P)
    jerk = ((P["LQR_q11"] - 30.0) / 20.0) ** 2 + ((P["MPC_w"] - 3.0) / 0.5) ** 2 + 0.01 * (job.seed - 7)
    return {"metrics": {"max_jerk": jerk, "collision": float(P["MPC_w"] < 2.0)}, "ending": "goal", "error": None}


def study(scenario: Path, search: str = "coordinate", budget: int = 60, **more: Any) -> Study:
    """Two knobs, two seeds a point."""
    knobs = (Knob("P.LQR_q11", "1/m^2", (10.0, 20.0, 30.0, 50.0)), Knob("P.MPC_w", "m", (1.5, 2.5, 3.0, 3.5)))
    objective = Objective("performance", (Term("max_jerk", 1.0),), (Constraint("collision", 0.0),))
    given: dict[str, Any] = {
        "start": {"P.LQR_q11": 10.0, "P.MPC_w": 3.5}, "search": search, "budget": budget, "seed": 3, "seeds": (7, 8),
        "variants": (Variant(scenario),), **more,
    }  # fmt: skip
    return Study("bowl", objective, knobs, **given)


def tuned(folder: Path, search: str = "coordinate", count: int = 1, what: Any = work, **more: Any) -> Tuning:
    """A tuning with the cache in `folder`, which holds the scenario, too."""
    folder.mkdir(parents=True, exist_ok=True)
    scenario = folder / "bowl.xosc"
    scenario.write_text("<OpenSCENARIO/>", encoding="utf-8")
    with Workers(Cache(folder / "cache"), count, work=what) as workers:
        return tune(study(scenario, search, **more), workers)


def main() -> None:
    folder, search, last = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    done = 0

    def mortal(job: Job) -> dict[str, Any]:
        nonlocal done
        done += 1
        if done == last:
            os.kill(os.getpid(), signal.SIGKILL)
        return work(job)

    tuned(folder, search, what=mortal)


if __name__ == "__main__":
    main()
