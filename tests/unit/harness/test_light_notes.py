"""States of traffic lights that say nothing of their lamps are told, as nobody stops for them."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.drive.light_notes import light_notes
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import LogEvent


@pytest.mark.parametrize("state", ["red", "amber", "orange", "stop", "flashing amber", "off", "off;off;off", "on;off"])
def test_what_says_its_lamps_needs_no_note(state: str) -> None:
    assert light_notes(Log({"t": np.arange(3.0)}, events=(LogEvent(0.0, "signal", "7", state),))) == ()


def test_each_state_that_nobody_knows_is_one_line_with_its_lights() -> None:
    states = [("7", "phase_2"), ("8", "phase_2"), ("7", "red"), ("7", "phase_2"), ("9", "u")]
    events = tuple(LogEvent(float(t), "signal", light, state) for t, (light, state) in enumerate(states))
    first, second = light_notes(Log({"t": np.arange(9.0)}, events=events))
    assert first.startswith("light 7, 8: the state 'phase_2' says of no lamp that it is lit, and stops nobody; ")
    assert second.startswith("light 9: the state 'u' ")
