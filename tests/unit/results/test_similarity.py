"""MNCC, lag and gain of two logs."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from results_logs import log_of, relaxed, times, track

from pytest_dvp.logs.likeness import likeness
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from pytest_dvp.metrics import compute


def bump(t: FloatArray, at: float) -> FloatArray:
    """A signal without mean that is zero at both ends, so that neither a shift nor the mean removal costs anything."""

    def wave(place: float, width: float) -> FloatArray:
        return -(t - place) / width * np.exp(-(((t - place) / width) ** 2))

    return wave(at, 1.5) - 0.4 * wave(at + 4.0, 0.7)


T = times(40.0)


def test_signal_is_like_itself() -> None:
    log = log_of(40.0, columns={"v": bump(T, 15.0)})
    assert compute("mncc", log, log, signal="v").value == pytest.approx(1.0, abs=1e-12)
    assert compute("lag", log, log, signal="v").value == 0.0
    assert compute("gain", log, log, signal="v").value == pytest.approx(1.0)


@pytest.mark.parametrize("delay", [0.3, -0.3, 2.0, 4.9])
def test_lag_is_positive_when_the_measurement_comes_later(delay: float) -> None:
    model = log_of(40.0, columns={"steer": bump(T, 15.0)})
    measured = log_of(40.0, columns={"steer": bump(T, 15.0 + delay)})
    assert compute("lag", model, measured, signal="steer").value == pytest.approx(delay, abs=1e-9)
    assert compute("mncc", model, measured, signal="steer").value == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("late", [0.0, 0.1, -0.3])
def test_noise_does_not_choose_between_the_turns_of_a_signal_that_repeats(late: float) -> None:
    """A slalom of 2 s is alike after each of its turns; the nearest to no shift is the one that is meant."""
    t = np.arange(0.0, 20.0, 0.02)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        model, measured = (np.sin(math.pi * (t - by)) + rng.normal(0.0, 0.05, len(t)) for by in (0.0, late))
        assert likeness(model, measured, 0.02).lag == pytest.approx(late, abs=0.041)


@pytest.mark.parametrize("late", [2.0, -2.0, 2.1])
def test_a_slalom_that_is_a_whole_turn_late_is_told_by_how_it_grows(late: float) -> None:
    t = np.arange(0.0, 20.0, 0.02)

    def swerve(at: FloatArray) -> FloatArray:
        return (1.0 + 0.15 * at) * np.sin(math.pi * at) * (at > 4.0)

    rng = np.random.default_rng(5)
    model, measured = (swerve(t - by) + rng.normal(0.0, 0.05, len(t)) for by in (0.0, late))
    assert likeness(model, measured, 0.02).lag == pytest.approx(late, abs=0.041)


@pytest.mark.parametrize("seed", range(5))
def test_ripples_of_noise_do_not_draw_a_lag_to_no_shift(seed: int) -> None:
    """One slow rise and fall with as much noise as signal: its broad top has many small ones."""
    t = np.arange(0.0, 60.0, 0.02)
    noise = np.random.default_rng(seed).normal(0.0, 0.2, (2, len(t)))
    model, measured = (np.exp(-(((t - 30.0 - by) / 3.0) ** 2)) + noise[k] for k, by in enumerate((0.0, 1.0)))
    assert likeness(model, measured, 0.02).lag == pytest.approx(1.0, abs=0.7)


def test_gain_is_measured_over_model_and_mncc_is_blind_to_it() -> None:
    model = log_of(40.0, columns={"steer": bump(T, 15.0)})
    measured = log_of(40.0, columns={"steer": 7.0 + 0.75 * bump(T, 15.3)})
    result = compute("mncc", model, measured, signal="steer")
    assert result.value == pytest.approx(1.0, abs=1e-6)
    assert result.extra["gain"] == pytest.approx(0.75, rel=1e-6)
    assert result.extra["lag"] == pytest.approx(0.3)


@pytest.mark.parametrize("signal", ["yaw", "ads.yaw", "object.car.yaw"])
@pytest.mark.parametrize("turns", [0.0, 1.0, -3.0])
def test_whole_turns_are_no_difference_of_headings(signal: str, turns: float) -> None:
    """A car that goes west, its heading around pi: one side wraps it to between -pi and pi, or counts further turns."""
    heading, measured = np.pi + 0.2 * bump(T, 15.0), np.pi + 0.02 + 0.2 * bump(T, 15.3)
    told = measured + 2.0 * np.pi * turns if turns else np.remainder(measured + np.pi, 2.0 * np.pi) - np.pi
    assert turns or np.ptp(told) > 6.0  # it jumps

    def log(yaw: FloatArray) -> Log:
        car = dataclasses.replace(track(T, 0.0, 0.0), yaw=yaw)
        return log_of(40.0, columns={"yaw": yaw, "ads.yaw": yaw}, objects={"car": car})

    found = compute("bias", log(heading), log(told), signal=signal)
    assert found.value == pytest.approx(0.02, abs=1e-4)
    assert found.extra["lag"] == pytest.approx(0.3)
    assert found.extra["gain"] == pytest.approx(1.0)
    assert found.extra["mncc"] == pytest.approx(1.0, abs=1e-6)


def test_lag_beyond_the_window_is_not_looked_for() -> None:
    model, measured = bump(T, 12.0), bump(T, 20.0)
    assert abs(likeness(model, measured, 0.01, max_lag=5.0).lag) <= 5.0
    assert likeness(model, measured, 0.01, max_lag=10.0).lag == pytest.approx(8.0)


@relaxed
@given(seed=st.integers(0, 10**6), n=st.integers(3, 900), max_lag=st.floats(0.0, 5.0))
def test_fft_correlation_is_the_defining_sum(seed: int, n: int, max_lag: float) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(2, n))
    result = likeness(x, y, 0.1, max_lag)
    x0, y0 = x - x.mean(), y - y.mean()
    norm = math.sqrt(x0 @ x0) * math.sqrt(y0 @ y0)
    for lag, value in zip(np.round(result.lags / 0.1).astype(int), result.correlation, strict=True):
        expected = x0[max(0, -lag) : n - max(0, lag)] @ y0[max(0, lag) : n - max(0, -lag)] / norm
        assert value == pytest.approx(expected, abs=1e-10)


def test_signals_of_opposite_sign_are_not_alike() -> None:
    assert likeness(T, -T, 0.01, max_lag=0.0).mncc == pytest.approx(-1.0)


@pytest.mark.parametrize("name", ["mncc", "lag", "gain"])
def test_constant_signal_is_undefined(name: str) -> None:
    log = log_of(10.0, columns={"v": 5.1})
    result = compute(name, log, log, signal="v")
    assert (result.valid, result.reason) == (False, "the signal is constant")


def test_without_the_other_log_it_is_undefined() -> None:
    result = compute("mncc", log_of(10.0), signal="v")
    assert (result.valid, result.reason) == (False, "the log to compare with is not there")


def test_logs_of_other_rate_and_start_are_compared_where_they_overlap() -> None:
    model = log_of(40.0, columns={"v": bump(T, 15.0)})
    other = log_of(40.0, columns={"v": bump(T, 15.0)})
    for name in other.columns:
        other.columns[name] = other.columns[name][200:3801:2]
    assert compute("mncc", model, other, signal="v").value == pytest.approx(1.0, abs=1e-4)
    assert compute("lag", model, other, signal="v").value == 0.0


def test_motion_of_an_object_can_be_compared() -> None:
    t = T[::5]
    model = log_of(40.0, objects={"car": track(t, bump(t, 15.0), 0.0)})
    measured = log_of(40.0, objects={"car": track(t, bump(t, 15.5), 0.0)})
    assert compute("lag", model, measured, signal="object.car.x").value == pytest.approx(0.5)


def test_object_that_is_not_there_is_undefined() -> None:
    log = log_of(10.0)
    assert compute("mncc", log, log, signal="object.car.x").reason == "no object.car.x in the log"


def test_rows_at_which_a_signal_was_not_measured_are_left_out_and_two_are_needed() -> None:
    """0.2 s without a value are straight between their ends: of a wave of some seconds the same within a thousandth."""
    whole = log_of(40.0, columns={"v": bump(T, 15.0)})
    gappy = log_of(40.0, columns={"v": np.where((T > 13.0) & (T < 13.2), np.nan, bump(T, 15.0))})
    for pair in ((whole, gappy), (gappy, whole), (gappy, gappy)):
        assert compute("mncc", *pair, signal="v").value == pytest.approx(1.0, abs=1e-3)
        assert compute("gain", *pair, signal="v").value == pytest.approx(1.0, abs=1e-3)
    for last in (0.0, -1.0):  # one value, or none
        few = log_of(40.0, columns={"v": np.where(last >= T, bump(T, 15.0), np.nan)})
        assert compute("mncc", whole, few, signal="v").reason == "v was not measured"


def test_a_way_is_like_itself_wherever_on_the_map_it_lies() -> None:
    """A lane change of 3.5 m, 5800 km north of the equator as UTM counts."""
    way = 3.5 * np.clip((T - 10.0) / 5.0, 0.0, 1.0)
    for north in (0.0, 5.8e6):
        assert likeness(north + way, north + way, 0.01).mncc == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("late", [30, 95, 150])
@pytest.mark.parametrize("stands", [0, 400])
def test_the_lag_of_a_drive_that_begins_later_is_its_delay(late: int, stands: int) -> None:
    """A drive that begins and ends in standstill, 0.01 s a sample; correlation over the whole norms said 0."""
    ramp = np.concatenate([np.zeros(stands + 100), np.linspace(0.0, 8.0, 400), np.full(1500, 8.0)])
    speed = np.concatenate([ramp, np.linspace(8.0, 0.0, 500), np.zeros(300)])
    delayed = np.concatenate([np.zeros(late), speed[:-late]])
    found = likeness(speed, delayed, 0.01)
    assert found.lag == pytest.approx(0.01 * late)
    assert found.gain == pytest.approx(1.0)
    back = likeness(delayed, speed, 0.01)
    assert (back.lag, back.gain) == pytest.approx((-0.01 * late, 1.0))


def test_a_short_piece_that_is_alike_by_chance_is_no_lag() -> None:
    """The end of one signal is the begin of the other; most of them is alike where they are."""
    rng = np.random.default_rng(11)
    one = np.convolve(rng.standard_normal(1000), np.ones(40) / 40.0, mode="same")
    other = one + 0.2 * np.convolve(rng.standard_normal(1000), np.ones(40) / 40.0, mode="same")
    other[:120] = one[-120:]
    assert likeness(one, other, 0.1, max_lag=99.0).lag == pytest.approx(0.0, abs=0.2)


def test_a_straight_line_has_no_lag_that_could_be_told() -> None:
    line = np.linspace(0.0, 100.0, 1000)
    assert likeness(line, line + 3.0, 0.01).lag == 0.0


@pytest.mark.parametrize(
    ("known", "defined"),
    [((0.0, 19.0), False), ((0.0, 21.0), True), ((19.0, 40.0), True), ((22.0, 40.0), False)],
)
def test_of_less_than_half_of_a_drive_no_likeness_is_told(known: tuple[float, float], defined: bool) -> None:
    """A drive that ended early is alike in its first seconds, which says nothing of the rest."""
    model = log_of(40.0, columns={"v": bump(T, 15.0)})
    inside = (known[0] <= T) & (known[1] >= T)
    part = log_of(40.0, columns={"v": np.where(inside, bump(T, 15.0), np.nan)})
    for pair in ((model, part), (part, model)):
        found = [compute(name, *pair, signal="v") for name in ("mncc", "lag", "gain", "bias")]
        assert [one.valid for one in found] == [defined] * 4
    seconds = f"{known[1] - known[0]:.1f}"
    told = compute("mncc", model, part, signal="v").reason
    assert told == ("" if defined else f"both logs have it for {seconds} s only, one of them for 40.0 s")


@pytest.mark.parametrize(("until", "defined"), [(29.0, True), (31.0, False)])
def test_a_hole_is_nothing_that_two_signals_share(until: float, defined: bool) -> None:
    """Not measured from 10 s on: through the hole a straight line would be compared."""
    model = log_of(40.0, columns={"v": bump(T, 15.0)})
    holed = log_of(40.0, columns={"v": np.where((T > 10.0) & (until > T), np.nan, bump(T, 15.0))})
    assert compute("mncc", model, holed, signal="v").valid == defined


def test_a_slow_sensor_has_no_holes() -> None:
    """One value a second in a log of 100 Hz."""
    model = log_of(40.0, columns={"v": np.sin(0.3 * T)})
    slow = log_of(40.0, columns={"v": np.where(np.arange(len(T)) % 100 == 0, np.sin(0.3 * T), np.nan)})
    assert compute("mncc", model, slow, signal="v").value == pytest.approx(1.0, abs=1e-3)
