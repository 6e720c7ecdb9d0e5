"""A heading counts with the fix that is nearest to it in time; fixes that find none are counted in the run's notes."""

from __future__ import annotations

import pytest

pytest.importorskip("cyclonedds")

from tests.unit.adapters.test_unstated_accuracy import Drive, place_and_heading
from vehicle.wire import convert, topics


def with_headings(off: float, *, ticks_late: int = 0, count: int = 10) -> Drive:
    """Ten fixes a second; headings are stamped `off` [s] after them and come some ticks of 0.05 s later."""
    drive = Drive()
    drive.begin()
    for k in range(2 * count):
        t = 0.05 * k
        place, heading = place_and_heading()
        place.header.stamp = convert.stamp(round(t * convert.SECOND))
        heading.header.stamp = convert.stamp(max(0, round((t - 0.05 * ticks_late + off) * convert.SECOND)))
        if k % 2 == 0:
            drive.end.kept[topics.FIX].append(place)
        if (k - ticks_late) % 2 == 0 and k >= ticks_late:
            drive.end.kept[topics.HEADING].append(heading)
        drive.at(t + max(0.0, off))
    return drive


@pytest.mark.parametrize("off", [0.0, 1e-6, 0.004, -0.004, 0.02, -0.049])
def test_stamps_need_not_be_the_same(off: float) -> None:
    """Of a receiver whose driver stamps each message when it sends it."""
    drive = with_headings(off)
    assert [fix.yaw for fix in drive.seen[1:]] == [pytest.approx(0.7)] * 9
    assert [fix.t for fix in drive.seen] == [pytest.approx(0.1 * k) for k in range(10)]
    assert drive.notes == []


def test_a_heading_that_comes_after_its_fix_was_handed_on_is_counted_as_lost() -> None:
    """One tick late, of the first ten: after the first heading, each fix finds none."""
    drive = with_headings(0.0, ticks_late=1, count=12)
    assert {fix.yaw for fix in drive.seen} == {None}
    lost = "so far, as none within 0.05 s had come"
    assert drive.notes == [f"/gnss/heading: unpaired: 1 fix {lost}", f"/gnss/heading: unpaired: 10 fixes {lost}"]


def test_a_receiver_without_headings_loses_none() -> None:
    drive = Drive()
    drive.begin()
    for k in range(10):
        place, _ = place_and_heading()
        drive.at(0.1 * k, FIX=place)
    assert drive.notes == []


def test_the_nearest_of_many_headings_counts() -> None:
    """Of an INS with 100 headings a second."""
    drive = Drive()
    drive.begin()
    for k in range(1, 10):
        place, _ = place_and_heading()
        for n in range(10):
            _, heading = convert.fix_to_ros(convert.GnssFix(0.0, 0.0, 0.0, 0.02, 0.1 * k + 0.01 * (n - 9), 0.01), 0)
            assert heading is not None
            heading.header.stamp = convert.stamp(round((0.1 * k + 0.01 * (n - 9)) * convert.SECOND))
            drive.end.kept[topics.HEADING].append(heading)
        drive.at(0.1 * k, FIX=place)
    assert [fix.yaw for fix in drive.seen] == [pytest.approx(fix.t) for fix in drive.seen]
    assert drive.notes == []


@pytest.mark.parametrize(
    ("t", "found"), [(0.149, 0.1), (0.151, 0.2), (0.25, 0.2), (0.2501, None), (0.05, 0.1), (0.0, None)]
)
def test_the_nearest_time_within_the_tolerance(t: float, found: float | None) -> None:
    assert convert.nearest([0.1, 0.2], t) == found
    assert convert.nearest([], t) is None
