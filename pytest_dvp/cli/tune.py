"""Tunes parameters of the driving stack (P) or of the twin (S) over declared candidates, until nothing improves.

Every simulation is stored under a hash of everything that it depends on. After a kill, the same command continues.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, existing, root_here
from pytest_dvp.cli.shared.progress import progress
from pytest_dvp.cli.shared.worker_options import add_workers, check_workers, workers
from pytest_dvp.text.errors import SettingError
from pytest_dvp.text.plain_json import finite
from pytest_dvp.text.spelling import unknown
from pytest_dvp.tuning.searchers import search_names

if TYPE_CHECKING:
    from pytest_dvp.tuning.repeat_commands import RepeatableRun
    from pytest_dvp.tuning.tune import Tuning

PLACE = 110  # in `dvp --help`

BEST_MODEL = "best.toml"  # an alignment's twin with the best S
SAID = 3  # commands that are printed


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the study, search, budget, seed, output folder and workers."""
    parser.add_argument(
        "study", metavar="STUDY.toml", help="study file: candidates, objective, constraints, scenarios, budget"
    )
    names = ", ".join(search_names())
    parser.add_argument("--search", metavar="NAME", help=f"search algorithm: {names}; coordinate is the paper's")
    parser.add_argument("--budget", type=int, metavar="N", help="maximum number of simulations, including stored ones")
    parser.add_argument("--seed", type=int, metavar="N", help="seed of the search algorithm")
    add_workers(parser)
    parser.add_argument("--out", metavar="DIR", help="folder of the result; default: ROOTDIR/runs/tuning/STUDY-SEARCH")
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Search parameters and write the best. Returns 0 if the best point keeps every declared bound, else 1.

    Raises SettingError for an unknown search, and for a budget or seed that is too small; LogError for a log that
    `dvp doctor` finds errors in.
    """
    path = existing(arguments.study, "study")
    check_workers(arguments)
    for option in ("budget", "seed"):
        value = getattr(arguments, option)
        if value is not None and value < (1 if option == "budget" else 0):
            raise SettingError(f"--{option} is {value}, expected a whole number >= {1 if option == 'budget' else 0}")
    from pytest_dvp.tuning.repeat_commands import repeatable_runs
    from pytest_dvp.tuning.study_file import read_study
    from pytest_dvp.tuning.tune import tune

    if arguments.search is not None and arguments.search not in search_names():
        raise SettingError(f"--search: {unknown('search', arguments.search, search_names())}")
    study = read_study(path, search=arguments.search, budget=arguments.budget, seed=arguments.seed)
    _examine(study.logs)
    out = folder_of(arguments.out, f"{study.name}-{study.search}")
    model = out / BEST_MODEL
    with progress("dvp tune", "tuning") as tick, workers(arguments, tick) as worked:
        found = tune(study, worked, tick, lambda so_far: write(so_far, repeatable_runs(so_far, model), out))
    rows = repeatable_runs(found, model)
    write(found, rows, out)
    print(f"dvp tune: {worked.done} simulated, {worked.known} kept from before; {out}", file=sys.stderr)
    _say_next(rows, out)
    if arguments.json:
        print(json.dumps(finite(_document(found, rows)), ensure_ascii=False, allow_nan=False))
    else:
        print(table(found))
    return 0 if found.best.score.allowed else 1


def _examine(logs: Sequence[Path]) -> None:
    """Print the doctor's warnings about the logs of an alignment. Raises LogError for one with an error: the twin would
    be bent to explain it."""
    from pytest_dvp.doctor import print_findings, read_checked_log

    for log in logs:
        print_findings(read_checked_log(str(log))[1])


def folder_of(text: str | None, name: str) -> Path:
    """The folder of a result, made if it is not there. Raises WrongArgument."""
    folder = Path(text) if text else root_here() / "runs" / "tuning" / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WrongArgument(f"--out {folder}: cannot be made: {error.strerror}") from None
    return folder


def write(found: Tuning, rows: Sequence[RepeatableRun], out: Path) -> None:
    """result.json, trials.csv and `rows`, the commands that repeat the best point; of an alignment its twin, too. Each
    whole or not at all."""
    from pytest_dvp.tuning.repeat_commands import best_model
    from reports.whole_file import write_whole

    if found.study.objective.kind == "alignment":
        write_whole(out / BEST_MODEL, best_model(found.study, found.best.point).encode())
    document = json.dumps(finite(_document(found, rows)), ensure_ascii=False, indent=1)
    write_whole(out / "result.json", document.encode() + b"\n")
    text = io.StringIO()
    sheet = csv.writer(text, lineterminator="\n")
    knobs = [knob.name for knob in found.study.knobs]
    terms = [term.metric for term in found.study.objective.terms]
    sheet.writerow(["trial", "simulations", "score", "broken", *knobs, *terms])
    for trial in found.trials:
        measured = [trial.metrics.get(name) for name in terms]
        sheet.writerow([
            trial.number, trial.simulations, f"{trial.score.value:.6g}", "; ".join(trial.score.broken),
            *(f"{trial.point[name]:g}" for name in knobs), *("" if v is None else f"{v:.6g}" for v in measured),
        ])  # fmt: skip
    write_whole(out / "trials.csv", text.getvalue().encode())
    lines = []
    for row in rows:
        looked_at = ", ".join(f"{name} {_value(value)}" for name, value in row.metrics.items())
        lines += [f"# {row.job.title}: score {_score(row.score)}{_broken(row.broken)}; {looked_at}", row.command]
    write_whole(out / "best.txt", ("\n".join(lines) + "\n").encode())


def _document(found: Tuning, rows: Sequence[RepeatableRun]) -> dict[str, Any]:
    from pytest_dvp.tuning.sensitivity import as_dict, sensitivity

    return {**found.as_dict(), "again": [row.as_dict() for row in rows], "sensitivity": as_dict(sensitivity(found))}


def _say_next(rows: Sequence[RepeatableRun], out: Path) -> None:
    """The commands that drive the best point again, exactly as it was judged."""
    for row in rows[:SAID]:
        print(f"dvp tune: next: {row.command}", file=sys.stderr)
    if len(rows) > SAID:
        print(
            f"dvp tune: the worst of the best point; and {len(rows) - SAID} more in {out / 'best.txt'}", file=sys.stderr
        )


def table(found: Tuning) -> str:
    """The result as text."""
    start, best, study = found.start, found.best, found.study
    lines = [
        f"{study.name}: {study.objective.kind} by {study.search}, {found.simulations} simulations, {found.ended}",
        f"score {_score(start.score.value)} -> {_score(best.score.value)}"
        + _broken(best.score.broken, "; nothing tried keeps what must hold: "),
        "",
        f"  {'parameter':<26}{'start':>12}{'best':>12}  unit",
    ]
    for knob in study.knobs:
        before, after = start.point[knob.name], best.point[knob.name]
        mark = "" if before == after else " *"
        lines.append(f"  {knob.name:<26}{before:>12g}{after:>12g}  {knob.unit}{mark}")
    if start.point != best.point:
        lines.append("  * moved from the start")
    lines += ["", f"  {'metric':<26}{'start':>12}{'best':>12}"]
    for name in study.objective.metrics:
        lines.append(f"  {name:<26}{_value(start.metrics.get(name)):>12}{_value(best.metrics.get(name)):>12}")
    return "\n".join(lines)


def _score(value: float) -> str:
    from pytest_dvp.tuning.objective import FORBIDDEN

    return "forbidden" if value >= FORBIDDEN else f"{value:.4f}"


def _broken(broken: tuple[str, ...], words: str = ", breaks ") -> str:
    return f"{words}{', '.join(broken)}" if broken else ""


def _value(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
