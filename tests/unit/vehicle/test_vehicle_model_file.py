"""Vehicle model files: what is read, and the one clear line for each mistake."""

from __future__ import annotations

import subprocess
import sys
from math import inf, radians
from pathlib import Path

import pytest

from vehicle.model.model_file import ModelError, model_text, parse_model, read_model, write_model

GOOD = """[model]
base = "kinematic_bicycle"

[inputs]
steer = "steer_cmd"
longitudinal = "accel_cmd"

[parameters]
wheelbase = 2.45
cg_to_front_axle = 1.15
mass = 1150.0
yaw_inertia = 1400.0

[[effect]]
name = "steer_delay"
fitted_on = ["rich.csv sha256:abc"]
[effect.parameters.T]
value = 0.21
low = 0.20
high = 0.22
unit = "s"
"""


def test_the_example_of_the_design_is_read() -> None:
    model = parse_model(GOOD)
    assert model.base == "kinematic_bicycle"
    assert model.car.wheelbase == 2.45
    assert model.value("steer_delay", "T") == 0.21
    applied = model.effects[0]
    assert (applied.intervals["T"].low, applied.intervals["T"].high) == (0.20, 0.22)
    assert applied.fitted_on == ("rich.csv sha256:abc",)


def test_a_bare_number_is_a_parameter_value_too() -> None:
    assert parse_model(GOOD + '[[effect]]\nname = "drive_lag"\nparameters = { tau = 0.3 }\n').value(
        "drive_lag", "tau"
    ) == pytest.approx(0.3)


def test_left_out_parameters_of_an_effect_are_neutral() -> None:
    model = parse_model(GOOD + '[[effect]]\nname = "motor_torque"\n[effect.parameters]\ntorque = 128.0\n')
    assert model.value("motor_torque", "power") == inf


@pytest.mark.parametrize("longitudinal", ["accel_cmd", "throttle_cmd + brake_cmd", "throttle_cmd+brake_cmd", "v"])
def test_declared_inputs(longitudinal: str) -> None:
    model = parse_model(GOOD.replace('"accel_cmd"', f'"{longitudinal}"'))
    assert model.inputs.longitudinal == tuple(p.strip() for p in longitudinal.split("+"))


def test_the_tabby_is_the_car_of_the_paper(scenarios_dir: Path) -> None:
    model = read_model(scenarios_dir / "models" / "tabby_evo.toml")
    about = model.description()
    assert (about.length, about.width, about.height, about.wheelbase, about.mass) == (3.03, 1.488, 1.38, 2.36, 730.0)
    assert about.max_steer == pytest.approx(radians(20.0), abs=1e-4)
    # 25 % climb, with the driver's and rolling share left
    assert about.max_acceleration > 9.81 * 0.2425


def test_what_the_file_left_to_the_defaults_stays_so() -> None:
    text = "[inputs]\nfull_brake = 6.0\n\n[parameters]\nwheelbase = 2.5\nmass = 1000.0\n"
    model = parse_model(text)
    stated = [line.split(" = ")[0] for line in model_text(model).splitlines() if " = " in line]
    assert stated == ["base", "steer", "longitudinal", "full_brake", "wheelbase", "mass"]
    changed = model.with_car({"wheelbase": 2.6, "cornering_stiffness_front": 70000.0})
    assert "cornering_stiffness_front = 70000.0" in model_text(changed)
    assert parse_model(model_text(changed)).car == changed.car


def test_an_effect_of_ones_own_without_its_file_is_told_the_option() -> None:
    with pytest.raises(ModelError, match=r"--effects FILE\.py"):
        parse_model(GOOD + '[[effect]]\nname = "tow_drag"\n')


def test_written_and_read_again_it_is_the_same_model(scenarios_dir: Path, tmp_path: Path) -> None:
    model = read_model(scenarios_dir / "models" / "tabby_evo.toml")
    write_model(model, tmp_path / "m.toml")
    assert read_model(tmp_path / "m.toml") == model
    assert model_text(read_model(tmp_path / "m.toml")) == model_text(model)


@pytest.mark.parametrize(
    "file",
    [
        "blind/model.toml",
        "measurements/genesis_g80/model.toml",
        "measurements/iac_av21_putnam/model.toml",
        "measurements/dart_jetracer/model.toml",
    ],
)
def test_model_files_of_real_cars_are_read(shared_dir: Path, file: str) -> None:
    assert read_model(shared_dir / file).effects == ()


MISTAKES = [
    ("wheelbase = 2.45", "wheelbase = 0.0", 9, "parameters.wheelbase", "more than 0 to 20 m"),
    ("wheelbase = 2.45", "wheelbase = -1", 9, "parameters.wheelbase", "found -1"),
    ("wheelbase = 2.45", "wheelbase = nan", 9, "parameters.wheelbase", "found nan"),
    ("mass = 1150.0", "mass = inf", 11, "parameters.mass", "found inf"),
    ("mass = 1150.0", 'mass = "heavy"', 11, "mass", "must be a number"),
    ("mass = 1150.0", "mass = true", 11, "mass", "must be a number"),
    ("mass = 1150.0", "mas = 1150.0", 11, "parameters.mas", "did you mean 'mass'?"),
    ("cg_to_front_axle = 1.15", "cg_to_front_axle = 2.5", 10, "cg_to_front_axle", "less than the wheelbase 2.45"),
    ("yaw_inertia = 1400.0", "yaw_inertia = 0", 12, "yaw_inertia", "more than zero"),
    ('name = "steer_delay"', 'name = "steer_dellay"', 15, "effect.name", "did you mean 'steer_delay'?"),
    ("[effect.parameters.T]", "[effect.parameters.tau]", 17, "steer_delay.tau", "allowed: T"),
    ("value = 0.21", "value = -0.21", 17, "steer_delay.T", "found -0.21"),
    ("value = 0.21", "value = nan", 17, "steer_delay.T", "found nan"),
    ("value = 0.21", "", 17, "steer_delay.T", "value missing"),
    ('unit = "s"', 'unit = "ms"', 17, "steer_delay.T", "allowed: s"),
    ("high = 0.22", "high = 0.205", 17, "steer_delay.T", "outside its interval"),
    ("kinematic_bicycle", "kinematic_bike", 2, "model.base", "did you mean 'kinematic_bicycle'?"),
    ('"accel_cmd"', '"acell_cmd"', 6, "inputs.longitudinal", "did you mean 'accel_cmd'?"),
    ("[inputs]", "[inputz]", 4, "inputz", "did you mean 'inputs'?"),
    ("wheelbase = 2.45", "wheelbase = ", 9, "", "not TOML"),
    ("value = 0.21", "value = inf", 17, "steer_delay.T", "found inf"),
    ('base = "kinematic_bicycle"', "name = 3", 2, "model.name", "must be a text (found 3)"),
]


@pytest.mark.parametrize(("right", "wrong", "line", "key", "says"), MISTAKES)
def test_a_mistake_is_answered_by_one_line_naming_its_place(
    tmp_path: Path, right: str, wrong: str, line: int, key: str, says: str
) -> None:
    assert GOOD.count(right) == 1
    path = tmp_path / "m.toml"
    path.write_text(GOOD.replace(right, wrong), encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        read_model(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:{line}: ")
    assert key in message
    assert says in message
    assert "\n" not in message


def test_effects_that_are_no_tables_are_one_line() -> None:
    with pytest.raises(ModelError, match=r"m\.toml:1: effect: write \[\[effect\]\], one for each effect"):
        parse_model("effect = [1, 2]\n[parameters]\nwheelbase = 2.5\n", "m.toml")


def test_a_byte_order_mark_is_passed_over(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text(GOOD, encoding="utf-8-sig")
    assert read_model(tmp_path / "m.toml") == parse_model(GOOD)


def test_a_limit_that_is_off_is_infinite(tmp_path: Path) -> None:
    text = '[parameters]\nwheelbase = 2.5\n[[effect]]\nname = "brake_limit"\n[effect.parameters]\nlimit = inf\n'
    assert parse_model(text).value("brake_limit", "limit") == float("inf")


def test_a_missing_wheelbase_is_named() -> None:
    with pytest.raises(ModelError, match=r"parameters\.wheelbase: missing"):
        parse_model(GOOD.replace("wheelbase = 2.45", ""), "m.toml")


def test_an_effect_that_stands_twice_is_named_with_the_line_of_the_second() -> None:
    twice = GOOD + '[[effect]]\nname = "steer_delay"\n'
    with pytest.raises(ModelError, match=r"m\.toml:23: effect\.name: effect stands twice"):
        parse_model(twice, "m.toml")


@pytest.mark.parametrize(
    "text",
    [
        "effect = 3",
        "model = 3",
        "parameters = []",
        "[[model]]",
        "[parameters]\nwheelbase = {}",
        "[parameters]\nwheelbase = 2\n[[effect]]\n",
        "[parameters]\nwheelbase = 2\n[[effect]]\nname = 3",
        '[parameters]\nwheelbase = 2\n[[effect]]\nname = "drive_lag"\nparameters = 3',
        '[parameters]\nwheelbase = 2\n[[effect]]\nname = "drive_lag"\nfitted_on = 3',
        '[parameters]\nwheelbase = 2\n[[effect]]\nname = "drive_lag"\nparameters = { tau = "x" }',
        "effect = [3]",
        "[inputs]\nsteer = 3",
        "[inputs]\nfull_brake = 0",
        "a = " + "[" * 5000,
    ],
)
def test_odd_shapes_are_model_errors_too(text: str) -> None:
    with pytest.raises(ModelError):
        parse_model(text, "m.toml")


def test_files_that_are_none_are_model_errors(tmp_path: Path) -> None:
    binary, large = tmp_path / "b.toml", tmp_path / "l.toml"
    binary.write_bytes(b"\xff\xfe\x00\x01")
    large.write_bytes(b"#" * 2_000_000)
    for path in (tmp_path / "absent.toml", tmp_path, binary, large):
        with pytest.raises(ModelError, match=str(path)):
            read_model(path)


def test_reading_a_model_needs_no_compiler() -> None:
    code = "import sys, vehicle.model.model_file as m; m.parse_model('[parameters]\\nwheelbase = 2'); "
    code += "print([n for n in ('numba', 'pandas', 'scipy') if n in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(("text", "key"), [("tyres = 4\n", "tyres"), ("[model]\nnaem = 'car'\n", "model.naem")])
def test_an_unknown_key_is_named_with_its_table(text: str, key: str) -> None:
    with pytest.raises(ModelError) as error:
        parse_model(text)
    assert error.value.key == key


@pytest.mark.parametrize("name", ["car.py", "car.py:simulate", "car.fmu", "other.csv"])
def test_a_model_that_can_only_be_compared_is_said_to_be_one(tmp_path: Path, name: str) -> None:
    (tmp_path / name.partition(":")[0]).write_bytes(b"def step(state, inputs, dt):\n    return \xff\n")
    with pytest.raises(
        ModelError, match=r"no model file \(\.toml\): a Python function, an FMU or a second log can only"
    ):
        read_model(tmp_path / name)
    with pytest.raises(ModelError, match="no such file"):
        read_model(tmp_path / "missing.csv")
