"""What is hidden in the surrogate's perception, on the boxes that its sensors look at."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.truth.tracks import TYPICAL
from vehicle.messages import FloatArray, Surroundings
from vehicle.surrogate.__main__ import main
from vehicle.surrogate.hidden import Hidden
from vehicle.surrogate.perceiver import Perceiver

PERIOD = 0.1  # s between two looks
CAR = (5.0, -3.0, math.pi / 2)  # looks along y


def around(*places: tuple[float, float]) -> Surroundings:
    boxes = np.array([[x, y, 0.75, 0.0, 4.0, 1.8, 1.5, 0.0, 0.0] for x, y in places]).reshape(-1, 9)
    return Surroundings(boxes, np.zeros(len(places), dtype=np.int64), tuple(f"car {k}" for k in range(len(places))))


def looks(scenes: list[Surroundings], seed: int = 1, **effects: dict[str, float]) -> list[Surroundings]:
    perceiver = Perceiver(Hidden(effects=effects), seed)
    return [perceiver.seen(PERIOD * k, *CAR, scene) for k, scene in enumerate(scenes)]


def places(seen: list[Surroundings]) -> FloatArray:
    return np.concatenate([one.boxes[:, :2] for one in seen])


def test_nothing_hidden_is_what_is_there() -> None:
    scene = around((5.0, 20.0))
    assert looks([scene])[0] is scene


def test_an_offset_is_in_the_cars_frame() -> None:
    """0.6 m ahead along y, 0.4 m to the right along x of a car that looks along y."""
    (seen,) = looks([around((5.0, 20.0))], detection_offset={"x": 0.6, "y": -0.4})
    assert seen.boxes[0, :2] == pytest.approx((5.4, 20.6))


def test_a_late_object_is_where_it_was_and_a_new_one_is_not_seen_yet() -> None:
    """3 m/s, 0.25 s late: 0.75 m behind, between two looks."""
    scenes = [around((0.3 * k, 20.0)) for k in range(10)]
    seen = looks(scenes, detection_latency={"T": 0.25})
    assert [len(one.names) for one in seen[:4]] == [0, 0, 0, 1]
    assert places(seen[3:])[:, 0] == pytest.approx([0.3 * k - 0.75 for k in range(3, 10)])


def test_the_range_ends_at_its_radius_around_the_rear_axle() -> None:
    (seen,) = looks([around((5.0, 16.9), (5.0, 17.1))], detection_range={"R": 20.0})
    assert seen.names == ("car 0",)


def test_misses_are_the_share_that_was_asked_for() -> None:
    seen = looks([around((5.0, 20.0))] * 2000, detection_misses={"rate": 0.3})
    assert sum(len(one.names) for one in seen) == pytest.approx(1400, abs=4 * math.sqrt(2000 * 0.21))


def test_noise_grows_with_distance_as_declared() -> None:
    seen = looks([around((5.0, 17.0), (5.0, 47.0))] * 2000, detection_noise={"sigma0": 0.1, "slope": 0.01})
    xy = places(seen).reshape(2000, 2, 2)
    assert xy[:, 0].std(axis=0) == pytest.approx(0.1 + 0.2, rel=0.08)  # 20 m away
    assert xy[:, 1].std(axis=0) == pytest.approx(0.1 + 0.5, rel=0.08)


def test_size_and_yaw_change_the_box_about_its_middle() -> None:
    (seen,) = looks(
        [around((5.0, 20.0))], detection_size={"length_ratio": 1.5, "width_ratio": 0.5}, detection_yaw={"b": 0.2}
    )
    assert seen.boxes[0, :7] == pytest.approx((5.0, 20.0, 0.75, 0.2, 6.0, 0.9, 1.5))


def test_a_car_is_seen_while_little_of_it_is_behind_another() -> None:
    """Seen along y, a car of 4 m 10 m away hides 30 m away what is within about 6.6 m to its sides."""
    for x, count in ((5.0, 1), (25.0, 2)):
        (seen,) = looks([around((5.0, 7.0), (x, 27.0))], detection_occlusion={"share": 0.5})
        assert len(seen.names) == count


def test_misses_grow_with_distance_and_by_class() -> None:
    scene = around((5.0, 17.0))  # 20 m away
    walker = Surroundings(scene.boxes, np.ones(1, dtype=np.int64), scene.names)
    hidden = {"detection_misses": {"rate": 0.1, "slope": 0.01, "pedestrian": 0.3}}
    for one, missed in ((scene, 0.3), (walker, 0.6)):
        count = sum(len(seen.names) for seen in looks([one] * 2000, **hidden))
        assert count == pytest.approx(2000 * (1.0 - missed), abs=4 * math.sqrt(2000 * 0.25))


@pytest.mark.parametrize("name", sorted(TYPICAL))
def test_every_effect_of_perception_shows(name: str) -> None:
    scenes = [around((5.0 + 0.3 * k, 20.0), (5.0, 47.0)) for k in range(500)]  # 50 s
    seen, there = places(looks(scenes, **{name: dict(TYPICAL[name])})), places(scenes)
    assert seen.shape != there.shape or np.abs(seen - there).max() > 0.1  # m


def test_false_objects_appear_at_their_rate_and_stay_for_a_second() -> None:
    """0.5 a second for 400 s, each in 10 looks; the number of a Poisson process of 200 scatters by its root."""
    boxes = places(looks([around()] * 4000, detection_false={"rate": 0.5}))
    found, times = np.unique(boxes, axis=0, return_counts=True)
    assert len(found) == pytest.approx(200, abs=4 * math.sqrt(200))
    assert set(times[:-1]) <= set(range(1, 11))  # those of the last second are cut off
    assert np.median(times) == 1.0 / PERIOD


def test_false_objects_lie_evenly_over_a_disc_of_40_m() -> None:
    """There squared distances are even from 0 to R^2: R^2 / 2 on average, scattering by R^2 / sqrt(12)."""
    found = np.unique(places(looks([around()] * 4000, detection_false={"rate": 0.5})), axis=0)
    squared = ((found - CAR[:2]) ** 2).sum(axis=1)
    assert squared.max() <= 40.0**2
    assert squared.mean() == pytest.approx(40.0**2 / 2, abs=4 * 40.0**2 / math.sqrt(12 * len(found)))


def test_the_same_seed_sees_the_same() -> None:
    scenes = [around((5.0, 20.0))] * 50
    hidden = {"detection_noise": {"sigma0": 0.2}, "detection_false": {"rate": 1.0}}
    first, again, other = (places(looks(scenes, seed, **hidden)) for seed in (3, 3, 4))
    assert first.tobytes() == again.tobytes() != other.tobytes()


def test_a_drive_without_objects_refuses_what_could_not_show(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "hidden.toml"
    file.write_text("[hidden.detection_offset]\nx = 0.5\n")
    assert main(["--hidden", str(file), "--out", str(file.with_name("log.csv"))]) == 2
    said = f"{file}: detection_offset is of what a car on a wire sees; a drive has nothing to see\n"
    assert capsys.readouterr().err == said
    assert main(["--hidden", str(file), "--check"]) == 0
