"""Searches planted faults: how rare they are by chance, and who finds them sooner.

    python -m scripts.planted_search chance STACK [DRIVES] [SEED]    # goes on where it was interrupted
    python -m scripts.planted_search search FAULT METHOD BUDGET [SEEDS] [FIRST]

STACKS and FAULTS below name them. A METHOD is one of `dvp campaign`, or a peer on the same drives: optuna-tpe, and
verifai-ce, verifai-mab and verifai-halton, which run in an environment of their own whose Python is in DVP_VERIFAI.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
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
from scripts.campaign_figures import ROOT, campaign, unmeasured

STORE = Path("runs/planted")
BLOCK = 500  # drives between two lines of progress
UNMEASURED = 1.0  # objective of a drive that measured nothing, or that the constraints exclude: far from failing


@dataclasses.dataclass(frozen=True)
class Stack:
    """Where a stack with planted faults lies in `benchmarks`, the scenario, and the seconds of a drive [s]."""

    source: str
    scenario: str
    seconds: float


@dataclasses.dataclass(frozen=True)
class Fault:
    """Metric and greatest value of the gate that a fault of a stack breaks."""

    stack: str
    metric: str
    most: float

    @property
    def gate(self) -> str:
        """It in a gate file."""
        return f'[[gate]]\nmetric = "{self.metric}"\nmax = {self.most:g}\n'


STACKS = {
    "follow": Stack("planted_follow.py:Follower", "follow.xosc", 10.0),  # until the bend, where it goes straight on
    "cut_in": Stack("planted_cut_in.py:Yielder", "cut_in.xosc", 7.0),  # until both have found their speed
    "child": Stack("planted_child.py:Watcher", "occluded_child.xosc", 6.0),  # until the ego stands or is past
}
FAULTS = {
    "old_sight": Fault("follow", "collision", 0.0),
    "slammed": Fault("follow", "max_deceleration", 4.9),  # m/s^2
    "parked_label": Fault("cut_in", "collision", 0.0),
    "undecided": Fault("cut_in", "accel_roughness", 37.45),  # m/s^3
    "pillar": Fault("child", "collision", 0.0),
    "wrong_row": Fault("child", "max_deceleration", 4.9),  # m/s^2
}
SILENT = '[[gate]]\nmetric = "events_fired"\nmax = 1000\n'  # a drive that ends before an event counts all the same


@contextmanager
def planted(
    stack: Stack, faults: Sequence[Fault], out: Path | None = None, kind: type[Campaign] = Campaign
) -> Iterator[Campaign]:
    """The campaign of a stack that the gates of these faults judge, and nothing else."""
    source = str(ROOT / "benchmarks" / stack.source)
    judged = "".join(fault.gate for fault in faults) + SILENT
    with unmeasured(), campaign(source, stack.seconds, judged, out, stack.scenario, kind) as one:
        yield one


def chance(stack: str, count: int = 20_000, seed: int = 1) -> None:
    """How rare the faults of a stack are among evenly drawn variants."""
    faults = {name: fault for name, fault in FAULTS.items() if fault.stack == stack}
    failed: dict[str, list[int]] = {name: [] for name in faults}
    done = 0
    with planted(STACKS[stack], list(faults.values()), STORE / stack) as one:
        points = sample("random", one.space.axes, count, seed)
        for begin in range(0, count, BLOCK):
            for row in checked(one.rows(points[begin : begin + BLOCK], "sample")):
                done += 1
                for name, fault in faults.items():
                    if (row.metrics[fault.metric] or 0.0) > fault.most:
                        failed[name].append(done)
            hits = {name: len(at) for name, at in failed.items()}
            print(f"\r{done} of {count}: {hits}", end="", file=sys.stderr)
    print(file=sys.stderr)
    for name, at in failed.items():
        p = clopper_pearson(len(at), 0, done)
        first, middle, last = (math.log(2.0) / each if each else math.inf for each in (p.high, p.estimate, p.low))
        print(f"{name}: {p.text()}; median of chance: {middle:.0f} drives, between {first:.0f} and {last:.0f}")
        budget = round(middle / 5.0) if at else 0
        blocks = done // budget if budget else 0
        found = len({(k - 1) // budget for k in at if k <= blocks * budget}) if budget else 0
        print(f"{name}: within {budget} drives in {found} of {blocks} blocks of these draws")


def checked(rows: Sequence[Row]) -> Sequence[Row]:
    """The rows. Raises SystemExit if a drive broke: it says nothing about a fault."""
    for row in rows:
        if row.verdict == "ERROR":
            raise SystemExit(row.message)
    return rows


class Found(Exception):
    """A drive failed: the search is over."""


class UntilFailure(Campaign):
    """A campaign that ends with its first failure."""

    def rows(self, points: Sequence[Shares], purpose: str) -> list[Row]:
        """A row for each point, one after the other. Raises Found."""
        rows: list[Row] = []
        for point in points:
            rows += checked(super().rows([point], purpose))
            if rows[-1].failed:
                raise Found
        return rows


def searched(fault: str, method: str, budget: int, seeds: int = 20, first: int = 100) -> None:
    """After how many drives a method finds a fault, by seed; 0 where it does not."""
    found: list[int] = []
    planned = FAULTS[fault]
    for seed in range(first, first + seeds):
        with planted(STACKS[planned.stack], [planned], kind=UntilFailure) as one:
            try:
                PEERS.get(method, search_by(method))(one, budget, seed)
                found.append(0)
            except Found:
                found.append(one.progress.driven)
        print(f"\r{fault}, {method}: {found}", end="", file=sys.stderr)
    print(file=sys.stderr)
    hits = [k for k in found if k]
    p = clopper_pearson(len(hits), 0, seeds)
    middle = np.median([k or math.inf for k in found])
    share = f"({p.low:.2f} to {p.high:.2f})"
    told = f"median {middle:g}, last {max(hits, default=0)}"
    print(f"{fault}, {method}: within {budget} drives in {len(hits)} of {seeds} seeds {share}, {told}; {sorted(found)}")


def search_by(name: str) -> Callable[[Campaign, int, int], object]:
    """A method of `dvp campaign`."""
    return lambda one, budget, seed: search(one, name, budget, seed)


def _driven(one: Campaign, at: Shares) -> float:
    """Drives a point if the constraints allow it. The objective; below 0 for a failure."""
    rows = one.rows([at], "search")
    return UNMEASURED if not rows or rows[0].objective is None else rows[0].objective


def _optuna(one: Campaign, budget: int, seed: int) -> None:
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=seed))
    for _ in range(budget):
        trial = study.ask()
        at = tuple(trial.suggest_float(str(k), 0.0, 1.0) for k in range(len(one.space.axes)))
        study.tell(trial, _driven(one, at))


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


def _verifai(one: Campaign, budget: int, seed: int, kind: str) -> None:
    """VerifAI's sampler in a process of its own: a line with a point comes, a line with its objective goes."""
    python = os.environ.get("DVP_VERIFAI", "")
    if not python:
        raise SystemExit("DVP_VERIFAI is not set: the Python of an environment in which VerifAI is installed")
    command = [python, "-c", PEER, kind, str(len(one.space.axes)), str(seed)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as peer:
        assert peer.stdin is not None
        assert peer.stdout is not None
        try:
            for _ in range(budget):
                score = _driven(one, tuple(json.loads(peer.stdout.readline())))
                peer.stdin.write(f"{score}\n")
                peer.stdin.flush()
        finally:
            peer.kill()


def _sampler(kind: str) -> Callable[[Campaign, int, int], None]:
    return lambda one, budget, seed: _verifai(one, budget, seed, kind)


PEERS: dict[str, Callable[[Campaign, int, int], object]] = {
    "hypothesis": search_by_hypothesis,
    "optuna-tpe": _optuna,
    **{f"verifai-{kind}": _sampler(kind) for kind in ("ce", "mab", "halton")},
}


def main() -> None:
    """Run what the first word names."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_subparsers(dest="what", required=True)
    counted, looked = what.add_parser("chance"), what.add_parser("search")
    counted.add_argument("stack", choices=list(STACKS))
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
