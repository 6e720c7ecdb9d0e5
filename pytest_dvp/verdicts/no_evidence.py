"""Why a drive is no evidence about a twin, whatever its figures are."""

from __future__ import annotations

from collections.abc import Mapping

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.lost_fix import no_evidence_of_place

LEAST = 0.5  # of the longer drive; chosen: a twin that is slower by half is still compared, a start alone is not


def no_evidence(log: Log) -> str:
    """One line, "" if the drive is evidence: the car did not know where it was, or the twin is not that of its file."""
    why = no_evidence_of_place(log)
    return f"{why}; drive it again" if why else _another_twin(log)


def ended_early(logs: Mapping[str, Log]) -> str:
    """One line if of two drives, by stage, one lasted less than LEAST of the other, "" if not: what both have in common
    is then only the beginning of the test."""
    (short, least), (other, most) = sorted(((name, log.duration) for name, log in logs.items()), key=lambda one: one[1])
    if least >= LEAST * most:
        return ""
    return f"stage {short} ended after {least:.1f} s, stage {other} lasted {most:.1f} s: most of the drive is missing"


def _another_twin(log: Log) -> str:
    """What was changed of a twin whose model file is of another car than the scenario's."""
    about = log.meta.get("model")
    if not isinstance(about, dict) or not about.get("scaled"):
        return ""
    numbers = [f"{key} {about[key]:g} {unit}" for key, unit in (("wheelbase", "m"), ("mass", "kg")) if key in about]
    return (
        f"what drove is not {about.get('file', 'the model')}, but that scaled to the car of the scenario, "
        f"{about.get('to', '')} ({', '.join(numbers)}); one of both has a wrong wheelbase or mass"
    )
