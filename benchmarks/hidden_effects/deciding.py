"""After driving the advised manoeuvre, is the truth alone in the set?

    python -m benchmarks.hidden_effects.deciding [--cases 30] [--seed 2000] [--json F]

A truth car with one hidden effect drives about town. Where the diagnosis of that log alone is ambiguous, the manoeuvre
that the tool advises is driven by the same truth car, with sensors and noise, and both logs are diagnosed together.
Where the tool says that nothing within the usual limits would be enough, it is asked again on longer ground, as a user
would ask.
Needs what `benchmarks.hidden_effects` needs: the truth cars of `tests.truth`, nothing of the kernel beside the tool.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, cast

import numpy as np

from benchmarks.hidden_effects.case import Case
from benchmarks.hidden_effects.detectable import body
from benchmarks.hidden_effects.truth import question
from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis
from pytest_dvp.gap.manoeuvres.advice import advise
from pytest_dvp.gap.manoeuvres.catalogue import Manoeuvre
from pytest_dvp.gap.manoeuvres.choice import Choice
from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
from pytest_dvp.gap.manoeuvres.simulated_drive import drive
from pytest_dvp.gap.manoeuvres.simulated_driver import DriverDemand
from pytest_dvp.logs.log import Log
from tests.truth.car import FINE, N_STATE, PERIOD, SUBSTEPS, advance
from tests.truth.effects import C_CF, C_CR, C_DYNAMIC, PLANT, Effects, FloatArray, TruthCar, checked, parameters
from tests.truth.generate import Noise, add_noise, sensed
from vehicle.model.car import make_car

CONFUSED = (
    "steer_lag", "steer_delay", "tyre_relaxation", "drive_lag", "drive_delay", "jerk_limit", "brake_limit",
    "brake_gain", "aero_drag", "viscous_resistance", "steer_offset", "gyro_bias", "steer_ratio", "understeer",
    "pedal_deadband", "steer_backlash", "steer_stiction", "power_limit", "brake_lag", "mass", "rolling_resistance",
    "lift_off_braking", "steer_rate_limit", "cornering_drag", "yaw_rate_latency", "gnss_latency", "headwind",
    "road_grade", "drive_gain",
)  # fmt: skip
"""Effects that urban data often leave with rivals."""
NOISES = ("mid", "low", "high")
ENVELOPE = Envelope()
WIDER = Envelope(max_speed=20.0, length=300.0)
"""Where a manoeuvre is planned again that the tool itself calls too weak for the usual limits."""


def driven(effects: Effects, manoeuvre: Manoeuvre, noise: Noise, seed: int, *, envelope: Envelope = ENVELOPE,
           size: float = 1.0) -> Log:  # fmt: skip
    """A log of the truth car with these effects driving a manoeuvre, as its sensors show it."""
    car = TruthCar()
    p = parameters(car, checked({name: values for name, values in effects.items() if name in PLANT}))
    if body(effects) == "dynamic":
        p[C_DYNAMIC] = 1.0
        if "understeer" not in effects:
            p[C_CF], p[C_CR] = car.stiffness_front, car.stiffness_rear
    s = np.zeros(N_STATE)
    commands: list[tuple[float, float, float]] = []
    rows: list[FloatArray] = []
    table = np.zeros((20_000, 3))

    def respond(wish: DriverDemand) -> tuple[float, float, float, float, float]:
        k = len(commands)
        commands.append((wish.accel, wish.steer, wish.speed))
        table[k] = commands[-1]
        fine = np.empty((SUBSTEPS, len(FINE)))
        advance(s, p, table, k, fine)
        rows.append(fine)
        return float(s[0]), float(s[1]), float(s[2]), float(s[3]), float(fine[-1, 4])

    known = {name: getattr(car, name) for name in ("wheelbase", "cg_to_front_axle", "mass", "yaw_inertia")}
    drive(manoeuvre, make_car(known), respond, envelope, size)
    n = len(commands)
    columns = {
        "t": np.round(np.arange(n) * PERIOD, 6),
        "accel_cmd": table[:n, 0].copy(),
        "steer_cmd": table[:n, 1].copy(),
        **sensed(np.concatenate(rows), effects),
    }
    return Log(add_noise(columns, noise, seed))


def advised(effects: Effects, choice: Choice, noise: Noise, seed: int, envelope: Envelope = ENVELOPE) -> dict[str, Log]:
    """The logs of the advised manoeuvre, as often as it is to be repeated."""
    name, size = choice.manoeuvre.name, choice.drive.size
    return {
        f"{name}_{k}.csv": driven(effects, choice.manoeuvre, noise, (seed << 8) + k, envelope=envelope, size=size)
        for k in range(choice.repeats)
    }


def sets(found: Diagnosis) -> list[set[str]]:
    """The returned set of each effect: its name and its rivals."""
    return [{effect.name, *effect.rivals} for effect in found.effects]


def decided(case: Case) -> dict[str, Any] | None:
    """One case from the town to the answer; None if the effect cannot be seen, or town alone tells it."""
    asked = question(case)
    if asked is None:
        return None
    before = diagnose(asked.logs, asked.model)
    (truth,) = asked.truth
    mine = [found for found in sets(before) if truth in found and len(found) > 1]
    if not mine:
        return None
    envelope = ENVELOPE
    advice = advise(before, asked.logs, asked.model, envelope, exciting=False)
    if any(choice.weak for choice in advice.choices):
        envelope = WIDER
        advice = advise(before, asked.logs, asked.model, envelope, exciting=False)
    line: dict[str, Any] = {
        "key": case.key, "truth": asked.truth, "noise": case.noise, "before": [sorted(found) for found in sets(before)],
    }  # fmt: skip
    choices = list(advice.deciding.values())
    if not choices:
        return {**line, "advised": [], "after": [], "alone": False, "refused": list(advice.refused)}
    logs = dict(asked.logs)
    for k, choice in enumerate(choices):
        logs |= advised(asked.truth, choice, cast(Noise, case.noise), case.log_seed + 7 * k, envelope)
    after = diagnose(logs, asked.model)
    return {
        **line,
        "advised": [f"{c.manoeuvre.name} x{c.repeats}" for c in choices],
        "wider": envelope is WIDER,
        "weak": [c.weak for c in choices],
        "gap": [round(c.gap, 4) for c in choices],
        "after": [sorted(found) for found in sets(after)],
        "verdict": after.verdict,
        "alone": sets(after) == [{truth}],
    }


def candidates_of(base_seed: int) -> Iterator[Case]:
    """Urban cases without end, each effect in turn."""
    for seed in range(1000):
        for k, name in enumerate(CONFUSED):
            yield Case("urban", (name,), seed, NOISES[(seed + k) % 3], base_seed=base_seed)


def run(count: int, base_seed: int = 2000) -> Iterable[dict[str, Any]]:
    """The first `count` ambiguous cases, one after another."""
    left = count
    for case in candidates_of(base_seed):
        line = decided(case)
        if line is not None:
            yield line
            left -= 1
        if not left:
            return


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--cases", type=int, default=30)
    parser.add_argument("--seed", type=int, default=2000)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    lines = []
    for line in run(args.cases, args.seed):
        lines.append(line)
        said = " ".join(f"{{{', '.join(found)}}}" for found in line["after"]) or "nothing"
        wider = " (wider)" if line.get("wider") else ""
        town = " ".join(f"{{{', '.join(found)}}}" for found in line["before"])
        print(
            f"{'yes' if line['alone'] else 'NO '} {line['key']}: {town} -> {line['advised']}{wider} -> {said}",
            flush=True,
        )
    alone = sum(line["alone"] for line in lines)
    print(f"after the advised manoeuvre, the truth alone: {alone} of {len(lines)}", file=sys.stderr)
    if args.json:
        args.json.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
