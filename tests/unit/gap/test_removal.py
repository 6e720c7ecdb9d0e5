"""When an effect of the model is taken out because the car lacks it, and what is said of that, on given errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.diagnosis import Estimate
from pytest_dvp.gap.diagnose.held_out import Fold
from pytest_dvp.gap.diagnose.removal import (
    SearchSpace,
    _removed,
    lost_held_out,
    price,
    removed_effect,
    searched,
)
from pytest_dvp.gap.diagnose.search import Search, SearchResult
from pytest_dvp.gap.diagnose.standing import REMAINDER_ONLY
from pytest_dvp.gap.diagnose.trial import Trial
from tests.unit.gap.linear_world import (
    BRAKE,
    DRIVE,
    MOTOR,
    Applied,
    Having,
    World,
    a_trial,
    direction,
)
from vehicle.model.effect_catalogue import find_effect


@pytest.mark.parametrize(("excused", "worth"), [(False, 50.0), (True, 200.0)])
def test_an_effect_of_the_model_goes_if_the_measurements_gain_without_it(excused: bool, worth: float) -> None:
    for gain, gone in ((worth - 1.0, False), (worth + 1.0, True)):
        does = {DRIVE: 10.0 * np.sqrt(gain) * direction(0), BRAKE: 100.0 * direction(1)}
        world = Having(does, {DRIVE: 1.0, BRAKE: 0.9}, excused=excused)
        model = Applied(drive_gain=0.9, brake_gain=0.9)
        assert _removed(world, model) == ({DRIVE: 1.0} if gone else {})  # type: ignore[arg-type]
    both = Having({DRIVE: 300.0 * direction(0), BRAKE: 200.0 * direction(1)}, {DRIVE: 1.0, BRAKE: 1.0}, excused=excused)
    off = {DRIVE: 1.0, BRAKE: 1.0, MOTOR: 0.0}
    assert _removed(both, Applied(drive_gain=0.9, brake_gain=0.9)) == off  # type: ignore[arg-type]


def test_a_set_has_a_price_for_each_value_fitted_and_each_effect_removed() -> None:
    found = SearchResult(a_trial(2000.0, "drive_gain", "brake_gain", fitted=2), {}, ())
    assert price(found, 1000, 1) == pytest.approx(2000.0 * 1.015)
    little = SearchResult(a_trial(900.0), {}, ())
    assert price(little, 1000, 0) == 1000.0


class Space(SearchSpace):
    """Searches whose results are given: with the effects of the model, and without those that seem too much."""

    results: dict[bool, SearchResult]

    def run(self, fixed: Any) -> Any:
        return Search(self.target, (), fixed=fixed), self.results[bool(fixed)]


def a_space(kept: Trial, without: Trial, *, excused: bool = False, does: float = 300.0) -> Any:
    world = Having({DRIVE: does * direction(0)}, {DRIVE: 1.0}, excused=excused)
    space = Space(world, (), (), (), {}, lambda text: None)  # type: ignore[arg-type]
    object.__setattr__(space, "results", {False: SearchResult(kept, {}, ()), True: SearchResult(without, {}, ())})
    return space


def test_the_search_without_an_effect_counts_if_it_explains_more() -> None:
    model: Any = Applied(drive_gain=0.9)
    better = searched(a_space(a_trial(1500.0, "brake_gain"), a_trial(1100.0, "steer_ratio")), model)
    assert (better.found.final.names, better.removed, better.instead) == (("steer_ratio",), {DRIVE: 1.0}, ())
    alike = searched(a_space(a_trial(1120.0, "brake_gain"), a_trial(1100.0, "steer_ratio")), model)
    assert (alike.removed, alike.instead) == ({DRIVE: 1.0}, ("brake_gain",))
    worse = searched(a_space(a_trial(1050.0, "brake_gain"), a_trial(1100.0, "steer_ratio")), model)
    assert (worse.found.final.names, worse.removed, worse.instead) == (("brake_gain",), {}, ())
    nothing = searched(a_space(a_trial(1050.0, "brake_gain"), a_trial(1100.0)), model)
    assert (nothing.found.final.names, nothing.removed) == ((), {DRIVE: 1.0})
    back = searched(a_space(a_trial(1400.0, "brake_gain"), a_trial(1100.0, "drive_gain")), model)
    assert (back.found.final.names, back.removed) == (("brake_gain",), {})
    right = searched(a_space(a_trial(1400.0, "brake_gain"), a_trial(1100.0), does=1.0), model)
    assert (right.found.final.names, right.removed) == (("brake_gain",), {})


@pytest.mark.parametrize(("more", "kept"), [(9.9, True), (10.2, False)])
def test_what_is_removed_costs_as_much_as_what_is_added(more: float, kept: bool) -> None:
    """Both have one value; the removal of one effect costs half a percent of 2,000."""
    found = searched(
        a_space(a_trial(2000.0 + more, "brake_gain"), a_trial(2000.0, "steer_ratio")), Applied(drive_gain=0.9)
    )  # type: ignore[arg-type]
    assert (found.removed == {}) is kept


def test_of_a_twin_that_learnt_its_car_nothing_is_taken_out_where_an_addition_explains_all(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model: Any = Applied(drive_gain=0.9)
    for left, gone in ((False, {}), (True, {DRIVE: 1.0})):
        monkeypatch.setattr(Search, "misfit", lambda self, now, left=left: left)
        space = a_space(a_trial(1500.0, "brake_gain"), a_trial(1100.0, "steer_ratio"), excused=True)
        assert searched(space, model).removed == gone


@pytest.mark.parametrize(
    ("held_out", "instead", "excused", "doubts"),
    [(0.1, (), False, []), (0.0, (), False, ["data held out do not gain without it"]), (None, (), False,
      ["data held out do not gain without it"]), (0.199, (), True, [REMAINDER_ONLY]), (0.201, (), True, []),
     (0.3, ("mass", "x"), False, ["the model does as well with mass, x added to it"])],
)  # fmt: skip
def test_a_removed_effect_says_what_speaks_against_it(
    held_out: float | None, instead: tuple[str, ...], excused: bool, doubts: list[str]
) -> None:
    found = removed_effect(find_effect("drive_gain"), 0.4, held_out, instead, excused=excused)
    assert (found.action, found.gain, found.rivals, list(found.doubts)) == ("remove", 0.4, instead, doubts)
    assert found.standing == ("provisional" if doubts else "confirmed")
    assert found.parameters == {"g": Estimate(1.0, 1.0, 1.0, "-")}
    assert removed_effect(find_effect("drive_gain"), -0.1, 1.0, (), excused=False).gain == 0.0
    assert removed_effect(find_effect("drive_gain"), 1.1, 1.0, (), excused=False).gain == 1.0


def test_what_an_effect_of_the_model_costs_on_data_held_out() -> None:
    world = World({DRIVE: 100.0 * direction(0)}, {DRIVE: 1.0})
    final = a_trial(1000.0, values={DRIVE: 1.0})
    judges = (Fold(None, world), Fold(None, World({}, count=500)))  # type: ignore[arg-type]
    assert lost_held_out(Applied(drive_gain=0.9), "drive_gain", final, judges) == pytest.approx(100.0 / 1500.0)  # type: ignore[arg-type]
    assert lost_held_out(Applied(drive_gain=0.9), "drive_gain", final, ()) is None  # type: ignore[arg-type]
