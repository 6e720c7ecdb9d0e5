"""Conditions on angles: within the tolerance, modulo a full turn."""

from __future__ import annotations

import pytest

from .conftest import Make, by_entity, condition, event, group, lane_position, log, run, speed, story, teleport


def fires(make: Make, test: str) -> bool:
    """A drives in lane 1, against the reference line: heading pi; B stands at 0.5 rad."""
    board = make(
        A=[teleport(lane_position(100.0, 1))],
        B=[teleport('<WorldPosition x="300" y="-1.75" z="0" h="0.5" p="0" r="0"/>')],
        stories=story(event("e", speed(5.0), start=group(condition(by_entity(test, "A"))))),
    )
    run(board, 0.05)
    return ("e", "startTransition") in [(name, what) for _, name, what in log(board, "event")]


@pytest.mark.parametrize(
    ("system", "angle", "expected"),
    [
        ("world", 3.14159, True),
        ("world", -3.2, True),
        ("world", -3.3, False),
        ("road", 3.1, True),
        ("road", 0.0, False),
        ("lane", 0.05, True),
        ("lane", 0.15, False),
    ],
)
def test_heading_against_a_coordinate_system(make: Make, system: str, angle: float, expected: bool) -> None:
    attributes = f'angleType="heading" angle="{angle}" angleTolerance="0.1" coordinateSystem="{system}"'
    assert fires(make, f"<AngleCondition {attributes}/>") is expected


@pytest.mark.parametrize(("angle", "expected"), [(0.5 - 3.14159, True), (0.5 + 3.14159, True), (0.5, False)])
def test_heading_of_another_entity(make: Make, angle: float, expected: bool) -> None:
    attributes = f'entityRef="B" angleType="heading" angle="{angle}" angleTolerance="0.01" coordinateSystem="entity"'
    assert fires(make, f"<RelativeAngleCondition {attributes}/>") is expected
