"""Stages: their names, and the names of what can stand in for the car.

DT is the digital twin in simulated time. In PE a car drives and the simulator supplies the road users; in RW everything
is the car's own. Both need a vehicle, and without a real one they take the surrogate: a car in a process of its own,
with other physics than the twin, on the other side of ROS 2 topics, and of a CAN bus if it is to have a drive-by-wire
there. What a request for a stage must fulfil is in stage_checks.py, and open_car.py opens the car.
"""

from __future__ import annotations

SURROGATE = "surrogate"
CAN = "can"  # the surrogate with its drive-by-wire on CAN
ROS1 = "ros1"  # the surrogate over ROS 1
VEHICLES = (SURROGATE, CAN, ROS1)
REPLAY = "replay"  # a recording
STEPPED, REAL = CLOCKS = ("stepped", "real")


class StageError(ValueError):
    """A stage that does not exist, or for which nothing can stand in for the car."""
