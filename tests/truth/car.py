"""The truth car in motion: actuators and a bicycle, integrated with Runge-Kutta at 1250 Hz.

Kinematic bicycle at the rear axle (r = v tan(d)/L), or, with effects that need slip angles, a dynamic one. Commands are
held for 20 ms; a delayed command is looked up in the history of commands, exactly, as a mean over the step.
Source of the equations: M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., secs. 2, 20-21.
"""

from __future__ import annotations

import math

import numpy as np

from machine_code import compiled
from tests.truth.effects import (
    C_A,
    C_CF,
    C_CR,
    C_DYNAMIC,
    C_I,
    C_L,
    C_M,
    C_SPEED_MODE,
    INDEX,
    FloatArray,
)

PERIOD = 0.02  # s, hold of the commands
SUBSTEPS = 25
H = PERIOD / SUBSTEPS  # s
G = 9.80665  # m/s^2
SLOW = 1.0  # m/s, below it the dynamic bicycle rolls without slip
CRAWL = 0.05  # m/s, slower tyres stick to the ground
IDLE = 0.05  # m/s^2, a smaller command means that no pedal is pressed

# the state
X, Y, YAW, V, VY, R, FF, FR = range(8)  # motion, vy at the centre of gravity, relaxed tyre forces
(A_LAG, A_BRAKE, A_JERK, D_LAG, D_RATE, D_STICK, D_PLAY, ROLL, SUM, HEAT, ENERGY, WAY, D_RES, W_RES, GAP) = range(8, 23)
DISC, D_FREE, HOLDS, RESTED = range(23, 27)  # heat of the brake; wheel angle that can stick, whether it does
A_LIFT = 27  # braking of a lifted pedal
IN_GEAR, ENGINE = 28, 29
N_STATE = 30
FINE = ("x", "y", "yaw", "v", "yaw_rate", "ax", "ay", "steer")
"""Columns of the fine record."""

P = INDEX
(DRIVE_T, DRIVE_TAU, BRAKE_TAU) = (P["drive_delay", "T"], P["drive_lag", "tau"], P["brake_lag", "tau"])
RELEASE, LATE_BRAKES = P["brake_lag", "release"], P["drive_lag", "brakes"]
(G_DRIVE, G_BRAKE, M_RATIO) = (P["drive_gain", "g"], P["brake_gain", "g"], P["mass", "ratio"])
(JERK, POWER, BRAKE_MAX) = (P["jerk_limit", "limit"], P["power_limit", "limit"], P["brake_limit", "limit"])
(DEAD, LIFT, ROLLING) = (P["pedal_deadband", "width"], P["lift_off_braking", "a"], P["rolling_resistance", "c"])
(LIFT_BRAKES, GEAR, GEAR_V) = (P["lift_off_braking", "braking"], P["gear_inertia", "share"], P["gear_inertia", "v1"])
(LIFT_RISE, LIFT_FADE, LIFT_LAG, LIFT_DRIVE) = (P["lift_off_braking", key] for key in ("rise", "fade", "lag", "drive"))
LIFT_BLEND = P["lift_off_braking", "blend"]
(VISCOUS, AERO, CORNER) = (P["viscous_resistance", "c"], P["aero_drag", "k"], P["cornering_drag", "c"])
(GRADE, GRADE_H) = (P["road_grade", "slope"], P["road_grade", "heading"])
(BANK, BANK_H) = (P["road_bank", "slope"], P["road_bank", "heading"])
(WIND, WIND_K, WIND_H) = (P["headwind", "speed"], P["headwind", "k"], P["headwind", "heading"])
(STEER_T, STEER_TAU, STEER_RATE) = (P["steer_delay", "T"], P["steer_lag", "tau"], P["steer_rate_limit", "limit"])
(STEER_MAX, STICK, PLAY) = (
    P["steer_angle_limit", "limit"],
    P["steer_stiction", "width"],
    P["steer_backlash", "half_width"],
)
(RATIO, LEFT, RIGHT) = (P["steer_ratio", "g"], P["steer_asymmetry", "g_left"], P["steer_asymmetry", "g_right"])
(OFFSET, GRIP, RELAX) = (P["steer_offset", "offset"], P["tyre_saturation", "limit"], P["tyre_relaxation", "length"])
(TRANSFER, COMPLY) = (P["load_transfer", "c"], P["steer_compliance", "c"])
(ROLL_GAIN, ROLL_TAU, INERTIA) = (P["roll_dynamics", "gain"], P["roll_dynamics", "tau"], P["yaw_inertia", "ratio"])
(KP, KI) = (P["speed_controller", "kp"], P["speed_controller", "ki"])
(RIPPLE, PER_METRE) = (P["torque_ripple", "amplitude"], P["torque_ripple", "per_metre"])
(RATIO_V, FADE, FADE_HEAT) = (P["speed_dependent_ratio", "c"], P["brake_fade", "drop"], P["brake_fade", "heat"])
(GUST, GUST_T) = (P["cross_wind", "amplitude"], P["cross_wind", "period"])
(RES_F, RES_D) = (P["steer_resonance", "frequency"], P["steer_resonance", "damping"])
(SAG, SAG_E) = (P["battery_sag", "drop"], P["battery_sag", "energy"])
(GAP_T, GAP_V, GAP_STEP) = (P["gear_changes", key] for key in ("T", "v1", "step"))
(GAP_MORE, GAP_CUT, GEAR_FALL) = (P["gear_changes", key] for key in ("demand", "cut", "fall"))
(OIL, STALL, ENGINE_J) = (P["torque_converter", key] for key in ("ratio", "stall", "J"))
(LOCK, ENGINE_IDLE) = (P["torque_converter", key] for key in ("lock", "idle"))
(FADE_K, FADE_TAU, TORQUE) = (P["brake_fade", "k"], P["brake_fade", "tau"], P["drive_torque_limit", "limit"])
(FASTEST, HOLD) = (P["speed_limit", "limit"], P["steer_sticking", "width"])
(ASSIST, ASSIST_V) = (P["steer_assist", "g"], P["steer_assist", "v0"])
(HILL, HILL_X) = (P["road_profile", "height"], P["road_profile", "x"])
(HILL_Y, HILL_L) = (P["road_profile", "y"], P["road_profile", "length"])
(CREEP, CREEP_V, CREEP_BRAKES) = (P["creep", key] for key in ("a", "v0", "braking"))
(GAIN, GAIN_V) = (P["converter_gain", "a"], P["converter_gain", "speed"])


@compiled
def held(commands: FloatArray, last: int, column: int, begin: float) -> float:
    """Mean of a held command over begin..begin+H [s]; before the log the first one held."""
    first = math.floor(begin / PERIOD + 1e-9)
    then = math.floor((begin + H) / PERIOD - 1e-9)
    u0 = commands[min(max(first, 0), last), column]
    if then <= first:
        return float(u0)
    u1 = commands[min(max(then, 0), last), column]
    part = (then * PERIOD - begin) / H
    return float(part * u0 + (1.0 - part) * u1)


@compiled
def follow(y: float, u: float, tau: float) -> float:
    """tau y' = u - y over one step, implicit midpoint."""
    if tau <= 0.0:
        return u
    q = 0.5 * H / tau
    return (y * (1.0 - q) + 2.0 * q * u) / (1.0 + q)


@compiled
def shift_speed(p: FloatArray, gear: float) -> float:
    """Speed at which a gear, 0 the lowest, is left upwards at 1 m/s^2; the steps close up by a tenth each."""
    v, step = p[GAP_V], p[GAP_STEP]
    while gear > 0.0:
        v *= max(step, 1.1)
        step /= 1.1
        gear -= 1.0
    return v


@compiled
def converter(s: FloatArray, p: FloatArray, a: float) -> float:
    """Acceleration behind a torque converter whose engine gives `a`, or idles beside brakes that give it [m/s^2]."""
    v, slowest = s[V], max(s[V], p[ENGINE_IDLE])
    if v >= p[LOCK]:
        s[ENGINE] = v
        return a
    engine, begin = max(a, 0.0), max(s[ENGINE], slowest)
    if p[ENGINE_J] > 0.0:  # implicit midpoint, by bisection: the load grows with the speed of the engine
        low, high = 0.0, begin + H * engine / p[ENGINE_J] + 1.0
        for _ in range(50):
            end = 0.5 * (low + high)
            load = ((0.5 * (begin + end)) ** 2 - v * v) / p[STALL] ** 2
            if p[ENGINE_J] * (end - begin) > H * (engine - load):
                high = end
            else:
                low = end
        s[ENGINE] = max(0.5 * (low + high), slowest)
        begin = 0.5 * (begin + s[ENGINE])
    else:
        begin = s[ENGINE] = max(math.sqrt(v * v + p[STALL] ** 2 * engine), slowest)
    if begin <= 0.0:
        return a
    slip = min(v / (0.85 * begin), 1.0)
    return min(a, 0.0) + (begin**2 - v * v) / p[STALL] ** 2 * (p[OIL] + (1.0 - p[OIL]) * slip)


@compiled
def pedals(s: FloatArray, p: FloatArray, commands: FloatArray, last: int, t: float) -> tuple[float, float]:
    """Produced acceleration (its brake part negative) and the friction of a lifted pedal, >= 0 [m/s^2]."""
    if p[C_SPEED_MODE] > 0.0:
        error = min(held(commands, last, 2, t - p[DRIVE_T]), p[FASTEST]) - s[V]
        s[SUM] += p[KI] * error * H
        wish = p[KP] * error + s[SUM]
    else:
        wish = held(commands, last, 0, t - p[DRIVE_T])
    if abs(wish) < p[DEAD]:
        wish = 0.0
    if wish > 0.0:
        wish *= p[G_DRIVE] * (1.0 - p[SAG] * (1.0 - math.exp(-s[ENERGY] / p[SAG_E])))
    else:
        wish *= p[G_BRAKE] * (1.0 - p[FADE] * (1.0 - math.exp(-s[HEAT] / p[FADE_HEAT])))
    lifted = 0.0
    if wish < IDLE + p[LIFT_BLEND]:
        lifted = max(p[LIFT] + p[LIFT_RISE] * (s[V] - 10.0), 0.0)
        lifted *= min((IDLE + p[LIFT_BLEND] - wish) / p[LIFT_BLEND], 1.0) if p[LIFT_BLEND] > 0.0 else 1.0
        if s[V] < p[LIFT_FADE]:
            lifted *= s[V] / p[LIFT_FADE]
    old = s[A_LIFT]
    s[A_LIFT] = follow(old, lifted, p[LIFT_LAG])
    if p[LIFT_LAG] > 0.0:
        lifted = 0.5 * (old + s[A_LIFT])
    if wish <= -IDLE:  # the brakes do what the motor does not, and the motor takes off what it does too much
        wish += (1.0 - p[LIFT_BRAKES]) * lifted
        wish *= p[LIFT_DRIVE] if wish > 0.0 else 1.0
    if p[CREEP] > 0.0 and s[V] < p[CREEP_V]:
        push = p[CREEP] * (1.0 - s[V] / p[CREEP_V])
        wish = max(wish, push) if wish >= 0.0 else wish + p[CREEP_BRAKES] * push
    old = s[A_LAG]
    at_once = (1.0 - p[LATE_BRAKES]) * min(wish, 0.0)  # a brake that is apart from the motor
    s[A_LAG] = follow(old, wish - at_once, p[DRIVE_TAU])
    a = 0.5 * (old + s[A_LAG]) + at_once if p[DRIVE_TAU] > 0.0 else wish
    if a < 0.0:
        old = s[A_BRAKE]
        s[A_BRAKE] = follow(old, a, p[BRAKE_TAU])
        a = 0.5 * (old + s[A_BRAKE]) if p[BRAKE_TAU] > 0.0 else a
    else:
        old = s[A_BRAKE]  # the brake fades beside the drive
        s[A_BRAKE] = follow(old, 0.0, p[RELEASE] * p[BRAKE_TAU])
        a += 0.5 * (old + s[A_BRAKE]) if s[A_BRAKE] < 0.0 else 0.0
    if p[GAP_T] > 0.0:
        if s[V] > shift_speed(p, s[IN_GEAR]) * (1.0 + p[GAP_MORE] * (max(a, 0.0) - 1.0)):
            s[IN_GEAR] += 1.0
            s[GAP] = t + p[GAP_T]
        elif s[IN_GEAR] > 0.0 and s[V] < 0.65 * shift_speed(p, s[IN_GEAR] - 1.0) * (
            1.0 + p[GAP_MORE] * (max(a, 0.0) - 1.0)
        ):
            s[IN_GEAR] -= 1.0
            s[GAP] = t + p[GAP_T]
        if a > 0.0:
            a *= 1.0 - p[GAP_CUT] * min(max((s[GAP] - t) / H, 0.0), 1.0)
            a *= (p[GAP_V] / shift_speed(p, s[IN_GEAR])) ** p[GEAR_FALL]
    a = min(max(a, s[A_JERK] - p[JERK] * H), s[A_JERK] + p[JERK] * H)
    s[A_JERK] = a
    a = max(a, -p[BRAKE_MAX])
    if a < 0.0:
        a /= 1.0 + p[FADE_K] * s[DISC]
    a = min(a, p[TORQUE])
    if p[OIL] > 1.0 or p[ENGINE_J] > 0.0 or p[ENGINE_IDLE] > 0.0:
        a = converter(s, p, a)
    if a > 0.0 and a * s[V] > p[POWER]:
        a = p[POWER] / s[V]
    if p[GAIN] > 0.0 and a > -0.3 and s[V] < p[GAIN_V]:
        a += p[GAIN] * (1.0 - s[V] / p[GAIN_V])
    if p[RIPPLE] > 0.0 and s[V] > 0.0:
        a += p[RIPPLE] * math.sin(2.0 * math.pi * p[PER_METRE] * s[WAY])
    return a, lifted


@compiled
def ground(q: FloatArray, p: FloatArray) -> tuple[float, float]:
    """Angles at which the ground rises ahead and to the left of the car at q [rad]."""
    up = p[GRADE] * math.cos(q[YAW] - p[GRADE_H])
    left = p[BANK] * math.cos(q[YAW] - p[BANK_H])
    if p[HILL] != 0.0:
        dx, dy = q[X] - p[HILL_X], q[Y] - p[HILL_Y]
        z = p[HILL] * math.exp(-(dx * dx + dy * dy) / (2.0 * p[HILL_L] * p[HILL_L]))
        zx, zy = -z * dx / (p[HILL_L] * p[HILL_L]), -z * dy / (p[HILL_L] * p[HILL_L])
        up += math.atan(zx * math.cos(q[YAW]) + zy * math.sin(q[YAW]))
        left += math.atan(zy * math.cos(q[YAW]) - zx * math.sin(q[YAW]))
    return up, left


@compiled
def steering(s: FloatArray, p: FloatArray, commands: FloatArray, last: int, t: float) -> float:
    """Mean road-wheel angle of the step [rad]."""
    d = held(commands, last, 1, t - p[STEER_T])
    if p[STICK] > 0.0:  # a mean of two commands would be a place to stick at
        d = commands[min(max(math.floor((t - p[STEER_T] + 0.5 * H) / PERIOD), 0), last), 1]
    d *= p[RATIO] * (p[LEFT] if d > 0.0 else p[RIGHT]) / (1.0 + p[RATIO_V] * s[V])
    d *= (s[V] + p[ASSIST_V] + p[ASSIST] * s[V]) / (s[V] + p[ASSIST_V])
    d += p[OFFSET]
    d = min(max(d, -p[STEER_MAX]), p[STEER_MAX])
    old = s[D_LAG]
    s[D_LAG] = follow(old, d, p[STEER_TAU])
    if p[STEER_TAU] > 0.0:
        d = 0.5 * (old + s[D_LAG])
    old = s[D_RATE]
    s[D_RATE] = min(max(d, old - p[STEER_RATE] * H), old + p[STEER_RATE] * H)
    d = s[D_RATE]
    if p[RES_F] > 0.0:
        w = 2.0 * math.pi * p[RES_F]
        s[W_RES] += H * (w * w * (d - s[D_RES]) - 2.0 * p[RES_D] * w * s[W_RES])
        s[D_RES] += H * s[W_RES]
        d = s[D_RES]
    if abs(d - s[D_STICK]) >= p[STICK]:  # breaks away and catches up
        if p[STICK] > 0.0 and (p[STEER_TAU] > 0.0 or p[STEER_RATE] < math.inf):  # the instant lies within the step
            d = s[D_STICK] + math.copysign(p[STICK] * math.floor(abs(d - s[D_STICK]) / p[STICK]), d - s[D_STICK])
        s[D_STICK] = d
    d = s[D_STICK]
    if s[V] >= CRAWL:
        s[RESTED] = 0.0
    elif s[RESTED] == 0.0:
        s[RESTED] = s[HOLDS] = 1.0
    if s[HOLDS] == 0.0 or abs(d - s[D_FREE]) >= p[HOLD]:
        s[HOLDS] = 0.0
        s[D_FREE] = d
    d = s[D_FREE]
    s[D_PLAY] = min(max(s[D_PLAY], d - p[PLAY]), d + p[PLAY])
    d = s[D_PLAY]
    if p[GUST] > 0.0:
        d += p[GUST] * math.sin(2.0 * math.pi * t / p[GUST_T])
    if p[ROLL_GAIN] > 0.0:
        s[ROLL] = follow(s[ROLL], p[ROLL_GAIN] * (s[R] * s[V] / G + math.sin(ground(s[:8], p)[1])), p[ROLL_TAU])
        d -= s[ROLL]
    return d


@compiled
def grip(force: float, most: float) -> float:
    """Linear force that levels off at `most`."""
    if most == math.inf:
        return force
    return most * math.tanh(force / most)


@compiled
def tyres(q: FloatArray, p: FloatArray, d: float) -> tuple[float, float]:
    """Steady lateral forces of front and rear axle [N] in motion q."""
    a, b = p[C_A], p[C_L] - p[C_A]
    v = max(q[V], SLOW)
    soft = 1.0 - p[TRANSFER] * (q[R] * q[V] / G + math.sin(ground(q, p)[1])) ** 2
    stiff = p[C_CF] * soft
    slip = d - math.atan((q[VY] + a * q[R]) / v)
    load = p[C_M] * p[GRIP] / p[C_L]
    rear = grip(-p[C_CR] * soft * math.atan((q[VY] - b * q[R]) / v), load * a)
    # d turns back by c F, and F = grip(C (d - c F - ...)): the linear F, then by halving the interval
    front = grip(stiff / (1.0 + 1e-3 * p[COMPLY] * stiff) * slip, load * b)
    if p[COMPLY] > 0.0 and p[GRIP] < math.inf:
        low, high = min(grip(stiff * slip, load * b), 0.0), max(grip(stiff * slip, load * b), 0.0)
        for _ in range(40):
            front = 0.5 * (low + high)
            if grip(stiff * (slip - 1e-3 * p[COMPLY] * front), load * b) > front:
                low = front
            else:
                high = front
    return front, rear


@compiled
def slope(q: FloatArray, p: FloatArray, a: float, d: float, slipping: bool, f: FloatArray) -> None:
    """Time derivative f of the motion q at produced acceleration a, without a load, and road-wheel angle d."""
    b = p[C_L] - p[C_A]
    v = q[V]
    r = q[R] if slipping else v * math.tan(d) / p[C_L]
    vy_rear = q[VY] - b * r if slipping else 0.0
    c, s = math.cos(q[YAW]), math.sin(q[YAW])
    wind = p[WIND]
    if p[WIND_H] != math.inf:  # of the vector over ground, the part against the car
        wind *= math.cos(p[WIND_H]) * c + math.sin(p[WIND_H]) * s
    wind += v
    up, left = ground(q, p)
    level, aside = v * math.cos(up), vy_rear * math.cos(left)  # the map is a view from above
    f[X], f[Y] = level * c - aside * s, level * s + aside * c
    f[YAW] = r * math.cos(left) / math.cos(up)
    across = -G * math.sin(left)
    forces = a - p[VISCOUS] * v - p[AERO] * v * v + p[WIND_K] * (v * v - wind * abs(wind))
    along = forces / p[M_RATIO]  # a load changes none of them
    along -= p[ROLLING] + p[CORNER] * abs(r * v - across) + G * math.sin(up)
    f[VY] = f[R] = f[FF] = f[FR] = 0.0
    if slipping:
        front, rear = tyres(q, p, d)
        if p[RELAX] > 0.0:
            f[FF] = (front - q[FF]) * v / p[RELAX]
            f[FR] = (rear - q[FR]) * v / p[RELAX]
            front, rear = q[FF], q[FR]
        d -= 1e-3 * p[COMPLY] * front  # the wheel as it stands
        along += r * q[VY] - front * math.sin(d) / p[C_M]
        f[VY] = (front * math.cos(d) + rear) / p[C_M] - v * r + across
        f[R] = (p[C_A] * front * math.cos(d) - b * rear) / (p[C_I] * p[INERTIA])
    else:
        along += across * b * math.tan(d) / p[C_L]  # the centre of gravity moves across the slope as the car turns
    gear = min(p[GEAR_V] / v, 1.0) if v > 0.0 else 1.0
    f[V] = along / (1.0 + p[GEAR] * gear * gear)


@compiled
def advance(s: FloatArray, p: FloatArray, commands: FloatArray, last: int, fine: FloatArray) -> None:
    """One period with command row `last` held: changes s; fine (SUBSTEPS, 8) gets FINE at the begin of each substep."""
    b = p[C_L] - p[C_A]
    k1, k2, k3, k4, q = np.zeros(8), np.zeros(8), np.zeros(8), np.zeros(8), np.zeros(8)
    for j in range(SUBSTEPS):
        t = last * PERIOD + j * H
        a, lifted = pedals(s, p, commands, last, t)
        d = steering(s, p, commands, last, t)
        v = s[V]
        slipping = p[C_DYNAMIC] > 0.0 and v > SLOW
        up, bank = ground(s[:8], p)
        lean = G * math.sin(up)
        if not slipping:
            s[R] = v * math.tan(d) / p[C_L]
            s[VY] = b * s[R]
        slope(s[:8], p, a - lifted, d, slipping, k1)
        rolls = v > 0.0 or k1[V] > 0.0
        # what stands at the begin of this substep
        fine[j, 0], fine[j, 1], fine[j, 2], fine[j, 3], fine[j, 4] = s[X], s[Y], s[YAW], v, s[R]
        vy_rear = s[VY] - b * s[R]
        if not rolls:
            fine[j, 5] = lean
            fine[j, 6] = G * math.sin(bank)
        else:
            fine[j, 5] = k1[V] - s[R] * vy_rear + lean
            fine[j, 6] = s[R] * v + G * math.sin(bank)
            if slipping:
                fine[j, 6] += k1[VY] - b * k1[R]
        fine[j, 7] = d - 1e-3 * p[COMPLY] * s[FF] if slipping else d
        s[DISC] += H * (v * max(-a, 0.0) - s[DISC] / p[FADE_TAU])
        if not rolls:
            continue
        for i in range(8):
            q[i] = s[i] + 0.5 * H * k1[i]
        slope(q, p, a - lifted, d, slipping, k2)
        for i in range(8):
            q[i] = s[i] + 0.5 * H * k2[i]
        slope(q, p, a - lifted, d, slipping, k3)
        for i in range(8):
            q[i] = s[i] + H * k3[i]
        slope(q, p, a - lifted, d, slipping, k4)
        for i in range(8):
            s[i] += H / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
        s[V] = max(s[V], 0.0)
        if not slipping:
            s[R] = s[V] * math.tan(d) / p[C_L]
            s[VY] = b * s[R]
            s[FF] = p[C_M] * b / p[C_L] * s[R] * s[V]
            s[FR] = p[C_M] * p[C_A] / p[C_L] * s[R] * s[V]
        elif p[RELAX] <= 0.0:
            s[FF], s[FR] = tyres(s[:8], p, d)
        s[WAY] += H * v
        s[ENERGY] += H * v * max(a, 0.0)
        s[HEAT] += H * v * max(-a, 0.0)
