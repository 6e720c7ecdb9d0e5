"""A car on tyres in a steady bend, in closed form, and what the text of an exported twin holds."""

from __future__ import annotations

import ast
import base64
import hashlib
import io
import math
import re
import zipfile
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.tyre_regressors import on_tyres
from pytest_dvp.gap.extend.exported_twin import python_text
from vehicle.model.errors import ModelError
from vehicle.model.model_file import model_text, parse_model

FRONT, REAR, WHEELBASE, CG_FRONT = 0.004, 0.003, 2.5, 1.0  # rad s^2/m, and m


def signals(speed: float, steer: float, n: int = 400) -> Any:
    return SimpleNamespace(v=np.full(n, speed), steer=np.full(n, steer), step=0.02, wheelbase=WHEELBASE,
                           cg_front=CG_FRONT, gyration=1.5)  # fmt: skip


@pytest.mark.parametrize("length", [0.0, 0.5])
@pytest.mark.parametrize("limit", [math.inf, 8.0, 5.0])
@pytest.mark.parametrize(("speed", "rate"), [(5.0, 0.2), (10.0, -0.3), (20.0, 0.2)])
def test_a_steady_bend(speed: float, rate: float, limit: float, length: float) -> None:
    """Each axle carries its share of the lateral acceleration, at a slip angle of so many rad per m/s^2, and of more
    where its force levels off: F = k s/sqrt(1 + (k s/F_max)^2). The wheels steer by L/R and by how much the front
    slips more than the rear."""
    ay = speed * rate
    more = 1.0 / math.sqrt(1.0 - (ay / limit) ** 2)
    steer = WHEELBASE * rate / speed + (FRONT - REAR) * ay * more
    found, side = on_tyres(signals(speed, steer), FRONT, REAR, limit=limit, length=length)
    assert found[-1] == pytest.approx(rate, rel=1e-4)
    assert side[-1] == pytest.approx(-REAR * ay * more * speed, rel=1e-4)


def test_a_bend_begins_as_the_wheels_point() -> None:
    faster = signals(10.0, 0.1)
    faster.v = np.linspace(10.0, 20.0, 400)
    found, side = on_tyres(faster, FRONT, REAR)
    assert (found[0], side[0]) == pytest.approx((10.0 * 0.1 / WHEELBASE, 0.0), abs=1e-12)
    assert side[1] != 0.0


@pytest.mark.parametrize(("speed", "slips"), [(0.99, False), (1.0, True)])
def test_a_slow_car_rolls_without_slip(speed: float, slips: bool) -> None:
    found, side = on_tyres(signals(speed, 0.4, 50), FRONT, REAR)
    assert bool((side[1:] != 0.0).all()) == slips
    if not slips:
        assert found == pytest.approx(np.full(50, speed * math.tan(0.4) / WHEELBASE))


# --- a twin as text

MODEL = """\
[model]
name = 'a "small" car'
base = "kinematic_bicycle"

[inputs]
steer = "steer_cmd"
longitudinal = "{longitudinal}"

[parameters]
wheelbase = 2.5
"""


def a_model(longitudinal: str = "accel_cmd") -> Any:
    return parse_model(MODEL.format(longitudinal=longitudinal))


@pytest.fixture(scope="module")
def text() -> str:
    return python_text(a_model())


def test_an_exported_twin_holds_its_model_and_the_sources(text: str) -> None:
    held: dict[str, Any] = {}
    for name in ("DIGEST", "MODEL", "_SOURCES"):
        found = re.search(rf'^{name} = (""".*?"""|.*?)$', text, re.MULTILINE | re.DOTALL)
        assert found is not None
        held[name] = ast.literal_eval(found[1])
    assert held["MODEL"] == model_text(a_model())
    archive = base64.b64decode(held["_SOURCES"])
    assert hashlib.sha256(archive).hexdigest() == held["DIGEST"]
    with zipfile.ZipFile(io.BytesIO(archive)) as files:
        names = files.namelist()
        assert {info.date_time for info in files.infolist()} == {(2020, 1, 1, 0, 0, 0)}
    assert names == list(dict.fromkeys(names))
    assert {"vehicle/messages.py", "vehicle/model/plant.py", "vehicle/model/effects/mass.py"} <= set(names)
    assert "machine_code/__init__.py" in names
    assert all(name.endswith(".py") for name in names)
    assert not [name for name in names if name.startswith("vehicle/") and name.count("/") > 1
                and not name.startswith("vehicle/model/")]  # fmt: skip
    assert max(map(len, text.split('_SOURCES = """\n')[1].split("\n"))) <= 116


def test_an_exported_twin_has_its_name_and_compiles(text: str) -> None:
    assert text.startswith('"""a \'small\' car: a vehicle model as a Python module')
    compile(text, "twin.py", "exec")
    assert "Fmi2Slave" not in text


@pytest.mark.parametrize(
    ("longitudinal", "taken"),
    [
        ("accel_cmd", ("accel_cmd",)),
        ("throttle_cmd + brake_cmd", ("throttle_cmd", "brake_cmd")),
        ("throttle_cmd + brake_pressure", ("throttle_cmd", "brake_cmd")),
        ("motor_current", ("throttle_cmd", "brake_cmd")),
    ],
)
def test_a_slave_takes_what_its_car_obeys(
    longitudinal: str, taken: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A log of a car that is driven by accelerations has no pedals to drive an FMU with."""
    monkeypatch.setattr("pytest_dvp.gap.extend.exported_twin._sources", lambda: b"none")
    text = python_text(a_model(longitudinal), slave="Small")
    assert f"TAKEN = {('steer_cmd', *taken)!r}" in text
    assert text.count("in TAKEN") == 2


def test_a_slave_stands_behind_the_module(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_dvp.gap.extend.exported_twin._sources", lambda: b"none")
    whole = python_text(a_model(), slave="Small")
    assert "class Small(Fmi2Slave):" in whole
    compile(whole, "twin.py", "exec")
    assert python_text(a_model()) == whole[: whole.index("\n\nfrom pythonfmu")]


def test_a_model_without_commands_is_not_exported() -> None:
    with pytest.raises(ModelError, match="driven by what was measured has no commands"):
        python_text(a_model("v"))
