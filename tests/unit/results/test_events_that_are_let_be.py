"""Events that never fired, without those that a gate lets be: of a gate on all of them, and of one on a single one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pytest_dvp.verdicts import judging
from pytest_dvp.verdicts.gate import Gate

ALL = ("S::cut_in", "S::brake", "S::stop")


@pytest.fixture(autouse=True)
def three_silent_events(monkeypatch: pytest.MonkeyPatch) -> None:
    """A log in which none of three events fired; gates with a bound of 9 hold."""
    monkeypatch.setattr(judging, "storyboard_events", lambda log: (ALL, ALL))
    monkeypatch.setattr(judging, "_here", lambda gates, log: gates)
    monkeypatch.setattr(
        judging, "_judge", lambda gate, log: SimpleNamespace(status="PASS" if gate.max == 9 else "FAIL")
    )


def silent(*gates: Gate) -> tuple[str, ...]:
    log: Any = None
    return judging.never_fired(gates, log)


def counted(most: float, *optional: str) -> Gate:
    return Gate("events_fired", max=most, options={"optional": list(optional)} if optional else {})


def started(most: float, event: str) -> Gate:
    return Gate("event_started", max=most, options={"event": event})


@pytest.mark.parametrize(
    ("gates", "left"),
    [
        ([], ALL),
        ([Gate("max_jerk", max=9)], ALL),
        ([counted(9)], ()),
        ([counted(9, "brake")], ()),
        ([counted(0)], ALL),
        ([counted(0, "brake")], ("S::cut_in", "S::stop")),
        ([counted(0, "S::brake", "stop")], ("S::cut_in",)),
        ([started(9, "brake")], ("S::cut_in", "S::stop")),
        ([started(0, "brake")], ALL),
        ([started(9, "brake"), counted(0, "stop")], ("S::cut_in",)),
    ],
)
def test_what_never_fired_and_no_gate_lets_be(gates: list[Gate], left: tuple[str, ...]) -> None:
    assert silent(*gates) == left
