"""Each threshold of the doctor just short of it and just past it, on logs with gaps and holes made by count.

The numbers come from what the doctor says of them (docs/logs.md and the text of each finding), not from its answers.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from known_motion import STEP, motion

from openscenario.findings import Findings
from pytest_dvp.doctor.excitation import _missed
from pytest_dvp.doctor.missing_values import check_missing
from pytest_dvp.doctor.redundant_motion import motion_of
from pytest_dvp.doctor.sensor_faults import check_sensors
from pytest_dvp.doctor.speed_and_acceleration import check_speed, check_wishes
from pytest_dvp.doctor.time_base import check_rate, check_stamps
from pytest_dvp.logs.log import Log
from pytest_dvp.logs.log_contents import FloatArray
from vehicle.model.effect_catalogue import catalogue
from vehicle.model.shown_by import BY_SLOT


def codes(findings: Findings) -> list[str]:
    return [finding.code for finding in findings.found]


def stamps(t: FloatArray) -> list[tuple[str, str]]:
    findings = Findings()
    check_stamps(Log({"t": t, "v": np.sin(t)}), "log.csv", findings)
    return [(finding.code, finding.severity) for finding in findings.found]


@pytest.mark.parametrize(("rate", "plausible"), [(0.49, False), (0.51, True), (19_000.0, True), (21_000.0, False)])
def test_stamps_are_seconds_between_half_a_hertz_and_twenty_kilohertz(rate: float, plausible: bool) -> None:
    assert check_rate(Log({"t": np.arange(100) / rate}), "log.csv", None, Findings()) is plausible


@pytest.mark.parametrize(("pause", "told"), [(86_000.0, True), (87_000.0, False), (1.7e9, False)])
def test_no_log_pauses_for_more_than_a_day(pause: float, told: bool) -> None:
    """What comes after has the stamps of another clock; nothing that lays a grid over them may be asked."""
    t = np.arange(500) * STEP
    t[250:] += pause
    findings = Findings()
    assert check_rate(Log({"t": t}), "log.csv", None, findings) is told
    assert [(one.code, one.severity) for one in findings.found] == ([] if told else [("log.gap", "error")])


@pytest.mark.parametrize(("share", "told"), [(0.039, []), (0.041, [("log.jitter", "warning")])])
def test_four_percent_of_the_interval_may_scatter(share: float, told: list[tuple[str, str]]) -> None:
    """Intervals that are long and short by turns: their standard deviation is exactly the share."""
    steps = STEP * (1.0 + share * np.where(np.arange(1001) % 2, 1.0, -1.0))
    steps[0] = STEP  # an odd count with one in the middle: the median is the plain interval
    assert stamps(np.concatenate([[0.0], np.cumsum(steps)])) == told


@pytest.mark.parametrize(("intervals", "told"), [(2.45, []), (2.55, [("log.gap", "warning")])])
def test_a_gap_is_longer_than_two_and_a_half_intervals(intervals: float, told: list[tuple[str, str]]) -> None:
    t = np.arange(500) * 0.1
    t[250:] += (intervals - 1.0) * 0.1
    assert stamps(t) == told


@pytest.mark.parametrize(("lost", "severity"), [(9.5, "warning"), (10.5, "error")])
def test_several_recordings_are_those_with_half_of_the_time_missing(lost: float, severity: str) -> None:
    """10 s of rows, and `lost` more without any."""
    t = np.arange(500) * STEP
    t[250:] += lost
    assert stamps(t) == [("log.gap", severity)]


def holes(lost: int, holes: int) -> list[str]:
    """100 s at 50 Hz that lack `lost` values in each of so many places."""
    t = np.arange(5001) * STEP
    v = np.sin(t)
    for k in range(holes):
        v[200 + 400 * k : 200 + 400 * k + lost] = np.nan
    findings = Findings()
    check_missing(Log({"t": t, "v": v}), "log.csv", findings)
    return codes(findings)


@pytest.mark.parametrize(("lost", "told"), [(23, []), (26, ["log.missing_values"])])
def test_a_hole_may_last_half_a_second(lost: int, told: list[str]) -> None:
    """From the last value before to the first one after: one interval more than values are lost, 0.48 and 0.54 s."""
    assert holes(lost, 1) == told


@pytest.mark.parametrize(("places", "told"), [(9, []), (11, ["log.missing_values"])])
def test_two_percent_of_the_time_may_be_missing(places: int, told: list[str]) -> None:
    """10 values, 0.2 s, in each place of 100 s: 1.8 and 2.2 %."""
    assert holes(10, places) == told


@pytest.mark.parametrize(("late", "samples", "told"), [(0.4, 9, []), (0.6, 9, ["log.missing_values"]), (0.6, 11, [])])
def test_between_two_samples_of_a_slower_channel_nothing_is_missing(late: float, samples: int, told: list[str]) -> None:
    """A channel of 1 Hz with some samples `late` [s] late by turns: so many of its 99 intervals are 1.4 or 1.6 s. A
    hole is longer than one and a half of its own, 1 s. With a tenth of them uneven it is a channel without a clock."""
    t = np.arange(5001) * STEP
    v = np.full(len(t), np.nan)
    at = np.arange(100.0)
    at[30 : 30 + 2 * samples : 2] += late
    v[np.round(at / STEP).astype(int)] = at
    findings = Findings()
    check_missing(Log({"t": t, "v": v}), "log.csv", findings)
    assert codes(findings) == told


@pytest.mark.parametrize(("seconds", "told"), [(0.9, []), (1.1, ["log.dead_sensor"])])
def test_a_sensor_is_dead_after_a_second_without_any_change(seconds: float, told: list[str]) -> None:
    """The car brakes by 8 m/s^2 all along: its speed over ground changes while v does not."""
    t = np.arange(1000) * STEP
    v = 200.0 - 8.0 * t
    v[400 : 400 + round(seconds / STEP) + 1] = v[400]
    findings = Findings()
    check_sensors(Log({"t": t, "v": v}), motion(path_speed=200.0 - 8.0 * t), "log.csv", findings)
    assert codes(findings) == told


@pytest.mark.parametrize(
    ("stretches", "rows", "told"),
    [(10, 3, []), (10, 4, ["log.saturated"]), (7, 4, []), (8, 4, ["log.saturated"])],
    ids=["three in a row", "four in a row", "28 of 10,000 rows", "32 of 10,000 rows"],
)
def test_a_sensor_is_saturated_in_three_of_a_thousand_rows_of_which_four_follow_each_other(
    stretches: int, rows: int, told: list[str]
) -> None:
    """Never fewer than 20 rows in all; 0.3 % of 10,000 rows are 30."""
    t = np.arange(10_000) * STEP
    ax = np.random.default_rng(2).normal(size=len(t)).clip(-4.0, 4.0) * 0.5
    for k in range(stretches):
        ax[500 * (k + 1) : 500 * (k + 1) + rows] = 3.0
    findings = Findings()
    check_sensors(Log({"t": t, "ax": ax}), motion(v=np.ones(len(t))), "log.csv", findings)
    assert codes(findings) == told


@pytest.mark.parametrize(
    ("gain", "largest", "told"),
    [(3.9, 2.0, []), (4.1, 2.0, ["log.unit_suspect"]), (0.26, 20.0, []), (0.24, 20.0, ["log.unit_suspect"]),
     (0.24, 11.9, []), (0.24, 12.2, ["log.unit_suspect"])],
)  # fmt: skip
def test_a_drive_answers_with_a_quarter_to_four_times_what_a_driver_asks_for(
    gain: float, largest: float, told: list[str]
) -> None:
    """Steps between two levels, so that the 98th percentile is the largest; no driver asks for more than 12 m/s^2."""
    t = np.arange(3000) * STEP
    wish = largest * np.sign(np.sin(0.7 * t) + 1e-9)
    findings = Findings()
    check_wishes(motion(accel=gain * wish, accel_cmd=wish), "log.csv", findings)
    assert codes(findings) == told


def drives() -> list[tuple[str, float, str]]:
    rules = [effect.shown_by for effect in catalogue().values() if effect.shown_by] + list(BY_SLOT.values())
    return sorted({drive for rule in rules for drive in (*rule.drives, *rule.usual)})


@pytest.mark.parametrize(("fact", "least", "text"), drives())
def test_what_a_drive_lacks_is_said_with_the_number_that_decides(fact: str, least: float, text: str) -> None:
    number = re.search(r"\d+(\.\d+)?", text)
    assert number is not None
    assert float(number[0]) == least
    assert _missed(((fact, least, text),), {fact: 0.99 * least}) == f"needs {text}"
    assert _missed(((fact, least, text),), {fact: least}) == ""


@pytest.mark.parametrize(("grips", "told"), [(0.13, "log.unit_suspect"), (0.17, "log.wheel_slip")])
def test_wheels_that_lock_on_a_slippery_road_are_no_wrong_unit(grips: float, told: str) -> None:
    """Over ground 10 m/s throughout; the wheels turn as fast for a share of it, elsewhere at 20 to 70 %."""
    t = np.arange(0.0, 60.0, STEP)
    slip = np.where(t < grips * t[-1], 1.0, 0.45 + 0.25 * np.sin(t))
    motion = motion_of(Log({"t": t, "x": 10.0 * t, "y": 0.0 * t, "yaw": 0.0 * t, "v": 10.0 * slip}))
    assert motion is not None
    findings = Findings()
    check_speed(motion, "log.csv", findings)
    assert [(f.code, f.severity == "warning") for f in findings.found] == [(told, told == "log.wheel_slip")]


@pytest.mark.parametrize(("jitter", "lost"), [(0.0, False), (0.4, False), (0.0, True)])
def test_an_uneven_channel_among_others_lacks_nothing(jitter: float, lost: bool) -> None:
    """A pose at 33 Hz whose stamps scatter, in the rows of four files: only samples that were lost are missing."""
    rng = np.random.default_rng(5)
    at = 0.03 * (np.arange(1000) + jitter * rng.uniform(-1.0, 1.0, 1000))
    at = np.delete(at, np.arange(10, 990, 10)) if lost else at
    others = np.sort(rng.uniform(0.0, 30.0, 3000))
    t = np.union1d(at, others)
    x = np.where(np.isin(t, at), 1.0 + t, np.nan)
    findings = Findings()
    check_missing(Log({"t": t, "x": x}), "drive.csv", findings)
    assert [each.code for each in findings.in_order()] == (["log.missing_values"] if lost else [])
