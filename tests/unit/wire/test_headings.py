"""A heading over the wire, and none where its message says that there is none."""

from __future__ import annotations

import copy
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("cyclonedds")

from vehicle.messages import GnssFix
from vehicle.wire import convert, ros2_types, topics
from vehicle.wire.health import Health, Trouble
from vehicle.wire.stack_topics import take_observation

NS = 12_340_000_000
PLACE, HEADING = convert.fix_to_ros(GnssFix(12.34, 30.0, -40.0, 0.02, 0.7, 0.01), NS)


def unknown() -> Any:
    """As sensor_msgs/Imu says it: element 0 of the covariance is -1."""
    message = copy.deepcopy(HEADING)
    message.orientation_covariance[0] = -1.0
    return message


def no_turn() -> Any:
    message = copy.deepcopy(HEADING)
    message.orientation = ros2_types.Quaternion(0.0, 0.0, 0.0, 0.0)
    return message


def test_a_heading_comes_as_it_was_measured() -> None:
    heading = convert.heading_from_ros(HEADING)
    assert (heading.t, heading.yaw, heading.sigma) == pytest.approx((12.34, 0.7, 0.01))


@pytest.mark.parametrize("message", [unknown(), no_turn()], ids=["covariance -1", "all zero"])
def test_a_heading_that_is_not_estimated_is_none_and_no_fault(message: Any) -> None:
    """Not north with certainty; the place beside it counts."""
    fix = convert.fix_from_ros(PLACE, message)
    assert (fix.x, fix.yaw) == (pytest.approx(30.0, abs=1e-6), None)
    troubles: list[Trouble] = []
    heading = convert.heading_from_ros(message)
    assert Health(troubles.append).sift("/gnss/heading", [heading], 12.36) == [heading]
    assert troubles == []


def test_a_fix_that_the_receiver_does_not_have_is_not_handed_on() -> None:
    """Neither to a stack in a process of its own."""
    lost = copy.deepcopy(PLACE)
    lost.status.status = -1  # sensor_msgs/NavSatStatus.STATUS_NO_FIX
    kept = {topics.FIX: [lost, PLACE], topics.HEADING: [HEADING]}
    end: Any = SimpleNamespace(take=lambda topic: kept.get(topic, []))
    (fix,) = take_observation(end, NS).gnss
    assert (fix.x, fix.y) == pytest.approx((30.0, -40.0), abs=1e-6)
