"""The least model that a log can be compared with: a kinematic bicycle of the car's wheelbase and mass."""

from __future__ import annotations

from collections.abc import Collection

STEERS = ("steer_cmd", "steer", "steer_cmd_norm")
"""Columns that can steer a model, the one to prefer first: with the command, a diagnosis also sees the actuator."""


def starting_model(names: Collection[str], wheelbase: float, mass: float | None) -> str:
    """Text of a model file for a log with signals of these names. wheelbase [m], mass [kg] (None: not known).

    The speed of the log is imposed unless it has a wanted acceleration: pedals and wanted speeds need a scale or a
    controller that nobody knows yet.
    """
    steer = next((name for name in STEERS if name in names), "steer_cmd")
    note = measured_drive(names)
    along = "accel_cmd" if "accel_cmd" in names else "v"
    lines = ["# Written by `dvp map --model`: what is known of the car before any log is fitted.", "[model]"]
    lines += ['base = "kinematic_bicycle"', "", "[inputs]", f'steer = "{steer}"']
    other = next((name for name in STEERS if name in names and name != steer), "")
    lines[-1] += f'  # or "{other}"' if other else ""
    lines.append(
        f'longitudinal = "{along}"' + (f"  # the speed is imposed; to look at the drive: {note}" if note else "")
    )
    lines += ["", "[parameters]", f"wheelbase = {wheelbase!r}"]
    lines += [f"mass = {mass!r}"] if mass is not None else []
    return "\n".join(lines) + "\n"


def measured_drive(names: Collection[str]) -> str:
    """What can drive the model of `starting_model` along instead of the imposed speed, as its file says it; "" if a
    wanted acceleration drives it already, or nothing can."""
    if "accel_cmd" in names:
        return ""
    for pair in (("throttle_cmd", "brake_cmd"), ("throttle_cmd", "brake_pressure"), ("throttle_cmd",), ("speed_cmd",)):
        if all(name in names for name in pair):
            effect = ', with [[effect]] name = "speed_controller" below' if pair == ("speed_cmd",) else ""
            return f'"{" + ".join(pair)}"{effect}'
    return ""
