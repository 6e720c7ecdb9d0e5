"""Detections and the objects they belong to, and latency, offset and noise of what lies between them."""

from __future__ import annotations

from math import inf, log
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.perception.detection_pairs import Frames, Pairs, _period, frames, paired
from pytest_dvp.gap.perception.diagnose_perception import perceived_in
from pytest_dvp.gap.perception.position_fit import Positions, _clustered, _noise
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import DetectionTable, FloatArray, ObjectTrack


def boxes(t: Any, x: Any, y: Any) -> DetectionTable:
    t = np.asarray(t, dtype=float)
    one = np.ones(len(t))
    return DetectionTable(t, ("misc",) * len(t), np.asarray(x, dtype=float), np.asarray(y, dtype=float), 0.0 * one, one,
                          one, 0.0 * one, 0.0 * one)  # fmt: skip


def a_track(t: Any, x: Any, y: Any, length: float = 4.0) -> ObjectTrack:
    t = np.asarray(t, dtype=float)
    none = np.zeros(len(t))
    return ObjectTrack("vehicle", length, 1.8, 1.5, t, none + x, none + y, none, none, none, none)


def a_log(objects: dict[str, ObjectTrack], found: DetectionTable, seconds: float = 10.0, **ego: Any) -> Log:
    t = np.arange(0.0, seconds, 0.1)
    columns = {"t": t} | {name: 0.0 * t + ego.get(name, 0.0) for name in ("x", "y", "yaw")}
    return Log(columns, objects=objects, detections=found)


def test_frames_go_from_the_first_to_the_last_detection_and_are_filled_in() -> None:
    log_ = a_log({}, boxes([1.0, 1.1, 1.1, 1.2, 1.5, 1.6], [0.0] * 6, [0.0] * 6))
    found = frames(log_)
    assert found is not None
    assert found.t == pytest.approx([1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6])
    assert found.row.tolist() == [0, 1, 1, 2, 5, 6]
    assert (found.period, found.duration) == (pytest.approx(0.1), pytest.approx(0.7))
    assert frames(a_log({}, boxes([1.0, 1.0], [0.0, 0.0], [0.0, 0.0]))) is None
    two = frames(a_log({}, boxes([1.0, 1.2], [0.0, 0.0], [0.0, 0.0])))
    assert two is not None
    assert two.t.tolist() == [1.0, 1.2]
    pause = frames(a_log({}, boxes([1.0, 1.1, 1.2, 500.0], [0.0] * 4, [0.0] * 4)))
    assert pause is not None
    assert len(pause.t) == 4 + 1000
    assert np.diff(pause.t[2:]) == pytest.approx(498.8 / 1001)


def test_boxes_of_one_look_may_each_have_a_stamp_of_their_own() -> None:
    """Three boxes 2 ms apart every 0.1 s; 6 ms on is another look."""
    stamps = [1.0, 1.002, 1.004, 1.1, 1.102, 1.104, 1.2, 1.202, 1.206]
    found = frames(a_log({}, boxes(stamps[:8], [0.0] * 8, [0.0] * 8)))
    assert found is not None
    assert found.t == pytest.approx([1.0, 1.1, 1.2])
    assert found.row.tolist() == [0, 0, 0, 1, 1, 1, 2, 2]
    more = frames(a_log({}, boxes(stamps, [0.0] * 9, [0.0] * 9)))
    assert more is not None
    assert more.t[-2:] == pytest.approx([1.2, 1.206])


def test_looks_are_found_where_most_of_them_show_nothing() -> None:
    """10 Hz, but only two looks in a row of every five show a box, or of every three one: 0.1 s apart all the same."""
    looks = np.array([k for k in range(60) if k % 10 in {0, 1, 4, 7}])
    found = frames(a_log({}, boxes(0.1 * looks, 0.0 * looks, 0.0 * looks)))
    assert found is not None
    assert found.period == pytest.approx(0.1)
    assert found.t == pytest.approx(0.1 * np.arange(58))
    assert found.row.tolist() == looks.tolist()


def asked(objects: dict[str, ObjectTrack], found: DetectionTable, latency: float = 0.0, offset: Any = (0.0, 0.0),
          gate: tuple[float, float] = (1.0, 0.0), **ego: Any) -> Pairs:  # fmt: skip
    f = frames(a_log(objects, found, **ego))
    assert f is not None
    return paired(f, latency, offset, gate)


TIMES = np.arange(0.0, 10.0, 0.1)


def test_a_box_lies_where_the_object_was_a_latency_ago_and_an_offset_aside() -> None:
    """An ego at (3, 1) that looks along y: forward is y, left is -x."""
    objects = {"a": a_track(TIMES, 20.0 + 5.0 * TIMES, 4.0 - 2.0 * TIMES)}
    p = asked(objects, boxes([2.0, 3.0], [26.0, 31.0], [2.0, 0.0]), 0.5, (0.3, -0.2), (3.0, 0.0),
              x=3.0, y=1.0, yaw=0.5 * np.pi)  # fmt: skip
    assert p.seen.all()
    assert p.there.all()
    assert p.row[:, 0].tolist() == [0, 1]
    for i, t in enumerate((1.5, 2.5)):
        x, y = 20.0 + 5.0 * t, 4.0 - 2.0 * t
        assert (p.dx[i, 0], p.dy[i, 0]) == pytest.approx((26.0 + 5.0 * i - x - 0.2, 2.0 - 2.0 * i - y - 0.3))
        assert (p.vx[i, 0], p.vy[i, 0]) == pytest.approx((5.0, -2.0))
        assert p.distance[i, 0] == pytest.approx(np.hypot(x - 3.0, y - 1.0))
        assert p.bearing[i, 0] == pytest.approx(np.arctan2(y - 1.0, x - 3.0) - 0.5 * np.pi)
    assert p.yaw == pytest.approx(0.5 * np.pi)
    still = asked({"a": a_track([2.0], 5.0, 0.0)}, boxes([2.0, 2.1], [5.0, 5.0], [0.0, 0.0]))
    assert (still.vx[0, 0], still.vy[0, 0]) == (0.0, 0.0)
    assert still.there[:, 0].tolist() == [True, False]


@pytest.mark.parametrize(("off", "seen"), [(1.99, True), (2.01, False)])
def test_a_box_beyond_the_gate_is_none_of_the_objects(off: float, seen: bool) -> None:
    """The gate is 1 m at the ego and grows by 0.1 of the distance, here 10 m."""
    objects = {"a": a_track(TIMES, 10.0, 0.0)}
    p = asked(objects, boxes([1.0, 1.1], [10.0, 10.0], [off, 0.0]), gate=(1.0, 0.1))
    assert p.seen[:, 0].tolist() == [seen, True]
    assert np.isnan(p.dx[0, 0]) == (not seen)


def test_boxes_belong_to_the_objects_with_the_least_sum_of_distances() -> None:
    objects = {"a": a_track(TIMES, 10.0, 0.0), "b": a_track(TIMES, 10.0, 1.0)}
    p = asked(objects, boxes([1.0, 1.0, 1.1], [10.0] * 3, [0.9, 1.8, 0.0]), gate=(2.0, 0.0))
    assert p.row[0].tolist() == [0, 1]
    assert p.row[1].tolist() == [2, -1]


def test_a_box_that_belongs_to_none_takes_no_other_box_away_from_its_object() -> None:
    """Whatever lies beyond the gate of 1 m counts as 1 m: 0.5 and 1 are less than twice 0.9, 0.5 and 2.3 are not."""
    objects = {"a": a_track(TIMES, 0.5, 0.0), "b": a_track(TIMES, -0.9, 0.0)}
    p = asked(objects, boxes([1.0, 1.0, 1.1], [0.0, 1.4, 0.5], [0.0] * 3))
    assert p.row.tolist() == [[0, -1], [2, -1]]


@pytest.mark.parametrize(("late", "seen", "false"), [(0.29, True, 0), (0.31, False, 0)])
def test_an_object_that_has_only_just_come_is_neither_seen_nor_false(late: float, seen: bool, false: int) -> None:
    """It came at 1.0 s; a box at 1.3 s shows it as it was by the latency before."""
    objects = {"a": a_track(TIMES[10:], 10.0, 0.0)}
    p = asked(objects, boxes([1.3, 1.4, 1.5], [10.0] * 3, [0.0] * 3), late)
    assert (bool(p.seen[0, 0]), p.false) == (seen, false)
    gone = asked({"a": a_track(TIMES[:10], 10.0, 0.0)}, boxes([1.3, 1.4], [10.0] * 2, [0.0] * 2))
    assert (gone.seen.any(), gone.there.any(), gone.false) == (False, False, 1)
    early = asked(objects, boxes([0.5, 1.5], [10.0] * 2, [0.0] * 2))
    assert (early.seen[:, 0].tolist(), early.false) == ([False, True], 1)


@pytest.mark.parametrize(("away", "false"), [(4.49, 0), (4.51, 1)])
def test_a_second_box_near_an_object_is_its_double(away: float, false: int) -> None:
    """Within 1 m of its ends (2 m from its middle) and 0.15 of its distance, here 10 m."""
    objects = {"a": a_track(TIMES, 10.0, 0.0)}
    p = asked(objects, boxes([1.0, 1.0, 1.1], [10.0] * 3, [0.0, away, 0.0]))
    assert (p.seen.tolist(), p.false) == ([[True], [True]], false)


def pairs(bearing: Any, distance: Any, seen: Any, hidden: Any = 0.0, there: Any = True) -> Pairs:
    bearing = np.atleast_2d(np.asarray(bearing, dtype=float))
    shape = bearing.shape
    full = {name: np.zeros(shape) for name in ("dx", "dy", "vx", "vy")}
    return Pairs(there=np.zeros(shape, dtype=bool) | there, seen=np.zeros(shape, dtype=bool) | seen,
                 row=np.zeros(shape, dtype=np.int64), hidden=np.zeros(shape) + hidden,
                 distance=np.zeros(shape) + distance, bearing=bearing, yaw=np.zeros(1), false=0, **full)  # fmt: skip


@pytest.mark.parametrize(("found", "looks"), [(2, True), (1, False)])
def test_a_detector_looks_where_it_sees_a_fifth_of_what_it_usually_sees(found: int, looks: bool) -> None:
    """Ten objects ahead, and one to the left that is seen: sectors of 15 degrees, counted from 0. The usual share is
    0.55 for one of ten and one of one, and a fifth of it is 0.11; for two of ten 0.47 and 0.09."""
    bearing = [*[0.1] * 10, 1.6, -0.1]
    seen = [*[True] * found, *[False] * (10 - found), True, False]
    assert pairs(bearing, 10.0, seen).in_field_of_view()[0].tolist() == [*[looks] * 10, True, False]


def test_a_detector_that_misses_nearly_all_still_looks_everywhere() -> None:
    """One of ten ahead is seen and one of twelve to the left; behind nothing is. A fifth is of what it usually sees."""
    bearing = [*[0.1] * 10, *[1.6] * 12, *[3.0] * 10]
    seen = [k in {3, 15} for k in range(32)]
    assert pairs(bearing, 10.0, seen).in_field_of_view()[0].tolist() == [*[True] * 22, *[False] * 10]


ROUND = [-2.5, -1.6, -0.5, 0.5, 1.6, 2.5]


@pytest.mark.parametrize("k", range(len(ROUND)))
@pytest.mark.parametrize("turns", [-1, 0, 1, 2])
def test_a_detector_that_looks_to_one_side_does_not_look_to_another(k: int, turns: int) -> None:
    """A bearing is the same whatever whole turns are in it."""
    bearing = [*ROUND[:k], ROUND[k] + 2.0 * np.pi * turns, *ROUND[k + 1 :]]
    seen = [j == k for j in range(len(ROUND))]
    assert pairs(bearing, 10.0, seen).in_field_of_view()[0].tolist() == seen


@pytest.mark.parametrize("ego", [(0.0, 0.0), (7.0, 50.0), (-30.0, 4.0)])
def test_who_is_behind_another_one_is_hidden_wherever_the_ego_is(ego: tuple[float, float]) -> None:
    """Ahead of it at 10 m and 20 m, and one as far away to the left."""
    x, y = ego
    objects = {
        "near": a_track(TIMES, x + 10.0, y),
        "far": a_track(TIMES, x + 20.0, y),
        "left": a_track(TIMES, x, y + 20.0),
    }
    p = asked(objects, boxes([1.0, 1.1], [x, x], [y, y]), x=x, y=y)
    assert p.hidden.tolist() == [[0.0, 1.0, 0.0]] * 2


def test_the_field_of_view_is_told_by_what_is_near_and_in_clear_view() -> None:
    """Of ten in a sector one is seen. What is beyond all that was seen, hidden or absent counts for nothing."""
    seen = [True, *[False] * 9]
    far = [10.0, *[9.0] * 4, *[11.0] * 5]
    assert pairs([0.1] * 10, far, seen).in_field_of_view().all()
    hidden = [0.0, *[0.05] * 4, *[0.051] * 5]
    assert pairs([0.1] * 10, 9.0, seen, hidden=hidden).in_field_of_view().all()
    assert not pairs([0.1] * 10, 9.0, seen, hidden=[0.051, *[0.0] * 9]).in_field_of_view().any()
    there = np.arange(10) < 5
    assert pairs([0.1] * 10, 9.0, seen, there=there).in_field_of_view()[0].tolist() == there.tolist()
    assert not pairs([0.1] * 10, 9.0, False).in_field_of_view().any()
    edge = np.pi / 12.0
    two = pairs([edge - 0.001, edge + 0.001, 2.0 * np.pi + 0.001, -0.001], 9.0, [True, False, False, False])
    assert two.in_field_of_view()[0].tolist() == [True, False, True, False]


def test_errors_within_a_block_depend_on_each_other() -> None:
    bread = np.array([[2.0, 0.3], [0.3, 1.0]])
    scores = np.random.default_rng(0).normal(size=(9, 2))
    blocks = np.array([0, 0, 0, 1, 1, 1, 2, 2, 2])
    sums = np.array([scores[blocks == k].sum(axis=0) for k in range(3)])
    clustered = bread @ sum(np.outer(s, s) for s in sums) @ bread * 1.5
    plain = bread @ sum(np.outer(s, s) for s in scores) @ bread
    expected = np.sqrt(np.maximum(np.diag(clustered), np.diag(plain)))
    assert _clustered(bread, scores, blocks) == pytest.approx(expected)
    same = np.repeat([[1.0, -1.0]], 9, axis=0)
    assert _clustered(np.eye(2), same, blocks) == pytest.approx(np.sqrt(27.0 * 1.5))
    one = _clustered(np.eye(2), same, np.zeros(9, dtype=np.int64))
    assert one == pytest.approx(9.0)
    apart = np.array([[1.0], [-1.0]] * 3)
    assert _clustered(np.eye(1), apart, np.repeat([0, 1, 2], 2)) == pytest.approx(np.sqrt(6.0))


def likelihood(rest: FloatArray, far: FloatArray, sigma0: float, slope: float) -> float:
    level = sigma0 + slope * far
    return float(-(np.log(level) + 0.5 * (rest / level) ** 2).sum())


@pytest.mark.parametrize(("sigma0", "slope"), [(0.3, 0.02), (0.2, 0.0), (0.0, 0.03)])
def test_noise_that_grows_with_distance_is_that_of_greatest_likelihood(sigma0: float, slope: float) -> None:
    rng = np.random.default_rng(4)
    far = rng.uniform(5.0, 60.0, 4000)
    rest = np.clip(rng.normal(size=4000), -2.9, 2.9) * (sigma0 + slope * far)
    found, spread = _noise(rest, far, np.repeat(np.arange(400), 10))
    assert found == pytest.approx([sigma0, slope], abs=0.02)
    assert (found >= 0.0).all()
    best = likelihood(rest, far, *found)
    for moved in ((0.004, 0.0), (-0.004, 0.0), (0.0, 2e-4), (0.0, -2e-4)):
        other = found + moved
        assert (other < 0.0).any() or likelihood(rest, far, *other) < best
    level = found[0] + found[1] * far
    x = np.column_stack([np.ones(4000), far])
    expected = np.sqrt(np.diag(np.linalg.inv((x * (2.0 / level**2)[:, None]).T @ x)))
    assert spread == pytest.approx(expected, rel=0.25)


def test_a_box_far_off_counts_as_four_standard_deviations() -> None:
    """At a constant distance the variance is the mean of squares, none above (4 sigma)^2."""
    rest = np.concatenate([np.tile([1.0, -1.0], 95), np.full(10, 50.0)])
    found, _ = _noise(rest, np.full(200, 10.0), np.arange(200))
    sigma = found[0] + 10.0 * found[1]
    assert sigma**2 == pytest.approx((190 * 1.0 + 10 * 16.0 * sigma**2) / 200.0, rel=1e-4)


def test_distances_below_a_metre_are_not_scaled_up() -> None:
    """Errors of 1 m everywhere: sigma0 + slope distance becomes 1, from half of 1.4826 for each of the two on. At 0.5 m
    that begins with 0.7413 * 1.5 = 1.11195, and the shortest way along (1, 0.5) is 0.11195 / 1.25 = 0.08956 long."""
    rest = np.tile([1.0, -1.0], 50)
    found, _ = _noise(rest, np.full(100, 0.5), np.arange(100))
    assert found == pytest.approx([0.7413 - 0.08956, 0.7413 - 0.5 * 0.08956], abs=1e-5)
    found, _ = _noise(rest, np.zeros(100), np.arange(100))
    assert found[0] == pytest.approx(1.0)


def drive(n: int, latency: float, offset: tuple[float, float], sigma: float, seed: int = 0, move: float = 8.0) -> Any:
    """n frames of 10 Hz with two objects, one that crosses and one ahead, and an ego that turns slowly."""
    rng = np.random.default_rng(seed)
    t, yaw = 0.1 * np.arange(n), 0.02 * np.arange(n)
    vx, vy = np.column_stack([0.0 * t + move, 0.5 * move * np.sin(t)]), np.column_stack([move * np.cos(t), 0.0 * t])
    c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    dx = -latency * vx + c * offset[0] - s * offset[1] + sigma * rng.normal(size=(n, 2))
    dy = -latency * vy + s * offset[0] + c * offset[1] + sigma * rng.normal(size=(n, 2))
    full = np.ones((n, 2), dtype=bool)
    f = Frames(t, 0.1, np.zeros(0, dtype=np.int64), t, t, Log({"t": t}))
    far = np.tile([20.0, 25.0], (n, 1))
    return f, Pairs(full, full, np.zeros((n, 2), dtype=np.int64), 0.0 * dx, dx, dy, vx, vy, far, 0.0 * dx, yaw, 0)


def test_latency_and_offset_are_those_of_least_squares() -> None:
    f, p = drive(300, 0.2, (0.4, -0.3), 0.05)
    found = Positions(f, p, np.array([0.05, 0.0]))
    assert found.step == pytest.approx([0.2, 0.4, -0.3], abs=0.01)
    x = np.column_stack([
        -np.concatenate([p.vx.ravel(), p.vy.ravel()]),
        np.concatenate([np.repeat(np.cos(p.yaw), 2), np.repeat(np.sin(p.yaw), 2)]),
        np.concatenate([np.repeat(-np.sin(p.yaw), 2), np.repeat(np.cos(p.yaw), 2)]),
    ])  # fmt: skip
    e = np.concatenate([p.dx.ravel(), p.dy.ravel()])
    assert found.step == pytest.approx(np.linalg.lstsq(x, e, rcond=None)[0], abs=2e-3)  # a few boxes pull less
    assert found.rest == pytest.approx(e - x @ found.step)
    plain = 0.05 * np.sqrt(np.diag(np.linalg.inv(x.T @ x)))
    assert np.all((found.spread > 0.6 * plain) & (found.spread < 2.0 * plain))
    assert found.noise[0] + 22.5 * found.noise[1] == pytest.approx(0.05, rel=0.05)
    assert len(np.unique(found.blocks)) == 6 * 2  # of each object, each 5 s
    assert found.far.tolist() == [20.0, 25.0] * 300


def test_boxes_far_off_pull_no_more_than_at_two_and_a_half_standard_deviations() -> None:
    """A constant offset along x, one box in ten 5 m off: Huber's mean has sum of clipped residuals 0."""
    f, p = drive(100, 0.0, (0.0, 0.0), 0.1, move=0.0)
    p.yaw[:] = 0.0
    p.dx[::10] += 5.0
    found = Positions(f, p, np.array([0.1, 0.0]))
    rest = np.clip((p.dx.ravel() - found.step[1]) / 0.1, -2.5, 2.5)
    assert abs(rest.sum()) < 0.02 * len(rest)
    assert found.spread[0] == inf
    assert found.step[0] == 0.0


@pytest.mark.parametrize(("speed", "told"), [(0.06, True), (0.04, False)])
def test_latency_shows_only_with_objects_that_move(speed: float, told: bool) -> None:
    f, p = drive(100, 0.0, (0.0, 0.0), 0.05)
    p.vx[:], p.vy[:] = speed, speed
    assert np.isfinite(Positions(f, p, np.array([0.05, 0.0])).spread[0]) == told


def test_what_is_lost_without_a_value_is_the_likelihood_that_it_brings() -> None:
    f, p = drive(200, 0.1, (0.4, 0.0), 0.2)
    found = Positions(f, p, np.array([0.2, 0.0]))
    full = found.rest / found.level
    e = found.rest + found.x @ found.step
    for without in ((0,), (1, 2), (0, 1, 2)):
        kept = [k for k in range(3) if k not in without]
        w = found.x[:, kept] / found.level[:, None]
        y = e / found.level
        left = y - w @ (np.linalg.pinv(w) @ y) if kept else y
        clipped = np.clip(left, -20.0, 20.0)
        expected = 0.5 * float(clipped @ clipped - full @ full)
        assert found.loss(found.step, without) == pytest.approx(expected, rel=1e-6)
    assert found.loss(np.zeros(3), (0, 1, 2)) == 0.0
    huge = found.loss(np.array([0.0, 1e3, 0.0]), (0, 1, 2))  # all but a few rows are beyond 20 standard deviations
    assert huge == pytest.approx(0.5 * 400.0 * len(found.rest), rel=0.05)


def test_noise_is_worth_what_it_brings_over_the_finest_detector() -> None:
    f, p = drive(100, 0.0, (0.0, 0.0), 0.2)
    found = Positions(f, p, np.array([0.2, 0.0]))
    fine = -(0.5 * np.clip(found.rest / 0.02, -20.0, 20.0) ** 2 + log(0.02)).sum()
    coarse = -(0.5 * (found.rest / found.level) ** 2 + np.log(found.level)).sum()
    assert found.noise_worth() == pytest.approx(coarse - fine)
    f, p = drive(100, 0.0, (0.0, 0.0), 0.001)
    clean = Positions(f, p, np.array([0.2, 0.0]))
    assert clean.level == pytest.approx(0.02)
    assert clean.noise_worth() == pytest.approx(0.0, abs=1e-9)


def test_the_interval_of_a_share_of_misses_ends_at_all_of_them() -> None:
    """Seen in all looks of 5 s and missed in nearly all of the next 5: two blocks, of which Student's t allows 12.7
    standard deviations."""
    t = np.append(np.arange(50) * 0.1, 9.9)
    found = perceived_in(a_log({"a": a_track(TIMES, 10.0, 0.0)}, boxes(t, np.full(51, 10.0), np.zeros(51))))
    assert found is not None
    value, low, high = found.values["detection_misses", "rate"]
    assert (value, low, high) == (pytest.approx(0.49), 0.0, 1.0)


@pytest.mark.parametrize("share", [0.15, 0.3, 0.45])
def test_two_sensors_that_look_in_turns_are_no_detector_that_misses_half(share: float) -> None:
    """LiDAR every 0.1 s, a camera between some of its looks: the time between looks stays that of the LiDAR."""
    rng = np.random.default_rng(5)
    between: list[float] = []
    for extra in rng.random(2000) < share / (2.0 - share):  # of all gaps, `share` are short
        between += [0.05, 0.05] if extra else [0.1]
    assert _period(np.array(between)) == pytest.approx(0.1)


@pytest.mark.parametrize("empty", [0.6, 0.8])
def test_a_detector_that_mostly_shows_nothing_has_the_time_of_its_single_looks(empty: float) -> None:
    """The number of looks from one with a box to the next is geometrically distributed: one is the most frequent."""
    gaps = 0.1 * np.random.default_rng(6).geometric(1.0 - empty, 2000)
    assert _period(gaps) == pytest.approx(0.1)
