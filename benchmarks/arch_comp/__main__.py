"""python -m benchmarks.arch_comp [--problem AT1] [--method random] [--seed 0] [--alone] [--json FILE] [--out PAGE]

Searches that falsify the vehicle problems of ARCH-COMP: 10 of each method, of at most 300 simulations. Prints how many
of them falsified, and the mean and median of their simulations. All take 2.5 minutes of CPU.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import sys
import warnings
from pathlib import Path

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):  # before numpy loads: CPU of one core
    os.environ.setdefault(_name, "1")

from benchmarks.arch_comp.problems import PROBLEMS  # noqa: E402
from benchmarks.arch_comp.table import table, written_into  # noqa: E402
from benchmarks.arch_comp.trial import METHODS, Trial, tried  # noqa: E402


def main() -> int:
    """Search on all problems, print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.arch_comp", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = [problem.name for problem in PROBLEMS]
    parser.add_argument("--problem", action="append", choices=names, help="only this one")
    parser.add_argument("--method", action="append", choices=METHODS, help="only this one")
    parser.add_argument("--seed", type=int, default=0, help="of the first search; the next ones follow")
    parser.add_argument("--repeats", type=int, default=10)
    parser.add_argument("--budget", type=int, default=300, help="simulations of a search")
    parser.add_argument(
        "--alone", action="store_true", help="the searcher alone, without what a campaign does around it"
    )
    parser.add_argument("--json", type=Path, help="where all trials are written")
    parser.add_argument("--out", type=Path, help="page in which the table is replaced")
    given = parser.parse_args()
    if given.out and not given.out.is_file():
        parser.error(f"--out {given.out}: there is no such page, in which a table could be replaced")
    if given.json and not given.json.parent.is_dir():
        parser.error(f"--json {given.json}: there is no such folder")
    for name, least in (("seed", 0), ("repeats", 1), ("budget", 1)):
        if getattr(given, name) < least:
            parser.error(f"--{name}: must be {least} or more (found {getattr(given, name)})")
    warnings.filterwarnings("ignore", module="cma")
    trials: list[Trial] = []
    for problem in PROBLEMS:
        if given.problem and problem.name not in given.problem:
            continue
        for method in given.method or METHODS:
            for seed in range(given.seed, given.seed + given.repeats):
                trials.append(tried(problem, method, seed, given.budget, alone=given.alone))
            print(f"\r{problem.name}, {method}          ", end="", file=sys.stderr)
    print(f"\r{sum(one.cpu for one in trials):.0f} s of CPU                    ", file=sys.stderr)
    if given.json:
        given.json.write_text(json.dumps([dataclasses.asdict(one) for one in trials], indent=1), encoding="utf-8")
    print(table(trials))
    if given.out:
        page, mark = given.out.read_text(encoding="utf-8"), "alone" if given.alone else "campaign"
        given.out.write_text(written_into(page, mark, table(trials)), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
