"""Effects on the road-wheel angle: each equation by numbers that one can work out by hand, exact over a step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from plain_effects import Applied, applied, bus
from scipy.integrate import solve_ivp

from vehicle.model.effects.steer_angle_limit import steer_angle_limit
from vehicle.model.effects.steer_assist import steer_assist
from vehicle.model.effects.steer_asymmetry import steer_asymmetry
from vehicle.model.effects.steer_backlash import steer_backlash
from vehicle.model.effects.steer_delay import steer_delay
from vehicle.model.effects.steer_lag import steer_lag
from vehicle.model.effects.steer_offset import steer_offset
from vehicle.model.effects.steer_rate_limit import steer_rate_limit
from vehicle.model.effects.steer_ratio import steer_ratio
from vehicle.model.effects.steer_servo import steer_servo
from vehicle.model.effects.steer_sticking import steer_sticking
from vehicle.model.effects.steer_stiction import steer_stiction

DT = 0.1


def ends(x: object) -> tuple[float, float]:
    """Angle at the start and at the end of a step."""
    return x.steer + x.steer_lead, x.steer - x.steer_lead  # type: ignore[attr-defined]


def test_a_ratio_and_an_offset() -> None:
    x = applied(steer_ratio, bus(steer=0.2, steer_lead=-0.05), g=1.2)
    assert (x.steer, x.steer_lead) == pytest.approx((0.24, -0.06))
    x = applied(steer_offset, bus(steer=0.2, steer_lead=-0.05), offset=0.03)
    assert (x.steer, x.steer_lead) == pytest.approx((0.23, -0.05))


@pytest.mark.parametrize(("steer", "gain"), [(0.2, 1.1), (-0.2, 0.8)])
def test_left_and_right_have_gains_of_their_own(steer: float, gain: float) -> None:
    x = applied(steer_asymmetry, bus(steer=steer, steer_lead=0.05), g_left=1.1, g_right=0.8)
    assert (x.steer, x.steer_lead) == pytest.approx((gain * steer, gain * 0.05))


@pytest.mark.parametrize(("speed", "gain"), [(0.0, 1.0), (4.0, 0.8), (-4.0, 0.8), (12.0, 0.7)])
def test_an_assist_changes_the_ratio_with_speed(speed: float, gain: float) -> None:
    """g = -0.4, v0 = 4 m/s: half of it at 4 m/s, three quarters at 12."""
    x = applied(steer_assist, bus(steer=0.2, steer_lead=-0.05, vx=speed), g=-0.4, v0=4.0)
    assert (x.steer, x.steer_lead) == pytest.approx((0.2 * gain, -0.05 * gain))
    assert applied(steer_assist, bus(steer=0.2, vx=9.0)).steer == 0.2


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("steer", "lead", "start", "end"),
    [
        (0.1, 0.05, 0.15, 0.05),
        (0.1, -0.15, -0.05, 0.25),
        (0.25, 0.1, 0.3, 0.15),
        (0.4, 0.05, 0.3, 0.3),
        (0.0, 0.5, 0.3, -0.3),
    ],
)
def test_an_angle_is_cut_at_both_ends_of_a_step(
    sign: float, steer: float, lead: float, start: float, end: float
) -> None:
    x = applied(steer_angle_limit, bus(steer=sign * steer, steer_lead=sign * lead), limit=0.3)
    assert ends(x) == pytest.approx((sign * start, sign * end))


def test_a_steering_lag_answers_a_step_exponentially() -> None:
    lagged, gone = Applied(steer_lag, tau=0.05), 1.0 - math.exp(-2.0)
    lagged(bus(steer=0.0))
    x = lagged(bus(steer=0.2))
    assert x.steer == pytest.approx(0.2 * (1.0 - 0.5 * gone))
    assert (ends(x)[0], lagged.memory.d, x.steer_glides) == pytest.approx((0.0, 0.2 * gone, 1.0))
    through = Applied(steer_lag)
    x = through(bus(steer=0.2, steer_lead=0.05))
    assert (x.steer, x.steer_lead, through.memory.d, x.steer_glides) == (0.2, 0.05, pytest.approx(0.15), 0.0)


def integrated(d: float, rate: float, first: float, last: float, tau: float, damping: float) -> tuple[float, ...]:
    """Mean, end and its rate of a servo over a step in which its command runs from first to last: by a solver."""

    def change(t: float, y: np.ndarray) -> list[float]:
        command = first + (last - first) * t / DT
        return [y[1], (command - y[0] - 2.0 * damping * tau * y[1]) / tau**2, y[0]]

    found = solve_ivp(change, (0.0, DT), [d, rate, 0.0], rtol=1e-10, atol=1e-13).y[:, -1]
    return float(found[2]) / DT, float(found[0]), float(found[1])


@pytest.mark.parametrize("damping", [0.3, 1.0, 1.2])
def test_a_servo_moves_as_a_damped_inertia_on_a_spring_would(damping: float) -> None:
    servo, d, rate = Applied(steer_servo, tau=0.06, damping=damping), 0.0, 0.0
    servo(bus(steer=0.0))
    for first, last in ((0.2, 0.2), (0.2, 0.05), (-0.1, 0.0)):
        mean, end, its_rate = integrated(d, rate, first, last, 0.06, damping)
        x = servo(bus(steer=0.5 * (first + last), steer_lead=0.5 * (first - last)))
        assert x.steer == pytest.approx(mean, abs=1e-8)
        assert ends(x)[0] == pytest.approx(d)
        assert (servo.memory.d, servo.memory.rate) == pytest.approx((end, its_rate), abs=1e-7)
        assert x.steer_glides == 1.0
        d, rate = end, its_rate
    through = Applied(steer_servo)
    x = through(bus(steer=0.2, steer_lead=0.05))
    assert (x.steer, x.steer_lead, through.memory.d, x.steer_glides) == (0.2, 0.05, pytest.approx(0.15), 0.0)
    assert through.memory.rate == 0.0  # a servo that sets in on the way begins at rest


def test_a_long_step_brings_a_servo_to_rest() -> None:
    """As the steps before a log do, of whatever damping: nothing overflows."""
    for damping in (0.3, 1.0, 20.0):
        servo = Applied(steer_servo, tau=0.06, damping=damping)
        servo(bus(steer=0.0))
        servo(bus(steer=0.3, dt=1000.0))
        assert (servo.memory.d, servo.memory.rate) == pytest.approx((0.3, 0.0), abs=1e-9)


def test_an_angle_changes_no_faster_than_the_limit_of_its_rate() -> None:
    """0.5 rad/s x 0.1 s."""
    limited = Applied(steer_rate_limit, limit=0.5)
    limited(bus(steer=0.0))
    for start, end in ((0.0, -0.05), (-0.05, -0.1)):
        x = limited(bus(steer=-0.2))
        assert (ends(x), limited.memory.d, x.steer_glides) == (pytest.approx((start, end)), pytest.approx(end), 1.0)
    free = Applied(steer_rate_limit)
    x = free(bus(steer=0.2, steer_lead=0.05))
    assert (x.steer, x.steer_lead, free.memory.d, x.steer_glides) == (0.2, 0.05, pytest.approx(0.15), 0.0)


def test_a_steering_dead_time_starts_from_the_first_angle() -> None:
    """0.13 s late: 0.3 of the second step after the change still shows what was before."""
    late = Applied(steer_delay, T=0.13)
    seen = [late(bus(t=DT * k, steer=steer)).steer for k, steer in enumerate((0.1, 0.3, 0.3, 0.3))]
    assert seen == pytest.approx([0.1, 0.1, 0.3 * 0.1 + 0.7 * 0.3, 0.3])


def test_backlash_follows_at_its_half_width() -> None:
    """0.02 rad: out by 0.1 it comes 0.02 behind, back by 0.03 it stays, back by more it follows."""
    loose = Applied(steer_backlash, half_width=0.02)
    loose(bus(steer=0.0))
    assert ends(loose(bus(steer=0.05, steer_lead=-0.05))) == pytest.approx((0.0, 0.08))
    assert ends(loose(bus(steer=0.07))) == pytest.approx((0.08, 0.08))
    assert ends(loose(bus(steer=0.04, steer_lead=0.03))) == pytest.approx((0.08, 0.03))
    assert loose.memory.d == pytest.approx(0.03)


def test_backlash_of_no_width_passes_the_command() -> None:
    tight = Applied(steer_backlash)
    x = tight(bus(steer=0.07, steer_lead=0.02))
    assert (x.steer, x.steer_lead, tight.memory.d) == (0.07, 0.02, pytest.approx(0.05))


def test_stiction_holds_until_a_jump_is_wide_enough() -> None:
    stuck = Applied(steer_stiction, width=0.05)
    stuck(bus(steer=0.0))
    assert ends(stuck(bus(steer=0.049))) == pytest.approx((0.0, 0.0))
    assert ends(stuck(bus(steer=0.05))) == pytest.approx((0.05, 0.05))
    assert ends(stuck(bus(steer=-0.1))) == pytest.approx((-0.1, -0.1))


def test_a_command_that_jumps_within_a_step_takes_the_linkage_along_at_its_end() -> None:
    """From 0 to 0.06 within the step: half of the step each."""
    stuck = Applied(steer_stiction, width=0.05)
    stuck(bus(steer=0.0))
    x = stuck(bus(steer=0.03, steer_lead=-0.03))
    assert (x.steer, x.steer_lead, stuck.memory.d) == pytest.approx((0.03, -0.03, 0.06))
    x = stuck(bus(steer=0.03, steer_lead=0.03 - 0.011))  # back to 0.011, which is not far enough
    assert stuck.memory.d == pytest.approx(0.011 if 0.06 - 0.011 >= 0.05 else 0.06)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_command_that_jumps_by_just_the_width_within_a_step_takes_the_linkage_along(sign: float) -> None:
    """From 0 to 1/16 within the step, which is the width: the linkage is there at its end, 1/32 on the mean."""
    stuck = Applied(steer_stiction, width=0.0625)
    stuck(bus(steer=0.0))
    x = stuck(bus(steer=sign * 0.03125, steer_lead=sign * -0.03125))
    assert (x.steer, x.steer_lead, stuck.memory.d) == (sign * 0.03125, sign * -0.03125, sign * 0.0625)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_command_that_glides_drags_the_linkage_along_in_jumps(sign: float) -> None:
    """From 0 to 0.2 with a width of 0.08: jumps to 0.08 and 0.16 at 0.4 and 0.8 of the step."""
    stuck = Applied(steer_stiction, width=0.08)
    stuck(bus(steer=0.0))
    x = stuck(bus(steer=sign * 0.1, steer_lead=sign * -0.1, steer_glides=1.0))
    assert x.steer == pytest.approx(sign * (0.6 * 0.08 + 0.2 * 0.08))
    assert (ends(x)[0], stuck.memory.d) == pytest.approx((0.0, sign * 0.16))


def test_a_glide_that_begins_ahead_of_the_linkage_needs_less_to_move_it() -> None:
    """The command is at 0.04 already: from there to 0.14 it passes 0.08 after 0.4 of the step."""
    stuck = Applied(steer_stiction, width=0.08)
    stuck(bus(steer=0.0))
    x = stuck(bus(steer=0.09, steer_lead=-0.05, steer_glides=1.0))
    assert (x.steer, stuck.memory.d) == pytest.approx((0.6 * 0.08, 0.08))


def test_stiction_of_no_width_passes_the_command() -> None:
    free = Applied(steer_stiction)
    x = free(bus(steer=0.07, steer_lead=0.02))
    assert (x.steer, x.steer_lead, free.memory.d) == (0.07, 0.02, pytest.approx(0.05))


def sticking(**before: float) -> Applied:
    """Of 0.05 rad width, having stood at an angle of 0."""
    found = Applied(steer_sticking, width=0.05)
    found(bus(steer=0.0, vx=0.0, **before))
    return found


def test_steering_that_has_stood_sticks_until_it_breaks_away() -> None:
    found = sticking()
    assert found.memory.stuck == 1.0
    assert ends(found(bus(steer=0.04, vx=0.0))) == pytest.approx((0.0, 0.0))
    assert ends(found(bus(steer=0.049, vx=3.0))) == pytest.approx((0.0, 0.0))
    assert ends(found(bus(steer=0.06, vx=3.0))) == pytest.approx((0.06, 0.06))
    assert found.memory.stuck == 0.0
    assert ends(found(bus(steer=0.01, vx=3.0))) == pytest.approx((0.01, 0.01))


@pytest.mark.parametrize(("speed", "stuck"), [(0.049, 1.0), (-0.049, 1.0), (0.05, 0.0), (-0.05, 0.0)])
def test_slower_than_five_centimetres_a_second_is_standing(speed: float, stuck: float) -> None:
    found = Applied(steer_sticking, width=0.05)
    found(bus(steer=0.0, vx=speed))
    assert found.memory.stuck == stuck


def test_it_sticks_again_at_the_next_standstill_only() -> None:
    """Broken away while standing it follows; after a drive and a stop it sticks where it then is."""
    found = sticking()
    found(bus(steer=0.2, vx=0.0))
    assert ends(found(bus(steer=0.18, vx=0.0))) == pytest.approx((0.18, 0.18))
    found(bus(steer=0.1, vx=3.0))
    assert ends(found(bus(steer=0.12, vx=0.0))) == pytest.approx((0.1, 0.1))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_it_breaks_away_half_way_through_a_step_in_which_the_command_jumps(sign: float) -> None:
    """0 in the first half, 0.08 in the second."""
    found = sticking()
    x = found(bus(steer=sign * 0.04, steer_lead=sign * -0.04, vx=3.0))
    assert (x.steer, ends(x)[0], found.memory.d) == pytest.approx((sign * 0.04, 0.0, sign * 0.08))
    assert found.memory.stuck == 0.0


def test_it_breaks_away_when_a_gliding_command_has_gone_its_width() -> None:
    """0 to 0.1: 0 for half of the step, then from 0.05 to 0.1."""
    found = sticking()
    x = found(bus(steer=0.05, steer_lead=-0.05, vx=3.0, steer_glides=1.0))
    assert (x.steer, ends(x)[0], found.memory.d) == pytest.approx((0.5 * 0.075, 0.0, 0.1))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_wheels_that_stick_on_one_side_break_away_towards_the_command(sign: float) -> None:
    """At 0.3; within a step the command goes from 0.28 to 0.2: 3/8 of it are over at 0.25, which is 0.05 off; then its
    mean is 0.225."""
    found = Applied(steer_sticking, width=0.05)
    found(bus(steer=sign * 0.3, vx=0.0))
    x = found(bus(steer=sign * 0.24, steer_lead=sign * 0.04, vx=3.0, steer_glides=1.0))
    mean = 0.375 * 0.3 + 0.625 * 0.225
    assert (x.steer, ends(x)[0], found.memory.d) == pytest.approx((sign * mean, sign * 0.3, sign * 0.2))


def test_a_command_beyond_its_width_at_the_start_of_a_step_frees_it() -> None:
    found = sticking()
    x = found(bus(steer=0.045, steer_lead=0.006, vx=3.0))
    assert (x.steer, x.steer_lead, found.memory.stuck) == (0.045, 0.006, 0.0)


@pytest.mark.parametrize(("width", "settle"), [(0.0, 0.0), (0.05, 1.0)])
def test_nothing_sticks_without_width_nor_before_the_log(width: float, settle: float) -> None:
    found = Applied(steer_sticking, width=width)
    x = found(bus(steer=0.02, steer_lead=0.005, vx=0.0, settle=settle))
    assert (x.steer, x.steer_lead, found.memory.d, found.memory.stuck) == (0.02, 0.005, pytest.approx(0.015), 0.0)
