"""Do two halves of a drive name the same effects?  python -m scripts.raw_halves [--write] [LOG ...]

What a log shows of the car, each half of it must show: an effect that only one half names, or with values that exclude
each other, is of that stretch, or stands in for something else. Every log is taken as its owner published it, by the
commands of the README: `dvp join`, `dvp map`, and `dvp diagnose` of each half. The logs are not part of the project:
they are read from `measurements/raw` of the reference material at DVP_SHARED, ../shared unless set.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "real-cars.md"
RAW = Path(os.environ.get("DVP_SHARED", ROOT.parent / "shared")) / "measurements" / "raw"
DVP = (sys.executable, "-m", "pytest_dvp.cli")
LOGS: Mapping[str, tuple[str, float, float]] = {
    "genesis": ("Genesis G80", 3.02, 2000.0),
    "iac_putnam": ("Dallara AV-21", 2.9808, 790.0),
    "dart": ("DART", 0.1735, 1.58),
    "f1tenth_ds1": ("F1TENTH, first drive", 0.33, 3.5),
    "f1tenth_ds2": ("F1TENTH, second drive", 0.33, 3.5),
}
"""Folder -> the car, its wheelbase [m], its mass [kg]."""


def dvp(*words: str | Path) -> str:
    """What a command prints on stdout; raises CalledProcessError if it refuses."""
    command = [*DVP, *(str(word) for word in words)]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, env=os.environ).stdout


def halves(name: str, folder: Path) -> list[dict[str, Any]]:
    """The diagnosis of each half of a log, as JSON documents."""
    files = sorted((RAW / name).iterdir())
    log = files[0]
    if len(files) > 1:
        log = folder / f"{name}.csv"
        dvp("join", *files, "--out", log)
    _, wheelbase, mass = LOGS[name]
    mapping, model = folder / f"{name}.map.toml", folder / f"{name}.toml"
    dvp("map", log, "--wheelbase", f"{wheelbase}", "--mass", f"{mass}", "--model", model, "--out", mapping)
    end = _seconds(log, mapping)
    parts = (f"{log}@0:{end / 2.0:.1f}", f"{log}@{end / 2.0:.1f}:{end + 1.0:.1f}")
    return [json.loads(dvp("diagnose", part, "--map", mapping, "--model", model, "--json")) for part in parts]


def _seconds(log: Path, mapping: Path) -> float:
    from pytest_dvp.logs.read_log import read_log

    t = read_log(log, mapping=mapping).t
    return float(t[-1] - t[0])


def row(name: str, found: list[dict[str, Any]]) -> list[str]:
    """Lines of the table: each value of each effect that a half names."""
    named = [{(e["name"], key): v for e in one["effects"] for key, v in e["parameters"].items()} for one in found]
    lines = []
    for key in dict.fromkeys([*named[0], *named[1]]):
        a, b = (side.get(key) for side in named)
        if a and b:
            said = "yes" if a["low"] <= b["high"] and b["low"] <= a["high"] else "**no**"
        else:
            said = "one half only"
        unit = (a or b or {}).get("unit", "-")
        lines.append(f"| {LOGS[name][0]} | `{key[0]}` {key[1]} | {_told(a)} | {_told(b)} | {unit} | {said} |")
    return lines or [f"| {LOGS[name][0]} | nothing | {found[0]['verdict']} | {found[1]['verdict']} | | |"]


def _told(value: Mapping[str, float] | None) -> str:
    return "-" if value is None else f"{value['value']:.3g} ({value['low']:.3g} to {value['high']:.3g})"


def main() -> int:
    """Returns the exit code: 0, or 2 if the logs are not there."""
    parser = argparse.ArgumentParser(description="Do two halves of a drive name the same effects?")
    parser.add_argument("logs", nargs="*", metavar="LOG", help=f"of {', '.join(LOGS)}; default: all")
    parser.add_argument(
        "--kept", type=Path, default=ROOT / "runs" / "raw-halves", help="folder of answers that are kept"
    )
    parser.add_argument("--write", action="store_true", help="put the table into docs/real-cars.md")
    asked = parser.parse_args()
    strange = [name for name in asked.logs if name not in LOGS]
    if strange:
        parser.error(f"{strange[0]!r} is no log; expected of {', '.join(LOGS)}")
    if not RAW.is_dir():
        print(f"{RAW}: no such folder; set DVP_SHARED", file=sys.stderr)
        return 2
    asked.kept.mkdir(parents=True, exist_ok=True)
    lines = ["| car | value | first half | second half | unit | intervals meet |", "|---|---|---|---|---|---|"]
    for name in asked.logs or tuple(LOGS):
        file = asked.kept / f"{name}.json"
        if not file.exists():
            print(name, file=sys.stderr)
            with TemporaryDirectory() as folder:
                file.write_text(json.dumps(halves(name, Path(folder))), encoding="utf-8")
        lines += row(name, json.loads(file.read_text("utf-8")))
    table = "\n".join(lines)
    print(table)
    if asked.write:
        before, begin, rest = PAGE.read_text("utf-8").partition("<!-- halves -->\n")
        _, end, after = rest.partition("<!-- end of halves -->")
        PAGE.write_text(before + begin + table + "\n" + end + after, encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
