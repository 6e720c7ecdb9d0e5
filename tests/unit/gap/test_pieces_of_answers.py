"""Small pieces behind an answer, by hand: rules of perception, peaks, what comes back, motion, pairs of effects."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.compared_model import CompareError, LogSubject, command_at_stamps, rows_with_motion
from pytest_dvp.gap.compare.noise_floor import sigma
from pytest_dvp.gap.compare.python_model import _apart, _rows
from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.compare.smoothed_motion import motion
from pytest_dvp.gap.diagnose.experiment import _without_jumps
from pytest_dvp.gap.diagnose.first_order_gain import FirstOrderGain
from pytest_dvp.gap.diagnose.masked_pairs import late_pair, masked_pair
from pytest_dvp.gap.diagnose.residual_recurrence import _comes_back, at_speed, over_time
from pytest_dvp.gap.diagnose.residual_spectrum import _peak, _vertex, peaks
from pytest_dvp.gap.extend.perception import _removed
from pytest_dvp.gap.perception.on_top import _border, _dampened, _difference, _share_missed, _variance, on_top
from pytest_dvp.gap.perception.perceived_values import Perceived
from pytest_dvp.logs.log import Log
from tests.unit.gap.linear_world import BRAKE, MOTOR, World, a_search, direction, tried
from vehicle.model.effect import Key
from vehicle.model.model_file import parse_model

INF, NAN = math.inf, math.nan
MODEL = parse_model("[parameters]\nwheelbase = 2.5\n")

# --- perception: what a model needs so that its own run shows the car's; value, shown, base


def key(neutral: float, least: float = 0.1) -> Key:
    return Key("k", "m", 0.0, 10.0, neutral, least, 0.0, 12.0)


@pytest.mark.parametrize(
    ("rule", "neutral", "value", "shown", "base", "needed"),
    [
        (_difference, 0.0, 0.5, 0.2, 0.1, 0.4),
        (_border, INF, INF, 40.0, 30.0, INF),  # the car has none
        (_border, INF, 40.0, 60.0, INF, 40.0),  # the model has none yet: the run's is that of its sensors
        (_border, INF, 40.0, INF, 50.0, 40.0),
        (_border, INF, 40.0, 30.0, 34.0, 44.0),
        (_share_missed, 0.0, 0.5, 0.2, 0.2, 0.5),
        (_share_missed, 0.0, 0.5, 0.0, 0.2, 0.6),  # 0.8 of 0.5 is seen
        (_share_missed, 0.0, 1.0, 1.0, 0.5, 1.0),
        (_share_missed, 0.0, 0.9995, 1.0, 0.0, 0.5),  # never divided by less than a thousandth
        (_dampened, 0.0, 0.6, 0.2, 0.0, 0.4),  # not in the model yet: the difference
        (_dampened, 0.0, 0.6, 0.2, 0.3, 0.9),  # three times as much is asked for as it shows
        (_dampened, 0.0, 0.6, -0.2, 0.3, 1.1),  # it shows the other way round: the difference
        (_dampened, 0.0, 0.6, 0.049, 0.3, 0.851),  # less than half of what is worth a name is no ratio
        (_dampened, 0.0, 0.1, 0.05, 0.3, 0.6),
        (_dampened, 0.0, 1.2, 0.2, 0.3, 1.5),  # five times at most
        (_dampened, 0.0, -1.2, 0.2, 0.3, -1.5),
        (_dampened, 1.0, 1.6, 1.2, 1.3, 1.9),  # counted from doing nothing
        (_dampened, 1.0, 0.85, 0.9, 0.8, 0.7),  # to the other side, too: half as much again
        (_variance, 0.0, 0.5, 0.4, 0.4, 0.5),
        (_variance, 0.0, 0.3, 0.5, 0.2, 0.0),
        (_variance, 0.0, 0.4, 0.0, 0.3, 0.5),
    ],
)
def test_a_rule_takes_what_a_tracker_does_out(
    rule: Any, neutral: float, value: float, shown: float, base: float, needed: float
) -> None:
    assert rule(value, shown, base, key(neutral)) == pytest.approx(needed)


def test_a_needed_value_is_allowed_and_as_unsure_as_both_runs_together() -> None:
    """A latency is 0 to 5 s: 3 s less 4 s are none; widths of 0.3 and 0.4 make 0.5, of 0.6 and 0.8 they make 1."""
    name = ("detection_latency", "T")
    found = Perceived({name: (3.0, 2.7, 3.6), ("detection_offset", "x"): (1.0, 0.5, 1.5)}, {}, {})
    twin = Perceived({name: (4.0, 3.6, 4.8)}, {}, {})
    values = on_top(found, twin, MODEL).values
    assert values[name] == pytest.approx((0.0, -0.5, 1.0))
    assert values["detection_offset", "x"] == (1.0, 0.5, 1.5)  # only one of both tells it
    has = MODEL.with_effect("detection_latency", {"T": 2.0})
    assert on_top(found, twin, has).values[name][0] == pytest.approx(1.0)


def test_an_effect_of_perception_is_taken_out_only_if_the_logs_say_so() -> None:
    model = MODEL.with_effect("detection_latency", {"T": 0.2})
    estimate = SimpleNamespace(value=0.12345, unit="s")
    seen: Any = SimpleNamespace(action="change", parameters={"T": estimate})
    assert _removed("detection_latency", None, model).wrong == (
        "detection_latency: the detections of these logs do not say that the car lacks it: keep it"
    )
    assert _removed("detection_latency", seen, model).wrong == (
        "detection_latency: the detections of these logs show it (T = 0.123 s): keep it"
    )
    seen.action = "remove"
    gone = _removed("detection_latency", seen, model)
    assert gone.wrong == ""
    assert (gone.effect.name, gone.effect.action) == ("detection_latency", "remove")
    assert [e.value for e in gone.effect.parameters.values()] == [0.0]


# --- peaks of a spectrum


def wave(n: int, cycles: float) -> Any:
    return np.sin(2.0 * np.pi * cycles * np.arange(n) / n)


@pytest.mark.parametrize(("n", "found"), [(63, False), (64, True)])
def test_a_peak_needs_64_samples(n: int, found: bool) -> None:
    assert (_peak("time", "Hz", [wave(n, 8.0)], 0.1, 10.0) is not None) is found


def test_a_wave_has_its_frequency_and_explains_all_of_itself() -> None:
    """12 waves in 256 samples of 0.05 s are 0.9375 Hz."""
    found = _peak("time", "Hz", [wave(256, 12.0)], 0.05, 10.0)
    assert found is not None
    assert (found.kind, found.unit) == ("time", "Hz")
    assert found.frequency == pytest.approx(12.0 / 12.8, rel=1e-3)
    assert found.share == pytest.approx(1.0)
    half = _peak("time", "Hz", [wave(256, 12.0), wave(256, 3.0)], 0.05, 10.0)
    assert half is not None
    assert half.share == pytest.approx(0.5, abs=0.02)  # another log has as much of another wave


def test_a_spectrum_is_looked_at_twice_as_finely_as_data_resolve() -> None:
    """Halves of a wave in the log: a quarter off the next of them shows (sin(pi / 4) / (pi / 4))^2 = 0.8106 of it."""
    found = _peak("time", "Hz", [wave(256, 60.25)], 0.05, 10.0)
    assert found is not None
    assert found.share == pytest.approx(0.8106, abs=0.02)


@pytest.mark.parametrize(("cycles", "seen"), [(1.0, False), (5.0, True)])
def test_a_wave_of_which_the_log_holds_less_than_three_is_a_trend(cycles: float, seen: bool) -> None:
    found = _peak("time", "Hz", [wave(256, cycles)], 0.05, 10.0)
    assert found is not None
    assert found.frequency >= 3.0 / 12.8 - 1e-9
    assert (found.share > 0.9) is seen


@pytest.mark.parametrize(("fastest", "share"), [(0.8, 0.1), (1.2, 0.9)])
def test_a_wave_faster_than_is_asked_for_is_none(fastest: float, share: float) -> None:
    found = _peak("time", "Hz", [wave(256, 12.0)], 0.05, fastest)
    assert found is not None
    assert (found.share > 0.9) is (share > 0.5)


def test_a_piece_of_fewer_than_16_samples_says_nothing() -> None:
    noisy = 100.0 * np.where(np.arange(16) % 2 == 0, 1.0, -1.0)
    alone, with_15, with_16 = (
        _peak("time", "Hz", [wave(256, 12.0), *more], 0.05, 10.0) for more in ([], [noisy[:15]], [noisy])
    )
    assert alone is not None
    assert with_16 is not None
    assert with_15 == alone
    assert with_16.share < 0.5
    assert _peak("time", "Hz", [np.ones(256)], 0.05, 10.0) is None


@pytest.mark.parametrize(
    ("power", "k", "at"),
    [
        ([1.0, 3.0, 1.0], 1, 1.0),
        ([2.0, 3.0, 1.0], 1, 1.0 - 0.5 / 3.0),
        ([3.0, 1.0, 1.0], 0, 0.0),
        ([1.0, 1.0, 3.0], 2, 2.0),
        ([1.0, 1.0, 1.0], 1, 1.0),
    ],
)
def test_the_vertex_of_a_parabola_lies_between_the_neighbours(power: list[float], k: int, at: float) -> None:
    assert _vertex(np.array([0.0, 0.5, 1.0]), np.array(power), k) == pytest.approx(0.5 * at)


def test_a_wave_over_the_distance_is_told_from_one_over_time() -> None:
    """Every 2 m, at speeds from 1 to 9 m/s, so that over time it has no frequency."""
    t = np.arange(0.0, 40.0, 0.02)
    way = t + 0.1 * t**2
    found = peaks([np.sin(np.pi * way)], [t], [way])
    assert [p.kind for p in found] == ["distance", "time"]
    assert found[0].frequency == pytest.approx(0.5, rel=0.01)
    assert found[0].share > 0.9
    assert found[0].unit == "1/m"


# --- what comes back


def recurring(times: list[float], values: list[float], rows: int = 9) -> float | None:
    """What is said of visits of one cell, with a cell of its own after each."""
    t, error, cell = [], [], []
    for k, (begin, value) in enumerate(zip(times, values, strict=True)):
        t += [*(begin + 0.1 * np.arange(rows)), *(begin + 0.1 * rows + 0.1 * np.arange(9))]
        error += [value] * rows + [0.0] * 9
        cell += [-1] * rows + [k] * 9
    m: Any = SimpleNamespace(t=np.array(t), step=99.0, moving=np.ones(len(t), bool))
    smooth = np.array(error)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pytest_dvp.gap.diagnose.residual_recurrence.mean_around", lambda y, window: y)
        return _comes_back([smooth], [m], np.array(cell))


def test_an_error_that_is_the_same_at_each_visit_comes_back_whole() -> None:
    """And one that changes sign is predicted worse than by nothing: by the mean of the others, the other way round."""
    times = [30.0 * k for k in range(6)]
    assert recurring(times, [2.0] * 6) == pytest.approx(1.0)
    left = sum((v - sum(w for j, w in enumerate([1.0, -1.0] * 3) if j != k) / 5.0) ** 2
               for k, v in enumerate([1.0, -1.0] * 3))  # fmt: skip
    assert recurring(times, [1.0, -1.0] * 3) == pytest.approx(1.0 - left / 6.0)


def test_six_visits_twenty_seconds_apart_say_something() -> None:
    assert recurring([30.0 * k for k in range(5)], [2.0] * 5) is None
    far = [0.0, 20.1, 40.2, 60.3, 80.4, 100.5]
    assert recurring(far, [2.0] * 6) == pytest.approx(1.0)


@pytest.mark.parametrize(("apart", "mean_off"), [(19.9, 2.0), (20.1, 2.4)])
def test_visits_up_to_twenty_seconds_apart_are_one(apart: float, mean_off: float) -> None:
    """Errors of 1 and 5 at three pairs of visits: the other pairs say 3, those with the other of the own pair 3.4 or
    2.6; of squares of 78 in all that leaves six times 4 or 5.76."""
    times = [begin + later for begin in (0.0, 300.0, 600.0) for later in (0.0, apart)]
    assert recurring(times, [1.0, 5.0] * 3) == pytest.approx(1.0 - 6.0 * mean_off**2 / 78.0)


def test_of_a_visit_of_three_rows_nothing_is_said() -> None:
    times = [30.0 * k for k in range(6)]
    assert recurring(times, [2.0] * 6, rows=3) is None
    assert recurring(times, [2.0] * 6, rows=4) == pytest.approx(1.0)


def test_an_error_that_grows_is_told_by_ranks_and_by_its_second_half() -> None:
    found = over_time([np.array([0.0, 1.0, 2.0, 5.0])])
    assert found == {"rank_correlation": pytest.approx(1.0), "share_in_second_half": pytest.approx(7.0 / 8.0)}
    both = over_time([np.array([0.0, 1.0, 2.0, 5.0]), np.array([4.0, 3.0, 1.0, 0.0])])
    assert both == {"rank_correlation": pytest.approx(0.0), "share_in_second_half": pytest.approx(8.0 / 16.0)}
    nothing = {"rank_correlation": 0.0, "share_in_second_half": 0.5}
    assert over_time([np.array([0.0, 1.0, 2.0])]) == over_time([np.zeros(9)]) == nothing


def test_the_speed_that_holds_most_error_for_its_time_is_named() -> None:
    v = np.r_[np.full(80, 3.0), np.full(20, 12.0)]
    m: Any = SimpleNamespace(v=v, moving=np.ones(100, bool))
    found = at_speed([np.r_[np.full(80, 1.0), np.full(20, 4.0)]], [m])
    assert found["share_of_error"] == pytest.approx(320.0 / 400.0)
    assert found["share_of_time"] == pytest.approx(0.2)


# --- noise, jumps, and logs as models


@pytest.mark.parametrize(("known", "taken"), [(15, False), (16, True)])
def test_a_residual_of_sixteen_samples_lowers_the_noise(known: int, taken: bool) -> None:
    """One that alternates by 0.01 has third differences of 0.08, and 1.4826 / sqrt(20) of that is its level."""
    t = 0.02 * np.arange(200.0)
    y = np.random.default_rng(3).normal(size=200)
    residual = np.full(200, NAN)
    residual[:known] = 0.01 * (-1.0) ** np.arange(known)
    found = sigma(t, y, residual)
    assert (found == pytest.approx(1.482602 * 0.08 / math.sqrt(20.0))) is taken
    assert (found == pytest.approx(sigma(t, y))) is not taken


def test_where_a_command_jumps_by_more_than_five_deviations_the_acceleration_has_no_value() -> None:
    measured = np.zeros((5, len(CHANNELS)))
    command = np.array([7.0, 7.0, 9.5, 6.99, 6.99])  # 5 times 0.5 is 2.5: not more
    found = _without_jumps(measured, command, 0.5)
    ax = CHANNELS.index("ax")
    assert np.isnan(found[:, ax]).tolist() == [False, False, False, True, False]
    assert np.isfinite(np.delete(found, ax, axis=1)).all()
    assert np.isfinite(measured).all()
    assert _without_jumps(measured, None, 0.5) is measured
    assert _without_jumps(measured, command, INF) is measured


def two_logs(t: Any, other: Any, **columns: Any) -> Any:
    return LogSubject(Log({"t": np.asarray(other), **columns})).at(np.asarray(t))


def test_a_second_log_is_straight_between_its_stamps_and_silent_in_holes() -> None:
    v = CHANNELS.index("v")
    stamps = np.array([0.0, 0.1, 0.2, 5.0, 5.1])
    found = two_logs([-0.1, 0.0, 0.05, 0.2, 2.0, 5.0, 5.05, 5.1, 5.2], stamps, v=np.arange(5.0))[:, v]
    assert found == pytest.approx([NAN, 0.0, 0.5, 2.0, NAN, 3.0, 3.5, 4.0, NAN], nan_ok=True)
    assert np.isnan(two_logs([0.0, 1.0], stamps, v=np.array([1.0, NAN, NAN, NAN, NAN]))).all()
    two = two_logs([0.0, 0.05], stamps, v=np.array([1.0, 2.0, NAN, NAN, NAN]))[:, v]
    assert two == pytest.approx([1.0, 1.5])


def test_a_heading_of_a_second_log_goes_the_short_way_round() -> None:
    found = two_logs([0.05], [0.0, 0.1], yaw=np.array([3.0, -3.0]))[0, CHANNELS.index("yaw")]
    assert found == pytest.approx(math.pi)


@pytest.mark.parametrize(
    ("begin", "told"), [(10.1, "(10.1 to 11.1 s and 0.0 to 10.0 s)"), (-1.2, "(-1.2 to -0.2 s and")]
)
def test_logs_that_share_no_time_are_no_model_of_each_other(begin: float, told: str) -> None:
    log = Log({"t": np.arange(0.0, 10.1, 0.1)})
    other = LogSubject(Log({"t": begin + np.arange(0.0, 1.1, 0.1), "v": np.ones(11)}), "b.csv")
    with pytest.raises(CompareError, match=r"b\.csv: has no time in common") as refused:
        other.output(log, None)  # type: ignore[arg-type]
    assert told in str(refused.value)


@pytest.mark.parametrize("begin", [10.0, -1.0])
def test_logs_that_share_an_instant_have_time_in_common(begin: float) -> None:
    t = np.arange(0.0, 10.5, 0.5)
    other = LogSubject(Log({"t": begin + 0.5 * np.arange(3.0), "v": np.ones(3)}), "b.csv")
    whole: Any = SimpleNamespace(starts=np.array([0]), ends=np.array([len(t)]), states=np.full((1, 6), np.nan))
    other.output(Log({"t": t}), whole)
    assert np.flatnonzero(np.isfinite(other.at(t)[:, CHANNELS.index("v")])).tolist() == [20 if begin > 0.0 else 0]


def test_rows_in_which_a_second_log_has_all_of_its_motion() -> None:
    t = 0.1 * np.arange(4.0)
    log = Log({"t": t})
    whole = LogSubject(Log({"t": t, "v": np.ones(4), "x": np.ones(4)}))
    assert rows_with_motion(log, whole) == []
    part = LogSubject(Log({"t": t, "v": np.ones(4), "x": np.array([NAN, NAN, 1.0, 1.0])}))
    (rows,) = rows_with_motion(log, part)
    assert rows.tolist() == [False, False, True, True]


def test_a_command_is_held_where_it_was_not_logged() -> None:
    log = Log({"t": np.arange(5.0), "steer_cmd": np.array([NAN, 1.0, NAN, 2.0, NAN])})
    assert command_at_stamps(log, "steer_cmd", "it").tolist() == [1.0, 1.0, 1.0, 2.0, 2.0]


def test_a_state_with_lists_is_copied_and_one_of_numbers_is_not() -> None:
    numbers: Any = {"v": 1.0, "n": 2}
    lists: Any = {"v": 1.0, "queue": [1.0]}
    assert _apart(numbers) is numbers
    assert _apart(lists) == lists
    assert _apart(lists)["queue"] is not lists["queue"]
    assert _rows({}, 2) == [{}, {}]
    assert _rows({"a": np.array([1.0, 2.0]), "b": np.array([3.0, 4.0])}, 2) == [
        {"a": 1.0, "b": 3.0},
        {"a": 2.0, "b": 4.0},
    ]


def test_speed_and_yaw_rate_that_were_not_measured_follow_from_the_way() -> None:
    """Straight at 3 m/s in x and 4 in y, turning by 0.2 rad/s; of two rows nothing can be derived."""
    t = 0.05 * np.arange(9.0)
    columns = {"t": t, "x": 3.0 * t, "y": 4.0 * t, "yaw": 0.2 * t, "accel_cmd": np.ones(9), "steer_cmd": np.zeros(9)}
    for rows in (9, 3):
        found = motion(Log({name: values[:rows] for name, values in columns.items()}), MODEL)
        assert found.v == pytest.approx(np.full(rows, 5.0))
        assert found.yaw_rate == pytest.approx(np.full(rows, 0.2))
        assert found.way[-1] == pytest.approx(5.0 * t[rows - 1])
        assert found.driven[-1] == pytest.approx(5.0 * t[rows - 1])
        assert found.braked[-1] == 0.0
    both = motion(Log({name: values[:2] for name, values in columns.items()}), MODEL)
    assert both.v.tolist() == both.yaw_rate.tolist() == [0.0, 0.0]
    braking = motion(Log({**columns, "v": np.full(9, 5.0), "accel_cmd": np.full(9, -2.0)}), MODEL)
    assert braking.braked[-1] == pytest.approx(2.0 * 5.0 * t[-1])
    assert braking.driven[-1] == 0.0


@pytest.mark.parametrize(("v", "moves"), [(0.05, False), (0.3, True), (-0.3, True)])
def test_who_is_slower_than_a_tenth_of_a_metre_a_second_stands(v: float, moves: bool) -> None:
    t = 0.05 * np.arange(9.0)
    flat = {name: np.zeros(9) for name in ("x", "y", "yaw", "yaw_rate", "accel_cmd", "steer_cmd")}
    assert motion(Log({"t": t, "v": np.full(9, v), **flat}), MODEL).moving.all() == moves


# --- what an effect promises, to first order, and pairs


@pytest.mark.parametrize(("needed", "points"), [(9.9, 3), (10.1, 1)])
def test_an_effect_that_promises_less_than_a_tenth_of_what_is_needed_is_looked_at_once(
    needed: float, points: int
) -> None:
    """In its direction there is an error of 5: all that it can take away is 25."""
    world = World({BRAKE: 200.0 * direction(1)})
    world.noise = world.noise + 5.0 * direction(1)
    search = a_search(world, "brake_gain")
    look = FirstOrderGain(world, search.trial((), {}))  # type: ignore[arg-type]
    (candidate,) = tried("brake_gain")
    strong = [{BRAKE: g, MOTOR: 0.0} for g in (0.7, 0.8, 0.9)]
    found = look.remaining_chi2(candidate, strong, needed * 25.0)
    assert (len(found) == 1) is (points == 1)
    if points == 1:
        assert found == [(pytest.approx(1000.0 + (5.0 - 20.0) ** 2), {BRAKE: 0.9, MOTOR: 0.0})]
    assert len(look.remaining_chi2(candidate, strong[:1], needed * 25.0)) >= 1


@pytest.mark.parametrize(("size", "shows"), [(0.0099, False), (0.0101, True)])
def test_a_change_of_a_ten_millionth_of_the_samples_is_nothing(size: float, shows: bool) -> None:
    """1e-7 of 1000 samples is a chi^2 of 1e-4."""
    world = World({BRAKE: size / 0.1 * direction(1)})
    look = FirstOrderGain(world, a_search(world, "brake_gain").trial((), {}))  # type: ignore[arg-type]
    (candidate,) = tried("brake_gain")
    assert bool(look.remaining_chi2(candidate, [{BRAKE: 0.9, MOTOR: 0.0}])) is shows
    assert look.strongest == pytest.approx(size**2)


class Pairing:
    """A search whose sets cost what `costs` says by names; all pay and mean something but what is said."""

    def __init__(self, costs: dict[frozenset[str], float], *, idle: Any = (), vague: Any = ()) -> None:
        self.costs, self.idle, self.vague = costs, set(idle), set(vague)
        self.tried = {c.name: c for c in tried("understeer", "tyre_relaxation", "tyre_saturation")}
        self.target: Any = None

    def trial(self, names: Any, start: Any, *, like: Any = None) -> Any:
        return SimpleNamespace(names=tuple(names), values={}, chi2=self.costs.get(frozenset(names), 99.0))

    def cost(self, trial: Any) -> float:
        return float(trial.chi2)

    def is_worth_adding(self, without: Any, with_it: Any) -> bool:
        return frozenset(without.names) not in self.idle

    def is_credible(self, trial: Any, name: str) -> bool:
        return name not in self.vague


A, B, C = "understeer", "tyre_relaxation", "tyre_saturation"


@pytest.mark.parametrize(
    ("costs", "idle", "vague", "found"),
    [
        ({frozenset((A, B)): 5.0, frozenset((B, C)): 4.0}, (), (), {B, C}),
        ({frozenset((A, B)): 5.0, frozenset((B, C)): 4.0}, (), (C,), {A, B}),
        ({frozenset((A, B)): 5.0}, (frozenset(),), (), None),  # none pays beside nothing
        ({frozenset((A, B)): 5.0}, (), (B,), {A, C}),
    ],
)
def test_the_best_pair_of_tyre_effects_that_pays_and_means_something(
    costs: Any, idle: Any, vague: Any, found: set[str] | None
) -> None:
    search: Any = Pairing(costs, idle=idle, vague=vague)
    result = late_pair(search, search.trial((), {}))
    assert [set(t.names) for t in result] == ([] if found is None else [found])


@pytest.mark.parametrize(
    ("idle", "vague", "found"),
    [
        ((), (), (A, B)),  # the cheapest
        ((frozenset((A,)),), (), (B, C)),  # beside one of them the other one does not pay
        ((frozenset(),), (), None),
        ((), (A,), (B, C)),
        ((), (B,), None),
    ],
)
def test_a_masked_pair_pays_as_a_whole_and_each_beside_the_other(
    monkeypatch: pytest.MonkeyPatch, idle: Any, vague: Any, found: Any
) -> None:
    search: Any = Pairing({frozenset((A, B)): 4.0, frozenset((B, C)): 5.0}, idle=idle, vague=vague)
    pairs = [(1.0, (B, C), {}), (2.0, (A, B), {}), (3.0, ("mass", B), {}), (4.0, ("mass", C), {})]
    monkeypatch.setattr("pytest_dvp.gap.diagnose.masked_pairs.promising", lambda target, now, pairs_: pairs)
    result = masked_pair(search, search.trial((), {}))
    assert [t.names for t in result] == ([] if found is None else [found])
