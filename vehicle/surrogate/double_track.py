"""The moving surrogate: four wheels on Magic Formula tyres under a body that rolls and pitches.

Frame as everywhere: x forward, y left, z up; roll > 0 leans to the right, pitch > 0 nose down. Semi-implicit Euler,
meant for 1 kHz; the velocity turns with the body by an exact rotation.

Tyres: similarity method. Normalised slip s = |(Kx kappa, Ky tan alpha)| / (mu Fz); force mu Fz sin(C atan(z - E (z -
atan z))), z = s/C, in the direction of the slip. Ky and mu fall with load. Both slips are relaxed over a length, with
the damping of low speeds that lets a car stand still. Source: H. B. Pacejka, Tire and Vehicle Dynamics, 3rd ed., secs.
4.3.1 (formula), 4.3.2 (similarity), 8.6 (single contact point, eq. 8.128 for standstill).
Body: M. Mitschke, H. Wallentowitz, Dynamik der Kraftfahrzeuge, 5th ed., secs. 25-27 (loads, roll).
Valid on a plane, wheels on the ground, up to the friction limit.
"""

from __future__ import annotations

import math

import numpy as np

from machine_code import compiled
from vehicle.messages import FloatArray
from vehicle.surrogate.car import Car
from vehicle.surrogate.hidden import EFFECTS, PERCEPTION, Hidden

G = 9.80665  # m/s^2
AIR = 1.2  # kg/m^3
IDLE = 0.05  # m/s^2, a smaller command means that no pedal is pressed
STEER_STIFF_TIME = 0.01  # s, in which an elastic steering settles
STANDS = 0.05  # m/s, a slower car is taken to stand
LOW_SPEED = 2.5  # m/s, below it slip is damped
DAMPING_X, DAMPING_Y = 1600.0, 4000.0  # N s/m a tyre at standstill
RING = 4096  # commands remembered: 1 s at 4 kHz

# State
X, Y, YAW, VX, VY, R = range(6)  # position of the centre of gravity, motion there
PHI, DPHI, THETA, DTHETA = range(6, 10)
W0 = 10  # four wheel speeds [rad/s]: front left, front right, rear left, rear right
K0 = 14  # four relaxed longitudinal slips
A0 = 18  # four relaxed lateral slips (tan alpha)
D_LAG, D_RATE, D_STICK, D_PLAY, D_WHEEL = range(22, 27)
A_LAG, A_BRAKE, A_JERK, WORK, STEPS = range(27, 32)
FZ0 = 32  # four wheel loads of the last step [N]
FY_FRONT = 36  # N
T_MOTOR, T_BRAKE = 37, 38  # N m at the motor; N m of all wheels
DISC = 39  # J/kg in the brake discs over the mass of the car
D_REST, STUCK, RESTING = range(40, 43)  # wheel angle that sticks after a standstill, whether it does, whether it stands
N_STATE = 43  # all of the above
ROW = ("x", "y", "yaw", "vx", "vy_rear", "yaw_rate", "ax", "ay", "steer", "roll", "pitch", "v_wheels")
"""Columns of the fine record, of the rear axle; ax, ay as a sensor in the leaning body feels them."""

# Parameters: the car's numbers in the order of their declaration, then the hidden effects
CAR_AT = {name: k for k, name in enumerate(Car.__dataclass_fields__)}
HIDDEN_AT = {
    pair: len(CAR_AT) + k
    for k, pair in enumerate((name, key) for name in EFFECTS if name not in PERCEPTION for key in EFFECTS[name])
}
N_PARAMETER = len(CAR_AT) + len(HIDDEN_AT)
_C = CAR_AT
M, L, A, HCG, TR = _C["mass"], _C["wheelbase"], _C["cg_to_front_axle"], _C["cg_height"], _C["track"]
IZ, IX, IY = _C["yaw_inertia"], _C["roll_inertia"], _C["pitch_inertia"]
KRF, KRR, CR = _C["roll_stiffness_front"], _C["roll_stiffness_rear"], _C["roll_damping"]
KP, CP, RCF, RCR = _C["pitch_stiffness"], _C["pitch_damping"], _C["roll_centre_front"], _C["roll_centre_rear"]
RW, IW, IM, GEAR = _C["wheel_radius"], _C["wheel_inertia"], _C["motor_inertia"], _C["gear_ratio"]
TMAX, PMAX, WMAX, BF = _C["motor_torque"], _C["motor_power"], _C["motor_speed"], _C["brake_front"]
MU, DMU, DCY = _C["friction"], _C["friction_sensitivity"], _C["load_sensitivity"]
CYF, CYR, CX = _C["cornering_front"], _C["cornering_rear"], _C["slip_coefficient"]
CC, CE, RELY = _C["curve_factor"], _C["curve_shape"], _C["relaxation_lateral"]
MRISE, BRISE = _C["motor_rise"], _C["brake_rise"]
RELX, ROLLING, CDA = _C["relaxation_longitudinal"], _C["rolling_coefficient"], _C["drag_area"]
_H = HIDDEN_AT
H_DRIVE_T, H_DRIVE_TAU, H_BRAKE_TAU = _H["drive_delay", "T"], _H["drive_lag", "tau"], _H["brake_lag", "tau"]
H_DRIVE_G, H_BRAKE_G, H_JERK = _H["drive_gain", "g"], _H["brake_gain", "g"], _H["jerk_limit", "limit"]
H_POWER, H_BRAKE, H_DEAD = _H["power_limit", "limit"], _H["brake_limit", "limit"], _H["pedal_deadband", "width"]
H_LIFT, H_ROLLING, H_VISCOUS = _H["lift_off_braking", "a"], _H["rolling_resistance", "c"], _H["viscous_resistance", "c"]
H_AERO, H_GRADE, H_GRADE_H = _H["aero_drag", "k"], _H["road_grade", "slope"], _H["road_grade", "heading"]
H_BANK, H_BANK_H = _H["road_bank", "slope"], _H["road_bank", "heading"]
H_WIND, H_WIND_K, H_WIND_H = _H["headwind", "speed"], _H["headwind", "k"], _H["headwind", "heading"]
H_TORQUE, H_FADE, H_COOL = _H["drive_torque_limit", "limit"], _H["brake_fade", "k"], _H["brake_fade", "tau"]
H_ASSIST, H_ASSIST_V, H_HOLD = _H["steer_assist", "g"], _H["steer_assist", "v0"], _H["steer_sticking", "width"]
H_HILL, H_HILL_X = _H["road_profile", "height"], _H["road_profile", "x"]
H_HILL_Y, H_HILL_L = _H["road_profile", "y"], _H["road_profile", "length"]
H_STEER_T, H_STEER_TAU, H_STEER_RATE = _H["steer_delay", "T"], _H["steer_lag", "tau"], _H["steer_rate_limit", "limit"]
H_STEER_MAX, H_STICK, H_PLAY = (
    _H["steer_angle_limit", "limit"],
    _H["steer_stiction", "width"],
    _H["steer_backlash", "half_width"],
)
H_RATIO, H_LEFT, H_RIGHT = _H["steer_ratio", "g"], _H["steer_asymmetry", "g_left"], _H["steer_asymmetry", "g_right"]
H_OFFSET, H_COMPLY, H_ROLL = _H["steer_offset", "offset"], _H["steer_compliance", "c"], _H["roll_dynamics", "gain"]
H_UNDER, H_MASS, H_INERTIA = _H["understeer", "K"], _H["mass", "ratio"], _H["yaw_inertia", "ratio"]


def parameters(hidden: Hidden) -> FloatArray:
    """The car and what is hidden in it as one array (N_PARAMETER,) in SI units for the compiled step."""
    p = np.zeros(N_PARAMETER)
    for name, k in CAR_AT.items():
        p[k] = getattr(hidden.car, name)
    for (name, key), k in HIDDEN_AT.items():
        p[k] = hidden.value(name, key)
    if "tyre_relaxation" in hidden.effects:
        p[RELY] = max(hidden.value("tyre_relaxation", "length"), 0.01)
    p[MU] = min(p[MU], hidden.value("tyre_saturation", "limit") / G)
    return p


@compiled
def _delayed(ring: FloatArray, column: int, count: int, delay: float, h: float) -> float:
    """Command of `delay` [s] ago, mean over the step; before the first command the first one."""
    steps = delay / h
    whole = int(steps + 1e-9)
    part = max(steps - whole, 0.0)
    newer = ring[max(count - whole, 0) % RING, column]
    older = ring[max(count - whole - 1, 0) % RING, column]
    return float(newer + part * (older - newer))


@compiled
def _lag(y: float, u: float, tau: float, h: float) -> float:
    return u if tau <= 0.0 else y + (u - y) * h / (tau + h)


@compiled
def _steer(s: FloatArray, p: FloatArray, ring: FloatArray, count: int, h: float) -> float:
    """Angle of the front wheels [rad]: command unit, motor, play, column."""
    d = _delayed(ring, 0, count, p[H_STEER_T], h)
    v = abs(s[VX])
    d *= 1.0 + p[H_ASSIST] * v / (v + p[H_ASSIST_V])
    d = d * p[H_RATIO] * (p[H_LEFT] if d > 0.0 else p[H_RIGHT]) + p[H_OFFSET]
    d = min(max(d, -p[H_STEER_MAX]), p[H_STEER_MAX])
    s[D_LAG] = _lag(s[D_LAG], d, p[H_STEER_TAU], h)
    s[D_RATE] += min(max(s[D_LAG] - s[D_RATE], -p[H_STEER_RATE] * h), p[H_STEER_RATE] * h)
    if abs(s[D_RATE] - s[D_STICK]) >= p[H_STICK]:
        s[D_STICK] = s[D_RATE]
    stands = 1.0 if v < STANDS else 0.0
    if stands > s[RESTING]:
        s[STUCK] = 1.0
    s[RESTING] = stands
    if s[STUCK] == 0.0 or abs(s[D_STICK] - s[D_REST]) >= p[H_HOLD]:
        s[STUCK], s[D_REST] = 0.0, s[D_STICK]
    s[D_PLAY] = min(max(s[D_PLAY], s[D_REST] - p[H_PLAY]), s[D_REST] + p[H_PLAY])
    if p[H_COMPLY] > 0.0:
        target = s[D_PLAY] - p[H_COMPLY] * s[FY_FRONT] / 1000.0
        s[D_WHEEL] = _lag(s[D_WHEEL], target, STEER_STIFF_TIME, h)
    else:
        s[D_WHEEL] = s[D_PLAY]
    return float(s[D_WHEEL] - p[H_ROLL] * s[PHI])


@compiled
def _pedals(s: FloatArray, p: FloatArray, ring: FloatArray, count: int, h: float) -> tuple[float, float]:
    """Asked acceleration after the command path (brake < 0) and the drag of a lifted pedal [m/s^2]."""
    a = _delayed(ring, 1, count, p[H_DRIVE_T], h)
    lifted = p[H_LIFT] if a < IDLE else 0.0
    braked = a <= -IDLE
    if abs(a) < p[H_DEAD]:
        a = 0.0
    a *= p[H_DRIVE_G] if a > 0.0 else p[H_BRAKE_G]
    if braked:  # the brakes do what the motor does not
        a = min(a + lifted, 0.0)
    s[A_LAG] = _lag(s[A_LAG], a, p[H_DRIVE_TAU], h)
    a = s[A_LAG]
    if a < 0.0:
        s[A_BRAKE] = _lag(s[A_BRAKE], a, p[H_BRAKE_TAU], h)
        a = s[A_BRAKE]
    else:
        s[A_BRAKE] = 0.0
    s[A_JERK] += min(max(a - s[A_JERK], -p[H_JERK] * h), p[H_JERK] * h)
    return max(s[A_JERK], -p[H_BRAKE]), lifted


@compiled
def _tyre(kappa: float, tangent: float, fz: float, static: float, p: FloatArray, stiff: float) -> tuple[float, float]:
    """Forces of one tyre along and across [N]; `stiff` [1/rad] is its cornering stiffness over the static load."""
    if fz <= 0.0:
        return 0.0, 0.0
    more = (fz - static) / static
    most = max(p[MU] * (1.0 - p[DMU] * more), 0.05) * fz
    qx = p[CX] * fz * kappa / most
    qy = stiff * max(1.0 - p[DCY] * more, 0.05) * fz * tangent / most
    q = math.sqrt(qx * qx + qy * qy)
    if q < 1e-9:
        return qx * most, qy * most
    z = q / p[CC]
    force = most * math.sin(p[CC] * math.atan(z - p[CE] * (z - math.atan(z))))
    return force * qx / q, force * qy / q


@compiled
def advance(
    s: FloatArray, p: FloatArray, ring: FloatArray, steer: float, accel: float, n: int, h: float, rows: FloatArray
) -> None:
    """n steps of h [s] with the command held; rows (n, 12) gets ROW at the begin of each step."""
    a, b = p[A], p[L] - p[A]
    mass = p[M] * p[H_MASS]
    inertia = p[IZ] * p[H_INERTIA]
    half = 0.5 * p[TR]
    stiff_f = p[CYF] / (1.0 + p[H_UNDER] * p[CYF] * G)
    wx, wy, fx, fy = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    for j in range(n):
        count = int(s[STEPS])
        ring[count % RING, 0], ring[count % RING, 1] = steer, accel
        s[STEPS] += 1.0
        d = _steer(s, p, ring, count, h)
        ask, lifted = _pedals(s, p, ring, count, h)
        cd, sd = math.cos(d), math.sin(d)
        vx, vy, r = s[VX], s[VY], s[R]
        grade = p[H_GRADE] * math.cos(s[YAW] - p[H_GRADE_H])
        bank = p[H_BANK] * math.cos(s[YAW] - p[H_BANK_H])
        if p[H_HILL] != 0.0:
            east, north = (s[X] - p[H_HILL_X]) / p[H_HILL_L], (s[Y] - p[H_HILL_Y]) / p[H_HILL_L]
            steep = p[H_HILL] / p[H_HILL_L] * math.exp(-0.5 * (east * east + north * north))
            grade -= math.atan(steep * (east * math.cos(s[YAW]) + north * math.sin(s[YAW])))
            bank -= math.atan(steep * (north * math.cos(s[YAW]) - east * math.sin(s[YAW])))
        pull_x, pull_y = -G * math.sin(grade), -G * math.sin(bank)
        down = mass * G * math.cos(grade) * math.cos(bank)

        # loads: what springs and dampers carry over
        over = (p[KP] * s[THETA] + p[CP] * s[DTHETA]) / p[L]  # from the rear axle to the front one
        split = p[KRF] / (p[KRF] + p[KRR])
        turn_f = p[KRF] * s[PHI] + split * p[CR] * s[DPHI]
        turn_r = p[KRR] * s[PHI] + (1.0 - split) * p[CR] * s[DPHI]
        side_f = (turn_f + s[FY_FRONT] * p[RCF]) / p[TR]
        side_r = (turn_r + s[FY_FRONT] * a / b * p[RCR]) / p[TR]
        front, rear = down * b / (2.0 * p[L]), down * a / (2.0 * p[L])
        s[FZ0] = max(front + 0.5 * over - side_f, 0.0)
        s[FZ0 + 1] = max(front + 0.5 * over + side_f, 0.0)
        s[FZ0 + 2] = max(rear - 0.5 * over - side_r, 0.0)
        s[FZ0 + 3] = max(rear - 0.5 * over + side_r, 0.0)

        # motor and brakes
        speed_m = 0.5 * (s[W0 + 2] + s[W0 + 3]) * p[GEAR]
        torque_m = 0.0
        if ask > 0.0 and speed_m < p[WMAX]:
            torque_m = min(ask * p[M] * p[RW] / p[GEAR], p[TMAX], p[H_TORQUE] * p[M] * p[RW] / p[GEAR])
            if speed_m > 1.0:
                torque_m = min(torque_m, p[PMAX] / speed_m, p[H_POWER] * p[M] / speed_m)
        s[T_MOTOR] = torque_m = _lag(s[T_MOTOR], torque_m, p[MRISE], h)
        pressed = max(-ask, 0.0) / (1.0 + p[H_FADE] * s[DISC])
        rolling = 0.25 * p[RW] * abs(s[W0] + s[W0 + 1] + s[W0 + 2] + s[W0 + 3])
        s[DISC] += h * (pressed * rolling - s[DISC] / p[H_COOL])
        s[T_BRAKE] = brake = _lag(s[T_BRAKE], (pressed + lifted) * p[M] * p[RW], p[BRISE], h)
        s[WORK] += h * torque_m * speed_m

        # wheels: speeds, slips, forces
        for i in range(4):
            left = half if i % 2 == 0 else -half
            along = vx - r * left
            across = vy + r * (a if i < 2 else -b)
            if i < 2:
                wx[i], wy[i] = along * cd + across * sd, across * cd - along * sd
            else:
                wx[i], wy[i] = along, across
            turning = p[IW] if i < 2 else p[IW] + 0.5 * p[IM] * p[GEAR] * p[GEAR]
            gone = abs(wx[i])
            fade = 0.5 * (1.0 + math.cos(math.pi * gone / LOW_SPEED)) if gone < LOW_SPEED else 0.0
            fz = s[FZ0 + i]
            slide = wx[i] - s[W0 + i] * p[RW]
            s[K0 + i] = (s[K0 + i] - h * slide / p[RELX]) / (1.0 + h * gone / p[RELX])
            s[A0 + i] = (s[A0 + i] - h * wy[i] / p[RELY]) / (1.0 + h * gone / p[RELY])
            s[K0 + i] = min(max(s[K0 + i], -1.0), 1.0)
            s[A0 + i] = min(max(s[A0 + i], -1.0), 1.0)
            kappa, tangent = s[K0 + i], s[A0 + i]
            if fz > 0.0 and fade > 0.0:
                kappa -= fade * DAMPING_X * slide / (p[CX] * fz)
                tangent -= fade * DAMPING_Y * wy[i] / (p[CYR] * fz)
            fx[i], fy[i] = _tyre(kappa, tangent, fz, front if i < 2 else rear, p, stiff_f if i < 2 else p[CYR])
            torque = -fx[i] * p[RW] + (0.5 * torque_m * p[GEAR] if i >= 2 else 0.0)
            share = 0.5 * p[BF] if i < 2 else 0.5 * (1.0 - p[BF])
            friction = share * brake + (p[ROLLING] * fz + p[H_ROLLING] * 0.25 * mass) * p[RW]
            spin = s[W0 + i] + h * torque / turning
            held = h * friction / turning
            s[W0 + i] = spin - held if spin > held else (spin + held if spin < -held else 0.0)

        # sums at the body
        long = (fx[0] + fx[1]) * cd - (fy[0] + fy[1]) * sd + fx[2] + fx[3]
        lat_f = (fx[0] + fx[1]) * sd + (fy[0] + fy[1]) * cd
        lat = lat_f + fy[2] + fy[3]
        left_f, right_f = fx[0] * cd - fy[0] * sd, fx[1] * cd - fy[1] * sd
        moment = a * lat_f - b * (fy[2] + fy[3]) + half * (right_f - left_f + fx[3] - fx[2])
        s[FY_FRONT] = lat_f
        wind = vx + p[H_WIND] * (1.0 if p[H_WIND_H] == math.inf else math.cos(s[YAW] - p[H_WIND_H]))
        air = 0.5 * AIR * p[CDA] * vx * abs(vx)
        air += p[M] * (p[H_VISCOUS] * vx + p[H_AERO] * vx * abs(vx))
        air += p[M] * p[H_WIND_K] * (wind * abs(wind) - vx * abs(vx))
        feel_x, feel_y = (long - air) / mass, lat / mass  # specific force at the centre of gravity
        spin_up = moment / inertia

        # what stands at the begin of this step, at the rear axle
        row = rows[j]
        row[0], row[1] = s[X] - b * math.cos(s[YAW]), s[Y] - b * math.sin(s[YAW])
        row[2], row[3], row[4], row[5] = s[YAW], vx, vy - b * r, r
        row[6] = feel_x + b * r * r - G * math.sin(s[THETA])
        row[7] = (feel_y - b * spin_up) * math.cos(s[PHI]) + G * math.sin(s[PHI])
        row[8], row[9], row[10] = d, s[PHI], s[THETA]
        row[11] = 0.5 * (s[W0 + 2] + s[W0 + 3]) * p[RW]

        # motion
        c, sn = math.cos(r * h), math.sin(r * h)
        s[VX] = vx * c + vy * sn + h * (feel_x + pull_x)
        s[VY] = vy * c - vx * sn + h * (feel_y + pull_y)
        s[R] = r + h * spin_up
        turned = s[R] * math.cos(bank) / math.cos(grade)  # in the map, as the way ahead and aside
        heading = s[YAW] + 0.5 * h * turned
        c, sn = math.cos(heading), math.sin(heading)
        ux, uy = 0.5 * (vx + s[VX]) * math.cos(grade), 0.5 * (vy + s[VY]) * math.cos(bank)
        s[X] += h * (ux * c - uy * sn)
        s[Y] += h * (ux * sn + uy * c)
        s[YAW] += h * turned

        # lean: forces at the ground act on the arm below the centre of gravity
        arm = p[HCG] - (b * p[RCF] + a * p[RCR]) / p[L]
        roll = arm * lat + mass * G * arm * s[PHI] - (turn_f + turn_r)
        pitch = -p[HCG] * long + mass * G * p[HCG] * s[THETA] - (p[KP] * s[THETA] + p[CP] * s[DTHETA])
        s[DPHI] += h * roll / p[IX]
        s[DTHETA] += h * pitch / p[IY]
        s[PHI] += h * s[DPHI]
        s[THETA] += h * s[DTHETA]
