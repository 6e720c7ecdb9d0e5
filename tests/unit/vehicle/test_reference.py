"""The surrogate's reference system: errors of the size and the correlation that are declared."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from vehicle.messages import VehicleState
from vehicle.surrogate.hidden import Hidden, HiddenError, read_hidden
from vehicle.surrogate.reference import UNITS, Reference, ReferenceSystem, reference_of

PERIOD = 0.01
STILL = VehicleState(t=0.0, x=10.0, y=-4.0, yaw=0.5, v=3.0, vx=3.0, yaw_rate=0.1, ax=0.5, ay=0.3)


def errors(reference: Reference, seed: int, count: int) -> np.ndarray:
    """Rows (count, 7) of shown - true: x, y, yaw, v, yaw_rate, ax, ay of a car that does the same all the time."""
    system = ReferenceSystem(reference, seed, PERIOD)
    names = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay")
    shown = [system.show(STILL) for _ in range(count)]
    return np.array([[getattr(s, n) - getattr(STILL, n) for n in names] for s in shown])


def test_an_ideal_one_shows_the_truth() -> None:
    assert ReferenceSystem(reference_of({"unit": "ideal"}), 1, PERIOD).show(STILL) == STILL


def test_it_errs_unless_something_else_is_said() -> None:
    assert Hidden().reference == reference_of({}) == UNITS["rtk"] != Reference()


def test_same_seed_same_errors() -> None:
    assert np.array_equal(errors(UNITS["rtk"], 5, 50), errors(UNITS["rtk"], 5, 50))
    assert not np.array_equal(errors(UNITS["rtk"], 5, 50), errors(UNITS["rtk"], 6, 50))


def test_white_noise_has_the_declared_size() -> None:
    """Standard deviation of 4,000 samples: known to 1.1 %, so 5 % is more than 4 standard errors."""
    found = errors(Reference(position_noise=0.02, heading_noise=0.01, speed_noise=0.05, accel_noise=0.2), 3, 4000)
    assert found.std(axis=0) == pytest.approx([0.02, 0.02, 0.01, 0.05, 0.0, 0.2, 0.2], rel=0.05, abs=1e-12)


def test_drift_wanders_with_its_correlation_time() -> None:
    """Of a Gauss-Markov process: correlation exp(-lag / time), and the same spread over many drives at any time."""
    found = np.array(
        [errors(Reference(position_drift=0.1, drift_time=1.0), seed, 101)[[0, 100], 0] for seed in range(800)]
    )
    assert found.std(axis=0) == pytest.approx([0.1, 0.1], rel=0.11)
    assert np.corrcoef(found.T)[0, 1] == pytest.approx(math.exp(-1.0), abs=0.13)


def test_biases_stay_for_a_drive_and_change_between_drives() -> None:
    found = [errors(Reference(yaw_rate_bias=0.01, accel_bias=0.1), seed, 30) for seed in range(200)]
    assert all(np.ptp(one, axis=0).max() < 1e-12 for one in found)
    first = np.array([one[0] for one in found])
    assert first[:, 4].std() == pytest.approx(0.01, rel=0.2)
    assert first[:, 5].std() == pytest.approx(0.1, rel=0.2)


def test_a_wrong_place_and_a_turned_mounting_act_in_the_cars_frame() -> None:
    """The place moves by the same length whatever the heading; a turn keeps the size of the acceleration."""
    system = ReferenceSystem(Reference(arm=0.5, mounting=0.3), 4, PERIOD)
    ahead, turned = (system.show(VehicleState(t=0.0, x=0.0, y=0.0, yaw=yaw, v=0.0, ax=1.0, ay=2.0))
                     for yaw in (0.0, 0.5 * math.pi))  # fmt: skip
    assert (turned.x, turned.y) == pytest.approx((-ahead.y, ahead.x))
    assert math.hypot(ahead.ax, ahead.ay) == pytest.approx(math.sqrt(5.0))
    assert ahead.ax != pytest.approx(1.0, abs=1e-3)


def test_without_satellites_the_place_drifts_and_comes_back() -> None:
    """Random walk of the speed, integrated: sigma of the place after T is drift * sqrt(T^3 / 3), here 1.15 m at 1 s."""
    reference = Reference(outages=6000.0, outage_time=1e9, outage_drift=2.0)  # lost at the first call, for good
    found = np.array([errors(reference, seed, 101)[-1] for seed in range(500)])
    assert found[:, :2].std() == pytest.approx(2.0 / math.sqrt(3.0), rel=0.1)
    assert found[:, 3].std() == pytest.approx(2.0, rel=0.1)
    often = errors(Reference(outages=60.0, outage_time=0.2, outage_drift=2.0), 1, 2000)[:, 0]
    assert 0.5 < np.mean(often == 0.0) < 0.95  # lost once a second for 0.2 s: 1 / 1.2 of the time it is not


def test_motion_is_as_old_as_the_latency_and_comes_at_the_rate() -> None:
    system = ReferenceSystem(Reference(latency=0.025, rate=50.0), 1, PERIOD)
    shown = [system.show(msgspec.structs.replace(STILL, x=0.1 * k)).x for k in range(10)]
    assert shown[5:] == pytest.approx([0.1 * (k - 2.5) for k in range(5, 10)])
    assert [k for k in range(6) if system.due(k)] == [0, 2, 4]


def test_wheel_speeds_are_scaled_and_come_in_steps() -> None:
    steps = ReferenceSystem(Reference(wheel_step=0.5), 1, PERIOD)
    assert [steps.wheels(v) for v in (0.2, 0.3, 7.74, -0.3)] == [0.0, 0.5, 7.5, -0.5]
    scales = [ReferenceSystem(Reference(wheel_scale=0.01), seed, PERIOD).wheels(10.0) for seed in range(300)]
    assert np.std(scales) == pytest.approx(0.1, rel=0.15)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('unit = "rtkk"', "reference.unit is 'rtkk'; known: ideal, rtk"),
        ("accel_bais = 0.1", "reference has no 'accel_bais'"),
        ("accel_bias = -0.1", "reference.accel_bias is -0.1; it must be at least 0"),
        ("drift_time = 0", "reference.drift_time is 0; it must be above 0"),
        ("rate = 30", "reference.rate is 30; known: 10, 20, 25, 50, 100"),
        ("latency = 0.6", "reference.latency is 0.6; it must be at most 0.5"),
        ('arm = "far"', "reference.arm is 'far'; a number is needed"),
    ],
)
def test_a_wrong_table_is_one_line_with_its_place(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "hidden.toml"
    file.write_text(f'[sensors]\nnoise = "low"\n[reference]\n{text}\n')
    with pytest.raises(HiddenError) as error:
        read_hidden(file)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(f"{file}:3: {said}")


def test_it_states_how_well_it_knows_the_place_and_worse_while_satellites_are_lost() -> None:
    """Of a random walk of the speed the place errs by q sqrt(t^3 / 3), beside what noise and drift always do."""
    reference = Reference(position_drift=0.01, position_noise=0.002, outages=30.0, outage_time=5.0, outage_drift=0.0055)
    system = ReferenceSystem(reference, 4, PERIOD)
    stated = np.array([system.show(STILL).position_sigma for _ in range(6000)])
    best = math.hypot(0.01, 0.002)
    assert stated.min() == pytest.approx(best)
    begins = np.flatnonzero((stated[:-1] == stated.min()) & (stated[1:] > stated.min()))
    assert len(begins) > 3
    one = begins[0]
    last = one + int(np.argmax(stated[one + 1 :] <= stated[one]))
    seconds = PERIOD * (last - one)
    assert stated[last] == pytest.approx(math.sqrt(best**2 + 0.0055**2 * seconds**3 / 3.0), rel=0.02)


def test_what_it_states_is_what_it_errs_by() -> None:
    """Over many outages the error over the stated deviation scatters by one."""
    reference = Reference(position_drift=0.01, outages=20.0, outage_time=8.0, outage_drift=0.0055)
    ratios = []
    for seed in range(60):
        system = ReferenceSystem(reference, seed, PERIOD)
        shown = [system.show(STILL) for _ in range(1500)][-1]
        ratios += [(shown.x - STILL.x) / shown.position_sigma, (shown.y - STILL.y) / shown.position_sigma]
    assert np.std(ratios) == pytest.approx(1.0, abs=0.2)
