"""python -m benchmarks.foreign_cars.given FOLDER --json F [--part K/N]

Asks the diagnosis about cars that somebody else has made: files only, so that any simulator or car can stand behind
them. FOLDER holds

- cars/CAR/sheet.toml, learn_rich.csv, learn_town.csv: the data sheet, and two drives with nothing hidden;
- cases/ID/rich.csv, town.csv: two drives with the same hidden change, or with none;
- truth.json: {ID: {"car", "noise", "names": [effect], "truth": {effect: {key: value}}, "detectable": bool}}; values
  that the catalogue cannot state are left out.

Twins are matched, asked and scored as in `python -m benchmarks.foreign_cars`.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):  # before numpy loads: CPU of one core
    os.environ.setdefault(_name, "1")

from benchmarks.foreign_cars.ask import kept, learnt, total  # noqa: E402
from benchmarks.foreign_cars.table import page  # noqa: E402
from pytest_dvp.gap.diagnose.diagnose import diagnose  # noqa: E402
from pytest_dvp.logs.read_log import read_log  # noqa: E402
from vehicle.model.model_file import read_model  # noqa: E402
from vehicle.model.vehicle_model import VehicleModel  # noqa: E402


def twin_of(car: Path, twins: Path) -> tuple[VehicleModel, dict[str, Any]]:
    """The twin of one car, and the answer from its data sheet ({} if the twin was learnt before)."""
    logs, held_out = ({f"{kind}.csv": read_log(car / f"learn_{kind}.csv")} for kind in ("rich", "town"))
    return learnt(twins / f"{car.name}.toml", read_model(car / "sheet.toml"), logs, held_out)


def asked(folder: Path, name: str, case: dict[str, Any], twin: VehicleModel) -> dict[str, Any]:
    """The record of a case."""
    line = {"key": name, "category": "single" if case["names"] else "null", **case}
    if case["names"] and not case["detectable"]:
        return line | {"verdict": "UNDETECTABLE", "effects": []}
    line["total"] = total(case["truth"], twin)
    logs, held_out = ({f"{kind}.csv": read_log(folder / f"{kind}.csv")} for kind in ("rich", "town"))
    begin = time.process_time()
    answer = diagnose(logs, twin, held_out).as_dict()
    return line | kept({**answer, "cpu": round(time.process_time() - begin, 1)})


def main() -> int:
    """Returns 0: the figures are the result."""
    parser = argparse.ArgumentParser(description="Cars of somebody else: is what they lack named?")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--json", type=Path, required=True, metavar="F", help="answers, a line each; goes on with them")
    parser.add_argument("--part", default="0/1", metavar="K/N", help="every Nth case, from the Kth on")
    args = parser.parse_args()
    part, parts = map(int, args.part.split("/"))
    known = [json.loads(text) for text in args.json.read_text("utf-8").splitlines()] if args.json.exists() else []
    done = {line["key"] for line in known}
    truth = json.loads((args.folder / "truth.json").read_text("utf-8"))
    twins = args.json.parent / "twins"
    bare = {f"bare/{name}": name for name in sorted({case["car"] for case in truth.values()})}
    for k, key in enumerate([*bare, *truth]):
        if key in done or k % parts != part:
            continue
        if key in bare:
            (twins / f"{bare[key]}.toml").unlink(missing_ok=True)
            _, answer = twin_of(args.folder / "cars" / bare[key], twins)
            line = {"key": key, "category": "bare", "car": bare[key], "names": [], "truth": {}} | kept(answer)
        else:
            twin, _ = twin_of(args.folder / "cars" / truth[key]["car"], twins)
            line = asked(args.folder / "cases" / key, key, truth[key], twin)
        known.append(line)
        said = ", ".join(f"{e['name']} ({e['standing']})" for e in line["effects"]) or "-"
        print(f"{key}: {line['verdict']} {said} ({line.get('cpu', 0):.0f} s)", file=sys.stderr, flush=True)
        with args.json.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
    print(page(known, "given"))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
