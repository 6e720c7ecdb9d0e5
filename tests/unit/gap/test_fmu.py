"""A real FMU, built by PythonFMU, as the model of a car. PythonFMU brings its library for x86-64 Linux and Windows."""

from __future__ import annotations

import importlib.util
import platform
import re
import subprocess
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from gap_logs import WHEELBASE, baseline, drive

from pytest_dvp.gap.compare.compare import compare
from pytest_dvp.gap.compare.compared_model import CompareError
from pytest_dvp.gap.compare.fmu_model import FmuSubject
from pytest_dvp.gap.compare.model_loader import load_compared_model
from pytest_dvp.gap.compare.segments import CHANNELS, cut, measured_array
from pytest_dvp.logs.log import Log
from vehicle.model.effect import Effect
from vehicle.model.effect_catalogue import find_effect

pytestmark = [
    pytest.mark.skipif(importlib.util.find_spec("fmpy") is None, reason="FMUs need the extra fmi"),
    pytest.mark.skipif(importlib.util.find_spec("pythonfmu") is None, reason="PythonFMU builds the FMU of these tests"),
    pytest.mark.skipif(
        platform.machine().lower() not in ("x86_64", "amd64") or sys.platform == "darwin",
        reason="PythonFMU has no library for this machine",
    ),
]

SLAVE = f"""
import math
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Bicycle(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.steer_cmd = self.accel_cmd = self.x = self.y = self.yaw = self.v = self.yaw_rate = 0.0
        for name in ("steer_cmd", "accel_cmd"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("x", "y", "yaw", "v", "yaw_rate"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        after = max(self.v + self.accel_cmd * step_size, 0.0)
        bend = math.tan(self.steer_cmd) / {WHEELBASE}
        way = 0.5 * (self.v + after) * step_size
        heading = self.yaw + 0.5 * way * bend
        self.x, self.y = self.x + way * math.cos(heading), self.y + way * math.sin(heading)
        self.yaw, self.v, self.yaw_rate = self.yaw + way * bend, after, after * bend
        return True
"""


def built(folder: Path, *options: str) -> Path:
    (folder / "bicycle.py").write_text(SLAVE)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "bicycle.py", "-d", ".", *options]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder / "Bicycle.fmu"


@pytest.fixture(scope="module")
def bicycle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("fmu"))


def test_fmu_of_the_car_leaves_the_noise(bicycle: Path) -> None:
    log = drive()
    found, ours = compare(log, load_compared_model(str(bicycle))), compare(log, baseline())
    for name in ("x", "y", "yaw", "v", "yaw_rate"):
        assert found.signals[name].chi2_per_n == pytest.approx(ours.signals[name].chi2_per_n, abs=0.01)
    assert found.not_compared["ax"] == "the model does not give it"


UNITS = """<UnitDefinitions><Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit>
<Unit name="degree per s"><BaseUnit rad="1" s="-1" factor="0.017453292519943295"/></Unit>
<Unit name="km/h"><BaseUnit m="1" s="-1" factor="0.2777777777777778"/></Unit></UnitDefinitions>"""


def declaring(fmu: Path, to: Path, units: Mapping[str, str]) -> Path:
    """The FMU with units of its variables in its description, which its numbers are then in."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(to, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                text = content.decode().replace("<LogCategories", UNITS + "<LogCategories", 1)
                for variable, unit in units.items():
                    text = re.sub(rf'(<ScalarVariable name="{variable}"[^>]*>\s*<Real)', rf'\1 unit="{unit}"', text)
                content = text.encode()
            new.writestr(name, content)
    return to


def test_values_in_a_declared_unit_are_converted(bicycle: Path, tmp_path: Path) -> None:
    """The FMU takes and shows the same numbers and calls them km/h, degrees and degrees per second."""
    t = np.arange(200) * 0.02
    steer, accel = np.where(t % 2.0 < 1.0, 0.1, -0.1), np.where(t < 1.0, 5.0, 0.0)
    log = Log({"t": t, "v": np.minimum(5.0 * t, 5.0), "steer_cmd": steer, "accel_cmd": accel})
    segments = cut(log.t, measured_array(log.columns))
    units = {"v": "km/h", "yaw": "deg", "yaw_rate": "degree per s", "steer_cmd": "deg"}
    plain = FmuSubject(bicycle).output(Log({**log.columns, "steer_cmd": np.degrees(steer)}), segments)
    shown = FmuSubject(declaring(bicycle, tmp_path / "deg.fmu", units)).output(log, segments)
    for name, factor in (("x", 1.0), ("v", 1.0 / 3.6), ("yaw_rate", np.pi / 180.0)):
        k = CHANNELS.index(name)
        assert shown[:, k] == pytest.approx(factor * plain[:, k], abs=1e-9)


def test_unit_that_is_none_of_the_signal_is_refused(bicycle: Path, tmp_path: Path) -> None:
    odd = declaring(bicycle, tmp_path / "odd.fmu", {"yaw_rate": "km/h"})
    with pytest.raises(CompareError, match=r"odd\.fmu: yaw_rate is declared in 'km/h'; allowed: rad/s, deg/s"):
        compare(drive(20.0), FmuSubject(odd))


def test_time_in_which_an_input_was_not_logged_does_not_count(tmp_path: Path) -> None:
    """The input has a name of its own, which does not say that it is a command."""
    (tmp_path / "bicycle.py").write_text(SLAVE.replace("steer_cmd", "wanted_angle"))
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "bicycle.py", "-d", "."]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    log = drive(40.0)
    silent = (log.t >= 10.0) & (log.t < 20.0)
    columns = {**log.columns, "wanted_angle": np.where(silent, np.nan, log["steer_cmd"])}
    del columns["steer_cmd"]
    found = compare(Log(columns), FmuSubject(tmp_path / "Bicycle.fmu"))
    assert found.alignment.coverage == pytest.approx(0.75, abs=0.02)
    assert found.signals["yaw_rate"].chi2_per_n == pytest.approx(1.0, abs=0.2)


def test_row_shows_the_command_of_its_stamp_already_acting(bicycle: Path) -> None:
    t = np.arange(200) * 0.02
    steer = np.where(t % 2.0 < 1.0, 0.1, -0.1)
    accel = np.where(t < 1.0, 5.0, 0.0)
    log = Log({"t": t, "v": np.minimum(5.0 * t, 5.0), "steer_cmd": steer, "accel_cmd": accel})
    shown = FmuSubject(bicycle).output(log, cut(t, measured_array(log.columns)))
    expected = np.minimum(5.0 * t, 5.0) * np.tan(steer) / WHEELBASE
    assert shown[:, CHANNELS.index("yaw_rate")] == pytest.approx(expected, abs=5.0 * 2e-5 * 0.05)


def test_stamps_of_a_real_clock_need_no_step_of_one_length(bicycle: Path) -> None:
    t = np.arange(200) * 0.02 + np.random.default_rng(1).uniform(-0.004, 0.004, 200)
    accel = np.where(np.arange(200) < 100, 2.0, 0.0)
    log = Log({"t": t, "v": np.zeros(200), "steer_cmd": np.zeros(200), "accel_cmd": accel})
    shown = FmuSubject(bicycle).output(log, cut(t, measured_array(log.columns)))
    expected = np.concatenate([[0.0], np.cumsum(accel[:-1] * np.diff(t))])
    assert shown[:, CHANNELS.index("v")] == pytest.approx(
        expected, abs=2.0 * 2.8e-5
    )  # a thousandth of the longest step


def test_fmu_of_one_step_length_keeps_to_it(tmp_path: Path) -> None:
    found = compare(drive(), load_compared_model(str(built(tmp_path, "--no-variable-step"))))
    assert found.signals["v"].chi2_per_n == pytest.approx(1.0, abs=0.1)


def test_dead_time_in_front_of_an_fmu(bicycle: Path) -> None:
    log, box = drive(noise=0.0, steer_delay=0.2), FmuSubject(bicycle)
    segments = cut(log.t, measured_array(log.columns))
    shown = box.output(log, segments, {("steer_delay", "T"): 0.2})[:, CHANNELS.index("yaw_rate")]
    assert shown == pytest.approx(log["yaw_rate"], abs=1e-3)
    biased = box.output(log, segments, {("steer_delay", "T"): 0.2, ("gyro_bias", "b"): 0.03})
    assert biased[:, CHANNELS.index("yaw_rate")] == pytest.approx(shown + 0.03)


@pytest.mark.parametrize(
    ("effect", "reason"),
    [
        (find_effect("steer_lag"), ""),
        (find_effect("gyro_bias"), ""),
        (find_effect("pitch"), "the model gives no ax"),
        (find_effect("aero_drag"), "acts inside the model (force)"),
    ],
)
def test_which_effects_can_be_judged_is_said(bicycle: Path, effect: Effect, reason: str) -> None:
    given = ("x", "y", "yaw", "v", "yaw_rate")
    assert FmuSubject(bicycle).why_not(effect, drive(20.0), given) == reason


def test_input_that_the_log_lacks_is_named(bicycle: Path) -> None:
    log = drive(20.0)
    bare = Log({name: column for name, column in log.columns.items() if name != "accel_cmd"})
    with pytest.raises(CompareError, match="accel_cmd"):
        compare(bare, FmuSubject(bicycle))
