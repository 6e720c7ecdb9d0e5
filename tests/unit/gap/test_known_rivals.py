"""What is known and may explain an error as well as a law does: it must be fitted as well as it can be."""

from __future__ import annotations

import numpy as np
import pytest

from pytest_dvp.gap.diagnose.experiment import ExperimentSet, Values, experiment_set
from pytest_dvp.gap.diagnose.linear_algebra import square
from pytest_dvp.gap.discover.known_rivals import known_rivals
from pytest_dvp.logs.log import Log
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.model_file import parse_model
from vehicle.model.open_loop import Replay

SHEET = '[model]\nbase = "kinematic_bicycle"\n[parameters]\nwheelbase = 2.7\nmass = 1500.0\n'
NOISE = {"x": 0.02, "y": 0.02, "yaw": 0.005, "v": 0.03, "yaw_rate": 0.005, "ax": 0.1, "ay": 0.1}
OFF = {("steer_ratio", "g"): 0.97, ("drive_gain", "g"): 0.98, ("brake_gain", "g"): 1.05}


def driven(seed: int, *, resistance: float) -> Log:
    """40 s of a car whose gains, and its resistance, are not those of the sheet."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 40.0, 0.02)
    part = (t // 2.0).astype(int)
    accel = np.where(t < 4.0, 2.0, rng.choice([-1.5, 0.0, 1.0, 2.0], part[-1] + 1)[part])
    commands = {"accel_cmd": accel, "steer_cmd": np.interp(t, np.arange(41.0), rng.uniform(-0.15, 0.15, 41))}
    car = parse_model(SHEET)
    for (effect, key), value in OFF.items():
        car = car.with_effect(effect, {key: value})
    if resistance:
        car = car.with_effect("rolling_resistance", {"c": resistance})
    rows = Replay(car, t, commands).run({}, starts=np.array([0]), states=np.array([[0.0] * 4 + [np.nan] * 2]))
    noisy = {name: rows[:, k] + sigma * rng.standard_normal(len(t)) for k, (name, sigma) in enumerate(NOISE.items())}
    return Log({"t": t, **commands, **noisy})


def chi2(data: ExperimentSet, values: Values) -> float:
    return square(data.whitened(values)) / data.count


@pytest.mark.parametrize("resistance", [0.0, 0.015])
def test_a_calibration_that_is_a_little_off_is_fitted_down_to_the_noise(resistance: float) -> None:
    """The fit begins at no resistance and no drag, and must neither stay there nor be held away from it."""
    model = parse_model(SHEET)
    target = experiment_set({"a": driven(1, resistance=resistance)}, model)
    judge = experiment_set({"b": driven(2, resistance=resistance)}, model)
    calibrated = next(known_rivals(target, judge, model, catalogue(), lambda text: None))
    assert "its calibration fitted again" in calibrated.text
    true = OFF | {("rolling_resistance", "c"): resistance}
    assert calibrated.left < chi2(target, true) + 0.01
    assert calibrated.judged < chi2(judge, true) + 0.03
    assert chi2(target, {}) > chi2(target, true) + 0.3  # so there was something to fit
