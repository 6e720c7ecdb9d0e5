"""When conditions become true, on a straight road where the time can be computed by hand."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from openscenario.road.network import load_network

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

STEP = 0.01
TICK = speed(1.0)


def fires(make: Make, test: str, *, edge: str = "none", seconds: float = 12.0, b: float = 200.0) -> float | None:
    """Time at which an event on `test` starts; A drives at 10 m/s from s = 100, B stands at s = b."""
    board = make(
        A=[teleport(lane_position(100.0)), speed(10.0)],
        B=[teleport(lane_position(b))],
        stories=story(event("e", TICK, start=group(condition(test, edge=edge)))),
    )
    run(board, seconds)
    return next((each[0] for each in log(board, "event") if each[2] == "startTransition"), None)


def of_a(test: str) -> str:
    return by_entity(test, "A")


@pytest.mark.parametrize(
    ("test", "expected"),
    [
        # reference points are 100 m apart and A's front is 4 m ahead of its own, B's rear 1 m behind its own
        ('<RelativeDistanceCondition entityRef="B" relativeDistanceType="longitudinal" freespace="{f}" rule="lessThan" '
         'value="40" coordinateSystem="entity"/>', {"false": 6.0, "true": 5.5}),
        ('<RelativeDistanceCondition entityRef="B" relativeDistanceType="longitudinal" freespace="{f}" rule="lessThan" '
         'value="40" coordinateSystem="road"/>', {"false": 6.0, "true": 5.5}),
        ('<RelativeDistanceCondition entityRef="B" relativeDistanceType="euclidianDistance" freespace="{f}" '
         'rule="lessThan" value="40"/>', {"false": 6.0, "true": 5.5}),
        ('<TimeHeadwayCondition entityRef="B" freespace="{f}" rule="lessThan" value="3" coordinateSystem="road" '
         'relativeDistanceType="longitudinal"/>', {"false": 7.0, "true": 6.5}),
        ('<TimeToCollisionCondition freespace="{f}" rule="lessThan" value="2" coordinateSystem="entity" '
         'relativeDistanceType="longitudinal"><TimeToCollisionConditionTarget><EntityRef entityRef="B"/>'
         "</TimeToCollisionConditionTarget></TimeToCollisionCondition>", {"false": 8.0, "true": 7.5}),
    ],
)  # fmt: skip
@pytest.mark.parametrize("freespace", ["false", "true"])
def test_distance_conditions(make: Make, test: str, expected: dict[str, float], freespace: str) -> None:
    assert fires(make, of_a(test.format(f=freespace))) == pytest.approx(expected[freespace], abs=2 * STEP)


def test_reach_position_fires_at_its_tolerance(make: Make) -> None:
    test = f'<ReachPositionCondition tolerance="5"><Position>{lane_position(160.0)}</Position></ReachPositionCondition>'
    assert fires(make, of_a(test)) == pytest.approx(5.5, abs=STEP)


def test_distance_to_a_position(make: Make) -> None:
    test = (
        '<DistanceCondition freespace="false" rule="lessThan" value="20" coordinateSystem="entity" '
        f'relativeDistanceType="longitudinal"><Position>{lane_position(160.0)}</Position></DistanceCondition>'
    )
    assert fires(make, of_a(test)) == pytest.approx(4.0, abs=2 * STEP)


def test_travelled_distance(make: Make) -> None:
    assert fires(make, of_a('<TraveledDistanceCondition value="33"/>')) == pytest.approx(3.3, abs=STEP)


def test_stand_still_counts_from_the_start(make: Make) -> None:
    assert fires(make, by_entity('<StandStillCondition duration="2"/>', "B")) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("external", "v", "since"),
    [(False, 9e-4, 3.0), (False, 1.1e-3, math.inf), (True, 0.099, 3.0), (True, -0.099, 3.0), (True, 0.101, math.inf)],
)
def test_an_ego_whose_speed_is_measured_stands_below_a_tenth_of_a_metre_per_second(
    make: Make, external: bool, v: float, since: float
) -> None:
    entity = make(A=[teleport(lane_position(100.0))]).entities["A"]
    entity.external, entity.speed, entity.still_since = external, v, math.inf
    entity.note_rest(3.0)
    entity.note_rest(4.0)
    assert entity.still_since == since


def test_speed_holds_at_once(make: Make) -> None:
    assert fires(make, of_a('<SpeedCondition rule="greaterThan" value="9.9"/>')) == 0.0


def test_relative_speed(make: Make) -> None:
    assert fires(make, of_a('<RelativeSpeedCondition entityRef="B" rule="equalTo" value="10"/>')) == 0.0


TO_B = '<TimeToCollisionConditionTarget><EntityRef entityRef="B"/></TimeToCollisionConditionTarget>'
COLLIDES = (
    f'<TimeToCollisionCondition freespace="false" rule="lessThan" value="100" {{}}>{TO_B}</TimeToCollisionCondition>'
)
FASTER = '<RelativeSpeedCondition entityRef="B" rule="{}" value="5" direction="longitudinal"/>'


@pytest.mark.parametrize(
    ("test", "edge", "expected"),
    [
        # A comes nearer at 10 m/s from 100 m away: 10 s before they collide, from t = 0 on
        (COLLIDES.format('coordinateSystem="road" relativeDistanceType="longitudinal"'), "none", 0.0),
        (COLLIDES.format('coordinateSystem="entity" relativeDistanceType="euclidianDistance"'), "none", 0.0),
        (COLLIDES.format('coordinateSystem="road" relativeDistanceType="longitudinal"'), "rising", None),
        (FASTER.format("greaterThan"), "none", 0.0),
        (FASTER.format("greaterThan"), "rising", None),
        (FASTER.format("lessThan"), "none", None),
    ],
)
def test_at_the_start_everybody_moves_with_the_speed_that_init_gave(
    make: Make, test: str, edge: str, expected: float | None
) -> None:
    assert fires(make, of_a(test), edge=edge, seconds=5.0) == expected


def test_collision_is_contact_of_the_boxes(make: Make) -> None:
    # A's front is at 104, B's rear at 199
    test = '<CollisionCondition><EntityRef entityRef="B"/></CollisionCondition>'
    assert fires(make, of_a(test)) == pytest.approx(9.5, abs=2 * STEP)


def test_end_of_road_counts_from_standing_there(make: Make) -> None:
    board = make(
        A=[teleport(lane_position(990.0)), speed(10.0)],
        stories=story(event("e", TICK, start=group(condition(of_a('<EndOfRoadCondition duration="1"/>'))))),
    )
    run(board, 4.0)
    started = [each[0] for each in log(board, "event") if each[2] == "startTransition"]
    assert started == [pytest.approx(2.0, abs=2 * STEP)]


def test_off_road(make: Make) -> None:
    board = make(
        A=[teleport('<WorldPosition x="100" y="-20"/>')],
        stories=story(event("e", TICK, start=group(condition(of_a('<OffroadCondition duration="0.5"/>'))))),
    )
    run(board, 1.0)
    assert (0.5, "e", "startTransition") in log(board, "event")


def test_the_rule_all_needs_every_entity(make: Make) -> None:
    test = by_entity('<SpeedCondition rule="greaterThan" value="5"/>', "A", "B", rule="all")
    assert fires(make, test, seconds=1.0) is None


def test_a_headway_to_something_behind_is_not_defined(make: Make) -> None:
    test = (
        '<TimeHeadwayCondition entityRef="B" freespace="false" rule="greaterThan" value="1" coordinateSystem="road" '
        'relativeDistanceType="longitudinal"/>'
    )
    assert fires(make, of_a(test), b=50.0, seconds=5.0) is None


def test_triggering_entities_become_the_actors(make: Make) -> None:
    test = by_entity('<SpeedCondition rule="greaterThan" value="5"/>', "A", "B")
    board = make(
        A=[teleport(lane_position(100.0)), speed(10.0)],
        B=[teleport(lane_position(200.0))],
        stories=story(event("e", speed(3.0), start=group(condition(test))), select=True),
    )
    run(board, 0.1)
    assert (board.entities["A"].speed, board.entities["B"].speed) == (3.0, 0.0)


@pytest.mark.parametrize(("rule", "value", "expected"), [("equalTo", "1", 0.0), ("greaterThan", "1", None)])
def test_variables_compare_as_numbers(make: Make, rule: str, value: str, expected: float | None) -> None:
    test = f'<ByValueCondition><VariableCondition variableRef="v" rule="{rule}" value="{value}"/></ByValueCondition>'
    assert fires(make, test, seconds=0.5) == expected


def test_a_speed_that_went_up_in_steps_meets_its_target(make: Make) -> None:
    """Ten steps of a tenth are not quite one; equal means within rounding."""
    ramp = event("ramp", speed(10.1, "linear", "time", 1.0), start=group(condition(at_time(0.0))))
    test = of_a('<SpeedCondition rule="equalTo" value="10.1"/>')
    board = make(
        A=[teleport(lane_position(100.0)), speed(10.0)],
        stories=story(ramp, event("e", TICK, start=group(condition(test)))),
    )
    board.entities["A"].max_speed = 10.1 - 1e-9
    run(board, 1.5)
    assert [each[0] for each in log(board, "event") if each[1:] == ("e", "startTransition")] == [pytest.approx(1.0)]


def test_who_cannot_be_reached_is_infinitely_far_away(make: Make, tmp_path: Path) -> None:
    """B stands on a road of its own, 500 m beside."""
    first = XODR[XODR.index("<road ") : XODR.index("</OpenDRIVE>")]
    second = first.replace('id="1" junction', 'id="9" junction').replace('y="0" hdg', 'y="500" hdg')
    (tmp_path / "two.xodr").write_text(XODR.replace("</OpenDRIVE>", f"{second}</OpenDRIVE>"))
    test = (
        '<RelativeDistanceCondition entityRef="B" relativeDistanceType="longitudinal" freespace="false" rule="{}" '
        'value="400" coordinateSystem="road"/>'
    )
    more, less = (group(condition(of_a(test.format(rule)))) for rule in ("greaterThan", "lessThan"))
    board = make(
        A=[teleport(lane_position(100.0)), speed(10.0)],
        B=[teleport('<WorldPosition x="100" y="498.25"/>')],
        stories=story(event("more", TICK, start=more), event("less", TICK, start=less)),
        on=load_network(tmp_path / "two.xodr"),
    )
    run(board, 1.0)
    assert [each[1] for each in log(board, "event") if each[2] == "startTransition"] == ["more"]


def test_nothing_holds_of_who_has_been_deleted(make: Make) -> None:
    delete = '<GlobalAction><EntityAction entityRef="B"><DeleteEntityAction/></EntityAction></GlobalAction>'
    tests = (
        '<RelativeDistanceCondition entityRef="B" relativeDistanceType="longitudinal" freespace="false" '
        'rule="greaterThan" value="1" coordinateSystem="entity"/>',
        '<RelativeSpeedCondition entityRef="B" rule="greaterThan" value="1"/>',
        '<TimeHeadwayCondition entityRef="B" freespace="false" rule="greaterThan" value="1" coordinateSystem="entity" '
        'relativeDistanceType="longitudinal"/>',
    )
    late = condition(at_time(1.0))
    events = [event(f"e{i}", TICK, start=group(late, condition(of_a(test)))) for i, test in enumerate(tests)]
    board = make(
        A=[teleport(lane_position(100.0)), speed(10.0)],
        B=[teleport(lane_position(200.0))],
        stories=story(event("delete", delete, start=group(condition(at_time(0.5)))), *events),
    )
    run(board, 2.0)
    assert [each[1] for each in log(board, "event") if each[2] == "startTransition"] == ["delete"]


@pytest.mark.parametrize("direction", ['direction="lateral" ', ""])
def test_acceleration_on_a_circle_is_v_squared_over_r(make: Make, tmp_path: Path, direction: str) -> None:
    """10 m/s in the lane of radius 100 + 1.75 m: 0.983 m/s^2 to the left."""
    (tmp_path / "arc.xodr").write_text(XODR.replace("<line/>", '<arc curvature="0.01"/>'))
    network = load_network(tmp_path / "arc.xodr")
    fired = {}
    for value in (0.97, 1.0):
        test = of_a(f'<AccelerationCondition {direction}rule="greaterThan" value="{value}"/>')
        board = make(
            A=[teleport(lane_position(100.0)), speed(10.0)],
            stories=story(event("e", TICK, start=group(condition(test)))),
            on=network,
        )
        run(board, 0.5)
        fired[value] = any(each[2] == "startTransition" for each in log(board, "event"))
    assert fired == {0.97: True, 1.0: False}


def test_the_entities_that_triggered_the_act_are_the_actors(make: Make) -> None:
    """7.3.1 (1.3): those whose states made true a condition of a condition group of the act that was true."""
    fast, slow = (f'<SpeedCondition rule="{rule}" value="5"/>' for rule in ("greaterThan", "lessThan"))
    never = condition(at_time(99.0))
    start = group(condition(by_entity(fast, "A", "B"))) + group(condition(by_entity(slow, "A", "B")), never)
    later = group(condition(by_entity(slow, "A", "B")))
    board = make(
        A=[teleport(lane_position(100.0)), speed(10.0)],
        B=[teleport(lane_position(200.0))],
        stories=story(event("e", speed(3.0), start=later), start=f"<StartTrigger>{start}</StartTrigger>", select=True),
    )
    run(board, 0.1)
    assert (board.entities["A"].speed, board.entities["B"].speed) == (3.0, 0.0)
