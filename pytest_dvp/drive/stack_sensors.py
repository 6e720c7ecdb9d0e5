"""Which sensors a driving stack reads: an attribute `reads` of its class, names such as ("gnss", "odometry").

On stage dt the others are then not simulated, which saves their time. A stack without it is given all.
"""

from __future__ import annotations

from pytest_dvp.drive.chosen_stack import Ads
from pytest_dvp.drive.stack_faults import AdsError, what
from pytest_dvp.text.spelling import unknown


def read_by(ads: Ads) -> frozenset[str] | None:
    """The sensors that a stack declares to read, by the names of `Observation`; None if it declares nothing.

    Raises AdsError, one line, for what is no sensor.
    """
    found = getattr(ads.factory, "reads", None)
    if isinstance(found, str):
        raise AdsError(f"ADS {ads.name}: reads: found {found!r}, expected names in a tuple: ({found!r},)")
    if not isinstance(found, tuple | list | set | frozenset):
        return None  # a method, a number, an object of its own: means another thing
    wrong = [each for each in found if not isinstance(each, str)]
    if wrong and len(wrong) == len(found):
        return None  # numbers or objects, and no names
    if wrong:
        raise AdsError(f"ADS {ads.name}: reads: found {what(wrong[0])} among the names, expected names of sensors")
    from vehicle.sensors.further import further_sensors
    from vehicle.sensors.suite import SENSORS

    known = (*SENSORS, *further_sensors())
    for name in found:
        if name not in known:
            raise AdsError(f"ADS {ads.name}: reads: {unknown('sensor', name, known)}")
    return frozenset(found)
