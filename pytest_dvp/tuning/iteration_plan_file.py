"""Plan files (TOML) of `dvp iterate`."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from pytest_dvp.tuning.iteration_plan import MOUNTS, STAGES, Plan
from pytest_dvp.tuning.objective import ALIGNMENT
from pytest_dvp.tuning.searchers import search_names
from pytest_dvp.tuning.toml_reader import Reader

_TOP = ("iterate", "scenario", "held_out", "parameters", "term", "constraint")
_ITERATE = (
    "model", "preset", "vehicle", "seeds", "held_out_seeds", "last_seeds", "other_seeds", "iterations", "search",
    "seed", "budget_P", "budget_S", "structure", "library", "proving_ground", "ads", "stages",
)  # fmt: skip


def read_plan(path: Path, **changes: Any) -> Plan:
    """A plan from its file; `changes` of vehicle, iterations, structure from the command line. Raises
    TuneError, one line."""
    return _PlanReader(path).plan({k: v for k, v in changes.items() if v is not None})


class _PlanReader(Reader):
    def plan(self, changes: dict[str, Any]) -> Plan:
        self.tables_of(_TOP, "a plan")
        head = self.table(self.data.get("iterate", {}), "iterate")
        self.known(head, _ITERATE, "key of [iterate]")
        if "model" not in head:
            self.fail("iterate", "no twin to begin with: model = ... in [iterate]")
        model = self.file(str(head["model"]), "model")
        preset = self.whole(head, "preset", 10, (1, 5, 10)) if "preset" in head else None
        if "ads" in head:
            self.ads = self.stack(str(head["ads"]))
        P, S = self.presets("performance", preset or 10, "dt", stated=preset is not None)
        knobs, _ = self.knobs({**P, **_of_the_twin(model), **S})
        plan = Plan(
            name=self.path.stem,
            model=model,
            variants=self.variants("scenario"),
            held_out=self.variants("held_out"),
            P=tuple(k for k in knobs if k.name.startswith("P.")),
            S=tuple(k for k in knobs if k.name.startswith("S.")),
            performance=self.objective("performance"),
            alignment=ALIGNMENT,
            preset=preset,
            vehicle=self.vehicle(str(head.get("vehicle", "surrogate"))),
            seeds=tuple(self.wholes(head, "seeds", (7,))),
            held_out_seeds=tuple(self.wholes(head, "held_out_seeds", (101, 102))),
            last_seeds=tuple(self.wholes(head, "last_seeds", (111, 112, 113, 114, 115))),
            other_seeds=tuple(self.wholes(head, "other_seeds", (201, 202, 203, 204, 205))),
            iterations=self.whole(head, "iterations", 6, least=1),
            search=str(self.word(head, "search", search_names(), "coordinate")),
            seed=self.whole(head, "seed", 1),
            budget_P=self.whole(head, "budget_P", 100, least=1),
            budget_S=self.whole(head, "budget_S", 400, least=1),
            structure=bool(self.word(head, "structure", (True, False), True)),
            library=tuple(self.file(name, "folder") for name in self.words(head, "library")),
            proving_ground=self.manoeuvres(head),
            ads=None if self.ads is None else self.ads.word,
            stages=self.stages(head),
        )
        plan = dataclasses.replace(plan, **changes)
        self.whole_plan(plan)
        return plan

    def manoeuvres(self, head: dict[str, Any]) -> tuple[str, ...]:
        from pytest_dvp.gap.manoeuvres.catalogue import chosen

        names = tuple(self.words(head, "proving_ground"))
        try:
            chosen(names)
        except ValueError as error:
            self.fail("proving_ground", str(error))
        return names

    def stages(self, head: dict[str, Any]) -> tuple[str, ...]:
        names = set(self.words(head, "stages") or STAGES)
        if not {"dt", "rw"} <= names <= set(STAGES):
            self.fail("stages", f"stages is {sorted(names)}, expected dt and rw, and pe if it is to be driven")
        return tuple(stage for stage in STAGES if stage in names)

    def whole_plan(self, plan: Plan) -> None:
        if not plan.variants:
            self.fail("iterate", "nothing to learn from: [[scenario]] file = ...")
        if not plan.held_out:
            self.fail("iterate", "nobody to judge: [[held_out]] file = ... that nothing is learnt from")
        if not plan.P:
            self.fail("parameters", "no P to tune")
        for variant in plan.held_out:
            if variant in plan.variants and set(plan.seeds) & {*plan.held_out_seeds, *plan.last_seeds}:
                self.fail("held_out", f"{variant.title}: learnt from with the same seed, and so would judge itself")
        if seen := sorted(set(plan.last_seeds) & set(plan.held_out_seeds)):
            self.fail(
                "last_seeds",
                f"last_seeds and held_out_seeds share {', '.join(map(str, seen))}: twin and stack are chosen by those "
                "drives, so the table at the end would judge its own choice",
            )
        if set(plan.last_seeds) & set(plan.other_seeds):
            self.fail("other_seeds", "the car would be held against the very same drive: a seed is in last_seeds, too")
        if len(plan.last_seeds) < 2:
            self.fail(
                "last_seeds",
                f"last_seeds is {list(plan.last_seeds)}, expected two at least: one repeat has no interval",
            )


def _of_the_twin(model: Path) -> dict[str, float]:
    """What the twin has of S, where a candidate begins that no preset covers."""
    from vehicle.model.model_file import read_model
    from vehicle.model.simulator_parameters import S_PARAMETERS, preset_s, s_value

    twin = read_model(model)
    values = {p.name: s_value(twin, p.name) for p in S_PARAMETERS}
    usual = preset_s(10)
    values |= {name: usual[name] for name in MOUNTS}
    return {f"S.{name}": value for name, value in values.items() if value is not None}
