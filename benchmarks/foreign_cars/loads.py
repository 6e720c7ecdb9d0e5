"""What acts on the bodies of a foreign car in one step: drive, brakes, steering, anti-roll bars, tyres and air."""

from __future__ import annotations

import numpy as np

from benchmarks.foreign_cars.tyres import FloatArray, forces
from machine_code import compiled
from pytest_dvp.gap.compare.start_correction import IntArray

SERVO, SERVO_DAMPING = 4000.0, 120.0  # N m/rad, N m s/rad: of the steering


@compiled
def apply_loads(drive: float, brake: float, steer: float, step: float, qpos: FloatArray, qvel: FloatArray,
                xpos: FloatArray, xmat: FloatArray, cvel: FloatArray, centre_of_mass: FloatArray, joints: FloatArray,
                bodies: FloatArray, where: IntArray, chassis: int, slip: FloatArray, force: FloatArray,
                torque: FloatArray, tyre: FloatArray, car: FloatArray) -> None:  # fmt: skip
    """Fill the generalised forces `joints` and the forces on `bodies` (nbody, 6), and advance the slip of the tyres.

    drive, brake: forces [N]; steer: wanted angle [rad]; step [s]. qpos to centre_of_mass: state of MuJoCo, in its own
    layout. where (6, 4): bodies of wheels and carriers; freedoms of their spin; positions and freedoms of their
    slides; positions and freedoms of the two steered joints. slip, force, torque, tyre: see `tyres.forces`. car (11,):
    shares of the drive at the wheels, of the brakes in front, wheel radius of the data sheet [m], coefficient of
    rolling, wheel radius [m], anti-roll stiffness [N/m], half the air's density times the drag area [kg/m], half the
    track over the wheelbase where wheels steer by Ackermann, else 0.
    """
    wheels, carriers, spins, slides, slide_freedoms = where[0], where[1], where[2], where[3], where[4]
    joints[:] = 0.0
    spin = np.empty(4)
    for k in range(4):
        spin[k] = qvel[spins[k]]
        share = 0.5 * car[4] if k < 2 else 0.5 - 0.5 * car[4]
        held = brake * share * car[5] * np.tanh(spin[k] / 0.25)
        rolls = car[6] * force[k, 2] * car[7] * np.tanh(spin[k] / 0.5)
        joints[spins[k]] = drive * car[k] * car[5] - held - rolls
    for k in range(2):
        freedom = where[5, 2 + k]
        side = 1.0 - 2.0 * k  # left, right: cot of the wheel is cot of the middle less half the track over wheelbase
        own = steer
        if car[10] != 0.0:
            own = np.arctan2(np.sin(steer), np.cos(steer) - side * car[10] * np.sin(steer))
        joints[freedom] = SERVO * (own - qpos[where[5, k]]) - SERVO_DAMPING * qvel[freedom]
        left, right = 2 * k, 2 * k + 1
        twist = car[8] * (qpos[slides[left]] - qpos[slides[right]])
        joints[slide_freedoms[left]] -= twist
        joints[slide_freedoms[right]] += twist
    centre, velocity, turned = np.empty((4, 3)), np.empty((4, 3)), np.empty((4, 9))
    for k in range(4):
        body = wheels[k]
        for i in range(3):
            centre[k, i] = xpos[body, i]
        turned[k] = xmat[carriers[k]]
        x = centre[k, 0] - centre_of_mass[chassis, 0]
        y = centre[k, 1] - centre_of_mass[chassis, 1]
        z = centre[k, 2] - centre_of_mass[chassis, 2]
        p, q, r = cvel[body, 0], cvel[body, 1], cvel[body, 2]
        velocity[k, 0] = cvel[body, 3] + q * z - r * y
        velocity[k, 1] = cvel[body, 4] + r * x - p * z
        velocity[k, 2] = cvel[body, 5] + p * y - q * x
    forces(centre, turned, velocity, spin, slip, step, tyre, force, torque)
    for k in range(4):
        for i in range(3):
            bodies[wheels[k], i], bodies[wheels[k], 3 + i] = force[k, i], torque[k, i]
    speed = np.hypot(qvel[0], qvel[1])
    bodies[chassis, 0], bodies[chassis, 1] = -car[9] * speed * qvel[0], -car[9] * speed * qvel[1]
