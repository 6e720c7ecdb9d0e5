"""Adds the effect that a model lacks: fits it, shows how the error falls, and writes the new model.

Without --add, the effects that `dvp diagnose` confirms on the logs are added; provisional ones only by name (--add). If
it confirms none for the model (NOTHING_MISSING, UNKNOWN, NOT_EXCITED, only provisional effects, or only effects of the
run), the question is answered: the new file is an unchanged copy of the model, and the exit code is 0. Nothing is
written, and the exit code is 1, if a requested effect explains nothing or loses on held-out data.

With --grow, a model that has been judged learns from all logs together: its effects are fitted again, and what these
logs show together is added. None of them can judge it then.
"""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.diagnose import read_all, twins_of
from pytest_dvp.cli.doctor import add_log_options, existing_log, read_files
from pytest_dvp.cli.effects import add_effects, effects_from
from pytest_dvp.cli.shared.arguments import WrongArgument, add_json, existing, new_file
from pytest_dvp.cli.shared.command_columns import check_command_columns
from pytest_dvp.cli.shared.forwarded_options import forwarded_options
from pytest_dvp.cli.shared.held_out_logs import refuse_same_drive, refuse_same_path
from pytest_dvp.cli.shared.named_effects import NamedEffects, named, of_diagnosis
from pytest_dvp.cli.shared.progress import progress
from pytest_dvp.cli.shared.selected_parts import select_parts
from pytest_dvp.text.plain_json import finite

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.diagnosis import Diagnosis
    from pytest_dvp.gap.extend.extension import Extension
    from pytest_dvp.logs.log import Log
    from pytest_dvp.verdicts.gate import Gate
    from pytest_dvp.verdicts.verdict_changes import GateChange
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

PLACE = 100  # in `dvp --help`

_TOGETHER = (
    "effects that are named are fitted one after another; those of which a diagnosis tells values all begin together: "
    "dvp diagnose ... --json > D.json, then --from D.json beside --add"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare model, logs to fit and to hold out, effects to add or remove, gates and the new model file."""

    def many(option: str, metavar: str, text: str, **more: Any) -> None:
        parser.add_argument(option, nargs="+", action="extend", metavar=metavar, help=text, **more)

    parser.add_argument("--model", required=True, metavar="M.toml", help="vehicle model that lacks an effect")
    many("--add", "EFFECT", "effect to add (dvp effects lists them); default: what dvp diagnose confirms", default=[])
    many("--remove", "EFFECT", "effect of the model that the car does not have", default=[])
    parser.add_argument(
        "--from",
        dest="diagnosis",
        metavar="D.json",
        help="add the effects that `dvp diagnose --json` confirmed, from the values that it found; others with --add",
    )
    parser.add_argument("--refit", action="store_true", help="also fit the other effects of the model again")
    parser.add_argument(
        "--grow", action="store_true",
        help="fit all effects of the model again, and add what all logs together show; no log is held out",
    )  # fmt: skip
    many("--fit", "LOG", "measured logs to fit on; a part of one as LOG@0:285 (seconds)", required=True)
    many(
        "--held-out", "LOG", "logs that are not fitted on but judge the result; default: each log is predicted from "
        "the others, a single one its last 40 %% from what came before", default=[],
    )  # fmt: skip
    parser.add_argument(
        "--twin", action="append", default=[], metavar="RUN",
        help="run of the model in a scenario of the logs, on top of whose detections effects of perception come; "
        "repeat for each run",
    )  # fmt: skip
    parser.add_argument("--out", required=True, metavar="M2.toml", help="file of the new model")
    parser.add_argument("--force", action="store_true", help="overwrite the model that was read (M2 may be M)")
    parser.add_argument(
        "--gates", action="append", default=[], metavar="FILE", help="show which verdicts of these gates change"
    )
    add_log_options(parser)
    add_effects(parser)
    add_json(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Fit the effects and write the new model.

    Returns 0 if a file was written, also an unchanged copy because no effect is missing; 1 if none was written. Raises
    WrongArgument for a model that is not what an option needs.
    """
    _check(arguments)
    from pytest_dvp.gap.extend.extend import extend
    from pytest_dvp.gap.extend.growth import grow
    from reports.whole_file import write_whole
    from vehicle.model.model_file import model_text, read_model
    from vehicle.model.model_file_edit import edited_text

    extra = effects_from(arguments)
    model = read_model(arguments.model, extra=extra)
    if arguments.grow and not model.effects:
        # Step by step from a bare data sheet, effects take each other's place: of a simulated car it left 48 of chi^2/N
        # with an asymmetry and a compliance that were not there, where the search of a diagnosis left 1.2.
        first, *others = map(shlex.quote, arguments.fit)
        raise WrongArgument(
            f"dvp extend: --grow goes on from effects that a diagnosis found, and {arguments.model} has none: first "
            f"run dvp diagnose {first} --held-out {' '.join(others)} --model {shlex.quote(arguments.model)}"
        )
    given = Path(arguments.model).read_text(encoding="utf-8")
    wanted = named(arguments, model, extra)
    gates = _gates(arguments)
    logs, held_out = read_all(arguments.fit, arguments), read_all(arguments.held_out, arguments)
    refuse_same_drive(logs, held_out)
    check_command_columns("dvp extend", model, arguments.model, logs, held_out)
    twins = twins_of(arguments, logs, model)
    wanted = wanted.shown_by(logs, model, twins)
    if wanted.nothing:
        return _copied(arguments, wanted.nothing, wanted.verdict)
    if arguments.diagnosis and wanted.empty:
        return _not_written(arguments, "; ".join(wanted.skipped))
    for text in wanted.notes(model, Path(arguments.model).name):
        print(f"dvp extend: {text}", file=sys.stderr)
    rivals: dict[str, tuple[str, ...]] = {}
    with progress("dvp extend", "extending") as tick:
        start = dict(wanted.values)
        if wanted.empty and not (arguments.refit or arguments.grow):
            fitted = select_parts(arguments.fit, logs, model)
            judged = select_parts(arguments.held_out, held_out, model)
            for text in (fitted.said, judged.said):
                if text:
                    print(f"dvp extend: the diagnosis {text}", file=sys.stderr)
            found = _diagnosed(fitted.logs, model, judged.logs, tuple(extra.values()), twins, tick)
            wanted = _asked(found)
            if wanted.nothing:
                return _copied(arguments, wanted.nothing, wanted.verdict)
            rivals = {effect.name: effect.rivals for effect in found.effects}
            start = dict(found.values)
        own, fitted_on = tuple(extra.values()), [provenance(text) for text in arguments.fit]
        if arguments.grow:
            parts = select_parts(arguments.fit, logs, model)
            if parts.said:
                print(f"dvp extend: --grow {parts.said}", file=sys.stderr)
            extension = grow(parts.logs, model, effects=own, fitted_on=fitted_on, tick=tick)
        else:
            extension = extend(
                logs, model, add=wanted.add, remove=wanted.remove, refit=arguments.refit, held_out=held_out,
                effects=own, start=start, fitted_on=fitted_on, twins=twins, tick=tick,
            )  # fmt: skip
        effects = [dataclasses.replace(e, rivals=rivals.get(e.name, ())) for e in extension.effects]
        notes = (*wanted.skipped, *extension.notes)
        extension = dataclasses.replace(extension, effects=tuple(effects), notes=notes)
        changes = _changes(gates, {**logs, **held_out}, model, extension, tuple(extra.values()))
    if not extension.refusal:
        kept = edited_text(given, extension.model, extra=extra)
        if kept is None:
            print(f"dvp extend: comments of {arguments.model} are not in the new file", file=sys.stderr)
        text = model_text(extension.model) if kept is None else kept
        write_whole(Path(arguments.out), text.encode())
    _tell(arguments, extension, changes)
    return 1 if extension.refusal else 0


def _check(arguments: argparse.Namespace) -> None:
    """What can be said before anything is read. Raises WrongArgument."""
    model = existing(arguments.model, "model")
    if not arguments.model.endswith(".toml"):
        raise WrongArgument(f"--model {arguments.model}: effects are added to a vehicle model (.toml)")
    for text in [*arguments.fit, *arguments.held_out, *arguments.twin]:
        existing_log(text)
    for text in arguments.gates:
        existing(text, "gate file")
    if arguments.diagnosis:
        existing(arguments.diagnosis, "diagnosis")
    against = {"--add": arguments.add, "--remove": arguments.remove, "--from": arguments.diagnosis,
               "--twin": arguments.twin, "--refit": arguments.refit}  # fmt: skip
    if arguments.grow and arguments.held_out:
        raise WrongArgument("dvp extend: --grow fits all logs: name those of --held-out after --fit")
    if arguments.grow and (also := [option for option, given in against.items() if given]):
        raise WrongArgument(f"dvp extend: --grow fits all effects and finds what to add itself: leave out {also[0]}")
    if arguments.grow and len(arguments.fit) < 2:
        raise WrongArgument("dvp extend: --grow asks what several logs show together: name two at least after --fit")
    both = set(arguments.add) & set(arguments.remove)
    if both:
        raise WrongArgument(f"dvp extend: {min(both)} is both to be added and to be removed")
    others = [*arguments.gates, *([arguments.diagnosis] if arguments.diagnosis else [])]
    out = new_file("--out", arguments.out, [*read_files(arguments, [*arguments.fit, *arguments.held_out]), *others])
    if out.resolve() == model.resolve() and not arguments.force:
        raise WrongArgument(f"--out {out} is the model that is read: name another file, or add --force")
    refuse_same_path(arguments.fit, arguments.held_out)


def _diagnosed(logs: Mapping[str, Log], model: VehicleModel, held_out: Mapping[str, Log], extra: Sequence[Effect],
               twins: Mapping[str, Log], tick: Any) -> Diagnosis:  # fmt: skip
    from pytest_dvp.gap.diagnose.diagnose import diagnose

    return diagnose(logs, model, held_out=held_out, effects=extra, twins=twins, tick=tick)


def _asked(found: Diagnosis) -> NamedEffects:
    from pytest_dvp.gap.words.diagnosis import page

    entries = [(e.name, e.action) for e in found.effects]
    doubtful = {e.name: "; ".join(e.doubts) for e in found.effects if e.standing == "provisional"}
    return of_diagnosis(entries, found.set_up, doubtful, verdict=found.verdict, headline=page(found).splitlines()[0])


def _copied(arguments: argparse.Namespace, why: str, verdict: str) -> int:
    """Nothing is to be added: the new model is the given one, byte for byte, so that the next command finds it."""
    from reports.whole_file import write_whole

    model, out = Path(arguments.model), Path(arguments.out)
    if not (out.exists() and out.samefile(model)):
        write_whole(out, model.read_bytes())
    if arguments.json:
        document = {"written": True, "model": arguments.out, "verdict": verdict, "effects": [], "refusal": ""}
        print(json.dumps(document, ensure_ascii=False))
    print(f"dvp extend: {arguments.out} written, an unchanged copy of {arguments.model}: {why}", file=sys.stderr)
    return 0


def _not_written(arguments: argparse.Namespace, why: str) -> int:
    text = f"dvp extend: {arguments.out} is not written: {why}"
    if arguments.json:
        document = {"written": False, "model": arguments.out, "effects": [], "refusal": text}
        print(json.dumps(document, ensure_ascii=False))
    print(text, file=sys.stderr)
    return 1


def provenance(text: str) -> str:
    """`name sha256:...` of a log argument: its bytes, of a folder those of its files in order of their names."""
    from pytest_dvp.logs.log_part import parse_argument

    path = parse_argument(text).path
    digest = hashlib.sha256()
    for file in sorted(f for f in path.rglob("*") if f.is_file()) if path.is_dir() else [path]:
        with file.open("rb") as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    return f"{Path(text).name} sha256:{digest.hexdigest()}"


def _gates(arguments: argparse.Namespace) -> list[Gate]:
    """The gates on the model. Raises WrongArgument if a file has none, GateError if it is wrong."""
    from pytest_dvp.verdicts.judging import read_gates
    from pytest_dvp.verdicts.verdict_changes import gates_on

    found: list[Gate] = []
    for text in arguments.gates:
        mine = gates_on(read_gates(text).gates, Path(arguments.model))
        if not mine:
            raise WrongArgument(f"--gates {text}: none of its gates is on {arguments.model}")
        found += mine
    return found


def _changes(gates: Sequence[Gate], logs: Mapping[str, Log], model: VehicleModel, extension: Extension,
             extra: Sequence[Effect]) -> list[GateChange]:  # fmt: skip
    if not gates:
        return []
    from pytest_dvp.gap.compare.compared_model import ModelSubject
    from pytest_dvp.verdicts.verdict_changes import gate_changes

    return gate_changes(gates, logs, ModelSubject(model, extra=extra), ModelSubject(extension.model, extra=extra))


def _tell(arguments: argparse.Namespace, extension: Extension, changes: Sequence[GateChange]) -> None:
    from pytest_dvp.gap.words.extension import page
    from pytest_dvp.verdicts.verdict_changes import change_lines

    written = not extension.refusal
    if arguments.json:
        document = {"written": written, "model": arguments.out, **extension.as_dict()}
        document["gates"] = [change.as_dict() for change in changes]
        print(json.dumps(finite(document), ensure_ascii=False, allow_nan=False))
    else:
        print(page(extension, change_lines(changes) if changes else ()))
    if written:
        print(f"dvp extend: {arguments.out} written", file=sys.stderr)
        if arguments.held_out and extension.model.remainder:
            said = "to learn from the held-out logs as well, now that they have judged it"
            print(f"dvp extend: {said}: {_on_all(arguments)}", file=sys.stderr)
    else:
        together = f"; {_TOGETHER}" if len(arguments.add) > 1 and not arguments.diagnosis else ""
        print(f"dvp extend: {arguments.out} is not written: {extension.refusal}{together}", file=sys.stderr)


def _on_all(arguments: argparse.Namespace) -> str:
    """The command that fits the new model on the logs that judged it, too."""
    words = ["dvp", "extend", "--model", arguments.out, "--grow", "--fit", *arguments.fit, *arguments.held_out]
    return shlex.join([*words, "--out", f"{Path(arguments.out).stem}.all.toml", *forwarded_options(arguments)])
