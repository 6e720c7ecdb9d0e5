"""VisibilityAction: hidden from the ego's sensors, and there for everything else. Sensors are those of the twin."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest

from pytest_dvp.drive.run import run
from tests.unit.harness.conftest import OneTrick, coast
from vehicle.adapters.mirror import Parallel
from vehicle.messages import Observation, Surroundings, VehicleState
from vehicle.model.model_file import read_model
from vehicle.sensors import Mount, default_sensors
from vehicle.twin import Twin
from vehicle.wire import convert

Write = Callable[..., Path]

CAR = """<Vehicle name="t" vehicleCategory="car" mass="1000">
  <BoundingBox><Center x="1.5" y="0" z="0.75"/><Dimensions width="2" length="4" height="1.5"/></BoundingBox>
  <Performance maxSpeed="30" maxAcceleration="3" maxDeceleration="6"/>
  <Axles>
    <FrontAxle maxSteering="0.5" wheelDiameter="0.6" trackWidth="1.5" positionX="2.6" positionZ="0.3"/>
    <RearAxle maxSteering="0" wheelDiameter="0.6" trackWidth="1.5" positionX="0" positionZ="0.3"/>
  </Axles></Vehicle>"""
BOX = (
    '<BoundingBox><Center x="0" y="0" z="0.9"/><Dimensions width="0.8" length="0.8" height="1.8"/></BoundingBox>'
    "<Properties/>"
)
WALKER = f'<Pedestrian name="p" mass="80" model="p" pedestrianCategory="pedestrian">{BOX}</Pedestrian>'
THING = f'<MiscObject name="m" mass="50" miscObjectCategory="obstacle">{BOX}</MiscObject>'


def show(sensors: bool, *named: str, traffic: bool = True) -> str:
    inner = "".join(f'<SensorReference name="{name}"/>' for name in named)
    references = f"<SensorReferenceSet>{inner}</SensorReferenceSet>" if named else ""
    return (
        f'<PrivateAction><VisibilityAction graphics="true" sensors="{str(sensors).lower()}" '
        f'traffic="{str(traffic).lower()}">{references}</VisibilityAction></PrivateAction>'
    )


def event(time: float, action: str) -> str:
    return (
        f'<Event name="e{time}" priority="parallel"><Action name="a{time}">{action}</Action><StartTrigger>'
        f'<ConditionGroup><Condition name="c" delay="0" conditionEdge="none"><ByValueCondition>'
        f'<SimulationTimeCondition value="{time}" rule="greaterOrEqual"/></ByValueCondition></Condition>'
        "</ConditionGroup></StartTrigger></Event>"
    )


def written(scenario: Write, entity: str, *events: str, init: str = "", at: float = 30.0, stop: float = 3.0) -> Path:
    """The ego, and what is `at` [m] on its lane."""
    place = (
        f'<Private entityRef="Target"><PrivateAction><TeleportAction><Position><LanePosition roadId="1" laneId="-1" '
        f's="{at}"/></Position></TeleportAction></PrivateAction>{init}</Private></Actions></Init>'
    )
    story = (
        '<Story name="s"><Act name="a"><ManeuverGroup name="g" maximumExecutionCount="1">'
        '<Actors selectTriggeringEntities="false"><EntityRef entityRef="Target"/></Actors>'
        f'<Maneuver name="m">{"".join(events)}</Maneuver></ManeuverGroup><StartTrigger/></Act></Story>'
    )
    return scenario(
        ("</Entities>", f'<ScenarioObject name="Target">{entity}</ScenarioObject></Entities>'),
        ("</Actions></Init>", place + (story if events else "")),
        ('value="3" rule="greaterThan"', f'value="{stop}" rule="greaterThan"'),
    )


def seen(driver: OneTrick, low: float, high: float) -> tuple[bool, bool]:
    """Whether scans and frames taken between the times [s] show anything on the empty road."""
    scans = [o.lidar for o in driver.seen if o.lidar is not None and low <= o.lidar.t <= high]
    frames = [o.camera for o in driver.seen if o.camera is not None and low <= o.camera.t <= high]
    assert scans
    assert frames
    return any(len(scan.points) for scan in scans), any(frame.boxes for frame in frames)


@pytest.mark.parametrize("entity", [CAR, WALKER, THING], ids=["vehicle", "pedestrian", "misc"])
def test_what_is_hidden_is_neither_scanned_nor_filmed_until_it_is_shown_again(scenario: Write, entity: str) -> None:
    driver = OneTrick(coast)
    path = written(scenario, entity, event(1.0, show(False)), event(2.0, show(True)))
    result = run(path, ads=driver)
    assert seen(driver, 0.0, 0.9) == (True, True)
    assert seen(driver, 1.2, 1.9) == (False, False)
    assert seen(driver, 2.2, 3.0) == (True, True)
    assert not [note for note in result.notes if "Visibility" in note]
    truth = result.log.objects["Target"].t  # the log knows of it all the time
    assert (truth[0], truth[-1]) == (0.0, pytest.approx(result.log.duration, abs=0.06))
    assert np.diff(truth).max() < 0.11


def test_a_set_of_sensors_concerns_those_alone(scenario: Write) -> None:
    driver = OneTrick(coast)
    events = (
        event(1.0, show(False, "Camera")),
        event(2.0, show(False)),
        event(3.0, show(True, "lidar")),
        event(4.0, show(True)),
    )
    run(written(scenario, CAR, *events, at=60.0, stop=5.0), ads=driver)
    assert seen(driver, 0.0, 0.9) == (True, True)
    assert seen(driver, 1.2, 1.9) == (True, False)
    assert seen(driver, 2.2, 2.9) == (False, False)
    assert seen(driver, 3.2, 3.9) == (True, False)
    assert seen(driver, 4.2, 5.0) == (True, True)


def test_what_is_hidden_from_the_start_is_still_hit_and_measured(scenario: Write) -> None:
    driver = OneTrick(coast)
    result = run(written(scenario, CAR, init=show(False), at=17.0, stop=9.0), ads=driver, duration=3.0)
    assert seen(driver, 0.0, 3.0) == (False, False)
    assert result.metrics["collision"] == 1
    assert [verdict.object for verdict in result.verdicts if verdict.metric == "collision"] == ["Target"]


def around(*hidden: str) -> Surroundings:
    boxes = np.array([[20.0, 0.0, 0.75, 0.0, 4.0, 2.0, 1.5, 0.0, 0.0]])
    return Surroundings(
        boxes, np.zeros(1, dtype=np.int64), ("Target",), (), {each: frozenset({"Target"}) for each in hidden}
    )


@pytest.mark.parametrize("hidden", [(), ("lidar",), ("camera",), ("lidar", "camera")])
def test_a_mirrored_car_does_not_see_it_either(hidden: tuple[str, ...], scenarios_dir: Path) -> None:
    vehicle = Parallel(Twin(read_model(scenarios_dir / "models" / "tabby_evo.toml"), default_sensors()), seed=1)
    vehicle.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    observations: list[Observation] = []
    for _ in range(20):
        observations.append(vehicle.observe(around(*hidden)))
        vehicle.step(0.05)
    assert any(o.lidar is not None and len(o.lidar.points) for o in observations) is ("lidar" not in hidden)
    assert any(o.camera is not None and len(o.camera.boxes) for o in observations) is ("camera" not in hidden)


@pytest.mark.parametrize("hidden", [(), ("lidar",), ("lidar", "camera")])
def test_the_wire_carries_who_is_hidden_from_what(hidden: tuple[str, ...]) -> None:
    sent = around(*hidden)
    back = convert.objects_from_ros(convert.objects_to_ros(sent, 0))
    assert back.hidden == sent.hidden
    assert msgspec.structs.asdict(back)["names"] == ("Target",)


@pytest.mark.parametrize("mount", [Mount(1.0, 0.0, 1.5), Mount(1.0, 0.5, 1.5, 0.3), Mount(1.0, -0.4, 1.5, -1.2)])
def test_a_mirrored_car_sees_virtual_objects_where_they_are_however_its_lidar_looks(
    mount: Mount, scenarios_dir: Path
) -> None:
    """The rear of the object stands 18 m ahead, from 1 m right to 1 m left."""
    sensors = default_sensors()
    sensors = dataclasses.replace(sensors, lidar=dataclasses.replace(sensors.lidar, mount=mount))
    vehicle = Parallel(Twin(read_model(scenarios_dir / "models" / "tabby_evo.toml"), sensors), seed=1)
    vehicle.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    seen_points: list[np.ndarray] = []
    for _ in range(20):
        scan = vehicle.observe(around()).lidar
        seen_points += [scan.points] if scan is not None and len(scan.points) else []
        vehicle.step(0.05)
    points = np.vstack(seen_points)
    c, s = np.cos(mount.yaw), np.sin(mount.yaw)
    x, y = mount.x + c * points[:, 0] - s * points[:, 1], mount.y + s * points[:, 0] + c * points[:, 1]
    assert x.min() == pytest.approx(18.0, abs=0.2)
    assert np.abs(y).max() == pytest.approx(1.0, abs=0.3)
