"""What `dvp discover` says on the terminal."""

from __future__ import annotations

from pytest_dvp.gap.discover.law import Law
from pytest_dvp.gap.discover.law_file import equation, law_names
from pytest_dvp.gap.words.diagnosis import figure, three


def discovery_lines(law: Law, file: str | None, held_out: str) -> list[str]:
    """Lines of the answer: the verdict with its equation, the error before and after, what speaks against it."""
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
        use = f"dvp extend --model M.toml --effects {file} --add {' '.join(law_names(law))} --fit LOG"
        lines.append(f"{file} written; use it: {use} --held-out {held_out} --out M2.toml")
    return lines
