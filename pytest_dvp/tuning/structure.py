"""Structure before parameters: what the twin lacks is looked for on the car's logs, and the twin is extended by it."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.tuning.cache import Cache, finite
from pytest_dvp.tuning.job import code_digest, file_digest

if TYPE_CHECKING:
    from pytest_dvp.log import Log

RATE = 50.0  # Hz: half the samples of a drive's log tell as much about effects of 20 ms and more, at half the cost
LEAST_GAIN = 0.002  # of the error: effects that explain less are not worth a twin that knows them


@dataclasses.dataclass(frozen=True, slots=True)
class Found:
    """diagnosis, extension: their documents (`dvp diagnose --json`, `dvp extend --json`); model: the extended twin as
    text, None if it is not to be taken; taken: what was added, changed or removed, in words."""

    diagnosis: dict[str, Any]
    extension: dict[str, Any] | None
    model: str | None
    taken: tuple[str, ...]

    @property
    def refusal(self) -> str:
        return str(self.extension.get("refusal", "")) if self.extension else ""


def look_for_structure(
    logs: Sequence[Path], model: Path, cache: Cache, tick: Callable[[str], None] = lambda text: None
) -> Found:
    """Diagnose, then extend. Kept by the hash of logs, model and code, as simulations are.

    Effects of perception are told, but not taken: the twin sees through sensors of its own.
    """
    text = json.dumps(
        ["structure", RATE, LEAST_GAIN, file_digest(str(model)), *(file_digest(str(p)) for p in logs), code_digest()]
    )
    key = hashlib.sha256(text.encode()).hexdigest()
    kept = cache.get(key)
    if kept is not None:
        return Found(kept["metrics"]["diagnosis"], kept["metrics"]["extension"], kept["metrics"]["model"],
                     tuple(kept["metrics"]["taken"]))  # fmt: skip
    found = _looked_for(logs, model, tick)
    cache.put(key, {"metrics": dataclasses.asdict(found)})
    return found


def _looked_for(paths: Sequence[Path], file: Path, tick: Callable[[str], None]) -> Found:
    from pytest_dvp.reality_gap.diagnose import diagnose
    from pytest_dvp.reality_gap.extend import extend
    from vehicle.model.catalogue import find_effect
    from vehicle.model.model_file import model_text, read_model

    model = read_model(file)
    logs = {path.name: thinned(path) for path in paths}
    diagnosis = diagnose(logs, model, tick=tick)
    wanted = [e for e in diagnosis.effects if e.gain >= LEAST_GAIN and find_effect(e.name).slot != "perception"]
    document = finite(diagnosis.as_dict())
    add = [e.name for e in wanted if e.action != "remove"]
    remove = [e.name for e in wanted if e.action == "remove"]
    if not wanted:
        return Found(document, None, None, ())
    fitted_on = [f"{path.name} sha256:{file_digest(str(path))}" for path in paths]
    while True:
        extension = extend(logs, model, add=add, remove=remove, start=diagnosis.values, fitted_on=fitted_on, tick=tick)
        idle = next((name for name in add if name in extension.refusal), None)
        if not extension.refusal or idle is None or len(add) < 2:
            break
        add.remove(idle)  # the extension names what does not pay on data it was not fitted on
    told = finite(extension.as_dict())
    if extension.refusal:
        return Found(document, told, None, ())
    signs = {"add": "+", "change": "~", "remove": "-"}
    taken = tuple(
        f"{signs[e.action]} {e.name} "
        + ", ".join(f"{k} = {p.value:.4g} {p.unit}".strip() for k, p in e.parameters.items())
        for e in extension.effects
    )
    return Found(document, told, model_text(extension.model), taken)


def thinned(path: Path) -> Log:
    """A log with its columns at RATE."""
    import numpy as np

    from pytest_dvp.log import Log

    log = Log.load(path)
    step = max(1, round(1.0 / (RATE * float(np.median(np.diff(log.t))))))
    return dataclasses.replace(log, columns={name: values[::step].copy() for name, values in log.columns.items()})
