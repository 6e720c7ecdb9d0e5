"""A file for CARLA's scenario runner has its positions in CARLA's coordinates: y to the right of x, h clockwise."""

from __future__ import annotations

from pathlib import Path

import pytest
from xosc_samples import Spoil

from openscenario import model
from openscenario.left_handed import right_handed
from openscenario.read import check_scenario, read_scenario
from openscenario.write import write_scenario

LANE = '<LanePosition roadId="1" laneId="-1" s="50.0"/>'


def read(spoil: Spoil, position: str, description: str = "CARLA:small") -> model.Scenario:
    return read_scenario(written(spoil, position, description))


def written(spoil: Spoil, position: str, description: str = "CARLA:small") -> Path:
    path = spoil(LANE, position)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace('description="small"', f'description="{description}"'), encoding="utf-8")
    return path


def position(scenario: model.Scenario) -> model.Position:
    action = scenario.storyboard.init.actions.privates[0].private_actions[0]
    assert isinstance(action, model.TeleportAction)
    return action.position


def test_y_and_heading_change_their_sign(spoil: Spoil) -> None:
    # a start of the public scenario emergency_331 on CARLA's Town04: 246.15 there is the middle of lane 1 of road 27
    carla = '<WorldPosition x="246.76" y="-246.151" z="0.004" h="0.25" p="0.1" r="0.2"/>'
    expected = model.WorldPosition(x=246.76, y=246.151, z=0.004, h=-0.25, p=0.1, r=0.2)
    assert position(read(spoil, carla)) == expected
    other = read(spoil, carla, "small CARLA:")
    assert position(other) == model.WorldPosition(x=246.76, y=-246.151, z=0.004, h=0.25, p=0.1, r=0.2)


def test_to_the_side_of_another_changes_its_sign_and_a_lane_does_not(spoil: Spoil) -> None:
    turned = '<Orientation type="relative" h="0.5"/>'
    lane = f'<LanePosition roadId="1" laneId="-1" s="50.0" offset="0.3">{turned}</LanePosition>'
    expected = model.LanePosition("1", -1, 50.0, 0.3, model.Orientation(h=-0.5, type="relative"))
    assert position(read(spoil, lane)) == expected
    for kind in (model.RelativeWorldPosition, model.RelativeObjectPosition):
        turn = model.Orientation(h=0.5, type="relative")
        found = right_handed(kind("A", 3.0, 2.0, 1.0, turn))
        assert found == kind("A", 3.0, -2.0, 1.0, model.Orientation(h=-0.5, type="relative"))


@pytest.mark.parametrize(
    ("where", "description", "warns"),
    [
        ('<WorldPosition x="9" y="1"/>', "CARLA:small", True),
        ('<WorldPosition x="9" y="1"/>', "small", False),
        ('<WorldPosition x="9" y="0" h="0"/>', "CARLA:small", False),
        (LANE, "CARLA:small", False),
    ],
)
def test_a_warning_says_so_where_a_position_changes(spoil: Spoil, where: str, description: str, warns: bool) -> None:
    found = [each for each in check_scenario(written(spoil, where, description)) if "hand" in each.code]
    assert [(each.code, each.severity, each.line) for each in found] == [("position.left_handed", "warning", 3)] * warns


def test_what_is_written_again_is_not_turned_twice(spoil: Spoil, tmp_path: Path) -> None:
    scenario = read(spoil, '<WorldPosition x="9" y="2" h="0.5"/>')
    write_scenario(scenario, tmp_path / "again.xosc")
    again = read_scenario(tmp_path / "again.xosc")
    assert again == scenario
    assert position(again) == model.WorldPosition(x=9.0, y=-2.0, h=-0.5)


def test_a_bend_to_the_left_becomes_one_to_the_right() -> None:
    place = model.WorldPosition(x=1.0, y=2.0)
    bend = model.Clothoid(curvature=0.1, curvature_prime=0.01, length=5.0, position=place)
    found = right_handed(bend)
    assert (found.curvature, found.curvature_prime, found.length) == (-0.1, -0.01, 5.0)
    assert found.position == model.WorldPosition(x=1.0, y=-2.0)
