"""Verdicts on a run itself, from its log: no gates decide on a drive that broke off, was dry or lost messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pytest_dvp.logs.log import Log
    from pytest_dvp.verdicts.judging import Verdict


def spoilt(log: Log) -> tuple[Verdict, ...]:
    """INCONCLUSIVE for a dry run and for faults on the wire, whatever a gate file says; none for a sound drive."""
    from pytest_dvp.drive.wire_log import wire_verdict

    vehicle = log.meta.get("vehicle")
    dry = (_dry(),) if isinstance(vehicle, dict) and vehicle.get("armed") is False else ()
    troubled = wire_verdict(log)
    return dry if troubled is None else (*dry, troubled)


def broke_off(log: Log) -> tuple[Verdict, ...]:
    """The ERROR of a run that broke off, as its log tells it (event `fault`); none for one that ended."""
    return tuple(broken(event.text or "it broke off", event.t) for event in log.events if event.kind == "fault")[:1]


def broken(error: str, t: float) -> Verdict:
    """The verdict of a run that broke off at t [s]: an ERROR, whatever its gates say of the rest."""
    from pytest_dvp.verdicts.judging import Verdict

    text = f"run ERROR: {error.strip().splitlines()[-1]} at t={t:.2f} s"
    return Verdict("run", "", "ERROR", None, "", None, None, t, "", text, text, "", None)


def _dry() -> Verdict:
    """The verdict of a real car that was not armed: nothing that its log shows is the stack's doing."""
    from pytest_dvp.verdicts.judging import Verdict

    text = "dry run INCONCLUSIVE: no command reached the car; both keys arm it: --vehicle NAME and --arming FILE"
    return Verdict("dry run", "", "INCONCLUSIVE", None, "", None, None, None, "", text, text, "", None)
