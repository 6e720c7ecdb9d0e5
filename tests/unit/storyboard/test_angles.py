"""Conditions on angles: within the tolerance, modulo a full turn."""

from __future__ import annotations

from pathlib import Path

import pytest

from openscenario.road.network import RoadNetwork, load_network

from .conftest import (
    XODR,
    Make,
    at_time,
    by_entity,
    condition,
    event,
    group,
    lane_position,
    log,
    run,
    speed,
    story,
    teleport,
)
from .test_actions import follow


def fires(make: Make, test: str, on: RoadNetwork | None = None) -> bool:
    """A drives in lane 1, against the reference line: heading pi; B stands at 0.5 rad."""
    board = make(
        A=[teleport(lane_position(100.0, 1))],
        B=[teleport('<WorldPosition x="300" y="-1.75" z="0" h="0.5" p="0" r="0"/>')],
        stories=story(event("e", speed(5.0), start=group(condition(by_entity(test, "A"))))),
        on=on,
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


@pytest.mark.parametrize(("angle", "expected"), [(3.14159, True), (0.0, False)])
def test_where_no_system_is_named_it_is_the_world(make: Make, angle: float, expected: bool) -> None:
    assert fires(make, f'<AngleCondition angleType="heading" angle="{angle}" angleTolerance="0.1"/>') is expected


@pytest.mark.parametrize(("angle", "expected"), [(0.05, True), (3.14159, False)])
def test_against_itself_an_entity_has_no_angle(make: Make, angle: float, expected: bool) -> None:
    attributes = f'angleType="heading" angle="{angle}" angleTolerance="0.1" coordinateSystem="entity"'
    assert fires(make, f"<AngleCondition {attributes}/>") is expected


@pytest.mark.parametrize("system", ["lane", "road"])
@pytest.mark.parametrize(("kind", "angle"), [("pitch", 0.0), ("roll", 0.0)])
def test_who_stands_on_the_surface_has_no_angle_to_it(
    make: Make, tmp_path: Path, system: str, kind: str, angle: float
) -> None:
    """Facing down a slope of 10 %, against the reference line, banked to the left by 0.1 rad."""
    profiles = (
        '<elevationProfile><elevation s="0" a="0" b="0.1" c="0" d="0"/></elevationProfile>'
        '<lateralProfile><superelevation s="0" a="0.1" b="0" c="0" d="0"/></lateralProfile><lanes>'
    )
    (tmp_path / "slope.xodr").write_text(XODR.replace("<lanes>", profiles))
    network = load_network(tmp_path / "slope.xodr")
    for coordinates, expected in ((system, True), ("world", False)):
        attributes = f'angleType="{kind}" angle="{angle}" angleTolerance="0.05" coordinateSystem="{coordinates}"'
        assert fires(make, f"<AngleCondition {attributes}/>", on=network) is expected


@pytest.mark.parametrize(
    ("seconds", "kind", "angle"),
    [(0.5, "heading", 0.0), (1.5, "heading", 0.3), (0.5, "pitch", 0.0), (0.5, "roll", 0.0)],
)
def test_angles_to_the_trajectory(make: Make, seconds: float, kind: str, angle: float) -> None:
    """10 m straight on, climbing 1 m; then 10 m more, 0.3 rad off the heading that the vertex asks for."""
    places = ('x="100" y="-1.75" z="0" h="0"', 'x="110" y="-1.75" z="1" h="0.3"', 'x="120" y="-1.75" z="1" h="0.3"')
    vertices = "".join(f"<Vertex><Position><WorldPosition {place}/></Position></Vertex>" for place in places)
    test = by_entity(
        f'<AngleCondition angleType="{kind}" angle="{angle}" angleTolerance="0.01" coordinateSystem="trajectory"/>', "A"
    )
    board = make(
        A=[teleport(lane_position(100.0)), speed(10.0), follow(vertices)],
        stories=story(event("e", speed(5.0), start=group(condition(at_time(seconds)), condition(test)))),
    )
    run(board, seconds + 0.05)
    assert ("e", "startTransition") in [(name, what) for _, name, what in log(board, "event")]


def test_there_is_no_angle_to_a_trajectory_that_nobody_follows(make: Make) -> None:
    assert not fires(
        make, '<AngleCondition angleType="heading" angle="0" angleTolerance="3.14" coordinateSystem="trajectory"/>'
    )


@pytest.mark.parametrize(("angle", "expected"), [(0.5 - 3.14159, True), (0.5 + 3.14159, True), (0.5, False)])
def test_heading_of_another_entity(make: Make, angle: float, expected: bool) -> None:
    attributes = f'entityRef="B" angleType="heading" angle="{angle}" angleTolerance="0.01" coordinateSystem="entity"'
    assert fires(make, f"<RelativeAngleCondition {attributes}/>") is expected
