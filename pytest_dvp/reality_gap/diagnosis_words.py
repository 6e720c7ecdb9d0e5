"""A diagnosis as text for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_dvp.reality_gap.diagnosis import Diagnosis, NamedEffect, Step

HEADLINES = {
    "NOTHING_MISSING": "nothing is missing: what is left is the noise of the sensors",
    "NAMED": "the model lacks",
    "AMBIGUOUS": "the model lacks, as far as these data tell",
    "PARTIAL": "found a part; something is left that no effect of the catalogue explains",
    "UNKNOWN": "something is missing, and no effect of the catalogue explains it",
    "NOT_EXCITED": "nothing found, but these data could not have shown most effects",
}


def page(found: Diagnosis) -> str:
    """The whole answer."""
    lines = [f"{found.verdict}: {HEADLINES[found.verdict]}"]
    lines += [_effect(effect) for effect in found.effects]
    for name in found.vetoed:
        lines.append(f"  not {name}: it fits, but loses on data it was not fitted on")
    lines += ["", *_ladder(found.ladder)]
    if found.not_excited:
        lines += ["", "these data cannot show: " + ", ".join(found.not_excited)]
    return "\n".join(lines)


def _effect(effect: NamedEffect) -> str:
    if effect.action == "remove":
        return f"  - {effect.name}: the car does not have it"
    values = ", ".join(f"{key} = {e.value:.4g} {e.unit} ({e.low:.4g} to {e.high:.4g})" for key, e in
                       effect.parameters.items())  # fmt: skip
    rivals = f"; or {', '.join(effect.rivals)}" if effect.rivals else ""
    sign = "+" if effect.action == "add" else "~"
    return f"  {sign} {effect.name}: {values}, explains {100.0 * effect.gain:.0f} % of the error{rivals}"


def _ladder(steps: Sequence[Step]) -> list[str]:
    lines = [f"{'':32s}{'chi^2/N fit':>12s}{'held out':>12s}"]
    for step in steps:
        held = f"{step.held_out_chi2_per_n:12.3g}" if step.held_out_chi2_per_n is not None else f"{'-':>12s}"
        lines.append(f"{'+ ' + step.added if step.added else 'model as given':32s}{step.chi2_per_n:12.3g}{held}")
    return lines
