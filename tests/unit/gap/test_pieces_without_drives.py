"""Pieces of comparing and diagnosing that only whole drives had asked for: each on a few rows that are written down."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare import position_error as position_module
from pytest_dvp.gap.compare.compared_model import CompareError, LogSubject, _span, command_at_stamps, rows_with_commands
from pytest_dvp.gap.compare.iso18571 import _shift
from pytest_dvp.gap.compare.match_bounds import BoundCheck, judge_bounds
from pytest_dvp.gap.compare.position_error import position_error
from pytest_dvp.gap.compare.segments import CHANNELS, _around, _over_ground, filled, stands_for
from pytest_dvp.gap.compare.time_alignment import alike, common_lag, coverage, grid, on_grid
from pytest_dvp.gap.diagnose.chance_gain import _within
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, Estimate, NamedEffect, Step
from pytest_dvp.gap.diagnose.error_shares import shares
from pytest_dvp.gap.diagnose.usual_values import has_usual_values, usual_set
from pytest_dvp.gap.diagnose.wheelbase_check import _implied
from pytest_dvp.gap.words.diagnosis import _second_opinion, setup_lines
from pytest_dvp.gap.words.diagnosis_page import _whole
from pytest_dvp.logs.log import Log
from vehicle.model.effect import Key

NAN = math.nan

# --- stamps around a stamp, and what moves between them


def test_stamps_before_and_after_lie_a_fifth_of_a_second_away_or_at_the_ends() -> None:
    """Steps of 1/16 s: four of them are the first beyond 0.2 s, and before a stamp the last one that is beyond."""
    ahead, behind = _around(np.arange(12) / 16.0)
    assert ahead.tolist() == [4, 5, 6, 7, 8, 9, 10, 11, 11, 11, 11, 11]
    assert behind.tolist() == [0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7]


def test_the_speed_over_ground_is_along_the_heading() -> None:
    """5 m/s at atan(3/4) to the heading: 4 m/s along it; backwards they are negative."""
    t = np.arange(12) / 16.0
    whole = np.zeros((12, 8))
    whole[:, 0], whole[:, 1], whole[:, 2] = 3.0 * t, 4.0 * t, math.atan2(4.0, 3.0) - math.atan2(3.0, 4.0)
    assert _over_ground(t, whole)[5] == pytest.approx(4.0)
    assert _over_ground(t, whole) == pytest.approx(np.full(12, 4.0))
    whole[:, 2] += math.pi
    assert _over_ground(t, whole) == pytest.approx(np.full(12, -4.0))


@pytest.mark.parametrize(
    ("rows", "there"),
    [
        ([], []),
        ([3], [3]),  # one value has no usual time
        ([0, 2], [0, 1, 2]),  # 0.2 s apart is usual here, and up to five times that
        ([0, 2, 4, 8], [0, 1, 2, 3, 4, 5, 6, 7, 8]),
        ([0, 1, 2, 9], [0, 1, 2, 3, 9]),  # a value holds for its usual time
    ],
)
def test_samples_stand_for_all_rows_but_those_of_gaps(rows: list[int], there: list[int]) -> None:
    known = np.zeros(10, dtype=bool)
    known[rows] = True
    t = np.arange(10) / 8.0
    found = np.flatnonzero(stands_for(t, known))
    last = rows[-1] if len(rows) > 1 else 9
    assert [row for row in found.tolist() if row <= last] == there


def test_a_log_of_one_row_is_filled_as_it_is() -> None:
    measured = np.full((1, 8), NAN)
    measured[0, :2] = 3.0, 4.0
    assert filled(np.zeros(1), measured).tolist() == [[3.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]


# --- how far off some seconds after a start


class Driven:
    """Two segments of 3 s in steps of 0.5 s; the model is off by (3, 4) m more in each second of a segment."""

    def __init__(self, counted: Any = None) -> None:
        t = 0.5 * np.arange(12.0)
        self.log: Any = SimpleNamespace(t=t)
        self.measured = np.zeros((12, 8))
        every = np.ones(12, dtype=bool)
        self.segments: Any = SimpleNamespace(
            starts=np.array([0, 6]), ends=np.array([6, 12]), counted=every if counted is None else counted
        )

    def motion(self, values: Any) -> Any:
        off = np.zeros((12, 8))
        since = np.tile(0.5 * np.arange(6.0), 2)
        off[:, 0], off[:, 1] = 3.0 * since, 4.0 * since
        off[6:] *= values["times"]
        return off


@pytest.mark.parametrize(
    ("ahead", "gone", "error"),
    [
        (2.0, (), math.sqrt((10.0**2 + 30.0**2) / 2.0)),  # 5 m a second, and three times that in the second
        (1.0, (), math.sqrt((5.0**2 + 15.0**2) / 2.0)),
        (2.5, (), math.sqrt((12.5**2 + 37.5**2) / 2.0)),  # the last row of each
        (2.6, (), NAN),  # beyond the ends
        (2.0, (5,), math.sqrt((10.0**2 + 30.0**2) / 2.0)),  # what comes later does not matter
        (2.0, (4,), 30.0),
        (2.0, (0, 6), NAN),
    ],
)
def test_the_position_some_seconds_after_each_start(
    ahead: float, gone: Any, error: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted = np.ones(12, dtype=bool)
    counted[list(gone)] = False
    target = SimpleNamespace(experiments=[Driven(counted)])
    monkeypatch.setattr(position_module, "experiment_set", lambda logs, model: target)
    monkeypatch.setattr(position_module, "posed", lambda output, segments: output)
    values: Any = {"times": 3.0}
    model: Any = None
    assert position_error({}, model, values, ahead) == pytest.approx(error, nan_ok=True)
    if ahead == 2.0:
        assert position_error({}, model, values) == pytest.approx(error, nan_ok=True)


# --- bounds


def scored(**signals: dict[str, Any]) -> Any:
    made = {name: SimpleNamespace(**{"rmse": 0.5, "mncc": 0.75, "lag": -0.25, "gain": 0.75} | more)
            for name, more in signals.items()}  # fmt: skip
    return SimpleNamespace(signals=made, not_compared={"steer": "it drives the model"})


@pytest.mark.parametrize(
    ("kind", "bound", "value", "holds"),
    [
        ("rmse", 0.5, 0.5, True), ("rmse", 0.4999, 0.5, False), ("mncc", 0.75, 0.75, True),
        ("mncc", 0.7501, 0.75, False), ("lag", 0.25, 0.25, True), ("lag", 0.2499, 0.25, False),
        ("gain", 0.25, 0.25, True), ("gain", 0.2499, 0.25, False),
    ],
)  # fmt: skip
def test_a_bound_holds_up_to_itself(kind: str, bound: float, value: float, holds: bool) -> None:
    (check,) = judge_bounds(scored(v={}), {kind: bound})
    assert (check.kind, check.signal, check.value, check.bound, check.holds) == (kind, "v", value, bound, holds)
    assert check.unit == {"rmse": "m/s", "lag": "s"}.get(kind, "-")


def test_a_number_bounds_every_signal_that_tells_it() -> None:
    """Positions tell neither lag nor gain, nor does a signal that is not alike."""
    found = scored(x={}, y={}, v={}, ax={"mncc": 0.499}, ay={"mncc": 0.5}, yaw={"mncc": None})
    asked = judge_bounds(found, {"rmse": 1.0, "lag": 1.0, "gain": None})
    assert [check.signal for check in asked if check.kind == "rmse"] == ["x", "y", "v", "ax", "ay", "yaw"]
    assert [check.signal for check in asked if check.kind == "lag"] == ["v", "ay"]
    assert len(asked) == 8
    chosen = judge_bounds(found, {"gain": {"x": 1.0, "steer": 2.0, "wheel": 3.0}})
    assert [(c.signal, c.value, c.holds) for c in chosen] == [("x", 0.25, True), ("steer", None, False),
                                                             ("wheel", None, False)]  # fmt: skip
    assert chosen[1].reason == "not compared (it drives the model)"
    assert chosen[2].reason == "not compared (no such signal; known: x, y, yaw, v, yaw_rate, ax, ay, steer)"


@pytest.mark.parametrize("kind", ["lag", "gain"])
def test_a_number_that_no_signal_tells_does_not_hold(kind: str) -> None:
    """A model of a car that drives on at one speed, beside one that speeds up and brakes: nothing would be judged."""
    (check,) = judge_bounds(scored(x={}, y={}, v={"mncc": 0.24}, yaw={"mncc": None}), {kind: 0.05})
    assert (check.value, check.holds) == (None, False)
    assert str(check) == (
        f"{kind} of every signal: no signal tells it: none that is compared, x and y aside, has an MNCC of 0.5 or more"
    )


@pytest.mark.parametrize("nothing", [None, NAN])
def test_a_figure_that_is_not_defined_holds_no_bound(nothing: float | None) -> None:
    (check,) = judge_bounds(scored(v={"gain": nothing}), {"gain": {"v": 1.0}})
    assert (check.value, check.holds) == (None, False)
    assert str(check) == "gain of v: not defined: the signal is constant or has no samples"
    (lag,) = judge_bounds(scored(v={"lag": nothing}), {"lag": {"v": 1.0}})  # alike, and yet no lag was found
    assert str(lag) == "lag of v: not defined: the best lag is beyond the 2 s that are looked at"


@pytest.mark.parametrize(
    ("check", "text"),
    [
        (BoundCheck("rmse", "v", 0.25, 0.5, "m/s", True), "rmse of v 0.25 m/s <= 0.5 m/s"),
        (BoundCheck("rmse", "v", 0.50001, 0.5, "m/s", False), "rmse of v 0.50001 m/s > 0.5 m/s"),
        (BoundCheck("mncc", "v", 0.5, 0.9, "-", False), "mncc of v 0.5 < 0.9"),
        (BoundCheck("mncc", "v", 0.9, 0.9, "-", True), "mncc of v 0.9 >= 0.9"),
        (BoundCheck("lag", "v", 1.0 / 3.0, 0.5, "s", True), "lag of v 0.3333 s <= 0.5 s"),
    ],
)
def test_a_bound_in_words_has_the_digits_that_keep_it_apart(check: BoundCheck, text: str) -> None:
    assert str(check) == text


# --- time


def test_a_row_stands_for_the_time_to_the_next_and_before_a_gap_for_the_usual_step() -> None:
    t = np.array([0.0, 1.0, 2.0, 3.0, 13.0])
    assert coverage(t, np.ones(5, dtype=bool), 5.0) == pytest.approx(4.0 / 13.0)
    assert coverage(t, np.ones(5, dtype=bool), 10.0) == 1.0  # just as long as the longest is no gap
    assert coverage(t, np.array([True, False, True, False, True]), 10.0) == pytest.approx(2.0 / 13.0)


def test_an_even_time_base_reaches_the_last_stamp_and_what_is_known_nowhere_is_nowhere() -> None:
    assert grid(np.array([1.0, 1.5, 2.0, 3.0])).tolist() == [1.0, 1.5, 2.0, 2.5, 3.0]
    assert grid(np.array([1.0, 1.5, 2.0, 2.9])).tolist() == [1.0, 1.5, 2.0, 2.5]
    t = np.array([0.0, 1.0, 2.0])
    assert on_grid(np.array([0.5, 1.5]), t, np.array([0.0, NAN, 4.0])).tolist() == [1.0, 3.0]
    assert np.isnan(on_grid(np.array([0.5]), t, np.full(3, NAN))).all()


def pulse(at: float, gain: float = 1.0) -> Any:
    t = 0.05 * np.arange(401)
    return gain * np.exp(-(((t - at) / 0.4) ** 2))


@pytest.mark.parametrize(
    ("late", "lag"), [(0.3, 0.3), (-0.5, -0.5), (1.9, 1.9), (2.5, None), (-2.5, None)]
)  # beyond the search none is found
def test_a_lag_within_two_seconds_is_found(late: float, lag: float | None) -> None:
    found = alike(pulse(10.0 + late, 2.0), pulse(10.0), 0.05)
    assert (found.lag is None) == (found.gain is None) == (lag is None)
    if lag is not None:
        assert found.lag == pytest.approx(lag, abs=2e-3)
        assert found.gain == pytest.approx(2.0, rel=0.01)
    assert alike(np.ones(50), pulse(10.0)[:50], 0.05).mncc is None


def test_several_signals_have_one_lag_by_what_changes_within_five_seconds() -> None:
    t = 0.05 * np.arange(401)
    still = np.ones(401)
    pairs = [(pulse(10.4), pulse(10.0)), (still, still), (pulse(5.4) + 0.1 * t, pulse(5.0) - 0.3 * t)]
    assert common_lag(pairs, 0.05) == pytest.approx(0.4, abs=0.01)
    assert common_lag([(still, still)], 0.05) == 0.0
    assert common_lag([], 0.05) == 0.0


@pytest.mark.parametrize("late", [-4, -1, 0, 3, 4])
def test_a_phase_is_found_up_to_a_fifth_of_the_length(late: int) -> None:
    """Of 20 samples; a pulse in the middle of them, and the same later."""
    reference, curve = np.zeros(20), np.zeros(20)
    reference[9:12] = 1.0, 2.0, 1.5
    curve[9 + late : 12 + late] = 1.0, 2.0, 1.5
    assert _shift(reference, curve) == late
    assert _shift(reference, 3.0 * curve + 7.0) == late


# --- logs as models


def a_log(**columns: Any) -> Log:
    first = next(iter(columns.values()))
    return Log({"t": 0.1 * np.arange(float(len(first))), **{n: np.array(v, dtype=float) for n, v in columns.items()}})


def test_a_span_of_time_in_words() -> None:
    assert _span(Log({"t": np.array([0.26, 1.0, 7.04])})) == "0.3 to 7.0 s"
    assert _span(Log({"t": np.zeros(0)})) == "empty"


def test_a_command_holds_until_the_next_and_the_first_one_from_the_beginning() -> None:
    log = a_log(steer_cmd=[NAN, NAN, 0.1, NAN, 0.3])
    assert command_at_stamps(log, "steer_cmd", "M").tolist() == [0.1, 0.1, 0.1, 0.1, 0.3]
    with pytest.raises(
        CompareError, match="M: is driven by 'accel_cmd', which the log does not have; nearest of its 1 "
    ):
        command_at_stamps(log, "accel_cmd", "M")
    with pytest.raises(CompareError, match="of which the other log has the column but no value"):
        command_at_stamps(a_log(steer_cmd=[NAN, NAN]), "steer_cmd", "M", "the other log")


@pytest.mark.parametrize(
    ("inputs", "rows"),
    [(("steer_cmd",), [[0, 2]]), (("accel_cmd",), []), (("steer_cmd", "brake_cmd"), [[0, 2]]), ((), [[0, 2], [1]])],
)
def test_rows_count_in_which_the_commands_of_a_model_were_logged(inputs: Any, rows: list[list[int]]) -> None:
    """Of a model that says nothing of its inputs all commands count."""
    log = a_log(steer_cmd=[0.1, NAN, 0.3], accel_cmd=[1.0, 1.0, 1.0], wheel_cmd=[NAN, 1.0, NAN], v=[NAN, 1.0, 1.0])
    found = rows_with_commands(log, SimpleNamespace(inputs=inputs))
    assert [np.flatnonzero(mask).tolist() for mask in found] == rows


def test_a_channel_of_a_second_log_needs_two_values() -> None:
    log = a_log(v=[1.0, NAN, 3.0], ax=[NAN, 2.0, NAN])
    found = LogSubject(log).at(np.array([-0.1, 0.0, 0.1, 0.2, 0.3]))
    assert found[:, CHANNELS.index("v")] == pytest.approx([NAN, 1.0, 2.0, 3.0, NAN], nan_ok=True)
    assert np.isnan(found[:, CHANNELS.index("ax")]).all()


def test_a_value_beside_a_hole_is_there_and_the_hole_is_not() -> None:
    """The step is 0.1 s: from half a second on it is a hole."""
    log = Log({"t": np.array([0.0, 2.0, 2.1, 2.2, 2.3, 2.4, 5.0]), "v": np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0])})
    found = LogSubject(log).at(np.array([-1e-8, 0.0, 5e-10, 1e-8, 1.0, 2.0 - 1e-8, 2.0, 2.05, 2.4, 2.5, 5.0, 5.1]))
    expected = [NAN, 1.0, 1.0, NAN, NAN, NAN, 2.0, 2.5, 6.0, NAN, 7.0, NAN]
    assert found[:, CHANNELS.index("v")] == pytest.approx(expected, nan_ok=True)


def test_a_message_names_the_three_nearest_columns() -> None:
    log = a_log(steer_cmd1=[0.0], steer_cmd2=[0.0], steer_cmd3=[0.0], steer_cmd4=[0.0])
    with pytest.raises(CompareError, match=r"nearest of its 4 columns: steer_cmd\d, steer_cmd\d, steer_cmd\d;"):
        command_at_stamps(log, "steer_cmd", "M")


# --- values that nobody meets


def key(name: str = "k", low: float = 0.0, high: float = 1.0, neutral: float = 0.0) -> Key:
    return Key(name, "-", low, high, neutral, 0.1)


def a_set(chi2: float, *names: str, **values: float) -> Any:
    coordinates = [SimpleNamespace(effect=n, name=(n, "k"), key=key()) for n in names]
    fit = SimpleNamespace(coordinates=coordinates)
    return SimpleNamespace(names=names, values={(n, "k"): v for n, v in values.items()}, fit=fit, chi2=chi2)


@pytest.mark.parametrize(("value", "usual"), [(0.5, True), (1.0, True), (1.01, False), (-0.5, True)])
def test_a_value_is_usual_up_to_the_end_of_its_range(value: float, usual: bool) -> None:
    assert has_usual_values(a_set(1.0, "a", a=value), "a") is usual
    assert has_usual_values(a_set(1.0, "a", "b", a=value, b=9.0), "a") is usual
    assert has_usual_values(a_set(1.0, "a"), "a")  # not fitted: neutral


@pytest.mark.parametrize(
    ("left", "other", "taken"),
    [
        (119.9, {"c": 0.5}, True),  # of 100 that are lost without it less than a fifth stays lost
        (120.0, {"c": 0.5}, False),
        (119.9, {"c": 1.5}, False),  # what takes its place has to be usual, too
        (90.0, {"c": 0.5, "d": 0.5}, True),
        (90.0, {"c": 0.5, "d": 1.5}, False),
        (119.9, {}, True),
    ],
)
def test_another_one_with_usual_values_takes_its_place(left: float, other: dict[str, float], taken: bool) -> None:
    best = a_set(100.0, "b", "a", b=0.5, a=2.0)
    less = a_set(200.0, "b", b=0.5)
    new = a_set(left, "b", *other, b=0.5, **other)
    asked: list[Any] = []

    def filled_set(given: Any, name: str) -> Any:
        asked.append((given, name))
        return new

    found: Any = usual_set(best, lambda name: less, filled_set, lambda trial: ("again", trial))  # type: ignore[arg-type, return-value]
    assert asked == [(less, "a")]
    assert found == (("again", new) if taken else best)


def test_a_set_of_usual_values_stays() -> None:
    best = a_set(100.0, "b", "a", b=0.5, a=1.0)
    assert usual_set(best, None, None, None) is best  # type: ignore[arg-type]


# --- another car's model


def turning(wheelbase: float, *, rows: int = 200, late: int = 0, v: float = 5.0, steer: float = 0.05) -> Any:
    """A slalom of steps of 0.1 s in which the car answers some steps late."""
    t = 0.1 * np.arange(rows)
    angle = steer * np.where(np.arange(rows) // 10 % 2 == 0, 1.0, -1.0) * (1.0 + 0.5 * np.sin(t))
    answered = np.interp(t - 0.1 * late, t, angle)
    speed = np.full(rows, v)
    return SimpleNamespace(t=t, v=speed, steer=angle, yaw_rate=speed * np.tan(answered) / wheelbase,
                           moving=np.ones(rows, dtype=bool))  # fmt: skip


@pytest.mark.parametrize("wheelbase", [0.5, 2.5])
@pytest.mark.parametrize("late", [0, 2])
def test_a_wheelbase_follows_from_steering_and_curvature(wheelbase: float, late: int) -> None:
    alike_, implied = _implied([turning(wheelbase, v=5.0 if wheelbase > 1.0 else 1.5, late=late)], 0.1 * late)
    assert alike_ == pytest.approx(1.0, abs=2e-2)
    assert implied == pytest.approx(wheelbase, rel=2e-2)
    less, _ = _implied([turning(wheelbase, v=5.0 if wheelbase > 1.0 else 1.5, late=late)], 0.1 * late + 0.3)
    assert less < alike_ - 0.1


@pytest.mark.parametrize(
    "change",
    [{"rows": 99}, {"v": 1.0}, {"v": 0.5}, {"steer": 0.006}, {"v": 20.0}, {"wheelbase": -2.5}],
    ids=["few rows", "at a crawl", "slower", "straight", "hard turns", "the other way"],
)
def test_turns_that_are_few_slow_slight_or_hard_tell_nothing(change: dict[str, Any]) -> None:
    assert _implied([turning(**{"wheelbase": 2.5, **change})], 0.0) == (0.0, 0.0)


def test_turns_of_several_logs_count_together_and_those_at_rest_not() -> None:
    half = [turning(2.5, rows=60), turning(2.5, rows=60)]
    assert _implied(half, 0.0)[1] == pytest.approx(2.5)
    assert _implied(half[:1], 0.0) == (0.0, 0.0)
    assert _implied(half, 0.0)[0] == pytest.approx(1.0)
    half[1].moving[:] = False
    assert _implied(half, 0.0) == (0.0, 0.0)
    assert _implied([], 0.0) == (0.0, 0.0)


# --- shares, chance and words


def a_step(level: float, segments: list[float]) -> Step:
    return Step("a", level, {}, {}, segments=tuple(segments))


@pytest.mark.parametrize(
    ("level", "after", "told"),
    [(1.06, [50.0] * 4, True), (1.05, [50.0] * 4, False), (3.0, [50.0] * 3, False), (3.0, [], False)],
)
def test_shares_need_an_excess_of_a_twentieth_and_the_same_segments(
    level: float, after: list[float], told: bool
) -> None:
    assert bool(shares([a_step(level, [100.0] * 4), a_step(1.0, after)])) is told
    assert shares([a_step(3.0, []), a_step(1.0, [])]) == {}


def test_the_part_within_a_basis_is_what_its_directions_say() -> None:
    basis = np.array([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]])
    assert _within(basis, np.array([2.0, 1.0, 3.0])) == pytest.approx([2.0, 0.6 * 3.0, 0.8 * 3.0])
    assert _within(np.zeros((0, 3)), np.ones(3)).tolist() == [0.0, 0.0, 0.0]


def found(**more: Any) -> Diagnosis:
    effect = NamedEffect("mass", {"ratio": Estimate(1.1, 1.0, 1.2, "-")}, rivals=("drive_gain",))
    runs: Any = ({("steer_offset", "b"): 0.0123, ("mass", "ratio"): 1.5}, {})
    step = Step("", 4.0, {"v": 4.0}, {"v": 0.1}, held_out_setups=runs)
    made = Diagnosis("NAMED", (effect,), (), (step,), {"v": 0.05}, {})
    return dataclasses.replace(made, **more)


def test_what_is_of_the_run_is_told_for_each_run_held_out(monkeypatch: pytest.MonkeyPatch) -> None:
    assert setup_lines(found(effects=())) == []
    monkeypatch.setattr(Diagnosis, "set_up", ("steer_offset", "mass"))
    first, one, other = setup_lines(found())
    assert first.startswith(
        "steer_offset and mass: of the run, not of the car (other values held out); calibrate before"
    )
    assert one == "held out: steer_offset.b = 0.0123, mass.ratio = 1.50"
    assert other == "held out: none of them"


@pytest.mark.parametrize(
    ("votes", "effects", "said"),
    [
        ({}, True, ""),
        ({"first": None, "ranking": []}, True, ""),
        ({"first": "mass", "ranking": [("mass", 0.9)]}, True, ""),
        ({"first": "drive_gain", "ranking": [("drive_gain", 0.9)]}, True, ""),
        ({"first": "aero_drag", "ranking": [("aero_drag", 0.876), ("mass", 0.1)]}, True,
         "aero_drag before mass (88 %)"),
        ({"first": "aero_drag", "ranking": [("aero_drag", 0.876)]}, False, "aero_drag (88 %)"),
    ],
)  # fmt: skip
def test_a_second_opinion_is_told_where_it_is_another(votes: dict[str, Any], effects: bool, said: str) -> None:
    asked = found(votes=votes) if effects else found(votes=votes, effects=())
    start = "second opinion: on the whole error, with no effect added yet, regression without simulation votes for "
    assert _second_opinion(asked) == ([start + said] if said else [])


@pytest.mark.parametrize(
    ("names", "said"), [(("detection_offset",), ""), (("detection_offset", "mass"), " before mass")]
)
def test_a_second_opinion_on_the_motion_is_not_set_before_what_detections_show(
    names: tuple[str, ...], said: str
) -> None:
    effects = tuple(NamedEffect(name, {"k": Estimate(1.1, 1.0, 1.2, "-")}) for name in names)
    votes: dict[str, Any] = {"first": "aero_drag", "ranking": [("aero_drag", 0.876)]}
    (line,) = _second_opinion(found(votes=votes, effects=effects))
    assert line.endswith(f"votes for aero_drag{said} (88 %)")


def test_lines_that_are_indented_go_on_with_the_line_before() -> None:
    assert _whole(["a", "    b", "c", " d", "  e"]) == ["a b", "c d e"]
    assert _whole(["  a", "b"]) == ["  a", "b"]
    assert _whole([]) == []
