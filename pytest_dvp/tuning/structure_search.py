"""Structure before parameters: what the twin lacks is looked for on the car's logs, and the twin is extended by it."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.text.plain_json import finite
from pytest_dvp.tuning.data_sheet_reset import ALLOWED, reset_to_data_sheet
from pytest_dvp.workers.cache import Cache
from pytest_dvp.workers.job import code_digest, file_digest

if TYPE_CHECKING:
    from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, NamedEffect
    from pytest_dvp.logs.log import Log

RATE = 50.0  # Hz; commands change at multiples of 10 ms, so between two samples their mean holds, not the first
COMMANDS = {"steer_cmd", "accel_cmd", "throttle_cmd", "brake_cmd"}  # as asked for, and below gate., arrived.
LEAST_GAIN = 0.002  # of the error that is left: effects that explain less are not worth a twin that knows them


@dataclasses.dataclass(frozen=True, slots=True)
class StructureResult:
    """diagnosis, extension: their documents (`dvp diagnose --json`, `dvp extend --json`); model: the extended twin as
    text, None if it is not to be taken; taken: what was added, changed or removed, in words; pruned: parameters of S
    that were set back to the data sheet before."""

    diagnosis: dict[str, Any]
    extension: dict[str, Any] | None
    model: str | None
    taken: tuple[str, ...]
    pruned: tuple[str, ...] = ()

    @property
    def refusal(self) -> str:
        """Why the extension was refused, in words; empty if it was not, or if there was none."""
        return str(self.extension.get("refusal", "")) if self.extension else ""


def look_for_structure(
    logs: Sequence[Path], model: Path, sheet: Path, cache: Cache, tick: Callable[[str], None] = lambda text: None,
    *, presets: bool = False,
) -> StructureResult:  # fmt: skip
    """Set back what the simulator has and the car lacks, diagnose, then extend; `sheet`: the twin of the data sheet.

    What the twin is known not to explain counts as error here, not as noise: it is to become less, and drives that are
    held out judge whether it does.

    presets: the parameters of S are presets that no log has ever spoken for; all of them are set back, and it is the
    diagnosis that brings back what the car has.
    Kept by the hash of logs, models and code, as simulations are.

    Effects of perception are told, but not taken: the twin sees through sensors of its own.
    """
    own = Path(__file__)  # the digest of the code is that of what simulates, to which this file does not belong
    files = [file_digest(str(path)) for path in (model, sheet, *logs, own)]
    text = json.dumps(["structure", RATE, LEAST_GAIN, ALLOWED, presets, *files, code_digest()])
    key = hashlib.sha256(text.encode()).hexdigest()
    kept = cache.get(key)
    if kept is None:
        kept = {"metrics": dataclasses.asdict(_looked_for(logs, model, sheet, tick, presets))}
        cache.put(key, kept)
    found = kept["metrics"]
    taken, back = tuple(found["taken"]), tuple(found["pruned"])
    return StructureResult(found["diagnosis"], found["extension"], found["model"], taken, back)


def _looked_for(
    paths: Sequence[Path], file: Path, sheet: Path, tick: Callable[[str], None], presets: bool
) -> StructureResult:
    from pytest_dvp.gap.diagnose.diagnose import diagnose
    from pytest_dvp.gap.extend.extend import extend
    from vehicle.model.effect_catalogue import find_effect
    from vehicle.model.model_file import model_text, read_model
    from vehicle.model.remainder_shape import RemainderShape

    logs = {path.name: thinned(path) for path in paths}
    cleared = reset_to_data_sheet(read_model(file), read_model(sheet), logs, math.inf if presets else ALLOWED)
    model = dataclasses.replace(cleared.model, remainder={}, remainder_shape=RemainderShape())
    back = cleared.changes
    diagnosis = diagnose(logs, model, tick=tick)
    wanted = [e for e in diagnosis.effects if _is_worth(e, diagnosis) and find_effect(e.name).slot != "perception"]
    document = finite(diagnosis.as_dict())
    add = [e.name for e in wanted if e.action != "remove"]
    remove = [e.name for e in wanted if e.action == "remove"]
    if not wanted:
        return StructureResult(document, None, model_text(model) if back else None, (), back)
    fitted_on = [f"{path.name} sha256:{file_digest(str(path))}" for path in paths]
    while True:
        extension = extend(logs, model, add=add, remove=remove, start=diagnosis.values, fitted_on=fitted_on, tick=tick)
        idle = [name for name in (*remove, *add) if name in extension.refused]
        if not idle or len(add) + len(remove) < 2:
            break
        # one at a time, the last named first, as it explains least: beside fewer others the next may pay
        (add if idle[-1] in add else remove).remove(idle[-1])
    told = finite(extension.as_dict())
    if extension.refusal:
        return StructureResult(document, told, model_text(model) if back else None, (), back)
    signs = {"add": "+", "change": "~", "remove": "-"}
    taken = tuple(f"{signs[e.action]} {e.name} {in_words(e.parameters, 4)}" for e in extension.effects)
    return StructureResult(document, told, model_text(extension.model), taken, back)


def _is_worth(effect: NamedEffect, diagnosis: Diagnosis) -> bool:
    """Whether an effect explains LEAST_GAIN of what is left once all are found: beside the error of a bare data sheet
    everything is little, and without the little things the great ones are fitted wrongly."""
    before, after = (step.chi2_per_n for step in (diagnosis.ladder[0], diagnosis.ladder[-1]))
    return effect.gain * before >= LEAST_GAIN * after


def in_words(parameters: Mapping[str, Any], digits: int) -> str:
    """`T = 0.1803 s, g = 0.92` of estimates by name, each with its value and unit."""
    return ", ".join(f"{k} = {p.value:.{digits}g} {p.unit}".removesuffix(" -").rstrip() for k, p in parameters.items())


def thinned(path: Path) -> Log:
    """A log with its columns at RATE: of commands the mean until the next sample, of all else the value at it."""
    import numpy as np

    from pytest_dvp.logs.log import Log

    log = Log.load(path)
    step = max(1, round(1.0 / (RATE * float(np.median(np.diff(log.t))))))
    columns = {name: values[::step].copy() for name, values in log.columns.items()}
    starts = np.arange(0, len(log.t), step)
    counts = np.diff(np.append(starts, len(log.t)))
    for name in [name for name in columns if name.rpartition(".")[2] in COMMANDS]:
        columns[name] = np.add.reduceat(log.columns[name], starts) / counts
    return dataclasses.replace(log, columns=columns)
