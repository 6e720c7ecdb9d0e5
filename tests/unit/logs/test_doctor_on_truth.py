"""The doctor on logs of simulated cars with hidden effects: physics is no defect, and dirt on physics is found."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from pytest_dvp.doctor import examine
from pytest_dvp.doctor.excitation import excitation
from pytest_dvp.logs.log import Log
from tests.truth.dirty import KINDS, dirty
from tests.truth.effects import KNOWN
from tests.truth.generate import make_log
from vehicle.model.effect_catalogue import catalogue

# A late sensor and a clock that is off are one thing to a log.
SAME_AS_A_CLOCK = {"gnss_latency": "column x, y, yaw", "yaw_rate_latency": "column yaw_rate"}

FOUND = {
    "jitter": ("log.jitter", "column t"),
    "gnss_jumps": ("log.position_jump", "column x"),
    "dropouts": ("log.missing_values", "column x, y, yaw"),
    "gap": ("log.gap", "column t"),
    "duplicated_stamps": ("log.duplicate_stamps", "column t"),
    "reversed_stamps": ("log.time_not_monotonic", "column t"),
    "concatenated": ("log.concatenated", "column x"),
    "degrees_as_radians": ("log.implausible_range", "column steer_cmd"),
    "kmh_as_mps": ("log.unit_suspect", "column v"),
    "sign_flip": ("log.sign_flipped", "column yaw_rate"),
    "axis_swap": ("log.axes_swapped", "column ax"),
    "clock_offset": ("log.clock_offset", "column steer_cmd, accel_cmd"),
    "saturated": ("log.saturated", "column yaw_rate"),
    "dead": ("log.dead_sensor", "column ay"),
    "steering_report_is_the_command": ("log.steer_is_command", "column steer"),
    # mixed rates and coarse steps are how logs are: nothing to repair
}


def told(columns: Mapping[str, np.ndarray]) -> set[tuple[str, str]]:
    log = Log(columns={name: np.ascontiguousarray(values, dtype=float) for name, values in columns.items()})
    return {(finding.code, finding.element) for finding in examine(log)}


@pytest.mark.parametrize("effect", sorted(set(KNOWN) & set(catalogue())))
@pytest.mark.nightly(by_day=8)
def test_an_effect_in_the_middle_of_its_range_is_no_defect(effect: str) -> None:
    values = {key.name: 0.5 * (key.low + key.high) for key in catalogue()[effect].parameters}
    expected = {("log.clock_offset", SAME_AS_A_CLOCK[effect])} if effect in SAME_AS_A_CLOCK else set()
    assert told(make_log({effect: values}, "rich", seed=2)) == expected


@pytest.mark.parametrize("drive", ["rich", pytest.param("urban", marks=pytest.mark.nightly)])
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_dirt_is_found(kind: str, drive: str) -> None:
    found = told(dirty(make_log({}, drive, seed=3), kind, seed=3))  # type: ignore[arg-type]
    assert found == ({FOUND[kind]} if kind in FOUND else set())


def test_commands_that_come_after_the_answer_are_told() -> None:
    columns = make_log({}, "rich", seed=4)
    late = {name: np.interp(columns["t"] - 0.3, columns["t"], columns[name]) for name in ("steer_cmd", "accel_cmd")}
    assert told({**columns, **late}) == {("log.clock_offset", "column steer_cmd, accel_cmd")}


def test_a_lateral_acceleration_in_g_accuses_no_other_column() -> None:
    columns = make_log({}, "rich", seed=4)
    assert told({**columns, "ay": columns["ay"] / 9.80665}) == {("log.unit_suspect", "column ay")}


def test_what_is_missing_is_told_as_it_is() -> None:
    columns = make_log({}, "rich", seed=4)
    still = excitation(Log({**columns, "steer_cmd": 0.0 * columns["t"]})).out_of_reach
    assert still["steer_delay"] == "needs a column steer_cmd that changes"
    blind = {name: values for name, values in columns.items() if name not in ("x", "y", "yaw", "v")}
    nowhere = excitation(Log(blind)).out_of_reach
    assert nowhere["steer_ratio"] == "needs the speed of the car (a column v, or x and y)"
    assert nowhere["wheel_radius"] == "needs a column v"
