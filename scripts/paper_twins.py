"""What a bare data sheet becomes by the logs of a car: the twins of `make paper`, without the tuning of the stack.

python -m scripts.paper_twins [CAR ...]      of scenarios/mcrpg/cars; writes its table into docs/mcrpg.md

Each car drives the variants of scenarios/mcrpg/paper.toml on stage rw, and urban, all recorded by a reference system
with errors. Whatever the diagnosis names is added to scenarios/models/surrogate.toml, also what is provisional, but
for what `dvp extend` then finds idle, and the twin is held against drives of the held-out variants with other seeds.
Kept in runs/paper-twins, car by car.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scenarios import path as shipped
from scripts.mcrpg_page import CARS, PAGE, ROOT
from scripts.real_cars import placed

BARE = "models/surrogate.toml"
FIT: tuple[tuple[str, Mapping[str, str]], ...] = (
    ("overtaking", {}), ("pedestrian_crossing", {"pedestrian_speed": "1.75"}), ("urban", {}),
)  # fmt: skip
HELD_OUT: tuple[tuple[str, Mapping[str, str]], ...] = (
    ("overtaking", {"target_position": "66", "target_lateral_offset": "-0.2", "oncoming_speed": "4.5"}),
    ("pedestrian_crossing", {"pedestrian_speed": "1.5", "ego_speed": "5.0"}),
)
FIT_SEED, HELD_OUT_SEEDS = 7, (101, 102)
IDLE = "explains too little"  # as `dvp extend` words it
NOISES = 2.0  # times the noise of the measured position


def learnt(car: str, folder: Path) -> dict[str, Any]:
    """Drive a car, diagnose, extend, and judge both twins on what nothing was fitted on."""
    folder.mkdir(parents=True, exist_ok=True)
    fit = [_drive(car, folder, name, given, FIT_SEED) for name, given in FIT]
    judging = [_drive(car, folder, name, given, seed) for name, given in HELD_OUT for seed in HELD_OUT_SEEDS]
    bare, twin = shipped(BARE), folder / "twin.toml"
    diagnosis = _dvp(["diagnose", *map(str, fit), "--held-out", str(judging[0]), "--model", str(bare), "--json"])
    effects = json.loads(diagnosis)["effects"]
    names = list(dict.fromkeys(effect["name"] for effect in effects))
    _extend(bare, names, ["--fit", *map(str, fit), "--held-out", str(judging[0])], twin)
    return {
        "verdict": json.loads(diagnosis)["verdict"],
        "effects": [{key: effect.get(key) for key in ("name", "standing", "parameters")} for effect in effects],
        "bare": _judged(bare, judging),
        "learnt": _judged(twin if twin.is_file() else bare, judging),
    }


def _extend(bare: Path, names: Sequence[str], logs: Sequence[str], twin: Path) -> None:
    """Write the twin with these effects, without those that `dvp extend` finds idle; none if all are. Raises SystemExit
    with the line of a refusal for another reason."""
    twin.unlink(missing_ok=True)
    while names:
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            _dvp(["extend", "--model", str(bare), "--add", *names, *logs, "--out", str(twin)])
        if twin.is_file():
            return
        (refusal,) = said.getvalue().splitlines()[-1:]
        busy = [name for name in names if f"{name} {IDLE}" not in refusal]
        if busy == list(names):
            raise SystemExit(refusal)
        names = busy


def _drive(car: str, folder: Path, scenario: str, given: Mapping[str, str], seed: int) -> Path:
    from pytest_dvp.drive.run import run

    file = folder / f"{scenario}-{seed}.mcap"
    if not file.is_file():
        print(f"{car}: drive {file.stem}", file=sys.stderr)
        hidden = shipped("mcrpg/paper.toml").parent / "cars" / f"{car}.toml"
        result = run(
            shipped(f"{scenario}.xosc"), stage="rw", seed=seed, vehicle=f"surrogate:{hidden}", model=shipped(BARE),
            parameters=dict(given),
        )  # fmt: skip
        result.log.save(file)
    return file


def _dvp(words: list[str]) -> str:
    from pytest_dvp.cli.command_line import main as dvp

    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        dvp(words)
    return said.getvalue()


def _judged(model: Path, logs: Sequence[Path]) -> dict[str, float]:
    """chi^2/N, whitened, geometric mean over the logs; error of the position after 2 s, and its noise [m]."""
    from pytest_dvp.gap.compare.compare import compare
    from pytest_dvp.gap.compare.position_error import position_error
    from pytest_dvp.gap.diagnose.experiment import experiment_set
    from pytest_dvp.logs.log import Log
    from pytest_dvp.logs.obeyed_commands import with_obeyed_commands
    from vehicle.model.model_file import read_model

    twin = read_model(model)
    loaded = {file.name: with_obeyed_commands(Log.load(file)) for file in logs}
    chi2 = [compare(log, twin).chi2_per_n for log in loaded.values()]
    noise = experiment_set(loaded, twin).noise()
    return {
        "chi2": math.exp(sum(map(math.log, chi2)) / len(chi2)),
        "greatest": max(chi2),
        "position": position_error(loaded, twin, {}),
        "noise": math.hypot(noise["x"], noise["y"]),
    }


def table(found: Mapping[str, Mapping[str, Any]]) -> str:
    """A row for each car."""
    lines = [
        "| car | hidden | diagnosis (+ confirmed, ~ provisional) | chi²/N held out: data sheet, learnt (goal 1.3) "
        f"| position after 2 s [m]: data sheet, learnt (goal {NOISES:g} x noise) |",
        "|---|---|---|---|---|",
    ]
    folder = shipped("mcrpg/paper.toml").parent / "cars"
    for car, one in found.items():
        text = [t for t in (folder / f"{car}.toml").read_text(encoding="utf-8").splitlines() if t[:1] != "#"]
        hidden = " ".join(text).replace("[hidden.", "`").replace("]", "`").replace(" = ", " ")
        named = ", ".join(
            f"{'+' if e['standing'] == 'confirmed' else '~'} {e['name']} "
            + " ".join(f"{key} {p['value']:.4g}" for key, p in e["parameters"].items())
            for e in one["effects"]
        )
        bare, after = one["bare"], one["learnt"]
        within = "" if after["chi2"] <= 1.3 else "✗ "
        placed_well = "" if after["position"] <= NOISES * after["noise"] else "✗ "
        lines.append(
            f"| {car.replace('_', ', ')} | {hidden} | {one['verdict']}: {named} | {bare['chi2']:.3g}, {within}"
            f"{after['chi2']:.3g} | {bare['position']:.3f}, {placed_well}{after['position']:.4f} "
            f"(<= {NOISES * after['noise']:.4f}) |"
        )
    return "\n".join(lines)


def main(argv: Sequence[str] | None = None) -> int:
    """Returns the exit code: 0."""
    parser = argparse.ArgumentParser(prog="python -m scripts.paper_twins", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("cars", nargs="*", metavar="CAR", help=f"of {', '.join(CARS)}; default: all")
    parser.add_argument("--runs", type=Path, default=ROOT / "runs" / "paper-twins")
    arguments = parser.parse_args(argv)
    if unknown := [car for car in arguments.cars if car not in CARS]:
        parser.error(f"CAR: no such car (found {unknown[0]!r}; allowed: {', '.join(CARS)})")
    for car in arguments.cars or CARS:
        file = arguments.runs / f"{car}.json"
        if not file.is_file():
            found = learnt(car, arguments.runs / car)
            file.write_text(json.dumps(found), encoding="utf-8")
    files = {car: arguments.runs / f"{car}.json" for car in CARS}
    text = table({car: json.loads(file.read_text(encoding="utf-8")) for car, file in files.items() if file.is_file()})
    print(text)
    PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), "paper twins", text), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
