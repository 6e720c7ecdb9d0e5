"""Route, path and control in a closed loop without traffic."""

from __future__ import annotations

import math

import pytest
from ads_loop import SEDAN, TABBY, Car, drive, new_stack
from ads_plane import PlaneMap

from vehicle.messages import RoadPoint, Task


def test_stops_at_the_goal_within_half_a_metre():
    network = PlaneMap([(200.0, 0.0)])
    log = drive(new_stack(network), Car(TABBY, 5.0, -1.75, 0.0), 40.0, Task(goal=RoadPoint("1", -1, 120.0)))
    assert log.v[-1] == 0.0
    assert log.rows[-1][1] == pytest.approx(120.0, abs=0.5)
    assert log.jerk() < 2.5


def test_drives_at_the_set_speed_on_a_straight():
    network = PlaneMap([(2000.0, 0.0)])
    log = drive(new_stack(network, SEDAN), Car(SEDAN, 5.0, -1.75, 0.0, 25.0), 30.0, Task(set_speed=30.0))
    assert log.v[-1] == pytest.approx(30.0, abs=0.2)
    assert log.rmse() < 0.02


def test_follows_a_bend_of_15_m_within_15_cm():
    network = PlaneMap([(40.0, 0.0), (25.0, 1 / 15), (40.0, 0.0), (25.0, -1 / 15), (60.0, 0.0)])
    log = drive(new_stack(network), Car(TABBY, 5.0, -1.75, 0.0, 5.0), 40.0)
    assert log.rmse() < 0.1
    assert max(log.off_path) < 0.3


def test_slows_for_a_bend_by_the_root_of_its_radius():
    network = PlaneMap([(60.0, 0.0), (60.0, 1 / 18.25), (60.0, 0.0)])  # lane -1: radius 20 m
    log = drive(new_stack(network), Car(TABBY, 5.0, -1.75, 0.0, 5.5), 30.0)
    assert log.v.min() == pytest.approx(5.5 * math.sqrt(20.0 / 40.0), abs=0.25)


def test_holds_a_wide_curve_at_30_m_per_s():
    network = PlaneMap([(300.0, 0.0), (900.0, 1 / 800), (600.0, 0.0)])
    log = drive(new_stack(network, SEDAN), Car(SEDAN, 5.0, -1.75, 0.0, 30.0), 40.0, Task(set_speed=30.0))
    assert log.v.min() > 29.0
    assert log.rmse() < 0.15


def test_stops_where_the_lane_leads_nowhere():
    network = PlaneMap([(150.0, 0.0)])
    log = drive(new_stack(network), Car(TABBY, 5.0, -1.75, 0.0, 5.0), 45.0)
    assert log.v[-1] == 0.0
    assert 140.0 < log.rows[-1][1] + TABBY.center_x + TABBY.length / 2 < 150.0


def test_comes_back_to_the_lane_from_a_metre_beside_it():
    network = PlaneMap([(400.0, 0.0)])
    log = drive(new_stack(network), Car(TABBY, 5.0, -2.75, 0.0, 5.0), 20.0)
    assert abs(log.rows[-1][2] + 1.75) < 0.05
