"""TimeOfDayCondition: the environment's clock, running or not."""

from __future__ import annotations

import pytest

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
