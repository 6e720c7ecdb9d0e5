"""MCRPG: DT, PE and RW drives, diagnosis, extension of the twin, tuning of S and P; again until nothing improves.

Source: Arango et al., Sensors 2026, 26, 1338 (method); structure is looked for before parameters are tuned, because a
parameter that is tuned while an effect is missing takes the place of the effect.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pytest_dvp.text.plain_json import finite
from pytest_dvp.tuning.held_out_judge import (
    HeldOutScore,
    judge,
    log_chi2,
    rw_logs,
    same_stack_change,
    stack_change,
    twin_change,
)
from pytest_dvp.tuning.implausible_values import ImplausibleValue, find_implausible_values
from pytest_dvp.tuning.iteration_plan import MOUNTS, STAGES, Plan, State, drives
from pytest_dvp.tuning.ledger import Entry, write_ledger
from pytest_dvp.tuning.objective import Score
from pytest_dvp.tuning.proving_ground import Folders, ProvingGroundResult, on_proving_ground
from pytest_dvp.tuning.sensitivity import as_dict, sensitivity
from pytest_dvp.tuning.stage_gap import Figure, gap, mean_alike
from pytest_dvp.tuning.structure_search import StructureResult, look_for_structure
from pytest_dvp.tuning.study import Study
from pytest_dvp.tuning.tune import Tuning, tune
from pytest_dvp.tuning.tuned_parameter import Point, changed
from pytest_dvp.workers.pool import Workers
from reports.whole_file import write_whole

MOST_INCIDENTS = 6  # drives that are told one by one
SHOWN = 5e-3  # of a score: a part that moved by less is not told

Tick = Callable[[str], None]


@dataclasses.dataclass(frozen=True, slots=True)
class Iterated:
    """Result of `iterate`: every entry of the ledger, the state at the end, the judge's first and last word, and how
    alike the mean drives of the car are of two sets of seeds, which differ in the noise of its sensors alone."""

    plan: Plan
    entries: tuple[Entry, ...]
    state: State
    first: HeldOutScore
    last: HeldOutScore
    repeatability: Mapping[str, Figure]
    ended: str


def iterate(plan: Plan, workers: Workers, out: Path, tick: Tick = lambda text: None) -> Iterated:
    """Close the gaps. Writes ledger.jsonl and a folder an iteration below `out`; killed, it goes on where it was."""
    logs = out / "logs"
    state = beginning(plan, out)
    tick("the beginning, on held-out drives")
    now = first = judge(plan, state, plan.held_out_seeds, workers, logs)
    told = [*_first_words(plan), *_unlike_P(state), *_broke(first)]
    entries = [_entry(plan, 0, state, now, workers, changes=told)]
    write_ledger(out / "ledger.jsonl", entries)
    grounds: list[ProvingGroundResult] = []  # what was driven on the proving ground once is learnt from ever after
    ended = f"the limit of {plan.iterations} (--iterations)"
    for number in range(1, plan.iterations + 1):
        step = _improve(plan, number, state, now, workers, out, tick, grounds)
        entries.append(step.entry)
        write_ledger(out / "ledger.jsonl", entries)
        if not step.entry.accepted:
            ended = "nothing improves on held-out drives"
            break
        state, now = step.judged.state, step.judged
    tick("the last word: held-out drives with repeats")
    last = judge(plan, state, plan.last_seeds, workers, logs)
    tick("the car against itself")
    again = [drives(plan, state, plan.held_out, seeds, logs, ("rw",)) for seeds in (plan.last_seeds, plan.other_seeds)]
    workers.run([drive.job for drive in again[1]])
    return Iterated(plan, tuple(entries), state, first, last, mean_alike(*again), ended)


def beginning(plan: Plan, out: Path) -> State:
    """The twin of the data sheet with S of the preset set in it, and P of the preset, stage by stage."""
    from vehicle.model.simulator_parameters import preset_s

    S: dict[str, float] = preset_s(plan.preset or 10)  # type: ignore[arg-type]
    if plan.preset is None:
        S = {name: S[name] for name in MOUNTS}
    S.pop("PEDESTRIAN_speed", None)  # the scenario moves the pedestrian, on all stages alike
    model = baked(plan.model, S, out / "iteration-00" / "twin.toml")
    return State(model, _first_P(plan), {name: S[name] for name in MOUNTS if name in S})


def _first_P(plan: Plan) -> dict[str, dict[str, float]]:
    """P of the preset, stage by stage; of a stack of one's own what it declares."""
    from ads.parameters import preset

    if plan.ads is None:
        return {stage: preset(plan.preset or 10, stage).as_dict() for stage in STAGES}
    from pytest_dvp.drive.stack_host import find_ads
    from pytest_dvp.drive.stack_parameters import as_plain, in_force

    ads = find_ads(plan.ads)
    return {stage: as_plain(in_force(ads, {}, stage)) for stage in STAGES}


def baked(model: Path, S: Mapping[str, float], target: Path) -> Path:
    """A model file with parameters of S set in it; the same bytes leave the file as it is."""
    from vehicle.model.model_file import model_text, read_model
    from vehicle.model.simulator_parameters import apply_s
    from vehicle.sensors import default_sensors

    twin = read_model(model)
    twin, _ = apply_s(twin, default_sensors(car=twin.car), S)
    return _written(model_text(twin), target)


def _written(text: str, target: Path) -> Path:
    target.parent.mkdir(parents=True, exist_ok=True)
    if not target.is_file() or target.read_text(encoding="utf-8") != text:
        write_whole(target, text.encode())
    return target


@dataclasses.dataclass(frozen=True, slots=True)
class _Step:
    entry: Entry
    judged: HeldOutScore


def _improve(
    plan: Plan,
    number: int,
    state: State,
    now: HeldOutScore,
    workers: Workers,
    out: Path,
    tick: Tick,
    grounds: list[ProvingGroundResult],
) -> _Step:
    """One iteration: learn on the training drives, then ask the judge."""
    folder = out / f"iteration-{number:02d}"
    folder.mkdir(parents=True, exist_ok=True)

    def told(text: str) -> None:
        tick(f"iteration {number}: {text}")

    told("drives")
    asked = drives(plan, state, plan.variants, plan.seeds, out / "logs")
    workers.run([drive.job for drive in asked])
    measured = rw_logs(asked)
    more: list[str] = []
    presets = number == 1 and plan.preset is not None
    learnt = [*measured, *(log for ground in grounds for log in ground.logs)]
    if plan.structure:
        told("diagnosis")
        ground = on_proving_ground(
            plan, learnt, state.model, Folders(folder / "proving_ground", out / "logs"), workers, told, presets=presets,
            known=[name for ground in grounds for name in ground.names],
        )  # fmt: skip
        more = [f"driven on the proving ground: {', '.join(ground.names)}"] if ground.names else []
        more += [f"on the proving ground, {sentence}" for sentence in ground.unfinished]
        learnt += ground.logs
        grounds.append(ground)
    found, model = _structure(plan, learnt, state.model, folder, workers, told, presets=presets)
    tuned_S, point_S, twin = _tuned_S(plan, measured, model, state.mounts, folder, workers, told)
    suspicions = find_implausible_values(plan.S, tuned_S.start.point, point_S, measured, model, told) if tuned_S else []
    old, new = log_chi2(state.model, now.logs, workers), log_chi2(twin, now.logs, workers)
    better_twin = twin_change(old, new) == "better"
    twin_words = f"twin {twin_change(old, new)} on held-out logs (chi^2/N {10**old:.3g} -> {10**new:.3g})"
    candidate = dataclasses.replace(state, model=twin) if better_twin else state
    tuned_P = _tuned_P(plan, candidate, workers, told)
    _write(folder / "tune_P.json", tuned_P.as_dict())
    best_P = {**candidate.P["rw"], **{name[2:]: value for name, value in tuned_P.best.point.items()}}
    options = []
    if stack_change(tuned_P.start.score.value, tuned_P.best.score.value) == "better":
        options.append(("twin and stack" if better_twin else "stack", candidate.with_P(best_P)))
    if better_twin:
        options.append(("twin", candidate))
    told("held-out drives")
    judged, accepted, why = _chosen(plan, options, state, now, workers, out / "logs")
    why = f"{twin_words}; {why}"
    changes = more + _words(found, tuned_S, tuned_P, suspicions, accepted, why)
    changes += _broke(judged)
    structure = {
        "verdict": found.diagnosis["verdict"] if found else "",
        "named": [e["name"] for e in found.diagnosis["effects"]] if found else [],
        "taken": list(found.taken) if found else [],
        "pruned": list(found.pruned) if found else [],
        "refusal": found.refusal if found else "",
        "chi2_per_n": found.diagnosis["chi2_per_n"] if found else None,
    }
    drives_gap = gap(asked).as_dict()
    tuned = {"S": _told(tuned_S), "P": _told(tuned_P)}
    kept = judged if accepted else now
    entry = _entry(
        plan, number, kept.state, kept, workers, structure=structure, tuned=tuned,
        suspicions=[{**s.as_dict(), "sentence": s.sentence} for s in suspicions], changes=changes, accepted=accepted,
        training=drives_gap,
    )  # fmt: skip
    return _Step(entry, kept)


def _structure(
    plan: Plan, logs: list[Path], model: Path, folder: Path, workers: Workers, tick: Tick, *, presets: bool
) -> tuple[StructureResult | None, Path]:
    if not plan.structure:
        return None, model
    tick("diagnosis")
    found = look_for_structure(logs, model, plan.model, workers.cache, tick, presets=presets)
    _write(folder / "diagnosis.json", found.diagnosis)
    if found.extension is not None:
        _write(folder / "extension.json", found.extension)
    return found, model if found.model is None else _written(found.model, folder / "extended.toml")


def _tuned_S(
    plan: Plan, logs: list[Path], model: Path, mounts: Mapping[str, float], folder: Path, workers: Workers, tick: Tick
) -> tuple[Tuning | None, Point, Path]:
    """S tuned on alignment and set in the twin, if there is anything of S to tune."""
    from vehicle.model.model_file import read_model
    from vehicle.model.simulator_parameters import s_value

    twin = read_model(model)
    start, knobs = {}, []
    for knob in plan.S:
        value = mounts.get(knob.name[2:], s_value(twin, knob.name[2:]))
        start[knob.name] = knob.high if value is None else value
        values = tuple(sorted({*knob.values, start[knob.name]}))
        knobs.append(dataclasses.replace(knob, values=values))
    if not knobs:
        return None, {}, _written(model.read_text(encoding="utf-8"), folder / "twin.toml")
    tick("tuning S on alignment")
    study = Study(
        "S", plan.alignment, tuple(knobs), start, plan.search, plan.budget_S, plan.seed, logs=tuple(logs), model=model
    )
    tuning = tune(study, workers, tick)
    _write(folder / "tune_S.json", tuning.as_dict())
    # A value that gains next to nothing is no news of the car, and adds no effect to the twin.
    gained = twin_change(tuning.start.score.value, tuning.best.score.value) == "better"
    point = tuning.best.point if gained else tuning.start.point
    moved = {name[2:]: point[name] for name in changed(start, point)}
    return tuning, point, baked(model, moved, folder / "twin.toml")


def _tuned_P(plan: Plan, state: State, workers: Workers, tick: Tick) -> Tuning:
    """P tuned on performance, on the twin."""
    tick("tuning P on performance")
    now = state.P["rw"]
    start = {knob.name: now[knob.name[2:]] for knob in plan.P}
    knobs = tuple(dataclasses.replace(k, values=tuple(sorted({*k.values, start[k.name]}))) for k in plan.P)
    study = Study(
        "P", plan.performance, knobs, start, plan.search, plan.budget_P, plan.seed, variants=plan.variants,
        seeds=plan.seeds, model=state.model, fixed_P=now, fixed_S=state.mounts, library=plan.library, gated=True,
        ads=plan.ads,
    )  # fmt: skip
    return tune(study, workers, tick)


def _chosen(
    plan: Plan, options: list[tuple[str, State]], state: State, now: HeldOutScore, workers: Workers, logs: Path
) -> tuple[HeldOutScore, str, str]:
    """The first option that is better on held-out drives in one thing and worse in none; its name, and why."""
    reasons = []
    for name, option in options:
        judged = judge(plan, option, plan.held_out_seeds, workers, logs)
        twin = "alike"
        if option.model != state.model:  # the new drives are logs that the twin has not seen either
            twin = twin_change(log_chi2(state.model, judged.logs, workers), judged.log_chi2)
        stack = stack_change(now.performance.value, judged.performance.value)
        if option.P == state.P:  # the stack is the same: its performance must not differ more than by chance
            stack = same_stack_change(now, judged)
        reason = (
            f"{name}: on the drives with it twin {twin}, performance {stack} "
            f"({_told_score(now.performance)} -> {_told_score(judged.performance)})"
        )
        if "worse" not in (twin, stack) and "better" in (twin, stack):
            return judged, name, reason
        reasons.append(reason)
    return now, "", "; ".join(reasons) or "the stack gains nothing on the twin either"


def _told_score(score: Score) -> str:
    """The number, or what keeps it from counting: `forbidden (collision > 0)`."""
    return f"{score.value:.4g}" if score.allowed else f"forbidden ({', '.join(score.broken)})"


def _words(
    found: StructureResult | None,
    S: Tuning | None,
    P: Tuning,
    suspicions: list[ImplausibleValue],
    accepted: str,
    why: str,
) -> list[str]:
    words = []
    if found is not None:
        verdict = found.diagnosis["verdict"]
        if found.pruned:
            words.append("S that the car does without, set back to the data sheet: " + "; ".join(found.pruned))
        words.append(f"diagnosis {verdict}: " + ("; ".join(found.taken) or found.refusal or "nothing to add"))
    for label, tuning in (("S", S), ("P", P)):
        if tuning is None:
            continue
        moved = changed(tuning.start.point, tuning.best.point)
        told = ", ".join(f"{name} {a:g} -> {b:g}" for name, (a, b) in moved.items()) or "nothing moved"
        change = twin_change if label == "S" else stack_change
        if moved and change(tuning.start.score.value, tuning.best.score.value) != "better":
            told += ", which gains too little to be taken"
        elif moved and label == "P" and "stack" not in accepted:
            told += ", which held-out drives did not bear out"
        words.append(
            f"{label} tuned, {tuning.simulations} {'replays' if label == 'S' else 'simulations'}: {told}; score "
            f"{_told_score(tuning.start.score)} -> {_told_score(tuning.best.score)}{_parts(tuning)}"
        )
    words += [f"guard: {suspicion.sentence}" for suspicion in suspicions]
    words.append(f"held-out drives: {'taken' if accepted else 'rejected'}: {why}")
    return words


def _first_words(plan: Plan) -> list[str]:
    return [
        "twin and stack as the plan gives them"
        if plan.preset is None
        else f"P and S of the paper's iteration {plan.preset}"
    ]


def _unlike_P(state: State) -> list[str]:
    """A line where the stack does not have the same P on all stages: what then differs between them is not the twin's
    alone."""
    first, *others = (state.P[stage] for stage in STAGES)
    unlike = [name for name in first if any(other.get(name) != first[name] for other in others)]
    if not unlike:
        return []
    example = ", ".join(f"{stage} {state.P[stage].get(unlike[0]):g}" for stage in STAGES)
    more = f" and {len(unlike) - 1} more" if len(unlike) > 1 else ""
    return [f"P is not the same on all stages ({unlike[0]}: {example}{more}): stages differ by that, too"]


def _broke(judged: HeldOutScore) -> list[str]:
    """What happened on held-out drives that must not."""
    return [f"on the car: {incident}" for incident in judged.incidents[:MOST_INCIDENTS]] + (
        [f"on the car: {len(judged.incidents) - MOST_INCIDENTS} more such drives"]
        if len(judged.incidents) > MOST_INCIDENTS
        else []
    )


def _parts(tuning: Tuning) -> str:
    """What the tuning moved, term by term: those that changed most."""
    before, after = tuning.start.score.parts, tuning.best.score.parts
    moved = sorted((name for name in after if name in before), key=lambda n: -abs(after[n] - before[n]))
    told = [f"{n} {before[n]:.3g} -> {after[n]:.3g}" for n in moved[:3] if abs(after[n] - before[n]) > SHOWN]
    return f", of it most by {', '.join(told)}" if told else ""


def _told(tuning: Tuning | None) -> dict[str, Any]:
    if tuning is None:
        return {}
    return {
        "start": tuning.start.score.value,
        "best": tuning.best.score.value,
        "simulations": tuning.simulations,
        "ended": tuning.ended,
        "moved": {name: list(pair) for name, pair in changed(tuning.start.point, tuning.best.point).items()},
        "sensitivity": as_dict(sensitivity(tuning)),
        "course": [[trial.simulations, trial.score.value] for trial in tuning.trials],
    }


def _entry(plan: Plan, number: int, state: State, judged: HeldOutScore, workers: Workers, **more: Any) -> Entry:
    from vehicle.model.model_file import read_model
    from vehicle.model.simulator_parameters import S_PARAMETERS, s_value

    twin = read_model(state.model)
    S = {p.name: s_value(twin, p.name) for p in S_PARAMETERS}
    values: dict[str, Any] = {
        "structure": {}, "tuned": {}, "suspicions": [], "training": {},
        "accepted": "beginning", **more,
    }  # fmt: skip
    return Entry(
        number=number,
        P={stage: dict(state.P[stage]) for stage in STAGES},
        S={**{name: value for name, value in S.items() if value is not None}, **state.mounts},
        effects={a.name: dict(a.values) for a in twin.effects},
        held_out=judged.as_dict(),
        simulations=workers.done + workers.known,
        **values,
    )


def _write(path: Path, document: Mapping[str, Any]) -> None:
    write_whole(path, json.dumps(finite(document), ensure_ascii=False, indent=1).encode() + b"\n")
