"""Criteria of CARLA's scenario runner: conditions of the stop trigger that judge a drive and are no conditions.

Its files write them as a ParameterCondition of a parameter that nobody declares, in a Condition called
`criteria_RunningStopTest` and the like. Here gates judge a drive, so such a condition is never true, with a warning.
Source: the example scenarios of the scenario runner.
"""

from __future__ import annotations

import re
from typing import Final

from openscenario.model.kinds import At

_CRITERION: Final = re.compile(r"/StopTrigger/.*/Condition\[(criteria_\w*)\]/")


def criterion_of(at: At) -> str:
    """The name of the criterion that an element is part of, as `criteria_RunningStopTest`; "" if it is part of none."""
    found = _CRITERION.search(at.element)
    return found[1] if found else ""
