"""Drives scenarios with the stack in the loop; writes metrics, verdicts, and a run folder with log and report."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import json
import sys
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.shared.arguments import add_json, add_settings, settings_from
from pytest_dvp.cli.shared.named_scenarios import named_scenarios
from pytest_dvp.cli.shared.named_stack import named_stack
from pytest_dvp.drive.option import STAGES
from pytest_dvp.drive.run_spec import BUDGET, OF_A_RUN, RunSpec
from pytest_dvp.text.errors import SettingError, is_users_mistake
from pytest_dvp.text.plain_json import finite
from pytest_dvp.text.spelling import unknown
from pytest_dvp.verdicts.result_text import BESIDE_VERDICTS, NOT_WRITTEN

if TYPE_CHECKING:
    from pytest_dvp.drive.chosen_stack import Ads
    from pytest_dvp.drive.result import RunResult
    from pytest_dvp.drive.stage_comparison import StageComparison

PLACE = 30  # in `dvp --help`

PATIENCE = 8.0  # s of wall time before a silent run says why it may take long
FIRST_RUN = "  still at it; the first run after an installation compiles for about a minute, once"
ON_THE_WIRE = "  still at it; a car of its own, beside the harness, may take a minute"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare scenarios, stages, further gates and every option of a run."""
    parser.add_argument("scenarios", nargs="+", metavar="X.xosc", help="scenario, or a folder with scenarios")
    parser.add_argument(
        "--stage",
        default="dt",
        help="stage: dt, pe or rw (pe and rw drive --vehicle); several to compare them, as dt,rw or all",
    )
    parser.add_argument("--no-report", action="store_true", help="judge only; do not write a run folder")
    parser.add_argument(
        "--gate", action="append", metavar="METRIC", help="let only the gates on this metric decide; may be repeated"
    )
    parser.add_argument(
        "--optional-event", action="append", metavar="EVENT", default=[],
        help="storyboard event that need not fire; otherwise, a run does not pass if an event never fired",
    )  # fmt: skip
    parser.add_argument("--no-ini", action="store_true", help="ignore the dvp_ keys of the project's ini file")
    add_settings(parser, OF_A_RUN)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Drive scenarios on the stages asked for. Returns 0 if every verdict is PASS, else 1.

    Raises SettingError for a stage that these options cannot drive; of several scenarios, one that cannot begin is an
    ERROR and the others drive.
    """
    named = named_scenarios(arguments.scenarios)
    settings = settings_from(arguments, ini=(*OF_A_RUN, *BUDGET))
    stages = _stages(arguments.stage)
    _refuse_folders(arguments.scenarios, stages, settings)
    from pytest_dvp.drive.stack_host import find_ads
    from pytest_dvp.drive.stage_checks import check_asked
    from pytest_dvp.drive.stages import StageError

    for stage in stages:
        try:
            check_asked(stage, settings)
        except StageError as error:
            raise SettingError(f"--stage {stage}: {error}") from None
    for text in _not_used(arguments, stages):
        print(f"dvp run: {text}", file=sys.stderr)
    if settings.stage_logs:
        from pytest_dvp.logs.log import Log

        for path in settings.stage_logs:  # a damaged one is told before the first drive
            Log.load(path)
    _check_gates(arguments.gate or ())
    if len(stages) > 1 or settings.stage_logs:
        from pytest_dvp.drive.stage_comparison import gates_between

        for path in named:  # a wrong file is told before the first drive
            gates_between(path, settings.gates, settings.stage_gates)
    with _stdout_for_results(arguments.json):
        ads = find_ads(settings.ads, [settings.rootdir], process=settings.stack_process, tick_limit=settings.tick_limit)
    jobs = _jobs(named, settings, stages, ads)
    _check_events(arguments.optional_event, jobs, settings)
    _refuse_repetition(jobs, settings)
    several = len(jobs) > 1 or any(job.label for job in jobs)
    documents: list[Any] = []
    passed = True
    drives: dict[Path, dict[str, RunResult]] = {}
    failed_stages: dict[Path, dict[str, str]] = {}
    for job in jobs:
        try:
            with _stdout_for_results(arguments.json):
                result = _drive(job, arguments, settings)
        except Exception as error:
            if not several or not is_users_mistake(error):
                raise
            print(error, file=sys.stderr)  # the other scenarios can still run
            findings = [finding.as_dict() for finding in getattr(error, "findings", ())]
            failed = {"scenario": str(job.path), "status": "ERROR", "error": str(error), "findings": findings}
            documents.append(failed | ({"set": dict(job.parameters)} if job.label else {}))
            failed_stages.setdefault(job.path, {})[job.stage] = f"the drive of stage {job.stage} did not begin: {error}"
            passed = False
            continue
        passed = _passes(result, arguments.gate, arguments.optional_event) and passed
        drives.setdefault(job.path, {})[job.stage] = result
        documents.append(finite(result.as_dict()))
        if not arguments.json:
            print(table(result, arguments.gate, arguments.optional_event), flush=True)
    if len(stages) > 1 or settings.stage_logs:
        for path, results in drives.items():
            held = _across(path, results, failed_stages.get(path, {}), stages, arguments, settings)
            passed = passed and (held.status == "PASS" or not held.verdicts)
            documents.append(finite(held.as_dict()))
            if not arguments.json:
                print("\n" + across_text(held), flush=True)
    if arguments.json:
        print(json.dumps(documents if several or len(documents) > 1 else documents[0], ensure_ascii=False))
    return 0 if passed else 1


@dataclasses.dataclass(frozen=True)
class Job:
    """One run: a scenario with values for its parameters; `label`: which case of which distribution it is.

    gates: the gate file of the distribution; folder_name: of its run folder; error: why there is nothing to drive
    """

    path: Path
    parameters: Mapping[str, str]
    stage: str = "dt"
    label: str = ""
    gates: Path | None = None
    folder_name: str | None = None
    error: Exception | None = None


def _stdout_for_results(json_wanted: bool) -> contextlib.AbstractContextManager[object]:
    """With --json, what a stack prints goes to stderr: stdout is one document and nothing else."""
    return contextlib.redirect_stdout(sys.stderr) if json_wanted else contextlib.nullcontext()


def _stages(text: str) -> list[str]:
    """The stages of `--stage`, in their order. Raises SettingError."""
    words = [word.strip() for word in text.split(",") if word.strip()]
    for word in words or [text]:
        if word not in (*STAGES, "all"):
            raise SettingError(f"--stage: {unknown('stage', word, (*STAGES, 'all'))}")
    return [stage for stage in STAGES if stage in words or "all" in words]


def _not_used(arguments: argparse.Namespace, stages: Sequence[str]) -> list[str]:
    """Options that were written and change nothing on these stages."""
    found = []
    if list(stages) == ["dt"]:
        for option in ("vehicle", "dbc", "fault", "clock", "arming", "envelope"):
            value = getattr(arguments, option)
            if value is not None and (option, value) != ("clock", "stepped"):
                why = "stage dt drives the twin; --stage pe or rw drives a car"
                found.append(f"--{option} {value} is not used: {why}")
    if len(stages) == 1 and arguments.stage_gates is not None and not arguments.stage_logs:
        found.append(f"--stage-gates {arguments.stage_gates} is not used: one stage, and no --stage-logs of another")
    return found


def _jobs(named: Sequence[Path], settings: RunSpec, stages: Sequence[str], ads: Ads) -> list[Job]:
    """The runs that the named files ask for: a distribution is all its cases, or a sample."""
    from openscenario.findings import ScenarioError
    from pytest_dvp.campaigns.cases import choose, is_distribution

    cases: dict[Path, list[Job]] = {}
    for path in dict.fromkeys(named):
        if is_distribution(path):
            if list(stages) != ["dt"]:
                text = f"{path} is a distribution, and its cases run on dt alone"
                raise SettingError(f"--stage {','.join(stages)}: {text}")
            try:
                chosen = choose(path, settings, say=lambda text: print(f"dvp run: {text}", file=sys.stderr))
            except ScenarioError as error:
                if len(named) == 1:
                    raise
                cases[path] = [Job(path, {}, error=error)]  # the other files can still run
                continue
            print(f"dvp run: {path}: {chosen.size} of {chosen.count} cases of {chosen.scenario}", file=sys.stderr)
            found = [
                Job(
                    chosen.scenario,
                    case.values,
                    label=f"{path.name}[{case.name}]",
                    gates=chosen.gates,
                    folder_name=chosen.folder_name(case),
                )
                for case in chosen
            ]
            if not found:
                raise SettingError(f"{path}: the scenario's constraints exclude all of these cases")
            cases[path] = found
    scenarios = [cases[path][0].path if path in cases else path for path in named]
    shares = _shares(scenarios, settings, ads)
    jobs: list[Job] = []
    for path, share in zip(named, shares, strict=True):
        jobs += [dataclasses.replace(job, parameters={**job.parameters, **share}) for job in cases.get(path, ())]
        jobs += [] if path in cases else [Job(path, share, stage) for stage in stages]
    return jobs


def _refuse_folders(texts: Sequence[str], stages: Sequence[str], settings: RunSpec) -> None:
    """A real car drives a scenario that a human has named, and not what happens to be in a folder."""
    from pytest_dvp.drive.announced_cars import refuse_repetition
    from pytest_dvp.drive.stages import StageError

    for text in texts:
        if Path(text).is_dir():
            for stage in stages:
                try:
                    refuse_repetition(f"{text}: a folder", stage, settings.vehicle)
                except StageError as error:
                    raise SettingError(str(error)) from None


def _refuse_repetition(jobs: Sequence[Job], settings: RunSpec) -> None:
    """One scenario for each confirmation by a human."""
    from pytest_dvp.drive.announced_cars import is_real, refuse_repetition
    from pytest_dvp.drive.stages import StageError

    real = [job for job in jobs if is_real(job.stage, settings.vehicle)]
    if len(real) > 1:
        try:
            refuse_repetition(f"{len(real)} drives in a row", real[0].stage, settings.vehicle)
        except StageError as error:
            raise SettingError(str(error)) from None


def _drive(job: Job, arguments: argparse.Namespace, settings: RunSpec) -> RunResult:
    from openscenario.findings import ScenarioError
    from pytest_dvp.drive.run import run

    print(f"dvp run: {_banner(job, settings)}", file=sys.stderr)
    if job.error is not None:
        raise job.error
    _say_who_is_waited_for(job.stage, settings.vehicle)
    said = FIRST_RUN if job.stage == "dt" else ON_THE_WIRE
    notice = threading.Timer(PATIENCE, print, (said,), {"file": sys.stderr, "flush": True})
    notice.daemon = True
    notice.start()
    try:
        of_this_job: dict[str, Any] = {
            "stage": job.stage,
            "parameters": job.parameters,
            "gates": settings.gates or job.gates,
            "folder_name": job.folder_name,
        }
        place = {"log_dir": None} if arguments.no_report else {}
        result = run(job.path, **{**settings.keywords(), **of_this_job, **place})
    except ScenarioError as error:
        if settings.ego is None or [finding.code for finding in error.findings] != ["dvp.ego"]:
            raise
        raise SettingError(f"{settings.origin('ego')} {settings.ego}: {error.findings[0].message}") from None
    finally:
        notice.cancel()
    for note in result.notes:
        if not note.startswith(BESIDE_VERDICTS):
            print(note, file=sys.stderr)
    return result


def _banner(job: Job, settings: RunSpec) -> str:
    """What is driven, by which stack, and what of this neither the command line nor a default says."""
    others = [origin for key, origin in settings.origins.items() if key != "ads" and not origin.startswith("--")]
    words = [f"{job.label or job.path}", f"stage {job.stage}", f"seed {settings.seed}", named_stack(settings)]
    return ", ".join(words) + (f"; {', '.join(others)}" if others else "")


def _say_who_is_waited_for(stage: str, vehicle: str) -> None:
    """Of an adapter that can tell, where it looks for the car: nobody should wait a minute to learn that."""
    from pytest_dvp.drive.announced_cars import find_adapter
    from pytest_dvp.drive.stages import REPLAY, VEHICLES

    name, _, argument = vehicle.partition(":")
    if stage == "dt" or name in (*VEHICLES, REPLAY):
        return
    waits_for = getattr(find_adapter(name).open, "waits_for", None)
    if waits_for is not None:
        print(f"  waits for {waits_for(argument)}", file=sys.stderr, flush=True)


def _across(
    path: Path,
    results: Mapping[str, RunResult],
    failed: Mapping[str, str],
    stages: Sequence[str],
    arguments: argparse.Namespace,
    settings: RunSpec,
) -> StageComparison:
    """The stages of one scenario held against each other, with those of earlier logs. failed: why one did not begin."""
    from pytest_dvp.drive import stage_comparison

    gates = stage_comparison.gates_between(path, settings.gates, settings.stage_gates)
    drives, missing = stage_comparison.earlier(settings.stage_logs, path.name)
    missing |= {stage: why for stage, why in failed.items() if stage not in drives}
    for stage, result in results.items():
        found = stage_comparison.driven(result)
        if isinstance(found, str):
            missing[stage] = found
        else:
            drives[stage] = found
            missing.pop(stage, None)
    pairs = stage_comparison.pairs_driven(gates, [*drives, *missing])
    first = next(iter(results.values()))
    about = {
        "scenario": first.scenario,
        "line": first.line,
        "seed": first.seed,
        "ads": first.ads,
        "set": first.set,
        "replay": stage_comparison.replay(
            path, {"parameters": settings.set.scenario, "P": settings.set.P, "S": settings.set.S}, stages, settings),
    }  # fmt: skip
    folder = None if arguments.no_report else settings.runs_folder
    for stage in STAGES:
        if stage not in drives:
            missing.setdefault(stage, f"stage {stage} was not asked for: --stage {','.join((*stages, stage))}")
    unjudged = stage_comparison.left_out(gates, pairs, [*results, *drives])
    return stage_comparison.compare_stages(
        drives,
        gates,
        pairs,
        about,
        missing=missing,
        notes=unjudged,
        files=stage_comparison.Files(folder, settings.single_file, settings.model, settings.effects),
    )


def across_text(held: StageComparison) -> str:
    """The gates between stages and the table, as text."""
    from pytest_dvp.text.printable import clean
    from pytest_dvp.verdicts.result_text import WHY, gathered, page_of
    from pytest_dvp.verdicts.statuses import worst_first

    plain = held.as_dict()
    judged = "" if plain["verdicts"] else ", no gate is between them"
    lines = [clean(f"{plain['scenario']} [{plain['stage']}]: {plain['status'] if not judged else 'compared'}{judged}")]
    lines += [f"  {v['status']:<12} {_told(v)}" for v in gathered(worst_first(plain["verdicts"]))]
    lines += [clean(f"  !! {note}") for note in plain["notes"]]
    lines += ["", *(f"  {clean(line)}" for line in held.table.lines()), ""] if held.table is not None else []
    if page := page_of(plain):
        lines.append(clean(f"  report: {page}"))
    lines += [clean(f"  {WHY}: {command}") for command in plain["why"]]
    lines.append(clean(f"  replay: {plain['replay']}"))
    return "\n".join(lines)


def _shares(paths: Sequence[Path], settings: RunSpec, ads: Ads) -> list[dict[str, str]]:
    """Of `--set` what each scenario declares; with several, a name must be declared by at least one of them."""
    from pytest_dvp.drive.parameter_checks import check_overrides, declared_names

    if len(paths) == 1 or not settings.set.scenario:
        check_overrides(paths[0], settings.set, settings.origin("set"), ads=ads)
        return [dict(settings.set.scenario) for _ in paths]
    declared = [_none_if_broken(declared_names, path) for path in paths]
    known = {name for names in declared for name in names}
    for name in settings.set.scenario:
        if name not in known:
            raise SettingError(f"{settings.origin('set')}: {unknown('parameter', name, known)}")
    shares = [{n: v for n, v in settings.set.scenario.items() if n in names} for names in declared]
    for path, share in zip(paths, shares, strict=True):
        check_overrides(path, dataclasses.replace(settings.set, scenario=share), settings.origin("set"), ads=ads)
    return shares


def _none_if_broken(read: Callable[[Path], Iterable[str]], path: Path) -> tuple[str, ...]:
    """The names that `read` finds in a file; of a broken one none: its own run says what is wrong with it."""
    from openscenario.findings import ScenarioError

    try:
        return tuple(read(path))
    except ScenarioError:
        return ()


def _check_gates(names: Sequence[str]) -> None:
    if names:
        from pytest_dvp.metrics import MetricError, find_metric

        for name in names:
            try:
                find_metric(name)
            except MetricError as error:
                raise SettingError(f"--gate: {error}") from None


def _check_events(optional: Sequence[str], jobs: Sequence[Job], settings: RunSpec) -> None:
    """Each event of --optional-event must be one of a scenario that is driven; told before the first drive."""
    if not optional:
        return
    from openscenario.read import read_scenario
    from pytest_dvp.logs.event_names import EventNames
    from pytest_dvp.verdicts.silent_events import check_optional

    names: list[str] = []
    for job in jobs:

        def events(path: Path, job: Job = job) -> EventNames:
            return EventNames(
                read_scenario(path, library=settings.library, rootdir=settings.rootdir, parameters=job.parameters)
            )

        names += events(job.path) if len(jobs) == 1 else _none_if_broken(events, job.path)
    check_optional(optional, list(dict.fromkeys(names)), "--optional-event")


def _passes(result: RunResult, only: Sequence[str] | None, optional: Sequence[str] = ()) -> bool:
    from pytest_dvp.verdicts.result_text import failure
    from pytest_dvp.verdicts.silent_events import without_optional

    if only is None and not optional:
        return result.status == "PASS"
    return failure(without_optional(result.as_dict(), optional), only) is None


def table(result: RunResult, only: Sequence[str] | None = None, optional: Sequence[str] = ()) -> str:
    """The verdicts of a run as text, worst first, and where its report is; `only` those metrics decide, and the
    `optional` events need not fire."""
    from pytest_dvp.text.printable import clean
    from pytest_dvp.verdicts.result_text import on_condition, page_of, without_clean
    from pytest_dvp.verdicts.silent_events import missed
    from pytest_dvp.verdicts.statuses import worst_first

    plain = result.as_dict()
    said = f"{plain['scenario']} [{plain['stage']}]: {plain['status']}"
    lines = [clean(f"{said} after {plain['simulated']:.2f} s simulated, ended by {plain['ended']}")]
    shown, held_bounds = without_clean(worst_first(plain["verdicts"]))
    lines += [f"  {v['status']:<12} {_told(v)}" for v in shown]
    lines += [f"  {'PASS':<12} {held_bounds}"] if held_bounds else []
    beside = [note for note in plain["notes"] if note.startswith(BESIDE_VERDICTS)]
    loud = (BESIDE_VERDICTS[0], NOT_WRITTEN)
    lines += [clean(f"  {'!! ' if note.startswith(loud) else ''}{note}") for note in beside]
    if only is not None or optional:
        held = "holds" if _passes(result, only, optional) else "does not hold"
        what = [f"by {', '.join(only)} alone"] if only is not None else []
        what += [f"with {', '.join(optional)} optional"] if optional else []
        silent = missed(plain) if not optional else None
        why = f": {silent['short']}" if silent is not None else ""
        lines.append(clean(f"  {', '.join(what)}: it {held}{why}"))
    if plain["error"]:
        lines += ["", *(clean(line) for line in plain["error"].strip().split("\n"))]
    if page := page_of(plain):
        lines.append(clean(f"  report: {page}"))
    replay = on_condition(plain["replay"], only or (), optional)
    lines.append(clean(f"  replay: {replay}"))
    return "\n".join(lines)


def _told(verdict: Mapping[str, Any]) -> str:
    """A verdict in one line; of one that is not PASS with the place of its gate."""
    from pytest_dvp.text.printable import clean
    from pytest_dvp.verdicts.result_text import reason

    if verdict["status"] != "PASS":
        return clean(verdict["message"])
    margin = verdict["margin"]
    return reason(verdict) + ("" if margin is None else f", margin {margin:.3g}")
