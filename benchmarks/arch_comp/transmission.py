"""The automatic transmission: throttle [%] and brake torque [lb ft] in; speed [mph], engine speed [rpm] and gear out.

The model is the demonstration "Modeling an Automatic Transmission Controller" of The MathWorks as ARCH-COMP uses it:
engine torque map, torque converter, four gears, shift schedule, road load. Blocks, constants, solver and the order of
what a chart does are those of `Autotrans_shift.mdl`, published in cpslab-asu/psy-taliro (examples). Its tables lie in
a data file that is not part of it; they are those that daineto/falsification_benchmarks wrote out for the same problem.
"""

from __future__ import annotations

import numpy as np

from machine_code import compiled
from pytest_dvp.logs.log_contents import FloatArray

STEP = 0.01  # [s], the model's fixed step
TICK = 4  # steps between two looks of the shift logic: it is sampled at 0.04 s
WAIT = 2  # ticks for which a threshold must stay crossed, the model's TWAIT

INERTIA = 0.021991488283555904  # engine and impeller [lb ft s min]
VEHICLE_INERTIA = 12.09414785731247  # at the wheel, in the same units
FINAL_DRIVE, FRICTION, DRAG, WHEEL = 3.23, 40.0, 0.02, 1.0  # [-], [lb ft], [lb ft / mph^2], [ft]
MPH = 2.0 * np.pi * WHEEL * 60.0 / 5280.0  # of a wheel speed of 1 rpm
SLOWEST, FASTEST = 600.0, 6000.0  # where the engine's integrator saturates [rpm]
GEARS = np.array([2.393, 1.450, 1.000, 0.677])

THROTTLES = np.array([0.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0])
ENGINE_SPEEDS = np.arange(800.0, 4801.0, 400.0)
TORQUES = np.array(
    [
        [-40.0, -44.0, -49.0, -53.0, -57.0, -61.0, -65.0, -70.0, -74.0, -78.0, -82.0],
        [215.0, 117.0, 85.0, 66.0, 44.0, 29.0, 10.0, -2.0, -13.0, -22.0, -32.0],
        [245.0, 208.0, 178.0, 148.0, 122.0, 104.0, 85.0, 66.0, 48.0, 33.0, 18.0],
        [264.0, 260.0, 241.0, 219.0, 193.0, 167.0, 152.0, 133.0, 119.0, 96.0, 85.0],
        [264.0, 279.0, 282.0, 275.0, 260.0, 238.0, 223.0, 208.0, 189.0, 171.0, 152.0],
        [267.0, 290.0, 293.0, 297.0, 290.0, 275.0, 260.0, 256.0, 234.0, 212.0, 193.0],
        [267.0, 297.0, 305.0, 305.0, 305.0, 301.0, 293.0, 282.0, 267.0, 249.0, 226.0],
        [267.0, 301.0, 308.0, 312.0, 319.0, 323.0, 319.0, 316.0, 297.0, 279.0, 253.0],
        [267.0, 301.0, 312.0, 319.0, 327.0, 327.0, 327.0, 327.0, 312.0, 293.0, 267.0],
        [267.0, 301.0, 312.0, 319.0, 327.0, 334.0, 334.0, 334.0, 319.0, 305.0, 275.0],
    ]
)
"""[lb ft] by throttle (rows) and engine speed."""

RATIOS = np.concatenate([np.arange(0.0, 0.75, 0.1), np.arange(0.80, 0.905, 0.01), [0.92, 0.94]])  # turbine by impeller
CAPACITIES = np.array(
    [
        *(137.4652089938063, 137.06501915685197, 135.86444964598905, 135.66435472751189, 137.56525645304487),
        *(140.36658531172509, 145.26891081441539, 152.87251771654735, 162.97731109964374, 164.2779280697452),
        *(166.17882979527823, 167.97968406157264, 170.08068070558275, 172.78196210502438, 175.38319604522741),
        *(179.58518933324765, 183.58708770279083, 189.89007763482121, 197.69377945543027, 215.90241703685155),
        244.51599037908485,
    ]
)
"""K factor: engine speed by the square root of the impeller's torque."""
TORQUE_RATIOS = np.array(
    [
        *(2.232, 2.075, 1.975, 1.846, 1.720, 1.564, 1.409, 1.254, 1.096, 1.080, 1.061, 1.043, 1.028, 1.012, 1.002),
        *(1.002, 1.001, 0.998, 0.999, 1.001, 1.002),
    ]
)

UP_THROTTLES = np.array([0.0, 25.0, 35.0, 50.0, 90.0, 100.0])
UP = np.array([[10.0, 10.0, 15.0, 23.0, 40.0, 40.0], [30.0, 30.0, 30.0, 41.0, 70.0, 70.0]])
UP = np.vstack([UP, [50.0, 50.0, 50.0, 60.0, 100.0, 100.0], np.full(6, 1e6)])  # [mph] by gear (rows) and throttle
DOWN_THROTTLES = np.array([0.0, 5.0, 40.0, 50.0, 90.0, 100.0])
DOWN = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [5.0, 5.0, 5.0, 5.0, 30.0, 30.0]])
DOWN = np.vstack([DOWN, [20.0, 20.0, 25.0, 30.0, 50.0, 50.0], [35.0, 35.0, 40.0, 50.0, 80.0, 80.0]])

# Dormand and Prince, A family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980): what `ode5` steps with
STAGES = np.zeros((6, 6))
STAGES[1, :1] = 1.0 / 5.0
STAGES[2, :2] = 3.0 / 40.0, 9.0 / 40.0
STAGES[3, :3] = 44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0
STAGES[4, :4] = 19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0
STAGES[5, :5] = 9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0
WEIGHTS = np.array([35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0])


@compiled
def between(x: float, at: FloatArray, values: FloatArray) -> float:
    """Linear between the points, and on beyond both ends, as the model's tables are."""
    k = min(max(np.searchsorted(at, x, side="right") - 1, 0), len(at) - 2)
    share = (x - at[k]) / (at[k + 1] - at[k])
    return values[k] + share * (values[k + 1] - values[k])


@compiled
def engine_torque(throttle: float, speed: float) -> float:
    """Torque of the engine [lb ft], negative where it drags."""
    k = min(max(np.searchsorted(THROTTLES, throttle, side="right") - 1, 0), len(THROTTLES) - 2)
    low, high = between(speed, ENGINE_SPEEDS, TORQUES[k]), between(speed, ENGINE_SPEEDS, TORQUES[k + 1])
    return low + (throttle - THROTTLES[k]) / (THROTTLES[k + 1] - THROTTLES[k]) * (high - low)


@compiled
def rates(engine: float, wheel: float, throttle: float, brake: float, gear: int) -> tuple[float, float]:
    """How fast engine and wheel speed change [rpm/s]."""
    ratio = GEARS[gear - 1]
    slip = wheel * FINAL_DRIVE * ratio / engine
    impeller = (engine / between(slip, RATIOS, CAPACITIES)) ** 2
    out = impeller * between(slip, RATIOS, TORQUE_RATIOS) * ratio
    engine_rate = (engine_torque(throttle, engine) - impeller) / INERTIA
    if (engine >= FASTEST and engine_rate > 0.0) or (engine <= SLOWEST and engine_rate < 0.0):
        engine_rate = 0.0
    mph = wheel * MPH
    load = np.sign(mph) * (FRICTION + DRAG * mph * mph + brake)
    return engine_rate, (out * FINAL_DRIVE - load) / VEHICLE_INERTIA


@compiled
def drive(throttles: FloatArray, brakes: FloatArray) -> FloatArray:
    """Speed, engine speed and gear in rows, from standstill; the inputs are those of each step, and the last counts."""
    count = len(throttles)
    trace = np.empty((3, count))
    engine, wheel = 1000.0, 0.0
    gear, state, waited = 1, 0, 0  # state: -1 shifts down, 1 shifts up, 0 neither
    slopes = np.zeros((6, 2))
    for k in range(count):
        throttle, brake, speed = throttles[k], brakes[k], wheel * MPH
        if k and k % TICK == 0:  # at the start the logic only enters its first gear
            up, down = between(throttle, UP_THROTTLES, UP[gear - 1]), between(throttle, DOWN_THROTTLES, DOWN[gear - 1])
            waited += 1
            if state == 0:
                state = 1 if speed > up else (-1 if speed < down else 0)
                waited = 0
            elif state == 1:
                if waited >= WAIT and speed >= up:
                    gear, state = min(gear + 1, 4), 0
                elif speed < up:
                    state = 0
            elif waited >= WAIT and speed <= down:
                gear, state = max(gear - 1, 1), 0
            elif speed > down:
                state = 0
        trace[0, k], trace[1, k], trace[2, k] = speed, engine, gear
        for stage in range(6):
            at_engine, at_wheel = engine, wheel
            for past in range(stage):
                at_engine += STEP * STAGES[stage, past] * slopes[past, 0]
                at_wheel += STEP * STAGES[stage, past] * slopes[past, 1]
            slopes[stage] = rates(min(max(at_engine, SLOWEST), FASTEST), at_wheel, throttle, brake, gear)
        for stage in range(6):
            engine += STEP * WEIGHTS[stage] * slopes[stage, 0]
            wheel += STEP * WEIGHTS[stage] * slopes[stage, 1]
        engine = min(max(engine, SLOWEST), FASTEST)
    return trace
