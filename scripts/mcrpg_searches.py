"""The same budget by three searches, and diagnosis first against tuning alone."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scripts.svg_curves import Curve, Panel, curves

if TYPE_CHECKING:
    from pytest_dvp.tuning.iteration_plan import Plan, State
    from pytest_dvp.tuning.tune import Tuning
    from pytest_dvp.workers.pool import Workers

CAR = "nominal"
BUDGET_S = 300  # replays
BUDGET_P = 80  # simulations
SEARCHES = (("coordinate", "coordinate search"), ("cma", "CMA-ES"), ("tpe", "TPE"))


def searches(runs: Path, jobs: int, docs: Path) -> str:
    """Tables as markdown; the figure is written to docs/mcrpg-searches.svg."""
    from pytest_dvp.tuning.implausible_values import find_implausible_values
    from pytest_dvp.tuning.iterate import baked, beginning
    from pytest_dvp.tuning.iteration_plan import drives
    from pytest_dvp.tuning.iteration_plan_file import read_plan
    from pytest_dvp.tuning.structure_search import look_for_structure
    from pytest_dvp.workers.cache import Cache
    from pytest_dvp.workers.pool import Workers
    from scenarios import path as shipped

    hidden = shipped(f"mcrpg/cars/{CAR}.toml")
    plan = read_plan(shipped("mcrpg/paper.toml"), vehicle=f"surrogate:{hidden}")
    out = runs / CAR
    with Workers(Cache(runs / "cache"), jobs, print) as workers:
        state = beginning(plan, out)
        fitted = drives(plan, state, plan.variants, plan.seeds, out / "logs", ("rw",))
        judging = drives(plan, state, plan.held_out, plan.held_out_seeds, out / "logs", ("rw",))
        workers.run([drive.job for drive in [*fitted, *judging]])
        logs, held_out = [d.log for d in fitted], [d.log for d in judging]
        found = look_for_structure(logs, state.model, plan.model, workers.cache, print, presets=True)
        extended = runs / "searches" / "extended.toml"
        extended.parent.mkdir(parents=True, exist_ok=True)
        extended.write_text(found.model or state.model.read_text(encoding="utf-8"), encoding="utf-8")
        alone = {name: _alignment(plan, state, state.model, logs, name, workers) for name, _ in SEARCHES}
        first = {name: _alignment(plan, state, extended, logs, name, workers) for name, _ in SEARCHES}
        rows, panels = [], []
        for what, tunings, model in (("tuning alone", alone, state.model), ("diagnosis first", first, extended)):
            for name, title in SEARCHES:
                tuning = tunings[name]
                point = {k[2:]: v for k, v in tuning.best.point.items() if v != tuning.start.point[k]}
                twin = baked(model, point, runs / "searches" / f"{what.replace(' ', '-')}-{name}.toml")
                rows.append(_row(what, title, tuning, twin, held_out, workers))
            courses = [Curve(title, _chi2(tunings[name])) for name, title in SEARCHES]
            text = f"S on alignment, {what}"
            panels.append(Panel(text, "replays of logs", "chi²/N, best so far", True, courses, (0.1, 1000.0)))
        study = alone["coordinate"].study
        suspects = find_implausible_values(
            study.knobs, study.start, alone["coordinate"].best.point, logs, state.model, print
        )
        better = dataclasses.replace(state, model=extended)
        performance = {name: _performance(plan, better, name, workers) for name, _ in SEARCHES}
        panels.append(Panel("P on performance, on the extended twin", "simulations", "score, best so far", False,
                            [Curve(title, _best(performance[name])) for name, title in SEARCHES]))  # fmt: skip
        more = [_performance_row(plan, better, title, performance[name], workers) for name, title in SEARCHES]
    (docs / "mcrpg-searches.svg").write_text(curves(panels), encoding="utf-8")
    head = ["| what | search | replays | chi²/N, fitted | chi²/N, held out | outside the plausible range |",
            "|---|---|---|---|---|---|"]  # fmt: skip
    told = "; ".join(found.taken) or "nothing"
    back = "; ".join(found.pruned) or "nothing"
    doubts = [f"- {suspicion.sentence}" for suspicion in suspects] or ["- nothing: each value is plausible by itself"]
    lines = [*head, *rows, "", *_caveats(hidden), ""]
    lines += ["Implausible values after the coordinate search alone:", "", *doubts, ""]
    lines += [f"The diagnosis took no simulation: set back to the data sheet: {back}; taken: {told}.", ""]
    lines += [
        "| P on performance | simulations | score, start | score, drives tuned on | score, held-out drives (DT) |"
    ]
    lines += ["|---|---|---|---|---|", *more, ""]
    return "\n".join([*lines, "![Best score over the budget, by search](mcrpg-searches.svg)"])


def _caveats(hidden: Path) -> list[str]:
    """What the figures do not say by themselves: which hidden effects S has no parameter for, and the missing noise."""
    effects = list(tomllib.loads(hidden.read_text(encoding="utf-8"))["hidden"])
    near = {"drive_lag": "`THROTTLE_delay`, which is a dead time and no lag"}
    none = " and ".join(f"`{name}`" for name in effects if name not in near)
    some = "".join(f"; for `{name}` it has only {near[name]}" for name in effects if name in near)
    return [
        "How to read the table:",
        "",
        f"- Of the {len(effects)} hidden effects, {none} have no parameter in S{some}.",
        "  So no search can match the car by tuning alone. The difference shows the cost of missing effects,",
        "  not that one searcher is better than another.",
        "- chi²/N is in units of the noise of the reference system that measured the car, or of the best sensors of",
        "  road cars where that is finer; 1 means that only noise is left.",
    ]


def _alignment(plan: Plan, state: State, model: Path, logs: Sequence[Path], search: str, workers: Workers) -> Tuning:
    from pytest_dvp.tuning.study import Study
    from pytest_dvp.tuning.tune import tune
    from vehicle.model.model_file import read_model
    from vehicle.model.simulator_parameters import s_value

    twin, start, knobs = read_model(model), {}, []
    for knob in plan.S:
        value = s_value(twin, knob.name[2:])
        start[knob.name] = knob.high if value is None else value
        knobs.append(dataclasses.replace(knob, values=tuple(sorted({*knob.values, start[knob.name]}))))
    study = Study("S", plan.alignment, tuple(knobs), start, search, BUDGET_S, plan.seed, logs=tuple(logs), model=model)
    return tune(study, workers)


def _performance(plan: Plan, state: State, search: str, workers: Workers) -> Tuning:
    from pytest_dvp.tuning.study import Study
    from pytest_dvp.tuning.tune import tune

    now = state.P["rw"]
    start = {knob.name: now[knob.name[2:]] for knob in plan.P}
    knobs = tuple(dataclasses.replace(k, values=tuple(sorted({*k.values, start[k.name]}))) for k in plan.P)
    study = Study(
        "P", plan.performance, knobs, start, search, BUDGET_P, plan.seed, variants=plan.variants, seeds=plan.seeds,
        model=state.model, fixed_P=now, fixed_S=state.mounts,
    )  # fmt: skip
    return tune(study, workers)


def _row(what: str, title: str, tuning: Tuning, twin: Path, held_out: Sequence[Path], workers: Workers) -> str:
    from pytest_dvp.tuning.held_out_judge import log_chi2
    from pytest_dvp.tuning.plausible_ranges import of_s

    outside = []
    for knob in tuning.study.knobs:
        value, allowed = tuning.best.point[knob.name], of_s(knob.name)
        if allowed is not None and not allowed[0] <= value <= allowed[1]:
            outside.append(f"{knob.name} = {value:.4g} {knob.unit}".strip())
    fitted = tuning.best.metrics["log10.chi2_per_n"]
    assert fitted is not None
    judged = 10.0 ** log_chi2(twin, held_out, workers)
    cells = [what, title, f"{tuning.simulations}", f"{10.0**fitted:.3g}", f"{judged:.3g}", ", ".join(outside) or "none"]
    return f"| {' | '.join(cells)} |"


def _performance_row(plan: Plan, state: State, title: str, tuning: Tuning, workers: Workers) -> str:
    judge = dataclasses.replace(tuning.study, variants=plan.held_out, seeds=plan.held_out_seeds)
    results = workers.run(judge.jobs(tuning.best.point))
    score = plan.performance.score([result["metrics"] for result in results])
    scores = [
        f"{each.value:.4f}" if each.allowed else "forbidden" for each in (tuning.start.score, tuning.best.score, score)
    ]
    return f"| {' | '.join([title, str(tuning.simulations), *scores])} |"


def _chi2(tuning: Tuning) -> list[tuple[float, float]]:
    """chi^2/N of the best point so far."""
    return _so_far([(t.simulations, t.score.value, _of(t.metrics)) for t in tuning.trials])


def _of(metrics: Mapping[str, float | None]) -> float:
    value = metrics.get("log10.chi2_per_n")
    return math.inf if value is None else 10.0**value


def _best(tuning: Tuning) -> list[tuple[float, float]]:
    return _so_far([(t.simulations, t.score.value, t.score.value) for t in tuning.trials if t.score.allowed])


def _so_far(trials: Sequence[tuple[int, float, float]]) -> list[tuple[float, float]]:
    best, shown, course = math.inf, math.inf, []
    for simulations, score, value in trials:
        if score < best:
            best, shown = score, value
        course.append((float(simulations), shown))
    return course
