"""What of a log a model may be held against: no spikes, no repeats, and no command that the car did not obey."""

from __future__ import annotations

from pytest_dvp.doctor.repeated_values import without_repeats
from pytest_dvp.doctor.spikes import without_spikes
from pytest_dvp.logs.engagement import while_engaged
from pytest_dvp.logs.log import Log


def comparable(log: Log) -> Log:
    """The log with such values as not measured (NaN); the log itself if there are none."""
    return without_spikes(without_repeats(while_engaged(log)))
