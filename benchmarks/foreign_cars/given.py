"""python -m benchmarks.foreign_cars.given FOLDER --json F [--part K/N]

Asks the diagnosis about cars that somebody else has made: files only, so that any simulator or car can stand behind
them. FOLDER holds

- cars/CAR/sheet.toml, learn_rich.csv, learn_town.csv: the data sheet, and two drives with nothing hidden;
- cases/ID/rich.csv, town.csv: two drives with the same hidden change, or with none;
- truth.json: {ID: {"car", "names": [effect], "truth": {effect: {key: value}}, "detectable": bool, "noise": optional,
  a note}}. One change is hidden in a case; several names are descriptions of it that are equally true, of which one has
  to be found. "detectable" tells whether the logs can show it, and is true where nothing is hidden. A value is what the
  change adds to the car, or the factor by which it multiplies; a limit is that of the changed car, and so is a place, a
  width or a speed that OWN lists. Values that the catalogue cannot state are left out.

Twins are matched, asked and scored as in `python -m benchmarks.foreign_cars`.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from pathlib import Path
from typing import Any

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):  # before numpy loads: CPU of one core
    os.environ.setdefault(_name, "1")

from benchmarks.foreign_cars.ask import answered, kept, learnt, total  # noqa: E402
from benchmarks.foreign_cars.hidden import Values  # noqa: E402
from benchmarks.foreign_cars.table import figures  # noqa: E402
from benchmarks.hidden_effects import score  # noqa: E402
from pytest_dvp.logs.read_log import read_log  # noqa: E402
from vehicle.model.model_file import read_model  # noqa: E402
from vehicle.model.vehicle_model import VehicleModel  # noqa: E402

KINDS = ("rich", "town")  # fitted, and held out
OWN = {
    "creep": ("v0",),
    "gnss_lever_arm": ("x", "y"),
    "pedal_deadband": ("width",),
    "steer_backlash": ("half_width",),
    "steer_stiction": ("width",),
}  # places and widths: the truth says that of the changed car, not what the change adds


def twin_of(car: Path, twins: Path) -> tuple[VehicleModel, dict[str, Any]]:
    """The twin of one car, and the answer from its data sheet ({} if the twin was learnt before)."""
    logs, held_out = ({f"{kind}.csv": read_log(car / f"learn_{kind}.csv")} for kind in KINDS)
    return learnt(twins / f"{car.name}.toml", read_model(car / "sheet.toml"), logs, held_out)


def asked(folder: Path, case: dict[str, Any], twin: VehicleModel) -> dict[str, Any]:
    """The record of a case."""
    line = {"key": folder.name, "category": "single" if case["names"] else "null", **case}
    if case["names"] and not case["detectable"]:
        return line | {"verdict": "UNDETECTABLE", "effects": []}
    logs, held_out = ({f"{kind}.csv": read_log(folder / f"{kind}.csv")} for kind in KINDS)
    answer = answered(logs, twin, held_out)
    truth = {name: case["truth"].get(name, {}) for name in _description(case["names"], answer)}
    return line | {"truth": truth, "total": given_total(truth, twin)} | answer


def given_total(truth: Values, twin: VehicleModel) -> dict[str, dict[str, float]]:
    """What a diagnosis from the twin should find: as `total`, but places and widths are those of the changed car."""
    found = total(truth, twin)
    for name, values in truth.items():
        found[name] |= {key: values[key] for key in OWN.get(name, ()) if key in values}
    return found


def _description(names: list[str], answer: dict[str, Any]) -> list[str]:
    """Of names that describe one change equally well, the one that the answer confirms, else names, else the first."""
    named = [*score.confirmed(answer), *score.names(answer)]
    return [next((name for name in named if name in names), names[0])] if names else []


def cases_of(folder: Path) -> dict[str, dict[str, Any]]:
    """What truth.json says of each case. Raises SystemExit with one line: a file is missing, or a key."""
    file = folder / "truth.json"
    try:
        cases: dict[str, dict[str, Any]] = json.loads(file.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise SystemExit(f"{file}: cannot be read as JSON: {error}") from None
    for name, case in cases.items():
        if lacking := sorted({"car", "names", "truth", "detectable"} - set(case)):
            raise SystemExit(f"{file}: case {name} lacks {', '.join(lacking)}; --help lists the keys")
        of_the_car = [f"cars/{case['car']}/{one}" for one in ("sheet.toml", "learn_rich.csv", "learn_town.csv")]
        for one in [*of_the_car, *(f"cases/{name}/{kind}.csv" for kind in KINDS)]:
            if not (folder / one).is_file():
                raise SystemExit(f"{folder / one}: there is no such file, which case {name} of {file} needs")
    return cases


def main() -> int:
    """Returns 0: the figures are the result."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--json", type=Path, required=True, metavar="F", help="answers, a line each; goes on with them")
    parser.add_argument("--part", default="0/1", metavar="K/N", help="every Nth case, from the Kth on")
    args = parser.parse_args()
    if not (found := re.fullmatch(r"(\d+)/([1-9]\d*)", args.part)) or int(found[1]) >= int(found[2]):
        raise SystemExit(f"--part: must be K/N with K from 0 to N - 1 (found {args.part!r})")
    part, parts = map(int, found.groups())
    truth = cases_of(args.folder)
    known = [json.loads(text) for text in args.json.read_text("utf-8").splitlines()] if args.json.exists() else []
    done = {line["key"] for line in known}
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
            line = asked(args.folder / "cases" / key, truth[key], twin)
        known.append(line)
        said = ", ".join(f"{e['name']} ({e['standing']})" for e in line["effects"]) or "-"
        print(f"{key}: {line['verdict']} {said} ({line.get('cpu', 0):.0f} s)", file=sys.stderr, flush=True)
        with args.json.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
    print(f"Of the cases and bare cars of {args.folder}, {figures(known)}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
