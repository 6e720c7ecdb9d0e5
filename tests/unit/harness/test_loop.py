"""The closed loop: when a run ends, what it records, and what happens when the stack breaks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pytest_dvp.drive.run import run
from scenarios import path
from tests.unit.harness.conftest import OneTrick, coast
from vehicle.messages import Command, Observation, Task

Write = Callable[..., Path]

NO_STOP = (
    '<SimulationTimeCondition value="3" rule="greaterThan"/>',
    '<SimulationTimeCondition value="9e9" rule="greaterThan"/>',
)

STANDING_CAR = """
    <ScenarioObject name="Target"><Vehicle name="t" vehicleCategory="car" mass="1000">
      <BoundingBox><Center x="1.5" y="0" z="0.75"/><Dimensions width="2" length="4" height="1.5"/></BoundingBox>
      <Performance maxSpeed="30" maxAcceleration="3" maxDeceleration="6"/>
      <Axles>
        <FrontAxle maxSteering="0.5" wheelDiameter="0.6" trackWidth="1.5" positionX="2.6" positionZ="0.3"/>
        <RearAxle maxSteering="0" wheelDiameter="0.6" trackWidth="1.5" positionX="0" positionZ="0.3"/>
      </Axles>
    </Vehicle></ScenarioObject>
  </Entities>"""

PLACED_CAR = """
    <Private entityRef="Target"><PrivateAction><TeleportAction><Position>
      <LanePosition roadId="1" laneId="-1" s="30"/>
    </Position></TeleportAction></PrivateAction></Private>
    </Actions></Init>"""

WITH_TARGET = (("</Entities>", STANDING_CAR), ("</Actions></Init>", PLACED_CAR))


def kinds(result: object) -> list[str]:
    return [event.kind for event in result.log.events]  # type: ignore[attr-defined]


def test_the_stop_trigger_ends_the_run(scenario: Write) -> None:
    result = run(scenario(), ads=OneTrick(coast))
    assert result.ending == "stop"
    assert result.log.duration == pytest.approx(3.05, abs=0.06)


def test_the_duration_ends_the_run(scenario: Write) -> None:
    result = run(scenario(NO_STOP), duration=2.0, ads=OneTrick(coast))
    assert (result.ending, result.log.duration) == ("timeout", pytest.approx(2.0))


def test_a_run_that_only_the_duration_ended_does_not_pass_the_default_gates(scenario: Write) -> None:
    result = run(scenario(NO_STOP), duration=1.0, ads=OneTrick(coast))
    assert result.status == "FAIL"
    assert [v.metric for v in result.verdicts if v.status == "FAIL"] == ["scenario_ended"]


def test_traffic_of_the_storyboard_is_in_the_log_as_it_comes(scenario: Write) -> None:
    """A car every 4 s: two of them within 5 s."""
    source = (
        '<GlobalAction><TrafficAction trafficName="flow"><TrafficSourceAction rate="0.25" radius="1" velocity="10">'
        '<Position><LanePosition roadId="1" laneId="-1" s="60"/></Position></TrafficSourceAction></TrafficAction>'
        "</GlobalAction></Actions></Init>"
    )
    result = run(scenario(NO_STOP, ("</Actions></Init>", source)), duration=5.0, ads=OneTrick(coast))
    assert set(result.log.objects) == {"flow-1", "flow-2"}


def test_the_wall_limit_is_an_error(scenario: Write) -> None:
    result = run(scenario(NO_STOP), wall_limit=0.0, ads=OneTrick(coast))
    assert (result.ending, result.status) == ("wall", "ERROR")
    assert "wall limit" in result.verdicts[0].short


def test_the_stack_ticks_at_20_hz_from_zero_on(scenario: Write) -> None:
    stack = OneTrick(coast)
    run(scenario(NO_STOP), duration=0.5, ads=stack)
    assert [o.t for o in stack.seen] == pytest.approx(np.arange(10) * 0.05)


def test_the_log_has_100_rows_a_second(scenario: Write) -> None:
    log = run(scenario(NO_STOP), duration=1.0, ads=OneTrick(coast)).log
    assert log.t == pytest.approx(np.arange(101) * 0.01)


def test_the_ego_starts_where_and_as_fast_as_init_says(scenario: Write) -> None:
    log = run(scenario(NO_STOP), duration=0.1, ads=OneTrick(coast)).log
    assert [log[name][0] for name in ("x", "y", "yaw", "v")] == pytest.approx([10.0, -1.75, 0.0, 5.0])


def test_the_set_speed_reaches_the_stack_once(scenario: Write) -> None:
    stack = OneTrick(coast)
    run(scenario(NO_STOP), duration=0.5, ads=stack)
    assert [o.task for o in stack.seen] == [Task(set_speed=5.0), *[None] * 9]


def test_a_parameter_given_by_name_changes_the_run(scenario: Write) -> None:
    log = run(scenario(NO_STOP), duration=0.1, parameters={"ego_speed": 3.0}, ads=OneTrick(coast)).log
    assert log["v"][0] == pytest.approx(3.0)
    assert log.meta["parameters"] == {"ego_speed": "3"}


def test_a_stack_that_raises_is_an_error_with_its_log_so_far(scenario: Write) -> None:
    def breaks(observation: Observation) -> Command:
        if observation.t >= 1.0:
            raise IndexError("list index out of range")
        return coast(observation)

    result = run(scenario(), ads=OneTrick(breaks))
    assert (result.ending, result.status) == ("fault", "ERROR")
    assert result.log.duration == pytest.approx(1.0)
    assert result.verdicts[0].short == "run ERROR: IndexError: list index out of range at t=1.00 s"
    assert result.error is not None
    assert "breaks" in result.error


@pytest.mark.parametrize("field", ["steer", "accel", "throttle", "brake"])
def test_a_command_that_is_not_finite_is_an_error(scenario: Write, field: str) -> None:
    values = {"steer": 0.0, "accel": 0.0, "throttle": 0.0, "brake": 0.0, field: float("nan")}
    result = run(scenario(), ads=OneTrick(lambda o: Command(o.t, **values)))
    assert result.status == "ERROR"
    assert field in result.verdicts[0].short


def test_a_collision_is_recorded_and_ends_the_run_one_second_later(scenario: Write) -> None:
    # front at 10 + 1.18 + 1.515 = 12.695 m, the target's rear at 30 + 1.5 - 2 = 29.5 m: 3.36 s at 5 m/s, or longer
    result = run(scenario(NO_STOP, *WITH_TARGET), ads=OneTrick(coast))
    (hit,) = [event for event in result.log.events if event.kind == "collision"]
    assert hit.element == "Target"
    assert 3.36 < hit.t < 4.0
    assert result.log.duration == pytest.approx(hit.t + 1.0, abs=0.051)
    assert result.ending == "collision"


def test_how_long_a_run_goes_on_after_a_collision_can_be_set(scenario: Write) -> None:
    result = run(scenario(NO_STOP, *WITH_TARGET), after_collision=0.0, ads=OneTrick(coast))
    (hit,) = [event for event in result.log.events if event.kind == "collision"]
    assert result.log.duration == pytest.approx(hit.t, abs=0.051)


def test_the_collision_gate_names_what_was_hit(scenario: Write) -> None:
    result = run(scenario(NO_STOP, *WITH_TARGET), ads=OneTrick(coast))
    (verdict,) = [v for v in result.verdicts if v.metric == "collision"]
    assert (verdict.status, verdict.object) == ("FAIL", "Target")


def test_the_goal_ends_the_run_when_the_ego_stands_there(scenario: Write) -> None:
    path = scenario(NO_STOP)
    gates = path.with_name("x.gates.toml")
    gates.write_text('[task]\ngoal = { road = "1", lane = -1, s = 20.0 }\n[[gate]]\nmetric = "goal_reached"\nmin = 1\n')
    result = run(path, ads=OneTrick(lambda o: Command(o.t, 0.0, -2.0, 0.0, 0.4) if o.t > 0.5 else coast(o)))
    assert result.ending == "goal"
    assert abs(result.log["v"][-1]) < 0.05
    assert result.status == "PASS"


def test_leaving_the_road_is_measured(scenario: Write) -> None:
    result = run(scenario(), ads=OneTrick(lambda o: Command(o.t, 0.2, 0.0, 0.0, 0.0)))
    (verdict,) = [v for v in result.verdicts if v.metric == "road_departure"]
    assert verdict.status == "FAIL"


def test_no_gate_judged_is_never_a_pass(scenario: Write) -> None:
    path = scenario()
    path.with_name("x.gates.toml").write_text('[[gate]]\nmetric = "goal_reached"\nmin = 1\nstages = ["rw"]\n')
    assert run(path, ads=OneTrick(coast)).status == "INCONCLUSIVE"


def test_nothing_in_the_log_tells_the_machine(scenario: Write, tmp_path: Path) -> None:
    result = run(scenario(*WITH_TARGET), ads=OneTrick(coast))
    assert str(tmp_path) not in repr(result.log.meta) + repr(result.log.events)


def test_who_drives_from_the_beginning_has_its_velocity_from_the_beginning(tmp_path: Path) -> None:
    """The lead of follow.xosc begins at 4 m/s to the east: no time to collision is measured against a standing one."""
    file = path("follow.xosc")
    values: dict[str, str | float | bool] = {"lead_speed": 4.0, "ego_speed": 4.0}
    lead = run(file, rootdir=file.parent, duration=0.2, parameters=values, log_dir=tmp_path).log.objects["Lead"]
    np.testing.assert_allclose(np.hypot(lead.vx, lead.vy), 4.0, rtol=1e-3)
