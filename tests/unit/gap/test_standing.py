"""Confirmed or provisional: each test that an effect has to pass, on logs whose truth shares nothing with the model."""

from __future__ import annotations

from functools import cache

import pytest

from pytest_dvp.gap.diagnose.diagnose import diagnose
from pytest_dvp.gap.diagnose.diagnosis import Diagnosis, NamedEffect
from pytest_dvp.gap.diagnose.input_scales import implausible_scales
from pytest_dvp.gap.extend.extend import extend
from pytest_dvp.logs.log import Log
from tests.truth.effects import Effects, TruthCar
from tests.truth.generate import make_log
from vehicle.model.command_inputs import Inputs
from vehicle.model.model_file import parse_model
from vehicle.model.vehicle_model import VehicleModel


def twin() -> VehicleModel:
    car = TruthCar()
    return parse_model(
        f"[parameters]\nwheelbase = {car.wheelbase}\ncg_to_front_axle = {car.cg_to_front_axle}\n"
        f"mass = {car.mass}\nyaw_inertia = {car.yaw_inertia}\n"
    )


@cache
def driven(name: str, key: str, value: float, more: tuple[tuple[str, float], ...] = ()) -> Diagnosis:
    effects: Effects = {name: {key: value, **dict(more)}}
    logs, held_out = ({f"{n}.csv": Log(make_log(effects, "rich", n, "low"))} for n in (3, 4))
    return diagnose(logs, twin(), held_out)


def only(found: Diagnosis) -> NamedEffect:
    (effect,) = found.effects
    return effect


def test_a_delay_that_both_engines_and_another_run_see_is_confirmed() -> None:
    effect = only(driven("steer_delay", "T", 0.2))
    assert (effect.name, effect.standing, effect.second_engine, effect.doubts) == (
        "steer_delay", "confirmed", "agrees", ()
    )  # fmt: skip
    assert effect.depends_on is None


@pytest.mark.nightly
def test_a_value_that_no_car_has_is_provisional() -> None:
    """The usual range of a lever arm ends at 2 m."""
    effect = only(driven("gnss_lever_arm", "x", 2.3, (("y", 0.0),)))
    assert effect.name == "gnss_lever_arm"
    assert effect.standing == "provisional"
    assert "outside what is usual" in effect.doubts[0]


@pytest.mark.nightly
def test_a_brake_that_fades_is_not_called_weak() -> None:
    """Cold brakes at the start, then a gain that falls by the heat in the disc."""
    found = driven("brake_fade", "k", 6e-4, (("tau", 120.0),))
    assert found.names == ("brake_fade",)
    (estimate, _) = only(found).parameters.values()
    assert estimate.value == pytest.approx(6e-4, rel=0.1)


@pytest.mark.nightly
def test_what_no_effect_of_the_catalogue_explains_leaves_no_confirmed_name() -> None:
    """A gust from the side every seven seconds: whatever fits some of that is not what the car has."""
    found = driven("cross_wind", "amplitude", 0.015, (("period", 7.0),))
    assert found.verdict in ("PARTIAL", "UNKNOWN")
    assert [e.name for e in found.effects if e.standing == "confirmed"] == []


@pytest.mark.nightly
def test_a_known_remainder_is_nothing_new_and_a_new_effect_stands_alone() -> None:
    """The twin was extended on a car with something that no effect explains; then that car gets a late steering."""
    odd: Effects = {"cross_wind": {"amplitude": 0.012, "period": 7.0}}
    late: Effects = {**odd, "steer_delay": {"T": 0.2}}
    learnt, judge, again, then = (
        {"log.csv": Log(make_log(effects, "rich", seed, "mid"))}
        for effects, seed in ((odd, 5), (odd, 6), (odd, 7), (late, 8))
    )
    matched = extend(learnt, twin(), refit=True, held_out=judge).model
    assert matched.effects == ()
    assert matched.remainder["yaw_rate"]
    nothing = diagnose(again, matched)
    assert (nothing.verdict, nothing.names) == ("NOTHING_MISSING", ())
    assert nothing.as_dict()["remainder"] == {c: dict(r) for c, r in matched.remainder.items()}
    assert diagnose(then, matched).names == ("steer_delay",)


@pytest.mark.parametrize(
    ("values", "told"),
    [({"full_throttle": 0.0}, 1), ({"full_brake": 44.0}, 1), ({"full_throttle": 3.0, "full_brake": 8.0}, 0),
     ({"steer_scale": 44.0}, 0)],
)  # fmt: skip
def test_pedal_scales_that_no_car_has_are_said(values: dict[str, float], told: int) -> None:
    assert len(implausible_scales(values, Inputs())) == told
