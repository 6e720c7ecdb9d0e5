"""What gates between stages can tell apart: how many wrong twins each catches, how often it fails the right one.

python -m scripts.gate_power                  38 faults, by little and by much, 200 repeats of the right twin; writes
                                              its table into docs/stages.md
python -m scripts.gate_power --draw SEED      60 wrong twins that a seed draws, 100 repeats by other seeds; likewise

The car is the surrogate with something hidden in it (scripts/stage_twins.py), the right twin what was learnt from its
logs (scenarios/models/surrogate_extended.toml). A car drives once with a seed, and every twin is judged against that
log: a repeat is a pair of a drive of the car and one of the twin, each with a seed of its own. Drives are kept in
runs/gate-power; killed, the same command goes on where it was.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.logs.log import Log
from scenarios import path as shipped
from scripts.real_cars import placed
from scripts.stage_twins import HIDDEN, WIRES, twin_of
from scripts.wrong_twins import WrongTwin, drawn, little_and_much
from vehicle.model.model_file import write_model
from vehicle.model.vehicle_model import VehicleModel

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "stages.md"
SCENARIOS = ("overtaking", "pedestrian_crossing")
CHOSEN, FRESH = 1000, 5000  # seeds of the car begin here; those of the twin 500 later
CARS = 10  # drives of the car with a seed of its own, each; twice as many of the twin for 200 pairs

Judged = dict[str, tuple[str, float | None, str]]
"""Of each gate by its name: status, value, what it says."""


class Drives:
    """Drives of car and twins on the scenarios, kept in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "car.toml").write_text(HIDDEN, encoding="utf-8")
        self.right = twin_of("extended", WIRES["ros2"])
        write_model(self.right, folder / "right.toml")

    def car(self, scenario: str, seed: int) -> Log:
        """The car on stage rw; its stack is told the delays of the right twin."""
        options = {
            "stage": "rw",
            "vehicle": f"surrogate:{self._folder / 'car.toml'}",
            "model": self._folder / "right.toml",
        }
        return self._kept(f"rw-{scenario}-{seed}", scenario, seed, options)

    def twin(self, model: VehicleModel, name: str, scenario: str, seed: int) -> Log:
        """A twin on stage dt."""
        file = self._folder / f"{name}.toml"
        write_model(model, file)
        return self._kept(f"dt-{name}-{scenario}-{seed}", scenario, seed, {"model": file})

    def _kept(self, name: str, scenario: str, seed: int, options: Mapping[str, Any]) -> Log:
        from pytest_dvp.drive.run import run

        file = self._folder / f"{name}.mcap"
        if not file.is_file():
            print(f"drive {name}", file=sys.stderr)
            run(shipped(f"{scenario}.xosc"), seed=seed, **options).log.save(file)
        return Log.load(file)


def judged(twin: Log, car: Log, scenario: str) -> Judged:
    """All gates between the stages of a twin and the car."""
    from pytest_dvp.drive.stage_comparison import gates_between
    from pytest_dvp.verdicts.judging import judge_between

    gates = gates_between(shipped(f"{scenario}.xosc"), None, shipped("stages.toml"))
    found = judge_between(gates, ("dt", "rw"), {"dt": twin, "rw": car})
    return {
        verdict.name: (verdict.status, verdict.value, verdict.short if verdict.status == "FAIL" else verdict.reason)
        for verdict in found
    }


def wrong_ones(drives: Drives, twins: Sequence[WrongTwin], first: int, cars: int) -> list[dict[str, Any]]:
    """Each wrong twin once on each scenario, against the drives of the car in turn."""
    found = []
    for k, twin in enumerate(twins):
        scenes = {}
        for scenario in SCENARIOS:
            seed = first + k % cars
            log = drives.twin(twin.fault.made(drives.right, twin.size), f"wrong-{first}-{k}", scenario, seed + 500)
            scenes[scenario] = judged(log, drives.car(scenario, seed), scenario)
        found.append({"name": twin.name, "parameter": twin.fault.parameter, "gates": scenes})
        print(f"{k + 1} of {len(twins)}: {twin.name}: {noticed(found[-1]) or 'PASS'}", file=sys.stderr)
    return found


def right_ones(drives: Drives, first: int, cars: int, count: int) -> list[dict[str, Judged]]:
    """`count` pairs of the car and the right twin, on each scenario. With as many drives of the car, no two pairs share
    a drive: only then are they `count` trials."""
    pairs = list(itertools.product(range(cars), range(-(-count // cars))))[:count]
    if cars >= count:
        pairs = [(k, k) for k in range(count)]
    found = []
    for car, twin in pairs:
        scenes = {}
        for scenario in SCENARIOS:
            log = drives.twin(drives.right, "right", scenario, first + 500 + twin)
            scenes[scenario] = judged(log, drives.car(scenario, first + car), scenario)
        found.append(scenes)
        bad = [
            f"{name} {text}"
            for gates in scenes.values()
            for name, (status, _, text) in gates.items()
            if status != "PASS"
        ]
        if bad:
            print(f"right twin {twin}, car {car}: {'; '.join(bad)}", file=sys.stderr)
    return found


def noticed(twin: Mapping[str, Any]) -> str:
    """How a wrong twin was noticed: "FAIL", "INCONCLUSIVE" if a verdict names its parameter; "" if it was not."""
    verdicts = [verdict for gates in twin["gates"].values() for verdict in gates.values()]
    if any(status == "FAIL" for status, _, _ in verdicts):
        return "FAIL"
    named = any(status == "INCONCLUSIVE" and twin["parameter"] in text for status, _, text in verdicts)
    return "INCONCLUSIVE" if named else ""


def table(wrong: Sequence[Mapping[str, Any]], right: Sequence[Mapping[str, Judged]]) -> str:
    """A row for each gate, and the sum."""
    names = list(dict.fromkeys(name for scenes in right for gates in scenes.values() for name in gates))
    lines = [
        f"| gate | wrong twins caught, of {len(wrong)} | by no other gate | right twin failed, of {len(right)} |",
        "|---|---:|---:|---:|",
    ]
    caught = {name: {k for k, twin in enumerate(wrong) if _of(twin["gates"], name) == "FAIL"} for name in names}
    for name in names:
        others = set().union(*(caught[other] for other in names if other != name))
        failed = sum(_of(scenes, name) == "FAIL" for scenes in right)
        lines.append(f"| {name} | {len(caught[name])} | {len(caught[name] - others)} | {failed} |")
    told = [noticed(twin) for twin in wrong]
    passed = sum(all(v[0] == "PASS" for gates in scenes.values() for v in gates.values()) for scenes in right)
    missed = ", ".join(f"`{twin['name']}`" for twin, how in zip(wrong, told, strict=True) if not how)
    lines += [
        "",
        f"FAIL: {told.count('FAIL')} of {len(wrong)} wrong twins; INCONCLUSIVE with the right parameter named: "
        f"{told.count('INCONCLUSIVE')}; not noticed: {missed or 'none'}. "
        f"The right twin passes in {passed} of {len(right)}.",
    ]
    return "\n".join(lines)


def _of(scenes: Mapping[str, Judged], name: str) -> str:
    """The worst status of a gate on the scenarios."""
    found = {gates[name][0] for gates in scenes.values() if name in gates}
    return next((status for status in ("FAIL", "INCONCLUSIVE", "PASS") if status in found), "")


def main(argv: Sequence[str] | None = None) -> int:
    """Returns the exit code: 0."""
    parser = argparse.ArgumentParser(prog="python -m scripts.gate_power", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--draw", metavar="SEED", help="hexadecimal: draw 60 wrong twins instead of those that ship")
    parser.add_argument("--cars", type=int, default=CARS, help="drives of the car")
    parser.add_argument("--repeats", type=int, help="pairs of the car and the right twin; default 200, of a draw 100")
    parser.add_argument("--wrong", type=int, default=60, help="wrong twins that a draw holds")
    parser.add_argument("--first", type=int, help=f"seed of the first drive of the car; default {CHOSEN}, {FRESH}")
    parser.add_argument("--only", choices=("right", "wrong"), help="this half; the other one by another process")
    parser.add_argument("--runs", type=Path, default=ROOT / "runs" / "gate-power")
    arguments = parser.parse_args(argv)
    first = arguments.first or (CHOSEN if arguments.draw is None else FRESH)
    twins = little_and_much() if arguments.draw is None else drawn(int(arguments.draw, 16), arguments.wrong)
    count = arguments.repeats or (200 if arguments.draw is None else 100)
    drives = Drives(arguments.runs)
    name = "chosen" if arguments.draw is None else f"draw-{arguments.draw}"
    parts: dict[str, list[Any]] = {}
    for part in ("right", "wrong"):
        file = arguments.runs / f"{name}-{part}.json"
        if not file.is_file() and arguments.only in (None, part):
            found: list[Any] = (
                list(right_ones(drives, first, arguments.cars, count))
                if part == "right"
                else wrong_ones(drives, twins, first, arguments.cars)
            )
            file.write_text(json.dumps(found), encoding="utf-8")
        if file.is_file():
            parts[part] = json.loads(file.read_text(encoding="utf-8"))
    if len(parts) < 2:
        return 0
    right, wrong = parts["right"], parts["wrong"]
    text = table(wrong, right)
    print(text)
    mark = "power" if arguments.draw is None else "power of a draw"
    PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), mark, text), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
