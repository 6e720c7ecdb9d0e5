"""Each limit of the doctor's look at speeds and wishes, just short of it and just past it."""

from __future__ import annotations

import numpy as np
import pytest
from known_motion import motion, times

from openscenario.findings import Finding, Findings
from pytest_dvp.doctor.speed_and_acceleration import check_speed, check_wishes
from pytest_dvp.logs.log_contents import FloatArray

MILE, NAUTICAL_MILE, HOUR = 1609.344, 1852.0, 3600.0  # m, m, s

UNITS = [
    (HOUR / 1000.0, "km/h stored as m/s", "km/h"), (HOUR / MILE, "mph stored as m/s", "mph"),
    (HOUR / NAUTICAL_MILE, "knots stored as m/s", "kn"), (1000.0 / HOUR, "m/s stored as km/h", "m/s"),
]  # fmt: skip


def speed(ratio: FloatArray) -> Finding:
    """What is told of a measured speed that is this many times (n,) the 10 m/s that the car has over ground."""
    found = Findings()
    check_speed(motion(path_speed=np.full(len(ratio), 10.0), v=10.0 * ratio), "log.csv", found)
    (finding,) = found.found
    return finding


def wishes(**of: FloatArray) -> list[str]:
    found = Findings()
    check_wishes(motion(**of), "log.csv", found)
    return [finding.code for finding in found.found]


@pytest.mark.parametrize(("ratio", "text", "unit"), UNITS)
def test_a_speed_in_another_unit_is_told_with_the_unit(ratio: float, text: str, unit: str) -> None:
    finding = speed(np.full(1000, ratio))
    assert (finding.code, finding.text) == ("log.unit_suspect", f"v does not fit the positions: {text}")
    assert finding.hint == f"write `v [{unit}]`"


@pytest.mark.parametrize(("ratio", "code"), [(1.09, "log.wheel_slip"), (1.11, "log.unit_suspect")])
def test_wheels_grip_where_their_speed_is_within_a_tenth_of_that_over_ground(ratio: float, code: str) -> None:
    """For a quarter of the drive; the rest of the time they turn at 20 to 70 % of it."""
    share = np.linspace(0.0, 1.0, 2000)
    assert speed(np.where(share < 0.25, ratio, 0.45 + 0.25 * np.sin(90.0 * share))).code == code


@pytest.mark.parametrize(("spread", "code"), [(0.19, "log.unit_suspect"), (0.21, "log.wheel_slip")])
def test_wheels_slip_where_the_ratio_of_the_speeds_spreads_by_a_fifth(spread: float, code: str) -> None:
    """They grip for the last 20 %. Before, the ratio rises evenly, with 0.6 at half of the drive: between its quarter
    and its three quarters are 5/8 of that rise."""
    share = np.linspace(0.0, 1.0, 2000)
    assert speed(np.where(share > 0.8, 1.0, 0.6 * (1.0 + spread * (share - 0.5) / 0.5))).code == code


@pytest.mark.parametrize(("faster", "code"), [(1.37, "log.speed_not_reached"), (1.43, "log.unit_suspect")])
def test_a_unit_of_wanted_speeds_is_told_if_they_vary_by_two_fifths(faster: float, code: str) -> None:
    """Two speeds by turns, and a wish in km/h: at nearly one speed it may as well be a car that cannot go faster."""
    v = 8.0 * np.where(np.sin(0.5 * times(60.0)) > 0.0, faster, 1.0)
    assert wishes(v=v, speed_cmd=3.6 * v) == [code]


@pytest.mark.parametrize(("more", "code"), [(1.14, "log.unit_suspect"), (1.16, "log.speed_not_reached")])
def test_a_unit_of_wanted_speeds_is_told_if_slow_and_fast_ones_have_one_ratio(more: float, code: str) -> None:
    """For the fast half of the wishes, which is the smaller one, the car lags behind by 15 % more, or not as much."""
    fast = np.sin(0.5 * times(60.0)) > 0.2
    v = np.where(fast, 16.0, 8.0)
    assert wishes(v=v, speed_cmd=3.6 * v * np.where(fast, more, 1.0)) == [code]


@pytest.mark.parametrize(("late", "told"), [(0.9, ["log.unit_suspect"]), (1.1, [])])
def test_a_drive_is_held_against_what_was_asked_for_up_to_a_second_before(late: float, told: list[str]) -> None:
    """The car does a tenth of what is asked for. Each wish lasts 0.1 s and has nothing to do with the next one, so that
    a drive which is later than that by 0.1 s is not like its wishes any more, and says nothing of a unit."""
    wish = 25.0 * np.repeat(np.random.default_rng(3).uniform(-1.0, 1.0, 600), 5)
    assert wishes(accel_cmd=wish, accel=np.roll(0.1 * wish, round(late / 0.02))) == told
