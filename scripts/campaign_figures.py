"""Measures the figures of docs/campaigns.md: cost of a drive, searchers against chance, coverage of the intervals.

    python -m scripts.campaign_figures cost | coverage [REPEATS] [FIRST_SEED] | chance [DRIVES] | search NAME [SEEDS]
        | driven [REPEATS] [FIRST_SEED] | workers [REPEATS] [DRIVES]

`make campaigns` runs all but the last two. `workers` runs the same campaign with one and with two processes, on a
machine that does nothing else. `chance` drives evenly drawn variants of the planted fault; `search` says after
how many drives a searcher finds it, beside the median of chance, ln 2 / p; `driven` counts a failure of about 1 % in
20,000 even drives, and says how often the interval of `rare` with 1,000 drives holds that count.
"""

from __future__ import annotations

import argparse
import inspect
import itertools
import math
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from scipy.stats import norm

from pytest_dvp.campaigns.campaign import Campaign
from pytest_dvp.campaigns.crew import LocalCrew
from pytest_dvp.campaigns.critical_search import search
from pytest_dvp.campaigns.measured_probability import counted_probability, measured_probability
from pytest_dvp.campaigns.one_drive import drive
from pytest_dvp.campaigns.parameter_space import space_of
from pytest_dvp.campaigns.rare_failures import Judge, rare_probability
from pytest_dvp.campaigns.sampling import sample
from pytest_dvp.campaigns.store import Store
from pytest_dvp.drive import run_folder
from pytest_dvp.drive.run_spec import RunSpec
from scenarios import path as shipped

ROOT = Path(__file__).parents[1]
STACKS = ROOT / "benchmarks" / "late_brake.py"
GATES = '[[gate]]\nmetric = "collision"\nmax = 0\n[[gate]]\nmetric = "events_fired"\nmax = 1000\n'
SECONDS = 9.0  # s of a drive with the planted fault: until all have stopped
BUDGET = 150  # drives of a search
RUNS = 2000  # drives of a measured probability


@contextmanager
def campaign(
    stack: str, seconds: float, gates: str = GATES, out: Path | None = None, scenario: str = "follow.xosc",
    kind: type[Campaign] = Campaign,
) -> Iterator[Campaign]:  # fmt: skip
    """A shipped scenario with a stack, FILE:CLASS, in the store `out`, or in one that is thrown away."""
    with tempfile.TemporaryDirectory() as folder:
        judged = Path(folder) / "planted.gates.toml"
        judged.write_text(gates, encoding="utf-8")
        settings = RunSpec(ads=stack, gates=judged, duration=seconds, stack_process="off", rootdir=ROOT)
        with Store(out or Path(folder) / "out", writes=True) as store, LocalCrew(1, drive) as crew:
            yield kind(space_of(shipped(scenario), settings), settings, store, crew, keep="none")


def cost() -> None:
    """Drives a CPU minute, warm, with the store's row written and no run folder."""
    for seconds, stack in itertools.product((SECONDS, 40.0), ("TenLines", "AllSensors")):
        with campaign(f"{STACKS}:{stack}", seconds) as one:
            points = sample("random", one.space.axes, 62, 7)
            one.rows(points[:2], "sample")
            before = time.process_time()
            one.rows(points[2:], "sample")
            rate = 60.0 * 60 / (time.process_time() - before)
            print(f"{stack}, {seconds:g} s: {rate:.0f} drives a CPU minute", flush=True)


def workers(repeats: int = 5, drives: int = 500) -> None:
    """How many times faster two processes are than one, and what they cost more: a whole command, with the drives that
    shrink failures, and the map."""
    rows = []
    for _ in range(repeats):
        (one, cpu), (two, more) = (_campaign_with(jobs, drives) for jobs in (1, 2))
        rows.append((one / two, more / cpu))
        print(f"{one:.1f} s and {two:.1f} s: {rows[-1][0]:.2f} times; CPU {more / cpu - 1.0:+.1%}", flush=True)
    faster, dearer = np.median(rows, axis=0)
    print(f"median: {faster:.2f} times; CPU {dearer - 1.0:+.1%}", flush=True)


def _campaign_with(jobs: int, drives: int) -> tuple[float, float]:
    """Wall time and CPU [s] of a campaign by its command. Raises SystemExit with one line where a drive is missing."""
    words = ["campaign", str(shipped("follow.xosc")), "--method", "random", "--runs", str(drives), "--seed", "7"]
    words += ["--ads", f"{STACKS}:TenLines", "--duration", "40", "--keep-logs", "none", "--stack-process", "off"]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        words += ["--jobs", str(jobs), "--out", str(out)]
        before, began = _cpu_of_children(), time.monotonic()
        # the exit code tells of failures found, so the rows tell whether it ran
        ran = subprocess.run([str(Path(sys.executable).with_name("dvp")), *words], cwd=ROOT, capture_output=True)
        taken = time.monotonic() - began, _cpu_of_children() - before
        with Store(out) as store:
            count = len(store.rows())
    if count < drives:
        raise SystemExit(f"{jobs} processes drove {count} of {drives}: {ran.stderr.decode().strip()[-300:]}")
    return taken


def _cpu_of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def chance(count: int = 2000) -> None:
    """The prevalence of the planted fault among evenly drawn variants."""
    with campaign(f"{STACKS}:LateBrake", SECONDS) as one:
        rows = one.rows(sample("random", one.space.axes, count, 7), "sample")
        found = counted_probability(rows)
        print(found.text())
        median = [math.log(2.0) / p if p else math.inf for p in (found.high, found.estimate, found.low)]
        print("median of chance: {1:.0f} drives, between {0:.0f} and {2:.0f}".format(*median), flush=True)


def driven(repeats: int = 20, first_seed: int = 0, count: int = 20_000, runs: int = 1000) -> None:
    """How often the interval of `rare` holds what many even drives of the same failure have counted."""
    stack = f"{STACKS}:LaterBrake"
    with unmeasured(), campaign(stack, SECONDS, out=ROOT / "runs" / "driven") as one:
        points = sample("random", one.space.axes, count, 11)
        rows = [row for begin in range(0, count, 500) for row in one.rows(points[begin : begin + 500], "sample")]
    counted = counted_probability(rows)
    print(f"counted in {count} even drives: {counted.text()}", flush=True)
    held = 0
    for seed in range(first_seed, first_seed + repeats):
        with unmeasured(), campaign(stack, SECONDS) as one:
            found = measured_probability(one, runs, seed)
        held += found.low <= counted.estimate <= found.high
        print(f"seed {seed}: {found.text()}", flush=True)
    print(f"rare, {runs} drives: holds it in {held} of {repeats}", flush=True)


@contextmanager
def unmeasured() -> Iterator[None]:
    """Drives judged by their gates alone: all other metrics take a quarter of the time of a short drive."""
    measure = run_folder.measure
    run_folder.measure = lambda log: {}
    try:
        yield
    finally:
        run_folder.measure = measure


def searched(name: str, seeds: int = 10) -> None:
    """After how many drives a searcher finds the planted fault, by seed."""
    first = []
    for seed in range(seeds):
        with campaign(f"{STACKS}:LateBrake", SECONDS) as one:
            rows = search(one, name, BUDGET, seed)
            first.append(next((k + 1 for k, row in enumerate(rows) if row.failed), BUDGET + 1))
    print(f"{name}: median {np.median(first):g} of {sorted(first)}", flush=True)


def half_space(size: int, p: float) -> Judge:
    """Fails beyond a plane."""
    return lambda u: -norm.ppf(p) - norm.ppf(np.clip(u, 1e-16, 1.0 - 1e-16)).sum(axis=1) / np.sqrt(size)


def two_sides(size: int, p: float) -> Judge:
    """Fails in two regions on opposite sides."""
    return lambda u: -norm.ppf(p / 2) - np.abs(norm.ppf(np.clip(u[:, 0], 1e-16, 1.0 - 1e-16)))


def corner(size: int, p: float) -> Judge:
    """Fails in a corner of the cube."""
    return lambda u: (1.0 - p ** (1.0 / size)) - u.min(axis=1)


def coverage(repeats: int = 200, first_seed: int = 0) -> None:
    """How often the interval holds a known probability, and how many drives plain counting needs for the same error."""
    problems: tuple[Callable[[int, float], Judge], ...] = (half_space, two_sides, corner)
    for problem in problems:
        for size in (2, 5):
            for p in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
                seeds = range(first_seed, first_seed + repeats)
                found = [rare_probability(problem(size, p), size, RUNS, seed) for seed in seeds]
                holds = float(np.mean([each.low <= p <= each.high for each in found]))
                error = math.sqrt(np.mean([(each.estimate / p - 1.0) ** 2 for each in found]))
                gain = (1.0 - p) / p / error**2 / RUNS
                print(
                    f"{problem.__name__} {size} parameters, p {p:g}: holds it in {100 * holds:.0f} %, relative error "
                    f"{100 * error:.0f} %, {gain:.0f} times fewer drives than counting",
                    flush=True,
                )


def main() -> None:
    """Run what the first word names."""
    parts: dict[str, Callable[..., None]] = {
        "cost": cost, "coverage": coverage, "chance": chance, "search": searched, "driven": driven, "workers": workers,
    }  # fmt: skip
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("part", choices=parts)
    parser.add_argument("words", nargs="*", metavar="WORD", help="of search: the name; then numbers, as listed above")
    asked = parser.parse_args()
    part = parts[asked.part]
    least, most = (1 if part is searched else 0), len(inspect.signature(part).parameters)
    if not least <= len(asked.words) <= most:
        parser.error(f"{asked.part}: found {len(asked.words)} words after it, allowed: {least} to {most}")
    try:
        numbers = [int(word) for word in asked.words[least:]]
    except ValueError:
        parser.error(f"{asked.part}: found {' '.join(asked.words[least:])}, allowed: whole numbers")
    part(*asked.words[:least], *numbers)


if __name__ == "__main__":
    main()
