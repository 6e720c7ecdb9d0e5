"""Whose reading of a scenario counts in three rules where the field's most used player departs from the standard.

esmini    as esmini 3.6 plays it, for which the field's scenarios are written: an event that is overridden may run again
          if it has executions left; a continuous LaneOffsetAction to an absolute offset ends there; the
          DynamicConstraints of a SpeedProfileAction never let a vehicle do more than its Performance
standard  ASAM OpenSCENARIO XML 1.3: it is complete (8.4.2.2); it has to be stopped (class LaneOffsetAction); they have
          precedence over any Performance settings (class SpeedProfileAction)

Where it mattered, the run says so.
"""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

Reading: TypeAlias = Literal["esmini", "standard"]
READINGS: tuple[Reading, ...] = get_args(Reading)
USUAL: Reading = "esmini"

EVENT_AGAIN = (
    "was overridden with executions left and waits for its trigger again, as in esmini; the standard (8.4.2.2) "
    "completes it: --reading standard"
)
OFFSET_ENDED = (
    "continuous LaneOffsetAction: ended at its offset, as in esmini; the standard has it go on until it is stopped: "
    "--reading standard"
)
CONSTRAINTS_CUT = (
    "DynamicConstraints beyond the vehicle's Performance: the Performance holds, as in esmini; the standard lets the "
    "constraints have precedence: --reading standard"
)
