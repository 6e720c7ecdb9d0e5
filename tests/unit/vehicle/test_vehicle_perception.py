"""Effects of perception: what they make of object tracks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vehicle.messages import FloatArray
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.perception_effects import TRACK_COLUMNS, Tracks, apply_perception_effects
from vehicle.model.vehicle_model import AppliedEffect

PERCEPTION = [e for e in catalogue().values() if e.slot == "perception"]


def crossing(speed: float = 2.0, seconds: float = 60.0) -> Tracks:
    """One object that walks left across the way, 20 m ahead of an ego that stands at (1, 2) and looks along y."""
    t = np.arange(round(seconds * 20)) / 20
    n, nought = len(t), np.zeros(len(t))
    return Tracks(
        t=t,
        object=np.zeros(n, dtype=np.int64),
        x=1.0 - speed * (t - 5.0),
        y=np.full(n, 22.0),
        yaw=np.full(n, np.pi),
        vx=np.full(n, -speed),
        vy=nought,
        ego_x=np.full(n, 1.0),
        ego_y=np.full(n, 2.0),
        ego_yaw=np.full(n, np.pi / 2),
    )


def seen(name: str, values: dict[str, float], tracks: Tracks, seed: int = 1) -> Tracks:
    effect = catalogue()[name]
    return apply_perception_effects(
        [AppliedEffect(effect, effect.complete(values))], tracks, np.random.default_rng(seed)
    )


def forward(tracks: Tracks) -> FloatArray:
    return tracks.y - tracks.ego_y  # the ego looks along y


@pytest.mark.parametrize("effect", PERCEPTION, ids=lambda e: e.name)
def test_neutral_values_show_what_is_there(effect: object) -> None:
    name = effect.name  # type: ignore[attr-defined]
    tracks = crossing()
    shown = seen(name, catalogue()[name].neutral(), tracks)
    assert all((getattr(shown, c) == getattr(tracks, c)).all() for c in TRACK_COLUMNS)


@pytest.mark.parametrize("effect", PERCEPTION, ids=lambda e: e.name)
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_finite_over_the_whole_range_and_for_no_object_at_all(effect: object, share: float) -> None:
    found = catalogue()[effect.name]  # type: ignore[attr-defined]
    values = {k.name: k.low + share * (k.high - k.low) for k in found.parameters}
    for tracks in (crossing(), crossing().rows(np.zeros(1200, dtype=bool))):
        shown = seen(found.name, values, tracks)
        assert all(np.isfinite(getattr(shown, c)).all() for c in TRACK_COLUMNS)


def test_a_late_object_is_where_it_was() -> None:
    shown = seen("detection_latency", {"T": 0.31}, crossing(2.0))
    assert shown.t[0] == pytest.approx(0.35)  # the first stamp 0.31 s after the object was first there
    assert np.abs(shown.x - (1.0 - 2.0 * (shown.t - 0.31 - 5.0))).max() < 1e-12


def test_lateness_keeps_objects_apart() -> None:
    one, other = crossing(2.0, 3.0), replace(crossing(1.0, 3.0), object=np.ones(60, dtype=np.int64))
    both = Tracks(*(np.concatenate((getattr(one, c), getattr(other, c))) for c in TRACK_COLUMNS))
    shown = seen("detection_latency", {"T": 0.2}, both.rows(np.argsort(both.t, kind="stable")))
    alone = seen("detection_latency", {"T": 0.2}, other)
    assert (shown.x[shown.object == 1] == alone.x).all()


def test_an_offset_is_in_the_egos_frame() -> None:
    tracks = crossing()
    shown = seen("detection_offset", {"x": 0.5, "y": 0.2}, tracks)
    assert np.abs(forward(shown) - forward(tracks) - 0.5).max() < 1e-12
    assert np.abs(shown.x - tracks.x + 0.2).max() < 1e-12  # left of an ego that looks along y


def test_the_range_ends_at_its_radius() -> None:
    shown = seen("detection_range", {"R": 25.0}, crossing())
    assert shown.distance().max() <= 25.0
    assert np.hypot(20.0, 15.0) == 25.0
    assert np.abs(shown.x - 1.0).max() == pytest.approx(15.0, abs=0.1)


def test_misses_are_the_share_of_frames_that_was_asked_for() -> None:
    shown = seen("detection_misses", {"rate": 0.3}, crossing())
    assert len(shown.t) == pytest.approx(0.7 * 1200, abs=4 * np.sqrt(1200 * 0.21))


def test_false_objects_come_at_their_rate_and_are_marked() -> None:
    shown = seen("detection_false", {"rate": 5.0}, crossing())
    false = shown.object == -1
    assert false.sum() == pytest.approx(300, abs=4 * np.sqrt(300))
    assert shown.distance()[false].max() <= 50.0
    assert (np.diff(shown.t) >= 0.0).all()


def test_noise_grows_with_distance_as_declared() -> None:
    tracks = crossing(0.0)
    near = replace(tracks, x=np.full(1200, 1.0), y=np.full(1200, 12.0))
    far = replace(tracks, x=np.full(1200, 1.0), y=np.full(1200, 52.0))
    values = {"sigma0": 0.1, "slope": 0.01}
    for distance, there in ((10.0, near), (50.0, far)):
        error = forward(seen("detection_noise", values, there)) - distance
        assert error.std() == pytest.approx(0.1 + 0.01 * distance, rel=0.1)


def test_same_seed_same_tracks() -> None:
    one, other = (seen("detection_noise", {"sigma0": 0.2}, crossing(), seed=4) for _ in range(2))
    assert one.x.tobytes() == other.x.tobytes()


def test_effects_of_the_car_do_not_touch_tracks() -> None:
    tracks = crossing()
    assert seen("steer_delay", {"T": 0.2}, tracks) is tracks
