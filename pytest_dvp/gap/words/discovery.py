"""What `dvp discover` says on the terminal."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from pytest_dvp.gap.discover.law import Law
from pytest_dvp.gap.discover.law_file import equation, law_names
from pytest_dvp.gap.words.diagnosis import figure, three
from vehicle.model.effect import Effect


def discovery_lines(
    law: Law, file: str | None, model: str, logs: Sequence[str], held_out: Sequence[str],
    options: Sequence[str] = (), beside: Sequence[Effect] = (),
) -> list[str]:  # fmt: skip
    """Lines of the answer: the verdict with its equation, the error before and after, what speaks against it, and the
    command that adds what was written to `file`; model, logs, held_out: as the user named them; options: words that
    the command takes over; beside: as in `law_names`."""
    if law.verdict == "NO_LAW":
        return [f"NO_LAW: {reason}" for reason in law.reasons]
    what = {"LAW": "this form explains the error", "STAND_IN": "this removes the error, but its form is not proven"}
    lines = [f"{law.verdict}: {equation(law.terms)} ({what[law.verdict]})", ""]
    for found in law.terms:
        term = found.term
        unit = f" {term.unit}" if term.unit != "-" else ""
        text = f"  {term.form.text} on the {term.point.part} ({term.point.name}): c = {three(term.coefficient)}"
        lines.append(f"{text}{unit} ({three(found.low)} to {three(found.high)})")
        if found.same:
            lines.append(f"    in this car the same as {', '.join(found.same)}")
    fit, judged = law.removed
    for side, k, share in (
        ("fitted  ", 0, f"{fit:.0%} of the error beyond the noise"),
        ("held out", 1, f"{judged:.0%}"),
    ):
        lines.append(f"  chi²/N {side}  {figure(law.before[k])} -> {figure(law.after[k])} ({share})")
    lines.append("")
    if len(law.points) > 1:
        lines.append(f"these data cannot tell at which of these it acts: {', '.join(law.points)}")
    lines += law.reasons
    if law.decides:
        lines.append(f"a drive that would tell more: {law.decides}")
    if file:
        use = ["dvp", "extend", "--model", model, "--effects", file, "--add", *law_names(law, beside), "--fit", *logs]
        use += ["--held-out", *held_out, "--out", f"{Path(model).stem}.extended.toml", *options]
        lines.append(f"{file} written; use it: {shlex.join(use)}")
    return lines
