"""The camera's boxes against the pinhole equation and geometry done by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vehicle.messages import CameraBox, Surroundings
from vehicle.model.errors import ModelError
from vehicle.sensors import Camera, Mount, Timing

SHARP = Camera(Mount(x=1.0, z=1.4), Timing(10.0), sigma=0.0, misses=0.0, score_sigma=0.0)


def _world(*boxes: list[float], kinds: list[int] | None = None) -> Surroundings:
    array = np.array(boxes, dtype=np.float64).reshape(-1, 9)
    return Surroundings(array, np.array(kinds or [0] * len(boxes)), tuple(f"box {i}" for i in range(len(boxes))))


def _box(x: float, y: float, *, length: float = 4.0, width: float = 1.8, height: float = 1.5) -> list[float]:
    return [x, y, height / 2, 0.0, length, width, height, 0.0, 0.0]


def _look(camera: Camera, world: Surroundings, frames: int = 1, seed: int = 1) -> list[tuple[CameraBox, ...]]:
    running = camera.start(0.0, np.random.SeedSequence(seed))
    seen = []
    for k in range(frames):
        running.measure(k / 10, 0.0, 0.0, 0.0, 0.0, world)
        frame = running.arrived(k / 10 + camera.timing.latency)
        assert frame is not None
        seen.append(frame.boxes)
    return seen


def test_a_box_straight_ahead_is_imaged_by_the_pinhole_equation() -> None:
    (box,) = _look(SHARP, _world(_box(21.0, 0.0)))[0]
    distance = 18.0  # to the nearer face
    assert box.u_min == pytest.approx(640.0 - 800.0 * 0.9 / distance)
    assert box.u_max == pytest.approx(640.0 + 800.0 * 0.9 / distance)
    assert box.v_max == pytest.approx(360.0 + 800.0 * 1.4 / distance)
    assert box.v_min == pytest.approx(360.0 - 800.0 * 0.1 / distance)


def test_left_in_the_world_is_left_in_the_image() -> None:
    (box,) = _look(SHARP, _world(_box(20.0, 5.0)))[0]
    assert box.u_max < 640.0


def test_kind_is_told() -> None:
    (box,) = _look(SHARP, _world(_box(15.0, 0.0), kinds=[1]))[0]
    assert box.kind == "pedestrian"


def test_what_is_behind_or_beside_the_image_is_not_seen() -> None:
    assert _look(SHARP, _world(_box(-20.0, 0.0), _box(5.0, 30.0), _box(200.0, 0.0))) == [()]


def test_what_a_nearer_box_hides_is_not_seen() -> None:
    hidden, front = _box(30.0, 0.0), _box(10.0, 0.0, width=2.5, height=2.5)
    seen = _look(SHARP, _world(hidden, front))[0]
    assert len(seen) == 1
    assert seen[0].u_max - seen[0].u_min > 250.0


def test_half_hidden_lowers_the_score() -> None:
    free = _look(SHARP, _world(_box(30.0, 0.0)))[0][0].score
    both = _look(SHARP, _world(_box(30.0, 0.0), _box(15.0, 0.9, length=0.2, height=3.0)))[0]
    assert len(both) == 2
    assert both[0].score < free - 0.1


def test_small_images_are_not_detected() -> None:
    assert _look(replace(SHARP, least_height=50.0), _world(_box(40.0, 0.0))) == [()]


def test_a_box_cut_by_the_image_ends_at_its_edge() -> None:
    (box,) = _look(SHARP, _world(_box(8.0, 5.0)))[0]
    assert box.u_min == 0.0


def test_misses_lose_their_share() -> None:
    frames = _look(replace(SHARP, misses=0.25), _world(_box(20.0, 0.0)), frames=4000)
    share = sum(not boxes for boxes in frames) / 4000
    assert share == pytest.approx(0.25, abs=4 * (0.25 * 0.75 / 4000) ** 0.5)


def test_confusions_and_false_boxes_have_their_share() -> None:
    camera = replace(SHARP, confusions=0.2, false_boxes=0.1)
    frames = _look(camera, _world(_box(20.0, 0.0)), frames=4000)
    wrong = sum(boxes[0].kind != "vehicle" for boxes in frames) / 4000
    false = sum(len(boxes) == 2 for boxes in frames) / 4000
    assert wrong == pytest.approx(0.2, abs=0.03)
    assert false == pytest.approx(0.1, abs=0.02)


def test_edge_noise_has_its_standard_deviation() -> None:
    frames = _look(replace(SHARP, sigma=2.0), _world(_box(20.0, 0.0)), frames=4000)
    edges = np.array([boxes[0].u_min for boxes in frames])
    assert edges.std() == pytest.approx(2.0, rel=0.06)


def test_more_boxes_than_before_fit() -> None:
    crowd = _world(*[_box(20.0 + i, 0.0) for i in range(40)])
    assert len(_look(SHARP, crowd)[0]) >= 1


@pytest.mark.parametrize("reach", [0.0, -5.0, float("nan")])
def test_a_camera_that_reaches_nowhere_is_refused(reach: float) -> None:
    with pytest.raises(ModelError, match="reach"):
        Camera(Mount(), Timing(10.0), reach=reach)
