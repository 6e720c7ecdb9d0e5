"""A street with much to see: parked, oncoming and leading cars, bicycles and pedestrians, some of them half hidden."""

from __future__ import annotations

from pathlib import Path

HEAD = '<FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="street" author="pytest_dvp"/>'

ROAD = """<?xml version="1.0"?>
<OpenDRIVE>
  <header revMajor="1" revMinor="6" name="street" date="2026-01-01T00:00:00"/>
  <road name="street" length="900" id="1" junction="-1">
    <link/>
    <planView><geometry s="0" x="0" y="0" hdg="0" length="900"><line/></geometry></planView>
    <lanes><laneSection s="0">
      <left><lane id="1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></left>
      <center><lane id="0" type="none" level="false"/></center>
      <right><lane id="-1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right>
    </laneSection></lanes>
  </road>
</OpenDRIVE>
"""

KINDS = {"car": (4.4, 1.8, 1.5), "bicycle": (1.8, 0.6, 1.7), "pedestrian": (0.5, 0.6, 1.75)}  # m

# name -> kind, x, y [m], heading [rad], speed [m/s]
PARKED = {
    f"Parked{k}": ("car", 45.0 + 24.0 * k, -6.6 if k % 2 == 0 else 6.6, (0.0, 0.25, -0.3, 0.1)[k % 4], 0.0)
    for k in range(12)
}
WALKERS = {f"Walker{k}": ("pedestrian", 49.0 + 48.0 * k, -8.6, 0.0, (0.0, -0.8, 0.8)[k % 3]) for k in range(6)}
ONCOMING = {f"Oncoming{k}": ("car", 120.0 + 70.0 * k, 1.75, 3.14159265, 6.0) for k in range(5)}
OTHERS = {
    "Lead": ("car", 50.0, -1.75, 0.0, 7.0),
    "Cyclist": ("bicycle", 100.0, 4.6, 3.14159265, 2.0),
    "Cyclist2": ("bicycle", 180.0, 4.6, 3.14159265, 3.0),
}
OBJECTS = {**PARKED, **WALKERS, **ONCOMING, **OTHERS}


def write_street(folder: Path, seconds: float = 40.0) -> Path:
    """The scenario file in `folder`, beside its road; it ends after `seconds`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "street.xodr").write_text(ROAD, encoding="utf-8")
    bodies = "".join(_body(name, kind) for name, (kind, *_) in OBJECTS.items())
    moves = "".join(_move(name, *rest) for name, (_, *rest) in OBJECTS.items())
    path = folder / "street.xosc"
    path.write_text(f"""<?xml version="1.0" encoding="UTF-8"?>
<OpenSCENARIO>
  {HEAD}
  <CatalogLocations/>
  <RoadNetwork><LogicFile filepath="street.xodr"/></RoadNetwork>
  <Entities>{_body("Ego", "car")}{bodies}</Entities>
  <Storyboard>
    <Init><Actions>{_move("Ego", 10.0, -1.75, 0.0, 6.0)}{moves}</Actions></Init>
    <StopTrigger><ConditionGroup><Condition name="end" delay="0" conditionEdge="none">
      <ByValueCondition><SimulationTimeCondition value="{seconds:g}" rule="greaterThan"/></ByValueCondition>
    </Condition></ConditionGroup></StopTrigger>
  </Storyboard>
</OpenSCENARIO>
""", encoding="utf-8")  # fmt: skip
    return path


def _body(name: str, kind: str) -> str:
    length, width, height = KINDS[kind]
    ahead = 1.3 if kind == "car" else 0.0
    box = (
        f'<BoundingBox><Center x="{ahead}" y="0" z="{height / 2}"/>'
        f'<Dimensions width="{width}" length="{length}" height="{height}"/></BoundingBox>'
    )
    if kind == "pedestrian":
        what = f'<Pedestrian name="{name}" pedestrianCategory="pedestrian" mass="75">{box}</Pedestrian>'
    else:
        what = f"""<Vehicle name="{name}" vehicleCategory="{kind}" mass="{1200 if kind == "car" else 90}">{box}
        <Performance maxSpeed="40" maxAcceleration="4" maxDeceleration="8"/>
        <Axles><FrontAxle maxSteering="0.5" wheelDiameter="0.6" trackWidth="1.5" positionX="2.6" positionZ="0.3"/>
        <RearAxle maxSteering="0" wheelDiameter="0.6" trackWidth="1.5" positionX="0" positionZ="0.3"/></Axles>
        </Vehicle>"""
    return f'<ScenarioObject name="{name}">{what}</ScenarioObject>'


def _move(name: str, x: float, y: float, heading: float, speed: float) -> str:
    return f"""<Private entityRef="{name}">
      <PrivateAction><TeleportAction><Position><WorldPosition x="{x}" y="{y}" h="{heading}"/></Position>
      </TeleportAction></PrivateAction>
      <PrivateAction><LongitudinalAction><SpeedAction>
        <SpeedActionDynamics dynamicsShape="step" value="0" dynamicsDimension="time"/>
        <SpeedActionTarget><AbsoluteTargetSpeed value="{speed}"/></SpeedActionTarget>
      </SpeedAction></LongitudinalAction></PrivateAction></Private>"""
