"""Mutation test of what names, judges and drives:  python -m scripts.mutants [--minutes 35] [--size 600]

Takes a sample of mutants from a fixed seed (mutant_sample.py), judges each by the tests of its file (mutant_tests.py),
and prints how many were killed, with a 95 % interval, and the survivors. Each verdict is kept in runs/mutants as soon
as it is there, and is used again as long as neither the mutated file nor a test that judged it has changed. So a run
that was cut short goes on where it was.
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
from functools import cache
from pathlib import Path

from scripts.decision_constants import MovedConstant, moved_constants
from scripts.mutant_run import Checkout, run_tests, warm_up
from scripts.mutant_sample import FOLDERS, ROOT, SEED, SIZE, Mutant, sample
from scripts.mutant_tests import ROOMS, judges, times

KEPT = ROOT / "runs" / "mutants"
_SLOWER = 3.0  # times as long as without a mutant, and
_COMPILING = 90.0  # s more, because most folders compile code: beyond that a mutant counts as endless


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


def verdict(row: Mapping[str, str] | None, tests: Sequence[str]) -> str:
    """What an earlier run has found, "" if a test has changed since then: for a mutant that was killed the one that
    killed it, for a survivor any."""
    if row is None:
        return ""
    judges = tests if row["verdict"] == "survived" else [row["by"]] if row["by"] else []
    return row["verdict"] if digest(*judges) == row["tests"] else ""


def seconds(tests: Sequence[str]) -> float:
    """CPU time after which a mutant counts as endless."""
    return _COMPILING + _SLOWER * sum(times().get(name, 10.0) for name in tests)


def difference(mutant: Mutant | MovedConstant) -> list[str]:
    """The changed lines, the old ones with a minus and the new ones with a plus."""
    original = (ROOT / mutant.path).read_text(encoding="utf-8")
    lines = difflib.unified_diff(original.splitlines(), mutant.source(original).splitlines(), lineterm="", n=0)
    return [line for line in lines if line[:1] in "+-" and line[:3] not in ("+++", "---")]


def judge(chosen: Sequence[Mutant | MovedConstant], minutes: float, place: Path) -> list[Judged]:
    """Judge the mutants in their order until the time is over; those judged before cost nothing."""
    verdicts = KEPT / "verdicts.jsonl"
    KEPT.mkdir(parents=True, exist_ok=True)
    known: dict[str, dict[str, str]] = {}
    if verdicts.exists():
        rows = [json.loads(line) for line in verdicts.read_text(encoding="utf-8").splitlines() if line.endswith("}")]
        known = {row["key"]: row for row in rows}
    ends = time.monotonic() + 60.0 * minutes
    checkout: Checkout | None = None
    passed = KEPT / "sound.txt"
    sound = set(passed.read_text(encoding="utf-8").split()) if passed.exists() else set()
    judged = []
    for mutant in chosen:
        tests = judges(mutant.path, mutant.folder)
        result = verdict(known.get(key(mutant)), tests)
        if not result:
            if time.monotonic() > ends:
                continue
            if checkout is None:
                warm_up()
                checkout = Checkout(place)
            for test in tests:
                if (state := _state(test)) not in sound:
                    if run_tests(checkout.place, [test], seconds=600.0, keep=True)[0] != "survived":
                        raise SystemExit(f"{test} fails without any change")
                    sound.add(state)
                    _add_line(passed, state)
            checkout.keep_machine_code()
            begun = time.monotonic()
            with checkout.changed(mutant):
                result, by = run_tests(checkout.place, tests, seconds=seconds(tests))
            judging = tests if result == "survived" else [by] if by else []
            row = {"key": key(mutant), "verdict": result, "by": by, "tests": digest(*judging), "mutant": mutant.name}
            _add_line(verdicts, json.dumps(row))
            print(f"{time.monotonic() - begun:7.1f} s  {result:15} {mutant.name}  {by}", flush=True)
        judged.append(Judged(mutant, result))
    return judged


def _add_line(path: Path, line: str) -> None:
    with path.open("a", encoding="utf-8") as out:
        out.write(line + "\n")


@cache
def _sources() -> bytes:
    """Digest of all modules that a test may use."""
    digest = hashlib.sha256()
    for room in ROOMS:
        for path in sorted((ROOT / room).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.digest()


@cache
def _state(test: str) -> str:
    """Digest of a test file and of all modules: a test that has passed in this state need not be run again."""
    return hashlib.sha256(_sources() + test.encode() + (ROOT / test).read_bytes()).hexdigest()[:20]


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
    options = parser.parse_args()
    os.environ.setdefault("DVP_SHARED", str(ROOT.parent / "shared"))
    every = list(moved_constants()) if options.constants else sample(options.size, options.seed)
    chosen = [mutant for mutant in every if mutant.path.startswith(options.only)]
    first, step = map(int, options.part.split("/"))
    chosen = chosen[first::step]
    judged = judge(chosen, options.minutes, KEPT / options.place)
    print(f"\n{len(judged)} of {len(chosen)} mutants judged (seed {options.seed})")
    print("" if options.constants else "\n".join(table(judged)), end="\n\n")
    for one in judged:
        if one.verdict == "survived":
            print(f"{one.mutant.name}", *(f"    {line}" for line in difference(one.mutant)), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
