"""python -m benchmarks.hidden_effects [--subset N] [--jobs 2] [--json F] [--resume] [--out docs/hidden_effects.md]

Asks the diagnosis the whole matrix of hidden effects, or a stratified part of it, and prints the figures beside the
goals. Every answer is a line of the JSON file as soon as it is there; --resume goes on after a kill.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):  # before numpy loads: CPU of one core
    os.environ.setdefault(_name, "1")

from benchmarks.hidden_effects.case import Case, cases, strata  # noqa: E402
from benchmarks.hidden_effects.table import answer, missed, page  # noqa: E402
from benchmarks.hidden_effects.work import ask, warm_up  # noqa: E402


def known_lines(path: Path, base_seed: int) -> dict[str, dict[str, Any]]:
    """The answers of an earlier run by key; a line cut short by a kill is left out."""
    found: dict[str, dict[str, Any]] = {}
    if path.exists():
        for text in path.read_text(encoding="utf-8").splitlines():
            try:
                line = json.loads(text)
            except ValueError:
                continue
            if line.get("base_seed") == base_seed:
                found[line["key"]] = line
    return found


def run(wanted: list[Case], path: Path | None, *, jobs: int, resume: bool, base_seed: int) -> list[dict[str, Any]]:
    """The answers to the wanted cases, in their order; those asked now are appended to the file one by one."""
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor, as_completed

    answers = known_lines(path, base_seed) if path and resume else {}
    if path:
        path.parent.mkdir(parents=True, exist_ok=True)
        kept = "".join(json.dumps(line) + "\n" for line in answers.values())
        path.write_text(kept, encoding="utf-8")
    left = [case for case in wanted if case.key not in answers]
    begin = time.monotonic()
    spawn = multiprocessing.get_context("spawn")
    # not a Pool: that one starts a worker whose warm-up failed again and again, for ever
    with ProcessPoolExecutor(jobs, spawn, initializer=warm_up) as pool:
        futures = [pool.submit(ask, case) for case in left]
        for count, future in enumerate(as_completed(futures), 1):
            line = future.result()
            answers[line["key"]] = line
            if path:
                with path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(line) + "\n")
            mark = "MISS " if missed(line) else ""
            rest = (time.monotonic() - begin) / count * (len(left) - count)
            print(f"{count}/{len(left)} {rest:.0f} s left: {mark}{line['key']}: {answer(line)}", file=sys.stderr)
    return [answers[case.key] for case in wanted]


def main(argv: list[str] | None = None) -> int:
    """Returns 0, the figures are the result; 1 if fewer cases than --at-least meet their goal, or one raised."""
    parser = argparse.ArgumentParser(prog="benchmarks.hidden_effects", description=(__doc__ or "").split("\n\n")[1])
    parser.add_argument("--subset", type=int, metavar="N", help="only N cases, a stratified sample; default: all")
    parser.add_argument("--only", action="append", choices=tuple(strata()), help="only this category; repeatable")
    parser.add_argument("--effect", action="append", metavar="NAME", help="only cases that hide it; repeatable")
    parser.add_argument("--seed", type=int, default=1000, help="base of all dice; another one gives fresh cases")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", type=Path, metavar="F", help="answers, one JSON line a case")
    parser.add_argument("--resume", action="store_true", help="go on with the answers that F has")
    parser.add_argument("--out", type=Path, metavar="F.md", help="write the page there as well")
    parser.add_argument("--advised", type=Path, metavar="F", help="answers of benchmarks.hidden_effects.deciding")
    parser.add_argument("--at-least", type=float, metavar="SHARE", help="exit code 1 if fewer cases meet their goal")
    args = parser.parse_args(argv)
    if args.resume and args.json is None:
        parser.error("--resume needs --json F")
    everything = cases(args.seed)
    wanted = [
        case
        for case in everything
        if (not args.only or case.category in args.only) and (not args.effect or set(args.effect) & set(case.names))
    ][: args.subset]
    lines = run(wanted, args.json, jobs=args.jobs, resume=args.resume, base_seed=args.seed)
    advised = [json.loads(text) for text in args.advised.read_text("utf-8").splitlines()] if args.advised else []
    text = page(lines, args.seed, len(everything), advised)
    print(text)
    if args.out:
        args.out.write_text(text, encoding="utf-8")
    if args.at_least is not None:
        met = sum(1 for line in lines if not missed(line)) / max(len(lines), 1)
        raised = sum(1 for line in lines if line["verdict"] == "ERROR")
        print(f"{met:.3f} of the cases meet their goal, {raised} raised", file=sys.stderr)
        return 1 if met < args.at_least or raised else 0
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
