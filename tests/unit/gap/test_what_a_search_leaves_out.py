"""What a search takes for no rival, for no name or for no error; and values that data held out may choose anew."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.candidates import candidates
from pytest_dvp.gap.diagnose.held_out import Fold, refit_on_fold, step
from pytest_dvp.gap.diagnose.run_setup import RunSetup
from pytest_dvp.gap.diagnose.trial import Trial
from tests.unit.gap.linear_world import (
    BRAKE,
    DRIVE,
    MODEL,
    NEUTRAL,
    SEGMENTS,
    Given,
    World,
    a_search,
    a_trial,
    direction,
    tried,
)
from vehicle.model.effect_catalogue import find_effect

EVEN = np.full(SEGMENTS, 20.0)
STICKS, GYRO = ("steer_stiction", "width"), ("gyro_bias", "b")


# --- the search


def test_what_contains_an_effect_or_is_a_finer_form_that_does_worse_is_no_rival_of_it() -> None:
    """A compliance of the axles details an understeer; worse in each segment is worse in each draw."""
    search = a_search(World({}), "steer_ratio", "steer_asymmetry", "mass", "cornering_compliance", "understeer")
    assert search.known["cornering_compliance"].detail
    best = a_trial(1000.0, "steer_ratio", segments=EVEN)
    worse = EVEN + 0.1
    assert search.is_rival(best, a_trial(1005.0, "mass", segments=worse), "steer_ratio")
    assert not search.is_rival(best, a_trial(1000.0, "steer_asymmetry", segments=EVEN), "steer_ratio")
    assert search.is_rival(best, a_trial(1000.0, "steer_asymmetry", segments=EVEN), "mass")
    assert not search.is_rival(best, a_trial(1005.0, "cornering_compliance", segments=worse), "steer_ratio")
    assert search.is_rival(best, a_trial(1000.0, "cornering_compliance", segments=EVEN), "steer_ratio")


class Beside(Given):
    """A search in which a mass means nothing, and a gain of the drive nothing beside it."""

    def is_credible(self, trial: Trial, name: str, target: Any = None, certain: bool = True) -> bool:
        return name != "mass" and "mass" not in trial.names


def test_what_was_named_first_may_mean_something_once_the_last_is_gone() -> None:
    search = Beside(World({}, channels={"v": 3.0}), tried("drive_gain", "mass"))  # type: ignore[arg-type]
    leaves = {"": 4000.0, "drive_gain": 2000.0, "mass": 2000.0, "drive_gain mass": 1000.0}
    search.leaves = {frozenset(key.split()): left for key, left in leaves.items()}
    whole = search.trial(("drive_gain", "mass"), {})
    assert search._drop_implausible(whole).names == ("drive_gain",)


@pytest.mark.parametrize(("trifle", "names"), [("drive_gain", []), ("brake_gain", ["drive_gain", "brake_gain"])])
def test_no_other_effect_stands_for_the_best_one_that_is_too_small_for_a_name(
    trifle: str, names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    search = a_search(World({}, channels={"v": 3.0}), "drive_gain", "brake_gain")
    left = {"drive_gain": 500.0, "brake_gain": 600.0}
    monkeypatch.setattr(search, "_scan", lambda now, few, needed=0.0: [(left[n], n, {}) for n in few])
    monkeypatch.setattr(search, "_additions", lambda now, ranking: [a_trial(c, n) for c, n, _ in ranking])
    monkeypatch.setattr(search, "_trifle", lambda trial: trial.names[-1] == trifle)
    monkeypatch.setattr(search, "is_credible", lambda trial, name, certain: True)
    assert [trial.names[-1] for trial in search.paying(a_trial(4000.0))] == names


def test_within_the_noise_nothing_is_named_and_what_could_not_have_shown_is_told() -> None:
    """At its end of 0.6 a gain of the brakes would change chi^2/N by (0.4 x 1)^2 / 1000; one of the drive, at 0.7, by
    90."""
    does = {DRIVE: 1000.0 * direction(0), BRAKE: 1.0 * direction(1)}
    found = a_search(World(does, {DRIVE: 0.9}, channels={"v": 0.99}), "drive_gain", "brake_gain").run()
    assert (found.final.names, found.rivals, found.not_excited) == ((), {}, ("brake_gain",))


# --- data held out


@pytest.mark.parametrize(("asks", "told"), [(0.51, 0.51), (0.46, 0.46), (0.6, 0.55), (0.3, 0.45)])
@pytest.mark.parametrize("parted", [True, False])
def test_of_an_effect_with_many_valleys_the_judging_data_choose_their_own_within_a_twentieth_of_the_range(
    asks: float, told: float, parted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was found in the middle of its range; the data of a fold that are fitted say 0.8 of the drive, and have no say
    in how the steering sticks."""
    monkeypatch.setitem(NEUTRAL, STICKS, 0.0)
    (sticks,) = tried("steer_stiction")[0].coordinates
    does = {STICKS: 1e4 * direction(0), DRIVE: 1000.0 * direction(1)}
    judge = World(does, {STICKS: sticks.value(asks), DRIVE: 0.7})
    fitted = World(does, {STICKS: sticks.value(0.9), DRIVE: 0.8}) if parted else None
    search = a_search(judge, "steer_stiction", "drive_gain")
    trial = a_trial(1000.0, "steer_stiction", "drive_gain", values={STICKS: sticks.value(0.5), DRIVE: 0.9})
    found = refit_on_fold(search, Fold(fitted, judge), trial)  # type: ignore[arg-type]
    assert found.values[STICKS] == pytest.approx(sticks.value(told))
    assert found.values[DRIVE] == pytest.approx(0.8 if parted else 0.9, abs=1e-4)


def test_a_step_tells_the_zeros_that_each_run_has_of_its_own() -> None:
    """A gyro is off by 0.02 rad/s on the drive fitted on, by -0.02 and 0.01 on the runs that judge."""
    does = {GYRO: 1500.0 * direction(0), DRIVE: 300.0 * direction(1)}
    zeros = tuple(c for one in candidates(MODEL, [find_effect("gyro_bias")]) for c in one.coordinates)

    def run(zero: float) -> Fold:
        world: Any = World(does, {GYRO: zero, DRIVE: 0.9})
        return Fold(None, world, RunSetup(world, zeros, frozenset({"gyro_bias"})))

    search = a_search(World(does, {GYRO: 0.02, DRIVE: 0.9}), "drive_gain", "gyro_bias")
    trial = search.trial(("drive_gain", "gyro_bias"), NEUTRAL)
    found = step(search, trial, (run(-0.02), run(0.01)))
    assert found.held_out_setups == ({GYRO: pytest.approx(-0.02, abs=1e-4)}, {GYRO: pytest.approx(0.01, abs=1e-4)})
    assert found.held_out_chi2_per_n == pytest.approx(1.0, abs=0.01)
    assert found.added == "gyro_bias"
    assert step(search, trial, ()).held_out_setups == ()


def test_a_trifle_is_what_came_last_however_large_the_first_effect_is() -> None:
    """A gain of 0.9 is worth a name; a second one of 0.99 is not, and gains 50 where 100 would make it clear."""
    world = World({DRIVE: 100.0 * direction(0), BRAKE: np.sqrt(50.0) / 0.01 * direction(1)}, {DRIVE: 0.9, BRAKE: 0.99})
    search = a_search(world, "drive_gain", "brake_gain")
    for names, trifle in ((("drive_gain", "brake_gain"), True), (("brake_gain", "drive_gain"), False)):
        assert search._trifle(search.trial(names, {DRIVE: 0.9, BRAKE: 0.99})) is trifle, names
