"""Why a drive is no evidence about a twin, whatever its figures are."""

from __future__ import annotations

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.lost_fix import no_evidence_of_place


def no_evidence(log: Log) -> str:
    """One line, "" if the drive is evidence: the car did not know where it was, or the twin is not that of its file."""
    why = no_evidence_of_place(log)
    return f"{why}; drive it again" if why else _another_twin(log)


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
