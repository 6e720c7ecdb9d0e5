"""TimeOfDayCondition: the environment's clock, running or not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from openscenario.storyboard.conditions.time_of_day import time_of_day
from openscenario.storyboard.unsupported import Unsupported

from .conftest import Make, condition, event, group, lane_position, log, run, speed, story, teleport


def environment(animation: bool) -> str:
    return (
        '<GlobalAction><EnvironmentAction><Environment name="noon">'
        f'<TimeOfDay animation="{str(animation).lower()}" dateTime="2026-01-01T12:00:00Z"/>'
        "</Environment></EnvironmentAction></GlobalAction>"
    )


@pytest.mark.parametrize(
    ("animation", "moment", "expected"),
    [
        (True, "2026-01-01T12:00:02Z", 2.0),
        (True, "2026-01-01T13:00:02+01:00", 2.0),
        (True, "2026-01-01T12:00:02", 2.0),
        (False, "2026-01-01T12:00:02Z", None),
        (False, "2026-01-01T12:00:00Z", 0.0),
    ],
)
def test_the_clock_of_the_environment(make: Make, animation: bool, moment: str, expected: float | None) -> None:
    test = f'<ByValueCondition><TimeOfDayCondition rule="greaterOrEqual" dateTime="{moment}"/></ByValueCondition>'
    events = event("noon", environment(animation)), event("e", speed(5.0), start=group(condition(test)))
    board = make(A=[teleport(lane_position(100.0))], stories=story(*events))
    run(board, 3.0)
    times = [time for time, name, what in log(board, "event") if (name, what) == ("e", "startTransition")]
    assert times == ([] if expected is None else [pytest.approx(expected, abs=0.0101)])


@pytest.mark.parametrize(
    ("moment", "time", "holds"),
    [
        ("12:00:00.3", 7.2, True),
        ("12:00:00.3", 7.21, False),
        ("12:00:00.300002", 7.2, False),
        ("12:00:00.3", 0.2, False),
    ],
)
def test_a_time_of_day_is_met_to_the_microsecond_in_spite_of_rounding(moment: str, time: float, holds: bool) -> None:
    """The clock began with 12:00:00.1 at 7 s. In seconds since the year 2000 a double has steps of 0.12 us."""
    day = SimpleNamespace(animation=True, date_time="2026-01-01T12:00:00.1Z")
    world = SimpleNamespace(clock=day, clock_since=7.0)
    element: Any = SimpleNamespace(rule="equalTo", date_time=f"2026-01-01T{moment}Z")
    scope: Any = SimpleNamespace(board=SimpleNamespace(world=world, time=time))
    assert time_of_day(element, None, scope)() is holds


def test_a_text_that_is_no_date_and_time_is_told() -> None:
    element: Any = SimpleNamespace(rule="equalTo", date_time="at noon")
    with pytest.raises(Unsupported, match="not a date and time"):
        time_of_day(element, None, SimpleNamespace(board=None))  # type: ignore[arg-type]
