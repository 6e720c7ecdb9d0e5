"""Each rule by which a log is cut into segments, held from both sides. The step is 1/64 s or 1/16 s: no rounding."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import (
    Segments,
    _gaps,
    _interior,
    _near,
    _slides,
    _states,
    cut,
    filled,
    has_speed,
    longest_step,
    measured_array,
    posed,
    residuals,
    standing,
    still_speed,
)
from pytest_dvp.logs.log_contents import FloatArray

STEP = 1.0 / 64.0


def nothing(n: int) -> FloatArray:
    return np.full((n, 8), np.nan)


def test_channels_are_in_their_order_and_only_the_heading_is_unwrapped() -> None:
    t = np.arange(4.0)
    columns = {"t": t, "x": 10.0 + t, "yaw": np.array([3.0, np.nan, -3.0, -2.5]), "v": np.array([9.0, 0.0, 9.0, 0.0]),
               "steer": -t}  # fmt: skip
    found = measured_array(columns)
    assert found.shape == (4, 8)
    assert found[:, 0] == pytest.approx(10.0 + t)
    assert found[[0, 2, 3], 2] == pytest.approx([3.0, 2.0 * np.pi - 3.0, 2.0 * np.pi - 2.5])
    assert np.isnan(found[1, 2])
    assert found[:, 3].tolist() == [9.0, 0.0, 9.0, 0.0]
    assert found[:, 7] == pytest.approx(-t)
    assert np.isnan(found[:, [1, 4, 5, 6]]).all()


@pytest.mark.parametrize(("step", "longest"), [(0.01, 0.1), (0.02, 0.1), (0.03, 0.15), (0.2, 1.0)])
def test_a_gap_is_longer_than_a_tenth_of_a_second_and_than_five_usual_steps(step: float, longest: float) -> None:
    assert longest_step(step * np.arange(100)) == pytest.approx(longest)
    assert longest_step(np.array([3.0])) == 0.1


def test_a_value_holds_for_its_usual_time_and_then_is_missing_until_the_next() -> None:
    t = np.arange(64) / 16.0
    known = np.ones(64, dtype=bool)
    known[10:16] = False  # from row 9 to row 16: seven steps
    known[30:34] = False  # five steps are no gap
    resumes, missing = _gaps(t, known)
    assert resumes == [16]
    assert np.flatnonzero(missing).tolist() == [11, 12, 13, 14, 15]


def test_gaps_at_both_ends_of_a_log() -> None:
    t = np.arange(64) / 16.0
    known = np.ones(64, dtype=bool)
    known[:8], known[-8:] = False, False
    resumes, missing = _gaps(t, known)
    assert resumes == [8]
    assert np.flatnonzero(missing).tolist() == [*range(8), *range(57, 64)]


@pytest.mark.parametrize(("rows", "resumes"), [([5], []), ([], []), ([5, 30], [])])
def test_a_single_value_has_no_usual_time(rows: list[int], resumes: list[int]) -> None:
    known = np.zeros(64, dtype=bool)
    known[rows] = True
    found, missing = _gaps(np.arange(64) / 16.0, known)
    assert found == resumes
    assert not missing.any()


def test_a_car_stands_below_0_3_metres_a_second_and_a_small_one_below_a_tenth_of_its_speed() -> None:
    assert still_speed(np.linspace(0.0, -20.0, 101)) == 0.3
    assert still_speed(np.linspace(0.0, -2.0, 101)) == pytest.approx(0.19, abs=1e-5)
    assert still_speed(np.zeros(9)) == pytest.approx(1e-6)


@pytest.mark.parametrize(("first", "end"), [(0, 400), (100, 500), (200, 640), (100, 228), (100, 229)])
def test_the_first_and_the_last_second_of_a_standstill_count(first: int, end: int) -> None:
    stands = np.zeros(640, dtype=bool)
    stands[first:end] = True
    inside = np.flatnonzero(_interior(STEP * np.arange(640), stands)).tolist()
    assert inside == list(range(first + 64, end - 1 - 64))


def test_standing_is_below_the_still_speed() -> None:
    v = np.full(640, 10.0)
    v[200:400] = 0.29
    v[400:600] = 0.31
    found = np.flatnonzero(standing(STEP * np.arange(640), v))
    assert (found[0], found[-1]) == (264, 334)


def test_a_cut_is_put_where_the_car_turns_least_within_half_a_second() -> None:
    t = STEP * np.arange(20 * 64)
    measured = nothing(len(t))
    measured[:, 3], measured[:, 4] = 10.0, 0.5
    measured[[round(5.3 * 64), round(10.6 * 64)], 4] = 0.1, 0.05
    measured[round(14.6 * 64), 4] = -0.2
    expected = [0, round(5.3 * 64), round(9.5 * 64), round(14.6 * 64)]  # 10.6 s is too far from 10 s
    assert cut(t, measured).starts.tolist() == expected


@pytest.mark.parametrize(("seconds", "pieces"), [(7.4, 1), (7.6, 2), (12.4, 2), (12.6, 3), (20.0, 4)])
def test_a_log_has_as_many_pieces_as_five_seconds_fit_best(seconds: float, pieces: int) -> None:
    t = STEP * np.arange(round(seconds * 64) + 1)
    measured = nothing(len(t))
    measured[:, 3] = 10.0
    found = cut(t, measured)
    assert len(found.starts) == pieces
    assert found.ends.tolist() == [*found.starts[1:].tolist(), len(t)]


@pytest.mark.parametrize("begins", [0.0, 1000.0, -7.0])
def test_a_log_is_cut_alike_whenever_its_clock_began(begins: float) -> None:
    """Of 20 s without a turn, cuts are within half a second of 5, 10 and 15 s: the first rows there."""
    t = begins + STEP * np.arange(20 * 64 + 1)
    measured = nothing(len(t))
    measured[:, 3], measured[:, 4] = 10.0, 0.0
    assert cut(t, measured).starts.tolist() == [0, round(4.5 * 64), round(9.5 * 64), round(14.5 * 64)]


@pytest.mark.parametrize(("n", "last"), [(102, 97), (101, 92)])
def test_pieces_have_five_rows_or_more(n: int, last: int) -> None:
    """The least rate is always the last one within reach, so the cuts run through the log row by row."""
    t = STEP * np.arange(n)
    measured = nothing(n)
    measured[:, 3], measured[:, 4] = 10.0, np.linspace(0.9, 0.1, n)
    assert cut(t, measured, length=STEP).starts.tolist() == [0, *range(32, last + 1, 5)]


def test_a_start_on_the_move_does_not_count_for_half_a_second_of_a_short_piece_a_quarter() -> None:
    for n, until in ((640, 32), (65, 16)):
        t = STEP * np.arange(n)
        measured = nothing(n)
        measured[:, 3] = 10.0
        found = cut(t, measured)
        assert np.flatnonzero(~found.counted).tolist() == list(range(until))
        assert np.flatnonzero(found.lost).tolist() == list(range(until))
        measured[0, 3] = 0.0
        assert cut(t, measured).counted.all()


def test_after_a_gap_in_a_command_a_piece_begins_anew() -> None:
    t = STEP * np.arange(640)
    measured = nothing(640)
    measured[:, 3] = 10.0
    known = np.ones(640, dtype=bool)
    known[20:80] = False
    found = cut(t, measured, known=[known])
    assert 80 in found.starts
    # a quarter of the piece before the gap, and from a step after the last command to half a second after the next
    assert np.flatnonzero(found.lost).tolist() == [*range(20), *range(21, 112)]


def test_a_hole_in_what_a_start_needs_is_lost_and_one_in_the_position_is_not() -> None:
    t = STEP * np.arange(640)
    for channel, lost in ((0, False), (1, False), (2, True), (3, True), (4, True)):
        measured = np.zeros((640, 8))
        measured[:, 3] = 10.0
        measured[:, 0] = 10.0 * t
        measured[200:260, channel] = np.nan
        found = cut(t, measured)
        assert 260 in found.starts, channel
        assert found.lost[201:260].all() == lost, channel
        assert found.lost[100:400].any() == lost, channel
        assert not found.lost[260:400].any(), channel


def test_rows_that_a_second_log_lacks_begin_a_piece_and_are_lost() -> None:
    t = STEP * np.arange(640)
    measured = nothing(640)
    measured[:, 3] = 10.0
    there = np.ones(640, dtype=bool)
    there[200:260] = False
    found = cut(t, measured, given=[there])
    assert 260 in found.starts
    assert np.flatnonzero(found.lost[100:400]).tolist() == list(range(101, 160))


def test_a_slide_does_not_count_to_the_end_of_its_piece() -> None:
    t = STEP * np.arange(640)
    measured = nothing(640)
    measured[:, 3], measured[:, 4] = 10.0, 0.0
    measured[100, 4] = 7.0
    found = cut(t, measured)
    second = int(found.starts[1])
    assert np.flatnonzero(~found.counted[32:]).tolist() == list(range(68 - 32, second - 32))


def test_a_slide_shows_in_position_and_heading_where_the_speed_has_a_hole() -> None:
    t = STEP * np.arange(640)
    measured = np.zeros((640, 8))
    measured[:, 0], measured[:, 3] = 10.0 * t, 10.0
    measured[220:240, 2] = 0.5  # more than the 0.3 rad that no wheel on the road allows
    for hole in (3, 4):
        there = measured.copy()
        there[200:260, hole] = np.nan
        assert np.flatnonzero(cut(t, there).slides).tolist() == list(range(220, 240)), hole
    for hole in (0, 1, 2):  # where it is or points is not known there
        there = measured.copy()
        there[200:260, hole] = np.nan
        assert not cut(t, there).slides[201:260].any(), hole


def test_of_wheels_whose_speed_has_a_hole_nobody_can_say_that_they_are_locked_there() -> None:
    """Before the hole they turn at 20 m/s, after it for a while at 5 m/s; the car goes on at 20 m/s. The straight line
    between is as steep as wheels that lock."""
    t = STEP * np.arange(640)
    measured = np.zeros((640, 8))
    measured[:, 0], measured[:, 3] = 20.0 * t, 20.0
    measured[230:250, 3] = 5.0
    measured[200:230, 3] = np.nan
    slides = cut(t, measured).slides
    assert slides[230:249].all()
    assert not slides[201:230].any()


@pytest.mark.parametrize("v", [0.0, 5.0, -5.0])
@pytest.mark.parametrize("beyond", [False, True])
def test_a_spin_turns_faster_than_six_fifths_of_v_over_the_wheelbase_and_half_a_radian(v: float, beyond: bool) -> None:
    t = STEP * np.arange(640)
    whole = np.zeros((640, 8))
    whole[:, 3] = v
    whole[300, 4] = -(abs(v) / 2.5 * 1.2 + 0.5 + (0.01 if beyond else -0.01))
    found = np.flatnonzero(_near(t, _slides(t, whole, 2.5, posed=np.zeros(640, dtype=bool))))
    assert found.tolist() == (list(range(300 - 32, 300 + 32)) if beyond else [])


@pytest.mark.parametrize(
    ("slip", "speed", "slides"),
    [(0.29, 5.0, False), (0.31, 5.0, True), (-0.31, 5.0, True), (0.31, 2.9, False), (0.31, 3.1, True),
     (np.pi, 5.0, False), (np.pi - 0.31, 5.0, True), (2.0 * np.pi, 5.0, False)],
)  # fmt: skip
def test_a_slide_goes_where_the_car_does_not_point(slip: float, speed: float, slides: bool) -> None:
    """Faster than 3 m/s and by more than 0.3 rad; a car that reverses goes against its heading, and does not slide."""
    t = STEP * np.arange(640)
    whole = np.zeros((640, 8))
    whole[:, 0], whole[:, 1] = speed * t * np.cos(0.4), speed * t * np.sin(0.4)
    whole[:, 2], whole[:, 3] = 0.4 - slip, speed
    assert _slides(t, whole, 2.5, posed=np.ones(640, dtype=bool)).any() == slides
    assert not _slides(t, whole, 2.5, posed=np.zeros(640, dtype=bool)).any()
    whole[:, 3] = 0.0  # a wheel that is locked says nothing of where the car goes
    assert not _slides(t, whole, 2.5, posed=np.ones(640, dtype=bool)).any()


def test_the_state_of_a_start_is_a_parabola_through_the_samples_around_it() -> None:
    t = STEP * np.arange(640)
    measured = nothing(640)
    for channel in range(5):
        s = t - 5.0
        measured[:, channel] = 3.0 + channel - 0.7 * s + (channel + 1.0) * s**2
    outside = np.abs(t - 5.0) > 0.15 + 1e-6
    measured[outside] = 99.0
    states = _states(t, measured, filled(t, measured), np.array([320]))
    assert states[0, [0, 1, 2, 3, 5]] == pytest.approx([3.0, 4.0, 5.0, 6.0, 7.0])
    assert np.isnan(states[0, 4])


def test_a_start_with_samples_on_one_side_only_is_on_a_straight_line() -> None:
    t = STEP * np.arange(64)
    y = np.where(t <= 0.15, (t - 0.1) ** 2, 50.0)
    measured = nothing(64)
    measured[:, 3] = 5.0 + y
    window = t <= 0.15 + 1e-9
    line = np.polyfit(t[window], 5.0 + y[window], 1)[1]
    assert _states(t, measured, filled(t, measured), np.array([0]))[0, 3] == pytest.approx(line)


@pytest.mark.parametrize(("known", "value"), [(7, 0.0), (6, None), (3, None), (2, "there"), (1, "there")])
def test_a_start_with_few_samples_is_on_a_line_and_with_fewer_what_was_bridged(known: int, value: object) -> None:
    t = STEP * np.arange(640)
    rows = {7: [311, 314, 317, 320, 323, 326, 329], 6: [311, 314, 317, 323, 326, 329], 3: [311, 320, 329],
            2: [315, 325], 1: [322]}[known]  # fmt: skip
    measured = nothing(640)
    measured[rows, 4] = (t[rows] - 5.0) ** 2
    measured[:, 3] = 5.0
    whole = filled(t, measured)
    state = _states(t, measured, whole, np.array([320]))[0, 5]
    line = float(np.polyfit(t[rows] - 5.0, measured[rows, 4], 1)[1]) if known > 1 else 0.0
    expected = {0.0: 0.0, None: line, "there": whole[320, 4]}[value]  # type: ignore[index]
    assert state == pytest.approx(expected, abs=1e-9)


def test_a_car_that_never_reverses_does_not_start_backwards() -> None:
    t = STEP * np.arange(640)
    measured = nothing(640)
    measured[:, 3] = np.where(t < 5.0, -0.2, 10.0)
    whole = filled(t, measured)
    assert _states(t, measured, whole, np.array([64]))[0, 3] == 0.0
    whole[0, 3] = -0.31
    assert _states(t, measured, whole, np.array([64]))[0, 3] == pytest.approx(-0.2)


def test_gaps_are_bridged_by_straight_lines_and_absent_channels_are_zero() -> None:
    t = np.array([0.0, 1.0, 3.0, 4.0])
    measured = nothing(4)
    measured[:, 3], measured[:, 4] = [1.0, np.nan, np.nan, 5.0], 0.0
    whole = filled(t, measured)
    assert whole[:, 3] == pytest.approx([1.0, 2.0, 4.0, 5.0])
    assert not whole[:, [0, 1, 2, 5, 6, 7]].any()


def test_speed_and_yaw_rate_follow_from_path_and_heading() -> None:
    """A circle of 20 m at 8 m/s, and the same backwards: over 0.2 s the chord is that of a turn of 0.16 rad."""
    t = STEP * np.arange(640)
    angle = 0.4 * t
    measured = nothing(640)
    measured[:, 0], measured[:, 1] = 20.0 * np.sin(angle), -20.0 * np.cos(angle)
    inner = slice(64, -64)
    # the stamp after is the first one beyond 0.2 s, the one before the last one within
    measured[:, 2] = angle
    assert filled(t, measured)[inner, 3] == pytest.approx(8.0, rel=0.01)
    assert filled(t, measured)[inner, 4] == pytest.approx(0.4)
    measured[:, 2] = angle + np.pi
    assert filled(t, measured)[inner, 3] == pytest.approx(-8.0, rel=0.01)
    measured[:, 2] = np.nan
    whole = filled(t, measured)
    assert whole[inner, 3] == pytest.approx(8.0, rel=0.01)
    assert whole[inner, 4] == pytest.approx(0.4, rel=0.01)
    assert np.abs(whole[inner, 2] - angle[inner]).max() < 0.02  # half of what one turns in a stamp
    measured[:, 3] = -8.0  # backwards it points the other way
    assert np.abs(np.angle(np.exp(1j * (filled(t, measured)[inner, 2] - angle[inner] - np.pi)))).max() < 0.02
    measured[:, 3] = np.nan
    measured[:, 1] = np.nan
    assert not filled(t, measured)[:, 3].any()


def test_what_is_measured_is_not_replaced() -> None:
    t = STEP * np.arange(64)
    measured = np.zeros((64, 8))
    measured[:, 0] = 9.0 * t
    measured[:, 3] = 1.0
    measured[:, 4] = np.nan
    measured[:, 2] = 0.3 * t
    whole = filled(t, measured)
    assert (whole[:, 3] == 1.0).all()
    assert whole[20:40, 4] == pytest.approx(0.3)
    measured[:, 3], measured[:, 4] = np.nan, 0.5  # the speed follows from the path, the yaw rate is there
    whole = filled(t, measured)
    assert (whole[:, 4] == 0.5).all()
    assert whole[20:40, 3] == pytest.approx(9.0 * np.cos(0.3 * t[20:40]), rel=0.01)


@pytest.mark.parametrize(
    ("there", "speed"), [([3], True), ([0, 1], True), ([0], False), ([1, 2, 4], False), ([], False)]
)
def test_a_speed_is_measured_or_follows_from_the_path(there: list[int], speed: bool) -> None:
    measured = nothing(5)
    measured[:, there] = 1.0
    assert has_speed(measured) is speed


def pieces(n: int, starts: list[int], states: FloatArray) -> Segments:
    begin = np.array(starts)
    return Segments(
        begin, np.append(begin[1:], n), states, np.ones(n, dtype=bool), *(np.zeros(n, dtype=bool) for _ in range(3))
    )


def test_an_output_is_turned_and_moved_onto_each_start_that_is_known() -> None:
    n = 12
    output = np.zeros((n, 8))
    output[:, 0], output[:, 1], output[:, 2] = np.arange(n), 2.0 * np.arange(n), 0.1 * np.arange(n)
    output[:, 3:] = 7.0
    output[4, 2] = np.nan  # the second piece is known from its second row on
    states = np.zeros((3, 6))
    states[0, :3] = 100.0, 50.0, np.pi / 2.0
    states[1, :3] = -3.0, 4.0, 0.5
    states[2, 1] = np.nan
    found = posed(output, pieces(n, [0, 4, 8], states))
    assert found[:4, 0] == pytest.approx(100.0 - 2.0 * np.arange(4))
    assert found[:4, 1] == pytest.approx(50.0 + np.arange(4))
    assert found[:4, 2] == pytest.approx(np.pi / 2.0 + 0.1 * np.arange(4))
    assert found[5, :3] == pytest.approx([-3.0, 4.0, 0.5])
    assert found[6, :3] == pytest.approx([-3.0 + 1.0, 4.0 + 2.0, 0.6])
    assert (found[8:] == output[8:]).all()
    assert (found[:, 3:] == 7.0).all()


def test_chi2_is_the_mean_square_of_what_counts_in_units_of_its_noise() -> None:
    n = 200
    t = STEP * np.arange(n)
    output = np.zeros((n, 8))
    output[:, 0], output[:, 3] = 10.0 * t, 10.0
    measured = output.copy()
    sign = np.where(np.arange(n) % 2, 1.0, -1.0)
    measured[:, 5], measured[:, 6], measured[:, 7] = 0.3 * sign, 0.4 * sign, 5.0
    measured[50:, 6] = np.nan
    sigma = np.array([1.0, 1.0, 0.1, 0.1, 0.1, 0.1, 0.1, np.nan])
    found = residuals(output, measured, t, sigma, pieces(n, [0], np.zeros((1, 6))))
    assert found.chi2[[5, 6]] == pytest.approx([9.0, 16.0])
    assert found.count.tolist() == [n, n, n, n, n, n, 50, 0]
    assert np.isnan(found.chi2[7])
    assert found.total == pytest.approx((9.0 * n + 16.0 * 50) / (6 * n + 50))
    sigma[:] = 0.0
    empty = residuals(output, measured, t, sigma, pieces(n, [0], np.zeros((1, 6))))
    assert empty.count.sum() == 0
    assert np.isnan(empty.total)


def test_where_the_model_has_no_value_nothing_is_compared() -> None:
    n = 100
    t = STEP * np.arange(n)
    output = np.zeros((n, 8))
    output[:, 0], output[:, 3] = 10.0 * t, 10.0
    measured = output.copy()
    output[40:50, 3] = np.nan
    found = residuals(output, measured, t, np.full(8, 0.1), pieces(n, [0], np.zeros((1, 6))))
    assert np.flatnonzero(np.isnan(found.values[:, 3])).tolist() == list(range(40, 50))
    assert np.isfinite(found.values[:, 0]).all()
    assert found.total == pytest.approx(0.0, abs=1e-12)


def test_an_output_is_placed_by_its_first_pose_even_if_it_has_no_speed_there() -> None:
    output = np.zeros((4, 8))
    output[:, 0] = np.arange(4.0)
    output[:2, 3:] = np.nan
    states = np.array([[5.0, 6.0, 0.0, 0.0, 0.0, 0.0]])
    found = posed(output, pieces(4, [0], states))
    assert found[:, :3].tolist() == [[5.0 + k, 6.0, 0.0] for k in range(4)]
