"""Figures of the behaviour: the shipped scenarios with the paper's presets, and variants from their declared ranges.

Each variant draws every declared parameter evenly from its range and a seed of the sensors' noise; it is driven with
the 10th preset and judged by its own log, not by its gates.
"""

from __future__ import annotations

import argparse
import math
import operator
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

import scenarios
from ads.parameters import ITERATIONS, STAGES, preset
from openscenario.read import read_declarations
from pytest_dvp.drive.run import run

SCENARIOS = ("overtaking", "pedestrian_crossing", "urban", "follow", "traffic_light", "junction")
OF_THE_PAPER = SCENARIOS[:3]
WITHOUT_COLLISION = 0.99  # of the variants
COMPLETED = 0.99
_SIDES = {"greaterOrEqual": 0, "lessOrEqual": 1}

Figure = dict[str, object]


class Outcome(NamedTuple):
    """What became of a variant; `tet` [s]; `replay`: the command that drives it again."""

    collisions: float
    arrived: bool
    tet: float
    replay: str


def ranges(scenario: str) -> dict[str, tuple[float, float]]:
    """Name to (low, high) of a shipped scenario's declared parameters, in the file's order."""
    found = {}
    for declaration in read_declarations(scenarios.path(f"{scenario}.xosc")):
        ends = {_SIDES[c.rule]: float(c.value) for g in declaration.constraint_groups for c in g.value_constraints}
        if len(ends) == len(_SIDES):
            found[declaration.name] = (ends[0], ends[1])
    return found


def variants(scenario: str, samples: int, seed: int) -> Iterator[tuple[dict[str, float], int]]:
    """Values and noise seed of each variant; the first `n` of more samples are those of `n`."""
    rng = np.random.default_rng([seed, SCENARIOS.index(scenario)])
    limits = ranges(scenario)
    for _ in range(samples):
        values = {name: round(float(rng.uniform(low, high)), 3) for name, (low, high) in limits.items()}
        yield values, int(rng.integers(1, 1_000_000))


def drive(scenario: str, values: Mapping[str, float], seed: int, P: Mapping[str, float] | None = None) -> Outcome:
    """Drive one variant."""
    result = run(scenarios.path(f"{scenario}.xosc"), seed=seed, parameters=values, P=P)
    found = result.metrics
    alone = not result.log.objects  # then there is no time to collision
    tet = 0.0 if alone else math.inf if found["tet"] is None else found["tet"]
    return Outcome(found["collision"] or 0.0, found["goal_reached"] == 1.0, tet, result.replay)


def figures(samples: int = 500, seed: int = 1) -> list[Figure]:
    """The figures, each a dict of name, found, goal, met; `samples` variants of each scenario."""
    found: list[Figure] = []
    for scenario in SCENARIOS:
        outcomes = [drive(scenario, values, noise) for values, noise in variants(scenario, samples, seed)]
        found.extend(_of_variants(scenario, outcomes))
    found.extend(_of_presets())
    return found


def _of_variants(scenario: str, outcomes: list[Outcome]) -> list[Figure]:
    n = len(outcomes)
    rows = []
    for what, good, least in (
        ("without collision", [o.collisions == 0.0 for o in outcomes], WITHOUT_COLLISION),
        ("reached the goal", [o.arrived for o in outcomes], COMPLETED),
        ("with a TET of 0, 10th preset", [o.tet == 0.0 for o in outcomes], 1.0),
    ):
        rows.append(
            {
                "name": f"{scenario}: variants {what}",
                "found": f"{sum(good)} of {n}",
                "goal": "all" if least == 1.0 else f">= {100.0 * least:g} %",
                "met": sum(good) >= least * n,
                "failed": [o.replay for o, fine in zip(outcomes, good, strict=True) if not fine],
            }
        )
    return rows


def _of_presets() -> list[Figure]:
    """The nominal scenarios with every preset; the paper has a TET of 0 with the 10th only."""
    rows: list[Figure] = []
    for scenario in OF_THE_PAPER:
        outcomes = {
            (iteration, stage): drive(scenario, {}, 7, preset(iteration, stage).as_dict())
            for iteration in ITERATIONS
            for stage in STAGES
        }
        safe = [f"{i} {stage}" for (i, stage), o in outcomes.items() if o.collisions == 0.0 and o.arrived]
        rows.append(
            {
                "name": f"{scenario}: presets without collision and with the goal reached",
                "found": f"{len(safe)} of {len(outcomes)}",
                "goal": f"{len(outcomes)} of {len(outcomes)}",
                "met": len(safe) == len(outcomes),
            }
        )
        worst = max(outcomes[10, stage].tet for stage in STAGES)
        rows.append(
            {"name": f"{scenario}: TET, 10th preset, worst stage", "found": f"{worst:.2f} s", "goal": "0 s",
             "met": worst == 0.0}
        )  # fmt: skip
    return rows


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    for figure in figures(chosen.samples, chosen.seed):
        print("met   " if figure["met"] else "MISSED", *operator.itemgetter("name", "found", "goal")(figure), sep=" | ")
        for command in figure.get("failed", []):  # type: ignore[attr-defined]
            print("    ", command)
