"""`python -m benchmarks [NAME...]`: runs every bench_*.py; all of them write docs/benchmarks.md and README's table."""

from __future__ import annotations

import argparse
import importlib
import os
import platform
import subprocess
import sys
from pathlib import Path

from benchmarks import readme
from benchmarks.measure import Row

FOLDER = Path(__file__).parent
TABLE = readme.PAGE


def table(rows: list[Row]) -> str:
    lines = [
        "# Measured speed",
        "",
        "`make bench` writes this page: medians of CPU time, warm, from one run on one machine. Compare ratios only.",
        f"Machine: {platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}.",
        f"State: {state()}.",
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


def state() -> str:
    """The commit that is measured, and whether something of it was changed."""
    told = subprocess.run(
        ["git", "describe", "--always", "--dirty= with changes", "--exclude=*"],
        cwd=FOLDER,
        capture_output=True,
        text=True,
    )
    return told.stdout.strip() or "no git repository"


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
        readme.write()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
