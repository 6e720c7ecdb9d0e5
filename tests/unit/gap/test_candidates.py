"""Which effects are tried on a model, and from where."""

from __future__ import annotations

import dataclasses
import itertools
from math import isinf, pi

import pytest
from gap_logs import baseline

from pytest_dvp.gap.diagnose.candidates import Candidate, candidates, is_worth_naming, sizes
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import parse_model
from vehicle.model.vehicle_model import VehicleModel

CAR = "[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.2\nmass = 1200.0\n"


def tried(model: VehicleModel | None = None, *, ay: bool = False) -> dict[str, Candidate]:
    return {c.name: c for c in candidates(model or baseline(), catalogue().values(), ay=ay)}


def test_effects_of_the_perception_are_not_for_a_replay() -> None:
    assert not [c.name for c in tried().values() if c.effect.slot == "perception"]


def test_effects_of_the_plain_catalogue_are_all_tried() -> None:
    assert {
        "drive_gain",
        "brake_limit",
        "road_grade",
        "steer_delay",
        "understeer",
        "gyro_bias",
        "gnss_lever_arm",
    } <= set(tried())


def test_a_controller_of_speed_is_tried_only_where_a_speed_is_commanded() -> None:
    by_speed = parse_model(f"[model]\nname = 'car'\n[inputs]\nlongitudinal = 'speed_cmd'\n{CAR}")
    assert "speed_controller" not in tried()
    assert "speed_controller" in tried(by_speed)


def test_a_ceiling_of_speed_is_tried_only_where_a_speed_is_commanded() -> None:
    by_speed = parse_model(f"[model]\nname = 'car'\n[inputs]\nlongitudinal = 'speed_cmd'\n{CAR}")
    assert "speed_limit" not in tried()
    assert "speed_limit" in tried(by_speed)


def test_what_refines_a_constant_effect_is_tried_only_if_it_is_asked_for_or_in_the_model() -> None:
    refined = {"brake_fade", "road_profile", "steer_assist"}
    assert {e.name for e in catalogue().values() if e.diagnosed.refines} == refined
    assert not refined & set(tried())
    asked = {c.name for c in candidates(baseline(), catalogue().values(), refined=True)}
    assert asked == set(tried()) | refined
    has_one = baseline().with_effect("brake_fade", {"k": 0.002})
    assert refined & set(tried(has_one)) == {"brake_fade"}


def test_the_direction_of_a_wind_stays_as_the_model_has_it() -> None:
    """Without it the wind is always ahead, which no value of the key means: a search must not put one in its place."""
    wind = tried()["headwind"]
    assert [c.key.name for c in wind.coordinates] == ["speed", "k"]
    assert not any(("headwind", "heading") in point for point in (*wind.points, *wind.coarse))


def test_parts_of_a_drive_train_are_tried_only_where_the_model_has_one() -> None:
    effect = "[[effect]]\nname = 'motor_inertia'\nparameters = {J = 0.05}\n"
    has_one = parse_model(f"[model]\nname = 'car'\n{CAR}{effect}")
    assert not {"motor_torque", "motor_damping", "motor_inertia"} & set(tried())
    assert {"motor_torque", "motor_damping", "motor_inertia"} <= set(tried(has_one))


@pytest.mark.parametrize("name", sorted(tried()))
def test_points_give_every_key_a_value_that_does_something_and_stays_in_its_range(name: str) -> None:
    candidate = tried()[name]
    for point in (*candidate.points, *candidate.coarse):
        keys = [key for key in candidate.effect.parameters if key.name not in candidate.effect.diagnosed.held]
        assert set(point) == {(name, key.name) for key in keys}
        for key in keys:
            value = point[name, key.name]
            if key.name != "heading":
                assert key.low - 1e-12 <= value <= key.high + 1e-12
        # none of the points is the effect switched off
        assert any(point[name, key.name] != key.neutral for key in keys)
    assert len(candidate.coarse) <= len(candidate.points)


def test_a_key_comes_late_by_its_declaration_and_not_by_its_name() -> None:
    """A user's effect may call what matters `lag`: its grid begins with it, and it says how much."""
    gain = catalogue()["drive_gain"]
    for late in (False, True):
        key = Key("lag", "s", 0.0, 0.5, neutral=0.0, least=0.03, late=late)
        mine = dataclasses.replace(gain, name="mine", parameters=(*gain.parameters, key))
        (found,) = candidates(baseline(), [mine])
        values = {point["mine", "lag"] for point in found.points}
        assert (values == {0.0}) is late
        assert [c.key.name for c in sizes(found.coordinates)] == (["g"] if late else ["g", "lag"])


@pytest.mark.parametrize("name", ["brake_limit", "steer_rate_limit", "steer_lag", "steer_delay", "rolling_resistance"])
def test_the_strongest_point_comes_first(name: str) -> None:
    (key,) = catalogue()[name].parameters
    values = [point[name, key.name] for point in tried()[name].points]
    strongest_first = sorted(values, reverse=not isinf(key.neutral))  # a limit is the stronger the lower
    assert values == strongest_first
    assert values[0] == pytest.approx(key.low if isinf(key.neutral) else key.high)


def test_both_sides_of_a_neutral_value_within_the_range_are_tried() -> None:
    values = {point["steer_ratio", "g"] for point in tried()["steer_ratio"].points}
    assert min(values) < 1.0 < max(values)
    assert 1.0 not in values


def test_a_slope_is_tried_up_and_down_along_headings_half_the_way_round() -> None:
    points = tried()["road_grade"].points
    slopes = {point["road_grade", "slope"] for point in points}
    headings = sorted({point["road_grade", "heading"] for point in points})
    assert min(slopes) < 0.0 < max(slopes)
    steps = [b - a for a, b in itertools.pairwise(headings)] + [headings[0] + pi - headings[-1]]
    assert steps == pytest.approx([pi / len(headings)] * len(headings))


def test_a_weaker_point_is_nearer_to_neutral_and_a_limit_has_none() -> None:
    ratio = tried()["steer_ratio"]
    assert ratio.weaker({("steer_ratio", "g"): 1.2}, 0.25) == [{("steer_ratio", "g"): pytest.approx(1.05)}]
    limit = tried()["brake_limit"]
    assert limit.weaker({("brake_limit", "limit"): 2.0}, 0.25) == []


def having(**effects: dict[str, float]) -> VehicleModel:
    model = baseline()
    for name, values in effects.items():
        model = model.with_effect(name, values)
    return model


def test_what_a_model_has_is_changed_from_there() -> None:
    """A quarter of the way from 0.9 to 1.2, from a limit of 6 to one of 2, from a lag of 0.13 s to one of 0.33 s."""
    model = having(steer_ratio={"g": 0.9}, brake_limit={"limit": 6.0}, drive_lag={"tau": 0.13, "brakes": 0.3})
    ratio, limit, lag = (tried(model)[name] for name in ("steer_ratio", "brake_limit", "drive_lag"))
    assert ratio.weaker({("steer_ratio", "g"): 1.2}, 0.25) == [{("steer_ratio", "g"): pytest.approx(0.975)}]
    assert limit.weaker({("brake_limit", "limit"): 2.0}, 0.25) == [{("brake_limit", "limit"): pytest.approx(5.0)}]
    (less,) = lag.weaker({("drive_lag", "tau"): 0.33, ("drive_lag", "brakes"): 0.3}, 0.25)
    assert less == {("drive_lag", "tau"): pytest.approx(0.18), ("drive_lag", "brakes"): pytest.approx(0.3)}
    assert tried(having(brake_limit={}))["brake_limit"].weaker({("brake_limit", "limit"): 2.0}, 0.25) == []


def test_what_only_a_fit_finds_of_what_a_model_has_begins_as_it_is() -> None:
    """A lag that acts on a third of the braking: with one that acts on all of it, no other lag does better."""
    had = tried(having(drive_lag={"tau": 0.13, "brakes": 0.3}))["drive_lag"]
    for points in (had.points, had.coarse):
        assert {point["drive_lag", "brakes"] for point in points} == {0.3}
        assert len({point["drive_lag", "tau"] for point in points}) > 1
    assert {point["drive_lag", "brakes"] for point in tried()["drive_lag"].points} == {1.0}


def test_how_an_effect_acts_does_not_weaken_with_how_much() -> None:
    (point,) = tried()["road_grade"].weaker({("road_grade", "slope"): 0.04, ("road_grade", "heading"): 1.0}, 0.5)
    assert point == {("road_grade", "slope"): pytest.approx(0.02), ("road_grade", "heading"): 1.0}


def test_lateral_acceleration_of_a_car_that_slips_may_be_that_of_either_place() -> None:
    """Rear axle or centre of gravity, 1.3 m ahead of it: a log seldom says which."""
    place = ("parameters", "ay_x")
    assert sorted({point[place] for point in tried(ay=True)["understeer"].points}) == pytest.approx([0.0, 1.3])
    assert not any(place in point for point in tried(ay=True)["steer_delay"].points)
    assert not any(place in point for point in tried(ay=False)["understeer"].points)
    named = parse_model(f"[model]\nname = 'car'\n{CAR}ay_x = 0.9\n")
    assert not any(place in point for point in tried(named, ay=True)["understeer"].points)


def test_a_value_is_worth_naming_from_its_least_size_on() -> None:
    key = Key("g", "-", 0.7, 1.3, neutral=1.0, least=0.01)
    assert is_worth_naming(key, 0.99)
    assert is_worth_naming(key, 1.02)
    assert not is_worth_naming(key, 1.005)
    assert is_worth_naming(Key("offset", "-", -1.0, 1.0, neutral=0.0, least=0.25), -0.25)
    assert is_worth_naming(Key("limit", "-", 1.0, 9.0, neutral=float("inf"), least=0.1), 8.0)


def test_a_parameter_is_held_where_a_fitted_scale_of_the_input_does_the_same() -> None:
    """A command from -1 to 1 has a scale of its own: it and both sides could be larger by the same factor."""
    effect = catalogue()["steer_asymmetry"]
    names = {}
    for signal in ("steer_cmd", "steer_cmd_norm"):
        text = f'[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.5\n[inputs]\nsteer = "{signal}"\n'
        (found,) = candidates(parse_model(text), [effect])
        names[signal] = [c.key.name for c in found.coordinates]
    assert names == {"steer_cmd": ["g_left", "g_right"], "steer_cmd_norm": ["g_right"]}
