"""The guard: a mass that tuning turned up because the twin lacks an effect is reported with that effect."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from pytest_dvp.logs.log import Log
from pytest_dvp.tuning.data_sheet_reset import chi2, reset_to_data_sheet
from pytest_dvp.tuning.implausible_values import find_implausible_values
from pytest_dvp.tuning.tuned_parameter import Knob
from tests.truth.generate import make_log
from vehicle.model.model_file import read_model
from vehicle.model.simulator_parameters import apply_s, preset_s
from vehicle.sensors import default_sensors

CAR = "[parameters]\nwheelbase = 2.45\ncg_to_front_axle = 1.15\nmass = 730.0\nyaw_inertia = 900.0\n"
MASS = Knob("S.EGO_mass", "kg", (730.0, 1000.0, 8500.0), (650.0, 1100.0))


@pytest.fixture(scope="module")
def twin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("twin") / "twin.toml"
    file.write_text(CAR, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def sluggish(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """45 s through town of a car of 730 kg whose drive answers late, with a lag of 0.5 s."""
    file = tmp_path_factory.mktemp("logs") / "sluggish.mcap"
    Log(make_log({"drive_lag": {"tau": 0.5}}, "urban", 1)).save(file)
    return file


@pytest.mark.nightly
def test_a_mass_that_no_car_has_is_reported_with_the_effect_that_explains_it(twin: Path, sluggish: Path) -> None:
    found = find_implausible_values([MASS], {"S.EGO_mass": 730.0}, {"S.EGO_mass": 8500.0}, [sluggish], twin)
    assert [s.why for s in found] == ["outside"]
    name, _, _, value, _ = found[0].effect.split()
    assert (name, float(value)) == ("drive_lag", pytest.approx(0.5, rel=0.05))
    assert "is outside 650 to 1100 kg" in found[0].sentence


@pytest.mark.nightly
def test_a_plausible_mass_that_stands_in_for_an_effect_is_reported_too(twin: Path, sluggish: Path) -> None:
    found = find_implausible_values([MASS], {"S.EGO_mass": 730.0}, {"S.EGO_mass": 1000.0}, [sluggish], twin)
    assert [s.why for s in found] == ["stands for"]
    assert found[0].effect.startswith("drive_lag")


@pytest.mark.nightly
def test_an_error_across_the_road_hides_no_stand_in_along_it(twin: Path, tmp_path: Path) -> None:
    """A dead time of the throttle for a lag of 0.5 s; the steering's ratio, of which it says nothing, is off by far
    more. Along the road the true lag leaves the noise of v and ax, chi^2/N about 1."""
    file = tmp_path / "log.mcap"
    Log(make_log({"drive_lag": {"tau": 0.5}, "steer_ratio": {"g": 0.7}}, "urban", 1)).save(file)
    delay = Knob("S.THROTTLE_delay", "s", (0.0, 0.3), (0.0, 0.5))
    found = find_implausible_values([delay], {delay.name: 0.0}, {delay.name: 0.3}, [file], twin)
    assert [s.why for s in found] == ["stands for"]
    name, _, _, value, _ = found[0].effect.split()
    assert (name, float(value)) == ("drive_lag", pytest.approx(0.5, rel=0.05))
    assert found[0].channels == ("v", "ax")
    assert found[0].explained is not None
    assert found[0].explained < 2.0 < found[0].tuned


def test_what_did_not_move_and_is_plausible_is_no_suspect(twin: Path, sluggish: Path) -> None:
    assert find_implausible_values([MASS], {"S.EGO_mass": 730.0}, {"S.EGO_mass": 730.0}, [sluggish], twin) == []


def test_what_the_simulator_has_and_the_car_lacks_is_set_back(twin: Path, sluggish: Path) -> None:
    """The presets of the paper's 1st iteration on a car that has none of them, though they mimic its lag a little."""
    sheet = read_model(twin)
    spoilt, _ = apply_s(sheet, default_sensors(car=sheet.car), preset_s(1))
    logs = {"a": Log.load(sluggish)}
    found = reset_to_data_sheet(spoilt, sheet, logs, math.inf)
    assert found.model.car.mass == 730.0
    assert {a.name for a in found.model.effects} == {"steer_angle_limit"}
    assert found.after == pytest.approx(chi2(sheet, logs), rel=0.01)


def test_what_the_logs_need_stays(twin: Path, sluggish: Path) -> None:
    """Half a second of lag is not given up for five percent, whatever the sheet says."""
    sheet = read_model(twin)
    late = sheet.with_effect("drive_delay", {"T": 0.4})
    assert reset_to_data_sheet(late, sheet, {"a": Log.load(sluggish)}).model.value("drive_delay", "T") == 0.4
