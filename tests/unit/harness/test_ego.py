"""Which entity is the ego, with which body and dynamics, and what its task is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from openscenario.findings import ScenarioError
from openscenario.read import read_scenario
from pytest_dvp.drive.ego_model import fitted_model
from pytest_dvp.drive.ego_task import find_ego
from pytest_dvp.drive.run import run
from tests.unit.harness.conftest import OneTrick, coast
from vehicle.model.bus import GRAVITY

Write = Callable[..., Path]
RENAMED = (('name="Ego"', 'name="Car7"'), ('entityRef="Ego"', 'entityRef="Car7"'))
CONTROLLED = (
    "      </Vehicle>\n    </ScenarioObject>",
    '      </Vehicle>\n      <ObjectController><Controller name="c"><Properties/></Controller></ObjectController>\n'
    "    </ScenarioObject>",
)
ACQUIRE = """
      <PrivateAction><RoutingAction><AcquirePositionAction><Position>
        <LanePosition roadId="1" laneId="-1" s="100"/>
      </Position></AcquirePositionAction></RoutingAction></PrivateAction>
    </Private>"""


@pytest.mark.parametrize("name", ["Ego", "ego", "EGO"])
def test_ego_in_any_case_is_the_ego(scenario: Write, name: str) -> None:
    path = scenario(('name="Ego"', f'name="{name}"'), ('entityRef="Ego"', f'entityRef="{name}"'))
    assert find_ego(read_scenario(path), None).name == name


def test_another_name_can_be_chosen(scenario: Write) -> None:
    assert find_ego(read_scenario(scenario(*RENAMED)), "Car7").name == "Car7"


def test_the_only_controlled_entity_is_the_ego(scenario: Write) -> None:
    assert find_ego(read_scenario(scenario(*RENAMED, CONTROLLED)), None).name == "Car7"


def test_without_name_and_controller_there_is_no_ego(scenario: Write) -> None:
    with pytest.raises(ScenarioError, match=r"no entity is called Ego.*--ego: Car7"):
        find_ego(read_scenario(scenario(*RENAMED)), None)


def test_an_unknown_name_comes_with_the_nearest(scenario: Write) -> None:
    with pytest.raises(ScenarioError, match="did you mean 'Ego'"):
        find_ego(read_scenario(scenario()), "Egon")


def test_acquire_position_is_the_goal(scenario: Write) -> None:
    log = run(scenario(("</Private>", ACQUIRE)), ads=OneTrick(coast), duration=0.2).log
    assert log.meta["task"]["goal"] == {"road": "1", "lane": -1, "s": 100.0}
    assert log.reference[-1] == pytest.approx([100.0, -1.75])


def test_the_goal_of_the_gate_file_wins(scenario: Write) -> None:
    path = scenario(("</Private>", ACQUIRE))
    path.with_name("x.gates.toml").write_text(
        '[task]\ngoal = { road = "1", lane = -1, s = 50.0 }\n[[gate]]\nmetric = "collision"\nmax = 0\n'
    )
    assert run(path, ads=OneTrick(coast), duration=0.2).log.meta["task"]["goal"]["s"] == 50.0


@pytest.mark.parametrize(
    ("place", "says"),
    [('{ road = "9", lane = -1, s = 5.0 }', "9"), ('{ road = "1", lane = -3, s = 5.0 }', "lane -3"),
     ('{ road = "1", lane = 1, s = 5.0 }', "no way leads")],
)  # fmt: skip
def test_a_goal_off_the_road_or_out_of_reach_is_an_error(scenario: Write, place: str, says: str) -> None:
    path = scenario()
    path.with_name("x.gates.toml").write_text(f'[task]\ngoal = {place}\n[[gate]]\nmetric = "collision"\nmax = 0\n')
    with pytest.raises(ScenarioError, match=says):
        run(path, ads=OneTrick(coast))


def test_without_a_goal_the_reference_is_the_lane_to_its_end(scenario: Write) -> None:
    log = run(scenario(), ads=OneTrick(coast), duration=0.2).log
    assert log.meta["task"]["goal"] is None
    assert log.reference[0] == pytest.approx([10.0, -1.75])
    assert log.reference[-1] == pytest.approx([1000.0, -1.75], abs=1.0)


def test_the_car_of_the_model_keeps_its_dynamics(scenario: Write) -> None:
    model, about = fitted_model(None, find_ego(read_scenario(scenario()), None))
    assert about["scaled"] is False
    assert (model.car.mass, model.car.wheelbase) == (730.0, 2.36)


def test_the_body_is_always_the_scenarios(scenario: Write) -> None:
    path = scenario(('length="3.03"', 'length="3.2"'), ('<Center x="1.18"', '<Center x="1.2"'))
    model, _ = fitted_model(None, find_ego(read_scenario(path), None))
    assert (model.car.length, model.car.center_x) == (3.2, 1.2)


def test_another_car_gets_a_scaled_model_and_the_log_says_so(scenario: Write) -> None:
    path = scenario(
        ('mass="730"', 'mass="1460"'),
        ('positionX="2.36"', 'positionX="2.95"'),
        ('maxSteering="0.349"', 'maxSteering="0.5"'),
        (
            'maxSpeed="30" maxAcceleration="3" maxDeceleration="6"',
            'maxSpeed="60" maxAcceleration="4" maxDeceleration="9"',
        ),
    )
    model, about = fitted_model(None, find_ego(read_scenario(path), None))
    assert about.pop("sha256")
    assert about == {
        "name": "TABBY EVO", "file": "tabby_evo.toml", "scaled": True, "wheelbase": 2.95, "mass": 1460.0, "to": "car"
    }  # fmt: skip
    assert (model.car.mass, model.car.wheelbase, model.car.max_speed) == (1460.0, 2.95, 60.0)
    assert model.car.yaw_inertia == pytest.approx(850.0 * 2 * 1.25**2)
    description = model.description()
    assert description.max_steer == 0.5
    assert description.max_deceleration == 9.0
    assert description.max_acceleration == pytest.approx(4.0, rel=0.02)  # less what the motor's inertia takes


@pytest.mark.parametrize(("mass", "wheelbase"), [(871.0, 2.95), (1056.0, 2.71), (1352.0, 2.59)])
def test_a_scaled_car_of_unknown_tyres_has_stiff_axles_still(
    scenario: Write, tmp_path: Path, mass: float, wheelbase: float
) -> None:
    """A kinematic car of which no tyres are known: 48/rad of the load of each axle, here half of the new mass."""
    path = scenario(('mass="730"', f'mass="{mass}"'), ('positionX="2.36"', f'positionX="{wheelbase}"'))
    bare = tmp_path / "bare.toml"
    bare.write_text('[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.36\nmass = 730.0\n')
    model, about = fitted_model(bare, find_ego(read_scenario(path), None))
    assert about["scaled"] is True
    assert model.car.stiffness(stiff=True) == pytest.approx((48.0 * 0.5 * mass * GRAVITY,) * 2)


def test_the_scaled_motor_pulls_at_the_files_top_speed(scenario: Write) -> None:
    path = scenario(('mass="730"', 'mass="1460"'), ('maxSpeed="30"', 'maxSpeed="57"'))
    model, _ = fitted_model(None, find_ego(read_scenario(path), None))
    limit = model.value("motor_torque", "max_speed")
    assert limit is not None
    assert limit * model.car.wheel_radius / model.car.gear_ratio == pytest.approx(57.0, rel=0.02)


ROUTE_EVENT = """</Init>
    <Story name="s"><Act name="a"><ManeuverGroup name="g" maximumExecutionCount="1">
      <Actors selectTriggeringEntities="false"><EntityRef entityRef="Ego"/></Actors>
      <Maneuver name="m"><Event name="e" priority="parallel" maximumExecutionCount="1">
        <Action name="go"><PrivateAction><RoutingAction><AcquirePositionAction><Position>
          <LanePosition roadId="1" laneId="-1" s="GOAL"/>
        </Position></AcquirePositionAction></RoutingAction></PrivateAction></Action>
        <StartTrigger><ConditionGroup><Condition name="c" delay="0" conditionEdge="none"><ByValueCondition>
          <SimulationTimeCondition value="1" rule="greaterThan"/>
        </ByValueCondition></Condition></ConditionGroup></StartTrigger>
      </Event></Maneuver>
    </ManeuverGroup></Act></Story>"""


def test_a_route_under_way_reaches_the_stack_as_a_new_task(scenario: Write) -> None:
    stack = OneTrick(coast)
    log = run(scenario(("</Init>", ROUTE_EVENT.replace("GOAL", "200"))), ads=stack, duration=2.0).log
    assert [o.task.goal for o in stack.seen if o.task is not None] == [None, ("1", -1, 200.0)]
    assert [event.element for event in log.events if event.kind == "request"] == ["route"]


def test_a_route_that_nobody_could_drive_is_refused_in_the_log(scenario: Write) -> None:
    stack = OneTrick(coast)
    log = run(scenario(("</Init>", ROUTE_EVENT.replace("GOAL", "2"))), ads=stack, duration=2.0).log
    assert [o.task.goal for o in stack.seen if o.task is not None] == [None]
    (request,) = [event for event in log.events if event.kind == "request"]
    assert request.text.startswith("refused: no way leads")


def test_the_stack_drives_on_after_a_refused_route(scenario: Write) -> None:
    assert run(scenario(("</Init>", ROUTE_EVENT.replace("GOAL", "2")))).status == "PASS"
