"""Behaviours in a closed loop with a perception that sees everything as it is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from ads_loop import SEDAN, TABBY, Car, drive, new_stack
from ads_plane import PlaneMap
from ads_traffic import Actor, SeeingAll, Watch, parked

from ads.parameters import Parameters
from vehicle.messages import RoadPoint, SignalState, Task

GOAL = Task(goal=RoadPoint("1", -1, 150.0))


def run(actors, network=None, car=None, duration=60.0, task=GOAL, sense=None, **more):
    network = network or PlaneMap([(300.0, 0.0)])
    car = car or Car(TABBY, 5.0, -1.75, 0.0, 5.0)
    stack = new_stack(network, car.description, perception=SeeingAll(actors), **more)
    watch = Watch(actors)
    return drive(stack, car, duration, task, sense, watch), watch


def test_drives_around_a_standing_vehicle_and_on_to_the_goal():
    log, watch = run([parked(70.0)])
    assert watch.least > 0.5
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)
    assert log.v[-1] == 0.0
    assert watch.inverse_ttc < 0.5
    assert log.jerk() < 2.5
    assert log.rmse() < 0.15


def test_drives_around_a_motorcycle_that_stands_in_the_lane():
    log, watch = run([Actor("bicycle", 70.0, -1.75, 0.0, 2.2, 0.8)])
    assert watch.least > 0.5
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


@pytest.mark.parametrize("gap", [6.0, 8.0, 12.0])
@pytest.mark.parametrize("length", [4.3, 12.0])
@pytest.mark.nightly(by_day=3)
def test_gets_out_from_where_it_stands_close_behind_an_obstacle(gap, length):
    # A swing of 2.3 m to the side on arcs of the tightest radius, 6.5 m, is 7.4 m long; the corner is clear before.
    truck = Actor("vehicle", 70.0, -1.75, 0.0, length, 1.8)
    front = TABBY.center_x + 0.5 * TABBY.length
    car = Car(TABBY, 70.0 - 0.5 * length - gap - front, -1.75, 0.0, 0.0)
    log, watch = run([truck], car=car)
    assert watch.least > 0.4
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


def test_waits_for_an_oncoming_vehicle_before_it_overtakes():
    oncoming = Actor("vehicle", 130.0, 1.75, math.pi, 4.4, 1.8, 5.0)
    log, watch = run([parked(70.0), oncoming])
    assert watch.least > 0.5
    assert watch.inverse_ttc < 1.0
    assert log.v[100:].min() < 1.0
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


@pytest.mark.parametrize("from_x", [85.0, 90.0, 95.0, 100.0])
@pytest.mark.nightly(by_day=4)
def test_does_not_stop_for_an_oncoming_vehicle_that_goes_by_in_time(from_x):
    # 5 m/s each: they meet where the car is still 15 to 23 m behind the rear of the parked one.
    oncoming = Actor("vehicle", from_x, 1.75, math.pi, 4.4, 1.8, 5.0)
    log, watch = run([parked(70.0), oncoming])
    assert watch.least > 0.5
    assert watch.inverse_ttc < 0.5
    assert log.v[:400].min() > 1.0
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


def test_an_oncoming_vehicle_that_only_sets_off_later_is_not_trusted():
    oncoming = Actor("vehicle", 95.0, 1.75, math.pi, 4.4, 1.8, 5.0, start=7.0)
    log, watch = run([parked(70.0), oncoming])
    assert watch.least > 0.5
    assert watch.inverse_ttc < 1.0
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


def test_stops_behind_a_box_it_cannot_pass():
    network = PlaneMap([(300.0, 0.0)])
    wall = Actor("misc", 70.0, 0.0, 0.0, 2.0, 7.0)
    log, watch = run([wall], network, duration=40.0)
    assert log.v[-1] == 0.0
    assert 2.0 < watch.least < 17.0
    assert watch.inverse_ttc < 0.5


def test_lets_a_pedestrian_pass_without_a_stop_and_comes_to_the_crosswalk_behind_him():
    network = PlaneMap([(300.0, 0.0)], crosswalk_at=60.0)
    pedestrian = Actor("pedestrian", 60.0, 8.0, -math.pi / 2, 0.5, 0.6, 2.0, start=6.0)
    log, watch = run([pedestrian], network)
    assert watch.inverse_ttc <= 0.5
    assert watch.least > 1.0
    slowest = log.v[:300].min()
    assert 0.5 < slowest < 3.0
    # He leaves the car's width (0.74 m to each side of -1.75 m) at t = 6 + (8 + 1.75 + 0.74 + 0.25) / 2 = 11.4 s;
    # before, the bumper, 2.7 m ahead of the axle, is not on the crosswalk, which begins 1.5 m before 60 m.
    before = [x + 2.7 for t, x, *_ in log.rows if t < 11.4]
    assert max(before) < 58.5
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


def test_stops_for_a_pedestrian_who_stops_before_the_car():
    network = PlaneMap([(300.0, 0.0)], crosswalk_at=60.0)
    pedestrian = Actor("pedestrian", 60.0, 8.0, -math.pi / 2, 0.5, 0.6, 2.0, start=6.0, reach=9.75)  # to -1.75
    log, watch = run([pedestrian], network, duration=30.0)
    assert log.v[-1] == 0.0
    assert watch.inverse_ttc < 1.0
    assert watch.least > 0.5


@pytest.mark.parametrize(("speed", "step_off"), [(5.0, 2.0), (8.0, 3.0), (8.0, 5.0), (8.0, 7.0)])
def test_stops_before_the_crosswalk_for_one_who_steps_off_late(speed, step_off):
    # Beside a pedestrian who stands at the kerb it comes at half its speed. When it is `step_off` [m] before the
    # crosswalk he walks, and would meet it: a stop before the crosswalk takes 2 to 5 m/s^2.
    front = TABBY.center_x + 0.5 * TABBY.length
    walker = Actor("pedestrian", 87.0, -6.0, math.pi / 2, 0.5, 0.5, 1.4, start=math.inf)

    def sense(t, car):
        if math.isinf(walker.start) and 85.5 - car.x - front < step_off:
            walker.start = t
        return {}

    task = Task(set_speed=speed, goal=RoadPoint("1", -1, 150.0))
    car = Car(TABBY, 40.0, -1.75, 0.0, speed)
    log, watch = run([walker], PlaneMap([(300.0, 0.0)], crosswalk_at=87.0), car, 45.0, task, sense)
    across = walker.start + (6.0 - 1.75 + 0.5 * TABBY.width) / walker.speed  # [s] he is out of the lane
    assert max(x + front for t, x, *_ in log.rows if t < across) < 85.5
    assert watch.inverse_ttc < 1.0
    assert watch.least > 1.5
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


def test_waits_15_m_before_the_middle_of_an_occupied_crossing():
    network = PlaneMap([(300.0, 0.0)], crosswalk_at=60.0)
    standing = Actor("pedestrian", 60.0, -1.75, -math.pi / 2, 0.5, 0.6)
    log, _ = run([standing], network, duration=30.0)
    assert log.v[-1] == 0.0
    assert log.rows[-1][1] == pytest.approx(45.0, abs=1.0)


@pytest.mark.parametrize(("start", "at", "when"), [(0.0, -1.75, 16.0), (0.0, -1.75, 25.0), (18.0, -6.0, 19.0)])
def test_a_new_goal_changes_nothing_for_who_crosses(start, at, when):
    # Places along the path are counted anew with it: one that was noted before is somewhere else.
    walker = Actor("pedestrian", 120.0, at, math.pi / 2, 0.5, 0.5, 0.7 if start else 0.0, start=start, reach=12.0)
    least = []
    for goals in ((), (RoadPoint("1", -1, 260.0),)):
        stack = new_stack(PlaneMap([(400.0, 0.0)], crosswalk_at=120.0), perception=SeeingAll([walker]))
        left, watch = list(goals), Watch([walker])

        def sense(t, car, left=left, stack=stack):
            if left and t >= when:
                stack.navigator.assign(Task(goal=left.pop()))
            return {}

        goal = Task(goal=RoadPoint("1", -1, 250.0))
        log = drive(stack, Car(TABBY, 5.0, -1.75, 0.0, 5.0), 40.0, goal, sense, watch)
        assert not any(trace["net.main.emergency"] for trace in log.traces)
        least.append(watch.least)
    assert least[1] > least[0] - 0.5


@pytest.mark.nightly
def test_without_stop_distance_the_crossing_is_not_safe():
    network = PlaneMap([(300.0, 0.0)], crosswalk_at=60.0)
    pedestrian = Actor("pedestrian", 60.0, 8.0, -math.pi / 2, 0.5, 0.6, 2.0, start=8.5)
    spoilt = Parameters().with_values({"DECISION_PC_d_min": 0.0})
    _, good = run([pedestrian], network)
    _, bad = run([pedestrian], network, parameters=spoilt)
    assert good.inverse_ttc <= 0.5 < bad.inverse_ttc


def test_brakes_for_a_pedestrian_away_from_any_crossing():
    pedestrian = Actor("pedestrian", 60.0, -6.0, math.pi / 2, 0.5, 0.6, 1.5, start=6.0)
    _, watch = run([pedestrian], duration=30.0)
    assert watch.least > 0.3


def test_brakes_for_a_pedestrian_at_16_m_per_s():
    pedestrian = Actor("pedestrian", 200.0, -6.0, math.pi / 2, 0.5, 0.6, 1.5, start=9.7)
    network = PlaneMap([(600.0, 0.0)])
    _, watch = run([pedestrian], network, Car(SEDAN, 5.0, -1.75, 0.0, 16.0), 20.0, Task(set_speed=16.0))
    assert watch.least > 0.0


def test_follows_a_slower_vehicle_at_its_speed():
    lead = Actor("vehicle", 40.0, -1.75, 0.0, 4.4, 1.8, 3.0)
    log, watch = run([lead], PlaneMap([(600.0, 0.0)]), duration=40.0, task=Task())
    assert log.v[-1] == pytest.approx(3.0, abs=0.1)
    assert watch.least > 5.0


@pytest.mark.parametrize(
    ("stop", "go"),
    [("red", "green"), ("on;off;off", "off;off;on"), ("red;amber", "green"), ("flashing red", "flashing amber")],
)
def test_stops_at_a_red_light_and_goes_at_green(stop, go):
    network = PlaneMap([(300.0, 0.0)], signal_at=60.0)

    def lights(t, car):
        return {"signals": (SignalState("lamp", stop if t < 25.0 else go),)}

    log, _ = run([], network, sense=lights)
    waiting = log.rows[480]
    assert waiting[3] == 0.0
    assert waiting[1] + TABBY.center_x + TABBY.length / 2 == pytest.approx(59.0, abs=0.8)
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


@pytest.mark.parametrize(("speed", "left"), [(8.0, 18.0), (13.9, 50.0), (13.9, 54.0), (13.9, 58.0)])
def test_a_stop_for_amber_is_not_given_up(speed, left):
    # At 13.9 m/s and 58 m before the line a stop needs 1.7 m/s^2 at the onset, and over 2 by the time the brake bites.
    network = PlaneMap([(400.0, 0.0)], signal_at=150.0)
    front = SEDAN.center_x + 0.5 * SEDAN.length
    onset = []

    def sense(t, car):
        if not onset and 150.0 - car.x - front < left:
            onset.append(t)
        state = "green" if not onset else "amber" if t - onset[0] < 3.0 else "red"
        return {"signals": (SignalState("lamp", state),)}

    car = Car(SEDAN, 5.0, -1.75, 0.0, speed)
    task = Task(set_speed=speed, goal=RoadPoint("1", -1, 350.0))
    log, _ = run([], network, car=car, duration=30.0, task=task, sense=sense)
    assert 148.5 < log.rows[-1][1] + front < 150.0
    assert log.v[-1] < 0.05


def waiting_at_a_light(sets_off):
    """A drive up to two who stand before a light, red for 25 s, and set off at `sets_off` [s]."""
    cars = [Actor("vehicle", x, -1.75, 0.0, 4.4, 1.8, 5.0, start=sets_off + k) for k, x in enumerate((96.0, 88.5))]

    def lights(t, car):
        return {"signals": (SignalState("lamp", "red" if t < 25.0 else "green"),)}

    return run(cars, PlaneMap([(300.0, 0.0)], signal_at=100.0), duration=80.0, sense=lights)


def test_does_not_overtake_those_who_wait_at_a_red_light():
    log, watch = waiting_at_a_light(sets_off=26.0)
    rear = 88.5 - 2.2 - TABBY.center_x - TABBY.length / 2
    assert log.rows[480][1] == pytest.approx(rear - 6.0, abs=0.5)
    assert np.abs(log.column(2) + 1.75).max() < 0.1
    assert watch.least > 5.0
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


def test_overtakes_one_who_does_not_set_off_at_green_after_a_while():
    log, watch = waiting_at_a_light(sets_off=math.inf)
    still = log.column(0) < 35.0  # 10 s of green
    assert np.abs(log.column(2)[still] + 1.75).max() < 0.1
    assert watch.least > 0.5
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


def test_does_not_overtake_one_who_waits_at_an_occupied_crossing():
    waits = parked(75.5)  # its front 0.8 m before the crosswalk
    walkers = [Actor("pedestrian", 80.0, -6.0, math.pi / 2, 0.5, 0.5, 1.4, start=5.0 + 4.0 * k) for k in range(4)]
    log, watch = run([waits, *walkers], PlaneMap([(300.0, 0.0)], crosswalk_at=80.0), duration=60.0)
    crossed = walkers[-1].start + (6.0 + 1.75) / 1.4  # [s] the last one is in the other lane's middle
    assert np.abs(log.column(2)[log.column(0) < crossed] + 1.75).max() < 0.1
    assert watch.least > 0.5
    assert log.rows[-1][1] == pytest.approx(150.0, abs=1.0)


def test_without_perception_it_drives_into_the_obstacle():
    network = PlaneMap([(300.0, 0.0)])
    actors = [parked(70.0)]
    stack = new_stack(network, perception=None)
    watch = Watch(actors)
    drive(stack, Car(TABBY, 5.0, -1.75, 0.0, 5.0), 20.0, GOAL, watch=watch)
    assert watch.least < 0.0


def test_without_gain_it_leaves_the_lane():
    network = PlaneMap([(40.0, 0.0), (25.0, 1 / 15), (80.0, 0.0)])
    spoilt = Parameters().with_values({"LQR_q11": 0.0, "LQR_q22": 0.0})
    log, _ = run([], network, Car(TABBY, 5.0, -1.75, 0.03, 5.0), 25.0, Task(), parameters=spoilt)
    assert log.rmse() > 0.4
