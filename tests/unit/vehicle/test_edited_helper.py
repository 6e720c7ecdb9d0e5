"""An edit of a function that effects call changes how the car moves, although old machine code is on disk."""

from __future__ import annotations

import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import machine_code
import vehicle
from vehicle.model.effect_catalogue import effects_of_file
from vehicle.model.model_file import parse_model
from vehicle.model.plant import Plant

TAU = 0.5  # s
MODEL = f"""
[model]
base = "kinematic_bicycle"
[inputs]
steer = "steer_cmd"
longitudinal = "accel_cmd"
[parameters]
wheelbase = 2.45
[[effect]]
name = "drive_lag"
[effect.parameters.tau]
value = {TAU}
"""
DRIVE = """
import sys
from vehicle.model.model_file import parse_model
from vehicle.model.plant import Plant

car = Plant(parse_model(sys.argv[1]))
car.command(0.0, 2.0)
car.advance(1000)
print(car.state.v)
"""


def speed(tau: float) -> float:
    """Of a car that is asked for 2 m/s^2 from standstill, after 1 s, if tau a' = 2 - a."""
    return 2.0 * (1.0 - tau * (1.0 - math.exp(-1.0 / tau)))


@pytest.mark.nightly
def test_an_edited_helper_of_effects_changes_the_motion(tmp_path: Path) -> None:
    car = Plant(parse_model(MODEL))  # the old machine code is on disk from here on
    car.command(0.0, 2.0)
    car.advance(1000)
    assert car.state.v == pytest.approx(speed(TAU), abs=1e-6)

    for package in (vehicle, machine_code):
        folder = Path(package.__file__ or "").parent
        shutil.copytree(folder, tmp_path / folder.name)  # with what was compiled
    helpers = tmp_path / "vehicle" / "model" / "step_maths.py"
    text = helpers.read_text()
    assert text.count("beta = dt / tau") == 1
    helpers.write_text(text.replace("beta = dt / tau", "beta = dt / (3.0 * tau)"))
    command = [sys.executable, "-c", DRIVE, MODEL]
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert float(done.stdout) == pytest.approx(speed(3.0 * TAU), abs=1e-6)


def test_an_edited_helper_of_a_users_effect_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "my_effect.py").write_text(
        "from my_helper import share\n"
        "from vehicle.model.effect import effect, Key\n\n"
        '@effect(name="weak_drive", slot="actuator", order=10, physics="gives less", equation="a = g a_c",\n'
        '        source="-", reveals="any drive", parameters=(Key("g", "-", 0.1, 1.0, neutral=1.0, least=0.01,'
        ' meaning="gain"),))\n'
        "def weak_drive(x, p, m):\n"
        "    x.accel = share(x.accel, p.g)\n"
    )
    model = MODEL.replace("drive_lag", "weak_drive").replace("tau", "g")
    for factor in (1.0, 0.5):
        (tmp_path / "my_helper.py").write_text(
            "from numba.extending import register_jitable\n\n"
            f"@register_jitable\ndef share(a, g):\n    return a * g * {factor}\n"
        )
        sys.modules.pop("my_helper", None)
        car = Plant(parse_model(model, extra=effects_of_file(tmp_path / "my_effect.py")))
        car.command(0.0, 2.0)
        car.advance(1000)
        assert car.state.v == pytest.approx(2.0 * TAU * factor, rel=1e-9)
    sys.modules.pop("my_helper", None)
