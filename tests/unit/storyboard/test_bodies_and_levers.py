"""What an entity is made of, its levers and its trailers: by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from openscenario import model
from openscenario.storyboard import held_controls
from openscenario.storyboard.actions.override import _brake, _gear, take
from openscenario.storyboard.controls import Controls, Setting
from openscenario.storyboard.entity import _number
from openscenario.storyboard.trailers import couple, couples, draw, line_up, train, trains, uncouple

from .bodies import car

INF = math.inf


# --- what an entity is made of


def test_an_entity_of_which_nothing_is_said() -> None:
    entity = car(bare=True)
    assert (entity.length, entity.width, entity.height, entity.center_x, entity.center_y, entity.center_z) == (0.0,) * 6
    assert (entity.max_speed, entity.max_acceleration, entity.max_deceleration) == (INF,) * 3
    assert (entity.max_acceleration_rate, entity.max_deceleration_rate) == (INF, INF)
    assert (entity.wheelbase, entity.max_steer, entity.mass) == (0.0, 0.6, 1500.0)
    assert (entity.hitch, entity.coupler, entity.leads) == (0.0, 0.0, 0.0)
    assert (entity.active, entity.tracked, entity.moved, entity.placed, entity.late, entity.shifted) == (
        True, False, False, False, False, False,
    )  # fmt: skip
    assert (entity.sense, entity.along, entity.still_since, entity.end_since) == (1.0, 1.0, INF, INF)
    assert (entity.teleports, entity.lane, entity.travelled, entity.end_of_road, entity.blocked) == (
        0, 0, 0.0, False, False,
    )  # fmt: skip
    assert entity.visible.to("camera")


def test_an_entity_as_its_file_says() -> None:
    axle = SimpleNamespace(position_x=2.7, max_steering=0.5)
    entity = car(axles=SimpleNamespace(front_axle=axle), mass=1200.0, trailer_hitch=SimpleNamespace(dx=-1.0),
                 trailer_coupler=SimpleNamespace(dx=3.0), properties={"refpoint_x_offset": "1.4"})  # fmt: skip
    assert (entity.wheelbase, entity.max_steer, entity.mass, entity.hitch, entity.coupler, entity.leads) == (
        2.7, 0.5, 1200.0, -1.0, 3.0, 1.4,
    )  # fmt: skip
    assert (entity.max_acceleration_rate, entity.max_deceleration_rate, entity.able) == (INF, 2.0, (3.0, 6.0))
    assert car(axles=SimpleNamespace(front_axle=None)).max_steer == 0.6


@pytest.mark.parametrize(("text", "number"), [(None, 0.0), ("", 0.0), ("1.5", 1.5), ("-1", 0.0), ("inf", 0.0),
                                              ("nan", 0.0), ("x", 0.0), ("0", 0.0)])  # fmt: skip
def test_a_property_is_a_number_above_nought_or_none(text: str | None, number: float) -> None:
    assert _number(text) == number


@pytest.mark.parametrize(("speed", "stands"), [(0.0, True), (9e-4, True), (-9e-4, True), (1e-3, False), (-1e-3, False)])
def test_who_is_slower_than_a_millimetre_a_second_stands(speed: float, stands: bool) -> None:
    entity = car()
    entity.speed = speed
    entity.note_rest(3.0)
    entity.note_rest(4.0)
    assert (entity.still_since, entity.end_since) == (3.0 if stands else INF, INF)
    entity.end_of_road = True
    entity.note_rest(5.0)
    entity.note_rest(6.0)
    assert entity.end_since == 5.0
    entity.end_of_road, entity.speed = False, 1.0
    entity.note_rest(7.0)
    assert (entity.still_since, entity.end_since) == (INF, INF)


def test_corners_begin_at_the_front_left_and_go_on_to_the_left() -> None:
    entity = car()
    entity.put(10.0, 20.0, 0.0, 0.5 * math.pi)
    flat = [value for corner in entity.corners() for value in corner]
    assert flat == pytest.approx([9.0, 23.0, 9.0, 19.0, 11.0, 19.0, 11.0, 23.0])
    entity.center_y = 0.5
    assert entity.corners()[0] == pytest.approx((8.5, 23.0))
    assert entity.corners()[2] == pytest.approx((10.5, 19.0))


@pytest.mark.parametrize(("axis", "low", "high"), [(0.0, -1.0, 3.0), (math.pi, -3.0, 1.0), (0.5 * math.pi, -0.5, 1.5),
                                                   (-0.5 * math.pi, -1.5, 0.5)])  # fmt: skip
def test_how_far_a_box_reaches_along_an_axis(axis: float, low: float, high: float) -> None:
    """Its middle is 1 m ahead and 0.5 m to the left."""
    entity = car()
    entity.center_y = 0.5
    assert entity.extent(axis) == pytest.approx((low, high))


def test_a_point_that_is_drawn_along_turns_the_body() -> None:
    """1 m behind the reference point at (0, 0): after a step to (0, 1) the body looks from (-1, 0) to there."""
    entity = car(properties={"refpoint_x_offset": "1"})
    entity.put(0.0, 1.0, 0.0, 0.0)
    entity.draw_behind(0.0, 0.0, 0.0)
    assert entity.h == pytest.approx(0.25 * math.pi)
    entity.put(2.0, 1.0, 0.0, 0.0)
    entity.draw_behind(1.0, 1.0, 0.5 * math.pi)  # drawn from (1, 0)
    assert entity.h == pytest.approx(0.25 * math.pi)


def test_a_domain_is_held_with_its_place_in_the_file_and_let_go_without() -> None:
    entity, runner = car(), object()
    for domain in ("longitudinal", "lateral", "fog"):
        entity.hold(domain, runner, 7)
        assert entity.holder(domain) is runner
        entity.hold(domain, None, 9)
        assert entity.holder(domain) is None
    assert (entity.longitudinal_order, entity.lateral_order, entity.lights) == (7, 7, {})
    entity.hold("fog", None)
    assert entity.holder("fog") is None


# --- levers


def test_a_lever_moves_no_faster_than_its_rate_from_where_it_was() -> None:
    controls = Controls()
    assert not controls.held
    controls.set({"throttle": Setting(0.5, 0.25)})
    assert (controls.held, controls.value("throttle")) == (True, 0.0)
    controls.step(1.0)
    assert controls.value("throttle") == 0.25
    controls.step(3.0)
    assert controls.value("throttle") == 0.5
    controls.set({"throttle": Setting(0.0, 0.1)})
    controls.step(1.0)
    assert controls.value("throttle") == pytest.approx(0.4)
    controls.set({"throttle": Setting(1.0)})
    assert controls.value("throttle") == 1.0
    controls.set({"throttle": None, "brake": None})
    assert (controls.value("throttle"), controls.held) == (None, False)


@pytest.mark.parametrize(
    ("levers", "gear", "braked", "engaged", "wheel"),
    [
        ({}, "drive", None, 1.0, None),
        ({"brake": 0.25}, "", 0.25, 1.0, None),
        ({"brake": 0.25, "parking_brake": 0.5}, "", 0.5, 1.0, None),
        ({"brake": 0.25}, "park", 1.0, 0.0, None),
        ({}, "neutral", None, 0.0, None),
        ({"clutch": 0.25}, "drive", None, 0.75, None),
        ({"clutch": 0.25}, "reverse", None, -0.75, None),
        ({"steering_wheel": 8.0}, "", None, 1.0, 0.5),  # over 16
    ],
)
def test_what_levers_do_together(levers: Any, gear: str, braked: Any, engaged: float, wheel: Any) -> None:
    controls = Controls()
    controls.set({name: Setting(value) for name, value in levers.items()}, gear)
    assert (controls.braked, controls.engaged, controls.road_wheel) == (braked, engaged, wheel)
    controls.set({}, None)
    assert controls.gear == gear
    controls.set({}, "")
    assert controls.gear == ""


def lever(value: float, rate: float | None = None, *, active: bool = True) -> Any:
    return SimpleNamespace(value=value, max_rate=rate, active=active)


def braking(value: float | None = None, *, percent: float | None = None, force: float | None = None,
            rate: float | None = None, active: bool = True) -> Any:  # fmt: skip
    given: Any = None
    if percent is not None:
        given = model.BrakePercent(value=percent, max_rate=rate)
    if force is not None:
        given = model.BrakeForce(value=force, max_rate=rate)
    return SimpleNamespace(value=value, brake_input=given, active=active)


@pytest.mark.parametrize(
    ("element", "value", "rate"),
    [
        (braking(0.5), 0.5, INF),
        (braking(1.5), 1.0, INF),
        (braking(-0.5), 0.0, INF),
        (braking(None), 0.0, INF),
        (braking(percent=0.25, rate=2.0), 0.25, 2.0),
        (braking(force=4500.0, rate=900.0), 0.5, 0.1),  # 1500 kg and 6 m/s^2 make 9000 N
        (braking(force=18000.0), 1.0, INF),
        (braking(force=-1.0), 0.0, INF),
    ],
)
def test_a_brake_is_a_share_of_the_full_one(element: Any, value: float, rate: float) -> None:
    found = _brake(element, car())
    assert found == pytest.approx((value, rate))


def test_a_force_on_a_car_without_a_full_brake_does_nothing() -> None:
    assert _brake(braking(force=9000.0, rate=1.0), car(bare=True)).value == 0.0


@pytest.mark.parametrize(
    ("gear", "number", "active", "name"),
    [
        (model.AutomaticGear(gear="n"), None, True, "neutral"),
        (model.AutomaticGear(gear="p"), None, True, "park"),
        (model.AutomaticGear(gear="r"), None, True, "reverse"),
        (model.AutomaticGear(gear="d"), None, True, "drive"),
        (model.AutomaticGear(gear="d"), None, False, ""),
        (model.ManualGear(number=1), None, True, "drive"),
        (model.ManualGear(number=0), None, True, "neutral"),
        (model.ManualGear(number=-1), None, True, "reverse"),
        (None, 2.0, True, "drive"),
        (None, None, True, "neutral"),
    ],
)
def test_gears_by_letter_and_number(gear: Any, number: Any, active: bool, name: str) -> None:
    element: Any = SimpleNamespace(gear=gear, number=number, active=active)
    assert _gear(element) == name


def test_an_override_takes_what_is_active_and_lets_go_what_is_not() -> None:
    entity = car()
    nothing = dict.fromkeys(("throttle", "clutch", "steering_wheel", "brake", "parking_brake", "gear"))
    first = {**nothing, "throttle": lever(1.5), "clutch": lever(-0.5), "steering_wheel": lever(-3.0, 1.0),
             "brake": braking(0.5)}  # fmt: skip
    take(SimpleNamespace(**first), entity)  # type: ignore[arg-type]
    controls = entity.controls
    assert [controls.value(name) for name in ("throttle", "clutch", "steering_wheel", "brake", "parking_brake")] == [
        1.0, 0.0, 0.0, 0.5, None,
    ]  # fmt: skip
    controls.step(2.0)
    assert controls.value("steering_wheel") == -2.0  # no lever from 0 to 1, and as fast as it may
    second = {**nothing, "throttle": lever(0.0, active=False), "brake": braking(0.5, active=False)}
    take(SimpleNamespace(**second), entity)  # type: ignore[arg-type]
    assert entity.controls is controls
    assert [controls.value(name) for name in ("throttle", "brake", "clutch")] == [None, None, 0.0]


@pytest.mark.parametrize(
    ("levers", "gear", "before", "after"),
    [
        ({"throttle": 0.5}, "", 10.0, 10.75),  # half of 3 m/s^2 for 0.5 s
        ({"throttle": 1.0}, "reverse", 1.0, -0.5),
        ({"brake": 0.5}, "", 10.0, 8.5),
        ({"brake": 0.5}, "", -10.0, -8.5),
        ({"brake": 1.0}, "", 2.0, 0.0),
        ({"throttle": 1.0, "brake": 0.25}, "", 10.0, 10.75),  # 1.5 up, 0.75 down
        ({"throttle": 1.0}, "", 49.0, 50.0),
        ({}, "drive", 10.0, 10.0),
    ],
)
def test_pedals_change_the_speed_by_their_share(levers: Any, gear: str, before: float, after: float) -> None:
    entity, controls = car(), Controls()
    controls.set({name: Setting(value) for name, value in levers.items()}, gear)
    entity.speed = before
    held_controls._press(entity, controls, 0.5)
    assert entity.speed == pytest.approx(after)


@pytest.mark.parametrize(("wheelbase", "angle", "turn"), [(2.5, 0.3, 4.0 * math.tan(0.3) / 2.5),
                                                          (0.0, 0.3, 4.0 * math.tan(0.3) / 2.4),
                                                          (2.5, 0.9, 4.0 * math.tan(0.6) / 2.5),
                                                          (-1.0, 0.1, 4.0 * math.tan(0.1)),
                                                          (2.5, -0.9, -4.0 * math.tan(0.6) / 2.5),
                                                          (2.5, 0.0, 0.0)])  # fmt: skip
def test_a_held_wheel_drives_an_arc(wheelbase: float, angle: float, turn: float) -> None:
    """8 m/s for 0.5 s; where the file states no axle, 0.6 of the length (without one, -1 here, 1 m), and 0.6 rad at
    most."""
    entity = car()
    entity.wheelbase, entity.h = max(wheelbase, 0.0), 0.25
    entity.length = 0.0 if wheelbase < 0.0 else entity.length
    entity.x, entity.y = 30.0, -20.0
    entity.jump_to_speed(8.0)
    stood: list[Any] = []
    held_controls._steer(entity, angle, 0.5, SimpleNamespace(stand=stood.append))  # type: ignore[arg-type]
    radius = 4.0 / turn if turn else INF
    ahead = (radius * (math.sin(0.25 + turn) - math.sin(0.25)), radius * (math.cos(0.25) - math.cos(0.25 + turn)))
    if not turn:
        ahead = (4.0 * math.cos(0.25), 4.0 * math.sin(0.25))
    assert (entity.x, entity.y) == pytest.approx((30.0 + ahead[0], -20.0 + ahead[1]))
    assert entity.h == pytest.approx(0.25 + turn)
    assert (entity.vx, entity.vy) == pytest.approx((ahead[0] / 0.5, ahead[1] / 0.5))
    assert (entity.travelled, entity.moved, stood) == (pytest.approx(4.0), True, [entity])


# --- trailers


def test_what_hung_before_lets_go_and_stands() -> None:
    a, b, c, d = (car(name) for name in "ABCD")
    couple(a, b)
    couple(c, d)
    b.speed = d.speed = 5.0
    couple(a, d)
    assert (a.trailer, d.drawn_by, b.drawn_by, c.trailer) == (d, a, None, None)
    assert (b.speed, d.speed) == (0.0, 0.0)
    uncouple(b)
    couple(d, b)
    assert [e.name for e in train(a)] == ["A", "D", "B"]
    assert [e.name for e in couples(b)] == ["A", "D", "B"]
    assert couples(c) == (c,)


def test_a_train_stands_in_line_and_its_axles_follow_the_hitch() -> None:
    """Hitch 1 m behind, coupler 3 m ahead: 4 m apart. From there the hitch goes to (0, 4): a 3-4-5 triangle."""
    a, b, c = (car(name) for name in "ABC")
    a.hitch = b.hitch = -1.0
    b.coupler = c.coupler = 3.0
    couple(a, b)
    couple(b, c)
    a.put(10.0, 5.0, 0.5, 0.0)
    line_up(a)
    assert [(e.x, e.y, e.z) for e in (b, c)] == [(6.0, 5.0, 0.5), (2.0, 5.0, 0.5)]
    uncouple(b)
    b.put(-3.0, 0.0, 0.0, 0.0)
    a.put(1.0, 4.0, 0.25, 0.0)
    a.pitch, a.roll, a.speed, a.speed_before, a.ax = 0.1, 0.2, 3.0, 2.0, 1.0
    draw(a, 0.5)
    h = math.atan2(4.0, 3.0)
    assert (b.x, b.y, b.z, b.h) == pytest.approx((-3.0 * 0.6, 4.0 - 3.0 * 0.8, 0.25, h))
    assert (b.pitch, b.roll, b.speed, b.speed_before, b.ax) == (0.1, 0.2, 3.0, 2.0, 1.0)
    assert (b.vx, b.vy, b.travelled) == pytest.approx((1.2 / 0.5, 1.6 / 0.5, 2.0))
    draw(a, 0.0)
    assert b.travelled == pytest.approx(2.0)
    b.coupler = 0.0
    b.put(5.0, 5.0, 0.0, 1.0)
    draw(a, 0.0)
    assert (b.x, b.y, b.h) == pytest.approx((0.0, 4.0, 1.0))  # a coupler above the axle keeps its heading


def test_trailers_inside_a_vehicle_are_called_after_it_but_not_of_one_moved_from_outside() -> None:
    def wrapped(name: str, inside: Any) -> Any:
        trailer = SimpleNamespace(trailer=inside, trailer_ref=None)
        return SimpleNamespace(name=name, kind="vehicle", category="car", bounding_box=None,
                               entity=SimpleNamespace(trailer=trailer if inside else None))  # fmt: skip

    last = wrapped("x", None)
    scenario: Any = SimpleNamespace(entities=[wrapped("A", wrapped("y", last)), wrapped("E", last)])
    found = [(entity.name, ahead and ahead.name) for entity, ahead in trains(scenario, {"E"})]
    assert found == [("A", None), ("A+", "A"), ("A++", "A+"), ("E", None)]
