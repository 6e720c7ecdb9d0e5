"""TimeOfDayCondition: the date and time that the environment says, running on with the simulation if it is animated.

Source: ASAM OpenSCENARIO XML 1.3, classes TimeOfDayCondition, TimeOfDay. Never true while no environment with a time of
day has been set. A time without a zone counts as UTC.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

from openscenario import model
from openscenario.storyboard.registry import Scope, condition
from openscenario.storyboard.triggers import Test
from openscenario.storyboard.unsupported import Unsupported
from openscenario.storyboard.values import COMPARISONS
from openscenario.values import moment


def _seconds(text: str) -> float:
    when = moment(text)
    if when.tzinfo is None:
        when = when.replace(tzinfo=UTC)
    return (when - datetime(2000, 1, 1, tzinfo=UTC)) / timedelta(seconds=1)


@condition(model.TimeOfDayCondition)
def time_of_day(element: model.TimeOfDayCondition, entity: None, scope: Scope) -> Test:
    """Compares the time of day of the environment with a date and time; false while the environment has none.

    Raises Unsupported for a text that is no date and time.
    """
    board, holds = scope.board, COMPARISONS[element.rule]
    try:
        wanted = _seconds(element.date_time)
    except ValueError:
        raise Unsupported("not a date and time", element.date_time, "2026-01-31T12:00:00") from None

    def test() -> bool:
        clock = board.world.clock
        if clock is None:
            return False
        now = _seconds(clock.date_time)
        if clock.animation:
            now += board.time - board.world.clock_since
        return holds(round(now, 6), round(wanted, 6))

    return test
