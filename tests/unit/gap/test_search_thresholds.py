"""Each threshold of the search from both sides, on sets of effects whose chi^2 is given instead of fitted.

Expected outcomes follow from what each threshold is said to mean (docs/diagnose.md and the comments in search.py): with
1,000 samples and an error near 1, a gain of 0.05 of chi^2/N is a chi^2 of 50. Just less and just more is tried.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from math import inf
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose import search as module
from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.least_squares import Coordinate, Fit, Stop
from pytest_dvp.gap.diagnose.search import PRACTICAL, Ranked, Search
from pytest_dvp.gap.diagnose.simpler_effects import is_simpler
from pytest_dvp.gap.diagnose.trial import Trial
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

COUNT = 1000
MODEL = parse_model("[model]\nname = 'car'\n[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n")
SEGMENTS = 50


class Samples:
    """Data of a search of which only the number of samples and the error of each channel are known."""

    count = COUNT
    excused = False

    def __init__(self, **channels: float) -> None:
        self.channels = channels

    def starts(self) -> Any:
        return np.arange(0, COUNT, COUNT // SEGMENTS)

    def settle(self, values: object) -> None:
        pass

    def by_channel(self, values: object) -> dict[str, float]:
        return self.channels

    def anew(self) -> dict[str, float]:
        return dict.fromkeys(self.channels, 1.0)


def search(*names: str, **channels: float) -> Search:
    tried = candidates(MODEL, [find_effect(name) for name in names])
    return Search(Samples(**channels), tried)  # type: ignore[arg-type]


def left(chi2: float, *names: str, parts: int | None = None, rest: Any = None) -> Trial:
    """A set of effects that leaves this chi^2, evenly over all segments; parts: how many parameters were fitted."""
    coordinates = [Coordinate(name, key) for name in names for key in find_effect(name).parameters]
    fit = Fit(tuple(coordinates[:parts]), {}, np.zeros(1), chi2, np.zeros((len(coordinates), 1)))
    return Trial(names, {}, fit, np.full(SEGMENTS, chi2 / SEGMENTS) if rest is None else rest)


def uneven(gains: Any) -> Any:
    """Error of each segment after these gains, from 20 in each."""
    return np.full(SEGMENTS, 20.0) - gains


@pytest.mark.parametrize(("gain", "worth"), [(29.0, False), (31.0, True)])
def test_the_first_effect_must_gain_three_percent(gain: float, worth: bool) -> None:
    assert search("drive_gain").is_worth_adding(left(1000.0), left(1000.0 - gain, "drive_gain")) is worth


@pytest.mark.parametrize(("gain", "worth"), [(49.0, False), (51.0, True)])
def test_each_further_effect_must_gain_five_percent(gain: float, worth: bool) -> None:
    before = left(1000.0, "brake_gain")
    assert search().is_worth_adding(before, left(1000.0 - gain, "brake_gain", "drive_gain")) is worth


@pytest.mark.parametrize(("after", "worth"), [(2000.0 - 90.0, False), (2000.0 - 100.0, True)])
def test_where_much_is_left_the_gain_is_a_share_of_it(after: float, worth: bool) -> None:
    """5 % of what is left, not of 1: 2000 - g >= 20 g has its end at g = 95.2."""
    assert search().is_worth_adding(left(2000.0, "brake_gain"), left(after, "brake_gain", "drive_gain")) is worth


@pytest.mark.parametrize(
    ("gain", "excused", "worth"),
    [(80.0, False, False), (95.0, False, True), (95.0, True, False), (135.0, True, False), (150.0, True, True)],
)
def test_far_from_the_noise_three_percent_are_worth_an_effect_but_for_a_known_remainder(
    gain: float, excused: bool, worth: bool
) -> None:
    """3 % of what is left: 3000 - g >= 33.3 g has its end at g = 87.4; 5 % at 142.9."""
    s = search()
    s.target.excused = excused  # type: ignore[misc]
    assert s.is_worth_adding(left(3000.0, "brake_gain"), left(3000.0 - gain, "brake_gain", "drive_gain")) is worth


@pytest.mark.parametrize(("segments", "pays"), [(2, False), (4, True)])
def test_a_gain_must_show_in_nearly_every_draw(segments: int, pays: bool) -> None:
    """Two of 50 segments that gain are missing from (1 - 2/50)^50 = 13 % of the draws, four from 1.5 %; the others lose
    a little, so a draw without them loses more than a tenth of the gain. The limit is 5 %."""
    loss = 0.6
    gains = np.full(SEGMENTS, -loss)
    gains[:segments] = (100.0 + loss * (SEGMENTS - segments)) / segments
    before, after = left(1000.0, "brake_gain"), left(900.0, "brake_gain", "drive_gain", rest=uneven(gains))
    assert search().is_worth_adding(before, after) is pays


@pytest.mark.parametrize(("loss", "pays"), [(9.0, True), (13.0, False)])
def test_draws_without_the_one_event_may_lose_a_tenth_of_the_gain(loss: float, pays: bool) -> None:
    """The one segment that gains is missing from 36 % of the draws, which then lose `loss` of 100 in all."""
    gains = np.full(SEGMENTS, -loss / SEGMENTS)
    gains[0] = 100.0 + loss * (SEGMENTS - 1) / SEGMENTS
    before, after = left(1000.0, "brake_gain"), left(900.0, "brake_gain", "drive_gain", rest=uneven(gains))
    assert search().is_worth_adding(before, after) is pays


@pytest.mark.parametrize(("gain", "pays"), [(240.0, False), (260.0, True)])
def test_five_times_what_is_worth_an_effect_needs_no_draws(gain: float, pays: bool) -> None:
    """All in one segment, while the others lose 20 % of it: the draws are against it."""
    gains = np.full(SEGMENTS, -0.2 * gain / SEGMENTS)
    gains[0] = gain + 0.2 * gain * (SEGMENTS - 1) / SEGMENTS
    before, after = left(1000.0, "brake_gain"), left(1000.0 - gain, "brake_gain", "drive_gain", rest=uneven(gains))
    assert search().is_worth_adding(before, after) is pays


@pytest.mark.parametrize(("gap", "alike"), [(19.0, True), (21.0, False)])
def test_a_gap_of_two_percent_tells_two_sets_apart_if_it_is_everywhere(gap: float, alike: bool) -> None:
    assert search().cannot_tell_apart(left(1000.0, "drive_gain"), left(1000.0 + gap, "mass")) is alike


@pytest.mark.parametrize(("gap", "alike"), [(48.0, True), (52.0, False)])
def test_a_gap_of_less_than_five_percent_that_few_segments_make_does_not(gap: float, alike: bool) -> None:
    rest = np.full(SEGMENTS, 20.0)
    rest[0] += gap
    assert search().cannot_tell_apart(left(1000.0, "drive_gain"), left(1000.0 + gap, "mass", rest=rest)) is alike


@pytest.mark.parametrize(("more", "simpler_wins"), [(4.0, True), (6.0, False)])
def test_a_parameter_costs_half_a_percent(more: float, simpler_wins: bool) -> None:
    s = search()
    one = left(1000.0 + more, "steer_asymmetry", parts=1)
    two = left(1000.0, "steer_asymmetry", parts=2)
    assert (s.cost(one) < s.cost(two)) is simpler_wins


@pytest.mark.parametrize(("more", "gain_wins"), [(0.4, True), (0.6, False)])
def test_a_limit_that_is_always_met_gives_way_to_a_gain(more: float, gain_wins: bool) -> None:
    """Sets that differ by less than 0.0005 of chi^2/N do the same: then the one without a limit is named."""
    s = search()
    assert (s.cost(left(900.0 + more, "drive_gain")) < s.cost(left(900.0, "brake_limit"))) is gain_wins


@pytest.mark.parametrize(
    ("chi2", "channels", "left_over"),
    [(1290.0, {"v": 1.4}, False), (1310.0, {"v": 1.4}, True), (900.0, {"v": 0.5, "yaw": 1.49}, False),
     (900.0, {"v": 0.5, "yaw": 1.51}, True)],
)  # fmt: skip
def test_a_misfit_is_thirty_percent_over_all_or_half_of_one_channel(
    chi2: float, channels: dict[str, float], left_over: bool
) -> None:
    assert search(**channels).misfit(left(chi2)) is left_over


@pytest.mark.parametrize(("worst", "noise"), [(0.99, True), (1.01, False)])
def test_nothing_is_looked_for_below_the_noise_of_every_channel(worst: float, noise: bool) -> None:
    s = search("drive_gain", v=0.2, yaw=worst)
    assert s.within_noise(left(900.0)) is noise


@pytest.mark.parametrize(("gain", "ratio_wins"), [(49.0, True), (51.0, False)])
def test_an_asymmetry_must_gain_what_an_effect_is_worth_over_a_ratio(gain: float, ratio_wins: bool) -> None:
    s = search("steer_asymmetry", "steer_ratio")
    ratio, sides = left(1000.0, "steer_ratio"), left(1000.0 - gain, "steer_asymmetry")
    assert is_simpler(s, "steer_ratio", ratio, sides, PRACTICAL) is ratio_wins


class Ordered(Search):
    """A search in which each effect, alone or with others, leaves a given chi^2."""

    leaves: dict[str, float]

    def _scan(self, now: Trial, names: Iterable[str], needed: float = 0.0) -> list[Ranked]:
        return sorted((self.leaves[name], name, {}) for name in names if name not in now.names)

    def _additions(self, now: Trial, ranking: Sequence[Ranked], lowest: float = inf) -> list[Trial]:
        return [left(chi2, *now.names, name, parts=1) for chi2, name, _ in ranking]

    def _trifle(self, trial: Trial) -> bool:
        return False

    def is_credible(self, trial: Trial, name: str, target: object = None, certain: bool = True) -> bool:
        return True


@pytest.mark.parametrize(("finer", "first"), [(0.81, "understeer"), (0.79, "cornering_compliance")])
def test_a_finer_effect_comes_first_only_if_it_leaves_less_than_four_fifths(finer: float, first: str) -> None:
    """Both have one parameter, so their prices are alike: half a percent of what is left."""
    tried = candidates(MODEL, [find_effect(name) for name in ("understeer", "cornering_compliance")])
    s = Ordered(Samples(yaw=3.0), tried)  # type: ignore[arg-type]
    s.leaves = {"understeer": 2000.0, "cornering_compliance": 2000.0 * finer}
    assert s.paying(left(4000.0))[0].names == (first,)


def test_twelve_effects_are_added_and_after_them_only_finer_ones() -> None:
    plain = ("drive_gain", "brake_gain", "drive_lag", "brake_lag", "steer_lag", "steer_delay", "drive_delay", "mass",
             "steer_ratio", "understeer", "lift_off_braking", "aero_drag", "rolling_resistance")  # fmt: skip
    tried = candidates(MODEL, [find_effect(name) for name in (*plain, "body_roll")])
    s = Ordered(Samples(yaw=3.0), tried)  # type: ignore[arg-type]
    s.leaves = dict.fromkeys((*plain, "body_roll"), 2000.0)
    eleven, twelve = left(4000.0, *plain[:11]), left(4000.0, *plain[:12])
    assert {t.names[-1] for t in s.paying(eleven)} == {"aero_drag", "rolling_resistance"}
    assert {t.names[-1] for t in s.paying(twelve)} == {"body_roll"}


@pytest.mark.parametrize(
    ("chi2", "present", "names"),
    [(19_900.0, 8, {"aero_drag", "rolling_resistance"}), (20_100.0, 8, {"body_roll"}),
     (20_100.0, 7, {"mass", "aero_drag", "rolling_resistance"})],
)  # fmt: skip
def test_far_from_the_car_eight_effects_are_added(chi2: float, present: int, names: set[str]) -> None:
    """Of 1000 samples, up to a chi^2/N of 20 more."""
    plain = ("drive_gain", "brake_gain", "drive_lag", "brake_lag", "steer_lag", "steer_delay", "drive_delay", "mass",
             "aero_drag", "rolling_resistance")  # fmt: skip
    s = Ordered(Samples(yaw=3.0), candidates(MODEL, [find_effect(name) for name in (*plain, "body_roll")]))  # type: ignore[arg-type]
    s.leaves = dict.fromkeys((*plain, "body_roll"), 2000.0)
    assert {t.names[-1] for t in s.paying(left(chi2, *plain[:present]))} == names


class Doubtful(Ordered):
    """Of a ranking the best six are fitted; those of `doubted` say nothing, the others leave what they promise."""

    doubted: tuple[str, ...] = ()

    def _additions(self, now: Trial, ranking: Sequence[Ranked], lowest: float = inf) -> list[Trial]:
        return super()._additions(now, ranking[:6])

    def is_credible(self, trial: Trial, name: str, target: object = None, certain: bool = True) -> bool:
        return name not in self.doubted

    def misfit(self, now: Trial) -> bool:
        return False


@pytest.mark.parametrize(
    ("chi2", "excused", "promised", "found"),
    [
        (4000.0, False, 3800.0, True),
        (4000.0, False, 3890.0, False),  # 3 % of what is left would be 117
        (4000.0, True, 3700.0, False),  # of a known remainder what comes first is asked only
        (1990.0, False, 1700.0, False),  # near the noise as well
    ],
)
def test_far_from_the_noise_what_promises_less_is_fitted_where_the_first_six_say_nothing(
    chi2: float, excused: bool, promised: float, found: bool
) -> None:
    first = ("drive_gain", "brake_gain", "drive_lag", "brake_lag", "steer_lag", "steer_delay")
    tried = candidates(MODEL, [find_effect(name) for name in (*first, "mass")])
    s = Doubtful(Samples(yaw=1.4), tried)  # type: ignore[arg-type]
    s.target.excused = excused  # type: ignore[misc]
    s.leaves = dict.fromkeys(first, 1500.0) | {"mass": promised}
    s.doubted = first
    assert [t.names[-1] for t in s.paying(left(chi2), barred=("understeer",))] == (["mass"] if found else [])


class Replaced(Search):
    """A search that ends with a set whose value means nothing, and knows what is left without it, or with others."""

    without_it: Trial
    with_others: Trial

    def _drop_implausible(self, best: Trial, *, refill: bool = False) -> Trial:
        return self.with_others if refill else self.without_it


@pytest.mark.parametrize(("lost", "taken"), [(190.0, True), (210.0, False)])
def test_others_take_its_place_if_they_recover_four_fifths(lost: float, taken: bool) -> None:
    """Without the wind the fit loses 1,000; with others in its place it may lose a fifth of that, 200."""
    s = Replaced(Samples(v=3.0), candidates(MODEL, [find_effect("headwind")]))  # type: ignore[arg-type]
    s.without_it, s.with_others = left(3000.0), left(2000.0 + lost, "rolling_resistance")
    assert (s.credible_set(left(2000.0, "headwind")) is s.with_others) is taken


class Fitted(Search):
    """A search that notes what it fits, and finds the same chi^2 each time."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self.fits: list[tuple[str, float]] = []
        self.enough: list[float] = []

    def trial(self, names: Collection[str], start: object, **options: Any) -> Trial:  # type: ignore[override]
        self.fits.append((list(names)[-1], options["above"]))
        self.enough.append(options["enough"])
        return left(800.0, *names)


def test_six_candidates_of_a_round_are_fitted_and_the_hopeless_ones_roughly() -> None:
    """A set that is a tenth behind the best so far, twice what an effect is worth, need not be fitted well."""
    s = Fitted(Samples(v=3.0), ())
    s._additions(left(2000.0), [(float(k), "drive_gain", {}) for k in range(9)])
    assert len(s.fits) == 6
    assert s.fits[0][1] == inf
    assert [above for _, above in s.fits[1:]] == pytest.approx([800.0 + 0.1 * COUNT] * 5)
    # half a percent of what is left beyond the noise: first 1,000, then nothing, for 800 is below it
    assert s.enough == pytest.approx([5.0, *[-1.0] * 5])


@pytest.mark.parametrize(("best", "enough"), [(9000.0, 40.0), (1000.0, 0.0)])
def test_what_may_take_the_place_of_an_effect_is_fitted_as_the_best_set_asks(best: float, enough: float) -> None:
    """However much is left without the effect: half a percent of what the best set leaves beyond the noise."""
    s = Fitted(Samples(v=3.0), ())
    s._additions(left(90_000.0), [(1.0, "drive_gain", {})], best)
    assert s.enough == pytest.approx([enough])


@pytest.mark.parametrize(("enough", "ends"), [(40.0, 40.0), (0.1, 0.2), (-1.0, 0.2)])
def test_a_fit_ends_where_a_round_gains_little(enough: float, ends: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """At 2e-4 of 1,000 samples at the latest."""
    stops: list[Stop] = []

    def fit(target: object, coordinates: object, start: object, *, stop: Stop, **more: object) -> object:
        stops.append(stop)
        raise StopIteration

    monkeypatch.setattr(module, "fit", fit)
    with pytest.raises(StopIteration):
        Search(Samples(v=3.0), ()).trial((), {}, enough=enough)  # type: ignore[arg-type]
    assert [stop.enough for stop in stops] == pytest.approx([ends])


def test_where_another_effect_will_come_a_fit_may_end_twice_as_early(monkeypatch: pytest.MonkeyPatch) -> None:
    s = Fitted(Samples(v=3.0), candidates(MODEL, [find_effect("drive_gain"), find_effect("mass")]))  # type: ignore[arg-type]
    monkeypatch.setattr(s, "trial", lambda names, start, **options: s.enough.append(options["enough"]) or left(9e4))
    monkeypatch.setattr(s, "_scan", lambda *asked: [])
    s.in_place_of(left(9000.0, "drive_gain", "mass"), "mass")
    assert s.enough == pytest.approx([80.0])


@pytest.mark.parametrize(("change", "hidden"), [(0.049, ("drive_gain",)), (0.051, ())])
def test_an_effect_whose_strongest_would_change_less_than_five_percent_is_not_excited(
    change: float, hidden: tuple[str, ...]
) -> None:
    s = search("drive_gain")
    s._shown = {"drive_gain": change}
    assert s.unseen() == hidden


def test_the_twelve_that_came_nearest_may_take_the_place_of_an_effect() -> None:
    plain = ("drive_gain", "brake_gain", "drive_lag", "brake_lag", "steer_lag", "steer_delay", "drive_delay",
             "aero_drag", "rolling_resistance", "viscous_resistance", "headwind", "mass", "steer_ratio",
             "understeer")  # fmt: skip
    s = Ordered(Samples(yaw=3.0), candidates(MODEL, [find_effect(name) for name in plain]))  # type: ignore[arg-type]
    s.leaves = {name: 2000.0 + k for k, name in enumerate(plain)}
    s.paying(left(4000.0))
    assert s._near["drive_gain"] == plain[:12]
