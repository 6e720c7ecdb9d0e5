"""What the second engine says of a diagnosis, in one line: whether it agrees."""

from __future__ import annotations

from pytest_dvp.gap.diagnose.diagnosis import Diagnosis


def second_opinion(found: Diagnosis) -> str:
    """One sentence on `found.votes` (see `equation_error.votes`); empty where the second engine could not judge."""
    scores = {str(name): float(score) for name, score in found.votes.get("ranking", ())}
    if not scores:
        return ""
    first, names = found.votes.get("first"), found.names
    if first is None:
        judged = [name for name in names if name in scores]
        if not names:
            return "agrees, it would name nothing"
        return f"would name nothing, not {', '.join(judged)} either" if judged else f"cannot judge {', '.join(names)}"
    alone = f"{first}, which alone explains {100.0 * scores[first]:.0f} % of the misfit in its equations"
    if first in names:
        own = next(e for e in found.effects if e.name == first)
        if own.second_engine == "disagrees":  # it was asked again with all other effects taken away
            return f"agrees on {alone}, but not beside the other effects: it then votes for another (see {first})"
        return f"agrees on {alone}"
    rival = next((e.name for e in found.effects if first in e.rivals), None)
    if rival is not None:
        return f"would take the rival of {rival}: {alone}"
    return f"disagrees, it would name {alone}"
