"""An extension as text for a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pytest_dvp.gap.compare.segments import UNITS
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.error_shares import percents
from pytest_dvp.gap.extend.extension import Extension, Rung
from pytest_dvp.gap.words.comparison import NOTHING_LEFT, columns
from pytest_dvp.gap.words.diagnosis import figure, interval, remainder_words, three, value
from vehicle.model.effect_catalogue import perception_effect_names


def page(found: Extension, gate_lines: Sequence[str] = ()) -> str:
    """What was done, the ladder, the lines about gates, what is to be known, and whether to go on."""
    sensed = [effect for effect in found.effects if effect.name in perception_effect_names()]
    moved = [effect for effect in found.effects if effect not in sensed]
    lines = [line for group in (moved, sensed) for line in map(_effect, group, percents([e.gain for e in group]))]
    lines += [f"  ~ {'.'.join(name)}: {_estimate(estimate)}" for name, estimate in found.refitted.items()]
    lines += ["", *ladder(found.ladder, found.noise_floor)]
    if gate_lines:
        lines += ["", *gate_lines]
    if found.notes:
        lines += ["", *(f"note: {note}" for note in found.notes)]
    if not found.refusal:
        lines += ["", rest(found)]
        if found.model.remainder:
            known = ", ".join(remainder_words(found.model.remainder))
            lines.append(
                f"written as [remainder], what the new model does not explain in single driving regimes: {known}"
            )
    return "\n".join(lines)


def ladder(rungs: Sequence[Rung], noise: Mapping[str, float]) -> list[str]:
    """The error of each step in units of the noise and of each signal, fitted on and held out."""
    signals = list(rungs[0].step.rmse)
    rows = [["", "", "chi²/N", *(f"{name} [{UNITS[name]}]" for name in signals)]]
    for rung in rungs:
        step = rung.step
        rows.append(["fit", rung.change or "model as given", figure(step.chi2_per_n), *_row(step.rmse, signals)])
    for rung in rungs:
        step = rung.step
        if step.held_out_chi2_per_n is not None:
            chi2 = figure(step.held_out_chi2_per_n)
            rows.append(["held out", rung.change or "model as given", chi2, *_row(step.held_out_rmse, signals)])
    rows.append(["noise", "", "1", *_row(noise, signals)])
    merged = [[f"{row[0]:8}  {row[1]}", *row[2:]] for row in rows]
    merged[0][0] = "error (RMSE)"
    return _aligned(merged)


def rest(found: Extension) -> str:
    """What is left, and whether anything can still be found in it."""
    last = found.ladder[-1].step
    if found.explained:
        noise = "what the twin is known to leave" if found.excused else "the sensors' noise"
        return (
            f"over the whole drive what is left is no more than {noise} (chi²/N {figure(last.chi2_per_n)}): "
            "stop here, more effects would fit noise"
        )
    held = last.held_out_chi2_per_n or 0.0
    if held > NOTHING_LEFT and held > 1.1 * last.chi2_per_n:
        return (
            f"more is missing: chi²/N {figure(last.chi2_per_n)} where it was fitted, {figure(held)} on held-out data; "
            "perhaps another effect that only looks like this one here: dvp diagnose with all logs tells"
        )
    worst = max(last.channels, key=lambda name: last.channels[name])
    return (
        f"more is missing: chi²/N {figure(last.chi2_per_n)}, most in {worst} ({figure(last.channels[worst])}): "
        "dvp diagnose with the new model looks for it"
    )


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    return columns([[row[0], row[1], "", *row[2:]] for row in rows])


def _row(values: Mapping[str, float], signals: Sequence[str]) -> list[str]:
    return [three(values[name]) if name in values else "-" for name in signals]


def _effect(effect: NamedEffect, share: str) -> str:
    if effect.action == "remove":
        return f"  - {effect.name}"
    values = ", ".join(f"{key} = {_estimate(estimate)}" for key, estimate in effect.parameters.items())
    sign = "+" if effect.action == "add" else "~"
    if not effect.parameters:
        return f"  {sign} {effect.name}: these data give it no value"
    of = "what the detections show" if effect.name in perception_effect_names() else "the error"
    rivals = f"; {', '.join(effect.rivals)} would do as well" if effect.rivals else ""
    return f"  {sign} {effect.name}: {values}, explains {share} of {of}{rivals}"


def _estimate(estimate: Estimate) -> str:
    unit = "" if estimate.unit == "-" else f" {estimate.unit}"
    return f"{value(estimate)}{unit} ({interval(estimate)})"
