"""How the signature of an unexplained error is chosen and read: on sums that are given, each bound from both sides."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.compare.segments import CHANNELS
from pytest_dvp.gap.compare.smoothed_motion import Motion, mean_around
from pytest_dvp.gap.diagnose import residual_signature as module
from pytest_dvp.gap.diagnose.residual_signature import (
    _at_measured_speed,
    _crawl,
    _error,
    _others,
    _read,
    _selected,
    _slip,
    _slope,
    signature,
)
from pytest_dvp.gap.diagnose.residual_terms import READINGS, Term
from pytest_dvp.gap.words.residual_signature import signature_lines


class Sums:
    """What terms explain on segments left out, together: the sum of what each of them does, of an error of 11 in units
    of the noise (chi^2/N)."""

    def __init__(self, shares: dict[int, float], level: float = 11.0) -> None:
        self.shares, self.level = shares, level

    def held_out(self, chosen: Any) -> float:
        return sum(self.shares.get(k, 0.0) for k in chosen)

    def fitted(self, chosen: Any) -> tuple[float, Any]:
        return self.held_out(chosen) + 0.01, np.array([*range(len(chosen)), 0.7])

    def left(self, share: float) -> float:
        return self.level - (self.level - 1.0) * share


def some_terms(*widths: int) -> list[Term]:
    return [Term(f"key{k}", f"name {k}", np.zeros((3, width))) for k, width in enumerate(widths)]


def test_terms_are_selected_one_by_one_up_to_three() -> None:
    sums: Any = Sums({0: 0.1, 1: 0.3, 2: 0.2, 3: 0.15})
    chosen, told = _selected(sums, some_terms(1, 1, 1, 1))
    assert chosen == [1, 2, 3]
    assert [(t["term"], t["key"]) for t in told] == [("name 1", "key1"), ("name 2", "key2"), ("name 3", "key3")]
    assert [t["held_out_share"] for t in told] == pytest.approx([0.3, 0.5, 0.65])
    assert [t["share"] for t in told] == pytest.approx([0.31, 0.51, 0.66])
    assert {t["coefficient"] for t in told} == {0.7}


@pytest.mark.parametrize(("share", "told"), [(0.051, 1), (0.049, 0)])
def test_a_term_must_explain_a_twentieth_of_what_is_beyond_the_noise(share: float, told: int) -> None:
    assert len(_selected(Sums({0: share}), some_terms(1, 1))[1]) == told  # type: ignore[arg-type]


@pytest.mark.parametrize(("behind", "first"), [(0.049, 1), (0.051, 0)])
def test_of_terms_that_do_nearly_as_well_the_one_with_fewer_columns_is_taken(behind: float, first: int) -> None:
    """The best leaves 2 of 11; 5 % of that are 0.1, which is 0.01 of the excess of 10. Below noise 0.05 count."""
    sums: Any = Sums({0: 0.9, 1: 0.9 - behind * 0.2}, 11.0)
    assert _selected(sums, some_terms(2, 1))[0][0] == first
    near: Any = Sums({0: 1.05, 1: 1.05 - behind * 0.1}, 11.0)
    assert _selected(near, some_terms(2, 1))[0][0] == first
    alike: Any = Sums({0: 0.9, 1: 0.895})
    assert _selected(alike, some_terms(1, 1))[0][0] == 0


def test_alternatives_are_the_best_of_other_families() -> None:
    names = [Term(key, f"{key} {k}", np.zeros((3, 1))) for k, key in enumerate("aabbcdefg")]
    sums: Any = Sums({0: 0.9, 1: 0.8, 2: 0.3, 3: 0.4, 4: 0.051, 5: 0.049, 6: 0.2, 7: 0.1, 8: 0.5})
    found = _others(sums, names, [0])
    assert [(one["term"], one["held_out_share"]) for one in found] == [
        ("g 8", 0.5),
        ("b 3", 0.4),
        ("e 6", 0.2),
        ("f 7", 0.1),
    ]
    assert _others(sums, names, [])[0]["term"] == "a 0"


N = 300


def a_motion(**given: Any) -> Motion:
    t = 0.05 * np.arange(N)
    fields: dict[str, Any] = {
        "t": t, "step": 0.05, "x": 0.0 * t, "y": 0.0 * t, "yaw": 0.0 * t, "v": 8.0 + 0.0 * t, "yaw_rate": 0.2 + 0.0 * t,
        "accel": None, "steer": None, "moving": np.ones(N, dtype=bool), "way": 8.0 * t, "braked": t, "driven": t,
        "wheelbase": 2.5,
    }  # fmt: skip
    return Motion(**(fields | given))


def an_experiment(*channels: str, edges: tuple[int, ...] = (0, 200, 290, 300)) -> Any:
    segments = SimpleNamespace(starts=np.array(edges[:-1]), ends=np.array(edges[1:]))
    return SimpleNamespace(channels=channels, segments=segments)


def rest(**channels: Any) -> Any:
    found = np.full((N, 8), np.nan)
    for name, values in channels.items():
        found[:, CHANNELS.index(name)] = values
    return found


def test_an_error_is_an_acceleration_or_an_angle_at_the_wheel() -> None:
    m = a_motion(moving=np.arange(N) >= 10)
    rng = np.random.default_rng(0)
    ax, rate = rng.normal(size=(2, N))
    ax[20] = np.nan
    found = _error("longitudinal", an_experiment("ax", "v"), rest(ax=ax, v=9.0), m)
    assert found == pytest.approx(np.where((np.arange(N) < 10) | np.isnan(ax), 0.0, ax))
    turned = _error("lateral", an_experiment("yaw_rate"), rest(yaw_rate=rate), m)
    assert turned[10:] == pytest.approx(rate[10:] * 2.5 / 8.0)
    slow = a_motion(v=np.where(np.arange(N) < 150, 1.9, 8.0))
    angle = _error("lateral", an_experiment("yaw_rate"), rest(yaw_rate=rate), slow)
    assert (angle[:150] == 0.0).all()
    assert angle[150:] == pytest.approx(rate[150:] * 2.5 / 8.0)
    speed = _error("longitudinal", an_experiment("v"), rest(v=3.0 * m.t), m)
    assert speed[10:280] == pytest.approx(3.0, abs=1.7)
    assert np.median(speed[10:280]) == pytest.approx(3.0)
    heading = _error("lateral", an_experiment("yaw"), rest(yaw=0.4 * m.t), m)
    assert np.median(heading[10:280]) == pytest.approx(0.4 * 2.5 / 8.0)


def test_a_slope_is_taken_within_segments_over_a_third_of_a_second() -> None:
    """A window of three samples to either side; a piece of twelve or fewer has none."""
    m = a_motion()
    y = np.random.default_rng(1).normal(size=N)
    found = _slope(an_experiment("v"), y, m)
    for first, end in ((0, 200), (200, 290)):
        assert found[first:end] == pytest.approx(np.gradient(mean_around(y[first:end], 3), m.t[first:end]))
    assert np.isnan(found[290:]).all()
    assert np.isfinite(_slope(an_experiment("v", edges=(0, 13, 25)), y[:25], a_motion())[:13]).all()
    assert np.isnan(_slope(an_experiment("v", edges=(0, 12, 24)), y[:24], a_motion())).all()


def test_a_wrong_speed_turns_the_car_as_much_too_fast() -> None:
    m = a_motion(v=np.where(np.arange(N) < 100, 1.0, 8.0))
    dv = np.where(np.arange(N) == 150, np.nan, 0.5)
    found = _at_measured_speed(rest(v=dv, yaw_rate=0.3, yaw=0.1), m)
    turned = np.where((np.arange(N) < 100) | np.isnan(dv), 0.0, 0.5 * 0.2 / 8.0)
    assert found[:, 4] == pytest.approx(0.3 - turned)
    assert found[:, 2] == pytest.approx(0.1 - np.cumsum(turned * np.append(np.diff(m.t), 0.0)))
    assert found[0, 3] == 0.5


@pytest.mark.parametrize(("top", "crawl"), [(20.0, 2.0), (8.1, 2.0), (4.0, 1.0)])
def test_a_crawl_is_two_metres_a_second_or_a_quarter_of_a_small_cars_speed(top: float, crawl: float) -> None:
    v = np.full(N, -top)
    v[:10] = 99.0  # of 300: less than one in twenty
    assert _crawl(a_motion(v=v)) == pytest.approx(crawl)


def test_a_slide_is_the_angle_between_heading_and_way() -> None:
    """It moves 0.3 rad to the left of where it points, but for a stretch at a crawl, in which it does anything."""
    t = 0.05 * np.arange(N)
    way = np.cumsum(np.where(np.arange(N) < 250, 8.0, 0.2) * 0.05)
    m = a_motion(x=way * np.cos(3.3), y=way * np.sin(3.3), yaw=np.where(np.arange(N) < 250, 3.0, 1.0))
    assert _slip(m) == pytest.approx(0.3, abs=0.01)
    other = a_motion(x=way * np.cos(-3.1), y=way * np.sin(-3.1), yaw=np.full(N, 3.1))
    assert _slip(other) == pytest.approx(2.0 * np.pi - 6.2, abs=0.01)
    for seconds, told in ((2.0, False), (2.6, True)):  # 40 and 52 samples, and some at the end by the smoothing
        way = np.minimum(8.0 * t, 8.0 * seconds)
        assert (_slip(a_motion(x=way, y=way)) > 0.0) is told
    assert _slip(a_motion()) == 0.0
    backwards = a_motion(x=-8.0 * t * np.cos(0.2), y=-8.0 * t * np.sin(0.2), v=np.full(N, -8.0))
    assert _slip(backwards) == pytest.approx(0.2, abs=0.01)  # a car that drives astern does not slide by half a turn


def entry(axis: str = "longitudinal", **given: Any) -> dict[str, Any]:
    fields = {"axis": axis, "chi2_per_n": 9.0, "regressors": [], "same_place": None, "slip": 0.0,
              "speed": {"bin": "speed 5-10 m/s"}}  # fmt: skip
    return fields | given


def term(key: str, share: float) -> dict[str, Any]:
    return {"key": key, "term": f"the {key}", "held_out_share": share}


PLACE = READINGS["place"]
CUT = "grip of the tyres and the road, a spin; `dvp compare` says when: cut it out with LOG@from:to"


@pytest.mark.parametrize(
    ("given", "reading", "look"),
    [
        (entry(regressors=[term("speed", 0.151)]), "longitudinal error grows with speed; 15 % of it on segments left",
         READINGS["speed"][1]),
        (entry(regressors=[term("speed", 0.149)]),
         "longitudinal error that no term of the list explains, most of it at speed 5-10 m/s", "the worst segments"),
        (entry(regressors=[term("wave_time", 0.6)]),
         "longitudinal error is periodic in time (the wave_time); 60 % of it on segments left out",
         READINGS["wave_time"][1]),
        (entry("lateral", chi2_per_n=1.49), "lateral error that follows from the wrong speed", "what is said of the"),
        (entry("lateral", chi2_per_n=1.51), "lateral error that no term of the list explains", "the worst segments"),
        (entry("longitudinal", chi2_per_n=1.49), "longitudinal error that no term", "the worst segments"),
        (entry("lateral", slip=0.121), "lateral error where the car slides: it moves up to 0.12 rad off", CUT),
        (entry("lateral", slip=0.119), "lateral error that no term", "the worst segments"),
        (entry("lateral", slip=0.3, regressors=[term("offset", 0.3), term("time", 0.49)]),
         "lateral error where the car slides: it moves up to 0.30", CUT),
        (entry("lateral", slip=0.3, regressors=[term("offset", 0.3), term("time", 0.51)]),
         "lateral error is a constant angle; 30 % of it", READINGS["offset"][1]),
        (entry(same_place=0.51), "longitudinal error comes back at the same places, 51 % of it", PLACE[1]),
        (entry(same_place=0.49), "longitudinal error that no term", "the worst segments"),
    ],
)  # fmt: skip
def test_an_error_reads_as_what_explains_it_best(given: dict[str, Any], reading: str, look: str) -> None:
    found = _read(given, [])
    assert found[0].startswith(reading)
    assert found[1].startswith(look)


@pytest.mark.parametrize(("share", "told"), [(0.21, True), (0.19, False)])
def test_a_rhythm_is_read_where_nothing_else_is(share: float, told: bool) -> None:
    peak: Any = SimpleNamespace(kind="distance", frequency=0.4567, unit="1/m", share=share)
    reading, look = _read(entry(), [peak])
    assert reading.startswith("longitudinal error is periodic over the distance: 0.457 1/m") is told
    assert (look == READINGS["wave_distance"][1]) is told


def test_the_worst_axis_comes_first_and_a_sensor_that_no_motion_shows_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each axis on the basis that leaves less; values of what was added are no part of the model as given."""
    asked: list[tuple[str, str, tuple[str, ...]]] = []

    def axis(axis: str, basis: str, target: Any, values: Any, motions: Any) -> dict[str, Any]:
        asked.append((axis, basis, tuple(sorted(name for name, _ in values))))
        left = 2.0 if basis == "model as given" else 3.0
        return {"axis": axis, "chi2_per_n_with_regressors": left, "reading": f"{axis} {basis}", "look_at": f"at {axis}"}

    monkeypatch.setattr(module, "_axis", axis)
    monkeypatch.setattr(module, "motion", lambda log, model: None)
    model = SimpleNamespace(effects=[SimpleNamespace(name="mass")])
    target: Any = SimpleNamespace(experiments=[SimpleNamespace(log=None, model=model)])
    target.by_channel = lambda values: {"v": 1.49, "ax": 1.51, "yaw_rate": 9.0, "x": 3.0}
    values = {("mass", "ratio"): 1.1, ("drag", "k"): 0.1, ("inputs", "s"): 1.0, ("parameters", "ay_x"): 0.3}
    found = signature(target, values)
    assert found["channels"] == {"yaw_rate": 9.0, "x": 3.0, "ax": 1.51}
    assert list(found["channels"]) == ["yaw_rate", "x", "ax"]
    assert [one["axis"] for one in found["axes"]] == ["lateral", "longitudinal"]
    assert (found["reading"], found["look_at"]) == ("lateral model as given", "at lateral")
    assert ("lateral", "with the effects found", ("drag", "inputs", "mass", "parameters")) in asked
    assert ("lateral", "model as given", ("inputs", "mass", "parameters")) in asked
    asked.clear()
    signature(target, {("mass", "ratio"): 1.1})
    assert {basis for _, basis, _ in asked} == {"with the effects found"}
    target.by_channel = lambda values: {"x": 3.0, "v": 1.0}
    assert signature(target, values)["reading"] == "error in x that neither speed nor yaw rate shows"
    assert signature(target, values)["look_at"] == "the sensor of x"
    target.by_channel = lambda values: {"x": 1.5}
    assert signature(target, values) == {}


def words(**given: Any) -> list[tuple[str, str]]:
    axis = {
        "axis": "lateral",
        "regressors": [{"term": "a", "held_out_share": 0.2}, {"term": "b", "held_out_share": 0.456}],
    }
    return signature_lines({"reading": "r", "look_at": "l", "axes": [axis | given]})


def test_a_signature_in_words() -> None:
    follows = "follows a, then b (46 % of it on segments left out)"
    assert words() == [("looks like", "r"), ("look at", "l"), ("lateral", follows)]
    assert signature_lines({}) == []
    assert signature_lines({"reading": "", "axes": [{"axis": "x"}]}) == [("x", "follows nothing that was tried")]
    speed = {"share_of_error": 0.5, "share_of_time": 0.39, "bin": "speed 5-10 m/s"}
    assert words(speed=speed)[-1][1] == f"{follows}; 50 % of it at 5-10 m/s, 39 % of the time"
    assert words(speed=speed | {"share_of_time": 0.41})[-1][1] == follows
    just = speed | {"share_of_error": 0.1, "share_of_time": 0.0}
    assert words(speed=just)[-1][1] == f"{follows}; 10 % of it at 5-10 m/s, 0 % of the time"
    wave = {"share": 0.3, "frequency": 1.2345, "unit": "Hz"}
    assert words(rhythm=[wave, None])[-1][1] == f"{follows}; 30 % of it repeats at 1.23 Hz"
    assert words(rhythm=[wave | {"share": 0.29}])[-1][1] == follows
    assert words(trend={"share_in_second_half": 0.8})[-1][1] == f"{follows}; 80 % of it in the second half"
    assert words(trend={"share_in_second_half": 0.79})[-1][1] == follows
