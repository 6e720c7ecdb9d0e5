"""What cannot run is refused before anything runs, with file, line and name."""

from __future__ import annotations

import pytest

from openscenario.findings import ScenarioError

from .conftest import Make, by_entity, condition, event, group, lane_position, run, speed, story, teleport

HERE = [teleport(lane_position(100.0)), speed(10.0)]


def refused(make: Make, **scenario: object) -> ScenarioError:
    with pytest.raises(ScenarioError) as caught:
        make(**scenario)
    return caught.value


TEMPLATE = (
    '<ScenarioObjectTemplate><MiscObject name="m" mass="1" miscObjectCategory="obstacle"><BoundingBox>'
    '<Center x="0" y="0" z="0"/><Dimensions width="1" length="1" height="1"/></BoundingBox><Properties/></MiscObject>'
    "</ScenarioObjectTemplate>"
)
AREA = (
    '<GlobalAction><TrafficAction><TrafficAreaAction continuous="false" numberOfEntities="1"><TrafficDistribution>'
    '<TrafficDistributionEntry weight="1"><EntityDistribution>'
    f'<EntityDistributionEntry weight="1">{TEMPLATE}</EntityDistributionEntry></EntityDistribution>'
    "</TrafficDistributionEntry></TrafficDistribution><TrafficArea>"
    '<RoadRange><RoadCursor roadId="1" s="0"/><RoadCursor roadId="2" s="10"/></RoadRange>'
    "</TrafficArea></TrafficAreaAction></TrafficAction></GlobalAction>"
)


def test_an_unsupported_action_is_a_finding_with_its_place(make: Make) -> None:
    (finding,) = refused(make, A=HERE, stories=story(event("e", AREA))).findings
    assert finding.file.endswith("scenario.xosc")
    assert finding.line is not None
    assert "several roads" in finding.message


def test_all_findings_come_at_once(make: Make) -> None:
    assert len(refused(make, A=HERE, stories=story(event("e", AREA), event("f", AREA))).findings) == 2


def test_an_unsupported_condition_is_a_finding_with_its_place(make: Make) -> None:
    angle = '<AngleCondition angleType="heading" angle="0" angleTolerance="1" coordinateSystem="road"/>'
    stories = story(event("e", speed(5.0), start=group(condition(by_entity(angle, "A")))))
    (finding,) = refused(make, A=[speed(10.0)], stories=stories, without_road=True).findings
    assert finding.file.endswith("scenario.xosc")
    assert finding.line is not None
    assert finding.element.endswith("AngleCondition")
    assert "this angle is not known" in finding.message


def test_without_time_stamps_a_trajectory_is_followed_at_the_own_speed_and_said_so(make: Make) -> None:
    vertices = "".join(f'<Vertex><Position><WorldPosition x="{x}" y="0"/></Position></Vertex>' for x in (0, 50))
    action = (
        "<PrivateAction><RoutingAction><FollowTrajectoryAction><TrajectoryRef>"
        f'<Trajectory name="t" closed="false"><Shape><Polyline>{vertices}</Polyline></Shape></Trajectory>'
        "</TrajectoryRef>"
        '<TimeReference><Timing domainAbsoluteRelative="relative" scale="1" offset="0"/></TimeReference>'
        '<TrajectoryFollowingMode followingMode="follow"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    )
    board = make(A=HERE, stories=story(event("e", action)))
    run(board, 1.0)
    assert board.entities["A"].x == pytest.approx(10.0)
    (finding,) = {each for each in board.report() if "no time stamps" in each.message}
    assert finding.element.endswith("Trajectory[t]")
