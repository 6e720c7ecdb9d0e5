"""Gates between stages: pass with the twin that was extended on the car's own logs, and fail with every wrong one.

python -m scripts.stage_twins [--wire can] [--jobs 2] [--seed 7]     writes its table into docs/stages.md

The car is the surrogate with something hidden in it (HIDDEN), over ROS 2 messages alone or with its drive-by-wire on
CAN; the twin has learnt that from its logs of stage rw over the same wire (scenarios/models/*_extended.toml). Each twin
drives stage dt of each scenario, the car stage rw with what the stack is told from that twin; then the gates of
scenarios/stages.toml judge. Exit code 0 only if all is as it must be.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import tempfile
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from math import radians
from pathlib import Path

from scenarios import path as shipped
from vehicle.model.model_file import read_model, write_model
from vehicle.model.vehicle_model import VehicleModel

HIDDEN = """\
[hidden.steer_delay]
T = 0.30
[hidden.drive_lag]
tau = 0.25
[hidden.steer_ratio]
g = 0.92
[hidden.understeer]
K = 0.002
"""
SCENARIOS = ("overtaking", "pedestrian_crossing", "urban")
PAGE = Path("docs/stages.md")


@dataclasses.dataclass(frozen=True)
class Wire:
    """How the car is reached: what `--vehicle` calls it, the twins from the data sheet and from the car's logs, the
    marks of its table in the page."""

    vehicle: str
    baseline: str
    extended: str
    begin: str
    end: str


WIRES: Mapping[str, Wire] = {
    "ros2": Wire(
        "surrogate", "models/surrogate.toml", "models/surrogate_extended.toml", "<!-- twins -->", "<!-- /twins -->"
    ),
    "can": Wire(
        "can",
        "models/surrogate_can.toml",
        "models/surrogate_can_extended.toml",
        "<!-- twins on can -->",
        "<!-- /twins on can -->",
    ),
}


def more_steering(model: VehicleModel) -> VehicleModel:
    """A quarter more wheel angle than the car has."""
    return model.with_effect("steer_ratio", {"g": 1.25 * (model.value("steer_ratio", "g") or 1.0)})


BASELINE = "baseline"
TWINS: Mapping[str, tuple[str, Callable[[VehicleModel], VehicleModel]]] = {
    "extended": ("extended on the car's logs", lambda model: model),
    BASELINE: ("from the data sheet", lambda model: model),
    "gain": ("steering gain 25 % off", more_steering),
    "lag": ("0.3 s of steering lag missing", lambda model: model.without_effect("steer_delay")),
    "speed": ("speed 5 % off", lambda model: model.with_effect("wheel_radius", {"ratio": 1.05})),
    "gnss": ("GNSS 0.2 s late", lambda model: model.with_effect("gnss_latency", {"T": 0.2})),
    "heading": ("heading 2° off", lambda model: model.with_effect("heading_bias", {"b": radians(2.0)})),
}
"""Twins by name: what the table says of them, and how each is made of the extended one (BASELINE: is the baseline)."""


def twin_of(name: str, wire: Wire) -> VehicleModel:
    """The twin of a name for the car on a wire."""
    return TWINS[name][1](read_model(shipped(wire.baseline if name == BASELINE else wire.extended)))


@dataclasses.dataclass(frozen=True)
class Held:
    """One twin on one scenario: status of the gates between stages, how many did not pass, the worst in one line, the
    open-loop error [m], and what the drives' own gates said."""

    twin: str
    scenario: str
    status: str
    failed: int
    gates: int
    worst: str
    twin_error: float | None
    drives: str


def hold(twin: str, scenario: str, seed: int, over: str = "ros2") -> Held:
    """Drive both stages and judge."""
    from pytest_dvp.drive import stage_comparison
    from pytest_dvp.drive.run import run
    from pytest_dvp.verdicts.statuses import worst_first

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_model(twin_of(twin, WIRES[over]), folder / "twin.toml")
        (folder / "car.toml").write_text(HIDDEN, encoding="utf-8")
        path = shipped(f"{scenario}.xosc")
        vehicle = f"{WIRES[over].vehicle}:{folder / 'car.toml'}"
        results = {
            stage: run(path, stage=stage, seed=seed, model=folder / "twin.toml", vehicle=vehicle)
            for stage in ("dt", "rw")
        }
    drives = {stage: stage_comparison.StageDrive(result.log) for stage, result in results.items()}
    about = {"scenario": f"{scenario}.xosc", "line": 1, "seed": seed, "replay": ""}
    held = stage_comparison.compare_stages(
        drives, stage_comparison.gates_between(path, None, shipped("stages.toml")), [("dt", "rw")], about
    )
    bad = [verdict for verdict in held.verdicts if verdict.status != "PASS"]
    worst = worst_first([verdict.as_dict() for verdict in held.verdicts])[0]
    return Held(
        twin,
        scenario,
        held.status,
        len(bad),
        len(held.verdicts),
        str(worst["short"]).split(" at t=")[0] if bad else "",
        next((verdict.value for verdict in held.verdicts if verdict.metric == "twin_error"), None),
        ", ".join(f"{stage} {result.status}" for stage, result in results.items()),
    )


def table(held: list[Held]) -> str:
    """The table of the page."""
    heads = " | ".join(name.replace("_", " ") for name in SCENARIOS)
    lines = [
        f"| twin | {heads} | open-loop error [m] | what shows most |",
        f"|---|{'---|' * len(SCENARIOS)}---:|---|",
    ]
    for name, (words, _) in TWINS.items():
        mine = [one for scenario in SCENARIOS for one in held if (one.twin, one.scenario) == (name, scenario)]
        if not mine:
            continue
        cells = [one.status if not one.failed else f"{one.status} ({one.failed} of {one.gates})" for one in mine]
        errors = [one.twin_error for one in mine if one.twin_error is not None]
        told = " to ".join(dict.fromkeys(f"{error:.3f}" for error in (min(errors), max(errors)))) if errors else "-"
        worst = max(mine, key=lambda one: one.failed).worst.replace("|", "\\|")
        lines.append(f"| {words} | {' | '.join(cells)} | {told} | {worst or 'nothing'} |")
    return "\n".join(lines)


def main(argv: list[str] | None = None) -> int:
    """Returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m scripts.stage_twins", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--wire", choices=WIRES, default="ros2")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--dry", action="store_true", help="write no page")
    arguments = parser.parse_args(argv)
    cases = [(twin, scenario) for scenario in reversed(SCENARIOS) for twin in TWINS]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        held = list(
            pool.map(hold, *zip(*cases, strict=True), [arguments.seed] * len(cases), [arguments.wire] * len(cases))
        )
    for one in held:
        print(f"{one.twin:9} {one.scenario:20} {one.status} {one.failed} of {one.gates}, {one.drives}; {one.worst}")
    text = table(held)
    print(text)
    if not arguments.dry:
        page = PAGE.read_text(encoding="utf-8")
        wire = WIRES[arguments.wire]
        before, rest = page.split(wire.begin)
        PAGE.write_text(f"{before}{wire.begin}\n{text}\n{wire.end}{rest.split(wire.end)[1]}", encoding="utf-8")
    right = all((one.status == "PASS") == (one.twin == "extended") for one in held)
    print("as it must be" if right else "NOT as it must be", file=sys.stderr)
    return 0 if right else 1


if __name__ == "__main__":
    raise SystemExit(main())
