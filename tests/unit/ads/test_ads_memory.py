"""What tracks of the camera alone are worth: one object is one track, and doubt of its range is no motion."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ads.perception.fusion import CAMERA, MEASURE, VEHICLE
from ads.perception.track import AP, HITS, TRACK, TX
from ads.perception.tracking import CONFIRM, MOST_TRACKS, predict_tracks, update_tracks
from ads.planning.memory import TrackMemory
from vehicle.messages import Detection

RANGE = 60.0  # m
SIGMA = 4.8  # m, of the range at 60 m: 1.5 px of a box's lower edge, focal length 800 px, camera 1.4 m up


def seen_by_camera(x: float) -> np.ndarray:
    row = np.zeros((1, MEASURE))
    row[0, [0, 3, 4, 5, 6, 7, 8, 9]] = x, 4.0, 1.75, VEHICLE, 0.9, 0.1 + SIGMA**2, CAMERA, 0.06
    return row


@pytest.mark.parametrize("seed", range(5))
def test_a_standing_car_that_only_the_camera_sees_is_one_track_with_the_doubt_of_its_range(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tracks, n, number, twice = np.zeros((MOST_TRACKS, TRACK)), 0, 1, 0
    for _ in range(100):
        n = predict_tracks(tracks, n, 0.05)
        row = seen_by_camera(RANGE + SIGMA * rng.standard_normal())
        n, number = update_tracks(tracks, n, row, (0.0, 0.0, 0.0), number)
        twice += int(np.sum(tracks[:n, HITS] >= CONFIRM)) > 1
    assert n == 1
    assert twice <= 10  # of 100 frames; an outlier may have a track of its own for a moment
    assert abs(tracks[0, TX] - RANGE) < 4.0
    assert math.sqrt(tracks[0, AP]) >= 0.03 * (RANGE - 15.0)  # 3 % of the range last, however many frames are taken


def vehicle(t: float, x: float, sigma: float) -> tuple[Detection, ...]:
    return (Detection(t, "vehicle", x, 0.0, 0.0, 4.0, 1.8, 0.0, 0.0, 0.9, sigma**2, 1),)


def test_a_place_that_wanders_within_its_doubt_is_no_motion() -> None:
    memory = TrackMemory(1.4)
    for k in range(200):
        memory.note(0.05 * k, 0.0, 0.0, vehicle(0.05 * k, 60.0 + 4.0 * math.sin(0.1 * k), 1.8))
    assert not memory.moved(1)


@pytest.mark.parametrize(("sigma", "way"), [(0.1, 3.0), (1.2, 30.0)])
def test_who_went_farther_than_the_doubt_of_his_place_has_moved(sigma: float, way: float) -> None:
    memory = TrackMemory(1.4)
    for k in range(50):
        gone = way * k / 49.0
        memory.note(0.05 * k, gone, 0.0, vehicle(0.05 * k, 40.0 + gone, sigma))  # the car follows it
    assert memory.moved(1)


def test_a_place_that_gets_surer_is_compared_with_the_surer_one() -> None:
    memory = TrackMemory(1.4)
    for k, (x, sigma) in enumerate([(66.0, 2.0), (61.0, 0.5), (60.0, 0.1), (60.3, 0.1)]):
        memory.note(0.05 * k, 0.0, 0.0, vehicle(0.05 * k, x, sigma))
    assert not memory.moved(1)


def test_a_place_that_wanders_by_the_pitch_of_the_car_is_no_motion_until_a_lidar_says_so() -> None:
    # as driven: a parked car, placed by the camera alone while the car pulls away, then by its LiDAR
    places = [(81.9, 74.2), (68.6, 58.6), (73.9, 61.5), (95.3, 68.6), (87.4, 46.1)]
    memory = TrackMemory(1.4)
    for k, (place, distance) in enumerate(places):
        sigma = 0.15 if distance < 50.0 else 0.03 * distance
        memory.note(0.05 * k, place - distance, 0.0, vehicle(0.05 * k, place, sigma))
        assert not memory.moved(1), k
    memory.note(1.0, 50.0, 0.0, vehicle(1.0, 91.0, 0.15))
    assert memory.moved(1)  # by the LiDAR, 3.6 m are motion
