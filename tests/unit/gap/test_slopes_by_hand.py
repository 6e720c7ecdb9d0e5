"""Hills of a drive made by formulas: what its accelerometer does beside them is taken out."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare import road_slope as module
from pytest_dvp.gap.compare.road_slope import (
    LEAST,
    LEAST_TOLD,
    _about,
    _beside,
    _differs,
    _hills,
    slope_spread,
    told_spread,
)
from pytest_dvp.logs.log_contents import FloatArray

STEP = 0.05  # s
WINDOW = 2.5  # s, that slopes are taken over; the first begins 0.2 s after the log
SIZE = 0.1  # m/s^2, of the hills, which change their sign from window to window by chance


class Drive:
    """A drive that never stops, on a road whose slope is SIZE up or down in each window; everything by formulas."""

    def __init__(self, seconds: float = 120.0, *, size: float = SIZE) -> None:
        self.t = t = STEP * np.arange(round(seconds / STEP) + 1)
        signs = np.random.default_rng(5).choice([-1.0, 1.0], 200)
        self.gravity = size * signs[np.maximum((t - 0.2) // WINDOW, 0.0).astype(int)]
        self.v = 10.0 + 3.0 * np.sin(0.37 * t) + 2.0 * np.sin(1.13 * t + 1.0)
        self.rate = 0.3 * np.sin(0.29 * t) + 0.2 * np.sin(0.83 * t + 2.0)
        self.ay = self.v * self.rate
        self.change = np.gradient(self.v, t)
        yaw = np.concatenate([[0.0], np.cumsum(0.5 * (self.rate[1:] + self.rate[:-1]) * STEP)])
        self.yaw = yaw
        self.x, self.y = np.cumsum(self.v * np.cos(yaw)) * STEP, np.cumsum(self.v * np.sin(yaw)) * STEP

    def spread(self, wrong: FloatArray | float = 0.0) -> float:
        """By an accelerometer that feels no gravity and is wrong by this [m/s^2]."""
        measured = np.column_stack([self.x, self.y, self.yaw, self.v, self.rate, self.change - self.gravity + wrong,
                                    self.ay, 0.0 * self.t])  # fmt: skip
        return slope_spread(self.t, measured)


def test_hills_are_told_by_their_size() -> None:
    """47 windows less 8 things that are taken out: within a tenth."""
    for size in (0.06, 0.1, 0.4):
        assert Drive(size=size).spread() == pytest.approx(size, rel=0.1)


def test_what_an_accelerometer_does_beside_them_in_proportion_to_the_motion_is_taken_out() -> None:
    """Each of these errors is more than the hills."""
    drive = Drive()
    alone = drive.spread()
    wrong = {
        "a bias": np.full(len(drive.t), 2.0),
        "a gain": 0.7 * drive.change,
        "the road that a turn leans to": 5.0 * drive.rate**2,
        "a sensor that is turned": 0.3 * drive.ay,
        "off the middle": 3.0 * np.gradient(drive.rate, drive.t),
        "the speed of pitch": 0.015 * np.gradient(drive.v * drive.change, drive.t),
        "the speed of roll": 0.5 * np.gradient(np.abs(drive.rate) * drive.v, drive.t),
    }
    for name, one in wrong.items():
        assert np.sqrt(np.mean(one**2)) > 1.5 * SIZE, name
        assert drive.spread(one) == pytest.approx(alone, rel=0.05), name


def test_a_sensor_that_is_a_little_late_is_taken_out_and_one_that_is_later_tells_nothing() -> None:
    drive = Drive()
    for late, told in ((0.1, drive.spread()), (0.5, 0.0), (1.0, 0.0)):  # LATEST is 0.3 s
        wrong = np.interp(drive.t - late, drive.t, drive.change) - drive.change
        assert drive.spread(wrong) == pytest.approx(told, rel=0.05)


def test_where_brakes_hold_the_car_nothing_tells_a_slope() -> None:
    """It stands from 50 to 60 s, and its accelerometer shows the hill of 20 % on which it does."""
    drive = Drive()
    alone = drive.spread()
    drive.v = drive.v * np.interp(drive.t, [45.0, 50.0, 60.0, 65.0], [1.0, 0.0, 0.0, 1.0])
    drive.change = np.gradient(drive.v, drive.t)
    drive.gravity = np.where((drive.t > 50.0) & (drive.t < 60.0), 2.0, drive.gravity)
    assert drive.spread() == pytest.approx(alone, rel=0.15)
    drive.v += 0.51  # as fast as that it rolls there, and the hill is one
    assert drive.spread() > 3.0 * alone


@pytest.mark.parametrize(("seconds", "told"), [(45.5, True), (45.3, False)])
def test_ten_windows_more_than_what_is_taken_out_tell_something(
    seconds: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """18 windows from 0.2 s on end at 45.2 s, and 0.2 s more are needed for what is there."""
    monkeypatch.setattr(module, "_differs", lambda known, rest, grounds: True)
    assert (Drive(seconds).spread() > 0.0) is told


def test_one_plane_and_one_hill_are_none() -> None:
    """The plane rises to the north-east; the hill is 20 m to its steepest place, in the middle of the drive."""
    drive = Drive(size=0.0)
    c, s = np.cos(drive.yaw), np.sin(drive.yaw)
    drive.gravity = 0.6 * c + 0.8 * s
    assert np.std(drive.gravity) > 3.0 * LEAST
    assert drive.spread() == 0.0
    places = np.linspace(drive.x.min(), drive.x.max(), 15)[7], np.linspace(drive.y.min(), drive.y.max(), 15)[7]
    near = np.argmin(np.hypot(drive.x - places[0], drive.y - places[1]))
    dx, dy = (drive.x - drive.x[near]) / 40.0, (drive.y - drive.y[near]) / 40.0
    drive.gravity = 2.0 * np.exp(-0.5 * (dx**2 + dy**2)) * (dx * c + dy * s)
    assert drive.spread() == 0.0


def test_without_speed_or_acceleration_and_within_one_window_nothing_tells() -> None:
    drive = Drive()
    measured = np.column_stack([drive.x, drive.y, drive.yaw, drive.v, drive.rate, drive.change - drive.gravity,
                                drive.ay, 0.0 * drive.t])  # fmt: skip
    for channel in (3, 5):
        there = measured.copy()
        there[1:, channel] = np.nan
        assert slope_spread(drive.t, there) == 0.0
    assert slope_spread(drive.t[:40], measured[:40]) == 0.0


def test_what_is_taken_at_the_end_of_a_window_is_a_mean_over_a_fifth_of_a_second_about_it() -> None:
    """Of a straight line that is its middle: stamps from 0.9 to 1.1 s, the last one excluded."""
    t = np.arange(128) / 64.0
    assert _about(t, 3.0 * t, 1.0) == pytest.approx(3.0)  # 6 rows before 1 s, as many after it, and the one at 1 s
    jump = np.where(np.arange(128) < 64, 0.0, 1.0)
    assert _about(t, jump, 1.0) == pytest.approx(7.0 / 13.0)
    thin = np.array([0.0, 2.0])
    assert _about(thin, np.array([4.0, 8.0]), 0.5) == pytest.approx(5.0)  # without stamps there: the line between


def test_what_columns_cannot_make_is_beside_them_and_a_ground_explains_three_quarters_of_it() -> None:
    known = np.array([[1.0], [1.0], [1.0], [1.0]])
    rest = np.array([3.0, -1.0, 1.0, -3.0])  # 20 in squares, the mean is 0
    assert _beside(known, 5.0 + rest).tolist() == pytest.approx(rest.tolist())
    pair, other = np.array([1.0, 0.0, 0.0, -1.0]), np.array([0.0, 1.0, -1.0, 0.0])
    assert not _differs(known, rest, [(pair,)])  # 18 of 20
    assert _differs(known, rest, [(other,)])  # 2 of 20
    assert not _differs(known, rest, [(other,), (pair,)])  # one is enough
    three = np.array([1.0, 1.0, -1.0, -1.0])
    assert _differs(known, rest, [(three,)])  # 4 by 4, squared over 4: 4 of 20
    assert not _differs(known, rest, [(three, other)])  # together all


def test_a_hill_rises_to_its_steepest_place_in_its_length_and_falls_behind_its_top() -> None:
    """The rise along the way of exp(-r^2/2), r in lengths of the hill: downhill from its top on."""
    x, y = np.array([0.0, 140.0, 70.0]), np.array([0.0, 0.0, 28.0])
    c, s = np.array([1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    found = _hills(x, y, c, s)
    assert len(found) == 15 * 15 * 4
    # tops each 10 m along x and 2 m along y, four lengths each; that at 70, 0 is the eighth along x
    for k, length in enumerate((10.0, 20.0, 40.0, 80.0)):
        ((first, second, third),) = (found[7 * 15 * 4 + k][0],)
        far = 70.0 / length
        assert first == pytest.approx(-far * np.exp(-0.5 * far**2))
        assert second == pytest.approx(far * np.exp(-0.5 * far**2))
        assert third == pytest.approx(28.0 / length * np.exp(-0.5 * (28.0 / length) ** 2))


def test_drives_and_their_segments_count_by_how_long_they_last() -> None:
    """Of 1 s by 0.3 and 3 s by -0.1 m/s^2 the mean is none and the square 0.03; a second drive of 4 s is flat."""
    one = (np.array([1.0, 3.0]), np.array([0.3, -0.1]), np.array([0.7, 0.7]))
    assert told_spread([one]) == pytest.approx(0.03**0.5)
    lifted = (one[0], one[1] + 0.5, one[2])
    assert told_spread([lifted]) == pytest.approx(0.03**0.5)
    flat = (np.array([4.0]), np.array([9.0]), np.array([-3.0]))
    nothing = (np.zeros(0), np.zeros(0), np.zeros(0))
    assert told_spread([flat, one, nothing]) == pytest.approx(0.015**0.5)
    # an accelerometer that shows more than what the car does is wrong, and no hill
    assert told_spread([(one[0], one[1], 2.0 * one[1])]) == 0.0
    assert told_spread([(one[0], one[1], -one[1])]) == pytest.approx(0.06**0.5)
    least = (np.array([1.0, 1.0]), np.array([LEAST_TOLD, -LEAST_TOLD]), np.zeros(2))
    assert told_spread([least]) == pytest.approx(LEAST_TOLD)
