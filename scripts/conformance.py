"""Plays all reference trajectories and tells how far apart we are:  python -m scripts.conformance

Writes docs/conformance.md. The references (INDEX.csv, NAME.csv, events/NAME.csv) and the corpus that they were made of
are found through DVP_SHARED or --reference. A row agrees if each of its positions lies within the reference's own
tolerance + 0.05 m, headings within 0.05 rad, speeds within 0.2 m/s, and every state of every element is reached within
30 ms. States are compared, not transitions: where the reference ends an overridden event the standard stops it, and it
stops instantaneous global actions that the standard ends.
"""

from __future__ import annotations

import argparse
import csv
import fnmatch
import math
import os
import sys
import tomllib
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

from openscenario.findings import ScenarioError
from openscenario.model.scenario import Scenario
from openscenario.read import read_scenario
from openscenario.road.network import load_network
from openscenario.storyboard.nodes import Transition
from openscenario.storyboard.play import Played, Row, play
from openscenario.storyboard.reading import READINGS, USUAL, Reading
from scripts.feature_table import features_of, table

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "conformance.md"
REASONS = Path(__file__).with_name("conformance.toml")

SLACK = 0.05  # m, beside the reference's own tolerance
HEADING = 0.05  # rad
SPEED = 0.2  # m/s
EVENTS = 0.03 + 1e-6  # s
DT = 0.01  # s, the step of the references
DURATION = 60.0  # s


class Case(NamedTuple):
    """One reference: its name, files and tolerance [m]."""

    name: str
    scenario: Path
    rows: Path
    events: Path
    library: Path
    tolerance: float


class Worst(NamedTuple):
    """The largest deviation of one kind, in parts of what is allowed; where it is."""

    share: float
    text: str


@dataclass(frozen=True)
class Outcome:
    """What came of one case; `first` is the first deviation beyond what is allowed."""

    name: str
    entities: int
    passed: bool
    worst: str
    first: str


def cases(reference: Path, tier: str | None = "A") -> list[Case]:
    """The references of a tier (None: of all), in the order of INDEX.csv."""
    corpus = reference.parent / "corpus"
    found = []
    with (reference / "INDEX.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            if tier is not None and row["tier"] != tier:
                continue
            name = row["name"]
            folder = reference if (reference / f"{name}.csv").exists() else reference / "more"
            events = folder / "events" / f"{name}.csv"
            tolerance = float(row["tol_pos_m"]) + SLACK
            found.append(Case(name, corpus / row["xosc"], folder / f"{name}.csv", events, corpus, tolerance))
    return found


def played(case: Case, reading: Reading = USUAL) -> tuple[Scenario, Played]:
    """The scenario as `dvp play --dt 0.01 --library CORPUS --reading READING` plays it."""
    scenario = read_scenario(case.scenario, library=[case.library])
    road = scenario.road_network.logic_file
    network = load_network(road) if road is not None else None
    return scenario, play(scenario, network, dt=DT, duration=DURATION, reading=reading)


def judge(case: Case, reading: Reading = USUAL) -> Outcome:
    """Play one case and compare it. Raises nothing: what cannot be read or run is an outcome too."""
    try:
        scenario, ours = played(case, reading)
    except ScenarioError as error:
        text = "; ".join(dict.fromkeys(finding.text for finding in error.findings if finding.severity == "error"))
        return Outcome(case.name, 0, False, "refused", text)
    except Exception as error:  # a defect of ours is an outcome as well: the others still count
        return Outcome(case.name, 0, False, "broken", f"{type(error).__name__}: {error}")
    worst, first = compare(case, ours.rows, ours.transitions)
    return Outcome(case.name, len(scenario.entities), not first, worst, first)


def compare(case: Case, rows: Sequence[Row], transitions: Sequence[Transition]) -> tuple[str, str]:
    """The worst deviation of what was played, and the first one that is too large ("" if none is)."""
    row_worst, row_first, row_time = _compare_rows(case, rows)
    event_worst, event_first, event_time = _compare_events(case.events, transitions)
    worst = max(row_worst, event_worst, key=lambda each: each.share)
    first = event_first if event_first and event_time <= row_time else row_first or event_first
    return worst.text, first


def _compare_rows(case: Case, rows: Sequence[Row]) -> tuple[Worst, str, float]:
    ours = {(round(row.time, 3), row.entity): row for row in rows}
    worst, first, when = Worst(0.0, "none"), "", math.inf
    missing: list[tuple[float, str]] = []
    seen = set()
    with case.rows.open(newline="") as file:
        for row in csv.DictReader(file):
            key = (round(float(row["time"]), 3), row["entity"])
            mine = ours.get(key)
            seen.add(key)
            if mine is None:
                missing.append(key)
                continue
            apart = math.hypot(mine.x - float(row["x"]), mine.y - float(row["y"]))
            turned = abs(math.remainder(mine.h - float(row["h"]), 2.0 * math.pi))
            faster = abs(mine.speed - float(row["speed"]))
            for size, allowed, unit in ((apart, case.tolerance, "m"), (turned, HEADING, "rad"), (faster, SPEED, "m/s")):
                if size / allowed > worst.share:
                    worst = Worst(size / allowed, f"{size:.3f} {unit}")
                if size > allowed and not first:
                    first, when = f"{key[1]} {size:.3f} {unit} apart at {key[0]:g} s", key[0]
    extra = [key for key in ours if key not in seen]
    # a run may end one row earlier or later
    for keys, text in ((missing, "is missing"), (extra, "is not in the reference")):
        if len({time for time, _ in keys}) > 1:
            time, entity = min(keys)
            if time < when:
                first, when = f"{entity} {text} at {time:g} s", time
            worst = max(worst, Worst(1e3, f"rows: {len(keys)} {text.split()[-1]}"), key=lambda each: each.share)
    return worst, first, when


def _compare_events(path: Path, transitions: Sequence[Transition]) -> tuple[Worst, str, float]:
    left = [(each.time, each.element, each.from_state, each.to_state) for each in transitions]
    worst, first, when = Worst(0.0, "none"), "", math.inf
    with path.open(newline="") as file:
        # an action of several actors is one row of ours; the reference writes one for each
        for row in {tuple(row.values()): row for row in csv.DictReader(file)}.values():
            wanted = (row["element"], row["from"], row["to"])
            time = float(row["time"])
            same = [each for each in left if each[1:] == wanted]
            name = f"{wanted[0]} {wanted[1].removesuffix('State')} -> {wanted[2].removesuffix('State')}"
            if not same:
                worst = max(worst, Worst(2e3, "an event is missing"), key=lambda each: each.share)
                if not first:
                    first, when = f"{name} at {time:g} s is missing", time
                continue
            nearest = min(same, key=lambda each: abs(each[0] - time))
            late = nearest[0] - time
            left.remove(nearest)
            if abs(late) / EVENTS > worst.share:
                worst = Worst(abs(late) / EVENTS, f"{abs(late):.3f} s")
            if abs(late) > EVENTS and not first:
                first, when = f"{name} {late:+.3f} s at {time:g} s", min(time, nearest[0])
    return worst, first, when


def reasons() -> dict[str, str]:
    """Name of a case -> the clause of the standard that we follow where the reference does something else."""
    with REASONS.open("rb") as file:
        return dict(tomllib.load(file)["followed"])


def page(outcomes: Sequence[Outcome], strict: Sequence[Outcome], why: dict[str, str]) -> str:
    """docs/conformance.md: the outcomes of the usual reading, then those of the standard's, of the same cases."""
    lines = [
        "# Conformance\n",
        "This page compares trajectories and storyboard events of an independent implementation (esmini 3.6.0,",
        "step 10 ms, default controllers) with `dvp play` of the same files. Two drives agree if positions are",
        "within the reference's tolerance (0.05 m, or twice the change with its step size) + 0.05 m, headings",
        "within 0.05 rad, speeds within 0.2 m/s and states within 30 ms. If the two differ, the last column names",
        "the clause of the standard that we follow, or says that the standard does not decide, and what we do.",
        "`make conformance` writes this page.\n",
        f"**{_agreeing(outcomes)}**; with `--reading standard` {_agreeing(strict)}. The goal is 95 %.\n",
        "For three rules, existing files rely on the behaviour of esmini, although the standard (1.3) says",
        "otherwise: an event that is *overridden* with executions left runs again at its next trigger (8.4.2.2:",
        "it is complete); a *continuous LaneOffsetAction to an absolute offset* ends there (class",
        "LaneOffsetAction: it must be stopped; the motion is the same); *DynamicConstraints of a",
        "SpeedProfileAction* never exceed the vehicle's Performance (class SpeedProfileAction: they have",
        "precedence over it; no reference shows it). `dvp play`, `dvp run` and pytest follow esmini here, and a",
        "warning says so where it mattered; `--reading standard` (pytest: `--dvp-reading`, `dvp_reading` in an",
        "ini file; in a test: `run(..., reading=...)`) follows the text. Everywhere else, the standard decides.\n",
        "| scenario | entities | verdict | as the standard | worst deviation | reason |",
        "|---|---|---|---|---|---|",
    ]
    for each, other in zip(outcomes, strict, strict=True):
        verdict = "agrees" if each.passed else ("differs" if each.worst not in ("refused", "broken") else each.worst)
        differing = other if each.passed else each
        reason = "" if differing.passed else "; ".join(filter(None, (differing.first, why.get(each.name, ""))))
        theirs = "agrees" if other.passed else "differs"
        cells = (each.name, str(each.entities), verdict, theirs, each.worst, reason)
        lines.append("| " + " | ".join(cell.replace("|", "/").replace("\n", " ") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def _agreeing(outcomes: Sequence[Outcome]) -> str:
    passed = sum(each.passed for each in outcomes)
    return f"{passed} of {len(outcomes)} agree ({100.0 * passed / max(len(outcomes), 1):.1f} %)"


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    shared = Path(os.environ.get("DVP_SHARED", ROOT.parent / "shared"))
    parser.add_argument("--reference", type=Path, default=shared / "openscenario" / "reference", metavar="FOLDER")
    parser.add_argument("--tier", default="A")
    parser.add_argument("--only", default="*", metavar="PATTERN", help="names to play; no page is written then")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--least", type=float, default=0.0, metavar="SHARE", help="exit 1 if fewer agree")
    options = parser.parse_args(arguments)
    if not (options.reference / "INDEX.csv").is_file():
        print(f"no reference trajectories at {options.reference} (set DVP_SHARED)", file=sys.stderr)
        return 2
    wanted = [case for case in cases(options.reference, options.tier) if fnmatch.fnmatch(case.name, options.only)]
    both: dict[Reading, list[Outcome]] = {}
    with ProcessPoolExecutor(options.processes, mp_context=get_context("spawn")) as pool:
        for reading in READINGS:
            both[reading] = list(pool.map(judge, wanted, [reading] * len(wanted)))
            for each in both[reading]:
                if not each.passed:
                    print(f"{reading}: {each.name}: {each.worst}: {each.first}")
    for reading, outcomes in both.items():
        print(f"{reading}: {_agreeing(outcomes)}")
    if options.only == "*" and options.tier == "A":
        shown = {
            case.name: (features_of(read_scenario(case.scenario, library=[case.library])), each.passed)
            for case, each in zip(wanted, both[USUAL], strict=True)
            if each.worst not in ("refused", "broken")
        }
        more = "\n".join(table(shown, options.reference.parent / "wild")) + "\n"
        PAGE.write_text(page(both[USUAL], both["standard"], reasons()) + more, encoding="utf-8")
    passed = sum(each.passed for each in both[USUAL])
    return 0 if wanted and passed >= options.least * len(wanted) else 1


if __name__ == "__main__":
    sys.exit(main())
