"""What the report page of a diagnosis shows, as plain data."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pytest_dvp.gap.compare.segments import CHANNELS, UNITS
from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.chance_gain import chance_gain
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, NamedEffect
from pytest_dvp.gap.diagnose.error_shares import Share, shares
from pytest_dvp.gap.diagnose.experiment import Experiment, ExperimentSet, Values
from pytest_dvp.gap.words.comparison import CAUSES, NOTHING_LEFT
from pytest_dvp.gap.words.diagnosis import (
    causes,
    extend_command,
    headline,
    interval,
    plan_command,
    standing_lines,
    step_label,
    trial_command,
    value,
)
from pytest_dvp.gap.words.residual_signature import signature_lines
from pytest_dvp.gap.words.second_opinion import second_opinion
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

if TYPE_CHECKING:
    from vehicle.model.effect import Effect
    from vehicle.model.vehicle_model import VehicleModel

MOST_LOGS = 4  # drawn over time: the page stays light
CLOSE = 8.0  # s of the close look, at most


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class _Drawn:
    """One log with the model as given (before) and with what was found (after): residuals (n, 8)."""

    name: str
    held_out: bool
    experiment: Experiment
    before: FloatArray
    after: FloatArray


@dataclasses.dataclass(frozen=True, slots=True)
class Typed:
    """What the user typed, for the next commands.

    model_file  the file of the model; fitted: the logs that were fitted on, judged: those that judged
    options     those that the next commands need as well, such as `--map F`
    mapping     a row for each signal that a mapping file names, to be shown (`mapping_rows`)
    """

    model_file: str = "model.toml"
    fitted: Sequence[str] = ()
    judged: Sequence[str] = ()
    options: Sequence[str] = ()
    mapping: Sequence[Mapping[str, str]] = ()


_NOTHING_TYPED = Typed()


def diagnosis_page(
    found: Diagnosis,
    logs: Mapping[str, Log],
    model: VehicleModel,
    *,
    held_out: Mapping[str, Log] | None = None,
    effects: Sequence[Effect] = (),
    typed: Typed = _NOTHING_TYPED,
) -> dict[str, Any]:
    """Input of `reports.diagnosis.write_diagnosis_report`, from the arguments of `diagnose` and its result."""
    from vehicle.model.effect_catalogue import catalogue

    known = {**catalogue(), **{e.name: e for e in effects}}
    drawn = _drawn(found, logs, held_out or {}, model, effects)
    fit, held = shares(found.ladder), shares(found.ladder, held_out=True)
    first, last = found.ladder[0], found.ladder[-1]
    order = sorted(first.channels, key=lambda c: -first.channels[c])
    return {
        "verdict": found.verdict,
        "mapping": list(typed.mapping),
        "headline": headline(found, typed.model_file.rpartition("/")[2]),
        "model": typed.model_file.rpartition("/")[2],
        "logs": list(logs),
        "held_out": list(held_out or {}),
        "changed": bool(found.effects),
        "noise": "noise and remainder" if found.remainder else "sensor noise",
        "effects": [_effect(e, known[e.name], fit.get(e.name), held.get(e.name), known) for e in found.effects],
        "vetoed": list(found.vetoed),
        "second_opinion": second_opinion(found),
        "fitted_along": [f"{key} = {value(e)} ({interval(e)})" for key, e in found.input_map.items()],
        "ladder": [
            {"label": step_label(found, s), "fit": s.chi2_per_n, "held_out": s.held_out_chi2_per_n}
            for s in found.ladder
        ],
        "null_line": _null_level(found, drawn, known) if found.effects else None,
        "tiles": causes(first),
        "signals": [
            {"name": c, "unit": UNITS[c], "noise": found.noise_floor.get(c), "before": first.rmse[c],
             "after": last.rmse[c], "held_before": first.held_out_rmse.get(c), "held_after": last.held_out_rmse.get(c),
             "chi2_before": first.channels[c], "chi2_after": last.channels[c]}
            for c in order
        ],
        "not_excited": [_not_shown(name, known) for name in found.not_excited],
        "left": signature_lines(found.signature),
        "remarks": _whole(standing_lines(found)),
        "command": extend_command(found, typed.model_file, typed.fitted or list(logs), typed.judged, typed.options),
        "trial": trial_command(found, typed.model_file, typed.fitted or list(logs), typed.judged, typed.options),
        "plan": plan_command(found, typed.model_file, typed.fitted or list(logs), typed.judged, typed.options),
        "close": _close(drawn, order),
        "over_time": [_over_time(one, order) for one in drawn],
    }  # fmt: skip


def _whole(lines: Sequence[str]) -> list[str]:
    """Lines of a terminal as sentences: what is indented goes on with the line before it."""
    found: list[str] = []
    for line in lines:
        if line.startswith(" ") and found:
            found[-1] += f" {line.strip()}"
        else:
            found.append(line)
    return found


def _null_level(found: Diagnosis, drawn: Sequence[_Drawn], known: Mapping[str, Effect]) -> float | None:
    """chi^2/N that the first step would reach by luck; None if no log was fitted on."""
    gain = found.null_line
    target = ExperimentSet(tuple(one.experiment for one in drawn if not one.held_out))
    if gain is None and target.experiments:
        tried = candidates(target.experiments[0].model, known.values(), ay="ay" in target.channels)
        gain = chance_gain(target, found.ladder[0].values, tried)
    return None if gain is None else found.ladder[0].chi2_per_n - gain


def _effect(effect: NamedEffect, known: Effect, fit: Share | None, held: Share | None,
            all_known: Mapping[str, Effect]) -> dict[str, Any]:  # fmt: skip
    return {
        "name": effect.name,
        "action": effect.action,
        "apart": known.slot == "perception",
        "standing": effect.standing,
        "physics": known.physics,
        "equation": known.equation,
        "parameters": [
            {"key": key, "value": value(e), "interval": interval(e), "unit": e.unit, "meaning": known.key(key).meaning}
            for key, e in effect.parameters.items()
        ],
        "fit": None if fit is None else dataclasses.asdict(fit),
        "held_out": None if held is None else dataclasses.asdict(held),
        "rivals": [{"name": name, "physics": all_known[name].physics if name in all_known else ""}
                   for name in effect.rivals],
        "manoeuvre": effect.deciding_manoeuvre,
        "reveals": known.reveals,
    }  # fmt: skip


def _not_shown(name: str, known: Mapping[str, Effect]) -> dict[str, str]:
    return {"name": name, "physics": known[name].physics, "reveals": known[name].reveals}


def _drawn(found: Diagnosis, logs: Mapping[str, Log], held_out: Mapping[str, Log], model: VehicleModel,
           effects: Sequence[Effect]) -> list[_Drawn]:  # fmt: skip
    before, after = found.ladder[0].values, found.values or found.ladder[-1].values
    drawn: list[_Drawn] = []
    for name, log, held in [*((n, g, False) for n, g in logs.items()), *((n, g, True) for n, g in held_out.items())]:
        if len(drawn) == MOST_LOGS:
            break
        one = Experiment(name, log, model, extra=effects)
        one.settle(after)
        drawn.append(_Drawn(name, held, one, _rest(one, before), _rest(one, after)))
    return drawn


def _rest(one: Experiment, values: Values) -> FloatArray:
    """Residuals (n, 8) with a gap where each segment begins: the model starts anew there, nothing jumps."""
    rest = one.residuals(values).values.copy()
    rest[one.segments.starts] = np.nan
    return rest


def _close(drawn: Sequence[_Drawn], order: Sequence[str]) -> dict[str, Any] | None:
    """The segment and signal in which what was found takes away most (else: in which most is left), to be seen whole.

    Of a signal that is a cause if one is off, as position and heading follow from those.
    """
    best: tuple[float, _Drawn, str, int] | None = None
    for one in drawn:
        e = one.experiment
        off = [c for c in e.channels if _level(one.before, e, c) > NOTHING_LEFT]
        for channel in [c for c in off if c in CAUSES] or off or [c for c in order if c in e.channels and c in CAUSES]:
            k = CHANNELS.index(channel)
            gone = (one.before[:, k] ** 2 - one.after[:, k] ** 2) / e.sigma[k] ** 2
            if not np.nansum(np.abs(gone)) > 0.0:
                gone = one.before[:, k] ** 2 / e.sigma[k] ** 2
            sums = np.add.reduceat(np.nan_to_num(gone), e.segments.starts)
            j = int(np.argmax(sums))
            if best is None or sums[j] > best[0]:
                best = float(sums[j]), one, channel, j
    if best is None:
        return None
    _, one, channel, j = best
    e, k = one.experiment, CHANNELS.index(channel)
    first, end = int(e.segments.starts[j]), int(e.segments.ends[j])
    end = min(end, int(np.searchsorted(e.log.t, e.log.t[first] + CLOSE)))
    rows = slice(first + 1, end)
    error = channel not in CAUSES
    measured = e.measured[rows, k]
    return {
        "log": one.name, "held_out": one.held_out, "channel": channel, "unit": UNITS[channel], "error": error,
        "t": e.log.t[rows], "noise": float(e.sigma[k]),
        "measured": np.zeros(end - first - 1) if error else measured,
        "before": -one.before[rows, k] if error else measured - one.before[rows, k],
        "after": -one.after[rows, k] if error else measured - one.after[rows, k],
    }  # fmt: skip


def _over_time(one: _Drawn, order: Sequence[str]) -> dict[str, Any]:
    """Residuals before and after of every signal that is or was off; position along and across the car."""
    e = one.experiment
    rows: dict[str, dict[str, Any]] = {}
    quiet: list[str] = []
    all_quiet = all(_worse(one, channel) <= NOTHING_LEFT for channel in e.channels)  # to be seen, too
    for channel in [c for c in order if c in e.channels and (c in CAUSES or not all_quiet)]:
        if not all_quiet and _worse(one, channel) <= NOTHING_LEFT:
            quiet.append(channel)
            continue
        k = CHANNELS.index(channel)
        rows[channel] = {"before": one.before[:, k], "after": one.after[:, k], "noise": float(e.sigma[k])}
    if {"x", "y"} & set(rows) and {"x", "y", "yaw"} <= set(e.channels):
        noise = float(np.sqrt(0.5 * (e.sigma[0] ** 2 + e.sigma[1] ** 2)))
        (a0, c0), (a1, c1) = _turned(one.before, e), _turned(one.after, e)
        rows.pop("x", None)
        rows.pop("y", None)
        rows["along"] = {"before": a0, "after": a1, "noise": noise}
        rows["across"] = {"before": c0, "after": c1, "noise": noise}
    units = {name: UNITS.get(name, "m") for name in rows}
    return {"log": one.name, "held_out": one.held_out, "t": e.log.t, "rows": rows, "units": units, "quiet": quiet}


def _turned(rest: FloatArray, e: Experiment) -> tuple[FloatArray, FloatArray]:
    c, s = np.cos(e.measured[:, 2]), np.sin(e.measured[:, 2])
    return c * rest[:, 0] + s * rest[:, 1], c * rest[:, 1] - s * rest[:, 0]


def _worse(one: _Drawn, channel: str) -> float:
    """chi^2/N of a channel, before or after, whichever is more."""
    return max(_level(one.before, one.experiment, channel), _level(one.after, one.experiment, channel))


def _level(rest: FloatArray, e: Experiment, channel: str) -> float:
    """chi^2/N of a channel; 0 without samples."""
    k = CHANNELS.index(channel)
    known = rest[np.isfinite(rest[:, k]), k]
    return float(np.mean((known / e.sigma[k]) ** 2)) if len(known) else 0.0
