"""Searches the planted faults of benchmarks/planted_faults.py: how rare they are by chance, and who finds them sooner.

    python -m scripts.planted_search chance [DRIVES] [SEED]       # counts both; goes on where it was interrupted
    python -m scripts.planted_search search FAULT METHOD BUDGET [SEEDS] [FIRST]

A METHOD is one of `dvp campaign`, or a peer on the same drives: optuna-tpe, and verifai-ce, verifai-mab and
verifai-halton, which run in an environment of their own whose Python is in DVP_VERIFAI.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.critical_search import search
from pytest_dvp.campaigns.failure_probability import clopper_pearson
from pytest_dvp.campaigns.hypothesis_search import search_by_hypothesis
from pytest_dvp.campaigns.parameter_space import Shares
from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.campaigns.store import Row
from pytest_dvp.tuning.searchers import search_names
from scripts.campaign_figures import ROOT, campaign

STACK = f"{ROOT / 'benchmarks' / 'planted_faults.py'}:Follower"
STORE = Path("runs/planted")
SECONDS = 10.0  # s of a drive: until the bend, where the stack goes straight on
BLOCK = 500  # drives between two lines of progress
FAULTS = {"old_sight": ("collision", 0.0), "slammed": ("max_deceleration", 4.9)}
"""Metric and greatest value [m/s^2 of the second one] of the gate that a fault breaks."""
UNMEASURED = 1.0  # objective of a drive that measured nothing, or that the constraints exclude: far from failing


def gates(*faults: str) -> str:
    """The gate file of these faults."""
    return "".join(f'[[gate]]\nmetric = "{metric}"\nmax = {most:g}\n' for metric, most in map(FAULTS.get, faults))


def chance(count: int = 20_000, seed: int = 1) -> None:
    """How rare the faults are among evenly drawn variants."""
    found, done = dict.fromkeys(FAULTS, 0), 0
    with campaign(STACK, SECONDS, gates(*FAULTS), STORE) as one:
        points = sample("random", one.space.axes, count, seed)
        for begin in range(0, count, BLOCK):
            rows = one.rows(points[begin : begin + BLOCK], "sample")
            done += len(rows)
            for name, (metric, most) in FAULTS.items():
                found[name] += sum((row.metrics[metric] or 0.0) > most for row in rows)
            print(f"\r{done} of {count}: {found}", end="", file=sys.stderr)
    print(file=sys.stderr)
    for name, hits in found.items():
        p = clopper_pearson(hits, 0, done)
        first, middle, last = (math.log(2.0) / each if each else math.inf for each in (p.high, p.estimate, p.low))
        print(f"{name}: {p.text()}; median of chance: {middle:.0f} drives, between {first:.0f} and {last:.0f}")


def searched(fault: str, method: str, budget: int, seeds: int = 20, first: int = 100) -> None:
    """After how many drives a method finds a fault, by seed; 0 where it does not."""
    found = []
    for seed in range(first, first + seeds):
        with campaign(STACK, SECONDS, gates(fault)) as one:
            rows = PEERS[method](one, budget, seed) if method in PEERS else search(one, method, budget, seed)
        found.append(next((k + 1 for k, row in enumerate(rows) if row.failed), 0))
        print(f"\r{fault}, {method}: {found}", end="", file=sys.stderr)
    print(file=sys.stderr)
    hits = [k for k in found if k]
    p = clopper_pearson(len(hits), 0, seeds)
    middle = f"median of those {np.median(hits):g}" if hits else "none"
    share = f"({p.low:.2f} to {p.high:.2f})"
    print(f"{fault}, {method}: within {budget} drives in {len(hits)} of {seeds} seeds {share}, {middle}")


def _driven(one: Campaign, rows: list[Row], at: Shares) -> float:
    """Drives a point, and appends its row if the constraints allow the point. The objective; below 0 for a failure."""
    new = one.rows([at], "search")
    rows += new
    return UNMEASURED if not new or new[0].objective is None else new[0].objective


def _optuna(one: Campaign, budget: int, seed: int) -> list[Row]:
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=seed))
    rows: list[Row] = []
    for _ in range(budget):
        trial = study.ask()
        at = tuple(trial.suggest_float(str(k), 0.0, 1.0) for k in range(len(one.space.axes)))
        study.tell(trial, score := _driven(one, rows, at))
        if score < 0.0:
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
            score = _driven(one, rows, tuple(json.loads(peer.stdout.readline())))
            if score < 0.0:
                break
            peer.stdin.write(f"{score}\n")
            peer.stdin.flush()
        peer.kill()
    return rows


def _sampler(kind: str) -> Callable[[Campaign, int, int], list[Row]]:
    return lambda one, budget, seed: _verifai(one, budget, seed, kind)


PEERS: dict[str, Callable[[Campaign, int, int], list[Row]]] = {
    "hypothesis": search_by_hypothesis,
    "optuna-tpe": _optuna,
    **{f"verifai-{kind}": _sampler(kind) for kind in ("ce", "mab", "halton")},
}


def main() -> None:
    """Run what the first word names."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_subparsers(dest="what", required=True)
    counted, looked = what.add_parser("chance"), what.add_parser("search")
    counted.add_argument("count", type=int, nargs="?", default=20_000, metavar="DRIVES")
    counted.add_argument("seed", type=int, nargs="?", default=1)
    looked.add_argument("fault", choices=list(FAULTS))
    looked.add_argument("method", choices=[*search_names(), *PEERS])
    looked.add_argument("budget", type=int)
    looked.add_argument("seeds", type=int, nargs="?", default=20)
    looked.add_argument("first", type=int, nargs="?", default=100)
    given = vars(parser.parse_args())
    (chance if given.pop("what") == "chance" else searched)(**given)


if __name__ == "__main__":
    main()
