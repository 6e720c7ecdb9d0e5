"""What the drives of a scenario set could not tell: manoeuvres on a proving ground, for a second diagnosis."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_dvp.tuning.data_sheet_reset import ALLOWED, reset_to_data_sheet
from pytest_dvp.tuning.iteration_plan import Plan
from pytest_dvp.tuning.structure_search import thinned
from pytest_dvp.workers.cache import Cache
from pytest_dvp.workers.job import Job, code_digest, file_digest
from pytest_dvp.workers.pool import Workers
from reports.whole_file import write_whole

if TYPE_CHECKING:
    from pytest_dvp.gap.manoeuvres.choice import Choice
    from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
    from pytest_dvp.logs.log import Log
    from vehicle.model.vehicle_model import VehicleModel

OPEN = ("AMBIGUOUS", "PARTIAL", "UNKNOWN", "NOT_EXCITED")
"""Verdicts of a diagnosis after which it is worth driving more."""

MOST = 1  # manoeuvres that the diagnosis advises, of those that decide the most first
DURATION = 300.0  # s, longer than any manoeuvre
SPEED, LATERAL = 10.0, 3.0  # m/s, m/s^2: what the guard lets out, and the tests were planned for
STEER, STEER_RATE = 0.34, 0.4  # rad, rad/s


@dataclasses.dataclass(frozen=True, slots=True)
class ProvingGroundResult:
    """verdict of the diagnosis before; names of the manoeuvres that were driven to their end for it; unfinished: those
    that broke off, a sentence each; logs of all of them, as what was driven of one is measured alike."""

    verdict: str
    names: tuple[str, ...]
    logs: tuple[Path, ...]
    unfinished: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True, slots=True)
class Folders:
    """Where the files of the manoeuvres are written, and the logs of their drives."""

    manoeuvres: Path
    logs: Path


def on_proving_ground(
    plan: Plan, measured: Sequence[Path], model: Path, folders: Folders, workers: Workers,
    tick: Callable[[str], None] = lambda text: None, *, presets: bool = False, known: Sequence[str] = (),
) -> ProvingGroundResult:  # fmt: skip
    """Diagnose the car's logs; if that leaves something open, have the car drive what would tell.

    presets: as of `look_for_structure`; known: manoeuvres that were driven to their end before, not to be driven again.
    """
    verdict, names = written(
        measured, model, plan, folders.manoeuvres, workers.cache, tick, presets=presets, known=known
    )
    jobs = [job(folders.manoeuvres, name, plan, folders.logs) for name in names]
    results = dict(zip(names, workers.run(jobs), strict=True))
    finished = tuple(name for name, result in results.items() if result["ending"] == "stop" and not result["error"])
    return ProvingGroundResult(
        verdict,
        finished,
        tuple(Path(each.save) for each in jobs if each.save),
        tuple(
            f"{name} did not come to its end: {result['error'] or result['ending']}"
            for name, result in results.items()
            if name not in finished
        ),
    )


def written(
    logs: Sequence[Path], model: Path, plan: Plan, folder: Path, cache: Cache,
    tick: Callable[[str], None] = lambda text: None, *, presets: bool = False, known: Sequence[str] = (),
) -> tuple[str, list[str]]:  # fmt: skip
    """Verdict of the diagnosis of `logs`, and the manoeuvres for what it leaves open, by name, as files of `folder`.

    Those of the plan, whatever is open, and those that the diagnosis advises; none if nothing is open. Kept by the hash
    of logs, model and code.
    """
    files = [file_digest(str(path)) for path in (model, plan.model, *logs)]
    figures = [list(plan.proving_ground), MOST, SPEED, LATERAL, STEER, STEER_RATE, presets, list(known)]
    text = json.dumps(["proving ground", *figures, *files, code_digest()])
    key = hashlib.sha256(text.encode()).hexdigest()
    kept = cache.get(key)
    if kept is None:
        loaded = {path.name: thinned(path) for path in logs}
        verdict, texts = _planned(loaded, model, plan, folder, tick, presets, known)
        kept = {"metrics": {"verdict": verdict, "files": texts}}
        cache.put(key, kept)
    found = kept["metrics"]
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in found["files"].items():
        write_whole(folder / name, content.encode())
    return found["verdict"], sorted(Path(name).stem for name in found["files"] if name.endswith(".xosc"))


def _planned(
    logs: dict[str, Log], file: Path, plan: Plan, folder: Path, tick: Callable[[str], None], presets: bool,
    known: Sequence[str],
) -> tuple[str, dict[str, str]]:  # fmt: skip
    from pytest_dvp.gap.diagnose.diagnose import diagnose
    from pytest_dvp.gap.manoeuvres.advice import advise
    from pytest_dvp.gap.manoeuvres.driving_limits import Envelope
    from pytest_dvp.gap.manoeuvres.plan_folder import write_plan
    from pytest_dvp.gap.manoeuvres.rehearsal import NOISE
    from vehicle.model.model_file import read_model

    model = reset_to_data_sheet(read_model(file), read_model(plan.model), logs, math.inf if presets else ALLOWED).model
    envelope = Envelope(max_speed=SPEED, max_lateral=LATERAL, max_steer=STEER, steer_rate=STEER_RATE)
    found = diagnose(logs, model, tick=tick)
    if found.verdict not in OPEN:
        return found.verdict, {}
    tick("what to drive on a proving ground")
    advice = advise(found, logs, model, envelope)
    choices: dict[str, Choice] = {}
    advised = [choice for choice in advice.choices if choice.manoeuvre.name not in known][:MOST]
    declared = [name for name in plan.proving_ground if name not in known]
    for choice in (*advised, *_declared(model, declared, envelope)):
        choices.setdefault(choice.manoeuvre.name, choice)
    names = sorted(f"{name}{end}" for name in choices for end in (".xosc", ".xodr", "_commands.csv", "_robot.py"))
    for name, choice in choices.items():
        write_plan(choice, model, envelope, found.noise_floor or NOISE, folder, name)
    return found.verdict, {name: (folder / name).read_text(encoding="utf-8") for name in names}


def _declared(model: VehicleModel, wanted: Sequence[str], envelope: Envelope) -> list[Choice]:
    """Each manoeuvre of these names, of the size at which it shows the most of what it reveals."""
    from pytest_dvp.gap.manoeuvres.catalogue import chosen
    from pytest_dvp.gap.manoeuvres.choice import PlanError
    from pytest_dvp.gap.manoeuvres.exciting_manoeuvres import excite
    from pytest_dvp.gap.manoeuvres.rehearsal import NOISE

    found: list[Choice] = []
    for manoeuvre in chosen(wanted):
        shows = SHOWS.get(manoeuvre.name, ("mass",))
        try:
            found += excite(model, shows, NOISE, envelope, manoeuvres=(manoeuvre,))
        except PlanError:
            continue  # it shows nothing on this ground
    return found


SHOWS = {
    "lift_offs": ("lift_off_braking",),
    "coast_down": ("aero_drag",),
    "held_steps": ("drive_lag",),
    "growing_steps": ("steer_ratio",),
    "slow_ramp": ("understeer",),
    "circles_both": ("steer_asymmetry",),
    "sine_sweep": ("steer_lag",),
}
"""What a manoeuvre is sized for; others for the reaction of the whole car."""


def job(folder: Path, name: str, plan: Plan, logs: Path) -> Job:
    """The drive of a manoeuvre with the car, by a robot that plays its commands; its log is kept."""
    asked = Job(
        str(folder / f"{name}.xosc"), "rw", plan.seeds[0], model=str(plan.model), vehicle=plan.vehicle,
        ads=f"{folder / f'{name}_robot.py'}:Robot", duration=DURATION,
    )  # fmt: skip
    return dataclasses.replace(asked, save=str(logs / f"{asked.key[:20]}.mcap"))
