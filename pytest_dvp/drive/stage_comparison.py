"""Drives of one scenario on several stages, held against each other: the table, and the gates between stages."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.drive.ini_file import changes_a_run
from pytest_dvp.drive.replay_words import words_of_comparison
from pytest_dvp.drive.run_spec import RunSpec
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.lost_fix import SIGMA, lost_for
from pytest_dvp.logs.obeyed_commands import twin_command_mismatch
from pytest_dvp.text.paths import shown
from pytest_dvp.verdicts.diagnose_command import gap_command
from pytest_dvp.verdicts.excited_parameters import not_validated
from pytest_dvp.verdicts.gate import STAGES, Gate, Stage
from pytest_dvp.verdicts.harmless_side import harmless_notes
from pytest_dvp.verdicts.judging import Verdict, judge_between, overall, pairs_of
from pytest_dvp.verdicts.result_text import NOT_WRITTEN
from pytest_dvp.verdicts.stage_table import StageTable, stage_table

if TYPE_CHECKING:
    from pytest_dvp.drive.result import RunResult

_STAGES: tuple[str, ...] = STAGES
CONDITIONS = ("parameters", "P", "ads", "seed", "compute_delay")
"""What two drives should have in common besides the scenario; where they do not, the result says so."""


@dataclasses.dataclass(frozen=True)
class StageDrive:
    """A drive on one stage: its log, and the file or run folder it is in (None: it was not written).

    before  True if it was driven in another session
    """

    log: Log
    place: Path | None = None
    before: bool = False

    @property
    def label(self) -> str:
        """What results of its stage are called: "dt", "rw-surrogate"."""
        return str(self.log.meta.get("stage", ""))


@dataclasses.dataclass(frozen=True)
class StageComparison:
    """Result of `hold`. Looks like a RunResult to summaries: `as_dict` has the same keys, and besides them the table.

    stage   "dt-rw-surrogate": the stages that were compared
    logs    run folder or file of each stage by its label
    status  PASS only if at least one gate was judged and all of them passed
    not_validated  what these drives could not show and no gate lists; pytest_dvp.verdicts.excited_parameters tells it
    why     commands that would say what the twin lacks, where a gate between it and a car failed
    """

    scenario: str
    line: int
    stage: str
    seed: int
    status: str
    verdicts: tuple[Verdict, ...]
    table: StageTable | None
    logs: Mapping[str, str]
    replay: str
    ads: str = "reference"
    set: Mapping[str, str] = dataclasses.field(default_factory=dict)
    folder: Path | None = None
    notes: tuple[str, ...] = ()
    why: tuple[str, ...] = ()
    not_validated: tuple[Mapping[str, Any], ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON-able data: what crosses processes and stands in result.json."""
        return {
            "scenario": self.scenario,
            "line": self.line,
            "stage": self.stage,
            "ads": self.ads,
            "seed": self.seed,
            "status": self.status,
            "set": dict(self.set),
            "verdicts": [verdict.as_dict() for verdict in self.verdicts],
            "metrics": {} if self.table is None else _flat(self.table),
            "table": None if self.table is None else self.table.as_dict(),
            "logs": dict(self.logs),
            "folder": None if self.folder is None else shown(self.folder),
            "replay": self.replay,
            "error": None,
            "notes": list(self.notes),
            "why": list(self.why),
            "not_validated": [dict(one) for one in self.not_validated],
        }


@dataclasses.dataclass(frozen=True)
class Files:
    """Files of a comparison.

    log_dir      folder for a numbered run folder with result.json and report.html; None: nothing is written
    single_file  that page carries the library that draws, and needs no other file
    model        file that the twin was made from, and the files of its own effects, where they are known
    """

    log_dir: Path | None = None
    single_file: bool = False
    model: Path | None = None
    effects: Sequence[Path] = ()


_NO_FILES = Files()


def compare_stages(
    drives: Mapping[str, StageDrive],
    gates: Sequence[Gate],
    pairs: Sequence[tuple[Stage, Stage]],
    about: Mapping[str, Any],
    *,
    missing: Mapping[str, str] | None = None,
    notes: Sequence[str] = (),
    files: Files = _NO_FILES,
    before: StageDrive | None = None,
) -> StageComparison:
    """Judge the gates between `pairs` of stages, and make the table of all `drives` (by stage, "dt", "pe", "rw").

    about    `scenario`, `line`, `seed`, `ads`, `set`, `replay` as in Across
    missing  by stage, why there is no drive and how to get one: its gates are INCONCLUSIVE
    notes    what else the result should say
    before   last drive of the previous iteration, which the table compares the first stage with

    Drives of different scenario files are not compared: the later one counts as missing. A note says so of a drive that
    no pair asks for, and of `before`.
    """
    absent = dict(missing or {})
    there = _of_one_scenario(drives, absent)
    logs = {stage: drive.log for stage, drive in there.items()}
    unlike = [absent[stage] for stage in drives if stage not in there and not any(stage in pair for pair in pairs)]
    earlier = None
    if before is not None and there:
        why_not = _unfit(before) or _another_test(before, next(iter(there.values())))
        unlike += [why_not] if why_not else []
        earlier = None if why_not else (f"{before.label} before", before.log)
    judged = {pair: judge_between(gates, pair, logs, absent) for pair in pairs}
    verdicts = [verdict for found in judged.values() for verdict in found]
    why = [
        gap_command(found, (there[a].log, there[a].place), (there[b].log, there[b].place), files.model, files.effects)
        for (a, b), found in judged.items()
        if a == "dt" and a in there and b in there and not twin_command_mismatch(there[a].log, there[b].log)
    ]
    labels: dict[str, str] = {stage: there[stage].label if stage in there else stage for stage in STAGES}
    compared = [stage for stage in STAGES if (any(stage in pair for pair in pairs) if pairs else stage in logs)]
    columns = {labels[stage]: logs[stage] for stage in STAGES if stage in logs}
    table = stage_table(columns, earlier) if len(columns) > 1 or earlier is not None else None
    result = StageComparison(
        stage=pair_name(tuple(labels[stage] for stage in compared)),
        status=overall(verdicts),
        verdicts=tuple(verdicts),
        table=table,
        logs={drive.label: shown(drive.place) for drive in there.values() if drive.place is not None},
        notes=(
            *notes,
            *(f"not compared: {reason}" for reason in unlike),
            *harmless_notes(_of_pairs(gates, pairs)),
            *_differences(there),
            *_left_out_rows(there),
            *_moved_positions(there),
        ),
        why=tuple(command for command in why if command),
        not_validated=tuple(not_validated(gates, pairs, logs)),
        **about,
    )
    if files.log_dir is None:
        return result
    from pytest_dvp.drive.run_folder import ResultError, write_across

    name = Path(result.scenario).stem
    try:
        folder = write_across(files.log_dir, name, result.as_dict(), logs, labels, single_file=files.single_file)
    except ResultError as error:  # the verdicts stand, whatever becomes of their page
        return dataclasses.replace(result, notes=(*result.notes, f"{NOT_WRITTEN}{error}"))
    return dataclasses.replace(result, folder=folder)


def gates_between(scenario: Path, gates: Path | None = None, stage_gates: Path | None = None) -> tuple[Gate, ...]:
    """The gates between stages that hold for a scenario: of `gates` or the file beside it, then of `stage_gates`.

    Raises GateError for a file that is wrong, or for `stage_gates` without a gate between stages.
    """
    from pytest_dvp.verdicts.judging import read_gates

    beside = scenario.with_name(f"{scenario.stem}.gates.toml")
    file = gates if gates is not None else (beside if beside.is_file() else None)
    found = [gate for gate in read_gates(shown(file)).gates if gate.between] if file is not None else []
    if stage_gates is None:
        return tuple(found)
    return (*found, *read_between(stage_gates))


def read_between(file: Path) -> tuple[Gate, ...]:
    """The gates between stages of a file. Raises GateError if it is wrong, or holds none."""
    from openscenario.findings import Finding
    from pytest_dvp.verdicts.judging import GateError, read_gates

    gates = tuple(gate for gate in read_gates(shown(file)).gates if gate.between)
    if gates:
        return gates
    allowed = 'between = ["dt", "rw"]'
    text = "no gate is between stages"
    raise GateError([Finding("dvp.gates.between", "error", shown(file), 1, "gate", text=text, allowed=allowed)])


def pair_name(labels: Sequence[str]) -> str:
    """`dt-rw-surrogate` of "dt" and "rw-surrogate": each stage, and once at the end what stood in for the car."""
    stages = [label.split("-")[0] for label in labels]
    extra = dict.fromkeys(label.partition("-")[2] for label in labels if "-" in label)
    return "-".join([*stages, *extra])


def driven(result: RunResult) -> StageDrive | str:
    """A finished run as a drive to compare, or why it is none."""
    if result.error is not None:
        return f"the drive of stage {result.stage} broke off: {result.error.strip().splitlines()[-1]}"
    return StageDrive(result.log, result.folder)


def earlier(paths: Sequence[Path], scenario_name: str) -> tuple[dict[str, StageDrive], dict[str, str]]:
    """Drives of a scenario from logs or run folders of earlier sessions, by stage; the last one of a stage counts.

    Second, by stage, why there is none among logs that are of that stage in other scenarios only: who names logs wants
    those looked at, and another drive in their place would be of another car.

    Raises LogError for a file that is no log of ours.
    """
    found: dict[str, StageDrive] = {}
    others: dict[str, list[str]] = {}
    for path in paths:
        log = Log.load(path)
        stage, scenario = str(log.meta.get("stage", "")).split("-")[0], str(log.meta.get("scenario", "no scenario"))
        if scenario == scenario_name:
            found[stage] = StageDrive(log, path, before=True)
        else:
            others.setdefault(stage, []).append(scenario)
    missing = {
        stage: f"no log given is a drive of {scenario_name} on {stage} (they are of {', '.join(names)})"
        for stage, names in others.items()
        if stage not in found
    }
    return found, missing


def pairs_driven(gates: Sequence[Gate], stages: Sequence[str]) -> list[tuple[Stage, Stage]]:
    """The pairs that gates are between of which both stages are among `stages`.

    If there is none, all of them: gates that were asked for and could not be judged are INCONCLUSIVE, not silent.
    """
    pairs = pairs_of(gates)
    return [pair for pair in pairs if all(stage in stages for stage in pair)] or pairs


def left_out(gates: Sequence[Gate], pairs: Sequence[tuple[Stage, Stage]], stages: Sequence[str]) -> list[str]:
    """A line for each pair that gates are between and that is not among `pairs`: there is no drive of one of them."""
    lines = []
    for pair in pairs_of(gates):
        count = sum(gate.between == pair for gate in gates)
        absent = " or ".join(stage for stage in pair if stage not in stages)
        if pair not in pairs:
            which = f"{count} gate{'s' if count > 1 else ''} between {pair[0]} and {pair[1]}"
            lines.append(f"not judged: {which} (no drive of stage {absent})")
    return lines


def assigned(options: Mapping[str, Any]) -> dict[str, str]:
    """Everything that was set, under the names `--set` takes; `options` as `pytest_dvp.drive.run.run` takes them."""
    named = {name: str(value) for name, value in options.get("parameters", {}).items()}
    for group in ("P", "S"):
        named.update((f"{group}.{name}", str(value)) for name, value in options.get(group, {}).items())
    return named


def replay(scenario: Path, options: Mapping[str, Any], stages: Sequence[str], settings: RunSpec) -> str:
    """The `dvp run` that drives these stages and compares them again."""
    file, _, name = settings.ads.rpartition(":")
    ads = f"{shown(Path(file))}:{name}" if file.endswith(".py") else settings.ads
    words = ["dvp", "run", shown(scenario), "--stage", ",".join(stages)]
    words += words_of_comparison(settings, ads, assigned(options))
    words += ["--no-ini"] if changes_a_run(words, "rw") else []
    return shlex.join(words)


def _of_one_scenario(drives: Mapping[str, StageDrive], absent: dict[str, str]) -> dict[str, StageDrive]:
    """The drives in the order of STAGES, without those of another version of scenario or road, noted in `absent`."""
    kept: dict[str, StageDrive] = {}
    first: StageDrive | None = None
    # What was driven now says which version counts: an earlier log gives way to it.
    for stage, drive in sorted(drives.items(), key=lambda item: (item[1].before, _STAGES.index(item[0]))):
        unfit = _unfit(drive)
        if unfit:
            absent[stage] = unfit
            continue
        first = first or drive
        unlike = _another_test(drive, first)
        if unlike:
            absent[stage] = unlike
        else:
            kept[stage] = drive
    return {stage: kept[stage] for stage in STAGES if stage in kept}


def _another_test(drive: StageDrive, first: StageDrive) -> str:
    """Why two drives are not of one test, "" if they are: another scenario, or another version of it or of its road."""
    name, other = (str(one.log.meta.get("scenario", "no scenario")) for one in (drive, first))
    if name != other:
        return f"{_place(drive)} is a drive of {name}, {_place(first)} one of {other}"
    changed = [what for what in ("scenario", "road") if _digest(drive, what) != _digest(first, what)]
    if not changed:
        return ""
    stage = drive.label.split("-")[0]
    return f"{_place(drive)} was driven with another version of the {changed[0]}; drive stage {stage} again"


def _of_pairs(gates: Sequence[Gate], pairs: Sequence[tuple[Stage, Stage]]) -> list[Gate]:
    return [gate for gate in gates if gate.between in pairs]


def _place(drive: StageDrive) -> str:
    return drive.label if drive.place is None else shown(drive.place)


def _unfit(drive: StageDrive) -> str:
    """Why a log is no evidence about its stage; empty if it is."""
    from pytest_dvp.drive.wire_log import wire_verdict

    log, name = drive.log, drive.place if drive.place is not None else f"the drive of stage {drive.label}"
    fault = next((event for event in log.events if event.kind == "fault"), None)
    if fault is not None:
        return f"{name} broke off at t={fault.t:.2f} s: {fault.text}"
    troubled = wire_verdict(log)
    if troubled is not None:
        return f"{name}: {troubled.short}"
    if log.meta.get("vehicle", {}).get("armed") is False:
        return f"{name} was a dry run: no command reached the car"
    return ""


def _digest(drive: StageDrive, what: str) -> object:
    return drive.log.meta.get(f"{what}_sha256")


def _differences(drives: Mapping[str, StageDrive]) -> list[str]:
    """One line for each condition in which drives differ: two drives that were not the same test are not alike."""
    if len(drives) < 2:
        return []
    (_, first), *rest = drives.items()
    lines = []
    for _, other in rest:
        asked = twin_command_mismatch(first.log, other.log)
        lines += [f"{first.label} and {other.label} differ in {asked}"] if asked else []
        for key in CONDITIONS:
            a, b = first.log.meta.get(key), other.log.meta.get(key)
            if a == b:
                continue
            names = f"{first.label} and {other.label}"
            if isinstance(a, Mapping) and isinstance(b, Mapping):
                keys = [name for name in {**a, **b} if a.get(name) != b.get(name)]
                told = ", ".join(f"{name} {a.get(name)} and {b.get(name)}" for name in keys[:4])
                lines.append(f"{names} differ in {key}: {told}{', ...' if len(keys) > 4 else ''}")
            else:
                lines.append(f"{names} differ in {key}: {a} and {b}")
    return lines


def _left_out_rows(drives: Mapping[str, StageDrive]) -> list[str]:
    """One line for each drive of which a part is not judged, as its reference system had lost its fix there."""
    lines = []
    for drive in drives.values():
        lost = lost_for(drive.log)
        if lost > 0.0:
            what = f"not judged: {lost:.1f} s of {drive.log.duration:.1f} s, in which its reference system had no fix"
            lines.append(f"{drive.label}: {what} (position_sigma)")
    return lines


def _moved_positions(drives: Mapping[str, StageDrive]) -> list[str]:
    """One line for each drive of a car that states no `position_sigma` and whose position moves as the car did not."""
    from pytest_dvp.doctor import examine

    lines = []
    for stage, drive in drives.items():
        if stage == "dt" or SIGMA in drive.log.columns:
            continue
        found = [f for f in examine(drive.log) if f.code in ("log.position_jump", "log.position_drift")]
        lines += [f"{drive.label}: {finding.text}: what fails there may be no fault of the twin" for finding in found]
    return lines


def _flat(table: StageTable) -> dict[str, float | None]:
    """The table as numbers by name, for JUnit: `rw-surrogate.mncc(v)`, `rw-surrogate.mncc(v).lag`, `dt.max_jerk`."""
    flat: dict[str, float | None] = {}
    for row in table.rows:
        name = f"{row.metric}({row.signal})" if row.signal else row.metric
        for stage, cell in zip(table.stages, row.cells, strict=True):
            if cell.value is None:
                continue
            flat[f"{stage}.{name}"] = cell.value
            if cell.lag is not None:
                flat[f"{stage}.{name}.lag"], flat[f"{stage}.{name}.gain"] = cell.lag, cell.gain
    return flat
