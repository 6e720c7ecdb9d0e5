"""Compiled geometry and small decisions of metrics, on figures that can be drawn on paper."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from results_logs import log_of, times

from pytest_dvp.logs.log_contents import LogEvent
from pytest_dvp.logs.undefined import Undefined
from pytest_dvp.metrics._box_collision_time import EDGE_TOLERANCE, _first_hit, time_to_collision
from pytest_dvp.metrics._box_touch import touch
from pytest_dvp.metrics._encroachment import least_time
from pytest_dvp.metrics._low_pass import low_pass
from pytest_dvp.metrics._polyline import gather, lateral_offsets
from pytest_dvp.metrics.responsibility import safe_lateral, safe_longitudinal
from pytest_dvp.metrics.traffic_light import _lights, is_green, is_red, red_light, start_up_delay, stop_line

QUARTER = 0.5 * math.pi
BESIDE = 2.0 + 0.5 * EDGE_TOLERANCE

# --- lines


@pytest.mark.parametrize(("reach", "found"), [(3.9, []), (4.1, [1]), (5.1, [0, 1]), (100.0, [0, 1])])
def test_which_segments_begin_near(reach: float, found: list[int]) -> None:
    """From (3, 4): (0, 0) is 5 m away, (3, 0) 4 m; no segment begins at the end of the line."""
    line, close = np.array([[0.0, 0.0], [3.0, 0.0], [9.0, 0.0]]), np.zeros(2, dtype=np.int64)
    assert close[: gather(3.0, 4.0, line, reach, 6.0, close)].tolist() == found


@pytest.mark.parametrize(
    ("point", "offset"),
    [((5.0, 2.0), 2.0), ((5.0, -2.0), -2.0), ((0.0, 1.0), 1.0), ((-0.1, 1.0), math.nan), ((10.0, 3.0), 0.0),
     ((10.0, 20.1), math.nan), ((8.0, 12.0), 2.0), ((13.0, 12.0), -3.0), ((12.0, -1.0), -math.hypot(2.0, 1.0))],
)  # fmt: skip
@pytest.mark.parametrize("shift", [(0.0, 0.0), (100.0, -40.0)])
def test_an_offset_from_a_bent_line(point: tuple[float, float], offset: float, shift: tuple[float, float]) -> None:
    """East for 10 m, then north for 20 m; left is positive; beyond its ends there is none."""
    line = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 20.0]]) + shift
    found = lateral_offsets(np.array([point[0] + shift[0]]), np.array([point[1] + shift[1]]), line)
    assert found[0] == pytest.approx(offset, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("speed", [0.05, 0.5, 40.0])
def test_an_offset_from_a_long_line_is_the_same_along_it(speed: float) -> None:
    """Longer than what is searched first: a circle of 50 m in steps of a degree, driven 2 m inside it."""
    turn = np.radians(np.arange(300.0))
    line = np.column_stack((50.0 * np.cos(turn), 50.0 * np.sin(turn)))
    at = np.radians(np.minimum(0.5 + speed * np.arange(400.0), 298.0))
    found = lateral_offsets(48.0 * np.cos(at), 48.0 * np.sin(at), np.ascontiguousarray(line))
    sag = 50.0 * (1.0 - math.cos(math.radians(0.5)))  # of a chord below the circle
    assert (found <= 2.0 + 1e-9).all()
    assert (found >= 2.0 - sag - 1e-9).all()


@pytest.mark.parametrize("speed", [0.0, 0.05, 0.9, 40.0])
def test_an_offset_is_that_of_the_nearest_of_all_segments(speed: float) -> None:
    """Two laps of a square, the second one 0.3 m further in: beside them and far from them, slowly and in leaps."""
    side = np.arange(0.0, 40.0)
    lap = np.concatenate([
        np.column_stack((side, 0 * side)), np.column_stack((40.0 + 0 * side, side)),
        np.column_stack((40.0 - side, 40.0 + 0 * side)), np.column_stack((0 * side, 40.0 - side)),
    ])  # fmt: skip
    line = np.concatenate([lap, 0.985 * lap + 0.3])
    at = speed * np.arange(200.0)
    x, y = 20.0 + 19.0 * np.cos(at / 20.0) + 0.3 * at, 20.0 + 19.0 * np.sin(at / 20.0)
    start, step = line[:-1, None], np.diff(line, axis=0)[:, None]
    points = np.column_stack((x, y))
    along = np.clip(((points - start) * step).sum(axis=2) / (step**2).sum(axis=2), 0.0, 1.0)
    least = np.linalg.norm(points - start - along[..., None] * step, axis=2).min(axis=0)
    found = np.abs(lateral_offsets(x, y, line))
    assert found[np.isfinite(found)] == pytest.approx(least[np.isfinite(found)])
    assert np.isfinite(found).any()


def test_a_line_is_read_up_to_its_last_point_and_no_further() -> None:
    """Compiled code would not notice: it reads whatever stands behind in memory. Plain Python says it."""
    plain = getattr(lateral_offsets, "py_func", lateral_offsets)
    line = np.array([[0.0, 0.0], [10.0, 0.0]])
    assert plain(np.array([5.0]), np.array([-2.0]), line).tolist() == [-2.0]


# --- boxes of 4 m by 2 m


def box(x: float, y: float, yaw: float = 0.0, length: float = 4.0, width: float = 2.0, *v: float) -> np.ndarray:
    return np.array([x, y, yaw, length, width, *v])


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (box(4.0, 0.0), True),
        (box(4.01, 0.0), False),
        (box(-4.01, 0.0), False),
        (box(0.0, 2.0), True),
        (box(0.0, 2.01), False),
        (box(0.0, -2.01), False),
        (box(2.99, 0.0, QUARTER), True),
        (box(3.01, 0.0, QUARTER), False),
        (box(0.0, 2.99, QUARTER), True),
        (box(0.0, 3.01, QUARTER), False),
        (box(5.4, 0.0, QUARTER, 2.0, 6.8), True),
        (box(5.41, 0.0, QUARTER, 2.0, 6.8), False),
        # a square on its corner: its half diagonal is sqrt(2) m
        (box(2.0 + math.sqrt(2.0) - 0.01, 0.0, 0.5 * QUARTER, 2.0, 2.0), True),
        (box(2.0 + math.sqrt(2.0) + 0.01, 0.0, 0.5 * QUARTER, 2.0, 2.0), False),
        # beside the corner (2, 1) only the square's own sides keep them apart: 1 m along the diagonal
        (box(2.0 + 0.99 * math.sqrt(0.5), 1.0 + 0.99 * math.sqrt(0.5), 0.5 * QUARTER, 2.0, 2.0), True),
        (box(2.0 + 1.01 * math.sqrt(0.5), 1.0 + 1.01 * math.sqrt(0.5), 0.5 * QUARTER, 2.0, 2.0), False),
    ],
)
@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_boxes_that_touch(other: np.ndarray, expected: bool, turn: float) -> None:
    """However both are turned and moved, and whichever is asked first; a hair of slack for the rounding of a turn."""
    c, s = math.cos(turn), math.sin(turn)
    one, two = box(7.0, 3.0, turn), other.copy()
    two[:3] = 7.0 + c * other[0] - s * other[1], 3.0 + s * other[0] + c * other[1], other[2] + turn
    if expected:
        two[3:5] += 1e-9
    assert touch(one, two) is expected
    assert touch(two, one) is expected


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (box(14.0, 0.0, 0.0, 4.0, 2.0, -5.0, 0.0), 2.0),
        (box(-14.0, 0.0, 0.0, 4.0, 2.0, 5.0, 0.0), 2.0),
        (box(14.0, 0.0, 0.0, 4.0, 2.0, 5.0, 0.0), math.inf),
        (box(14.0, 0.0, 0.0, 4.0, 2.0, 0.0, 0.0), math.inf),
        (box(0.0, 12.0, 0.0, 4.0, 2.0, 0.0, -5.0), 2.0),
        (box(0.0, -12.0, 0.0, 4.0, 2.0, 0.0, 5.0), 2.0),
        (box(14.0, 1.99, 0.0, 4.0, 2.0, -5.0, 0.0), 2.0),
        (box(14.0, 2.01, 0.0, 4.0, 2.0, -5.0, 0.0), math.inf),
        (box(13.0, 0.0, QUARTER, 4.0, 2.0, -5.0, 0.0), 2.0),
        (box(0.0, 13.0, QUARTER, 4.0, 2.0, 0.0, -5.0), 2.0),
        (box(14.0, 12.0, 0.0, 4.0, 2.0, -5.0, -5.0), 2.0),  # corner to corner
        (box(12.0 + math.sqrt(2.0), 0.0, 0.5 * QUARTER, 2.0, 2.0, -5.0, 0.0), 2.0),
        (box(12.0 + math.sqrt(2.0), 1.5, 0.5 * QUARTER, 2.0, 2.0, -5.0, 0.0), 2.1),  # the corner at (2, 1): 0.5 m late
        (box(2.0, 0.0, 0.0, 4.0, 2.0, 5.0, 0.0), 0.0),
        (box(0.0, 0.0, QUARTER, 10.0, 0.5, 0.0, 0.0), 0.0),  # they cross, no corner inside the other one
        (box(30.0, 20.0, 0.0, 4.0, 2.0, -5.0, 0.0), math.inf),
    ],
)
@pytest.mark.parametrize("turn", [0.0, 0.4, -2.0])
def test_the_time_to_a_collision(other: np.ndarray, expected: float, turn: float) -> None:
    """The first box moves as well: only the difference of the velocities counts."""
    c, s = math.cos(turn), math.sin(turn)
    one, two = box(7.0, 3.0, turn, 4.0, 2.0, 1.0, -2.0), other.copy()
    two[:3] = 7.0 + c * other[0] - s * other[1], 3.0 + s * other[0] + c * other[1], other[2] + turn
    two[5:] = 1.0 + c * other[5] - s * other[6], -2.0 + s * other[5] + c * other[6]
    pairs = [(one, two), (two, one)]
    found = time_to_collision(np.array([a for a, _ in pairs]), np.array([b for _, b in pairs]))
    assert found == pytest.approx([expected, expected], abs=1e-6)


@pytest.mark.parametrize(("longest", "expected"), [(10.0, (2.0, 5.0)), (2.0, (2.0, 5.0)), (1.9, (math.inf, math.nan))])
@pytest.mark.parametrize("ego_first", [True, False])
def test_the_time_from_one_leaving_to_the_other_coming(
    longest: float, expected: tuple[float, float], ego_first: bool
) -> None:
    """One stands at the crossing at 3 s, the other one at 5 s; else they are far from it and from each other."""
    t = np.arange(8.0)
    first = np.array([box(0.0 if k == 3 else 100.0 + 20.0 * k, 50.0) for k in range(8)])
    second = np.array([box(1.0 if k == 5 else -100.0 - 20.0 * k, 50.0, QUARTER) for k in range(8)])
    found = least_time(t, *((first, second) if ego_first else (second, first)), longest)
    assert found == pytest.approx(expected, nan_ok=True)


@pytest.mark.parametrize(("beyond", "expected"), [(EDGE_TOLERANCE, 3.0), (2.0 * EDGE_TOLERANCE, math.inf)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_corner_still_touches_an_edge_as_far_beyond_its_end_as_is_allowed(
    side: float, beyond: float, expected: float
) -> None:
    """A box of 4 x 2 m; the corner comes at 1 m/s from 5 m, along the box and across it."""
    assert _first_hit(-5.0, side * (1.0 + beyond), 1.0, 0.0, 2.0, 1.0, math.inf) == expected
    assert _first_hit(side * (2.0 + beyond), -4.0, 0.0, 1.0, 2.0, 1.0, math.inf) == expected


@pytest.mark.parametrize(("x", "y", "vx", "vy"), [(-2.0, BESIDE, 1.0, 0.0), (2.0, -BESIDE, -1.0, 0.0),
                                                  (BESIDE, -2.0, 0.0, 1.0), (-BESIDE, 2.0, 0.0, -1.0)])  # fmt: skip
def test_a_corner_that_just_touches_has_met_now_and_not_with_the_next_corner(
    x: float, y: float, vx: float, vy: float
) -> None:
    """Two boxes of 2 x 2 m, corner at corner but for half of what is allowed; the second one comes at 1 m/s, so its
    other two corners are at the same edge 2 s later."""
    still, coming = box(0.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0), box(x, y, 0.0, 2.0, 2.0, vx, vy)
    assert time_to_collision(np.array([still]), np.array([coming]))[0] == 0.0


def test_a_corner_at_an_edge_meets_it_at_once() -> None:
    """Half a metre from the middle of a side of a box of 4 x 2 m, on its way inwards."""
    assert _first_hit(-2.0, 0.5, 1.0, 0.0, 2.0, 1.0, math.inf) == 0.0
    assert _first_hit(0.5, -1.0, 0.0, 1.0, 2.0, 1.0, math.inf) == 0.0


@pytest.mark.parametrize(("gap", "expected"), [(0.49, 0.0), (0.51, math.inf)])
@pytest.mark.parametrize(("along", "across"), [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_boxes_of_half_a_metre_meet_at_half_a_metre(along: float, across: float, gap: float, expected: float) -> None:
    small, other = box(0.0, 0.0, 0.0, 0.5, 0.5), box(gap * along, gap * across, 0.0, 0.5, 0.5)
    assert least_time(np.arange(2.0), np.array([small] * 2), np.array([other] * 2), 10.0)[0] == expected


@pytest.mark.parametrize(("gap", "expected"), [(0.70, 0.0), (0.71, math.inf)])
@pytest.mark.parametrize(("along", "across"), [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_boxes_of_half_a_metre_on_their_corners_meet_at_their_diagonal(
    along: float, across: float, gap: float, expected: float
) -> None:
    """sqrt(0.5) m, farther than the side; in metres the square of such a number is less than the number."""
    small, other = (box(far * along, far * across, 0.5 * QUARTER, 0.5, 0.5) for far in (0.0, gap))
    assert least_time(np.arange(2.0), np.array([small] * 2), np.array([other] * 2), 10.0)[0] == expected


def test_a_road_user_of_one_instant_is_as_wide_as_it_is_then() -> None:
    """40 m wide and 15 m aside: the boxes overlap. What stands behind in memory, here a box of no size, is nothing."""
    wide = np.array([box(0.0, 15.0, 0.0, 2.0, 40.0), np.zeros(5)])
    assert least_time(np.array([3.0]), np.array([box(0.0, 0.0)]), wide[:1], 10.0) == (0.0, 3.0)
    assert least_time(np.array([3.0]), wide[:1], np.array([box(0.0, 0.0)]), 10.0) == (0.0, 3.0)


@pytest.mark.parametrize(("gap", "expected"), [(4.0, 0.0), (4.01, math.inf)])
def test_boxes_that_just_touch_at_one_time(gap: float, expected: float) -> None:
    t = np.arange(2.0)
    found = least_time(t, np.array([box(0.0, 0.0)] * 2), np.array([box(gap, 0.0)] * 2), 10.0)
    assert found[0] == expected


# --- a low pass


@pytest.mark.parametrize("cutoff", [1.0, 5.0])
def test_a_low_pass_leaves_lines_and_halves_its_cut_off(cutoff: float) -> None:
    """Both runs of an order 2 take 3 dB twice: half of the cut-off is left, and 1/17 of twice its frequency, as far as
    the bilinear transform bends the scale: tan(2 w)/tan(w) is 2 within a thousandth at these rates."""
    t = np.arange(8001) * 0.001
    line = 3.0 - 2.0 * t
    assert low_pass(line, 0.001, cutoff) == pytest.approx(line, abs=1e-9)
    for ratio, left in ((1.0, 0.5), (2.0, 1.0 / 17.0)):
        wave = np.sin(2.0 * math.pi * ratio * cutoff * t)
        middle = slice(3500, 4500)  # a whole number of periods, far from the ends
        found = low_pass(wave, 0.001, cutoff)[middle]
        assert np.abs(found - left * wave[middle]).max() < 2e-3


@pytest.mark.parametrize("n", [1, 2, 5])
def test_a_low_pass_of_few_samples_keeps_a_constant(n: int) -> None:
    assert low_pass(np.full(n, 1.5), 0.01, 5.0) == pytest.approx(np.full(n, 1.5), abs=1e-9)


@pytest.mark.parametrize(("cutoff", "good"), [(0.0, False), (-1.0, False), (49.9, True), (50.0, False)])
def test_a_cut_off_lies_below_half_the_rate(cutoff: float, good: bool) -> None:
    if good:
        assert low_pass(np.ones(9), 0.01, cutoff) == pytest.approx(np.ones(9))
        return
    with pytest.raises(ValueError, match=r"is not between 0 and 50 Hz, half the sampling rate"):
        low_pass(np.ones(9), 0.01, cutoff)


# --- traffic lights; the front of the ego is 2.7 m ahead of its reference point


def lit(*phases: tuple[float, str], x: Any, v: Any = 5.0, y: float = 0.0) -> Any:
    line = {"signal": "L", "x": 50.0, "y": 0.0, "heading": 0.0, "width": 4.0}
    events = tuple(LogEvent(t, "signal", "L", text) for t, text in phases)
    return log_of(10.0, columns={"x": x, "v": v, "y": y}, meta={"stop_lines": [line]}, events=events)


@pytest.mark.parametrize(
    ("state", "red", "green"),
    [
        ("red", True, False), (" Red ", True, False), ("red amber", True, False), ("red-yellow", True, False),
        ("green", False, True), ("on;off;off", True, False), ("on;on;off", True, False), ("off;off;on", False, True),
        ("1;0", True, False), ("0;1", False, False), ("true;false;false", True, False), ("off", False, False),
        ("off;on;off", False, False),
    ],
)  # fmt: skip
def test_states_of_a_light(state: str, red: bool, green: bool) -> None:
    assert (is_red(state), is_green(state)) == (red, green)


def test_how_far_the_front_is_beyond_a_line() -> None:
    ((name, _, ahead, beside, red),) = _lights(lit((2.0, "red"), (4.0, "green"), x=47.0, y=2.0))
    assert name == "L"
    assert ahead == pytest.approx(-0.3)
    assert beside.all()
    assert np.flatnonzero(red)[[0, -1]].tolist() == [200, 399]
    ((_, _, _, beside, _),) = _lights(lit((2.0, "red"), x=47.0, y=2.01))
    assert not beside.any()


@pytest.mark.parametrize(
    ("phases", "count", "when"),
    [
        (((0.0, "red"),), 1.0, 4.73),  # 47.3 m at 10 m/s
        (((4.73, "red"),), 1.0, 4.73),
        (((4.74, "red"),), 0.0, None),
        (((0.0, "red"), (4.73, "green")), 0.0, None),
        (((0.0, "red"), (4.74, "green")), 1.0, 4.73),
    ],
)
def test_red_lights_that_were_crossed(phases: Any, count: float, when: float | None) -> None:
    found = red_light(lit(*phases, x=10.0 * times() + 1e-9, v=10.0))
    assert (found.value, found.object) == (count, "L" if count else "")
    assert found.t == (None if when is None else pytest.approx(when))


@pytest.mark.parametrize(("stand", "expected"), [(45.0, -2.3), (48.0, None), (-2.6, -49.9), (-2.8, None)])
def test_how_near_to_a_red_line_the_ego_stood(stand: float, expected: float | None) -> None:
    """Beyond the line, or more than 50 m before it, no red light is the ego's."""
    log = lit((1.0, "red"), x=stand, v=0.0)
    if expected is None:
        with pytest.raises(Undefined, match="no traffic light was red ahead of the ego"):
            stop_line(log)
    else:
        found = stop_line(log)
        assert (found.value, found.t, found.object) == (pytest.approx(expected), pytest.approx(1.0), "L")


def test_how_far_the_ego_went_beyond_a_red_line() -> None:
    """Red from 2 to 6 s, off at 3 s from 30 m with 10 m/s: at the last red row, 5.99 s, it is at 59.9 m."""
    x = 30.0 + 10.0 * np.maximum(times() - 3.0, 0.0)
    found = stop_line(lit((2.0, "red"), (6.0, "green"), x=x))
    assert (found.value, found.t) == (pytest.approx(59.9 + 2.7 - 50.0), pytest.approx(5.99))


@pytest.mark.parametrize(
    ("speeds", "expected"),
    [((0.0, 1.0), 2.0), ((0.49, 1.0), 2.0), ((0.5, 1.0), None), ((0.0, 0.5), 7.0)],
)
def test_how_late_the_ego_set_off(speeds: tuple[float, float], expected: float | None) -> None:
    """Green at 3 s; the second speed from 5 s on. Not faster than 0.5 m/s is not off: 7 s to the end of the log."""
    v = np.where(times() < 5.0 - 1e-6, *speeds)
    log = lit((0.0, "red"), (3.0, "green"), x=45.0, v=v)
    if expected is None:
        with pytest.raises(Undefined, match="waited for no traffic light"):
            start_up_delay(log)
    else:
        found = start_up_delay(log)
        assert (found.value, found.t, found.object) == (pytest.approx(expected), 3.0, "L")


# --- safe distances of RSS


@pytest.mark.parametrize(
    ("rear", "front", "expected"),
    [
        # response 1 s, up to 2 m/s^2 faster meanwhile, then braking with 4; the one ahead brakes with 8 at most
        (10.0, 10.0, 10.0 + 1.0 + 144.0 / 8.0 - 100.0 / 16.0),
        (10.0, 0.0, 29.0),
        (0.0, 30.0, 0.0),
        (10.0, -6.0, 29.0 + 6.0 + 1.0 + 64.0 / 8.0),
        (-4.0, 0.0, 0.0),
    ],
)
def test_a_safe_distance_along(rear: float, front: float, expected: float) -> None:
    found = safe_longitudinal(np.array([rear]), np.array([front]), 1.0, 2.0, 4.0, 8.0)
    assert found == pytest.approx([expected])


@pytest.mark.parametrize(
    ("toward", "away", "expected"),
    [
        (0.0, 0.0, 0.5 + 2.0 * (0.5 + 0.5)),  # each 0.5 m in 1 s, then from 1 m/s to rest with 1 m/s^2
        (-3.0, 3.0, 0.5),
        (1.0, 0.0, 0.5 + 1.5 + 2.0 + 1.0),
    ],
)
def test_a_safe_distance_aside(toward: float, away: float, expected: float) -> None:
    assert safe_lateral(np.array([toward]), np.array([away]), 1.0, 1.0, 1.0, 0.5) == pytest.approx([expected])
