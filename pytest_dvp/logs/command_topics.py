"""Topics that carry what was asked of a car, not what it did: `/cmd_vel`, `/goal_pose`, `/apollo/control`."""

from __future__ import annotations

import re

_ASKED = frozenset(("cmd", "command", "commands", "commanded", "setpoint", "request", "desired", "target", "goal"))
_OF_A_STACK = frozenset(("control", "controls", "ctrl"))  # in a bus, ESP_Control tells what the unit measures as well
_MEASURED = frozenset(  # words that take it back
    ("status", "state", "report", "feedback", "mode", "actual", "measured", "odom", "odometry", "imu", "info")
)
_TYPES = frozenset(("ackermann", "command", "control", "cmd"))  # in the name of a message type


def carries_commands(topic: str, kind: str) -> bool:
    """Whether a topic holds commands, by the last part of its name and of its message type. kind: the type; "mdf" for
    the group of an MDF file."""
    said, told = _words(topic), _words(kind)
    if (said | told) & _MEASURED:
        return False
    return bool(said & (_ASKED if kind == "mdf" else _ASKED | _OF_A_STACK) or told & _TYPES)


def _words(name: str) -> set[str]:
    last = re.split(r"[/.]", name.rstrip("/"))[-1]
    return {word.lower() for word in re.split(r"[\W_]+|(?<=[a-z0-9])(?=[A-Z])", last) if word}
