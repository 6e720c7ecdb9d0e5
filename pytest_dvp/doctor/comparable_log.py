"""What of a log a model may be held against: only what was measured, and commands that the car obeyed."""

from __future__ import annotations

from pytest_dvp.doctor.dead_speed import without_dead_speed
from pytest_dvp.doctor.repeated_values import without_repeats
from pytest_dvp.doctor.spikes import without_spikes
from pytest_dvp.logs.engagement import while_engaged
from pytest_dvp.logs.log import Log


def comparable(log: Log) -> Log:
    """The log with all else as not measured (NaN): spikes, repeats of slow or lost sensors, a speed of 0 of a car that
    rolls, and commands that it did not obey; the log itself if there is nothing of that."""
    return without_spikes(without_repeats(without_dead_speed(while_engaged(log))))
