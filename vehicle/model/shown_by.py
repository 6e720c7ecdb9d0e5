"""What a log must hold, and how the car must have been driven, for an effect to show.

`dvp doctor` and `dvp plan` read this from the effects themselves. It is a necessary condition, not a promise: an effect
that could show may still drown in noise or hide behind another one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

Drive: TypeAlias = tuple[str, float, str]
"""A fact of `pytest_dvp.doctor.excitation`, the least value it must have, and the same in words."""

LAST = 100_000  # behind every place that an effect states


@dataclass(frozen=True, slots=True)
class ShownBy:
    """What must be there for an effect to show.

    place    where the effect stands in lists of the doctor: smaller comes first, equal ones by name
    columns  groups of columns of a log; of each group one must be there and vary
    drives   without these nobody sees the effect, were it at the strong end of its usual range
    usual    without these only a strong one shows: for one in the (geometric) middle of that range
    """

    place: int = LAST
    columns: tuple[tuple[str, ...], ...] = ()
    drives: tuple[Drive, ...] = ()
    usual: tuple[Drive, ...] = ()


DRIVE = ("accel_cmd", "throttle_cmd", "motor_current", "speed_cmd")  # the last by the car's own speed controller
BRAKE = ("accel_cmd", "brake_cmd", "brake_pressure", "motor_current", "speed_cmd")
STEER = ("steer_cmd", "steer_cmd_norm", "steer")
COMMAND = ("steer_cmd", "steer_cmd_norm")
SPEED = ("v", "vx", "x")
TURN = ("yaw_rate", "yaw", "ay")

# The bounds are the least meaningful sizes of the effects against usual sensor noise; they are deliberately low.
ACCELERATES: Drive = ("acceleration", 0.5, "accelerating by 0.5 m/s^2")
ACCELERATES_WELL: Drive = ("acceleration", 1.0, "accelerating by 1 m/s^2")
BRAKES: Drive = ("braking", 0.5, "braking by 0.5 m/s^2")
CHANGES_COMMAND: Drive = ("command_rate", 0.5, "a command that changes by 0.5 m/s^3")
TURNS: Drive = ("turn_rate", 0.05, "turning by 0.05 rad/s")
MOVES_WHEEL: Drive = ("steer_rate", 0.02, "steering by 0.02 rad/s")
CURVES: Drive = ("lateral_acceleration", 1.0, "curves of 1 m/s^2")
SHARP_CURVES: Drive = ("lateral_acceleration", 2.0, "curves of 2 m/s^2")
DRIVES_5_S: Drive = ("moving_time", 5.0, "5 s of driving")
DRIVES_10_S: Drive = ("moving_time", 10.0, "10 s of driving")
TURNS_AROUND: Drive = ("headings", 1.5, "headings 1.5 rad apart")
SPEEDS_APART: Drive = ("speed_range", 0.5, "speeds 0.5 m/s apart")
SPEEDS_3_APART: Drive = ("speed_range", 3.0, "speeds 3 m/s apart")

BY_SLOT = {
    **dict.fromkeys(
        ("command", "actuator"), ShownBy(columns=((*COMMAND, *DRIVE, *BRAKE), (*SPEED, *TURN)), drives=(DRIVES_5_S,))
    ),
    **dict.fromkeys(("force", "body", "road"), ShownBy(columns=((*SPEED, *TURN),), drives=(DRIVES_5_S,))),
    "sensor": ShownBy(columns=((*SPEED, *TURN, "ax"),)),
    "perception": ShownBy(),
}
"""What is assumed of an effect that does not say it: its slot is all that is known."""
