"""Effects of others: a file, an installed package, and what goes wrong with them."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core.errors import NumbaError

from vehicle.messages import TRACE_COLUMNS, VehicleState
from vehicle.model import effect_compiler
from vehicle.model.effect_catalogue import effects_of_file, find_effect
from vehicle.model.errors import ModelError
from vehicle.model.model_file import parse_model
from vehicle.model.plant import Plant

MINE = """
from vehicle.model.effect import Key, Memory, effect
from vehicle.model.step_maths import clip

@effect(
    name="magnet", slot="force", physics="a magnet at the end of the road", equation="a = c t", source="none",
    parameters=(Key("c", "m/s^3", 0.1, 1.0, neutral=0.0, least=0.05, meaning="pull"),), memory=(Memory("t"),),
    reveals="wait",
)
def magnet(x, p, m):
    m.t += x.dt
    x.drag += p.c * clip(m.t, 0.0, 2.0) * x.mass
"""
BENT = """
from vehicle.model.effect import Key, effect

@effect(
    name="bent", slot="body", physics="a bent track rod", equation="d = d_c + a", source="none",
    parameters=(Key("a", "rad", -0.2, 0.2, neutral=0.0, least=0.05, meaning="angle"),), reveals="straight driving",
)
def bent(x, p, m):
    x.steer += p.a
"""
MODEL = '[parameters]\nwheelbase = 2\n[[effect]]\nname = "magnet"\nparameters = { c = 0.5 }\n'


def test_a_users_effect_acts_like_a_built_in_one(tmp_path: Path) -> None:
    file = tmp_path / "my_effect.py"
    file.write_text(MINE, encoding="utf-8")
    car = Plant(parse_model(MODEL, extra=effects_of_file(file)))
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=0.0))
    assert car.advance(2000)[-1, 5] == pytest.approx(0.5 * 2.0**2 / 2.0, abs=2e-3)


@pytest.mark.parametrize("angle", [0.0, 0.1])
def test_a_car_turns_as_its_wheels_point_after_the_effects_of_the_body(angle: float, tmp_path: Path) -> None:
    """Yaw rate of a car that rolls without slip: v tan(d)/L."""
    file = tmp_path / "bent.py"
    file.write_text(BENT, encoding="utf-8")
    text = f'[parameters]\nwheelbase = 2\n[[effect]]\nname = "bent"\nparameters = {{ a = {angle} }}\n'
    car = Plant(parse_model(text, extra=effects_of_file(file)), keep_neutral=True)
    car.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=5.0, steer=0.1))
    car.command(0.1, 0.0, 0.0, 0.0, 0.0)
    row = dict(zip(TRACE_COLUMNS, car.advance(10)[-1], strict=True))
    assert row["yaw_rate"] == pytest.approx(5.0 * math.tan(0.1 + angle) / 2.0, rel=1e-3)


@pytest.mark.nightly
def test_a_users_effect_runs_again_in_the_next_process(tmp_path: Path) -> None:
    file = tmp_path / "my_effect.py"
    file.write_text(MINE, encoding="utf-8")
    code = (
        "from pathlib import Path\n"
        "from vehicle.model.effect_catalogue import effects_of_file\n"
        "from vehicle.model.effect_compiler import compiled\n"
        f"print(compiled(effects_of_file(Path({str(file)!r}))['magnet']).address > 0)\n"
    )
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
        assert done.stdout.strip() == "True", done.stderr


def test_an_installed_package_announces_its_effects(tmp_path: Path) -> None:
    (tmp_path / "magnets.py").write_text(MINE, encoding="utf-8")
    about = tmp_path / "magnets-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: magnets\nVersion: 1.0\n", encoding="utf-8")
    (about / "entry_points.txt").write_text("[pytest_dvp.effects]\nmagnets = magnets\n", encoding="utf-8")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
    code += "from vehicle.model.effect_catalogue import catalogue; print(catalogue()['magnet'].equation)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "a = c t"


@pytest.mark.parametrize(
    ("right", "wrong", "says"),
    [
        ('slot="force"', 'slot="engine"', "no such slot"),
        ("neutral=0.0", "neutral=float('nan')", "neutral value is wrong"),
        ('Memory("t")', 'Memory("t", start="velocity")', "no such bus field"),
        ("@effect", "@effetc", "NameError"),
        ("def magnet(", "def magnet(:", "SyntaxError"),
    ],
)
def test_a_faulty_description_is_a_model_error_naming_the_file(
    tmp_path: Path, right: str, wrong: str, says: str
) -> None:
    file = tmp_path / "my_effect.py"
    file.write_text(MINE.replace(right, wrong), encoding="utf-8")
    with pytest.raises(ModelError, match=says) as caught:
        effects_of_file(file)
    assert str(file) in str(caught.value)


def test_a_function_that_does_not_compile_is_a_model_error_naming_effect_and_file(tmp_path: Path) -> None:
    file = tmp_path / "my_effect.py"
    file.write_text(MINE.replace("x.drag", "x.drug"), encoding="utf-8")
    model = parse_model(MODEL, extra=effects_of_file(file))
    with pytest.raises(ModelError, match="no such field: drug") as caught:
        Plant(model)
    assert "magnet" in str(caught.value)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_of_a_long_reason_why_a_function_does_not_compile_the_first_300_letters_are_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On one line: what numba says has many."""

    def refuse(*asked: object) -> None:
        raise NumbaError("no\n  way " + 400 * "x")

    monkeypatch.setattr(effect_compiler, "compiled_callback", refuse)
    with pytest.raises(ModelError) as caught:
        effect_compiler.compiled.__wrapped__(find_effect("steer_lag"))
    assert caught.value.text == "effect cannot be compiled: no way " + 293 * "x"


def test_a_file_without_effects_and_a_missing_one_are_model_errors(tmp_path: Path) -> None:
    file = tmp_path / "empty.py"
    file.write_text("", encoding="utf-8")
    with pytest.raises(ModelError, match="no function decorated"):
        effects_of_file(file)
    with pytest.raises(ModelError, match="no such file"):
        effects_of_file(tmp_path / "absent.py")


def test_a_dead_time_beyond_the_delay_line_is_refused(tmp_path: Path) -> None:
    text = '[parameters]\nwheelbase = 2\n[[effect]]\nname = "drive_delay"\nparameters = { T = 0.5 }\n'
    with pytest.raises(ModelError, match="too long for a step"):
        Plant(parse_model(text), dt=1e-4)


def test_an_installed_package_that_does_not_load_is_named(tmp_path: Path) -> None:
    (tmp_path / "broken_magnets.py").write_text("import absent_module_of_nobody", encoding="utf-8")
    about = tmp_path / "broken_magnets-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: broken-magnets\nVersion: 1.0\n", encoding="utf-8")
    (about / "entry_points.txt").write_text("[pytest_dvp.effects]\nm = broken_magnets\n", encoding="utf-8")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n"
    code += "from vehicle.model.effect_catalogue import catalogue\n"
    code += "try:\n    catalogue()\nexcept ValueError as error:\n    print(error)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("broken-magnets: broken_magnets: announced effects cannot be loaded")
