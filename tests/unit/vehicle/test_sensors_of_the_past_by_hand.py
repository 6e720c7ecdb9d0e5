"""Sensors that show the past, as plain Python on a bus of a few fields: the numbers are arithmetic."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from vehicle.model.effect_catalogue import find_effect

HALF_PI = 0.5 * math.pi


def history(*names: str) -> SimpleNamespace:
    rows = {name: np.zeros(1024) for name in ("times", *names)}  # as many as a delay line holds
    return SimpleNamespace(head=0.0, tail=0.0, **rows)


def test_a_late_yaw_rate_is_straight_between_rows() -> None:
    m, late = history("r"), find_effect("yaw_rate_latency").function
    shown = []
    for t, rate in ((0.0, 1.0), (0.1, 2.0), (0.2, 4.0)):
        x = SimpleNamespace(t=t, meas_yaw_rate=rate)
        late(x, SimpleNamespace(T=0.05), m)
        shown.append(x.meas_yaw_rate)
    assert shown == pytest.approx([1.0, 1.5, 3.0])


def test_a_late_pose_came_straight_before_the_log_and_goes_along_when_a_replay_moves_the_car() -> None:
    """North at 4 m/s: a pose 0.25 s old is 1 m behind. Then the car is put to (10, 5), heading west."""
    m, late = history("x", "y", "yaw"), find_effect("gnss_latency").function

    def seen(t: float, x: float, y: float, yaw: float, moved: float = 0.0) -> list[float]:
        bus = SimpleNamespace(t=t, x=x, y=y, yaw=yaw, vx=4.0, moved=moved, old_x=0.0, old_y=2.0, old_yaw=HALF_PI,
                              meas_x=x, meas_y=y, meas_yaw=yaw)  # fmt: skip
        late(bus, SimpleNamespace(T=0.25), m)
        return [bus.meas_x, bus.meas_y, bus.meas_yaw]

    assert seen(0.0, 0.0, 0.0, HALF_PI) == pytest.approx([0.0, -1.0, HALF_PI])
    assert seen(0.5, 0.0, 2.0, HALF_PI) == pytest.approx([0.0, 1.0, HALF_PI])
    assert seen(0.75, 10.0, 5.0, math.pi, moved=1.0) == pytest.approx([10.0, 5.0, math.pi])  # of the row at 0.5 s
    assert seen(0.8, 9.8, 5.0, math.pi) == pytest.approx([10.0, 5.0, math.pi])
    m.tail = 0.0
    assert seen(0.25, 9.8, 5.0, math.pi) == pytest.approx([12.0, 5.0, math.pi])  # at 0 s it was 2 m behind


def test_a_pose_without_age_is_shown_as_it_is() -> None:
    m = history("x", "y", "yaw")
    x = SimpleNamespace(t=0.0, x=1.0, y=2.0, yaw=0.5, vx=4.0, moved=0.0, meas_x=1.0, meas_y=2.0, meas_yaw=0.5)
    find_effect("gnss_latency").function(x, SimpleNamespace(T=0.0), m)
    assert (x.meas_x, x.meas_y, x.meas_yaw) == (1.0, 2.0, 0.5)
    assert (m.x[0], m.y[0], m.times[0]) == pytest.approx((1.0 - 4.0 * math.cos(0.5), 2.0 - 4.0 * math.sin(0.5), -1.0))
