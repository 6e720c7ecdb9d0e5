"""The compiled step: commands -> actuators -> road -> forces -> body -> motion -> sensors.

`run` is for the twin: many small steps, sensors after each. `replay` drives a log: steps as long as its samples; a row
shows the motion at its stamp under the command that begins there.

Effects are called by address in their slots (see `vehicle.model.effect_compiler`).

Motion is a single-track model at the rear axle. Longitudinal: m v' = traction + drag + gravity -+ (brake + resistance),
where brake and resistance are dry friction: they never push the car backward, and hold it at standstill. Lateral,
`kinematic_bicycle`: r = v tan(d)/L, no slip. `dynamic_bicycle`: linear tyres at the axles,

    m (vy' + vx r) = Fyf cos d + Fyr,   I r' = a Fyf cos d - b Fyr,   Fyf = Cf (d - atan((vy + a r)/vx)), ...

integrated by the linearly implicit trapezoidal rule (second order, stable for stiff tyres at low speed), blended
smoothly into the kinematic model between 2 and 1 m/s; below 1 m/s and in reverse it is purely kinematic (speeds of a
car with a wheelbase of 2 m or more; those of a smaller one go with the root of its size).

Speeds and rates are those of the body, along and about the normal of the ground. On a slope, x and y, level in the map,
change by vx cos(grade) ahead and vy cos(bank) aside, and the heading by r cos(bank)/cos(grade) (Euler angles; without
what pitching over a crest adds on a bank, the product of two small angles).

Source: R. Rajamani, Vehicle Dynamics and Control, 2nd ed., eqs. 2.24-2.31 (single track), 2.1 (kinematic);
E. Hairer, G. Wanner, Solving ODEs II, sec. IV.7 (linearly implicit methods). Valid for lateral accelerations up to
about 4 m/s^2 with linear tyres; beyond, add `tyre_saturation`.
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped,unused-ignore]
from numba import types
from numba.extending import intrinsic

from machine_code import compiled
from vehicle.messages import FloatArray
from vehicle.model.air_forces import blow
from vehicle.model.bus import BLEND_TIME, GRAVITY
from vehicle.model.imposed_speed import heed_shown, push_as_told, take_as_shown
from vehicle.model.road_hold import hold, hold_across, hold_along, hold_path, left_across

KINEMATIC, DYNAMIC = 0, 1
ACCELERATION, PEDALS, SPEED, IMPOSED = 0, 1, 2, 3

COMMAND_COLUMNS = ("steer_cmd", "accel_cmd", "throttle_cmd", "brake_cmd", "speed_cmd", "v_cmd")

SETTLING = 10.0  # s
SETTLING_STEPS = 8  # of SETTLING s before the start; chosen, not measured
SHAPES, TAKES = 8, 10  # parts of the slot body: what forms the tyres' forces, and what takes those that the road holds


@intrinsic  # type: ignore[untyped-decorator,unused-ignore]
def call_effect(
    typingctx: Any, address: Any, bus: Any, parameters: Any, p_at: Any, memory: Any, m_at: Any
) -> tuple[Any, Any]:
    """Call the C function at `address` with the bus and the effect's places in the parameter and memory arrays."""
    signature = types.void(address, bus, parameters, p_at, memory, m_at)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        word, byte_pointer = ir.IntType(64), ir.PointerType(ir.IntType(8))

        def place(array_type: Any, array: Any, offset: Any) -> Any:
            data = builder.ptrtoint(context.make_array(array_type)(context, builder, array).data, word)
            return builder.inttoptr(builder.add(data, builder.mul(offset, ir.Constant(word, 8))), byte_pointer)

        function_type = ir.FunctionType(ir.VoidType(), [byte_pointer] * 3)
        function = builder.inttoptr(args[0], ir.PointerType(function_type))
        bus_place = place(sig.args[1], args[1], ir.Constant(word, 0))
        pointers = [bus_place, place(sig.args[2], args[2], args[3]), place(sig.args[4], args[4], args[5])]
        builder.call(function, pointers)
        return context.get_dummy_value()

    return signature, codegen


@compiled
def _slot(index: int, bus: Any, table: Any, bounds: Any, parameters: Any, memory: Any) -> None:
    for j in range(bounds[index], bounds[index + 1]):
        call_effect(table[j, 0], bus, parameters, table[j, 1], memory, table[j, 2])  # type: ignore[call-arg]


@compiled
def _wish(x: Any, mode: int) -> None:
    """Inputs of the model file -> wanted acceleration and road-wheel angle."""
    x.steer = x.steer_zero + x.steer_scale * x.steer_cmd
    x.accel_lead = x.accel_jump = x.accel_brakes = 0.0
    x.steer_lead = -0.5 * x.steer_scale * x.steer_slope
    x.steer_glides = 0.0 if x.steer_slope == 0.0 else 1.0
    if mode == ACCELERATION:
        x.accel = x.accel_cmd
    elif mode == PEDALS:
        throttle = min(max(x.throttle_cmd, 0.0), 1.0)
        brake = min(max(x.brake_cmd, 0.0), 1.0)
        x.accel = x.full_throttle * throttle - x.full_brake * brake
    else:
        x.accel = 0.0


@compiled
def _tyres(x: Any) -> None:
    """Slip angles and forces of linear axles; those of a car so slow that it moves without slip are of its path."""
    if x.vx <= x.slow:
        across = x.mass * x.vx * x.yaw_rate / x.wheelbase
        x.fy_front, x.fy_rear = x.cg_rear * across, x.cg_front * across
        x.slip_front, x.slip_rear = x.fy_front / x.stiffness_front, x.fy_rear / x.stiffness_rear
        x.tangent_front = x.tangent_rear = 0.0
        return
    speed = x.vx
    qf = (x.vy + x.cg_front * x.yaw_rate) / speed
    qr = (x.vy - x.cg_rear * x.yaw_rate) / speed
    x.slip_front = x.steer - math.atan(qf)
    x.slip_rear = -math.atan(qr)
    x.tangent_front = x.stiffness_front
    x.tangent_rear = x.stiffness_rear
    x.fy_front = x.stiffness_front * x.slip_front
    x.fy_rear = x.stiffness_rear * x.slip_rear


@compiled
def _act(x: Any, kind: int, mode: int, bus: Any, table: Any, bounds: Any, parameters: Any, memory: Any) -> None:
    """Everything that acts on the car during the step that begins now."""
    x.resistance = x.drive_drag = x.drag = x.push = x.steered_pull = 0.0
    x.rotating_mass = x.yaw_moment = x.lean_y = 0.0
    x.turning_inertia = x.yaw_inertia
    x.load_front = x.load_rear = 1.0
    x.tyre_limit = math.inf
    _wish(x, mode)
    _slot(0, bus, table, bounds, parameters, memory)
    _slot(1, bus, table, bounds, parameters, memory)
    x.grade, x.bank = x.road_grade, x.road_bank
    _slot(4, bus, table, bounds, parameters, memory)
    steer = x.steer
    kinematic = math.tan(steer) / x.wheelbase
    x.curvature = x.yaw_rate / x.vx if kind == DYNAMIC and x.vx > 2.0 * x.slow else kinematic
    held = x.road_friction > 0.0
    if held:
        hold_path(x, hold(x))
    start = x.accel + x.accel_lead
    if x.vx == 0.0 and x.accel_lead == x.accel_jump and start < 0.0 < x.accel_arrived:
        share = (x.accel - start) / (x.accel_arrived - start)
        x.accel = share * x.accel_arrived  # brakes hold the car until the drive arrives
        x.accel_lead = start - x.accel
    x.traction = x.mass_ref * max(x.accel, 0.0)
    x.brake = x.mass_ref * max(-x.accel, 0.0)
    if x.wind_x != 0.0 or x.wind_y != 0.0:
        blow(x)
    _slot(2, bus, table, bounds, parameters, memory)
    if held:
        hold_along(x)
    if mode == IMPOSED:
        push_as_told(x, _blend(x, kind))
    if kind == DYNAMIC:
        _tyres(x)
    _slot(SHAPES, bus, table, bounds, parameters, memory)
    if held and kind == DYNAMIC:
        hold_across(x)
    _slot(TAKES, bus, table, bounds, parameters, memory)
    x.curvature = kinematic if x.steer == steer else math.tan(x.steer) / x.wheelbase
    if held:
        hold_path(x, left_across(x))


@compiled
def _blend(x: Any, kind: int) -> float:
    """Share of the motion with tyres in a car that is kinematic when slow."""
    if kind != DYNAMIC:
        return 0.0
    s = min(max(x.vx / x.slow - 1.0, 0.0), 1.0)
    return float(s * s * (3.0 - 2.0 * s))


@compiled
def _pull(slope: float) -> float:
    """Specific gravity along a slope [m/s^2]."""
    return 0.0 if slope == 0.0 else -GRAVITY * math.sin(slope)


@compiled
def _along(x: Any, blend: float, mode: int) -> float:
    """Speed at the end of the step: smooth forces, then dry friction, which can stop the car but not reverse it."""
    if mode == IMPOSED:
        return float(x.v_cmd / x.speed_gain)
    inertia = x.mass + x.rotating_mass
    smooth = x.traction + x.drag + x.mass * _pull(x.grade)
    if blend > 0.0:
        smooth += blend * (x.mass * x.yaw_rate * x.vy - x.fy_front * math.sin(x.steer))
    if blend < 1.0 and x.bank != 0.0:  # turning moves the centre of gravity up or down a slope across, too
        smooth += (1.0 - blend) * x.mass * _pull(x.bank) * x.cg_rear * x.curvature
    v1 = x.vx + x.dt * smooth / inertia
    friction = x.dt * (x.brake + x.resistance) / inertia
    if v1 > friction:
        return float(v1 - friction)
    if v1 < -friction:
        return float(v1 + friction)
    return 0.0


@compiled
def _move(x: Any, blend: float, v1: float, mode: int) -> float:
    """Integrate the motion over one step, at whose end the speed is v1 but for what lateral motion changes of it.

    Returns the deceleration [m/s^2] with which a car in the blend pays for being pulled to the kinematic motion.
    """
    dt = x.dt
    v0, r0, vy0, vyr0 = x.vx, x.yaw_rate, x.vy, x.vy_rear
    gy = _pull(x.bank)
    v_mean = 0.5 * (v0 + v1)
    r1 = v1 * x.curvature
    r_mean = v_mean * x.curvature
    vy1 = r1 * x.cg_rear
    x.slip_change_front = x.slip_change_rear = took = 0.0
    if blend > 0.0:
        slope = math.tan(x.steer)
        cos_d = 1.0 / math.sqrt(1.0 + slope * slope)
        speed = max(v0, x.slow)
        qf = (vy0 + x.cg_front * r0) / speed
        qr = (vy0 - x.cg_rear * r0) / speed
        front_slip = 1.0 / (speed * (1.0 + qf * qf))
        rear_slip = 1.0 / (speed * (1.0 + qr * qr))
        front = x.tangent_front * cos_d * front_slip
        rear = x.tangent_rear * rear_slip
        faster = v_mean - v0  # slip angles shrink with speed
        fyf = x.fy_front * cos_d + front * qf * faster
        fyr = x.fy_rear + rear * qr * faster
        f_vy = (fyf + fyr + x.push) / x.mass + gy - v_mean * r0
        f_r = (x.cg_front * fyf - x.cg_rear * fyr + x.yaw_moment) / x.turning_inertia
        turn = x.cg_rear * rear - x.cg_front * front
        h = 0.5 * dt
        j11 = 1.0 + h * (front + rear) / x.mass
        j12 = h * (v_mean - turn / x.mass)
        j21 = -h * turn / x.turning_inertia
        j22 = 1.0 + h * (x.cg_front * x.cg_front * front + x.cg_rear * x.cg_rear * rear) / x.turning_inertia
        scale = dt / (j11 * j22 - j12 * j21)
        vy_dyn = vy0 + scale * (j22 * f_vy - j12 * f_r)
        r_dyn = r0 + scale * (j11 * f_r - j21 * f_vy)
        fade = 0.0
        if blend < 1.0:  # pull towards the kinematic motion, the harder the slower
            fade = dt * (1.0 - blend) / (dt * (1.0 - blend) + blend * BLEND_TIME)
        turned, drifted = fade * (r1 - r_dyn), fade * (vy1 - vy_dyn)
        r1, vy1 = r_dyn + turned, vy_dyn + drifted
        r_mean = 0.5 * (r0 + r1)
        x.slip_change_front = -front_slip * (vy1 - vy0 + x.cg_front * (r1 - r0))
        x.slip_change_rear = -rear_slip * (vy1 - vy0 - x.cg_rear * (r1 - r0))
        if mode != IMPOSED and v1 != 0.0:
            less = -x.tangent_front * front_slip * (vy_dyn - vy0 + x.cg_front * (r_dyn - r0)) * slope * cos_d / x.mass
            v1 += h * blend * (r_dyn * vy_dyn - r0 * vy0 - less)
            # The forces that pull it there act at the steered wheels along, too; they only take speed away.
            pull = (x.cg_rear * x.mass * drifted + x.turning_inertia * turned) / x.wheelbase
            took = min(blend * max(slope * pull, 0.0) / x.mass, max(v1, 0.0))
            v1 -= took
            v_mean = 0.5 * (v0 + v1)
    vyr1 = vy1 - x.cg_rear * r1
    vyr_mean = 0.5 * (vyr0 + vyr1)

    ahead, aside, turned = v_mean, vyr_mean, r_mean
    if x.grade != 0.0 or x.bank != 0.0:  # motion is in the plane of the ground, position and heading are in the map
        up, across = math.cos(x.grade), math.cos(x.bank)
        ahead, aside, turned = ahead * up, aside * across, turned * across / up
    heading = x.yaw + 0.5 * dt * turned
    c, s = math.cos(heading), math.sin(heading)
    x.x += dt * (ahead * c - aside * s)
    x.y += dt * (ahead * s + aside * c)
    x.yaw += dt * turned
    x.ax = (v1 - v0) / dt - r_mean * vyr_mean - _pull(x.grade)
    x.ay = (vyr1 - vyr0) / dt + r_mean * v_mean - gy
    x.vx, x.vy, x.vy_rear, x.yaw_rate = v1, vy1, vyr1, r1
    return float(took / dt)


@compiled
def _show(x: Any, r0: float) -> None:
    """What perfect instruments show at the end of a step that began with the yaw rate r0."""
    x.meas_x, x.meas_y, x.meas_yaw, x.meas_v = x.x, x.y, x.yaw, x.vx
    x.meas_yaw_rate, x.meas_ax, x.meas_ay = x.yaw_rate, x.ax, x.ay + x.lean_y
    if x.ax_x != 0.0:
        x.meas_ax -= x.ax_x * x.yaw_rate * x.yaw_rate
    if x.ay_x != 0.0:
        x.meas_ay += x.ay_x * (x.yaw_rate - r0) / x.dt


@compiled
def _write(row: Any, x: Any, measured: bool) -> None:
    """One row of TRACE_COLUMNS."""
    row[0], row[3], row[7], row[11] = x.t, x.z, x.vy_rear, x.steer - x.steer_lead
    if measured:
        row[1], row[2], row[4], row[5], row[6] = x.meas_x, x.meas_y, x.meas_yaw, x.meas_v, x.meas_v
        row[8], row[9], row[10] = x.meas_yaw_rate, x.meas_ax, x.meas_ay
    else:
        row[1], row[2], row[4], row[5], row[6] = x.x, x.y, x.yaw, x.vx, x.vx
        row[8], row[9], row[10] = x.yaw_rate, x.ax, x.ay


@compiled
def run(
    bus: Any,
    kind: int,
    mode: int,
    table: Any,
    bounds: Any,
    parameters: FloatArray,
    memory: FloatArray,
    commands: FloatArray,
    hold: int,
    every: int,
    measured: bool,
    trace: FloatArray,
) -> int:
    """Advance by `hold` steps for each row of `commands` (COMMAND_COLUMNS); returns the number of trace rows written.

    `bus` is an array of one bus record; `table` int64 (n, 3): address, place of parameters, place of memory of each
    effect, sorted by slot; `bounds` int64 (12,) as of `Layout`; a row of TRACE_COLUMNS is written whenever the
    step count is a multiple of `every`.
    """
    x = bus[0]
    rows = 0
    for i in range(commands.shape[0]):
        x.steer_cmd, x.accel_cmd, x.throttle_cmd = commands[i, 0], commands[i, 1], commands[i, 2]
        x.brake_cmd, x.speed_cmd, x.v_cmd = commands[i, 3], commands[i, 4], commands[i, 5]
        for _ in range(hold):
            _act(x, kind, mode, bus, table, bounds, parameters, memory)
            blend = _blend(x, kind)
            r0 = x.yaw_rate
            _move(x, blend, _along(x, blend, mode), mode)
            x.count += 1.0
            x.t = x.t_start + x.count * x.dt
            _show(x, r0)
            _slot(5, bus, table, bounds, parameters, memory)
            if mode == SPEED:
                heed_shown(x, x.dt, x.count <= 1.0)
            if int(x.count) % every == 0:
                _write(trace[rows], x, measured)
                rows += 1
    return rows


@compiled
def _look(x: Any, blend: float, v1: float, took: float = 0.0) -> None:
    """What a perfect instrument shows at the start of the step: motion and the accelerations that begin now.

    took: deceleration [m/s^2] that `_move` returned of the last step
    """
    rate = (v1 - x.vx) / x.dt - (took if blend > 0.0 else 0.0)
    if v1 != 0.0 and x.accel_lead != 0.0:
        rate += x.accel_lead * x.mass_ref / (x.mass + x.rotating_mass)
        if x.vx == 0.0 and rate * v1 < 0.0:  # brakes hold a standing car, they do not push it
            rate = 0.0
    steer = x.steer + x.steer_lead
    bend = math.tan(steer)
    kinematic = x.vx * bend / x.wheelbase
    r = kinematic
    gy = _pull(x.bank)
    ay = x.vx * r - gy
    if x.ay_x != 0.0:  # ahead of the rear axle the turning itself accelerates, too
        ay += x.ay_x * (rate * bend - x.vx * (1.0 + bend * bend) * 2.0 * x.steer_lead / x.dt) / x.wheelbase
    if blend > 0.0:
        cos_d = math.cos(steer)
        front = (x.fy_front + x.tangent_front * x.steer_lead + x.fy_front_lead) * cos_d
        rear = x.fy_rear + x.fy_rear_lead
        turn = (x.cg_front * front - x.cg_rear * rear + x.yaw_moment) / x.turning_inertia
        r += blend * (x.yaw_rate - kinematic)
        ay += blend * ((front + rear + x.push) / x.mass + (x.ay_x - x.cg_rear) * turn - ay)
    x.meas_x, x.meas_y, x.meas_yaw, x.meas_v = x.x, x.y, x.yaw, x.vx
    x.meas_yaw_rate, x.meas_ay = r, ay + x.lean_y
    x.meas_ax = rate - blend * r * x.vy_rear - x.ax_x * r * r - _pull(x.grade)


@compiled
def _restart(x: Any, state: Any) -> None:
    """Put the car at `state` (x, y, yaw, v, vy at the rear axle, yaw rate); what is NaN runs on.

    Lateral motion runs on in proportion to speed: the car stays on its curve.
    """
    x.old_x, x.old_y, x.old_yaw, x.old_vx, x.moved = x.x, x.y, x.yaw, x.vx, 1.0
    if not math.isnan(state[0]):
        x.x = state[0]
    if not math.isnan(state[1]):
        x.y = state[1]
    if not math.isnan(state[2]):
        x.yaw = state[2]
    if not math.isnan(state[3]):
        if x.vx > x.slow:
            ratio = state[3] / x.vx
            x.yaw_rate *= ratio
            x.vy_rear *= ratio
        else:
            x.yaw_rate, x.vy_rear = state[3] * x.curvature, 0.0
        x.vx = state[3]
    if not math.isnan(state[5]):
        x.yaw_rate = state[5]
    if not math.isnan(state[4]):
        x.vy_rear = state[4]
    x.vy = x.vy_rear + x.cg_rear * x.yaw_rate


@compiled
def _settle(x: Any, mode: int, bus: Any, table: Any, bounds: Any, parameters: Any, memory: Any) -> None:
    """Bring actuators to rest at the first command: long steps, one for each in a row, and the car does not move."""
    x.dt, x.settle = SETTLING, 1.0
    for i in range(SETTLING_STEPS):
        x.t = x.t_start - (SETTLING_STEPS - i) * SETTLING
        _wish(x, mode)
        _slot(0, bus, table, bounds, parameters, memory)
        _slot(1, bus, table, bounds, parameters, memory)
    x.settle = 0.0


@compiled
def replay(
    bus: Any,
    kind: int,
    mode: int,
    table: Any,
    bounds: Any,
    parameters: FloatArray,
    memory: FloatArray,
    t: FloatArray,
    commands: FloatArray,
    slopes: FloatArray,
    step: float,
    starts: Any,
    states: FloatArray,
    out: FloatArray,
) -> None:
    """Drive recorded commands and write what the log would show at its stamps.

    `commands` (n, 6): COMMAND_COLUMNS, held from stamp to stamp, but changing straight by `slopes` (n, 2) of steer_cmd
    and v_cmd, the value at the next stamp minus this one; `step` [s] the longest step; at row starts[j] the motion
    takes states[j]; `out` (n, 8). A row shows the motion at its stamp, with the command of the stamp already acting.
    """
    x = bus[0]
    n = t.shape[0]
    x.t_start = t[0]
    x.steer_cmd, x.accel_cmd, x.throttle_cmd = commands[0, 0], commands[0, 1], commands[0, 2]
    x.brake_cmd, x.speed_cmd, x.v_cmd = commands[0, 3], commands[0, 4], commands[0, 5]
    if starts.shape[0] > 0:
        _restart(x, states[0])
    if mode == IMPOSED:
        x.vx = commands[0, 5]
    shown = mode == IMPOSED or mode == SPEED  # cars that go by the speed that their sensors show
    kept = memory.copy() if shown else memory
    _settle(x, mode, bus, table, bounds, parameters, memory)
    if kind == DYNAMIC and starts.shape[0] > 0 and math.isnan(states[0, 5]):
        x.yaw_rate = x.vx * math.tan(x.steer) / x.wheelbase
        x.vy = x.vy_rear + x.cg_rear * x.yaw_rate
    x.moved = 0.0
    segment = 0
    seen = t[0]
    took = 0.0
    for turn in range(-1 if shown else 0, n):  # the first row twice, at first to learn what sensors make of the speed
        k = max(turn, 0)
        if segment < starts.shape[0] and starts[segment] == k:
            if k > 0:
                _restart(x, states[segment])
            segment += 1
        x.accel_cmd, x.throttle_cmd = commands[k, 1], commands[k, 2]
        x.brake_cmd, x.speed_cmd = commands[k, 3], commands[k, 4]
        span = t[k + 1] - t[k] if k + 1 < n else step
        pieces = max(math.ceil(span / step - 1e-6), 1)
        x.dt = span / pieces
        for i in range(pieces):
            part = (i + 0.5) / pieces
            x.t = t[k] + i * x.dt
            x.steer_cmd = commands[k, 0] + part * slopes[k, 0]
            x.v_cmd = commands[k, 5] + (part + 0.5 / pieces) * slopes[k, 1]
            x.steer_slope = slopes[k, 0] / pieces
            _act(x, kind, mode, bus, table, bounds, parameters, memory)
            blend = _blend(x, kind)
            v1 = _along(x, blend, mode)
            if i == 0:
                _look(x, blend, v1, took)
                dt = x.dt
                if k > 0:
                    x.dt = x.t - seen
                seen = x.t
                _slot(5, bus, table, bounds, parameters, memory)
                if mode == SPEED:
                    heed_shown(x, x.dt, turn < 0)
                x.dt, x.moved = dt, 0.0
                row = out[k]
                row[0], row[1], row[2], row[3] = x.meas_x, x.meas_y, x.meas_yaw, x.meas_v
                row[4], row[5], row[6] = x.meas_yaw_rate, x.meas_ax, x.meas_ay
                row[7] = x.steer + x.steer_lead
                if mode == IMPOSED:
                    take_as_shown(x, turn < 0, states)
                if turn < 0:
                    memory[:] = kept
                    _settle(x, mode, bus, table, bounds, parameters, memory)
                    break
                if k == n - 1:
                    break
            took = _move(x, blend, v1, mode)
