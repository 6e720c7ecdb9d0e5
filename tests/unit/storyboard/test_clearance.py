"""RelativeClearanceCondition: whether lanes beside, ahead and behind are free; two lanes each way, 3.5 m wide."""

from __future__ import annotations

import pytest

from .conftest import Make, by_entity, condition, event, group, lane_position, log, run, speed, story, teleport


def free(make: Make, other: str, lanes: str, options: str = "") -> bool:
    """Whether A, in lane -2 at 100 m (box 1 m behind to 4 m ahead), finds the lanes free of B."""
    attributes = 'distanceForward="20" distanceBackward="10" freeSpace="{free}" oppositeLanes="{opposite}"'.format(
        free="true" if "free" in options else "false", opposite="true" if "opposite" in options else "false"
    )
    test = by_entity(f"<RelativeClearanceCondition {attributes}>{lanes}</RelativeClearanceCondition>", "A")
    board = make(
        A=[teleport(lane_position(100.0, -2))],
        B=[teleport(other)],
        stories=story(event("e", speed(5.0), start=group(condition(test)))),
    )
    run(board, 0.05)
    return ("e", "startTransition") in [(name, what) for _, name, what in log(board, "event")]


LEFT = '<RelativeLaneRange from="1" to="1"/>'


@pytest.mark.parametrize(
    ("s", "expected"), [(121.0, True), (119.0, False), (100.0, False), (91.0, False), (89.0, True)]
)
def test_it_is_free_beyond_the_distances(make: Make, s: float, expected: bool) -> None:
    assert free(make, lane_position(s, -1), LEFT) is expected


def test_other_lanes_do_not_count(make: Make) -> None:
    assert free(make, lane_position(100.0, -1), '<RelativeLaneRange from="0" to="0"/>')


def test_without_a_range_all_lanes_count(make: Make) -> None:
    assert not free(make, lane_position(110.0, -1), "")


def test_free_space_counts_between_the_boxes(make: Make) -> None:
    """B's rear 1 m behind its reference point, A's front 4 m ahead: 125 - 1 - 104 = 20 m."""
    assert free(make, lane_position(125.1, -1), LEFT, "free")
    assert not free(make, lane_position(124.9, -1), LEFT, "free")


@pytest.mark.parametrize(("options", "expected"), [("", True), ("opposite", False)])
def test_opposite_lanes_count_when_asked_for(make: Make, options: str, expected: bool) -> None:
    assert free(make, lane_position(100.0, 1), '<RelativeLaneRange from="1" to="2"/>', options) is expected


def test_a_lane_that_the_road_does_not_have_is_not_free(make: Make) -> None:
    assert not free(make, lane_position(300.0, -1), '<RelativeLaneRange from="-1" to="-1"/>')
