"""A straight two-way road and scenarios written from their parts, so that a test shows only what it is about."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from openscenario.read import read_scenario
from openscenario.road.network import RoadNetwork, load_network
from openscenario.storyboard.engine import Storyboard
from openscenario.storyboard.reading import Reading

LANE = '<lane id="{id}" type="driving" level="false"><link/><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'

XODR = f"""<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="6" name="straight"/>
  <road name="straight" length="1000" id="1" junction="-1" rule="RHT">
    <link/>
    <planView><geometry s="0" x="0" y="0" hdg="0" length="1000"><line/></geometry></planView>
    <lanes><laneSection s="0">
      <left>{LANE.format(id=2)}{LANE.format(id=1)}</left>
      <center><lane id="0" type="none" level="false"/></center>
      <right>{LANE.format(id=-1)}{LANE.format(id=-2)}</right>
    </laneSection></lanes>
  </road>
</OpenDRIVE>
"""

CAR = """<Vehicle name="{name}" vehicleCategory="car">
  <BoundingBox><Center x="1.5" y="0" z="0.75"/><Dimensions width="2" length="5" height="1.5"/></BoundingBox>
  <Performance maxSpeed="70" maxAcceleration="{acceleration}" maxDeceleration="10"/>
  <Axles>
    <FrontAxle maxSteering="0.5" wheelDiameter="0.6" trackWidth="1.8" positionX="3" positionZ="0.3"/>
    <RearAxle maxSteering="0" wheelDiameter="0.6" trackWidth="1.8" positionX="0" positionZ="0.3"/>
  </Axles>
  <Properties/>
</Vehicle>"""

XOSC = """<?xml version="1.0"?>
<OpenSCENARIO>
  <FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="" author=""/>
  <ParameterDeclarations><ParameterDeclaration name="p" parameterType="double" value="1"/></ParameterDeclarations>
  <VariableDeclarations><VariableDeclaration name="v" variableType="double" value="1"/></VariableDeclarations>
  <CatalogLocations/>
  <RoadNetwork><LogicFile filepath="straight.xodr"/></RoadNetwork>
  <Entities>{entities}</Entities>
  <Storyboard>
    <Init><Actions>{init}</Actions></Init>
    {stories}
    <StopTrigger>{stop}</StopTrigger>
  </Storyboard>
</OpenSCENARIO>
"""

Make = Callable[..., Storyboard]


def lane_position(s: float, lane: int = -1, offset: float = 0.0, inner: str = "") -> str:
    return f'<LanePosition roadId="1" laneId="{lane}" s="{s}" offset="{offset}">{inner}</LanePosition>'


def teleport(position: str) -> str:
    return f"<PrivateAction><TeleportAction><Position>{position}</Position></TeleportAction></PrivateAction>"


def speed(target: float, shape: str = "step", dimension: str = "time", value: float = 0.0) -> str:
    return relative_speed(f'<AbsoluteTargetSpeed value="{target}"/>', shape, dimension, value)


def relative_speed(target: str, shape: str = "step", dimension: str = "time", value: float = 0.0) -> str:
    return (
        "<PrivateAction><LongitudinalAction><SpeedAction>"
        f'<SpeedActionDynamics dynamicsShape="{shape}" dynamicsDimension="{dimension}" value="{value}"/>'
        f"<SpeedActionTarget>{target}</SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>"
    )


def lane_change(target: str, shape: str = "sinusoidal", dimension: str = "time", value: float = 3.0) -> str:
    return (
        "<PrivateAction><LateralAction><LaneChangeAction>"
        f'<LaneChangeActionDynamics dynamicsShape="{shape}" dynamicsDimension="{dimension}" value="{value}"/>'
        f"<LaneChangeTarget>{target}</LaneChangeTarget></LaneChangeAction></LateralAction></PrivateAction>"
    )


def condition(test: str, name: str = "c", edge: str = "none", delay: float = 0.0) -> str:
    return f'<Condition name="{name}" delay="{delay}" conditionEdge="{edge}">{test}</Condition>'


def at_time(value: float, rule: str = "greaterOrEqual") -> str:
    return f'<ByValueCondition><SimulationTimeCondition value="{value}" rule="{rule}"/></ByValueCondition>'


def state_of(kind: str, name: str, state: str) -> str:
    return (
        f'<ByValueCondition><StoryboardElementStateCondition storyboardElementType="{kind}" '
        f'storyboardElementRef="{name}" state="{state}"/></ByValueCondition>'
    )


def by_entity(test: str, *entities: str, rule: str = "any") -> str:
    refs = "".join(f'<EntityRef entityRef="{entity}"/>' for entity in entities)
    return (
        f'<ByEntityCondition><TriggeringEntities triggeringEntitiesRule="{rule}">{refs}</TriggeringEntities>'
        f"<EntityCondition>{test}</EntityCondition></ByEntityCondition>"
    )


def group(*conditions: str) -> str:
    return f"<ConditionGroup>{''.join(conditions)}</ConditionGroup>"


def event(name: str, *actions: str, start: str | None = None, priority: str = "parallel", count: int = 1) -> str:
    trigger = "" if start is None else f"<StartTrigger>{start}</StartTrigger>"
    inner = "".join(f'<Action name="{name}-{i}">{action}</Action>' for i, action in enumerate(actions))
    return f'<Event name="{name}" priority="{priority}" maximumExecutionCount="{count}">{inner}{trigger}</Event>'


def story(
    *events: str,
    actor: str = "A",
    start: str = "<StartTrigger/>",
    stop: str = "",
    select: bool = False,
    name: str = "story",
) -> str:
    actors = "" if select else f'<EntityRef entityRef="{actor}"/>'
    return (
        f'<Story name="{name}"><Act name="act"><ManeuverGroup name="group" maximumExecutionCount="1">'
        f'<Actors selectTriggeringEntities="{str(select).lower()}">{actors}</Actors>'
        f'<Maneuver name="maneuver">{"".join(events)}</Maneuver></ManeuverGroup>{start}{stop}</Act></Story>'
    )


@pytest.fixture(scope="session")
def road(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("road") / "straight.xodr"
    path.write_text(XODR)
    return path


@pytest.fixture(scope="session")
def network(road: Path) -> RoadNetwork:
    return load_network(road)


@pytest.fixture
def make(road: Path, network: RoadNetwork) -> Make:
    """make(A=[actions], B=[actions], stories=..., stop=..., on=road, ...) -> a storyboard before its start."""

    def run(
        *,
        stories: str = "",
        stop: str = "",
        external: tuple[str, ...] = (),
        acceleration: float = 10.0,
        on: RoadNetwork | None = None,
        without_road: bool = False,
        selections: str = "",
        reading: Reading = "esmini",
        **actions: list[str],
    ) -> Storyboard:
        entities = "".join(
            f'<ScenarioObject name="{name}">{CAR.format(name=name, acceleration=acceleration)}</ScenarioObject>'
            for name in actions
        )
        entities += selections
        init = "".join(
            f'<Private entityRef="{name}">{"".join(each)}</Private>' for name, each in actions.items() if each
        )
        path = road.parent / "scenario.xosc"
        text = XOSC.format(entities=entities, init=init, stories=stories, stop=stop)
        path.write_text(text.replace('<LogicFile filepath="straight.xodr"/>', "") if without_road else text)
        where = None if without_road else on or network
        return Storyboard(read_scenario(path), where, external=external, reading=reading)

    return run


def run(board: Storyboard, seconds: float, dt: float = 0.01) -> None:
    """Start it if it has not, and step it."""
    if not board.running:
        board.start()
    for _ in range(round(seconds / dt)):
        board.step(dt)


def log(board: Storyboard, *kinds: str) -> list[tuple[float, str, str]]:
    """(time, element, transition) of elements of some kinds, without those of Init."""
    return [
        (round(each.time, 3), each.element, each.transition)
        for each in board.transitions
        if each.kind in kinds and not each.element.startswith("Init")
    ]
