"""Which effects `dvp extend` is asked to add and to remove: by its options, or by the document of a diagnosis."""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.cli.shared.arguments import WrongArgument
from pytest_dvp.text.spelling import unknown

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel


ACTIONS = ("add", "change", "remove")  # of an effect in the document of a diagnosis
NOTHING = ("NOTHING_MISSING", "UNKNOWN", "NOT_EXCITED")  # verdicts of a diagnosis that names no effect


class DiagnosisFileError(ValueError):
    """A file of --from is no diagnosis, or names what cannot be added: one line."""


@dataclasses.dataclass(frozen=True, slots=True)
class NamedEffects:
    """Names of effects to add (to fit again, where the model has them) and to remove.

    left: what a diagnosis named beside them and why it is not for the model, a line each; diagnosed: by one, whose
    verdict this is; nothing: why it names nothing for the model, one line, empty if it does; values: (effect, key) ->
    what it found, of all that it named.
    """

    add: tuple[str, ...] = ()
    remove: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()
    diagnosed: bool = False
    verdict: str = ""
    nothing: str = ""
    values: Mapping[tuple[str, str], float] = dataclasses.field(default_factory=dict)

    @property
    def empty(self) -> bool:
        """True if no effect is to be added or removed."""
        return not self.add and not self.remove

    def notes(self, model: VehicleModel, file: str) -> Iterator[str]:
        """What is to be known before anything is fitted, a line each."""
        yield from self.skipped
        again = [name for name in self.add if any(a.name == name for a in model.effects)]
        if again:
            them = "its value is" if len(again) == 1 else "their values are"
            yield f"{file} has {', '.join(again)} already: {them} fitted again"

    def shown_by(self, logs: Mapping[str, Log], model: VehicleModel, twins: Mapping[str, Log]) -> NamedEffects:
        """Without the perception effects of a diagnosis whose values these logs do not tell.

        twins: runs of the model by scenario, beside which they are judged.
        """
        from pytest_dvp.gap.perception.diagnose_perception import diagnose_perceptions
        from vehicle.model.effect_catalogue import perception_effect_names

        sensed = perception_effect_names()
        if not self.diagnosed or not sensed & {*self.add, *self.remove}:
            return self
        shown = {e.name: e.action == "remove" for e in diagnose_perceptions(logs.values(), model, twins)}
        add = _kept(self.add, sensed, {name for name, gone in shown.items() if not gone})
        remove = _kept(self.remove, sensed, {name for name, gone in shown.items() if gone})
        off = [name for name in (*self.add, *self.remove) if name not in (*add, *remove)]
        left = self.skipped
        if off:
            left += (f"{', '.join(off)}: left, as the detections of the logs fitted on give no value for the model",)
        return dataclasses.replace(self, add=add, remove=remove, skipped=left)


def named(arguments: argparse.Namespace, model: VehicleModel, extra: Mapping[str, Effect]) -> NamedEffects:
    """Effects named by options or a diagnosis. Raises WrongArgument, DiagnosisFileError."""
    from vehicle.model.effect_catalogue import catalogue

    known, file = {**catalogue(), **extra}, Path(arguments.model).name
    asked = NamedEffects(tuple(dict.fromkeys(arguments.add)), tuple(dict.fromkeys(arguments.remove)))
    _check(asked, known, model, file, ("--add: ", "--remove: "))
    if not arguments.diagnosis:
        return asked
    found = _of_file(arguments.diagnosis, asked)
    try:
        _check(found, known, model, file, ("", ""))
    except WrongArgument as error:
        raise DiagnosisFileError(f"{arguments.diagnosis}: {error}") from None
    return found


def _check(
    asked: NamedEffects, known: Mapping[str, Effect], model: VehicleModel, file: str, options: Sequence[str]
) -> None:
    present = [a.name for a in model.effects]
    for option, names in zip(options, (asked.add, asked.remove), strict=True):
        for name in names:
            if name not in known:
                raise WrongArgument(f"{option}{unknown('effect', name, known)} (dvp effects lists them)")
    for name in asked.remove:
        if name not in present:
            raise WrongArgument(f"{options[1]}{file} does not have {name}; it has {', '.join(present) or 'no effects'}")


def _kept(names: Sequence[str], sensed: Collection[str], shown: Collection[str]) -> tuple[str, ...]:
    return tuple(name for name in names if name not in sensed or name in shown)


def _of_file(name: str, asked: NamedEffects) -> NamedEffects:
    """What the document of `dvp diagnose --json` confirms of the car, and what is asked for besides, with the values of
    the document. Raises DiagnosisFileError."""
    try:
        data = Path(name).read_bytes()  # a shell of Windows writes UTF-16
        document = json.loads(data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"))
        entries = [(str(entry["name"]), entry.get("action", "add")) for entry in document["effects"]]
        doubtful = {
            str(entry["name"]): "; ".join(map(str, entry.get("doubts", ())))
            for entry in document["effects"] if entry.get("standing", "confirmed") != "confirmed"
        }  # fmt: skip
        of_run, values = _of_run(document), dict(_values(document["effects"]))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise DiagnosisFileError(f"{name}: not a document of `dvp diagnose --json`") from None
    for effect, action in entries:
        if action not in ACTIONS:
            allowed = ", ".join(ACTIONS)
            raise DiagnosisFileError(f"{name}: {effect}: action is {action!r}, allowed: {allowed}")
    verdict = str(document.get("verdict", ""))
    if not entries and verdict not in NOTHING:
        raise DiagnosisFileError(f"{name}: this diagnosis names no effect ({verdict or 'no verdict'})")
    entries = [one for one in entries if one[0] not in (*asked.add, *asked.remove)]
    found = of_diagnosis(entries, of_run, doubtful, verdict=verdict, headline=verdict)
    add, remove = (*found.add, *asked.add), (*found.remove, *asked.remove)
    nothing = "" if add or remove else found.nothing
    return dataclasses.replace(found, add=add, remove=remove, nothing=nothing, values=values)


def _values(entries: Sequence[Mapping[str, Any]]) -> Iterator[tuple[tuple[str, str], float]]:
    """The values of a document of a diagnosis; one that is not finite stands there as null."""
    for entry in entries:
        for key, estimate in entry.get("parameters", {}).items():
            value = estimate["value"]
            if value is not None and isfinite(float(value)):
                yield (str(entry["name"]), str(key)), float(value)


def of_diagnosis(
    entries: Sequence[tuple[str, str]], of_run: Collection[str], doubtful: Mapping[str, str], *, verdict: str,
    headline: str,
) -> NamedEffects:  # fmt: skip
    """What of a diagnosis is for the model: what it confirms of the car.

    entries: (effect, action); of_run: names that belong to a run; doubtful: provisional effects with what speaks
    against each; headline: what is said if nothing is left.
    """
    own = [name for name, _ in entries if name in of_run]
    left = [of_the_run(own)] if own else []
    left += [_provisional(name, doubtful[name]) for name, _ in entries if name in doubtful and name not in of_run]
    sure = [(name, action) for name, action in entries if name not in of_run and name not in doubtful]
    return NamedEffects(
        add=tuple(name for name, action in sure if action != "remove"),
        remove=tuple(name for name, action in sure if action == "remove"),
        skipped=tuple(left),
        diagnosed=True,
        verdict=verdict,
        nothing="" if sure else "; ".join([*([headline] if headline else []), *left]),
    )


def of_the_run(names: Sequence[str]) -> str:
    """Why these effects are not for the model."""
    return f"{', '.join(names)}: left, as of the run and not of the car; calibrate before each run"


def _provisional(name: str, doubts: str) -> str:
    """Why a provisional effect is not for the model, and how it is added nevertheless."""
    return f"{name}: left, as provisional{f' ({doubts})' if doubts else ''}; --add {name} adds it"


def _of_run(document: Mapping[str, Any]) -> frozenset[str]:
    return frozenset(str(name) for name in document.get("set_up", {}).get("names", ()))
