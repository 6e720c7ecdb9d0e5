"""A model made ready to run, and what is said of a file that is none: each constant, bound and line of its own."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from vehicle.model.effect_catalogue import find_effect
from vehicle.model.errors import ModelError
from vehicle.model.kernel import ACCELERATION, DYNAMIC, IMPOSED, KINEMATIC, PEDALS, SPEED
from vehicle.model.kernel_layout import Layout, body_kind, bus_of, check_delay, input_mode
from vehicle.model.model_file import model_text, parse_model
from vehicle.model.open_loop import Replay
from vehicle.model.remainder_shape import RemainderShape, read_shape, shape_text

CAR = "[parameters]\nwheelbase = 2.5\n"
MODEL = parse_model(CAR)

# --- the record of a car


@pytest.mark.parametrize(
    ("longitudinal", "mode"),
    [
        (("accel_cmd",), ACCELERATION),
        (("throttle_cmd", "brake_cmd"), PEDALS),
        (("throttle_cmd", "brake_pressure"), PEDALS),
        (("throttle_cmd",), PEDALS),
        (("motor_current",), PEDALS),
        (("speed_cmd",), SPEED),
        (("v",), IMPOSED),
    ],
)
def test_columns_say_how_the_car_is_driven_along(longitudinal: tuple[str, ...], mode: int) -> None:
    assert input_mode(longitudinal) == mode


def test_a_car_has_tyres_if_its_base_or_an_effect_has() -> None:
    plain, relaxed = Layout([find_effect("steer_lag")]), Layout([find_effect("tyre_relaxation")])
    dynamic = dataclasses.replace(MODEL, base="dynamic_bicycle")
    assert [body_kind(MODEL, plain), body_kind(MODEL, relaxed), body_kind(dynamic, plain)] == [
        KINEMATIC, DYNAMIC, DYNAMIC,
    ]  # fmt: skip
    assert (plain.tyres, plain.swings, relaxed.tyres, relaxed.swings) == (False, False, True, True)
    assert not Layout([find_effect("understeer")]).swings  # tyres without a state of their own


@pytest.mark.parametrize(("wheelbase", "slow"), [(2.5, 1.0), (2.0, 1.0), (0.5, 0.5), (0.32, 0.4)])
def test_a_model_of_a_car_is_slow_by_the_root_of_its_size(wheelbase: float, slow: float) -> None:
    """Froude: speeds go with the root of lengths; 2 m count as whole."""
    (bus,) = bus_of(parse_model(f"[parameters]\nwheelbase = {wheelbase}\n"))
    assert bus["slow"] == pytest.approx(slow)


def test_the_record_holds_the_numbers_of_the_car() -> None:
    text = (
        "[inputs]\nfull_throttle = 2.5\nfull_brake = 7.5\n[parameters]\nwheelbase = 2.5\ncg_to_front_axle = 1.0\n"
        "mass = 1300.0\ncommand_mass = 1200.0\nyaw_inertia = 1500.0\ncg_height = 0.6\ntrack = 1.4\nax_x = 0.3\n"
        "ay_x = 0.7\nwheel_radius = 0.32\ngear_ratio = 8.0\ncornering_stiffness_front = 6e4\n"
        "cornering_stiffness_rear = 7e4\n"
    )
    (bus,) = bus_of(parse_model(text))
    told = {"wheelbase": 2.5, "cg_front": 1.0, "cg_rear": 1.5, "cg_height": 0.6, "track": 1.4, "ax_x": 0.3, "ay_x": 0.7,
            "mass": 1300.0, "mass_ref": 1200.0, "yaw_inertia": 1500.0, "stiffness_front": 6e4, "stiffness_rear": 7e4,
            "wheel_radius": 0.32, "gear_ratio": 8.0, "full_throttle": 2.5, "full_brake": 7.5, "steer_scale": 1.0,
            "steer_zero": 0.0, "t": 0.0}  # fmt: skip
    assert {name: float(bus[name]) for name in told} == told


@pytest.mark.parametrize(("steps", "fits"), [(1022.0, True), (1022.5, False)])
def test_a_dead_time_fits_into_1024_steps_less_two(steps: float, fits: bool) -> None:
    effect = find_effect("steer_delay")
    if fits:
        check_delay(effect, {"T": steps / 1024.0}, 1.0 / 1024.0)
        return
    with pytest.raises(ModelError) as refused:
        check_delay(effect, {"T": steps / 1024.0}, 1.0 / 1024.0)
    assert (refused.value.key, refused.value.allowed) == ("T", "up to 0.998047 s")
    check_delay(find_effect("steer_lag"), {"tau": 99.0}, 1e-3)  # a lag needs no line


def test_the_road_holds_side_forces_between_what_forms_and_what_takes_them() -> None:
    """An order of up to 60 forms them (understeer 10, tyre_saturation 60); body_roll (90) takes what is left."""
    names = ("body_roll", "steer_lag", "tyre_saturation", "gyro_bias", "understeer", "aero_drag", "steer_compliance")
    layout = Layout([find_effect(name) for name in names])
    called = [effect.name for effect in layout.effects]
    shapes, takes = layout.bounds[8:10], layout.bounds[10:12]
    assert called[shapes[0] : shapes[1]] == ["understeer", "tyre_saturation"]
    assert called[takes[0] : takes[1]] == ["steer_compliance", "body_roll"]


def test_effects_are_called_by_slot_order_and_name_and_keep_their_places() -> None:
    names = ("gnss_latency", "steer_ratio", "detection_yaw", "brake_fade", "brake_lag", "steer_offset")
    layout = Layout([find_effect(name) for name in names])
    called = [effect.name for effect in layout.effects]
    assert "detection_yaw" not in called
    assert called.index("steer_offset") < called.index("brake_lag") < called.index("brake_fade")
    assert called[-1] == "gnss_latency"
    assert layout.bounds[:8].tolist() == [0, 2, 4, 4, 4, 4, 5, 5]
    assert len(layout.places) == layout.parameters({}).size == layout.table[-1, 1] + 1
    given = layout.parameters({"brake_fade": {"k": 0.01}})
    assert given[layout.places["brake_fade", "k"]] == 0.01
    assert given[layout.places["brake_fade", "tau"]] == 120.0  # its neutral value
    assert given[layout.places["steer_ratio", "g"]] == 1.0
    assert layout.table[0, 2] == 0


# --- stamps and steps of a replay

T = 0.02 * np.arange(5.0)
COMMANDS = {"steer_cmd": np.zeros(5), "accel_cmd": np.zeros(5)}


@pytest.mark.parametrize("t", [T[:1], np.r_[T[:4], T[3]], np.r_[T[:4], 0.0], np.r_[T[:4], np.nan], T[None, :]])
def test_stamps_are_finite_and_increase(t: Any) -> None:
    with pytest.raises(ModelError, match="stamps must be finite and increase, at least two"):
        Replay(MODEL, t, COMMANDS)


@pytest.mark.parametrize(("starts", "good"), [([0, 3], True), ([0, 3, 3], False), ([3, 0], False)])
def test_rows_in_which_a_motion_begins_anew_increase(starts: list[int], good: bool) -> None:
    replay, states = Replay(MODEL, T, COMMANDS), np.zeros((len(starts), 6))
    if good:
        assert np.asarray(replay.run(starts=np.array(starts), states=states)).shape[0] == 5
    else:
        with pytest.raises(ModelError, match="starts must increase"):
            replay.run(starts=np.array(starts), states=states)


@pytest.mark.parametrize("given", range(6))
def test_where_a_motion_begins_anew_what_is_not_known_runs_on(given: int) -> None:
    """The car stood at the origin; of x, y, yaw, speed, sideways speed and yaw rate one is known."""
    states = np.full((2, 6), math.nan)
    states[0], states[1, given] = 0.0, 0.5
    shown = np.asarray(Replay(MODEL, T, COMMANDS).run(starts=np.array([0, 3]), states=states))
    assert shown[2, :4].tolist() == [0.0] * 4
    assert shown[3, :4].tolist() == [0.5 if k == given else 0.0 for k in range(4)]


@pytest.mark.parametrize("gain", [1.0, 0.5])
def test_effects_on_the_command_act_in_each_step(gain: float) -> None:
    """From rest with a share of 2 m/s^2: v = a t."""
    model = parse_model(CAR).with_effect("drive_gain", {"g": gain})
    shown = np.asarray(Replay(model, T, {**COMMANDS, "accel_cmd": np.full(5, 2.0)}).run())
    assert shown[:, 3] == pytest.approx(2.0 * gain * T)


@pytest.mark.parametrize(
    ("pause", "step", "good"),
    [(101.0, None, False), (99.0, None, True), (99.0, 0.0098, False), (99.0, 0.01, True), (1.0, 0.0, False),
     (1.0, -1.0, False)],
)  # fmt: skip
def test_a_pause_has_ten_thousand_pieces_at_most(pause: float, step: float | None, good: bool) -> None:
    """The finer of both steps counts, 10 ms."""
    t = np.r_[T[:4], T[3] + pause]
    if good:
        assert Replay(MODEL, t, COMMANDS, step=step)._shortest == pytest.approx(step or 0.01)
    else:
        with pytest.raises(ModelError, match="step does not suit the stamps"):
            Replay(MODEL, t, COMMANDS, step=step)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({("parameters", "mas"): 1.0}, "no such value of parameters"),
        ({("inputs", "full_break"): 1.0}, "did you mean 'full_brake'"),
        ({("steer_lag", "tua"): 1.0}, "did you mean 'tau'"),
        ({("steer_lag", "tau"): -1.0}, "value not allowed"),
    ],
)
def test_values_that_are_none_are_refused(values: Any, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        Replay(MODEL, T, COMMANDS)._split(values)


def test_values_are_those_of_the_model_unless_others_are_given_and_neutral_ones_are_left_out() -> None:
    model = MODEL.with_effect("steer_lag", {"tau": 0.2}).with_effect("steer_ratio", {"g": 0.9})
    replay = Replay(model, T, COMMANDS)
    assert replay._split({})[0] == {"steer_lag": {"tau": 0.2}, "steer_ratio": {"g": 0.9}}
    active, constants = replay._split({("steer_ratio", "g"): 1.0, ("parameters", "mass"): 900.0,
                                       ("inputs", "full_brake"): 5.0})  # fmt: skip
    assert active == {"steer_lag": {"tau": 0.2}}
    assert constants == {"mass": 900.0, "full_brake": 5.0}


# --- what is said of a file


@pytest.mark.parametrize(
    ("text", "line", "key", "found"),
    [
        ("[modle]\n", 1, "modle", "modle"),
        ("[model]\nbase = 'bicycle'\n", 2, "model.base", "'bicycle'"),
        ("[model]\n\nname = 3\n", 3, "model.name", "3"),
        ("[model]\nnmae = 'a'\n", 2, "model.nmae", "nmae"),
        ("model = 3\n", 1, "model", ""),
        ("[inputs]\nsteer = 3\n", 2, "inputs.steer", "3"),
        ("[inputs]\nsteer = ' '\n", 2, "inputs.steer", "' '"),
        ("[inputs]\nlongitudinal = 'pedal'\n", 2, "inputs.longitudinal", "'pedal'"),
        ("[inputs]\nfull_brake = true\n", 2, "inputs.full_brake", "True"),
        ("[inputs]\nfull_brake = 50.5\n", 2, "inputs.full_brake", "50.5"),
        ("[parameters]\nwheelbase = 2.5\nmas = 3.0\n", 3, "parameters.mas", "mas"),
        ("[parameters]\nwheelbase = 2.5\nmass = 'x'\n", 3, "mass", "'x'"),
        ("[parameters]\nmass = 3.0\n", 1, "parameters.wheelbase", ""),
        (f"{CAR}[effect]\nname = 'mass'\n", 3, "effect", ""),
        (f"{CAR}[[effect]]\nnmae = 'mass'\n", 4, "effect.nmae", "nmae"),
        (f"{CAR}[[effect]]\nfitted_on = []\n", 3, "effect.name", ""),
        (f"{CAR}[[effect]]\nname = 'mas'\n", 4, "effect.name", "mas"),
        (f"{CAR}[[effect]]\nname = 'mass'\n[[effect]]\nname = 'mass'\n", 6, "effect.name", "mass"),
        (f"{CAR}[[effect]]\nname = 'mass'\nparameters = 3\n", 5, "mass", ""),
        (f"{CAR}[[effect]]\nname = 'mass'\nfitted_on = 'a'\n", 5, "mass.fitted_on", ""),
        (f"{CAR}[[effect]]\nname = 'mass'\nfitted_on = [3]\n", 5, "mass.fitted_on", ""),
        (f"{CAR}[[effect]]\nname = 'mass'\n[effect.parameters.ratio]\nunit = '-'\n", 5, "mass.ratio", ""),
        (f"{CAR}[[effect]]\nname = 'mass'\n[effect.parameters.ratio]\nvalue = 1.1\nunit = 'kg'\n", 5, "mass.ratio",
         "'kg'"),
        (f"{CAR}[[effect]]\nname = 'mass'\n[effect.parameters.ratio]\nvalue = 1.1\nlow = 1.2\n", 5, "mass.ratio",
         "1.1"),
        (f"{CAR}[[effect]]\nname = 'mass'\n[effect.parameters.ratio]\nvalue = 1.1\nhigh = 1.0\n", 5, "mass.ratio",
         "1.1"),
        (f"{CAR}[remainder]\nvv = {{ cruise = 0.1 }}\n", 4, "remainder.vv", "vv"),
        (f"{CAR}[remainder.memory]\nvv = 0.1\n", None, "remainder.memory.vv", "vv"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_with_its_line_and_key(text: str, line: int | None, key: str, found: str) -> None:
    with pytest.raises(ModelError) as refused:
        parse_model(text, "car.toml")
    error = refused.value
    assert (error.file, error.key, error.found) == ("car.toml", key, found)
    if line is not None:
        assert error.line == line


@pytest.mark.parametrize(("low", "high", "good"), [(1.1, 1.1, True), (1.0, 1.2, True), (1.11, 1.2, False),
                                                   (1.0, 1.09, False)])  # fmt: skip
def test_a_value_lies_within_its_interval(low: float, high: float, good: bool) -> None:
    text = f"{CAR}[[effect]]\nname = 'mass'\nparameters.ratio = {{ value = 1.1, low = {low}, high = {high} }}\n"
    if good:
        (applied,) = parse_model(text).effects
        assert (applied.intervals["ratio"].low, applied.intervals["ratio"].high) == (low, high)
    else:
        with pytest.raises(ModelError, match="value outside its interval"):
            parse_model(text)


def test_one_end_of_an_interval_alone_ends_at_the_value() -> None:
    (applied,) = parse_model(
        f"{CAR}[[effect]]\nname = 'mass'\nparameters.ratio = {{ value = 1.1, low = 1.0 }}\n"
    ).effects
    assert (applied.intervals["ratio"].low, applied.intervals["ratio"].high) == (1.0, 1.1)


def test_a_model_that_was_read_is_written_as_it_was_stated() -> None:
    text = '[model]\nbase = "kinematic_bicycle"\nname = "a \\"car\\""\n\n[inputs]\nsteer = "steer_norm"\n' \
           'longitudinal = "throttle_cmd + brake_cmd"\nfull_brake = 5.0  # m/s^2\n\n[parameters]\n' \
           "wheelbase = 2.5  # m\nmass = 900.0  # kg\n"  # fmt: skip
    model = parse_model(text)
    assert model_text(model) == text
    assert model.inputs.steer_scale == 0.4
    whole = model_text(dataclasses.replace(model, given=None))
    assert "full_throttle = 3.0  # m/s^2" in whole
    assert "steer_scale" not in whole
    assert "yaw_inertia = 1406.25  # kg m^2" in whole  # 900 x 1.25^2


# --- how a remainder repeats itself


def test_the_shape_of_a_remainder_is_written_and_read_again() -> None:
    shape = RemainderShape({"v": 0.16}, {"drive_gain": {"g": 0.0052}})
    text = shape_text(shape)
    assert text == "[remainder.memory]\nv = 0.16  # s\n[remainder.imitates]\ndrive_gain.g = 0.0052\n"
    assert read_shape({"memory": {"v": 0.16}, "imitates": {"drive_gain": {"g": 0.0052}}}) == shape
    more = RemainderShape(anew={"ax": 2.2}, limits={"jerk_limit": {"limit": 13.0}})
    text = shape_text(more)
    assert text == "[remainder.anew]\nax = 2.2  # chi^2/N\n[remainder.limits]\njerk_limit.limit = 13.0\n"
    assert read_shape({"anew": {"ax": 2.2}, "limits": {"jerk_limit": {"limit": 13.0}}}) == more
    unseen = RemainderShape(unseen={"power_limit": {"limit": 17.2}})
    assert shape_text(unseen) == "[remainder.unseen]\npower_limit.limit = 17.2\n"
    assert read_shape({"unseen": {"power_limit": {"limit": 17.2}}}) == unseen
    agree = RemainderShape(
        wanders={"along": {"cruise": 0.1}, "yaw": {"braking": 0.002}}, sensors={"gyro_bias": {"b": 0.001}}
    )
    text = "[remainder.wanders]\nalong.cruise = 0.1  # m\nyaw.braking = 0.002  # rad\n"
    assert shape_text(agree) == f"[remainder.sensors]\ngyro_bias.b = 0.001\n{text}"
    assert read_shape({"wanders": agree.wanders, "sensors": {"gyro_bias": {"b": 0.001}}}) == agree
    for slopes in (0.0, 0.06, 5.0):
        road = RemainderShape(slopes=slopes)
        assert shape_text(road) == f"[remainder.road]\nslopes = {slopes}  # m/s^2\n"
        assert read_shape({"road": {"slopes": slopes}}) == road
    assert shape_text(RemainderShape()) == ""
    assert read_shape({}) == RemainderShape()
    assert read_shape({"imitates": {"drive_gain": {"g": 0}}}).imitates == {"drive_gain": {"g": 0.0}}


@pytest.mark.parametrize(
    ("table", "key", "says"),
    [
        ({"memory": 3}, "memory", "must be a table"),
        ({"memory": {"v": 0.0}}, "memory.v", "allowed: more than 0 s"),
        ({"memory": {"v": -1.0}}, "memory.v", "allowed: 0 or more"),
        ({"anew": {"v": 0.0}}, "anew.v", r"allowed: more than 0 chi\^2/N"),
        ({"limits": {"jerk_limit": {"limit": 0}}}, "limits.jerk_limit.limit", "found 0; allowed: more than 0"),
        ({"wanders": 3}, "wanders", "must be a table"),
        ({"wanders": {"acros": {"cruise": 0.1}}}, "wanders.acros", "unknown direction .* did you mean 'across'"),
        ({"wanders": {"yaw": {"cruse": 0.1}}}, "wanders.yaw.cruse", "did you mean 'cruise'"),
        ({"wanders": {"yaw": {"cruise": -0.1}}}, "wanders.yaw.cruise", "allowed: 0 rad or more"),
        ({"unseen": {"power_limit": {"limit": 0}}}, "unseen.power_limit.limit", "found 0; allowed: more than 0"),
        ({"road": {"slopes": 5.1}}, "road.slopes", r"found 5.1; allowed: 0 to 5 m/s\^2"),
        ({"road": {"slopes": -0.1}}, "road.slopes", "allowed: 0 or more"),
        ({"road": {"slope": 0.1}}, "road.slope", "unknown key.* did you mean 'slopes'"),
        ({"limits": {"jerk_limit": 3}}, "limits.jerk_limit", "must be a table of the effect's keys"),
        ({"memory": {"v": math.inf}}, "memory.v", "allowed: 0 or more"),
        ({"memory": {"v": True}}, "memory.v", "must be a number"),
        ({"memory": {"w": 1.0}}, "memory.w", "unknown channel"),
        ({"imitates": {"mass": 3}}, "imitates.mass", "must be a table of the effect's keys"),
        ({"imitates": {"mass": {"ratio": "x"}}}, "imitates.mass.ratio", "must be a number"),
        ({"imitates": {"drive_gian": {"g": 1.0}}}, "imitates.drive_gian", "unknown effect.* did you mean 'drive_gain'"),
        ({"unseen": {"jerk_limit": {"limits": 1.0}}}, "unseen.jerk_limit.limits", "unknown key.* did you mean 'limit'"),
    ],
)
def test_a_wrong_shape_is_told_by_its_path(table: Any, key: str, says: str) -> None:
    with pytest.raises(ModelError, match=says) as refused:
        read_shape(table)
    assert refused.value.key == key


@pytest.mark.parametrize("name", ["brake_lag_of_our_trailer", "brake_lag2", "my_brake_gain", "xmass"])
def test_an_effect_of_others_that_is_not_loaded_stays_in_the_tables_of_a_twin(name: str) -> None:
    assert read_shape({"imitates": {name: {"t": 0.1}}}).imitates == {name: {"t": 0.1}}


@pytest.mark.parametrize("name", ["brake_gan", "brake_gaain", "brake_gaim", "brake_gian", "Brake_Gain", "ptich"])
def test_a_name_with_one_slip_is_refused(name: str) -> None:
    with pytest.raises(ModelError, match="unknown effect"):
        read_shape({"imitates": {name: {"g": 0.1}}})
