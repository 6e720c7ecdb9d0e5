"""An exported twin drives as ours does, over 165 s: as a module in a process without us, and as an FMU."""

from __future__ import annotations

import importlib.util
import json
import math
import platform
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from pytest_dvp.cli.dispatch import main
from pytest_dvp.gap.compare.fmu_model import FmuSubject
from pytest_dvp.gap.compare.segments import CHANNELS, cut, measured_array
from pytest_dvp.logs.log import Log
from vehicle.messages import VehicleState
from vehicle.model.model_file import read_model
from vehicle.model.plant import Plant

MODEL = Path(__file__).parents[3] / "scenarios" / "models" / "surrogate.toml"
TICK, TICKS = 0.05, 3300
SHOWN = (1, 2, 4, 5, 8, 9, 10, 11)  # x, y, yaw, v, yaw_rate, ax, ay, steer of a row of the twin

CAR = """
[model]
base = "kinematic_bicycle"
[inputs]
steer = "steer_cmd"
longitudinal = "accel_cmd"
[parameters]
wheelbase = 2.7
"""

DRIVE = """
import json, math, sys
sys.path.insert(0, sys.argv[1])
import twin
car = twin.Twin(v=10.0)
rows = [list(car.step(0.05, 0.05 * math.sin(0.05 * k), math.sin(0.02 * k)).values()) for k in range(int(sys.argv[2]))]
source = sys.modules["vehicle"].__path__[0]
print(json.dumps({"rows": rows, "from": source, "ours": "pytest_dvp" in sys.modules}))
"""


def commands(k: int) -> tuple[float, float]:
    return 0.05 * math.sin(0.05 * k), math.sin(0.02 * k)


@pytest.fixture(scope="module")
def ours() -> np.ndarray:
    plant = Plant(read_model(MODEL))
    plant.reset(VehicleState(t=0.0, x=0.0, y=0.0, yaw=0.0, v=10.0))
    rows = []
    for k in range(TICKS):
        plant.command(*commands(k))
        plant.advance(50)
        rows.append(plant.shown_row()[list(SHOWN)])
    return np.array(rows)


@pytest.mark.parametrize("ticks", [0, pytest.param(TICKS, marks=pytest.mark.nightly)])
def test_the_module_drives_alone_as_our_twin_does(tmp_path, ours, ticks):
    """By day it only begins alone: its first step compiles, which takes longer than all else. The FMU drives by day."""
    assert main(["export", str(MODEL), "--python", str(tmp_path / "twin.py")]) == 0
    command = [sys.executable, "-I", "-c", DRIVE, str(tmp_path), str(ticks)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=True)
    told = json.loads(done.stdout)
    assert not told["ours"]
    assert Path(told["from"]).parent.name.startswith("twin-")
    assert len(told["rows"]) == ticks
    assert np.abs(np.reshape(told["rows"], (ticks, len(SHOWN))) - ours[:ticks]).max(initial=0.0) < 1e-6


fmus = pytest.mark.skipif(
    not all(importlib.util.find_spec(name) for name in ("fmpy", "pythonfmu"))
    or platform.machine().lower() not in ("x86_64", "amd64")
    or sys.platform == "darwin",
    reason="FMUs need the extra fmi, and PythonFMU has no library for other machines",
)


@fmus
def test_the_fmu_drives_as_our_twin_does(tmp_path, ours, monkeypatch):
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    path = tmp_path / "twin.fmu"
    with monkeypatch.context() as patch:  # as after a run of another FMU, whose copy of PythonFMU cannot build
        patch.setitem(sys.modules, "pythonfmu", ModuleType("pythonfmu"))
        assert main(["export", str(MODEL), "--fmu", str(path)]) == 0
    described = fmpy.read_model_description(str(path))
    of = {v.name: v.valueReference for v in described.modelVariables}
    assert [v.name for v in described.modelVariables if v.causality == "input"] == ["steer_cmd", "accel_cmd"]
    slave = FMU2Slave(
        guid=described.guid, unzipDirectory=fmpy.extract(str(path), str(tmp_path / "fmu")),
        modelIdentifier=described.coSimulation.modelIdentifier,
    )  # fmt: skip
    slave.instantiate()
    slave.setReal([of["v0"]], [10.0])
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    assert slave.getReal([of[name] for name in ("x", "v", "yaw_rate")]) == [0.0, 10.0, 0.0]
    rows = []
    for k in range(TICKS):
        slave.setReal([of["steer_cmd"], of["accel_cmd"]], list(commands(k)))
        slave.doStep(k * TICK, TICK)
        rows.append(slave.getReal([of[n] for n in ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")]))
    slave.terminate()
    assert np.abs(np.array(rows) - ours).max() < 1e-6


@fmus
def test_the_fmu_is_compared_as_its_model_is_from_a_start_on_the_move(tmp_path: Path) -> None:
    """The log begins at 10 m/s and shows each command from its stamp on, as every row of a comparison does."""
    model = tmp_path / "car.toml"
    model.write_text(CAR)
    assert main(["export", str(model), "--fmu", str(tmp_path / "car.fmu")]) == 0
    plant = Plant(read_model(model))
    plant.reset(VehicleState(t=0.0, x=30.0, y=-20.0, yaw=1.0, v=10.0))
    rows = []
    for k in range(1000):
        steer, accel = (0.05 if k % 100 < 50 else -0.02), (0.8 if k % 160 < 80 else -0.9)
        plant.command(steer, accel)
        plant.advance(1)
        rows.append([0.02 * k, steer, accel, *plant.shown_row()[list(SHOWN[:7])]])
        plant.advance(19)
    names = ("t", "steer_cmd", "accel_cmd", "x", "y", "yaw", "v", "yaw_rate", "ax", "ay")
    log = Log(dict(zip(names, np.array(rows).T, strict=True)))
    shown = FmuSubject(tmp_path / "car.fmu").output(log, cut(log.t, measured_array(log.columns)))
    for k, name in enumerate(CHANNELS[:7]):
        assert shown[:, k] == pytest.approx(log[name], abs=0.02), name


def test_a_measured_speed_is_no_command_to_export_with(tmp_path, capsys):
    path = tmp_path / "m.toml"
    path.write_text(MODEL.read_text().replace('longitudinal = "accel_cmd"', 'longitudinal = "v"'))
    assert main(["export", str(path), "--python", str(tmp_path / "t.py")]) != 0
    assert "measured" in capsys.readouterr().err
    assert not (tmp_path / "t.py").exists()
