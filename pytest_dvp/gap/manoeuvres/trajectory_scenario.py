"""A drive as OpenSCENARIO: the path with its times for a robot or driver, on a flat ground of one road.

OpenSCENARIO has no steering by the clock that a driving stack or robot would have to obey; what every player and robot
follows is a trajectory with time stamps. So the scenario holds the path that the model drives with these commands, and
the commands themselves stand beside it, for a car that is driven by wire.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np

from pytest_dvp.gap.manoeuvres.driving_limits import Area, Envelope
from pytest_dvp.gap.manoeuvres.simulated_drive import Drive

if TYPE_CHECKING:
    from vehicle.model.car import Car

EVERY = 5  # rows of a drive to a vertex: 0.1 s
LANE = 3.5  # m, of the lane in which the drive begins
_DATE = "2026-01-01T00:00:00"


def road(area: Area) -> str:
    """An OpenDRIVE file: the area as a straight road whose lanes fill it, that of the start 3.5 m wide about y = 0."""
    left, right = area.y_max - 0.5 * LANE, -area.y_min - 0.5 * LANE
    lanes = [_lane(1, left)] if left > 0.1 else []
    rights = [_lane(-1, LANE)] + ([_lane(-2, right)] if right > 0.1 else [])
    left_side = f"<left>{''.join(lanes)}</left>" if lanes else ""
    length = area.x_max - area.x_min
    north, south = area.y_max, area.y_min
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="7" name="proving ground" version="1.00" north="{north:.3f}" south="{south:.3f}" \
east="{area.x_max:.3f}" west="{area.x_min:.3f}"/>
  <road name="Ground" length="{length:.3f}" id="1" junction="-1" rule="RHT">
    <planView>
      <geometry s="0" x="{area.x_min:.3f}" y="{0.5 * LANE:.3f}" hdg="0" length="{length:.3f}"><line/></geometry>
    </planView>
    <lanes>
      <laneSection s="0">
        {left_side}
        <center><lane id="0" type="none" level="false"/></center>
        <right>{"".join(rights)}</right>
      </laneSection>
    </lanes>
  </road>
</OpenDRIVE>
"""


def _lane(number: int, width: float) -> str:
    return (f'<lane id="{number}" type="driving" level="false">'
            f'<width sOffset="0" a="{width:.3f}" b="0" c="0" d="0"/></lane>')  # fmt: skip


def scenario(drive: Drive, car: Car, envelope: Envelope, road_file: str, description: str) -> str:
    """An OpenSCENARIO 1.2 file whose Ego follows the path of the drive by the clock, and which ends a second after."""
    name = quoteattr(drive.manoeuvre.title)
    rows = np.unique(np.append(np.arange(0, len(drive.t), EVERY), len(drive.t) - 1))
    vertices = "\n".join(
        f'                      <Vertex time="{drive.t[k]:.2f}"><Position><WorldPosition x="{x:.4f}" y="{y:.4f}" '
        f'h="{yaw:.5f}"/></Position></Vertex>'
        for k, (x, y, yaw) in ((int(k), drive.motion[k, :3]) for k in rows)
    )
    box = (f'<Center x="{car.center_x:g}" y="0" z="{0.5 * car.height:g}"/>'
           f'<Dimensions width="{car.width:g}" length="{car.length:g}" height="{car.height:g}"/>')  # fmt: skip
    wheel = f'wheelDiameter="{2.0 * car.wheel_radius:g}" trackWidth="{car.track:g}" positionZ="{car.wheel_radius:g}"'
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<OpenSCENARIO>
  <FileHeader revMajor="1" revMinor="2" date="{_DATE}" description={quoteattr(description)} author="dvp plan"/>
  <CatalogLocations/>
  <RoadNetwork><LogicFile filepath={quoteattr(road_file)}/></RoadNetwork>
  <Entities>
    <ScenarioObject name="Ego">
      <Vehicle name="car" vehicleCategory="car" mass="{car.mass:g}">
        <BoundingBox>{box}</BoundingBox>
        <Performance maxSpeed="{envelope.max_speed:g}" maxAcceleration="{envelope.max_acceleration:g}" \
maxDeceleration="{envelope.max_deceleration:g}"/>
        <Axles>
          <FrontAxle maxSteering="{envelope.max_steer:g}" {wheel} positionX="{car.wheelbase:g}"/>
          <RearAxle maxSteering="0" {wheel} positionX="0"/>
        </Axles>
        <Properties/>
      </Vehicle>
    </ScenarioObject>
  </Entities>
  <Storyboard>
    <Init>
      <Actions>
        <Private entityRef="Ego">
          <PrivateAction>
            <TeleportAction><Position><WorldPosition x="0" y="0" h="0"/></Position></TeleportAction>
          </PrivateAction>
        </Private>
      </Actions>
    </Init>
    <Story name={name}>
      <Act name="Drive">
        <ManeuverGroup name="Driver" maximumExecutionCount="1">
          <Actors selectTriggeringEntities="false"><EntityRef entityRef="Ego"/></Actors>
          <Maneuver name={name}>
            <Event name="FollowPath" priority="override" maximumExecutionCount="1">
              <Action name="FollowPath">
                <PrivateAction>
                  <RoutingAction>
                    <FollowTrajectoryAction>
                      <TrajectoryRef>
                        <Trajectory name={name} closed="false">
                          <Shape>
                            <Polyline>
{vertices}
                            </Polyline>
                          </Shape>
                        </Trajectory>
                      </TrajectoryRef>
                      <TimeReference><Timing domainAbsoluteRelative="relative" scale="1" offset="0"/></TimeReference>
                      <TrajectoryFollowingMode followingMode="position"/>
                    </FollowTrajectoryAction>
                  </RoutingAction>
                </PrivateAction>
              </Action>
              <StartTrigger>{_after("AtOnce", 0.0)}</StartTrigger>
            </Event>
          </Maneuver>
        </ManeuverGroup>
        <StartTrigger>{_after("Begin", 0.0)}</StartTrigger>
      </Act>
    </Story>
    <StopTrigger>{_after("End", drive.seconds + 1.0)}</StopTrigger>
  </Storyboard>
</OpenSCENARIO>
"""


def _after(name: str, seconds: float) -> str:
    return (f'<ConditionGroup><Condition name="{name}" delay="0" conditionEdge="none"><ByValueCondition>'
            f'<SimulationTimeCondition value="{seconds:g}" rule="greaterOrEqual"/></ByValueCondition></Condition>'
            "</ConditionGroup>")  # fmt: skip
