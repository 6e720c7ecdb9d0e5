"""python -m benchmarks.foreign_cars --seed HEX [--cases N] [--json F] [--resume] [--out docs/foreign_cars.md]

Asks the diagnosis about cars of another make; needs `mujoco` (in the extra `dev`). Every answer is a line of the JSON
file as soon as it is there; --resume goes on after a kill. Matched twins are kept beside that file.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):  # before numpy loads: CPU of one core
    os.environ.setdefault(_name, "1")

from benchmarks.foreign_cars.ask import ask  # noqa: E402
from benchmarks.foreign_cars.case import cases  # noqa: E402
from benchmarks.foreign_cars.table import page  # noqa: E402


def _seed(text: str) -> str:
    int(text, 16)  # a ValueError becomes argparse's one line
    return text


def main() -> int:
    """Returns 0: the figures are the result."""
    parser = argparse.ArgumentParser(description="Cars of another make: is what they lack named?")
    rule = "first 8 digits of the commit that froze the rule"
    parser.add_argument("--seed", required=True, type=_seed, metavar="HEX", help=rule)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--part", default="0/1", metavar="K/N", help="every Nth case, from the Kth on")
    parser.add_argument("--no-bare", action="store_true", help="leave out the bare cars, which take minutes each")
    parser.add_argument("--json", type=Path, default=Path("runs/foreign_cars/answers.jsonl"), metavar="F")
    parser.add_argument("--resume", action="store_true", help="go on with the answers that F has")
    parser.add_argument("--out", type=Path, metavar="F", help="write the page")
    args = parser.parse_args()
    lines: list[dict[str, Any]] = []
    if args.resume and args.json.exists():
        lines = [json.loads(text) for text in args.json.read_text("utf-8").splitlines()]
    known = {line["key"] for line in lines}
    part, parts = map(int, args.part.split("/"))
    args.json.parent.mkdir(parents=True, exist_ok=True)
    wanted = cases(args.seed)[: args.cases]
    for k, case in enumerate(wanted):
        if case.key in known or k % parts != part or (args.no_bare and case.category == "bare"):
            continue
        line = ask(case, args.json.parent / f"twins-{args.seed}")
        lines.append(line)
        said = ", ".join(f"{e['name']} ({e['standing']})" for e in line["effects"]) or "-"
        print(f"{k + 1}/{len(wanted)} {line['key']}: {line['verdict']} {said} ({line.get('cpu', 0):.0f} s)",
              file=sys.stderr, flush=True)  # fmt: skip
        with args.json.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
    if args.out:
        args.out.write_text(page(lines, args.seed), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
