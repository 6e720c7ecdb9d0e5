"""When conditions become true, on a straight road where the time can be computed by hand."""

from __future__ import annotations

import pytest

from .conftest import Make, by_entity, condition, event, group, lane_position, log, run, speed, story, teleport

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


def test_speed_holds_at_once(make: Make) -> None:
    assert fires(make, of_a('<SpeedCondition rule="greaterThan" value="9.9"/>')) == 0.0


def test_relative_speed(make: Make) -> None:
    assert fires(make, of_a('<RelativeSpeedCondition entityRef="B" rule="equalTo" value="10"/>')) == 0.0


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
