"""An effect fitted at the end of its range means nothing: the truth lies beyond, or is another effect."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.candidates import candidates, is_certain
from pytest_dvp.gap.diagnose.experiment import ExperimentSet, experiment_set
from pytest_dvp.gap.diagnose.least_squares import Coordinate, intervals
from pytest_dvp.gap.diagnose.search import Search
from pytest_dvp.gap.diagnose.trial import Trial
from pytest_dvp.logs.log import Log
from tests.truth.effects import TruthCar
from tests.truth.generate import make_log
from vehicle.model.effect_catalogue import find_effect
from vehicle.model.model_file import parse_model

CAR = TruthCar()
BASE = parse_model(
    f"[model]\nname = 'car'\n[parameters]\nwheelbase = {CAR.wheelbase}\nmass = {CAR.mass}\n"
    f"cg_to_front_axle = {CAR.cg_to_front_axle}\nyaw_inertia = {CAR.yaw_inertia}\n"
)


def driven(gain: float) -> ExperimentSet:
    """A drive of the truth car whose motor gives `gain` of what is asked for."""
    columns = make_log({"drive_gain": {"g": gain}}, "rich", 4, "mid")
    rows = columns["t"] < 90.0
    log = Log({name: np.ascontiguousarray(values[rows]) for name, values in columns.items()})
    return experiment_set({"rich": log}, BASE)


def fitted(target: ExperimentSet) -> tuple[Search, Trial]:
    search = Search(target, candidates(BASE, [find_effect("drive_gain")], ay=False))
    first = search.trial(("drive_gain",), {("drive_gain", "g"): 0.9})
    target.settle(first.values)
    return search, search.trial(("drive_gain",), first.values)


@pytest.mark.parametrize(("gain", "means_something"), [(0.85, True), (0.62, True), (0.5, False)])
def test_a_value_where_the_search_had_to_stop_means_nothing(gain: float, means_something: bool) -> None:
    """The gain is met from 0.7 to 1.2 and looked for a quarter of that range further, 0.575 to 1.325. A gain of 0.5
    is fitted there, and all else speaks for it: it explains most of the error, and its interval is far from 1."""
    search, found = fitted(driven(gain))
    name = ("drive_gain", "g")
    assert found.values[name] == pytest.approx(max(gain, 0.7 - 0.25 * (1.2 - 0.7)), abs=0.01)
    low, high = intervals(found.fit, search.starts)[name]
    assert low < high < 0.9
    assert is_certain(found.fit.coordinates[0], found.values[name], (low, high))
    assert search.trial((), {}).chi2 > 1.5 * found.chi2
    assert search.is_credible(found, "drive_gain") is means_something


@pytest.mark.parametrize(
    ("half_width", "certain"),
    [(0.0999 / 1.2, True), (0.1001 / 1.2, False), (0.0, False)],
    ids=["three standard deviations", "a little less", "nothing moves with it"],
)
def test_a_value_is_certain_three_standard_deviations_from_doing_nothing(half_width: float, certain: bool) -> None:
    """A gain of 0.9 is 0.1 off; its 95 % interval is 2.5 standard deviations wide on each side."""
    (key,) = find_effect("drive_gain").parameters
    assert is_certain(Coordinate("drive_gain", key), 0.9, (0.9 - half_width, 0.9 + half_width)) is certain


@pytest.mark.parametrize(("share", "certain"), [(0.3, True), (0.36, False)])
def test_a_limit_is_certain_to_a_third_of_its_range(share: float, certain: bool) -> None:
    """A limit that does nothing is infinite: no distance from it can be measured in standard deviations."""
    (key,) = find_effect("brake_limit").parameters
    limit = Coordinate("brake_limit", key)
    assert is_certain(limit, limit.value(0.5), (limit.value(0.5 - share / 2), limit.value(0.5 + share / 2))) is certain
