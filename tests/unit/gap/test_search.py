"""The search: what pays is added, what does not is dropped or exchanged, what cannot be told apart is listed."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from gap_logs import baseline, drive

from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, experiment_set
from pytest_dvp.gap.diagnose.least_squares import intervals
from pytest_dvp.gap.diagnose.search import FIRST, Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log import Log
from tests.truth.effects import Effects, TruthCar
from tests.truth.generate import make_log
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import parse_model
from vehicle.surrogate.driver import Drive

CAR = TruthCar()
TRUTH_MODEL = parse_model(
    f"[model]\nname = 'car'\n[parameters]\nwheelbase = {CAR.wheelbase}\nmass = {CAR.mass}\n"
    f"cg_to_front_axle = {CAR.cg_to_front_axle}\nyaw_inertia = {CAR.yaw_inertia}\n"
)


@lru_cache(maxsize=16)
def weak(g: float = 0.85) -> ExperimentSet:
    return experiment_set({"log": drive(drive_gain=g, seed=3)}, baseline())


def search(target: ExperimentSet, *names: str) -> Search:
    """A search among a few effects of the catalogue."""
    model = target.experiments[0].model
    return Search(target, candidates(model, [catalogue()[name] for name in names], ay=False))


def on_truth(effects: Effects, course: Drive, *names: str, noise: str = "mid", seconds: float = 100.0) -> Search:
    columns = make_log(effects, course, 4, noise)  # type: ignore[arg-type]
    rows = columns["t"] < seconds
    log = Log({name: np.ascontiguousarray(values[rows]) for name, values in columns.items()})
    return search(experiment_set({course: log}, TRUTH_MODEL), *names)


def fitted(s: Search, *names: str) -> Trial:
    """These effects, fitted from their strongest point on."""
    start = {k: v for name in names for k, v in s.tried[name].points[-1].items()}
    trial = s.trial(names, start)
    s.target.settle(trial.values)
    return s.trial(names, trial.values)


def test_the_right_effect_is_added_and_then_nothing_more() -> None:
    found = search(weak(), "rolling_resistance", "drive_gain", "brake_gain", "drive_lag", "aero_drag").run()
    assert found.final.names == ("drive_gain",)
    assert found.final.values["drive_gain", "g"] == pytest.approx(0.85, rel=0.005)


def test_the_order_of_the_catalogue_does_not_matter() -> None:
    names = ("rolling_resistance", "drive_gain", "brake_gain", "drive_lag", "aero_drag")
    one, other = search(weak(), *names).run(), search(weak(), *reversed(names)).run()
    assert one.final.names == other.final.names
    assert one.final.values == pytest.approx(other.final.values, rel=1e-3)
    assert one.not_excited == other.not_excited


def test_a_gain_of_less_than_is_worth_an_effect_is_left_alone() -> None:
    """3 permille less drive are seen by the sums, but what they buy goes with the square: no effect is named for it."""
    s = search(weak(0.997), "drive_gain", "brake_gain", "steer_ratio")
    nothing, gain = s.trial((), {}), fitted(s, "drive_gain")
    assert 0.0 < (nothing.chi2 - gain.chi2) / s.count < FIRST
    assert s.run().final.names == ()


def test_a_value_below_the_least_size_is_left_alone_though_it_would_pay() -> None:
    s = search(weak(0.992), "drive_gain", "brake_gain", "steer_ratio")
    nothing, gain = s.trial((), {}), fitted(s, "drive_gain")
    assert abs(gain.values["drive_gain", "g"] - 1.0) < s.tried["drive_gain"].coordinates[0].key.least
    assert s.is_worth_adding(nothing, gain)
    assert s.run().final.names == ()


@pytest.mark.parametrize(("name", "limit"), [("brake_limit", 2.0), ("power_limit", 9.0), ("steer_angle_limit", 0.22)])
@pytest.mark.nightly(by_day=3)
def test_a_limit_is_found_where_it_begins_to_bite(name: str, limit: float) -> None:
    s = on_truth({name: {"limit": limit}}, "rich", name, "brake_gain", "steer_ratio", "steer_lag", "drive_gain")
    found = s.run()
    assert found.final.names == (name,)
    assert found.final.values[name, "limit"] == pytest.approx(limit, rel=0.02)


def test_a_limit_that_is_never_met_is_not_excited() -> None:
    s = search(weak(), "steer_angle_limit", "drive_gain")
    assert s.run().not_excited == ("steer_angle_limit",)


def test_what_a_drive_shows_does_not_depend_on_what_is_looked_at_later() -> None:
    """In place of the only effect of a set, those without hope are looked at in their weakest point only."""
    s = search(weak(), "drive_gain", "brake_gain", "steer_ratio", "steer_lag", "steer_offset")
    found = s.run()
    assert (found.final.names, found.not_excited) == (("drive_gain",), ())
    s._near.clear()
    s.in_place_of(found.final, "drive_gain")
    assert s.unseen() == ()


def test_the_simpler_of_two_that_can_do_the_same_is_named() -> None:
    """Both sides alike is a ratio; an asymmetry would do it with one parameter more, and is no rival for that."""
    s = on_truth({"steer_ratio": {"g": 0.88}}, "rich", "steer_asymmetry", "steer_ratio", "steer_offset")
    found = s.run()
    assert found.final.names == ("steer_ratio",)
    assert found.rivals["steer_ratio"] == ()


def test_sides_that_differ_are_an_asymmetry() -> None:
    truth = {"steer_asymmetry": {"g_left": 0.9, "g_right": 1.1}}
    s = on_truth(truth, "rich", "steer_asymmetry", "steer_ratio", "steer_offset")
    assert s.run().final.names == ("steer_asymmetry",)


def test_sides_that_hardly_differ_are_a_ratio() -> None:
    """0.7 % between the sides is seen, but worth 0.015 of chi^2/N, less than an effect is (0.05)."""
    truth = {"steer_asymmetry": {"g_left": 1.15, "g_right": 1.157}}
    s = on_truth(truth, "rich", "steer_asymmetry", "steer_ratio", "steer_offset")
    assert 0.0 < (fitted(s, "steer_ratio").chi2 - fitted(s, "steer_asymmetry").chi2) / s.count < 0.05
    assert s.run().final.names == ("steer_ratio",)


def test_another_effect_takes_the_place_of_one_whose_value_means_nothing() -> None:
    """A wind at the end of its range has a force that hardly depends on the speed, as rolling resistance has."""
    s = on_truth({"rolling_resistance": {"c": 0.15}}, "rich", "headwind", "rolling_resistance", "viscous_resistance")
    wind = fitted(s, "headwind")
    assert wind.chi2 > 1.5 * s.count
    assert not s.is_credible(wind, "headwind")
    assert s.credible_set(wind).names == ("rolling_resistance",)


def test_far_from_the_car_an_effect_is_added_though_one_segment_alone_shows_it() -> None:
    """The car turns once: of a single segment no interval is known, and the search had ended at chi2/N 100."""
    s = search(experiment_set({"drive": drive(20.0, steer_ratio=0.6, drive_gain=0.5)}, baseline()),
               "steer_ratio", "drive_gain", "understeer")  # fmt: skip
    assert set(s.grown(s.trial((), s.start), []).names) == {"steer_ratio", "drive_gain"}


def test_what_does_not_pay_is_pruned() -> None:
    s = search(weak(), "drive_gain", "brake_gain", "aero_drag")
    both = fitted(s, "drive_gain", "brake_gain")
    assert not s.is_worth_adding(fitted(s, "drive_gain"), both)
    assert s.pruned(both).names == ("drive_gain",)


def test_an_effect_that_another_does_better_in_its_place_is_exchanged() -> None:
    s = search(experiment_set({"log": drive(steer_delay=0.2, seed=5)}, baseline()), "steer_lag", "steer_delay")
    best, _ = s._contest(fitted(s, "steer_lag"))
    assert best.names == ("steer_delay",)
    assert best.values["steer_delay", "T"] == pytest.approx(0.2, abs=0.005)


def test_delay_and_lag_of_the_steering_are_told_apart_where_it_is_stirred() -> None:
    s = on_truth({"steer_delay": {"T": 0.15}}, "rich", "steer_delay", "steer_lag", "tyre_relaxation")
    found = s.run()
    assert found.final.names == ("steer_delay",)
    assert found.rivals["steer_delay"] == ()


def test_what_does_nearly_as_well_on_gentle_town_driving_is_a_rival() -> None:
    """A delay and a lag of 30 ms differ only where the wheel moves fast; under twice the noise nobody can tell."""
    s = on_truth({"steer_delay": {"T": 0.05}}, "urban", "steer_delay", "steer_lag", "drive_gain", noise="high")
    found = s.run()
    (name,) = found.final.names
    assert {name, *found.rivals[name]} == {"steer_delay", "steer_lag"}


def test_a_finer_form_that_does_worse_in_nearly_all_draws_is_no_rival() -> None:
    """In town a servo of second order does nearly what a dead time does: 0.4 % more chi2, in 99 of 100 draws."""
    s = on_truth({"steer_delay": {"T": 0.2}}, "urban", "steer_delay", "steer_servo", seconds=45.0)
    found = s.run()
    assert (found.final.names, found.rivals) == (("steer_delay",), {"steer_delay": ()})


@pytest.mark.parametrize("blend", [0.0, 0.3])
def test_over_how_much_of_the_pedal_a_drag_comes_is_found_though_nothing_moves_at_first(blend: float) -> None:
    """With the last bit of the pedal or from 0.35 m/s^2 on: no other resistance stands for it."""
    truth = {"lift_off_braking": {"a": 0.5, "blend": blend}}
    s = on_truth(truth, "rich", "lift_off_braking", "rolling_resistance", "drive_gain", "pedal_deadband")
    found = s.run().final
    assert found.names == ("lift_off_braking",)
    assert found.values["lift_off_braking", "blend"] == pytest.approx(blend, abs=0.01)
    assert found.values["lift_off_braking", "a"] == pytest.approx(0.5, rel=0.02)


def test_what_pushes_a_slow_car_is_creep_and_no_weaker_brake() -> None:
    truth = {"creep": {"a": 0.8, "v0": 4.0, "braking": 1.0}}
    found = on_truth(truth, "rich", "creep", "brake_gain", "rolling_resistance", "drive_gain", "brake_lag").run()
    assert (found.final.names, found.rivals) == (("creep",), {"creep": ()})
    assert found.final.values["creep", "a"] == pytest.approx(0.8, rel=0.05)
    under_brakes = found.final.values["creep", "a"] * found.final.values["creep", "braking"]
    assert under_brakes == pytest.approx(0.8, rel=0.02)  # this car is slow mostly while it brakes
    assert found.final.values["creep", "v0"] == pytest.approx(4.0, rel=0.02)


def test_only_positive_commands_leave_the_mass_and_the_gain_of_the_drive_equal() -> None:
    log = drive(seed=7, drive_gain=0.8)
    launch = Log({name: values[: 11 * 50] for name, values in log.columns.items()})
    found = search(experiment_set({"log": launch}, baseline()), "mass", "drive_gain", "brake_gain").run()
    (name,) = found.final.names
    assert {name, *found.rivals[name]} == {"mass", "drive_gain"}
    assert "brake_gain" in found.not_excited


def test_pure_noise_names_nothing_whatever_is_tried() -> None:
    target = experiment_set({"log": drive(seed=9)}, baseline())
    found = search(target, *[name for name, e in catalogue().items() if e.slot in ("command", "force", "sensor")]).run()
    assert found.final.names == ()


def test_a_gain_must_show_in_nearly_every_draw_of_segments() -> None:
    s = search(weak(), "drive_gain")
    m = len(s.starts)
    better = np.ones(m)
    everywhere, once = better + 0.1, better.copy()
    once[0] += 0.1 * m
    assert s.bootstrap_share(everywhere, better) == 1.0
    # the one segment that gains is in a draw of m with 1 - (1 - 1/m)^m
    assert s.bootstrap_share(once, better) == pytest.approx(1.0 - (1.0 - 1.0 / m) ** m, abs=0.08)
    assert s.bootstrap_share(better, everywhere) == 0.0


def test_the_interval_of_a_named_effect_holds_the_truth() -> None:
    s = search(weak(), "drive_gain", "brake_gain")
    final = s.run().final
    low, high = intervals(final.fit, s.starts)["drive_gain", "g"]
    assert low <= 0.85 <= high
    assert high - low < 0.01


def test_a_finer_effect_is_not_called_hidden_for_being_without_hope() -> None:
    """It is first looked at in the place of the only effect, and in its weakest point only."""
    s = on_truth({"steer_delay": {"T": 0.15}}, "rich", "steer_delay", "steer_sticking", "steer_ratio")
    assert "steer_sticking" not in s.run().not_excited
