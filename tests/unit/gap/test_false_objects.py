"""False objects are counted when they appear, however long they stay."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.perception.false_objects import appearances
from pytest_dvp.logs.log_contents import FloatArray

STAMPS = np.arange(40) / 20.0  # 2 s at 20 Hz


def count(*ghosts: FloatArray) -> int:
    t, x, y = np.concatenate(ghosts).T
    return appearances(t, x, y)


def ghost(
    begin: float = 0.0, x: float = 10.0, y: float = 0.0, speed: float = 0.0, stamps: FloatArray = STAMPS
) -> FloatArray:
    return np.column_stack([begin + stamps, x + speed * stamps, np.full(len(stamps), y)])


def test_one_that_lives_two_seconds_at_20_hz_is_one() -> None:
    assert count(ghost()) == 1


@pytest.mark.parametrize("speed", [5.0, 15.0, -15.0])  # fixed to a car that drives, or comes towards it
def test_one_that_moves_is_one(speed: float) -> None:
    assert count(ghost(speed=speed)) == 1


def test_one_that_flickers_is_one_until_it_was_away_for_longer_than_half_a_second() -> None:
    assert count(ghost(stamps=np.array([0.0, 0.1, 0.5, 0.9]))) == 1
    assert count(ghost(stamps=np.array([0.0, 0.1, 0.7, 0.8]))) == 2


def test_two_beside_each_other_are_two() -> None:
    assert count(ghost(), ghost(y=0.8)) == 2


def test_one_that_appears_elsewhere_is_another() -> None:
    assert count(ghost(stamps=STAMPS[:20]), ghost(begin=1.0, x=20.0, stamps=STAMPS[:20])) == 2


def test_the_order_of_boxes_does_not_matter() -> None:
    boxes = np.concatenate([ghost(), ghost(y=5.0), ghost(begin=5.0)])
    turned = boxes[np.random.default_rng(0).permutation(len(boxes))]
    assert count(turned) == count(boxes) == 3


def test_clutter_that_lives_for_one_frame_is_counted_box_by_box() -> None:
    """Poisson clutter of 0.5 a second in 10 minutes at 10 Hz, over a disc of 50 m: few meet by chance.

    0.1 to 0.5 s later it may be 2 to 6 m away: (4 + 9 + 16 + 25 + 36) pi m^2 of 2500 pi, times 0.05 boxes a stamp,
    times 300 boxes: 0.54 meetings, four or more once in 400 such drives.
    """
    rng = np.random.default_rng(1)
    t = np.sort(rng.integers(0, 6000, 300)) / 10.0
    bearing, distance = rng.uniform(-np.pi, np.pi, 300), 50.0 * np.sqrt(rng.random(300))
    assert 297 <= appearances(t, distance * np.cos(bearing), distance * np.sin(bearing)) <= 300


def test_no_box_is_no_object() -> None:
    none = np.zeros(0)
    assert appearances(none, none, none) == 0
