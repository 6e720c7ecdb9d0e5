"""What a failing `assert_matches` or `model` gate adds to its text: the effect that most likely explains it, its
rivals, and the command that adds it. Seconds of work, so only where a test has failed; and never a failure of its own.
"""

from __future__ import annotations

import dataclasses
import hashlib
import shlex
import warnings
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, NamedEffect
from pytest_dvp.gap.diagnose.error_shares import percents, shares
from pytest_dvp.gap.words.diagnosis import extend_command, headline, interval, plan_command, value
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_part import cut_log
from vehicle.model.model_file import model_text

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

LONGEST = 20_000  # rows that are diagnosed: 400 s at 50 Hz, some seconds of CPU


def explanation(
    log: Log, model: VehicleModel, *, log_name: str = "", model_name: str = "", effects: Sequence[Effect] = (),
    options: Sequence[str] = (),
) -> list[str]:  # fmt: skip
    """Lines that name what `model` lacks on `log`; names as a command line takes them (empty: there is no file),
    `options` as `--map F`.

    Anything that goes wrong is one line, too: the test has failed already, and must not become an error.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found, rows = _question(log, model, tuple(effects))
        found = _of_motion(found)
    except Exception as error:  # whatever it is: the failure that is explained counts, not this
        return [f"no diagnosis: {type(error).__name__}: {' '.join(str(error).split())[:200]}"]
    part = "" if rows == len(log.t) else f" (of its first {log.t[rows - 1] - log.t[0]:.0f} s)"
    called = Path(model_name).name or model.name or "the model"
    lines = [f"diagnosis{part}: {found.verdict}: {headline(found, called)}"]
    told = {name: share.shown for name, share in shares(found.ladder).items()}
    gains = percents([effect.gain for effect in found.effects])
    lines += [f"  {_effect(e, told.get(e.name, gain))}" for e, gain in zip(found.effects, gains, strict=True)]
    missing = [word for word, name in (("LOG", log_name), ("M.toml", model_name)) if not name]
    note = f" ({' and '.join(missing)}: to be written to a file first)" if missing else ""
    log_name, model_name = log_name or "LOG", model_name or "M.toml"
    command = extend_command(found, model_name, [log_name], options=options)
    if command:
        lines.append(f"  add it: {command}{note}")
        tell = plan_command(found, model_name, [log_name], options=options)
        return [*lines, f"  tell the rivals apart: {tell}"] if tell else lines
    if found.verdict == "NOTHING_MISSING":
        return [*lines, "  a bound that fails now is tighter than the noise of the sensors"]
    look = shlex.join(["dvp", "diagnose", log_name, "--model", model_name, *options])
    return [*lines, f"  look closer: {look}{note}"]


def _effect(effect: NamedEffect, share: str) -> str:
    if effect.action == "remove":
        return f"remove {effect.name}"
    values = ", ".join(
        f"{key} = {value(e)}{'' if e.unit == '-' else ' ' + e.unit} ({interval(e)})"
        for key, e in effect.parameters.items()
    )
    rivals = f", rivals: {', '.join(effect.rivals)}" if effect.rivals else ", no rivals"
    return f"{effect.name}: {values}, explains {share} of the error{rivals}"


def _of_motion(found: Diagnosis) -> Diagnosis:
    """Without what it says of detections: what has failed is a bound on motion."""
    from vehicle.model.effect_catalogue import catalogue

    known = catalogue()
    kept = tuple(e for e in found.effects if e.name not in known or known[e.name].slot != "perception")
    nothing = not kept and found.verdict in ("NAMED", "AMBIGUOUS")
    return dataclasses.replace(found, effects=kept, verdict="NOTHING_MISSING" if nothing else found.verdict)


@dataclasses.dataclass(frozen=True, slots=True)
class _Question:
    """A log and a model; two of them are the same if their bytes are, as several bounds of one test ask the same."""

    key: str
    log: Log = dataclasses.field(compare=False)
    model: Any = dataclasses.field(compare=False)
    effects: tuple[Any, ...] = dataclasses.field(compare=False)


def _question(log: Log, model: VehicleModel, effects: tuple[Effect, ...]) -> tuple[Diagnosis, int]:
    rows = min(len(log.t), LONGEST)
    if rows < len(log.t):
        log = cut_log(log, -float("inf"), float(log.t[rows]))
    digest = hashlib.sha256(model_text(model).encode())
    for name, column in log.columns.items():
        digest.update(name.encode())
        digest.update(column.tobytes())
    names = ",".join(effect.name for effect in effects)
    return _answer(_Question(f"{digest.hexdigest()} {names}", log, model, effects)), rows


@lru_cache(maxsize=4)
def _answer(question: _Question) -> Diagnosis:
    from pytest_dvp.gap.diagnose.diagnose import diagnose

    return diagnose({"log": question.log}, question.model, effects=question.effects)
