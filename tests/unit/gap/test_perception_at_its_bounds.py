"""How a perception is fitted round by round, what of it is named and in which order, and what holds just at a bound."""

from __future__ import annotations

import dataclasses
from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.perception import diagnose_perception as module
from pytest_dvp.gap.perception.box_fit import _of_object
from pytest_dvp.gap.perception.detection_pairs import Frames, Pairs, _known, frames
from pytest_dvp.gap.perception.diagnose_perception import (
    _differs,
    _likelihood,
    _Seen,
    diagnose_perception,
    perceived_in,
    simulated_sensors,
)
from pytest_dvp.gap.perception.false_objects import appearances
from pytest_dvp.gap.perception.fresh_detections import fresh
from pytest_dvp.gap.perception.on_top import _border, _dampened, _share_missed, _variance, on_top
from pytest_dvp.gap.perception.perceived_values import Perceived
from pytest_dvp.gap.perception.position_fit import Positions, _clustered
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

MODEL: Any = parse_model("[model]\nname = 'c'\n[parameters]\nwheelbase = 2.5\n")


# --- round by round


class Rounds:
    """A fit whose steps and noises are given; notes with what each round pairs and fits."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, pairs: int = 50, step: Any = (0.5, 0.1, -0.2), sigma: float = 0.1
    ) -> None:
        self.paired: list[Any] = []
        self.noise: list[list[float]] = []
        self.place: Any = None
        seen = np.arange(60) < pairs

        def paired(f: Any, latency: float, offset: Any, gate: Any) -> Any:
            self.paired.append((latency, offset, gate))
            return SimpleNamespace(seen=seen)

        def positions(f: Any, p: Any, noise: Any) -> Any:
            self.noise.append(noise.tolist())
            return SimpleNamespace(step=np.array(step), noise=np.array([sigma, 0.02]))

        def together(f: Any, p: Any, fitted: Any, place: Any) -> Any:
            self.place = place
            return SimpleNamespace(perceived=lambda: "all of it")

        monkeypatch.setattr(module, "measured_only", lambda table: table)
        monkeypatch.setattr(module, "frames", lambda log: SimpleNamespace(x=np.zeros(50)))
        monkeypatch.setattr(module, "paired", paired)
        monkeypatch.setattr(module, "Positions", positions)
        monkeypatch.setattr(module, "_Seen", together)


@dataclasses.dataclass
class Measured:
    detections: Any = dataclasses.field(default_factory=lambda: SimpleNamespace(t=np.zeros(3)))
    objects: Any = dataclasses.field(default_factory=lambda: {"a": None})
    columns: Any = dataclasses.field(default_factory=lambda: {"x": 0, "y": 0, "yaw": 0, "v": 0})
    meta: Any = dataclasses.field(default_factory=dict)


def test_each_round_pairs_with_what_the_one_before_has_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Five rounds, each 1.5 s later until 5 s; a gate of half a metre and five standard deviations of the noise."""
    rounds = Rounds(monkeypatch, step=(1.5, 0.1, -0.2))
    assert perceived_in(Measured()) == "all of it"  # type: ignore[arg-type]
    latency, offset, gate = zip(*rounds.paired, strict=True)
    assert latency == pytest.approx((0.0, 1.5, 3.0, 4.5, 5.0))
    assert np.array(offset) == pytest.approx(np.outer(np.arange(5), [0.1, -0.2]))
    assert gate[0] == (4.0, 0.05)  # half a second at 8 m/s
    assert np.array(gate[1:]) == pytest.approx(np.tile([0.5 + 5.0 * 0.1, 5.0 * 0.02], (4, 1)))
    assert rounds.noise == [[0.3, 0.0], *[[0.1, 0.02]] * 4]
    assert rounds.place == pytest.approx([5.0, 0.5, -1.0])


def test_a_latency_is_not_below_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rounds = Rounds(monkeypatch, step=(-0.25, 0.0, 0.0))
    perceived_in(Measured())  # type: ignore[arg-type]
    assert [latency for latency, *_ in rounds.paired] == [0.0] * 5


@pytest.mark.parametrize(("pairs", "told"), [(50, True), (49, False)])
def test_fifty_pairs_say_something_of_a_perception(pairs: int, told: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    Rounds(monkeypatch, pairs)
    assert (perceived_in(Measured()) is not None) is told  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "lacking",
    [{"detections": SimpleNamespace(t=np.zeros(0))}, {"objects": {}}, {"columns": {"x": 0, "y": 0}},
     {"columns": {"x": 0, "yaw": 0}}],
)  # fmt: skip
def test_without_boxes_objects_or_a_place_nothing_is_said(
    lacking: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    Rounds(monkeypatch)
    assert perceived_in(Measured(**lacking)) is None  # type: ignore[arg-type]


# --- what is named


def shown(**values: tuple[float, float, float]) -> dict[tuple[str, str], tuple[float, float, float]]:
    keys = {"latency": "T", "range": "R", "misses": "rate", "false": "rate", "yaw": "b", "noise": "sigma0"}
    return {(f"detection_{name}", keys[name]): value for name, value in values.items()}


WORTH = {"detection_latency": 30.0, "detection_misses": 50.0, "detection_false": 10.0, "detection_yaw": 10.0,
         "detection_noise": 99.0, "detection_range": 0.0}  # fmt: skip


def test_what_explains_most_comes_first_and_gains_are_shares_of_what_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Latency, misses and yaw differ from what the model has; false objects do not."""
    values = shown(latency=(0.3, 0.25, 0.35), misses=(0.2, 0.15, 0.25), false=(0.0, 0.0, 0.1), yaw=(0.2, 0.15, 0.25))
    monkeypatch.setattr(module, "perceived_in", lambda log: Perceived(values, WORTH, {}))
    found = diagnose_perception(Measured(), MODEL)  # type: ignore[arg-type]
    assert [e.name for e in found] == ["detection_misses", "detection_latency", "detection_yaw"]
    assert [e.gain for e in found] == pytest.approx([50.0 / 90.0, 30.0 / 90.0, 10.0 / 90.0])
    assert [e.standing for e in found] == ["confirmed"] * 3
    alike = dict(WORTH, detection_latency=50.0)
    monkeypatch.setattr(module, "perceived_in", lambda log: Perceived(values, alike, {}))
    assert next(e.name for e in diagnose_perception(Measured(), MODEL)) == "detection_latency"  # type: ignore[arg-type]


def test_a_run_of_a_stage_says_nothing_without_a_twin(monkeypatch: pytest.MonkeyPatch) -> None:
    values = shown(latency=(0.3, 0.25, 0.35))
    monkeypatch.setattr(module, "perceived_in", lambda log: Perceived(values, WORTH, {}))
    run = Measured(meta={"stage": "vi"})
    assert simulated_sensors(run)  # type: ignore[arg-type]
    assert diagnose_perception(run, MODEL) == ()  # type: ignore[arg-type]
    assert len(diagnose_perception(Measured(meta={"stage": ""}), MODEL)) == 1  # type: ignore[arg-type]


def test_beside_a_twin_noise_and_false_objects_wait_for_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    car = shown(latency=(0.4, 0.35, 0.45), false=(2.0, 1.9, 2.1), noise=(0.8, 0.75, 0.85))
    twin = shown(latency=(0.1, 0.08, 0.12), false=(0.1, 0.05, 0.15), noise=(0.1, 0.08, 0.12))
    log, run = Measured(), Measured(meta={"stage": "vi"})
    found = {id(log): car, id(run): twin}
    monkeypatch.setattr(module, "perceived_in", lambda one: Perceived(found[id(one)], WORTH, {}))
    named = {e.name: e for e in diagnose_perception(log, MODEL, twin=run)}  # type: ignore[arg-type]
    assert set(named) == {"detection_latency", "detection_false", "detection_noise"}
    assert named["detection_latency"].rivals == ()
    assert named["detection_false"].rivals == named["detection_noise"].rivals == ("detection_latency",)
    assert named["detection_latency"].parameters["T"].value == pytest.approx(0.3)  # on top of the twin's own
    del car["detection_latency", "T"]
    named = {e.name: e for e in diagnose_perception(log, MODEL, twin=run)}  # type: ignore[arg-type]
    assert {e.rivals for e in named.values()} == {()}  # there is nothing to wait for


def test_a_border_that_was_not_found_differs_only_by_more_than_the_least_size() -> None:
    """A range is worth a name from its least size on, beyond what was seen in the other log."""
    effect = find_effect("detection_range")
    least = effect.key("R").least

    def differ(car: tuple[float, float, float], twin: tuple[float, float, float]) -> bool:
        return _differs(Perceived(shown(range=car), {}, {}), Perceived(shown(range=twin), {}, {}), MODEL, effect, "R")

    near = (64.0, 60.0, 66.0)
    for at, differs in ((66.0 + least, False), (66.5 + least, True)):
        assert differ((inf, at, inf), near) is differs
    for at, differs in ((60.0 + 6.0 + least, False), (66.5 + least, True)):
        assert differ(near, (inf, at, inf)) is differs
    assert not differ((inf, 90.0, inf), (inf, 10.0, inf))


# --- the parts


def test_objects_left_out_move_a_border_that_lies_between_rows_of_uneven_distance() -> None:
    """Seen at 10, 20, 32 and 40 m, not at 47, 60, 61 and 80 m, by turns of two objects: without the first the border
    lies between 20 and 60 (of 20, 40 | 60, 80), without the second between 32 and 47 (of 10, 32 | 47, 61)."""
    far = np.array([10.0, 20.0, 32.0, 40.0, 47.0, 60.0, 61.0, 80.0])
    one = object.__new__(_Seen)
    one.far, one.seen, one.thing = far, far < 45.0, np.array([0, 1, 0, 1, 0, 1, 0, 1])
    borders = np.array([50.0, 39.5])
    expected = 1.96 * np.sqrt(0.5 * np.sum((borders - borders.mean()) ** 2))
    assert one._between_objects(43.5) == pytest.approx(expected)


def test_a_border_behind_a_single_row_that_was_missed_is_as_likely_as_missing_everything_before_it() -> None:
    """One of one missed: a share of 1, at most 0.9999; behind the border 30 rows that are not seen."""
    found = _likelihood(np.zeros(31, dtype=bool))
    assert found[0] == pytest.approx(31 * np.log(0.995))
    assert found[1] == pytest.approx(np.log(0.9999) + 30 * np.log(0.995))
    assert found[31] == pytest.approx(31 * np.log(0.9999))


def test_angles_go_on_beyond_half_a_turn_and_what_is_not_known_lies_between() -> None:
    yaw, x = np.array([3.0, np.nan, -2.5, np.nan]), np.array([1.0, np.nan, 12.0, np.nan])
    log: Any = SimpleNamespace(t=np.arange(4.0), columns={"yaw": yaw, "x": x, "y": np.full(4, np.nan)})
    assert _known(log, "x").tolist() == [1.0, 6.5, 12.0, 12.0]
    end = 2.0 * np.pi - 2.5
    assert _known(log, "yaw") == pytest.approx([3.0, 0.5 * (3.0 + end), end, end])
    assert _known(log, "y").tolist() == [0.0] * 4


def test_noise_grows_with_the_distance_of_each_row() -> None:
    """The level is sigma0 + slope d, of both directions of a box, and two centimetres at least."""
    rng = np.random.default_rng(3)
    n = 400
    t, far = 0.1 * np.arange(n), np.linspace(5.0, 80.0, n)
    error = rng.normal(size=(2, n)) * (0.05 + 0.01 * far)
    column = far[:, None]
    p: Any = SimpleNamespace(
        seen=np.ones((n, 1), dtype=bool), dx=error[0][:, None], dy=error[1][:, None], yaw=np.zeros(n),
        vx=np.full((n, 1), 5.0), vy=np.zeros((n, 1)), distance=column,
    )  # fmt: skip
    found = Positions(SimpleNamespace(t=t), p, np.array([0.3, 0.0]))  # type: ignore[arg-type]
    level = np.maximum(found.noise[0] + found.noise[1] * np.concatenate([far, far]), 0.02)
    assert found.noise[1] == pytest.approx(0.01, rel=0.2)
    assert found.level == pytest.approx(level)


def test_the_widest_of_several_ways_to_group_the_rows_counts() -> None:
    """Four errors of one: alone they add up by squares to 4, in two groups of two to 8, times m/(m - 1) = 2; a single
    group of all has 16 and no such factor."""
    bread, scores = np.eye(1), np.ones((4, 1))
    alone, two, one = np.arange(4), np.array([0, 0, 1, 1]), np.zeros(4, dtype=int)
    assert _clustered(bread, scores, alone) == pytest.approx([np.sqrt(4.0 * 4.0 / 3.0)])
    assert _clustered(bread, scores, two) == pytest.approx([4.0])
    assert _clustered(bread, scores, alone, two) == _clustered(bread, scores, two, alone) == pytest.approx([4.0])
    assert _clustered(bread, np.array([[1.0], [2.0], [3.0], [4.0]]), one) == pytest.approx([10.0])
    assert _clustered(bread, np.array([[1.0], [-1.0]]), np.zeros(2, dtype=int)) == pytest.approx([np.sqrt(2.0)])


@pytest.mark.parametrize(("gap", "count"), [(0.5, 1), (0.501, 2)])
def test_a_false_object_is_remembered_for_half_a_second(gap: float, count: int) -> None:
    assert appearances(np.array([0.0, gap]), np.zeros(2), np.zeros(2)) == count


@pytest.mark.parametrize(("gap", "away", "count"), [(0.25, 3.49, 1), (0.25, 3.5, 2), (0.5, 5.99, 1), (0.5, 6.0, 2)])
def test_a_false_object_goes_on_within_a_metre_and_ten_metres_a_second(gap: float, away: float, count: int) -> None:
    for turn in (0.0, 0.5 * np.pi):
        x, y = away * np.cos(turn), away * np.sin(turn)
        assert appearances(np.array([0.0, gap]), np.array([0.0, x]), np.array([0.0, y])) == count


def test_frames_that_were_lost_are_spread_evenly() -> None:
    """Boxes at 0, 0.1, 0.2 and 0.52 s: two frames are missing in between."""
    table = SimpleNamespace(t=np.array([0.0, 0.1, 0.2, 0.52, 0.52]), x=np.zeros(5), y=np.zeros(5))
    found = frames(SimpleNamespace(detections=table))  # type: ignore[arg-type]
    assert found is not None
    assert found.t == pytest.approx([0.0, 0.1, 0.2, 0.2 + 0.32 / 3.0, 0.2 + 0.64 / 3.0, 0.52])
    assert found.row.tolist() == [0, 1, 2, 5, 5]
    assert found.duration == pytest.approx(0.6)
    still = SimpleNamespace(t=np.array([1.0, 1.0]), x=np.zeros(2), y=np.zeros(2))
    assert frames(SimpleNamespace(detections=still)) is None  # type: ignore[arg-type]


def a_field(bearing: Any, there: Any, seen: Any, distance: Any, hidden: Any = 0.0) -> list[bool]:
    """Which rows of one object lie where the detector looks."""
    n = len(bearing)
    given = [np.broadcast_to(np.asarray(one), n)[:, None] for one in (bearing, there, seen, distance, hidden)]
    fields = {field.name: None for field in dataclasses.fields(Pairs)}
    fields |= dict(zip(("bearing", "there", "seen", "distance", "hidden"), given, strict=True))
    return list(Pairs(**fields).in_field_of_view()[:, 0])  # type: ignore[arg-type]


@pytest.mark.parametrize(("there", "looks"), [(11, True), (12, False)])
def test_a_sector_is_a_twentyfourth_of_a_turn_and_is_looked_at_if_a_fifth_of_the_usual_is_seen(
    there: int, looks: bool
) -> None:
    """15 degrees: six rows ahead of which two are seen, 11 or 12 to the left of which one is, and one behind 0.

    The usual share is (2 2/6 + 1/11 + 1) / 4 = 0.439, a fifth of it 0.0879: 1/11 is more, and of 12 0.0875 > 1/12.
    """
    ahead, left = np.full(5, np.radians(7.0)), np.full(there, np.radians(16.0))
    bearing = np.concatenate([ahead, left, np.radians([-361.0, 374.0])])
    seen = np.isin(np.arange(7 + there), [0, 5, 5 + there, 6 + there])
    found = a_field(bearing, True, seen, 20.0)
    assert found == [True] * 5 + [looks] * there + [True, True]


def test_what_is_farther_than_anything_seen_does_not_count_for_a_field_of_view() -> None:
    ahead = np.full(5, np.radians(7.0))
    nothing = a_field(ahead, True, False, 20.0)
    assert nothing == [False] * 5
    far = a_field(np.concatenate([ahead, ahead[:1]]), True, np.arange(6) == 0, np.array([20.0] * 5 + [90.0]))
    assert far == [True] * 6  # what is farther than anything was seen does not count as not seen


def test_what_is_seen_ahead_says_nothing_of_what_is_behind() -> None:
    """Bearings of 7 and of -173 degrees."""
    ahead = np.arange(10) < 5
    assert a_field(np.where(ahead, np.radians(7.0), np.radians(-173.0)), True, ahead, 20.0) == ahead.tolist()


def test_boxes_of_a_car_count_up_to_twentyfive_metres() -> None:
    n = 10
    track = SimpleNamespace(kind="vehicle", length=4.0, width=2.0, t=np.array([0.0, 9.0]), yaw=np.array([0.0, 0.0]))
    table = SimpleNamespace(length=np.linspace(4.3, 4.5, n), width=np.full(n, 1.9), yaw=np.full(n, np.pi + 0.1))
    log = SimpleNamespace(objects={"a": track}, detections=table)
    f: Any = Frames(0.1 * np.arange(n), 0.1, np.arange(n), np.zeros(n), np.zeros(n), log)  # type: ignore[arg-type]

    def of(distance: float) -> Any:
        p: Any = SimpleNamespace(
            seen=np.ones((n, 1), dtype=bool), distance=np.full((n, 1), distance), row=np.arange(n)[:, None]
        )
        return _of_object(f, p, 0, "a")

    assert of(25.0) == pytest.approx([1.1, 0.95, 0.1])
    assert of(25.1) is None
    track.length = 0.0
    assert of(25.0) is None


def test_a_row_of_a_tracker_is_fresh_if_either_part_of_its_velocity_changes() -> None:
    track = np.array([1.0, 1.0, 1.0, 1.0, 2.0, 2.0])
    table: Any = SimpleNamespace(
        t=np.array([0.0, 0.1, 0.2, 0.3, 0.0, 0.1]), track=track, x=np.zeros(6), y=np.zeros(6),
        vx=np.array([5.0, 5.0, 5.0, 6.0, 6.0, 6.0]), vy=np.array([0.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
    )  # fmt: skip
    assert fresh(table).tolist() == [True, False, True, True, True, True]  # the second track never changes


# --- on top of a twin


def key(**given: Any) -> Key:
    return Key("k", "-", 0.0, 1.0, **({"neutral": 0.0, "least": 0.1} | given))


def test_what_a_model_needs_beside_what_its_own_run_shows() -> None:
    assert _border(40.0, 60.0, 50.0, key(neutral=inf)) == 30.0
    assert _border(40.0, 60.0, inf, key(neutral=inf)) == 40.0
    assert _border(40.0, inf, 50.0, key(neutral=inf)) == 40.0
    assert _border(inf, 60.0, 50.0, key(neutral=inf)) == inf
    assert _share_missed(0.6, 0.2, 0.1, key()) == pytest.approx(1.0 - 0.9 * 0.4 / 0.8)
    assert _share_missed(0.6, 1.0, 0.1, key()) == pytest.approx(1.0 - 0.9 * 0.4 / 1e-3)
    assert _dampened(0.6, 0.2, 0.4, key()) == pytest.approx(1.2)  # a half of it gets through: three times as much
    assert _dampened(1.5, 1.25, 1.5, key(neutral=1.0)) == pytest.approx(2.0)
    assert _dampened(9.0, 0.2, 0.4, key()) == pytest.approx(2.0)  # five times at most
    assert _dampened(-9.0, 0.2, 0.4, key()) == pytest.approx(-2.0)
    assert _dampened(0.6, 0.2, 0.0, key()) == pytest.approx(0.4)  # the model has none: by how much more is shown
    assert _dampened(0.6, -0.2, 0.4, key()) == pytest.approx(1.2)  # what shows is no part of what it has: 0.4 + 0.8
    assert _dampened(0.06, 0.05, 0.4, key()) == pytest.approx(0.48)  # half of the least size is enough to tell the part
    assert _dampened(0.06, 0.049, 0.4, key()) == pytest.approx(0.411)
    assert _variance(0.5, 0.3, 0.4, key()) == pytest.approx(0.4 * 5.0 / 3.0)  # 0.5657 by squares
    assert _variance(0.5, 0.4, 0.1, key()) == pytest.approx(np.hypot(0.1, 0.3))
    assert _variance(0.3, 0.4, 0.5, key()) == pytest.approx(0.375)  # 0.4243 by squares
    assert _variance(0.0, 0.4, 0.3, key()) == 0.0
    assert _variance(0.9, 0.1, 0.3, key()) == pytest.approx(1.5)  # five times at most, and 0.943 by squares
    assert _variance(0.3, 0.0, 0.4, key()) == pytest.approx(0.5)


def test_a_value_on_top_keeps_within_what_its_key_allows_with_both_intervals() -> None:
    car, twin = shown(latency=(0.1, 0.06, 0.15), misses=(0.3, 0.2, 0.4)), shown(latency=(0.3, 0.27, 0.42))
    found = on_top(Perceived(car, {}, {}), Perceived(twin, {}, {}), MODEL).values
    assert found["detection_latency", "T"] == pytest.approx((0.0, -0.05, 0.13))  # 3-4-5 and 5-12-13
    assert found["detection_misses", "rate"] == (0.3, 0.2, 0.4)  # the twin tells none
