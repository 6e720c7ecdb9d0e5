"""Decisions within a search and within the second opinion that no whole search would hold in place."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import filled
from pytest_dvp.gap.diagnose import all_cores, held_out_choice
from pytest_dvp.gap.diagnose import search as module
from pytest_dvp.gap.diagnose.dependence import _by_place, _quantile, _quantities
from pytest_dvp.gap.diagnose.equation_error import _Joint, _summed, _Table
from pytest_dvp.gap.diagnose.experiment import Experiment, ExperimentSet
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.held_out_choice import chosen
from pytest_dvp.gap.diagnose.linear_algebra import orthonormal
from pytest_dvp.gap.diagnose.regressors import Form
from pytest_dvp.gap.diagnose.residual_recurrence import _comes_back, at_speed, over_time
from pytest_dvp.gap.diagnose.residual_spectrum import _peak, _vertex, peaks
from pytest_dvp.gap.diagnose.search import SearchResult
from pytest_dvp.gap.diagnose.tyre_regressors import on_tyres
from pytest_dvp.gap.discover.known_rivals import _climb
from tests.unit.gap.linear_world import SettledSearch, World, a_search, a_trial, direction

# --- the search


@pytest.mark.parametrize(
    ("left", "barred", "pair"), [(1400.0, (), True), (1200.0, (), False), (1400.0, ("mass",), False)]
)
def test_a_masked_pair_is_looked_for_where_something_is_left_and_nothing_is_barred(
    left: float, barred: tuple[str, ...], pair: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = a_trial(900.0, "mass", "drive_gain")
    monkeypatch.setattr(module, "masked_pair", lambda search, now: [both])
    search = a_search(World({}, channels={"v": 1.4}))
    assert search.paying(a_trial(left), barred) == ([both] if pair else [])


def test_each_set_of_a_climb_begins_where_the_one_before_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """And with its derivatives: those of the best set, not of the second best."""
    world = World({})
    search = a_search(world, "mass", "brake_gain")
    start, first, other, second = a_trial(9.0), a_trial(8.0, "mass"), a_trial(8.5, "brake_gain"), a_trial(7.0, "mass")
    rounds = iter([[first, other], [second], []])
    asked: list[Any] = []

    def trial(names: Any, values: Any, like: Any = None) -> Any:
        asked.append((names, like))
        return first if like is first else second if like is second else start

    monkeypatch.setattr(search, "paying", lambda now: next(rounds))
    monkeypatch.setattr(search, "trial", trial)
    assert list(_climb(search)) == [first, second]
    assert asked == [((), None), (("mass",), first), (("mass",), second)]
    asked.clear()
    rounds = iter([[first, other], [second], []])
    monkeypatch.setattr(search, "paying", lambda now, barred, most: next(rounds))
    turns: list[Any] = []
    assert search.grown(start, turns) is second
    assert turns == [other]  # the second best of each round, where there is one
    assert asked == [(("mass",), first), (("mass",), second)]


@pytest.mark.parametrize(("left", "asked"), [(1290.0, False), (1310.0, True)])
def test_two_effects_of_tyres_are_tried_together_only_where_much_is_left(
    left: float, asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = a_search(World({}, channels={"v": 1.4}))
    best = a_trial(left)
    pairs: list[Any] = []
    monkeypatch.setattr(module, "late_pair", lambda search, base: pairs.append(base) or [])
    monkeypatch.setattr(search, "trial", lambda names, values, **more: best)
    monkeypatch.setattr(search, "_contest", lambda grown: (best, {}))
    monkeypatch.setattr(search, "_risen", lambda now, turns: best)
    monkeypatch.setattr(search, "_whole_actuator", lambda now: now)
    monkeypatch.setattr(search, "credible_set", lambda now: now)
    monkeypatch.setattr(search, "grown", lambda now, turns: now)
    assert search.run().final is best
    assert bool(pairs) is asked


class Chain(SettledSearch):
    """A search in which each effect has the next one as a rival, and held-out data like that one better."""

    def __init__(self, length: int) -> None:
        super().__init__()
        self.length = length

    def trial(self, names: Any, values: Any = None, zoom: bool = False) -> Any:
        held = 0.5 ** int(names[0][1:])
        return SimpleNamespace(names=tuple(names), values={"held": 1e6 * held}, chi2=9000.0)

    def in_place_of(self, best: Any, name: str) -> list[Any]:
        return [self.trial((f"e{k}",)) for k in range(self.length) if f"e{k}" != name]


def test_effects_are_exchanged_four_times_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    """What has gone is a rival of what came, and so is its own: only the next one is better, so each turn takes one."""
    monkeypatch.setattr(held_out_choice, "refit_on_fold", lambda search, fold, trial: trial)
    monkeypatch.setattr(held_out_choice, "whole_actuators", lambda search, final: iter(()))
    turns: list[str] = []

    def alike(search: Any, final: Any, rivals: Any) -> Any:
        turns.append(final.names[0])
        return iter([search.trial((f"e{int(final.names[0][1:]) + 1}",))])

    monkeypatch.setattr(held_out_choice, "_alike", alike)
    judge: Any = SimpleNamespace(count=1000, whitened=lambda values: np.array([np.sqrt(values["held"])]))
    search: Any = Chain(9)
    found = chosen(search, SearchResult(search.trial(("e0",)), {"e0": ()}, ()), (Fold(None, judge),))
    assert turns == ["e0", "e1", "e2", "e3"]
    assert found.final.names == ("e4",)


@pytest.mark.parametrize(("cores", "names"), [(1, {"MainThread"}), (2, {"dvp_0", "dvp_1"})])
def test_two_cores_are_enough_to_work_side_by_side(
    cores: int, names: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", cores)
    all_cores._pool.cache_clear()
    together = threading.Barrier(cores, timeout=30.0)

    def name(item: int) -> str:
        together.wait()
        return threading.current_thread().name

    try:
        assert set(all_cores.mapped(name, range(4))) == names
        assert all_cores.mapped(lambda item: threading.current_thread().name, [1]) == ["MainThread"]
    finally:
        all_cores._pool.cache_clear()


def test_the_latest_motions_are_kept_as_far_as_there_is_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Room for two of 80 bytes: the third takes the place of the one that was not asked for longest."""
    monkeypatch.setattr("pytest_dvp.gap.diagnose.experiment.KEPT", 160)
    runs: list[float] = []

    def run(values: Any, *, starts: Any, states: Any) -> Any:
        runs.append(values["e", "k"])
        return np.zeros(10)

    e = object.__new__(Experiment)
    e.machine, e._one_at_a_time, e._motions = SimpleNamespace(run=run), threading.Lock(), {}  # type: ignore[assignment]
    e.segments = e._moved_on = SimpleNamespace(starts=None, states=None)  # type: ignore[assignment]
    for value in (1.0, 2.0, 1.0, 3.0, 1.0, 3.0, 2.0):
        e.motion({("e", "k"): value})
    assert runs == [1.0, 2.0, 3.0, 2.0]
    e.segments = SimpleNamespace(starts=None, states=None)  # type: ignore[assignment]
    e.motion({("e", "k"): 2.0})
    assert runs == [1.0, 2.0, 3.0, 2.0, 2.0]  # from other beginnings they are others


def test_rows_that_do_the_same_and_rows_of_nothing_span_nothing_more() -> None:
    basis = orthonormal(np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [6.0, 8.0, 0.0], [3e-9, 4e-9, 1e-8]]))
    assert basis == pytest.approx(np.array([[0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]), abs=1e-12)
    assert orthonormal(np.zeros((2, 3))).shape == (0, 3)
    nearly = np.array([[1.0, 0.0], [1.0, 0.9e-6]])  # a millionth of its length stands beside
    assert len(orthonormal(nearly)) == 1
    assert len(orthonormal(nearly + np.array([[0.0, 0.0], [0.0, 0.3e-6]]))) == 2


# --- the second opinion


def signals(n: int = 100) -> Any:
    t = 0.5 * np.arange(n)
    measured = {"dv": np.sin(t)}
    return SimpleNamespace(
        t=t, rows=np.arange(n), measured=measured, noise={"dv": 0.1}, accel=None, steer=None, mean=lambda y: y
    )


def test_what_a_form_moves_is_seen_at_the_first_point_of_its_grid() -> None:
    """The last one does nothing: it would be a rival of nothing."""
    table = _Table(signals())
    first = Form("a", (), lambda s, p: {"dv": np.full(len(s.rows), 2.0 - p), "else": np.ones(len(s.rows))}, (1.0, 2.0))
    plain = Form("b", (), lambda s, p: {"dv": np.full(len(s.rows), p)})
    joint = object.__new__(_Joint)
    joint.tables, joint.rests = [table], [table.rest]
    assert joint._moved(first) == {"dv"}
    assert joint._moved(plain) == set()  # a form without a grid has nought as its point


def test_normal_equations_of_several_logs_add_up() -> None:
    tables = [_Table(signals()), _Table(signals(60))]
    form = Form("a", (), lambda s, p: {"dv": np.full(len(s.rows), p)}, (1.0, 2.0))
    found = _summed(form, tables, 3.0)
    assert found is not None
    assert found[0].sum() == pytest.approx((100 + 60) * (3.0 / 0.1) ** 2)
    assert found[0].shape == (5, 1, 1)
    both = 10.0 * (np.sin(0.5 * np.arange(100)).sum() + np.sin(0.5 * np.arange(60)).sum())
    assert found[1].sum() == pytest.approx(30.0 * both)


@pytest.mark.parametrize("length", [0.0, 1e9])
def test_a_car_goes_on_in_its_circle_when_its_tyres_begin_to_slip(length: float) -> None:
    """Up to 1 m/s it rolls. From then on, forces that build up over a long way are still those of rolling: v r in all,
    shared so that nothing turns it. Where they are there at once the slip angles of 1 m/s are next to nothing."""
    n = 60
    v = np.where(np.arange(n) < 20, 0.9999, 1.0001)
    s: Any = SimpleNamespace(v=v, steer=np.full(n, 0.2), step=0.02, wheelbase=2.5, cg_front=1.7, gyration=1.4)
    rate, side = on_tyres(s, 1e-6, 1e-6, length=length)
    assert rate == pytest.approx(np.full(n, np.tan(0.2) / 2.5), rel=2e-2 if length == 0.0 else 1e-3)
    assert np.abs(side).max() < 2e-3
    assert side[:20].tolist() == [0.0] * 20


# --- where an error comes back


def moving(n: int, **given: Any) -> Any:
    fields = {"t": 10.0 * np.arange(n), "step": 10.0, "moving": np.ones(n, dtype=bool), "v": np.full(n, 7.0)}
    return SimpleNamespace(**(fields | given))


def test_six_visits_after_more_than_twenty_seconds_are_enough() -> None:
    """Visits of four rows of a second to two cells by turns, each 8 s after the last one of its own: the next but two
    is far enough away."""
    for visits, told in ((6, True), (5, False)):
        n = 4 * visits
        cell = np.repeat(np.arange(visits) % 2, 4)
        m = moving(n, t=20.0 * np.arange(n), step=20.0)
        error = np.where(cell == 0, 2.0, -1.0)
        found = _comes_back([error], [m], cell)
        assert (found is not None) is told


@pytest.mark.parametrize(("apart", "share"), [(20.0, None), (20.5, 1.0), (-20.0, None), (-20.5, 1.0)])
def test_a_visit_within_twenty_seconds_is_the_same_one(apart: float, share: float | None) -> None:
    """Six cells of four rows, and all of them once more; an error that is the same everywhere comes back in whole."""
    cell = np.repeat([0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5], 4)
    first = np.concatenate([0.5 * k + 0.0625 * np.arange(4) for k in range(6)])
    m = moving(48, t=np.concatenate([first, first + apart]), step=0.0625)
    assert _comes_back([np.full(48, 3.0)], [m], cell) == share
    other = _comes_back([np.append(np.full(24, 3.0), np.full(24, -3.0))], [m], cell)
    assert (other is None) is (share is None)
    assert other is None or other < -2.5  # the other visit says the opposite: 1 - 4, but for where it is smoothed


def test_a_car_that_stands_has_no_speed_at_which_its_error_is_large() -> None:
    m = moving(10, moving=np.zeros(10, dtype=bool))
    found = at_speed([np.ones(10)], [m])
    assert (found["share_of_error"], found["share_of_time"]) == (0.0, 0.0)
    half = moving(10, moving=np.arange(10) < 5, v=np.where(np.arange(10) < 4, 7.0, 12.0))
    share = at_speed([np.where(np.arange(10) < 4, 1.0, 2.0)], [half])
    assert share["share_of_error"] == pytest.approx(4.0 / 8.0)  # one row of five has half of the squares
    assert share["share_of_time"] == pytest.approx(1.0 / 5.0)


def test_a_trend_needs_four_segments_and_some_error() -> None:
    none = {"rank_correlation": 0.0, "share_in_second_half": 0.5}
    assert over_time([np.array([1.0, 2.0, 3.0])]) == none
    assert over_time([np.zeros(9)]) == none
    assert over_time([np.array([1.0, 2.0, 3.0, 4.0])]) == {"rank_correlation": pytest.approx(1.0),
                                                          "share_in_second_half": pytest.approx(0.7)}  # fmt: skip
    odd = over_time([np.array([9.0, 4.0, 3.0, 2.0, 0.0]), np.array([7.0])])
    assert odd == {"rank_correlation": pytest.approx(-1.0), "share_in_second_half": pytest.approx(5.0 / 18.0)}


def test_a_wave_is_found_between_the_frequencies_of_its_neighbours() -> None:
    frequency = 0.5 * np.arange(4)
    for left, middle, right, at in ((1.0, 3.0, 1.0, 0.5), (2.0, 3.0, 1.0, 0.5 - 0.5 / 6.0), (1.0, 3.0, 2.0, 3.5 / 6.0)):
        assert _vertex(frequency, np.array([left, middle, right, 0.0]), 1) == pytest.approx(at)
    assert _vertex(frequency, np.ones(4), 1) == 0.5  # flat
    assert _vertex(frequency, np.array([3.0, 1.0, 0.0, 0.0]), 0) == 0.0
    assert _vertex(frequency, np.array([0.0, 0.0, 1.0, 3.0]), 3) == 1.5
    assert _vertex(frequency, np.array([0.0, 1.0, 3.0, 1.0]), 2) == 1.0


@pytest.mark.parametrize(("rows", "told"), [(63, False), (64, True)])
def test_a_wave_needs_64_samples(rows: int, told: bool) -> None:
    wave = np.sin(2.0 * np.pi * np.arange(rows) / 8.0)
    found = _peak("time", "Hz", [wave], 0.1, 4.0)
    assert (found is not None) is told
    if found is not None:
        assert found.frequency == pytest.approx(1.25, rel=0.02)
        assert found.share == pytest.approx(1.0, abs=0.02)


def test_short_pieces_do_not_count_and_of_no_error_there_is_no_wave() -> None:
    wave = np.sin(2.0 * np.pi * np.arange(160) / 8.0)
    rough = 9.0 * np.where(np.arange(15) % 2 == 0, 1.0, -1.0)
    with_short = _peak("time", "Hz", [wave, rough], 0.1, 4.0)
    assert with_short == _peak("time", "Hz", [wave], 0.1, 4.0)
    long = _peak("time", "Hz", [wave, np.append(rough, -9.0)], 0.1, 4.0)
    assert long is not None
    assert long.share < 0.1
    assert _peak("time", "Hz", [np.full(100, 3.0)], 0.1, 4.0) is None


def test_the_sharper_of_two_waves_comes_first() -> None:
    """The car waits for a while, so that what is a wave over the way is none over time."""
    t = 0.05 * np.arange(2000)
    way = np.where(t < 30.0, 4.0 * t, np.where(t < 60.0, 120.0, 120.0 + 9.0 * (t - 60.0)))
    first, second = peaks([np.sin(2.0 * np.pi * 0.2 * way)], [t], [way])
    assert (first.kind, first.unit, second.kind, second.unit) == ("distance", "1/m", "time", "Hz")
    assert first.frequency == pytest.approx(0.2, rel=0.01)
    assert first.share > 0.9 > second.share


@pytest.mark.parametrize(("cycles", "found"), [(2.0, True), (3.9, True), (4.2, False)])
def test_a_wave_over_the_way_is_a_quarter_of_a_metre_or_longer(cycles: float, found: bool) -> None:
    """It is looked for on cells of 5 cm from where the log begins."""
    t = 0.02 * np.arange(4000)
    way = np.where(t < 40.0, 0.5 * t, 20.0 + 0.3 * (t - 40.0))
    error = np.sin(2.0 * np.pi * cycles * way)
    peak = next(one for one in peaks([error], [t], [way]) if one.kind == "distance")
    assert (peak.share > 0.9 and peak.frequency == pytest.approx(cycles, rel=0.01)) is found
    cells = 0.05 * np.arange(640)  # 32 m
    assert peak == _peak("distance", "1/m", [np.interp(cells[cells < way[-1]], way, error)], 0.05, 4.0)


# --- what a value may depend on


def drive(**columns: Any) -> Any:
    n = len(next(iter(columns.values())))
    t = 0.125 * np.arange(n)
    measured = np.zeros((n, 8))
    for name, values in columns.items():
        measured[:, {"x": 0, "y": 1, "v": 3}[name]] = values
    return SimpleNamespace(log=SimpleNamespace(t=t), measured=measured)


def quantities(e: Any) -> Any:
    whole = filled(e.log.t, e.measured)
    return _quantities(e, whole, max(1e-6, *(float(np.ptp(whole[:, k])) for k in (0, 1))) / 8.0)


def test_energies_are_summed_over_smoothed_accelerations() -> None:
    """From 0 to 10 m/s with 2 m/s^2 and back with 1: 50 J/kg each way; what is smoothed is half a second wide."""
    t = 0.125 * np.arange(200)
    v = np.where(t < 5.0, 2.0 * t, np.maximum(15.0 - t, 0.0))
    found = quantities(drive(v=-v, x=4.0 * t, y=0.0 * t))
    assert found["motor_energy"][-1] == pytest.approx(50.0, rel=0.06)
    assert found["brake_energy"][-1] == pytest.approx(50.0, rel=0.06)
    assert found["motor_energy"][39] == pytest.approx(50.0, rel=0.06)
    assert found["brake_energy"][37] == 0.0
    assert found["speed"][20] == pytest.approx(5.0)
    assert found["acceleration"][20] == pytest.approx(2.0)
    assert found["acceleration"][100] == pytest.approx(-1.0)
    assert found["time"].tolist() == pytest.approx((t - t[0]).tolist())
    step = quantities(drive(v=np.where(t < 10.0, 0.0, 5.0), x=t, y=t))["speed"]
    assert step[77:83] == pytest.approx([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])  # five rows, two to either side


def test_a_place_is_one_of_eight_cells_along_the_longer_side() -> None:
    x = np.array([0.5, 9.5, 10.5, 79.9, 0.5, 80.0])
    y = np.array([0.5, 9.5, 0.5, 0.5, 10.5, 0.0])
    place = quantities(drive(v=np.ones(6), x=x - 0.0, y=y))["place"]
    side = (80.0 - 0.5) / 8.0
    assert place.tolist() == [float(int(a / side) + 1000 * int(b / side)) for a, b in zip(x, y, strict=True)]
    turned = quantities(drive(v=np.ones(6), x=y, y=x))["place"]
    assert turned.tolist() == [float(int(b / side) + 1000 * int(a / side)) for a, b in zip(x, y, strict=True)]


def test_a_window_is_told_by_other_visits_of_its_place() -> None:
    """Visits four segments apart are two. Of a shift s a weight w has the slope -w s."""
    cell = np.array([1.0, 1.0, 1.0, 2.0])
    segment = np.array([0, 4, 7, 9])
    weight, shift = np.array([1.0, 3.0, 5.0, 2.0]), np.array([0.5, 0.25, 1.0, 9.0])
    found = _by_place(cell, weight, -weight * shift, segment)
    assert found is not None
    assert found == pytest.approx([(3.0 * 0.25 + 5.0 * 1.0) / 8.0, 0.5, 0.5, 0.0])
    assert _by_place(np.array([1.0, 1.0, 2.0, 3.0]), weight, weight, np.array([0, 4, 5, 6])) is None  # half of them
    assert _by_place(np.array([1.0, 1.0, 2.0]), weight[:3], weight[:3], np.array([0, 3, 9])) is None


def test_a_quantile_counts_by_weight() -> None:
    q, weight = np.array([3.0, 1.0, 2.0]), np.array([1.0, 1.0, 2.0])
    assert [_quantile(q, weight, share) for share in (0.05, 0.25, 0.3, 0.75, 0.76, 0.95)] == [1, 1, 2, 2, 3, 3]


# --- several logs


def test_experiments_are_judged_one_after_the_other() -> None:
    def one(step: float, white: Any, edges: Any) -> Any:
        t = step * np.arange(20)
        rest = SimpleNamespace(values=np.asarray(white))
        return SimpleNamespace(
            log=SimpleNamespace(t=t), residuals=lambda values: rest, white=lambda r: r.ravel(), edges=np.array(edges),
            count=len(white), independent=0.5 * len(white),
            freed=lambda r: 2.0 * r.ravel(), model=SimpleNamespace(remainder={}),
        )  # fmt: skip

    a, b = one(0.02, [1.0, 2.0, 3.0], [0, 2, 3]), one(0.05, [4.0, 5.0], [0, 2])
    both = ExperimentSet((a, b))
    assert both.whitened({}).tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert both.lasting().whitened({}).tolist() == [2.0, 4.0, 6.0, 8.0, 10.0]
    assert both.starts().tolist() == [0, 2, 3]
    assert both.by_segment(both.whitened({})).tolist() == [5.0, 9.0, 41.0]
    assert (both.count, both.independent, both.sample) == (5, 2.5, pytest.approx(0.05))
    assert not both.excused
    b.model.remainder = {"v": 0.1}
    assert both.excused


def test_an_effect_means_something_only_if_it_is_certain_unless_nobody_asks(monkeypatch: pytest.MonkeyPatch) -> None:
    search = a_search(World({}), "drive_gain")
    trial = a_trial(900.0, "drive_gain", values={("drive_gain", "g"): 0.8})
    monkeypatch.setattr(module, "intervals", lambda fit, starts: {("drive_gain", "g"): (0.5, 1.1)})
    assert not search.is_credible(trial, "drive_gain")
    assert search.is_credible(trial, "drive_gain", certain=False)
    monkeypatch.setattr(module, "intervals", lambda fit, starts: {("drive_gain", "g"): (0.75, 0.85)})
    assert search.is_credible(trial, "drive_gain")


def test_whether_an_effect_matters_is_asked_of_the_data_that_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """A gain of 2 % of the drive is small, but clearly to be seen where it is fitted; other data do not show it."""
    gain = ("drive_gain", "g")
    fitted_on, others = (World({gain: size * direction(0)}, {gain: 0.98}) for size in (1000.0, 0.0))
    search = a_search(fitted_on, "drive_gain")
    trial = search.trial(("drive_gain",), {gain: 0.99})
    monkeypatch.setattr(module, "intervals", lambda fit, starts: {gain: (0.975, 0.985)})
    assert search.is_credible(trial, "drive_gain")
    assert not search.is_credible(trial, "drive_gain", others)  # type: ignore[arg-type]


@pytest.mark.parametrize(("leaves", "again"), [(1945.0, False), (1935.0, True)])
def test_far_from_the_noise_a_ranking_is_taken_up_again_for_what_is_worth_an_effect_beside_others(
    leaves: float, again: bool
) -> None:
    """Of 2040 with 1000 samples, 5 % of what is left must be gained, 97: the first effect alone might bring 3 %."""
    search = a_search(World({}), "mass", "drive_gain")
    ranking: Any = [(1900.0 if k < 6 else leaves, f"effect {k}", {}) for k in range(8)]
    found = list(search._batches(a_trial(2040.0, "mass"), ranking))
    assert found == ([ranking, ranking[6:]] if again else [ranking])


def test_points_of_a_grid_at_which_a_form_moves_nothing_are_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    joint: Any = object.__new__(_Joint)
    joint.forms = {"a": Form("a", (), lambda s, p: {}, (1.0, 2.0, 3.0))}
    joint.fold = np.array([0, 1, 2, 3, 4])
    rest = np.array([2.0, 0.0, 0.0, 0.0, 0.0])
    made = {1.0: None, 2.0: np.array([[2.0], [0.0], [0.0], [0.0], [0.0]]), 3.0: np.full((5, 1), 1.0)}
    monkeypatch.setattr(_Joint, "columns", lambda self, name, p: made[p])
    assert joint._gain("a", rest, np.zeros((5, 0)), 4.0) == (4.0, 2.0)
    made[1.0] = np.array([[2.0], [0.0], [0.0], [0.0], [0.5]])  # leaves 0.25, more than the next point
    assert joint._gain("a", rest, np.zeros((5, 0)), 4.0) == (4.0, 2.0)
    made[1.0], made[2.0] = made[2.0], made[1.0]
    assert joint._gain("a", rest, np.zeros((5, 0)), 4.0) == (4.0, 1.0)
    made[1.0] = made[2.0] = None
    assert joint._gain("a", rest, np.zeros((5, 0)), 4.0) == (4.0 - 5.0, 3.0)
    made[3.0] = None
    assert joint._gain("a", rest, np.zeros((5, 0)), 4.0) is None
