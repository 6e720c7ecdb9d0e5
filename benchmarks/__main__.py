"""`python -m benchmarks [NAME...]`: runs every bench_*.py and writes the table."""

from __future__ import annotations

import argparse
import importlib
import os
import platform
import sys
from pathlib import Path

from benchmarks.measure import Row

FOLDER = Path(__file__).parent
TABLE = FOLDER.parent / "docs" / "benchmarks.md"


def table(rows: list[Row]) -> str:
    lines = [
        "# Measured speed",
        "",
        "Made by `make bench`. CPU time, medians, warm, one run of one machine: compare within the run, by ratio.",
        f"Machine: {platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}.",
        "",
        "| work | ours | unit | goal | peer | peer's figure | ours / peer | note |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        peer = "" if row.peer is None else f"{row.peer:.4g}"
        ratio = "" if not row.peer else f"{row.ours / row.peer:.3g}"
        cells = (row.name, f"{row.ours:.4g}", row.unit, row.goal, row.peer_name, peer, ratio, row.note)
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(prog="benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", help="only these (bench_NAME.py)")
    names = parser.parse_args().names
    modules = sorted(path.stem for path in FOLDER.glob("bench_*.py"))
    wanted = [m for m in modules if not names or m.removeprefix("bench_") in names]
    rows: list[Row] = []
    for module in wanted:
        print(f"{module} ...", file=sys.stderr)
        rows += importlib.import_module(f"benchmarks.{module}").run()
    text = table(rows)
    print(text)
    if not names:
        TABLE.parent.mkdir(exist_ok=True)
        TABLE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
