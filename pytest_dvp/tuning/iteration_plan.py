"""What `dvp iterate` does: the twin it starts from, the scenarios it learns on, those that judge, what may be tuned."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from pytest_dvp.tuning.objective import Objective
from pytest_dvp.tuning.study import Variant
from pytest_dvp.tuning.tuned_parameter import Knob
from pytest_dvp.workers.job import Job, pairs

STAGES = ("dt", "pe", "rw")
MOUNTS = ("GNSS_x", "CAMERA_x")  # of S, but no part of the vehicle model


@dataclasses.dataclass(frozen=True, slots=True)
class Plan:
    """One closing of the gaps.

    model       the twin as its data sheet has it; S of `preset` is set in it before anything runs
    preset      the paper's iteration whose P and S are the beginning; None: P of `dvp run`, and the twin as it is
    ads         "FILE.py:Class", the driving stack, whose P begin at the defaults that it declares; None: the reference
    variants, seeds            drives that are learnt from
    held_out, held_out_seeds   drives that judge each iteration; last_seeds: of the table at the end, others;
                other_seeds: of the car's drives that are held against its own
    P, S        knobs with their candidates
    budget_P, budget_S         simulations, and replays of logs, of each tuning
    proving_ground  manoeuvres that the car drives when a diagnosis leaves something open, beside those it advises
    stages      that are driven: dt and rw, and pe unless a plan leaves it out
    structure   whether the missing effects are looked for before anything is tuned
    """

    name: str
    model: Path
    variants: tuple[Variant, ...]
    held_out: tuple[Variant, ...]
    P: tuple[Knob, ...]
    S: tuple[Knob, ...]
    performance: Objective
    alignment: Objective
    preset: int | None = None
    vehicle: str = "surrogate"
    seeds: tuple[int, ...] = (7,)
    held_out_seeds: tuple[int, ...] = (101, 102)
    last_seeds: tuple[int, ...] = (111, 112, 113, 114, 115)
    other_seeds: tuple[int, ...] = (201, 202, 203, 204, 205)
    iterations: int = 6
    search: str = "coordinate"
    seed: int = 1
    budget_P: int = 100
    budget_S: int = 400
    structure: bool = True
    library: tuple[Path, ...] = ()
    proving_ground: tuple[str, ...] = ()
    ads: str | None = None
    stages: tuple[str, ...] = STAGES


@dataclasses.dataclass(frozen=True, slots=True)
class State:
    """Where an iteration stands: the twin's file, P of each stage, S that is no part of the model (mounting)."""

    model: Path
    P: Mapping[str, Mapping[str, float]]
    mounts: Mapping[str, float]

    def with_P(self, values: Mapping[str, float]) -> State:
        """The same values of P on all stages."""
        return dataclasses.replace(self, P={stage: dict(values) for stage in STAGES})


@dataclasses.dataclass(frozen=True, slots=True)
class Drive:
    """One simulation of a stage: which variant, which seed, and the job that makes it and keeps its log."""

    stage: str
    variant: Variant
    seed: int
    job: Job

    @property
    def log(self) -> Path:
        """The file that the job of this drive saves its log to."""
        assert self.job.save is not None
        return Path(self.job.save)


def drives(
    plan: Plan, state: State, variants: tuple[Variant, ...], seeds: tuple[int, ...], logs: Path,
    stages: tuple[str, ...] | None = None,
) -> list[Drive]:  # fmt: skip
    """A drive for each stage, variant and seed; logs are named by the hash of what they depend on.

    stages  those to drive; None: those of the plan
    """
    found = []
    for stage in stages or plan.stages:
        for variant in variants:
            for seed in seeds:
                job = Job(
                    str(variant.scenario), stage, seed, pairs(variant.values), pairs(state.P[stage]),
                    pairs(state.mounts) if stage == "dt" else (), str(state.model),
                    vehicle="surrogate" if stage == "dt" else plan.vehicle, library=tuple(map(str, plan.library)),
                    gated=stage == "dt", ads=plan.ads,
                )  # fmt: skip
                job = dataclasses.replace(job, save=str(logs / f"{job.key[:20]}.mcap"))
                found.append(Drive(stage, variant, seed, job))
    return found
