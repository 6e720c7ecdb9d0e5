"""Distances, headway, deceleration, PET and RSS against closed forms and computations of another kind."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest
from results_logs import drive_straight, log_of, times, track

from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.metrics import MetricError, compute
from pytest_dvp.metrics._box_gaps import distances, gaps, overlap
from pytest_dvp.metrics.responsibility import safe_lateral, safe_longitudinal

CASES = int(os.environ.get("DVP_CASES", "200"))  # random ones of each comparison; `make nightly` takes 10,000
TICKS = np.arange(0.0, 10.01, 0.05)
FRONT, REAR, SIDE = 2.7, -0.3, 0.75  # of results_logs.EGO from its reference point [m]
RSS = {"response_time": 0.5, "max_acceleration": 2.0, "max_braking": 8.0, "min_braking": 4.0}
RSS |= {"lateral_acceleration": 0.5, "lateral_braking": 1.0, "lateral_margin": 0.2}


def boxes(rng: np.random.Generator, n: int, spread: float) -> FloatArray:
    """Random boxes: x, y [m], yaw [rad], length, width [m]."""
    place = rng.uniform(-spread, spread, (n, 2))
    return np.column_stack((place, rng.uniform(-4.0, 4.0, n), rng.uniform(0.3, 6.0, n), rng.uniform(0.3, 3.0, n)))


def outline(box: FloatArray) -> FloatArray:
    """Points of the outline (k, 2) [m] by complex rotation, every 1/400 of an edge."""
    corner = [complex(sx * box[3] / 2, sy * box[4] / 2) for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    turned = [complex(box[0], box[1]) + c * complex(math.cos(box[2]), math.sin(box[2])) for c in corner]
    share = np.linspace(0.0, 1.0, 401)
    line = np.concatenate([a + (b - a) * share for a, b in zip(turned, turned[1:] + turned[:1], strict=True)])
    return np.column_stack((line.real, line.imag))


def edge_distance(box: FloatArray, other: FloatArray) -> float:
    """Least distance of all pairs of edges by projection of each corner on each segment; boxes apart."""
    first, second = outline(box)[::401], outline(other)[::401]
    least = math.inf
    for points, ring in ((first, second), (second, first)):
        for p in points:
            for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                share = min(1.0, max(0.0, float((p - a) @ (b - a)) / float((b - a) @ (b - a))))
                least = min(least, math.dist(p, a + share * (b - a)))
    return least


def inside(points: FloatArray, box: FloatArray) -> FloatArray:
    d = (points[:, 0] - box[0] + 1j * (points[:, 1] - box[1])) * np.exp(-1j * box[2])
    return np.asarray((np.abs(d.real) <= box[3] / 2) & (np.abs(d.imag) <= box[4] / 2))


def test_distance_of_oriented_boxes_is_that_of_their_edges() -> None:
    rng = np.random.default_rng(1)
    some, others = boxes(rng, CASES, 6.0), boxes(rng, CASES, 6.0)
    found, met = distances(some, others), overlap(some, others)
    assert 0.1 < met.mean() < 0.9
    for a, b, least, touch in zip(some, others, found, met, strict=True):
        assert least == (0.0 if touch else pytest.approx(edge_distance(a, b), abs=1e-9))


def test_boxes_overlap_where_an_outline_enters_the_other() -> None:
    rng = np.random.default_rng(2)
    some, others = boxes(rng, CASES, 5.0), boxes(rng, CASES, 5.0)
    met = overlap(some, others)
    for a, b, told in zip(some, others, met, strict=True):
        crossed = bool(inside(outline(a), b).any() or inside(outline(b), a).any())
        assert told == crossed or distances(np.array([a]), np.array([b]))[0] < 0.01


@pytest.mark.parametrize("axis", [0, 1])
def test_gap_in_the_strip_is_that_of_the_outline_within_it(axis: int) -> None:
    rng = np.random.default_rng(3)
    some, others = boxes(rng, CASES, 8.0), boxes(rng, CASES, 8.0)
    found = gaps(some, others, axis)
    assert np.isnan(found).any()
    assert (found > 0.0).any()
    for a, b, gap in zip(some, others, found, strict=True):
        d = (outline(b) - a[:2]) @ np.array([1.0, 1j]) * np.exp(-1j * a[2])
        along, across = (d.real, d.imag) if axis == 0 else (d.imag, d.real)
        part = along[np.abs(across) <= a[4 - axis] / 2]
        if not len(part):
            assert np.isnan(gap) or (gap > -1.0 and np.abs(across).min() < a[4 - axis] / 2 + 0.02)
            continue
        half = a[3 + axis] / 2
        expected = max(part.min() - half, -half - part.max(), 0.0)
        assert gap == pytest.approx(expected, abs=0.05)  # the outline is sampled


def test_distances_ahead_and_beside() -> None:
    # Ahead: rear bumper at 18 m. Beside: from y = 2 m on, passed.
    log = drive_straight(1.0, objects={"ahead": track(TICKS, 20.0, 0.0), "beside": track(TICKS, 5.0, 3.0)})
    values = {
        name: compute(name, log) for name in ("min_distance", "min_distance_longitudinal", "min_distance_lateral")
    }
    assert values["min_distance"].value == pytest.approx(2.0 - SIDE)
    assert values["min_distance"].object == "beside"
    ahead = values["min_distance_longitudinal"]
    assert (ahead.value, ahead.t, ahead.object) == (pytest.approx(18.0 - 10.0 - FRONT), pytest.approx(10.0), "ahead")
    assert values["min_distance_lateral"].value == pytest.approx(2.0 - SIDE)


def test_who_drives_alongside_is_not_passed() -> None:
    beside = track(TICKS, 5.0 * TICKS + 1.2, 3.0, vx=5.0)
    log = drive_straight(5.0, objects={"beside": beside})
    assert compute("min_distance_lateral", log).value == pytest.approx(2.0 - SIDE)
    assert compute("passing_clearance", log).reason == "the ego passed nobody faster than 1 m/s"
    standing = drive_straight(5.0, objects={"parked": track(TICKS, 20.0, -3.0)})
    passed = compute("passing_clearance", standing)
    assert (passed.value, passed.object) == (pytest.approx(2.0 - SIDE), "parked")


def test_headway_and_deceleration_of_a_steady_approach() -> None:
    lead = track(TICKS, 40.0 + 4.0 * TICKS, 0.0, vx=4.0)
    log = drive_straight(6.0, objects={"lead": lead})
    gap = 40.0 - 2.0 - FRONT - (6.0 - 4.0) * 10.0
    assert compute("time_headway", log).value == pytest.approx(gap / 6.0)
    needed = compute("required_deceleration", log)
    assert (needed.value, needed.t, needed.object) == (pytest.approx(2.0**2 / (2.0 * gap)), pytest.approx(10.0), "lead")


def test_what_drives_away_needs_no_deceleration() -> None:
    log = drive_straight(3.0, objects={"lead": track(TICKS, 20.0 + 5.0 * TICKS, 0.0, vx=5.0)})
    assert compute("required_deceleration", log).value == 0.0
    behind = drive_straight(3.0, objects={"behind": track(TICKS, -20.0, 0.0)})
    assert not compute("required_deceleration", behind).valid
    assert not compute("time_headway", behind).valid


def test_required_deceleration_just_avoids_the_contact() -> None:
    """Braking by it in a simulation of its own touches, and a hair more stops short."""
    gap, dv = 12.0, 7.0
    log = log_of(0.1, columns={"v": dv, "vx": dv}, objects={"car": track(np.array([0.0]), FRONT + gap + 2.0, 0.0)})
    needed = compute("required_deceleration", log).value
    assert needed is not None
    for share, hits in ((0.999, True), (1.001, False)):
        t = np.linspace(0.0, dv / (needed * share), 100_001)
        assert (np.max(dv * t - 0.5 * needed * share * t**2) > gap) is np.bool_(hits)


def crossing(delay: float, speed: float = 4.0) -> Log:
    """The ego leaves the walker's way; it enters `delay` [s] later: half a metre of walker, ego 5 m/s."""
    t = times()
    way, leaves = 20.0, (20.0 + 0.25 - REAR) / 5.0
    y = -(SIDE + 0.25) - speed * (leaves + delay - TICKS)
    walker = track(TICKS, way, y, vy=speed, size=(0.5, 0.5), kind="pedestrian")
    return log_of(10.0, columns={"x": 5.0 * t, "v": 5.0, "vx": 5.0}, objects={"walker": walker})


@pytest.mark.parametrize("delay", [0.3, 1.0, 2.5])
def test_pet_of_a_crossing(delay: float) -> None:
    found = compute("pet", crossing(delay))
    assert delay <= found.value + 1e-9 <= delay + 0.1 + 1e-9  # two ends, a step each
    assert found.object == "walker"


def test_pet_is_the_least_of_all_pairs_of_instants() -> None:
    from pytest_dvp.metrics._encroachment import least_time

    rng = np.random.default_rng(4)
    n, met = 40, 0
    first, second = (index.ravel() for index in np.indices((n, n)))
    for _ in range(max(20, CASES // 10)):
        t = np.cumsum(rng.uniform(0.04, 0.06, n))
        tracks = []
        for length, width, start in ((3.0, 1.5, 0.0), (1.0, 0.5, rng.uniform(0.0, 8.0))):
            place = np.cumsum(rng.normal(0.2, 0.1, (n, 2)), axis=0) + np.array([start, -start])
            tracks.append(np.column_stack((place, rng.uniform(-3.0, 3.0, n), np.tile((length, width), (n, 1)))))
        touched = overlap(tracks[0][first], tracks[1][second])
        apart = np.abs(t[first] - t[second])[touched]
        found, _ = least_time(t, *tracks, 10.0)
        met += len(apart) > 0
        assert found == (pytest.approx(apart.min()) if len(apart) else math.inf)
    assert met > 3


def test_a_contact_has_pet_0_and_apart_ways_none() -> None:
    assert compute("pet", drive_straight(2.0, objects={"car": track(TICKS, 10.0, 0.0)})).value == 0.0
    assert not compute("pet", drive_straight(2.0, objects={"car": track(TICKS, 10.0, 8.0)})).valid


def test_rss_follows_from_braking_it_out() -> None:
    """The safe distance is the greatest loss of gap of a simulated worst case."""
    rng = np.random.default_rng(5)
    rho, a, b_min, b_max = 0.6, 2.0, 4.0, 8.0
    dt = 1e-3
    for rear, front in rng.uniform(0.0, 20.0, (CASES, 2)):
        stop_r, stop_f = rho + (rear + rho * a) / b_min, front / b_max
        t = np.arange(0.0, max(stop_r, stop_f) + dt, dt)
        v_r = np.where(t < rho, rear + a * t, np.maximum(rear + rho * a - b_min * (t - rho), 0.0))
        v_f = np.maximum(front - b_max * t, 0.0)
        lost = float(np.trapezoid(v_r - v_f, t))  # until both stand
        found = safe_longitudinal(np.array([rear]), np.array([front]), rho, a, b_min, b_max)[0]
        assert found == pytest.approx(max(lost, 0.0), abs=0.02)


def test_rss_of_two_who_meet_and_of_two_side_by_side() -> None:
    # Each: 10 * 0.5 + 0.5 * 2 * 0.25 + 11^2 / 8 = 5 + 0.25 + 15.125
    meet = safe_longitudinal(np.array([10.0]), np.array([-10.0]), 0.5, 2.0, 4.0, 8.0)
    assert meet[0] == pytest.approx(2 * 20.375)
    # At rest laterally both move towards each other: 2 * (0.5 * 0.5 * 0.5^2 + 0.25^2 / 2) + 0.2
    side = safe_lateral(np.zeros(1), np.zeros(1), 0.5, 0.5, 1.0, 0.2)
    assert side[0] == pytest.approx(0.2 + 2 * (0.0625 + 0.03125))


@pytest.mark.parametrize("rest", [-1e-12, 0.0, 1e-12])
def test_rss_does_not_depend_on_the_rounding_of_a_standstill(rest: float) -> None:
    """One that stands meets what comes towards its front, whatever sign its speed of 0 has: definition 2."""
    comes = track(TICKS, 14.0 - 1.0 * TICKS, 0.0, vx=-1.0)
    found = compute("rss_violation", drive_straight(rest, objects={"comes": comes}), **RSS)
    # 0.5 s of response at +2 m/s^2 and braking by 4 m/s^2, of 0 m/s and of 1 m/s: 0.25 + 0.125 and 0.75 + 0.5 m.
    need = 0.375 + 1.25
    begins = 14.0 - 2.0 - FRONT - need
    assert found.value == pytest.approx(10.0 - begins, abs=0.051)


def test_rss_counts_the_time_below_both_distances_and_needs_its_parameters() -> None:
    gap = 5.0
    log = drive_straight(10.0, objects={"lead": track(TICKS, FRONT + gap + 2.0 + 10.0 * TICKS, 0.0, vx=10.0)})
    found = compute("rss_violation", log, **RSS)  # need: 5 + 0.25 + 15.125 - 6.25 = 14.125 m
    assert (found.value, found.object) == (pytest.approx(10.0), "lead")
    assert found.extra["greatest shortfall along"] == pytest.approx(14.125 - gap)
    beside = drive_straight(10.0, objects={"beside": track(TICKS, 10.0 * TICKS, 4.0, vx=10.0)})
    assert compute("rss_violation", beside, **RSS).value == 0.0
    missing = compute("rss_violation", log, **{k: v for k, v in RSS.items() if k != "min_braking"})
    assert missing.reason == "RSS parameters are not declared: min_braking"
    with pytest.raises(MetricError, match=r"'max_braking' .* must be > 0, found 0$"):
        compute("rss_violation", log, **{**RSS, "max_braking": 0.0})
