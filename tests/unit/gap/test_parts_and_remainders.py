"""Which parts of a log are looked at, what a twin leaves by regime, and all of an actuator: each rule by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.diagnose import known_remainder, part_selection, whole_actuators
from pytest_dvp.gap.diagnose.diagnosis import Estimate, NamedEffect
from pytest_dvp.gap.diagnose.known_remainder import Left, expected, measured_remainder
from pytest_dvp.gap.diagnose.part_selection import Part, _Book, _energies, _filled, _spread, _sums, exciting_parts
from pytest_dvp.gap.extend import perception
from pytest_dvp.gap.perception.perceived_values import Perceived
from pytest_dvp.logs.log import Log
from tests.unit.gap.linear_world import tried
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

NAN = math.nan

# --- parts of long logs


def test_energies_of_a_cell_are_squares_about_its_mean() -> None:
    y, cut = np.array([1.0, 3.0, 5.0, 5.0, 8.0]), np.array([0, 2, 4, 5])
    assert _sums(y, cut) == pytest.approx([4.0, 10.0, 8.0])
    assert _spread(y, cut) == pytest.approx([2.0, 0.0, 0.0])
    assert _spread(y + 1e3, cut) == pytest.approx([2.0, 0.0, 0.0], abs=1e-6)
    assert _spread(y, np.array([0, 0, 2, 5])) == pytest.approx([0.0, 2.0, 6.0])


def test_a_column_is_filled_by_straight_lines_and_one_that_is_not_there_is_nought() -> None:
    log = Log({"t": np.arange(4.0), "v": np.array([NAN, 1.0, NAN, 3.0]), "a": np.full(4, NAN)})
    assert _filled(log, "v").tolist() == [1.0, 1.0, 2.0, 3.0]
    assert _filled(log, "a").tolist() == _filled(log, "b").tolist() == [0.0] * 4


def test_a_stretch_has_the_energy_of_commands_their_changes_the_speed_and_the_yaw_rate() -> None:
    """Rows 0.1 s apart: a command changes over two of them; 1, 1, 3, 3 changes by 2 twice."""
    t = 0.1 * np.arange(4.0)
    log = Log({"t": t, "c": np.array([1.0, 1.0, 3.0, 3.0]), "v": np.array([2.0, 4.0, 2.0, 4.0]),
               "yaw_rate": np.array([0.0, 0.0, 0.0, 4.0])})  # fmt: skip
    (row,) = _energies(log, ["c"], np.array([0, 4]))
    assert row == pytest.approx([4.0, 8.0, 4.0, 40.0, 12.0])


def flat(seconds: float, begin: float = 0.0, step: float = 0.5, **columns: Any) -> Log:
    t = begin + np.arange(0.0, seconds, step)
    return Log({"t": t, **{name: np.asarray(values(t)) for name, values in columns.items()}})


@pytest.mark.parametrize(("begin", "seconds", "edges"), [
    (0.0, 20.0, [0, 5, 10, 15, 20]), (3.0, 10.0, [0, 5, 10, 15]), (-1.0, 3.0, [-5, 0, 5]), (5.0, 5.5, [5, 10, 15]),
])  # fmt: skip
def test_cells_of_five_seconds_begin_at_multiples_of_five(begin: float, seconds: float, edges: list[float]) -> None:
    book = _Book(flat(seconds, begin), [], 10)
    assert book.edges.tolist() == edges
    assert int(book.rows.sum()) == round(2 * seconds)


@pytest.mark.parametrize(("rows", "cells"), [(9, 1), (10, 1), (19, 1), (20, 2), (30, 3), (99, 4)])
def test_a_stretch_has_as_many_cells_as_its_rows_make(rows: int, cells: int) -> None:
    """Ten rows in each of four cells."""
    assert _Book(flat(20.0), [], rows).cells == cells


def test_what_is_free_and_short_enough_can_be_taken() -> None:
    book = _Book(flat(20.0, v=lambda t: t // 5.0), [], 20)
    assert [(k, energy.tolist()) for _, k, energy in book.options("a", 20)] == [
        (0, [0.0, 10.0, 0.0]), (1, [0.0, 50.0, 0.0]), (2, [0.0, 130.0, 0.0]),
    ]  # fmt: skip
    assert book.options("a", 19) == []
    part = book.take("a", 1)
    assert (part.name, part.start, part.stop, part.whole) == ("a", 5.0, 15.0, False)
    assert part.called("f.csv") == "f.csv@5:15"
    assert part.log.t[0] == 5.0
    assert part.log.t[-1] <= 15.0
    assert len(part.log.t) >= 20
    assert book.options("a", 20) == []  # the two cells that are left are not beside each other
    whole = _Book(flat(20.0), [], 40).take("a", 0)
    assert (whole.whole, whole.called("f.csv")) == (True, "f.csv")


def test_two_rows_are_no_stretch() -> None:
    assert _Book(flat(1.0), [], 40).options("a", 40) == []
    assert len(_Book(flat(1.5), [], 40).options("a", 40)) == 1


def test_logs_that_are_short_enough_are_whole_and_of_longer_ones_a_third_is_a_part(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """In the order of the logs, then of time; 60 rows, so parts of 20: those that move."""
    a = flat(40.0, v=lambda t: np.where((t >= 30.0) | (t < 10.0), 3.0, 0.0))
    b = flat(40.0, v=lambda t: np.where((t >= 10.0) & (t < 20.0), 2.0, 0.0))
    logs = {"b": b, "a": a}
    assert [part.whole for part in exciting_parts(logs, [], most=160)] == [True, True]
    found = exciting_parts(logs, [], most=60)
    assert [(part.name, part.start, part.stop) for part in found] == [
        ("b", 10.0, 20.0), ("a", 0.0, 10.0), ("a", 30.0, 40.0),
    ]  # fmt: skip
    monkeypatch.setattr(part_selection, "LONGEST", 159)
    assert not exciting_parts(logs, [])[0].whole
    assert isinstance(found[0], Part)


# --- what a twin is known to leave

V, X = CHANNELS.index("v"), CHANNELS.index("x")


@pytest.fixture
def halves(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first half of a log is cruise, the second braking, the last quarter a turn as well."""

    def masks(log: Any, measured: Any) -> dict[str, Any]:
        rows = np.arange(len(log.t)) / len(log.t)
        return {"cruise": rows < 0.5, "braking": rows >= 0.5, "turn_in": rows >= 0.75}

    monkeypatch.setattr(known_remainder, "regimes_of", masks)


def test_each_sample_is_expected_to_be_off_by_the_largest_of_its_regimes(halves: None) -> None:
    """0 for half of the time, 0.2 for a quarter, 0.4 for the other."""
    log = flat(100.0)
    found = expected({"v": {"braking": 0.2, "turn_in": 0.4}}, log, np.zeros((200, 8)))
    assert found[V] == pytest.approx(math.sqrt((0.04 + 0.16) / 4.0))
    assert not np.delete(found, V).any()
    less = expected({"v": {"braking": 0.4, "turn_in": 0.2}}, log, np.zeros((200, 8)))
    assert less[V] == pytest.approx(math.sqrt(0.16 / 2.0))
    assert not expected({}, log, np.zeros((200, 8))).any()


def left(size: float, *, rows: int = 400, channel: int = V, noise: float = 1.0, cruise: float = 0.0) -> Left:
    rest = np.full((rows, 8), NAN)
    rest[:, channel] = np.r_[np.full(rows // 2, cruise), np.full(rows - rows // 2, size)]
    return Left(flat(0.5 * rows), np.zeros((rows, 8)), rest, np.full(8, noise), [CHANNELS[channel]])


@pytest.mark.parametrize(
    ("square", "told"),
    [(1.09, {}), (1.11, {"v": {"braking": 0.332, "turn_in": 0.332}}), (5.0, {"v": {"braking": 2.0, "turn_in": 2.0}})],
)
def test_a_remainder_is_what_is_left_beyond_the_noise_in_three_digits(
    square: float, told: dict[str, Any], halves: None
) -> None:
    """A tenth of the noise's square is none; sqrt(0.11) is 0.33166."""
    assert measured_remainder([[left(math.sqrt(square))]]) == told


@pytest.mark.parametrize(("noise", "told"), [(0.5, 2.96), (1.0, 2.83), (2.0, 2.24), (2.5, 1.66)])
def test_the_square_of_the_noise_is_taken_off(noise: float, told: float, halves: None) -> None:
    """sqrt(9 - 0.25), sqrt(9 - 1), sqrt(9 - 4) and sqrt(9 - 6.25)."""
    assert measured_remainder([[left(3.0, noise=noise)]])["v"]["braking"] == told


@pytest.mark.parametrize(("rows", "told"), [(398, ["braking"]), (400, ["braking", "turn_in"])])
def test_a_regime_needs_a_hundred_samples(rows: int, told: list[str], halves: None) -> None:
    """The last quarter of 398 rows are 99."""
    assert list(measured_remainder([[left(3.0, rows=rows)]]).get("v", {})) == told


def test_groups_count_by_their_largest_and_logs_of_one_together(halves: None) -> None:
    """In one group 200 samples of 9 and 200 of 1 are 5 on average; less the noise of 1 they are 2 squared."""
    together = measured_remainder([[left(3.0), left(1.0)]])["v"]["braking"]
    assert together == pytest.approx(2.0)
    apart = measured_remainder([[left(3.0)], [left(1.0)], [left(2.0)]])["v"]["braking"]
    assert apart == pytest.approx(2.83)  # sqrt(9 - 1)
    assert measured_remainder([[left(2.0)], [left(3.0)]])["v"]["braking"] == pytest.approx(2.83)


def test_both_axes_of_the_map_are_one_and_regimes_come_in_their_order(halves: None) -> None:
    found = measured_remainder([[left(3.0, channel=X, cruise=2.0)]])
    assert found["x"] == found["y"] == {"cruise": 1.73, "braking": 2.83, "turn_in": 2.83}
    assert list(found) == ["x", "y"]


# --- all of an actuator

DELAY, LAG, RATE, LATE = ("steer_delay", "T"), ("steer_lag", "tau"), ("steer_rate_limit", "limit"), "yaw_rate_latency"


class Fitter:
    """Fits by looking up what a set costs by its names; all effects mean something but the vague ones."""

    def __init__(self, costs: dict[str, float], *, idle: Any = (), vague: Any = (), more: Any = ()) -> None:
        names = ("steer_delay", "steer_lag", "steer_rate_limit", *more)
        self.costs, self.idle, self.vague = costs, set(idle), set(vague)
        self.tried = {c.name: c for c in tried(*names)}
        self.begun: list[dict[Any, float]] = []
        self.target: Any = SimpleNamespace(whitened=self._whitened)

    def _whitened(self, values: Any) -> Any:
        """Best where the delay is half of 0.2 s and the others are at their second points."""
        self.begun.append(dict(values))
        lag, rate = (self.tried[name].points[1][key] for name, key in (("steer_lag", LAG), ("steer_rate_limit", RATE)))
        return np.array([values.get(DELAY, 0.0) - 0.1, values.get(LAG, 9.0) - lag, values.get(RATE, 9.0) - rate])

    def trial(self, names: Any, start: Any, *, like: Any = None) -> Any:
        return SimpleNamespace(names=tuple(names), values=dict(start), chi2=self.costs.get(" ".join(names), 50.0))

    def cost(self, trial: Any) -> float:
        return float(trial.chi2)

    def is_worth_adding(self, without: Any, with_it: Any) -> bool:
        return not (set(with_it.names) - set(without.names)) & self.idle

    def is_credible(self, trial: Any, name: str) -> bool:
        return name not in self.vague


def whole(search: Any, *names: str) -> list[tuple[str, ...]]:
    values = {DELAY: 0.2, LAG: 0.2, RATE: 0.5, (LATE, "T"): 0.1}
    now = search.trial(names, {key: value for key, value in values.items() if key[0] in names})
    return [trial.names for trial in whole_actuators.whole_actuators(search, now)]


ALL = ("steer_delay", "steer_lag", "steer_rate_limit")


@pytest.mark.parametrize(
    ("names", "idle", "vague", "found"),
    [
        (("steer_delay",), (), (), [ALL]),
        (("steer_delay",), ("steer_lag",), (), [("steer_delay", "steer_rate_limit")]),
        (("steer_delay",), ("steer_lag", "steer_rate_limit"), (), []),  # nothing new pays
        (("steer_delay",), ("steer_delay",), (), [("steer_lag", "steer_rate_limit")]),
        (("steer_delay",), (), ("steer_lag",), []),  # what is new must mean something
        (("steer_delay",), ("steer_lag",), ("steer_lag",), [("steer_delay", "steer_rate_limit")]),
        ((), (), (), []),
        (ALL, (), (), []),
    ],
)
def test_what_does_not_pay_beside_the_rest_goes_and_what_is_new_means_something(
    names: Any, idle: Any, vague: Any, found: Any
) -> None:
    assert whole(Fitter({}, idle=idle, vague=vague), *names) == found


def test_a_fit_begins_at_all_points_beside_a_share_of_the_time_that_is_named() -> None:
    search = Fitter({})
    (found,) = whole(search, "steer_delay")
    assert found == ALL
    points = len(search.tried["steer_lag"].points) * len(search.tried["steer_rate_limit"].points)
    assert len(search.begun) == 3 * points
    assert {start[DELAY] for start in search.begun} == {0.2, 0.1, 0.05}
    pairs = {(start[LAG], start[RATE]) for start in search.begun}
    assert len(pairs) == points
    unnamed = Fitter({})
    whole(unnamed, "steer_rate_limit")  # a rate is no time
    assert {start[RATE] for start in unnamed.begun} == {0.5}


def test_what_is_like_a_missing_part_may_give_way_to_it() -> None:
    search = Fitter({"steer_lag steer_rate_limit steer_delay": 10.0}, more=(LATE,))
    assert LATE in find_effect("steer_delay").ties or "steer_delay" in find_effect(LATE).ties
    assert whole(search, "steer_lag", "steer_rate_limit", LATE) == [("steer_lag", "steer_rate_limit", "steer_delay")]
    kept = [(LATE, "T") in start for start in search.begun]
    assert any(kept)
    assert not all(kept)
    assert len(kept) == 2 * kept.count(True)


def test_what_is_not_like_a_missing_part_stays() -> None:
    search = Fitter({"mass steer_lag steer_rate_limit steer_delay": 10.0}, more=("mass",))
    now = search.trial(("mass", "steer_lag", "steer_rate_limit"), {("mass", "ratio"): 1.2, LAG: 0.2, RATE: 0.5})
    (found,) = whole_actuators.whole_actuators(search, now)  # type: ignore[arg-type]
    assert found.names == ("mass", "steer_lag", "steer_rate_limit", "steer_delay")
    assert all(start["mass", "ratio"] == 1.2 for start in search.begun)


# --- effects of perception that are added

MODEL = parse_model("[parameters]\nwheelbase = 2.5\n")
LATENCY = find_effect("detection_latency")


def seen(value: float) -> Perceived:
    return Perceived({("detection_latency", "T"): (value, value, value)}, {}, {})


def added(monkeypatch: pytest.MonkeyPatch, found: Any, told: Any, model: Any = MODEL) -> Any:
    """Judged on as many held-out logs as values are told; None: a log that shows nothing of it."""
    answers = iter(told)
    monkeypatch.setattr(perception, "_seen_in", lambda log, model, twins: next(answers))
    held: Any = {str(k): None for k in range(len(told))}
    return perception._added(LATENCY, found, model, held, {})


FOUND = NamedEffect("detection_latency", {"T": Estimate(0.3, 0.28, 0.32, "s")})


@pytest.mark.parametrize(("told", "good"), [(0.3, True), (0.151, True), (0.149, False), (0.0, False), (9.0, True)])
def test_a_value_must_be_nearer_to_what_held_out_data_tell_than_doing_nothing(
    monkeypatch: pytest.MonkeyPatch, told: float, good: bool
) -> None:
    judged = added(monkeypatch, FOUND, [seen(told)])
    assert (judged.wrong == "") is good
    if not good:
        assert judged.wrong == (
            f"detection_latency loses on held-out data: T is {told:.3g} s there, 0.3 where it was fitted: leave it "
            "out, or fit it on more logs"
        )
    assert judged.note == ""


def test_or_than_what_the_model_has_already(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between 0.2 that it has and 0.3 that was found: 0.25."""
    has = MODEL.with_effect("detection_latency", {"T": 0.2})
    assert added(monkeypatch, FOUND, [seen(0.24)], has).wrong
    assert not added(monkeypatch, FOUND, [seen(0.26)], has).wrong
    assert added(monkeypatch, FOUND, [seen(0.26), seen(0.24)], has).wrong  # every log judges


def test_without_a_log_that_judges_it_is_told_and_without_a_value_nothing_is_added(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for told in ([], [None]):
        judged = added(monkeypatch, FOUND, told)
        assert (judged.wrong, judged.note) == (
            "", "detection_latency is not judged on held-out data: name a log with detections by --held-out",
        )  # fmt: skip
    other = Perceived({("detection_offset", "x"): (1.0, 1.0, 1.0)}, {}, {})
    assert added(monkeypatch, FOUND, [other]).wrong == ""
    gone = NamedEffect("detection_latency", {}, action="remove")
    for found in (None, gone):
        assert added(monkeypatch, found, []).wrong == (
            "detection_latency: the detections of these logs do not show it; leave it out, or drive what would show "
            f"it: {LATENCY.reveals}"
        )


def test_all_that_is_to_be_added_and_removed_is_judged_in_its_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(perception, "diagnose_perceptions", lambda logs, model, twins: (FOUND,))
    model = MODEL.with_effect("detection_yaw", {"b": 0.1})
    found = perception.judge_perception(model, {}, {}, [LATENCY, find_effect("detection_offset")], ["detection_yaw"])
    assert [(one.effect.name, bool(one.wrong)) for one in found] == [
        ("detection_latency", False), ("detection_offset", True), ("detection_yaw", True),
    ]  # fmt: skip
    assert perception.judge_perception(model, {}, {}, [], []) == []


@pytest.mark.parametrize(
    ("scenario", "simulated", "shown", "base", "result"),
    [
        ("", False, 0.3, None, 0.3),  # a real car's log is told as it is
        ("", True, 0.3, None, None),  # a run without one beside it says nothing
        ("a", True, 0.3, 0.1, 0.2),  # what the twin's own run shows is taken out
        ("a", False, 0.3, None, None),
        ("a", False, None, 0.1, None),
    ],
)
def test_a_log_held_out_is_told_beside_the_twin_s_run_of_its_scenario(
    monkeypatch: pytest.MonkeyPatch, scenario: str, simulated: bool, shown: Any, base: Any, result: Any
) -> None:
    log: Any = SimpleNamespace(meta={"scenario": scenario} if scenario else {})
    twin: Any = SimpleNamespace(meta={})
    values = {id(log): shown, id(twin): base}
    monkeypatch.setattr(perception, "simulated_sensors", lambda log: simulated)
    monkeypatch.setattr(
        perception, "perceived_in", lambda log: None if values[id(log)] is None else seen(values[id(log)])
    )
    told = perception._seen_in(log, MODEL, {"a": twin})
    if result is None:
        assert told is None
    else:
        assert told is not None
        assert told.values["detection_latency", "T"][0] == pytest.approx(result)
