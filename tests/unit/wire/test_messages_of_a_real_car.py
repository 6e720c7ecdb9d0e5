"""Messages that sensor_msgs allows and the surrogate never sends: they count, and are no fault."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

from vehicle.messages import GnssFix, VehicleState
from vehicle.wire import convert
from vehicle.wire.health import Health, Trouble

NS = 12_340_000_000
PLACE, _ = convert.fix_to_ros(GnssFix(12.34, 300.0, -400.0, 0.02), NS)


def sifted(message: Any) -> Any:
    """What the stack gets of a message; none may be kept back."""
    troubles: list[Trouble] = []
    (kept,) = Health(troubles.append).sift("/x", [message], 12.36)
    assert troubles == []
    return kept


def test_a_fix_without_an_altitude_is_a_fix() -> None:
    """sensor_msgs/NavSatFix: NaN if no altitude is available."""
    flat = copy.deepcopy(PLACE)
    flat.altitude = math.nan
    fix = sifted(convert.fix_from_ros(flat))
    assert (fix.x, fix.y) == pytest.approx((300.0, -400.0), abs=1e-3)


def test_invalid_points_of_a_cloud_that_has_some_are_left_out() -> None:
    cloud = convert.points_to_ros(np.array([[1.0, 2.0, 3.0], [math.nan] * 3, [4.0, 5.0, 6.0]]), NS)
    cloud.is_dense = False
    assert sifted(convert.points_from_ros(cloud)).points.tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]


def test_a_cloud_that_says_it_has_none_is_faulty_with_one() -> None:
    cloud = convert.points_to_ros(np.array([[1.0, 2.0, 3.0], [math.nan] * 3]), NS)
    troubles: list[Trouble] = []
    assert Health(troubles.append).sift("/x", [convert.points_from_ros(cloud)], 12.36) == []
    assert [trouble.what for trouble in troubles] == ["not_finite"]


def test_rows_of_a_cloud_may_be_filled_up() -> None:
    """Two rows of two points, 24 bytes each, and 8 that mean nothing."""
    points = np.arange(12.0).reshape(4, 3)
    cloud = convert.points_to_ros(points, NS)
    data = bytes(cloud.data)
    cloud.height, cloud.width, cloud.row_step = 2, 2, 32
    cloud.data = b"".join(data[24 * row : 24 * row + 24] + b"\xff" * 8 for row in range(2))
    assert convert.points_from_ros(cloud).points.tolist() == points.tolist()


@pytest.mark.parametrize("variance", [math.nan, math.inf, -1.0])
@pytest.mark.parametrize("place", [0, 7])
def test_a_pose_whose_accuracy_is_not_known_is_a_pose(variance: float, place: int) -> None:
    pose = convert.state_to_ros(VehicleState(t=0.0, x=3.0, y=4.0, yaw=0.0, v=0.0, position_sigma=0.5), NS)
    assert convert.state_from_ros(pose).position_sigma == 0.5
    pose.pose.covariance[place] = variance
    state = sifted(convert.state_from_ros(pose))
    assert (state.x, state.y, state.position_sigma) == (3.0, 4.0, 0.0)
