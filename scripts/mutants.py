"""Mutation test of what names, judges and drives:  python -m scripts.mutants [--minutes 35] [--size 600]

Takes a sample of mutants from a fixed seed (mutant_sample.py), judges each by the tests that execute its line
(mutant_coverage.py, mutant_session.py; of compiled code those of its file, mutant_tests.py), and prints how many were
killed, with a 95 % interval, and the survivors. Each verdict is kept in runs/mutants as soon as it is there, and is
used again as long as neither the mutated file nor a test that judged it has changed. So a run that was cut short goes
on where it was.
"""

from __future__ import annotations

import argparse
import difflib
import hashlib
import json
import math
import os
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from scripts.decision_constants import MovedConstant, moved_constants
from scripts.mutant_coverage import Coverage, Tests, candidates
from scripts.mutant_run import Checkout, run_tests, warm_up
from scripts.mutant_sample import FOLDERS, ROOT, SEED, SIZE, Mutant, sample
from scripts.mutant_session import Session
from scripts.mutant_tests import judges

KEPT = ROOT / "runs" / "mutants"
BUDGET = 10.0  # s of CPU, of the tests that judge one mutant
_SLOWER = 3.0  # times as long as without a mutant, and
_COMPILING = 30.0  # s more, because most folders compile code: beyond that a mutant counts as endless


@dataclass(frozen=True)
class Judged:
    """A mutant and what became of it: "killed", "killed by time" or "survived"."""

    mutant: Mutant | MovedConstant
    verdict: str


def wilson(successes: int, count: int, z: float = 1.959964) -> tuple[float, float]:
    """Wilson's interval for a share, by default of 95 %. Raises ZeroDivisionError for a count of 0."""
    share = successes / count
    middle = share + z * z / (2.0 * count)
    spread = z * math.sqrt(share * (1.0 - share) / count + z * z / (4.0 * count * count))
    whole = 1.0 + z * z / count
    return (middle - spread) / whole, (middle + spread) / whole


def digest(*parts: str) -> str:
    """Digest of texts and, for names of files, of what is in them."""
    found = hashlib.sha256()
    for part in parts:
        found.update(part.encode() + b"\n")
        if (ROOT / part).is_file():
            found.update((ROOT / part).read_bytes())
    return found.hexdigest()[:20]


def key(mutant: Mutant | MovedConstant) -> str:
    """Digest of the mutated source."""
    return digest(mutant.operator, str(mutant.occurrence), mutant.path)


def verdict(row: Mapping[str, str] | None, tests: Tests) -> str:
    """What an earlier run has found, "" if a test has changed since then: for a mutant that was killed the one that
    killed it, for a survivor any."""
    if row is None:
        return ""
    by = row["by"].partition("::")[0]
    files = tests.files if row["verdict"] == "survived" else [by] if by else []
    return row["verdict"] if digest(*files) == row["tests"] else ""


def difference(mutant: Mutant | MovedConstant) -> list[str]:
    """The changed lines, the old ones with a minus and the new ones with a plus."""
    original = (ROOT / mutant.path).read_text(encoding="utf-8")
    lines = difflib.unified_diff(original.splitlines(), mutant.source(original).splitlines(), lineterm="", n=0)
    return [line for line in lines if line[:1] in "+-" and line[:3] not in ("+++", "---")]


def judge(chosen: Sequence[Mutant | MovedConstant], minutes: float, place: Path, budget: float) -> list[Judged]:
    """Judge the mutants in their order until the time is over; those judged before cost nothing.

    budget: CPU time of the tests that judge one mutant [s].
    """
    KEPT.mkdir(parents=True, exist_ok=True)
    verdicts = KEPT / "verdicts.jsonl"
    known: dict[str, dict[str, str]] = {}
    if verdicts.exists():
        rows = [json.loads(line) for line in verdicts.read_text(encoding="utf-8").splitlines() if line.endswith("}")]
        known = {row["key"]: row for row in rows}
    warm_up()
    checkout = Checkout(place)
    files = sorted({file for folder in {mutant.folder for mutant in chosen} for file in candidates(folder)})
    session = Session(checkout, files)
    covered = Coverage(KEPT / "coverage.jsonl", files, session)
    ends = time.monotonic() + 60.0 * minutes
    judged = []
    for mutant in chosen:
        tests = covered.tests(mutant.path, mutant.line, budget)
        seen = bool(tests.items)
        if not seen:  # compiled code executes no lines
            names = tuple(judges(mutant.path, mutant.folder, covered.seconds))
            tests = Tests(names, sum(covered.seconds.get(name, 10.0) for name in names))
        result = verdict(known.get(key(mutant)), tests)
        if not result:
            if time.monotonic() > ends:
                continue
            begun = time.monotonic()
            limit = _COMPILING + _SLOWER * tests.seconds
            checkout.keep_machine_code()
            with checkout.changed(mutant):
                found = session.judge(mutant.path, mutant.line, tests.items, limit) if seen else None
                way = "swapped" if found else "imported"
                result, by = found or run_tests(checkout.place, tests.items, seconds=limit)
            judging = tests.files if result == "survived" else [by.partition("::")[0]] if by else []
            row = {"key": key(mutant), "verdict": result, "by": by, "tests": digest(*judging), "mutant": mutant.name}
            _add_line(verdicts, json.dumps(row))
            print(f"{time.monotonic() - begun:7.1f} s  {way:9}{result:15} {mutant.name}  {by}", flush=True)
        judged.append(Judged(mutant, result))
    session.end()
    return judged


def _add_line(path: Path, line: str) -> None:
    with path.open("a", encoding="utf-8") as out:
        out.write(line + "\n")


def table(judged: Sequence[Judged]) -> list[str]:
    """Mutants, killed ones and their share with its interval, by folder and in all, as a table of Markdown."""
    out = ["| folder | mutants | killed | share | 95 % interval |", "|---|--|--|--|--|"]
    for name, of_it in [*((f, [j for j in judged if j.mutant.folder == f]) for f in FOLDERS), ("all", list(judged))]:
        if of_it:
            killed = sum(j.verdict != "survived" for j in of_it)
            low, high = wilson(killed, len(of_it))
            share = f"{100 * killed / len(of_it):.1f} %"
            out.append(f"| {name} | {len(of_it)} | {killed} | {share} | {100 * low:.1f} to {100 * high:.1f} % |")
    return out


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=math.inf, help="time after which no further mutant is begun")
    parser.add_argument("--size", type=int, default=SIZE, help="mutants in the sample")
    parser.add_argument("--seed", type=int, default=SEED, help="seed of the sample")
    parser.add_argument("--only", default="", help="beginning of the paths that are judged, for a look at one file")
    parser.add_argument("--constants", action="store_true", help="move each constant that decides, not the sample")
    parser.add_argument("--part", default="0/1", help="K/N: each Nth mutant from the Kth on, for several processes")
    parser.add_argument("--place", default="checkout", help="name of the copy of the checkout, one for each run")
    parser.add_argument("--budget", type=float, default=BUDGET, help="s of CPU, of the tests that judge one mutant")
    options = parser.parse_args()
    os.environ.setdefault("DVP_SHARED", str(ROOT.parent / "shared"))
    every = list(moved_constants()) if options.constants else sample(options.size, options.seed)
    chosen = [mutant for mutant in every if mutant.path.startswith(options.only)]
    first, step = map(int, options.part.split("/"))
    chosen = chosen[first::step]
    judged = judge(chosen, options.minutes, KEPT / options.place, options.budget)
    print(f"\n{len(judged)} of {len(chosen)} mutants judged (seed {options.seed})")
    print("" if options.constants else "\n".join(table(judged)), end="\n\n")
    for one in judged:
        if one.verdict == "survived":
            print(f"{one.mutant.name}", *(f"    {line}" for line in difference(one.mutant)), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
