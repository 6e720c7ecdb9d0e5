"""Each limit of the doctor's look at clocks, just short of it and just past it."""

from __future__ import annotations

import numpy as np
import pytest
from known_motion import findings, rate_and_integral, times, way

from pytest_dvp.logs.log_contents import FloatArray

SPEED = 10.0  # m/s
SLOW = (0.04, 0.09)  # Hz: a mean over 0.4 s leaves 99.8 % of it
LIVELY = (0.1, 0.9)  # Hz


def offsets(columns: dict[str, FloatArray]) -> list[str]:
    return [finding.element for finding in findings(columns, "log.clock_offset")]


def of_known_deviation(deviation: float, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A slow signal with this standard deviation in the log, its integral, and the same signal 0.3 s later."""
    rate, integral = rate_and_integral(*SLOW)
    scale = deviation / float(np.std(rate(t)))
    return scale * rate(t), scale * integral(t), scale * rate(t - 0.3)


def late(channel: str, seconds: float) -> dict[str, FloatArray]:
    """A log in which one channel comes late, and the others tell so."""
    t = times(60.0)
    rate, integral = rate_and_integral(*LIVELY)
    if channel == "yaw_rate":
        return {"t": t, "yaw": 0.1 * integral(t), "yaw_rate": 0.1 * rate(t - seconds)}
    if channel == "ay":
        lateral = 0.1 * SPEED * rate(t - seconds)
        v, yaw = np.full(len(t), SPEED), 0.1 * integral(t)
        return {"t": t, "v": v, "yaw": yaw, "yaw_rate": 0.1 * rate(t), "ay": lateral}
    if channel == "ax":
        v = SPEED + integral(t)
        return {"t": t, **way(t, v, np.zeros(len(t))), "v": v, "ax": rate(t - seconds)}
    v = SPEED + 2.0 * rate(t)
    return {"t": t, **way(t, v, np.zeros(len(t))), "v": SPEED + 2.0 * rate(t - seconds)}


@pytest.mark.parametrize(("channel", "allowed"), [("yaw_rate", 0.08), ("v", 0.08), ("ay", 0.16), ("ax", 0.15)])
def test_a_clock_may_be_off_by_as_much_as_the_place_of_its_sensor_explains(channel: str, allowed: float) -> None:
    assert offsets(late(channel, 0.93 * allowed)) == []
    assert offsets(late(channel, 1.07 * allowed)) == [f"column {channel}"]


@pytest.mark.parametrize("seconds", [1.9, 2.1, 18.0, 37.0])
def test_a_clock_that_was_set_apart_is_told_with_the_seconds(seconds: float) -> None:
    """GPS time is 18 s ahead of UTC, TAI 37 s."""
    t = times(200.0)
    rate, integral = rate_and_integral(*LIVELY)
    told = findings({"t": t, "yaw": 0.1 * integral(t), "yaw_rate": 0.1 * rate(t - seconds)}, "log.clock_offset")
    assert [finding.message.partition(" than")[0] for finding in told] == [f"yaw_rate comes {seconds:.2f} s later"]


@pytest.mark.parametrize("seconds", [2.3, 2.5, 3.0])
def test_a_clock_that_is_seconds_off_is_no_wrong_sign(seconds: float) -> None:
    """A gyro that comes late by half a period of a slow slalom looks like one that is turned round."""
    t = times(120.0)
    rate, integral = rate_and_integral(0.1, 0.25)
    log = {"t": t, "v": np.full(len(t), SPEED), "yaw": 0.1 * integral(t), "yaw_rate": 0.1 * rate(t - seconds)}
    (told,) = findings(log, "log.sign_flipped", "log.clock_offset")
    assert told.message.startswith(f"yaw_rate comes {seconds:.2f} s later")


@pytest.mark.parametrize(("channel", "least"), [("yaw_rate", 0.02), ("ay", 0.3), ("ax", 0.3), ("v", 0.5)])
def test_a_clock_is_judged_by_channels_that_vary_enough(channel: str, least: float) -> None:
    """The channel comes 0.3 s late in all of them; its standard deviation is just too small, or just large enough."""
    t = times(120.0)
    for share, told in ((0.95, []), (1.05, [f"column {channel}"])):
        signal, integral, delayed = of_known_deviation(share * least, t)
        columns = {
            "yaw_rate": {"yaw": integral, "yaw_rate": delayed},
            "ay": {"v": np.full(len(t), SPEED), "yaw": integral / SPEED, "yaw_rate": signal / SPEED, "ay": delayed},
            "ax": {**way(t, SPEED + integral, np.zeros(len(t))), "v": SPEED + integral, "ax": delayed},
            "v": {**way(t, SPEED + signal, np.zeros(len(t))), "v": SPEED + delayed},
        }[channel]
        assert offsets({"t": t, **columns}) == told


@pytest.mark.parametrize(("deviation", "told"), [(0.028, "column yaw_rate"), (0.032, "column yaw")])
def test_a_path_that_turns_enough_tells_which_clock_is_off(deviation: float, told: str) -> None:
    """Yaw and yaw_rate disagree by 0.3 s. The path turns with yaw_rate, which it can say from 0.03 rad/s on; before
    that nothing tells which of the two is off."""
    t = times(120.0)
    signal, integral, _ = of_known_deviation(deviation, t)
    late_yaw = np.interp(t - 0.3, t, integral)
    columns = {"t": t, "v": np.full(len(t), SPEED), "yaw": late_yaw, "yaw_rate": signal}
    assert offsets({**columns, **way(t, columns["v"], integral)}) == [told]


@pytest.mark.parametrize(("ahead", "told"), [(0.5, ["yaw_rate"]), (0.57, ["x, y", "yaw_rate"])])
def test_a_path_may_turn_four_tenths_of_a_second_early_by_the_place_of_the_antenna(
    ahead: float, told: list[str]
) -> None:
    """0.4 s, and a quarter of the time itself, for a lag is known no better: 0.4 / 0.75 = 0.53 s. Yaw_rate is late, and
    explains all there is if the path is not; else the clock of the positions is off, too."""
    t = times(60.0)
    rate, integral = rate_and_integral(*LIVELY)
    v = np.full(len(t), SPEED)
    columns = {"t": t, "v": v, "yaw": 0.1 * integral(t), "yaw_rate": 0.1 * rate(t - 0.2)}
    found = offsets({**columns, **way(t, v, 0.1 * integral(t + ahead))})
    assert sorted(found) == [f"column {name}" for name in told]


@pytest.mark.parametrize(("ends", "told"), [(100.4, []), (120.4, ["from t = 60 to 120 s only"])])
def test_a_clock_that_is_late_for_two_parts_of_thirty_seconds_is_told(ends: float, told: list[str]) -> None:
    """Parts are counted from the first mean on, 0.4 s after the first row. Up to 100 s one part is late, and a third of
    the next; up to 120 s two whole parts are."""
    t = times(215.0)
    rate, integral = rate_and_integral(*LIVELY)
    delay = np.where((t >= 60.4) & (t < ends), 1.0, 0.0)
    found = findings({"t": t, "yaw": 0.1 * integral(t), "yaw_rate": 0.1 * rate(t - delay)}, "log.clock_offset")
    assert [each.text.partition(" tell ")[2] for each in found] == told
