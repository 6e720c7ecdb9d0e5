"""A small valid scenario with its road, and helpers to spoil it in one place."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

ROAD = """<OpenDRIVE><header revMajor="1" revMinor="6"/>
<road id="1" length="500.0" junction="-1">
<planView><geometry s="0" x="0" y="0" hdg="0" length="500.0"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none"/></center>
<right><lane id="-1" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right></laneSection></lanes>
<signals><signal id="77" s="10" t="0"/></signals></road></OpenDRIVE>
"""

SCENARIO = """<?xml version="1.0" encoding="UTF-8"?>
<OpenSCENARIO>
  <FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="small" author="test"/>
  <ParameterDeclarations>
    <ParameterDeclaration name="EgoSpeed" parameterType="double" value="10.0"/>
  </ParameterDeclarations>
  <CatalogLocations/>
  <RoadNetwork><LogicFile filepath="road.xodr"/></RoadNetwork>
  <Entities>
    <ScenarioObject name="Ego">
      <Vehicle name="car" vehicleCategory="car">
        <BoundingBox>
          <Center x="1.4" y="0.0" z="0.75"/>
          <Dimensions width="1.8" length="4.5" height="1.5"/>
        </BoundingBox>
        <Performance maxSpeed="70.0" maxDeceleration="9.0" maxAcceleration="4.0"/>
        <Axles>
          <FrontAxle maxSteering="0.5" wheelDiameter="0.6" trackWidth="1.6" positionX="2.8" positionZ="0.3"/>
          <RearAxle maxSteering="0.0" wheelDiameter="0.6" trackWidth="1.6" positionX="0.0" positionZ="0.3"/>
        </Axles>
        <Properties/>
      </Vehicle>
    </ScenarioObject>
  </Entities>
  <Storyboard>
    <Init>
      <Actions>
        <Private entityRef="Ego">
          <PrivateAction><TeleportAction><Position>
            <LanePosition roadId="1" laneId="-1" s="50.0"/>
          </Position></TeleportAction></PrivateAction>
          <PrivateAction><LongitudinalAction><SpeedAction>
            <SpeedActionDynamics dynamicsShape="step" value="0.0" dynamicsDimension="time"/>
            <SpeedActionTarget>
              <AbsoluteTargetSpeed value="$EgoSpeed"/>
            </SpeedActionTarget>
          </SpeedAction></LongitudinalAction></PrivateAction>
        </Private>
      </Actions>
    </Init>
    <Story name="story">
      <Act name="act">
        <ManeuverGroup name="group" maximumExecutionCount="1">
          <Actors selectTriggeringEntities="false"><EntityRef entityRef="Ego"/></Actors>
          <Maneuver name="maneuver">
            <Event name="event" priority="overwrite">
              <Action name="action">
                <PrivateAction><LateralAction><LaneChangeAction>
                  <LaneChangeActionDynamics dynamicsShape="sinusoidal" value="3.0" dynamicsDimension="time"/>
                  <LaneChangeTarget><AbsoluteTargetLane value="-1"/></LaneChangeTarget>
                </LaneChangeAction></LateralAction></PrivateAction>
              </Action>
              <StartTrigger><ConditionGroup>
                <Condition name="later" delay="0" conditionEdge="rising">
                  <ByValueCondition><SimulationTimeCondition value="1.0" rule="greaterThan"/></ByValueCondition>
                </Condition>
              </ConditionGroup></StartTrigger>
            </Event>
          </Maneuver>
        </ManeuverGroup>
        <StartTrigger><ConditionGroup>
          <Condition name="start" delay="0" conditionEdge="none">
            <ByValueCondition><SimulationTimeCondition value="0.0" rule="greaterThan"/></ByValueCondition>
          </Condition>
        </ConditionGroup></StartTrigger>
      </Act>
    </Story>
    <StopTrigger/>
  </Storyboard>
</OpenSCENARIO>
"""

Spoil = Callable[..., Path]


def line_of(path: Path, text: str) -> int:
    """1-based number of the first line that holds the text."""
    return next(number for number, line in enumerate(path.read_text().splitlines(), 1) if text in line)
