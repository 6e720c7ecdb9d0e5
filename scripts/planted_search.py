"""Searches the planted faults of benchmarks/planted_faults.py: how rare they are by chance, and who finds them sooner.

    python -m scripts.planted_search chance STACK [DRIVES] [SEED]     # counts both faults of a stack, resumes
    python -m scripts.planted_search search FAULT METHOD BUDGET [SEEDS] [FIRST]

A METHOD is one of `dvp campaign`, or a peer on the same drives: optuna-tpe, and verifai-ce, verifai-mab and
verifai-halton, which run in an environment of their own whose Python is in DVP_VERIFAI.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.crew import LocalCrew
from pytest_dvp.campaigns.critical_search import search
from pytest_dvp.campaigns.failure_probability import clopper_pearson
from pytest_dvp.campaigns.hypothesis_search import search_by_hypothesis
from pytest_dvp.campaigns.one_drive import drive
from pytest_dvp.campaigns.parameter_space import Shares, space_of
from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.campaigns.store import Row, Store
from pytest_dvp.drive.run_spec import RunSpec
from scenarios import path as shipped

ROOT = Path(__file__).parents[1]
STACKS = ROOT / "benchmarks" / "planted_faults.py"
STORES = Path("runs/planted")
BLOCK = 500  # drives between two lines of progress


class Planted(NamedTuple):
    """scenario and stack; metric and greatest value of the gate that it breaks; seconds of a drive."""

    scenario: str
    stack: str
    metric: str
    bound: float
    seconds: float


FAULTS = {
    "old_sight": Planted("follow", "Follower", "collision", 0.0, 10.0),
    "slammed": Planted("follow", "Follower", "max_deceleration", 4.9, 10.0),
    "narrow": Planted("cut_in", "Merged", "collision", 0.0, 10.0),
    "slammed_behind": Planted("cut_in", "Merged", "max_deceleration", 4.5, 10.0),
    "late_for_a_child": Planted("occluded_child", "Child", "collision", 0.0, 9.0),
    "swerves": Planted("occluded_child", "Child", "max_yaw_rate", 0.2, 9.0),
}


@contextmanager
def campaign(faults: list[Planted], folder: Path | None = None) -> Iterator[Campaign]:
    """The campaign whose gates are those of `faults`, all of one stack; without a folder its store is thrown away."""
    one = faults[0]
    with tempfile.TemporaryDirectory() as temporary:
        gates = Path(temporary) / "planted.gates.toml"
        gates.write_text(
            "".join(f'[[gate]]\nmetric = "{f.metric}"\nmax = {f.bound:g}\n' for f in faults), encoding="utf-8"
        )
        settings = RunSpec(
            ads=f"{STACKS}:{one.stack}", gates=gates, duration=one.seconds, stack_process="off", rootdir=ROOT
        )
        space = space_of(shipped(f"{one.scenario}.xosc"), settings)
        with Store(folder or Path(temporary) / "out", writes=True) as store, LocalCrew(1, drive) as crew:
            yield Campaign(space, settings, store, crew, keep="none")


def chance(stack: str, count: int = 20_000, seed: int = 1) -> None:
    """How rare both faults of a stack are among evenly drawn variants."""
    faults = {name: fault for name, fault in FAULTS.items() if fault.stack == stack}
    found = dict.fromkeys(faults, 0)
    with campaign(list(faults.values()), STORES / stack) as one:
        points = sample("random", one.space.axes, count, seed)
        done = 0
        for begin in range(0, count, BLOCK):
            rows = one.rows(points[begin : begin + BLOCK], "sample")
            done += len(rows)
            for name, fault in faults.items():
                found[name] += sum(_breaks(row, fault) for row in rows)
            print(f"\r{done} of {count}: {found}", end="", file=sys.stderr)
    print(file=sys.stderr)
    for name, hits in found.items():
        told = clopper_pearson(hits, 0, done)
        low, high = told.low, told.high
        median = [np.log(2.0) / p if p else np.inf for p in (high, hits / done, low)]
        print(
            f"{name}: {hits} of {done}, {100 * hits / done:.3f} % ({100 * low:.3f} to {100 * high:.3f}); median of "
            f"chance {median[1]:.0f} drives ({median[0]:.0f} to {median[2]:.0f})",
            flush=True,
        )


def _breaks(row: Row, fault: Planted) -> bool:
    value = row.metrics.get(fault.metric)
    return value is not None and value > fault.bound


def searched(fault: str, method: str, budget: int, seeds: int = 20, first: int = 100) -> None:
    """After how many drives a method finds a fault, by seed; 0 where it does not."""
    found = []
    for seed in range(first, first + seeds):
        with campaign([FAULTS[fault]]) as one:
            if method == "hypothesis":
                rows = search_by_hypothesis(one, budget, seed)
            elif method.startswith("optuna"):
                rows = _optuna(one, budget, seed)
            elif method.startswith("verifai"):
                rows = _verifai(one, budget, seed, method.partition("-")[2])
            else:
                rows = search(one, method, budget, seed)
        found.append(next((k + 1 for k, row in enumerate(rows) if row.failed), 0))
        print(f"\r{fault}, {method}: {found}", end="", file=sys.stderr)
    print(file=sys.stderr)
    hits = sorted(k for k in found if k)
    told = clopper_pearson(len(hits), 0, seeds)
    middle = f"median of those {np.median(hits):g}" if hits else "none"
    print(
        f"{fault}, {method}: within {budget} drives in {len(hits)} of {seeds} seeds "
        f"({told.low:.2f} to {told.high:.2f}), {middle}",
        flush=True,
    )


def _driven(one: Campaign, at: Shares) -> Row | None:
    """The row of a point; None where the scenario's constraints exclude it, or where it was driven before."""
    rows = one.rows([at], "search")
    return rows[0] if rows else None


def _optuna(one: Campaign, budget: int, seed: int) -> list[Row]:
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=seed))
    rows: list[Row] = []
    for _ in range(budget):
        trial = study.ask()
        row = _driven(one, tuple(trial.suggest_float(str(k), 0.0, 1.0) for k in range(len(one.space.axes))))
        if row is not None:
            rows.append(row)
        score = row.objective if row is not None and row.objective is not None else 1.0
        study.tell(trial, score)
        if row is not None and row.failed:
            break
    return rows


PEER = r"""
import json, random, sys
import numpy as np
from dotmap import DotMap
from verifai.features import Box, Feature, FeatureSpace
from verifai.samplers import FeatureSampler
kind, size, seed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
random.seed(seed); np.random.seed(seed)
space = FeatureSpace({"at": Feature(Box(*[(0.0, 1.0)] * size))})
params = DotMap(alpha=0.9, thres=0.0, cont=DotMap(buckets=5, dist=None), disc=DotMap(dist=None))
if kind == "ce":
    sampler = FeatureSampler.crossEntropySamplerFor(space, ce_params=params)
elif kind == "mab":
    sampler = FeatureSampler.multiArmedBanditSamplerFor(space, mab_params=params)
else:
    sampler = FeatureSampler.haltonSamplerFor(space, halton_params=DotMap(sample_index=seed, bases_skipped=0))
rho = None
while True:
    sample = sampler.nextSample(rho)
    print(json.dumps([float(x) for x in sample.at]), flush=True)
    line = sys.stdin.readline()
    if not line:
        break
    rho = float(line)
"""


def _verifai(one: Campaign, budget: int, seed: int, kind: str) -> list[Row]:
    """VerifAI's sampler in a process of its own: a line with a point comes, a line with its objective goes."""
    python = os.environ.get("DVP_VERIFAI", "")
    if not python:
        raise SystemExit("DVP_VERIFAI is not set: the Python of an environment in which VerifAI is installed")
    command = [python, "-c", PEER, kind, str(len(one.space.axes)), str(seed)]
    rows: list[Row] = []
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as peer:
        assert peer.stdin is not None
        assert peer.stdout is not None
        for _ in range(budget):
            row = _driven(one, tuple(json.loads(peer.stdout.readline())))
            if row is not None:
                rows.append(row)
                if row.failed:
                    break
            score = row.objective if row is not None and row.objective is not None else 1.0
            peer.stdin.write(f"{score}\n")
            peer.stdin.flush()
        peer.kill()
    return rows


def main() -> None:
    """Run what the first word names."""
    what, name, *rest = sys.argv[1:]
    if what == "chance":
        chance(name, *(int(word) for word in rest))
    else:
        searched(name, rest[0], *(int(word) for word in rest[1:]))


if __name__ == "__main__":
    main()
