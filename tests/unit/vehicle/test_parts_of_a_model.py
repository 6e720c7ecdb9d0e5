"""Parts of a vehicle model by themselves: ranges, errors, data sheet, inputs, lines of a file, what hides what."""

from __future__ import annotations

import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vehicle.model import simulator_parameters, wrapped_model
from vehicle.model.car import make_car
from vehicle.model.command_inputs import Inputs, command_table, default_steer_scale
from vehicle.model.declared_parameter import Declaration
from vehicle.model.effect import Key
from vehicle.model.effect_catalogue import effects_of_file
from vehicle.model.effects.detection_range import detection_range
from vehicle.model.errors import ModelError, is_misspelt, nearest_name
from vehicle.model.model_file import _Lines, parse_model
from vehicle.model.model_file_edit import edited_text
from vehicle.model.occlusion import hidden_share
from vehicle.model.open_loop import LONGEST_STEP, LONGEST_SWING_STEP
from vehicle.model.perception_effects import Tracks
from vehicle.model.plant import Plant
from vehicle.model.vehicle_model import VehicleModel

# --- ranges and errors


@pytest.mark.parametrize(
    ("positive", "good", "bad"),
    [
        (False, (0.0, 2.5, 5.0), (-0.1, 5.1, math.nan, math.inf)),
        (True, (1e-9, 5.0), (0.0, -0.1, 5.1, math.inf, -math.inf)),
    ],
)
def test_a_declared_range_includes_its_ends(positive: bool, good: tuple[float, ...], bad: tuple[float, ...]) -> None:
    declared = Declaration("mass", "kg", 0.0, 5.0, "of the car", positive=positive)
    assert [declared.check(value) for value in good] == list(good)
    for value in bad:
        with pytest.raises(ModelError, match=r"allowed: (more than )?0 to 5 kg") as error:
            declared.check(value)
        assert ("more than" in str(error.value)) == positive


def test_a_positive_range_that_begins_above_nought_includes_its_end() -> None:
    declared = Declaration("mass", "kg", 2.0, 5.0, "of the car", positive=True)
    assert declared.check(2.0) == 2.0
    with pytest.raises(ModelError, match="allowed: 2 to 5 kg"):
        declared.check(1.9)


def test_a_range_without_a_sign_may_begin_at_nought() -> None:
    with pytest.raises(ModelError, match="allowed: 0 to 5 kg"):
        Declaration("mass", "kg", 0.0, 5.0, "of the car").check(-1.0)


@pytest.mark.parametrize(
    ("minimum", "maximum", "allowed", "good", "bad"),
    [(-math.inf, math.inf, "any", -9.0, math.nan), (-math.inf, 2.0, "up to 2", 2.0, 2.1),
     (1.0, math.inf, "1 or more", 1.0, 0.9), (1.0, 2.0, "1 to 2", 2.0, 2.1)],
)  # fmt: skip
def test_a_key_says_what_it_accepts(minimum: float, maximum: float, allowed: str, good: float, bad: float) -> None:
    key = Key("k", "s", 0.0, 3.0, neutral=7.0, least=0.1, minimum=minimum, maximum=maximum)
    assert key.allowed == allowed
    assert (key.check(good), key.check(7.0)) == (good, 7.0)
    with pytest.raises(ModelError, match="value not allowed"):
        key.check(bad)


@pytest.mark.parametrize(
    ("more", "text"),
    [
        ({}, "wrong"),
        ({"file": "m.toml"}, "m.toml: wrong"),
        ({"file": "m.toml", "line": 3}, "m.toml:3: wrong"),
        ({"line": 3}, "wrong"),
        ({"key": "T"}, "T: wrong"),
        ({"found": "7"}, "wrong (found 7)"),
        ({"allowed": "1 to 2"}, "wrong (allowed: 1 to 2)"),
        (
            {"found": "7", "allowed": "1 to 2", "nearest": "tau"},
            "wrong (found 7; allowed: 1 to 2); did you mean 'tau'?",
        ),
    ],
)
def test_an_error_is_one_line_of_what_is_known(more: dict[str, Any], text: str) -> None:
    assert str(ModelError("wrong", **more)) == text
    placed = ModelError("wrong", **more).at("other.toml", 9)
    assert str(placed).startswith("other.toml:9: ")
    assert (placed.key, placed.found, placed.allowed, placed.nearest) == tuple(
        more.get(name, "") for name in ("key", "found", "allowed", "nearest")
    )
    assert ModelError("wrong", **more).at("o", 1, "K").key == "K"


def test_the_nearest_name_looks_at_no_case() -> None:
    assert nearest_name("STEER_LAG", ["steer_lag", "steer_delay"]) == "steer_lag"
    assert nearest_name("xyz", ["steer_lag"]) == ""


@pytest.mark.parametrize(
    ("name", "misspelt"),
    [
        ("brake_lag", True), ("Brake_LAG", True),
        ("rake_lag", True), ("brake_la", True), ("brakelag", True),  # a letter left out: the first, the last, another
        ("brrake_lag", True), ("brake_laag", True),  # one put in
        ("xbrake_lag", False), ("brake_lag2", False),  # before or behind it: a name of its own
        ("xrake_lag", True), ("brake_lax", True), ("bruke_lag", True),  # one exchanged
        ("xrake_lax", False), ("bxxke_lag", False),  # two are no slip
        ("rbake_lag", True), ("brake_lga", True), ("brkae_lag", True),  # neighbours
        ("krabe_lag", False), ("brabe_kag", False),  # no neighbours
        ("brae_lg", False), ("brraake_lag", False), ("", False),
    ],
)  # fmt: skip
def test_one_slip_misspells_a_name(name: str, misspelt: bool) -> None:
    assert is_misspelt(name, "brake_lag") is misspelt


# --- data sheet

CAR = {"wheelbase": 2.5, "cg_to_front_axle": 1.2, "mass": 1000.0, "yaw_inertia": 1300.0, "wheel_radius": 0.3,
       "gear_ratio": 6.0, "cornering_stiffness_front": 5e4, "cornering_stiffness_rear": 6e4}  # fmt: skip


def sheet(**effects: dict[str, float]) -> Any:
    found = VehicleModel("kinematic_bicycle", Inputs(full_throttle=3.0, full_brake=6.0), make_car(CAR))
    for name, values in effects.items():
        found = found.with_effect(name, values)
    return found.description()


def test_a_data_sheet_of_a_bare_car_has_its_pedals_and_no_delays() -> None:
    bare = sheet()
    assert (bare.max_acceleration, bare.max_deceleration, bare.steer_delay, bare.drive_delay) == (3.0, 6.0, 0.0, 0.0)
    assert (bare.max_steer, bare.mass, bare.wheelbase) == (0.6, 1000.0, 2.5)


def test_delays_and_lags_of_a_data_sheet_add_up() -> None:
    known = sheet(steer_delay={"T": 0.1}, steer_lag={"tau": 0.2}, drive_delay={"T": 0.3}, drive_lag={"tau": 0.5})
    assert (known.steer_delay, known.drive_delay) == pytest.approx((0.3, 0.8))


def test_a_data_sheet_knows_limits_that_are_finite() -> None:
    """100 N m x 6 / 0.3 m are 2 kN; 1 kg m^2 x (6 / 0.3 m)^2 add 400 kg."""
    assert sheet(motor_torque={"torque": 100.0}).max_acceleration == pytest.approx(2.0)
    assert sheet(motor_inertia={"J": 1.0}).max_acceleration == pytest.approx(3000.0 / 1400.0)
    assert sheet(brake_limit={"limit": 4.0}).max_deceleration == 4.0
    assert sheet(brake_limit={"limit": 9.0}).max_deceleration == 6.0
    assert sheet(steer_angle_limit={"limit": 0.4}).max_steer == 0.4
    assert sheet(steer_angle_limit={"limit": math.inf}).max_steer == 0.6


# --- inputs


def test_columns_hold_their_last_value_and_begin_with_their_first() -> None:
    table, slopes = command_table(
        Inputs(), np.arange(5.0), {"steer_cmd": [math.nan, 0.1, math.nan, 0.3, math.nan], "accel_cmd": [1.0] * 5}
    )
    assert table[:, 0] == pytest.approx([0.1, 0.1, 0.1, 0.3, 0.3])
    assert table[:, 1] == pytest.approx([1.0] * 5)
    assert not slopes.any()


@pytest.mark.parametrize(
    ("longitudinal", "columns", "expected"),
    [
        (("throttle_cmd", "brake_pressure"), {"throttle_cmd": [0.5], "brake_pressure": [2e6]}, {2: 0.5, 3: 0.4}),
        (("motor_current",), {"motor_current": [50.0]}, {2: 0.5}),
        (("motor_current",), {"motor_current": [-25.0]}, {3: 0.25}),
        (("speed_cmd",), {"speed_cmd": [7.0]}, {4: 7.0}),
        (("throttle_cmd", "brake_cmd"), {"throttle_cmd": [0.2], "brake_cmd": [0.3]}, {2: 0.2, 3: 0.3}),
        (("v",), {"v": [7.0]}, {5: 7.0}),
    ],
)
def test_each_column_is_a_command_of_its_own(
    longitudinal: tuple[str, ...], columns: dict[str, list[float]], expected: dict[int, float]
) -> None:
    table, _ = command_table(Inputs(longitudinal=longitudinal), np.zeros(1), {"steer_cmd": [0.1], **columns})
    assert table[0].tolist() == pytest.approx([0.1, *(expected.get(k, 0.0) for k in range(1, 6))])


def test_measured_columns_are_straight_between_stamps() -> None:
    columns = {"steer": [0.0, 0.2, 0.1], "v": [5.0, 7.0, 8.0]}
    _, slopes = command_table(Inputs(steer="steer", longitudinal=("v",)), np.arange(3.0), columns)
    assert slopes == pytest.approx(np.array([[0.2, 2.0], [-0.1, 1.0], [0.0, 0.0]]))


def test_the_acceleration_of_an_imposed_speed_is_its_slope_over_a_fifth_of_a_second() -> None:
    t = np.array([0.0, 0.1, 0.2, 0.3, 5.0, 5.01])  # the last two stand alone
    v = np.array([0.0, 0.1, 0.4, 0.9, 0.0, 0.02])
    table, _ = command_table(Inputs(longitudinal=("v",)), t, {"steer_cmd": np.zeros(6), "v": v})
    lone = [np.polyfit(t[part], v[part], 1)[0] for part in ([2, 3, 4], [3, 4, 5])]  # beside a pause, both neighbours
    assert table[:, 1] == pytest.approx([1.0, 2.0, 4.0, *lone, 2.0])
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 20.0, 0.02)
    noisy = 5.0 + 0.5 * t + rng.normal(0.0, 0.02, len(t))
    table, _ = command_table(Inputs(longitudinal=("v",)), t, {"steer_cmd": 0.0 * t, "v": noisy})
    # The slope of a line through 11 points that are 0.02 s apart: sigma / sqrt(sum of squared distances).
    assert np.std(table[5:-5, 1] - 0.5) == pytest.approx(0.02 / np.sqrt(110 * 0.02**2), rel=0.1)


def test_a_column_without_any_value_is_refused() -> None:
    with pytest.raises(ModelError, match="column has no value"):
        command_table(Inputs(), np.arange(2.0), {"steer_cmd": [math.nan] * 2, "accel_cmd": [0.0] * 2})
    with pytest.raises(ModelError, match="another length"):
        command_table(Inputs(), np.arange(2.0), {"steer_cmd": [0.0] * 3, "accel_cmd": [0.0] * 2})


def test_a_normalised_column_has_another_scale() -> None:
    assert (default_steer_scale("steer_norm"), default_steer_scale("steer_cmd")) == (0.4, 1.0)


# --- effects of a file


def test_a_file_of_effects_that_is_missing_or_fails_is_named(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no such file"):
        effects_of_file(tmp_path / "none.py")
    failing = tmp_path / "failing.py"
    failing.write_text("raise RuntimeError('out of paper')\n")
    with pytest.raises(ModelError, match=r"failing\.py: cannot be loaded: RuntimeError: out of paper"):
        effects_of_file(failing)
    empty = tmp_path / "empty.py"
    empty.write_text("x = 1\n")
    with pytest.raises(ModelError, match="holds no function"):
        effects_of_file(empty)


# --- lines of a model file

FILE = """[model]
base = "kinematic_bicycle"

[inputs]
steer = "steer_cmd"

[[effect]]
name = "steer_delay"
[effect.parameters]
T = 0.2

[[effect]]
name = "drive_delay"
"T" = 0.3
[effect.parameters.T]
value = 0.4

[parameters]
mass = 1000.0
"""


@pytest.mark.parametrize(
    ("table", "key", "nth", "line"),
    [
        ("model", "", 0, 1),
        ("model", "base", 0, 2),
        ("inputs", "steer", 0, 5),
        ("inputs", "longitudinal", 0, 4),  # not stated: the head of its table
        ("effect", "", 0, 7),
        ("effect", "", 1, 12),
        ("effect", "name", 0, 8),
        ("effect", "name", 1, 13),
        ("effect", "T", 0, 10),
        ("effect", "T", 1, 14),
        ("effect", "", 2, None),
        ("parameters", "mass", 0, 19),
        ("remainder", "v", 0, None),
    ],
)
def test_the_line_of_a_key(table: str, key: str, nth: int, line: int | None) -> None:
    assert _Lines(FILE).find(table, key, nth) == line


def test_what_should_be_a_table_is_found_as_a_key() -> None:
    assert _Lines("[model]\nname = 'x'\ninputs = 3\n").find("inputs") == 3


@pytest.mark.parametrize("wish", ["accel_cmd", "throttle_cmd + brake_cmd", "throttle_cmd+brake_cmd", "v"])
def test_longitudinal_inputs_are_those_that_are_known(wish: str) -> None:
    parts = tuple(part.strip() for part in wish.split("+"))
    car = "\n".join(f"{key} = {value}" for key, value in CAR.items())
    assert parse_model(f'[inputs]\nlongitudinal = "{wish}"\n[parameters]\n{car}\n').inputs.longitudinal == parts
    with pytest.raises(ModelError, match=r"m\.toml:2: inputs\.longitudinal: unknown longitudinal input"):
        parse_model(f'[inputs]\nlongitudinal = "{wish}s"\n[parameters]\n{car}\n', "m.toml")


def test_a_remainder_is_exchanged_and_one_that_is_the_same_stays() -> None:
    car = "\n".join(f"{key} = {value}" for key, value in CAR.items())
    text = f"[parameters]\n{car}\n\n# mine\n[remainder]\nv = {{ cruise = 0.1 }}\n"
    given = parse_model(text)
    assert edited_text(text, given) == text
    changed = edited_text(text, given.__class__(given.base, given.inputs, given.car, remainder={"v": {"cruise": 0.2}}))
    assert changed is not None
    assert parse_model(changed).remainder == {"v": {"cruise": 0.2}}
    assert changed.count("[remainder]") == 1


def test_only_the_value_that_changed_changes_in_an_effect() -> None:
    """The first key is left out because it is neutral; the second one is changed all the same."""
    car = "\n".join(f"{key} = {value}" for key, value in CAR.items())
    text = f'[parameters]\n{car}\n\n[[effect]]\nname = "motor_damping"\nparameters = {{ zero = 0.02 }}\n'
    changed = edited_text(text, parse_model(text).with_effect("motor_damping", {"zero": 0.03}))
    assert changed == text.replace("0.02", "0.03")
    both = text.replace("zero = 0.02", "full = 0.08, zero = 0.02")
    changed = edited_text(both, parse_model(both).with_effect("motor_damping", {"full": 0.09, "zero": 0.03}))
    assert changed == both.replace("0.02", "0.03").replace("0.08", "0.09")


# --- what hides what


def row(
    *objects: tuple[float, float, float, float, float], ego: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> Tracks:
    """Objects x, y, yaw, length, width at one stamp."""
    x, y, yaw, length, width = np.array(objects).T
    n = len(objects)
    flat = np.zeros(n)
    seen_from = {"ego_x": flat + ego[0], "ego_y": flat + ego[1], "ego_yaw": flat + ego[2]}
    box = {"x": x, "y": y, "yaw": yaw, "vx": flat, "vy": flat, "length": length, "width": width}
    return Tracks(t=flat, object=np.arange(n), **seen_from, **box)


def plate(distance: float, direction: float, low: float, high: float) -> tuple[float, float, float, float, float]:
    """A thin plate at right angles to a direction, from one angle to another as seen from the origin."""
    a, b = distance * math.tan(low), distance * math.tan(high)
    c, s, middle = math.cos(direction), math.sin(direction), 0.5 * (a + b)
    return distance * c - middle * s, distance * s + middle * c, direction, 1e-9, b - a


@pytest.mark.parametrize("direction", [0.0, 1.0, math.pi, -2.5])
@pytest.mark.parametrize(
    ("low", "high", "share"),
    [(-0.3, 0.3, 1.0), (-0.3, 0.0, 0.5), (0.05, 0.3, 0.25), (0.11, 0.3, 0.0), (-0.05, 0.0, 0.25)],
)
def test_the_share_of_the_angle_that_is_behind_another(direction: float, low: float, high: float, share: float) -> None:
    """A plate from -0.1 to 0.1 rad 40 m away, another one before it 10 m away; also where the angle passes pi."""
    tracks = row(plate(40.0, direction, -0.1, 0.1), plate(10.0, direction, low, high))
    assert hidden_share(tracks) == pytest.approx(np.array([share, 0.0]), abs=0.02)


def test_what_is_farther_hides_nothing_and_neither_does_another_stamp() -> None:
    near, far = plate(10.0, 0.0, -0.1, 0.1), plate(40.0, 0.0, -0.3, 0.3)
    assert hidden_share(row(near, far)) == pytest.approx(np.array([0.0, 0.33]), abs=0.02)
    later = row(far, near)
    two = Tracks(**{name: getattr(later, name) for name in Tracks.__slots__} | {"t": np.array([0.0, 1.0])})
    assert hidden_share(two).tolist() == [0.0, 0.0]


def test_two_that_overlap_hide_together_what_both_do() -> None:
    tracks = row(plate(40.0, 0.5, -0.1, 0.1), plate(10.0, 0.5, -0.2, 0.0), plate(20.0, 0.5, -0.05, 0.05))
    assert hidden_share(tracks)[0] == pytest.approx(0.75, abs=0.02)


def test_a_box_fills_the_angle_of_its_outermost_corners() -> None:
    """4 x 2 m at 10 m: corners at atan(1 / 8); a thin plate far behind is hidden as far as that."""
    edge = math.atan(1.0 / 8.0)
    tracks = row(plate(100.0, 0.0, -2.0 * edge, 2.0 * edge), (10.0, 0.0, 0.0, 4.0, 2.0))
    assert hidden_share(tracks)[0] == pytest.approx(0.5, abs=0.02)
    turned_ = row(plate(100.0, 0.0, -0.4, 0.4), (10.0, 0.0, math.pi / 6.0, 4.0, 2.0))
    corners = [
        math.atan2(x * 0.5 + y * 0.75**0.5, 10.0 + x * 0.75**0.5 - y * 0.5) for x in (2.0, -2.0) for y in (1.0, -1.0)
    ]
    assert hidden_share(turned_)[0] == pytest.approx((max(corners) - min(corners)) / 0.8, abs=0.02)


def test_a_box_around_the_ego_hides_nothing() -> None:
    assert hidden_share(row(plate(40.0, 0.0, -0.1, 0.1), (1.0, 0.0, 0.0, 4.0, 2.0))).tolist() == [0.0, 0.0]
    assert hidden_share(row(plate(40.0, 0.0, -0.1, 0.1), (1.0, 2.0, 0.0, 4.0, 2.0)))[0] == 0.0  # beside it
    assert hidden_share(row(plate(40.0, 0.0, -0.1, 0.1))).tolist() == [0.0]


def test_shifts_are_in_the_frame_of_the_ego() -> None:
    """Facing +y: forward is +y, left is -x."""
    moved = row((5.0, 6.0, 0.0, 1.0, 1.0), ego=(0.0, 0.0, 0.5 * math.pi)).moved(2.0, 3.0)
    assert (moved.x[0], moved.y[0]) == pytest.approx((2.0, 8.0))
    moved = row((5.0, 6.0, 0.0, 1.0, 1.0), ego=(0.0, 0.0, math.pi / 6.0)).moved(2.0, 4.0)
    assert (moved.x[0], moved.y[0]) == pytest.approx((5.0 + 3.0**0.5 - 2.0, 6.0 + 1.0 + 2.0 * 3.0**0.5))


def test_a_range_includes_its_end() -> None:
    tracks = row((3.0, 4.0, 0.0, 1.0, 1.0), (3.1, 4.0, 0.0, 1.0, 1.0))
    shown = detection_range.function(tracks, SimpleNamespace(R=5.0), np.random.default_rng(0))
    assert shown.object.tolist() == [0]


# --- the twin's commands, and the paper's table


def test_a_command_is_what_it_is_called() -> None:
    car = Plant(VehicleModel("kinematic_bicycle", Inputs(), make_car(CAR)))
    car.command(0.1, accel=0.2, throttle=0.3, brake=0.4, speed=0.5)
    assert car._command[0, :5].tolist() == [0.1, 0.2, 0.3, 0.4, 0.5]


def test_steps_of_cars_that_swing_are_finer() -> None:
    """As the descriptions of effects say (`fine`): 10 ms instead of 20."""
    assert (LONGEST_SWING_STEP, LONGEST_STEP) == (0.01, 0.02)


@pytest.mark.parametrize("iteration", [1, 5, 10])
def test_a_preset_is_its_column_of_the_table(iteration: Any) -> None:
    column = {1: "first", 5: "fifth", 10: "tenth"}[iteration]
    found = simulator_parameters.preset_s(iteration)
    known = {p.name: getattr(p, column) for p in simulator_parameters.S_PARAMETERS}
    assert found == {name: value for name, value in known.items() if value is not None}
    assert found["EGO_mass"] == known["EGO_mass"]


@pytest.mark.parametrize(("iteration", "stage"), [(2, "dt"), (1, "sim"), (0, "dt")])
def test_there_is_no_other_preset(iteration: Any, stage: Any) -> None:
    with pytest.raises(ModelError, match="no such preset"):
        simulator_parameters.preset_s(iteration, stage)


# --- effects around a box


class Spy:
    """Counts calls, halves the angle, adds to the acceleration, and notes what it saw."""

    def __init__(self) -> None:
        self.seen: list[tuple[float, float, float, float]] = []

    def __call__(self, first: int, end: int, bus: Any, *_: Any) -> None:
        x = bus[0]
        self.seen.append((x.settle, x.t, x.dt, x.steer_cmd))
        x.steer_lead, x.accel_lead = 0.25 * x.steer, 0.5
        x.steer *= 0.5
        x.accel += len(self.seen)


def test_the_way_of_a_command_is_the_mean_over_its_steps_and_its_start(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten long steps at rest, then two pieces of 15 ms and one step of its own behind the last stamp."""
    spy = Spy()
    monkeypatch.setattr(wrapped_model, "_slots", spy)
    x = SimpleNamespace(settle=0.0, accel=0.0)
    found, given = np.zeros((2, 4)), np.array([[0.4, 1.0], [0.8, 2.0]])
    wrapped_model._act.py_func([x], None, None, None, None, np.array([5.0, 5.03]), given, 0.02, found)
    rest = wrapped_model.SETTLING_STEPS
    settle, t, dt, steer = (list(column) for column in zip(*spy.seen, strict=True))
    assert settle == [1.0] * rest + [0.0] * 3
    assert t == pytest.approx([5.0 + (k - rest) * wrapped_model.SETTLING for k in range(rest)] + [5.0, 5.015, 5.03])
    assert dt == pytest.approx([wrapped_model.SETTLING] * rest + [0.015, 0.015, 0.02])
    assert steer == [0.4] * (rest + 2) + [0.8]
    assert found[:, 0] == pytest.approx([0.2, 0.4])  # the mean of the angle
    assert found[:, 1] == pytest.approx([0.2 + 0.1, 0.4 + 0.2])  # and at the stamp
    assert found[:, 2] == pytest.approx([1.0 + rest + 1.5, 2.0 + rest + 3.0])
    assert found[:, 3] == pytest.approx([1.0 + rest + 1.0 + 0.5, 2.0 + rest + 3.0 + 0.5])


def test_sensors_around_a_box_see_its_motion_and_where_it_was_put(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[dict[str, float]] = []

    def slots(first: int, end: int, bus: Any, *_: Any) -> None:
        seen.append(dict(vars(bus[0])))
        for name in ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay"):
            setattr(bus[0], f"meas_{name}", getattr(bus[0], f"meas_{name}") + 100.0)

    monkeypatch.setattr(wrapped_model, "_slots", slots)
    motion = np.arange(24.0).reshape(3, 8)
    shown = motion.copy()
    x = SimpleNamespace(old_x=0.0, old_y=0.0, old_yaw=0.0)
    t, starts, before = np.array([1.0, 1.1, 1.3]), np.array([0, 2]), np.array([[7.0, 8.0, 9.0], [70.0, 80.0, 90.0]])
    wrapped_model._sense.py_func([x], None, None, None, None, t, starts, before, shown)
    assert shown[:, :7] == pytest.approx(motion[:, :7] + 100.0)
    assert shown[:, 7] == pytest.approx(motion[:, 7])
    for k, bus in enumerate(seen):
        names = ("x", "y", "yaw", "vx", "yaw_rate", "ax", "ay")
        assert [bus[name] for name in names] == motion[k, :7].tolist()
    assert [bus["t"] for bus in seen] == [1.0, 1.1, 1.3]
    assert [bus["dt"] for bus in seen] == pytest.approx([0.1, 0.1, 0.2])
    assert [bus["moved"] for bus in seen] == [0.0, 0.0, 1.0]
    assert [seen[2][name] for name in ("old_x", "old_y", "old_yaw")] == [70.0, 80.0, 90.0]
    assert seen[0]["old_x"] == 0.0


@pytest.mark.parametrize(
    ("key", "value", "allowed"),
    [
        (Key("v0", "m/s", 1.0, 6.0, neutral=2.0, least=0.5, minimum=0.2), 0.1, "allowed: 0.2 m/s or more)"),
        (Key("g", "-", 0.7, 1.2, neutral=1.0, least=0.02, minimum=0.1, maximum=2.0), 3.0, "allowed: 0.1 to 2)"),
        (Key("c", "-", 0.0, 1.0, neutral=0.0, least=0.1, maximum=1.0), 2.0, "allowed: up to 1)"),
        (Key("limit", "rad", 0.1, 0.6, neutral=math.inf, least=0.1, minimum=0.0, maximum=1.5), -1.0,
         "allowed: 0 to 1.5 rad, inf for none)"),
    ],
)  # fmt: skip
def test_what_a_key_allows_is_said_with_its_unit_and_what_switches_it_off_if_that_lies_outside(
    key: Key, value: float, allowed: str
) -> None:
    with pytest.raises(ModelError, match=re.escape(allowed)):
        key.check(value)
    assert key.check(key.neutral) == key.neutral
