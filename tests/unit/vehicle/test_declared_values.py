"""What a car, its inputs and the paper's parameters are declared to be: ranges, defaults and what follows from them."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from vehicle.model.bus import GRAVITY
from vehicle.model.car import CAR_DECLARATIONS, make_car
from vehicle.model.command_inputs import INPUT_KEYS, Inputs, default_steer_scale
from vehicle.model.effect import DELAY_MEMORY, HISTORY_MEMORY, Key, Memory, effect
from vehicle.model.errors import ModelError
from vehicle.model.model_file import parse_model
from vehicle.model.simulator_parameters import S_PARAMETERS, apply_s, check_s, preset_s, s_value, scenario_parameters
from vehicle.model.wind import air_coefficients

# --- the car: lowest and highest value, unit, what is assumed where nothing is given

CAR: dict[str, tuple[float, float, str, float | None]] = {
    "wheelbase": (0.0, 20.0, "m", None),
    "cg_to_front_axle": (0.0, 20.0, "m", None),
    "cg_height": (0.0, 5.0, "m", 0.5),
    "mass": (0.0, 1e5, "kg", 1000.0),
    "command_mass": (0.0, 1e5, "kg", None),
    "yaw_inertia": (0.0, 1e7, "kg m^2", None),
    "cornering_stiffness_front": (0.0, 1e7, "N/rad", None),
    "cornering_stiffness_rear": (0.0, 1e7, "N/rad", None),
    "wheel_radius": (0.0, 2.0, "m", 0.3),
    "gear_ratio": (0.0, 100.0, "-", 1.0),
    "length": (0.0, 30.0, "m", 4.0),
    "width": (0.0, 5.0, "m", 1.8),
    "height": (0.0, 5.0, "m", 1.5),
    "center_x": (-10.0, 20.0, "m", None),
    "track": (0.0, 5.0, "m", 1.5),
    "ax_x": (-20.0, 20.0, "m", 0.0),
    "ay_x": (-20.0, 20.0, "m", 0.0),
    "max_speed": (0.0, 150.0, "m/s", 50.0),
}
POSITIVE = {"wheelbase", "mass", "wheel_radius", "gear_ratio", "length", "width", "height", "track", "max_speed"}


@pytest.mark.parametrize("name", sorted(CAR))
def test_a_parameter_of_the_car_has_its_range_and_default(name: str) -> None:
    low, high, unit, default = CAR[name]
    declared = next(d for d in CAR_DECLARATIONS if d.name == name)
    assert (declared.unit, declared.default) == (unit, default)
    assert declared.check(high) == high
    begins = f"more than {low:g}" if name in POSITIVE else f"{low:g}"
    wrong = [1.001 * high, low - 0.001, *([low] if name in POSITIVE else [])]
    for value in wrong:
        with pytest.raises(ModelError) as refused:
            declared.check(value)
        assert refused.value.allowed == f"{begins} to {high:g} {unit}"
    if name not in POSITIVE:
        assert declared.check(low) == low


def test_a_bare_car_follows_from_its_wheelbase() -> None:
    """1000 kg, its centre of gravity in the middle: inertia m a b, 12/rad of the load of each axle."""
    car = make_car({"wheelbase": 2.0})
    assert (car.cg_to_front_axle, car.cg_to_rear_axle, car.center_x, car.command_mass) == (1.0, 1.0, 1.0, 1000.0)
    assert car.yaw_inertia == pytest.approx(1000.0)
    each = 12.0 * 500.0 * GRAVITY
    assert (car.cornering_stiffness_front, car.cornering_stiffness_rear) == (pytest.approx(each), pytest.approx(each))


def test_a_car_whose_front_is_heavy_has_the_stiffer_front_axle() -> None:
    """Centre of gravity 0.5 m behind the front axle of 2 m: three quarters of 800 kg stand on it."""
    car = make_car({"wheelbase": 2.0, "cg_to_front_axle": 0.5, "mass": 800.0})
    assert car.yaw_inertia == pytest.approx(800.0 * 0.5 * 1.5)
    front, rear = 600.0 * GRAVITY, 200.0 * GRAVITY
    assert car.stiffness() == pytest.approx((12.0 * front, 12.0 * rear))
    assert car.stiffness(stiff=True) == pytest.approx((48.0 * front, 48.0 * rear))
    assert car.values()["mass"] == 800.0
    for given in ("cornering_stiffness_front", "cornering_stiffness_rear"):
        own = car.with_values({given: 5e4})
        assert own.stiffness(stiff=True) == own.stiffness()
        assert getattr(own, given) == 5e4


def test_what_follows_from_the_mass_follows_another_mass() -> None:
    """Middle between axles 2 m apart: half of the load on each, m a b about z. What a file states is kept."""
    heavy = make_car({"wheelbase": 2.0}).with_values({"mass": 1500.0})
    assert heavy == make_car({"wheelbase": 2.0, "mass": 1500.0, "command_mass": 1000.0})
    assert heavy.stiffness(stiff=True) == pytest.approx((48.0 * 750.0 * GRAVITY,) * 2)
    stated = {"yaw_inertia": 900.0, "cornering_stiffness_front": 5e4, "cornering_stiffness_rear": 6e4}
    own = make_car({"wheelbase": 2.0, **stated}).with_values({"mass": 1500.0})
    assert (own.yaw_inertia, own.stiffness(stiff=True)) == (900.0, (5e4, 6e4))


def test_what_follows_from_the_axles_follows_other_axles() -> None:
    """1000 kg, 2.5 m, centre of gravity 1 m behind the front axle: three fifths stand on it."""
    moved = make_car({"wheelbase": 2.0}).with_values({"wheelbase": 2.5})
    assert (moved.cg_to_front_axle, moved.yaw_inertia) == (1.0, pytest.approx(1500.0))
    assert moved.stiffness() == pytest.approx((12.0 * 600.0 * GRAVITY, 12.0 * 400.0 * GRAVITY))


@pytest.mark.parametrize("mass", [730.1, 900.0, 8500.0])
def test_a_mass_set_through_s_leaves_a_kinematic_car_its_stiff_axles(mass: float) -> None:
    bare = parse_model('[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.0\nmass = 730.0\n')
    heavy, _ = apply_s(bare, SimpleNamespace(), {"EGO_mass": mass})
    assert heavy.car.stiffness(stiff=True) == pytest.approx((48.0 * 0.5 * mass * GRAVITY,) * 2)


@pytest.mark.parametrize(("front", "good"), [(0.0, False), (1e-6, True), (2.0 - 1e-6, True), (2.0, False)])
def test_the_centre_of_gravity_lies_between_the_axles(front: float, good: bool) -> None:
    if good:
        assert make_car({"wheelbase": 2.0, "cg_to_front_axle": front}).cg_to_front_axle == front
        return
    with pytest.raises(ModelError) as refused:
        make_car({"wheelbase": 2.0, "cg_to_front_axle": front})
    assert refused.value.allowed == "more than 0 and less than the wheelbase 2 m"
    assert refused.value.found == f"{front:g}"


@pytest.mark.parametrize("name", ["yaw_inertia", "cornering_stiffness_front", "cornering_stiffness_rear",
                                  "command_mass"])  # fmt: skip
def test_what_has_a_default_of_its_own_must_still_be_more_than_nought(name: str) -> None:
    assert getattr(make_car({"wheelbase": 2.0, name: 0.5}), name) == 0.5
    with pytest.raises(ModelError) as refused:
        make_car({"wheelbase": 2.0, name: 0.0})
    assert (refused.value.key, refused.value.found) == (name, "0")


# --- the inputs: range, value that is assumed, least that matters, what is refused


INPUTS: dict[str, tuple[float, float, float, float, float, float]] = {
    "steer_scale": (0.02, 1.5, 1.0, 0.01, -math.inf, math.inf),
    "steer_zero": (-0.1, 0.1, 0.0, 0.002, -math.inf, math.inf),
    "full_throttle": (0.2, 15.0, 3.0, 0.05, 0.0, 50.0),
    "full_brake": (0.2, 15.0, 6.0, 0.05, 0.0, 50.0),
}


@pytest.mark.parametrize("name", sorted(INPUTS))
def test_a_scale_of_the_inputs_has_its_range(name: str) -> None:
    key = next(key for key in INPUT_KEYS if key.name == name)
    assert (key.low, key.high, key.neutral, key.least, key.minimum, key.maximum) == INPUTS[name]
    assert getattr(Inputs(), name) == key.neutral


def test_a_map_that_says_nothing_takes_angles_accelerations_and_usual_full_scales() -> None:
    nothing = Inputs()
    assert nothing.columns == ("steer_cmd", "accel_cmd")
    assert (nothing.full_current, nothing.full_pressure) == (100.0, 5e6)
    assert (default_steer_scale("steer_norm"), default_steer_scale("steer_cmd")) == (0.4, 1.0)


# --- the paper's parameters: lowest, highest, unit, the presets of its three iterations, where each goes

S: dict[str, tuple[float, float, str, tuple[float | None, float, float]]] = {
    "PEDESTRIAN_speed": (0.1, 5.0, "m/s", (3.0, 1.75, 1.75)),
    "EGO_mass": (300.0, 1e4, "kg", (1000.0, 4000.0, 8500.0)),
    "EGO_max_steer_angle": (5.0, 45.0, "deg", (25.0, 25.0, 20.0)),
    "EGO_dr_full_throttle": (0.0, 2.0, "N m s/rad", (0.15, 0.05, 0.05)),
    "EGO_dr_zero_throttle": (0.0, 2.0, "N m s/rad", (0.1, 0.5, 0.5)),
    "EGO_moi": (0.0, 5.0, "kg m^2", (1.0, 0.75, 0.75)),
    "THROTTLE_kp": (0.0, 5.0, "-", (0.5, 1.25, 1.25)),
    "THROTTLE_ki": (0.0, 5.0, "1/s", (0.025, 0.005, 0.005)),
    "THROTTLE_delay": (0.0, 1.0, "s", (None, 0.15, 0.15)),
    "BRAKE_kp": (0.0, 5.0, "-", (1.0, 0.09, 0.09)),
    "BRAKE_ki": (0.0, 5.0, "1/s", (0.0, 0.0005, 0.0005)),
    "GNSS_x": (-3.0, 3.0, "m", (-0.6, -0.6, -1.0)),
    "CAMERA_x": (-3.0, 3.0, "m", (0.375, 0.375, 0.4)),
}
EFFECT_OF = {
    "EGO_max_steer_angle": ("steer_angle_limit", "limit", math.pi / 180.0),
    "EGO_dr_full_throttle": ("motor_damping", "full", 1.0),
    "EGO_dr_zero_throttle": ("motor_damping", "zero", 1.0),
    "EGO_moi": ("motor_inertia", "J", 1.0),
    "THROTTLE_kp": ("accel_controller", "kp_drive", 1.0),
    "THROTTLE_ki": ("accel_controller", "ki_drive", 1.0),
    "THROTTLE_delay": ("drive_delay", "T", 1.0),
    "BRAKE_kp": ("accel_controller", "kp_brake", 1.0),
    "BRAKE_ki": ("accel_controller", "ki_brake", 1.0),
}
MODEL = parse_model("[parameters]\nwheelbase = 2.0\nmass = 500.0\nyaw_inertia = 400.0\ncenter_x = 1.5\n")


@pytest.mark.parametrize("name", sorted(S))
def test_a_parameter_of_the_paper_has_its_range_and_presets(name: str) -> None:
    low, high, unit, presets = S[name]
    assert check_s({name: low})[name] == low
    assert check_s({name: str(high)})[name] == high
    for value in (low - 0.001, high + 0.001):
        with pytest.raises(ModelError) as refused:
            check_s({name: value})
        assert refused.value.allowed == f"{low:g} to {high:g} {unit}"
    for iteration, preset in zip((1, 5, 10), presets, strict=True):
        assert preset_s(iteration).get(name) == preset  # type: ignore[arg-type]


@pytest.mark.parametrize(("iteration", "stage", "speed"), [
    (1, "dt", 3.0), (1, "pe", 1.75), (1, "rw", 1.75), (5, "dt", 1.75), (5, "rw", 1.75), (10, "pe", 1.75),
])  # fmt: skip
def test_only_the_first_twin_of_the_paper_met_a_running_pedestrian(iteration: Any, stage: Any, speed: float) -> None:
    assert preset_s(iteration, stage)["PEDESTRIAN_speed"] == speed
    assert scenario_parameters(preset_s(iteration, stage)) == {"pedestrian_speed": speed}


@pytest.mark.parametrize("name", sorted(EFFECT_OF))
def test_a_parameter_of_the_paper_sets_one_key_of_one_effect(name: str) -> None:
    effect_name, key, factor = EFFECT_OF[name]
    high = S[name][1]
    model, _ = apply_s(MODEL, SimpleNamespace(), {name: high})
    assert [a.name for a in model.effects] == [effect_name]
    assert model.value(effect_name, key) == pytest.approx(factor * high)
    assert s_value(model, name) == pytest.approx(high)
    assert s_value(MODEL, name) == (None if name == "EGO_max_steer_angle" else 0.0)


def test_a_heavier_car_has_as_much_more_yaw_inertia_and_sensors_move_from_the_middle() -> None:
    placed: dict[str, float] = {}

    class Mounts:
        def with_mount_x(self, sensor: str, x: float) -> Mounts:
            placed[sensor] = x
            return self

    model, _ = apply_s(MODEL, Mounts(), {"EGO_mass": 750.0, "GNSS_x": -0.6, "CAMERA_x": 0.4})
    assert (model.car.mass, model.car.yaw_inertia, model.car.command_mass) == (750.0, pytest.approx(600.0), 500.0)
    assert placed == {"gnss": pytest.approx(0.9), "camera": pytest.approx(1.9)}
    assert s_value(model, "EGO_mass") == 750.0
    assert [s_value(model, name) for name in ("GNSS_x", "CAMERA_x", "PEDESTRIAN_speed")] == [None] * 3
    with pytest.raises(ModelError, match="unknown parameter of S"):
        s_value(model, "EGO_mas")
    assert {p.name for p in S_PARAMETERS} == set(S)


# --- effects, and the wind


@pytest.mark.parametrize(
    ("low", "high", "neutral", "good"),
    [
        (1.0, 2.0, 1.0, True),
        (1.0, 1.0, 1.0, False),
        (2.0, 1.0, 1.0, False),
        (-math.inf, 1.0, 1.0, False),
        (1.0, math.inf, 1.0, False),
        (1.0, 2.0, math.nan, False),
        (1.0, 2.0, math.inf, True),
    ],
)
def test_an_effect_needs_a_finite_range_of_some_width_and_a_neutral_value(
    low: float, high: float, neutral: float, good: bool
) -> None:
    def declare() -> Any:
        return effect(
            name="odd",
            slot="force",
            physics="",
            equation="",
            source="",
            reveals="",
            parameters=(Key("k", "s", low, high, neutral, 0.1),),
        )(lambda x, p, m: None)

    if good:
        found = declare()
        assert (found.order, found.tyres, found.fine, found.delay, found.memory) == (50, False, False, "", ())
        assert found.base == ("kinematic_bicycle", "dynamic_bicycle")
        assert found.is_off({"k": neutral})
        assert not found.is_off({"k": 1.5})
        assert found.complete({}) == {"k": neutral}
    else:
        with pytest.raises(ModelError, match="range or neutral value is wrong"):
            declare()


@pytest.mark.parametrize(("step", "good"), [(0.0, True), (2.0, True), (2.001, False), (-0.1, False), (math.nan, False)])
def test_a_step_is_no_longer_than_the_range_in_which_it_is_taken(step: float, good: bool) -> None:
    def declare() -> Any:
        key = Key("k", "s", 1.0, 3.0, 1.0, 0.1, step=step)
        words = {"physics": "", "equation": "", "source": "", "reveals": ""}
        return effect(name="odd", slot="force", parameters=(key,), **words)(lambda x, p, m: None)  # type: ignore[arg-type]

    if good:
        assert declare().parameters[0].step == step
    else:
        with pytest.raises(ModelError, match=r"outside its range.*0 to 2 s"):
            declare()


def test_a_memory_is_one_number_and_a_line_holds_a_second_of_a_thousand_steps() -> None:
    assert (Memory("m").size, Memory("m").start) == (1, "")
    lines = {m.name: m.size for m in (*DELAY_MEMORY, *HISTORY_MEMORY)}
    assert {name for name, size in lines.items() if size == 1} == {"head", "tail"}
    assert {size for size in lines.values() if size > 1} == {1024}


@pytest.mark.parametrize(("drag", "along"), [("", 0.3 * 0.5 * 1.225 * 0.81 * 2.0 * 1.5 / 1200.0), ("0.004", 0.004)])
def test_the_wind_takes_hold_of_the_front_and_of_the_side(drag: str, along: float) -> None:
    """Half the density of air times 0.81 of width times height, over mass; c_d is 0.3, and 2.2/rad across."""
    text = "[parameters]\nwheelbase = 2.5\nwidth = 2.0\nheight = 1.5\nmass = 1500.0\ncommand_mass = 1200.0\n"
    own = f'[[effect]]\nname = "aero_drag"\nparameters = {{ k = {drag} }}\n' if drag else ""
    found = air_coefficients(parse_model(text + own))
    assert found == pytest.approx((along, 2.2 * 0.5 * 1.225 * 0.81 * 2.0 * 1.5 / 1200.0))
