"""What each row of the table of docs/mcrpg.md can tell apart: how many wrong twins miss its bound, and the right one.

python -m scripts.paper_power --draw SEED --first CAR     after `python -m scripts.gate_power` with the same arguments

The drives are those of scripts/gate_power.py (runs/gate-power): wrong twins that a seed drew, each driven once on each
scenario and held against one drive of the car, and pairs of the right twin. The table of docs/mcrpg.md judges means
over repeats; here each row judges one pair, on both scenarios. Writes its table into docs/mcrpg.md.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_dvp.logs.log import Log
from pytest_dvp.tuning.result_bounds import DRIVE, EQUIVALENT, GAIN, LIKENESS, NOISES, SAMPLE, SEEN
from scripts.gate_power import CARS, ROOT, SCENARIOS, Drives
from scripts.real_cars import placed
from scripts.wrong_twins import drawn

PAGE = ROOT / "docs" / "mcrpg.md"
POSITION = "open-loop position after 2 s"

Rows = dict[str, bool]
"""Whether a row of the table holds, by its name; a figure that is not defined does not hold."""


def held(twin: Log, car: Log) -> Rows:
    """Which rows hold for one drive of a twin on dt and one of the car on rw."""
    from pytest_dvp.verdicts.stage_table import stage_table

    found: Rows = {}
    for row in stage_table({"dt": twin, "rw": car}).rows:
        first, second = row.cells
        if row.metric == "mncc" and row.name in LIKENESS:
            lag = SEEN if row.name.startswith("object") else SAMPLE
            found[f"MNCC {row.name}"] = _within(second.value, low=LIKENESS[row.name])
            found[f"lag of {row.name}"] = _within(second.lag, low=-lag - 1e-9, high=lag + 1e-9)
            found[f"gain of {row.name}"] = _within(second.gain, low=1.0 - GAIN, high=1.0 + GAIN)
        if row.name in DRIVE:
            found[row.name] = _within(first.value, high=DRIVE[row.name][0])
        if row.name in EQUIVALENT:
            known = first.value is not None and second.value is not None
            apart = abs(first.value - second.value) if known else None  # type: ignore[operator]
            margin = GAIN * (DRIVE[row.name][0] if row.name in DRIVE else abs(second.value or 0.0))
            found[f"{row.name}, between stages"] = _within(apart, high=margin + 1e-12)
    found[POSITION] = _positioned(twin, car)
    return found


def _within(value: float | None, low: float = -math.inf, high: float = math.inf) -> bool:
    return value is not None and low <= value <= high


def _positioned(twin: Log, car: Log) -> bool:
    """Whether the twin is within NOISES times the noise of the measured position 2 s after a start."""
    from pytest_dvp.gap.compare.position_error import position_error
    from pytest_dvp.gap.diagnose.experiment import experiment_set
    from pytest_dvp.logs.obeyed_commands import with_obeyed_commands
    from vehicle.model.model_file import parse_model

    model, logs = parse_model(str(twin.meta["model"]["toml"])), {"car": with_obeyed_commands(car)}
    noise = experiment_set(logs, model).noise()
    return position_error(logs, model, {}) <= NOISES * math.hypot(noise["x"], noise["y"])


def table(wrong: Sequence[Mapping[str, bool]], right: Sequence[Mapping[str, bool]]) -> str:
    """A row for each row of the paper's table; what no wrong twin misses, or the right one often does, is no gate."""
    lines = [
        f"| row | wrong twins that miss it, of {len(wrong)} | the right twin misses it, of {len(right)} | it is |",
        "|---|---:|---:|---|",
    ]
    for name in right[0]:
        caught = sum(not one.get(name, False) for one in wrong)
        failed = sum(not one.get(name, False) for one in right)
        more = caught / len(wrong) - failed / len(right)
        tells = caught > 0 and failed <= 0.03 * len(right)
        what = "a gate" if tells else "for information" if more < 0.05 else "a gate over repeats only"
        lines.append(f"| {name} | {caught} | {failed} | {what} |")
    return "\n".join(lines)


def main(argv: Sequence[str] | None = None) -> int:
    """Returns the exit code: 0."""
    parser = argparse.ArgumentParser(prog="python -m scripts.paper_power", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--draw", metavar="SEED", required=True)
    parser.add_argument("--first", type=int, required=True)
    parser.add_argument("--cars", type=int, default=CARS)
    parser.add_argument("--pairs", type=int, default=50, help="pairs of the car and the right twin")
    parser.add_argument("--runs", type=Path, default=ROOT / "runs" / "gate-power")
    arguments = parser.parse_args(argv)
    drives, first, cars = Drives(arguments.runs), arguments.first, arguments.cars
    file = arguments.runs / f"paper-{arguments.draw}.json"
    done: dict[str, Rows] = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}

    def pair(name: str, twin: Any, seed: int, car: int) -> Rows:
        """The rows of a pair on both scenarios: a row holds if it does on each; kept in the file."""
        key = f"{name} {seed} {car}"
        if key not in done:
            both = [held(drives.twin(twin, name, s, seed), drives.car(s, car)) for s in SCENARIOS]
            done[key] = {row: all(one.get(row, False) for one in both) for row in dict.fromkeys(itertools.chain(*both))}
            file.write_text(json.dumps(done), encoding="utf-8")
            print(f"{key}: misses {sum(not ok for ok in done[key].values())}", file=sys.stderr)
        return done[key]

    wrong = [
        pair(f"wrong-{first}-{k}", twin.fault.made(drives.right, twin.size), first + 500 + k % cars, first + k % cars)
        for k, twin in enumerate(drawn(int(arguments.draw, 16), 60))
    ]
    repeats = list(itertools.product(range(cars), range(cars)))[:: max(1, cars * cars // arguments.pairs)]
    right = [pair("right", drives.right, first + 500 + twin, first + car) for car, twin in repeats]
    text = table(wrong, right)
    print(text)
    PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), "paper power", text), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
