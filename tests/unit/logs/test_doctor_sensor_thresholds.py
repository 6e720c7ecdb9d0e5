"""By how much the rest of a car has to move before a sensor that stays is dead: just not enough, and just enough."""

from __future__ import annotations

import numpy as np
import pytest
from known_motion import motion, times

from openscenario.findings import Findings
from pytest_dvp.doctor.sensor_faults import check_sensors
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray

SPEED = 10.0  # m/s

# Column -> what moves when it must, and from which standard deviation on it is said to move.
LEAST = [
    ("v", "path_speed", 0.3), ("yaw", "yaw_rate", 0.03), ("yaw", "path_turn", 0.05), ("yaw_rate", "turn", 0.03),
    ("yaw_rate", "path_turn", 0.05), ("ax", "accel", 0.2), ("ay", "v*turn", 0.15), ("steer", "turn", 0.05),
    ("steer", "yaw_rate", 0.05),
]  # fmt: skip


def dead(column: str, **witness: FloatArray) -> list[str]:
    """Codes of the findings in a log of one column that never changes, beside what the car does."""
    t = times(120.0)
    findings = Findings()
    check_sensors(Log({"t": t, column: np.full(len(t), 0.5)}), motion(**witness), "log.csv", findings)
    return [finding.code for finding in findings.found]


@pytest.mark.parametrize(("column", "witness", "least"), LEAST)
def test_a_sensor_that_stays_is_dead_if_the_car_moves_enough(column: str, witness: str, least: float) -> None:
    """A sine of 30 s, of which a mean over 2 s leaves 99 %: its standard deviation is its amplitude / sqrt(2)."""
    wave = np.sqrt(2.0) * np.sin(2.0 * np.pi * times(120.0) / 30.0)
    for share, told in ((0.93, []), (1.07, ["log.dead_sensor"])):
        moves = share * least * wave
        if witness == "v*turn":
            assert dead(column, v=np.full(len(wave), SPEED), turn=moves / SPEED) == told
        else:
            assert dead(column, **{witness: moves}) == told


@pytest.mark.parametrize(("period", "told"), [(3.0, []), (3.7, ["log.dead_sensor"])])
def test_what_goes_in_means_over_two_seconds_is_noise_and_not_motion(period: float, told: list[str]) -> None:
    """A mean over 2 s leaves sin(x) / x of a sine, with x = 2 pi / period. Half of it, below which it counts as noise,
    is left at 3.3 s."""
    assert dead("v", path_speed=20.0 + 5.0 * np.sin(2.0 * np.pi * times(120.0) / period)) == told
