"""Effects on what a log shows: each equation by numbers that one can work out by hand."""

from __future__ import annotations

import math

import pytest
from plain_effects import Applied, applied, bus

from vehicle.model.effects.accelerometer_bias import accelerometer_bias
from vehicle.model.effects.accelerometer_filter import accelerometer_filter
from vehicle.model.effects.body_pitch import body_pitch
from vehicle.model.effects.front_wheel_speed import front_wheel_speed
from vehicle.model.effects.gnss_latency import gnss_latency
from vehicle.model.effects.gnss_lever_arm import gnss_lever_arm
from vehicle.model.effects.gyro_bias import gyro_bias
from vehicle.model.effects.heading_bias import heading_bias
from vehicle.model.effects.imu_misalignment import imu_misalignment
from vehicle.model.effects.lateral_accelerometer_bias import lateral_accelerometer_bias
from vehicle.model.effects.pitch import pitch
from vehicle.model.effects.roll import roll
from vehicle.model.effects.wheel_radius import wheel_radius
from vehicle.model.effects.wheel_slip import wheel_slip
from vehicle.model.effects.yaw_rate_latency import yaw_rate_latency

QUARTER = 0.5 * math.pi


def test_biases_are_added() -> None:
    assert applied(accelerometer_bias, bus(meas_ax=1.0), b=0.2).meas_ax == pytest.approx(1.2)
    assert applied(lateral_accelerometer_bias, bus(meas_ay=1.0), b=0.2).meas_ay == pytest.approx(1.2)
    assert applied(gyro_bias, bus(meas_yaw_rate=1.0), b=0.2).meas_yaw_rate == pytest.approx(1.2)
    assert applied(heading_bias, bus(meas_yaw=1.0), b=0.2).meas_yaw == pytest.approx(1.2)


def test_gains_are_multiplied() -> None:
    assert applied(pitch, bus(meas_ax=2.0), gain=0.1).meas_ax == pytest.approx(2.2)
    assert applied(roll, bus(meas_ay=2.0), gain=0.1).meas_ay == pytest.approx(2.2)
    assert applied(wheel_radius, bus(meas_v=2.0), ratio=1.1).meas_v == pytest.approx(2.2)


def test_wheels_slip_with_the_force() -> None:
    """3000 N of 1500 kg: 2 m/s^2; braked wheels are slower, driven ones faster, forward: while the car rolls back, they
    turn back less."""
    assert applied(
        wheel_slip, bus(vx=10.0, meas_v=10.0, brake=3000.0), c_brake=0.01, c_drive=0.03
    ).meas_v == pytest.approx(9.8)
    assert applied(
        wheel_slip, bus(vx=10.0, meas_v=10.0, traction=3000.0), c_brake=0.01, c_drive=0.03
    ).meas_v == pytest.approx(10.6)
    back = bus(vx=-2.0, meas_v=-2.0, traction=3000.0)
    assert applied(wheel_slip, back, c_brake=0.01, c_drive=0.03).meas_v == pytest.approx(-1.88)
    back = bus(vx=-2.0, meas_v=-2.0, brake=3000.0)
    assert applied(wheel_slip, back, c_brake=0.01, c_drive=0.03).meas_v == pytest.approx(-1.96)


def test_an_antenna_beside_the_axle_turns_with_the_car() -> None:
    """1 m ahead, 0.5 m to the left; facing +y ahead is +y and left is -x."""
    x = applied(gnss_lever_arm, bus(meas_x=10.0, meas_y=20.0, meas_yaw=0.0), x=1.0, y=0.5)
    assert (x.meas_x, x.meas_y) == pytest.approx((11.0, 20.5))
    x = applied(gnss_lever_arm, bus(meas_x=10.0, meas_y=20.0, meas_yaw=QUARTER), x=1.0, y=0.5)
    assert (x.meas_x, x.meas_y) == pytest.approx((9.5, 21.0))


@pytest.mark.parametrize(
    ("angle", "shown"), [(QUARTER, (2.0, -1.0)), (math.pi / 6.0, (0.75**0.5 + 1.0, 3.0**0.5 - 0.5))]
)
def test_a_turned_imu_mixes_its_axes(angle: float, shown: tuple[float, float]) -> None:
    x = applied(imu_misalignment, bus(meas_ax=1.0, meas_ay=2.0), angle=angle)
    assert (x.meas_ax, x.meas_ay) == pytest.approx(shown)


def test_front_wheels_run_along_their_own_direction() -> None:
    """At 30 degrees: 10 cos + (vy + 2.8 r) sin instead of 10 m/s; half of it at a share of a half."""
    x = bus(meas_v=10.0, vx=10.0, steer=math.pi / 6.0, vy_rear=0.4, meas_yaw_rate=0.5)
    assert applied(front_wheel_speed, x, share=0.5).meas_v == pytest.approx(5.0 + 0.5 * (10.0 * 0.75**0.5 + 0.9))


def test_a_nodding_body_is_an_oscillator() -> None:
    """Held at 2 m/s^2 it is at rest; then at 0 it swings as exp(-D w t) cos, free of any push."""
    nodding = Applied(body_pitch, gain=0.1, frequency=1.2, damping=0.3)
    assert nodding(bus(meas_ax=2.0)).meas_ax == pytest.approx(2.2)
    assert nodding(bus(meas_ax=0.0)).meas_ax == pytest.approx(0.2)  # what held until this row
    w = 2.0 * math.pi * 1.2
    damped = w * math.sqrt(1.0 - 0.09)
    for k in range(1, 6):
        t = 0.1 * k
        swing = 2.0 * math.exp(-0.3 * w * t) * (math.cos(damped * t) + 0.3 * w / damped * math.sin(damped * t))
        assert nodding(bus(meas_ax=0.0)).meas_ax == pytest.approx(0.1 * swing)


def test_a_nodding_body_that_was_pushed_twice() -> None:
    """The answers to two steps add up: the oscillator is linear."""

    def answer(pushes: list[float]) -> list[float]:
        nodding = Applied(body_pitch, gain=1.0, frequency=1.2, damping=0.3)
        return [nodding(bus(meas_ax=a)).meas_ax - a for a in [0.0, *pushes]]

    one, other = answer([1.0, 1.0, 1.0, 1.0, 1.0]), answer([0.0, 0.0, 2.0, 2.0, 2.0])
    assert answer([1.0, 1.0, 3.0, 3.0, 3.0]) == pytest.approx([a + b for a, b in zip(one, other, strict=True)])
    assert other[3:] == pytest.approx([2.0 * a for a in one[1:4]])  # the same, later


def drive(sensor: Applied, rows: int = 4, **more: float) -> list[object]:
    """Along +y from (5, 0) with 10 m/s, turning by 0.2 rad/s: a row each 0.1 s."""
    return [sensor(bus(t=0.1 * k, vx=10.0, x=5.0, y=1.0 * k, yaw=QUARTER + 0.02 * k, meas_x=5.0, meas_y=1.0 * k,
                       meas_yaw=QUARTER + 0.02 * k, meas_yaw_rate=0.1 * k, **more)) for k in range(rows)]  # fmt: skip


def test_a_late_position_is_the_one_of_before() -> None:
    """0.15 s late: 1.5 m behind; before the first row the car came straight."""
    seen = drive(Applied(gnss_latency, T=0.15))
    assert [x.meas_y for x in seen] == pytest.approx([-1.5, -0.5, 0.5, 1.5])  # type: ignore[attr-defined]
    assert [x.meas_x for x in seen] == pytest.approx([5.0] * 4)  # type: ignore[attr-defined]
    assert seen[3].meas_yaw == pytest.approx(QUARTER + 0.03)  # type: ignore[attr-defined]
    assert seen[0].meas_yaw == pytest.approx(QUARTER)  # type: ignore[attr-defined]


def test_a_position_that_is_not_late_is_left_alone() -> None:
    seen = drive(Applied(gnss_latency))
    assert [x.meas_y for x in seen] == [0.0, 1.0, 2.0, 3.0]  # type: ignore[attr-defined]


def test_where_a_replay_puts_the_car_its_past_goes_along() -> None:
    """From (5, 3), facing +y, to (20, 7), facing -x (turned by a quarter): the past is behind it, towards +x."""
    late = Applied(gnss_latency, T=0.15)
    for k in range(4):
        late(bus(t=0.1 * k, vx=10.0, x=5.0, y=1.0 * k, yaw=QUARTER, meas_x=5.0, meas_y=1.0 * k, meas_yaw=QUARTER))
    x = late(bus(t=0.4, vx=10.0, x=20.0, y=7.0, yaw=math.pi, meas_x=20.0, meas_y=7.0, meas_yaw=math.pi,
                 moved=1.0, old_x=5.0, old_y=4.0, old_yaw=QUARTER))  # fmt: skip
    assert (x.meas_x, x.meas_y, x.meas_yaw) == pytest.approx((21.5, 7.0, math.pi))
    assert (late.memory.x[1], late.memory.y[1]) == pytest.approx((5.0, 0.0))  # longer ago than it is asked for


def test_a_past_that_bends_goes_along_as_it_is() -> None:
    """A place 1 m behind and 2 m to the left of the car stays so."""
    late = Applied(gnss_latency, T=0.1)
    late(bus(t=0.0, x=2.0, y=-1.0, yaw=QUARTER, meas_x=2.0, meas_y=-1.0, meas_yaw=QUARTER))
    x = late(
        bus(t=0.1, x=50.0, y=60.0, yaw=0.0, meas_x=50.0, meas_y=60.0, moved=1.0, old_x=4.0, old_y=0.0, old_yaw=QUARTER)
    )
    assert (x.meas_x, x.meas_y, x.meas_yaw) == pytest.approx((49.0, 62.0, 0.0))


def test_a_yaw_rate_comes_late() -> None:
    """0.15 s: half of the row before last and of the last; at first the first row."""
    seen = drive(Applied(yaw_rate_latency, T=0.15))
    assert [x.meas_yaw_rate for x in seen] == pytest.approx([0.0, 0.0, 0.05, 0.15])  # type: ignore[attr-defined]
    assert [x.meas_yaw_rate for x in drive(Applied(yaw_rate_latency))] == pytest.approx([0.0, 0.1, 0.2, 0.3])  # type: ignore[attr-defined]


def test_smoothed_accelerations_approach_a_step_exponentially() -> None:
    """From 1 m/s^2 to 3 m/s^2 at a row, time constant 0.2 s, rows of 0.1 s: 1, then 3 - 2 exp(-t/0.2)."""
    smoothed = Applied(accelerometer_filter, tau=0.2)
    past = [1.0, 1.0, 3.0, 3.0, 3.0]  # what the step before each row had
    now = [1.0, 3.0, 3.0, 3.0, 3.0]
    seen = [
        smoothed(bus(dt=0.1, meas_ax=a, meas_ay=-a, ax=b, ay=-b)) for a, b in zip(now, past, strict=True)
    ]  # fmt: skip
    expected = [1.0, 1.0, *(3.0 - 2.0 * math.exp(-0.1 * k / 0.2) for k in range(1, 4))]
    assert [x.meas_ax for x in seen] == pytest.approx(expected)
    assert [x.meas_ay for x in seen] == pytest.approx([-value for value in expected])
    plain = Applied(accelerometer_filter)
    assert [plain(bus(dt=0.1, meas_ax=a, ax=a)).meas_ax for a in (1.0, 3.0)] == [1.0, 3.0]


def test_smoothed_accelerations_of_a_ramp_are_late_by_the_time_constant() -> None:
    """The mean of a step is what lies in the middle of it; after seven time constants."""
    smoothed = Applied(accelerometer_filter, tau=0.2)
    seen = [smoothed(bus(dt=0.02, meas_ax=0.02 * k, ax=0.02 * (k - 0.5))) for k in range(70)]
    assert seen[-1].meas_ax == pytest.approx(0.02 * 69 - 0.2, abs=0.003)
