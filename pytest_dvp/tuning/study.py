"""A study: what is tuned, on what, by which search, with how many simulations."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from pytest_dvp.tuning.objective import Objective
from pytest_dvp.tuning.tuned_parameter import Knob, Point, split
from pytest_dvp.workers.job import Job, pairs


@dataclasses.dataclass(frozen=True, slots=True)
class Variant:
    """A scenario with values for parameters that it declares."""

    scenario: Path
    values: Mapping[str, float] = dataclasses.field(default_factory=dict)

    @property
    def title(self) -> str:
        """The scenario's name, and its parameter values in brackets."""
        inside = ", ".join(f"{name}={value:g}" for name, value in self.values.items())
        return self.scenario.stem + (f" ({inside})" if inside else "")


@dataclasses.dataclass(frozen=True, slots=True)
class Study:
    """What `tune` does.

    knobs      in the order in which a coordinate search goes through them
    start      a value for each knob
    fixed_P, fixed_S  all other values of P and S; P of the stack's presets where nothing is stated
    variants, seeds   performance: each with each is one simulation
    gated      the twin behind the guard, as the car is
    ads        "FILE.py:Class", the driving stack; None: the reference stack
    logs       alignment: recorded logs, one replay each
    budget     simulations (or replays), those that the cache had included
    seed       of the search
    """

    name: str
    objective: Objective
    knobs: tuple[Knob, ...]
    start: Point
    search: str = "coordinate"
    budget: int = 200
    seed: int = 1
    stage: str = "dt"
    variants: tuple[Variant, ...] = ()
    seeds: tuple[int, ...] = (7,)
    logs: tuple[Path, ...] = ()
    model: Path | None = None
    vehicle: str = "surrogate"
    fixed_P: Mapping[str, float] = dataclasses.field(default_factory=dict)
    fixed_S: Mapping[str, float] = dataclasses.field(default_factory=dict)
    library: tuple[Path, ...] = ()
    gated: bool = False
    ads: str | None = None

    def jobs(self, point: Point) -> list[Job]:
        """The simulations that judge a point."""
        P, S = split(point)
        model = None if self.model is None else str(self.model)
        given_S = pairs({**self.fixed_S, **S})
        if self.objective.kind == "alignment":
            return [Job("", S=given_S, model=model, log=str(log)) for log in self.logs]
        given_P = pairs({**self.fixed_P, **P})
        library = tuple(map(str, self.library))
        return [
            Job(str(variant.scenario), self.stage, seed, pairs(variant.values), given_P, given_S, model,
                vehicle=self.vehicle, library=library, gated=self.gated, ads=self.ads)
            for variant in self.variants
            for seed in self.seeds
        ]  # fmt: skip

    @property
    def jobs_a_point(self) -> int:
        """Number of simulations that one point takes: the logs of an alignment, else variants times seeds."""
        return len(self.logs) if self.objective.kind == "alignment" else len(self.variants) * len(self.seeds)
