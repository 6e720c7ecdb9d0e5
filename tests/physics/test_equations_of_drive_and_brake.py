"""Effects on the acceleration: each equation by numbers that one can work out by hand, exact over a step."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from plain_effects import Applied, applied, bus

from vehicle.model.effects.accel_controller import accel_controller
from vehicle.model.effects.brake_fade import brake_fade
from vehicle.model.effects.brake_gain import brake_gain
from vehicle.model.effects.brake_lag import brake_lag
from vehicle.model.effects.brake_limit import brake_limit
from vehicle.model.effects.drive_delay import drive_delay
from vehicle.model.effects.drive_gain import drive_gain
from vehicle.model.effects.drive_lag import drive_lag
from vehicle.model.effects.drive_torque_limit import drive_torque_limit
from vehicle.model.effects.force_rise import force_rise
from vehicle.model.effects.jerk_limit import jerk_limit
from vehicle.model.effects.lift_off_braking import lift_off_braking
from vehicle.model.effects.mass import mass
from vehicle.model.effects.pedal_deadband import pedal_deadband
from vehicle.model.effects.speed_controller import speed_controller
from vehicle.model.effects.speed_limit import speed_limit

DT = 0.1
GONE = 1.0 - math.exp(-DT / 0.4)  # of a lag of 0.4 s, by the end of a step
MEAN = 1.0 - GONE * 0.4 / DT  # ... and on the mean of it


@pytest.mark.parametrize(
    ("effect", "key", "accel", "lead"),
    [(drive_gain, "g", 2.0, 0.5), (drive_gain, "g", 0.5, 0.25), (brake_gain, "g", -2.0, 0.5)],
)  # fmt: skip
def test_a_gain_acts_on_its_own_sign(effect: object, key: str, accel: float, lead: float) -> None:
    x = applied(effect, bus(accel=accel, accel_lead=lead), **{key: 0.8})  # type: ignore[arg-type]
    assert (x.accel, x.accel_lead) == pytest.approx((0.8 * accel, 0.8 * lead))
    x = applied(effect, bus(accel=-accel, accel_lead=lead), **{key: 0.8})  # type: ignore[arg-type]
    assert (x.accel, x.accel_lead) == (-accel, lead)


def test_mass_divides_forces_but_not_what_goes_with_the_weight() -> None:
    """Of 500 N of resistance the drive makes 100."""
    forces = {"traction": 900.0, "brake": 400.0, "drag": -60.0, "resistance": 500.0, "drive_drag": 100.0}
    x = applied(mass, bus(accel_lead=-0.5, rotating_mass=50.0, **forces), ratio=1.25)
    assert (x.traction, x.brake, x.drag, x.rotating_mass) == pytest.approx((720.0, 320.0, -48.0, 40.0))
    assert (x.resistance, x.drive_drag, x.accel_lead) == pytest.approx((480.0, 80.0, -0.4))


@pytest.mark.parametrize(("accel", "left"), [(0.29, 0.0), (-0.29, 0.0), (0.3, 0.3), (-0.31, -0.31)])
def test_a_pedal_does_nothing_within_its_dead_band(accel: float, left: float) -> None:
    x = applied(pedal_deadband, bus(accel=accel, accel_lead=0.1), width=0.3)
    assert (x.accel, x.accel_lead) == (left, 0.1 if left else 0.0)


@pytest.mark.parametrize(
    ("accel", "braked", "left"),
    [(0.0, 1.0, 0.0), (0.049, 1.0, 0.049), (-0.049, 1.0, -0.049), (0.05, 0.0, 0.05), (2.0, 0.0, 2.0),
     (-0.06, 1.0, 0.0), (-0.6, 1.0, 0.0), (-0.7, 1.0, -0.1), (-3.0, 1.0, -2.4)],
)  # fmt: skip
def test_a_released_pedal_brakes_and_the_brakes_do_the_rest(accel: float, braked: float, left: float) -> None:
    """0.6 m/s^2 of the reference mass of 1500 kg, on top of what is there."""
    x = applied(lift_off_braking, bus(accel=accel, resistance=50.0), a=0.6, drive=0.0)
    assert x.resistance == 50.0 + braked * 900.0
    assert x.accel == pytest.approx(left)


@pytest.mark.parametrize(("accel", "braked"), [(-0.1, 0.6), (-0.5, 0.74), (-3.0, 3.24), (-0.04, 0.64), (0.06, -0.06)])
def test_a_released_accelerator_may_go_on_braking_beside_the_brake(accel: float, braked: float) -> None:
    """The brakes allow for three fifths of 0.6 m/s^2."""
    x = applied(lift_off_braking, bus(accel=accel, resistance=50.0), a=0.6, braking=0.4, drive=0.0)
    assert (x.resistance - 50.0) / 1500.0 - x.accel == pytest.approx(braked)


@pytest.mark.parametrize(("drive", "braked"), [(0.0, 0.6), (0.5, 0.35), (1.0, 0.1)])
def test_the_drive_may_take_off_what_is_more_than_was_asked_for(drive: float, braked: float) -> None:
    """0.1 m/s^2 are asked for, and the released pedal brakes with 0.6; more than that is left to the brakes."""
    x = applied(lift_off_braking, bus(accel=-0.1, resistance=50.0), a=0.6, drive=drive)
    assert (x.resistance - 50.0) / 1500.0 - x.accel == pytest.approx(braked)
    assert x.accel_lead == pytest.approx(0.0)
    assert applied(lift_off_braking, bus(accel=-2.0), a=0.6, drive=drive).accel == pytest.approx(-1.4)


def test_what_a_pedal_brakes_grows_with_speed_and_fades_before_the_stop() -> None:
    """0.6 m/s^2 at 10 m/s and 0.02 1/s more or less, from 4 m/s on in proportion to speed."""
    for speed, braked in ((10.0, 0.6), (20.0, 0.8), (5.0, 0.5), (2.0, 0.5 * 0.44), (0.0, 0.0)):
        x = applied(lift_off_braking, bus(accel=0.0, vx=speed), a=0.6, rise=0.02, fade=4.0)
        assert x.resistance == pytest.approx(braked * 1500.0)
    assert applied(lift_off_braking, bus(accel=0.0, vx=1.0), a=0.1, rise=0.06).resistance == 0.0  # it never pushes


def test_the_handover_to_the_brakes_keeps_the_whole_while_the_motor_is_late() -> None:
    """It comes with 0.2 s; the brakes leave it what it does, in the mean and at the start of a step of 20 ms."""
    late = Applied(lift_off_braking, a=0.5, lag=0.2)
    late.memory = SimpleNamespace(a=0.25)
    x = late(bus(accel=-2.0, accel_lead=0.3, dt=0.02))
    mean = 0.5 - 0.25 * (1.0 - math.exp(-0.1)) / 0.1
    assert x.resistance == pytest.approx(mean * 1500.0)
    assert x.accel == pytest.approx(-2.0 + mean)
    assert x.accel + x.accel_lead == pytest.approx(-1.7 + 0.25)
    assert late.memory.a == pytest.approx(0.5 - 0.25 * math.exp(-0.1))


@pytest.mark.parametrize(("asked", "speed"), [(9.0, 6.0), (-9.0, -6.0), (5.0, 5.0), (-5.0, -5.0)])
def test_a_speed_limit_cuts_what_is_asked_for(asked: float, speed: float) -> None:
    assert applied(speed_limit, bus(speed_cmd=asked), limit=6.0).speed_cmd == speed


@pytest.mark.parametrize(("effect", "sign"), [(drive_torque_limit, 1.0), (brake_limit, -1.0)])
@pytest.mark.parametrize(
    ("accel", "lead", "start", "end"),
    [(2.0, 0.5, 2.5, 1.5), (2.0, -0.9, 1.1, 2.9), (4.0, 0.0, 3.0, 3.0), (4.0, 0.5, 3.0, 3.0), (2.8, 0.5, 3.0, 2.3),
     (2.8, -0.5, 2.3, 3.0), (-9.0, 1.0, -8.0, -10.0)],
)  # fmt: skip
def test_what_is_beyond_a_limit_is_cut_at_both_ends_of_a_step(
    effect: object, sign: float, accel: float, lead: float, start: float, end: float
) -> None:
    """Limit 3: a command runs straight from accel + lead to accel - lead; its mean is that of the cut ends."""
    x = applied(effect, bus(accel=sign * accel, accel_lead=sign * lead), limit=3.0)  # type: ignore[arg-type]
    assert sign * (x.accel + x.accel_lead) == pytest.approx(start)
    assert sign * (x.accel - x.accel_lead) == pytest.approx(end)


@pytest.mark.parametrize("effect", [drive_lag, brake_lag, force_rise])
def test_a_lag_answers_a_step_exponentially(effect: object) -> None:
    """From 0 to -2 m/s^2 with 0.04 s: mean and end of two steps."""
    lagged, tau = Applied(effect, tau=0.04), 0.04  # type: ignore[arg-type]
    gone = 1.0 - math.exp(-DT / tau)
    first = lagged(bus(accel=-2.0, vx=9.0))
    assert first.accel == pytest.approx(-2.0 * (1.0 - gone * tau / DT))
    assert first.accel + first.accel_lead == 0.0
    assert lagged.memory.a == pytest.approx(-2.0 * gone)
    second = lagged(bus(accel=-2.0, vx=9.0))
    assert second.accel == pytest.approx(-2.0 * (1.0 - gone * tau / DT * (1.0 - gone)))
    assert second.accel + second.accel_lead == pytest.approx(-2.0 * gone)


@pytest.mark.parametrize("effect", [drive_lag, force_rise])
def test_without_a_time_constant_the_command_passes(effect: object) -> None:
    """What it ends with is remembered for when the effect begins."""
    lagged = Applied(effect, tau=0.0)  # type: ignore[arg-type]
    x = lagged(bus(accel=2.0, accel_lead=0.5, vx=9.0))
    assert (x.accel, x.accel_lead, lagged.memory.a) == (2.0, 0.5, 1.5)


def test_brakes_hold_a_standing_car_with_no_force() -> None:
    """The drive rises from 0 although the brake was on; a car that moves still has the brake in its tyres."""
    for speed, start in ((0.0, 0.0), (3.0, -2.0)):
        rising = Applied(force_rise, tau=0.04)
        x = bus(accel=1.0, vx=speed)
        rising(bus(accel=-2.0, vx=9.0))
        rising.memory.a = -2.0
        rising(x)
        assert x.accel + x.accel_lead == pytest.approx(start)
    standing = Applied(force_rise, tau=0.04)
    standing(bus(vx=0.0))
    standing.memory.a = 2.0
    x = standing(bus(accel=1.0, vx=0.0))
    assert x.accel + x.accel_lead == pytest.approx(2.0)


@pytest.mark.parametrize(("accel", "share"), [(3.0, 1.0), (-3.0, 0.25)])
def test_only_a_share_of_the_brake_comes_as_late_as_the_drive(accel: float, share: float) -> None:
    x = applied(drive_lag, bus(accel=accel), tau=0.4, brakes=0.25)
    assert x.accel == pytest.approx(accel * ((1.0 - share) + share * MEAN))
    assert x.accel + x.accel_lead == pytest.approx((1.0 - share) * accel)


def test_a_lead_passes_with_the_share_that_is_not_late() -> None:
    """Of a command from -4 to -2 all ends are those of its two parts."""
    lagged = Applied(drive_lag, tau=0.4, brakes=0.25)
    x = lagged(bus(accel=-3.0, accel_lead=-1.0))
    assert x.accel + x.accel_lead == pytest.approx(0.75 * -4.0)
    u, slope, beta = -4.0 * 0.25, 2.0 * 0.25, DT / 0.4
    end = u + slope - slope / beta - (u - slope / beta) * math.exp(-beta)  # of tau y' = u + slope s/dt - y, y(0) = 0
    assert lagged.memory.a == pytest.approx(end)


def test_a_brake_is_released_at_once() -> None:
    lagged = Applied(brake_lag, tau=0.4)
    lagged(bus(accel=-3.0))
    assert lagged.memory.a == pytest.approx(-3.0 * GONE)
    x = lagged(bus(accel=1.0))
    assert (x.accel, x.accel_lead, lagged.memory.a) == (1.0, 0.0, 0.0)


def test_a_brake_that_fades_away_acts_against_the_drive() -> None:
    """Half of the time constant: exp(-0.5) of -3 GONE m/s^2 is left after a step."""
    lagged = Applied(brake_lag, tau=0.4, release=0.5)
    lagged(bus(accel=-3.0))
    start, gone = -3.0 * GONE, 1.0 - math.exp(-DT / 0.2)
    x = lagged(bus(accel=1.0))
    assert x.accel == pytest.approx(1.0 + start * gone * 0.2 / DT)
    assert x.accel + x.accel_lead == pytest.approx(1.0 + start)
    assert lagged.memory.a == pytest.approx(start * (1.0 - gone))


def test_a_brake_that_was_not_on_leaves_the_drive_alone() -> None:
    lagged = Applied(brake_lag, tau=0.4, release=0.5)
    x = lagged(bus(accel=1.0))
    assert (x.accel, x.accel_lead, lagged.memory.a) == (1.0, 0.0, 0.0)


def test_a_brake_without_time_constant_forgets() -> None:
    lagged = Applied(brake_lag, tau=0.0, release=0.5)
    x = lagged(bus(accel=-3.0, accel_lead=0.2))
    assert (x.accel, x.accel_lead, lagged.memory.a) == (-3.0, 0.2, 0.0)


@pytest.mark.parametrize("tau", [1.5, 0.4])
def test_a_slow_brake_is_slow_and_not_gone(tau: float) -> None:
    assert applied(brake_lag, bus(accel=-3.0), tau=tau).accel == pytest.approx(-1.5 * DT / tau, rel=0.1)


def test_acceleration_changes_no_faster_than_the_limit_of_jerk() -> None:
    """8 m/s^3 x 0.1 s: 0.8 m/s^2 a step, its mean half of that."""
    limited = Applied(jerk_limit, limit=8.0)
    x = limited(bus(accel=2.0))
    assert (x.accel, x.accel + x.accel_lead, limited.memory.a) == pytest.approx((0.4, 0.0, 0.8))
    x = limited(bus(accel=2.0))
    assert (x.accel, x.accel + x.accel_lead, limited.memory.a) == pytest.approx((1.2, 0.8, 1.6))
    free = Applied(jerk_limit)
    x = free(bus(accel=2.0, accel_lead=0.5))
    assert (x.accel, x.accel_lead, free.memory.a) == (2.0, 0.5, 1.5)


def test_a_dead_time_lets_a_step_through_within_a_step() -> None:
    """0.25 s late: nothing in two steps, half of the third, all of the fourth."""
    late = Applied(drive_delay, T=0.25)
    seen = [late(bus(t=DT * k, accel=2.0)) for k in range(4)]
    assert [x.accel for x in seen] == pytest.approx([0.0, 0.0, 1.0, 2.0])
    assert [x.accel_lead for x in seen] == pytest.approx([0.0, 0.0, -1.0, 0.0])
    assert [x.accel_jump for x in seen] == [x.accel_lead for x in seen]
    assert seen[2].accel_arrived == seen[3].accel_arrived == 2.0


def test_brakes_fade_with_the_energy_that_they_took() -> None:
    """10 to 9 m/s hold 9.5 m^2/s^2; with k = 0.02 the next braking has 1/1.19 of it, and it cools with 60 s."""
    fading = Applied(brake_fade, k=0.02, tau=60.0)
    x = fading(bus(accel=-10.0, accel_lead=0.4, vx=10.0))
    assert (x.accel, x.accel_lead) == (-10.0, 0.4)
    share = DT / 60.0
    assert fading.memory.heat == pytest.approx(9.5 * (1.0 - math.exp(-share)) / share)
    heat = fading.memory.heat
    x = fading(bus(accel=-10.0, accel_lead=0.4, vx=9.0))
    gain = 1.0 / (1.0 + 0.02 * heat)
    assert (x.accel, x.accel_lead) == pytest.approx((-10.0 * gain, 0.4 * gain))


def test_brakes_cool_while_the_car_drives_on() -> None:
    fading = Applied(brake_fade, k=0.02, tau=2.0)
    fading(bus(accel=-10.0, vx=10.0))
    heat = fading.memory.heat
    x = fading(bus(accel=3.0, vx=10.0))
    assert (x.accel, fading.memory.heat) == (3.0, pytest.approx(heat * math.exp(-DT / 2.0)))


def test_brakes_take_no_more_than_the_car_has() -> None:
    """From 0.5 m/s, backwards too, a braking by 1 m/s takes 0.125 m^2/s^2 and no more."""
    for speed in (0.5, -0.5):
        fading = Applied(brake_fade, k=0.02, tau=1e6)
        fading(bus(accel=-10.0, vx=speed))
        assert fading.memory.heat == pytest.approx(0.125, rel=1e-6)


@pytest.mark.parametrize(("k", "settle"), [(0.0, 0.0), (0.02, 1.0)])
def test_no_fade_without_its_constant_nor_before_the_log(k: float, settle: float) -> None:
    fading = Applied(brake_fade, k=k)
    fading(bus(accel=-10.0, vx=10.0, settle=settle))
    assert fading.memory.heat == 0.0


def test_a_speed_controller_asks_for_what_its_errors_want() -> None:
    """e = 2 m/s: it begins with kp e, and the error shrinks by what the car gains: mean = start / (1 + kp dt / 2)."""
    controlled = Applied(speed_controller, kp=0.8, ki=0.5)
    x = controlled(bus(speed_cmd=12.0, vx=10.0, accel=0.1))
    mean = 1.6 / 1.04
    assert (x.accel, x.accel + x.accel_lead) == pytest.approx((0.1 + mean, 0.1 + 1.6))
    assert controlled.memory.sum == pytest.approx(0.5 * (2.0 - 0.05 * mean) * DT)
    held = controlled.memory.sum
    x = controlled(bus(speed_cmd=10.0, vx=10.0))
    assert x.accel + x.accel_lead == pytest.approx(held)


def test_a_speed_controller_does_not_wind_up_before_the_log() -> None:
    controlled = Applied(speed_controller, kp=0.8, ki=0.5)
    controlled(bus(speed_cmd=12.0, vx=10.0, settle=1.0))
    assert controlled.memory.sum == 0.0


def test_an_acceleration_controller_adds_up_what_is_missing() -> None:
    """The car holds its speed: all of the 2 m/s^2 is missing; then it gains 0.1 m/s, measured as (1 - e^-2) m/s^2."""
    controlled = Applied(accel_controller, kp_drive=0.3, ki_drive=0.5, kp_brake=0.6, ki_brake=2.0)
    x = controlled(bus(accel=2.0, vx=10.0))
    assert x.accel == pytest.approx(2.0 + 0.3 * 2.0 + 0.5 * 2.0 * DT)
    measured = 1.0 - math.exp(-DT / 0.05)
    x = controlled(bus(accel=2.0, vx=10.1))
    assert x.accel == pytest.approx(2.0 + 0.3 * (2.0 - measured) + 0.1 + 0.5 * (2.0 - measured) * DT)


def test_an_acceleration_controller_brakes_with_its_own_gains() -> None:
    controlled = Applied(accel_controller, kp_drive=0.3, ki_drive=0.5, kp_brake=0.6, ki_brake=2.0)
    assert controlled(bus(accel=-2.0, vx=10.0)).accel == pytest.approx(-2.0 - 0.6 * 2.0 - 2.0 * 2.0 * DT)


def test_a_standing_car_is_not_corrected() -> None:
    controlled = Applied(accel_controller, kp_drive=0.3, ki_drive=0.5, kp_brake=0.6, ki_brake=2.0)
    controlled(bus(accel=2.0, vx=0.0))
    assert controlled.memory.sum == pytest.approx(0.1)
    assert controlled(bus(accel=0.0, vx=0.0)).accel == 0.0
    assert controlled.memory.sum == 0.0


def test_an_acceleration_controller_begins_with_the_log() -> None:
    controlled = Applied(accel_controller, kp_drive=0.3, ki_drive=0.5)
    x = controlled(bus(accel=2.0, vx=7.0, settle=1.0))
    assert (x.accel, controlled.memory.a, controlled.memory.v, controlled.memory.sum) == (2.0, 2.0, 7.0, 0.0)
